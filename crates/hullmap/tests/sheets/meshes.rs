//! Triangle meshes and bodies for tests.

use glam::{DQuat, DVec3};
use hullmap::shapes::Cuboid;
use hullmap::{CompoundManifolds, Geometry, ManifoldSettings, Pack, Pose, TriangleMesh};
use hullmap_testkit::packs;
use shapes::rng::SplitMix64;

/// A triangle mesh of these vertices, rounded to f32.
pub fn mesh(positions: &[DVec3], corners: &[[u32; 3]]) -> TriangleMesh {
    packs::triangle_mesh(&positions.iter().map(|p| p.as_vec3().to_array()).collect::<Vec<_>>(), corners)
}

/// A grid of `cells` by `cells` squares of size 1, centred, each of two triangles, with these
/// heights. The front is upwards.
pub fn grid(cells: usize, mut height: impl FnMut(usize, usize) -> f64) -> TriangleMesh {
    let middle = 0.5 * cells as f64;
    let mut positions = Vec::new();
    for y in 0..=cells {
        for x in 0..=cells {
            positions.push(DVec3::new(x as f64 - middle, y as f64 - middle, height(x, y)));
        }
    }
    let mut corners = Vec::new();
    for y in 0..cells {
        for x in 0..cells {
            let at = |dx: usize, dy: usize| ((y + dy) * (cells + 1) + x + dx) as u32;
            corners.extend([[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]]);
        }
    }
    mesh(&positions, &corners)
}

/// `count` triangles of this size at random places within 3.
pub fn soup(count: usize, size: f64, rng: &mut SplitMix64) -> TriangleMesh {
    let mut positions = Vec::new();
    for _ in 0..count {
        let middle = 3.0 * DVec3::from_array(rng.direction()) * rng.unit();
        positions.extend((0..3).map(|_| middle + size * DVec3::from_array(rng.direction())));
    }
    let corners: Vec<[u32; 3]> = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    mesh(&positions, &corners)
}

/// Corners of all triangles.
pub fn triangles(mesh: &TriangleMesh) -> Vec<[DVec3; 3]> {
    (0..mesh.triangle_count()).map(|index| mesh.triangle(index).unwrap().corners()).collect()
}

/// A few meshes of different kinds.
pub fn meshes(rng: &mut SplitMix64) -> Vec<TriangleMesh> {
    let rough = grid(8, |_, _| rng.unit());
    let flat = grid(5, |_, _| 0.25);
    vec![rough, flat, soup(60, 0.5, rng), soup(20, 1e-3, rng), soup(1, 1.0, rng), soup(5, 2.0, rng)]
}

/// A body of four to eight vertices, and where it is.
pub fn body(rng: &mut SplitMix64) -> (Pack, Pose) {
    let count = 4 + rng.below(5);
    let points: Vec<[f32; 3]> = (0..count).map(|_| rng.direction().map(|c| 0.4 * c as f32)).collect();
    let rotation = DQuat::from_xyzw(rng.unit() - 0.5, rng.unit() - 0.5, rng.unit() - 0.5, rng.unit() - 0.5);
    let position = DVec3::from_array(rng.direction()) * rng.between(0.0, 2.5);
    (packs::tree_pack(&points), Pose::new(position, rotation.normalize()).unwrap())
}

/// Slides a box with these half edges over a surface that is level from x = -4.5 on, a little below
/// it, in steps of this length along x: all normals are normals of its level faces. Returns the
/// number of poses with another normal where the manifolds are not welded.
pub fn slide_box<S: Geometry + ?Sized>(surface: &S, half: DVec3, steps: u32, length: f64) -> usize {
    let (die, sunk, settings) = (Cuboid::new(half).unwrap(), 1e-3 * half.z, ManifoldSettings::default());
    let is_steep = |normal: DVec3| normal.distance(DVec3::Z) > 1e-3;
    let mut replaced = 0;
    for step in 0..steps {
        // Not parallel to the diagonals.
        let x = -4.5 + length * f64::from(step);
        let at = DVec3::new(x, 0.137 + 0.1 * x, half.z - sunk);
        let pose = Pose::new(at, DQuat::from_rotation_z(0.3 * x)).unwrap();
        let (mut manifolds, mut alone) = (CompoundManifolds::new(64), CompoundManifolds::new(64));
        alone.set_welding(false);
        manifolds.update(surface, &die, pose, &settings);
        alone.update(surface, &die, pose, &settings);
        replaced += usize::from(alone.iter().any(|(_, manifold)| is_steep(manifold.normal())));
        assert!(!manifolds.is_empty(), "x = {x}");
        for ([triangle, _], manifold) in manifolds.iter() {
            let normal = manifold.normal();
            assert!(!is_steep(normal), "x = {x}, half {half}: triangle {triangle} has the normal {normal}");
            assert!(manifold.points().iter().all(|p| p.depth <= sunk * 1.001), "x = {x}");
        }
    }
    replaced
}
