//! A point of a manifold, and the features that it lies on.

use std::fmt;

use glam::DVec3;

use super::clip::{FACE, Part};

/// The feature of one shape that a manifold point lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FeatureId {
    /// A vertex: its [`Corner::vertex`](crate::Corner::vertex), which for a hull is the vertex
    /// index.
    Vertex(u32),
    /// An edge, by its two vertices in ascending order.
    Edge(u32, u32),
    /// The interior of a face.
    Face,
}

impl FeatureId {
    fn from_part(part: Part) -> Self {
        match part {
            FACE => Self::Face,
            [a, b] if a == b => Self::Vertex(a),
            [a, b] => Self::Edge(a, b),
        }
    }
}

impl fmt::Display for FeatureId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Vertex(vertex) => write!(f, "vertex {vertex}"),
            Self::Edge(start, end) => write!(f, "edge {start}-{end}"),
            Self::Face => f.write_str("face"),
        }
    }
}

/// The pair of features that a manifold point lies on. Equal from frame to frame while the same
/// features meet.
///
/// # Examples
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::manifold::FeatureId;
/// use hullmap::shapes::Cuboid;
/// use hullmap::{Cache, Manifold, ManifoldSettings, Pose};
///
/// let (floor, cube) = (Cuboid::new(DVec3::new(5.0, 5.0, 1.0))?, Cuboid::new(DVec3::ONE)?);
/// let (mut manifold, mut cache) = (Manifold::new(), Cache::new());
/// let b_in_a = Pose::from_translation(DVec3::new(0.0, 0.0, 1.99))?;
/// manifold.update(&floor, &cube, b_in_a, &ManifoldSettings::default(), &mut cache);
/// let id = manifold.points()[0].id;
/// assert_eq!(id.on_a(), FeatureId::Face);
/// assert!(matches!(id.on_b(), FeatureId::Vertex(_)));
/// assert!(id.to_string().starts_with("face to vertex"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PointId {
    pub(super) parts: [Part; 2],
}

impl PointId {
    /// The feature of A.
    pub fn on_a(self) -> FeatureId {
        FeatureId::from_part(self.parts[0])
    }

    /// The feature of B.
    pub fn on_b(self) -> FeatureId {
        FeatureId::from_part(self.parts[1])
    }
}

impl fmt::Display for PointId {
    /// For instance `face to vertex 3`: A's feature, then B's.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} to {}", self.on_a(), self.on_b())
    }
}

/// A point of a [`Manifold`](crate::Manifold). Lengths are in the shapes' units.
///
/// The two points lie on the surfaces, whatever the status of the manifold is: off by at most 2e-6
/// of the smaller shape's outer radius, plus the rounding of coordinates (for curved surfaces also
/// 1e-10 of their own radius). A hull's faces are flat up to the rounding of its vertices to f32.
/// Where points are deeper than the contact, within these bounds, both give way by half of the
/// excess.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldPoint {
    /// The features it lies on.
    pub id: PointId,
    /// The point on A's surface, in A's frame.
    pub point_a: DVec3,
    /// The point on B's surface, in A's frame.
    pub point_b: DVec3,
    /// The point on B's surface, in B's frame.
    pub local_b: DVec3,
    /// Penetration depth at this point along the manifold's normal n, (`point_a` − `point_b`) · n;
    /// negative if the surfaces are separated there, by at most the prediction. At most the depth
    /// of the contact, or its upper bound if the interval is wide.
    pub depth: f64,
    /// Owned by the caller: 0 in a new point and unchanged while the point is kept. Made for the
    /// accumulated impulse along the normal and two tangents, with which the next frame's solver
    /// starts.
    pub impulse: [f64; 3],
    /// Owned by the caller: 0 in a new point and unchanged while the point is kept. For a material,
    /// an event id or an index.
    pub user_data: u64,
    /// Number of earlier updates in which the point was present.
    pub age: u32,
}

impl ManifoldPoint {
    /// Distance from an earlier point: on A or on B, whichever is smaller.
    pub(crate) fn distance(&self, old: &Self) -> f64 {
        self.point_a.distance(old.point_a).min(self.local_b.distance(old.local_b))
    }

    /// Takes over what the caller stored in this point in the last frame.
    pub(crate) fn keep(&mut self, old: &Self) {
        (self.impulse, self.user_data) = (old.impulse, old.user_data);
        self.age = old.age.saturating_add(1);
    }

    /// Fills unused places.
    pub(crate) const EMPTY: Self = Self {
        id: PointId { parts: [FACE; 2] },
        point_a: DVec3::ZERO,
        point_b: DVec3::ZERO,
        local_b: DVec3::ZERO,
        depth: 0.0,
        impulse: [0.0; 3],
        user_data: 0,
        age: 0,
    };
}
