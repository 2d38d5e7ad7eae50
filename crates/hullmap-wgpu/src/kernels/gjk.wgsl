// GJK: one pair for each thread. `twin/gjk.rs` explains the steps.

// The simplex with which the pair ended: a vertex of A and one of B for each corner. 0 for no
// corner, CENTER for the centre, otherwise FIRST_WORD + a word of `blocks`.
struct State {
    corners: array<vec2u, 4>,
}

// For all pairs, from batch to batch.
@group(0) @binding(8) var<storage, read_write> states: array<State>;

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

fn gjk(index: u32) {
    let pair = pairs[index];
    var out = Answer(vec3f(1.0, 0.0, 0.0), 0.0, vec3f(), -LOWEST, vec3f(), REJECTED, 0u, 0u, 0u, 0u);
    if pair.a == NO_INDEX {
        answers[index] = out;
        return;
    }
    fuel = MAX_READS;
    let center = center_of(pair);
    let error = pair.rounding;
    let query = parameters.query;
    let center_square = dot_of(center, center);
    let far = sqrt(center_square);
    var upper = far;
    var lower = far - (hulls[pair.a].outer + hulls[pair.b].outer) * pair.scale;
    var dir = vec3f(1.0, 0.0, 0.0);
    if far > 0.0 {
        dir = center * -(1.0 / far);
    }
    var size = 0u;
    var square = -LOWEST;
    var outward = false;
    var depth_upper = -lower;
    var depth_lower = 0.0;
    // Whether the simplex comes from the last batch. Its closest point is then computed first.
    var restored = false;
    if (parameters.flags & FIRST) != 0u {
        out.normal = dir;
        out.between = center;
        out.status = RUNNING;
        let deep = (hulls[pair.a].inner + hulls[pair.b].inner) * pair.scale - far;
        if deep > error {
            depth_lower = deep - error;
        }
        if query != CONTACT && deep > error {
            out.status = OVERLAPPING;
        } else if query != DISTANCE && lower > error {
            out.status = SEPARATED;
        }
        if (parameters.flags & WARM) != 0u {
            size = restore(pair, states[index]);
            restored = size > 0u;
        }
        if size == 0u {
            simplex[0] = Corner(center, CENTER, vec3f(), CENTER);
            size = 1u;
            square = center_square;
        }
    } else {
        out = answers[index];
        fuel = MAX_READS - out.reads;
        for (var corner = 0u; corner < 4u; corner++) {
            simplex[corner] = progress[index].simplex[corner];
        }
        dir = progress[index].dir;
        square = progress[index].square;
        upper = progress[index].upper;
        lower = progress[index].lower;
        depth_upper = progress[index].depth_upper;
        depth_lower = progress[index].depth_lower;
        size = progress[index].size;
        outward = progress[index].outward != 0u;
    }
    while out.status == RUNNING && (restored || out.steps < parameters.round_steps) {
        if !restored {
            out.steps += 1u;
            let reached = reach(pair, dir);
            if !reached.is_certain {
                out.status = BUDGET;
                break;
            }
            let w = reached.corner.w;
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
            var stuck = outward && !(along > 2.0 * error);
            for (var corner = 0u; corner < size; corner++) {
                if all(simplex[corner].w == w) {
                    stuck = true;
                }
            }
            if stuck {
                out.status = select(select(OPEN, STALLED, apart), AXES, query == CONTACT);
                break;
            }
            simplex[size] = reached.corner;
            size += 1u;
        }
        restored = false;

        var closest = Closest(vec4f(1.0, 0.0, 0.0, 0.0), center, -LOWEST);
        var inside = size == 4u;
        var certain = true;
        var least = -LOWEST;
        var through = 0u;
        var outwards = 1.0;
        var face_count = 0u;
        if size <= 2u {
            closest = on_segment(0u, size - 1u);
        } else if size == 3u {
            face_count = 1u;
        } else {
            face_count = 4u;
            let across = cross_of(simplex[1].w - simplex[0].w, simplex[2].w - simplex[0].w);
            if dot_of(across, simplex[3].w - simplex[0].w) > 0.0 {
                outwards = -1.0;
            }
        }
        for (var face = 0u; face < face_count; face++) {
            let ijk = face_of(face);
            if size == 4u {
                let p = simplex[ijk.x].w;
                let e = simplex[ijk.y].w - p;
                let f = simplex[ijk.z].w - p;
                let normal = cross_of(e, f) * outwards;
                let volume = dot_of(normal, p);
                let long = dot_of(e, e) + dot_of(f, f);
                if volume > CERTAIN * 0.5 * long * l1(p) {
                    let length = sqrt(dot_of(normal, normal));
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
                    continue;
                }
                inside = false;
            }
            closest = nearer(closest, on_triangle(ijk.x, ijk.y, ijk.z));
        }
        if inside {
            if query == CONTACT {
                if outwards < 0.0 {
                    let first = simplex[0];
                    simplex[0] = simplex[1];
                    simplex[1] = first;
                }
                out.status = TETRAHEDRON;
                break;
            }
            if certain {
                out.status = OVERLAPPING;
                break;
            }
            let ijk = face_of(through);
            let i = simplex[ijk.x];
            let j = simplex[ijk.y];
            let k = simplex[ijk.z];
            simplex[0] = i;
            simplex[1] = j;
            simplex[2] = k;
            size = 3u;
            outward = true;
            continue;
        }
        outward = false;
        if !(closest.square < square) || (query == CONTACT && !(closest.square > 0.0)) {
            out.status = select(select(OPEN, STALLED, lower > error), AXES, query == CONTACT);
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
            out.status = select(OPEN, AXES, query == CONTACT);
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
    out.reads = MAX_READS - fuel;
    out.gjk_steps = out.steps;
    if out.status == RUNNING && out.steps >= parameters.max_steps {
        out.status = BUDGET;
    }
    var state: State;
    for (var corner = 0u; corner < size; corner++) {
        state.corners[corner] = vec2u(simplex[corner].a, simplex[corner].b);
    }
    states[index] = state;
    if out.status >= RUNNING {
        for (var corner = 0u; corner < 4u; corner++) {
            progress[index].simplex[corner] = simplex[corner];
        }
        progress[index].dir = dir;
        progress[index].square = square;
        progress[index].upper = upper;
        progress[index].lower = lower;
        progress[index].depth_upper = depth_upper;
        progress[index].depth_lower = depth_lower;
        progress[index].size = size;
        progress[index].outward = u32(outward);
    } else if query == CONTACT {
        out.lower = depth_lower;
        out.upper = 0.0;
        if depth_upper + error > 0.0 {
            out.upper = depth_upper + error;
        }
        if out.status == SEPARATED {
            out.lower = 0.0;
            out.upper = 0.0;
        }
    } else {
        out.lower = 0.0;
        if lower > error {
            out.lower = lower - error;
        }
        out.upper = upper + error;
        if out.status == OVERLAPPING {
            out.lower = 0.0;
            out.upper = 0.0;
        }
    }
    if loops_end_early() {
        out = Answer(vec3f(1.0, 0.0, 0.0), 0.0, vec3f(), -LOWEST, vec3f(), BUDGET, out.steps, out.reads, out.steps, 0u);
    }
    answers[index] = out;
}

@compute @workgroup_size(WORKGROUP)
fn solve_pairs(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {
    local_thread = local;
    if id.x < list[0] {
        gjk(list[id.x + 1u]);
    }
}
