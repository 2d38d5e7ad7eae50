//! The kept inputs of the fuzz targets, replayed without libFuzzer from the archives in
//! `fuzz/corpus`.

use std::fs;

use hullmap_testkit::files::workspace;
use hullmap_tests::fuzzed::{
    TARGETS, Target,
    corpus::{self, Input},
    seeds,
};

fn archive(target: &str) -> Vec<u8> {
    let path = corpus::archive_path(&workspace().join("fuzz/corpus"), target);
    fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn inputs(target: &str) -> Vec<Input> {
    corpus::unpack(&archive(target)).unwrap_or_else(|error| panic!("{target}: {error}"))
}

fn replay((name, run): Target) {
    let inputs = inputs(name);
    for (input, bytes) in &inputs {
        // If the input panics, its name is the last line.
        println!("{input}");
        run(bytes);
    }
    println!("{name}: {} inputs", inputs.len());
    assert!(inputs.len() >= 100, "{name} has {} inputs", inputs.len());
}

macro_rules! targets {
    ($($name:ident $index:literal)*) => {
        $(#[test]
        fn $name() {
            replay(TARGETS[$index]);
        })*
    };
}

targets! { open_and_query 0 solver 1 build_open_verify 2 import 3 open_sheets 4 }

#[test]
fn seeds_run() {
    for (name, run) in TARGETS.into_iter().filter(|(name, _)| *name != "import") {
        let seeds = seeds::seeds(name);
        assert!(seeds.len() >= 10, "{name}");
        seeds.iter().for_each(|(_, bytes)| run(bytes));
    }
}

#[test]
fn the_corpus_is_small() {
    let bytes: usize = TARGETS.iter().flat_map(|(name, _)| inputs(name)).map(|(_, bytes)| bytes.len()).sum();
    println!("{bytes} bytes");
    assert!(bytes < 1 << 20, "{bytes} bytes");
}

/// An archive that is packed again has the same bytes if its inputs are the same.
#[test]
fn archives_are_what_fuzz_corpus_packs() {
    for (name, _) in TARGETS {
        assert!(corpus::pack(inputs(name)).unwrap() == archive(name), "{name}: pack it with fuzz-corpus");
    }
}
