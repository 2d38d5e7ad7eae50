//! The sections of a triangle mesh as slices, read as in [`crate::sections`].

use std::mem::offset_of;

use rkyv::rend::{f32_le, u16_le, u32_le};

use super::archive::{ArchivedRecord, ArchivedTriangleMesh};
use crate::{check_error::CheckError, cutter::Cutter};

/// Length of the root in bytes: an offset and a count, four bytes each, for each of 11 sections.
const ROOT_LEN: usize = size_of::<ArchivedTriangleMesh>();

const _: () = assert!(ROOT_LEN == 11 * 8, "the root is 11 offsets and counts without padding");

/// All sections, in the order of the file. See
/// [`TriangleMesh`](super::archive::TriangleMesh) for what each holds.
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "each field is documented in `archive::TriangleMesh`")]
pub struct Sections<'a> {
    pub records: &'a [ArchivedRecord],
    pub source_path: &'a [u8],
    pub options: &'a [u8],
    pub vertices: &'a [[f32_le; 3]],
    pub triangles: &'a [[u32_le; 3]],
    pub neighbours: &'a [[u32_le; 3]],
    pub source_triangles: &'a [u32_le],
    pub materials: &'a [u16_le],
    pub edge_classes: &'a [u16_le],
    pub boxes: &'a [[u16_le; 6]],
    pub vertex_classes: &'a [u8],
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
            records: cutter.cut("records", offset_of!(ArchivedTriangleMesh, records))?,
            source_path: cutter.cut("source_path", offset_of!(ArchivedTriangleMesh, source_path))?,
            options: cutter.cut("options", offset_of!(ArchivedTriangleMesh, options))?,
            vertices: cutter.cut("vertices", offset_of!(ArchivedTriangleMesh, vertices))?,
            triangles: cutter.cut("triangles", offset_of!(ArchivedTriangleMesh, triangles))?,
            neighbours: cutter.cut("neighbours", offset_of!(ArchivedTriangleMesh, neighbours))?,
            source_triangles: cutter.cut("source_triangles", offset_of!(ArchivedTriangleMesh, source_triangles))?,
            materials: cutter.cut("materials", offset_of!(ArchivedTriangleMesh, materials))?,
            edge_classes: cutter.cut("edge_classes", offset_of!(ArchivedTriangleMesh, edge_classes))?,
            boxes: cutter.cut("boxes", offset_of!(ArchivedTriangleMesh, boxes))?,
            vertex_classes: cutter.cut("vertex_classes", offset_of!(ArchivedTriangleMesh, vertex_classes))?,
        };
        cutter.finish()?;
        Ok(sections)
    }

    /// The options that shaped the bake, then a line for each warning; empty if they are not UTF-8.
    pub fn options_text(&self) -> &'a str {
        std::str::from_utf8(self.options).unwrap_or_default()
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// The corners of a triangle; `None` if the index is out of range.
    #[inline]
    pub fn corners(&self, triangle: usize) -> Option<[[f32; 3]; 3]> {
        let [a, b, c] = *self.triangles.get(triangle)?;
        Some([self.vertex(a)?, self.vertex(b)?, self.vertex(c)?])
    }

    #[inline]
    fn vertex(&self, index: u32_le) -> Option<[f32; 3]> {
        self.vertices.get(index.to_native() as usize).map(|vertex| vertex.map(f32_le::to_native))
    }
}
