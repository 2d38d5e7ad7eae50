// Bodies on a level: a triangle mesh or a height field, with the contact points of each body.
{
  const get = (id) => document.getElementById(id);
  const CLASSES = ["border", "flat", "convex", "concave", "non-manifold", "reversed"];
  const canvas = get("level-view"), view = openView(canvas), camera = new Camera();
  let level = null, drawn = null, bodies = [], touched = null;

  const { bake, inWords } = window.hullmapPage;
  const say = (text) => {
    get("error").hidden = !text;
    get("error").firstElementChild.textContent = text;
  };
  const resetView = () => {
    camera.reset();
    camera.grow(1.15);
  };
  const digits = (number, count = 6) => Number(number.toPrecision(count)).toString().replace("-", "−");

  // Samples: grids of heights, and a hall with steps and walls.

  /** A grid of `count` × `count` squares of 1 m, as OBJ. */
  function groundOf(count, height) {
    const points = [], faces = [], row = count + 1;
    for (let i = 0; i < row * row; i++) points.push([(i % row) - count / 2, Math.floor(i / row) - count / 2, height(i % row, Math.floor(i / row))]);
    for (let i = 0; i < count * count; i++) {
      const a = Math.floor(i / count) * row + (i % count);
      faces.push([a, a + 1, a + row + 1], [a, a + row + 1, a + row]);
    }
    return obj(points, faces);
  }
  /** Boxes, as OBJ: the lowest and the highest corner of each. */
  function boxesOf(boxes) {
    const points = [], faces = [];
    for (const [low, high] of boxes) {
      const first = points.length, corner = (i) => [0, 1, 2].map((axis) => ((i >> axis) & 1 ? high : low)[axis]);
      for (let i = 0; i < 8; i++) points.push(corner(i));
      for (const face of [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]) faces.push(face.map((i) => first + i));
    }
    return obj(points, faces);
  }
  const LEVELS = {
    hills: { name: "Hills", make: () => groundOf(40, (x, y) => 1.2 * Math.sin(0.31 * x) * Math.cos(0.27 * y)) },
    rough: { name: "Rough ground", make: () => groundOf(24, (x, y) => 0.25 * Math.sin(12.9898 * x + 78.233 * y + 3 * Math.sin(5.1 * x * y))) },
    steps: {
      name: "Steps and walls",
      make: () =>
        boxesOf([
          [[-8, -8, -0.5], [8, 8, 0]],
          ...Array.from({ length: 8 }, (_, i) => [[-3, -6 + i, 0], [3, -5 + i, 0.3 * (i + 1)]]),
          [[-8, 4, 0], [8, 4.4, 4]],
          [[-6, -7, 0], [-5.6, 3, 2.5]],
        ]),
    },
  };

  // The level.

  function show(opened, file, warnings) {
    if (view && drawn) for (const mesh of [drawn.mesh, ...drawn.classes]) view.forget(mesh);
    removeAll();
    level?.free();
    level = opened;
    const points = level.vertices(), triangles = level.triangles(), bounds = level.bounds;
    const classes = CLASSES.map((name) => ({ name, points, edges: level.edges(name) }));
    drawn = { mesh: { points, triangles }, classes };
    camera.centre = [0, 1, 2].map((axis) => (bounds[axis] + bounds[axis + 3]) / 2);
    camera.radius = Math.max(Math.hypot(...[0, 1, 2].map((axis) => bounds[axis + 3] - bounds[axis])) / 2, 1e-30);
    get("level-size").value = String(Number((0.12 * camera.radius).toPrecision(2)));
    resetView();
    const rows = [
      ["Level", file],
      ["Kind", level.kind === "mesh" ? "triangle mesh" : "height field"],
      ["Triangles", grouped(level.triangleCount)],
      ["Vertices", grouped(points.length / 3)],
      ...classes.filter(({ edges }) => edges.length).map(({ name, edges }) => [`Edges, ${name}`, grouped(edges.length / 2)]),
    ];
    get("level-facts").replaceChildren(
      ...rows.map(([term, text]) => {
        const [row, dt, dd] = ["div", "dt", "dd"].map((name) => document.createElement(name));
        [dt.textContent, dd.textContent] = [term, text];
        row.append(dt, dd);
        return row;
      }),
    );
    get("level-remarks").replaceChildren(
      ...warnings.map((text) => {
        const item = document.createElement("li");
        [item.className, item.textContent] = ["odd", text];
        return item;
      }),
    );
  }

  let loads = 0;
  async function load(file, bytes) {
    say("");
    try {
      if (!bytes.length) throw new Error(`${file}: the file is empty; choose a level`);
      const isBaked = /\.(hullmesh|hullfield)$/i.test(file);
      const scale = Number(get("level-scale").value.trim() || 1);
      if (!(scale > 0)) throw new Error("The scale of the level must be a number above 0.");
      const options = { unitScale: scale, upAxis: get("level-up").value };
      const baked = isBaked ? null : await bake("level", file, bytes, options);
      const opened = new wasm_bindgen.Level(baked ? baked.bytes : bytes);
      show(opened, file, baked ? baked.warnings : opened.warnings);
      known = { file, bytes };
    } catch (error) {
      say(inWords(error));
    }
    document.documentElement.dataset.levels = ++loads;
    redraw();
  }
  let known = null;
  const again = () => known && load(known.file, known.bytes);
  async function loadFile(file) {
    if (!file) return;
    get("level-sample").value = "";
    await load(file.name, new Uint8Array(await file.arrayBuffer()));
  }
  const loadSample = (key) => load(`${key}.obj`, new TextEncoder().encode(LEVELS[key].make()));

  // Bodies.

  /** A surface around the z axis: `rings` of a radius and a height, each with `count` points. */
  function turned(rings, count) {
    const points = [], triangles = [], edges = [];
    for (const [radius, z] of rings) {
      for (let i = 0; i < count; i++) points.push(radius * Math.cos((2 * Math.PI * i) / count), radius * Math.sin((2 * Math.PI * i) / count), z);
    }
    for (let ring = 0; ring + 1 < rings.length; ring++) {
      for (let i = 0; i < count; i++) {
        const at = (r, c) => (ring + r) * count + ((i + c) % count);
        triangles.push(at(0, 0), at(0, 1), at(1, 1), at(0, 0), at(1, 1), at(1, 0));
        if (i % 4 === 0) edges.push(at(0, 0), at(1, 0));
      }
    }
    return { points: new Float32Array(points), triangles: new Uint32Array(triangles), edges: new Uint32Array(edges) };
  }
  const arc = (radius, from, to, z) => Array.from({ length: 9 }, (_, i) => from + ((to - from) * i) / 8).map((angle) => [radius * Math.cos(angle), z + radius * Math.sin(angle)]);
  function boxMesh(half) {
    const points = [], edges = [];
    for (let i = 0; i < 8; i++) {
      for (let axis = 0; axis < 3; axis++) {
        points.push((i >> axis) & 1 ? half[axis] : -half[axis]);
        if (!((i >> axis) & 1)) edges.push(i, i | (1 << axis));
      }
    }
    const faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    return { points: new Float32Array(points), triangles: new Uint32Array(faces.flatMap(([a, b, c, d]) => [a, b, c, a, c, d])), edges: new Uint32Array(edges) };
  }
  const KINDS = {
    box: (size) => [wasm_bindgen.Shape.box([0.5 * size, 0.4 * size, 0.3 * size]), boxMesh([0.5 * size, 0.4 * size, 0.3 * size])],
    ball: (size) => [wasm_bindgen.Shape.sphere(0.5 * size), turned(arc(0.5 * size, -Math.PI / 2, Math.PI / 2, 0), 24)],
    capsule: (size) => {
      const [half, radius] = [0.3 * size, 0.2 * size];
      return [wasm_bindgen.Shape.capsule(half, radius), turned([...arc(radius, -Math.PI / 2, 0, -half), ...arc(radius, 0, Math.PI / 2, half)], 24)];
    },
    hull: async (size) => {
      const hull = new wasm_bindgen.Pack((await bake("mesh", "b.obj", bytesOfHull(size), {})).pack).hull(0);
      return [hull, { points: hull.vertices(), triangles: hull.triangles(), edges: hull.edges() }];
    },
  };
  /** Vertices of body B's hull, as OBJ, about the origin. The longest side has the length `size`. */
  function bytesOfHull(size) {
    const points = window.hullmapPage.pointsOfB(), rows = [];
    const range = [0, 1, 2].map((axis) => {
      let [low, high] = [Infinity, -Infinity];
      for (let i = axis; i < points.length; i += 3) [low, high] = [Math.min(low, points[i]), Math.max(high, points[i])];
      return [low, high];
    });
    const scale = size / Math.max(...range.map(([low, high]) => high - low), 1e-30);
    for (let i = 0; i < points.length; i += 3) rows.push([0, 1, 2].map((axis) => scale * (points[i + axis] - (range[axis][0] + range[axis][1]) / 2)));
    return new TextEncoder().encode(obj(rows));
  }

  function removeAll() {
    for (const body of bodies) {
      if (view) view.forget(body.mesh);
      body.pair.free();
      body.shape.free();
    }
    [bodies, touched] = [[], null];
    showAnswer();
  }

  /** Places of bodies that are dropped, one after the other: they cover the level evenly. */
  let count = 0;
  async function drop() {
    const size = Number(get("level-size").value);
    if (!level || !(size > 0)) return say("The size of a body must be a number above 0.");
    say("");
    try {
      const kind = get("level-body").value, [shape, mesh] = await KINDS[kind](size);
      const bounds = level.bounds, share = [0.7548776662, 0.5698402909].map((step) => 0.1 + 0.8 * ((0.5 + step * count) % 1));
      const turn = quaternionOf([137, 63, 211].map((degrees) => degrees * count)), index = count++;
      const at = [0, 1].map((axis) => bounds[axis] + share[axis] * (bounds[axis + 3] - bounds[axis]));
      const pair = new wasm_bindgen.Pair(level, shape);
      const body = { name: `${kind} ${index + 1}`, size, shape, mesh, pair, numbers: [...at, bounds[5] + size, ...turn], found: null };
      bodies.push(body);
      fall(body);
    } catch (error) {
      say(inWords(error));
    }
    document.documentElement.dataset.drops = count;
    redraw();
  }

  /** How deep a body that was dropped is in the level, relative to its size. */
  const SINK = 1e-3;
  /** Moves a body down until it touches the level; one that is below its top falls from there. */
  function fall(body) {
    body.numbers[2] = Math.max(body.numbers[2], level.bounds[5] + body.size);
    const { hit, t } = level.cast(body.shape, body.numbers, [0, 0, -1]);
    body.numbers[2] -= hit ? t + SINK * body.size : 0;
    solve(body);
    choose(body);
  }

  const times = [];
  function solve(body) {
    const start = performance.now();
    const contact = body.pair.contact(body.numbers);
    const distance = contact.hit ? null : body.pair.distance(body.numbers);
    const manifold = body.pair.manifold(body.numbers);
    times.push(performance.now() - start);
    if (times.length > 240) times.shift();
    body.found = { contact, distance, manifold };
  }

  function choose(body) {
    touched = body;
    showAnswer();
  }

  function showAnswer() {
    const place = get("level-answer");
    if (!touched) {
      get("level-verdict").textContent = level ? "No body" : "";
      place.replaceChildren();
      delete place.dataset.answer;
      return;
    }
    const { contact, distance, manifold } = touched.found, answer = distance || contact;
    get("level-verdict").textContent = `${touched.name} ${contact.hit ? "touches the level" : "is above the level"}`;
    const triangles = [...new Set(manifold.points.map((point) => point.parts[0]))];
    const sorted = [...times].sort((x, y) => x - y);
    const rows = [
      contact.hit ? ["Depth", digits(contact.depth)] : ["Distance", digits(distance.distance)],
      ["Interval", contact.hit ? `${digits(contact.depthLower, 9)} to ${digits(contact.depthUpper, 9)}` : `${digits(distance.lower, 9)} to ${digits(distance.upper, 9)}`],
      ["Normal, level to body", [...answer.normal].map((c) => digits(c, 4)).join(", ")],
      ["Triangle", String(answer.parts[0])],
      ["Contact points", String(manifold.points.length)],
      ["on triangles", triangles.length ? triangles.slice(0, 12).join(", ") : "–"],
      ["Bodies", String(bodies.length)],
      ["Query time", `${sorted[sorted.length >> 1].toFixed(2)} ms`],
    ];
    place.replaceChildren(
      ...rows.flatMap(([term, text]) => {
        const [dt, dd] = ["dt", "dd"].map((name) => document.createElement(name));
        [dt.textContent, dd.textContent] = [term, text];
        return [dt, dd];
      }),
    );
    place.dataset.answer = JSON.stringify({
      pose: touched.numbers,
      hit: contact.hit,
      depth: contact.depth,
      depth_lower: contact.depthLower,
      depth_upper: contact.depthUpper,
      distance: distance && distance.distance,
      triangle: answer.parts[0],
      points: manifold.points.length,
      normals: manifold.points.map((point) => [...point.normal]),
    });
  }

  // Drawing.

  const colours = {};
  function readColours() {
    for (const name of ["well-face", "hull", "edge", "mark", "good", ...CLASSES.map((name) => `edge-${name}`)]) colours[name] = cssColour(`--${name}`);
  }

  function draw() {
    if (!view || !level) return;
    view.begin(camera);
    view.triangles(drawn.mesh, { colour: colours["well-face"] });
    for (const group of drawn.classes) {
      // The edges of a smooth ground hide its shape.
      const opacity = group.name === "flat" ? 0.4 : 0.9;
      if (get(`level-class-${group.name}`).checked) view.edges(group, { colour: colours[`edge-${group.name}`], opacity });
    }
    for (const body of bodies) {
      const model = matrixOf(body.numbers);
      view.triangles(body.mesh, { model, colour: colours[body === touched ? "good" : "hull"], opacity: 0.55 });
      if (body.mesh.edges.length < 20_000) view.edges(body.mesh, { model, colour: colours.edge, opacity: 0.5 });
    }
    for (const { found, size } of bodies) {
      const points = found.manifold.points, near = { colour: colours.mark, forward: 1 };
      view.loose("points", points.map((point) => [...point.pointA]), { ...near, size: 6 });
      view.loose("lines", points.flatMap((point) => [[...point.pointA], plus([...point.pointA], point.normal, 0.4 * size)]), near);
    }
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

  // Mouse, touch and keys.

  const aspect = () => canvas.clientWidth / Math.max(canvas.clientHeight, 1);
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return [(2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height];
  };
  /** Moves a body by a vector. */
  function move(body, from, shift, length = 1) {
    [0, 1, 2].forEach((axis) => (body.numbers[axis] = from[axis] + length * shift[axis]));
    solve(body);
    choose(body);
    redraw();
  }
  let last = null, grip = null;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    canvas.classList.add("dragging");
    [last, grip] = [place(event), null];
    if (!level) return;
    const along = camera.ray(last, aspect()), ground = level.shape().ray(camera.eye, along).t;
    for (const body of bodies) {
      const depth = rayTo(body.mesh, matrixOf(body.numbers), camera.eye, along);
      if (depth < Math.min(ground, grip ? grip.depth : Infinity)) grip = { body, depth, from: last, at: body.numbers.slice(0, 3) };
    }
    if (grip) choose(grip.body);
    redraw();
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!last) return;
    const now = place(event);
    if (grip) {
      // In the plane through the point that was gripped, parallel to the picture.
      move(grip.body, grip.at, plus(camera.ray(now, aspect()), camera.ray(grip.from, aspect()), -1), grip.depth);
    } else {
      camera.turn((last[0] - now[0]) * 2.2 * Math.min(aspect(), 2), (last[1] - now[1]) * 2.2);
      redraw();
    }
    last = now;
  });
  for (const name of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(name, () => {
      [last, grip] = [null, null];
      canvas.classList.remove("dragging");
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
    if (event.altKey || event.metaKey || event.ctrlKey) return;
    const [right, up] = camera.axes, turn = (yaw, pitch) => () => camera.turn(yaw, pitch);
    const push = (axis, sign) => () => touched && move(touched, touched.numbers.slice(0, 3), axis, sign * 0.02 * camera.radius);
    const keys = event.shiftKey
      ? { ArrowLeft: push(right, -1), ArrowRight: push(right, 1), ArrowUp: push(up, 1), ArrowDown: push(up, -1), "+": () => camera.grow(1.15) }
      : {
          ArrowLeft: turn(0.08, 0), ArrowRight: turn(-0.08, 0), ArrowUp: turn(0, 0.08), ArrowDown: turn(0, -0.08),
          PageDown: () => touched && fall(touched),
          "+": () => camera.grow(1.15), "=": () => camera.grow(1.15), "-": () => camera.grow(1 / 1.15), Home: resetView,
        };
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
    redraw();
  });

  // Controls.

  get("level-file").addEventListener("click", (event) => (event.target.value = ""));
  get("level-file").addEventListener("change", (event) => loadFile(event.target.files[0]));
  const choice = get("level-sample");
  choice.append(new Option("choose", ""), ...Object.entries(LEVELS).map(([key, { name }]) => new Option(name, key)));
  choice.addEventListener("change", () => {
    if (!choice.value) return;
    get("level-file").value = "";
    loadSample(choice.value);
  });
  for (const id of ["level-scale", "level-up"]) get(id).addEventListener("change", again);
  get("level-drop").addEventListener("click", drop);
  get("level-fall").addEventListener("click", () => {
    const before = touched;
    bodies.forEach(fall);
    if (before) choose(before);
    redraw();
  });
  get("level-clear").addEventListener("click", () => {
    removeAll();
    redraw();
  });
  get("level-reset").addEventListener("click", () => (resetView(), redraw()));
  for (const name of CLASSES) {
    const [label, input, sample] = ["label", "input", "span"].map((name) => document.createElement(name));
    [input.type, input.id, input.checked] = ["checkbox", `level-class-${name}`, true];
    sample.className = "class-sample";
    sample.style.background = `var(--edge-${name})`;
    label.append(input, sample, ` ${name}`);
    get("level-classes").append(label);
    input.addEventListener("change", redraw);
  }
  // A file on this picture is a level, elsewhere a body.
  canvas.addEventListener("drop", (event) => {
    const [file] = event.dataTransfer.files;
    if (!file) return;
    event.preventDefault();
    event.stopPropagation();
    document.body.classList.remove("dropping");
    loadFile(file);
  });

  // Start.

  const repaint = () => {
    readColours();
    redraw();
  };
  new ResizeObserver(repaint).observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
  readColours();
  choice.value = "hills";
  loadSample("hills").then(async () => {
    for (const kind of ["box", "ball", "capsule"]) {
      get("level-body").value = kind;
      await drop();
    }
    get("level-body").value = "box";
  });
  /** For tests: what is on the picture, the bytes of the level, and where the chosen body is seen. */
  window.hullmapLevel = {
    drawn: () => (draw(), view ? view.share() : 0),
    bytes: () => level.bytes,
    seen() {
      const [x, y, z] = transform(camera.toView, touched.numbers.slice(0, 3)), lens = -z * camera.lens(aspect());
      return [(1 + x / (lens * aspect())) / 2, (1 - y / lens) / 2];
    },
  };
}
