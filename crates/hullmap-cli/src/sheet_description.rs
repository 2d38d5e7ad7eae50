//! `bake inspect`: what the descriptions of triangle meshes and of height fields share.

use std::collections::BTreeMap;

use hullmap_format::header::Header;
use serde::Serialize;

use crate::outcome::Failure;
use crate::terminal::Output;
use hullmap_bake::number::grouped;

const MATERIALS_IN_TEXT: usize = 8;

pub type Row = (String, String);

/// Description of a file. Field names are the JSON's.
#[derive(Debug, Serialize)]
pub struct FileDescription {
    file: String,
    format_version: u32,
    bytes: u64,
    source: String,
    pub options: String,
    /// XXH3-128 of the source, 32 hexadecimal digits.
    source_hash: String,
}

impl FileDescription {
    pub fn new(file: String, header: &Header, bytes: usize, source: &str, options: &str) -> Self {
        Self {
            file,
            format_version: header.format_version,
            bytes: bytes as u64,
            source: source.to_owned(),
            options: options.to_owned(),
            source_hash: format!("{:032x}", header.source_hash),
        }
    }

    /// The rows about a file of this kind, which has `count` elements. `options` is in words.
    pub fn rows(&self, kind: &str, options: String, (element, count): (&str, usize)) -> [Row; 4] {
        let each = self.bytes as f64 / count.max(1) as f64;
        [
            ("format version", format!("{}, a {kind}", self.format_version)),
            ("bytes", format!("{} ({each:.1} per {element})", grouped(self.bytes))),
            ("source", format!("{} (xxh3 {})", self.source, self.source_hash)),
            ("options", options),
        ]
        .map(|(name, value)| (name.to_owned(), value))
    }

    pub fn write_text(&self, rows: Vec<Row>, out: &mut Output) -> Result<(), Failure> {
        out.line(&self.file)?;
        for (name, value) in rows {
            out.line(format_args!("  {name:<18} {value}"))?;
        }
        Ok(())
    }
}

pub fn count_materials(materials: impl Iterator<Item = u16>) -> BTreeMap<u16, usize> {
    let mut counts = BTreeMap::new();
    materials.for_each(|material| *counts.entry(material).or_default() += 1);
    counts
}

pub fn list_materials(counts: &BTreeMap<u16, usize>) -> String {
    let listed = counts.iter().take(MATERIALS_IN_TEXT);
    let listed: Vec<String> =
        listed.map(|(material, count)| format!("{material}: {} triangles", grouped(*count as u64))).collect();
    let more = if counts.len() > MATERIALS_IN_TEXT { ", …" } else { "" };
    format!("{}{more}", listed.join(", "))
}
