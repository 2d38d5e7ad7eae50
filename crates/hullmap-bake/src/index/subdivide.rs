//! Adaptive binary subdivision of the cube's faces (Kenwright 4.9), with exact leaves: chooses the
//! candidates of each leaf.
//!
//! 1. A cell that meets few enough normal cones is a leaf, which lists all of them.
//! 2. A large cell becomes a fan if its cones lie side by side around an axis ([`super::fan`]). The
//!    steps of the fan are halved until each is a leaf. Where halving no longer separates cones,
//!    planes continue.
//! 3. Any other cell is halved, alternately across u and across v.
//! 4. Where halving barely separates the cones, the cell becomes a fan even if it is small. If its
//!    cones do not form a fan, a plane between two of them cuts the cell, and planes cut everything
//!    below it.
//!
//! Deviations from the paper:
//! - It stops where a cell's corners share their support vertex, or at a depth limit, and may
//!   return a wrong vertex. Here, a leaf lists every vertex whose cone reaches into the cell by
//!   more than a tolerance ([`super::cones`]), so the regret is bounded.
//! - [`super::packing`] lets leaves share blocks afterwards; then a leaf may list more vertices.
//! - Steps 2 and 4 are new; [`Cuts`] turns fans off, as in the paper's tree. Separating n of the
//!   thin cones around a face with many corners, or along a prism's side, takes n² squares.

use glam::DVec3;
use hullmap_format::cube::{self, GRID_BITS, grid_to_uv};

use super::{
    cones::{Cones, Line},
    fan::{self, Fan, Frame, Interval},
};
use crate::gauss_map::GaussMap;

/// Maximum number of halvings along each axis; below that, only planes cut. At this depth, cells
/// are 20 times as wide as their overlap.
const MAX_HALVINGS: u32 = 18;

/// Halving a square cell tiled by k compact cones lists about 1.2·√k of them twice. Halving
/// separates cones badly if it lists more than this constant times √k, plus one, twice.
const GOOD_HALVING: f64 = 2.0;

/// Maximum number of cones that a plane may list twice to be preferred to halving, relative to it.
const GOOD_PLANE: f64 = 0.5;

/// Maximum number of futile halvings on one path. After that, only planes cut.
const FUTILE_LIMIT: u32 = 12;

/// A halving is futile if it lists more than this fraction of the cones twice.
const FUTILE: f64 = 0.9;

/// Number of vertices from which planes are tried, and number of planes tried per vertex.
const PLANE_SAMPLES: usize = 8;
const PLANES_OF_VERTEX: usize = 3;

/// Minimum fraction of the cones, and at least one, that a plane must keep out of its fuller side.
const PROGRESS: f64 = 0.1;

/// Minimum number of cones of a fan, in multiples of the leaf size.
const FAN_FROM: usize = 3;

/// Minimum number of cones, in multiples of the leaf size, for a fan to be tried before halving. A
/// smaller cell is tried only where halving fails.
const FAN_FIRST: usize = 16;

/// Maximum number of consecutive halvings of a fan that separate nothing. After that, planes cut.
const FUTILE_WEDGES: u32 = 5;

/// Number of cones above which a cell is subdivided in parallel.
const PARALLEL_FROM: usize = 512;

/// A subdivided cell. A large hull has millions of them, so that all but the leaves are boxed.
#[derive(Clone, Debug, PartialEq)]
pub enum Tree {
    /// Every vertex whose cone meets the cell, ascending.
    Leaf(Vec<u32>),
    /// Lower and upper half along u or v.
    Axis(Box<[Tree; 2]>),
    /// The parts behind and in front of a plane through the origin.
    Plane(Box<[f64; 3]>, Box<[Tree; 2]>),
    /// A fan: cones side by side around an axis, at positions 0 to 1 of this frame.
    Fan(Box<Frame>, Box<Tree>),
    /// Lower and upper half of a range of positions in a fan.
    Wedges(Box<[Tree; 2]>),
}

/// Means of cutting a cell, in addition to halving.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cuts {
    /// Planes, where halving stalls. This is as close to the paper as an exact tree of reasonable
    /// size can be.
    Planes,
    /// Fans, and planes where the cones do not form a fan.
    FansAndPlanes,
}

/// Subdivides one face of the cube, down to cells that meet the cones of at most `leaf` vertices.
/// The result does not depend on the number of threads.
///
/// # Complexity
/// O(n log n) for n vertices on all families tried.
pub fn subdivide(map: &GaussMap, face: u32, leaf: usize, cuts: Cuts) -> Tree {
    Subdivision { map, face, leaf, cuts }.cell(Cones::on_face(map, face), [0, 0], 0, 0)
}

struct Subdivision<'a> {
    map: &'a GaussMap,
    face: u32,
    leaf: usize,
    cuts: Cuts,
}

struct Wedges<'a> {
    cones: &'a Cones,
    frame: Frame,
    /// Maximum number of vertices of a leaf that is not halved. It is less than a leaf's capacity,
    /// so that neighbouring leaves can share blocks.
    full: usize,
    /// Support vertex at the axis. Steps outside of the cell list it: rounding error may locate a
    /// direction near the axis in any step.
    apex: u32,
}

impl Subdivision<'_> {
    /// Subdivides the cell at grid position `at`, after `depth` halvings, `futile` of them futile.
    fn cell(&self, cones: Cones, at: [u32; 2], depth: u32, futile: u32) -> Tree {
        if cones.vertex_count() <= self.leaf {
            return Tree::Leaf(cones.into_vertices());
        }
        if depth == 2 * MAX_HALVINGS || futile == FUTILE_LIMIT {
            return self.planes(cones);
        }
        if cones.len() >= FAN_FIRST * self.leaf
            && let Some(fan) = self.fan(&cones)
        {
            return fan;
        }
        let axis = (depth % 2) as usize;
        let half = 1 << (GRID_BITS - 1 - depth / 2);
        let mut upper = at;
        upper[axis] += half;
        let line = Line::axis(axis, grid_to_uv(upper[axis]));
        let count = cones.len() as f64;
        let counts = cones.count(line);
        let twice = (counts.iter().sum::<usize>() - cones.len()) as f64;
        if twice > GOOD_HALVING * count.sqrt() + 1.0
            && let Some((_, by_plane)) = self.best_plane(&cones)
            && (by_plane as f64) <= GOOD_PLANE * twice
        {
            return self.planes(cones);
        }
        let futile = futile + u32::from(twice > FUTILE * count);
        let (parallel, [behind, front]) = (cones.len() > PARALLEL_FROM, cones.split(line, counts));
        drop(cones);
        let lower = || self.cell(behind, at, depth + 1, futile);
        let upper = || self.cell(front, upper, depth + 1, futile);
        let halves = if parallel { rayon::join(lower, upper) } else { (lower(), upper()) };
        Tree::Axis(Box::new(halves.into()))
    }

    fn planes(&self, cones: Cones) -> Tree {
        if cones.vertex_count() <= self.leaf {
            return Tree::Leaf(cones.into_vertices());
        }
        if let Some(fan) = self.fan(&cones) {
            return fan;
        }
        let Some((normal, _)) = self.best_plane(&cones) else {
            return Tree::Leaf(cones.into_vertices());
        };
        let line = Line::plane(self.face, normal);
        let (parallel, counts) = (cones.len() > PARALLEL_FROM, cones.count(line));
        let [behind, front] = cones.split(line, counts);
        drop(cones);
        let behind = || self.planes(behind);
        let front = || self.planes(front);
        let halves = if parallel { rayon::join(behind, front) } else { (behind(), front()) };
        Tree::Plane(Box::new(normal.to_array()), Box::new(halves.into()))
    }

    fn fan(&self, cones: &Cones) -> Option<Tree> {
        if self.cuts == Cuts::Planes || cones.len() < FAN_FROM * self.leaf {
            return None;
        }
        let axis = fan::axis(&self.samples(cones).collect::<Vec<_>>())?;
        let fan = Fan::new(self.face, cones, axis)?;
        let full = fan.layers as usize + self.leaf / 3;
        let wedges = Wedges { cones, frame: fan.frame, full, apex: self.support(cones, axis) };
        let root = self.wedges(&wedges, &fan.intervals, [0.0, 1.0], 0);
        Some(if matches!(root, Tree::Wedges(_)) { Tree::Fan(Box::new(fan.frame), Box::new(root)) } else { root })
    }

    /// Halves a range of a fan's positions until few enough of its `intervals` are left.
    fn wedges(&self, fan: &Wedges, intervals: &[Interval], positions: [f64; 2], futile: u32) -> Tree {
        let mut list: Vec<u32> = intervals.iter().map(|i| i.vertex).collect();
        list.dedup();
        if list.is_empty() {
            return Tree::Leaf(vec![fan.apex]);
        }
        if list.len() <= fan.full {
            return Tree::Leaf(list);
        }
        if futile == FUTILE_WEDGES {
            let part = fan.cones.select(intervals.iter().map(|i| i.polygon as usize));
            let [start, end] = positions.map(|t| Line::plane(self.face, fan.frame.plane(t)));
            let [_, part] = part.split(start, part.count(start));
            let [part, _] = part.split(end, part.count(end));
            return if part.is_empty() { Tree::Leaf(vec![fan.apex]) } else { self.planes(part) };
        }
        let middle = 0.5 * (positions[0] + positions[1]);
        let halves = [[positions[0], middle], [middle, positions[1]]];
        let within = halves.map(|[start, end]| -> Vec<Interval> {
            intervals.iter().filter(|i| i.meets(start, end)).copied().collect()
        });
        if list.len() <= self.leaf && within.iter().any(|half| half.len() == intervals.len()) {
            return Tree::Leaf(list);
        }
        let half = |i: usize| {
            let futile = if within[i].len() < intervals.len() { 0 } else { futile + 1 };
            self.wedges(fan, &within[i], halves[i], futile)
        };
        Tree::Wedges(Box::new([half(0), half(1)]))
    }

    /// The support vertex among these cones' vertices where an axis goes through the cube's face.
    fn support(&self, cones: &Cones, axis: DVec3) -> u32 {
        let towards = DVec3::from_array(cube::direction(self.face, 0.0, 0.0));
        let axis = if axis.dot(towards) < 0.0 { -axis } else { axis };
        let height = |vertex: &u32| self.map.position(*vertex).dot(axis);
        cones.vertices.iter().copied().max_by(|a, b| height(a).total_cmp(&height(b))).unwrap_or(0)
    }

    fn samples<'b>(&'b self, cones: &'b Cones) -> impl Iterator<Item = DVec3> + 'b {
        sample(&cones.vertices, PLANE_SAMPLES).flat_map(move |vertex| {
            let neighbours = self.map.neighbours(vertex).iter().copied();
            let within: Vec<u32> = neighbours.filter(|w| cones.vertices.binary_search(w).is_ok()).collect();
            let chosen: Vec<u32> = sample(&within, PLANES_OF_VERTEX).collect();
            chosen.into_iter().map(move |neighbour| self.map.plane_between(vertex, neighbour))
        })
    }

    /// The sampled plane between cones whose fuller side has the fewest, and the number that it
    /// lists twice.
    fn best_plane(&self, cones: &Cones) -> Option<(DVec3, usize)> {
        let least = ((PROGRESS * cones.len() as f64) as usize).max(1);
        let mut fullest = cones.len() - least + 1;
        let mut best = None;
        for normal in self.samples(cones) {
            let [behind, front] = cones.count(Line::plane(self.face, normal));
            if behind.max(front) < fullest {
                fullest = behind.max(front);
                best = Some((normal, behind + front - cones.len()));
            }
        }
        best
    }
}

fn sample(all: &[u32], max_count: usize) -> impl Iterator<Item = u32> + '_ {
    let count = all.len().min(max_count);
    (0..count).map(move |i| all[(2 * i + 1) * all.len() / (2 * count)])
}
