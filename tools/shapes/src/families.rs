//! Point families: seeded clouds of exactly `n` points, each with a known geometric property.
//!
//! Every family is a function `fn(n, seed) -> Vec<[f32; 3]>`, and [`Family`] lists them by name.
//! All of them guarantee:
//!
//! - `n` points, finite, pairwise distinct, without negative zero, for every `n` from
//!   [`MIN_POINTS`] up to at least a hundred thousand;
//! - the same bits for the same `n` and `seed` on every machine;
//! - coordinates within [-1, 1].
//!
//! "All extreme" means that before rounding to `f32` all points are vertices of their convex hull.
//! Where points are very close together, the rounding error (6e-8 at a distance of one) can move
//! one of them inside.
//!
//! Families without randomness ignore the seed. They take it so that all families have one
//! signature.

use crate::rng::SplitMix64;
use crate::turn::cos_sin;
use crate::vector::{self, Vec3, to_f32};
use std::collections::HashSet;

/// Minimum number of points of a family. Fewer than eight do not form a prism or a grid.
pub const MIN_POINTS: usize = 8;

/// Semi-axes of [`clustered_ellipsoid`].
pub const ELLIPSOID_SEMI_AXES: [f64; 3] = [1.0, 0.6, 0.3];

/// Half the thickness of [`lens`], whose rim has radius 1.
pub const LENS_HALF_THICKNESS: f64 = 0.05;

/// Radius of [`needle`]. Its half-length is 1.
pub const NEEDLE_RADIUS: f64 = 1e-3;

/// Height of the plane that [`flat_sheet`] lies in.
pub const FLAT_SHEET_Z: f32 = 0.25;

/// Maximum number of candidates for each point. After that, the family has no more distinct points.
const MAX_TRIES_PER_POINT: usize = 64;

/// Makes points from their number and a seed.
type Generator = fn(usize, u64) -> Vec<[f32; 3]>;

/// A point family. Families can be iterated over and looked up by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Family {
    /// [`sphere`]
    Sphere,
    /// [`clustered_ellipsoid`]
    ClusteredEllipsoid,
    /// [`rock`]
    Rock,
    /// [`prism`]
    Prism,
    /// [`rotated_prism`]
    RotatedPrism,
    /// [`cone`]
    Cone,
    /// [`lens`]
    Lens,
    /// [`uv_sphere`]
    UvSphere,
    /// [`ball`]
    Ball,
    /// [`cube_grid`]
    CubeGrid,
    /// [`flat_sheet`]
    FlatSheet,
    /// [`needle`]
    Needle,
}

impl Family {
    /// Every family, in a fixed order.
    pub const ALL: [Family; 12] = [
        Family::Sphere,
        Family::ClusteredEllipsoid,
        Family::Rock,
        Family::Prism,
        Family::RotatedPrism,
        Family::Cone,
        Family::Lens,
        Family::UvSphere,
        Family::Ball,
        Family::CubeGrid,
        Family::FlatSheet,
        Family::Needle,
    ];

    /// Name and function of the family.
    const fn generator(self) -> (&'static str, Generator) {
        match self {
            Family::Sphere => ("sphere", sphere),
            Family::ClusteredEllipsoid => ("clustered_ellipsoid", clustered_ellipsoid),
            Family::Rock => ("rock", rock),
            Family::Prism => ("prism", prism),
            Family::RotatedPrism => ("rotated_prism", rotated_prism),
            Family::Cone => ("cone", cone),
            Family::Lens => ("lens", lens),
            Family::UvSphere => ("uv_sphere", uv_sphere),
            Family::Ball => ("ball", ball),
            Family::CubeGrid => ("cube_grid", cube_grid),
            Family::FlatSheet => ("flat_sheet", flat_sheet),
            Family::Needle => ("needle", needle),
        }
    }

    /// Name of the family and of its function.
    pub const fn name(self) -> &'static str {
        self.generator().0
    }

    /// The family with this name, if there is one.
    pub fn from_name(name: &str) -> Option<Family> {
        Family::ALL.into_iter().find(|family| family.name() == name)
    }

    /// Exactly `n` points of the family. Panics if `n` is below [`MIN_POINTS`], or above the number
    /// of distinct `f32` points of the family.
    pub fn points(self, n: usize, seed: u64) -> Vec<[f32; 3]> {
        self.generator().1(n, seed)
    }

    /// Whether the seed changes the points.
    pub const fn is_random(self) -> bool {
        !matches!(self, Family::Prism | Family::RotatedPrism | Family::Cone | Family::UvSphere | Family::CubeGrid)
    }
}

/// Random points on the unit sphere, uniform by area; all extreme.
pub fn sphere(n: usize, seed: u64) -> Vec<[f32; 3]> {
    let mut rng = SplitMix64::new(seed);
    distinct(n, || rng.direction())
}

/// Random points on an ellipsoid, clustered around eight random centres; all extreme.
///
/// One point in eight is uniform, so that no side is empty. The semi-axes are
/// [`ELLIPSOID_SEMI_AXES`]. Panics if `n` is below [`MIN_POINTS`].
pub fn clustered_ellipsoid(n: usize, seed: u64) -> Vec<[f32; 3]> {
    /// Reach of a cluster about its centre, in radii of the unit sphere.
    const CLUSTER_RADIUS: f64 = 0.25;
    let mut rng = SplitMix64::new(seed);
    let centres: [Vec3; 8] = core::array::from_fn(|_| rng.direction());
    distinct(n, || {
        let uniform = rng.direction();
        let on_sphere = if rng.below(8) == 0 {
            uniform
        } else {
            // Linear in the radius: a cluster is denser in the middle, but not so dense that
            // rounded points coincide.
            let reach = CLUSTER_RADIUS * rng.unit();
            let centre = centres[rng.below(centres.len())];
            vector::normalized(vector::add(centre, vector::scale(uniform, reach)))
        };
        stretched(on_sphere, ELLIPSOID_SEMI_AXES)
    })
}

/// A rounded, lopsided boulder with about two dozen knobs; all extreme.
///
/// Points are where random outward normals touch a [`Boulder`], so they crowd on the knobs and thin
/// out between them. Panics if `n` is below [`MIN_POINTS`].
pub fn rock(n: usize, seed: u64) -> Vec<[f32; 3]> {
    let boulder = Boulder::new(seed);
    // The normals continue from another seed, or they would retrace the knobs.
    let mut rng = SplitMix64::new(!seed);
    distinct(n, || boulder.support_point(rng.direction()))
}

/// Two regular polygons one above the other, at z = ±1 and of radius 1; all extreme.
///
/// Both caps are exactly planar. For odd `n` the lower one has a corner more.
pub fn prism(n: usize, _seed: u64) -> Vec<[f32; 3]> {
    distinct_from(n, prism_corners(n))
}

/// The points of [`prism`] scaled by 0.7 and rotated about (3, 1, 2) by a fixed angle. Rounding to
/// `f32` leaves the caps coplanar only to about 6e-8.
pub fn rotated_prism(n: usize, _seed: u64) -> Vec<[f32; 3]> {
    // A prism reaches √2 from its centre: 0.7 keeps any rotation of it within [-1, 1].
    distinct_from(n, prism_corners(n).map(|p| rotated_generic(vector::scale(p, 0.7))))
}

/// A regular polygon of `n` − 1 corners at z = -1, of radius 1, and an apex at z = 1; all extreme.
///
/// The base is exactly planar; the apex is the last point and has `n` − 1 neighbours.
pub fn cone(n: usize, _seed: u64) -> Vec<[f32; 3]> {
    let base = ring(n.saturating_sub(1).max(1), 1.0, -1.0);
    distinct_from(n, base.chain([[0.0, 0.0, 1.0]]))
}

/// Random points on two shallow spherical caps that share a rim of radius 1; all extreme. Twenty
/// times as wide as it is thick: see [`LENS_HALF_THICKNESS`].
pub fn lens(n: usize, seed: u64) -> Vec<[f32; 3]> {
    let radius = lens_sphere_radius();
    let mut rng = SplitMix64::new(seed);
    distinct(n, || {
        // Uniform height on a spherical cap is uniform area.
        let height = rng.between(0.0, LENS_HALF_THICKNESS);
        let below_top = LENS_HALF_THICKNESS - height;
        let r = libm::sqrt(below_top * (2.0 * radius - below_top));
        let angle_rad = core::f64::consts::TAU * rng.unit();
        let side = if rng.below(2) == 0 { 1.0 } else { -1.0 };
        [r * libm::cos(angle_rad), r * libm::sin(angle_rad), side * height]
    })
}

/// Latitude and longitude grid on the unit sphere, poles first and last; all extreme.
///
/// Rings of equal latitude are exactly planar. The lowest ring has the remaining points, and may be
/// sparser than the others. The seed is not used. Panics if `n` is below [`MIN_POINTS`].
pub fn uv_sphere(n: usize, _seed: u64) -> Vec<[f32; 3]> {
    let on_rings = n.saturating_sub(2);
    // Rings span half a turn and segments a whole one: twice as many segments make the cells about
    // square.
    let segments = (2 * on_rings).isqrt().max(3);
    let rings = on_rings.div_ceil(segments);
    let rows = (0..rings).flat_map(|row| {
        let (z, r) = cos_sin(row + 1, 2 * (rings + 1));
        ring(segments.min(on_rings - row * segments), r, z)
    });
    let points = [[0.0, 0.0, 1.0]].into_iter().chain(rows).chain([[0.0, 0.0, -1.0]]);
    distinct_from(n, points)
}

/// Random points inside the unit ball, uniform by volume; few extreme (about √n of them).
pub fn ball(n: usize, seed: u64) -> Vec<[f32; 3]> {
    let mut rng = SplitMix64::new(seed);
    distinct(n, || vector::scale(rng.direction(), libm::cbrt(rng.unit())))
}

/// The first `n` points of a cubic grid, x fastest; a handful extreme, the rest on faces, on edges
/// or inside.
///
/// The grid is the smallest that has `n` points. Its step is a power of two, so all coordinates are
/// exact and every coplanar or collinear set is exactly so. Unless `n` is a cube, the topmost
/// layers are incomplete. The seed is not used. Panics if `n` is below [`MIN_POINTS`].
pub fn cube_grid(n: usize, _seed: u64) -> Vec<[f32; 3]> {
    let side = (1..=n).find(|side| side.pow(3) >= n).unwrap_or(1);
    let step = 2.0 / side.next_power_of_two() as f64;
    let coordinate = move |index: usize| (index as f64 - (side - 1) as f64 / 2.0) * step;
    let points = (0..n).map(|i| [i % side, i / side % side, i / (side * side)].map(coordinate));
    distinct_from(n, points)
}

/// Random points in a square of the plane z = [`FLAT_SHEET_Z`]: affine rank 2, exactly.
pub fn flat_sheet(n: usize, seed: u64) -> Vec<[f32; 3]> {
    let mut rng = SplitMix64::new(seed);
    distinct(n, || [rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), f64::from(FLAT_SHEET_Z)])
}

/// Random points on an ellipsoid a thousand times as long (in x) as it is wide; all extreme. The
/// half-length is 1, the radius across is [`NEEDLE_RADIUS`].
pub fn needle(n: usize, seed: u64) -> Vec<[f32; 3]> {
    let mut rng = SplitMix64::new(seed);
    distinct(n, || stretched(rng.direction(), [1.0, NEEDLE_RADIUS, NEEDLE_RADIUS]))
}

/// A smooth, strictly convex boulder, given by its support function h.
///
/// With random knobs v and the positive part x₊, h(d) = r |d| + (Σ (d·v)₊⁸)^⅛. Both terms are
/// convex and scale with d, so h is the support function of a convex body: a ball of radius r,
/// swept over a softened hull of the knobs and the origin. The ball makes it strictly convex: each
/// outward normal touches it in one point, the gradient of h.
#[derive(Clone, Debug)]
pub struct Boulder {
    knobs: [Vec3; Boulder::KNOB_COUNT],
}

impl Boulder {
    /// Knobs on a boulder.
    pub const KNOB_COUNT: usize = 24;
    /// Radius r of the ball in the sweep.
    pub const BALL_RADIUS: f64 = 0.25;
    /// Nearest and farthest that a knob lies from the origin.
    pub const KNOB_DISTANCE: [f64; 2] = [0.4, 0.6];

    /// A boulder with random knobs.
    pub fn new(seed: u64) -> Self {
        let mut rng = SplitMix64::new(seed);
        let [near, far] = Self::KNOB_DISTANCE;
        let knobs = core::array::from_fn(|_| {
            let direction = rng.direction();
            vector::scale(direction, rng.between(near, far))
        });
        Self { knobs }
    }

    /// The point whose outward normal is `normal`, a unit vector.
    pub fn support_point(&self, normal: [f64; 3]) -> [f64; 3] {
        let mut sum_of_eighths = 0.0;
        let mut sum_of_sevenths = [0.0; 3];
        for &knob in &self.knobs {
            let x = vector::dot(normal, knob).max(0.0);
            let x2 = x * x;
            let x4 = x2 * x2;
            sum_of_eighths += x4 * x4;
            sum_of_sevenths = vector::add(sum_of_sevenths, vector::scale(knob, x4 * x2 * x));
        }
        let on_ball = vector::scale(normal, Self::BALL_RADIUS);
        if sum_of_eighths == 0.0 {
            // All knobs are behind: the softened hull's support point is the origin.
            return on_ball;
        }
        let root = libm::sqrt(libm::sqrt(libm::sqrt(sum_of_eighths)));
        // The gradient of (Σ x⁸)^⅛ is Σ x⁷ v / (Σ x⁸)^⅞.
        let soft = vector::scale(sum_of_sevenths, root / sum_of_eighths);
        vector::add(on_ball, soft)
    }
}

/// Radius of the spheres that the two caps of a lens with rim radius 1 are cut from.
pub(crate) fn lens_sphere_radius() -> f64 {
    (1.0 + LENS_HALF_THICKNESS * LENS_HALF_THICKNESS) / (2.0 * LENS_HALF_THICKNESS)
}

/// A regular polygon about the z axis, from the x axis on.
fn ring(corners: usize, radius: f64, z: f64) -> impl Iterator<Item = Vec3> {
    (0..corners).map(move |i| {
        let (c, s) = cos_sin(i, corners);
        [radius * c, radius * s, z]
    })
}

fn prism_corners(n: usize) -> impl Iterator<Item = Vec3> {
    let top = n / 2;
    ring(n - top, 1.0, -1.0).chain(ring(top, 1.0, 1.0))
}

fn stretched(p: Vec3, semi_axes: Vec3) -> Vec3 {
    [p[0] * semi_axes[0], p[1] * semi_axes[1], p[2] * semi_axes[2]]
}

/// `p` rotated by one radian about (3, 1, 2), by Rodrigues' formula.
fn rotated_generic(p: Vec3) -> Vec3 {
    let axis = vector::normalized([3.0, 1.0, 2.0]);
    let (c, s) = (libm::cos(1.0), libm::sin(1.0));
    let along = vector::scale(axis, vector::dot(axis, p) * (1.0 - c));
    let across = vector::scale(vector::cross(axis, p), s);
    vector::add(vector::scale(p, c), vector::add(across, along))
}

/// `n` points drawn from `candidate`, rounded to `f32`; one that was drawn before is dropped.
fn distinct(n: usize, candidate: impl FnMut() -> Vec3) -> Vec<[f32; 3]> {
    let limit = n.saturating_mul(MAX_TRIES_PER_POINT);
    distinct_from(n, core::iter::repeat_with(candidate).take(limit))
}

/// The first `n` distinct points of `candidates`, rounded to `f32`.
fn distinct_from(n: usize, candidates: impl Iterator<Item = Vec3>) -> Vec<[f32; 3]> {
    assert!(n >= MIN_POINTS, "a family has at least {MIN_POINTS} points, but {n} were requested");
    // Used only for membership, so its order has no effect.
    let mut seen = HashSet::with_capacity(n);
    let mut points = Vec::with_capacity(n);
    for candidate in candidates {
        let point = to_f32(candidate);
        if seen.insert(point.map(f32::to_bits)) {
            points.push(point);
            if points.len() == n {
                return points;
            }
        }
    }
    panic!("the family has only {} distinct points in f32, but {n} were requested", points.len());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::{dot, length, to_f64};

    const SEEDS: [u64; 3] = [0, 1, 0xdead_beef];

    fn extent(points: &[[f32; 3]], axis: usize) -> (f32, f32) {
        points.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), p| (low.min(p[axis]), high.max(p[axis])))
    }

    #[test]
    fn names_find_their_family() {
        for family in Family::ALL {
            assert_eq!(Family::from_name(family.name()), Some(family));
        }
        assert_eq!(Family::from_name("Sphere"), None);
    }

    #[test]
    fn families_give_exactly_n_finite_distinct_points_in_the_unit_cube() {
        for family in Family::ALL {
            for n in [MIN_POINTS, 9, 10, 11, 27, 64, 101, 1_000, 4_099, 100_000] {
                for seed in if n == 100_000 { &SEEDS[..1] } else { &SEEDS } {
                    let points = family.points(n, *seed);
                    let at = format!("{} n={n} seed={seed}", family.name());
                    assert_eq!(points.len(), n, "{at}");
                    let bits: HashSet<_> = points.iter().map(|p| p.map(f32::to_bits)).collect();
                    assert_eq!(bits.len(), n, "{at}: repeated points");
                    for x in points.iter().flatten() {
                        // NaN fails the comparison.
                        assert!(x.abs() <= 1.0, "{at}: {x}");
                        assert_ne!(x.to_bits(), (-0.0_f32).to_bits(), "{at}: negative zero");
                    }
                }
            }
        }
    }

    #[test]
    fn seeds_decide_and_nothing_else_does() {
        for family in Family::ALL {
            let name = family.name();
            assert_eq!(family.points(300, 3), family.points(300, 3), "{name}");
            let changed = family.points(300, 3) != family.points(300, 4);
            assert_eq!(changed, family.is_random(), "{name}");
        }
    }

    #[test]
    #[should_panic(expected = "at least 8 points")]
    fn too_few_points_are_rejected() {
        cone(0, 0);
    }

    /// How far a point lies off the surface that the family's points lie on, in `f32` steps.
    fn error(family: Family, point: [f32; 3]) -> f64 {
        let p @ [x, y, z] = to_f64(point);
        let off_cap = (z.abs() - 1.0).abs();
        match family {
            Family::Sphere | Family::UvSphere => length(p) - 1.0,
            Family::ClusteredEllipsoid => length(stretched(p, ELLIPSOID_SEMI_AXES.map(f64::recip))) - 1.0,
            Family::Needle => length(stretched(p, [1.0, NEEDLE_RADIUS, NEEDLE_RADIUS].map(f64::recip))) - 1.0,
            Family::Lens => {
                let radius = lens_sphere_radius();
                length([x, y, z.abs() + radius - LENS_HALF_THICKNESS]) - radius
            }
            Family::Prism => off_cap.max((x.hypot(y) - 1.0).abs()),
            Family::Cone if z > 0.0 => length([x, y, z - 1.0]),
            Family::Cone => off_cap.max((x.hypot(y) - 1.0).abs()),
            Family::RotatedPrism => dot(p, rotated_generic([0.0, 0.0, 1.0])).abs() - 0.7,
            Family::Ball => (length(p) - 1.0).max(0.0),
            // The step is 1/8 and the grid is centred, so sixteenths are whole numbers.
            Family::CubeGrid => p.map(|x| (x * 16.0).fract().abs()).into_iter().sum(),
            Family::FlatSheet => z - f64::from(FLAT_SHEET_Z),
            // `rock_points_are_extreme_along_their_normals`
            Family::Rock => 0.0,
        }
    }

    #[test]
    fn points_lie_where_their_family_says() {
        for family in Family::ALL {
            for point in family.points(1_000, 2) {
                assert!(error(family, point).abs() < 2e-7, "{}: {point:?}", family.name());
            }
        }
        let tilts = rotated_generic([0.0, 0.0, 1.0]);
        assert!(tilts.iter().all(|x| x.abs() > 0.1), "no cap is planar in f32: {tilts:?}");
        let needle = extent(&needle(1_000, 2), 0);
        assert!(needle.1 - needle.0 > 1.99, "{needle:?}");
        // Half the radius holds an eighth of the volume.
        let inner = ball(2_000, 8).into_iter().filter(|p| length(to_f64(*p)) < 0.5).count();
        assert!((200..300).contains(&inner), "{inner}");
    }

    #[test]
    fn points_of_a_sphere_are_extreme() {
        for points in [sphere(500, 1), uv_sphere(500, 1)] {
            for (i, &p) in points.iter().enumerate() {
                // On a sphere, each point is the support point in its own direction.
                let own = dot(to_f64(p), to_f64(p));
                assert!(points.iter().enumerate().all(|(j, &q)| i == j || dot(to_f64(p), to_f64(q)) < own), "{i}");
            }
        }
    }

    #[test]
    fn rock_points_are_extreme_along_their_normals() {
        let boulder = Boulder::new(9);
        let mut rng = SplitMix64::new(4);
        let touching: Vec<_> =
            (0..800).map(|_| rng.direction()).map(|normal| (normal, boulder.support_point(normal))).collect();
        for (i, &(normal, own)) in touching.iter().enumerate() {
            for (j, &(_, other)) in touching.iter().enumerate() {
                assert!(i == j || dot(normal, other) < dot(normal, own), "{i} {j}");
            }
        }
    }
}
