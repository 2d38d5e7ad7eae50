use std::sync::Arc;

use hullmap::{Pack, TriangleMesh};
use hullmap_parry::{BakedHull, BakedSurface, HullDispatcher};
use rapier3d::prelude::*;

pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let level = BakedSurface::new(Arc::new(TriangleMesh::open("baked/gear.hullmesh")?));
    let rock = BakedHull::new(Arc::new(Pack::open("baked/rock.hullmap")?).shared_hull(0)?);

    let mut world = PhysicsWorld::new();
    world.narrow_phase = NarrowPhase::with_query_dispatcher(HullDispatcher);
    let z_up = Vector::X * -std::f32::consts::FRAC_PI_2;
    world.insert_collider(ColliderBuilder::new(level.into()).rotation(z_up), None);
    let body = RigidBodyBuilder::dynamic().translation(Vector::new(1.0, 6.0, 0.0)).ccd_enabled(true);
    let (rock, _) = world.insert(body, ColliderBuilder::new(rock.into()));
    for _ in 0..240 {
        world.step();
    }
    println!("the rock lies at {}", world.bodies[rock].translation());
    Ok(())
}
