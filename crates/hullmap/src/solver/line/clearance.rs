//! Clearance of a line that pierces a convex set: its distance from the set's border, seen along
//! the line. EPA in the plane, from the corners of a portal.

use super::portal::{LineSearch, Portal};
use crate::polygon;
use crate::support::SupportMap;

/// Support points this many errors beyond an edge or less are on it.
const FLAT_ERRORS: f64 = 4.0;

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> LineSearch<'_, '_, A, B> {
    /// Lower bound of the clearance, at most a little more than `enough`. Not positive if the line
    /// may miss the set.
    pub(super) fn clearance(&mut self, portal: &Portal, enough: f64) -> f64 {
        let noise = self.clip.noise;
        let corners = portal.corners.map(|corner| corner.at.truncate());
        let distance = polygon::expand(corners, |side| {
            if side.distance - noise >= enough {
                return None;
            }
            let new = self.probe(side.outward.extend(0.0)).at.truncate();
            // NaN counts as no gain.
            let is_farther = side.outward.dot(new - side.start) > FLAT_ERRORS * self.clip.error * side.outward.length();
            (is_farther && !self.clip.is_empty()).then_some(new)
        });
        distance.map_or(0.0, |distance| distance - noise)
    }
}
