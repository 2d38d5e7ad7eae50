//! Lengths that an update of a manifold goes by.

use super::clip::PatchPoint;
use super::select::SLIGHT;

/// Depths that differ by less than this count as equal in any case, relative to the smaller shape's
/// outer radius. Larger than the solver's tolerance on any depth below that radius.
pub(crate) const SAME_DEPTH: f64 = 1e-4;

/// Maximum distance of a point from a surface, relative to the smaller shape's outer radius, beyond
/// the rounding error of coordinates: the slack of clipping.
pub(super) const ON_SURFACE: f64 = 1e-6;

/// Lengths of an update.
pub(super) struct Lengths {
    /// Depth of the contact; negative for a gap.
    pub(super) depth: f64,
    /// Width of the interval of the depth.
    pub(super) width: f64,
    pub(super) prediction: f64,
    /// The smaller outer radius.
    pub(super) reach: f64,
}

impl Lengths {
    /// A height above both surfaces, from the origin of the frame.
    pub(super) fn height_above(&self) -> f64 {
        self.depth.abs() + self.reach
    }

    /// Greatest depth of a point: of the contact, or of its upper bound if the interval is wide.
    pub(super) fn greatest(&self) -> f64 {
        if self.width > ON_SURFACE * self.reach { self.depth + self.width } else { self.depth }
    }

    /// A point that is within the prediction; also one that is beyond it by less than points may be
    /// off, whose surfaces give way by half of that.
    pub(super) fn near_enough(&self, point: PatchPoint) -> Option<PatchPoint> {
        let beyond = (-self.prediction - point.depth()).max(0.0);
        let heights = [point.heights[0] + 0.5 * beyond, point.heights[1] - 0.5 * beyond];
        // NaN takes the failing branch.
        (beyond <= ON_SURFACE * self.reach).then_some(PatchPoint { heights, ..point })
    }

    /// Depths that differ by less than this count as equal.
    pub(super) fn slight(&self) -> f64 {
        (SLIGHT * self.prediction).max(SAME_DEPTH * self.reach)
    }
}
