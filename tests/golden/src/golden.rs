//! The golden file: a line with the format version, then one line `name hash` per hash.

use std::{collections::BTreeMap, fmt::Write};

use hullmap_format::FORMAT_VERSION;
use rayon::prelude::*;

use crate::{
    answers::{self, CHUNKS, PER_CHUNK},
    packs::{self, Set},
};

/// Answers of each kind in the small set.
const SMALL: usize = 3;

const VERSION: &str = "format-version";

/// Contents of the golden file, or computed hashes to compare with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Golden {
    /// Format version of the packs.
    pub format_version: u32,
    /// Hashes by name.
    pub hashes: BTreeMap<String, u64>,
}

impl Golden {
    /// Bakes and queries the small set.
    pub fn small() -> Self {
        let files = packs::files(Set::Small);
        let chunk = answers::chunk(&packs::opened(&files), 0, SMALL);
        Self::new("small", packs::hashes(&files), answers::joined(&[chunk]))
    }

    /// Bakes and queries the large set on rayon's pool.
    pub fn large() -> Self {
        let files = packs::files(Set::Large);
        let opened = packs::opened(&files);
        let chunks: Vec<_> =
            (0..CHUNKS).into_par_iter().map(|index| answers::chunk(&opened, index, PER_CHUNK)).collect();
        Self::new("large", packs::hashes(&files), answers::joined(&chunks))
    }

    fn new(set: &str, packs: Vec<(String, u64)>, answers: Vec<(String, u64)>) -> Self {
        let hashes = packs.into_iter().chain(answers).map(|(name, hash)| (format!("{set} {name}"), hash)).collect();
        Self { format_version: FORMAT_VERSION, hashes }
    }

    /// The hashes of both sets.
    pub fn join(mut self, other: Self) -> Self {
        self.hashes.extend(other.hashes);
        self
    }

    /// Parses the text of the golden file. The error is the first invalid line.
    pub fn read(text: &str) -> Result<Self, String> {
        let (mut format_version, mut hashes) = (0, BTreeMap::new());
        for line in text.lines().filter(|line| !line.starts_with('#') && !line.is_empty()) {
            let wrong = || format!("{line:?} is not a line of a golden file; renew the file");
            let (name, value) = line.rsplit_once(' ').ok_or_else(wrong)?;
            if name == VERSION {
                format_version = value.parse().map_err(|_| wrong())?;
            } else {
                hashes.insert(name.to_owned(), u64::from_str_radix(value, 16).map_err(|_| wrong())?);
            }
        }
        Ok(Self { format_version, hashes })
    }

    /// The text of the golden file.
    pub fn text(&self) -> String {
        let mut text = String::from(
            "# XXH3-64 of packs and of answers. Renew by `cargo run --release -p hullmap-golden -- --renew`.\n",
        );
        let mut line = |name: &str, value: String| writeln!(text, "{name} {value}").expect("a string takes all");
        line(VERSION, self.format_version.to_string());
        self.hashes.iter().for_each(|(name, hash)| line(name, format!("{hash:016x}")));
        text
    }

    /// Describes each hash of `found` that differs from the one here, or is missing here, in one
    /// line. The bytes of packs must never change within a format version.
    pub fn differences(&self, found: &Self) -> Vec<String> {
        let mut lines = Vec::new();
        for (name, hash) in &found.hashes {
            let golden = self.hashes.get(name);
            if golden == Some(hash) {
                continue;
            }
            let is_pack = name.contains(" pack ");
            let golden = golden.map_or("missing".to_owned(), |golden| format!("{golden:016x}"));
            let remedy = match (is_pack, self.format_version == found.format_version) {
                (true, true) => {
                    "the bytes of this format version changed: raise FORMAT_VERSION and give the reason in docs/contributors/FORMAT.md"
                }
                _ => "if the change is intended, renew the file",
            };
            lines.push(format!("{name}: found {hash:016x}, golden {golden}; {remedy}"));
        }
        lines
    }
}
