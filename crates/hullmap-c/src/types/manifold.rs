//! Points of contact manifolds.

use hullmap::Status;
use hullmap::glam::DVec3;

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

/// A point of a manifold. Points and normal are in A's frame unless stated otherwise. Both points
/// are on the surfaces, and separated by at most the prediction.
///
/// The caller may write impulse and user_data: the next update keeps them if it keeps the point.
/// Changes to other fields are ignored.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldPoint {
    /// Unit vector from A to B; the same for all points of a pair of hulls.
    pub normal: DVec3,
    /// The point on A.
    pub point_a: DVec3,
    /// The point on B.
    pub point_b: DVec3,
    /// The point on B, in B's frame.
    pub local_b: DVec3,
    /// Penetration depth at this point; negative if the surfaces are separated there.
    pub depth: f64,
    /// Owned by the caller; 0 in a new point. For the accumulated impulse along the normal and two
    /// tangents.
    pub impulse: [f64; 3],
    /// Owned by the caller; 0 in a new point.
    pub user_data: u64,
    /// Number of earlier updates in which the point was present.
    pub age: u32,
    /// The parts of A and of B that touch, as in HullmapContact.
    pub parts: [u32; 2],
    /// The feature of A.
    pub feature_a: Feature,
    /// The feature of B.
    pub feature_b: Feature,
    /// How the query ended that found the normal; the same for all points of a pair of hulls.
    pub status: Status,
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
