//! The kept inputs of the fuzz targets, replayed without libFuzzer from the archives in
//! `fuzz/corpus`.

use std::fs;

use hullmap_testkit::files::workspace;
use hullmap_tests::fuzzed::{TARGETS, Target, unpack};

fn replay((name, run): Target) {
    let archive = fs::read(workspace().join(format!("fuzz/corpus/{name}.tar.gz"))).unwrap();
    let inputs = unpack(&archive).unwrap();
    for (input, bytes) in &inputs {
        // If the input panics, its name is the last line.
        println!("{input}");
        run(bytes);
    }
    let bytes: usize = inputs.iter().map(|(_, bytes)| bytes.len()).sum();
    println!("{name}: {} inputs, {bytes} bytes", inputs.len());
    assert!(inputs.len() >= 100 && bytes < 1 << 20, "{name}: {} inputs, {bytes} bytes", inputs.len());
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
