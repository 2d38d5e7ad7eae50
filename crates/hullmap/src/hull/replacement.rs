//! The primitive that may replace a convex part: a box, a sphere, a capsule or a cylinder.

use glam::{DQuat, DVec3};
use hullmap_format::PrimitiveKind;

use super::{Hull, vector};

/// A primitive that may replace a convex part (option `primitives`), in the frame of the hulls.
///
/// It contains all of the source object's surface that is in the part, so the surface stays covered
/// if some or all parts are replaced. It is an alternative for engines that are faster with
/// primitives; hullmap's own queries use the hull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Replacement {
    /// The primitive.
    pub kind: PrimitiveKind,
    /// Its centre.
    pub center: DVec3,
    /// Rotation from its own axes, of unit length. The axis of capsules and cylinders is z.
    pub rotation: DQuat,
    /// Box: half of its extent along x, y and z. Sphere: radius. Capsule and cylinder: radius, and
    /// half the length of its axis, without the round ends of a capsule. The others are 0.
    pub sizes: [f64; 3],
    /// Upper bound on how far a point of it lies outside the source object's solid, a length.
    pub protrusion: f64,
}

impl Hull<'_> {
    /// The primitive that may replace this convex part; `None` if there is none, or the bake did
    /// not look for primitives.
    ///
    /// # Complexity
    /// O(1).
    pub fn primitive(&self) -> Option<Replacement> {
        let record = self.primitive?;
        Some(Replacement {
            // A pack that was opened without checks may state no known kind.
            kind: PrimitiveKind::from_code(record.kind.to_native())?,
            center: vector(&record.center),
            rotation: DQuat::from_array(record.rotation.map(|c| c.to_native())),
            sizes: record.sizes.map(|c| c.to_native()),
            protrusion: record.protrusion.to_native(),
        })
    }
}
