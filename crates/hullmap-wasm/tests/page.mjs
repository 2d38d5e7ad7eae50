// Tests of the page in headless Chromium, beside the command `bake`.
//
//   node page.mjs PAGE BAKE FOLDER PLAYWRIGHT CHROMIUM [SCREENSHOT]
//
// FOLDER holds meshes. PLAYWRIGHT is the folder of playwright-core, CHROMIUM the browser's program.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { pathToFileURL } from "node:url";

import { testLevelPage } from "./level-page.mjs";

const [file, command, meshes, playwright, program, screenshot] = process.argv.slice(2);
const { chromium } = createRequire(import.meta.url)(join(playwright, "index.js"));
const native = (...words) => execFileSync(command, words, { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });

const profile = mkdtempSync(join(tmpdir(), "hullmap-page-"));
const context = await chromium.launchPersistentContext(profile, {
  executablePath: program,
  headless: true,
  viewport: { width: 1280, height: 900 },
  acceptDownloads: true,
  args: [
    "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
    // WebGL on the processor: there may be no GPU.
    "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
  ],
});
const complaints = [];
try {
  await context.setOffline(true);
  const page = await context.newPage();
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type()) && !/GPU stall due to ReadPixels/.test(message.text())) complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("request", (request) => {
    if (!/^(file|data|blob):/.test(request.url())) complaints.push(`request: ${request.url()}`);
  });

  // It opens from disk, with two bodies in contact.
  let start = performance.now();
  await page.goto(pathToFileURL(file).href);
  await page.waitForFunction(() => document.documentElement.dataset.ready === "true", null, { timeout: 60_000 });
  console.log(`opened from disk, two samples baked: ${(performance.now() - start).toFixed(0)} ms`);
  assert.equal(await page.locator("#error").isVisible(), false, await page.locator("#error").textContent());
  const hasGl = await page.evaluate(() => document.documentElement.dataset.webgl === "true");
  if (hasGl) assert.ok((await page.evaluate(() => window.hullmapPage.drawn())) > 0.05, "the view is empty");
  else console.log("skipped: this Chromium has no WebGL2, so nothing is drawn");
  if (screenshot) {
    await page.screenshot({ path: `${screenshot}.png`, fullPage: true });
    await page.emulateMedia({ colorScheme: "dark" });
    await page.waitForTimeout(300);
    await page.screenshot({ path: `${screenshot}-dark.png`, fullPage: true });
    await page.emulateMedia({ colorScheme: "light" });
  }

  // Bake files of each body.
  const loaded = async (act) => {
    const before = await page.evaluate(() => Number(document.documentElement.dataset.loads || 0));
    await act();
    await page.waitForFunction((count) => Number(document.documentElement.dataset.loads || 0) > count, before, { timeout: 60_000 });
  };
  const pawn = join(meshes, "pawn.obj"), rock = join(meshes, "rock.obj");
  await loaded(() => page.setInputFiles("#file-a", pawn));
  await loaded(() => page.setInputFiles("#file-b", rock));
  assert.match(await page.locator("#facts").textContent(), /pawn\.obj.*Hull vertices257/s);

  // The pack that the button downloads equals the command's.
  const packs = {};
  for (const mesh of [pawn, rock]) {
    native("build", mesh, "--out", meshes, "--force");
    packs[mesh] = mesh.replace(/\.obj$/, ".hullmap");
  }
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#download")]);
  assert.equal(download.suggestedFilename(), "pawn.hullmap");
  const saved = join(profile, "saved.hullmap");
  await download.saveAs(saved);
  assert.deepEqual(readFileSync(saved), readFileSync(packs[pawn]));
  console.log(`the downloaded pack has the bytes of the command's: ${readFileSync(saved).length}`);

  // Body B, moved by its fields: what is shown is the command's answer.
  const shown = () => page.evaluate(() => JSON.parse(document.getElementById("answer").dataset.answer));
  const field = async (id, value) => {
    await page.fill(id, String(value));
  };
  let compared = 0;
  for (const [at, turn] of [[[0.4, 0.1, 0.5], [0, 0, 0]], [[0.5, -0.2, 0.6], [20, -35, 70]], [[3, 1, 0], [10, 0, 45]]]) {
    for (const [i, axis] of ["x", "y", "z"].entries()) {
      await field(`#pose-${axis}`, at[i]);
      await field(`#turn-${axis}`, turn[i]);
    }
    const answer = await shown();
    assert.deepEqual(answer.pose.slice(0, 3), at);
    const mode = answer.hit ? "contact" : "distance";
    const expected = JSON.parse(native("query", packs[pawn], packs[rock], "--mode", mode, "--json", "--pose", answer.pose.join(" ")));
    const label = (name) => page.locator(`#answer dt:text-is("${name}") + dd`).textContent();
    if (answer.hit) {
      assert.deepEqual([answer.depth, answer.depth_lower, answer.depth_upper], [expected.depth, expected.depth_lower, expected.depth_upper]);
      assert.equal(await label("Depth"), String(Number(expected.depth.toPrecision(9))));
    } else {
      assert.equal(answer.distance, expected.distance);
      assert.equal(await label("Distance"), String(Number(expected.distance.toPrecision(9))));
    }
    assert.deepEqual(answer.normal, expected.normal);
    compared++;
  }
  console.log(`${compared} poses: shown depth, distance, interval and normal equal the command's`);

  // The motion of B: apart just before its interval of contact, and overlapping just after it, by the command.
  const course = await page.evaluate(() => JSON.parse(document.getElementById("motion-answer").dataset.answer));
  assert.ok(course.hit && course.status === "within" && course.tUpper - course.tLower < 1e-3, JSON.stringify(course));
  const goTo = (t) =>
    page.evaluate((t) => {
      const slider = document.getElementById("time");
      slider.value = String(t);
      slider.dispatchEvent(new Event("input"));
    }, t);
  for (const [t, hit] of [[0, false], [course.tLower - 1e-4, false], [course.tUpper + 1e-4, true]]) {
    await goTo(t);
    const answer = await shown();
    assert.equal(answer.hit, hit, `${t}`);
    const expected = JSON.parse(native("query", packs[pawn], packs[rock], "--mode", "contact", "--json", "--pose", answer.pose.join(" ")));
    assert.equal(expected.hit, hit, `${t}`);
  }
  await page.click("#to-contact");
  const near = await shown();
  assert.ok(!near.hit && near.distance < 1e-3, JSON.stringify(near));
  if (screenshot) await page.screenshot({ path: `${screenshot}-motion.png`, fullPage: true });
  // A motion that ends where it is now meets nothing.
  await goTo(0);
  await page.click("#take-end");
  assert.match(await page.locator("#motion-answer").textContent(), /does not meet A/);
  console.log("the motion of B is apart before its interval of contact, and overlaps after it");

  // Dragged with the mouse, and moved by keys, the depth changes.
  await page.click("#place");
  const before = await shown();
  const box = await page.locator("#view").boundingBox();
  await page.focus("#view");
  for (let i = 0; i < 5; i++) await page.keyboard.press("Shift+ArrowRight");
  const keyed = await shown();
  assert.notDeepEqual(keyed.pose, before.pose);
  const dragged = await page.evaluate(async ([width, height]) => {
    // Where on the picture is B? Try a grid of places, with real events.
    const canvas = document.getElementById("view"), rect = canvas.getBoundingClientRect();
    const fire = (type, x, y) => canvas.dispatchEvent(new PointerEvent(type, { pointerId: 1, clientX: rect.left + x, clientY: rect.top + y, bubbles: true }));
    canvas.setPointerCapture = () => {};
    const pose = () => JSON.parse(document.getElementById("answer").dataset.answer).pose.slice(0, 3).join();
    const start = pose();
    for (let row = 1; row < 10; row++) {
      for (let column = 1; column < 20; column++) {
        const [x, y] = [(width * column) / 20, (height * row) / 10];
        fire("pointerdown", x, y);
        fire("pointermove", x + 4, y + 2);
        fire("pointerup", x + 4, y + 2);
        if (pose() !== start) return [x, y];
      }
    }
    return null;
  }, [box.width, box.height]);
  assert.ok(dragged, "body B cannot be gripped");

  // Files that are dropped on the page: body A, or body B with the Shift key.
  const drop = async (init, name, text) => {
    const dataTransfer = await page.evaluateHandle(([name, text]) => {
      const transfer = new DataTransfer();
      if (name) transfer.items.add(new File([text], name));
      else transfer.items.add("a word", "text/plain");
      return transfer;
    }, [name, text]);
    await page.dispatchEvent("main", "dragover", { dataTransfer });
    assert.equal(await page.locator("body.dropping").count(), 1);
    await page.dispatchEvent("main", "drop", { dataTransfer, ...init });
    assert.equal(await page.locator("body.dropping").count(), 0);
  };
  const bounds = "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\n", factsOf = () => page.locator("#facts").textContent();
  await loaded(() => drop({}, "corner.obj", bounds));
  assert.match(await factsOf(), /Body Acorner\.obj.*Hull vertices4.*Body Brock\.obj/s);
  await loaded(() => drop({ shiftKey: true }, "other.obj", `${bounds}v 2 2 2\n`));
  assert.match(await factsOf(), /Body Acorner\.obj.*Body Bother\.obj.*Hull vertices of B5/s);
  await drop({}, null, null);
  assert.match(await page.locator("#error").textContent(), /That was no file/);
  console.log("dropped files became body A, and body B with the Shift key");

  // A worker that ends: its bake fails, and the next one has a new worker. A cancelled bake fails, too.
  // The first source answers for the baker, the second one does not run.
  const outcomes = await page.evaluate(async () => {
    const fake = `let count = 0; onmessage = ({ data: { module, id, words: [file] = [] } }) => {
      if (module || file === "long") return;
      if (file === "trap") postMessage({ id, ended: true, message: "unreachable" });
      else postMessage({ id, answer: { file, count: ++count } });
    };`;
    const baker = new Baker(fake, new Uint8Array(1)), broken = new Baker("this is no script (", new Uint8Array(1));
    const run = (baker, files) => files.map((file) => baker.run("mesh", [file]));
    const settled = await Promise.allSettled(run(baker, ["one", "trap", "two", "three"]));
    const long = run(baker, ["long", "never"]);
    baker.cancel();
    settled.push(...(await Promise.allSettled([...long, ...run(baker, ["four"]), ...run(broken, ["one"])])));
    return settled.map(({ value, reason }) => (value ? `${value.file} ${value.count}` : reason.constructor.name));
  });
  const expected = ["one 1", "BakerEnded", "two 1", "three 2", "BakeCancelled", "BakeCancelled", "four 1", "BakerEnded"];
  assert.deepEqual(outcomes, expected);

  // Errors are sentences on the page; the bodies remain.
  for (const [name, text, expected] of [
    ["broken.obj", "v 0 0 0\nf 9\n", "broken.obj:2: vertex index 9 is out of range"],
    ["empty.stl", "", "the file is empty"],
    ["page.html", "<html></html>", "page.html"],
  ]) {
    const broken = join(profile, name);
    writeFileSync(broken, text);
    await loaded(() => page.setInputFiles("#file-a", broken));
    assert.match(await page.locator("#error").textContent(), new RegExp(expected));
  }
  assert.equal((await shown()).hit !== undefined, true);

  // The message is in sight wherever the page is scrolled to, and can be closed.
  const narrow = { width: 390, height: 844 };
  await page.setViewportSize(narrow);
  for (const y of [0, 1e6]) {
    await page.evaluate((y) => scrollTo(0, y), y);
    const box = await page.locator("#error").boundingBox();
    assert.ok(box && box.y >= 0 && box.y + box.height <= narrow.height && box.x >= 0 && box.x + box.width <= narrow.width, JSON.stringify(box));
  }
  await page.click("#dismiss");
  assert.equal(await page.locator("#error").isVisible(), false);

  // Nothing sticks out, with a long name in both file inputs.
  const long = join(profile, `${"a_file_with_a_very_long_name_".repeat(4)}.obj`);
  copyFileSync(pawn, long);
  for (const which of ["a", "b"]) await loaded(() => page.setInputFiles(`#file-${which}`, long));
  for (const width of [390, 1400]) {
    await page.setViewportSize({ width, height: 900 });
    const out = await page.evaluate(() => {
      const sections = [...document.querySelectorAll("header, section")];
      const beyond = (outer) => [...outer.querySelectorAll("*")].filter((e) => {
        const [box, around] = [e, outer].map((element) => element.getBoundingClientRect());
        return !e.closest(".visually-hidden") && box.width > 0 && (box.right > around.right + 0.5 || box.left < around.left - 0.5);
      });
      return [document.documentElement.scrollWidth, ...sections.flatMap(beyond).map((e) => e.outerHTML.slice(0, 100))];
    });
    assert.deepEqual(out, [width], `at ${width} pixels`);
    if (screenshot) await page.screenshot({ path: `${screenshot}-${width}.png`, fullPage: true });
  }
  await page.setViewportSize({ width: 1280, height: 900 });
  console.log("at 390 and 1 400 pixels nothing sticks out, and errors are in sight");

  // Scale and axes of each body: the hull, and the pack of the command.
  await loaded(() => page.setInputFiles("#file-a", pawn));
  await loaded(() => page.setInputFiles("#file-b", rock));
  const setNumber = async (id, value) => {
    await page.fill(id, String(value));
    await page.dispatchEvent(id, "change");
  };
  await loaded(() => setNumber("#scale-a", 0.01));
  await loaded(() => page.selectOption("#up-a", "y-to-z"));
  native("build", pawn, "--out", profile, "--unit-scale", "0.01", "--up-axis", "y-to-z");
  const packOfA = await page.evaluate(() => [...window.hullmapPage.pack()]);
  const expectedPack = readFileSync(join(profile, "pawn.hullmap"));
  // The command records the path to the mesh; the rest is equal.
  assert.equal(Buffer.from(packOfA).includes("unit_scale 0.01, up_axis y-to-z"), true);
  assert.deepEqual(await page.evaluate((bytes) => {
    const volume = (pack) => new wasm_bindgen.Pack(new Uint8Array(pack)).hull(0).volume;
    return volume(bytes) - volume([...window.hullmapPage.pack()]);
  }, [...expectedPack]), 0);
  assert.match(await page.locator("#sizes").textContent(), /Body B is \d+ times larger than body A/);
  await loaded(() => page.click("#match"));
  assert.equal(await page.locator("#sizes").isVisible(), false);
  assert.ok(Math.abs(Number(await page.inputValue("#scale-b")) - 0.01) < 0.02);
  await loaded(() => setNumber("#scale-b", -1));
  assert.match(await page.locator("#error").textContent(), /The scale of body B must be a number above 0/);
  await loaded(() => page.selectOption("#sample-b", "cube"));
  assert.equal(await page.inputValue("#scale-b"), "1");
  await page.selectOption("#up-a", "keep");
  console.log("scale and axes reach the pack, and B gets the size of A");

  // Where a face of the hull lies in faces of the mesh, one of both is drawn: there are no patches.
  if (hasGl) {
    await loaded(() => page.setInputFiles("#file-a", join(meshes, "capsule.obj")));
    await page.uncheck("#show-edges");
    await page.fill("#pose-x", "40");
    await page.focus("#view");
    for (let i = 0; i < 6; i++) await page.keyboard.press("+");
    const borders = () => page.evaluate(() => {
      window.hullmapPage.drawn();
      const canvas = document.getElementById("view"), gl = canvas.getContext("webgl2");
      const pixels = new Uint8Array(4 * canvas.width * canvas.height);
      gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      let count = 0;
      for (let i = 4; i < pixels.length; i += 4) {
        const difference = [0, 1, 2].reduce((sum, c) => sum + Math.abs(pixels[i + c] - pixels[i - 4 + c]), 0);
        count += difference > 30 ? 1 : 0;
      }
      return count;
    });
    const both = await borders();
    await page.uncheck("#show-mesh");
    const hull = await borders();
    await page.check("#show-mesh");
    await page.uncheck("#show-hull");
    const mesh = await borders();
    await page.check("#show-hull");
    await page.check("#show-edges");
    console.log(`borders of colours on a capsule: ${hull} of the hull, ${mesh} of the mesh, ${both} of both`);
    assert.ok(hull > 100 && both < 1.2 * Math.max(hull, mesh), "mesh and hull are mixed");
  }

  // Two hulls of 10 000 vertices, for three seconds.
  for (const which of ["a", "b"]) await loaded(() => page.selectOption(`#sample-${which}`, "ellipsoid"));
  assert.equal(await page.locator("#error").isVisible(), false);
  assert.match(await page.locator("#facts").textContent(), /Hull vertices10.000/);
  await page.check("#moves");
  await page.waitForTimeout(3500);
  if (screenshot) await page.screenshot({ path: `${screenshot}-moving.png` });
  const times = await page.evaluate(() => window.hullmapPage.times());
  await page.uncheck("#moves");
  const rank = (list, share) => [...list].sort((x, y) => x - y)[Math.floor(share * (list.length - 1))];
  assert.ok(times.frame.length > 10, `${times.frame.length} frames`);
  const work = await page.evaluate(() => Array.from({ length: 40 }, () => window.hullmapPage.work()));
  console.log(
    `10 000 vertices against 10 000, WebGL on the processor: frame ${rank(times.frame, 0.5).toFixed(1)} ms (median), ` +
      `${rank(times.frame, 0.95).toFixed(1)} ms (95 %), of ${times.frame.length}; queries ${rank(times.query, 0.5).toFixed(2)} ms, ` +
      `${rank(times.query, 0.99).toFixed(2)} ms (99 %); queries and drawing ${rank(work, 0.5).toFixed(1)} ms`,
  );
  // A frame at 60 Hz is 16.7 ms long. The queries take a small part of it.
  assert.ok(rank(times.query, 0.5) < 4, "queries take too long");

  // The page goes on while it bakes: frames of the moving bodies during a bake of 100 000 points.
  let large = "";
  for (let i = 0; i < 100_000; i++) {
    const z = 1 - (2 * i + 1) / 100_000, turn = i * Math.PI * (3 - Math.sqrt(5)), r = Math.sqrt(1 - z * z);
    large += `v ${(r * Math.cos(turn)).toFixed(7)} ${(r * Math.sin(turn)).toFixed(7)} ${z.toFixed(7)}\n`;
  }
  const largeFile = join(profile, "large.obj");
  writeFileSync(largeFile, large);
  for (const which of ["a", "b"]) await loaded(() => page.selectOption(`#sample-${which}`, "knot"));
  await page.check("#moves");
  await page.evaluate(() => {
    window.gaps = [];
    let last = performance.now();
    const tick = (now) => {
      window.gaps.push(now - last);
      last = now;
      if (window.gaps) requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  });
  const idle = await page.waitForTimeout(2000).then(() => page.evaluate(() => window.gaps.splice(0)));
  // Until the bake ends; what follows, the map of a hull of this size, is drawn by the page.
  await page.setInputFiles("#file-b", largeFile);
  await page.waitForFunction(() => /Baking large/.test(document.getElementById("busy").textContent));
  await page.evaluate(() => window.gaps.splice(0));
  await page.waitForFunction(() => document.getElementById("busy").textContent === "", null, { timeout: 120_000 });
  const during = await page.evaluate(() => window.gaps.splice(0));
  await page.uncheck("#moves");
  assert.equal(await page.locator("#error").isVisible(), false);
  assert.match(await factsOf(), /Body Blarge\.obj/);
  const total = during.reduce((sum, gap) => sum + gap, 0);
  console.log(
    `a bake of 100 000 points: ${total.toFixed(0)} ms, ${during.length} frames meanwhile, ${rank(during, 0.5).toFixed(1)} ms (median), ` +
      `${rank(during, 0.95).toFixed(1)} ms (95 %), ${Math.max(...during).toFixed(0)} ms (longest); before it ${rank(idle, 0.5).toFixed(1)} ms (median)`,
  );
  // A page that stands still has one frame.
  assert.ok(during.length > 3, `${during.length} frames during a bake`);

  // A concave mesh becomes convex parts, in the pack of the command. The bar moves, and so do the bodies.
  const decomposed = join(meshes, "gear.obj");
  await page.evaluate(() => {
    window.bars = [];
    const bar = document.getElementById("progress");
    new MutationObserver(() => window.bars.push(bar.value)).observe(bar, { attributes: true });
  });
  await loaded(() => page.setInputFiles("#file-a", decomposed));
  await loaded(() => page.selectOption("#sample-b", "cube"));
  await loaded(() => page.selectOption("#split", "parts"));
  await page.check("#moves");
  await setNumber("#max-parts", 4);
  await page.waitForFunction(() => /Baking gear/.test(document.getElementById("busy").textContent));
  await page.evaluate(() => window.gaps.splice(0));
  await page.waitForFunction(() => document.getElementById("busy").textContent === "", null, { timeout: 120_000 });
  const moving = await page.evaluate(() => window.gaps.splice(0));
  await page.uncheck("#moves");
  native("build", decomposed, "--out", meshes, "--force", "--decompose", "--max-parts", "4");
  assert.deepEqual(Buffer.from(await page.evaluate(() => [...window.hullmapPage.pack()])), readFileSync(decomposed.replace(".obj", ".hullmap")));
  assert.match(await factsOf(), /Body Agear\.obj.*Convex parts[234]/s);
  const bars = await page.evaluate(() => window.bars);
  assert.ok(bars.length > 5 && Math.max(...bars) > 0.5 && Math.max(...bars) <= 1, bars.join());
  assert.ok(moving.length > 3, `${moving.length} frames during a decomposition`);
  if (screenshot) await page.screenshot({ path: `${screenshot}-parts.png`, fullPage: true });
  console.log(`a gear became ${(await factsOf()).match(/Convex parts(\d+)/)[1]} parts: ${moving.length} frames meanwhile, the longest ${Math.max(...moving).toFixed(0)} ms`);
  // A bake that is cancelled leaves the body, and is no error.
  const facts = await factsOf();
  await loaded(async () => {
    await page.selectOption("#sample-a", "knot");
    await page.click("#cancel");
  });
  assert.deepEqual([await factsOf(), await page.locator("#error").isVisible(), await page.locator("#baking").isVisible()], [facts, false, false]);
  await loaded(() => page.selectOption("#split", "none"));

  await testLevelPage(page, native, meshes, hasGl, screenshot);

  // The licences of everything that is compiled in belong to every copy.
  assert.match(await page.locator("#licences").textContent(), /Permission is hereby granted.*^==== rkyv /ms);

  // Every control has a name.
  const unnamed = await page.evaluate(() =>
    [...document.querySelectorAll("input, select, button, canvas")].filter((e) => !(e.labels?.length || e.textContent.trim() || e.getAttribute("aria-label"))).map((e) => e.id),
  );
  assert.deepEqual(unnamed, []);
  assert.deepEqual(complaints, []);
  assert.equal(await page.evaluate(() => document.documentElement.dataset.errors ?? "0"), "0");
  console.log(`page: passed in ${basename(program)} ${context.browser()?.version() ?? ""}`.trimEnd());
} finally {
  await context.close();
  rmSync(profile, { recursive: true, force: true });
}
