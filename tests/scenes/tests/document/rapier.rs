use std::sync::Arc;

use hullmap::Pack;
use hullmap_parry::{BakedHull, HullDispatcher};
use rapier3d::prelude::*;

pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let pack = Arc::new(Pack::open("baked/rock.hullmap")?);
    let rock = BakedHull::new(pack.shared_hull(0)?);

    let mut world = PhysicsWorld::new();
    world.narrow_phase = NarrowPhase::with_query_dispatcher(HullDispatcher); // optional, see below
    world.insert_collider(ColliderBuilder::cuboid(10.0, 0.5, 10.0), None);
    let body = RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 4.0, 0.0));
    let (rock, _) = world.insert(body, ColliderBuilder::new(rock.into()));
    for _ in 0..120 {
        world.step();
    }
    println!("the rock lies at {}", world.bodies[rock].translation());
    Ok(())
}
