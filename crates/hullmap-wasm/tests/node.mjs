// Tests of the npm package in Node, beside the command `bake`: equal packs, equal answers.
//
//   node node.mjs PACKAGE BAKE FOLDER
//
// FOLDER holds meshes. BAKE is the command; it writes its packs beside the meshes.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";
import { pathToFileURL } from "node:url";

const [folder, command, meshes] = process.argv.slice(2);
const module = await import(pathToFileURL(join(folder, "hullmap.js")));
module.initSync({ module: readFileSync(join(folder, "hullmap_bg.wasm")) });
const { bake, Pack, Pair, version } = module;
const native = (...words) => execFileSync(command, words, { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });

assert.equal(JSON.parse(readFileSync(join(folder, "package.json"))).version, version());
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
  [{ index: "compact" }, ["--index", "compact"]],
  [{ index: "cubemap" }, ["--index", "cubemap"]],
  [{ split: "object", vertices: "all", index: "none" }, ["--split", "object", "--vertices", "all", "--index", "none"]],
  [{ maxVertices: 12 }, ["--max-vertices", "12"]],
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
const extensions = new Set(files.map((name) => name.split(".").pop()));
console.log(`${equal} packs have the same bytes as those of the command (${[...extensions].sort().join(", ")})`);

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
console.log(`${queries} contacts and distances have the same bits as those of the command (${hits} of ${queries / 2} pairs overlap)`);

// Arrays of a cube.
const corners = Array.from({ length: 8 }, (_, i) => `v ${i & 1} ${(i >> 1) & 1} ${i >> 2}\n`).join("");
const baked = bake("cube.obj", new TextEncoder().encode(corners));
assert.deepEqual(baked.notes, ["the file has no elements, so all vertices are used (a point cloud)"]);
const pack = new Pack(baked.pack), cube = pack.hull(0);
assert.deepEqual([pack.hullCount, pack.source, pack.options], [1, "cube.obj", "split none, vertices referenced, index tree 8"]);
assert.equal(pack.hullNamed("cube").vertexCount, 8);
assert.equal(pack.hullNamed("sphere"), undefined);
assert.deepEqual([cube.name, cube.rank, cube.vertexCount, cube.faceCount], ["cube", 3, 8, 6]);
assert.ok(Math.abs(cube.volume - 1) < 1e-12);
assert.deepEqual([cube.vertices().length, cube.triangles().length, cube.edges().length], [24, 36, 24]);
assert.deepEqual([cube.faceStarts().length, cube.faceVertices().length, cube.neighbours().length], [6, 24, 24]);
assert.deepEqual([...cube.bounds], [0, 0, 0, 1, 1, 1]);
assert.deepEqual([...cube.support(1, 1, 1).point], [1, 1, 1]);
assert.equal(cube.supports(new Float32Array([1, 1, 1, -1, -1, -1])).length, 2);
const { faces, map } = cube.gaussMap(64);
assert.deepEqual([faces.length, map.resolution, map.line_starts.length], [6, 64, 7]);
const stacked = new Pair(cube, cube);
assert.equal(stacked.intersects(new Float64Array([0, 0, 0.99, 0, 0, 0, 1])), "overlapping");
const manifold = stacked.manifold(new Float64Array([0, 0, 0.99, 0, 0, 0, 1]));
assert.equal(manifold.points.length, 4);
assert.ok(Math.hypot(manifold.normal[0], manifold.normal[1], manifold.normal[2] - 1) < 1e-9);
assert.ok(manifold.points.every((point) => Math.abs(point.depth - 0.01) < 1e-6));

// Errors are sentences that name the fault.
const fails = (run, text) => assert.throws(run, (error) => error instanceof Error && error.message.includes(text));
fails(() => new Pack(new Uint8Array(10)), "");
const damaged = baked.pack;
damaged[200] ^= 1;
fails(() => new Pack(damaged), "checksum");
fails(() => bake("a.obj", new TextEncoder().encode("v 0 0 0\nf 9\n")), "a.obj:2: vertex index 9 is out of range");
fails(() => bake("a.obj", new Uint8Array(), {}), "a.obj");
fails(() => bake("a.obj", new Uint8Array(), { indx: "tree" }), "unknown option indx: the options are split");
fails(() => bake("a.obj", new Uint8Array(), { index: "oak" }), "invalid value of option index");
fails(() => bake("a.obj", new Uint8Array(), { maxVertices: 3 }), "4 or more");
fails(() => stacked.contact(new Float64Array(6)), "a pose has seven numbers");
fails(() => stacked.contact(new Float64Array([NaN, 0, 0, 0, 0, 0, 1])), "translation must be finite");
fails(() => cube.supports(new Float32Array(4)), "three numbers");
fails(() => pack.hull(1), "1");

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
const moving = new Pair(ellipsoid, ellipsoid), spent = [];
for (let i = 0; i < 3000; i++) {
  const angle = 0.015 * i, s = Math.sin(angle / 2), c = Math.cos(angle / 2);
  const pose = new Float64Array([1.7 * Math.cos(angle), 1.4 * Math.sin(angle), 0.1, s * 0.6, 0, s * 0.8, c]);
  start = performance.now();
  moving.contact(pose);
  moving.manifold(pose);
  spent.push(performance.now() - start);
}
spent.sort((x, y) => x - y);
const micros = (share) => (1000 * spent[Math.floor(share * (spent.length - 1))]).toFixed(0);
console.log(`10 000 vertices: baked in ${bakeTime.toFixed(0)} ms; contact and manifold take ${micros(0.5)} µs (median), ${micros(0.99)} µs (99 %)`);
// The examples of the documents, without the lines that load the module.
let examples = 0;
for (const document of ["../README.md", "../../../README.md", "../../../docs/browser.md"]) {
  const text = readFileSync(new URL(document, import.meta.url), "utf8");
  for (const [, block] of text.matchAll(/```js\n(.*?)```/gs)) {
    const code = block.replace(/^(import init|await init).*$/gm, ""), shown = [];
    new Function("bake", "Pack", "Pair", "bytes", "console", code)(bake, Pack, Pair, bytes, { log: (...values) => shown.push(values) });
    assert.ok(shown.length > 0 && shown[0][0] > 0, `${document}: ${shown}`);
    examples++;
  }
}
assert.equal(examples, 3);

console.log("node: passed");
