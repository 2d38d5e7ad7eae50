// Tests of the npm package in Node, beside the command `bake`: equal packs, equal answers.
//
//   node node.mjs PACKAGE BAKE FOLDER
//
// FOLDER holds meshes. BAKE is the command; it writes its packs beside the meshes.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, readdirSync, statSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";
import { pathToFileURL } from "node:url";
import { gzipSync } from "node:zlib";

import { testLevels } from "./level.mjs";

const [folder, command, meshes] = process.argv.slice(2);
// The entry that the package names for Node.
const { exports } = JSON.parse(readFileSync(join(folder, "package.json")));
const [runtime, baker] = await Promise.all([".", "./bake"].map((name) => import(pathToFileURL(join(folder, exports[name].node)))));
const { interpolatePoses, Level, Pack, Pair, relativePose, Shape, version } = runtime;
const { bake, bakeLevel, bakeMesh, gaussMap } = baker;
for (const call of [() => new Pack(new Uint8Array(9)), () => Shape.sphere(1), () => bake("a.obj", new Uint8Array(9)), () => bakeMesh([0, 0, 0])]) {
  assert.throws(call, /the module is not loaded: await init\(\)/);
}
for (const { default: init } of [runtime, baker]) {
  await init();
  await init(); // does nothing
}
const native = (...words) => execFileSync(command, words, { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });

for (const module of [runtime, baker]) assert.equal(JSON.parse(readFileSync(join(folder, "package.json"))).version, module.version());

// The runtime stays small, because nothing of the baker is in it.
const LIMIT = 1_000_000;
const size = statSync(join(folder, "hullmap_bg.wasm")).size;
assert.ok(size <= LIMIT, `the module of the runtime has ${size} bytes, and may have ${LIMIT}`);
assert.deepEqual(Object.keys(runtime).filter((name) => /bake/i.test(name)), []);

// The archive holds the files that package.json lists, and both licences.
const packed = execFileSync("tar", ["-tzf", join(folder, "../hullmap.tgz")], { encoding: "utf8" }).trim().split("\n");
assert.deepEqual(packed.map((path) => path.replace("package/", "")).sort(), [...JSON.parse(readFileSync(join(folder, "package.json"))).files, "README.md", "package.json"].sort());
for (const name of ["CITATION.cff", "SECURITY.md", "LICENSE-APACHE", "LICENSE-MIT", "LICENSES-OF-DEPENDENCIES.txt"]) assert.ok(packed.includes(`package/${name}`), name);
assert.match(readFileSync(join(folder, "LICENSES-OF-DEPENDENCIES.txt"), "utf8"), /^==== rkyv /m);

// Each format: hulls as STL and GLB, written by the command, and a PLY file.
native("build", join(meshes, "pawn.obj"), "--out", meshes, "--force");
for (const format of ["stl", "glb"]) {
  native("export", join(meshes, "pawn.hullmap"), "--out", join(meshes, `pawn_hull_${format}.${format}`), "--force");
}
const square = ["0 0 0", "1 0 0", "1 1 0", "0 1 0", "0.5 0.5 1"];
const header = ["ply", "format ascii 1.0", `element vertex ${square.length}`, ...["x", "y", "z"].map((axis) => `property float ${axis}`), "end_header"];
writeFileSync(join(meshes, "pyramid.ply"), [...header, ...square, ""].join("\n"));

// Packs are equal to the last byte, with each option.
const files = readdirSync(meshes).filter((name) => /\.(obj|stl|ply|glb)$/.test(name));
const choices = [
  [{}, []],
  [{ index: "compact" }, ["--set", "index=compact"]],
  [{ index: "cubemap" }, ["--set", "index=cubemap"]],
  [{ split: "object", vertices: "all", index: "none" }, ["--split", "object", "--set", "vertices=all", "--set", "index=none"]],
  [{ maxVertices: 12 }, ["--max-vertices", "12"]],
  [{ unitScale: 0.01, upAxis: "y-to-z", recentre: true, lean: true }, ["--unit-scale", "0.01", "--up-axis", "y-to-z", "--set", "recentre=true", "--set", "lean=true"]],
];
let equal = 0;
for (const [options, flags] of choices) {
  for (const name of files) {
    const path = join(meshes, name), out = join(meshes, `${name.replace(/\.[^.]*$/, "")}.hullmap`);
    native("build", path, "--out", meshes, "--force", ...flags);
    const baked = bake(name, readFileSync(path), options);
    assert.deepEqual(Buffer.from(baked.pack), readFileSync(out), `${name} ${flags.join(" ")}`);
    baked.free();
    equal++;
  }
}
// Convex parts take longer: of three concave meshes, and of one that is convex.
for (const name of ["gear.obj", "pawn.obj", "two_objects.obj", "cube.obj"]) {
  for (const [options, flags] of [
    [{ decompose: true, maxError: "3%" }, ["--decompose", "--max-error", "3%"]],
    [{ decompose: true, maxParts: 4 }, ["--decompose", "--max-parts", "4"]],
  ]) {
    native("build", join(meshes, name), "--out", meshes, "--force", ...flags);
    const baked = bake(name, readFileSync(join(meshes, name)), options);
    assert.deepEqual(Buffer.from(baked.pack), readFileSync(join(meshes, name.replace(".obj", ".hullmap"))), `${name} ${flags.join(" ")}`);
    equal++;
  }
}
const extensions = new Set(files.map((name) => name.split(".").pop()));
console.log(`${equal} packs have the same bytes as the command's packs (${[...extensions].sort().join(", ")})`);

// Answers are equal to the last bit: the same pose, the same pack.
for (const name of files) native("build", join(meshes, name), "--out", meshes, "--force");
const solid = files.filter((name) => !/sheet|segment|point|two_objects/.test(name)).map((name) => join(meshes, `${basename(name).replace(/\.[^.]*$/, "")}.hullmap`));
let state = 5;
const random = () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 31 - 1;
let hits = 0, queries = 0;
for (const [i, a] of solid.entries()) {
  const b = solid[(i + 1) % solid.length];
  const hulls = [a, b].map((path) => new Pack(readFileSync(path)).hull(0));
  const reach = (hulls[0].diameter + hulls[1].diameter) / 4;
  const poses = Array.from({ length: 10 }, () => [
    ...[0, 1, 2].map((axis) => hulls[0].centroid[axis] - hulls[1].centroid[axis] + 1.6 * reach * random()),
    ...[random(), random(), random(), random()],
  ]);
  // One pose at a time: within one call, the command remembers the pose before.
  const query = (mode, pose) => JSON.parse(native("query", a, b, "--mode", mode, "--json", "--pose", pose.join(" ")));
  for (const pose of poses) {
    const pair = new Pair(...hulls), numbers = new Float64Array(pose);
    const contact = pair.contact(numbers), expected = query("contact", pose);
    assert.equal(contact.hit, expected.hit);
    if (contact.hit) {
      hits++;
      for (const [mine, theirs] of [["depth", "depth"], ["depthLower", "depth_lower"], ["depthUpper", "depth_upper"]]) {
        assert.equal(contact[mine], expected[theirs], `${a} ${b} ${pose}: ${mine}`);
      }
      assert.deepEqual([...contact.normal], expected.normal);
      assert.deepEqual([...contact.pointA], expected.point_a);
      assert.deepEqual([...contact.pointB], expected.point_b);
    }
    pair.forget();
    const distance = pair.distance(numbers), gap = query("distance", pose);
    assert.deepEqual([distance.distance, distance.lower, distance.upper], [gap.distance, gap.distance_lower, gap.distance_upper]);
    queries += 2;
    pair.free();
  }
}
assert.ok(hits > 0.2 * (queries / 2) && hits < 0.8 * (queries / 2), `${hits} of ${queries / 2} pairs overlap`);
console.log(`${queries} contacts and distances have the same bits as in the command (${hits} of ${queries / 2} pairs overlap)`);

testLevels({ bakeLevel, Level, Pack, Pair, Shape }, native, meshes);

// Arrays of a cube.
const corners = Array.from({ length: 8 }, (_, i) => `v ${i & 1} ${(i >> 1) & 1} ${i >> 2}\n`).join("");
const baked = bake("cube.obj", new TextEncoder().encode(corners));
assert.deepEqual(baked.notes, ["the file has no elements, so all vertices are used (a point cloud)"]);
const pack = new Pack(baked.pack), cube = pack.hull(0);
assert.deepEqual([pack.hullCount, pack.source, pack.options], [1, "cube.obj", "split none, vertices referenced, index tree 8"]);
assert.equal(pack.hullNamed("cube").vertexCount, 8);
assert.throws(() => pack.hullNamed("sphere"), /no hull has the name "sphere": the pack has 1 \(cube\)/);
assert.deepEqual([cube.name, cube.rank, cube.vertexCount, cube.faceCount], ["cube", 3, 8, 6]);
assert.ok(Math.abs(cube.volume - 1) < 1e-12);
assert.deepEqual([cube.vertices().length, cube.triangles().length, cube.edges().length], [24, 36, 24]);
assert.deepEqual([cube.faceStarts().length, cube.faceVertices().length, cube.neighbours().length], [6, 24, 24]);
assert.deepEqual([...cube.bounds], [0, 0, 0, 1, 1, 1]);
assert.deepEqual([...cube.support([1, 1, 1]).point], [1, 1, 1]);
assert.throws(() => cube.support(0, 0, 1), /expected an array of numbers/);
assert.throws(() => cube.support([0, NaN, 1]), /finite/);
assert.equal(cube.supports(new Float32Array([1, 1, 1, -1, -1, -1])).length, 2);
// Points have no mesh whose mass is known.
assert.deepEqual([cube.meshMassProperties(1), cube.voids, cube.primitive], [undefined, undefined, undefined]);
const weight = pack.massProperties(3);
assert.ok(weight.source === "hulls" && Math.abs(weight.mass - 3) < 1e-12 && Math.abs(weight.centerOfMass[0] - 0.5) < 1e-12);
assert.ok(Math.abs(weight.inertia[4] - 0.5) < 1e-12);
for (const wrong of [undefined, -1, NaN, Infinity]) {
  assert.throws(() => pack.massProperties(wrong), /density: expected a finite number from 0, found/);
  assert.throws(() => cube.meshMassProperties(wrong), /density: expected/);
}
// A recentred hull knows where it was.
const centred = new Pack(bakeMesh(cube.vertices(), null, { recentre: true }).pack).hull(0);
assert.deepEqual([[...cube.origin], [...centred.origin]], [[0, 0, 0], [0.5, 0.5, 0.5]]);
const { faces, map } = gaussMap(baked.pack, 0, 64);
assert.deepEqual([faces.length, map.resolution, map.line_starts.length], [6, 64, 7]);
const stacked = new Pair(cube, cube);
assert.equal(stacked.intersects(new Float64Array([0, 0, 0.99, 0, 0, 0, 1])), "overlapping");
const manifold = stacked.manifold(new Float64Array([0, 0, 0.99, 0, 0, 0, 1]));
assert.equal(manifold.points.length, 4);
assert.ok(Math.hypot(manifold.normal[0], manifold.normal[1], manifold.normal[2] - 1) < 1e-9);
assert.ok(manifold.points.every((point) => Math.abs(point.depth - 0.01) < 1e-6 && point.status === "exact"));

// Arrays bake to the hull of a file with the same numbers, whatever their type.
const text = readFileSync(join(meshes, "gear.obj"), "utf8").split("\n").map((line) => line.split(/\s+/));
const positions = text.filter(([word]) => word === "v").flatMap(([, ...numbers]) => numbers.map(Number));
// Polygons as fans.
const indices = text.filter(([word]) => word === "f").flatMap(([, ...corners]) => corners.slice(2).flatMap((_, i) => [0, i + 1, i + 2].map((at) => Number(corners[at]) - 1)));
const [ofFile, ofCloud] = ["referenced", "all"].map((vertices) => new Pack(bake("gear.obj", readFileSync(join(meshes, "gear.obj")), { vertices }).pack).hull(0));
for (const [points, corners] of [[positions, indices], [new Float64Array(positions), new Uint32Array(indices)], [new Float32Array(positions), new Uint16Array(indices)], [positions, null], [positions, undefined]]) {
  const gear = bakeMesh(points, corners, { name: "gear" });
  const opened = new Pack(gear.pack);
  assert.deepEqual([opened.hull(0).name, opened.source], ["gear", ""]);
  assert.deepEqual(opened.hull(0).vertices(), (corners ? ofFile : ofCloud).vertices());
  assert.equal(gear.triangles.length, corners ? indices.length : 0);
  // Vertices that no triangle references are left out.
  assert.equal(gear.positions.length, corners ? 3 * new Set(indices).size : positions.length);
}
assert.equal(new Pack(bakeMesh(positions).pack).hull(0).name, "mesh");
// Attributes of three.js, here with other numbers between the positions.
const attribute = (itemSize, numbers, stride = itemSize) => {
  const array = Array.from({ length: (numbers.length / itemSize) * stride }, (_, i) => (i % stride < itemSize ? numbers[Math.floor(i / stride) * itemSize + (i % stride)] : 1e6));
  const [getX, getY, getZ] = [0, 1, 2].map((axis) => (i) => array[stride * i + axis]);
  return { count: numbers.length / itemSize, itemSize, array, getX, getY, getZ };
};
assert.deepEqual(bakeMesh(attribute(3, positions, 8), attribute(1, indices), { name: "gear" }).pack, bakeMesh(positions, indices, { name: "gear" }).pack);
// Fans of the gear's concave faces overlap: no solid. The triangles of the import do not.
const imported = bake("gear.obj", readFileSync(join(meshes, "gear.obj")), {});
const gear = new Pack(bakeMesh(imported.positions, imported.triangles, { decompose: true }).pack);
assert.ok(gear.hullCount > 2 && gear.hull(0).partCount === gear.hullCount && gear.hull(0).uncovered < 1e-6);
const gearMass = gear.massProperties(2), part = gear.hull(0);
assert.ok(gearMass.source === "mesh" && part.meshMassProperties(2).mass === gearMass.mass);
assert.ok(gearMass.mass < 2 * Array.from({ length: gear.hullCount }, (_, i) => gear.hull(i).volume).reduce((a, b) => a + b));
assert.ok(part.voids.share >= 0 && part.voids.error < 0.01 && part.primitive === undefined);
const shares = [];
const heard = bakeMesh(imported.positions, imported.triangles, { decompose: true }, (share) => shares.push(share));
assert.ok(shares.length > 5 && shares.every((share, i) => share > (shares[i - 1] ?? 0) && share <= 1), shares.join());
assert.deepEqual(heard.pack, bakeMesh(imported.positions, imported.triangles, { decompose: true }).pack);
for (const listener of [(share) => share < 0.1, () => { throw new Error("enough"); }]) {
  assert.throws(() => bake("gear.obj", readFileSync(join(meshes, "gear.obj")), { decompose: true }, listener), /cancelled/);
}
assert.throws(() => bakeMesh(attribute(2, [0, 0])), /expected an array of numbers, .* or an attribute of three.js/);
const flat = bakeMesh(positions, null, { decompose: true });
assert.match([...flat.notes, ...flat.warnings].join(), /mesh: not decomposed, because it has no faces/);

// Primitives and half-spaces, against a cube from 0 to 1: depth, distance, and an empty answer.
const at = (x, y, z) => [x, y, z, 0, 0, 0, 1];
// The tolerance of a query is 1e-5 of the answer.
const near = (number, expected) => assert.ok(Math.abs(number - expected) <= 2e-5 * Math.abs(expected), `${number}, expected ${expected}`);
for (const [shape, reach] of [
  [Shape.sphere(0.5), 0.5], [Shape.box([0.5, 1, 1]), 0.5], [Shape.capsule(1, 0.5), 0.5], [Shape.cylinder(1, 0.5), 0.5],
  [Shape.segment([-0.5, 0, 0], [0.5, 0, 0]), 0.5], [Shape.triangle([-0.5, 0, 0], [0.5, 1, 0], [0.5, -1, 0]), 0.5],
]) {
  for (const body of [cube, pack, pack.shape(), cube.shape()]) {
    const pair = new Pair(body, shape);
    near(pair.contact(at(1.1, 0.5, 0.5)).depth, reach - 0.1);
    near(pair.distance(at(3, 0.5, 0.5)).distance, 2 - reach);
    const apart = pair.contact(at(3, 0.5, 0.5));
    assert.deepEqual([apart.hit, apart.status, pair.manifold(at(3, 0.5, 0.5)).points.length], [false, "separated", 0]);
    assert.ok(pair.manifold(at(1.1, 0.5, 0.5)).points.length > 0);
    // The same with the bodies exchanged.
    near(new Pair(shape, body).contact(at(-1.1, -0.5, -0.5)).depth, reach - 0.1);
    near(shape.ray([-9, 0, 0], [2, 0, 0]).t, (9 - reach) / 2);
    assert.equal(shape.ray([-9, 0, 0], [2, 0, 0], 4).hit, false);
  }
}
near(new Pair(cube, Shape.cone(0.5, 0.25)).distance(at(0.5, 0.5, -1)).distance, 0.5);
near(Shape.cone(0.5, 0.25).ray([-9, 0, 0], [1, 0, 0]).t, 9 - 0.125);
const ground = Shape.halfSpace([0, 0, 2], 0);
for (const body of [cube, pack]) {
  const pair = new Pair(ground, body);
  near(pair.contact(at(0, 0, -0.1)).depth, 0.1);
  near(pair.distance(at(0, 0, 0.3)).distance, 0.3);
  assert.equal(pair.manifold(at(0, 0, -0.1)).points.length, 4);
}
near(ground.ray([0, 0, 3], [0, 0, -1]).t, 3);

// A pack with two hulls: the answers name those that decided it.
const both = new Pack(bake("two_objects.obj", readFileSync(join(meshes, "two_objects.obj")), { split: "object" }).pack);
const between = new Pair(both, Shape.sphere(0.5)), gap = between.distance(at(0.25, 0, 0));
near(gap.distance, 0.25);
assert.deepEqual([...gap.parts], [1, 0]);
assert.deepEqual([...new Pair(Shape.sphere(0.5), both).distance(at(-0.25, 0, 0)).parts], [0, 1]);
const none = between.contact(at(0.25, 0, 0));
assert.ok(!none.hit && none.normal.every(Number.isNaN));
const touching = new Pair(both, both).manifold(at(0, 0, 1.99));
assert.deepEqual([touching.dropped, ...new Set(touching.points.map((point) => point.parts.join()))], [0, "0,0", "1,1"]);
assert.equal(both.shape().ray([2.2, 0.1, 5], [0, 0, -1]).part, 1);

// Batches have the answers of single queries, to the last bit, and so do rays.
const many = Array.from({ length: 200 }, () => [0, 0, 0, 0, 0, 0, 0].map(random).map((x, i) => (i < 3 ? 2 * x : x)));
for (const [a, b] of [[cube, ofFile], [both, ofFile], [ground, both], [Shape.cylinder(1, 1), both]]) {
  const pair = new Pair(a, b), flat = new Float64Array(many.flat());
  const [contacts, distances, overlaps] = [pair.contacts(flat), pair.distances(flat), pair.intersections(flat)];
  for (const [i, pose] of many.entries()) {
    for (const [columns, query] of [[contacts, "contact"], [distances, "distance"]]) {
      pair.forget();
      const single = pair[query](pose);
      assert.deepEqual(Object.keys(columns), Object.keys(single));
      for (const [key, column] of Object.entries(columns)) {
        const width = column.length / many.length, value = single[key];
        const expected = typeof value === "boolean" ? [Number(value)] : width === 1 ? [value] : [...value];
        assert.deepEqual([...column].slice(i * width, (i + 1) * width), expected, `${query} ${i} ${key}`);
      }
    }
    pair.forget();
    assert.equal(overlaps.status[i], pair.intersects(pose));
    assert.equal(overlaps.hit[i], contacts.hit[i]);
  }
  assert.ok(contacts.hit.some((hit) => hit) && contacts.hit.some((hit) => !hit));
}
const origins = new Float64Array(many.flatMap((pose) => pose.slice(0, 3).map((x) => 3 * x))), aim = new Float32Array([0, 0, -1]);
const struck = both.shape().rays(origins, aim, 2);
for (let i = 0; i < many.length; i++) {
  const single = both.shape().ray(origins.subarray(3 * i, 3 * i + 3), aim, 2);
  assert.deepEqual([struck.hit[i], struck.status[i], struck.t[i], struck.part[i]], [Number(single.hit), single.status, single.t, single.part]);
}
for (const [empty, full] of [[stacked.contacts([]), stacked.contacts(at(0, 0, 0))], [cube.shape().rays([], []), cube.shape().rays(aim, aim)]]) {
  assert.deepEqual(Object.keys(empty), Object.keys(full));
  for (const [key, column] of Object.entries(empty)) assert.deepEqual([column.length, column.constructor], [0, full[key].constructor]);
}

// Errors are sentences that name the fault.
const fails = (run, text) => assert.throws(run, (error) => error instanceof Error && error.message.includes(text));
fails(() => new Pack(new Uint8Array(10)), "");
const copied = baked.pack.buffer;
assert.equal(new Pack(copied).hullCount, 1);
for (const wrong of ["text", {}, null, undefined, new Float64Array(9), 7]) {
  fails(() => new Pack(wrong), "expected the bytes of a file");
  fails(() => bake("a.obj", wrong), "expected the bytes of a file");
}
fails(() => gaussMap(baked.pack, 1, 64), "there is no hull 1: the pack has 1");
const damaged = baked.pack;
damaged[200] ^= 1;
fails(() => new Pack(damaged), "checksum");
fails(() => bake("a.obj", new TextEncoder().encode("v 0 0 0\nf 9\n")), "a.obj:2: vertex index 9 is out of range");
fails(() => bake("a.obj", new Uint8Array(), {}), "a.obj");
fails(() => bake("a.obj", new Uint8Array(), { maxparts: 4 }), "unknown option maxparts; did you mean maxParts?");
fails(() => bake("a.obj", new Uint8Array(), { index: "oak" }), "invalid value oak of option index: expected one of tree");
fails(() => bake("a.obj", new Uint8Array(), { maxVertices: 3 }), "invalid value 3 of option maxVertices: expected a whole number of at least 4");
fails(() => stacked.contact(new Float64Array(6)), "a pose has seven numbers");
fails(() => stacked.contact(new Float64Array([NaN, 0, 0, 0, 0, 0, 1])), "translation must be finite");
fails(() => cube.supports(new Float32Array(4)), "three numbers");
fails(() => pack.hull(1), "1");
fails(() => pack.hull(-1), "whole number");
fails(() => pack.hull("cube"), "hullNamed");
for (const wrong of [0, undefined, {}]) {
  fails(() => pack.hullNamed(wrong), "expected the name of a hull");
  for (const make of [bake, bakeLevel]) fails(() => make(wrong, damaged), "expected the name of a mesh file");
}
fails(() => bake(damaged, "a.obj"), "expected the name of a mesh file");
fails(() => gaussMap([1, 2], 0, 64), "expected the bytes of a file");
const apart = { asset: { version: "2.0" }, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }], meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }] };
Object.assign(apart, { accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3" }], bufferViews: [{ buffer: 0, byteLength: 36 }], buffers: [{ uri: "a.bin", byteLength: 36 }] });
fails(() => bake("a.gltf", new TextEncoder().encode(JSON.stringify(apart))), "a.gltf: buffer 0 (a.bin) is missing, since the file is read alone: export it as GLB");
fails(() => new Level(baked.pack), "new Pack");
fails(() => bake("a.obj", new Uint8Array(), { name: "b" }), "option name: the hulls of a file have its names");
fails(() => bake("a.obj", new Uint8Array(), { max_vertices: 8 }), "unknown option max_vertices: write it as in JavaScript, maxVertices");
fails(() => bake("a.obj", new Uint8Array(), { maxVertices: 8, maxError: 1 }), "maxError and maxVertices exclude each other");
fails(() => bake("a.obj", new Uint8Array(), { decomposeSeconds: 1 }), "WebAssembly has no clock");
fails(() => bake("a.obj", new Uint8Array(), { unitScale: [] }), "option unitScale: expected a word, a number or a truth value");
for (const wrong of [8, -1, 0.5, NaN]) fails(() => bakeMesh(Array(24).fill(0), [0, 1, wrong]), `indices[2]: expected a whole number from 0, below the number of vertices, 8, found ${wrong}`);
fails(() => bakeMesh(Array(24).fill(0), [0, 1]), "a triangle has three indices, found 2");
fails(() => bakeMesh([1, 2, 3, 4]), "positions must have three numbers each, found 4");
fails(() => bakeMesh([0, 0, NaN]), "mesh: vertex 0 is (0, 0, NaN), but a hull requires finite points");
fails(() => bakeMesh([]), "mesh");
fails(() => Shape.sphere(-1), "-1");
fails(() => Shape.box([1, 2]), "halfEdges: expected three numbers, found 2");
// Motions: a rod that turns by 90 degrees meets a wall where the formula says.
{
  const rod = new Pair(Shape.box([5, 0.1, 5]), Shape.box([1, 0.01, 0.01]));
  const [start, end] = [[0, -0.7, 0, 0, 0, 0, 1], [0, -0.7, 0, 0, 0, Math.SQRT1_2, Math.SQRT1_2]];
  const found = rod.castMotion(start, end);
  const truth = (Math.asin(0.6 / Math.hypot(1, 0.01)) - Math.atan(0.01)) / (Math.PI / 2);
  assert.ok(found.hit && found.tLower <= truth && truth <= found.tUpper && found.tUpper - found.tLower < 1e-4);
  assert.equal(found.status, "within");
  near(found.normal[1], -1);
  near(interpolatePoses(start, end, 0.5)[6], Math.cos(Math.PI / 8));
  fails(() => interpolatePoses(start, end), "t: expected a number");
  // B is above A, which is turned by 90 degrees about z: along its own y axis is −x in the world.
  const turned = [1, 2, 3, 0, 0, Math.SQRT1_2, Math.SQRT1_2], b = relativePose(turned, [0, 2, 5, 0, 0, Math.SQRT1_2, Math.SQRT1_2]);
  assert.ok([0, 1, 2, 0, 0, 0, 1].every((number, i) => Math.abs(b[i] - number) < 1e-15), b);
  assert.equal(rod.castMotion(start, start).hit, false);
  const packs = new Pair(both, Shape.sphere(0.5)).castMotion(at(2, 0, 9), at(2, 0, -9));
  assert.ok(packs.hit && packs.parts.length === 2);
  near(new Pair(ground, Shape.sphere(0.5)).castMotion(at(0, 0, 2.5), at(0, 0, -1.5)).hit ? 1 : 0, 1);
  fails(() => rod.castMotion([1], end), "seven numbers");
}

fails(() => new Pair(cube, {}), "B: expected a Hull, a Pack, a Shape or a Level");
fails(() => new Pair(cube), "B: expected a Hull, a Pack, a Shape or a Level");
fails(() => new Pair(ground, ground), "two half-spaces have no query");
near(new Pair(cube, ground).distance(at(0, 0, -1)).distance, new Pair(ground, cube).distance(at(0, 0, 1)).distance);
fails(() => stacked.contacts(new Float64Array(6)), "poses must have seven numbers each");
fails(() => stacked.contacts([...at(0, 0, 0), ...at(NaN, 0, 0)]), "pose 1: ");
fails(() => cube.shape().rays([0, 0, 0, 1, 1, 1], Array(9).fill(1)), "2 origins do not fit 3 directions");
fails(() => cube.shape().rays([0, 0, 0, NaN, 1, 1], [0, 0, 1]), "ray 1: ");
fails(() => cube.shape().ray([0, 0], [0, 0, 1]), "origin: expected three numbers, found 2");
const freed = Shape.sphere(1);
freed.free();
fails(() => new Pair(cube, freed), "that was not freed");
fails(() => freed.ray([0, 0, 5], [0, 0, -1]), "the object was freed");

// Time of a contact of two hulls with 10 000 vertices, along a path.
const points = Array.from({ length: 10_000 }, (_, i) => {
  const z = 1 - (2 * i + 1) / 10_000, r = Math.sqrt(1 - z * z), angle = 2.399963229728653 * i;
  return `v ${r * Math.cos(angle)} ${0.8 * r * Math.sin(angle)} ${0.6 * z}\n`;
}).join("");
const bytes = new TextEncoder().encode(points);
let start = performance.now();
const large = bake("ellipsoid.obj", bytes);
const bakeTime = performance.now() - start;
const ellipsoid = new Pack(large.pack).hull(0);
assert.equal(ellipsoid.vertexCount, 10_000);
const moving = new Pair(ellipsoid, ellipsoid), spent = [], path = [];
for (let i = 0; i < 3000; i++) {
  const angle = 0.015 * i, s = Math.sin(angle / 2), c = Math.cos(angle / 2);
  const pose = new Float64Array([1.7 * Math.cos(angle), 1.4 * Math.sin(angle), 0.1, s * 0.6, 0, s * 0.8, c]);
  path.push(...pose);
  start = performance.now();
  moving.contact(pose);
  moving.manifold(pose);
  spent.push(performance.now() - start);
}
spent.sort((x, y) => x - y);
const micros = (share) => (1000 * spent[Math.floor(share * (spent.length - 1))]).toFixed(0);
console.log(`10 000 vertices: baked in ${bakeTime.toFixed(0)} ms; contact and manifold take ${micros(0.5)} µs (median), ${micros(0.99)} µs (99 %)`);
const perPose = (query) => {
  start = performance.now();
  query(path);
  return ((performance.now() - start) / 3).toFixed(1);
};
console.log(`for each pose of a batch: contacts ${perPose((poses) => moving.contacts(poses))} µs, distances ${perPose((poses) => moving.distances(poses))} µs`);

// TypeScript knows the options of the command, but for one that needs a clock.
const interfaceText = /interface BakeOptions \{(.*?)\n\}/s.exec(readFileSync(join(folder, "bake.d.ts"), "utf8"))[1];
const declared = [...interfaceText.matchAll(/^ {4}(\w+)\?:/gm)].map(([, key]) => key);
let known = "";
fails(() => {
  try {
    bakeMesh([0, 0, 0], null, { unknown: 1 });
  } catch (error) {
    known = error.message;
    throw error;
  }
}, "unknown option unknown");
assert.deepEqual(declared.sort(), [...known.split("options are ")[1].split(", ").filter((key) => key !== "decomposeSeconds"), "name"].sort());

// Sizes in the document, to a twentieth: of the files, and as a server with gzip sends them.
const stated = readFileSync(new URL("../../../docs/browser.md", import.meta.url), "utf8");
for (const file of ["hullmap_bg.wasm", "bake_bg.wasm", "../hullmap.tgz", "../hullmap.html"]) {
  const bytes = readFileSync(join(folder, file)), sizes = [bytes.length, gzipSync(bytes, { level: 9 }).length].map((size) => size / 1e6);
  const row = stated.match(new RegExp(`\\| \`${basename(file)}\` \\|[^|]*\\| ([0-9.]+) MB \\| ([0-9.]+) MB \\|`)) ?? [];
  for (const [i, size] of sizes.entries()) {
    assert.ok(Math.abs(row[i + 1] / size - 1) < 0.05, `docs/browser.md: ${basename(file)} has ${sizes.map((size) => size.toFixed(2)).join(" MB, with gzip ")} MB`);
  }
}

console.log("node: passed");
