//! Files of each kind: opening, and all queries on what opened.

use hullmap::{Asset, InvalidPack};
use hullmap_format::header::{FileKind, Header};

use super::inquiry::{Extent, Inquiry};
use super::sheet_inquiry::SheetInquiry;

/// Places of the queries of a mesh or a field, for each contact query of a pack.
const PLACES: f64 = 0.4;

/// Queries for the changed files of one file.
pub enum AnyInquiry {
    /// A pack.
    Pack(Box<Inquiry>),
    /// A triangle mesh or a height field.
    Sheet(SheetInquiry),
}

impl AnyInquiry {
    /// Queries for files like `file`. Panics if it does not open.
    pub fn new(file: &[u8], extent: Extent) -> Self {
        match Asset::from_bytes(file).expect("a sample opens") {
            Asset::Pack(pack) => Self::Pack(Box::new(Inquiry::new(&pack, extent))),
            _ => Self::Sheet(SheetInquiry::new((PLACES * extent.pairs as f64).ceil() as usize)),
        }
    }

    /// Opens a file and runs the queries. Fails if it does not open; panics as
    /// [`Inquiry::run`].
    pub fn run(&self, file: &[u8]) -> Result<(), InvalidPack> {
        match (self, Asset::from_bytes(file)?) {
            (Self::Pack(inquiry), Asset::Pack(pack)) => inquiry.run(&pack),
            (Self::Sheet(inquiry), Asset::TriangleMesh(mesh)) => inquiry.run_mesh(mesh),
            (Self::Sheet(inquiry), Asset::HeightField(field)) => inquiry.run_field(field),
            // A change of the magic, which opens as another kind only if the payload fits it.
            (_, other) => panic!("opens as a {}", other.header().kind),
        }
        Ok(())
    }
}

/// The kind of a file that opens. Panics if its header is not valid.
pub fn kind_of(file: &[u8]) -> FileKind {
    let kind = FileKind::ALL.into_iter().find(|kind| Header::read_kind(file, *kind).is_ok());
    kind.expect("a sample has a header")
}

/// Whether a file of this kind opens.
pub fn opens(kind: FileKind, file: &[u8]) -> bool {
    Asset::from_bytes(file).is_ok_and(|asset| asset.header().kind == kind)
}

/// Two counts of a file that opens, which are ends of ranges of indices. Panics if it does not.
pub fn counts(file: &[u8]) -> [u32; 2] {
    let counts = match Asset::from_bytes(file).expect("a sample opens") {
        Asset::Pack(pack) => {
            let hull = pack.hull(0).expect("a pack has a hull");
            [hull.vertex_count(), hull.face_count()]
        }
        Asset::TriangleMesh(mesh) => [mesh.vertex_count(), mesh.triangle_count()],
        Asset::HeightField(field) => [field.layout().columns, field.layout().rows],
    };
    counts.map(|count| count as u32)
}
