// Points of the Minkowski difference, and the closest point of a simplex.

struct Corner {
    w: vec3f,
    // Vertex of A, as in State; likewise `b`.
    a: u32,
    offset: vec3f,
    b: u32,
}

// State that GJK leaves to EPA.
struct Progress {
    simplex: array<Corner, 4>,
    depth_upper: f32,
    depth_lower: f32,
    padding_x: u32,
    padding_y: u32,
}

@group(0) @binding(4) var<storage, read> pairs: array<PairRecord>;
@group(0) @binding(5) var<storage, read_write> answers: array<Answer>;
@group(0) @binding(6) var<storage, read_write> progress: array<Progress>;

const CENTER = 1u;
const FIRST_WORD = 2u;

fn center_of(pair: PairRecord) -> vec3f {
    return vec3f(pair.row_x.w, pair.row_y.w, pair.row_z.w);
}

fn corner_of(pair: PairRecord, from_a: vec3f, a: u32, from_b: vec3f, b: u32) -> Corner {
    let offset = from_a * pair.scale;
    let of_b = from_b * pair.scale;
    let turned = vec3f(dot_of(pair.row_x.xyz, of_b), dot_of(pair.row_y.xyz, of_b), dot_of(pair.row_z.xyz, of_b));
    return Corner(center_of(pair) + (offset - turned), a + FIRST_WORD, offset, b + FIRST_WORD);
}

struct Reached {
    corner: Corner,
    is_certain: bool,
}

fn reach(pair: PairRecord, dir: vec3f) -> Reached {
    var along = dir;
    var hull = pair.a;
    var is_certain = true;
    var on_a: Found;
    var on_b: Found;
    // One call of support_of, since compilers copy it into each place where it is called.
    for (var side = 0u; side < 2u; side++) {
        on_a = on_b;
        on_b = support_of(hull, along);
        is_certain = is_certain && on_b.is_certain;
        hull = pair.b;
        along = vec3f(
            -dot_of(vec3f(pair.row_x.x, pair.row_y.x, pair.row_z.x), dir),
            -dot_of(vec3f(pair.row_x.y, pair.row_y.y, pair.row_z.y), dir),
            -dot_of(vec3f(pair.row_x.z, pair.row_y.z, pair.row_z.z), dir),
        );
    }
    return Reached(corner_of(pair, on_a.offset, on_a.at, on_b.offset, on_b.at), is_certain);
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
    for (var side = 0u; side < 3u; side++) {
        var from_corner = j;
        var to_corner = k;
        var area = of_a;
        if side == 1u {
            from_corner = i;
            area = of_b;
        } else if side == 2u {
            from_corner = i;
            to_corner = j;
            area = of_c;
        }
        if !(area > 0.0) {
            best = nearer(best, on_segment(from_corner, to_corner));
        }
    }
    return best;
}

fn face_of(face: u32) -> vec3u {
    switch face {
        case 0u: { return vec3u(0u, 1u, 2u); }
        case 1u: { return vec3u(0u, 3u, 1u); }
        case 2u: { return vec3u(0u, 2u, 3u); }
        default: { return vec3u(1u, 3u, 2u); }
    }
}
