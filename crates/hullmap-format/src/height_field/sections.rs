//! The sections of a height field as slices, read as in [`crate::sections`].

use std::mem::offset_of;

use rkyv::rend::{f32_le, u16_le};

use super::{
    archive::{ArchivedHeightField, ArchivedRecord},
    layout::{Diagonal, Layout},
    ranges::{Heights, is_marked},
};
use crate::{check_error::CheckError, cutter::Cutter};

/// Length of the root in bytes: an offset and a count, four bytes each, for each of 7 sections.
const ROOT_LEN: usize = size_of::<ArchivedHeightField>();

const _: () = assert!(ROOT_LEN == 7 * 8, "the root is 7 offsets and counts without padding");

/// All sections, in the order of the file. See [`HeightField`](super::archive::HeightField) for
/// what each holds.
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "each field is documented in `archive::HeightField`")]
pub struct Sections<'a> {
    pub records: &'a [ArchivedRecord],
    pub source_path: &'a [u8],
    pub options: &'a [u8],
    pub heights: &'a [f32_le],
    pub ranges: &'a [[u16_le; 2]],
    pub materials: &'a [u16_le],
    pub holes: &'a [u8],
}

impl<'a> Sections<'a> {
    /// Cuts `payload`, all bytes after the header, into its sections, as
    /// [`Sections::read`](crate::sections::Sections::read) of a pack.
    ///
    /// # Errors
    /// As [`Sections::read`](crate::sections::Sections::read).
    pub fn read(payload: &'a [u8]) -> Result<Self, CheckError> {
        let mut cutter = Cutter::<ROOT_LEN>::new(payload, ROOT_LEN)?;
        let sections = Self {
            records: cutter.cut("records", offset_of!(ArchivedHeightField, records))?,
            source_path: cutter.cut("source_path", offset_of!(ArchivedHeightField, source_path))?,
            options: cutter.cut("options", offset_of!(ArchivedHeightField, options))?,
            heights: cutter.cut("heights", offset_of!(ArchivedHeightField, heights))?,
            ranges: cutter.cut("ranges", offset_of!(ArchivedHeightField, ranges))?,
            materials: cutter.cut("materials", offset_of!(ArchivedHeightField, materials))?,
            holes: cutter.cut("holes", offset_of!(ArchivedHeightField, holes))?,
        };
        cutter.finish()?;
        Ok(sections)
    }

    /// The options that shaped the bake, then a line for each warning; empty if they are not UTF-8.
    pub fn options_text(&self) -> &'a str {
        std::str::from_utf8(self.options).unwrap_or_default()
    }

    /// The grid that the record states; `None` without a record, or with an unknown diagonal.
    pub fn layout(&self) -> Option<Layout> {
        let record = self.records.first()?;
        Some(Layout {
            columns: record.columns.to_native() as usize,
            rows: record.rows.to_native() as usize,
            origin: record.origin.map(|c| c.to_native()),
            spacing: record.spacing.map(|c| c.to_native()),
            diagonal: Diagonal::from_code(record.diagonal.to_native())?,
        })
    }

    /// Least and greatest height, as the record states them.
    pub fn height_range(&self) -> Option<[f32; 2]> {
        self.records.first().map(|record| [record.low, record.high].map(f32_le::to_native))
    }
}

impl Heights for Sections<'_> {
    #[inline]
    fn height(&self, vertex: usize) -> f32 {
        self.heights.get(vertex).map_or(0.0, |height| height.to_native())
    }

    #[inline]
    fn has_holes(&self) -> bool {
        !self.holes.is_empty()
    }

    #[inline]
    fn is_hole(&self, cell: usize) -> bool {
        is_marked(self.holes, cell)
    }
}
