use std::collections::BTreeMap;
use std::sync::Arc;

use hullmap::Pack;
use hullmap_parry::{BakedHull, HullDispatcher, SavedShape, is_custom};
use rapier3d::prelude::*;

type Packs = BTreeMap<String, Arc<Pack>>;
type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// The bytes of a world. Meanwhile, shapes that parry cannot serialise are replaced by balls.
pub fn save(world: &mut PhysicsWorld, packs: &Packs) -> Outcome<Vec<u8>> {
    let mut colliders = world.colliders.clone();
    let mut shapes = Vec::new();
    for (handle, collider) in colliders.iter_mut().filter(|(_, collider)| is_custom(collider.shared_shape())) {
        shapes.push((handle, SavedShape::from_shape(collider.shared_shape(), packs)?));
        collider.set_shape(SharedShape::ball(1.0));
    }
    std::mem::swap(&mut world.colliders, &mut colliders);
    let bytes = postcard::to_stdvec(&(&*world, &shapes));
    std::mem::swap(&mut world.colliders, &mut colliders);
    Ok(bytes?)
}

/// The world, with its shapes put back.
pub fn load(bytes: &[u8], packs: &Packs) -> Outcome<PhysicsWorld> {
    let (mut world, shapes): (PhysicsWorld, Vec<(ColliderHandle, SavedShape)>) = postcard::from_bytes(bytes)?;
    for (handle, shape) in shapes {
        let collider = world.colliders.get_mut(handle).ok_or("a saved shape has no collider")?;
        collider.set_shape(shape.load(packs)?);
    }
    Ok(world)
}

pub fn main() -> Outcome<()> {
    let pack = Arc::new(Pack::open("baked/rock.hullmap")?);
    let rock = BakedHull::new(pack.shared_hull(0)?);
    let mut world = PhysicsWorld::new();
    world.insert(RigidBodyBuilder::dynamic(), ColliderBuilder::new(rock.into()));

    let packs = Packs::from([("rock".to_owned(), pack)]);
    let bytes = save(&mut world, &packs)?;
    let mut world = load(&bytes, &packs)?;
    world.narrow_phase.set_query_dispatcher(HullDispatcher); // in mode B: Rapier does not save it
    world.step();
    assert!(world.colliders.iter().all(|(_, collider)| is_custom(collider.shared_shape())));
    Ok(())
}
