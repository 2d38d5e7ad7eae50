//! Conflicts: pairs of points of a piece's surface that must not be in the same part, because the
//! line between them leads too far from the solid.
//!
//! The fewer conflicts are left within the sides of a plane, the fewer parts the sides will take.
//! The number of forbidden points in their hulls is less meaningful: a plane across a ring halves
//! it, and both halves take as many parts as the ring.
//!
//! Reference, where such pairs are called mutex pairs: Ren, Yuan, Li, Liu, "Minimum near-convex
//! decomposition for robust shape representation", 2011.

use glam::DVec3;
use rayon::prelude::*;

use super::{
    context::PartitionSearch,
    field::Field,
    links::Links,
    piece::{Piece, Scale},
    sample::spread_points,
};
use hullmap_geometry::planes::HalfSpace;

const POINTS: usize = 64;

/// Where a line is measured, the middle first.
const MEASURED: [f64; 5] = [0.5, 0.25, 0.75, 0.125, 0.875];

type Points = u64;

/// Points of a piece's surface, and which of them are in conflict.
pub struct Conflicts {
    /// Each point, and the number of its atom.
    points: Vec<(DVec3, u32)>,
    /// For each point, those with which it is in conflict.
    with: Vec<Points>,
    total: f64,
    /// Number of colours of all points, so that no conflict is within a colour.
    colours: u32,
}

impl Conflicts {
    /// Points spread by area, and their conflicts.
    ///
    /// # Complexity
    /// A few distances from the solid for each of at most 2,016 pairs.
    pub fn new(search: &PartitionSearch, piece: &Piece) -> Self {
        let PartitionSearch { field, scale, .. } = search;
        let atoms = piece.atoms.iter().enumerate();
        let (owners, triangles): (Vec<u32>, Vec<[DVec3; 3]>) =
            atoms.flat_map(|(index, atom)| atom.triangles().map(move |triangle| (index as u32, triangle))).unzip();
        let spread = spread_points(triangles.into_iter(), piece.area() / POINTS as f64);
        let mut points: Vec<(DVec3, u32)> = spread.into_iter().map(|(index, p)| (p, owners[index])).collect();
        points.truncate(POINTS);
        let pair = |p: DVec3, q: DVec3| far(field, p, q, scale.limit).is_some();
        let with = conflicts(&points.iter().map(|(p, _)| *p).collect::<Vec<_>>(), pair);
        let total = with.iter().map(|with| f64::from(with.count_ones())).sum();
        let mut found = Self { points, with, total, colours: 0 };
        found.colours = found.colours((0..found.points.len()).fold(0, |all, i| all | 1 << i));
        found
    }

    /// The share of the conflicts that are within connected components on one side of a plane, plus
    /// the share of the colours that these need.
    pub fn left(&self, piece: &Piece, scale: &Scale, near: &Links, plane: &HalfSpace) -> f64 {
        if self.total == 0.0 {
            return 0.0;
        }
        let back = plane.opposite();
        let mut left = 0.0;
        let mut colours = 0;
        for side in [plane, &back] {
            let component = scale.components_above(&piece.atoms, near, side);
            let count = component.iter().filter(|c| **c != u32::MAX).max().map_or(0, |c| *c as usize + 1);
            let mut members: Vec<Points> = vec![0; count];
            let mut of: Vec<u32> = Vec::with_capacity(self.points.len());
            for (i, (p, atom)) in self.points.iter().enumerate() {
                let is_above = side.height(*p) >= 0.0;
                let c = if is_above { component[*atom as usize] } else { u32::MAX };
                of.push(c);
                if c != u32::MAX {
                    members[c as usize] |= 1 << i;
                }
            }
            colours += members.iter().map(|members| self.colours(*members)).sum::<u32>();
            for (with, c) in self.with.iter().zip(&of).filter(|(_, c)| **c != u32::MAX) {
                left += f64::from((with & members[*c as usize]).count_ones());
            }
        }
        left / self.total + f64::from(colours) / f64::from(self.colours)
    }

    /// Number of groups of points of a set within which there are no conflicts: an estimate of the
    /// number of parts that they need.
    fn colours(&self, points: Points) -> u32 {
        let (mut left, mut count) = (points, 0);
        while left != 0 {
            let mut free = left;
            while free != 0 {
                let i = free.trailing_zeros() as usize;
                left &= !(1 << i);
                free &= !(self.with[i] | 1 << i);
            }
            count += 1;
        }
        count
    }
}

/// A point between two others that is too far from the solid; `None` if none is found.
pub fn far(field: &Field, p: DVec3, q: DVec3, limit: f64) -> Option<DVec3> {
    MEASURED.iter().map(|t| p.lerp(q, *t)).find(|between| field.is_beyond(*between, limit))
}

fn conflicts(points: &[DVec3], pair: impl Fn(DVec3, DVec3) -> bool + Sync) -> Vec<Points> {
    let earlier = |i: usize| (0..i).map(|j| Points::from(pair(points[i], points[j])) << j).sum();
    mutual((0..points.len()).into_par_iter().map(earlier).collect())
}

fn mutual(mut rows: Vec<Points>) -> Vec<Points> {
    for i in 0..rows.len() {
        for j in 0..i {
            rows[j] |= (rows[i] >> j & 1) << i;
        }
    }
    rows
}
