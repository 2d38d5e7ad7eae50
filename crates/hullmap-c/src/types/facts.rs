//! Facts and arrays of a hull, the primitive that may replace it, and mass properties of a pack.

use hullmap::glam::DVec3;
use hullmap::{Bounds, MassSource};

use super::geometry::Pose;

/// Kind of solid that convex parts were measured against: HullmapHullFacts.solid.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solid {
    /// The hull was not measured: it is not a part, or its mesh was not known.
    Unmeasured = 0,
    /// The mesh is watertight.
    Watertight = 1,
    /// The mesh has holes, which were closed.
    Closed = 2,
    /// The solid is the triangles of the mesh alone: it is open, or encloses nothing.
    Walls = 3,
}

impl From<Option<hullmap::SolidKind>> for Solid {
    fn from(kind: Option<hullmap::SolidKind>) -> Self {
        match kind {
            None => Self::Unmeasured,
            Some(hullmap::SolidKind::Watertight) => Self::Watertight,
            Some(hullmap::SolidKind::Closed) => Self::Closed,
            Some(hullmap::SolidKind::Walls) => Self::Walls,
        }
    }
}

/// Text in UTF-8. It is not terminated, and may hold any character.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Text {
    /// First byte; never NULL.
    pub data: *const std::ffi::c_char,
    /// Number of bytes.
    pub length: usize,
}

/// Facts that the bake recorded about a hull. Points are in the hull's frame, which is the source
/// mesh's; lengths are in its unit.
///
/// Set struct_size to sizeof(HullmapHullFacts) before the call. Later versions may add fields at
/// the end.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct HullFacts {
    /// Set by the caller.
    pub struct_size: usize,
    /// Name; valid as long as the pack, or a shape made from it, exists.
    pub name: Text,
    /// Number of vertices, at least 1.
    pub vertex_count: usize,
    /// Number of faces: both sides of a polygon, 0 for a segment or a point.
    pub face_count: usize,
    /// Dimension: 3 for a solid, 2 for a polygon, 1 for a segment, 0 for a point.
    pub rank: u32,
    /// Index of the hull among the convex parts of its source object.
    pub part: u32,
    /// Volume; 0 below rank 3.
    pub volume: f64,
    /// Surface area: both sides of a polygon, 0 below rank 2.
    pub surface_area: f64,
    /// Centre of mass at uniform density.
    pub centroid: DVec3,
    /// Inertia tensor about the centroid at density 1, row by row; symmetric. For a density d or a
    /// mass m, multiply it by d, or by m / volume.
    pub inertia: [f64; 9],
    /// Box around the vertices.
    pub bounds: Bounds,
    /// Maximum distance between two vertices.
    pub diameter: f64,
    /// A point in the hull, far from its surface.
    pub interior_point: DVec3,
    /// Radius of a ball around interior_point that the hull contains; 0 for a flat hull.
    pub inner_radius: f64,
    /// Radius of a ball around interior_point that contains the hull.
    pub outer_radius: f64,
    /// Maximum distance of a source point from the hull, divided by the diameter; at most 1e-7.
    pub containment_error: f64,
    /// Maximum distance by which the hull reaches beyond the convex hull of its source; 0 for an
    /// exact hull.
    pub outer_error: f64,
    /// Origin of the hull's frame in the source file's frame; zero unless the bake recentred.
    pub origin: DVec3,
    /// Number of convex parts of its source object; 0 for a hull that is not a part.
    pub part_count: u32,
    /// A HullmapSolid: kind of solid that the part was measured against. With
    /// HULLMAP_SOLID_UNMEASURED, the next three fields are 0 and claim nothing.
    pub solid: u32,
    /// Upper bound on how far a point of the mesh's surface lies outside all of its parts.
    pub uncovered: f64,
    /// Upper bound on how far a point of the part lies outside the mesh's solid.
    pub protrusion: f64,
    /// The point of the part that protrudes most, as far as the bake found.
    pub protrusion_at: DVec3,
    /// Share of the mesh's solid that is in no part, from 0 to 1; -1 if it is not recorded.
    pub voids: f64,
    /// Error of voids, from 0 to 1.
    pub voids_error: f64,
}

/// Kind of a primitive: HullmapReplacement.kind.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PrimitiveKind {
    /// No primitive may replace the hull.
    None = 0,
    /// A cuboid, with three half extents.
    Box = 1,
    /// A ball, with a radius.
    Sphere = 2,
    /// All points within a radius of a segment along z, with half of its length.
    Capsule = 3,
    /// A cylinder along z, with a radius and half of its height.
    Cylinder = 4,
}

impl From<hullmap::PrimitiveKind> for PrimitiveKind {
    fn from(kind: hullmap::PrimitiveKind) -> Self {
        match kind {
            hullmap::PrimitiveKind::Box => Self::Box,
            hullmap::PrimitiveKind::Sphere => Self::Sphere,
            hullmap::PrimitiveKind::Capsule => Self::Capsule,
            hullmap::PrimitiveKind::Cylinder => Self::Cylinder,
        }
    }
}

/// A primitive that may replace a convex part, from hullmap_pack_hull_primitive.
///
/// It contains all of the mesh's surface that is in the part, so the surface stays covered if some
/// or all parts are replaced.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Replacement {
    /// A HullmapPrimitiveKind. With HULLMAP_PRIMITIVE_KIND_NONE, all other fields are 0.
    pub kind: u32,
    /// From the primitive's own axes to the frame of the hull. The origin is its centre; the axis
    /// of capsules and cylinders is z.
    pub pose: Pose,
    /// Box: half of its extent along x, y and z. Sphere: radius. Capsule and cylinder: radius, and
    /// half the length of its axis, without the round ends of a capsule. The others are 0.
    pub sizes: [f64; 3],
    /// Upper bound on how far a point of the primitive lies outside the mesh's solid, a length.
    pub protrusion: f64,
}

/// Mass properties of a rigid body, from hullmap_pack_mass_properties.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct MassProperties {
    /// Mass: density times volume.
    pub mass: f64,
    /// Centre of mass, in the frame of the pack.
    pub center_of_mass: DVec3,
    /// Inertia tensor about the centre of mass, row by row; symmetric.
    pub inertia: [f64; 9],
    /// The solid that these are the properties of.
    pub source: MassSource,
}

/// The arrays of a hull: pointers into the pack, for reading only. They are valid as long as the
/// pack, or a shape made from it, exists. All are aligned to 4 bytes.
///
/// A run of face_vertices or neighbours ends where the next one starts, the last one at the end of
/// the array.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct HullArrays {
    /// Positions: three numbers x, y, z for each vertex.
    pub vertices: *const f32,
    /// For each vertex, its index in the source file; UINT32_MAX for a vertex that the bake
    /// created.
    pub source_vertices: *const u32,
    /// For each vertex, where its run of neighbours starts.
    pub neighbour_starts: *const u32,
    /// Number of vertices.
    pub vertex_count: usize,
    /// Indices of the vertices that share an edge with each vertex, ascending.
    pub neighbours: *const u32,
    /// Length of neighbours.
    pub neighbour_count: usize,
    /// For each face, where its run of face_vertices starts.
    pub face_starts: *const u32,
    /// Number of faces.
    pub face_count: usize,
    /// Indices of the vertices of the faces, counter-clockwise seen from outside.
    pub face_vertices: *const u32,
    /// Length of face_vertices.
    pub face_vertex_count: usize,
}
