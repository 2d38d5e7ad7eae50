//! The surface that parts must contain: a mesh's, or half of it.

use std::collections::HashSet;

use glam::DVec3;

use super::piece::ON_PLANE;
use crate::{
    fit::{Solid, SolidKind},
    symmetry::Mirror,
};
use hullmap_geometry::{PointSet, bits, planes, triangle::Triangle};

/// Triangles, and where they are halved.
pub struct Surface {
    /// The triangles on the own sides of all mirrors. Their faces point outward.
    pub triangles: Vec<Triangle>,
    /// The mirrors, at right angles to each other.
    pub mirrors: Vec<Mirror>,
}

impl Surface {
    /// The whole surface of a mesh, whose solid states which way its triangles face. Triangles that
    /// repeat others, or are their other sides, are left out.
    pub fn new(mesh: &PointSet, solid: &Solid) -> Self {
        let at = |v: u32| mesh.positions.get(v as usize).map(|p| DVec3::from_array(p.map(f64::from)));
        let normal = |[a, b, c]: &Triangle| (*b - *a).cross(*c - *a);
        let mut seen = HashSet::new();
        let own =
            mesh.triangles.iter().zip(solid.triangles()).enumerate().filter_map(|(index, ([a, b, c], turned))| {
                let mut corners = [at(*a)?, at(*b)?, at(*c)?];
                let mut key = corners.map(bits);
                key.sort_unstable();
                // A line bounds nothing, but must be covered.
                let is_line = key[0] == key[1] || key[1] == key[2];
                let is_needed = solid.bounds_inside(index) || solid.kind() == SolidKind::Walls || is_line;
                if normal(&corners).dot(normal(turned)) < 0.0 {
                    corners.swap(1, 2);
                }
                (is_needed && seen.insert(key)).then_some(corners)
            });
        let mut triangles: Vec<Triangle> = own.collect();
        if triangles.iter().map(|[a, b, c]| a.cross(*b).dot(*c)).sum::<f64>() < 0.0 {
            triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        Self { triangles, mirrors: Vec::new() }
    }

    /// The half on a mirror's own side; `diagonal` belongs to the whole mesh.
    pub fn halved(&self, mirror: Mirror, diagonal: f64) -> Self {
        let own = mirror.plane.opposite();
        let half = |triangle: &Triangle| {
            let mut kept = planes::cut(triangle, &own, ON_PLANE * diagonal)[0].clone();
            // Both halves end at the same points.
            kept.iter_mut().filter(|p| own.height(**p).abs() <= ON_PLANE * diagonal).for_each(|p| *p = mirror.foot(*p));
            planes::fan(&kept)
        };
        let triangles = self.triangles.iter().flat_map(half).collect();
        Self { triangles, mirrors: [self.mirrors.as_slice(), &[mirror]].concat() }
    }
}
