// EPA: one overlapping pair for each thread. `twin/epa.rs` explains the steps.

// A corner of the polytope: w, offset and, in `word`, a triangle that is to be added. Or a face:
// normal, height and, in `word`, its corners.
struct Cell {
    first: vec3f,
    word: u32,
    second: vec3f,
    height: f32,
}

// MAX_VERTICES + MAX_FACES cells for each thread. Cells of neighbouring threads are neighbours.
@group(0) @binding(8) var<storage, read_write> cells: array<Cell>;

const MAX_VERTICES = 64u;
const MAX_FACES = 124u;
// Triangles that are to be added: as many as there are words of corners.
const MAX_PENDING = 64u;
// Bits of a corner's index in a word.
const INDEX_BITS = 8u;

var<private> thread: u32;
// Cells from one of a thread to its next one.
var<private> stride: u32;

fn cell(at: u32) -> u32 {
    return at * stride + thread;
}

fn triangle(i: u32, j: u32, k: u32) -> u32 {
    return i | (j << INDEX_BITS) | (k << (2u * INDEX_BITS));
}

fn corners_of(word: u32) -> vec3u {
    let mask = (1u << INDEX_BITS) - 1u;
    return vec3u(word & mask, (word >> INDEX_BITS) & mask, word >> (2u * INDEX_BITS));
}

fn add_face(face: u32, word: u32) {
    let ijk = corners_of(word);
    let p = cells[cell(ijk.x)].first;
    let q = cells[cell(ijk.y)].first;
    let r = cells[cell(ijk.z)].first;
    let e = q - p;
    let f = r - p;
    var normal = cross_of(e, f);
    let volume = dot_of(normal, p);
    let long = dot_of(e, e) + dot_of(f, f);
    var height = -1.0;
    if volume > CERTAIN * 0.5 * long * l1(p) {
        let inverse = 1.0 / sqrt(dot_of(normal, normal));
        var least = volume;
        let at_j = dot_of(normal, q);
        let at_k = dot_of(normal, r);
        if at_j < least {
            least = at_j;
        }
        if at_k < least {
            least = at_k;
        }
        normal = normal * inverse;
        height = least * inverse;
    }
    cells[cell(MAX_VERTICES + face)] = Cell(normal, word, vec3f(), height);
}

fn axis_direction(index: u32) -> vec3f {
    var dir = vec3f();
    dir[index >> 1u] = select(-1.0, 1.0, (index & 1u) == 0u);
    return dir;
}

// Removes the faces that see the point w, and leaves the fan over their border as triangles to be
// added. Returns the number of faces left and of triangles; no triangle if there is no room.
fn open_horizon(w: vec3f, apex: u32, faces: u32, error: f32) -> vec2u {
    var face_count = faces;
    var pending = 0u;
    var face = 0u;
    while face < face_count {
        let seen = cell(MAX_VERTICES + face);
        if !(dot_of(cells[seen].first, w) > cells[seen].height + error) {
            face += 1u;
            continue;
        }
        let corners = corners_of(cells[seen].word);
        for (var side = 0u; side < 3u; side++) {
            var start = corners.x;
            var end = corners.y;
            if side == 1u {
                start = corners.y;
                end = corners.z;
            } else if side == 2u {
                start = corners.z;
                end = corners.x;
            }
            let opposite = triangle(end, start, apex);
            var at = 0u;
            while at < pending && cells[cell(at)].word != opposite {
                at += 1u;
            }
            if at < pending {
                pending -= 1u;
                cells[cell(at)].word = cells[cell(pending)].word;
            } else if pending == MAX_PENDING {
                return vec2u(0u, 0u);
            } else {
                cells[cell(pending)].word = triangle(start, end, apex);
                pending += 1u;
            }
        }
        face_count -= 1u;
        cells[seen] = cells[cell(MAX_VERTICES + face_count)];
    }
    // Without a border, the surface is no longer closed.
    if pending == 0u || face_count + pending > MAX_FACES {
        return vec2u(0u, 0u);
    }
    return vec2u(face_count, pending);
}

fn epa(index: u32) {
    let pair = pairs[index];
    var out = answers[index];
    fuel = MAX_READS - out.reads;
    let error = pair.rounding;
    var depth_upper = progress[index].depth_upper;
    var depth_lower = progress[index].depth_lower;
    var dir = axis_direction(0u);
    var corner_count = 0u;
    var face_count = 0u;
    var pending = 0u;
    var height = 0.0;
    // The lowest face so far, of a closed surface with certain volumes.
    var lowest_face = 0u;
    var lowest_height = 0.0;
    var axes = out.status == AXES;
    if !axes {
        for (var corner = 0u; corner < 4u; corner++) {
            let from_corner = progress[index].simplex[corner];
            let ijk = face_of(corner);
            cells[cell(corner)] = Cell(from_corner.w, triangle(ijk.x, ijk.y, ijk.z), from_corner.offset, 0.0);
        }
        corner_count = 4u;
        pending = 4u;
    }
    out.status = RUNNING;
    loop {
        if pending > 0u {
            for (var at = 0u; at < pending; at++) {
                add_face(face_count + at, cells[cell(at)].word);
            }
            face_count += pending;
            pending = 0u;
            var lowest = 0u;
            height = -LOWEST;
            for (var face = 0u; face < face_count; face++) {
                let found = cells[cell(MAX_VERTICES + face)].height;
                if found < height {
                    lowest = face;
                    height = found;
                }
            }
            // NaN takes the failing branch.
            if !(height > 0.0) {
                out.status = STALLED;
                break;
            }
            if height - error > depth_lower {
                depth_lower = height - error;
            }
            lowest_face = cells[cell(MAX_VERTICES + lowest)].word;
            lowest_height = height;
            dir = cells[cell(MAX_VERTICES + lowest)].first;
        }
        if out.steps >= parameters.max_steps {
            out.status = BUDGET;
            break;
        }
        out.steps += 1u;
        let reached = reach(pair, dir);
        if !reached.is_certain {
            out.status = BUDGET;
            break;
        }
        let w = reached.corner.w;
        let along = dot_of(w, dir);
        if along < depth_upper {
            depth_upper = along;
            out.normal = dir;
        }
        if -depth_upper > error {
            out.status = SEPARATED;
            break;
        }
        if !axes {
            if depth_upper - height <= parameters.tolerance * depth_upper + 2.0 * error {
                out.status = OVERLAPPING;
                break;
            }
            if corner_count == MAX_VERTICES {
                out.status = BUDGET;
                break;
            }
            var known = false;
            for (var corner = 0u; corner < corner_count; corner++) {
                if all(cells[cell(corner)].first == w) {
                    known = true;
                }
            }
            if known {
                out.status = STALLED;
                break;
            }
        }
        let apex = corner_count;
        cells[cell(apex)] = Cell(w, 0u, reached.corner.offset, 0.0);
        corner_count += 1u;
        if axes {
            if corner_count < 6u {
                dir = axis_direction(corner_count);
                continue;
            }
            axes = false;
            pending = 8u;
            for (var face = 0u; face < 8u; face++) {
                let i = face & 1u;
                var j = 2u + ((face >> 1u) & 1u);
                var k = 4u + (face >> 2u);
                if ((face ^ (face >> 1u) ^ (face >> 2u)) & 1u) != 0u {
                    let other = j;
                    j = k;
                    k = other;
                }
                cells[cell(face)].word = triangle(i, j, k);
            }
            continue;
        }
        let left = open_horizon(w, apex, face_count, error);
        face_count = left.x;
        pending = left.y;
        if pending == 0u {
            out.status = STALLED;
            break;
        }
    }
    // The closest point of the lowest face, and of those as low: a facet has several triangles.
    let limit = lowest_height + (parameters.tolerance * depth_upper + 2.0 * error);
    var square = -LOWEST;
    for (var at = 0u; lowest_face != 0u && at <= face_count; at++) {
        var word = lowest_face;
        if at > 0u {
            let found = cells[cell(MAX_VERTICES + at - 1u)].height;
            if !(found > 0.0 && found <= limit) {
                continue;
            }
            word = cells[cell(MAX_VERTICES + at - 1u)].word;
        }
        let ijk = corners_of(word);
        simplex[0] = Corner(cells[cell(ijk.x)].first, 0u, cells[cell(ijk.x)].second, 0u);
        simplex[1] = Corner(cells[cell(ijk.y)].first, 0u, cells[cell(ijk.y)].second, 0u);
        simplex[2] = Corner(cells[cell(ijk.z)].first, 0u, cells[cell(ijk.z)].second, 0u);
        let closest = on_triangle(0u, 1u, 2u);
        if closest.square < square {
            square = closest.square;
            out.between = closest.y;
            out.offset = vec3f();
            for (var corner = 0u; corner < 3u; corner++) {
                out.offset = simplex[corner].offset * closest.weights[corner] + out.offset;
            }
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
    } else if !(depth_lower > 0.0) && out.status != BUDGET {
        out.status = OPEN;
    }
    out.reads = MAX_READS - fuel;
    if loops_end_early() {
        let before = out.gjk_steps;
        out = Answer(vec3f(1.0, 0.0, 0.0), 0.0, vec3f(), -LOWEST, vec3f(), BUDGET, out.steps, out.reads, before, 0u);
    }
    answers[index] = out;
}

@compute @workgroup_size(WORKGROUP)
fn expand_pairs(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {
    local_thread = local;
    if id.x < list[0] {
        thread = id.x;
        stride = arrayLength(&cells) / (MAX_VERTICES + MAX_FACES);
        epa(list[id.x + 1u]);
    }
}
