// Tests of levels, beside the command: equal files, equal answers. Called by node.mjs.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

/** `native` runs the command; `meshes` is a folder of meshes, and of packs of the same names. */
export function testLevels({ bakeLevel, Level, Pack, Pair, Shape }, native, meshes) {
  // Files have the bytes of the command's.
  const levels = {};
  for (const [name, options, flags] of [
    ["gear.obj", {}, []],
    ["pawn.obj", { unitScale: 2, upAxis: "y-to-z" }, ["--unit-scale", "2", "--up-axis", "y-to-z"]],
    ["two_objects.obj", {}, []],
  ]) {
    native("build", join(meshes, name), "--out", meshes, "--force", "--keep-triangles", ...flags);
    const file = join(meshes, name.replace(".obj", ".hullmesh")), baked = bakeLevel(name, readFileSync(join(meshes, name)), options);
    assert.deepEqual(Buffer.from(baked.bytes), readFileSync(file), name);
    levels[file] = new Level(baked.bytes);
    assert.deepEqual([Buffer.from(levels[file].bytes), levels[file].warnings.length], [readFileSync(file), baked.warnings.length]);
  }
  // Heights in rows of nine, from the least y on.
  const heights = Float32Array.from({ length: 81 }, (_, i) => Math.sin(i % 9) * Math.cos(Math.floor(i / 9)));
  writeFileSync(join(meshes, "waves.raw"), new Uint8Array(heights.buffer));
  native("build", join(meshes, "waves.raw"), "--terrain", "--set", "columns=9", "--set", "rows=9", "--set", "spacing=1", "--out", meshes, "--force");
  const field = join(meshes, "waves.hullfield");
  levels[field] = new Level(readFileSync(field));
  assert.deepEqual([levels[field].kind, levels[field].triangleCount], ["field", 128]);
  assert.deepEqual([...levels[field].bounds].map(Math.round), [-4, -4, -1, 4, 4, 1]);

  // Answers have the bits of the command's, which does not query fields: those are compared with the
  // answers of all triangles.
  const body = join(meshes, "cube.hullmap"), hull = new Pack(readFileSync(body)).hull(0);
  /** The greatest depth and the least distance over all triangles of a level. */
  const byTriangles = (level, hull, pose) => {
    const [points, triangles] = [level.vertices(), level.triangles()], found = { depth: 0, distance: Infinity };
    for (let i = 0; i < triangles.length; i += 3) {
      const corners = [0, 1, 2].map((k) => [...points.subarray(3 * triangles[i + k], 3 * triangles[i + k] + 3)]);
      const pair = new Pair(Shape.triangle(...corners), hull), contact = pair.contact(pose);
      found.depth = Math.max(found.depth, contact.hit ? contact.depth : 0);
      found.distance = Math.min(found.distance, pair.distance(pose).distance);
      pair.free();
    }
    return found;
  };
  let state = 9, hits = 0, queries = 0;
  const random = () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 31 - 1;
  for (const [file, level] of Object.entries(levels)) {
    const bounds = level.bounds;
    for (let i = 0; i < 12; i++) {
      const at = [0, 1, 2].map((axis) => (bounds[axis] + bounds[axis + 3]) / 2 + (0.5 * (bounds[axis + 3] - bounds[axis]) + 1.8) * random());
      const pose = [...at, random(), random(), random(), random()], pair = new Pair(level, hull);
      const contact = pair.contact(pose), mode = contact.hit ? "contact" : "distance";
      const expected = level.kind === "field" ? byTriangles(level, hull, pose) : JSON.parse(native("query", file, body, "--mode", mode, "--json", "--pose", pose.join(" ")));
      if (level.kind === "field") {
        const { distance } = new Pair(level, hull).distance(pose);
        assert.ok(Math.abs(contact.depth - expected.depth) < 1e-9 && Math.abs(distance - expected.distance) < 1e-9, JSON.stringify(expected));
        queries++;
        hits += contact.hit ? 1 : 0;
        continue;
      }
      if (contact.hit) {
        hits++;
        assert.deepEqual([contact.depth, contact.depthLower, contact.depthUpper], [expected.depth, expected.depth_lower, expected.depth_upper]);
        assert.deepEqual([...contact.normal], expected.normal);
        assert.equal(pair.intersects(pose) !== "separated", true);
        const { points } = pair.manifold(pose);
        assert.ok(points.every((point) => point.parts[0] < level.triangleCount && point.parts[1] === 0));
      } else {
        pair.forget();
        const { distance, lower, upper } = pair.distance(pose);
        assert.deepEqual([distance, lower, upper], [expected.distance, expected.distance_lower, expected.distance_upper]);
      }
      queries++;
      pair.free();
    }
  }
  assert.ok(hits > 0.2 * queries && hits < 0.9 * queries, `${hits} of ${queries} bodies overlap a level`);
  console.log(`${queries} contacts and distances on levels equal the answers of the command, or of all triangles (${hits} overlap)`);

  // A square with a ridge: edges by class, a ray, a body that falls, and one on both sides.
  const roof = "v 0 0 0\nv 2 0 0\nv 2 1 1\nv 0 1 1\nv 2 2 0\nv 0 2 0\nf 1 2 3 4\nf 4 3 5 6\n";
  const level = new Level(bakeLevel("roof.obj", new TextEncoder().encode(roof)).bytes);
  const counts = ["border", "flat", "convex", "concave", "non-manifold", "reversed"].map((name) => level.edges(name).length / 2);
  assert.deepEqual(counts, [6, 2, 1, 0, 0, 0]);
  assert.deepEqual([level.vertices().length, level.triangles().length], [18, 12]);
  const down = level.shape().ray([1, 0.5, 5], [0, 0, -1]);
  assert.ok(down.hit && Math.abs(down.t - 4.5) < 1e-9 && down.part < 4);
  const ball = Shape.sphere(0.25), fall = level.cast(ball, [1, 1, 5, 0, 0, 0, 1], [0, 0, -2]);
  assert.ok(fall.hit && Math.abs(fall.t - 1.875) < 1e-5 && Math.abs(fall.normal[2] - 1) < 1e-3, JSON.stringify(fall));
  assert.equal(level.cast(ball, [9, 9, 5, 0, 0, 0, 1], [0, 0, -2]).hit, false);
  const above = new Pair(ball, level).distance([-1, -1, -5, 0, 0, 0, 1]);
  assert.ok(above.normal[2] < -0.5 && above.parts[0] === 0 && above.parts[1] < 4, JSON.stringify(above));
  const slab = new Pair(level, Shape.box([0.5, 0.5, 0.2])).manifold([1, 1, 1.19, 0, 0, 0, 1]);
  assert.ok(slab.points.length >= 2 && slab.points.every((point) => point.normal[2] > 0.7), JSON.stringify(slab.points.length));

  for (const [what, act, message] of [
    ["damaged", () => new Level(level.bytes.slice(0, 90)), "was truncated"],
    ["no level", () => new Level(readFileSync(body)), ""],
    ["no faces", () => bakeLevel("points.obj", new TextEncoder().encode("v 0 0 0\n")), "has no faces"],
    ["class", () => level.edges("blunt"), "there is no class blunt of edges: the classes are border,"],
    ["option", () => bakeLevel("roof.obj", new TextEncoder().encode(roof), { decompose: true }), "decompose has no effect on a level"],
    ["body", () => level.cast({}, [0, 0, 0, 0, 0, 0, 1], [0, 0, 1]), "body: expected a Hull"],
  ]) {
    assert.throws(act, (error) => error instanceof Error && error.message.includes(message), what);
  }
}
