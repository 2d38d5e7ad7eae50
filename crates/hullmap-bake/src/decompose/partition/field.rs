//! Tests whether points are farther from the solid than a limit. A grid of voxels settles most
//! points at once.
//!
//! # Steps
//! 1. Label voxels that a triangle may enter as mixed.
//! 2. The other voxels form connected components, each all inside or all outside. Label each
//!    component by one query of the solid.
//! 3. Count the steps from each voxel to the nearest mixed one: a lower bound on the distance.

use std::collections::BinaryHeap;

use glam::DVec3;

use super::flats::Flats;
use crate::deadline::Deadline;
use crate::fit::{branch::Entry, peaks::Peaks, solid::Solid};
use hullmap_geometry::triangle;

const VOXELS: usize = 48;

/// Maximum number of measurements to find local maxima.
const PEAK_MEASUREMENTS: usize = 60_000;

const MIXED: u8 = 0;
const OUTSIDE: u8 = 1;
const INSIDE: u8 = 2;
const UNKNOWN: u8 = 3;

/// A solid with a grid of labels.
pub struct Field<'a> {
    solid: &'a Solid,
    low: DVec3,
    step: f64,
    size: [usize; 3],
    labels: Vec<u8>,
    /// For each voxel, the number of steps to the nearest mixed one among its 26 neighbours.
    steps: Vec<u8>,
    peaks: Option<Peaks>,
    /// The greatest length above which there are too many.
    no_peaks_above: f64,
    flats: Flats,
}

impl<'a> Field<'a> {
    /// The field of a solid.
    pub fn new(solid: &'a Solid) -> Self {
        let [low, high] = solid.bounds();
        let extent = (high - low).max_element();
        let step = extent / VOXELS as f64;
        if !(step > 0.0) || !step.is_finite() {
            return Self::of_labels(solid, low, 1.0, [0; 3], Vec::new());
        }
        // A voxel of margin on every side.
        let low = low - DVec3::splat(step);
        let size = (high - low).to_array().map(|x| (x / step) as usize + 2);
        let labels = vec![UNKNOWN; size[0] * size[1] * size[2]];
        let mut field = Self::of_labels(solid, low, step, size, labels);
        for triangle in solid.triangles() {
            field.mark(triangle);
        }
        field.fill();
        field.count_steps();
        field
    }

    fn of_labels(solid: &'a Solid, low: DVec3, step: f64, size: [usize; 3], labels: Vec<u8>) -> Self {
        Self {
            solid,
            low,
            step,
            size,
            labels,
            steps: Vec::new(),
            peaks: None,
            no_peaks_above: 0.0,
            flats: Flats::default(),
        }
    }

    fn mark(&mut self, [a, b, c]: &[DVec3; 3]) {
        let (low, high) = (a.min(*b).min(*c), a.max(*b).max(*c));
        let slack = DVec3::splat(1e-6 * self.step);
        let [first, last] = [low - slack, high + slack].map(|p| self.cell(p));
        let normal = (*b - *a).cross(*c - *a).normalize_or_zero();
        let reach = normal.abs().element_sum() * 0.5 * self.step * (1.0 + 1e-6);
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    let centre = self.low + (DVec3::new(x as f64, y as f64, z as f64) + 0.5) * self.step;
                    if normal.dot(centre - *a).abs() <= reach {
                        let at = self.cell_index([x, y, z]);
                        self.labels[at] = MIXED;
                    }
                }
            }
        }
    }

    fn fill(&mut self) {
        let mut stack = Vec::new();
        for z in 0..self.size[2] {
            for y in 0..self.size[1] {
                for x in 0..self.size[0] {
                    if self.labels[self.cell_index([x, y, z])] != UNKNOWN {
                        continue;
                    }
                    let centre = self.low + (DVec3::new(x as f64, y as f64, z as f64) + 0.5) * self.step;
                    let label = if self.solid.is_inside(centre) { INSIDE } else { OUTSIDE };
                    let at = self.cell_index([x, y, z]);
                    self.labels[at] = label;
                    stack.push([x, y, z]);
                    while let Some(cell) = stack.pop() {
                        for axis in 0..3 {
                            for other in [cell[axis].wrapping_sub(1), cell[axis] + 1] {
                                if other >= self.size[axis] {
                                    continue;
                                }
                                let mut next = cell;
                                next[axis] = other;
                                let at = self.cell_index(next);
                                if self.labels[at] == UNKNOWN {
                                    self.labels[at] = label;
                                    stack.push(next);
                                }
                            }
                        }
                    }
                }
            }
        }
    }

    /// One axis after the other: the least of the greatest of the steps along the axes.
    fn count_steps(&mut self) {
        self.steps = self.labels.iter().map(|label| if *label == MIXED { 0 } else { u8::MAX }).collect();
        for axis in 0..3 {
            let stride = [1, self.size[0], self.size[0] * self.size[1]][axis];
            let length = self.size[axis];
            for start in (0..self.steps.len()).filter(|at| (at / stride).is_multiple_of(length)) {
                let line: Vec<u8> = (0..length).map(|k| self.steps[start + k * stride]).collect();
                for k in 0..length {
                    let mut least = line[k];
                    for away in 1..length {
                        if away >= usize::from(least) {
                            break;
                        }
                        let both = [k.checked_sub(away), Some(k + away)];
                        let near = both.into_iter().flatten().filter_map(|k| line.get(k)).min();
                        least = near.map_or(least, |near| least.min((*near).max(away as u8)));
                    }
                    self.steps[start + k * stride] = least;
                }
            }
        }
    }

    /// The label of the voxel around a point, and a lower bound of the point's distance from the
    /// surface; `None` outside of the grid.
    fn side(&self, p: DVec3) -> Option<(u8, f64)> {
        let q = (p - self.low) / self.step;
        let is_in_grid = q.min_element() >= 0.0 && (0..3).all(|axis| q[axis] < self.size[axis] as f64);
        is_in_grid.then(|| {
            let at = self.cell_index(self.cell(p));
            (self.labels[at], f64::from(self.steps[at].saturating_sub(1)) * self.step * (1.0 - 1e-5))
        })
    }

    fn cell(&self, p: DVec3) -> [usize; 3] {
        let q = ((p - self.low) / self.step).to_array();
        [0, 1, 2].map(|axis| (q[axis].max(0.0) as usize).min(self.size[axis] - 1))
    }

    fn cell_index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.size[1] + y) * self.size[0] + x
    }

    /// Whether a point is farther than `limit` from the solid, or stands out of a flat face.
    pub fn is_beyond(&self, p: DVec3, limit: f64) -> bool {
        self.is_far(p, limit) || self.flats.are_exceeded(self.solid, p) && !self.is_inside(p)
    }

    /// Whether a point is farther than `limit` from the solid.
    pub fn is_far(&self, p: DVec3, limit: f64) -> bool {
        match self.side(p) {
            Some((INSIDE, _)) => false,
            Some((OUTSIDE, clearance)) if clearance > limit => true,
            _ => !self.solid.is_near(p, limit) && !self.is_inside(p),
        }
    }

    /// Keeps the large flat faces flat, for parts within a limit.
    pub fn keep_flats(&mut self, limit: f64, thickness: f64) {
        self.flats = Flats::new(self.solid, limit, thickness);
    }

    /// Finds the local maxima of the distance above a length, which makes proofs for greater
    /// lengths faster. Does nothing if a smaller length is done, or if there were too many above a
    /// greater one.
    pub fn find_peaks(&mut self, above: f64, deadline: Option<Deadline>) {
        if above <= self.no_peaks_above || self.peaks.as_ref().is_some_and(|peaks| peaks.above() <= above) {
            return;
        }
        match Peaks::new(self.solid, above, PEAK_MEASUREMENTS, deadline) {
            Some(peaks) => self.peaks = Some(peaks),
            None => self.no_peaks_above = above,
        }
    }

    /// The local maxima of the distance, if they are known.
    pub fn peaks(&self) -> Option<&Peaks> {
        self.peaks.as_ref()
    }

    /// At most `count` points of triangles that are farther than `limit` from the solid, by branch
    /// and bound as in [`protrusion`](mod@crate::fit::protrusion). Triangles whose middle is found
    /// are not divided, so that points are far apart.
    pub fn points_beyond(&self, triangles: &[[DVec3; 3]], limit: f64, count: usize, measurements: usize) -> Vec<DVec3> {
        let mut queue = BinaryHeap::new();
        let mut found = Vec::new();
        for corners in triangles {
            let (_, bound) = triangle::ball(corners);
            let cell = Piece { within: f64::INFINITY, hint: None, corners: *corners };
            queue.push(Entry { bound, index: queue.len(), cell });
        }
        let mut pushed = queue.len();
        for _ in 0..measurements {
            let Some(Entry { cell: piece, .. }) = queue.pop() else { break };
            let (centre, radius) = triangle::ball(&piece.corners);
            match self.side(centre) {
                Some((OUTSIDE, clearance)) if clearance > limit => {
                    found.push(centre);
                    if found.len() >= count {
                        break;
                    }
                    continue;
                }
                Some((INSIDE, clearance)) if clearance > radius => continue,
                _ => {}
            }
            let Some(near) = self.solid.near_beside(centre, piece.within, piece.hint.as_ref()) else { continue };
            let to_corners = triangle::farthest(&piece.corners, &near.triangle);
            let may_exceed_flats = self.flats.may_be_exceeded(&piece.corners);
            let least = if may_exceed_flats { self.flats.height() } else { limit };
            if (near.distance + radius).min(to_corners.max(near.distance)) <= least {
                continue;
            }
            let exceeds = |p| may_exceed_flats && self.flats.are_exceeded(self.solid, p);
            if near.distance > least || near.gap > radius {
                if self.is_inside(centre) {
                    if near.gap > radius {
                        continue;
                    }
                } else if near.distance > limit || exceeds(centre) {
                    found.push(centre);
                    if found.len() >= count {
                        break;
                    }
                    continue;
                }
            }
            let within = near.distance + 2.0 * radius;
            for corners in triangle::halves(&piece.corners) {
                let (middle, radius) = triangle::ball(&corners);
                let distance = near.distance + middle.distance(centre);
                if distance + radius > least {
                    let cell = Piece { within, hint: Some(near.triangle), corners };
                    queue.push(Entry { bound: distance + radius, index: pushed, cell });
                    pushed += 1;
                }
            }
        }
        found
    }

    /// Whether a point is in the solid.
    pub fn is_inside(&self, p: DVec3) -> bool {
        match self.side(p) {
            Some((INSIDE, _)) => true,
            Some((OUTSIDE, _)) => false,
            None if !self.labels.is_empty() => false,
            _ => self.solid.is_inside(p),
        }
    }

    /// A point, and the first point behind it along a unit vector at which the solid ends; `None`
    /// if it does not begin there.
    pub fn across(&self, p: DVec3, direction: DVec3) -> Option<[DVec3; 2]> {
        let end = self.solid.first_hit(p, direction)?;
        let is_between = [0.5, 0.1, 0.9].iter().all(|t| self.is_inside(p.lerp(end, *t)));
        is_between.then_some([p, end])
    }

    /// The solid.
    pub fn solid(&self) -> &'a Solid {
        self.solid
    }
}

struct Piece {
    /// A distance that exceeds its middle's.
    within: f64,
    /// A triangle of the mesh that is near.
    hint: Option<[DVec3; 3]>,
    corners: [DVec3; 3],
}

#[cfg(test)]
mod tests {
    use shapes::{concave, rng::SplitMix64};

    use super::*;
    use crate::test_meshes::point_set;

    #[test]
    fn points_are_beyond_if_the_nearest_triangle_is() {
        let seed = 8;
        println!("seed {seed}");
        let mut rng = SplitMix64::new(seed);
        let [mut open, mut sheet] = [point_set(&concave::mug(24)), point_set(&concave::bowl(16, 5))];
        open.triangles.drain(..30);
        sheet.triangles.truncate(40);
        let (mut beyond, mut by_steps) = (0, 0);
        for mesh in [point_set(&concave::pipe(16)), open, sheet] {
            let solid = Solid::new(&mesh);
            let field = Field::new(&solid);
            let [low, high] = solid.bounds();
            for round in 0..6_000 {
                let t = DVec3::from_array(std::array::from_fn(|_| rng.between(-0.2, 1.2)));
                let p = low + (high - low) * t;
                let limit = solid.diagonal() * [0.002, 0.01, 0.05][round % 3];
                let is_near = solid.near(p, limit).is_some_and(|near| near.distance <= limit);
                let is_beyond = !is_near && !solid.is_inside(p);
                assert_eq!(field.is_beyond(p, limit), is_beyond, "round {round}: {p}");
                if let Some((_, clearance)) = field.side(p).filter(|side| side.1 > 0.0) {
                    let near = solid.near(p, f64::INFINITY).unwrap();
                    assert!(clearance <= near.gap, "round {round}: {clearance} at {p}");
                    by_steps += usize::from(is_beyond && clearance > limit);
                }
                beyond += usize::from(is_beyond);
            }
        }
        assert!(beyond > 3_000 && by_steps > 1_000, "{beyond} beyond, {by_steps} by steps");
    }

    #[test]
    fn peaks_serve_greater_lengths() {
        let mesh = point_set(&concave::bowl(24, 8));
        let solid = Solid::new(&mesh);
        let diagonal = solid.diagonal();
        let mut field = Field::new(&solid);
        // There are too many above the tiny length, and few above the others.
        let [tiny, tenth, fifth, third] = [1e-4, 0.1, 0.2, 0.3].map(|share| share * diagonal);
        let above = |field: &Field| field.peaks().map(Peaks::above);
        field.find_peaks(fifth, None);
        assert_eq!(above(&field), Some(fifth));
        field.find_peaks(third, None);
        assert_eq!(above(&field), Some(fifth));
        field.find_peaks(tiny, None);
        assert_eq!((above(&field), field.no_peaks_above), (Some(fifth), tiny));
        field.find_peaks(tenth, None);
        assert_eq!(above(&field), Some(tenth));
    }
}
