//! A single body that falls on a floor, in its own world.

use hullmap::glam::DQuat;
use hullmap_random::SplitMix64;
use rapier3d::prelude::*;

use super::floor::Floor;
use super::model::Model;
use super::way::Way;

/// Length of a step.
pub const STEP_SECONDS: f32 = 1.0 / 60.0;

/// Number of steps that a gain of energy must last to count: half a second. Continuous collision
/// detection delays a body that rolls over its corners, but not its speed, until it has landed.
const LASTING: usize = 30;

/// How a body ended.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// Seconds until it slept for good; `None` if it was awake at the end.
    pub asleep_after: Option<f32>,
    /// Whether it fell through the floor, or off it.
    pub lost: bool,
    /// Maximum depth of a point of the body below the floor, over all steps.
    pub deepest: f32,
    /// Maximum depth at the end.
    pub final_depth: f32,
    /// Energy gained, in J/kg: the greatest rise of the body's energy above an earlier value, for
    /// half a second or longer. At the earlier time, depth in the floor counts as height: the way
    /// back up is no gain.
    pub gained: f32,
}

impl Outcome {
    /// Depth in the floor at which a body counts as stuck: Rapier's own tolerance, 5 mm.
    pub const STUCK: f32 = 0.005;

    /// Energy in J/kg that counts as gained: the energy of a body that is 1 mm higher.
    pub const GAIN: f32 = 0.01;

    /// Whether the body is in the floor for good.
    pub fn is_stuck(&self) -> bool {
        !self.lost && self.final_depth > Self::STUCK
    }
}

/// Drops `model` from half of `size` above the floor, rotated by `rotation`, and simulates
/// `seconds`.
pub fn drop(model: &Model, size: f32, rotation: Rotation, floor: Floor, way: Way, seconds: f32) -> Outcome {
    let mut world = way.world();
    world.insert_collider(floor.collider(way), None);
    let [top, lowest] = floor.heights();
    let height = top + model.depth_below_origin(rotation) + 0.5 * size;
    // Not above edges of the triangle mesh or of the compound's parts.
    let at = Vector::new(0.31, height, 0.17);
    let body = RigidBodyBuilder::dynamic().pose(Pose::from_parts(at, rotation));
    let (body, _) = world.insert(body, ColliderBuilder::new(model.shape(way)));
    let mut deepest = 0.0_f32;
    let (mut below, mut least, mut gained) = (0.0, f32::INFINITY, 0.0_f32);
    let mut lasting = [f32::NEG_INFINITY; LASTING];
    let mut slept_at = None;
    let steps = (seconds / STEP_SECONDS).round() as u32;
    for step in 0..steps {
        world.step();
        let body = &world.bodies[body];
        below = floor.depth(model, body.position());
        deepest = deepest.max(below);
        let energy = body.kinetic_energy() / body.mass() - world.gravity.y * body.center_of_mass().y;
        lasting[step as usize % LASTING] = energy;
        gained = gained.max(lasting.into_iter().fold(f32::INFINITY, f32::min) - least);
        least = least.min(energy - world.gravity.y * below.max(0.0));
        match (body.is_sleeping(), slept_at) {
            (true, None) => slept_at = Some((step + 1) as f32 * STEP_SECONDS),
            (false, Some(_)) => slept_at = None,
            _ => {}
        }
    }
    let body = &world.bodies[body];
    let lost = !(body.translation().y > lowest - 0.5 * size && deepest < 0.5 * size);
    Outcome { asleep_after: slept_at, lost, deepest, final_depth: below, gained }
}

/// `count` random rotations, the same for a seed.
pub fn rotations(seed: u64, count: usize) -> Vec<Rotation> {
    let mut rng = SplitMix64::new(seed);
    let mut next = || loop {
        // Uniform over the unit ball of quaternions, then normalised.
        let q = DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0)));
        if (0.01..1.0).contains(&q.length_squared()) {
            return q.normalize().as_quat();
        }
    };
    (0..count).map(|_| next()).collect()
}
