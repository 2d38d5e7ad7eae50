//! Hulls as binary STL: triangles with a normal each. It has no objects and no names.
//!
//! # Reference
//! 3D Systems, "StereoLithography Interface Specification" (1989).

use glam::Vec3;

use super::body::Body;
use super::seal::{SEAL, sealed};

/// Length of the comment before the triangles. It must not start with `solid`, as text files do.
const COMMENT_LEN: usize = 80;

/// The file. Fails if it would have more triangles than its header can count.
pub fn write(body: &Body) -> Result<Vec<u8>, String> {
    write_with("convex hull", body)
}

pub fn write_triangles(body: &Body) -> Result<Vec<u8>, String> {
    write_with("triangle mesh", body)
}

fn write_with(contents: &str, body: &Body) -> Result<Vec<u8>, String> {
    let count = body.triangles().count();
    let count = u32::try_from(count).map_err(|_| format!("has {count} triangles, but STL counts to {}", u32::MAX))?;
    let mut bytes = format!("{contents}, {SEAL}").into_bytes();
    bytes.resize(COMMENT_LEN, b' ');
    bytes.extend(count.to_le_bytes());
    for corners in body.triangles() {
        let corners = corners.map(|corner| body.positions.get(corner as usize).copied().unwrap_or_default());
        for vector in [normal(corners)].into_iter().chain(corners) {
            bytes.extend(vector.iter().flat_map(|coordinate| coordinate.to_le_bytes()));
        }
        // Attribute.
        bytes.extend([0; 2]);
    }
    Ok(sealed(bytes))
}

/// Unit normal of a triangle; zero for one without area, as the format allows.
fn normal(corners: [[f32; 3]; 3]) -> [f32; 3] {
    let [a, b, c] = corners.map(|corner| Vec3::from_array(corner).as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array()
}

#[cfg(test)]
mod tests {
    use super::super::body::cube;
    use super::*;

    #[test]
    fn normals_point_outwards() {
        let bytes = write(&cube("cube")).unwrap();
        assert_eq!(bytes.len(), 84 + 12 * 50);
        assert_eq!(bytes[80..84], 12_u32.to_le_bytes());
        for triangle in bytes[84..].chunks_exact(50) {
            let vector = |index: usize| -> Vec3 {
                let number = |axis: usize| {
                    let at = 12 * index + 4 * axis;
                    f32::from_le_bytes(triangle[at..at + 4].try_into().unwrap())
                };
                Vec3::new(number(0), number(1), number(2))
            };
            assert!((vector(0).dot(vector(1)) - 1.0).abs() < 1e-6, "the cube's faces are at distance 1");
        }
        assert_eq!(normal([[1.0; 3]; 3]), [0.0; 3]);
    }
}
