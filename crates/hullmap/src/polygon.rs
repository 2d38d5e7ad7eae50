//! The expanding polytope algorithm in the plane: a convex polygon of support points grows across
//! the side that is nearest to the origin.
//!
//! # Reference
//! van den Bergen 2001, one dimension lower.
//!
//! # Steps
//! 1. Take the side nearest to the origin. Its distance bounds the clearance of the origin from the
//!    border of the set from below.
//! 2. Ask for a support point across that side. Insert it, remove neighbours that are no longer
//!    corners, and repeat from step 1.

#![forbid(unsafe_code)]

use arrayvec::ArrayVec;
use glam::DVec2;

/// Maximum number of corners. 3 to 6 are common.
const MAX_CORNERS: usize = 24;

#[derive(Clone, Copy, Debug)]
pub(crate) struct PolygonSide {
    /// The corner from which it starts.
    pub(crate) start: DVec2,
    /// Normal that points out of the polygon, as long as the side.
    pub(crate) outward: DVec2,
    /// Distance of the origin from the side's line: positive inside.
    pub(crate) distance: f64,
}

/// Distance of the origin from the line through `a` and `b`: positive on its left. 0 if the corners
/// coincide.
pub(crate) fn edge_distance(a: DVec2, b: DVec2) -> f64 {
    let distance = a.perp_dot(b) / (b - a).length();
    if distance.is_nan() { 0.0 } else { distance }
}

/// Expands a triangle, counter-clockwise, by the corners that `next` returns for the nearest side,
/// until it returns `None` or one that is not beyond the side, or the polygon is full. Returns the
/// distance of the origin from the nearest side, which is negative outside; `None` if all corners
/// coincide.
pub(crate) fn expand(corners: [DVec2; 3], mut next: impl FnMut(&PolygonSide) -> Option<DVec2>) -> Option<f64> {
    let mut polygon: ArrayVec<DVec2, MAX_CORNERS> = corners.into_iter().collect();
    loop {
        let (index, side) = nearest_side(&polygon)?;
        let corner = if polygon.is_full() { None } else { next(&side) };
        // NaN is not beyond the side.
        let is_beyond = |corner: &DVec2| side.outward.dot(*corner - side.start) > 0.0;
        let Some(corner) = corner.filter(is_beyond) else { return Some(side.distance) };
        polygon.insert(index + 1, corner);
        remove_dents(&mut polygon, index + 1);
    }
}

#[expect(clippy::indexing_slicing, reason = "the index is taken modulo the number of corners")]
fn nearest_side(polygon: &[DVec2]) -> Option<(usize, PolygonSide)> {
    let mut nearest: Option<(usize, PolygonSide)> = None;
    for (index, &start) in polygon.iter().enumerate() {
        let end = polygon[(index + 1) % polygon.len()];
        let distance = edge_distance(start, end);
        // A side without length bounds nothing.
        if start != end && nearest.is_none_or(|(_, side)| distance < side.distance) {
            let outward = DVec2::new(end.y - start.y, start.x - end.x);
            nearest = Some((index, PolygonSide { start, outward, distance }));
        }
    }
    nearest
}

/// Removes the neighbours of the new corner that are no longer corners. If one corner of the first
/// triangle is no support point, at most this corner is removed.
#[expect(clippy::indexing_slicing, reason = "indices are taken modulo the number of corners")]
fn remove_dents(polygon: &mut ArrayVec<DVec2, MAX_CORNERS>, new: usize) {
    let count = polygon.len();
    let [before, after] = [(new + count - 1) % count, (new + 1) % count];
    for at in [before.max(after), before.min(after)] {
        let count = polygon.len();
        let [previous, next] = [(at + count - 1) % count, (at + 1) % count];
        let is_corner = (polygon[at] - polygon[previous]).perp_dot(polygon[next] - polygon[at]) > 0.0;
        if count > 3 && !is_corner {
            polygon.remove(at);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Expands to the border of the disc around `centre`, while the gain is more than `flat`.
    fn expand_in_disc(corners: [DVec2; 3], centre: DVec2, flat: f64) -> (Option<f64>, u32) {
        let mut calls = 0;
        let found = expand(corners, |side| {
            calls += 1;
            let outward = side.outward.normalize();
            let corner = centre + outward;
            (outward.dot(corner - side.start) > flat).then_some(corner)
        });
        (found, calls)
    }

    #[test]
    fn distance_bounds_the_clearance_in_a_disc_from_below() {
        let thirds = [0.0, 2.1, 4.2].map(DVec2::from_angle);
        for (x, y) in [(0.0, 0.0), (0.3, -0.2), (0.9, 0.1), (-0.5, 0.8)] {
            let centre = DVec2::new(x, y);
            let (found, calls) = expand_in_disc(thirds.map(|corner| centre + corner), centre, 1e-3);
            let clearance = 1.0 - centre.length();
            let found = found.expect("the corners are apart");
            assert!(found <= clearance + 1e-12 && found > clearance - 0.05, "{found} for {clearance}");
            assert!(calls <= 22, "{calls} calls");
        }
    }

    #[test]
    fn origin_outside_has_a_negative_distance() {
        let corners = [DVec2::new(1.0, 1.0), DVec2::new(3.0, 1.0), DVec2::new(2.0, 2.0)];
        assert_eq!(expand(corners, |_| None), Some(-1.0));
    }

    #[test]
    fn corner_that_is_inside_afterwards_is_removed() {
        // The corner left of the origin is no support point of the square.
        let corners = [DVec2::new(1.0, -1.0), DVec2::new(1.0, 1.0), DVec2::new(-0.1, 0.0)];
        let found = expand(corners, |side| Some(DVec2::ONE.copysign(side.outward)));
        assert!(found.is_some_and(|distance| (distance - 1.0).abs() < 1e-12), "{found:?}");
    }

    #[test]
    fn coincident_corners_have_no_side() {
        assert_eq!(expand([DVec2::ONE; 3], |_| unreachable!()), None);
    }

    #[test]
    fn nan_ends_the_expansion() {
        let corners = [DVec2::X, DVec2::Y, DVec2::NAN];
        let mut calls = 0;
        expand(corners, |_| {
            calls += 1;
            Some(DVec2::NAN)
        });
        assert_eq!(calls, 1);
    }
}
