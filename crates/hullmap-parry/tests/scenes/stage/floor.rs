//! Floors of the scenes. The top of each is the plane y = 0, unless it is uneven.

use std::sync::OnceLock;

use hullmap::height_field::Diagonal;
use hullmap_parry::BakedHull;
use rapier3d::parry::shape::Compound;
use rapier3d::prelude::*;

use super::model::{Model, prism};
use super::relief::Relief;
use super::sheets::{self, Heights};
use super::way::Way;

/// A kind of floor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Floor {
    /// A cuboid of 20 m × 20 m.
    Cuboid,
    /// A disc of 500 sides and 10 m radius: a baked hull, or parry's.
    Hull,
    /// A half-space.
    HalfSpace,
    /// A mesh of 800 triangles.
    TriangleMesh,
    /// Nine discs of 500 sides, which overlap.
    Compound,
    /// The mesh of 800 triangles as a baked surface. parry's own shapes are the same as for
    /// [`TriangleMesh`](Self::TriangleMesh).
    BakedMesh,
    /// A flat height field of 800 triangles.
    HeightField,
    /// A rough height field of 3,200 triangles.
    Rough,
}

impl Floor {
    /// The ground, if it is not the plane y = 0.
    fn relief(self) -> Option<&'static Relief> {
        (self == Self::Rough).then(Relief::rough)
    }

    /// Greatest height where bodies fall, and the least one.
    pub fn heights(self) -> [f32; 2] {
        self.relief().map_or([0.0; 2], |relief| [relief.top, relief.lowest])
    }

    /// Depth of the deepest point of a body below the floor; on a plane negative above it.
    pub fn depth(self, model: &Model, pose: &Pose) -> f32 {
        match self.relief() {
            Some(relief) => relief.depth(model, pose),
            None => model.depth_below_origin(pose.rotation) - pose.translation.y,
        }
    }

    /// The floor's collider. Panics if parry rejects the mesh.
    pub fn collider(self, way: Way) -> ColliderBuilder {
        let down = Vector::new(0.0, -0.5, 0.0);
        match self {
            Self::Cuboid => ColliderBuilder::cuboid(10.0, 0.5, 10.0).translation(down),
            Self::Hull => ColliderBuilder::new(disc(way)).translation(down),
            Self::HalfSpace => ColliderBuilder::new(SharedShape::halfspace(Vector::Y)),
            Self::TriangleMesh => {
                let (vertices, triangles) = grid(20, 1.0);
                ColliderBuilder::trimesh(vertices, triangles).expect("a mesh")
            }
            Self::Compound => {
                let place =
                    |i: i32| (Pose::translation((i % 3 - 1) as f32 * 4.0, -0.5, (i / 3 - 1) as f32 * 4.0), disc(way));
                ColliderBuilder::new(SharedShape::new(Compound::new((0..9).map(place).collect())))
            }
            Self::BakedMesh => {
                let (vertices, triangles) = grid(20, 1.0);
                let positions: Vec<[f32; 3]> = vertices.iter().map(|v| v.to_array()).collect();
                ColliderBuilder::new(sheets::shape(&sheets::mesh(&positions, &triangles), way))
            }
            Self::HeightField => {
                let flat = Heights::new([20, 20], [-10.0; 2], [1.0; 2], Diagonal::Rising, |_, _| 0.0);
                match way {
                    Way::Parry => {
                        let (pose, shape) = flat.of_parry();
                        ColliderBuilder::new(shape).position(pose)
                    }
                    Way::Shapes | Way::Dispatcher => ColliderBuilder::new(flat.surface().into()),
                }
            }
            Self::Rough => Relief::rough().collider(way),
        }
    }
}

/// The disc of 500 sides, 1 m thick. Its radius is 10 m.
fn disc(way: Way) -> SharedShape {
    static DISC: OnceLock<Model> = OnceLock::new();
    let disc = DISC.get_or_init(|| prism(500, 10.0, 0.5));
    match way {
        Way::Parry => disc.shape(way),
        Way::Shapes | Way::Dispatcher => BakedHull::new(disc.hull.clone()).into(),
    }
}

/// A square grid of `cells` × `cells` squares of two triangles, facing up.
fn grid(cells: u32, cell: f32) -> (Vec<Vector>, Vec<[u32; 3]>) {
    let half = cells as f32 * cell * 0.5;
    let row = cells + 1;
    let vertices = (0..row * row)
        .map(|i| Vector::new((i % row) as f32 * cell - half, 0.0, (i / row) as f32 * cell - half))
        .collect();
    let triangles = (0..cells * cells).flat_map(|i| {
        let a = i / cells * row + i % cells;
        [[a, a + row, a + 1], [a + 1, a + row, a + row + 1]]
    });
    (vertices, triangles.collect())
}
