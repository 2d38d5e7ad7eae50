//! Judges how parts fit their mesh: searches for a point that refutes a recorded bound.
//!
//! It shares no measurement with the baker: distances from parts come from the runtime solver,
//! distances from the solid from [`TriangleSoup`]. One point, which is reported, refutes the claim.
//!
//! # Steps
//! 1. The point that the pack records as the worst; for uncovered surface, the baker's, since gaps
//!    may be too small for samples. A point refutes a claim only by its distance.
//! 2. Vertices, and a seeded sample of the surface.
//! 3. Branch and bound over the surface, greatest bound first, without cells below the claim. A
//!    cell with the greatest value so far is halved towards greater values until it is a point.
//! 4. A sample of the inside of the part, for cavities: see [`Judge::protrusion`].
//!
//! The number of cells is limited. A claim that is not refuted by then passes.

use std::collections::BinaryHeap;

use glam::DVec3;
use hullmap::{Hull, SolidKind};
use hullmap_bake::fit::{Solid, uncovered};
use hullmap_geometry::PointSet;
use rayon::prelude::*;

use crate::geometry::{polygons, rebuilt};
use crate::outside::to_point;
use crate::random::SplitMix;
use crate::soup::TriangleSoup;
use hullmap_geometry::triangle::{Triangle, ball, farthest, halves};

const MAX_CELLS: usize = 40_000;

/// Number of cells halved at a time, on all threads.
const BATCH: usize = 64;

/// Number of halvings from a cell to a point.
const DESCENT: usize = 48;

/// Number of points in a sample of a surface or of the inside of a part.
const SAMPLE: usize = 4096;

/// Seed of the samples.
const SEED: u64 = 0x5eed;

/// Rounding error of a measured distance, relative to the greatest coordinate.
const ROUNDING: f64 = 4e-12;

/// Distance of the recorded point of greatest protrusion from the part, relative to the diagonal.
const ON_PART: f64 = 1e-6;

/// Depth of a cavity below which it is ignored, relative to the protrusion, and to the diagonal: as
/// in the file format, with an allowance for rounding.
const CAVITY: [f64; 2] = [0.1001, 1.001e-3];

/// A point that refutes a claim, and its distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Witness {
    /// Distance, rounded down by its error.
    pub distance: f64,
    /// The point, in the frame of the positions.
    pub at: DVec3,
}

/// A mesh, prepared for judgements.
pub struct Judge {
    triangles: Vec<Triangle>,
    soup: TriangleSoup,
    kind: SolidKind,
    diagonal: f64,
    rounding: f64,
}

/// Known bounds of a cell: an upper bound, and a value at a point of it.
#[derive(Clone, Copy)]
struct Measured {
    bound: f64,
    value: f64,
    at: DVec3,
}

struct Cell {
    bound: f64,
    corners: Triangle,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

impl Judge {
    /// Prepares the mesh of `points`, which must have triangles, and the solid from which
    /// protrusion counts.
    pub fn new(points: &PointSet, solid: &Solid) -> Self {
        let triangles: Vec<Triangle> = points.triangles.iter().map(|triangle| points.corners(triangle)).collect();
        let soup = TriangleSoup::new(solid, solid.mesh_count());
        let [low, high] = solid.bounds();
        let rounding = ROUNDING * low.abs().max(high.abs()).max_element() + solid.tolerance();
        Self { triangles, soup, kind: solid.kind(), diagonal: solid.diagonal(), rounding }
    }

    /// How the solid is known.
    pub fn kind(&self) -> SolidKind {
        self.kind
    }

    /// A point of the surface of `mesh`, for which this is the judge, that is farther than `claim`
    /// from all `hulls`.
    pub fn uncovered(&self, mesh: &PointSet, hulls: &[Hull], claim: f64) -> Option<Witness> {
        let boxes: Vec<[DVec3; 2]> = hulls.iter().map(|hull| hull.bounds().map(|corner| corner.as_dvec3())).collect();
        let to_box = |p: DVec3, [low, high]: [DVec3; 2]| (low - p).max(p - high).max(DVec3::ZERO).length();
        // Lower bound on the distance from the nearest part, and that part.
        let nearest = |p: DVec3| {
            let mut best = (f64::INFINITY, 0);
            for (index, (hull, bounds)) in hulls.iter().zip(&boxes).enumerate() {
                if to_box(p, *bounds) < best.0 {
                    let distance = to_point(hull, p).lower;
                    if distance < best.0 {
                        best = (distance, index);
                    }
                }
            }
            best
        };
        let measure = |corners: &Triangle| {
            let (centre, radius) = ball(corners);
            let (distance, part) = nearest(centre);
            let mut bound = distance + radius;
            // The distance from a convex part is greatest at a corner.
            if bound > claim
                && let Some(hull) = hulls.get(part)
            {
                let farthest = corners.iter().map(|p| to_point(hull, *p).upper).fold(0.0, f64::max);
                bound = bound.min(farthest);
            }
            Measured { bound, value: distance - self.rounding, at: centre }
        };
        let confirm = |_: DVec3| true;
        let mut points = sample(&self.triangles);
        points.extend(self.least_covered(mesh, hulls));
        let value = |p: DVec3| nearest(p).0 - self.rounding;
        sampled(&points, claim, value, confirm).or_else(|| search(&self.triangles, claim, measure, confirm))
    }

    /// The point of the surface that the baker finds farthest from all hulls, if it is on it.
    fn least_covered(&self, mesh: &PointSet, hulls: &[Hull]) -> Option<DVec3> {
        let parts = hulls.par_iter().map(rebuilt).collect::<Option<Vec<_>>>()?;
        let at = uncovered(mesh, &parts.iter().collect::<Vec<_>>()).at;
        self.soup.to_mesh(at).filter(|(distance, _)| *distance <= self.rounding).map(|_| at)
    }

    /// A point of `hull` that is farther than `claim` from the solid, starting from the recorded
    /// point `at`, which must be in the hull.
    ///
    /// By the rule of the file format, points inside the hull count only in a cavity: if they are
    /// farther by more than a tenth plus a thousandth of the diagonal.
    pub fn protrusion(&self, hull: &Hull, claim: f64, at: Option<DVec3>) -> Option<Witness> {
        let value = |p: DVec3| if self.soup.seems_inside(p) { 0.0 } else { self.soup.gap(p) - self.rounding };
        let confirm = |p: DVec3| self.soup.is_outside(p);
        let measure = |corners: &Triangle| {
            let (centre, radius) = ball(corners);
            let Some((distance, triangle)) = self.soup.to_mesh(centre) else {
                return Measured { bound: f64::INFINITY, value: 0.0, at: centre };
            };
            // The distance from a triangle is greatest at a corner.
            let bound = (distance + radius).min(farthest(corners, &triangle));
            if bound <= claim {
                return Measured { bound, value: 0.0, at: centre };
            }
            if self.soup.seems_inside(centre) {
                let bound = if self.soup.gap(centre) > radius { 0.0 } else { bound.min(radius) };
                return Measured { bound, value: 0.0, at: centre };
            }
            Measured { bound, value: self.soup.gap(centre) - self.rounding, at: centre }
        };
        let vertices: Vec<DVec3> = hull.vertices().map(|vertex| vertex.as_dvec3()).collect();
        let surface = surface(hull, &vertices);
        let mut points: Vec<DVec3> = at.into_iter().chain(vertices.iter().copied()).collect();
        points.extend(sample(&surface));
        let cavity = claim * (1.0 + CAVITY[0]) + CAVITY[1] * self.diagonal;
        sampled(&points, claim, value, confirm)
            .or_else(|| search(&surface, claim, measure, confirm))
            .or_else(|| sampled(&inside(&vertices), cavity, value, confirm))
    }

    /// A point of `points` of a primitive that is farther than `claim` from the solid.
    pub fn farther(&self, points: &[DVec3], claim: f64) -> Option<Witness> {
        let value = |p: DVec3| if self.soup.seems_inside(p) { 0.0 } else { self.soup.gap(p) - self.rounding };
        sampled(points, claim, value, |p| self.soup.is_outside(p))
    }

    /// Whether a point lies on or in the hull.
    pub fn is_in(&self, hull: &Hull, p: DVec3) -> bool {
        to_point(hull, p).lower <= ON_PART * self.diagonal
    }
}

/// The triangles of a hull's faces; for a segment and a point, a triangle without area.
fn surface(hull: &Hull, vertices: &[DVec3]) -> Vec<Triangle> {
    if hull.rank() < 2 {
        return vec![[vertices[0], vertices[vertices.len() - 1], vertices[0]]];
    }
    let mut triangles = Vec::new();
    for face in polygons(hull) {
        let corners: Vec<DVec3> = face.iter().filter_map(|v| vertices.get(*v as usize)).copied().collect();
        triangles.extend((2..corners.len()).map(|last| [corners[0], corners[last - 1], corners[last]]));
    }
    triangles
}

/// Random points of the triangles, in proportion to their areas.
fn sample(triangles: &[Triangle]) -> Vec<DVec3> {
    let mut sum = 0.0;
    let ends: Vec<f64> = triangles
        .iter()
        .map(|[a, b, c]| {
            sum += (*b - *a).cross(*c - *a).length();
            sum
        })
        .collect();
    let mut random = SplitMix::new(SEED);
    let mut unit = || 0.5 + 0.5 * random.signed();
    (0..SAMPLE)
        .filter_map(|_| {
            let at = unit() * sum;
            let [a, b, c] = *triangles.get(ends.partition_point(|end| *end <= at))?;
            let (mut u, mut v) = (unit(), unit());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            Some(a + (b - a) * u + (c - a) * v)
        })
        .collect()
}

/// Random points of the hull of the vertices: means of four of them.
fn inside(vertices: &[DVec3]) -> Vec<DVec3> {
    let mut random = SplitMix::new(SEED);
    (0..SAMPLE)
        .map(|_| {
            let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
            for _ in 0..4 {
                let weight = 1.0 + random.signed();
                sum += vertices[random.below(vertices.len())] * weight;
                weights += weight;
            }
            sum / weights
        })
        .collect()
}

/// The point of the greatest value, if that exceeds the claim and is confirmed.
fn sampled(
    points: &[DVec3],
    claim: f64,
    value: impl Fn(DVec3) -> f64 + Sync,
    confirm: impl Fn(DVec3) -> bool,
) -> Option<Witness> {
    let values: Vec<f64> = points.par_iter().map(|p| value(*p)).collect();
    let mut beyond: Vec<(f64, DVec3)> =
        values.into_iter().zip(points).filter(|(value, _)| *value > claim).map(|(value, p)| (value, *p)).collect();
    beyond.sort_by(|a, b| b.0.total_cmp(&a.0));
    let found = beyond.into_iter().find(|(_, p)| confirm(*p));
    found.map(|(distance, at)| Witness { distance, at })
}

fn search(
    triangles: &[Triangle],
    claim: f64,
    measure: impl Fn(&Triangle) -> Measured + Sync,
    confirm: impl Fn(DVec3) -> bool,
) -> Option<Witness> {
    let mut queue = BinaryHeap::new();
    let (mut best, mut count) = (0.0, 0);
    let mut next: Vec<Triangle> = triangles.to_vec();
    loop {
        count += next.len();
        let measured: Vec<Measured> = next.par_iter().map(&measure).collect();
        let mut greatest: Option<(f64, Triangle)> = None;
        for (corners, Measured { bound, value, at }) in next.drain(..).zip(measured) {
            if value > claim && confirm(at) {
                return Some(Witness { distance: value, at });
            }
            if value > best {
                best = value;
                greatest = Some((value, corners));
            }
            // NaN is kept.
            if !(bound <= claim) {
                queue.push(Cell { bound, corners });
            }
        }
        if let Some((_, mut corners)) = greatest {
            for _ in 0..DESCENT {
                let [left, right] = halves(&corners).map(|half| (measure(&half), half));
                let (measured, half) = if left.0.value >= right.0.value { left } else { right };
                best = best.max(measured.value);
                if measured.value > claim && confirm(measured.at) {
                    return Some(Witness { distance: measured.value, at: measured.at });
                }
                corners = half;
            }
        }
        if count >= MAX_CELLS {
            return None;
        }
        while next.len() < 2 * BATCH {
            let Some(cell) = queue.pop() else { break };
            next.extend(halves(&cell.corners));
        }
        if next.is_empty() {
            return None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hullmap::Pack;
    use hullmap_bake::fit::fits;
    use hullmap_bake::{BakedHull, IndexKind, SourceRecord, bake_hull, write_pack};
    use shapes::solids::extrusion;

    /// An L. Its caps are fans from the concave corner, the fourth one.
    fn corner() -> PointSet {
        let outline = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let mut l = extrusion(&outline, 0.0, 1.0);
        l.faces[0].rotate_left(2);
        l.faces[1].rotate_left(3);
        PointSet { name: "l".into(), triangles: l.fans(), ..PointSet::of_positions(l.vertices) }
    }

    fn part(mesh: &PointSet, vertices: &[usize]) -> BakedHull {
        let points = PointSet {
            positions: vertices.iter().map(|v| mesh.positions[*v]).collect(),
            source_vertices: vertices.iter().map(|v| *v as u32).collect(),
            triangles: Vec::new(),
            ..mesh.clone()
        };
        bake_hull(&points, IndexKind::None).unwrap()
    }

    fn pack(mut parts: Vec<BakedHull>, mesh: &PointSet) -> Pack {
        let fits = fits(mesh, &parts.iter().map(|part| &part.hull).collect::<Vec<_>>(), None).unwrap();
        let count = parts.len() as u32;
        for (index, (part, fit)) in parts.iter_mut().zip(fits).enumerate() {
            (part.part, part.part_count, part.fit) = (index as u32, count, Some(fit));
        }
        Pack::from_bytes(&write_pack(&parts, &SourceRecord::default()).unwrap()).unwrap()
    }

    #[test]
    fn a_hull_around_an_l_protrudes_by_the_height_of_a_triangle() {
        let mesh = corner();
        let all: Vec<usize> = (0..12).collect();
        let pack = pack(vec![part(&mesh, &all)], &mesh);
        let (hull, judge) = (pack.hull(0).unwrap(), Judge::new(&mesh, &Solid::new(&mesh)));
        assert_eq!((judge.kind(), hull.solid()), (SolidKind::Watertight, Some(SolidKind::Watertight)));
        // The face from (3, 1) to (1, 2) is farthest from the solid where both arms are as far.
        let truth = 2.0 / 3.0;
        let (claimed, at) = (hull.protrusion().unwrap(), hull.protrusion_at().unwrap());
        assert!((truth..1.006 * truth).contains(&claimed), "{claimed}");
        assert!(judge.is_in(&hull, at) && !judge.is_in(&hull, DVec3::splat(9.0)));
        assert_eq!(judge.protrusion(&hull, claimed, Some(at)), None);
        for start in [Some(at), None] {
            let found = judge.protrusion(&hull, 0.99 * truth, start).unwrap();
            assert!((0.99 * truth..=truth).contains(&found.distance), "{found:?}");
        }
        assert_eq!(judge.uncovered(&mesh, &[hull], 1e-9), None);
    }

    #[test]
    fn a_missing_corner_of_the_surface_is_found() {
        let mesh = corner();
        let mut upper = part(&mesh, &[0, 3, 4, 5, 6, 9, 10, 11]);
        let flat = part(&mesh, &[0, 1, 2, 6, 7, 8]);
        upper.name = "upper".into();
        let pack = pack(vec![upper, flat], &mesh);
        let hulls: Vec<Hull> = pack.hulls().collect();
        let judge = Judge::new(&mesh, &Solid::new(&mesh));
        let claimed = hulls[0].uncovered().unwrap();
        // The vertex (1, 1) is covered by the upper arm. The edge from there to (3, 1) is outside
        // of both parts between its ends.
        assert!(claimed > 0.1, "{claimed}");
        assert_eq!(judge.uncovered(&mesh, &hulls, claimed), None);
        let found = judge.uncovered(&mesh, &hulls, 0.985 * claimed).unwrap();
        assert!(found.distance > 0.985 * claimed && found.distance <= claimed);
        assert_eq!(judge.uncovered(&mesh, &hulls[..1], 1.5).map(|found| found.distance > 1.5), Some(true));
    }
}
