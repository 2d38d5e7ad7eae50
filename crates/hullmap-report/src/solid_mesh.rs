//! Meshes of primitive solids, to draw beside others.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::DisplayMesh;

/// Number of corners around the axis of a round solid. A multiple of four.
const SEGMENTS: usize = 24;

/// Number of rings of a half ball.
const RINGS: usize = 6;

impl DisplayMesh {
    /// A box about the origin, by half of its edges.
    pub fn cuboid(half: [f64; 3]) -> Self {
        let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -half[axis] } else { half[axis] } as f32);
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        let edges = (0..8_u32).flat_map(|i| [0, 1, 2].map(|axis| [i, i | 1 << axis])).filter(|[a, b]| a < b).collect();
        Self { points: (0..8).map(corner).collect(), numbers: Vec::new(), triangles, edges }
    }

    /// An ellipsoid about the origin, by its radii.
    pub fn ellipsoid(radii: [f64; 3]) -> Self {
        let rings = (0..=2 * RINGS).map(|ring| {
            let angle = PI * ring as f64 / (2 * RINGS) as f64 - FRAC_PI_2;
            [angle.cos(), radii[2] * angle.sin()]
        });
        let mut mesh = Self::revolved(&rings.collect::<Vec<_>>(), &[RINGS]);
        for point in &mut mesh.points {
            point[0] *= radii[0] as f32;
            point[1] *= radii[1] as f32;
        }
        mesh
    }

    /// A cylinder about the origin, along z.
    pub fn cylinder(radius: f64, half_length: f64) -> Self {
        Self::revolved(
            &[[0.0, -half_length], [radius, -half_length], [radius, half_length], [0.0, half_length]],
            &[1, 2],
        )
    }

    /// A cone along z, its apex up, the origin halfway up.
    pub fn cone(radius: f64, half_length: f64) -> Self {
        Self::revolved(&[[0.0, -half_length], [radius, -half_length], [0.0, half_length]], &[1])
    }

    /// A capsule along z; `half_length` is half of the distance between the centres of its caps.
    pub fn capsule(radius: f64, half_length: f64) -> Self {
        let cap = |up: f64| {
            (0..=RINGS).map(move |ring| {
                let angle = FRAC_PI_2 * ring as f64 / RINGS as f64;
                [radius * angle.cos(), up * (half_length + radius * angle.sin())]
            })
        };
        let profile: Vec<[f64; 2]> = cap(-1.0).rev().chain(cap(1.0)).collect();
        Self::revolved(&profile, &[RINGS, RINGS + 1])
    }

    /// A solid of revolution about z. The profile goes up from the axis to the axis: a radius and a
    /// height each. Its edges are the rings `drawn`, and four lines between them.
    fn revolved(profile: &[[f64; 2]], drawn: &[usize]) -> Self {
        let mut mesh = Self::default();
        let index = |ring: usize, segment: usize| (ring * SEGMENTS + segment % SEGMENTS) as u32;
        for (ring, [radius, height]) in profile.iter().enumerate() {
            for segment in 0..SEGMENTS {
                let angle = TAU * segment as f64 / SEGMENTS as f64;
                mesh.points.push([radius * angle.cos(), radius * angle.sin(), *height].map(|c| c as f32));
                if drawn.contains(&ring) {
                    mesh.edges.push([index(ring, segment), index(ring, segment + 1)]);
                }
                if ring == 0 {
                    continue;
                }
                let [a, b] = [index(ring - 1, segment), index(ring - 1, segment + 1)];
                let [c, d] = [index(ring, segment), index(ring, segment + 1)];
                // At the axis, corners coincide.
                if ring > 1 {
                    mesh.triangles.push([a, b, d]);
                }
                if ring + 1 < profile.len() {
                    mesh.triangles.push([a, d, c]);
                }
                if segment % (SEGMENTS / 4) == 0 {
                    mesh.edges.push([a, c]);
                }
            }
        }
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume, by the divergence theorem: positive if the triangles are seen from outside.
    fn volume(mesh: &DisplayMesh) -> f64 {
        let point = |corner: u32| hullmap::glam::DVec3::from_array(mesh.points[corner as usize].map(f64::from));
        mesh.triangles.iter().map(|t| t.map(point)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }

    #[test]
    fn solids_have_nearly_their_volumes() {
        // A regular polygon of 24 corners has 0.9886 of the area of its circle.
        for (mesh, exact) in [
            (DisplayMesh::cylinder(0.5, 2.0), PI * 0.25 * 4.0),
            (DisplayMesh::cone(0.5, 2.0), PI * 0.25 * 4.0 / 3.0),
            (DisplayMesh::ellipsoid([1.0, 2.0, 3.0]), 4.0 / 3.0 * PI * 6.0),
            (DisplayMesh::capsule(0.5, 1.0), PI * 0.25 * 2.0 + 4.0 / 3.0 * PI * 0.125),
        ] {
            let share = volume(&mesh) / exact;
            assert!((0.95..1.0).contains(&share), "{share}");
        }
        let cuboid = DisplayMesh::cuboid([1.0, 2.0, 3.0]);
        assert!((volume(&cuboid) - 48.0).abs() < 1e-9 && cuboid.edges.len() == 12);
    }
}
