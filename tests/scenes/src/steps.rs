//! Many bodies on a cuboid: the time of a step while they fall into a pile, and when it is settled.

use std::time::Duration;

use hullmap_outside::clock::thread_time;
use rapier3d::prelude::*;

use crate::model::Model;
use crate::rest::rotations;
use crate::way::Way;

/// A pile of bodies.
pub struct Pile {
    /// The world, to step.
    pub world: PhysicsWorld,
}

impl Pile {
    /// `count` bodies of `models` in turn, in layers of 7 × 7 above a cuboid with four walls.
    pub fn new(models: &[Model], count: usize, way: Way) -> Self {
        let mut world = way.world();
        let floor = ColliderBuilder::cuboid(40.0, 0.5, 40.0).translation(Vector::new(0.0, -0.5, 0.0));
        world.insert_collider(floor, None);
        for (x, z) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            let half = Vector::new(if x == 0.0 { 7.0 } else { 0.5 }, 20.0, if z == 0.0 { 7.0 } else { 0.5 });
            let wall = ColliderBuilder::cuboid(half.x, half.y, half.z).translation(Vector::new(x * 6.5, 20.0, z * 6.5));
            world.insert_collider(wall, None);
        }
        let shapes: Vec<SharedShape> = models.iter().map(|model| model.shape(way)).collect();
        for (i, rotation) in rotations(7, count).into_iter().enumerate() {
            let (layer, cell) = (i / 49, i % 49);
            let offset = if layer % 2 == 0 { 0.0 } else { 0.3 };
            let x = (cell % 7) as f32 * 1.6 - 4.8 + offset;
            let z = (cell / 7) as f32 * 1.6 - 4.8 + offset;
            let at = Vector::new(x, 1.2 + layer as f32 * 1.4, z);
            let body = RigidBodyBuilder::dynamic().pose(Pose::from_parts(at, rotation)).can_sleep(false);
            world.insert(body, ColliderBuilder::new(shapes[i % shapes.len()].clone()));
        }
        Self { world }
    }

    /// Time of `steps` steps.
    pub fn step(&mut self, steps: usize) -> Duration {
        timed_steps(&mut self.world, steps)
    }
}

/// Processor time of `steps` steps of a world.
pub fn timed_steps(world: &mut PhysicsWorld, steps: usize) -> Duration {
    let start = thread_time();
    for _ in 0..steps {
        world.step();
    }
    thread_time() - start
}
