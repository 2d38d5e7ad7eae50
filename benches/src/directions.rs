//! Query directions, seeded: unit vectors in f32.

use glam::{DVec3, Vec3};
use hullmap::Hull;
use shapes::rng::SplitMix64;

/// Angle between successive directions of [`turning`], in radians: one degree.
pub const TURN_RAD: f64 = std::f64::consts::PI / 180.0;

/// Sideways speed of the path of [`turning`] over its forward speed. It makes the path cover the
/// sphere instead of one circle.
const WANDER: f64 = 0.2;

/// `count` directions, uniform over the sphere and independent of each other.
pub fn random(count: usize, seed: u64) -> Vec<Vec3> {
    let mut rng = SplitMix64::new(seed);
    (0..count).map(|_| DVec3::from_array(rng.direction()).as_vec3()).collect()
}

/// `count` directions, each [`TURN_RAD`] from the last, along a path that wanders over the sphere.
pub fn turning(count: usize, seed: u64) -> Vec<Vec3> {
    let mut rng = SplitMix64::new(seed);
    let mut dir = DVec3::from_array(rng.direction());
    let mut heading = dir.any_orthonormal_vector();
    let (sin, cos) = TURN_RAD.sin_cos();
    (0..count)
        .map(|_| {
            (dir, heading) = (dir * cos + heading * sin, heading * cos - dir * sin);
            heading = (heading + DVec3::from_array(rng.direction()) * WANDER).reject_from_normalized(dir).normalize();
            dir = dir.normalize();
            dir.as_vec3()
        })
        .collect()
}

/// `count` directions, difficult ones among them: half are random, a quarter are face normals, a
/// quarter are face normals disturbed by 0.1 … 1e-8.
pub fn awkward(hull: &Hull<'_>, count: usize, seed: u64) -> Vec<Vec3> {
    let mut rng = SplitMix64::new(seed);
    let normals: Vec<DVec3> = (0..hull.face_count() as u32).filter_map(|face| hull.face_normal(face)).collect();
    let mut dirs: Vec<Vec3> = (0..count / 2).map(|_| DVec3::from_array(rng.direction()).as_vec3()).collect();
    while dirs.len() < count {
        let normal = normals[rng.below(normals.len())];
        dirs.push(normal.as_vec3());
        let offset = DVec3::from_array(rng.direction()) * 10_f64.powi(-1 - rng.below(8) as i32);
        dirs.push((normal + offset).as_vec3());
    }
    dirs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turning_steps_one_degree_and_covers_all_octants() {
        let dirs = turning(5_000, 3);
        for pair in dirs.windows(2) {
            let angle_rad = pair[0].as_dvec3().angle_between(pair[1].as_dvec3());
            assert!((angle_rad - TURN_RAD).abs() < 1e-4, "{angle_rad}");
        }
        let octants = dirs.iter().fold(0_u8, |seen, d| {
            seen | 1 << (d.to_array().map(f32::is_sign_negative).iter().fold(0, |o, &n| 2 * o + u8::from(n)))
        });
        assert_eq!(octants, u8::MAX, "the path misses an octant");
    }
}
