//! The convex pieces of links, as shapes that can be queried.

use glam::DVec3;
use hullmap_planning::Convex;
use hullmap_robot::{Frame, masks_match};

/// A convex piece of a link.
pub struct Piece {
    /// The shape.
    pub shape: Convex,
    /// Its frame in the link's.
    pub in_link: Frame,
    /// `contype` and `conaffinity`.
    pub contact_bits: [i32; 2],
}

impl Piece {
    /// Centre and radius of a ball that holds it, in the frame of the link.
    pub fn ball(&self) -> (DVec3, f64) {
        let shape = self.shape.shape();
        (self.in_link.apply(shape.interior_point()), shape.outer_radius())
    }

    /// Whether MuJoCo lets the two meet.
    pub fn may_meet(&self, other: &Self) -> bool {
        masks_match(self.contact_bits, other.contact_bits)
    }
}
