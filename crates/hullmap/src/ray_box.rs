//! The part of a ray in a box along the axes: slabs, moved outwards by a margin.
//!
//! # Reference
//! Kay, Kajiya, "Ray Tracing Complex Scenes", 1986.

#![forbid(unsafe_code)]

use glam::DVec3;

/// Relative rounding error of a length along a ray: of a sum, an inverse and a product.
pub(crate) const LENGTH_ERROR: f64 = 4.0 * f64::EPSILON;

#[derive(Clone, Copy, Debug)]
pub(crate) struct BoxedRay {
    pub(crate) origin: DVec3,
    /// Inverses of the components of a unit direction.
    pub(crate) inverse: DVec3,
    /// By how much boxes are grown: more than the rounding error of a coordinate.
    pub(crate) margin: f64,
}

impl BoxedRay {
    /// The part of the ray from `span` that is in a box; `None` if there is none.
    #[inline]
    pub(crate) fn clip(&self, [low, high]: [DVec3; 2], [mut enter, mut leave]: [f64; 2]) -> Option<[f64; 2]> {
        let margin = DVec3::splat(self.margin);
        let p = ((low - margin - self.origin) * self.inverse).to_array();
        let q = ((high + margin - self.origin) * self.inverse).to_array();
        // Along an axis without motion both are infinite, of the same sign outside. A NaN is passed
        // over by `min` and `max`.
        for (p, q) in p.into_iter().zip(q) {
            (enter, leave) = (enter.max(p.min(q)), leave.min(p.max(q)));
        }
        let span = [enter * (1.0 - LENGTH_ERROR), leave * (1.0 + LENGTH_ERROR)];
        (span[0] <= span[1]).then_some(span)
    }
}
