//! Conflicts: pairs of points of a piece's surface that must not be in the same part, because the
//! line between them leads too far from the solid.
//!
//! The fewer conflicts are left within the sides of a plane, the fewer parts the sides will take.
//! The number of forbidden points in their hulls is less meaningful: a plane across a ring halves
//! it, and both halves take as many parts as the ring.
//!
//! # Reference
//! Such pairs are called mutex pairs in Ren, Yuan, Li, Liu, "Minimum near-convex decomposition for
//! robust shape representation", 2011.

use glam::DVec3;
use rayon::prelude::*;

use super::{
    field::Field,
    piece::{Piece, Scale},
    sample::spread_points,
};
use crate::fit::planes::HalfSpace;

/// Maximum number of points.
const POINTS: usize = 64;

/// Where a line is measured, the middle first.
const MEASURED: [f64; 5] = [0.5, 0.25, 0.75, 0.125, 0.875];

/// A set of points.
type Points = u64;

/// Points of a piece's surface, and which of them are in conflict.
pub struct Conflicts {
    /// Each point, and the number of its atom.
    points: Vec<(DVec3, u32)>,
    /// For each point, those with which it is in conflict.
    with: Vec<Points>,
    total: f64,
}

impl Conflicts {
    /// Points spread by area, and their conflicts.
    ///
    /// # Complexity
    /// A few distances from the solid for each of at most 2,016 pairs.
    pub fn new(piece: &Piece, scale: &Scale, field: &Field) -> Self {
        let atoms = piece.atoms.iter().enumerate();
        let (owners, triangles): (Vec<u32>, Vec<[DVec3; 3]>) =
            atoms.flat_map(|(index, atom)| atom.triangles().map(move |triangle| (index as u32, triangle))).unzip();
        let spread = spread_points(triangles.into_iter(), piece.area() / POINTS as f64);
        let mut points: Vec<(DVec3, u32)> = spread.into_iter().map(|(index, p)| (p, owners[index])).collect();
        points.truncate(POINTS);
        let is_conflict = |p: DVec3, q: DVec3| MEASURED.iter().any(|t| field.is_beyond(p.lerp(q, *t), scale.limit));
        let row = |i: usize| {
            let mut with: Points = 0;
            for j in (0..i).filter(|j| is_conflict(points[i].0, points[*j].0)) {
                with |= 1 << j;
            }
            with
        };
        let mut with: Vec<Points> = (0..points.len()).into_par_iter().map(row).collect();
        for i in 0..points.len() {
            for j in 0..i {
                with[j] |= (with[i] >> j & 1) << i;
            }
        }
        let total = with.iter().map(|with| f64::from(with.count_ones())).sum();
        Self { points, with, total }
    }

    /// The share of the conflicts that are within connected components on one side of a plane.
    pub fn left(&self, piece: &Piece, scale: &Scale, near: &[Vec<u32>], plane: &HalfSpace) -> f64 {
        if self.total == 0.0 {
            return 0.0;
        }
        let back = plane.opposite();
        let mut left = 0.0;
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
            for (with, c) in self.with.iter().zip(&of).filter(|(_, c)| **c != u32::MAX) {
                left += f64::from((with & members[*c as usize]).count_ones());
            }
        }
        left / self.total
    }
}
