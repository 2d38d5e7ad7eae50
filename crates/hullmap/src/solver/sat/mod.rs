//! SAT, the separating axis test, for two small polytopes whose faces are known: penetration depth
//! from face normals and arcs of the Gauss map.
//!
//! # Reference
//! D. Gregorius, "The Separating Axis Test between Convex Polyhedra", GDC 2013, for the Gauss map.
//! The minimum over an arc from the other shape's support points alone, without its edges, is our
//! own. docs/contributors/intervals.md, section 12, proves the bounds.
//!
//! # Steps
//! 1. The line of centres, if the balls inside the shapes do not overlap and the cache had no axis
//!    to test. It may separate the shapes.
//! 2. In f32, the support values at the face normals of both shapes ([`first_pass`]). One of them
//!    may separate the shapes.
//! 3. In f64, by support queries, the faces that may have the minimum.
//! 4. In f32, rule out the arcs of A whose values cannot be the minimum. In f64, bisect the others
//!    at the direction in which two support points are equally far.
//! 5. The bounds of the depth.
//! 6. Witness points from all vertices in the support plane ([`witness`]); or, if those in
//!    neighbouring planes are needed as well, by GJK ([`Bound::search`]).
//!
//! # Deviations
//! - Nothing loops over pairs of edges: an arc of A whose two ends share the support point of B
//!   crosses no arc of B.
//! - What is not decided for certain, or has too many candidates, is `None`. Then the general path
//!   answers, from portal refinement (MPR) and EPA.

mod first_pass;
mod witness;

use glam::DVec3;

use self::first_pass::{Arc, FacetPair, FirstPass, threshold};
use super::answer::Contact;
use super::bound::{Bound, FOOT_ROUNDINGS, SAME_NORMAL};
use super::cache::Cache;
use super::kept_face::keep_face;
use super::minkowski::{Minkowski, Point};
use super::status::Status;
use crate::facets::table::{NORMAL_BLOCKS, POINT_BLOCKS};
use crate::facets::view::{Buffer, Facets};
use crate::support::SupportMap;
use crate::support::simd::Dispatch;
use crate::vector::unit;

/// Maximum number of vertices of a small pair, whose points fit one block of eight.
const SMALL: usize = 8;

/// Maximum number of vertices of a medium pair, whose points fit two blocks.
const MEDIUM: usize = 16;

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
/// docs/contributors/intervals.md, section 12.
const DIRECTION_UNITS: f64 = 24.0;

/// Depths up to this many rounding errors are left to the general path, which distinguishes
/// touching from penetrating.
const TINY_ROUNDINGS: f64 = 32.0;

/// Whether the test is likely to be faster than the general path. The fewer vertices, the more it
/// gains: not for a pair that barely overlaps, nor for one whose last polytope EPA can start from,
/// and above 16 vertices for neither. docs/contributors/decisions/0012-separating-axes.md has the
/// measurements.
pub(super) fn pays<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    [a, b]: &[Facets<'_>; 2],
    cache: &Cache,
) -> bool {
    match a.vertex_count().max(b.vertex_count()) {
        count if count <= SMALL => true,
        count if count <= MEDIUM => cache.is_new() || m.inner_balls_overlap(),
        _ => cache.is_new() && m.inner_balls_overlap(),
    }
}

/// Contact of two shapes with facets; `None` if the general path has to decide.
///
/// The pair has passed the tests by balls and by the last axis.
pub(super) fn contact<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    facets: [Facets<'_>; 2],
    tolerance: f64,
    cache: &mut Cache,
) -> Option<Contact> {
    let [a, b] = &facets;
    match a.vertex_count().max(b.vertex_count()) {
        count if count <= SMALL => search::<A, B, 1, 2>(m, &facets, tolerance, cache),
        count if count <= MEDIUM => search::<A, B, 2, 4>(m, &facets, tolerance, cache),
        _ => search::<A, B, POINT_BLOCKS, NORMAL_BLOCKS>(m, &facets, tolerance, cache),
    }
}

/// [`contact`] with arrays of `P` blocks of points and `N` blocks of faces.
///
/// Not inlined, so that the arrays are on the stack only here, and only the arrays of one size.
#[inline(never)]
fn search<A: SupportMap + ?Sized, B: SupportMap + ?Sized, const P: usize, const N: usize>(
    m: &mut Minkowski<'_, A, B>,
    facets: &[Facets<'_>; 2],
    tolerance: f64,
    cache: &mut Cache,
) -> Option<Contact> {
    let reach = m.outer_radius() + m.center_point().w.abs().element_sum();
    if !RANGE.contains(&reach) {
        return None;
    }
    // 1.
    if cache.axis().is_none()
        && !m.inner_balls_overlap()
        && let Some(axis) = unit(-m.center_point().w)
    {
        let point = m.point(axis);
        if m.separates(axis, &point) {
            cache.set_separation(axis, &[point; 3]);
            return Some(m.separated_contact(cache, axis, 1));
        }
    }
    // 2.
    let [a, b] = facets;
    let mut buffers = [Buffer::default(), Buffer::default()];
    let pair = FacetPair::new(m, facets, &mut buffers, reach);
    let dispatch = a.dispatch().or(b.dispatch()).unwrap_or_else(Dispatch::best);
    let mut first = FirstPass::<P, N>::new(&pair);
    first.find_faces(&pair, dispatch);
    // NaN takes the branch.
    if !(first.low >= -first.error) {
        return separated_by_face(m, facets, &first, cache);
    }
    // 3.
    let mut search = AxisSearch::new(m, facets);
    search.evaluate_faces(&mut first)?;
    // 4.
    first.find_arcs(&pair, dispatch, search.best.upper as f32)?;
    search.evaluate_arcs(&first)?;
    if search.is_separated() {
        cache.set_simplex([search.features]);
        return Some(search.m.separated_contact(cache, search.best.normal, search.m.support_calls()));
    }
    // 5.
    let (status, lower) = search.interval(reach, tolerance)?;
    // Axes that the first pass ruled out are at least two of its errors above the depth.
    let others = search.others.min(search.best.upper + 2.0 * f64::from(first.error)) - (search.best.upper - lower);
    // 6.
    let AxisSearch { m, mut best, mut features, lowest_of_a, .. } = search;
    // B is at a vertex, and A at a face.
    features[0] = if best.normal == lowest_of_a { Point::CENTER[0] } else { features[0] };
    let enough = best.upper - lower + FOOT_ROUNDINGS * m.noise();
    cache.set_axis(best.normal);
    match witness::points(m, facets, &first.points, pair.error(), dispatch, &best, enough) {
        Some((points, corners)) => {
            [best.point_a, best.point_b] = points;
            keep_face(m, (best.upper, corners), cache);
        }
        // The facets beside the facet of the foot have to be considered, too.
        None => _ = best.search(m, &[], enough),
    }
    // NaN takes the failing branch.
    if !(best.off() <= enough + FOOT_ROUNDINGS * m.rounding_error()) {
        return None;
    }
    let found = Contact {
        hit: true,
        status,
        depth: best.upper,
        depth_lower: lower - m.noise(),
        depth_upper: best.upper + m.rounding_error(),
        normal: best.normal,
        point_a: best.point_a,
        point_b: best.point_b,
        iterations: m.support_calls(),
        features,
        ..Contact::default()
    };
    Some(found.with_others(others, m.outer_radius()))
}

/// The answer if the lowest face separates the shapes in f64, too.
fn separated_by_face<A: SupportMap + ?Sized, B: SupportMap + ?Sized, const P: usize, const N: usize>(
    m: &mut Minkowski<'_, A, B>,
    facets: &[Facets<'_>; 2],
    first: &FirstPass<P, N>,
    cache: &mut Cache,
) -> Option<Contact> {
    let [of_a, of_b] = first.faces_at_most(first.low).map(|faces| faces.iter().next());
    let axis = match of_a {
        Some(face) => facets[0].normal(face)?,
        None => reversed_normal(m, facets, of_b?)?,
    };
    let point = m.point(axis);
    // NaN takes the failing branch.
    (point.w.dot(axis) < -m.rounding_error()).then(|| {
        cache.set_separation(axis, &[point; 3]);
        m.separated_contact(cache, axis, 2)
    })
}

fn reversed_normal<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    [_, b]: &[Facets<'_>; 2],
    face: usize,
) -> Option<DVec3> {
    unit(m.rotation() * -b.normal(face)?)
}

struct AxisSearch<'m, 's, 'f, A: SupportMap + ?Sized, B: SupportMap + ?Sized> {
    m: &'m mut Minkowski<'s, A, B>,
    facets: &'f [Facets<'f>; 2],
    best: Bound,
    features: [u32; 2],
    /// Lower bound over everything that was evaluated.
    lower: f64,
    /// Lower bound over the directions of local minima that were evaluated, apart from the one of
    /// the bound.
    others: f64,
    /// The normal of A's lowest face; zero if there is none.
    lowest_of_a: DVec3,
}

impl<'m, 's, 'f, A: SupportMap + ?Sized, B: SupportMap + ?Sized> AxisSearch<'m, 's, 'f, A, B> {
    fn new(m: &'m mut Minkowski<'s, A, B>, facets: &'f [Facets<'f>; 2]) -> Self {
        let nothing = f64::INFINITY;
        let lowest_of_a = DVec3::ZERO;
        Self { m, facets, best: Bound::none(), features: [0; 2], lower: nothing, others: nothing, lowest_of_a }
    }

    /// Step 3. `None` after too many queries.
    #[inline(always)]
    fn evaluate_faces<const P: usize, const N: usize>(&mut self, first: &mut FirstPass<P, N>) -> Option<()> {
        let [a, b] = self.facets;
        // The lowest face is at most one error above its value.
        let [of_a, of_b] = first.faces(first.low + first.error);
        for face in of_a.iter() {
            let (dir, on_a) = (a.normal(face)?, a.support(face)?);
            let point = self.m.point_with_a(a.vertex(on_a)?, on_a as u32, dir);
            self.lower = self.lower.min(self.take(&point, dir)?);
            first.set_vertex(face, point.features[1]);
        }
        self.lowest_of_a = self.best.normal;
        for face in of_b.iter() {
            let (dir, on_b) = (reversed_normal(self.m, self.facets, face)?, b.support(face)?);
            let point = self.m.point_with_b(b.vertex(on_b)?, on_b as u32, dir);
            self.lower = self.lower.min(self.take(&point, dir)?);
        }
        Some(())
    }

    /// Step 4, until a direction separates the shapes. `None` after too many queries.
    #[inline(always)]
    fn evaluate_arcs<const P: usize, const N: usize>(&mut self, first: &FirstPass<P, N>) -> Option<()> {
        let [a, b] = self.facets;
        for Arc { faces, vertex, bound } in first.arcs() {
            if self.is_separated() {
                break;
            }
            // The value of the first arc, the lowest, rules out most of the others. NaN does not.
            if *bound >= threshold(self.best.upper as f32, first.error) {
                continue;
            }
            let on_a = a.vertex((*vertex).into())?;
            let [from, to] = faces.map(usize::from);
            let (p, q) = (b.vertex(first.vertex(from))?, b.vertex(first.vertex(to))?);
            let points = [self.m.point_of(on_a, p, [0; 2]).w, self.m.point_of(on_a, q, [0; 2]).w];
            self.along([a.normal(from)?, a.normal(to)?], points, 0)?;
        }
        Some(())
    }

    /// Step 5: the status and the lower bound of the depth. `None` if the interval is too wide, or
    /// the pair may only touch.
    #[inline(always)]
    fn interval(&self, reach: f64, tolerance: f64) -> Option<(Status, f64)> {
        let [a, b] = self.facets;
        let (upper, rounding) = (self.best.upper, self.m.rounding_error());
        let slack = 2.0 * (a.slack() + b.slack()) + DIRECTION_UNITS * f64::EPSILON * reach;
        let lower = self.lower.min(upper) - slack;
        // NaN takes the failing branch, here and below.
        if !(upper > TINY_ROUNDINGS * rounding && lower > self.m.noise()) {
            return None;
        }
        if upper - lower <= rounding {
            Some((Status::Exact, lower))
        } else {
            (upper - lower <= tolerance * upper + 2.0 * rounding).then_some((Status::Within, lower))
        }
    }

    fn take(&mut self, point: &Point, dir: DVec3) -> Option<f64> {
        if self.m.support_calls() > MAX_QUERIES {
            return None;
        }
        let value = point.w.dot(dir);
        self.compare(dir, value.max(self.best.upper));
        if value < self.best.upper {
            self.best = Bound { upper: value, normal: dir, ..self.best };
            self.features = point.features;
        }
        Some(value)
    }

    fn compare(&mut self, dir: DVec3, value: f64) {
        // NaN counts as a low value.
        if !(value >= self.others) && !(dir.distance(self.best.normal) <= SAME_NORMAL) {
            self.others = value;
        }
    }

    /// Whether the direction of the smallest value separates the shapes.
    fn is_separated(&self) -> bool {
        self.best.upper < -self.m.rounding_error()
    }

    /// Bounds the support values along a piece of an arc from below, and finds its minimum if that
    /// may be the depth. `p` and `q` are the support points at its ends, or nearly so. `None` after
    /// too many steps.
    fn along(&mut self, [from, to]: [DVec3; 2], [p, q]: [DVec3; 2], bisections: u32) -> Option<()> {
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
            let point = self.m.point(dir);
            let value = self.take(&point, dir)?;
            if self.is_separated() {
                return Some(());
            }
            if value - middle > equal {
                if bisections == MAX_BISECTIONS {
                    return None;
                }
                self.along([from, dir], [p, point.w], bisections + 1)?;
                if self.is_separated() {
                    return Some(());
                }
                return self.along([dir, to], [point.w, q], bisections + 1);
            }
        }
        self.compare(dir, middle);
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

    fn pose(x: f64) -> Pose {
        Pose::from_translation(DVec3::new(x, 0.3, 0.2)).unwrap()
    }

    fn pays_at<S: SupportMap>(shape: &S, x: f64, cache: &Cache) -> bool {
        pays(&Minkowski::new(shape, shape, pose(x)), &[shape.facets().unwrap(), shape.facets().unwrap()], cache)
    }

    /// Whether the test pays for two of these shapes before the first contact, and before the next
    /// ones.
    fn pays_for<S: crate::Shape>(shape: &S, distances: [f64; 3]) -> ([bool; 2], Cache) {
        let mut cache = Cache::new();
        let found = distances.map(|x| {
            let pays = pays_at(shape, x, &cache);
            assert!(contact(shape, shape, pose(x), &Settings::default(), &mut cache).hit);
            pays
        });
        assert_eq!(found[1], found[2]);
        ([found[0], found[1]], cache)
    }

    #[test]
    fn it_pays_for_few_vertices_and_for_the_first_contact_of_more() {
        let cube = Cuboid::new(DVec3::ONE).unwrap();
        assert!(pays_at(&cube, 1.5, &Cache::new()) && pays_at(&cube, 7.0, &Cache::new()));
        assert!(pays_at(&cube, 1.5, &Cache::from_axis(DVec3::X)));
        let (pays, cache) = pays_for(&cube, [1.5, 1.49, 1.48]);
        assert!(pays == [true, true] && cache.polytope().is_none());
        // The test leaves its normal, then the general path its polytope.
        let pack = Pack::from_bytes(&packs::tree_bytes(&families::sphere(24, 1))).unwrap();
        let (pays, cache) = pays_for(&pack.hull(0).unwrap(), [0.8, 0.79, 0.78]);
        assert!(pays == [true, false] && cache.polytope().is_some());
    }
}
