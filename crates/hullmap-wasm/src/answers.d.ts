// Made from hullmap.h by crates/hullmap-c/header: do not edit.

/**
 * How a distance or contact query ended, and thus how narrow its interval is. The interval contains
 * the true value whatever the status is.
 */
export type Status =
    /** The interval is as narrow as rounding error allows. */
    | "exact"
    /** The interval is within `tolerance`. */
    | "within"
    /**
     * The shapes touch: rounding error leaves open whether they overlap. A gap or a penetration is
     * at most 64 rounding errors: docs/contributors/intervals.md, section 6, states them. For baked
     * hulls near the origin, that is 1e-10 of the sum of their outer radii.
     */
    | "touching"
    /** The shapes overlap: their distance is 0, or a ray or a motion starts so. */
    | "overlapping"
    /** Certainly no contact, or no hit of a ray or a motion: a separating plane proves it. */
    | "separated"
    /**
     * The iteration limit was reached; the interval is wider than the tolerance, or the witness
     * points are less accurate than the interval.
     */
    | "iteration_limit"
    /**
     * Rounding error stopped all progress; the interval is wider than the tolerance, or the witness
     * points are less accurate than the interval.
     */
    | "stalled";

/** Whether two shapes share a point. */
export type Overlap =
    /** They share no point: a separating plane proves it. Any other status counts as a hit. */
    | "separated"
    /** Their interiors share points. */
    | "overlapping"
    /** They touch, as `touching` defines it. */
    | "touching"
    /** Not known: an iteration limit was reached, or rounding error stopped all progress. */
    | "undecided";

/**
 * Answers of many queries, as one array for each field: three numbers for a vector, two indices for
 * `parts`, and 1 or 0 for `hit`.
 */
export interface Intersections {
    hit: Uint8Array;
    status: Overlap[];
    iterations: Uint32Array;
    supportCalls: Uint32Array;
    parts: Uint32Array;
}

/**
 * Answer of `distance`: the distance of a pair and the witness points that realise it. Lengths are
 * in the shapes' unit, points and directions in A's frame. The interval from `lower` to `upper`
 * always contains the distance.
 */
export interface Distance {
    /** How the query ended, and thus how narrow the interval is. */
    status: Status;
    /** Length of the segment from `pointA` to `pointB`; 0 if the shapes overlap or touch. */
    distance: number;
    /** Lower bound of the distance, at least 0, with allowance for rounding error. */
    lower: number;
    /** Upper bound of the distance, with allowance for rounding error. */
    upper: number;
    /**
     * Unit vector from A to B: the normal of the planes that prove `lower`. It is the direction of
     * the shortest segment within the tolerance.
     */
    normal: Float64Array;
    /** Witness point: the point of A closest to B. If the shapes overlap, a common point. */
    pointA: Float64Array;
    /** Witness point: the point of B closest to A. If the shapes overlap, a common point. */
    pointB: Float64Array;
    /** Number of steps of the search. */
    iterations: number;
    /** Number of support calls. One call queries both shapes once. */
    supportCalls: number;
    /**
     * The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a
     * mesh or a field. 0 for a shape without parts.
     */
    parts: Uint32Array;
}

/**
 * Answers of many queries, as one array for each field: three numbers for a vector, two indices for
 * `parts`, and 1 or 0 for `hit`.
 */
export interface Distances {
    status: Status[];
    distance: Float64Array;
    lower: Float64Array;
    upper: Float64Array;
    normal: Float64Array;
    pointA: Float64Array;
    pointB: Float64Array;
    iterations: Uint32Array;
    supportCalls: Uint32Array;
    parts: Uint32Array;
}

/**
 * Answer of `contact`: penetration depth, normal and witness points of a pair. Lengths are in the
 * shapes' unit, points and directions in A's frame. If rounding error or a limit stopped the
 * search, `status` says so; the interval from `depthLower` to `depthUpper` always contains the
 * depth.
 */
export interface Contact {
    /** False only if a separating plane proves the shapes separated. */
    hit: boolean;
    /** How the query ended, and thus how narrow the interval is. */
    status: Status;
    /**
     * Penetration depth: moving B by this length along `normal` makes the shapes touch. 0 if they
     * are separated or touch.
     */
    depth: number;
    /** Lower bound of the penetration depth, at least 0, with allowance for rounding error. */
    depthLower: number;
    /** Upper bound of the penetration depth, with allowance for rounding error. */
    depthUpper: number;
    /**
     * Unit vector from A to B. If two convex shapes are separated, a separating axis. If parts are
     * separated, the normal and the points are NaN: one axis may not separate them all.
     */
    normal: Float64Array;
    /**
     * Witness point: the point of A that is deepest in B. If the shapes are separated, some point
     * of A; `distance` computes the closest one.
     */
    pointA: Float64Array;
    /**
     * Witness point: the point of B that is deepest in A. If the shapes are separated, some point
     * of B.
     */
    pointB: Float64Array;
    /** Number of steps of all phases together. */
    iterations: number;
    /** Number of support calls. One call queries both shapes once. */
    supportCalls: number;
    /**
     * The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a
     * mesh or a field. 0 for a shape without parts.
     */
    parts: Uint32Array;
}

/**
 * Answers of many queries, as one array for each field: three numbers for a vector, two indices for
 * `parts`, and 1 or 0 for `hit`.
 */
export interface Contacts {
    hit: Uint8Array;
    status: Status[];
    depth: Float64Array;
    depthLower: Float64Array;
    depthUpper: Float64Array;
    normal: Float64Array;
    pointA: Float64Array;
    pointB: Float64Array;
    iterations: Uint32Array;
    supportCalls: Uint32Array;
    parts: Uint32Array;
}

/**
 * Answer of `ray`: where a ray first enters a shape. Points and directions are in the shape's
 * frame. t is a factor of the ray's direction, which need not be of unit length.
 */
export interface RayHit {
    /** False only if it is certain that the ray misses the shape up to `maxT`. */
    hit: boolean;
    /** How the query ended. */
    status: Status;
    /** The ray enters the shape at `origin + t direction`; infinite if there is no hit. */
    t: number;
    /** Lower bound of t, at least 0, with allowance for rounding error. */
    tLower: number;
    /**
     * Upper bound of t, with allowance for rounding error. It may exceed `maxT` if the interval
     * does.
     */
    tUpper: number;
    /**
     * The point at t. If the ray grazes the shape, the point need not be on the shape. The origin
     * if there is no hit.
     */
    point: Float64Array;
    /**
     * Unit outward normal of a support plane of the shape, which the ray crosses at `tLower`. On a
     * polytope, it is the normal of the face at the point. If there is no hit, normal of a plane
     * that takes part in the proof.
     */
    normal: Float64Array;
    /** Number of steps of the search. */
    iterations: number;
    /** Number of support calls. */
    supportCalls: number;
    /**
     * Index of the part that decided the answer: the hull of a pack, the triangle of a mesh or a
     * field. 0 for a shape without parts.
     */
    part: number;
}

/**
 * Answers of many queries, as one array for each field: three numbers for a vector, two indices for
 * `parts`, and 1 or 0 for `hit`.
 */
export interface RayHits {
    hit: Uint8Array;
    status: Status[];
    t: Float64Array;
    tLower: Float64Array;
    tUpper: Float64Array;
    point: Float64Array;
    normal: Float64Array;
    iterations: Uint32Array;
    supportCalls: Uint32Array;
    part: Uint32Array;
}

/**
 * Answer of `cast`: when and where a moving shape first meets another. Points and directions are in
 * A's frame. Times are in the unit that the velocity implies: at time t, B has moved by t times its
 * velocity.
 */
export interface Impact {
    /** False only if it is certain that the shapes do not meet up to `maxT`. */
    hit: boolean;
    /** How the query ended. */
    status: Status;
    /** Time of impact; infinite if there is no hit. */
    t: number;
    /**
     * Lower bound of the time of impact, at least 0, with allowance for rounding error. Until then
     * the shapes certainly do not overlap.
     */
    tLower: number;
    /**
     * Upper bound of the time of impact, with allowance for rounding error. It may exceed `maxT` if
     * the interval does.
     */
    tUpper: number;
    /**
     * Unit vector from A to B: normal of a plane that separates the shapes until `tLower`. If there
     * is no hit, normal of a plane that takes part in the proof.
     */
    normal: Float64Array;
    /**
     * Point of A at which the shapes meet. If they overlap at the start, a common point. Zero if
     * there is no hit.
     */
    pointA: Float64Array;
    /** Point of B at which the shapes meet, at time `t`. */
    pointB: Float64Array;
    /** Number of steps of the search. */
    iterations: number;
    /** Number of support calls. One call queries both shapes once. */
    supportCalls: number;
    /**
     * The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a
     * mesh or a field. 0 for a shape without parts.
     */
    parts: Uint32Array;
}

/**
 * Answer of `castMotion`: when and where two moving shapes first meet. Points and directions are in
 * the common frame of the motions.
 */
export interface TimeOfImpact {
    /** False only if it is certain that the shapes do not meet until time 1. */
    hit: boolean;
    /** How the query ended. */
    status: Status;
    /** Time of impact, between 0 and 1; infinite if there is no hit. */
    t: number;
    /**
     * Lower bound of the time of impact, with allowance for rounding error. Until then the shapes
     * are certainly farther apart than the target distance.
     */
    tLower: number;
    /**
     * Upper bound: at this time the shapes are certainly within the target distance. Infinite if no
     * such time was found.
     */
    tUpper: number;
    /** Unit vector from A to B at `tLower`: normal of a plane that separates the shapes then. */
    normal: Float64Array;
    /** Point of A closest to B at `tLower`. */
    pointA: Float64Array;
    /** Point of B closest to A at `tLower`. */
    pointB: Float64Array;
    /** Number of distance and contact queries. */
    iterations: number;
    /** Number of support calls. One call queries both shapes once. */
    supportCalls: number;
    /**
     * The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a
     * mesh or a field. 0 for a shape without parts.
     */
    parts: Uint32Array;
}
