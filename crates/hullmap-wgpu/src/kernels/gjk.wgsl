// GJK: one pair for each thread.
//
// Kenwright, section 3. E. G. Gilbert, D. W. Johnson, S. S. Keerthi, "A fast procedure for computing
// the distance between complex objects in three-dimensional space", 1988.
//
// 1. The balls around and inside the hulls may decide.
// 2. A support call in the direction of the origin. Its plane is a lower bound of the distance. A
//    pair that has a simplex from the last batch starts with step 3.
// 3. The point of the simplex closest to the origin is the next upper bound.
// 4. A tetrahedron that holds the origin by more than the rounding error proves an overlap. If it
//    holds it by less, the search continues across its closest face.
// 5. For a depth, EPA continues from any tetrahedron that holds the origin. If GJK finds none, it
//    starts from the axes.

// The simplex with which the pair ended: a vertex of A and one of B for each corner. 0 for no
// corner, CENTER for the centre, otherwise FIRST_WORD + a word of `blocks`. Any numbers are valid:
// those that are not vertices of the pair's hulls are ignored.
struct State {
    corners: array<vec2u, 4>,
}

// For all pairs, from batch to batch.
@group(0) @binding(8) var<storage, read_write> states: array<State>;

// The pairs that EPA continues. Their order depends on which thread is first, and no answer on it.
struct Overlapping {
    count: atomic<u32>,
    indices: array<u32>,
}
@group(0) @binding(7) var<storage, read_write> overlapping: Overlapping;

// Squared length below which a normal has no direction.
const NO_NORMAL = 1e-30;

fn is_vertex(hull: u32, stored: u32) -> bool {
    let start = FIRST_WORD + hulls[hull].block_start * BLOCK_WORDS;
    let at = stored - start;
    return stored >= start && at < hulls[hull].block_count * BLOCK_WORDS && at % BLOCK_WORDS < 8u;
}

// Puts the corners of a state into the simplex, and returns their number.
fn restore(pair: PairRecord, state: State) -> u32 {
    var corners = state.corners;
    var size = 0u;
    for (var at = 0u; at < 4u; at++) {
        let ends = corners[at];
        if ends.x == CENTER {
            simplex[size] = Corner(center_of(pair), CENTER, vec3f(), CENTER);
            size += 1u;
        } else if is_vertex(pair.a, ends.x) && is_vertex(pair.b, ends.y) {
            let a = ends.x - FIRST_WORD;
            let b = ends.y - FIRST_WORD;
            let offset_a = offset_of(hulls[pair.a].center, a);
            let offset_b = offset_of(hulls[pair.b].center, b);
            simplex[size] = corner_of(pair, offset_a, a, offset_b, b);
            size += 1u;
        }
    }
    return size;
}

// State of the search. Its corners are in `simplex`.
struct GjkSearch {
    // INTERSECTS, DISTANCE or CONTACT.
    query: u32,
    out: Answer,
    size: u32,
    // Direction of the next support call.
    dir: vec3f,
    // Bounds of the distance.
    upper: f32,
    lower: f32,
    // Square of the upper bound.
    square: f32,
    // Whether the search continues across a face of a tetrahedron that may hold the origin.
    outward: bool,
    // Bounds of the depth.
    depth_upper: f32,
    depth_lower: f32,
}

// The point of the simplex closest to the origin, and where the origin is in a tetrahedron.
struct Nearest {
    closest: Closest,
    // Whether the simplex is a tetrahedron that holds the origin.
    inside: bool,
    // Whether it holds the origin by more than the rounding error.
    certain: bool,
    // The face closest to the origin.
    through: u32,
    // The faces are oriented alike, outwards by this factor.
    outwards: f32,
}

// A face of the tetrahedron. Lengths are in lengths of the normal.
struct FaceInFront {
    // Whether the origin is certainly behind the face.
    is_certain: bool,
    normal: vec3f,
    height: f32,
    // Height of the lowest corner.
    lowest: f32,
}

fn gjk(index: u32) {
    let pair = pairs[index];
    if pair.a == NO_INDEX {
        answers[index] = no_answer(REJECTED);
        return;
    }
    var search = start(pair);
    search.query = parameters.query;
    if parameters.warm != 0u {
        search.size = restore(pair, states[index]);
    }
    // Whether the simplex comes from the last batch. Its closest point is then computed first.
    let restored = search.size > 0u;
    if !restored {
        start_at_center(&search, pair);
    }
    approach(&search, pair, restored);
    finish(&search, index, pair);
}

// Steps 2 to 4, until the pair ends. The search ends by breaks of this loop: compilers turn returns
// from its steps into conditions around all that follows.
fn approach(search: ptr<function, GjkSearch>, pair: PairRecord, starts_restored: bool) {
    var restored = starts_restored;
    while search.out.status == RUNNING && (restored || search.out.steps < parameters.max_steps) {
        if !restored {
            search.out.steps += 1u;
            let reached = reach(pair, search.dir);
            if !reached.is_certain {
                search.out.status = BUDGET;
                break;
            }
            search.out.status = bound_distance(search, reached.corner.w, pair.rounding);
            if search.out.status != RUNNING {
                break;
            }
            simplex[search.size] = reached.corner;
            search.size += 1u;
        }
        restored = false;
        let found = nearest(search, pair);
        if found.inside {
            end_or_go_outward(search, found);
            continue;
        }
        search.outward = false;
        let square = found.closest.square;
        if !(square < search.square) || (search.query == CONTACT && !(square > 0.0)) {
            search.out.status = ended(search.query, search.lower > pair.rounding);
            break;
        }
        search.square = square;
        search.upper = sqrt(square);
        search.out.between = found.closest.y;
        keep_corners(search, found.closest.weights);
        if !(search.upper > 0.0) {
            search.out.status = select(OPEN, AXES, search.query == CONTACT);
            break;
        }
        turn_to_origin(search, found.closest.y);
    }
}

// Step 1.
fn start(pair: PairRecord) -> GjkSearch {
    fuel = MAX_READS;
    var search: GjkSearch;
    search.out = no_answer(RUNNING);
    let center = center_of(pair);
    let error = pair.rounding;
    let far = sqrt(dot_of(center, center));
    search.upper = far;
    search.lower = far - (hulls[pair.a].outer + hulls[pair.b].outer) * pair.scale;
    search.dir = vec3f(1.0, 0.0, 0.0);
    if far > 0.0 {
        search.dir = center * -(1.0 / far);
    }
    search.square = -LOWEST;
    search.depth_upper = -search.lower;
    search.out.normal = search.dir;
    search.out.between = center;
    let deep = (hulls[pair.a].inner + hulls[pair.b].inner) * pair.scale - far;
    if deep > error {
        search.depth_lower = deep - error;
    }
    if parameters.query != CONTACT && deep > error {
        search.out.status = OVERLAPPING;
    } else if parameters.query != DISTANCE && search.lower > error {
        search.out.status = SEPARATED;
    }
    return search;
}

fn start_at_center(search: ptr<function, GjkSearch>, pair: PairRecord) {
    let center = center_of(pair);
    simplex[0] = Corner(center, CENTER, vec3f(), CENTER);
    search.size = 1u;
    search.square = dot_of(center, center);
}

// Hands the simplex over to EPA.
fn hand_over(search: ptr<function, GjkSearch>, index: u32) {
    for (var corner = 0u; corner < 4u; corner++) {
        progress[index].simplex[corner] = simplex[corner];
    }
    progress[index].depth_upper = search.depth_upper;
    progress[index].depth_lower = search.depth_lower;
    overlapping.indices[atomicAdd(&overlapping.count, 1u)] = index;
}

// Outcome of a pair that makes no more progress.
fn ended(query: u32, apart: bool) -> u32 {
    return select(select(OPEN, STALLED, apart), AXES, query == CONTACT);
}

// Step 2: the plane at the support point w bounds the distance from below, and the depth from
// above. Returns the status with which the search ends, or RUNNING.
fn bound_distance(search: ptr<function, GjkSearch>, w: vec3f, error: f32) -> u32 {
    let along = dot_of(w, search.dir);
    if -along > search.lower {
        search.lower = -along;
        search.out.normal = search.dir;
    }
    if along < search.depth_upper {
        search.depth_upper = along;
        if search.query == CONTACT {
            search.out.normal = search.dir;
        }
    }
    var stuck = search.outward && !(along > 2.0 * error);
    for (var corner = 0u; corner < search.size; corner++) {
        if all(simplex[corner].w == w) {
            stuck = true;
        }
    }
    let apart = search.lower > error;
    let narrow = search.upper - search.lower <= parameters.tolerance * search.upper + 2.0 * error;
    if apart && (search.query != DISTANCE || narrow) {
        return SEPARATED;
    }
    return select(RUNNING, ended(search.query, apart), stuck);
}

// If the tetrahedron holds the origin, `dir` becomes the normal of the closest face.
fn nearest(search: ptr<function, GjkSearch>, pair: PairRecord) -> Nearest {
    let size = search.size;
    let none = Closest(vec4f(1.0, 0.0, 0.0, 0.0), center_of(pair), -LOWEST);
    var found = Nearest(none, size == 4u, true, 0u, 1.0);
    var face_count = 0u;
    if size <= 2u {
        found.closest = on_segment(0u, size - 1u);
    } else if size == 3u {
        face_count = 1u;
    } else {
        face_count = 4u;
        let across = cross_of(simplex[1].w - simplex[0].w, simplex[2].w - simplex[0].w);
        if dot_of(across, simplex[3].w - simplex[0].w) > 0.0 {
            found.outwards = -1.0;
        }
    }
    var least = -LOWEST;
    // One call of on_triangle for triangles and tetrahedra, see `reach`.
    for (var face = 0u; face < face_count; face++) {
        let ijk = face_of(face);
        if size == 4u {
            let front = face_in_front(ijk, found.outwards);
            if front.is_certain {
                let length = sqrt(dot_of(front.normal, front.normal));
                if !(front.lowest > pair.rounding * length) {
                    found.certain = false;
                }
                let clearance = front.height * (1.0 / length);
                if clearance < least {
                    least = clearance;
                    found.through = face;
                    search.dir = front.normal * (1.0 / length);
                }
                continue;
            }
            found.inside = false;
        }
        found.closest = nearer(found.closest, on_triangle(ijk.x, ijk.y, ijk.z));
    }
    return found;
}

fn face_in_front(ijk: vec3u, outwards: f32) -> FaceInFront {
    let p = simplex[ijk.x].w;
    let e = simplex[ijk.y].w - p;
    let f = simplex[ijk.z].w - p;
    let normal = cross_of(e, f) * outwards;
    let height = dot_of(normal, p);
    let long = dot_of(e, e) + dot_of(f, f);
    var lowest = height;
    let at_j = dot_of(normal, simplex[ijk.y].w);
    let at_k = dot_of(normal, simplex[ijk.z].w);
    if at_j < lowest {
        lowest = at_j;
    }
    if at_k < lowest {
        lowest = at_k;
    }
    // NaN takes the failing branch.
    return FaceInFront(height > CERTAIN * 0.5 * long * l1(p), normal, height, lowest);
}

// Step 4: the tetrahedron holds the origin.
fn end_or_go_outward(search: ptr<function, GjkSearch>, found: Nearest) {
    if search.query == CONTACT {
        if found.outwards < 0.0 {
            let first = simplex[0];
            simplex[0] = simplex[1];
            simplex[1] = first;
        }
        search.out.status = TETRAHEDRON;
        return;
    }
    if found.certain {
        search.out.status = OVERLAPPING;
        return;
    }
    let ijk = face_of(found.through);
    let i = simplex[ijk.x];
    let j = simplex[ijk.y];
    let k = simplex[ijk.z];
    simplex[0] = i;
    simplex[1] = j;
    simplex[2] = k;
    search.size = 3u;
    search.outward = true;
}

// Keeps the corners with positive weights, and computes A's part of the closest point.
fn keep_corners(search: ptr<function, GjkSearch>, weights: vec4f) {
    search.out.offset = vec3f();
    var kept = 0u;
    for (var corner = 0u; corner < search.size; corner++) {
        let weight = weights[corner];
        if weight > 0.0 {
            let kept_corner = simplex[corner];
            search.out.offset = kept_corner.offset * weight + search.out.offset;
            simplex[kept] = kept_corner;
            kept += 1u;
        }
    }
    search.size = kept;
}

// Turns `dir` from the closest point `y` to the origin.
fn turn_to_origin(search: ptr<function, GjkSearch>, y: vec3f) {
    search.dir = y * -(1.0 / search.upper);
    if search.size == 3u {
        let e = simplex[1].w - simplex[0].w;
        let f = simplex[2].w - simplex[0].w;
        let normal = cross_of(e, f);
        let long = dot_of(normal, normal);
        if long > dot_of(e, e) * dot_of(f, f) * search.square && long > NO_NORMAL {
            var by = 1.0 / sqrt(long);
            if dot_of(normal, simplex[0].w) > 0.0 {
                by = -by;
            }
            search.dir = normal * by;
        }
    }
}

// Stores the answer, the state for the next batch and, if EPA continues, its start.
fn finish(search: ptr<function, GjkSearch>, index: u32, pair: PairRecord) {
    search.out.reads = MAX_READS - fuel;
    if search.out.status == RUNNING {
        search.out.status = BUDGET;
    }
    var state: State;
    for (var corner = 0u; corner < search.size; corner++) {
        state.corners[corner] = vec2u(simplex[corner].a, simplex[corner].b);
    }
    states[index] = state;
    var out = search.out;
    if loops_end_early() {
        out = no_answer(BUDGET);
        out.steps = search.out.steps;
        out.reads = search.out.reads;
    } else if out.status > RUNNING {
        hand_over(search, index);
    } else {
        widen(search, pair.rounding);
        out = search.out;
    }
    answers[index] = out;
}

// The bounds of the answer, widened by the rounding error.
fn widen(search: ptr<function, GjkSearch>, error: f32) {
    search.out.lower = 0.0;
    search.out.upper = 0.0;
    if search.query == CONTACT {
        if search.out.status != SEPARATED {
            search.out.lower = search.depth_lower;
            if search.depth_upper + error > 0.0 {
                search.out.upper = search.depth_upper + error;
            }
        }
    } else if search.out.status != OVERLAPPING {
        if search.lower > error {
            search.out.lower = search.lower - error;
        }
        search.out.upper = search.upper + error;
    }
}

@compute @workgroup_size(WORKGROUP)
fn solve_pairs(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {
    local_thread = local;
    if id.x < parameters.count {
        gjk(id.x);
    }
}
