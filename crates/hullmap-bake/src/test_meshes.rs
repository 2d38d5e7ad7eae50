//! Meshes and hulls that the tests of several modules use.

use glam::DVec3;
use shapes::{mesh::Mesh, rng::SplitMix64};

use crate::hull::{self, Hull};
use hullmap_geometry::{PointSet, triangle::Triangle};

pub fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> PointSet {
    PointSet { name: "mesh".into(), triangles, ..PointSet::of_positions(positions) }
}

pub fn point_set(shape: &Mesh) -> PointSet {
    mesh(shape.vertices.clone(), shape.fans())
}

/// The corners of a box. Bit k of an index is set at the upper end of axis k.
pub fn corners(low: [f32; 3], high: [f32; 3]) -> Vec<[f32; 3]> {
    (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] })).collect()
}

/// A box of twelve triangles, two for each side. The second pair is the top.
pub fn block(low: [f32; 3], high: [f32; 3]) -> PointSet {
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    mesh(corners(low, high), triangles.collect())
}

/// A box without a lid, of ten triangles.
pub fn open_block(low: [f32; 3], high: [f32; 3]) -> PointSet {
    let mut open = block(low, high);
    open.triangles.drain(2..4);
    open
}

pub fn joined(meshes: &[PointSet]) -> PointSet {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for part in meshes {
        let first = positions.len() as u32;
        positions.extend(&part.positions);
        triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    mesh(positions, triangles)
}

pub fn inside_out(mut mesh: PointSet) -> PointSet {
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    mesh
}

/// The triangles of a mesh, then their other sides.
pub fn doubled(mut mesh: PointSet) -> PointSet {
    mesh.triangles.extend(inside_out(mesh.clone()).triangles);
    mesh
}

/// A mesh whose axes come in another order and with other signs. Triangles are shuffled, start with
/// other corners and, if it is reversed, face the other way.
pub fn turned(mesh: &PointSet, axes: [usize; 3], signs: [f32; 3], is_reversed: bool, rng: &mut SplitMix64) -> PointSet {
    let positions = mesh.positions.iter().map(|p| [0, 1, 2].map(|k| signs[k] * p[axes[k]] + 0.0)).collect();
    let mut turned = PointSet { positions, ..mesh.clone() };
    for k in (1..turned.triangles.len()).rev() {
        turned.triangles.swap(k, rng.below(k + 1));
    }
    turned.triangles.iter_mut().for_each(|t| t.rotate_left(rng.below(3)));
    if is_reversed { inside_out(turned) } else { turned }
}

/// A random point of a triangle.
pub fn in_triangle(&[a, b, c]: &Triangle, rng: &mut SplitMix64) -> DVec3 {
    let (u, v) = (rng.unit(), rng.unit());
    let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
    a + u * (b - a) + v * (c - a)
}

/// The result of work on a number of threads.
pub fn on_threads<T: Send>(count: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap().install(work)
}

pub fn hull_of(positions: Vec<[f32; 3]>) -> Hull {
    hull::build(&PointSet::of_positions(positions)).unwrap()
}

pub fn hulls_of(parts: &[PointSet]) -> Vec<Hull> {
    parts.iter().map(|part| hull::build(part).unwrap()).collect()
}

/// The faces of a hull as a mesh.
pub fn surface_of(hull: &Hull) -> PointSet {
    point_set(&Mesh { vertices: hull.vertices.clone(), faces: hull.faces.clone() })
}

pub fn box_hull(low: [f32; 3], high: [f32; 3]) -> Hull {
    hull_of(corners(low, high))
}
