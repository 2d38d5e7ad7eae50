// Structures that the kernels read and write, and the arithmetic of all kernels. `records.rs` has
// the same structures.

struct Hull {
    center: vec3f,
    outer: f32,
    inner: f32,
    kind: u32,
    resolution: u32,
    leaf_blocks: u32,
    slot_start: u32,
    slot_count: u32,
    block_start: u32,
    block_count: u32,
}

// Coordinates and indices of eight vertices, as in the file.
struct Block {
    x: array<vec4f, 2>,
    y: array<vec4f, 2>,
    z: array<vec4f, 2>,
    vertex: array<vec4u, 2>,
}

struct PairRecord {
    row_x: vec4f,
    row_y: vec4f,
    row_z: vec4f,
    a: u32,
    b: u32,
    rounding: f32,
    scale: f32,
}

struct Answer {
    normal: vec3f,
    lower: f32,
    offset: vec3f,
    upper: f32,
    between: vec3f,
    status: u32,
    steps: u32,
    reads: u32,
    padding_x: u32,
    padding_y: u32,
}

struct Parameters {
    // Pairs or directions of the dispatch, at most.
    count: u32,
    // INTERSECTS, DISTANCE or CONTACT.
    query: u32,
    // Steps after which a pair ends.
    max_steps: u32,
    tolerance: f32,
    // 1 if pairs start from the simplex of the last batch.
    warm: u32,
    // Always 3, but no compiler can know that: see loops_end_early.
    three: u32,
    padding_x: u32,
    padding_y: u32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> hulls: array<Hull>;
@group(0) @binding(2) var<storage, read> blocks: array<Block>;
@group(0) @binding(3) var<storage, read> slots: array<u32>;

const INTERSECTS = 0u;
const DISTANCE = 1u;
const CONTACT = 2u;

const SEPARATED = 0u;
const OVERLAPPING = 1u;
const OPEN = 2u;
const STALLED = 3u;
const BUDGET = 4u;
const REJECTED = 5u;
// The search continues.
const RUNNING = 6u;
// EPA continues from the tetrahedron, or from the axes.
const TETRAHEDRON = 7u;
const AXES = 8u;

// Maximum number of nodes and blocks that a pair reads. 99 % of the pairs of hulls with up to 65,536
// vertices read less than 300; the others are near the axis of a fan of thousands of faces, and read all of them.
const MAX_READS = 2048u;
// Twice the largest possible f32 would be infinite; every dot product is above this.
const LOWEST = -3.0e38;
// 2⁻²³: bound on the relative error of one operation.
const EPSILON = 1.1920928955078125e-7;
// A volume above this many times the product of the lengths of two edges and a corner is positive.
const CERTAIN = 16.0 * EPSILON;
const NO_INDEX = 0xffffffffu;

fn no_answer(status: u32) -> Answer {
    return Answer(vec3f(1.0, 0.0, 0.0), 0.0, vec3f(), -LOWEST, vec3f(), status, 0u, 0u, 0u, 0u);
}

// Nodes and blocks that may still be read.
var<private> fuel: u32;

// A product and a sum. Tests replace this function by one that rounds as fused operations do.
fn mad(a: f32, b: f32, c: f32) -> f32 {
    return a * b + c;
}

fn dot_of(a: vec3f, b: vec3f) -> f32 {
    return mad(a.z, b.z, mad(a.y, b.y, a.x * b.x));
}

fn cross_of(a: vec3f, b: vec3f) -> vec3f {
    return vec3f(mad(a.y, b.z, -(a.z * b.y)), mad(a.z, b.x, -(a.x * b.z)), mad(a.x, b.y, -(a.y * b.x)));
}

fn l1(a: vec3f) -> f32 {
    return abs(a.x) + abs(a.y) + abs(a.z);
}

// Whether loops end before their conditions say so. Mesa's llvmpipe ends all loops of eight threads
// after 65,535 iterations of any of them. Then nothing that was computed counts.
fn loops_end_early() -> bool {
    var count = 0u;
    while count < parameters.three {
        count += 1u;
    }
    return count != 3u;
}
