//! SAT, the separating axis test, for two small polytopes whose faces are known: penetration depth
//! from face normals and arcs of the Gauss map.
//!
//! # Reference
//! D. Gregorius, "The Separating Axis Test between Convex Polyhedra", GDC 2013, for the Gauss map.
//! The minimum over an arc from the other shape's support points alone, without its edges, is our
//! own. docs/intervals.md, section 12, proves the bounds.
//!
//! # Steps
//! 1. The last axis, or the line of centres: it may separate. If not, its support value bounds the
//!    depth.
//! 2. In f32, lower bounds at all face normals of both shapes, raised until the lowest is a support
//!    value ([`scan`]). For few vertices, all support values instead ([`flat`]).
//! 3. In f32, rule out the faces and the arcs of A whose values cannot be the minimum.
//! 4. In f64, evaluate the rest: faces by a support query, arcs by bisection at the direction in
//!    which two support points are equally far.
//! 5. Witness points from all vertices in the support plane ([`witness`]); or, if those in
//!    neighbouring planes are needed as well, by GJK ([`Bound::search`]).
//!
//! # Deviations
//! - Nothing loops over pairs of edges: an arc of A whose two ends share the support point of B
//!   crosses no arc of B.
//! - What is not decided for certain, or has too many candidates, is `None`. Then the general path
//!   answers, from portal refinement (MPR) and EPA.

mod first_pass;
mod flat;
mod scan;
mod witness;

use glam::DVec3;

use self::first_pass::FirstPass;
use self::flat::Flat;
use self::scan::{Arc, Pair, Scan, threshold};
use super::answer::{Contact, separated_contact};
use super::bound::{Bound, FOOT_ROUNDINGS};
use super::cache::Cache;
use super::intersection::store_separation;
use super::minkowski::{Minkowski, Point};
use super::status::Status;
use crate::support::SupportMap;
use crate::support::facet_table::{NORMAL_BLOCKS, POINT_BLOCKS};
use crate::support::facets::{Buffer, Facets};
use crate::support::simd::Dispatch;
use crate::vector::unit;

/// Reach of a pair that f32 can represent with room for squares and for small coordinates.
const RANGE: std::ops::RangeInclusive<f64> = 1e-12..=1e12;

/// Maximum number of support queries. Most pairs need 3 to 6.
const MAX_QUERIES: u32 = 96;

/// Maximum depth of the bisection of an arc.
const MAX_BISECTIONS: u32 = 16;

/// Two values along an arc are equal within this fraction of the noise, which allows for several
/// times their rounding error.
const EQUAL: f64 = 0.125;

/// Rounding error of a direction, and of its length, in units of `f64::EPSILON` times the reach:
/// docs/intervals.md, section 12.
const DIRECTION_UNITS: f64 = 24.0;

/// Depths up to this many rounding errors are left to the general path, which distinguishes
/// touching from penetrating.
const TINY_ROUNDINGS: f64 = 32.0;

/// Where the test is faster than the general path. Each row holds the maximum number of products of
/// faces and vertices of a pair, and the maximum distance of the interior points over the sum of
/// the inner radii.
///
/// Measured by `small-table` and `peer-table`: hulls of 8 vertices, up to 64, and up to 128. Beyond
/// the distance most pairs are separated, and the general path proves that with fewer operations.
const PAYS: [(usize, f64); 3] = [(300, 3.0), (16_000, 2.0), (66_000, 1.2)];

/// Minimum distance of the interior points over the sum of the inner radii at which the line of
/// centres is tested, if its value is not needed as an upper bound.
const LINE_OF_CENTERS: f64 = 2.0;

/// Maximum number of products up to which the test is faster for a cache that knows the pair, too:
/// hulls of 16 vertices. Measured by `contact-table` along paths.
const PAYS_AGAIN: usize = 1_000;

/// Whether the test is likely to be faster than the general path.
///
/// Above [`PAYS_AGAIN`] it is not for a cache that knows the pair: the general path then starts
/// from the last polytope, or leaves one for the next query.
pub(super) fn pays<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    [a, b]: &[Facets<'_>; 2],
    cache: &Cache,
) -> bool {
    let products = a.face_count() * b.vertex_count() + b.face_count() * a.vertex_count();
    (cache.is_new() || products <= PAYS_AGAIN)
        && PAYS.iter().find(|(most, _)| products <= *most).is_some_and(|(_, distance)| {
            let near = m.inner_radius() * distance;
            m.center_point().w.length_squared() < near * near
        })
}

/// The search in f64.
struct Search<'m, 's, A: SupportMap + ?Sized, B: SupportMap + ?Sized> {
    m: &'m mut Minkowski<'s, A, B>,
    /// The smallest support value, and the direction that has it.
    best: Bound,
    /// The features of its support point.
    features: [u32; 2],
    /// Lower bound over everything that was evaluated.
    lower: f64,
}

/// A part of an arc: two directions, and a point of the difference that is the support point in
/// each, or nearly so.
#[derive(Clone, Copy)]
struct Piece {
    dirs: [DVec3; 2],
    points: [DVec3; 2],
}

/// Contact of two shapes with facets; `None` if the general path has to decide.
///
/// The pair has passed the tests by balls and by the last axis. `last` is that axis with its
/// support point.
///
/// # Complexity
/// O(faces) in f32, 8 lanes at a time, or O(faces × vertices) up to 16 vertices; O(vertices) for
/// each face near the depth, of which there are about ten; and a few support queries. No
/// allocation.
pub(super) fn contact<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    facets: [Facets<'_>; 2],
    tolerance: f64,
    last: Option<&(DVec3, Point)>,
    cache: &mut Cache,
) -> Option<Contact> {
    let [a, b] = &facets;
    match a.vertex_count().max(b.vertex_count()) {
        0..=8 => search::<A, B, Flat<1, 2>, 1, 2>(m, &facets, tolerance, last, cache),
        9..=16 if m.inner_balls_overlap() => search::<A, B, Flat<2, 4>, 2, 4>(m, &facets, tolerance, last, cache),
        9..=16 => search::<A, B, Scan<2, 4>, 2, 4>(m, &facets, tolerance, last, cache),
        17..=32 => search::<A, B, Scan<4, 8>, 4, 8>(m, &facets, tolerance, last, cache),
        33..=64 => search::<A, B, Scan<8, 16>, 8, 16>(m, &facets, tolerance, last, cache),
        _ => {
            type Largest = Scan<POINT_BLOCKS, NORMAL_BLOCKS>;
            search::<A, B, Largest, POINT_BLOCKS, NORMAL_BLOCKS>(m, &facets, tolerance, last, cache)
        }
    }
}

/// [`contact`] with the first pass `F`, and arrays of `P` blocks of points and `N` blocks of faces.
///
/// Not inlined, so that the arrays are on the stack only here, and only those of one size.
#[inline(never)]
fn search<A: SupportMap + ?Sized, B: SupportMap + ?Sized, F: FirstPass<P, N>, const P: usize, const N: usize>(
    m: &mut Minkowski<'_, A, B>,
    facets: &[Facets<'_>; 2],
    tolerance: f64,
    last: Option<&(DVec3, Point)>,
    cache: &mut Cache,
) -> Option<Contact> {
    // 1.
    let center = m.center_point().w;
    let rounding = m.rounding_error();
    let reach = m.outer_radius() + center.abs().element_sum();
    if !RANGE.contains(&reach) {
        return None;
    }
    let mut best = Bound::none();
    let mut seen = None;
    let mut test = |axis: DVec3, point: &Point| {
        let upper = point.w.dot(axis);
        best = Bound { upper, normal: axis, ..best };
        let [on_a, on_b] = point.features;
        seen = Some([on_b as usize, on_a as usize]);
        upper < -rounding
    };
    let near = m.inner_radius() * if F::TAKES_UPPER { 1.0 } else { LINE_OF_CENTERS };
    if let Some((axis, point)) = last {
        // It does not separate.
        test(*axis, point);
    } else if center.length_squared() > near * near
        && let Some(axis) = unit(-center)
    {
        // If the pair is nearer, the line of centres rarely separates, and is a poor guess.
        let point = m.point(axis);
        if test(axis, &point) {
            store_separation(cache, axis, &[point; 3]);
            return Some(separated_contact(m, cache, axis, 1));
        }
    }
    // 2.
    let mut buffers = [Buffer::default(), Buffer::default()];
    let [a, b] = facets;
    let pair = Pair::new(m, facets, &mut buffers);
    let dispatch = a.dispatch().or(b.dispatch()).unwrap_or_else(Dispatch::best);
    let mut first = F::new(&pair);
    first.run(&pair, dispatch, best.upper as f32, seen)?;
    // 3.
    let (low, error) = (first.low(), first.error());
    if !(low >= -error) {
        let [of_a, of_b] = first.faces_at_most(low);
        let (face, of_b) =
            of_a.iter().next().map(|face| (face, false)).or_else(|| of_b.iter().next().map(|face| (face, true)))?;
        let axis = direction(m, facets, face, of_b)?;
        let point = m.point(axis);
        if point.w.dot(axis) < -rounding {
            store_separation(cache, axis, &[point; 3]);
            return Some(separated_contact(m, cache, axis, 2));
        }
        return None;
    }
    // The lowest face is at most one error above its value.
    let faces = first.faces((low + error).min(best.upper as f32));
    // 4.
    let mut search = Search { m, best, features: [0; 2], lower: f64::INFINITY };
    for face in faces[0].iter() {
        let dir = a.normal(face)?;
        let on_a = a.support(face)?;
        let point = search.m.point_with_a(a.vertex(on_a)?, on_a as u32, dir);
        let value = search.take(&point, dir)?;
        search.lower = search.lower.min(value);
        first.set_vertex(face, point.features[1]);
    }
    for face in faces[1].iter() {
        let dir = direction(search.m, facets, face, true)?;
        let on_b = b.support(face)?;
        let point = search.m.point_with_b(b.vertex(on_b)?, on_b as u32, dir);
        let value = search.take(&point, dir)?;
        search.lower = search.lower.min(value);
    }
    first.find_arcs(&pair, dispatch, search.best.upper as f32)?;
    for Arc { faces: [from, to], vertex, bound } in first.arcs() {
        if search.is_separated() {
            break;
        }
        // The value of the first arc, the lowest, rules out most of the others. NaN does not.
        if *bound >= threshold(search.best.upper as f32, error) {
            continue;
        }
        let on_a = a.vertex((*vertex).into())?;
        let (from, to) = (usize::from(*from), usize::from(*to));
        let (p, q) = (b.vertex(first.vertex(from))?, b.vertex(first.vertex(to))?);
        let points = [search.m.point_of(on_a, p, [0; 2]).w, search.m.point_of(on_a, q, [0; 2]).w];
        search.along(Piece { dirs: [a.normal(from)?, a.normal(to)?], points }, 0)?;
    }
    if search.is_separated() {
        let Search { m, best, features, .. } = search;
        cache.set_simplex([features]);
        return Some(separated_contact(m, cache, best.normal, m.support_calls()));
    }
    // The bounds.
    let Search { m, best, lower, .. } = search;
    let slack = 2.0 * (a.slack() + b.slack()) + DIRECTION_UNITS * f64::EPSILON * reach;
    let lower = lower.min(best.upper) - slack;
    // NaN takes the failing branch, here and below.
    if !(best.upper > TINY_ROUNDINGS * rounding && lower > m.noise()) {
        return None;
    }
    let status = if best.upper - lower <= rounding {
        Status::Exact
    } else if best.upper - lower <= tolerance * best.upper + 2.0 * rounding {
        Status::Within
    } else {
        return None;
    };
    // 5.
    let mut best = best;
    let enough = best.upper - lower + FOOT_ROUNDINGS * m.noise();
    match witness::points(m, facets, &pair, first.points(), dispatch, &best, enough) {
        Some(points) => [best.point_a, best.point_b] = points,
        // The facets beside that of the foot have to be considered, too.
        None => _ = best.search(m, &[], enough),
    }
    // NaN takes the failing branch.
    if !(best.off() <= enough + FOOT_ROUNDINGS * rounding) {
        return None;
    }
    cache.set_axis(best.normal);
    Some(Contact {
        hit: true,
        status,
        depth: best.upper,
        depth_lower: lower - m.noise(),
        depth_upper: best.upper + rounding,
        normal: best.normal,
        point_a: best.point_a,
        point_b: best.point_b,
        iterations: m.support_calls(),
        support_calls: 0,
    })
}

/// The direction of a face normal of A, or of one of B reversed, in A's frame.
fn direction<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    [a, b]: &[Facets<'_>; 2],
    face: usize,
    of_b: bool,
) -> Option<DVec3> {
    if of_b { unit(m.rotation() * -b.normal(face)?) } else { a.normal(face) }
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> Search<'_, '_, A, B> {
    /// The support point in a unit direction and its value. `None` after too many queries.
    fn at(&mut self, dir: DVec3) -> Option<(Point, f64)> {
        let point = self.m.point(dir);
        let value = self.take(&point, dir)?;
        Some((point, value))
    }

    /// The value of the support point in a unit direction. `None` after too many queries.
    fn take(&mut self, point: &Point, dir: DVec3) -> Option<f64> {
        if self.m.support_calls() > MAX_QUERIES {
            return None;
        }
        let value = point.w.dot(dir);
        if value < self.best.upper {
            self.best = Bound { upper: value, normal: dir, ..self.best };
            self.features = point.features;
        }
        Some(value)
    }

    /// Whether the direction of the smallest value separates the shapes.
    fn is_separated(&self) -> bool {
        self.best.upper < -self.m.rounding_error()
    }

    /// Bounds the support values along a piece of an arc from below, and finds its minimum if that
    /// may be the depth. `None` after too many steps.
    fn along(&mut self, Piece { dirs: [from, to], points: [p, q] }: Piece, bisections: u32) -> Option<()> {
        let equal = EQUAL * self.m.noise();
        let (p_from, p_to, q_from, q_to) = (p.dot(from), p.dot(to), q.dot(from), q.dot(to));
        let (drop_from, drop_to) = (p_from - q_from, q_to - p_to);
        if !(drop_from > 0.0 && drop_to > 0.0) {
            // One of the points serves the whole piece.
            self.lower = self.lower.min(p_from.min(p_to).max(q_from.min(q_to)));
            return Some(());
        }
        let t = drop_from / (drop_from + drop_to);
        let dir = unit(from * (1.0 - t) + to * t)?;
        let middle = p.dot(dir).min(q.dot(dir));
        let lowest = p_from.min(q_to).min(middle);
        if middle < self.best.upper - equal {
            let (point, value) = self.at(dir)?;
            if self.is_separated() {
                return Some(());
            }
            if value - middle > equal {
                if bisections == MAX_BISECTIONS {
                    return None;
                }
                self.along(Piece { dirs: [from, dir], points: [p, point.w] }, bisections + 1)?;
                if self.is_separated() {
                    return Some(());
                }
                return self.along(Piece { dirs: [dir, to], points: [point.w, q] }, bisections + 1);
            }
        }
        self.lower = self.lower.min(lowest);
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use hullmap_testkit::packs;
    use shapes::families;

    use super::*;
    use crate::{Pack, Pose, Settings, contact, shapes::Cuboid};

    /// Whether the test pays for two of these shapes before the first contact, and before the next
    /// ones.
    fn pays_for<S: SupportMap>(shape: &S, distances: [f64; 3]) -> ([bool; 2], Cache) {
        let facets = [shape.facets().unwrap(), shape.facets().unwrap()];
        let pose = |x: f64| Pose::from_translation(DVec3::new(x, 0.3, 0.2)).unwrap();
        let mut cache = Cache::new();
        let found = distances.map(|x| {
            let pays = pays(&Minkowski::new(shape, shape, pose(x)), &facets, &cache);
            let found = contact(shape, shape, pose(x), &Settings::default(), &mut cache);
            assert!(found.hit);
            pays
        });
        assert_eq!(found[1], found[2]);
        ([found[0], found[1]], cache)
    }

    #[test]
    fn it_pays_for_few_vertices_and_for_the_first_contact_of_more() {
        let cube = Cuboid::new(DVec3::ONE).unwrap();
        let pose = |x: f64| Pose::from_translation(DVec3::new(x, 0.3, 0.2)).unwrap();
        let pays_at = |x: f64, cache: &Cache| {
            let facets = [cube.facets().unwrap(), cube.facets().unwrap()];
            pays(&Minkowski::new(&cube, &cube, pose(x)), &facets, cache)
        };
        assert!(pays_at(1.5, &Cache::new()) && !pays_at(7.0, &Cache::new()));
        assert!(pays_at(1.5, &Cache::from_axis(DVec3::X)));
        let (pays, cache) = pays_for(&cube, [1.5, 1.49, 1.48]);
        assert!(pays == [true, true] && cache.polytope().is_none());
        // The test leaves its normal, then the general path its polytope.
        let pack = Pack::from_bytes(&packs::tree_bytes(&families::sphere(24, 1))).unwrap();
        let (pays, cache) = pays_for(&pack.hull(0).unwrap(), [0.8, 0.79, 0.78]);
        assert!(pays == [true, false] && cache.polytope().is_some());
    }
}
