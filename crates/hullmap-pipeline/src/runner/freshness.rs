//! Freshness: whether a pack is what a bake would write, judged by its bytes, never by time stamps.
//!
//! A file is fresh if its header holds this format version and the hash of the
//! source's bytes; if it records the options and the source's path; and if it opens, which checks a
//! checksum over every byte. A stale header is detected after 64 bytes; checking a fresh pack costs
//! less than hashing its source.

use std::io::{self, Read};
use std::path::Path;

use hullmap::Asset;
use hullmap_format::header::{HEADER_LEN, Header, options_hash};
use hullmap_import::open_regular;

use crate::jobs::Job;
use crate::open::open_asset;
use crate::options::BuildOptions;
use crate::options::removed::instead_of_record;

const SOURCE_CHANGED: &str = "the source has changed";

#[derive(Debug)]
pub struct Expected<'a> {
    pub source_hash: u128,
    pub job: &'a Job,
    /// The source's path, as a bake would record it.
    pub recorded_path: &'a str,
}

#[derive(Debug)]
pub enum Found {
    Fresh(Asset),
    Stale(String),
    Missing,
}

/// Complexity: one read of 64 bytes, and for the right header one pass over the bytes.
pub fn judge(path: &Path, expected: &Expected) -> Found {
    let mut bytes = Vec::with_capacity(HEADER_LEN);
    let read = open_regular(path).and_then(|file| file.take(HEADER_LEN as u64).read_to_end(&mut bytes));
    match read {
        Ok(_) => {}
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Found::Missing,
        Err(error) => return Found::Stale(format!("the pack cannot be read: {error}")),
    }
    let header = match Header::read_kind(&bytes, expected.job.options.file_kind()) {
        Ok(header) => header,
        Err(error) => return Found::Stale(error.to_string()),
    };
    let source_changed = header.source_hash != expected.source_hash;
    let text = expected.job.options.to_string();
    if source_changed && header.options_hash == options_hash(&text) {
        return Found::Stale(SOURCE_CHANGED.to_owned());
    }
    // The hash of the options of a pack with warnings covers them too, so the pack has to be read.
    match open_asset(path) {
        Err(_) if source_changed => Found::Stale(SOURCE_CHANGED.to_owned()),
        Err(failure) => {
            // The message starts with the pack's path, which the row shows already.
            let path = format!("{}: ", path.display());
            Found::Stale(failure.message.strip_prefix(&path).unwrap_or(&failure.message).to_owned())
        }
        // Another bake may have replaced it meanwhile.
        Ok(pack) if *pack.header() != header => Found::Stale("the pack was replaced while it was read".to_owned()),
        Ok(pack) if source_changed || pack.options() != text => {
            let mut reasons = Vec::new();
            if source_changed {
                reasons.push(SOURCE_CHANGED.to_owned());
            }
            if pack.options() != text {
                let was = BuildOptions::recorded_in_words(pack.options());
                reasons.push(format!(
                    "the options have changed from `{was}` to `{}`",
                    BuildOptions::recorded_in_words(&text)
                ));
                reasons.extend(instead_of_record(pack.options()).map(str::to_owned));
            }
            Found::Stale(reasons.join("; "))
        }
        Ok(pack) if !expected.job.accepts_record(pack.source_path(), expected.recorded_path) => {
            let was = pack.source_path();
            Found::Stale(format!("the pack records its source as `{was}`, but it is `{}`", expected.recorded_path))
        }
        Ok(pack) => Found::Fresh(pack),
    }
}
