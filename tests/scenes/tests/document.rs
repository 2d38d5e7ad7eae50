//! The first example of docs/engines.md compiles and runs as it is printed.

use std::path::Path;
use std::sync::Arc;
use std::{env, fs};

use hullmap::Pack;
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_parry::{BakedHull, HullDispatcher};
use hullmap_testkit::packs::{self, point_set};
use rapier3d::prelude::*;
use shapes::families::Family;

fn example() -> Result<PhysicsWorld, Box<dyn std::error::Error>> {
    // <example>
    let pack = Arc::new(Pack::open("baked/rock.hullmap")?);
    let rock = BakedHull::new(pack.shared_hull(0)?);

    let mut world = PhysicsWorld::new();
    world.narrow_phase = NarrowPhase::with_query_dispatcher(HullDispatcher); // optional, see below
    world.insert(RigidBodyBuilder::dynamic(), ColliderBuilder::new(rock.into()));
    // </example>
    Ok(world)
}

#[test]
fn the_example_runs_as_printed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let document = fs::read_to_string(root.join("docs/engines.md")).unwrap();
    let printed = document.split("```rust\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let source = fs::read_to_string(root.join("tests/scenes").join("tests/document.rs")).unwrap();
    let body = source.split("// <example>\n").nth(1).and_then(|rest| rest.split("// </example>").next()).unwrap();
    let lines = |text: &str| -> Vec<String> {
        text.lines().map(|line| line.trim().to_owned()).filter(|line| !line.is_empty()).collect()
    };
    let (imports, code): (Vec<_>, Vec<_>) = lines(printed).into_iter().partition(|line| line.starts_with("use "));
    assert_eq!(code, lines(body));
    assert!(
        imports.len() == 4 && imports.iter().all(|import| source.contains(&format!("\n{import}\n"))),
        "{imports:?}"
    );

    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("document");
    fs::create_dir_all(folder.join("baked")).unwrap();
    let set = point_set("rock", &Family::Rock.points(300, 1));
    let bytes = packs::bytes(&[set], IndexKind::Tree, &SourceRecord::default()).unwrap();
    fs::write(folder.join("baked/rock.hullmap"), bytes).unwrap();
    // The only test of this program, so nobody else has a working folder.
    env::set_current_dir(&folder).unwrap();
    let mut world = example().unwrap();
    let height = |world: &PhysicsWorld| world.bodies.iter().map(|(_, body)| body.translation().y).sum::<f32>();
    let before = height(&world);
    (0..10).for_each(|_| world.step());
    assert!(height(&world) < before, "it falls");
}
