// The support query.
//
// 1. The direction's cell, and the branches above its leaf. A direction is placed up to rounding
//    error, which the baker's margin covers.
// 2. Planes and fans have no margin. Wherever f32 cannot distinguish their sides, both are
//    visited, from a small stack.
// 3. The candidate with the maximum dot product, of all leaves visited.

const SCAN = 0u;
const CUBE_MAP = 1u;
const BINARY = 2u;

const STACK = 24u;
const BLOCK_WORDS = 32u;
const WORKGROUP = 64u;
// Rounding to a grid number, see `hullmap_format::cube`.
const GRID_BITS = 23u;
const GRID_MASK = 8388607u;
const GRID_SCALE = 4194303.0;
const ROUND_BY = 12582912.0;
// Width of the slab around a plane in which its side is uncertain, relative to |d|₁.
const PLANE_DOUBT = 16.0 * EPSILON;
// Error of a coordinate in the frame of a fan, relative to |d|₁.
const FAN_DOUBT = 8.0 * EPSILON;
// Rounding error of an angle.
const ANGLE_DOUBT = 32.0 * EPSILON;

// An f64 of two words, truncated to f32.
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
    // Word of `blocks` that holds the vertex's x; NO_INDEX if there is none.
    at: u32,
    is_certain: bool,
}

// Position of the vertex whose x is at word `at` of the blocks.
fn offset_of(center: vec3f, at: u32) -> vec3f {
    let block = at / BLOCK_WORDS;
    let half = (at >> 2u) & 1u;
    let lane_of_half = at & 3u;
    return vec3f(
        blocks[block].x[half][lane_of_half] - center.x,
        blocks[block].y[half][lane_of_half] - center.y,
        blocks[block].z[half][lane_of_half] - center.z,
    );
}

// The stacks of all threads of a workgroup. As private memory they would take registers, since they
// are indexed.
var<workgroup> stacks: array<vec2u, STACK * WORKGROUP>;
var<private> local_thread: u32;

// State of a support query. Entries of its stack in `stacks` are a word, or the range of a fan's
// slots from the first number up to the second.
struct SupportSearch {
    hull: u32,
    block_start: u32,
    block_count: u32,
    center: vec3f,
    dir: vec3f,
    // Half the width of the slab around a plane in which its side is uncertain.
    doubt: f32,
    found: Found,
    // The greatest dot product.
    greatest: f32,
    // Entries on the stack.
    height: u32,
}

// Blocks of a leaf.
struct Leaf {
    first: u32,
    count: u32,
}

fn support_of(hull: u32, dir: vec3f) -> Found {
    var search: SupportSearch;
    search.hull = hull;
    search.block_start = hulls[hull].block_start;
    search.block_count = hulls[hull].block_count;
    search.center = hulls[hull].center;
    search.dir = dir;
    search.doubt = PLANE_DOUBT * l1(dir);
    search.found = Found(vec3f(), NO_INDEX, true);
    search.greatest = LOWEST;
    var leaf = Leaf(0u, search.block_count);
    if hulls[hull].kind != SCAN {
        leaf = Leaf();
        push(&search, vec2u(descend(hull, dir), 0u));
    }
    var last_word = NO_INDEX;
    loop {
        scan(&search, leaf);
        leaf = Leaf();
        if search.height == 0u {
            break;
        }
        if fuel == 0u {
            search.found.is_certain = false;
            break;
        }
        fuel -= 1u;
        let word = pop(&search);
        if word == last_word {
            // The nodes below it are visited already, or on the stack.
            continue;
        }
        last_word = word;
        leaf = visit(&search, word);
    }
    if search.found.at != NO_INDEX {
        search.found.offset = offset_of(search.center, search.found.at);
    }
    return search.found;
}

// Step 3: the candidates of a leaf.
fn scan(search: ptr<function, SupportSearch>, leaf: Leaf) {
    var count = leaf.count;
    if leaf.first >= search.block_count || count > search.block_count - leaf.first {
        search.found.is_certain = false;
        count = 0u;
    }
    for (var block = 0u; block < count; block++) {
        if fuel == 0u {
            search.found.is_certain = false;
            break;
        }
        fuel -= 1u;
        let start = search.block_start + leaf.first + block;
        for (var half = 0u; half < 2u; half++) {
            let z = (blocks[start].z[half] - search.center.z) * search.dir.z;
            let y = (blocks[start].y[half] - search.center.y) * search.dir.y;
            let x = (blocks[start].x[half] - search.center.x) * search.dir.x;
            let along = z + (y + x);
            let at = start * BLOCK_WORDS + 4u * half;
            if along.x > search.greatest {
                search.greatest = along.x;
                search.found.at = at;
            }
            if along.y > search.greatest {
                search.greatest = along.y;
                search.found.at = at + 1u;
            }
            if along.z > search.greatest {
                search.greatest = along.z;
                search.found.at = at + 2u;
            }
            if along.w > search.greatest {
                search.greatest = along.w;
                search.found.at = at + 3u;
            }
        }
    }
}

fn push(search: ptr<function, SupportSearch>, entry: vec2u) {
    stacks[search.height * WORKGROUP + local_thread] = entry;
    search.height += 1u;
}

// Takes the next word from the stack.
fn pop(search: ptr<function, SupportSearch>) -> u32 {
    let top = (search.height - 1u) * WORKGROUP + local_thread;
    var word = stacks[top].x;
    let end = stacks[top].y;
    if end == 0u {
        search.height -= 1u;
    } else {
        let at = word;
        word = slot(search.hull, at);
        stacks[top].x = at + 1u;
        if at + 1u >= end {
            search.height -= 1u;
        }
    }
    return word;
}

// Step 2: returns the leaf to which a word leads, or puts words below it on the stack.
fn visit(search: ptr<function, SupportSearch>, word: u32) -> Leaf {
    let hull = search.hull;
    let payload = word & 0x3fffffffu;
    let at = payload >> 2u;
    let tag = word >> 30u;
    var leaf = Leaf();
    if tag == 1u {
        leaf = Leaf(payload, hulls[hull].leaf_blocks);
    } else if tag == 3u {
        leaf = Leaf(slot(hull, payload), slot(hull, payload + 1u));
        if leaf.count == 0u {
            search.found.is_certain = false;
        }
    } else if tag == 0u || search.height + 8u > STACK {
        search.found.is_certain = false;
    } else if (payload & 2u) != 0u {
        let range = steps_of(hull, at, search.dir);
        push(search, vec2u(at + 17u + range.x, at + 18u + range.y));
    } else if (payload & 1u) == 0u {
        let sides = sides_of(hull, at, 2u, search.dir, search.doubt);
        for (var side = 0u; side < 2u; side++) {
            if ((sides >> side) & 1u) != 0u {
                push(search, vec2u(slot(hull, at + 6u + side), 0u));
            }
        }
    } else {
        push_parts(search, at);
    }
    return leaf;
}

// Puts the parts of a bundle in which the direction may be on the stack.
fn push_parts(search: ptr<function, SupportSearch>, at: u32) {
    var sides = 0u;
    for (var plane = 0u; plane < 7u; plane++) {
        sides |= sides_of(search.hull, at + 2u * plane, 14u, search.dir, search.doubt) << (2u * plane);
    }
    var previous = NO_INDEX;
    for (var part = 0u; part < 8u; part++) {
        let top = part >> 2u;
        let middle = (part >> 1u) & 1u;
        let low = part & 1u;
        let possible = (sides >> top) & (sides >> (2u + 2u * top + middle))
            & (sides >> (6u + 4u * top + 2u * middle + low)) & 1u;
        let word = slot(search.hull, at + 42u + part);
        if possible != 0u && word != previous {
            push(search, vec2u(word, 0u));
            previous = word;
        }
    }
}
