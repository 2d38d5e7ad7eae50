// Meshes to begin with, as the text of OBJ files.

const obj = (points, faces = []) =>
  points.map((point) => `v ${point.map((c) => c.toFixed(6)).join(" ")}\n`).join("") +
  faces.map((face) => `f ${face.map((corner) => corner + 1).join(" ")}\n`).join("");

/** Points and quads of a grid of `rows` × `columns` that closes in both directions. */
function closedGrid(rows, columns, place) {
  const points = [], faces = [];
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      points.push(place((2 * Math.PI * row) / rows, (2 * Math.PI * column) / columns));
      const at = (r, c) => ((row + r) % rows) * columns + ((column + c) % columns);
      faces.push([at(0, 0), at(0, 1), at(1, 1), at(1, 0)]);
    }
  }
  return obj(points, faces);
}

/** `count` points spread evenly over an ellipsoid: all are vertices of the hull. */
function ellipsoid(count, [a, b, c]) {
  const golden = Math.PI * (3 - Math.sqrt(5));
  const points = Array.from({ length: count }, (_, i) => {
    const z = 1 - (2 * i + 1) / count, r = Math.sqrt(1 - z * z);
    return [a * r * Math.cos(golden * i), b * r * Math.sin(golden * i), c * z];
  });
  return obj(points);
}

const SAMPLES = {
  knot: {
    name: "Torus knot",
    make: () =>
      closedGrid(160, 14, (u, v) => {
        const r = 0.7 + 0.25 * Math.cos(3 * u);
        return [(r + 0.1 * Math.cos(v)) * Math.cos(2 * u), (r + 0.1 * Math.cos(v)) * Math.sin(2 * u), 0.25 * Math.sin(3 * u) + 0.1 * Math.sin(v)];
      }),
  },
  cube: {
    name: "Cube",
    make: () =>
      obj(
        Array.from({ length: 8 }, (_, i) => [i & 1, (i >> 1) & 1, i >> 2].map((c) => c - 0.5)),
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]],
      ),
  },
  ring: { name: "Ring", make: () => closedGrid(96, 24, (u, v) => [(0.75 + 0.25 * Math.cos(v)) * Math.cos(u), (0.75 + 0.25 * Math.cos(v)) * Math.sin(u), 0.25 * Math.sin(v)]) },
  ellipsoid: { name: "Ellipsoid, 10 000 vertices", make: () => ellipsoid(10_000, [1, 0.8, 0.6]) },
  rock: {
    name: "Rock, 400 random points",
    make: () => {
      // Numerical Recipes' linear congruential generator: the same rock everywhere.
      let state = 7;
      const random = () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 31 - 1;
      const points = [];
      while (points.length < 400) {
        const point = [random(), random(), random()];
        if (Math.hypot(...point) < 1) points.push([point[0], 0.75 * point[1], 0.6 * point[2]]);
      }
      return obj(points);
    },
  },
};
