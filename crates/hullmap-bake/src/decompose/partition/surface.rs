//! The surface that parts must contain: a mesh's, or half of it.

use glam::DVec3;

use super::piece::ON_PLANE;
use crate::symmetry::Mirror;
use hullmap_geometry::{PointSet, planes};

/// Triangles, and where they are halved.
pub struct Surface {
    /// The triangles. Their faces point outward.
    pub triangles: Vec<[DVec3; 3]>,
    /// The mirror about which they are half of a surface.
    pub mirror: Option<Mirror>,
}

impl Surface {
    /// The whole surface of a mesh.
    pub fn new(mesh: &PointSet) -> Self {
        let at = |v: &u32| mesh.positions.get(*v as usize).map(|p| DVec3::from_array(p.map(f64::from)));
        let corners = |[a, b, c]: &[u32; 3]| Some([at(a)?, at(b)?, at(c)?]);
        let mut triangles: Vec<[DVec3; 3]> = mesh.triangles.iter().filter_map(corners).collect();
        if triangles.iter().map(|[a, b, c]| a.cross(*b).dot(*c)).sum::<f64>() < 0.0 {
            triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        Self { triangles, mirror: None }
    }

    /// The half on the mirror's own side; `diagonal` belongs to the whole mesh.
    pub fn halved(self, mirror: Mirror, diagonal: f64) -> Self {
        let own = mirror.plane.opposite();
        let half = |triangle: &[DVec3; 3]| {
            let mut kept = planes::cut(triangle, &own, ON_PLANE * diagonal)[0].clone();
            // Both halves end at the same points.
            kept.iter_mut().filter(|p| own.height(**p).abs() <= ON_PLANE * diagonal).for_each(|p| *p = mirror.foot(*p));
            planes::fan(&kept)
        };
        Self { triangles: self.triangles.iter().flat_map(half).collect(), mirror: Some(mirror) }
    }
}
