//! Adaptive binary subdivision of the cube's faces (Kenwright 4.9), with exact leaves.
//!
//! 1. A cell that few enough normal cones meet is a leaf, and lists them all.
//! 2. A cell with room for a fan is one if its cones lie side by side around an axis ([`super::fan`]). Its steps are halved
//!    until each is a leaf; where that parts nothing, planes go on.
//! 3. Any other cell is halved: across u, across v, and so on in turn.
//! 4. Where halving hardly parts the cones, the cell is a fan, however small, or else is cut by a plane between two of them,
//!    and so is all below it.
//!
//! Deviations from the paper: it stops where a cell's corners share their support vertex, or at a depth limit, where it
//! then answers wrongly; here the leaf lists every vertex that can be the answer, and a cell whose corners agree is
//! just a leaf of one. Steps 2 and 4 are new (the paper's own tree does without fans: [`Cuts`]): the cones around a facet of many corners, or along a prism's side, are long
//! and thin, and squares small enough to part them are too many, n² of them instead of n.

use glam::DVec3;
use hullmap_format::cube::{GRID_BITS, grid_to_uv};

use super::{
    cones::{Cones, Line},
    fan::{self, Fan, Frame, Interval},
};
use crate::gauss_map::GaussMap;

/// Halvings along each axis after which only planes are left: cells are then 20 times as wide as their overlap.
const MAX_HALVINGS: u32 = 18;

/// Halving a square cell that compact cones tile lists about 1.2·√k of its k cones twice; it parts them badly where it
/// lists more than this many times √k twice, and one more.
const GOOD_HALVING: f64 = 2.0;

/// A plane is worth leaving the grid for if it lists at most this share of what halving lists twice.
const GOOD_PLANE: f64 = 0.5;

/// Halvings on one path that may list nearly all cones twice before the cell is left as it is, with a long list.
const FUTILE_LIMIT: u32 = 12;

/// A halving is futile where it lists this share of the cones twice.
const FUTILE: f64 = 0.9;

/// Vertices from which planes are tried, and planes from each.
const PLANE_SAMPLES: usize = 8;
const PLANES_OF_VERTEX: usize = 3;

/// A plane must leave this share of the cones, and at least one, out of its fuller side.
const PROGRESS: f64 = 0.1;

/// Cells of this many leaves of cones may be fans.
const FAN_FROM: usize = 3;

/// Cells of this many leaves of cones are looked at as fans before they are halved, smaller ones only where halving fails.
const FAN_FIRST: usize = 16;

/// Halvings of a fan, one after another, that part nothing before its places are left as they are.
const FUTILE_WEDGES: u32 = 5;

/// Cells of more cones are subdivided in parallel.
const PARALLEL_FROM: usize = 512;

/// A subdivided cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Tree {
    /// Every vertex whose cone meets the cell, ascending.
    Leaf(Vec<u32>),
    /// Lower and upper half.
    Axis(Box<[Tree; 2]>),
    /// Behind and in front of a plane through the origin.
    Plane([f64; 3], Box<[Tree; 2]>),
    /// Side by side around an axis: the places from 0 to 1 of this frame.
    Fan(Frame, Box<Tree>),
    /// Lower and upper half of a fan's places, or of half of them.
    Wedges(Box<[Tree; 2]>),
}

/// What may part the cones of a cell, beside halving.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cuts {
    /// Planes, where halving stalls: as near to the paper as an exact tree of reasonable size gets.
    Planes,
    /// Fans, and planes where there is no fan.
    FansAndPlanes,
}

/// Subdivides one face of the cube, down to leaves of at most `leaf` vertices.
///
/// # Complexity
/// O(n log n) for n vertices on all families tried; the result does not depend on the number of threads.
pub fn subdivide(map: &GaussMap, face: u32, leaf: usize, cuts: Cuts) -> Tree {
    Subdivision { map, face, leaf, cuts }.cell(Cones::on_face(map, face), [0, 0], 0, 0)
}

struct Subdivision<'a> {
    map: &'a GaussMap,
    face: u32,
    leaf: usize,
    cuts: Cuts,
}

/// A fan that is being subdivided.
struct Wedges<'a> {
    cones: &'a Cones,
    frame: Frame,
    /// Vertices of a leaf that is not halved: fewer than fit, as neighbouring leaves fill up each other's blocks.
    full: usize,
}

impl Subdivision<'_> {
    /// Subdivides the cell at grid place `at`, halved `depth` times, `futile` times in vain.
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
        let twice = (cones.count(line).iter().sum::<usize>() - cones.len()) as f64;
        if twice > GOOD_HALVING * count.sqrt() + 1.0
            && let Some((_, by_plane)) = self.best_plane(&cones)
            && (by_plane as f64) <= GOOD_PLANE * twice
        {
            return self.planes(cones);
        }
        let futile = futile + u32::from(twice > FUTILE * count);
        let (parallel, [behind, front]) = (cones.len() > PARALLEL_FROM, cones.split(line));
        drop(cones);
        let lower = || self.cell(behind, at, depth + 1, futile);
        let upper = || self.cell(front, upper, depth + 1, futile);
        let halves = if parallel { rayon::join(lower, upper) } else { (lower(), upper()) };
        Tree::Axis(Box::new(halves.into()))
    }

    /// Cuts a cell by planes alone.
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
        let (parallel, [behind, front]) = (cones.len() > PARALLEL_FROM, cones.split(Line::plane(self.face, normal)));
        drop(cones);
        let behind = || self.planes(behind);
        let front = || self.planes(front);
        let halves = if parallel { rayon::join(behind, front) } else { (behind(), front()) };
        Tree::Plane(normal.to_array(), Box::new(halves.into()))
    }

    /// A cell whose cones lie side by side.
    fn fan(&self, cones: &Cones) -> Option<Tree> {
        if self.cuts == Cuts::Planes || cones.len() < FAN_FROM * self.leaf {
            return None;
        }
        let axis = fan::axis(&self.samples(cones).collect::<Vec<_>>())?;
        let fan = Fan::new(self.face, cones, axis)?;
        let wedges = Wedges { cones, frame: fan.frame, full: fan.layers as usize + self.leaf / 3 };
        let root = self.wedges(&wedges, &fan.intervals, [0.0, 1.0], 0);
        Some(if matches!(root, Tree::Wedges(_)) { Tree::Fan(fan.frame, Box::new(root)) } else { root })
    }

    /// Halves the places of a fan until few enough cones are left: `intervals` are those within `places`.
    fn wedges(&self, fan: &Wedges, intervals: &[Interval], places: [f64; 2], futile: u32) -> Tree {
        let mut list: Vec<u32> = intervals.iter().map(|i| i.vertex).collect();
        list.dedup();
        if list.len() <= fan.full {
            return Tree::Leaf(list);
        }
        if futile == FUTILE_WEDGES {
            let part = fan.cones.select(intervals.iter().map(|i| i.polygon as usize));
            let [start, end] = places.map(|t| Line::plane(self.face, fan.frame.plane(t)));
            let [_, part] = part.split(start);
            let [part, _] = part.split(end);
            return self.planes(part);
        }
        let middle = 0.5 * (places[0] + places[1]);
        let halves = [[places[0], middle], [middle, places[1]]];
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

    /// Normals of some planes between neighbouring cones of this cell.
    fn samples<'b>(&'b self, cones: &'b Cones) -> impl Iterator<Item = DVec3> + 'b {
        sample(&cones.vertices, PLANE_SAMPLES).flat_map(move |vertex| {
            let neighbours = self.map.neighbours(vertex).iter().copied();
            let within: Vec<u32> = neighbours.filter(|w| cones.vertices.binary_search(w).is_ok()).collect();
            let chosen: Vec<u32> = sample(&within, PLANES_OF_VERTEX).collect();
            chosen.into_iter().map(move |neighbour| self.map.plane_between(vertex, neighbour))
        })
    }

    /// Of some planes between cones of this cell, the one whose fuller side has the fewest, and how many it lists twice.
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

/// Up to `most` of `all`, evenly spread.
fn sample(all: &[u32], most: usize) -> impl Iterator<Item = u32> + '_ {
    let count = all.len().min(most);
    (0..count).map(move |i| all[(2 * i + 1) * all.len() / (2 * count)])
}
