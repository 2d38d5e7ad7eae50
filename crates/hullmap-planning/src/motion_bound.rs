//! Upper bounds of how far the points of a body move while joints move.
//!
//! # Reference
//! Schwarzer, Saha, Latombe, "Adaptive dynamic collision checking for single and multiple
//! articulated robots in complex environments", 2005, for the principle. The bound is our own;
//! docs/contributors/intervals.md, section 17, proves it.
//!
//! # The bound
//! Joint by joint, from the body to the root. Let the points of a body move by at most m as seen
//! from the frame that joint j moves, and let none of them be farther than r from its axis now.
//! During the motion, none is farther than r + m. So a turn by up to φ adds at most φ (r + m), as
//! seen from the frame that does not turn. A slider adds its displacement.

use glam::DVec3;
use hullmap_robot::{Frame, Motion};

use crate::kinematics::{Kinematics, Placement};

/// For rounding: a hundred joints take fewer than 1000 sums and products of 1.2e-16 each.
const ROUNDED_UP: f64 = 1.0 + 1e-12;

/// A turn moves no point farther than the diameter of its circle.
const MAX_CHORD: f64 = 2.0;

/// Writes to `out`, for each joint of `path`, the maximum motion of points of a box due to it and
/// all later ones, in the frame before it; then 0. `spans` bounds the change of each joint's
/// displacement from `at`. `frame` is the box's frame in the world, `bounds` its centre and half
/// edges, and `noise` bounds the rounding error of its position.
pub(crate) fn motions(
    (kinematics, path): (&Kinematics, &[usize]),
    (frame, bounds, noise): (Frame, [DVec3; 2], f64),
    at: &Placement,
    spans: &[f64],
    out: &mut Vec<f64>,
) {
    let centre = frame.apply(bounds[0]);
    let edges = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| frame.rotation * (axis * axis.dot(bounds[1])));
    out.clear();
    out.resize(path.len() + 1, 0.0);
    let mut moved = 0.0;
    for (place, &joint) in path.iter().enumerate().rev() {
        let span = spans[joint];
        if span > 0.0 {
            moved = match kinematics.joint(joint).motion {
                Motion::Hinge => {
                    let [axis, anchor] = at.axes[joint];
                    let far = farthest(centre - anchor, edges, axis) + noise + moved;
                    (span.min(MAX_CHORD) * far + moved) * ROUNDED_UP
                }
                _ => (span + moved) * ROUNDED_UP,
            };
        }
        out[place] = moved;
    }
}

fn farthest(centre: DVec3, edges: [DVec3; 3], axis: DVec3) -> f64 {
    let across = |v: DVec3| v - axis * axis.dot(v);
    let (centre, [x, y, z]) = (across(centre), edges.map(across));
    let [near, far] = [centre - x, centre + x];
    let ends = [near - y, near + y, far - y, far + y];
    ends.iter().flat_map(|end| [*end - z, *end + z]).map(DVec3::length_squared).fold(0.0, f64::max).sqrt()
}
