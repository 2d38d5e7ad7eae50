//! Seeded random directions, rotations and poses, as methods of the generator.

use glam::{DQuat, DVec3};
use hullmap::Pose;
use shapes::rng::SplitMix64;

/// Random directions, rotations and poses.
pub trait RandomPoses {
    /// A unit vector, uniform over the sphere.
    fn unit_vector(&mut self) -> DVec3;

    /// A rotation by a uniform angle about a uniform axis.
    fn rotation(&mut self) -> DQuat;

    /// A [`rotation`](Self::rotation), and a translation of uniform length from 0 to `reach` in a
    /// uniform direction. Panics if `reach` is not finite.
    fn pose(&mut self, reach: f64) -> Pose;
}

impl RandomPoses for SplitMix64 {
    fn unit_vector(&mut self) -> DVec3 {
        DVec3::from_array(self.direction())
    }

    fn rotation(&mut self) -> DQuat {
        let axis = self.unit_vector();
        DQuat::from_axis_angle(axis, self.between(0.0, std::f64::consts::TAU))
    }

    fn pose(&mut self, reach: f64) -> Pose {
        let translation = self.unit_vector() * self.between(0.0, reach);
        Pose::new(translation, self.rotation()).expect("the reach is finite")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_stay_within_reach_and_turn_every_way() {
        let mut rng = SplitMix64::new(5);
        let poses: Vec<Pose> = (0..2_000).map(|_| rng.pose(2.0)).collect();
        let lengths = poses.iter().map(|pose| pose.translation().length());
        assert!(lengths.clone().all(|length| length <= 2.0) && lengths.sum::<f64>() > 1_800.0);
        let up: DVec3 = poses.iter().map(|pose| pose.transform_vector(DVec3::Z)).sum();
        // A rotation keeps a third of the vector on average, along z; the other axes cancel out.
        assert!(up.truncate().length() < 150.0, "{up}");
    }
}
