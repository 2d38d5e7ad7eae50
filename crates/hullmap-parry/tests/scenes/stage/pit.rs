//! Bodies that fall into a square pit, and pile up.

use hullmap::{Cache, Settings};
use rapier3d::prelude::*;

use super::model::Model;
use super::rest::rotations;
use super::way::Way;

/// Distance between bodies of 1 m at the start: none touch.
const SPACING: f32 = 1.4;

/// Distance that the outermost bodies keep from the walls at the start.
const MARGIN: f32 = 0.3;

/// A world with a floor, four walls and falling bodies.
pub struct Pit<'m> {
    /// The world, to step.
    pub world: PhysicsWorld,
    /// The bodies, each with its model.
    pub bodies: Vec<(RigidBodyHandle, &'m Model)>,
    /// Half the width of the pit.
    pub half_width: f32,
}

impl<'m> Pit<'m> {
    /// `count` bodies of `models` in turn, 1 m long, in layers above the pit, rotated at random by
    /// `seed`.
    pub fn new(models: &'m [Model], count: usize, half_width: f32, seed: u64, way: Way) -> Self {
        let mut world = way.world();
        let floor = ColliderBuilder::cuboid(half_width + 1.0, 0.5, half_width + 1.0);
        world.insert_collider(floor.translation(Vector::new(0.0, -0.5, 0.0)), None);
        for (x, z) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            let along = |c: f32| if c == 0.0 { half_width + 1.0 } else { 0.5 };
            let at = Vector::new(x * (half_width + 0.5), 20.0, z * (half_width + 0.5));
            world.insert_collider(ColliderBuilder::cuboid(along(x), 20.0, along(z)).translation(at), None);
        }
        let shapes: Vec<SharedShape> = models.iter().map(|model| model.shape(way)).collect();
        let row = (((half_width - MARGIN) * 2.0 / SPACING) as usize).max(1);
        let middle = (row - 1) as f32 * 0.5;
        let bodies = rotations(seed, count).into_iter().enumerate().map(|(i, rotation)| {
            let (layer, cell) = (i / (row * row), i % (row * row));
            let across = |k: usize| (k as f32 - middle) * SPACING;
            // Every second layer is shifted, so that no column of bodies stands by itself.
            let shift = if layer % 2 == 0 { 0.0 } else { 0.3 };
            let height = 1.2 + layer as f32 * SPACING;
            let at = Vector::new(across(cell % row) + shift, height, across(cell / row) + shift);
            let body = RigidBodyBuilder::dynamic().pose(Pose::from_parts(at, rotation));
            let model = i % shapes.len();
            (world.insert(body, ColliderBuilder::new(shapes[model].clone())).0, &models[model])
        });
        let bodies = bodies.collect();
        Self { bodies, half_width, world }
    }

    /// Bodies that sleep.
    pub fn asleep(&self) -> usize {
        self.bodies.iter().filter(|(body, _)| self.world.bodies[*body].is_sleeping()).count()
    }

    /// Bodies that fell through the floor or a wall.
    pub fn lost(&self) -> usize {
        let is_out = |at: Vector| !(at.y > 0.0 && at.x.abs().max(at.z.abs()) < self.half_width);
        self.bodies.iter().filter(|(body, _)| is_out(self.world.bodies[*body].center_of_mass())).count()
    }

    /// Depth of the deepest point of a body in another body, the floor or a wall.
    pub fn deepest(&self) -> f32 {
        let placed: Vec<(Pose, &Model)> =
            self.bodies.iter().map(|(body, model)| (*self.world.bodies[*body].position(), *model)).collect();
        let mut deepest = 0.0_f32;
        for (i, (pose, model)) in placed.iter().enumerate() {
            for outward in [-Vector::Y, Vector::X, -Vector::X, Vector::Z, -Vector::Z] {
                let wall = if outward == -Vector::Y { 0.0 } else { self.half_width };
                deepest = deepest.max(model.extent(*pose, outward) - wall);
            }
            for (other, on) in &placed[..i] {
                if pose.translation.distance(other.translation) > model.radius() + on.radius() {
                    continue;
                }
                let b_in_a = hullmap::Pose::new(
                    (pose.inverse() * other.translation).as_dvec3(),
                    (pose.rotation.inverse() * other.rotation).as_dquat(),
                );
                let b_in_a = b_in_a.expect("a finite pose");
                for (a, b) in model.parts.iter().flat_map(|a| on.parts.iter().map(move |b| (a, b))) {
                    let contact = hullmap::contact(a.hull(), b.hull(), b_in_a, &Settings::default(), &mut Cache::new());
                    deepest = deepest.max(contact.depth as f32);
                }
            }
        }
        deepest
    }
}
