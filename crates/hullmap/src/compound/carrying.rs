//! The parts of a compound that can lie on a triangle.
//!
//! A part hides the contacts of another part where it contains their points: it has contacts of its
//! own there. A triangle has no inside, so a part that has passed through has none, and a part that
//! is more than halfway through is pushed out on the other side. They hide nothing.

use super::seams::{Neighbour, Union};
use crate::pose::Pose;
use crate::vector::unit;
use glam::DVec3;

/// A union without the parts that are more than halfway behind the plane of a triangle.
pub(super) struct Carrying<'u> {
    union: &'u dyn Union,
    /// Unit normal of the plane, towards the body, in the frame of the union.
    normal: DVec3,
    height: f64,
}

impl<'u> Carrying<'u> {
    /// `triangle_in_union`: the pose of the triangle's frame in the union. `towards`: a direction
    /// from the triangle to the body, in the triangle's frame. `None` without an area.
    pub(super) fn new(
        union: &'u dyn Union,
        corners: [DVec3; 3],
        towards: DVec3,
        triangle_in_union: Pose,
    ) -> Option<Self> {
        let [a, b, c] = corners.map(|corner| triangle_in_union.transform_point(corner));
        let normal = unit((b - a).cross(c - a))?;
        let is_away = normal.dot(triangle_in_union.transform_vector(towards)) < 0.0;
        let normal = if is_away { -normal } else { normal };
        Some(Self { union, normal, height: a.dot(normal) })
    }

    fn is_behind(&self, near: &Neighbour<'_>) -> bool {
        let dir = near.place.inverse_transform_vector(self.normal);
        let ends = [dir, -dir].map(|dir| near.place.transform_point(near.shape.support_point(dir).point));
        let [above, below] = ends.map(|end| end.dot(self.normal) - self.height);
        above < -below
    }
}

impl Union for Carrying<'_> {
    fn any_near(&self, point: DVec3, reach: f64, test: &mut dyn FnMut(Neighbour<'_>) -> bool) -> bool {
        self.union.any_near(point, reach, &mut |near| !self.is_behind(&near) && test(near))
    }

    fn face_towards(&self, part: usize, dir: DVec3) -> Option<DVec3> {
        self.union.face_towards(part, dir)
    }

    fn faces_near(&self, part: usize, vertex: u32, visit: &mut dyn FnMut(DVec3, DVec3)) {
        self.union.faces_near(part, vertex, visit);
    }
}
