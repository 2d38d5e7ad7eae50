//! Opening baked files, with the exit code for each error, and the remarks in them.

use std::path::Path;

use hullmap::{Asset, OpenError, Pack};
use hullmap_format::header::FileKind;
use hullmap_import::open_regular;

use crate::outcome::Failure;

const MAX_REMARKS: usize = 100;

const MAX_REMARK: usize = 10_000;

/// The first bytes decide what a file holds.
pub fn open_asset(path: &Path) -> Result<Asset, Failure> {
    // `Asset::open` would wait for a pipe.
    if path.exists()
        && !path.is_file()
        && let Err(error) = open_regular(path)
    {
        return Err(Failure::usage(format!("{}: cannot read: {error}; name a baked file", path.display())));
    }
    Asset::open(path).map_err(|error| match &error {
        OpenError::Io { .. } => Failure::usage(error.to_string()),
        OpenError::Invalid { .. } => Failure::rejected(error.to_string()),
    })
}

pub fn open_pack(path: &Path) -> Result<Pack, Failure> {
    match open_asset(path)? {
        Asset::Pack(pack) => Ok(pack),
        other => Err(Failure::rejected(format!(
            "{}: is a {}, but hulls are required; bake its source without options of another kind",
            path.display(),
            noun(other.header().kind)
        ))),
    }
}

/// Name of a kind of file in messages.
pub fn noun(kind: FileKind) -> &'static str {
    match kind {
        FileKind::Pack => "pack",
        FileKind::TriangleMesh => "triangle mesh",
        FileKind::HeightField => "height field",
    }
}

/// The recorded warnings, within limits, because the file may be hostile.
pub fn kept_warnings(asset: &Asset) -> Vec<String> {
    bounded_remarks(asset.warnings().into_iter(), str::to_owned)
}

/// Remarks from elsewhere within limits, each as `here` shows it.
pub fn bounded_remarks<'a>(remarks: impl Iterator<Item = &'a str>, here: impl Fn(&str) -> String) -> Vec<String> {
    let bounded = |text: &str| text.chars().take(MAX_REMARK).collect::<String>();
    // `here` may lengthen a remark.
    remarks.take(MAX_REMARKS).map(|text| bounded(&here(&bounded(text)))).collect()
}
