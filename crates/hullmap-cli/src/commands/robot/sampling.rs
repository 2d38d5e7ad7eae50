//! Random configurations: which pairs of links touch in all of them, and which in none.
//!
//! # Reference
//! MoveIt's setup assistant, `compute_default_collisions`: random states within the limits.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3};
use hullmap_random::SplitMix64;
use hullmap_robot::{Chain, Displacement, Frame, Joint, Motion};
use rayon::prelude::*;

use super::touching::Bodies;

/// Configurations that are tested before pairs that are decided are dropped.
const CHUNK: usize = 64;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    pub together: bool,
    pub apart: bool,
}

/// Tests pairs of links in up to `count` random configurations, until they touched and were apart.
/// The result depends on the seed, not on the number of threads.
pub fn sample(chain: &Chain, bodies: &Bodies, pairs: &[[usize; 2]], count: u32, seed: u64) -> Vec<Seen> {
    let mut random = SplitMix64::new(seed);
    let mut seen = vec![Seen::default(); pairs.len()];
    let mut left = count as usize;
    while left > 0 {
        let own = left.min(CHUNK);
        left -= own;
        let poses: Vec<Vec<Frame>> = (0..own).map(|_| chain.poses(&configuration(chain, &mut random))).collect();
        seen.par_iter_mut().zip(pairs).filter(|(seen, _)| !(seen.together && seen.apart)).for_each(|(seen, pair)| {
            for frames in &poses {
                if bodies.touch(*pair, frames) {
                    seen.together = true
                } else {
                    seen.apart = true
                }
                if seen.together && seen.apart {
                    return;
                }
            }
        });
    }
    seen
}

/// A random configuration: joints are uniform within their limits, hinges without limits over a
/// turn. Sliders without limits stay where they are, as do free joints.
fn configuration(chain: &Chain, random: &mut SplitMix64) -> Vec<Displacement> {
    let mut all: Vec<Displacement> = chain.joints.iter().map(|joint| displacement(joint, random)).collect();
    chain.follow(&mut all);
    all
}

fn displacement(joint: &Joint, random: &mut SplitMix64) -> Displacement {
    let limits = match (joint.motion, joint.limits) {
        (Motion::Ball, limits) => {
            let most = limits.map_or(PI, |[_, most]| most.clamp(0.0, PI));
            let axis = DVec3::from_array(random.direction());
            return Displacement::Turn(DQuat::from_axis_angle(axis, random.between(0.0, most)));
        }
        (Motion::Free, _) => [0.0; 2],
        (_, Some(limits)) => limits,
        (Motion::Hinge, None) => [joint.reference, joint.reference + TAU],
        (Motion::Slide, None) => [joint.neutral; 2],
    };
    Displacement::Scalar(random.between(limits[0], limits[1]) - joint.reference)
}
