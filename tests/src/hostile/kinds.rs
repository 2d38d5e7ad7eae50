//! Files of each kind: opening, and all queries on what opened.

use hullmap::{HeightField, InvalidPack, Pack, TriangleMesh};
use hullmap_format::header::{FileKind, Header};

use super::inquiry::{Extent, Inquiry};
use super::sheet_inquiry::SheetInquiry;

/// Places of the queries of a mesh or a field, for each contact query of a pack.
const PLACES: f64 = 0.4;

/// Queries for the changed files of one file.
pub enum AnyInquiry {
    /// A pack.
    Pack(Box<Inquiry>),
    /// A triangle mesh.
    Mesh(SheetInquiry),
    /// A height field.
    Field(SheetInquiry),
}

impl AnyInquiry {
    /// Queries for files like `file`. Panics if it does not open.
    pub fn new(file: &[u8], extent: Extent) -> Self {
        let sheet = || SheetInquiry::new((PLACES * extent.pairs as f64).ceil() as usize);
        match kind_of(file) {
            FileKind::Pack => {
                Self::Pack(Box::new(Inquiry::new(&Pack::from_bytes(file).expect("a sample opens"), extent)))
            }
            FileKind::TriangleMesh => Self::Mesh(sheet()),
            FileKind::HeightField => Self::Field(sheet()),
        }
    }

    /// Opens a file and runs the queries. Fails if it does not open; panics as
    /// [`Inquiry::run`].
    pub fn run(&self, file: &[u8]) -> Result<(), InvalidPack> {
        match self {
            Self::Pack(inquiry) => inquiry.run(&Pack::from_bytes(file)?),
            Self::Mesh(inquiry) => inquiry.run_mesh(TriangleMesh::from_bytes(file)?),
            Self::Field(inquiry) => inquiry.run_field(HeightField::from_bytes(file)?),
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
    match kind {
        FileKind::Pack => Pack::from_bytes(file).is_ok(),
        FileKind::TriangleMesh => TriangleMesh::from_bytes(file).is_ok(),
        FileKind::HeightField => HeightField::from_bytes(file).is_ok(),
    }
}

/// Two counts of a file that opens, which are ends of ranges of indices. Panics if it does not.
pub fn counts(file: &[u8]) -> [u32; 2] {
    let counts = match kind_of(file) {
        FileKind::Pack => {
            let pack = Pack::from_bytes(file).expect("a sample opens");
            let hull = pack.hull(0).expect("a pack has a hull");
            [hull.vertex_count(), hull.face_count()]
        }
        FileKind::TriangleMesh => {
            let mesh = TriangleMesh::from_bytes(file).expect("a sample opens");
            [mesh.vertex_count(), mesh.triangle_count()]
        }
        FileKind::HeightField => {
            let field = HeightField::from_bytes(file).expect("a sample opens");
            [field.layout().columns, field.layout().rows]
        }
    };
    counts.map(|count| count as u32)
}
