//! First inputs of the fuzz targets that read packs, meshes, fields and numbers. Without them,
//! nearly all inputs fail the first check. The corpus of `import` has source files of all formats.

use shapes::rng::SplitMix64;

use super::change_pack;
use crate::hostile::{samples, sheets};

/// Number of random inputs for each target that reads numbers.
const DRAWN: usize = 64;

/// Maximum length of a random input, in bytes.
const MAX_DRAWN_LEN: usize = 400;

/// Maximum size of a pack, in bytes.
const MAX_PACK_LEN: usize = 4096;

/// Number of inputs for each mesh and field: as it is, and with a few changed words.
const VARIANTS: u32 = 8;

/// Names and bytes of the first inputs of a target; empty for `import`.
pub fn seeds(target: &str) -> Vec<(String, Vec<u8>)> {
    let random = |seed: u64| {
        let mut rng = SplitMix64::new(seed);
        let drawn = |index: usize| {
            let bytes = (0..8 + rng.below(MAX_DRAWN_LEN)).map(|_| rng.next_u64() as u8).collect();
            (format!("drawn-{index:02}"), bytes)
        };
        (0..DRAWN).map(drawn).collect()
    };
    match target {
        "open_and_query" => samples::small()
            .into_iter()
            .filter(|sample| sample.file.len() <= MAX_PACK_LEN)
            .map(|sample| (sample.name.replace([' ', ','], "-"), sample.file))
            .collect(),
        "open_sheets" => sheets::small()
            .into_iter()
            .filter(|sample| sample.file.len() <= MAX_PACK_LEN)
            .flat_map(|sample| (0..VARIANTS).map(move |variant| variant_of(&sample, variant)))
            .collect(),
        "solver" => random(1),
        "build_open_verify" => random(2),
        _ => Vec::new(),
    }
}

/// A sample, or the sample with a few changed words.
fn variant_of(sample: &samples::Sample, variant: u32) -> (String, Vec<u8>) {
    let mut file = sample.file.clone();
    if variant > 0 {
        change_pack(&mut file, variant);
    }
    (format!("{}-{variant}", sample.name.replace([' ', ','], "-")), file)
}
