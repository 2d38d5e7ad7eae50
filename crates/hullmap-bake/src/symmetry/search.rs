//! The mirror planes of a set of points, found by hashing.
//!
//! # Steps
//! 1. Take planes that may be mirrors. At right angles to an axis, only the middle of the points'
//!    box can be. Any other mirror contains the centre of the points, and maps the point farthest
//!    from the centre to one that is as far. If it contains that point, too, it maps the point
//!    farthest from the line of both to one that is as far from the line, at the same height.
//! 2. Reflect each point, and look it up in a grid whose cells have the size of rounding errors.
//!
//! Planes across axes come first, and the longest side before the others. Others are searched for
//! only without these.
//!
//! # Reference
//! - Wolter, Woo, Volz, "Optimal algorithms for symmetry detection in two and three dimensions",
//!   1985: symmetries map the points of each distance from the centre to each other.
//!
//! # Complexity
//! O(n) look-ups for each plane. There are at most 100 planes, and a sample rules out most of them.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use super::mirror::Mirror;
use hullmap_geometry::{bits, bounds, planes::HalfSpace};

/// Distance of matching points, relative to the diagonal: files of six digits have such errors.
const MATCH: f64 = 1e-6;

/// Distance relative to the greatest coordinate: two roundings to f32.
const ROUNDING: f64 = 2.4e-7;

/// Maximum number of points that may be images of one point.
const MAX_IMAGES: usize = 48;

/// Number of points that are reflected before all are.
const SAMPLE: usize = 64;

/// Least distance of a point from its image, relative to the diagonal, for a precise normal.
const LEAST_STEP: f64 = 1e-2;

pub fn tolerance(points: &[[f32; 3]]) -> f64 {
    let [low, high] = bounds(points.iter().map(|p| DVec3::from_array(p.map(f64::from))));
    MATCH * low.distance(high) + ROUNDING * low.abs().max(high.abs()).max_element()
}

/// The planes about which distinct points are symmetric, the preferred one first.
pub fn mirrors(points: &[[f32; 3]]) -> Vec<Mirror> {
    let mut bits: Vec<[u32; 3]> = points.iter().map(|p| p.map(|c| (c + 0.0).to_bits())).collect();
    bits.sort_unstable();
    bits.dedup();
    let distinct: Vec<DVec3> =
        bits.iter().map(|p| DVec3::from_array(p.map(|c| f64::from(f32::from_bits(c))))).collect();
    if distinct.len() < 4 || !distinct.iter().all(|p| p.is_finite()) {
        return Vec::new();
    }
    let set = Points::new(distinct, tolerance(points));
    let across: Vec<Mirror> = set.across_axes().into_iter().filter_map(|plane| set.mirror(plane)).collect();
    if !across.is_empty() {
        return across;
    }
    set.others().into_iter().find_map(|plane| set.mirror(plane)).into_iter().collect()
}

struct Points {
    points: Vec<DVec3>,
    exact: HashSet<[u64; 3]>,
    cells: HashMap<[i64; 3], DVec3>,
    low: DVec3,
    high: DVec3,
    tolerance: f64,
}

impl Points {
    fn new(points: Vec<DVec3>, tolerance: f64) -> Self {
        let [low, high] = bounds(points.iter().copied());
        let exact = points.iter().map(|p| bits(*p)).collect();
        let mut set = Self { points, exact, cells: HashMap::new(), low, high, tolerance };
        for k in 0..set.points.len() {
            let p = set.points[k];
            set.cells.entry(set.cell(p)).or_insert(p);
        }
        set
    }

    fn cell(&self, p: DVec3) -> [i64; 3] {
        ((p - self.low) / self.tolerance).floor().to_array().map(|c| c as i64)
    }

    fn across_axes(&self) -> Vec<HalfSpace> {
        let size = self.high - self.low;
        let mut axes = [0, 1, 2];
        axes.sort_by(|a, b| size[*b].total_cmp(&size[*a]).then(a.cmp(b)));
        // A flat set would be its own image about its plane.
        let axes = axes.into_iter().filter(|axis| size[*axis] > 4.0 * self.tolerance);
        let plane = |axis: usize| {
            let middle = 0.5 * (self.low[axis] + self.high[axis]);
            let offset = if middle.abs() <= self.tolerance { 0.0 } else { middle };
            HalfSpace { normal: DVec3::AXES[axis], offset }
        };
        axes.map(plane).collect()
    }

    fn others(&self) -> Vec<HalfSpace> {
        let centre = self.points.iter().sum::<DVec3>() / self.points.len() as f64;
        let mut planes = Vec::new();
        let farthest = |key: &dyn Fn(DVec3) -> f64| {
            self.points.iter().copied().reduce(|best, p| if key(p) > key(best) { p } else { best })
        };
        let Some(first) = farthest(&|p| p.distance(centre)) else { return planes };
        let slack = 4.0 * self.tolerance;
        let images = |p: DVec3, is_image: &dyn Fn(DVec3) -> bool| {
            let found = self.points.iter().filter(|q| is_image(**q));
            let found = found.take(MAX_IMAGES + 1).filter_map(|q| self.between(p, *q));
            found.collect::<Vec<HalfSpace>>()
        };
        let radius = first.distance(centre);
        planes.extend(images(first, &|q| (q.distance(centre) - radius).abs() <= slack));
        let Some(along) = (first - centre).try_normalize() else { return planes };
        let off = |p: DVec3| (p - centre).reject_from_normalized(along).length();
        let Some(second) = farthest(&off) else { return planes };
        let (height, distance) = (along.dot(second), off(second));
        planes
            .extend(images(second, &|q| (off(q) - distance).abs() <= slack && (along.dot(q) - height).abs() <= slack));
        let normal = along.cross(second - centre).try_normalize();
        planes.extend(normal.map(|normal| HalfSpace { normal, offset: normal.dot(centre) }));
        planes
    }

    /// The plane between two points; `None` if they are so close that its normal is not precise.
    fn between(&self, p: DVec3, q: DVec3) -> Option<HalfSpace> {
        let normal = (p - q).try_normalize()?;
        let is_far = p.distance(q) > LEAST_STEP * self.low.distance(self.high);
        is_far.then(|| HalfSpace { normal, offset: normal.dot(0.5 * (p + q)) })
    }

    fn mirror(&self, plane: HalfSpace) -> Option<Mirror> {
        let mirror = Mirror { plane, error: 0.0 };
        let step = self.points.len().div_ceil(SAMPLE);
        let gap = |p: &DVec3| self.gap(mirror.image(*p));
        self.points.iter().step_by(step).all(|p| gap(p).is_some()).then_some(())?;
        let error = self.points.iter().try_fold(0.0, |worst, p| Some(f64::max(worst, gap(p)?)))?;
        Some(Mirror { error, ..mirror })
    }

    fn gap(&self, p: DVec3) -> Option<f64> {
        if self.exact.contains(&bits(p)) {
            return Some(0.0);
        }
        let [x, y, z] = self.cell(p);
        let around = (0..27).map(|i| [x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1]);
        let gaps = around.filter_map(|cell| self.cells.get(&cell)).map(|q| q.distance(p));
        // The first point of a cell stands for all.
        gaps.reduce(f64::min).filter(|gap| *gap <= 3.0 * self.tolerance)
    }
}
