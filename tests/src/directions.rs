//! Directions in which a support query can go wrong.

use glam::{DVec3, Vec3};
use hullmap::Hull;
use shapes::rng::SplitMix64;

/// At least `count` valid directions for `hull`: random ones; face normals, exact and disturbed;
/// edge normals; axes, diagonals and seams of the cube map; very long and very short ones.
pub fn all(hull: &Hull, count: usize, seed: u64) -> Vec<Vec3> {
    let mut rng = SplitMix64::new(seed);
    let mut dirs: Vec<Vec3> = (0..count / 2).map(|_| narrow(DVec3::from_array(rng.direction()))).collect();
    for x in -1..=1 {
        for y in -1..=1 {
            for z in -1..=1 {
                let axis = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
                dirs.push(narrow(axis));
                dirs.push(narrow(axis + DVec3::from_array(rng.direction()) * 1e-7));
            }
        }
    }
    let vertices: Vec<DVec3> = hull.vertices().map(|v| v.as_dvec3()).collect();
    let normals: Vec<DVec3> = hull
        .faces()
        .map(|face| {
            let corners: Vec<DVec3> = face.map(|v| vertices[v as usize]).collect();
            let root = corners[0];
            corners.windows(2).map(|w| (w[0] - root).cross(w[1] - root)).sum::<DVec3>().normalize_or_zero()
        })
        .collect();
    while dirs.len() < count && !normals.is_empty() {
        let normal = normals[rng.below(normals.len())];
        let other = normals[rng.below(normals.len())];
        let random = DVec3::from_array(rng.direction());
        dirs.push(narrow(normal));
        dirs.push(narrow(-normal));
        dirs.push(narrow(normal + random * 10_f64.powi(-(rng.below(9) as i32))));
        dirs.push(narrow(normal * rng.unit() + other * rng.unit()));
        let edge = vertices[rng.below(vertices.len())] - vertices[rng.below(vertices.len())];
        dirs.push(narrow(edge.cross(random).normalize_or_zero()));
        // Seams of the cube map: two coordinates of the same size.
        dirs.push(narrow(DVec3::new(random.x, random.x.abs() * random.y.signum(), random.z)));
        dirs.push(narrow(DVec3::new(random.x, random.y, random.y)));
        dirs.push(narrow(DVec3::new(random.z, random.y, -random.z)));
    }
    for scale in [1e-44, 1e-38, 1e-20, 1e20, 1e37] {
        let dir = DVec3::from_array(rng.direction());
        dirs.push(narrow(dir * scale));
    }
    dirs.retain(|d| *d != Vec3::ZERO);
    dirs
}

/// Invalid directions: zero, NaN, infinite. Any vertex is an allowed answer.
pub fn invalid() -> Vec<Vec3> {
    let odd = [0.0, -0.0, 1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    let mut dirs = Vec::new();
    for x in odd {
        for y in odd {
            for z in odd {
                let dir = Vec3::new(x, y, z);
                if !dir.is_finite() || dir == Vec3::ZERO {
                    dirs.push(dir);
                }
            }
        }
    }
    dirs
}

fn narrow(dir: DVec3) -> Vec3 {
    dir.as_vec3()
}
