//! Upright prisms, alone or in a stack.

use rapier3d::prelude::*;

use super::floor::Floor;
use super::model::prism;
use super::way::Way;

/// How a stack ended.
#[derive(Clone, Copy, Debug)]
pub struct Standing {
    /// Maximum tilt of a prism's axis, in degrees.
    pub tilt_degrees: f32,
    /// Bodies that sleep at the end.
    pub asleep: usize,
    /// Maximum distance of a prism's centre from the vertical line that it started on.
    pub drift: f32,
    /// Distance by which the topmost centre is below its place in a perfect stack.
    pub sunk: f32,
}

/// Puts `count` prisms of `sides` sides (1 m wide, 0.5 m high) on each other and simulates
/// `seconds`.
pub fn stand(sides: usize, count: usize, floor: Floor, way: Way, seconds: f32) -> Standing {
    let (model, height) = (prism(sides, 0.5, 0.25), 0.5);
    let mut world = way.world();
    world.insert_collider(floor.collider(way), None);
    let start = [0.31, 0.17];
    let place = |i: usize| Vector::new(start[0], (i as f32 + 0.5) * height, start[1]);
    let bodies: Vec<RigidBodyHandle> = (0..count)
        .map(|i| {
            let body = RigidBodyBuilder::dynamic().translation(place(i));
            world.insert(body, ColliderBuilder::new(model.shape(way))).0
        })
        .collect();
    for _ in 0..(seconds * 60.0) as u32 {
        world.step();
    }
    let mut standing = Standing { tilt_degrees: 0.0, asleep: 0, drift: 0.0, sunk: 0.0 };
    for (i, handle) in bodies.iter().enumerate() {
        let body = &world.bodies[*handle];
        let axis = *body.rotation() * Vector::Y;
        let tilt = axis.cross(Vector::Y).length().atan2(axis.y).to_degrees();
        let offset = body.translation() - place(i);
        standing.tilt_degrees = standing.tilt_degrees.max(tilt);
        standing.asleep += usize::from(body.is_sleeping());
        standing.drift = standing.drift.max(Vector::new(offset.x, 0.0, offset.z).length());
        standing.sunk = -offset.y;
    }
    standing
}
