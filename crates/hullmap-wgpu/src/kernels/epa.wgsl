// EPA: one overlapping pair for each thread.
//
// G. van den Bergen, "Proximity queries and penetration depth computation on 3D game objects", 2001.
//
// 1. Start with the surface of GJK's tetrahedron, or of the support points along the six axes.
// 2. A face is certain if its volume with the origin is. If all are, the lowest height of a corner
//    over a face is a lower bound of the depth: see docs/contributors/intervals.md, section 13.
// 3. The support point beyond the lowest face. Its plane is an upper bound.
// 4. The point replaces the faces that see it. Their border is found by cancelling edges that
//    occur in both directions, so the surface stays closed whatever the rounding.
// 5. The witness points belong to the closest point of the surface.
//
// Deviation: the depth ends as stalled as soon as one face is not certain. There is no surface to
// return to.

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

// The pairs that GJK left to this kernel.
struct Overlapping {
    count: u32,
    indices: array<u32>,
}
@group(0) @binding(7) var<storage, read> overlapping: Overlapping;

// Vertices of the polytope. A closed surface of them has at most 124 faces.
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

// State of the search. The polytope is in `cells`.
struct EpaSearch {
    out: Answer,
    corner_count: u32,
    face_count: u32,
    // Triangles that become faces in the next step.
    pending: u32,
    // Direction of the next support call.
    dir: vec3f,
    // Height of the lowest face.
    height: f32,
    // The lowest face so far, of a closed surface with certain volumes, and its height. 0 for none.
    lowest_face: u32,
    lowest_height: f32,
    depth_upper: f32,
    depth_lower: f32,
    // Whether the search still collects support points along the axes.
    axes: bool,
}

fn epa(index: u32) {
    let pair = pairs[index];
    var search = start(index);
    while search.out.status == RUNNING {
        expand(&search, pair);
    }
    find_witness(&search, pair.rounding);
    answers[index] = finish(&search, pair.rounding);
}

// Step 1.
fn start(index: u32) -> EpaSearch {
    var search: EpaSearch;
    search.out = answers[index];
    fuel = MAX_READS - search.out.reads;
    search.depth_upper = progress[index].depth_upper;
    search.depth_lower = progress[index].depth_lower;
    search.dir = axis_direction(0u);
    search.axes = search.out.status == AXES;
    if !search.axes {
        for (var corner = 0u; corner < 4u; corner++) {
            let from_corner = progress[index].simplex[corner];
            let ijk = face_of(corner);
            cells[cell(corner)] = Cell(from_corner.w, triangle(ijk.x, ijk.y, ijk.z), from_corner.offset, 0.0);
        }
        search.corner_count = 4u;
        search.pending = 4u;
    }
    search.out.status = RUNNING;
    return search;
}

// Steps 2 to 4. The search ends if its status is no longer RUNNING.
fn expand(search: ptr<function, EpaSearch>, pair: PairRecord) {
    let error = pair.rounding;
    if search.pending > 0u && !add_faces(search, error) {
        return;
    }
    if search.out.steps >= parameters.max_steps {
        search.out.status = BUDGET;
        return;
    }
    search.out.steps += 1u;
    let reached = reach(pair, search.dir);
    if !reached.is_certain {
        search.out.status = BUDGET;
        return;
    }
    let w = reached.corner.w;
    if !bound_depth(search, w, error) {
        return;
    }
    let apex = search.corner_count;
    cells[cell(apex)] = Cell(w, 0u, reached.corner.offset, 0.0);
    search.corner_count += 1u;
    if search.axes {
        turn_to_next_axis(search);
        return;
    }
    let left = open_horizon(w, apex, search.face_count, error);
    search.face_count = left.x;
    search.pending = left.y;
    if search.pending == 0u {
        search.out.status = STALLED;
    }
}

// Step 2: the pending triangles become faces. Returns false if the search has ended.
fn add_faces(search: ptr<function, EpaSearch>, error: f32) -> bool {
    for (var at = 0u; at < search.pending; at++) {
        add_face(search.face_count + at, cells[cell(at)].word);
    }
    search.face_count += search.pending;
    search.pending = 0u;
    var lowest = 0u;
    search.height = -LOWEST;
    for (var face = 0u; face < search.face_count; face++) {
        let found = cells[cell(MAX_VERTICES + face)].height;
        if found < search.height {
            lowest = face;
            search.height = found;
        }
    }
    // NaN takes the failing branch.
    if !(search.height > 0.0) {
        search.out.status = STALLED;
        return false;
    }
    if search.height - error > search.depth_lower {
        search.depth_lower = search.height - error;
    }
    search.lowest_face = cells[cell(MAX_VERTICES + lowest)].word;
    search.lowest_height = search.height;
    search.dir = cells[cell(MAX_VERTICES + lowest)].first;
    return true;
}

// Step 3: the plane at the support point w bounds the depth from above. Returns false if the search
// has ended.
fn bound_depth(search: ptr<function, EpaSearch>, w: vec3f, error: f32) -> bool {
    let along = dot_of(w, search.dir);
    if along < search.depth_upper {
        search.depth_upper = along;
        search.out.normal = search.dir;
    }
    if -search.depth_upper > error {
        search.out.status = SEPARATED;
    } else if !search.axes {
        if search.depth_upper - search.height <= parameters.tolerance * search.depth_upper + 2.0 * error {
            search.out.status = OVERLAPPING;
        } else if search.corner_count == MAX_VERTICES {
            search.out.status = BUDGET;
        } else if is_corner(w, search.corner_count) {
            search.out.status = STALLED;
        }
    }
    return search.out.status == RUNNING;
}

fn is_corner(w: vec3f, corner_count: u32) -> bool {
    var known = false;
    for (var corner = 0u; corner < corner_count; corner++) {
        if all(cells[cell(corner)].first == w) {
            known = true;
        }
    }
    return known;
}

// The next support point along the axes, or the octahedron of all six.
fn turn_to_next_axis(search: ptr<function, EpaSearch>) {
    if search.corner_count < 6u {
        search.dir = axis_direction(search.corner_count);
        return;
    }
    search.axes = false;
    search.pending = 8u;
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
}

// Step 5: the closest point of the lowest face, and of those as low. A facet has several triangles.
fn find_witness(search: ptr<function, EpaSearch>, error: f32) {
    let limit = search.lowest_height + (parameters.tolerance * search.depth_upper + 2.0 * error);
    var square = -LOWEST;
    for (var at = 0u; search.lowest_face != 0u && at <= search.face_count; at++) {
        var word = search.lowest_face;
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
            search.out.between = closest.y;
            search.out.offset = vec3f();
            for (var corner = 0u; corner < 3u; corner++) {
                search.out.offset = simplex[corner].offset * closest.weights[corner] + search.out.offset;
            }
        }
    }
}

// The answer, with its bounds widened by the rounding error.
fn finish(search: ptr<function, EpaSearch>, error: f32) -> Answer {
    var out = search.out;
    out.lower = search.depth_lower;
    out.upper = 0.0;
    if search.depth_upper + error > 0.0 {
        out.upper = search.depth_upper + error;
    }
    if out.status == SEPARATED {
        out.lower = 0.0;
        out.upper = 0.0;
    } else if !(search.depth_lower > 0.0) && out.status != BUDGET {
        out.status = OPEN;
    }
    out.reads = MAX_READS - fuel;
    if loops_end_early() {
        let before = out;
        out = no_answer(BUDGET);
        out.steps = before.steps;
        out.reads = before.reads;
    }
    return out;
}

@compute @workgroup_size(WORKGROUP)
fn expand_pairs(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {
    local_thread = local;
    if id.x < overlapping.count {
        thread = id.x;
        stride = arrayLength(&cells) / (MAX_VERTICES + MAX_FACES);
        epa(overlapping.indices[id.x]);
    }
}
