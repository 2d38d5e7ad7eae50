// Writes streams of meshopt compression and hashes of the bytes that they stand for, as JSON, for the tests of
// `crates/hullmap-import`. meshoptimizer's own encoder makes them, and its decoder applies the filter.
//
//   npm install meshoptimizer && node tests/gltf/streams.mjs > crates/hullmap-import/src/tests/meshopt/streams.json
import { createHash } from 'node:crypto';

import { MeshoptDecoder, MeshoptEncoder } from 'meshoptimizer';

await Promise.all([MeshoptDecoder.ready, MeshoptEncoder.ready]);

// A fixed sequence: the file is the same in each run.
let state = 1;
const random = () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
const base64 = (bytes) => Buffer.from(bytes.buffer, bytes.byteOffset, bytes.byteLength).toString('base64');
const streams = [];

// The encoder may start a triangle at another of its corners.
function turned(bytes, stride) {
    const indices = new (stride === 2 ? Uint16Array : Uint32Array)(bytes.buffer);
    const triangles = Array.from({ length: indices.length / 3 }, (_, at) => Array.from(indices.slice(3 * at, 3 * at + 3)));
    return JSON.stringify(triangles.map(([a, b, c]) => (a <= b && a <= c ? [a, b, c] : b <= c ? [b, c, a] : [c, a, b])));
}

function add(name, mode, filter, source, count, stride, data) {
    const target = new Uint8Array(count * stride);
    MeshoptDecoder.decodeGltfBuffer(target, count, stride, data, mode, filter);
    const isSame = mode === 'TRIANGLES' ? turned(target, stride) === turned(source, stride) : Buffer.compare(target, source) === 0;
    if (filter === 'NONE' && !isSame) throw new Error(`${name} does not decode`);
    streams.push({ name, mode, filter, count, stride, data: base64(data), sha256: createHash('sha256').update(target).digest('hex') });
}

// Attributes: smooth floats, small integers, noise and zeros, in blocks of all lengths.
const bytesOf = {
    floats: (count, stride) => new Uint8Array(Float32Array.from({ length: (count * stride) / 4 }, (_, at) => Math.sin(at * 0.03) * (1 + (at % 3))).buffer),
    shorts: (count, stride) => new Uint8Array(Int16Array.from({ length: (count * stride) / 2 }, (_, at) => Math.floor(at / 2) * ((at % 2) * 2 - 1) + 3 * random()).buffer),
    noise: (count, stride) => Uint8Array.from({ length: count * stride }, () => Math.floor(256 * random())),
    steps: (count, stride) => Uint8Array.from({ length: count * stride }, (_, at) => Math.floor(at / stride) * (random() < 0.9 ? 1 : 9)),
    zeros: (count, stride) => new Uint8Array(count * stride),
};
for (const [kind, count, stride] of [
    ['floats', 1, 12], ['floats', 17, 12], ['floats', 260, 12], ['floats', 40, 16],
    ['shorts', 16, 8], ['shorts', 270, 8], ['noise', 33, 4], ['noise', 35, 20], ['steps', 290, 4],
    ['steps', 31, 8], ['zeros', 600, 12], ['floats', 30, 64], ['noise', 9, 256],
]) {
    const source = bytesOf[kind](count, stride);
    for (const version of [0, 1]) {
        const data = MeshoptEncoder.encodeVertexBufferLevel(source, count, stride, version === 0 ? 2 : 3, version);
        add(`${kind} ${count} x ${stride}`, 'ATTRIBUTES', 'NONE', source, count, stride, data);
    }
}
// Exponents: positions with 15 bits, far from 1 and near 0.
for (const scale of [1, 1e-9, 1e12]) {
    const floats = Float32Array.from({ length: 150 }, (_, at) => scale * Math.sin(at) * 10 ** ((at % 5) - 2));
    const packed = MeshoptEncoder.encodeFilterExp(floats, 50, 12, 15, 'Separate');
    add(`exponents ${scale}`, 'ATTRIBUTES', 'EXPONENTIAL', packed, 50, 12, MeshoptEncoder.encodeVertexBufferLevel(packed, 50, 12, 3, 1));
}
// Indices: a sheet, a list in random order with a restart at 0, and a strip, of two and four bytes.
const sheet = [];
for (let y = 0; y < 9; y++) for (let x = 0; x < 9; x++) {
    const at = 10 * y + x;
    sheet.push(at, at + 1, at + 10, at + 10, at + 1, at + 11);
}
const shuffled = Array.from({ length: 240 }, () => Math.floor(60000 * random()));
const strip = Array.from({ length: 101 }, (_, at) => (at % 2) * 50 + Math.floor(at / 2));
for (const stride of [2, 4]) {
    const list = stride === 2 ? Uint16Array : Uint32Array;
    for (const [name, mode, indices] of [
        ['sheet', 'TRIANGLES', sheet], ['twice', 'TRIANGLES', sheet.concat(sheet)], ['random', 'TRIANGLES', shuffled],
        ['strip', 'INDICES', strip], ['random', 'INDICES', shuffled],
    ]) {
        const source = new Uint8Array(list.from(indices).buffer);
        add(name, mode, 'NONE', source, indices.length, stride, MeshoptEncoder.encodeGltfBuffer(source, indices.length, stride, mode));
    }
}
console.log('[\n' + streams.map((stream) => JSON.stringify(stream)).join(',\n') + '\n]');
