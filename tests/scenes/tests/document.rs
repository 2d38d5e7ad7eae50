//! The programs of docs/engines.md compile and run as they are printed. `.ci/nightly` also builds
//! them in a fresh project, with the dependencies that the page names.

use std::path::Path;
use std::{env, fs};

use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_testkit::packs::{self, point_set};
use shapes::families::Family;

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
    let sources = [include_str!("document/rapier.rs"), include_str!("document/saving.rs")];
    assert_eq!(printed, sources.map(|source| source.replace("pub fn", "fn")));

    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("document");
    fs::create_dir_all(folder.join("baked")).unwrap();
    let set = point_set("rock", &Family::Rock.points(300, 1));
    let bytes = packs::bytes(&[set], IndexKind::Tree, &SourceRecord::default()).unwrap();
    fs::write(folder.join("baked/rock.hullmap"), bytes).unwrap();
    // The only test of this program, so nobody else has a working folder.
    env::set_current_dir(&folder).unwrap();
    rapier::main().unwrap();
    saving::main().unwrap();
}
