//! Opening packs and triangle meshes, with the exit code for each error, and the remarks in them.

use std::io::Read;
use std::path::Path;

use hullmap::{OpenError, Pack, TriangleMesh};
use hullmap_format::header::{FileKind, HEADER_LEN, Header};
use hullmap_import::open_regular;

use crate::outcome::Failure;
use crate::packs::kind_by_name;

const MAX_REMARKS: usize = 100;

const MAX_REMARK: usize = 10_000;

#[derive(Debug)]
pub enum BakedFile {
    Pack(Pack),
    TriangleMesh(TriangleMesh),
}

impl BakedFile {
    pub fn header(&self) -> &Header {
        match self {
            Self::Pack(pack) => pack.header(),
            Self::TriangleMesh(mesh) => mesh.header(),
        }
    }

    pub fn options(&self) -> &str {
        match self {
            Self::Pack(pack) => pack.options(),
            Self::TriangleMesh(mesh) => mesh.options(),
        }
    }

    pub fn source_path(&self) -> &str {
        match self {
            Self::Pack(pack) => pack.source_path(),
            Self::TriangleMesh(mesh) => mesh.source_path(),
        }
    }

    /// The recorded warnings, within limits, because the file may be hostile.
    pub fn kept_warnings(&self) -> Vec<String> {
        match self {
            Self::Pack(pack) => kept_warnings(pack),
            Self::TriangleMesh(mesh) => bounded_remarks(mesh.warnings(), str::to_owned),
        }
    }
}

/// The first bytes decide which kind of file it is, or else the extension.
pub fn open_baked(path: &Path) -> Result<BakedFile, Failure> {
    let mut start = Vec::new();
    // `Pack::open` would wait for a pipe.
    match open_regular(path).and_then(|file| file.take(HEADER_LEN as u64).read_to_end(&mut start)) {
        Err(error) if path.exists() && !path.is_file() => {
            return Err(Failure::usage(format!("{}: cannot read: {error}; name the file of a pack", path.display())));
        }
        _ => {}
    }
    let opened = match FileKind::from_start(&start).or_else(|| kind_by_name(path)) {
        Some(FileKind::TriangleMesh) => TriangleMesh::open(path).map(BakedFile::TriangleMesh),
        Some(FileKind::HeightField) => {
            return Err(Failure::rejected(format!(
                "{}: is a height field; bake inspect, verify, export and report take it by its extension .hullfield, \
                 without other files",
                path.display()
            )));
        }
        Some(FileKind::Pack) | None => Pack::open(path).map(BakedFile::Pack),
    };
    opened.map_err(|error| match &error {
        OpenError::Io { .. } => Failure::usage(error.to_string()),
        OpenError::Invalid { .. } => Failure::rejected(error.to_string()),
    })
}

pub fn open_pack(path: &Path) -> Result<Pack, Failure> {
    match open_baked(path)? {
        BakedFile::Pack(pack) => Ok(pack),
        BakedFile::TriangleMesh(_) => Err(Failure::rejected(format!(
            "{}: is a triangle mesh, but hulls are required; bake its source without --keep-triangles",
            path.display()
        ))),
    }
}

pub fn kept_warnings(pack: &Pack) -> Vec<String> {
    bounded_remarks(pack.warnings(), str::to_owned)
}

/// Remarks from elsewhere within limits, each as `here` shows it.
pub fn bounded_remarks<'a>(remarks: impl Iterator<Item = &'a str>, here: impl Fn(&str) -> String) -> Vec<String> {
    let bounded = |text: &str| text.chars().take(MAX_REMARK).collect::<String>();
    // `here` may lengthen a remark.
    remarks.take(MAX_REMARKS).map(|text| bounded(&here(&bounded(text)))).collect()
}
