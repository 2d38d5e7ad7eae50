// The page of a robot: its links in the pose that the sliders say.
{
  const data = JSON.parse(document.getElementById("data").textContent);
  const get = (id) => document.getElementById(id);
  const meshes = data.meshes.map((mesh) => mesh && meshOf(mesh));
  const camera = new Camera(data.up);
  const positions = data.joints.map((joint) => joint.neutral);
  // Links whose rows are under the pointer, or pressed.
  let pointed = null, pressed = null;

  const displacements = () => followed(data.joints, data.joints.map((joint, index) => positions[index] - joint.reference));
  const frames = () => posesOf(data.links, data.joints, displacements());

  /** Every shape that is drawn, with its mesh and its map into the world. */
  function shapes() {
    const placedLinks = frames();
    return data.links.flatMap((link, index) =>
      link.shapes
        .filter((shape) => meshes[shape.mesh])
        .map((shape) => ({ ...shape, link: index, mesh: meshes[shape.mesh], columns: placed(placedLinks[index], shape.in_link) })),
    );
  }

  function boundsOf(list) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const { mesh, columns } of list) {
      for (let corner = 0; corner < 8; corner++) {
        const at = [0, 1, 2].map((axis) => mesh.low[axis] + ((corner >> axis) & 1) * mesh.size[axis]);
        for (let axis = 0; axis < 3; axis++) {
          const c = columns[3][axis] + at.reduce((sum, x, of) => sum + x * columns[of][axis], 0);
          [low[axis], high[axis]] = [Math.min(low[axis], c), Math.max(high[axis], c)];
        }
      }
    }
    if (!list.length) return { centre: [0, 0, 0], radius: 1 };
    const centre = low.map((c, axis) => (c + high[axis]) / 2);
    return { centre, radius: Math.hypot(...low.map((c, axis) => (high[axis] - c) / 2)) };
  }
  // The view stays where it is while joints move.
  camera.look(boundsOf(shapes()));

  /** The camera for a shape with an affine map into the world. */
  function seenBy(columns) {
    const outer = camera.toView;
    const toView = new Float32Array(16);
    for (let column = 0; column < 4; column++) {
      for (let row = 0; row < 3; row++) {
        const own = [0, 1, 2].reduce((sum, axis) => sum + outer[4 * axis + row] * columns[column][axis], 0);
        toView[4 * column + row] = own + (column === 3 ? outer[12 + row] : 0);
      }
    }
    toView[15] = 1;
    return { toView, toClip: (aspect) => camera.toClip(aspect) };
  }

  const layers = ["show-visual", "show-around", "show-after", "show-before", "show-edges"];
  const { views, redraw, drawNow, measure } = openStage(["source", "hull"], camera, layers, () => {
    const isOn = (id) => get(id).checked;
    const look = Object.fromEntries(["mesh", "edge", "mesh-edge", "well"].map((name) => [name, cssColour(`--${name}`)]));
    const chosen = pointed ?? pressed;
    const isFaded = (shape) => chosen !== null && !chosen.includes(shape.link);
    const all = shapes();
    const opacity = (mesh) => Math.min(0.8, Math.max(0.1, Math.sqrt(250 / (mesh.edges.length + 1))));
    for (const view of Object.values(views)) view.clear();
    for (const shape of all) {
      const { mesh, layer } = shape;
      const seen = seenBy(shape.columns);
      const fade = isFaded(shape) ? 0.3 : 1;
      if (layer === "visual" && isOn("show-visual")) {
        if (mesh.triangles.length) views.source.triangles(mesh, seen, isFaded(shape) ? look.well : look.mesh);
        else views.source.dots(mesh, seen, { colour: look["mesh-edge"], size: 3 });
      }
      if (layer === "after" && isOn("show-around")) {
        views.source.edges(mesh, seen, { colour: look.edge, opacity: opacity(mesh) * fade, forward: 0 });
      }
      if ((layer === "after" && isOn("show-after")) || (layer === "before" && isOn("show-before"))) {
        const colour = isFaded(shape) ? look.well : layer === "after" ? shape.colour : look.mesh;
        if (mesh.triangles.length) views.hull.triangles(mesh, seen, colour);
        const edge = layer === "after" ? look.edge : look["mesh-edge"];
        if (isOn("show-edges")) views.hull.edges(mesh, seen, { colour: edge, opacity: opacity(mesh) * fade });
      }
    }
  });

  // A slider for each joint that moves alone; the others show what they follow.
  const degrees = (angle) => `${((angle * 180) / Math.PI).toFixed(1)}°`.replace("-", "−");
  const millimetres = (length) => `${(length * 1000).toFixed(1)} mm`.replace("-", "−");
  const outputs = [];
  data.joints.forEach((joint, index) => {
    if (joint.motion === "other") return;
    const row = element("label", joint.name || `joint of ${data.links[joint.link].name}`);
    const slider = element("input");
    const [low, high] = joint.limits || (joint.motion === "hinge" ? [-Math.PI, Math.PI] : [joint.reference - 1, joint.reference + 1]);
    Object.assign(slider, { type: "range", min: low, max: high, step: (high - low) / 1000 || 1, value: joint.neutral });
    slider.dataset.joint = index;
    slider.disabled = joint.coefficients.length > 0;
    const output = element("output");
    slider.addEventListener("input", () => {
      positions[index] = Number(slider.value);
      show();
    });
    row.append(slider, output);
    get("joints").append(row);
    outputs.push({ index, slider, output, joint });
  });
  const still = data.joints.filter((joint) => joint.motion === "other").length;
  get("joint-note").textContent = !data.joints.length
    ? "It has no joints that move."
    : still ? `Joints without a slider, since they have several axes: ${still}.` : "";

  function show() {
    const moved = displacements();
    for (const { index, slider, output, joint } of outputs) {
      const position = joint.reference + moved[index];
      if (slider.disabled) slider.value = position;
      output.textContent = joint.motion === "hinge" ? degrees(position) : millimetres(position);
    }
    redraw();
  }
  get("neutral").addEventListener("click", () => {
    data.joints.forEach((joint, index) => (positions[index] = joint.neutral));
    for (const { index, slider } of outputs) slider.value = positions[index];
    show();
  });

  // Rows of tables show their links.
  for (const row of document.querySelectorAll("tr[data-links]")) {
    const links = row.dataset.links.split(" ").map(Number);
    const button = row.querySelector("button");
    row.addEventListener("pointerenter", () => {
      pointed = links;
      redraw();
    });
    row.addEventListener("pointerleave", () => {
      pointed = null;
      redraw();
    });
    button.addEventListener("click", () => {
      const isOn = button.getAttribute("aria-pressed") !== "true";
      for (const other of document.querySelectorAll("tr[data-links] button")) other.setAttribute("aria-pressed", "false");
      button.setAttribute("aria-pressed", isOn);
      pressed = isOn ? links : null;
      redraw();
    });
  }

  show();
  drawNow();
  measure();
  document.documentElement.dataset.ready = "true";
}
