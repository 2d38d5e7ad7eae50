// The page of one pack: the selected hull, and everything that depends on it.
{
  const data = JSON.parse(document.getElementById("data").textContent);
  const root = document.documentElement;
  const get = (id) => document.getElementById(id);
  const ALL = "all";
  const hulls = data.hulls.map((hull) => ({
    ...hull,
    hull: hull.hull && meshOf(hull.hull),
    source: hull.source && meshOf(hull.source),
  }));
  const isMany = data.hulls.length > 1;
  // If a mesh was cut into parts, the whole mesh is shown beside each part.
  const whole = data.meshes.map(meshOf);
  const hasSource = whole.length > 0 || hulls.some((hull) => hull.source);
  const meshesOf = (list) => (whole.length ? whole : list.map((hull) => hull.source).filter(Boolean));
  const camera = new Camera(data.up);
  let chosen = isMany ? ALL : 0;
  let marked = null;
  // Parts of the table of parts: the one under the pointer, and the one whose button is pressed.
  let pointed = null, pressed = null, highlighted = null;

  // Controls.
  const choice = get("hull-choice");
  const hasParts = isMany && hulls.some((hull) => hull.part_count > 1);
  const several = hasParts ? "parts" : "hulls";
  if (isMany) {
    choice.append(new Option(`all ${grouped(data.hull_count)} ${several}`, ALL));
    hulls.forEach((hull, number) => choice.append(new Option(`#${number} ${hull.name}`, number)));
  }
  get("hull-choice-row").hidden = !isMany;
  get("source-figure").hidden = !hasSource;
  get("pair").classList.toggle("alone", !hasSource);
  const hasFit = hulls.some((hull) => hull.protrusion_at);
  for (const label of document.querySelectorAll(".with-parts")) label.hidden = !hasParts;
  for (const label of document.querySelectorAll(".with-fit")) label.hidden = !hasFit;
  for (const label of document.querySelectorAll(".with-source")) label.hidden = !hasSource;

  const current = () => (chosen === ALL ? hulls.filter((hull) => hull.hull) : [hulls[chosen]].filter((hull) => hull.hull));

  function boxOf(shapes) {
    const low = [0, 1, 2].map((axis) => Math.min(...shapes.map((shape) => shape.low[axis])));
    const high = [0, 1, 2].map((axis) => Math.max(...shapes.map((shape) => shape.low[axis] + shape.size[axis])));
    return { low, high };
  }

  /** Width, depth and height, along the axes. */
  function sizeOf(shapes) {
    const { low, high } = boxOf(shapes);
    return low.map((c, axis) => short(high[axis] - c)).join(" × ");
  }

  function frame(list) {
    const shapes = [...list.map((hull) => hull.hull), ...meshesOf(list)];
    const { low, high } = boxOf(shapes);
    const centre = low.map((c, axis) => (c + high[axis]) / 2);
    let reach = 0;
    for (const { points } of shapes) {
      for (let i = 0; i < points.length; i += 3) {
        reach = Math.max(reach, Math.hypot(points[i] - centre[0], points[i + 1] - centre[1], points[i + 2] - centre[2]));
      }
    }
    return { centre, radius: reach };
  }

  // How far parts are pulled apart: each moves away from the middle by this share of its distance.
  const spread = () => (hasParts && chosen === ALL ? Number(get("spread").value) : 0);
  let whole3d = { centre: [0, 0, 0], radius: 1 };
  function offsetOf({ hull }) {
    const share = 1.5 * spread();
    return [0, 1, 2].map((axis) => share * (hull.low[axis] + hull.size[axis] / 2 - whole3d.centre[axis]));
  }

  /** The part among these that protrudes most. */
  function worstOf(list) {
    const measured = list.filter((hull) => hull.protrusion_at);
    return measured.reduce((worst, hull) => (worst && worst.protrusion >= hull.protrusion ? worst : hull), null);
  }

  const switches = ["show-edges", "show-vertices", "show-mesh-edges", "show-around", "show-protrusion", "spread"];
  const canvases = hasSource ? ["source", "hull"] : ["hull"];
  const { views, redraw, drawNow, measure } = openStage(canvases, camera, switches, () => {
    const list = current();
    if (!list.length) return;
    camera.look({ ...whole3d, radius: whole3d.radius * (1 + spread()) });
    const look = Object.fromEntries(["hull", "mesh", "edge", "mesh-edge", "mark", "well"].map((name) => [name, cssColour(`--${name}`)]));
    const isOn = (id) => get(id).checked;
    views.hull.clear();
    for (const hull of list) {
      const shape = hull.hull;
      const moved = movedBy(camera, offsetOf(hull));
      const isFaded = highlighted !== null && chosen === ALL && hull.number !== highlighted;
      const colour = isFaded ? look.well : chosen === ALL ? hull.colour : look.hull;
      if (shape.triangles.length) views.hull.triangles(shape, moved, colour);
      // Dense edges are drawn paler.
      const opacity = Math.min(0.9, Math.max(0.12, Math.sqrt(900 / (shape.edges.length + 1)))) * (isFaded ? 0.35 : 1);
      if (isOn("show-edges") || !shape.triangles.length) views.hull.edges(shape, moved, { colour: look.edge, opacity });
      if (isOn("show-vertices") || hull.rank === 0) views.hull.dots(shape, moved, { size: hull.rank ? 5 : 12 });
    }
    const worst = hasFit && isOn("show-protrusion") ? worstOf(list) : null;
    if (worst) views.hull.spot(movedBy(camera, offsetOf(worst)), worst.protrusion_at, look.mark);
    root.dataset.spot = worst ? worst.number : "none";
    root.dataset.spread = spread();
    if (marked && chosen !== ALL) {
      const hull = list[0];
      const vertex = hull.hull.vertex(marked.vertex);
      const tip = camera.middle.map((c, axis) => c + marked.dir[axis] * camera.radius * 1.25);
      if (vertex) views.hull.mark(camera, camera.middle, tip, vertex, look.mark);
    }
    if (!views.source) return;
    views.source.clear();
    for (const source of meshesOf(list)) {
      if (source.triangles.length) views.source.triangles(source, camera, look.mesh);
      else views.source.dots(source, camera, { colour: look["mesh-edge"], size: source.points.length > 30 ? 3.5 : 10 });
      const opacity = Math.min(0.8, Math.max(0.15, Math.sqrt(1500 / (source.edges.length + 1))));
      if (isOn("show-mesh-edges")) views.source.edges(source, camera, { colour: look["mesh-edge"], opacity });
    }
    for (const { hull } of list) {
      const opacity = Math.min(0.55, Math.max(0.06, Math.sqrt(250 / (hull.edges.length + 1))));
      if (isOn("show-around")) views.source.edges(hull, camera, { colour: look.edge, opacity, forward: 0 });
    }
    if (worst) views.source.spot(camera, worst.protrusion_at, look.mark);
  });

  // Gauss map.
  const gauss = new GaussView(get("gauss"), data.faces, (found) => {
    marked = found;
    tell(found);
    redraw();
  });
  const mapped = () => (chosen === ALL ? hulls[0] : hulls[chosen]);

  function tell(found) {
    const readout = get("readout");
    if (!found) {
      readout.textContent = "Point at a direction to see its vertex, leaf and candidates.";
      return;
    }
    const { dir, vertex, leaf } = found;
    const hull = mapped();
    const position = hull.hull && hull.hull.vertex(vertex);
    const numbers = (list) => list.map(short).join(", ");
    const more = leaf.candidates > leaf.listed.length ? ", …" : "";
    const way = hull.index === "none" ? "no index: all vertices" : `leaf at block ${grouped(leaf.block)}`;
    const parts = [
      `direction (${numbers(dir.map((c) => Math.round(c * 1e4) / 1e4))})`,
      `vertex ${grouped(vertex)}${position ? ` at (${position.map((c) => fixed(c, hull.hull.digits)).join(", ")})` : ""}`,
      `${way}, depth ${leaf.nodes} ${leaf.nodes === 1 ? "node" : "nodes"}`,
      `${grouped(leaf.candidates)} ${leaf.candidates === 1 ? "candidate" : "candidates"} in ${grouped(leaf.dots)} lanes: ${leaf.listed.join(", ")}${more}`,
    ];
    readout.textContent = parts.join(" · ");
  }

  function fixed(number, digits) {
    return String(Number(number.toFixed(digits))).replace("-", "−").replace(/^−0$/, "0");
  }

  function legend() {
    const place = get("legend");
    place.textContent = "";
    if (gauss.colourBy === "vertex" || !gauss.map) return;
    const { low, high } = gauss.scale();
    const bar = element("i");
    bar.style.background = `linear-gradient(to right, ${[0, 0.25, 0.5, 0.75, 1].map((share) => `rgb(${scaleColour(share)})`)})`;
    place.append(grouped(low), bar, grouped(high));
  }

  // Captions and charts of the selected hull.
  function captions() {
    const list = current();
    const sum = (pick) => list.reduce((total, hull) => total + pick(hull), 0);
    const part = (shown, whole) => (shown < whole ? ` (${grouped(shown)} of ${grouped(whole)} triangles drawn)` : "");
    if (hasSource) {
      const meshes = meshesOf(list);
      const count = (pick) => meshes.reduce((total, mesh) => total + pick(mesh), 0);
      const [shown, all] = [count((mesh) => mesh.shown), count((mesh) => mesh.whole)];
      const points = `The mesh: ${grouped(count((mesh) => mesh.corners))} points`;
      const size = meshes.length ? `, ${sizeOf(meshes)} ${data.unit}` : "";
      get("source-caption").textContent = all ? `${points}, ${grouped(all)} triangles${size}${part(shown, all)}` : `${points} without faces${size}`;
    }
    const shown = sum((hull) => hull.hull.shown), all = sum((hull) => hull.hull.whole);
    const one = list.length === 1 ? list[0] : null;
    const what = !isMany ? "The convex hull" : one ? `#${one.number} ${one.name}` : `${grouped(list.length)} convex ${several}, each in its colour`;
    get("hull-caption").textContent = list.length
      ? `${what}: ${grouped(sum((hull) => hull.vertices))} vertices, ${grouped(sum((hull) => hull.faces))} faces${part(shown, all)}`
      : "This hull is not drawn, to limit the size of the page.";
    if (one && one.protrusion_at) {
      const at = one.protrusion_at.map((c) => fixed(c, one.hull.digits)).join(", ");
      get("hull-caption").textContent += `. It leaves the mesh by at most ${short(one.protrusion)} ${data.unit}, at the dot (${at})`;
    }
    const hull = mapped();
    const map = hull.gauss;
    const resolution = map ? `Hull ${hull.name}. One runtime query for each of 6 × ${map.resolution} × ${map.resolution} pixels` : "";
    const lines = !map || hull.index === "none" ? "; without an index there are no cells" : map.lines_are_cut ? "; only the coarser cells of the index are drawn" : "; the borders of all cells of the index are drawn exactly";
    get("gauss-caption").textContent = map ? `${resolution}${lines}.` : "";
    get("cost-note").textContent = `Hull ${hull.name}, over ${grouped(hull.census.directions)} evenly spread directions. These numbers depend only on the file, not on the machine.`;
    get("charts").replaceChildren(
      chart("Candidates per query", "candidates", hull.census.candidates),
      chart("Depth: nodes per query", "nodes", hull.census.nodes),
    );
  }

  function check() {
    measure();
    if (gauss.map && get("more").open) {
      const { drawn, colours } = gauss.share();
      get("gauss").dataset.drawn = drawn.toFixed(4);
      get("gauss").dataset.colours = colours;
    }
    root.dataset.hull = chosen;
  }

  function choose(value) {
    chosen = value === ALL ? ALL : Number(value);
    marked = null;
    for (const view of Object.values(views)) if (view) view.forget();
    camera.reset();
    if (current().length) camera.look((whole3d = frame(current())));
    for (const label of document.querySelectorAll(".with-parts")) label.hidden = !hasParts || chosen !== ALL;
    gauss.show(mapped().gauss);
    captions();
    legend();
    tell(null);
    drawNow();
    gauss.draw();
    check();
  }

  function highlight() {
    highlighted = pointed ?? pressed;
    root.dataset.part = highlighted ?? "none";
    if (highlighted !== null && chosen !== ALL) choose((choice.value = ALL));
    redraw();
  }
  /** Highlights the part `number`, or none, until the button is pressed again. */
  function press(button, number) {
    pressed = button?.getAttribute("aria-pressed") === "true" ? null : number;
    for (const other of document.querySelectorAll("button[aria-pressed]")) {
      other.setAttribute("aria-pressed", pressed !== null && other === button);
    }
    highlight();
  }
  for (const row of document.querySelectorAll("tr[data-part]")) {
    const number = Number(row.dataset.part), button = row.querySelector("button");
    const point = (now) => () => {
      pointed = now;
      highlight();
    };
    row.addEventListener("pointerenter", point(number));
    row.addEventListener("pointerleave", point(null));
    button.addEventListener("click", () => press(button, number));
  }
  // Not on the page if no part leaves the mesh.
  get("show-worst")?.addEventListener("click", ({ target }) => {
    const worst = worstOf(hulls.filter((hull) => hull.hull));
    if (!worst) return;
    get("spread").value = 0;
    press(target, worst.number);
    if (pressed === null) camera.reset();
    else camera.approach(worst.protrusion_at);
    get("view").scrollIntoView({ block: "nearest" });
  });

  get("reset").addEventListener("click", () => press(null, null));
  choice.addEventListener("change", () => choose(choice.value));
  get("colour-by").addEventListener("change", (event) => {
    gauss.colourBy = event.target.value;
    if (gauss.map) gauss.paint();
    legend();
    gauss.draw();
  });
  get("show-cells").addEventListener("change", (event) => {
    gauss.showsCells = event.target.checked;
    gauss.draw();
  });
  get("gauss-in").addEventListener("click", () => gauss.grow(1.6));
  get("gauss-out").addEventListener("click", () => gauss.grow(1 / 1.6));
  get("gauss-reset").addEventListener("click", () => {
    gauss.reset();
    gauss.grow(1);
  });
  // The map has no size until its fold is opened.
  new ResizeObserver(() => {
    gauss.draw();
    check();
  }).observe(get("gauss"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => gauss.draw());

  choose(isMany ? ALL : 0);
  root.dataset.ready = "true";
}
