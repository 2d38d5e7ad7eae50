//! Bodies come to rest on every kind of floor, and prisms stand.

use hullmap_testkit::files;

use crate::stage::floor::Floor;
use crate::stage::model::{Model, generated, meshes};
use crate::stage::pit::Pit;
use crate::stage::rest::{Outcome, STEP_SECONDS, drop, rotations};
use crate::stage::stack::stand;
use crate::stage::way::Way;

const BAKED: [Way; 2] = [Way::Shapes, Way::Dispatcher];

/// The meshes in the folder that `HULLMAP_MESHES` names, if any, and generated bodies.
fn models(size: f32) -> Vec<Model> {
    let mut models = generated(size);
    // Smooth round bodies roll on, in every engine.
    models.retain(|model| !["sphere", "lens"].contains(&model.name.as_str()));
    if let Some(folder) = files::path("HULLMAP_MESHES", "bodies of meshes by others") {
        models.extend(meshes(&folder, size));
    }
    models
}

/// At least seven in eight sleep after 10 s, none is stuck in the floor, and none gains energy. No
/// more bodies are lost than of parry's hulls: floors of no thickness lose fast bodies, and Rapier
/// considers 0.1 m small.
fn most_come_to_rest(ways: &[Way], floor: Floor, size: f32) {
    for &way in ways {
        let (mut asleep, mut count, mut lost) = (0, 0, 0);
        for model in models(size) {
            for rotation in rotations(1, 2) {
                let outcome = drop(&model, size, rotation, floor, way, 10.0);
                let place = format!("{} on {floor:?}, {way:?}: {outcome:?}", model.name);
                // Mode A forgets its points in every step. Some bodies gain up to twice the limit.
                let most = if way == Way::Dispatcher { Outcome::GAIN } else { 2.0 * Outcome::GAIN };
                assert!(!outcome.is_stuck() && outcome.gained <= most, "{place}");
                if outcome.lost {
                    println!("lost: {place}");
                }
                count += 1;
                lost += usize::from(outcome.lost);
                asleep += usize::from(outcome.asleep_after.is_some());
                if outcome.asleep_after.is_none() {
                    println!("awake: {place}");
                }
            }
        }
        if lost > 0 {
            let of_parry = models(size)
                .iter()
                .flat_map(|model| rotations(1, 2).into_iter().map(move |rotation| (model, rotation)))
                .filter(|(model, rotation)| drop(model, size, *rotation, floor, Way::Parry, 10.0).lost)
                .count();
            assert!(lost <= of_parry, "{lost} lost through {floor:?}, {way:?}; {of_parry} of parry's");
        }
        assert!(asleep * 8 >= count * 7, "{asleep} of {count} sleep on {floor:?}, {way:?}");
    }
}

macro_rules! floors {
    ($($name:ident: $floor:ident, $size:literal, $ways:expr;)*) => {
        $(#[test]
        fn $name() {
            most_come_to_rest($ways, Floor::$floor, $size);
        })*
    };
}

floors! {
    on_a_cuboid: Cuboid, 1.0, &BAKED;
    on_a_baked_hull: Hull, 1.0, &BAKED;
    on_a_half_space: HalfSpace, 1.0, &BAKED;
    on_a_triangle_mesh: TriangleMesh, 1.0, &BAKED;
    on_a_compound: Compound, 1.0, &BAKED;
    on_a_baked_mesh: BakedMesh, 1.0, &BAKED;
    on_a_height_field: HeightField, 1.0, &BAKED;
    // In mode A, parry solves each triangle alone, and 10 of 12 generated bodies sleep.
    on_a_rough_height_field: Rough, 1.0, &[Way::Dispatcher];
    small_bodies_on_a_cuboid: Cuboid, 0.1, &BAKED;
}

/// Half of the bodies of a pit stayed awake in mode A, since a body that rocks keeps bodies awake
/// that touch it.
#[test]
fn a_pile_comes_to_rest() {
    let models = models(1.0);
    for way in BAKED {
        for seed in [1, 2] {
            let mut pit = Pit::new(&models, 24, 2.0, seed, way);
            (0..(20.0 / STEP_SECONDS) as u32).for_each(|_| pit.world.step());
            let (asleep, lost, deepest) = (pit.asleep(), pit.lost(), pit.deepest());
            let rests = asleep == pit.bodies.len() && lost == 0 && deepest < 0.05;
            assert!(rests, "seed {seed}, {way:?}: {asleep} asleep, {lost} lost, {} mm deep", deepest * 1e3);
        }
    }
}

#[test]
fn prisms_stand_upright() {
    for way in BAKED {
        for floor in [Floor::Cuboid, Floor::Hull, Floor::HalfSpace] {
            for sides in [3, 5, 8, 16, 64, 500] {
                let standing = stand(sides, 1, floor, way, 3.0);
                let upright = standing.tilt_degrees < 0.02 && standing.asleep == 1 && standing.drift < 1e-3;
                assert!(upright, "{sides} sides on {floor:?}, {way:?}: {standing:?}");
            }
        }
    }
}

#[test]
fn stacks_of_ten_prisms_stand() {
    for way in BAKED {
        for sides in [4, 8, 64, 500] {
            let standing = stand(sides, 10, Floor::Cuboid, way, 10.0);
            let stands = standing.tilt_degrees < 3.0 && standing.sunk < 0.06 && standing.asleep == 10;
            assert!(stands, "{sides} sides, {way:?}: {standing:?}");
        }
    }
}
