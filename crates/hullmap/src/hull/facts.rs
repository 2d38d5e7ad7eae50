//! Facts that the bake recorded about a hull: sizes, mass, bounds, errors.

use glam::{DVec3, Vec3};
use hullmap_format::SolidKind;

use super::{Hull, vector};

impl Hull<'_> {
    /// Dimension of the hull: 3 for a solid, 2 for a polygon, 1 for a segment, 0 for a point.
    pub fn rank(&self) -> u32 {
        self.record.rank.to_native()
    }

    /// Number of source points that the hull was built from.
    pub fn source_point_count(&self) -> u32 {
        self.record.source_points.to_native()
    }

    /// Maximum distance between two vertices, in source units.
    pub fn diameter(&self) -> f64 {
        self.record.diameter.to_native()
    }

    /// Volume; 0 below rank 3.
    pub fn volume(&self) -> f64 {
        self.record.volume.to_native()
    }

    /// Surface area: both sides of a polygon, 0 below rank 2.
    pub fn surface_area(&self) -> f64 {
        self.record.surface_area.to_native()
    }

    /// Centre of mass at uniform density, in the hull's local frame.
    pub fn centroid(&self) -> DVec3 {
        vector(&self.record.centroid)
    }

    /// Second moments about the centroid, divided by the volume (area, length): xx, yy, zz, yz, zx,
    /// xy.
    ///
    /// For the inertia tensor, see [`mass_properties`](Self::mass_properties).
    pub fn second_moments(&self) -> [f64; 6] {
        self.record.second_moments.map(|m| m.to_native())
    }

    /// Minimum and maximum coordinates of the vertices.
    pub fn bounds(&self) -> [Vec3; 2] {
        [&self.record.bounds_min, &self.record.bounds_max].map(|b| Vec3::from_array(b.map(|c| c.to_native())))
    }

    /// Maximum distance of a source point from the hull, divided by the diameter. At most 1e-7.
    pub fn containment_error(&self) -> f64 {
        self.record.containment_error.to_native()
    }

    /// Maximum distance by which the hull reaches beyond the convex hull of its source points, in
    /// source units. 0 for an exact hull, positive for a simplified one.
    pub fn outer_error(&self) -> f64 {
        self.record.outer_error.to_native()
    }

    /// Origin of the hull's frame in the frame of the source file. Add it to a point of the hull to
    /// get the source's coordinates. Zero unless the bake recentred; the same for all hulls of a
    /// pack.
    pub fn origin(&self) -> DVec3 {
        vector(&self.record.origin)
    }

    /// Index of the hull among the convex parts of its source object, counted from 0. Also 0 for a
    /// hull that is not a part. The parts of an object follow one another.
    pub fn part(&self) -> u32 {
        self.record.part.to_native()
    }

    /// Number of convex parts of the hull's source object; 0 for a hull that is not a part.
    pub fn part_count(&self) -> u32 {
        self.record.part_count.to_native()
    }

    /// Kind of solid that this part was measured against. `None` if it was not measured: then
    /// [`uncovered`](Self::uncovered) and [`protrusion`](Self::protrusion) are unknown. Hulls that
    /// are not parts, and parts without their mesh, are not measured.
    pub fn solid(&self) -> Option<SolidKind> {
        SolidKind::from_code(self.record.solid.to_native())
    }

    /// Upper bound on how far a point of the source object's surface lies outside all of its convex
    /// parts, in source units. All parts of an object have the same; `None` if not measured.
    pub fn uncovered(&self) -> Option<f64> {
        self.solid().map(|_| self.record.uncovered.to_native())
    }

    /// Upper bound on how far a point of this convex part lies outside the solid of the source
    /// object, in source units; `None` if it was not measured.
    pub fn protrusion(&self) -> Option<f64> {
        self.solid().map(|_| self.record.protrusion.to_native())
    }

    /// The point of this convex part that protrudes most from the solid of the source object, as
    /// far as the bake found, in the hull's local frame; `None` if it was not measured.
    pub fn protrusion_at(&self) -> Option<DVec3> {
        self.solid().map(|_| vector(&self.record.protrusion_at))
    }

    /// Share of the solid of the source object's mesh that lies in none of its parts: 0 to 1. The
    /// same for all parts of an object. A small body that starts there touches nothing.
    ///
    /// `None` if the pack does not record it: the hull is not a part, or its mesh bounds no solid
    /// that could be measured.
    ///
    /// # Complexity
    /// O(1).
    pub fn voids(&self) -> Option<Voids> {
        let voids = self.voids?;
        Some(Voids { share: f64::from(voids.share.to_native()), error: f64::from(voids.error.to_native()) })
    }
}

/// The share of a solid's volume that lies in none of its parts, as an estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Voids {
    /// Volume in no part, relative to the volume of the solid: 0 to 1.
    pub share: f64,
    /// Error of the share: twice its standard deviation, 0 to 1.
    pub error: f64,
}
