//! What fuzzing found worth keeping, replayed: every input of `fuzz/corpus`, without libFuzzer.

use std::{fs, path::PathBuf};

use hullmap_tests::{
    fuzzed::{TARGETS, Target, seeds},
    outside::workspace,
};

/// Inputs of a target in the order of their names.
fn corpus(target: &str) -> Vec<PathBuf> {
    let folder = workspace().join("fuzz/corpus").join(target);
    let entries = fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

fn replay((name, run): Target) {
    let files = corpus(name);
    for file in &files {
        // Told by the last line if it panics.
        println!("{}", file.file_name().unwrap_or_default().display());
        run(&fs::read(file).unwrap());
    }
    println!("{name}: {} inputs", files.len());
    assert!(files.len() >= 10, "{name} has {} inputs", files.len());
}

#[test]
fn open_and_query() {
    replay(TARGETS[0]);
}

#[test]
fn solver() {
    replay(TARGETS[1]);
}

#[test]
fn build_open_verify() {
    replay(TARGETS[2]);
}

#[test]
fn import() {
    replay(TARGETS[3]);
}

#[test]
fn seeds_run() {
    for (name, run) in TARGETS {
        let seeds = seeds::seeds(name);
        assert!(seeds.len() >= 10, "{name}");
        seeds.iter().for_each(|(_, bytes)| run(bytes));
    }
}

#[test]
fn the_corpus_is_small() {
    let len = |file: &PathBuf| fs::metadata(file).unwrap().len();
    let bytes: u64 = TARGETS.iter().flat_map(|(name, _)| corpus(name)).map(|file| len(&file)).sum();
    println!("{bytes} bytes");
    assert!(bytes < 1 << 20, "{bytes} bytes");
}
