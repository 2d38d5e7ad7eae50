// Tests of the level on the page. Called by page.mjs.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";

/** `native` runs the command. `screenshot` is the start of a path, or undefined. */
export async function testLevelPage(page, native, meshes, hasGl, screenshot) {
  const shown = () => page.evaluate(() => JSON.parse(document.getElementById("level-answer").dataset.answer ?? "null"));
  const facts = () => page.locator("#level-facts").textContent();
  const loaded = async (act) => {
    const before = await page.evaluate(() => Number(document.documentElement.dataset.levels));
    await act();
    await page.waitForFunction((count) => Number(document.documentElement.dataset.levels) > count, before, { timeout: 60_000 });
  };
  const drop = async (kind) => {
    const before = await page.evaluate(() => Number(document.documentElement.dataset.drops));
    await page.selectOption("#level-body", kind);
    await page.click("#level-drop");
    // A hull is baked first.
    await page.waitForFunction((count) => Number(document.documentElement.dataset.drops) > count, before, { timeout: 60_000 });
  };

  // Three bodies lie on hills from the start.
  assert.match(await facts(), /Kindtriangle mesh.*Triangles3.200/s);
  const first = await shown();
  assert.ok(first.hit && first.points > 0 && first.normals.every((normal) => normal[2] > 0.3), JSON.stringify(first));
  assert.match(await page.locator("#level-answer").textContent(), /Bodies3/);

  // Each kind of body falls until it touches, on each sample.
  for (const sample of ["rough", "steps"]) {
    await loaded(() => page.selectOption("#level-sample", sample));
    assert.equal(await shown(), null);
    for (const kind of ["box", "ball", "capsule", "hull"]) {
      for (let i = 0; i < 3; i++) await drop(kind);
      const answer = await shown(), label = `${sample}, ${kind}: ${JSON.stringify(answer)}`;
      assert.ok(answer.hit && answer.depth > 0 && answer.depth < 0.02 && answer.points > 0, label);
      assert.ok(answer.depth_lower <= answer.depth && answer.depth <= answer.depth_upper, label);
    }
    if (hasGl) assert.ok((await page.evaluate(() => window.hullmapLevel.drawn())) > 0.05, "the picture is empty");
    if (screenshot) await page.locator("#level-view").screenshot({ path: `${screenshot}-level-${sample}.png` });
  }

  // Keys lift the body that was touched last, and drop it again: on hills, with no wall beside it.
  await loaded(() => page.selectOption("#level-sample", "hills"));
  await drop("ball");
  await page.focus("#level-view");
  const resting = await shown();
  for (let i = 0; i < 8; i++) await page.keyboard.press("Shift+ArrowUp");
  const lifted = await shown();
  assert.ok(!lifted.hit && lifted.distance > 0, JSON.stringify(lifted));
  await page.keyboard.press("PageDown");
  assert.ok((await shown()).hit);
  assert.notDeepEqual((await shown()).pose, resting.pose);

  // The mouse grips a body.
  await page.locator("#level-view").scrollIntoViewIfNeeded();
  const box = await page.locator("#level-view").boundingBox(), [x, y] = await page.evaluate(() => window.hullmapLevel.seen());
  const gripped = await shown();
  await page.mouse.move(box.x + x * box.width, box.y + y * box.height);
  await page.mouse.down();
  await page.mouse.move(box.x + x * box.width + 9, box.y + y * box.height - 6);
  await page.mouse.up();
  assert.notDeepEqual((await shown()).pose, gripped.pose, "the body was not gripped");

  // A file that is baked, and files of the command: the same bytes.
  const gear = join(meshes, "gear.obj");
  native("build", gear, "--out", meshes, "--force", "--keep-triangles");
  const file = join(meshes, "gear.hullmesh");
  await loaded(() => page.setInputFiles("#level-file", gear));
  const baked = await page.evaluate(() => [...window.hullmapLevel.bytes()]);
  assert.deepEqual(Buffer.from(baked), readFileSync(file));
  await loaded(() => page.setInputFiles("#level-file", file));
  await drop("ball");
  assert.ok((await shown()).hit);

  // Dropped on the picture: it is no body. A file that is no level is an error; the level stays.
  const bodies = () => page.locator("#facts").textContent(), before = await bodies();
  const dropFile = async (name, text) => {
    const dataTransfer = await page.evaluateHandle(([name, text]) => {
      const transfer = new DataTransfer();
      transfer.items.add(new File([text], name));
      return transfer;
    }, [name, text]);
    await page.dispatchEvent("#level-view", "drop", { dataTransfer });
  };
  await loaded(() => dropFile("roof.obj", "v 0 0 0\nv 2 0 0\nv 2 1 1\nv 0 1 1\nv 2 2 0\nv 0 2 0\nf 1 2 3 4\nf 4 3 5 6\n"));
  assert.match(await facts(), /Levelroof\.obj.*Triangles4.*Edges, border6.*Edges, flat2.*Edges, convex1/s);
  assert.equal(await bodies(), before);
  await drop("box");
  await loaded(() => dropFile("broken.hullmesh", "hullmsh\n and no more"));
  assert.equal(await page.locator("#error").isVisible(), true);
  assert.match(await facts(), /Levelroof\.obj/);
  assert.ok((await shown()).hit);
  await page.click("#dismiss");
  await page.click("#level-fall");
  assert.ok((await shown()).hit);
  await page.click("#level-clear");
  assert.equal(await shown(), null);
  await page.uncheck("#level-class-border");
  await page.check("#level-class-border");
  console.log("levels: bodies fall, are gripped and lifted; files have the command's bytes");
}
