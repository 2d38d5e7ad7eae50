//! Surfaces for tests.

use std::sync::Arc;

use hullmap::glam::DVec3;
use hullmap::height_field::{Diagonal, Layout};
use hullmap::{HeightField, TriangleMesh};
use hullmap_parry::BakedSurface;
use hullmap_random::SplitMix64;
use hullmap_testkit::packs;
use parry3d::math::{Pose, Vector};

/// A triangle mesh of these vertices, rounded to f32.
pub fn mesh(positions: &[DVec3], corners: &[[u32; 3]]) -> Arc<TriangleMesh> {
    let positions: Vec<[f32; 3]> = positions.iter().map(|p| p.as_vec3().to_array()).collect();
    Arc::new(packs::triangle_mesh(&positions, corners))
}

/// A height field of `cells` by `cells` squares of size 1, whose least x and y are at `origin`.
pub fn field(cells: usize, origin: [f64; 2], mut height: impl FnMut(usize, usize) -> f32) -> Arc<HeightField> {
    let row = cells + 1;
    let layout = Layout { columns: row, rows: row, origin, spacing: [1.0; 2], diagonal: Diagonal::Rising };
    let heights: Vec<f32> = (0..row * row).map(|i| height(i % row, i / row)).collect();
    Arc::new(packs::height_field(layout, &heights, &[]))
}

/// Triangles at random places within 3.
pub fn soup(count: usize, size: f64, rng: &mut SplitMix64) -> Arc<TriangleMesh> {
    let mut positions = Vec::new();
    for _ in 0..count {
        let middle = 3.0 * DVec3::from_array(rng.direction()) * rng.unit();
        positions.extend((0..3).map(|_| middle + size * DVec3::from_array(rng.direction())));
    }
    let corners: Vec<[u32; 3]> = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    mesh(&positions, &corners)
}

/// A surface, with its name and the corners of its triangles by subshape, in its frame.
pub struct NamedSurface {
    pub name: &'static str,
    pub surface: BakedSurface,
    pub triangles: Vec<[DVec3; 3]>,
}

impl NamedSurface {
    pub fn new(name: &'static str, surface: BakedSurface) -> Self {
        let (vertices, triangles) = surface.to_trimesh();
        let triangles = triangles.iter().map(|t| t.map(|corner| vertices[corner as usize].as_dvec3())).collect();
        Self { name, surface, triangles }
    }
}

/// Surfaces of every kind: a mesh, a field, and several tiles with poses.
pub fn grounds(seed: u64) -> Vec<NamedSurface> {
    let mut rng = SplitMix64::new(seed);
    let soup = BakedSurface::new(soup(40, 0.7, &mut rng));
    let rough = BakedSurface::new(field(6, [-3.0; 2], |_, _| rng.between(-0.4, 0.4) as f32));
    let moved = |x: f32, angle: f32| Pose::new(Vector::new(x, 0.2, -0.1), Vector::new(0.1, -0.2, 1.0) * angle);
    let joined = BakedSurface::joined([(moved(2.0, 0.4), rough.clone()), (moved(-2.0, -0.8), soup.clone())]).unwrap();
    let nested = BakedSurface::joined([(moved(0.5, 1.0), joined.clone()), (Pose::IDENTITY, rough.clone())]).unwrap();
    vec![
        NamedSurface::new("mesh", soup),
        NamedSurface::new("field", rough),
        NamedSurface::new("joined", joined),
        NamedSurface::new("nested", nested),
    ]
}
