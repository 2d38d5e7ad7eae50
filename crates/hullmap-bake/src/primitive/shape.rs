//! Boxes, spheres, capsules and cylinders: which points they hold, and how far they reach.

use glam::{DQuat, DVec3};
use hullmap_format::PrimitiveKind;

/// A box, a sphere, a capsule or a cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primitive {
    /// Its kind.
    pub kind: PrimitiveKind,
    /// Its centre.
    pub center: DVec3,
    /// Rotation from its own axes: a unit quaternion. The axis of capsules and cylinders is z.
    pub rotation: DQuat,
    /// Box: half of its extent along x, y and z. Sphere: radius. Capsule and cylinder: radius, and
    /// half the length of its axis, without the ends of the capsule. The others are 0.
    pub sizes: [f64; 3],
}

impl Primitive {
    /// A point in the axes of the primitive, from its centre.
    pub fn local(&self, p: DVec3) -> DVec3 {
        self.rotation.inverse() * (p - self.center)
    }

    /// Whether a point is at most `slack` outside.
    pub fn holds(&self, p: DVec3, slack: f64) -> bool {
        let ([a, b, c], p) = (self.sizes, self.local(p));
        let from_axis = p.truncate().length();
        match self.kind {
            PrimitiveKind::Box => p.abs().cmple(DVec3::new(a, b, c) + slack).all(),
            PrimitiveKind::Sphere => p.length() <= a + slack,
            PrimitiveKind::Capsule => (p - DVec3::Z * p.z.clamp(-b, b)).length() <= a + slack,
            PrimitiveKind::Cylinder => from_axis <= a + slack && p.z.abs() <= b + slack,
        }
    }

    /// The greatest height of its points above the plane through its centre with this unit normal.
    pub fn reach(&self, normal: DVec3) -> f64 {
        let ([a, b, c], n) = (self.sizes, self.rotation.inverse() * normal);
        match self.kind {
            PrimitiveKind::Box => n.abs().dot(DVec3::new(a, b, c)),
            PrimitiveKind::Sphere => a,
            PrimitiveKind::Capsule => a + b * n.z.abs(),
            PrimitiveKind::Cylinder => a * n.truncate().length() + b * n.z.abs(),
        }
    }

    /// Its volume.
    pub fn volume(&self) -> f64 {
        let [a, b, c] = self.sizes;
        let pi = std::f64::consts::PI;
        match self.kind {
            PrimitiveKind::Box => 8.0 * a * b * c,
            PrimitiveKind::Sphere => 4.0 / 3.0 * pi * a.powi(3),
            PrimitiveKind::Capsule => pi * a * a * (4.0 / 3.0 * a + 2.0 * b),
            PrimitiveKind::Cylinder => pi * a * a * 2.0 * b,
        }
    }
}
