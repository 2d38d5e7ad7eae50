//! Ways to build a closed mesh: from face normals, by extrusion, on a lathe, as a tube, by
//! subdivision.
//!
//! Positions are worked out in `f64` and rounded to `f32` as they enter the mesh.

use crate::mesh::Mesh;
use crate::turn::cos_sin;
use crate::vector::{Vec3, add, cross, dot, normalized, scale, sub};
use std::collections::BTreeMap;

/// How far below a face's plane a corner of it may lie, in multiples of the vertices' distance from
/// the origin.
///
/// Far above rounding in `f64` (1e-16), far below the gap to the next vertex of any regular solid
/// (above 0.1).
const COPLANAR_RELATIVE: f64 = 1e-9;

/// The convex polyhedron with these `vertices` and one face for each outward `normal`.
///
/// A face's corners are the vertices farthest along its normal.
pub fn polyhedron(vertices: &[[f64; 3]], normals: &[[f64; 3]]) -> Mesh {
    let mut mesh = Mesh::default();
    for &vertex in vertices {
        mesh.push_vertex(vertex);
    }
    mesh.faces = normals.iter().map(|&normal| face_along(vertices, normalized(normal))).collect();
    mesh
}

/// The vertices farthest along the unit vector `normal`, counter-clockwise about it, lowest index
/// first.
fn face_along(vertices: &[Vec3], normal: Vec3) -> Vec<u32> {
    let far = vertices.iter().map(|&v| dot(v, normal)).fold(f64::NEG_INFINITY, f64::max);
    let slack = far.abs() * COPLANAR_RELATIVE;
    let corners: Vec<usize> = (0..vertices.len()).filter(|&i| dot(vertices[i], normal) >= far - slack).collect();
    let sum = corners.iter().fold([0.0; 3], |sum, &i| add(sum, vertices[i]));
    let centre = scale(sum, 1.0 / corners.len() as f64);
    let x_axis = normalized(sub(vertices[corners[0]], centre));
    let y_axis = cross(normal, x_axis);
    let mut by_angle: Vec<(f64, usize)> = corners
        .iter()
        .map(|&i| {
            let from_centre = sub(vertices[i], centre);
            let angle_rad = libm::atan2(dot(from_centre, y_axis), dot(from_centre, x_axis));
            // The first corner is at angle zero and must stay first, also if rounding makes the
            // angle negative.
            if i == corners[0] {
                (0.0, i)
            } else if angle_rad < 0.0 {
                (angle_rad + core::f64::consts::TAU, i)
            } else {
                (angle_rad, i)
            }
        })
        .collect();
    by_angle.sort_by(|a, b| a.0.total_cmp(&b.0));
    by_angle.into_iter().map(|(_, i)| i as u32).collect()
}

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

/// Pyramid over a regular polygon, with the apex `apex_z` above it as the last vertex. The base is
/// one n-gon.
pub fn cone(base_corners: usize, radius: f64, base_z: f64, apex_z: f64) -> Mesh {
    let mut mesh = Mesh::default();
    for [x, y] in regular_polygon(base_corners, radius) {
        mesh.push_vertex([x, y, base_z]);
    }
    let apex = mesh.push_vertex([0.0, 0.0, apex_z]);
    mesh.faces.push((0..apex).rev().collect());
    for i in 0..apex {
        mesh.faces.push(vec![i, (i + 1) % apex, apex]);
    }
    mesh
}

/// Size of a [`torus_knot`].
#[derive(Clone, Copy, Debug)]
pub struct TorusKnot {
    /// Turns about the z axis.
    pub turns_about_axis: usize,
    /// Turns about the circle inside the torus; coprime to the other.
    pub turns_about_circle: usize,
    /// Radius of the circle inside the torus.
    pub major_radius: f64,
    /// Distance of the knot from that circle.
    pub minor_radius: f64,
    /// Radius of the tube laid along the knot.
    pub tube_radius: f64,
    /// Cross-sections along the knot.
    pub sections: usize,
    /// Corners of each cross-section.
    pub sides: usize,
}

/// A closed tube along a curve that winds around a torus; all quads.
///
/// The frame of the tube is the tangent of the curve and the normal of the torus. The two are
/// perpendicular everywhere and periodic, so the tube closes without a twist.
pub fn torus_knot(knot: TorusKnot) -> Mesh {
    let (p, q) = (knot.turns_about_axis, knot.turns_about_circle);
    let (sections, sides) = (knot.sections, knot.sides);
    let mut mesh = Mesh::default();
    for i in 0..sections {
        let (cos_p, sin_p) = cos_sin(p * i, sections);
        let (cos_q, sin_q) = cos_sin(q * i, sections);
        let outward = [cos_p, sin_p, 0.0];
        let around = [-sin_p, cos_p, 0.0];
        let up = [0.0, 0.0, 1.0];
        let from_axis = knot.major_radius + knot.minor_radius * cos_q;
        let centre = add(scale(outward, from_axis), scale(up, knot.minor_radius * sin_q));
        let normal = add(scale(outward, cos_q), scale(up, sin_q));
        let along_minor = add(scale(outward, -sin_q), scale(up, cos_q));
        let tangent =
            normalized(add(scale(around, p as f64 * from_axis), scale(along_minor, q as f64 * knot.minor_radius)));
        let binormal = cross(tangent, normal);
        for j in 0..sides {
            let (c, s) = cos_sin(j, sides);
            let spoke = add(scale(normal, c), scale(binormal, s));
            mesh.push_vertex(add(centre, scale(spoke, knot.tube_radius)));
        }
    }
    let at = |i: usize, j: usize| ((i % sections) * sides + j % sides) as u32;
    for i in 0..sections {
        for j in 0..sides {
            mesh.faces.push(vec![at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    mesh
}

/// Directions and triangles of an icosahedron, each triangle divided into four, `levels` times.
///
/// Directions are unit vectors; there are 10·4^`levels` + 2 of them.
pub fn geodesic(levels: u32) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mut directions: Vec<Vec3> = icosahedron_vertices().into_iter().map(normalized).collect();
    let mut triangles: Vec<[u32; 3]> = dodecahedron_vertices()
        .into_iter()
        .map(|normal| face_along(&directions, normalized(normal)))
        .map(|face| [face[0], face[1], face[2]])
        .collect();
    for _ in 0..levels {
        let mut midpoints = BTreeMap::new();
        let mut midpoint = |a: u32, b: u32| {
            *midpoints.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let sum = add(directions[a as usize], directions[b as usize]);
                directions.push(normalized(sum));
                directions.len() as u32 - 1
            })
        };
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let (ab, bc, ca) = (midpoint(a, b), midpoint(b, c), midpoint(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    (directions, triangles)
}

fn golden() -> f64 {
    (1.0 + libm::sqrt(5.0)) / 2.0
}

/// The twelve corners (0, ±1, ±φ) and their cyclic shifts: edges of length 2.
pub fn icosahedron_vertices() -> Vec<[f64; 3]> {
    cyclic_corners(1.0, golden())
}

/// The twenty corners (±1, ±1, ±1), (0, ±φ, ±1/φ) and the latter's cyclic shifts.
///
/// These are also the directions of an icosahedron's face normals, and the other way round.
pub fn dodecahedron_vertices() -> Vec<[f64; 3]> {
    let mut corners = cube_vertices();
    corners.extend(cyclic_corners(golden(), golden() - 1.0));
    corners
}

/// The eight corners (±1, ±1, ±1).
pub fn cube_vertices() -> Vec<[f64; 3]> {
    (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| if bit == 0 { -1.0 } else { 1.0 })).collect()
}

/// The six corners ±x, ±y, ±z.
pub fn octahedron_vertices() -> Vec<[f64; 3]> {
    let mut corners = Vec::new();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut corner = [0.0; 3];
            corner[axis] = sign;
            corners.push(corner);
        }
    }
    corners
}

fn cyclic_corners(a: f64, b: f64) -> Vec<Vec3> {
    let mut corners = Vec::new();
    for shift in 0..3 {
        for (y, z) in [(a, b), (-a, b), (a, -b), (-a, -b)] {
            let mut corner = [0.0, y, z];
            corner.rotate_right(shift);
            corners.push(corner);
        }
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    fn euler_characteristic(mesh: &Mesh) -> i64 {
        let half_edges: usize = mesh.faces.iter().map(Vec::len).sum();
        mesh.vertices.len() as i64 - half_edges as i64 / 2 + mesh.faces.len() as i64
    }

    fn assert_solid(mesh: &Mesh, characteristic: i64) {
        assert_eq!(mesh.check_closed(), Ok(()));
        assert!(mesh.signed_volume() > 0.0);
        assert_eq!(euler_characteristic(mesh), characteristic);
    }

    #[test]
    fn platonic_solids_have_their_volumes() {
        let (phi, root5) = (golden(), libm::sqrt(5.0));
        let dodecahedron_edge = 2.0 / phi;
        let cases = [
            (cube_vertices(), octahedron_vertices(), 4, 8.0),
            (octahedron_vertices(), cube_vertices(), 3, 4.0 / 3.0),
            (icosahedron_vertices(), dodecahedron_vertices(), 3, 8.0 * 5.0 * (3.0 + root5) / 12.0),
            (
                dodecahedron_vertices(),
                icosahedron_vertices(),
                5,
                dodecahedron_edge * dodecahedron_edge * dodecahedron_edge * (15.0 + 7.0 * root5) / 4.0,
            ),
        ];
        for (vertices, normals, corners, volume) in cases {
            let mesh = polyhedron(&vertices, &normals);
            assert_solid(&mesh, 2);
            assert!(mesh.faces.iter().all(|face| face.len() == corners));
            let error = (mesh.signed_volume() - volume).abs() / volume;
            assert!(error < 1e-6, "{error}");
        }
    }

    #[test]
    fn extrusion_and_cone_are_closed() {
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]];
        let mesh = extrusion(&square, -1.0, 2.0);
        assert_solid(&mesh, 2);
        assert_eq!(mesh.signed_volume(), 6.0);
        assert_solid(&cone(64, 1.0, -1.0, 1.0), 2);
    }

    #[test]
    fn lathe_turns_a_diamond_into_an_octahedron() {
        let mesh = lathe(&[[0.0, -1.0], [1.0, 0.0], [0.0, 1.0]], 4);
        assert_solid(&mesh, 2);
        assert_eq!(mesh.signed_volume() as f32, 4.0 / 3.0);
    }

    #[test]
    fn torus_knot_is_a_torus() {
        let knot = TorusKnot {
            turns_about_axis: 2,
            turns_about_circle: 3,
            major_radius: 2.0,
            minor_radius: 0.8,
            tube_radius: 0.3,
            sections: 60,
            sides: 8,
        };
        assert_solid(&torus_knot(knot), 0);
    }

    #[test]
    fn geodesic_is_a_sphere() {
        for levels in 0..4 {
            let (directions, triangles) = geodesic(levels);
            let mut mesh = Mesh::default();
            for &direction in &directions {
                mesh.push_vertex(direction);
            }
            mesh.faces = triangles.iter().map(|t| t.to_vec()).collect();
            assert_eq!(directions.len(), 10 * 4_usize.pow(levels) + 2);
            assert_solid(&mesh, 2);
        }
    }
}
