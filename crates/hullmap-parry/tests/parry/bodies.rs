//! Bodies and where they are.

use std::sync::Arc;

use hullmap::glam::{DQuat, DVec3};
use hullmap_parry::BakedHull;
use hullmap_random::SplitMix64;
use hullmap_testkit::packs;
use parry3d::math::Pose;

pub fn rotation(rng: &mut SplitMix64) -> DQuat {
    DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize()
}

pub fn pose(rng: &mut SplitMix64, distance: f64) -> Pose {
    let turn = rotation(rng);
    Pose::from_parts((DVec3::from_array(rng.direction()) * distance).as_vec3(), turn.as_quat())
}

#[cfg(feature = "dispatcher")]
pub fn wide_pose(pose: &Pose) -> hullmap::Pose {
    hullmap::Pose::from_f32(pose.translation, pose.rotation).unwrap()
}

pub fn hull(points: &[[f32; 3]]) -> BakedHull {
    BakedHull::new(Arc::new(packs::tree_pack(points)).shared_hull(0).unwrap())
}

/// Vertices of a hull, in the frame that `pose` maps to.
#[cfg(feature = "dispatcher")]
pub fn vertices(hull: &BakedHull, pose: &Pose) -> Vec<DVec3> {
    let pose = wide_pose(pose);
    hull.hull().vertices().map(|v| pose.transform_point(v.as_dvec3())).collect()
}
