//! A Rapier world with baked hulls is saved, loaded, and goes on as before.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::saving::{load, save};
use crate::stage::rest::rotations;
use crate::stage::way::Way;
use hullmap::Pack;
use hullmap_parry::{BakedHull, HullDispatcher, SavedShape, SavedShapeError, compound, is_custom};
use hullmap_testkit::packs::{self, point_set};
use rapier3d::prelude::*;
use shapes::families::{Family, cube_grid};

type Packages = BTreeMap<String, Arc<Pack>>;

/// Two packs: one with rocks, and one with the parts of a concave object.
fn packages() -> Packages {
    let rocks = [40, 300].map(|n| point_set(&format!("rock {n}"), &Family::Rock.points(n, 3)));
    let moved = |x: f32| cube_grid(27, 1).iter().map(|p| [0.5 * p[0] + x, 0.5 * p[1], 0.5 * p[2]]).collect::<Vec<_>>();
    let parts = [point_set("pair", &moved(-0.6)), point_set("pair", &moved(0.6))];
    BTreeMap::from([
        ("rocks".to_owned(), Arc::new(packs::parts(&rocks))),
        ("pair".to_owned(), Arc::new(packs::parts(&parts))),
    ])
}

fn world(packages: &Packages, way: Way) -> PhysicsWorld {
    let mut world = way.world();
    world.insert_collider(ColliderBuilder::cuboid(100.0, 0.5, 100.0).translation(Vector::new(0.0, -0.5, 0.0)), None);
    let rocks = [0, 1].map(|i| BakedHull::new(packages["rocks"].shared_hull(i).unwrap()));
    let mirrored: SharedShape = rocks[1].scaled(Vector::new(-0.5, 1.0, 1.5)).unwrap().into();
    let shapes = [rocks[0].clone().into(), mirrored, compound(&packages["pair"]).unwrap(), SharedShape::ball(0.6)];
    for (i, rotation) in rotations(5, 24).into_iter().enumerate() {
        let at = Vector::new((i % 3) as f32 * 1.5, 1.5 + (i / 3) as f32 * 2.5, 0.3 * (i % 5) as f32);
        // Without damping, the balls would roll on.
        let body = RigidBodyBuilder::dynamic().pose(Pose::from_parts(at, rotation)).angular_damping(1.0);
        world.insert(body, ColliderBuilder::new(shapes[i % shapes.len()].clone()));
    }
    world
}

fn positions(world: &PhysicsWorld) -> Vec<Vector> {
    world.bodies.iter().map(|(_, body)| body.translation()).collect()
}

fn farthest(a: &PhysicsWorld, b: &PhysicsWorld) -> f32 {
    positions(a).iter().zip(positions(b)).map(|(p, q)| p.distance(q)).fold(0.0, f32::max)
}

/// `.ci/nightly` runs the programs of the page in a fresh project.
#[test]
fn the_recipe_is_as_printed() {
    let page = include_str!("../../../../docs/engines.md");
    assert!(page.contains(&include_str!("saving.rs").replace("pub fn", "fn")));
}

#[test]
fn a_world_goes_on_after_saving_and_loading() {
    for way in [Way::Shapes, Way::Dispatcher] {
        let packages = packages();
        let mut world = world(&packages, way);
        (0..90).for_each(|_| world.step());
        let bytes = save(&mut world, &packages).unwrap();
        let mut loaded = load(&bytes, &packages).unwrap();
        if way == Way::Dispatcher {
            // Rapier does not save it.
            loaded.narrow_phase.set_query_dispatcher(HullDispatcher);
        }
        assert_eq!(farthest(&world, &loaded), 0.0);
        let moving = world.bodies.iter().filter(|(_, body)| body.linvel().length() > 0.1).count();
        assert!(moving >= 10, "{moving} bodies move, and would show a difference");
        // Setting a shape makes Rapier drop the stored contacts of a pair, in any world.
        let mut reset = load(&bytes, &packages).unwrap();
        let hulls = || world.colliders.iter().filter(|(_, collider)| is_custom(collider.shared_shape()));
        assert_eq!(hulls().count(), 18);
        for (handle, collider) in hulls() {
            reset.colliders.get_mut(handle).unwrap().set_shape(collider.shared_shape().clone());
        }
        reset.narrow_phase = world.narrow_phase.clone();
        for step in 0..10 {
            world.step();
            loaded.step();
            reset.step();
            assert_eq!(farthest(&reset, &loaded), 0.0, "{way:?}: after {} steps", step + 1);
            // A body may meet another one step later, and then takes another path. Most do not.
            let mut apart: Vec<f32> =
                positions(&world).iter().zip(positions(&loaded)).map(|(p, q)| p.distance(q)).collect();
            apart.sort_by(f32::total_cmp);
            println!("{way:?}: up to {:?} apart after {} steps", apart.last(), step + 1);
            let apart = apart[apart.len() * 3 / 4];
            assert!(apart < 5e-3, "{way:?}: {apart} apart after {} steps", step + 1);
        }
        (0..900).for_each(|_| loaded.step());
        let bodies = || loaded.bodies.iter().map(|(_, body)| body);
        assert!(bodies().all(|body| body.translation().y > 0.0), "{way:?}: a body fell through the floor");
        let asleep = bodies().filter(|body| body.is_sleeping()).count();
        assert!(asleep >= 20, "{way:?}: {asleep} of 24 sleep");
    }
}

#[test]
fn hulls_are_found_by_name_after_another_bake() {
    let packages = packages();
    let shape: SharedShape = BakedHull::new(packages["rocks"].shared_hull(1).unwrap()).into();
    let saved = SavedShape::from_shape(&shape, &packages).unwrap();
    // The rocks in another order.
    let rocks = [300, 40].map(|n| point_set(&format!("rock {n}"), &Family::Rock.points(n, 3)));
    let again = BTreeMap::from([("rocks".to_owned(), Arc::new(packs::parts(&rocks)))]);
    let loaded = saved.load(&again).unwrap();
    assert_eq!(loaded.as_shape::<BakedHull>().unwrap().hull().name(), "rock 300");

    let without = BTreeMap::from([("rocks".to_owned(), Arc::new(packs::parts(&rocks[1..])))]);
    let expected = SavedShapeError::NoSuchHull { pack: "rocks".into(), hull: "rock 300".into(), part: 0 };
    assert_eq!(saved.load(&without).err().unwrap(), expected);
    let message = expected.to_string();
    assert!(message.contains("bake the source") && message.contains("\"rock 300\""), "{message}");
    let no_packs = Packages::new();
    assert_eq!(saved.load(&no_packs).err().unwrap(), SavedShapeError::NoSuchPack { pack: "rocks".into() });
    let unknown = SavedShape::from_shape(&shape, &no_packs).err().unwrap();
    assert_eq!(unknown, SavedShapeError::UnknownPack { hull: "rock 300".into() });
}
