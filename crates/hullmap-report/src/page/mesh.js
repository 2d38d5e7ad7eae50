// The page of a triangle mesh: its wireframe.
{
  const data = JSON.parse(document.getElementById("data").textContent);
  const root = document.documentElement;
  const get = (id) => document.getElementById(id);
  const mesh = meshOf(data.mesh);
  const classes = data.classes.map(({ name, edges }) => ({ ...mesh, name, triangles: new Uint16Array(), edges: wordsOf(edges) }));
  const switches = [...document.querySelectorAll("[data-class]")];
  const camera = new Camera();
  get("up").value = data.up;

  const view = openView(get("mesh"));
  root.classList.toggle("no-webgl", !view);
  root.dataset.webgl = Boolean(view);

  camera.look({
    centre: mesh.low.map((c, axis) => c + mesh.size[axis] / 2),
    radius: Math.hypot(...mesh.size) / 2,
  });

  function draw3d() {
    if (!view) return;
    camera.up = get("up").value;
    view.begin();
    if (get("show-faces").checked) view.triangles(mesh, camera, cssColour("--well-face"));
    classes.forEach((group, at) => {
      if (switches[at].checked && group.edges.length) {
        view.edges(group, camera, { colour: cssColour(`--edge-${group.name}`) });
      }
    });
  }

  let waits = false;
  function redraw() {
    if (waits) return;
    waits = true;
    requestAnimationFrame(() => {
      waits = false;
      draw3d();
    });
  }

  for (const input of [...switches, get("show-faces"), get("up")]) input.addEventListener("change", redraw);
  get("reset").addEventListener("click", () => {
    camera.reset();
    redraw();
  });
  if (view) {
    steer(view.canvas, camera, redraw);
    new ResizeObserver(redraw).observe(get("mesh"));
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  addEventListener("beforeprint", draw3d);

  draw3d();
  if (view) get("mesh").dataset.drawn = view.share().toFixed(4);
  root.dataset.ready = "true";
}
