//! Structs and enums of the header: plain numbers, laid out as C does.
//!
//! Documentation comments become comments of the header, so they speak of C names.

#![forbid(unsafe_code)]

use hullmap::glam::DVec3;

/// Number of the binary interface. A program compares it with hullmap_abi_version() if it loads the
/// library at run time.
pub const ABI_VERSION: u32 = 1;

/// Open a file by mapping it instead of copying it. No process may write to the file or truncate it
/// while the pack or a shape made from it exists; replacing it by renaming is allowed. If this rule
/// is broken, answers are wrong, or the process is ended by SIGBUS.
pub const OPEN_MAP: u32 = 1;

/// Use the caller's memory in place instead of copying it.
pub const OPEN_BORROW: u32 = 2;

/// Check the header, the length and the structure, but not the checksum and the contents. For files
/// that have passed the full check before. If the file is damaged, answers may be wrong, and
/// queries may return HULLMAP_RESULT_PANIC; they never read out of bounds.
pub const OPEN_SKIP_CONTENTS: u32 = 4;

/// Result of a function. Every value except HULLMAP_RESULT_OK is a failure, for which
/// hullmap_last_error() has a message.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Result {
    /// Success.
    Ok = 0,
    /// A pointer is NULL but must not be.
    Null = 1,
    /// An argument is out of range, not a finite number, misaligned or of an unknown version.
    InvalidArgument = 2,
    /// The pack has no hull of this index or name.
    NotFound = 3,
    /// The file cannot be read.
    Io = 4,
    /// The file or the memory is not a sound pack that this version reads.
    InvalidPack = 5,
    /// The query does not exist for shapes of this kind.
    Unsupported = 6,
    /// A cache or manifold is in use by another call, or was passed twice to a batch.
    Busy = 7,
    /// A bug in the library. The call was ended; caches and manifolds in it were emptied.
    Panic = 8,
}

/// How a query ended, and thus how narrow its interval is. The interval contains the true value
/// whatever the status is.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The interval is as narrow as rounding error allows.
    Exact = 0,
    /// The interval is within the tolerance.
    Within = 1,
    /// The shapes touch: any gap or penetration is below rounding error.
    Touching = 2,
    /// The shapes overlap.
    Overlapping = 3,
    /// The shapes are certainly separated; of a ray or a cast: certainly no hit.
    Separated = 4,
    /// The iteration limit was reached; the interval is wider than the tolerance.
    IterationLimit = 5,
    /// Rounding error stopped all progress; the interval is wider than the tolerance.
    Stalled = 6,
}

impl From<hullmap::Status> for Status {
    fn from(status: hullmap::Status) -> Self {
        match status {
            hullmap::Status::Exact => Self::Exact,
            hullmap::Status::Within => Self::Within,
            hullmap::Status::Touching => Self::Touching,
            hullmap::Status::Overlapping => Self::Overlapping,
            hullmap::Status::Separated => Self::Separated,
            hullmap::Status::IterationLimit => Self::IterationLimit,
            hullmap::Status::Stalled => Self::Stalled,
        }
    }
}

/// Whether two shapes share a point.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlap {
    /// They share no point: a separating plane proves it.
    Separated = 0,
    /// Their interiors share points.
    Overlapping = 1,
    /// They touch: any gap or penetration is below rounding error.
    Touching = 2,
    /// Not known: an iteration limit was reached, or rounding error stopped all progress.
    Undecided = 3,
}

impl From<hullmap::Overlap> for Overlap {
    fn from(overlap: hullmap::Overlap) -> Self {
        match overlap {
            hullmap::Overlap::Separated => Self::Separated,
            hullmap::Overlap::Overlapping => Self::Overlapping,
            hullmap::Overlap::Touching => Self::Touching,
            hullmap::Overlap::Undecided => Self::Undecided,
        }
    }
}

/// Unit of HullmapManifoldSettings.prediction.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prediction {
    /// A fraction of the outer radius of the smaller shape.
    Relative = 0,
    /// A length in the shapes' unit.
    Length = 1,
}

/// Kind of solid that convex parts were measured against: HullmapHullFacts.solid.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solid {
    /// The hull was not measured: it is not a part, or its mesh was not known.
    Unmeasured = 0,
    /// The mesh is closed.
    Watertight = 1,
    /// The mesh has holes, which were closed.
    Closed = 2,
    /// The mesh has no inside.
    Sheet = 3,
}

impl From<Option<hullmap::SolidKind>> for Solid {
    fn from(kind: Option<hullmap::SolidKind>) -> Self {
        match kind {
            None => Self::Unmeasured,
            Some(hullmap::SolidKind::Watertight) => Self::Watertight,
            Some(hullmap::SolidKind::Closed) => Self::Closed,
            Some(hullmap::SolidKind::Sheet) => Self::Sheet,
        }
    }
}

/// Kind of feature that a manifold point lies on.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeatureKind {
    /// The interior of a face.
    Face = 0,
    /// An edge: two vertices in ascending order.
    Edge = 1,
    /// A vertex.
    Vertex = 2,
}

/// A point, a direction or a velocity.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec3 {
    /// First coordinate.
    pub x: f64,
    /// Second coordinate.
    pub y: f64,
    /// Third coordinate.
    pub z: f64,
}

impl From<DVec3> for Vec3 {
    #[inline(always)]
    fn from(v: DVec3) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl From<Vec3> for DVec3 {
    #[inline(always)]
    fn from(v: Vec3) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

/// A rotation. Any length but zero: it is normalised by each query. The identity is (0, 0, 0, 1).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quat {
    /// Vector part.
    pub x: f64,
    /// Vector part.
    pub y: f64,
    /// Vector part.
    pub z: f64,
    /// Scalar part.
    pub w: f64,
}

/// A rigid motion: rotate, then translate. `b_in_a` maps points of B's frame into A's frame. From
/// the poses of both in a world, hullmap_pose_relative() computes it. A component of the
/// translation is at most 3.4e38.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Where B's origin is in A's frame.
    pub translation: Vec3,
    /// Rotation of B in A's frame.
    pub rotation: Quat,
}

/// An axis-aligned box.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounds {
    /// Minimum of each coordinate.
    pub min: Vec3,
    /// Maximum of each coordinate.
    pub max: Vec3,
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
    pub centroid: Vec3,
    /// Inertia tensor about the centroid at density 1, row by row; symmetric. For a density d or a
    /// mass m, multiply it by d, or by m / volume.
    pub inertia: [f64; 9],
    /// Box around the vertices.
    pub bounds: Bounds,
    /// Maximum distance between two vertices.
    pub diameter: f64,
    /// A point in the hull, far from its surface.
    pub interior_point: Vec3,
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
    pub origin: Vec3,
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
    pub protrusion_at: Vec3,
    /// Share of the mesh's solid that is in no part, from 0 to 1; -1 if it is not recorded.
    pub voids: f64,
    /// Error of voids, from 0 to 1.
    pub voids_error: f64,
}

/// The solid that mass properties describe: HullmapMassProperties.source.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MassSource {
    /// The hulls. Parts of a mesh overlap, so their mass is too large, up to about twice.
    Hulls = 0,
    /// The mesh that the hulls were baked from.
    Mesh = 1,
}

impl From<hullmap::MassSource> for MassSource {
    fn from(source: hullmap::MassSource) -> Self {
        match source {
            hullmap::MassSource::Hulls => Self::Hulls,
            hullmap::MassSource::Mesh => Self::Mesh,
        }
    }
}

/// Mass properties of a rigid body, from hullmap_pack_mass_properties.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct MassProperties {
    /// Mass: density times volume.
    pub mass: f64,
    /// Centre of mass, in the frame of the pack.
    pub center_of_mass: Vec3,
    /// Inertia tensor about the centre of mass, row by row; symmetric.
    pub inertia: [f64; 9],
    /// A HullmapMassSource.
    pub source: u32,
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

/// Accuracy and effort of a distance, contact or signed distance. Start from
/// HULLMAP_SETTINGS_DEFAULT.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// sizeof(HullmapSettings)
    pub struct_size: usize,
    /// Maximum width of the interval, relative to its upper bound. The default is 1e-5. NaN and
    /// negative values count as 0: as narrow as rounding error allows.
    pub tolerance: f64,
    /// Maximum number of steps of the last phase. The default is 1000.
    pub max_iterations: u32,
}

/// Limits and accuracy of a ray or a cast. Start from HULLMAP_CAST_SETTINGS_DEFAULT.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CastSettings {
    /// sizeof(HullmapCastSettings)
    pub struct_size: usize,
    /// Maximum t, in the unit of the ray or the motion. The default is infinite. NaN and negative
    /// values count as 0.
    pub max_t: f64,
    /// Maximum width of the interval as a length along the way, relative to the outer radius of the
    /// shape, or to the sum of both radii. The default is 1e-6.
    pub tolerance: f64,
    /// Maximum number of steps. The default is 1000.
    pub max_iterations: u32,
}

/// Settings of a contact manifold. Start from HULLMAP_MANIFOLD_SETTINGS_DEFAULT.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldSettings {
    /// sizeof(HullmapManifoldSettings)
    pub struct_size: usize,
    /// As in HullmapSettings.
    pub tolerance: f64,
    /// As in HullmapSettings.
    pub max_iterations: u32,
    /// A HullmapPrediction: the unit of prediction. The default is HULLMAP_PREDICTION_RELATIVE.
    pub prediction_kind: u32,
    /// How far two surfaces may be separated and still have points, of negative depth. The default
    /// is 0.02. NaN and negative values count as 0.
    pub prediction: f64,
}

/// What an edge of a triangle of a mesh is, seen from the front: HullmapMeshTriangle.edge_classes.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeClass {
    /// No other triangle has the edge.
    Border = 0,
    /// The neighbour continues in the same plane.
    Flat = 1,
    /// A ridge.
    Convex = 2,
    /// A valley.
    Concave = 3,
    /// More than two triangles have the edge.
    NonManifold = 4,
    /// The neighbour has the other side in front.
    Reversed = 5,
}

impl From<hullmap::EdgeClass> for EdgeClass {
    fn from(class: hullmap::EdgeClass) -> Self {
        match class {
            hullmap::EdgeClass::Border => Self::Border,
            hullmap::EdgeClass::Flat => Self::Flat,
            hullmap::EdgeClass::Convex => Self::Convex,
            hullmap::EdgeClass::Concave => Self::Concave,
            hullmap::EdgeClass::NonManifold => Self::NonManifold,
            hullmap::EdgeClass::Reversed => Self::Reversed,
        }
    }
}

/// A triangle of a mesh. Edge i goes from corner i to the next one.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshTriangle {
    /// Its corners, counter-clockwise seen from the front.
    pub corners: [Vec3; 3],
    /// Indices of the corners among the vertices of the mesh.
    pub vertices: [u32; 3],
    /// The triangles beyond its edges; UINT32_MAX where there is none, or more than one.
    pub neighbours: [u32; 3],
    /// Classes of its edges: a HullmapEdgeClass each.
    pub edge_classes: [u32; 3],
    /// Its index in the mesh that was baked.
    pub source_triangle: u32,
    /// Its material; 0 without one.
    pub material: u32,
}

impl MeshTriangle {
    pub(crate) fn of(mesh: &hullmap::TriangleMesh, index: usize) -> Option<Self> {
        Some(Self {
            corners: mesh.triangle(index)?.corners().map(Into::into),
            vertices: mesh.corners(index)?,
            neighbours: mesh.neighbours(index)?.map(|neighbour| neighbour.unwrap_or(u32::MAX)),
            edge_classes: mesh.edge_classes(index)?.map(|class| EdgeClass::from(class) as u32),
            source_triangle: mesh.source_triangle(index)?,
            material: u32::from(mesh.material(index)?),
        })
    }
}

/// A support point.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Support {
    /// A point of the shape with the maximum dot product with the direction.
    pub point: Vec3,
    /// On a hull, the index of the vertex.
    pub feature: u32,
}

impl From<hullmap::SupportPoint> for Support {
    fn from(found: hullmap::SupportPoint) -> Self {
        Self { point: found.point.into(), feature: found.feature }
    }
}

/// Whether two shapes share a point.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersection {
    /// True unless the shapes are certainly separated.
    pub hit: bool,
    /// The answer.
    pub status: Overlap,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull_a: u32,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull_b: u32,
    /// Number of steps.
    pub iterations: u32,
    /// Number of support calls. One call queries both shapes once.
    pub support_calls: u32,
}

impl Intersection {
    #[inline(always)]
    pub(crate) fn new(found: hullmap::Intersection, hulls: [usize; 2]) -> Self {
        let [hull_a, hull_b] = hulls.map(|hull| hull as u32);
        let hullmap::Intersection { status, iterations, support_calls } = found;
        Self { hit: found.is_hit(), status: status.into(), hull_a, hull_b, iterations, support_calls }
    }
}

/// Distance of two shapes. Points and normal are in A's frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// How the query ended. HULLMAP_STATUS_OVERLAPPING: the distance is 0.
    pub status: Status,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull_a: u32,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull_b: u32,
    /// Number of steps.
    pub iterations: u32,
    /// Number of support calls.
    pub support_calls: u32,
    /// Length of the segment from point_a to point_b; 0 if the shapes overlap or touch.
    pub distance: f64,
    /// Lower bound of the distance, at least 0.
    pub lower: f64,
    /// Upper bound of the distance.
    pub upper: f64,
    /// Unit vector from A to B: the normal of the planes that prove the lower bound. Any unit
    /// vector if the shapes overlap.
    pub normal: Vec3,
    /// The point of A closest to B; if they overlap, a common point.
    pub point_a: Vec3,
    /// The point of B closest to A; if they overlap, a common point.
    pub point_b: Vec3,
}

impl Distance {
    #[inline(always)]
    pub(crate) fn new(found: hullmap::Distance, hulls: [usize; 2]) -> Self {
        let [hull_a, hull_b] = hulls.map(|hull| hull as u32);
        Self {
            status: found.status.into(),
            hull_a,
            hull_b,
            iterations: found.iterations,
            support_calls: found.support_calls,
            distance: found.distance,
            lower: found.lower,
            upper: found.upper,
            normal: found.normal.into(),
            point_a: found.point_a.into(),
            point_b: found.point_b.into(),
        }
    }
}

/// Contact of two shapes. Points and normal are in A's frame. For compounds, it is the deepest
/// contact of two hulls.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// False only if the shapes are certainly separated.
    pub hit: bool,
    /// How the query ended. HULLMAP_STATUS_SEPARATED: no contact.
    pub status: Status,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull_a: u32,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull_b: u32,
    /// Number of steps.
    pub iterations: u32,
    /// Number of support calls.
    pub support_calls: u32,
    /// Penetration depth: moving B by it along the normal makes the shapes touch. 0 if they are
    /// separated or touch.
    pub depth: f64,
    /// Lower bound of the depth, at least 0.
    pub depth_lower: f64,
    /// Upper bound of the depth.
    pub depth_upper: f64,
    /// Unit vector from A to B. For separated convex shapes, a separating axis. For separated
    /// compounds, normal, points and counts are 0.
    pub normal: Vec3,
    /// The point of A that is deepest in B; if they are separated, some point of A.
    pub point_a: Vec3,
    /// The point of B that is deepest in A; if they are separated, some point of B.
    pub point_b: Vec3,
}

impl Contact {
    #[inline(always)]
    pub(crate) fn new(found: hullmap::Contact, hulls: [usize; 2]) -> Self {
        let [hull_a, hull_b] = hulls.map(|hull| hull as u32);
        Self {
            hit: found.hit,
            status: found.status.into(),
            hull_a,
            hull_b,
            iterations: found.iterations,
            support_calls: found.support_calls,
            depth: found.depth,
            depth_lower: found.depth_lower,
            depth_upper: found.depth_upper,
            normal: found.normal.into(),
            point_a: found.point_a.into(),
            point_b: found.point_b.into(),
        }
    }

    /// The answer for compounds of which no two parts touch.
    pub(crate) fn separated() -> Self {
        let [normal, point_a, point_b] = [DVec3::ZERO; 3];
        let (hit, status, depth_upper) = (false, hullmap::Status::Separated, 0.0);
        let none = hullmap::Contact { hit, status, depth_upper, normal, point_a, point_b, ..Default::default() };
        Self::new(none, [0, 0])
    }
}

/// Where a ray first enters a shape. Point and normal are in the shape's frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// False only if the ray certainly misses the shape up to max_t.
    pub hit: bool,
    /// How the query ended. HULLMAP_STATUS_OVERLAPPING: the origin is inside the shape.
    pub status: Status,
    /// For a compound, the hull that is hit; otherwise 0.
    pub hull: u32,
    /// Number of steps.
    pub iterations: u32,
    /// Number of support calls.
    pub support_calls: u32,
    /// The ray enters at origin + t direction; infinite if there is no hit.
    pub t: f64,
    /// Lower bound of t, at least 0.
    pub t_lower: f64,
    /// Upper bound of t. It may exceed max_t if the interval does.
    pub t_upper: f64,
    /// The point at t; the origin if there is no hit.
    pub point: Vec3,
    /// Unit outward normal where the ray enters.
    pub normal: Vec3,
}

impl RayHit {
    pub(crate) fn new(found: hullmap::RayHit, hull: usize) -> Self {
        Self {
            hit: found.hit,
            status: found.status.into(),
            hull: hull as u32,
            iterations: found.iterations,
            support_calls: found.support_calls,
            t: found.t,
            t_lower: found.t_lower,
            t_upper: found.t_upper,
            point: found.point.into(),
            normal: found.normal.into(),
        }
    }
}

/// When and where a moving shape B first meets A. Points and normal are in A's frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// False only if the shapes certainly do not meet up to max_t.
    pub hit: bool,
    /// How the query ended. HULLMAP_STATUS_OVERLAPPING: the shapes overlap at the start.
    pub status: Status,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull_a: u32,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull_b: u32,
    /// Number of steps.
    pub iterations: u32,
    /// Number of support calls.
    pub support_calls: u32,
    /// Time of impact, in the unit that the velocity implies; infinite if there is no hit.
    pub t: f64,
    /// Lower bound of the time, at least 0.
    pub t_lower: f64,
    /// Upper bound of the time. It may exceed max_t if the interval does.
    pub t_upper: f64,
    /// Unit vector from A to B where they meet.
    pub normal: Vec3,
    /// Point of A at which the shapes meet; zero if there is no hit.
    pub point_a: Vec3,
    /// Point of B at which the shapes meet, at time t.
    pub point_b: Vec3,
}

impl Impact {
    pub(crate) fn new(found: hullmap::Impact, hulls: [usize; 2]) -> Self {
        let [hull_a, hull_b] = hulls.map(|hull| hull as u32);
        Self {
            hit: found.hit,
            status: found.status.into(),
            hull_a,
            hull_b,
            iterations: found.iterations,
            support_calls: found.support_calls,
            t: found.t,
            t_lower: found.t_lower,
            t_upper: found.t_upper,
            normal: found.normal.into(),
            point_a: found.point_a.into(),
            point_b: found.point_b.into(),
        }
    }
}

/// Signed distance of a point from the surface of a shape, in the shape's frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignedDistance {
    /// How the query ended.
    pub status: Status,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull: u32,
    /// Number of steps.
    pub iterations: u32,
    /// Number of support calls.
    pub support_calls: u32,
    /// Distance from the surface: positive outside, negative inside.
    pub distance: f64,
    /// Lower bound of the distance.
    pub lower: f64,
    /// Upper bound of the distance.
    pub upper: f64,
    /// The point of the surface closest to the query point.
    pub point: Vec3,
    /// Unit outward normal of the surface at that point.
    pub normal: Vec3,
}

impl SignedDistance {
    pub(crate) fn new(found: hullmap::SignedDistance, hull: usize) -> Self {
        Self {
            status: found.status.into(),
            hull: hull as u32,
            iterations: found.iterations,
            support_calls: found.support_calls,
            distance: found.distance,
            lower: found.lower,
            upper: found.upper,
            point: found.point.into(),
            normal: found.normal.into(),
        }
    }
}

/// The feature of a shape that a manifold point lies on.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feature {
    /// Kind of the feature.
    pub kind: FeatureKind,
    /// One vertex, twice, or the two vertices of an edge. On a hull, their indices. 0 for a face.
    pub vertices: [u32; 2],
}

impl From<hullmap::manifold::FeatureId> for Feature {
    fn from(id: hullmap::manifold::FeatureId) -> Self {
        use hullmap::manifold::FeatureId;
        match id {
            FeatureId::Face => Self { kind: FeatureKind::Face, vertices: [0; 2] },
            FeatureId::Edge(v, w) => Self { kind: FeatureKind::Edge, vertices: [v, w] },
            FeatureId::Vertex(v) => Self { kind: FeatureKind::Vertex, vertices: [v; 2] },
        }
    }
}

/// A point of a manifold. Points and normal are in A's frame unless stated otherwise.
///
/// The caller may write impulse and user_data: the next update keeps them if it keeps the point.
/// Changes to other fields are ignored.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldPoint {
    /// Unit vector from A to B; the same for all points of a pair of hulls.
    pub normal: Vec3,
    /// The point on A.
    pub point_a: Vec3,
    /// The point on B.
    pub point_b: Vec3,
    /// The point on B, in B's frame.
    pub local_b: Vec3,
    /// Penetration depth at this point; negative if the surfaces are separated there.
    pub depth: f64,
    /// Owned by the caller; 0 in a new point. For the accumulated impulse along the normal and two
    /// tangents.
    pub impulse: [f64; 3],
    /// Owned by the caller; 0 in a new point.
    pub user_data: u64,
    /// Number of earlier updates in which the point was present.
    pub age: u32,
    /// For a compound, the hull of A; otherwise 0.
    pub hull_a: u32,
    /// For a compound, the hull of B; otherwise 0.
    pub hull_b: u32,
    /// The feature of A.
    pub feature_a: Feature,
    /// The feature of B.
    pub feature_b: Feature,
}

/// The points of a manifold after an update, and what the update cost.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ManifoldPoints {
    /// The points: memory of the manifold, valid until its next update, until it is cleared, or
    /// until it is freed. Never NULL.
    pub points: *mut ManifoldPoint,
    /// Number of points: at most 4 for each pair of hulls.
    pub count: usize,
    /// Number of pairs of hulls with points.
    pub touching: u32,
    /// Number of pairs of hulls that touch but have no points, because the manifold has no room for
    /// more pairs.
    pub dropped: u32,
    /// Number of pairs of hulls queried.
    pub pairs: u32,
    /// Number of steps.
    pub iterations: u32,
    /// Number of support calls.
    pub support_calls: u32,
}
