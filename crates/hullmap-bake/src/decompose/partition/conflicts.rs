//! Conflicts: pairs of points of a piece's surface that must not be in the same part, because the
//! line between them leads too far from the solid.
//!
//! The fewer conflicts are left within the sides of a plane, the fewer parts the sides will take.
//! The number of forbidden points in their hulls is less meaningful: a plane across a ring halves
//! it, and both halves take as many parts as the ring.
//!
//! Points in mutual conflict, a *clique*, need a part each. So a clique is a lower bound on the
//! number of parts, proven up to rounding: a part with both ends of a line contains it, and
//! protrudes by more than the limit.
//!
//! Reference, where such pairs are called mutex pairs: Ren, Yuan, Li, Liu, "Minimum near-convex
//! decomposition for robust shape representation", 2011.

use glam::DVec3;
use rayon::prelude::*;

use super::{
    clique::large_clique,
    context::PartitionSearch,
    field::Field,
    piece::{Piece, Scale},
    sample::{far_apart, spread_points},
    surface::Surface,
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
    /// Conflicts beyond the limit of final hulls, which is larger.
    proven: Vec<Points>,
    total: f64,
}

impl Conflicts {
    /// Points spread by area, and their conflicts.
    ///
    /// # Complexity
    /// A few distances from the solid for each of at most 2,016 pairs.
    pub fn new(search: &PartitionSearch, piece: &Piece) -> Self {
        let PartitionSearch { field, scale, bounds, .. } = search;
        let atoms = piece.atoms.iter().enumerate();
        let (owners, triangles): (Vec<u32>, Vec<[DVec3; 3]>) =
            atoms.flat_map(|(index, atom)| atom.triangles().map(move |triangle| (index as u32, triangle))).unzip();
        let spread = spread_points(triangles.into_iter(), piece.area() / POINTS as f64);
        let mut points: Vec<(DVec3, u32)> = spread.into_iter().map(|(index, p)| (p, owners[index])).collect();
        points.truncate(POINTS);
        let pair = |p: DVec3, q: DVec3| match far(field, p, q, scale.limit) {
            Some(far) => [true, field.is_beyond(far, bounds.limit)],
            None => [false; 2],
        };
        let [with, proven] = conflicts(&points.iter().map(|(p, _)| *p).collect::<Vec<_>>(), pair);
        let total = with.iter().map(|with| f64::from(with.count_ones())).sum();
        Self { points, with, proven, total }
    }

    /// A number of parts that any cover of the piece within the limit needs.
    pub fn needed(&self) -> usize {
        large_clique(self.proven.len(), |i, j| self.proven[i] >> j & 1 == 1).max(1)
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

/// Sample points that bound the number of parts for any limit: spread ones, and corners far from
/// each other, such as the ends of limbs. For half a surface, with mirror images.
pub struct Samples([Vec<DVec3>; 2]);

impl Samples {
    /// # Complexity
    /// O(n) for n triangles.
    pub fn new(surface: &Surface) -> Self {
        let triangles = surface.triangles.iter().copied();
        let area = triangles.clone().map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum::<f64>();
        let count = if surface.mirror.is_some() { POINTS / 2 } else { POINTS };
        let mut spread: Vec<DVec3> =
            spread_points(triangles, area / count as f64).into_iter().map(|(_, p)| p).collect();
        spread.truncate(count);
        let far = far_apart(surface.triangles.as_flattened(), count);
        let with_images = |points: Vec<DVec3>| {
            let images = surface.mirror.iter().flat_map(|mirror| points.iter().map(|p| mirror.image(*p)));
            [images.collect(), points.clone()].concat()
        };
        Self([spread, far].map(with_images))
    }

    /// A number of parts that any cover within `limit` needs, at least 1.
    ///
    /// # Complexity
    /// A few distances from the solid for each of at most 4,032 pairs.
    pub fn needed(&self, field: &Field, limit: f64) -> usize {
        let needed =
            |points: &Vec<DVec3>| large_clique(points.len(), |i, j| far(field, points[i], points[j], limit).is_some());
        self.0.iter().map(needed).fold(1, usize::max)
    }
}

/// A point between two others that is too far from the solid; `None` if none is found.
pub fn far(field: &Field, p: DVec3, q: DVec3, limit: f64) -> Option<DVec3> {
    MEASURED.iter().map(|t| p.lerp(q, *t)).find(|between| field.is_beyond(*between, limit))
}

fn conflicts(points: &[DVec3], pair: impl Fn(DVec3, DVec3) -> [bool; 2] + Sync) -> [Vec<Points>; 2] {
    let earlier = |i: usize| {
        let mut row = [0; 2];
        for j in 0..i {
            let found = pair(points[i], points[j]);
            (0..2).for_each(|k| row[k] |= Points::from(found[k]) << j);
        }
        row
    };
    let rows: Vec<[Points; 2]> = (0..points.len()).into_par_iter().map(earlier).collect();
    [0, 1].map(|k| mutual(rows.iter().map(|row| row[k]).collect()))
}

fn mutual(mut rows: Vec<Points>) -> Vec<Points> {
    for i in 0..rows.len() {
        for j in 0..i {
            rows[j] |= (rows[i] >> j & 1) << i;
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use shapes::{concave, mesh::Mesh, solids::extrusion};

    use super::*;
    use crate::{
        decompose::{
            partition::{PartitionLimits, cells::FacePlanes, piece::Atom, search, wrap::HullLimits},
            patch::Patch,
            tests::point_set,
        },
        fit::Solid,
        progress::Stage,
        symmetry,
    };
    use hullmap_geometry::PointSet;

    fn bounds(share: f64, solid: &Solid) -> HullLimits<'static> {
        let (diagonal, stage) = (solid.diagonal(), Stage::default());
        HullLimits { limit: share * diagonal, max_vertices: 64, diagonal, thickness: 0.0, deadline: None, stage }
    }

    fn all_needed(mesh: &PointSet, share: f64) -> Vec<usize> {
        let (solid, surface) = (Solid::new(mesh), Surface::new(mesh));
        let bounds = bounds(share, &solid);
        let field = Field::new(&solid);
        let scale = Scale { limit: 0.94 * bounds.limit, diagonal: bounds.diagonal };
        let planes = FacePlanes::new(&surface.triangles, bounds.diagonal);
        let atom = |triangle: &[DVec3; 3]| Arc::new(Atom::new(Patch::new(vec![triangle.to_vec()]).unwrap()));
        let piece = scale.piece(surface.triangles.iter().map(atom).collect(), Vec::new(), &[]);
        let search = PartitionSearch { field: &field, scale, planes: &planes, bounds, enough: usize::MAX, peels: true };
        let mut found =
            vec![Conflicts::new(&search, &piece).needed(), Samples::new(&surface).needed(&field, bounds.limit)];
        if let Some(mirror) = symmetry::mirror_of_mesh(mesh, &solid) {
            found.push(Samples::new(&surface.halved(mirror, bounds.diagonal)).needed(&field, bounds.limit));
        }
        found
    }

    #[test]
    fn bodies_in_a_row_need_a_part_each() {
        for count in 1..=6 {
            let mut row = Mesh::default();
            for k in 0..count {
                let cube = extrusion(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 0.0, 1.0);
                let first = row.vertices.len() as u32;
                row.vertices.extend(cube.vertices.iter().map(|p| [p[0] + 3.0 * k as f32, p[1], p[2]]));
                row.faces.extend(cube.faces.iter().map(|face| face.iter().map(|v| v + first).collect::<Vec<_>>()));
            }
            assert_eq!(all_needed(&point_set(&row), 0.01), [count; 3]);
        }
    }

    #[test]
    fn no_more_parts_are_needed_than_are_found() {
        let (mut equal, mut sum) = (0, [0; 2]);
        for mesh in [concave::l(), concave::open_box(), concave::chair(), concave::horseshoe(12), concave::pipe(10)] {
            let mesh = point_set(&mesh);
            let solid = Solid::new(&mesh);
            for share in [0.01, 0.03] {
                let limits = PartitionLimits {
                    bounds: bounds(share, &solid),
                    overlap: 0.05,
                    useful: None,
                    wanted: 1,
                    peels: true,
                    bridges: true,
                };
                let found = search(&Surface::new(&mesh), &mut Field::new(&solid), &limits).unwrap().parts.len();
                let needed = all_needed(&mesh, share);
                println!("{needed:?} needed, {found} found");
                assert!(needed.iter().all(|needed| *needed <= found), "{needed:?} of {found}");
                equal += usize::from(needed[0] == found);
                sum = [sum[0] + needed[0], sum[1] + found];
            }
        }
        assert!(equal > 3 && 2 * sum[0] > sum[1], "the sample is not representative: {equal}, {sum:?}");
    }
}
