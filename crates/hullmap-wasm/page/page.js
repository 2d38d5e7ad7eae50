// The page: two bodies, their contact, and the Gauss map of body A.
{
  const get = (id) => document.getElementById(id);
  const root = document.documentElement;
  const [wasm, bakerWasm] = ["wasm", "baker-wasm"].map(get);
  wasm_bindgen.initSync({ module: bytesOf(wasm.textContent) });
  const baker = new Baker(get("worker").textContent, bytesOf(bakerWasm.textContent));
  for (const element of [wasm, bakerWasm]) element.remove();

  /** Bodies by name: file, pack, hull, and what the view draws. */
  const bodies = { a: null, b: null };
  let pair = null;
  const pose = { at: [0, 0, 0], turn: [0, 0, 0] };
  const camera = new Camera();
  const view = openView(get("view"));
  root.dataset.webgl = Boolean(view);

  // Messages.

  function fail(text) {
    const place = get("error");
    place.hidden = !text;
    place.firstElementChild.textContent = text;
  }

  /** A sentence for people. */
  function inWords(error) {
    if (error instanceof BakeCancelled) return "";
    if (error instanceof BakerEnded) {
      return "The baker failed on this file, or ran out of memory. Bake it with the command bake.";
    }
    if (error instanceof WebAssembly.RuntimeError || error instanceof RangeError) {
      return "The page ran out of memory, or has a fault. Reload it before you go on.";
    }
    return error && error.message ? error.message : String(error);
  }

  const digits = (number, count = 9) => Number(number.toPrecision(count)).toString().replace("-", "−");
  const triple = (vector) => [...vector].map((c) => digits(c, 5)).join(", ");

  // Bodies.

  function chosenOptions(which) {
    const split = get("split").value, isParts = split === "parts";
    const options = { split: isParts ? "none" : split, decompose: isParts, index: get("index").value, upAxis: get(`up-${which}`).value };
    const scale = Number(get(`scale-${which}`).value.trim() || 1);
    if (!(scale > 0)) throw new Error(`The scale of body ${which.toUpperCase()} must be a number above 0.`);
    options.unitScale = scale;
    const most = get("max-vertices").value.trim();
    if (most) options.maxVertices = Number(most);
    const parts = get("max-parts").value.trim();
    if (isParts && parts) options.maxParts = Number(parts);
    return options;
  }

  /** Makes a baked mesh body `which`. */
  function setBody(which, file, bytes, { pack, positions, triangles, notes, warnings, millis }) {
    const mesh = { points: positions, triangles };
    const old = bodies[which];
    const open = new wasm_bindgen.Pack(pack);
    bodies[which] = { file, bytes, pack, open, mesh, notes, warnings, millis };
    chooseHull(which, 0);
    if (view && old) for (const mesh of [old.mesh, old.shape]) view.forget(mesh);
  }

  function chooseHull(which, index) {
    const body = bodies[which];
    if (view && body.shape) view.forget(body.shape);
    body.hull = body.open.hull(index);
    body.index = index;
    // A decomposed mesh is one body. The chosen part has the facts and the Gauss map.
    const isParts = body.hull.partCount > 0;
    body.whole = isParts ? body.open : body.hull;
    const hulls = isParts ? Array.from({ length: body.open.hullCount }, (_, i) => body.open.hull(i)) : [body.hull];
    body.shape = joined(hulls);
    const all = hulls.map((hull) => hull.bounds);
    body.bounds = [0, 1, 2, 3, 4, 5].map((i) => (i < 3 ? Math.min : Math.max)(...all.map((bounds) => bounds[i])));
    body.centre = [0, 1, 2].map((axis) => (body.bounds[axis] + body.bounds[axis + 3]) / 2);
    body.radius = Math.max(Math.hypot(...[0, 1, 2].map((axis) => body.bounds[axis + 3] - body.bounds[axis])) / 2, 1e-30);
  }

  /** Points, triangles and edges of hulls, to be drawn. */
  function joined(hulls) {
    const [points, triangles, edges] = [[], [], []];
    for (const hull of hulls) {
      const first = points.length / 3;
      for (const coordinate of hull.vertices()) points.push(coordinate);
      for (const corner of hull.triangles()) triangles.push(first + corner);
      for (const end of hull.edges()) edges.push(first + end);
    }
    return { points: new Float32Array(points), triangles: new Uint32Array(triangles), edges: new Uint32Array(edges) };
  }

  let bakes = 0;
  /** Bakes in the worker, and shows how far it is. */
  async function bake(kind, file, bytes, options) {
    bakes++;
    get("busy").textContent = `Baking ${file} …`;
    get("progress").value = 0;
    get("baking").hidden = false;
    try {
      return await baker.run(kind, [file, bytes, options], (share) => (get("progress").value = share));
    } finally {
      bakes--;
      if (!bakes) get("busy").textContent = "";
      get("baking").hidden = !bakes;
    }
  }
  get("cancel").addEventListener("click", () => baker.cancel());

  /** Bakes a mesh and makes it body `which`. The page stays responsive. */
  async function load(which, file, bytes) {
    fail("");
    try {
      if (!bytes.length) throw new Error(`${file}: the file is empty; choose an OBJ, STL, PLY, GLB, glTF, DAE or MSH file`);
      const baked = await bake("mesh", file, bytes, chosenOptions(which));
      setBody(which, file, bytes, baked);
      // The first body A is also body B.
      if (!bodies.b) setBody("b", file, bytes, baked);
      bodiesChanged(which);
    } catch (error) {
      fail(inWords(error));
    }
    root.dataset.loads = Number(root.dataset.loads || 0) + 1;
  }

  async function loadFile(which, file) {
    if (!file) return;
    try {
      const bytes = new Uint8Array(await file.arrayBuffer());
      get(`sample-${which}`).value = "";
      get(`scale-${which}`).value = "1";
      await load(which, file.name, bytes);
    } catch (error) {
      fail(`${file.name}: the browser cannot read this file (${inWords(error)})`);
    }
  }

  const loadSample = (which, key) => {
    get(`scale-${which}`).value = "1";
    return load(which, `${key}.obj`, new TextEncoder().encode(SAMPLES[key].make()));
  };

  function bodiesChanged(which) {
    pair = new wasm_bindgen.Pair(bodies.a.whole, bodies.b.whole);
    times.frame.length = times.query.length = 0;
    showFacts();
    showSizes();
    if (which === "a") {
      showRemarks();
      showMap().catch((error) => fail(inWords(error)));
    }
    course.begin(pair, bodies.a, bodies.b);
    placeBeside();
    frameBoth();
  }

  function showFacts() {
    const { a, b } = bodies;
    const rows = [
      ["Body A", a.file],
      ["Source points", grouped(a.hull.sourcePointCount)],
      ...(a.hull.partCount ? [["Convex parts", grouped(a.hull.partCount)]] : []),
      ["Hull vertices", grouped(a.hull.vertexCount)],
      ["Hull faces", grouped(a.hull.faceCount)],
      ["Volume", digits(a.hull.volume, 6)],
      ["Index, bytes per vertex", (a.hull.indexBytes / a.hull.vertexCount).toFixed(1)],
      ["Pack", `${grouped(a.pack.length)} bytes`],
      ["Bake time", `${a.millis.toFixed(0)} ms`],
      ["Body B", b.file],
      ["Hull vertices of B", grouped(b.hull.vertexCount)],
    ];
    const item = ([term, text]) => {
      const [pairOf, dt, dd] = ["div", "dt", "dd"].map((name) => document.createElement(name));
      [dt.textContent, dd.textContent] = [term, text];
      pairOf.append(dt, dd);
      return pairOf;
    };
    get("facts").replaceChildren(...rows.map(item));
    const choice = get("hull"), count = a.open.hullCount;
    get("hull-row").hidden = count < 2;
    choice.replaceChildren(
      ...Array.from({ length: Math.min(count, 500) }, (_, i) => new Option(`#${i} ${a.open.hull(i).name}`, i, false, i === a.index)),
    );
    get("download").disabled = false;
  }

  /** Ratio of the sizes of two bodies above which the smaller one is hard to see. */
  const FAR_APART = 8;

  /** Shows a hint if one body is much larger than the other. */
  function showSizes() {
    const ratio = bodies.a.radius / bodies.b.radius, factor = Math.max(ratio, 1 / ratio);
    get("sizes").hidden = !(factor > FAR_APART);
    get("sizes").firstElementChild.textContent = `Body B is ${digits(factor, 2)} times ${ratio > 1 ? "smaller" : "larger"} than body A.`;
  }

  function showRemarks() {
    const item = (kind, word) => (text) => {
      const [li, strong] = ["li", "strong"].map((name) => document.createElement(name));
      li.className = kind;
      strong.textContent = `${word}: `;
      li.append(strong, text);
      return li;
    };
    get("remarks").replaceChildren(
      ...bodies.a.warnings.map(item("odd", "Warning")),
      ...bodies.a.notes.map(item("plain", "Note")),
    );
  }

  // Pose.

  const FIELDS = ["pose-x", "pose-y", "pose-z", "turn-x", "turn-y", "turn-z"];

  function showPose() {
    [...pose.at, ...pose.turn].forEach((number, i) => {
      const field = get(FIELDS[i]);
      if (document.activeElement !== field) field.value = String(Number(number.toPrecision(6)));
    });
  }

  function placeBeside() {
    const { a, b } = bodies;
    pose.turn = [0, 0, 0];
    pose.at = plus(a.centre, b.centre, -1);
    // Where A and B overlap by a little, along x.
    const reach = (a.bounds[3] - a.bounds[0] + b.bounds[3] - b.bounds[0]) / 2;
    pose.at[0] += 0.9 * reach;
    pair.forget();
    showPose();
    solve();
    redraw();
  }

  const numbersOf = () => new Float64Array([...pose.at, ...quaternionOf(pose.turn)]);

  // Queries.

  let found = null;
  const times = { query: [], frame: [] };
  const remember = (list, value) => {
    list.push(value);
    if (list.length > 240) list.shift();
  };
  const median = (list) => (list.length ? [...list].sort((x, y) => x - y)[list.length >> 1] : 0);

  function solve() {
    if (!pair) return;
    const numbers = numbersOf();
    const start = performance.now();
    try {
      const contact = pair.contact(numbers);
      const distance = contact.hit ? null : pair.distance(numbers);
      const manifold = pair.manifold(numbers);
      remember(times.query, performance.now() - start);
      found = { numbers, contact, distance, manifold };
    } catch (error) {
      found = null;
      fail(inWords(error));
    }
    showAnswer();
  }

  function showAnswer() {
    if (!found) return;
    const { contact, distance, manifold } = found;
    const rows = [];
    let verdict;
    if (contact.hit) {
      verdict = contact.status === "touching" ? "The bodies touch" : "The bodies overlap";
      rows.push(["Depth", digits(contact.depth)], ["Interval", interval(contact.depthLower, contact.depthUpper)]);
    } else {
      verdict = "The bodies are separated";
      rows.push(["Distance", digits(distance.distance)], ["Interval", interval(distance.lower, distance.upper)]);
    }
    const answer = distance || contact;
    rows.push(
      ["Status", answer.status.replace("_", " ")],
      ["Normal, A to B", triple(answer.normal)],
      ["Point of A", triple(answer.pointA)],
      ["Point of B", triple(answer.pointB)],
      ["Contact points", String(manifold.points.length)],
      ["Depths there", manifold.points.map((point) => digits(point.depth, 4)).join(", ") || "–"],
      ["Support calls", String(answer.supportCalls)],
      ["Query time", times.query.length > 4 ? `${median(times.query).toFixed(2)} ms` : "–"],
      ["Frame time", times.frame.length ? `${median(times.frame).toFixed(1)} ms` : "–"],
    );
    get("verdict").textContent = verdict;
    const place = get("answer");
    if (place.children.length === 2 * rows.length) {
      rows.forEach(([term, text], i) => {
        place.children[2 * i].textContent = term;
        place.children[2 * i + 1].textContent = text;
      });
    } else {
      place.replaceChildren(
        ...rows.flatMap(([term, text]) => {
          const [dt, dd] = ["dt", "dd"].map((name) => document.createElement(name));
          [dt.textContent, dd.textContent] = [term, text];
          return [dt, dd];
        }),
      );
    }
    place.dataset.answer = JSON.stringify({
      pose: [...found.numbers],
      hit: contact.hit,
      status: answer.status,
      depth: contact.depth,
      depth_lower: contact.depthLower,
      depth_upper: contact.depthUpper,
      distance: distance && distance.distance,
      normal: [...answer.normal],
      points: manifold.points.length,
    });
    speak(`${verdict}. ${rows[0][0]} ${rows[0][1]}.`);
  }

  /** The bounds, and the width of the interval, which their digits may not show. */
  const interval = (lower, upper) => `${digits(lower, 10)} to ${digits(upper, 10)}, width ${(upper - lower).toExponential(1).replace("-", "−")}`;

  let speech = 0;
  /** For screen readers, once the body rests. */
  function speak(text) {
    clearTimeout(speech);
    speech = setTimeout(() => (get("spoken").textContent = text), 700);
  }

  // Drawing.

  function frameBoth() {
    const { a, b } = bodies;
    const centreB = transform(matrixOf(numbersOf()), b.centre), apart = Math.hypot(...plus(centreB, a.centre, -1));
    camera.centre = plus(a.centre, plus(centreB, a.centre, -1), 0.5);
    camera.radius = Math.max(a.radius, b.radius, 0.5 * (apart + a.radius + b.radius));
    redraw();
  }

  /** Maximum number of edges of a hull that are drawn. */
  const MOST_EDGES = 10_000;

  const colours = {};
  function readColours() {
    for (const name of ["hull", "mesh", "edge", "mesh-edge", "mark", "good"]) colours[name] = cssColour(`--${name}`);
  }

  function draw() {
    if (!view || !bodies.a) return;
    const { a, b } = bodies;
    const isOn = (id) => get(id).checked;
    const model = matrixOf(numbersOf());
    // Dense edges are drawn paler.
    const pale = (shape) => Math.min(0.7, Math.max(0.07, Math.sqrt(400 / (shape.edges.length + 1))));
    view.begin(camera);
    if (isOn("show-mesh")) {
      if (a.mesh.triangles.length) view.triangles(a.mesh, { colour: colours.mesh });
      else view.cloud(a.mesh, { colour: colours["mesh-edge"], opacity: 0.6, size: a.mesh.points.length > 3000 ? 1.5 : 4 });
    }
    view.triangles(b.shape, { model, colour: colours.good, opacity: 0.55 });
    if (isOn("show-hull")) view.triangles(a.shape, { colour: colours.hull, opacity: 0.45 });
    if (isOn("show-edges")) {
      // Denser edges only darken a body, and take most of the time of a frame.
      const isClear = (shape) => shape.edges.length <= 2 * MOST_EDGES;
      if (isClear(a.shape)) view.edges(a.shape, { colour: colours.edge, opacity: pale(a.shape) });
      if (isClear(b.shape)) view.edges(b.shape, { model, colour: colours.edge, opacity: pale(b.shape) });
    }
    if (isOn("show-motion")) course.draw(view, b.shape, 0.22 * Math.min(a.radius, b.radius), { ghost: colours.edge, colour: colours.mark });
    if (!found) return;
    const { contact, distance, manifold } = found;
    const answer = distance || contact, colour = colours.mark, size = 0.22 * Math.min(a.radius, b.radius);
    const near = { colour, forward: 1 };
    view.loose("lines", [[...answer.pointA], [...answer.pointB], [...answer.pointA], plus([...answer.pointA], answer.normal, size)], near);
    view.loose("points", [[...answer.pointA], [...answer.pointB]], { ...near, size: 9 });
    view.loose("points", manifold.points.map((point) => [...point.pointA]), { ...near, size: 6, colour: colours.edge });
  }

  let waits = false;
  function redraw() {
    if (waits) return;
    waits = true;
    requestAnimationFrame(() => {
      waits = false;
      draw();
    });
  }

  // Motion.

  function moved() {
    showPose();
    solve();
    redraw();
  }

  const course = new MotionSection({
    get,
    digits,
    move(numbers) {
      [pose.at, pose.turn] = [numbers.slice(0, 3), anglesOf(numbers.slice(3))];
      moved();
    },
  });
  for (const which of ["start", "end"]) get(`take-${which}`).addEventListener("click", () => pair && course.take(which, numbersOf()));

  let motion = null;
  function step(now) {
    if (!motion) return;
    // A tab in the background gets no frames; the pause is no frame.
    if (motion.last && now - motion.last < 1000) remember(times.frame, now - motion.last);
    motion.last = now;
    const seconds = (now - motion.start) / 1000;
    const angle = 0.9 * seconds;
    pose.at = plus(motion.centre, [Math.cos(angle), Math.sin(angle), 0.35 * Math.sin(0.7 * angle)], motion.reach * (1 + 0.18 * Math.sin(2.3 * angle)));
    pose.turn = [20 * seconds, 33 * seconds, 47 * seconds].map((degrees) => degrees % 360);
    showPose();
    solve();
    draw();
    requestAnimationFrame(step);
  }

  get("moves").addEventListener("change", (event) => {
    if (!event.target.checked || !bodies.a) {
      motion = null;
      return;
    }
    const { a, b } = bodies;
    const extent = (body, axis) => body.bounds[axis + 3] - body.bounds[axis];
    const mean = (body) => (extent(body, 0) + extent(body, 1) + extent(body, 2)) / 6;
    times.frame.length = times.query.length = 0;
    motion = { start: performance.now(), centre: plus(a.centre, b.centre, -1), reach: mean(a) + mean(b) };
    // All of its path is in the picture.
    [camera.centre, camera.radius] = [a.centre, 1.1 * motion.reach + 0.6 * b.radius];
    requestAnimationFrame(step);
  });

  FIELDS.forEach((id, i) => {
    get(id).addEventListener("input", (event) => {
      const number = event.target.valueAsNumber;
      if (!Number.isFinite(number) || !pair) return;
      (i < 3 ? pose.at : pose.turn)[i % 3] = number;
      // A typed pose has the answer of a first query, to the last bit.
      pair.forget();
      solve();
      redraw();
    });
    get(id).addEventListener("change", showPose);
  });
  get("place").addEventListener("click", () => pair && placeBeside());
  get("reset").addEventListener("click", () => (camera.reset(), redraw()));
  for (const id of ["show-mesh", "show-hull", "show-edges", "show-motion"]) get(id).addEventListener("change", redraw);

  // Mouse, touch and keys.

  const canvas = get("view");
  const aspect = () => canvas.clientWidth / Math.max(canvas.clientHeight, 1);
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return [(2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height];
  };
  const touches = new Map();
  let grip = null, spread = 0;
  const between = () => {
    const [p, q] = [...touches.values()];
    return Math.hypot(p[0] - q[0], p[1] - q[1]);
  };

  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    canvas.classList.add("dragging");
    touches.set(event.pointerId, place(event));
    grip = null;
    if (touches.size === 2) spread = between();
    if (touches.size > 1 || !bodies.b || motion) return;
    const along = camera.ray(place(event), aspect());
    const toB = rayTo(bodies.b.shape, matrixOf(numbersOf()), camera.eye, along);
    const toA = rayTo(bodies.a.shape, IDENTITY, camera.eye, along);
    if (toB <= toA && toB < Infinity) grip = { depth: toB, from: place(event), at: [...pose.at] };
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = touches.get(event.pointerId);
    if (!before) return;
    const now = place(event);
    touches.set(event.pointerId, now);
    if (touches.size === 2 && spread > 0) {
      camera.grow(between() / spread);
      spread = between();
    } else if (grip) {
      // In the plane through the point that was gripped, parallel to the picture.
      const shift = plus(camera.ray(now, aspect()), camera.ray(grip.from, aspect()), -1);
      pose.at = plus(grip.at, shift, grip.depth);
      return moved();
    } else {
      camera.turn((before[0] - now[0]) * 2.2 * Math.min(aspect(), 2), (before[1] - now[1]) * 2.2);
    }
    redraw();
  });
  for (const name of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(name, (event) => {
      touches.delete(event.pointerId);
      grip = null;
      if (!touches.size) canvas.classList.remove("dragging");
    });
  }
  canvas.addEventListener("wheel", (event) => {
    // The wheel scrolls the page until the picture is chosen.
    if (document.activeElement !== canvas && !event.ctrlKey) return;
    event.preventDefault();
    camera.grow(Math.exp(-event.deltaY * (event.deltaMode ? 0.03 : 0.001)));
    redraw();
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    if (event.altKey || event.metaKey || event.ctrlKey || !bodies.b) return;
    const [right, up, back] = camera.axes, length = 0.02 * camera.radius;
    const move = (axis, sign) => () => {
      pose.at = plus(pose.at, axis, sign * length);
      moved();
    };
    const turn = (yaw, pitch) => () => camera.turn(yaw, pitch);
    const keys = event.shiftKey
      ? { ArrowLeft: move(right, -1), ArrowRight: move(right, 1), ArrowUp: move(up, 1), ArrowDown: move(up, -1), "+": () => camera.grow(1.15) }
      : {
          ArrowLeft: turn(0.08, 0), ArrowRight: turn(-0.08, 0), ArrowUp: turn(0, 0.08), ArrowDown: turn(0, -0.08),
          PageUp: move(back, -1), PageDown: move(back, 1),
          "+": () => camera.grow(1.15), "=": () => camera.grow(1.15), "-": () => camera.grow(1 / 1.15), Home: () => camera.reset(),
        };
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
    redraw();
  });

  // Files and samples.

  for (const which of ["a", "b"]) {
    // So that the same file can be chosen again after an edit.
    get(`file-${which}`).addEventListener("click", (event) => (event.target.value = ""));
    get(`file-${which}`).addEventListener("change", (event) => loadFile(which, event.target.files[0]));
    const choice = get(`sample-${which}`);
    choice.append(new Option("choose", ""), ...Object.entries(SAMPLES).map(([key, { name }]) => new Option(name, key)));
    choice.addEventListener("change", () => {
      if (!choice.value) return;
      get(`file-${which}`).value = "";
      loadSample(which, choice.value);
    });
  }
  const again = (which) => bodies[which] && load(which, bodies[which].file, bodies[which].bytes);
  get("split").addEventListener("change", (event) => (get("max-parts-row").hidden = event.target.value !== "parts"));
  for (const id of ["split", "index", "max-vertices", "max-parts"]) get(id).addEventListener("change", () => again("a"));
  for (const which of ["a", "b"]) {
    for (const id of ["scale", "up"]) get(`${id}-${which}`).addEventListener("change", () => again(which));
  }
  get("match").addEventListener("click", () => {
    const scale = get("scale-b"), { a, b } = bodies;
    scale.value = String(Number(((Number(scale.value) || 1) * (a.radius / b.radius)).toPrecision(3)));
    again("b");
  });
  get("dismiss").addEventListener("click", () => fail(""));
  get("hull").addEventListener("change", (event) => {
    chooseHull("a", Number(event.target.value));
    bodiesChanged("a");
  });
  addEventListener("dragover", (event) => {
    event.preventDefault();
    document.body.classList.add("dropping");
  });
  addEventListener("dragleave", (event) => {
    if (!event.relatedTarget) document.body.classList.remove("dropping");
  });
  addEventListener("drop", (event) => {
    event.preventDefault();
    document.body.classList.remove("dropping");
    const [file] = event.dataTransfer.files;
    if (!file) return fail("That was no file. Drop an OBJ, STL, PLY, GLB, glTF, DAE or MSH file.");
    const which = event.shiftKey ? "b" : "a";
    get(`file-${which}`).value = "";
    loadFile(which, file);
  });
  get("download").addEventListener("click", () => {
    const { pack, file } = bodies.a;
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([pack], { type: "application/octet-stream" }));
    link.download = `${file.replace(/\.[^.]*$/, "")}.hullmap`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  });

  // Gauss map.

  let gauss = null;
  async function showMap() {
    const { hull, pack, index } = bodies.a;
    const { faces, map } = await baker.run("map", [pack, index, 160]);
    if (hull !== bodies.a.hull) return;
    gauss ??= new GaussView(get("gauss"), faces, tell);
    gauss.show(map);
    gauss.draw();
    tell(null);
  }
  function tell(point) {
    const readout = get("readout");
    if (!point) {
      readout.textContent = "Point at a direction to see its vertex, leaf and candidates.";
      return;
    }
    const { dir, vertex, leaf } = point;
    const at = bodies.a.hull.support(dir).point;
    readout.textContent = [
      `direction (${triple(dir)})`,
      `vertex ${grouped(vertex)} at (${triple(at)})`,
      `depth ${leaf.nodes} ${leaf.nodes === 1 ? "node" : "nodes"}`,
      `${grouped(leaf.candidates)} ${leaf.candidates === 1 ? "candidate" : "candidates"} in ${grouped(leaf.dots)} lanes`,
    ].join(" · ");
  }
  get("colour-by").addEventListener("change", (event) => {
    if (!gauss) return;
    gauss.colourBy = event.target.value;
    gauss.paint();
    gauss.draw();
  });
  get("show-cells").addEventListener("change", (event) => {
    if (!gauss) return;
    gauss.showsCells = event.target.checked;
    gauss.draw();
  });
  get("gauss-in").addEventListener("click", () => gauss && gauss.grow(1.6));
  get("gauss-out").addEventListener("click", () => gauss && gauss.grow(1 / 1.6));
  get("gauss-reset").addEventListener("click", () => {
    if (!gauss) return;
    gauss.reset();
    gauss.grow(1);
  });

  // Start.

  const repaint = () => {
    readColours();
    redraw();
    if (gauss) gauss.draw();
  };
  new ResizeObserver(repaint).observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
  readColours();
  if (!view) fail("This browser has no WebGL2, so the bodies are not drawn. The numbers and the Gauss map work.");
  get("sample-a").value = "knot";
  get("sample-b").value = "ellipsoid";
  loadSample("a", "knot")
    .then(() => loadSample("b", "ellipsoid"))
    .then(() => (root.dataset.ready = "true"));
  /** For tests and other parts of the page: what is on the screen, and how long frames take. */
  window.hullmapPage = {
    drawn: () => (draw(), view ? view.share() : 0),
    times: () => ({ query: [...times.query], frame: [...times.frame] }),
    work() {
      const start = performance.now();
      solve();
      draw();
      if (view) view.finish();
      return performance.now() - start;
    },
    pack: () => bodies.a.pack,
    bake,
    inWords,
    pointsOfB: () => bodies.b.hull.vertices(),
  };
}
