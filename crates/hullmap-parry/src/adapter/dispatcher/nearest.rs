//! The contact of a pair, or its closest points if it has none.

use hullmap::glam::DVec3;
use hullmap::{Cache, Settings};

use super::pair::{HullPair, Placement, on_pair};

/// Deepest or closest points of a pair, in A's frame. The normal has unit length.
pub(super) struct Nearest {
    pub(super) point_a: DVec3,
    pub(super) point_b: DVec3,
    /// From A to B.
    pub(super) normal: DVec3,
    /// Negative if the shapes overlap.
    pub(super) dist: f64,
}

pub(super) fn contact_of(pair: &HullPair<'_>, placement: &Placement, settings: &Settings) -> Nearest {
    let cache = &mut Cache::new();
    let found = on_pair!(*pair, a, b => hullmap::contact(a, b, placement.b_in_a, settings, cache));
    if found.hit {
        let (point_a, point_b) = (found.point_a, found.point_b);
        return Nearest { point_a, point_b, normal: found.normal, dist: -found.depth };
    }
    let gap = on_pair!(*pair, a, b => hullmap::distance(a, b, placement.b_in_a, settings, cache));
    Nearest { point_a: gap.point_a, point_b: gap.point_b, normal: gap.normal, dist: gap.distance }
}
