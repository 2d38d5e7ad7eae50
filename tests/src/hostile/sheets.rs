//! The triangle meshes and height fields to change.

use hullmap::height_field::{Diagonal, Layout};
use hullmap_bake::height_field::{HeightGrid, bake_height_field, write_height_field};
use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};
use shapes::{families::Family, rng::SplitMix64};

use super::samples::{Sample, source};

/// Seed of the heights.
const SEED: u64 = 0x5eed;

/// Small files of both kinds: flat and rough, closed and with borders, with every class of edges,
/// with holes, long and of one cell.
pub fn small() -> Vec<Sample> {
    let mut rng = SplitMix64::new(SEED);
    let rough = |cells: usize, height: f64, rng: &mut SplitMix64| ground(cells, |_| height * rng.unit());
    vec![
        mesh("triangle", &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]),
        mesh("two triangles", &[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, 0.0]], &[[0, 1, 2], [0, 2, 3]]),
        mesh_of("tetrahedron", tetrahedra(1)),
        mesh_of("two solids", tetrahedra(2)),
        mesh_of("seven solids", tetrahedra(7)),
        mesh_of("flat floor", ground(4, |_| 0.0)),
        mesh_of("rough floor", rough(5, 0.4, &mut rng)),
        mesh_of("larger floor", rough(8, 0.4, &mut rng)),
        mesh_of("steps", ground(6, |at| f64::from(at % 3 == 0))),
        flawed(),
        scattered(),
        field("cell", [2, 2], Diagonal::Rising, 0.0, &mut rng),
        field("two cells", [3, 2], Diagonal::Falling, 0.0, &mut rng),
        field("row", [40, 2], Diagonal::Rising, 0.0, &mut rng),
        field("column", [2, 50], Diagonal::Falling, 0.2, &mut rng),
        field("square", [9, 9], Diagonal::Rising, 0.0, &mut rng),
        field("square with holes", [10, 9], Diagonal::Rising, 0.3, &mut rng),
        field("mostly holes", [12, 11], Diagonal::Falling, 0.9, &mut rng),
        field("wide", [31, 12], Diagonal::Falling, 0.0, &mut rng),
        field("tall", [7, 40], Diagonal::Rising, 0.1, &mut rng),
        field("large", [21, 20], Diagonal::Falling, 0.1, &mut rng),
    ]
}

/// File `index` of the random series of `seed`: a rough floor, solids or a field, of 20 to 200
/// triangles.
pub fn drawn(seed: u64, index: u64) -> Sample {
    let mut rng = SplitMix64::new(seed ^ index << 32);
    let name = format!("drawn {index}");
    let height = rng.unit();
    match rng.below(4) {
        0 => mesh_of(&name, ground(3 + rng.below(8), |_| height * rng.unit())),
        1 => mesh_of(&name, tetrahedra(5 + rng.below(46))),
        kind => {
            let (columns, rows) = (3 + rng.below(9), 6 + rng.below(5));
            let (diagonal, holes) = (Diagonal::ALL[kind - 2], 0.5 * height);
            field(&name, [columns, rows], diagonal, holes, &mut rng)
        }
    }
}

/// The small file of this name. Panics if no file has this name.
pub fn named(name: &str) -> Vec<u8> {
    let found = small().into_iter().find(|sample| sample.name == name);
    found.unwrap_or_else(|| panic!("there is no sample {name:?}")).file
}

type Mesh = (Vec<[f32; 3]>, Vec<[u32; 3]>);

fn mesh_of(name: &str, (positions, corners): Mesh) -> Sample {
    mesh(name, &positions, &corners)
}

fn mesh(name: &str, positions: &[[f32; 3]], corners: &[[u32; 3]]) -> Sample {
    let materials: Vec<u16> = (0..corners.len() as u16).collect();
    let baked = bake_triangle_mesh(&Triangles { positions, corners, materials: &materials });
    let file = write_triangle_mesh(baked.expect("the sample can be baked"), &source()).expect("it is small");
    Sample { name: format!("mesh, {name}"), file }
}

/// A grid of squares, each of two triangles, with these heights by the number of the vertex.
fn ground(cells: usize, mut height: impl FnMut(usize) -> f64) -> Mesh {
    let side = cells + 1;
    let positions = (0..side * side).map(|at| [(at % side) as f32, (at / side) as f32, height(at) as f32]).collect();
    let square = |at: usize| {
        let first = (at / cells * side + at % cells) as u32;
        let [right, far, up] = [first + 1, first + side as u32 + 1, first + side as u32];
        [[first, right, far], [first, far, up]]
    };
    (positions, (0..cells * cells).flat_map(square).collect())
}

/// Solids beside each other.
fn tetrahedra(count: usize) -> Mesh {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0_f32]];
    let positions = (0..count).flat_map(|i| corners.map(|[x, y, z]| [x + 1.5 * i as f32, y, z + 0.5 * i as f32]));
    let faces = |i: usize| [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|face| face.map(|v: u32| v + 4 * i as u32));
    (positions.collect(), (0..count).flat_map(faces).collect())
}

/// A mesh with degenerate and duplicate triangles, non-manifold and reversed edges.
fn flawed() -> Sample {
    let positions = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.5, 0.5, 1.0],
        [1.0, 1.0, 0.0],
        [2.0, 0.0, 0.0],
        [0.0, 0.0, 0.0],
    ];
    let corners = [[0, 1, 2], [0, 1, 2], [1, 0, 3], [0, 1, 4], [2, 1, 4], [1, 2, 3], [0, 1, 5], [0, 0, 1], [6, 2, 1]];
    mesh("flawed", &positions, &corners)
}

/// Triangles without neighbours.
fn scattered() -> Sample {
    let positions = Family::Sphere.points(90, 6);
    let corners: Vec<[u32; 3]> = (0..30).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    mesh("scattered", &positions, &corners)
}

fn field(name: &str, [columns, rows]: [usize; 2], diagonal: Diagonal, share: f64, rng: &mut SplitMix64) -> Sample {
    let layout = Layout { columns, rows, origin: [-3.0, 4.5], spacing: [1.0, 0.5], diagonal };
    let heights: Vec<f32> = (0..columns * rows).map(|_| rng.unit() as f32).collect();
    let holes: Vec<bool> = (1..layout.cell_count()).map(|_| rng.unit() < share).collect();
    let holes = [&[false], holes.as_slice()].concat();
    let materials: Vec<u16> = (0..layout.cell_count() as u16).collect();
    let grid = HeightGrid { layout, heights: &heights, holes: &holes, materials: &materials };
    let baked = bake_height_field(&grid).expect("the sample can be baked");
    let file = write_height_field(baked, &source()).expect("it is small");
    Sample { name: format!("field, {name}"), file }
}
