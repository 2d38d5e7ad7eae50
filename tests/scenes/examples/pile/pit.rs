//! The scene: bodies above a square pit.

use hullmap_scenes::model::Model;
use hullmap_scenes::rest::rotations;
use hullmap_scenes::way::Way;
use rapier3d::prelude::*;

/// Half the width of the pit.
pub const HALF_WIDTH: f32 = 6.0;

/// Bodies along each side of a layer.
const ROW: usize = 8;

/// Distance between bodies of 1 m at the start: none touch.
const SPACING: f32 = 1.4;

/// Triangles of a shape, in its frame.
pub struct Mesh {
    pub vertices: Vec<Vector>,
    pub triangles: Vec<[u32; 3]>,
}

/// A world with a floor, four walls and falling bodies.
pub struct Pit {
    /// The world, to step.
    pub world: PhysicsWorld,
    /// The bodies, each with its index in [`meshes`](Self::meshes).
    pub bodies: Vec<(RigidBodyHandle, usize)>,
    /// What the bodies look like.
    pub meshes: Vec<Mesh>,
}

impl Pit {
    /// `count` bodies of `models` in turn, in layers above the pit.
    pub fn new(models: &[Model], count: usize, way: Way) -> Self {
        let mut world = way.world();
        let floor = ColliderBuilder::cuboid(HALF_WIDTH + 1.0, 0.5, HALF_WIDTH + 1.0);
        world.insert_collider(floor.translation(Vector::new(0.0, -0.5, 0.0)), None);
        for (x, z) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            let along = |c: f32| if c == 0.0 { HALF_WIDTH + 1.0 } else { 0.5 };
            let at = Vector::new(x * (HALF_WIDTH + 0.5), 20.0, z * (HALF_WIDTH + 0.5));
            world.insert_collider(ColliderBuilder::cuboid(along(x), 20.0, along(z)).translation(at), None);
        }
        let shapes: Vec<SharedShape> = models.iter().map(|model| model.shape(way)).collect();
        let middle = (ROW - 1) as f32 * 0.5;
        let bodies = rotations(7, count).into_iter().enumerate().map(|(i, rotation)| {
            let (layer, cell) = (i / (ROW * ROW), i % (ROW * ROW));
            let across = |k: usize| (k as f32 - middle) * SPACING;
            // Every second layer is shifted, so that no column of bodies stands by itself.
            let shift = if layer % 2 == 0 { 0.0 } else { 0.3 };
            let height = 1.2 + layer as f32 * SPACING;
            let at = Vector::new(across(cell % ROW) + shift, height, across(cell / ROW) + shift);
            let body = RigidBodyBuilder::dynamic().pose(Pose::from_parts(at, rotation));
            let model = i % shapes.len();
            (world.insert(body, ColliderBuilder::new(shapes[model].clone())).0, model)
        });
        let bodies = bodies.collect();
        Self { bodies, meshes: models.iter().map(mesh).collect(), world }
    }

    /// Bodies that sleep.
    pub fn asleep(&self) -> usize {
        self.bodies.iter().filter(|(body, _)| self.world.bodies[*body].is_sleeping()).count()
    }

    /// Bodies that fell through the floor or a wall.
    pub fn lost(&self) -> usize {
        let is_out = |at: Vector| !(at.y > 0.0 && at.x.abs().max(at.z.abs()) < HALF_WIDTH);
        self.bodies.iter().filter(|(body, _)| is_out(self.world.bodies[*body].translation())).count()
    }
}

/// The faces of a hull, as fans of triangles.
fn mesh(model: &Model) -> Mesh {
    let hull = model.hull.hull();
    let mut triangles = Vec::new();
    for face in hull.faces() {
        let corners: Vec<u32> = face.collect();
        triangles.extend(corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]));
    }
    Mesh { vertices: hull.vertices().collect(), triangles }
}
