// The page of a triangle mesh: its faces, and edges by class.
{
  const data = JSON.parse(document.getElementById("data").textContent);
  const get = (id) => document.getElementById(id);
  const mesh = meshOf(data.mesh);
  const classes = data.classes.map(({ name, edges }) => ({ ...mesh, name, triangles: new Uint16Array(), edges: wordsOf(edges) }));
  const switches = [...document.querySelectorAll("[data-class]")];
  // From above, and not quite: walls show their height.
  const camera = new Camera(data.up, 1.05);
  camera.look({
    centre: mesh.low.map((c, axis) => c + mesh.size[axis] / 2),
    radius: Math.hypot(...mesh.size) / 2,
  });

  const { views, redraw, drawNow, measure } = openStage(["mesh"], camera, ["show-faces"], () => {
    const view = views.mesh;
    view.clear();
    if (get("show-faces").checked) view.triangles(mesh, camera, cssColour("--well-face"));
    for (const input of switches.filter((input) => input.checked)) {
      const group = classes[input.dataset.class];
      if (group.edges.length) view.edges(group, camera, { colour: cssColour(`--edge-${group.name}`) });
    }
  });
  for (const input of switches) input.addEventListener("change", redraw);

  drawNow();
  measure();
  document.documentElement.dataset.ready = "true";
}
