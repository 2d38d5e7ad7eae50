//! Structs and enums of the header: plain numbers, laid out as C does.
//!
//! Documentation comments become comments of the header, so they use C names.

#![forbid(unsafe_code)]

/// Result of a function. Every value except HULLMAP_DECOMPOSE_RESULT_OK is a failure, for which
/// hullmap_decompose_last_error() has a message.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Result {
    /// Success.
    Ok = 0,
    /// A pointer is NULL but must not be.
    Null = 1,
    /// An argument is out of range, not a finite number, misaligned or of an unknown version.
    InvalidArgument = 2,
    /// The mesh has no hull.
    Rejected = 3,
    /// The computation was cancelled.
    Cancelled = 4,
    /// A bug in the library. The call was ended.
    Panic = 5,
}

/// Options of a decomposition. A field that is 0 has its default.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// sizeof(HullmapDecomposeOptions).
    pub struct_size: usize,
    /// Maximum protrusion of a part from the mesh's solid, a length. Default: max_error_share.
    pub max_error: f64,
    /// The same as a share of the diagonal of the box around the mesh. Default: 0.02.
    pub max_error_share: f64,
    /// Maximum number of parts. The search then looks for the smallest error. Default: no maximum.
    pub max_parts: u32,
    /// Maximum number of vertices of a part, at least 4. Default: 64; 255 for a mesh that one part
    /// represents within the maximum error.
    pub max_vertices: u32,
    /// The solid of an open mesh. 1: its inside, after its holes are closed. 2: its walls, so that
    /// openings stay open. Default: open surfaces are walls if half of their area has faces on both
    /// sides, a hole has more than an eighth of it, or all holes together more than all of it;
    /// otherwise their holes are closed. Closed surfaces are solid.
    pub solid: u32,
    /// Thickness of the parts of walls, as a share of the diagonal; at most half of the maximum
    /// error. Default: 0.005.
    pub wall_share: f64,
    /// Time for the decomposition and its bounds, in seconds. Parts may then protrude further, and
    /// depend on the machine. Default: no limit.
    pub seconds: f64,
}

/// A convex part. The arrays belong to the decomposition.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Three coordinates for each vertex, in the frame of the mesh.
    pub vertices: *const f64,
    /// Number of vertices.
    pub vertex_count: u32,
    /// Number of triangles.
    pub triangle_count: u32,
    /// Three indices of vertices for each triangle, counter-clockwise seen from outside.
    pub triangles: *const u32,
    /// Volume.
    pub volume: f64,
    /// Centre of mass.
    pub center: [f64; 3],
    /// Bound on how far a point of the part lies outside the mesh's solid; NaN if it is unknown.
    pub protrusion: f64,
}

/// Facts about a decomposition.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Facts {
    /// sizeof(HullmapDecomposeFacts), written by the caller.
    pub struct_size: usize,
    /// Number of parts.
    pub part_count: usize,
    /// Bound on how far a point of the mesh's surface lies outside all parts; NaN if it is unknown.
    pub uncovered: f64,
    /// Bound on how far a point of a part lies outside the mesh's solid; NaN if it is unknown.
    pub protrusion: f64,
    /// Overlap: the sum of the parts' volumes minus the volume of their union, as a share of the
    /// latter. An estimate; NaN if it is unknown.
    pub overlap: f64,
    /// Mean distance of the parts' visible surface from the mesh's solid. An estimate; NaN if it is
    /// unknown.
    pub mean_protrusion: f64,
    /// Share of the solid's volume that is in no part. An estimate; NaN if the mesh is not
    /// watertight.
    pub voids: f64,
    /// Volume of the solid that the mesh bounds; NaN if the mesh is not watertight. The parts weigh
    /// more, because they protrude and overlap.
    pub volume: f64,
    /// Centre of mass of that solid; NaN if the mesh is not watertight.
    pub center: [f64; 3],
    /// Inertia tensor of that solid about its centre of mass at density 1, row by row; NaN if the
    /// mesh is not watertight.
    pub inertia: [f64; 9],
    /// The solid that the parts were measured against: 1 if the mesh is watertight, 2 if its holes
    /// were closed, 3 for its walls; 0 without triangles.
    pub solid: u32,
}
