// Kernels of the batches: the support query, and GJK on the Minkowski difference. One thread a pair.
//
// `twin.rs` explains the steps. Functions, names and the order of operations are the same there;
// tests compare the bits. Whoever changes one file changes the other.

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

struct Pair {
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

struct Direction {
    dir: vec3f,
    hull: u32,
}

struct FoundRecord {
    offset: vec3f,
    vertex: u32,
    is_certain: u32,
    padding_x: u32,
    padding_y: u32,
    padding_z: u32,
}

struct Parameters {
    count: u32,
    // INTERSECTS, DISTANCE or CONTACT.
    query: u32,
    max_steps: u32,
    tolerance: f32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> hulls: array<Hull>;
@group(0) @binding(2) var<storage, read> blocks: array<u32>;
@group(0) @binding(3) var<storage, read> slots: array<u32>;
@group(0) @binding(4) var<storage, read> pairs: array<Pair>;
@group(0) @binding(5) var<storage, read_write> answers: array<Answer>;
@group(0) @binding(6) var<storage, read> directions: array<Direction>;
@group(0) @binding(7) var<storage, read_write> vertices: array<FoundRecord>;

const SCAN = 0u;
const CUBE_MAP = 1u;
const BINARY = 2u;

const INTERSECTS = 0u;
const DISTANCE = 1u;
const CONTACT = 2u;

const GJK = 0u;
const AXES = 1u;
const EXPAND = 2u;

const SEPARATED = 0u;
const OVERLAPPING = 1u;
const OPEN = 2u;
const STALLED = 3u;
const BUDGET = 4u;
const REJECTED = 5u;

const MAX_READS = 131072u;
const STACK = 32u;
const MAX_VERTICES = 64u;
const MAX_FACES = 124u;
const MAX_EDGES = 64u;
const GRID_BITS = 23u;
const GRID_MASK = 8388607u;
const GRID_SCALE = 4194303.0;
const ROUND_BY = 12582912.0;
const LOWEST = -3.0e38;
const EPSILON = 1.1920928955078125e-7;
const PLANE_DOUBT = 16.0 * EPSILON;
const FAN_DOUBT = 8.0 * EPSILON;
const ANGLE_DOUBT = 32.0 * EPSILON;
const CERTAIN = 16.0 * EPSILON;
const NO_NORMAL = 1e-30;
const NO_INDEX = 0xffffffffu;

// Nodes and blocks that may still be read.
var<private> fuel: u32;

fn dot_of(a: vec3f, b: vec3f) -> f32 {
    return a.z * b.z + (a.y * b.y + a.x * b.x);
}

fn cross_of(a: vec3f, b: vec3f) -> vec3f {
    return vec3f(a.y * b.z + -(a.z * b.y), a.z * b.x + -(a.x * b.z), a.x * b.y + -(a.y * b.x));
}

fn l1(a: vec3f) -> f32 {
    return abs(a.x) + abs(a.y) + abs(a.z);
}

fn decode(low: u32, high: u32) -> f32 {
    let exponent = i32((high >> 20u) & 0x7ffu) - 896;
    if exponent <= 0 {
        return 0.0;
    }
    var magnitude = 0x7f000000u;
    if exponent < 255 {
        magnitude = (u32(exponent) << 23u) | ((high & 0xfffffu) << 3u) | (low >> 29u);
    }
    return bitcast<f32>((high & 0x80000000u) | magnitude);
}

fn slot(hull: u32, at: u32) -> u32 {
    if at < hulls[hull].slot_count {
        return slots[hulls[hull].slot_start + at];
    }
    return 0u;
}

fn number(hull: u32, at: u32) -> f32 {
    return decode(slot(hull, at), slot(hull, at + 1u));
}

fn sides_of(hull: u32, at: u32, stride: u32, dir: vec3f, doubt: f32) -> u32 {
    let normal = vec3f(number(hull, at), number(hull, at + stride), number(hull, at + 2u * stride));
    let height = dot_of(normal, dir);
    if height > doubt {
        return 2u;
    }
    if height < -doubt {
        return 1u;
    }
    if l1(normal) == 0.0 {
        return 1u;
    }
    return 3u;
}

fn step_at(at: f32, last: u32) -> u32 {
    if !(at > 0.0) {
        return 0u;
    }
    if at >= f32(last) {
        return last;
    }
    return u32(at);
}

fn axis_of(hull: u32, at: u32) -> vec3f {
    return vec3f(number(hull, at), number(hull, at + 2u), number(hull, at + 4u));
}

fn steps_of(hull: u32, at: u32, dir: vec3f) -> vec2u {
    let last = (1u << (slot(hull, at + 16u) & 31u)) - 1u;
    let x = dot_of(axis_of(hull, at), dir);
    let y = dot_of(axis_of(hull, at + 6u), dir);
    let doubt = FAN_DOUBT * l1(dir);
    let steep = abs(y) > abs(x);
    let rise = select(y, -x, steep);
    let run = select(x, y, steep);
    let size = abs(run);
    if !(size > 64.0 * doubt) {
        return vec2u(0u, last);
    }
    var turns = 0.0;
    if steep {
        turns += 2.0;
    }
    if run < 0.0 {
        turns += 4.0;
    }
    let angle = rise * (1.0 / run) + turns;
    let error = 4.0 * doubt * (1.0 / size) + ANGLE_DOUBT;
    if !(angle - error > -1.0 && angle + error < 7.0) {
        return vec2u(0u, last);
    }
    let rate = number(hull, at + 14u);
    let from_start = (angle - number(hull, at + 12u)) * rate;
    let spread = error * rate + 8.0 * EPSILON * f32(last);
    return vec2u(step_at(from_start - spread, last), step_at(from_start + spread, last));
}

fn grid(c: f32, inverse: f32) -> u32 {
    var t = c * inverse;
    if t > 1.0 {
        t = 1.0;
    } else if t < -1.0 {
        t = -1.0;
    }
    return bitcast<u32>(t * GRID_SCALE + ROUND_BY) & GRID_MASK;
}

fn descend(hull: u32, along: vec3f) -> u32 {
    var dir = along;
    var axis = 0u;
    var size = abs(dir.x);
    if abs(dir.y) > size {
        axis = 1u;
        size = abs(dir.y);
    }
    if abs(dir.z) > size {
        axis = 2u;
        size = abs(dir.z);
    }
    let inverse = 1.0 / size;
    var u = grid(dir[(axis + 1u) % 3u], inverse);
    var v = grid(dir[(axis + 2u) % 3u], inverse);
    let face = 2u * axis + (bitcast<u32>(dir[axis]) >> 31u);
    if hulls[hull].kind == CUBE_MAP {
        let r = hulls[hull].resolution;
        let column = ((u >> 11u) * r + (((u & 2047u) * r) >> 11u)) >> 12u;
        let row = ((v >> 11u) * r + (((v & 2047u) * r) >> 11u)) >> 12u;
        return slot(hull, (face * r + row) * r + column);
    }
    var word = slot(hull, face);
    u <<= 32u - GRID_BITS;
    v <<= 32u - GRID_BITS;
    for (var level = 0u; level < 2u * GRID_BITS; level++) {
        if (word >> 30u) != 0u || fuel == 0u {
            break;
        }
        fuel -= 1u;
        if hulls[hull].kind == BINARY {
            word = slot(hull, word + (u >> 31u));
            let halved = u << 1u;
            u = v;
            v = halved;
        } else {
            let bits = word & 15u;
            if bits == 0u {
                break;
            }
            word = slot(hull, (word >> 4u) + (((v >> (32u - bits)) << bits) | (u >> (32u - bits))));
            u <<= bits;
            v <<= bits;
        }
    }
    return word;
}

struct Found {
    offset: vec3f,
    vertex: u32,
    is_certain: bool,
}

fn support_of(hull: u32, dir: vec3f) -> Found {
    var found = Found(vec3f(), 0u, true);
    let block_start = hulls[hull].block_start;
    let block_count = hulls[hull].block_count;
    let center = hulls[hull].center;
    var greatest = LOWEST;
    let doubt = PLANE_DOUBT * l1(dir);
    var stack: array<vec2u, STACK>;
    var height = 0u;
    var first = 0u;
    var count = block_count;
    var last_word = NO_INDEX;
    if hulls[hull].kind != SCAN {
        count = 0u;
        stack[0] = vec2u(descend(hull, dir), 0u);
        height = 1u;
    }
    loop {
        if first >= block_count || count > block_count - first {
            found.is_certain = false;
            count = 0u;
        }
        for (var block = 0u; block < count; block++) {
            if fuel == 0u {
                found.is_certain = false;
                break;
            }
            fuel -= 1u;
            let start = (block_start + first + block) * 32u;
            for (var lane = 0u; lane < 8u; lane++) {
                let at = start + lane;
                let offset = vec3f(
                    bitcast<f32>(blocks[at]) - center.x,
                    bitcast<f32>(blocks[at + 8u]) - center.y,
                    bitcast<f32>(blocks[at + 16u]) - center.z,
                );
                let along = dot_of(offset, dir);
                if along > greatest {
                    greatest = along;
                    found.offset = offset;
                    found.vertex = blocks[at + 24u];
                }
            }
        }
        count = 0u;
        first = 0u;
        if height == 0u {
            break;
        }
        if fuel == 0u {
            found.is_certain = false;
            break;
        }
        fuel -= 1u;
        var word = stack[height - 1u].x;
        let end = stack[height - 1u].y;
        if end == 0u {
            height -= 1u;
        } else {
            let at = word;
            word = slot(hull, at);
            stack[height - 1u].x = at + 1u;
            if at + 1u >= end {
                height -= 1u;
            }
        }
        if word == last_word {
            continue;
        }
        last_word = word;
        let payload = word & 0x3fffffffu;
        let at = payload >> 2u;
        let tag = word >> 30u;
        if tag == 1u {
            first = payload;
            count = hulls[hull].leaf_blocks;
        } else if tag == 3u {
            first = slot(hull, payload);
            count = slot(hull, payload + 1u);
            if count == 0u {
                found.is_certain = false;
            }
        } else if tag == 0u || height + 8u > STACK {
            found.is_certain = false;
        } else if (payload & 2u) != 0u {
            let range = steps_of(hull, at, dir);
            stack[height] = vec2u(at + 17u + range.x, at + 18u + range.y);
            height += 1u;
        } else if (payload & 1u) == 0u {
            let sides = sides_of(hull, at, 2u, dir, doubt);
            for (var side = 0u; side < 2u; side++) {
                if ((sides >> side) & 1u) != 0u {
                    stack[height] = vec2u(slot(hull, at + 6u + side), 0u);
                    height += 1u;
                }
            }
        } else {
            var sides = 0u;
            for (var plane = 0u; plane < 7u; plane++) {
                sides |= sides_of(hull, at + 2u * plane, 14u, dir, doubt) << (2u * plane);
            }
            var previous = NO_INDEX;
            for (var part = 0u; part < 8u; part++) {
                let top = part >> 2u;
                let middle = (part >> 1u) & 1u;
                let low = part & 1u;
                let possible = (sides >> top) & (sides >> (2u + 2u * top + middle))
                    & (sides >> (6u + 4u * top + 2u * middle + low)) & 1u;
                let below = slot(hull, at + 42u + part);
                if possible != 0u && below != previous {
                    stack[height] = vec2u(below, 0u);
                    height += 1u;
                    previous = below;
                }
            }
        }
    }
    return found;
}

struct Corner {
    w: vec3f,
    offset: vec3f,
}

struct Closest {
    weights: vec4f,
    y: vec3f,
    square: f32,
}

var<private> simplex: array<Corner, 4>;

fn on_segment(i: u32, j: u32) -> Closest {
    let a = simplex[i].w;
    let b = simplex[j].w;
    let edge = b - a;
    let of_a = dot_of(b, edge);
    let of_b = -dot_of(a, edge);
    var weights = vec4f();
    var y = a;
    if !(of_b > 0.0) {
        weights[i] = 1.0;
    } else if !(of_a > 0.0) {
        weights[j] = 1.0;
        y = b;
    } else {
        let inverse = 1.0 / (of_a + of_b);
        let r = of_a * inverse;
        let s = of_b * inverse;
        weights[i] = r;
        weights[j] = s;
        y = b * s + a * r;
    }
    return Closest(weights, y, dot_of(y, y));
}

fn nearer(a: Closest, b: Closest) -> Closest {
    if b.square < a.square {
        return b;
    }
    return a;
}

fn on_triangle(i: u32, j: u32, k: u32) -> Closest {
    let a = simplex[i].w;
    let b = simplex[j].w;
    let c = simplex[k].w;
    let ab = b - a;
    let ac = c - a;
    let bc = c - b;
    let normal = cross_of(ab, ac);
    let of_a = dot_of(cross_of(b, bc), normal);
    let of_b = -dot_of(cross_of(c, ac), normal);
    let of_c = dot_of(cross_of(a, ab), normal);
    var weights = vec4f();
    if of_a > 0.0 && of_b > 0.0 && of_c > 0.0 {
        let inverse = 1.0 / (of_a + of_b + of_c);
        let r = of_a * inverse;
        let s = of_b * inverse;
        let t = of_c * inverse;
        let y = c * t + (b * s + a * r);
        weights[i] = r;
        weights[j] = s;
        weights[k] = t;
        return Closest(weights, y, dot_of(y, y));
    }
    weights[i] = 1.0;
    var best = Closest(weights, a, -LOWEST);
    if !(of_a > 0.0) {
        best = nearer(best, on_segment(j, k));
    }
    if !(of_b > 0.0) {
        best = nearer(best, on_segment(i, k));
    }
    if !(of_c > 0.0) {
        best = nearer(best, on_segment(i, j));
    }
    return best;
}

struct Face {
    normal: vec3f,
    height: f32,
    corners: vec3u,
}

var<private> polytope: array<Corner, MAX_VERTICES>;
var<private> corner_count: u32;
var<private> faces: array<Face, MAX_FACES>;
var<private> face_count: u32;
var<private> lowest: u32;
var<private> lowest_height: f32;

fn add_face(i: u32, j: u32, k: u32) {
    let p = polytope[i].w;
    let e = polytope[j].w - p;
    let f = polytope[k].w - p;
    let normal = cross_of(e, f);
    let volume = dot_of(normal, p);
    let long = dot_of(e, e) + dot_of(f, f);
    var face = Face(normal, -1.0, vec3u(i, j, k));
    if volume > CERTAIN * 0.5 * long * l1(p) {
        let inverse = 1.0 / sqrt(dot_of(normal, normal));
        var least = volume;
        let at_j = dot_of(normal, polytope[j].w);
        let at_k = dot_of(normal, polytope[k].w);
        if at_j < least {
            least = at_j;
        }
        if at_k < least {
            least = at_k;
        }
        face.normal = normal * inverse;
        face.height = least * inverse;
    }
    faces[face_count] = face;
    face_count += 1u;
}

fn find_lowest() {
    lowest = 0u;
    lowest_height = faces[0].height;
    for (var face = 1u; face < face_count; face++) {
        if faces[face].height < lowest_height {
            lowest = face;
            lowest_height = faces[face].height;
        }
    }
}

fn insert(error: f32) -> bool {
    let apex = corner_count - 1u;
    let w = polytope[apex].w;
    var edges: array<vec2u, MAX_EDGES>;
    var edge_count = 0u;
    var face = 0u;
    while face < face_count {
        let seen = faces[face];
        if !(dot_of(seen.normal, w) > seen.height + error) {
            face += 1u;
            continue;
        }
        for (var side = 0u; side < 3u; side++) {
            let start = seen.corners[side];
            let end = seen.corners[(side + 1u) % 3u];
            var at = 0u;
            while at < edge_count && !(edges[at].x == end && edges[at].y == start) {
                at += 1u;
            }
            if at < edge_count {
                edge_count -= 1u;
                edges[at] = edges[edge_count];
            } else if edge_count == MAX_EDGES {
                return false;
            } else {
                edges[edge_count] = vec2u(start, end);
                edge_count += 1u;
            }
        }
        face_count -= 1u;
        faces[face] = faces[face_count];
    }
    if face_count + edge_count > MAX_FACES {
        return false;
    }
    for (var at = 0u; at < edge_count; at++) {
        add_face(edges[at].x, edges[at].y, apex);
    }
    return true;
}

fn axis_direction(index: u32) -> vec3f {
    var dir = vec3f();
    dir[index >> 1u] = select(-1.0, 1.0, (index & 1u) == 0u);
    return dir;
}

fn face_of(face: u32) -> vec3u {
    switch face {
        case 0u: { return vec3u(0u, 1u, 2u); }
        case 1u: { return vec3u(0u, 3u, 1u); }
        case 2u: { return vec3u(0u, 2u, 3u); }
        default: { return vec3u(1u, 3u, 2u); }
    }
}

fn solve(pair: Pair) -> Answer {
    var out = Answer(vec3f(1.0, 0.0, 0.0), 0.0, vec3f(), -LOWEST, vec3f(), REJECTED, 0u, 0u, 0u, 0u);
    if pair.a == NO_INDEX {
        return out;
    }
    fuel = MAX_READS;
    let center = vec3f(pair.row_x.w, pair.row_y.w, pair.row_z.w);
    let error = pair.rounding;
    let query = parameters.query;
    let far = sqrt(dot_of(center, center));
    var upper = far;
    var lower = far - (hulls[pair.a].outer + hulls[pair.b].outer) * pair.scale;
    var dir = vec3f(1.0, 0.0, 0.0);
    if far > 0.0 {
        dir = center * -(1.0 / far);
    }
    out.normal = dir;
    out.between = center;
    out.status = BUDGET;
    simplex[0] = Corner(center, vec3f());
    var size = 1u;
    var square = far * far;
    var outward = false;
    let deep = (hulls[pair.a].inner + hulls[pair.b].inner) * pair.scale - far;
    if query != CONTACT && deep > error {
        out.status = OVERLAPPING;
    } else if query != DISTANCE && lower > error {
        out.status = SEPARATED;
    }
    var depth_upper = -lower;
    var depth_lower = 0.0;
    if deep > error {
        depth_lower = deep - error;
    }
    var phase = GJK;
    corner_count = 0u;
    face_count = 0u;
    lowest_height = 0.0;
    while out.status == BUDGET && out.steps < parameters.max_steps {
        out.steps += 1u;
        let along_b = vec3f(
            -(pair.row_z.x * dir.z + (pair.row_y.x * dir.y + pair.row_x.x * dir.x)),
            -(pair.row_z.y * dir.z + (pair.row_y.y * dir.y + pair.row_x.y * dir.x)),
            -(pair.row_z.z * dir.z + (pair.row_y.z * dir.y + pair.row_x.z * dir.x)),
        );
        let on_a = support_of(pair.a, dir);
        let on_b = support_of(pair.b, along_b);
        if !(on_a.is_certain && on_b.is_certain) {
            break;
        }
        let offset = on_a.offset * pair.scale;
        let of_b = on_b.offset * pair.scale;
        let turned = vec3f(dot_of(pair.row_x.xyz, of_b), dot_of(pair.row_y.xyz, of_b), dot_of(pair.row_z.xyz, of_b));
        let w = center + (offset - turned);
        let along = dot_of(w, dir);
        if -along > lower {
            lower = -along;
            out.normal = dir;
        }
        if along < depth_upper {
            depth_upper = along;
            if query == CONTACT {
                out.normal = dir;
            }
        }
        let apart = lower > error;
        if apart && (query != DISTANCE || upper - lower <= parameters.tolerance * upper + 2.0 * error) {
            out.status = SEPARATED;
            break;
        }
        if phase != GJK {
            if phase == EXPAND {
                if depth_upper - lowest_height <= parameters.tolerance * depth_upper + 2.0 * error {
                    out.status = OVERLAPPING;
                    break;
                }
                if corner_count == MAX_VERTICES {
                    break;
                }
                var known = false;
                for (var corner = 0u; corner < corner_count; corner++) {
                    if all(polytope[corner].w == w) {
                        known = true;
                    }
                }
                if known {
                    out.status = STALLED;
                    break;
                }
            }
            polytope[corner_count] = Corner(w, offset);
            corner_count += 1u;
            if phase == AXES {
                if corner_count < 6u {
                    dir = axis_direction(corner_count);
                    continue;
                }
                for (var face = 0u; face < 8u; face++) {
                    let i = face & 1u;
                    let j = 2u + ((face >> 1u) & 1u);
                    let k = 4u + (face >> 2u);
                    if ((face ^ (face >> 1u) ^ (face >> 2u)) & 1u) == 0u {
                        add_face(i, j, k);
                    } else {
                        add_face(i, k, j);
                    }
                }
                phase = EXPAND;
            } else if !insert(error) {
                face_count = 0u;
                out.status = STALLED;
                break;
            }
            find_lowest();
            if !(lowest_height > 0.0) {
                out.status = STALLED;
                break;
            }
            if lowest_height - error > depth_lower {
                depth_lower = lowest_height - error;
            }
            dir = faces[lowest].normal;
            continue;
        }
        var stuck = outward && !(along > 2.0 * error);
        for (var corner = 0u; corner < size; corner++) {
            if all(simplex[corner].w == w) {
                stuck = true;
            }
        }
        if stuck {
            if query == CONTACT {
                phase = AXES;
                dir = axis_direction(0u);
                continue;
            }
            out.status = select(OPEN, STALLED, apart);
            break;
        }
        simplex[size] = Corner(w, offset);
        size += 1u;

        var closest = Closest(vec4f(1.0, 0.0, 0.0, 0.0), center, -LOWEST);
        var inside = false;
        if size == 2u {
            closest = on_segment(0u, 1u);
        } else if size == 3u {
            closest = on_triangle(0u, 1u, 2u);
        } else {
            inside = true;
            var certain = true;
            var least = -LOWEST;
            var through = 0u;
            let across = cross_of(simplex[1].w - simplex[0].w, simplex[2].w - simplex[0].w);
            var outwards = 1.0;
            if dot_of(across, simplex[3].w - simplex[0].w) > 0.0 {
                outwards = -1.0;
            }
            for (var face = 0u; face < 4u; face++) {
                let ijk = face_of(face);
                let p = simplex[ijk.x].w;
                let e = simplex[ijk.y].w - p;
                let f = simplex[ijk.z].w - p;
                let normal = cross_of(e, f) * outwards;
                let volume = dot_of(normal, p);
                let long = dot_of(e, e) + dot_of(f, f);
                let length = sqrt(dot_of(normal, normal));
                if volume > CERTAIN * 0.5 * long * l1(p) {
                    var height = volume;
                    let at_j = dot_of(normal, simplex[ijk.y].w);
                    let at_k = dot_of(normal, simplex[ijk.z].w);
                    if at_j < height {
                        height = at_j;
                    }
                    if at_k < height {
                        height = at_k;
                    }
                    if !(height > error * length) {
                        certain = false;
                    }
                    let clearance = volume * (1.0 / length);
                    if clearance < least {
                        least = clearance;
                        through = face;
                        dir = normal * (1.0 / length);
                    }
                } else {
                    inside = false;
                    closest = nearer(closest, on_triangle(ijk.x, ijk.y, ijk.z));
                }
            }
            if inside && query == CONTACT {
                for (var corner = 0u; corner < 4u; corner++) {
                    polytope[corner] = simplex[corner];
                }
                corner_count = 4u;
                for (var face = 0u; face < 4u; face++) {
                    let ijk = face_of(face);
                    if outwards > 0.0 {
                        add_face(ijk.x, ijk.y, ijk.z);
                    } else {
                        add_face(ijk.x, ijk.z, ijk.y);
                    }
                }
                phase = EXPAND;
                find_lowest();
                if !(lowest_height > 0.0) {
                    out.status = STALLED;
                    break;
                }
                if lowest_height - error > depth_lower {
                    depth_lower = lowest_height - error;
                }
                dir = faces[lowest].normal;
                continue;
            }
            if inside && certain {
                out.status = OVERLAPPING;
                break;
            }
            if inside {
                let ijk = face_of(through);
                let i = simplex[ijk.x];
                let j = simplex[ijk.y];
                let k = simplex[ijk.z];
                simplex[0] = i;
                simplex[1] = j;
                simplex[2] = k;
                size = 3u;
            }
        }
        outward = inside;
        if inside {
            continue;
        }
        if !(closest.square < square) || (query == CONTACT && !(closest.square > 0.0)) {
            if query == CONTACT {
                phase = AXES;
                dir = axis_direction(0u);
                continue;
            }
            out.status = select(OPEN, STALLED, apart);
            break;
        }
        square = closest.square;
        upper = sqrt(square);
        out.between = closest.y;
        out.offset = vec3f();
        var kept = 0u;
        for (var corner = 0u; corner < size; corner++) {
            let weight = closest.weights[corner];
            if weight > 0.0 {
                let kept_corner = simplex[corner];
                out.offset = kept_corner.offset * weight + out.offset;
                simplex[kept] = kept_corner;
                kept += 1u;
            }
        }
        size = kept;
        if !(upper > 0.0) {
            out.status = OPEN;
            break;
        }
        dir = closest.y * -(1.0 / upper);
        if size == 3u {
            let e = simplex[1].w - simplex[0].w;
            let f = simplex[2].w - simplex[0].w;
            let normal = cross_of(e, f);
            let long = dot_of(normal, normal);
            if long > dot_of(e, e) * dot_of(f, f) * square && long > NO_NORMAL {
                var by = 1.0 / sqrt(long);
                if dot_of(normal, simplex[0].w) > 0.0 {
                    by = -by;
                }
                dir = normal * by;
            }
        }
    }
    out.lower = 0.0;
    if query == CONTACT {
        if face_count > 0u && lowest_height > 0.0 {
            let ijk = faces[lowest].corners;
            simplex[0] = polytope[ijk.x];
            simplex[1] = polytope[ijk.y];
            simplex[2] = polytope[ijk.z];
            let closest = on_triangle(0u, 1u, 2u);
            out.between = closest.y;
            out.offset = vec3f();
            for (var corner = 0u; corner < 3u; corner++) {
                out.offset = simplex[corner].offset * closest.weights[corner] + out.offset;
            }
        }
        out.lower = depth_lower;
        out.upper = 0.0;
        if depth_upper + error > 0.0 {
            out.upper = depth_upper + error;
        }
        if out.status == SEPARATED {
            out.lower = 0.0;
            out.upper = 0.0;
        } else if !(depth_lower > 0.0) && (out.status == OVERLAPPING || out.status == STALLED) {
            out.status = OPEN;
        }
    } else {
        if lower > error {
            out.lower = lower - error;
        }
        out.upper = upper + error;
        if out.status == OVERLAPPING {
            out.lower = 0.0;
            out.upper = 0.0;
        }
    }
    out.reads = MAX_READS - fuel;
    return out;
}

@compute @workgroup_size(64)
fn solve_pairs(@builtin(global_invocation_id) id: vec3u) {
    if id.x < parameters.count {
        answers[id.x] = solve(pairs[id.x]);
    }
}

@compute @workgroup_size(64)
fn find_vertices(@builtin(global_invocation_id) id: vec3u) {
    if id.x < parameters.count {
        fuel = MAX_READS;
        let query = directions[id.x];
        var found = Found(vec3f(), 0u, false);
        if query.hull != NO_INDEX {
            found = support_of(query.hull, query.dir);
        }
        vertices[id.x] = FoundRecord(found.offset, found.vertex, u32(found.is_certain), 0u, 0u, 0u);
    }
}
