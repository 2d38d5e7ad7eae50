use glam::DVec3;
use hullmap_planning::Convex;
use hullmap_robot::{Frame, masks_match};

pub struct Piece {
    pub shape: Convex,
    pub in_link: Frame,
    /// `contype` and `conaffinity`.
    pub contact_bits: [i32; 2],
}

impl Piece {
    pub fn ball(&self) -> (DVec3, f64) {
        let shape = self.shape.shape();
        (self.in_link.apply(shape.interior_point()), shape.outer_radius())
    }

    pub fn may_meet(&self, other: &Self) -> bool {
        masks_match(self.contact_bits, other.contact_bits)
    }
}
