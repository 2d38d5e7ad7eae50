//! A hull as a shape without faces, so that the solver takes the general path.

use hullmap::{Hull, Shape, SupportMap, SupportPoint, glam::DVec3};

/// A hull whose faces are hidden from the solver: contacts come from portal refinement (MPR) and
/// EPA, never from the separating axis test.
#[derive(Clone, Copy, Debug)]
pub struct Faceless<'a>(pub Hull<'a>);

impl SupportMap for Faceless<'_> {
    #[inline(always)]
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        self.0.support_point(dir)
    }
    fn interior_point(&self) -> DVec3 {
        self.0.interior_point()
    }
    fn inner_radius(&self) -> f64 {
        self.0.inner_radius()
    }
    fn outer_radius(&self) -> f64 {
        self.0.outer_radius()
    }
    fn support_error(&self) -> f64 {
        self.0.support_error()
    }
    fn point(&self, feature: u32) -> Option<DVec3> {
        self.0.point(feature)
    }
}

impl Shape for Faceless<'_> {}
