//! The programs of docs/engines.md compile and run as they are printed. `.ci/nightly` also builds
//! them in a fresh project, with the dependencies that the page names.

use std::path::Path;
use std::{env, fs};

use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_scenes::model::triangles;
use hullmap_testkit::packs::{self, point_set};
use shapes::families::Family;

#[path = "document/level.rs"]
mod level;
#[path = "document/rapier.rs"]
mod rapier;
#[path = "document/saving.rs"]
mod saving;

#[test]
fn the_programs_run_as_printed() {
    let document = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/engines.md")).unwrap();
    let printed: Vec<&str> =
        document.split("```rust\n").skip(1).filter_map(|rest| rest.split_once("```").map(|(code, _)| code)).collect();
    // Here, they are modules.
    let sources =
        [include_str!("document/rapier.rs"), include_str!("document/level.rs"), include_str!("document/saving.rs")];
    assert_eq!(printed, sources.map(|source| source.replace("pub fn", "fn")));

    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("document");
    fs::create_dir_all(folder.join("baked")).unwrap();
    let set = point_set("rock", &Family::Rock.points(300, 1));
    let bytes = packs::bytes(&[set], IndexKind::Tree, &SourceRecord::default()).unwrap();
    fs::write(folder.join("baked/rock.hullmap"), bytes).unwrap();
    let (positions, corners) = triangles(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/gear.obj"));
    let positions: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|x| 10.0 * x)).collect();
    let gear = bake_triangle_mesh(&Triangles { positions: &positions, corners: &corners, materials: &[] }).unwrap();
    fs::write(folder.join("baked/gear.hullmesh"), write_triangle_mesh(gear, &Default::default()).unwrap()).unwrap();
    // The only test of this program, so no other test uses the working folder.
    env::set_current_dir(&folder).unwrap();
    rapier::main().unwrap();
    level::main().unwrap();
    saving::main().unwrap();
}
