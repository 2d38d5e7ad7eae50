//! Atoms: small patches of the surface, of which pieces are made.

use std::sync::OnceLock;

use glam::DVec3;

use super::{extremes::Extremes, field::Field};
use crate::{decompose::patch::Patch, fit::triangle_tree::Bounds, symmetry::Mirror};
use hullmap_geometry::{bounds, planes, triangle};

/// A small patch that is not divided unless a plane cuts it.
#[derive(Debug)]
pub struct Atom {
    /// The patch.
    pub patch: Patch,
    /// Minimum of its points.
    pub low: DVec3,
    /// Maximum of its points.
    pub high: DVec3,
    /// Its area.
    pub area: f64,
    /// Sum of the polygons' normals, each as long as its area.
    pub normal: DVec3,
    /// The extremes of its points, once they are used.
    extremes: OnceLock<Box<Extremes>>,
    /// A point of a polygon, and where the solid behind it ends, once they are used.
    across: OnceLock<Option<[DVec3; 2]>>,
}

impl Atom {
    /// An atom of a patch.
    pub fn new(patch: Patch) -> Self {
        let [low, high] = bounds(patch.points.iter().copied());
        let mut atom = Self {
            patch,
            low,
            high,
            area: 0.0,
            normal: DVec3::ZERO,
            extremes: OnceLock::new(),
            across: OnceLock::new(),
        };
        let normals: Vec<DVec3> = atom.triangles().map(|[a, b, c]| 0.5 * (b - a).cross(c - a)).collect();
        (atom.area, atom.normal) = (normals.iter().map(|n| n.length()).sum(), normals.iter().sum());
        atom
    }

    /// The extremes of its points.
    pub fn extremes(&self) -> &Extremes {
        self.extremes.get_or_init(|| Box::new(Extremes::from_points(&self.patch.points)))
    }

    /// The box around it.
    pub fn bounds(&self) -> Bounds {
        Bounds { low: self.low, high: self.high }
    }

    /// A point of the largest polygon, and the first point behind it where the solid ends.
    pub fn across(&self, field: &Field) -> Option<[DVec3; 2]> {
        *self.across.get_or_init(|| {
            let normal = |[a, b, c]: &[DVec3; 3]| (*b - *a).cross(*c - *a);
            let largest = self.triangles().max_by(|a, b| normal(a).length().total_cmp(&normal(b).length()))?;
            let normal = normal(&largest).try_normalize()?;
            field.across((largest[0] + largest[1] + largest[2]) / 3.0, -normal)
        })
    }

    /// The distance of a point.
    pub fn distance(&self, p: DVec3) -> f64 {
        self.triangles().map(|corners| triangle::nearest(&corners, p).distance(p)).fold(f64::INFINITY, f64::min)
    }

    /// A point of a polygon within a distance.
    pub fn near(&self, p: DVec3, distance: f64) -> Option<DVec3> {
        self.triangles().map(|corners| triangle::nearest(&corners, p)).find(|q| q.distance(p) <= distance)
    }

    /// Its mirror image, whose faces point outward, too.
    pub fn image(&self, mirror: &Mirror) -> Self {
        let polygons = &self.patch.polygons;
        let image = |p: &DVec3| mirror.image(*p);
        let polygons = polygons.iter().map(|polygon| polygon.iter().rev().map(image).collect()).collect();
        Self::new(Patch { polygons, points: self.patch.points.iter().map(image).collect() })
    }

    /// The polygons as triangles.
    pub fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        let fan = |p: &'_ Vec<DVec3>| planes::fan(p);
        self.patch.polygons.iter().flat_map(fan)
    }
}
