// Writes a GLB file of our own making, for the tests of scenes: a dented ring and a wedge, in nodes that
// turn, scale and mirror them.
//
//   node tests/gltf/model.mjs model.glb
import { writeFileSync } from 'node:fs';

function ring() {
    const positions = [], indices = [], [around, across] = [18, 8];
    for (let i = 0; i < around; i++) for (let j = 0; j < across; j++) {
        const [u, v] = [(2 * Math.PI * i) / around, (2 * Math.PI * j) / across];
        const radius = 0.3 + 0.06 * Math.cos(3 * u) * Math.sin(v);
        positions.push((1 + radius * Math.cos(v)) * Math.cos(u), radius * Math.sin(v), (1 + radius * Math.cos(v)) * Math.sin(u));
        const [a, b] = [i * across + j, ((i + 1) % around) * across + j];
        const [c, d] = [i * across + ((j + 1) % across), ((i + 1) % around) * across + ((j + 1) % across)];
        indices.push(a, c, b, b, c, d);
    }
    return { name: 'ring', positions, indices };
}

const wedge = {
    name: 'wedge',
    positions: [0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 1, 0, 1, 0, 0, 1, 1],
    indices: [0, 1, 2, 2, 1, 3, 0, 4, 1, 2, 3, 5, 0, 2, 4, 4, 2, 5, 1, 4, 3, 3, 4, 5],
};

const document = {
    asset: { version: '2.0', generator: 'hullmap' }, scene: 0, scenes: [{ nodes: [0, 3] }],
    nodes: [
        { name: 'body', children: [1, 2], translation: [0, 2, 0] },
        { name: 'wheel', mesh: 0, rotation: [0.7071067811865476, 0, 0, 0.7071067811865476], scale: [0.5, 0.5, 0.5] },
        { name: 'left', mesh: 1, translation: [1.5, 0, 0] },
        { name: 'right', mesh: 1, translation: [-1.5, 0, 0], scale: [-1, 1, 1] },
    ],
    meshes: [], accessors: [], bufferViews: [], buffers: [],
};
const chunks = [];
let length = 0;
function view(array, target) {
    const bytes = Buffer.from(array.buffer);
    document.bufferViews.push({ buffer: 0, byteOffset: length, byteLength: bytes.length, target });
    chunks.push(bytes, Buffer.alloc(-bytes.length & 3));
    length += bytes.length + (-bytes.length & 3);
    return document.bufferViews.length - 1;
}
for (const { name, positions, indices } of [ring(), wedge]) {
    const floats = Float32Array.from(positions);
    const extreme = (pick) => [0, 1, 2].map((axis) => pick(...floats.filter((_, at) => at % 3 === axis)));
    const at = document.accessors.push(
        { bufferView: view(floats, 34962), componentType: 5126, count: floats.length / 3, type: 'VEC3', min: extreme(Math.min), max: extreme(Math.max) },
        { bufferView: view(Uint16Array.from(indices), 34963), componentType: 5123, count: indices.length, type: 'SCALAR' });
    document.meshes.push({ name, primitives: [{ attributes: { POSITION: at - 2 }, indices: at - 1 }] });
}
document.buffers.push({ byteLength: length });
const json = Buffer.from(JSON.stringify(document));
const text = Buffer.concat([json, Buffer.alloc(-json.length & 3, 0x20)]);
const word = (...numbers) => Buffer.from(Uint32Array.from(numbers).buffer);
writeFileSync(process.argv[2], Buffer.concat([
    word(0x46546c67, 2, 28 + text.length + length), word(text.length, 0x4e4f534a), text, word(length, 0x4e4942), ...chunks]));
