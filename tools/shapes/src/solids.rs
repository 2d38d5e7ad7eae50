//! Ways to build a closed mesh: by extrusion, and on a lathe.
//!
//! Positions are worked out in `f64` and rounded to `f32` as they enter the mesh.

use crate::mesh::Mesh;
use crate::turn::cos_sin;

/// The `outline`, a counter-clockwise polygon in x and y, raised from `z_bottom` to `z_top`.
///
/// Vertices: the bottom outline, then the top one. Faces: bottom cap, top cap, then one quad per
/// side. The caps are single polygons, concave where the outline is.
pub fn extrusion(outline: &[[f64; 2]], z_bottom: f64, z_top: f64) -> Mesh {
    let count = outline.len() as u32;
    let mut mesh = Mesh::default();
    for z in [z_bottom, z_top] {
        for &[x, y] in outline {
            mesh.push_vertex([x, y, z]);
        }
    }
    mesh.faces.push((0..count).rev().collect());
    mesh.faces.push((count..2 * count).collect());
    for i in 0..count {
        let next = (i + 1) % count;
        mesh.faces.push(vec![i, next, count + next, count + i]);
    }
    mesh
}

/// Regular polygon of this `radius`. The first of its `corners` is on the x axis.
pub fn regular_polygon(corners: usize, radius: f64) -> Vec<[f64; 2]> {
    (0..corners)
        .map(|i| {
            let (c, s) = cos_sin(i, corners);
            [radius * c, radius * s]
        })
        .collect()
}

/// Solid of revolution: the `profile` rotated about the z axis in `segments` steps, with a pole at
/// each end.
///
/// The profile lists `[radius, z]`, upwards along the outside; its first and last radius must be
/// zero and all others positive. Vertices: lower pole, rings upwards, upper pole. Faces: triangles
/// at the poles, quads between. Panics if the profile has fewer than three points or does not start
/// and end on the axis.
pub fn lathe(profile: &[[f64; 2]], segments: u32) -> Mesh {
    let [first, rings @ .., last] = profile else {
        panic!("a profile needs two poles");
    };
    assert!(!rings.is_empty(), "a profile needs a ring between its poles");
    assert!(first[0] == 0.0 && last[0] == 0.0, "a profile starts and ends on the axis");
    let mut mesh = Mesh::default();
    let bottom = mesh.push_vertex([0.0, 0.0, first[1]]);
    for &[radius, z] in rings {
        for i in 0..segments {
            let (c, s) = cos_sin(i as usize, segments as usize);
            mesh.push_vertex([radius * c, radius * s, z]);
        }
    }
    let top = mesh.push_vertex([0.0, 0.0, last[1]]);

    let ring_count = rings.len() as u32;
    let at = |ring: u32, i: u32| 1 + ring * segments + i % segments;
    for i in 0..segments {
        mesh.faces.push(vec![bottom, at(0, i + 1), at(0, i)]);
    }
    for ring in 1..ring_count {
        for i in 0..segments {
            mesh.faces.push(vec![at(ring - 1, i), at(ring - 1, i + 1), at(ring, i + 1), at(ring, i)]);
        }
    }
    for i in 0..segments {
        mesh.faces.push(vec![top, at(ring_count - 1, i), at(ring_count - 1, i + 1)]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solids_are_closed_and_have_their_volumes() {
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]];
        let diamond = [[0.0, -1.0], [1.0, 0.0], [0.0, 1.0]];
        for (mesh, volume) in [(extrusion(&square, -1.0, 2.0), 6.0), (lathe(&diamond, 4), 4.0 / 3.0)] {
            assert_eq!(mesh.check_closed(), Ok(()));
            assert_eq!(mesh.signed_volume() as f32, volume);
        }
    }
}
