//! The support mapping: all the solver ever asks of a shape.

use glam::DVec3;

/// Answer of a [`SupportMap`]: a point of the shape that lies farthest in the asked direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// The point, in the shape's local frame.
    pub point: DVec3,
    /// Which feature of the shape it is: the vertex number of a hull. Equal features mean equal points.
    pub feature: u32,
}

/// A convex shape, seen through its support mapping.
///
/// All points, directions and lengths are in the shape's local frame and units.
pub trait SupportMap {
    /// A point of the shape with the greatest dot product with `dir`.
    ///
    /// `dir` need not be of unit length. For a direction that is zero or not finite any point of the
    /// shape may come back; it never panics.
    fn support(&self, dir: DVec3) -> Support;

    /// A point inside the shape, as deep as is known: where the solver starts.
    fn interior_point(&self) -> DVec3;

    /// Radius of a ball around [`interior_point`](Self::interior_point) that lies in the shape; 0 for flat ones.
    fn inner_radius(&self) -> f64;

    /// Radius of a ball around [`interior_point`](Self::interior_point) that holds the shape.
    fn outer_radius(&self) -> f64;

    /// By how much a support point may fall short of the farthest point in the direction asked for, measured along it: a
    /// length, beyond the rounding of one dot product.
    ///
    /// The intervals of [`contact`](crate::contact) and [`distance`](crate::distance) are wider by this. 0, as here, is for
    /// support mappings that are exact but for rounding.
    fn support_error(&self) -> f64 {
        0.0
    }

    /// The point that `feature` of a [`Support`] names; `None` where features are not points, or there is no such one.
    ///
    /// With it, the solver starts from the points of the last query, without asking for them again. It must be a
    /// point of the shape, whatever `feature`.
    fn point(&self, feature: u32) -> Option<DVec3> {
        let _ = feature;
        None
    }

    /// [`support`](Self::support), by way of a feature that may be the answer again. The answer is that of `support`.
    fn support_from(&self, dir: DVec3, hint: u32) -> Support {
        let _ = hint;
        self.support(dir)
    }

    /// Radius r of the ball that the shape's core is rounded by: the shape is the Minkowski sum of both. 0 by default: no core.
    ///
    /// A sphere is a rounded point and a capsule a rounded segment. The queries solve the cores, which takes a few exact
    /// steps where curved shapes would take many, and add the radii; [`solver`](crate::solver) has them as they are.
    fn rounding_radius(&self) -> f64 {
        0.0
    }

    /// Support mapping of the core; that of the shape by default. The core has the shape's
    /// [`interior_point`](Self::interior_point).
    fn core_support(&self, dir: DVec3) -> Support {
        self.support(dir)
    }

    /// Radii of balls around the interior point: one that lies in the core, one that holds it. The shape's by default.
    fn core_radii(&self) -> [f64; 2] {
        [self.inner_radius(), self.outer_radius()]
    }

    /// The [`point`](Self::point) of the core that a feature names; the shape's by default.
    fn core_point(&self, feature: u32) -> Option<DVec3> {
        self.point(feature)
    }
}
