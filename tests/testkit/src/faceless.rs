//! A shape without faces and without a core, so that the solver takes the general path.

use hullmap::{Shape, SupportMap, SupportPoint, glam::DVec3};

/// A shape whose faces and core are hidden from the solver: contacts come from portal refinement
/// (MPR) and EPA on the shape itself, never from the separating axis test or from the core.
#[derive(Clone, Copy, Debug)]
pub struct Faceless<S>(pub S);

impl<S: SupportMap> SupportMap for Faceless<S> {
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
    fn support_point_from(&self, dir: DVec3, hint: u32) -> SupportPoint {
        self.0.support_point_from(dir, hint)
    }
}

impl<S: SupportMap> Shape for Faceless<S> {}
