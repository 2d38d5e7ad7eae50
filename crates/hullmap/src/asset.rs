//! A baked file of any kind: it states what it holds.

use std::path::Path;
use std::sync::Arc;

use hullmap_format::header::{FileKind, Header};

use crate::file::checked::Checked;
use crate::file::{copy_of, read};
use crate::geometry::{Geometry, SharedGeometry, Visitor};
use crate::height_field::HeightField;
use crate::pack::{InvalidPack, OpenError, Pack};
use crate::triangle_mesh::TriangleMesh;

/// An opened baked file of any kind. Queries take it, and each of its variants.
///
/// The first bytes of a file decide, not its extension.
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let _folder = folder_of_packs()?;
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Sphere;
/// use hullmap::{Asset, Cache, Pose};
///
/// let cube = Asset::open("baked/cube.hullmap")?; // or a .hullmesh, or a .hullfield
/// let (ball, at) = (Sphere::new(0.5)?, Pose::from_translation(DVec3::new(1.25, 0.0, 0.0))?);
/// assert!(hullmap::intersects(&cube, &ball, at, &mut Cache::new()).is_hit());
/// match &cube {
///     Asset::Pack(pack) => assert_eq!(pack.hull_count(), 1),
///     Asset::TriangleMesh(level) => println!("{} triangles", level.triangle_count()),
///     Asset::HeightField(terrain) => println!("{} columns", terrain.layout().columns),
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub enum Asset {
    /// Convex hulls.
    Pack(Pack),
    /// A static mesh that keeps its triangles.
    TriangleMesh(TriangleMesh),
    /// A static ground whose heights are on a grid.
    HeightField(HeightField),
}

/// Calls a method that all contents have.
macro_rules! of_any {
    ($asset:expr, $content:ident => $call:expr) => {
        match $asset {
            Asset::Pack($content) => $call,
            Asset::TriangleMesh($content) => $call,
            Asset::HeightField($content) => $call,
        }
    };
}

impl Asset {
    /// Reads the file into memory of this process and checks all of it.
    ///
    /// # Errors
    /// [`OpenError`] names the file, what is wrong with it, and what to do.
    ///
    /// # Complexity
    /// One read and a few passes over the file.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        let path = path.as_ref();
        let (header, bytes) = read(path, None)?;
        Self::check(header, bytes).map_err(|cause| OpenError::Invalid { path: path.to_owned(), cause })
    }

    /// Copies the bytes of a whole file and checks all of them.
    ///
    /// # Errors
    /// The bytes are rejected; the error states the first fault.
    ///
    /// # Complexity
    /// One copy, and a few passes.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, InvalidPack> {
        let header = Header::read_kind(bytes, FileKind::from_start(bytes).unwrap_or(FileKind::Pack))?;
        Self::check(header, copy_of(bytes))
    }

    fn check(header: Header, bytes: crate::file::Bytes) -> Result<Self, InvalidPack> {
        match header.kind {
            FileKind::Pack => Pack::check(header, bytes).map(Self::Pack),
            FileKind::TriangleMesh => TriangleMesh::check(header, bytes).map(Self::TriangleMesh),
            FileKind::HeightField => HeightField::check(header, bytes).map(Self::HeightField),
        }
    }

    /// Header of the file, which states the kind.
    pub fn header(&self) -> &Header {
        of_any!(self, content => content.header())
    }

    /// Bytes of the whole file.
    pub fn bytes(&self) -> &[u8] {
        of_any!(self, content => content.bytes())
    }

    /// Path of the source relative to the file's folder; empty if none was recorded.
    pub fn source_path(&self) -> &str {
        of_any!(self, content => content.source_path())
    }

    /// The options that shaped the bake, in the form in which `bake` records them: one line.
    pub fn options(&self) -> &str {
        of_any!(self, content => content.options())
    }

    /// Warnings of the bake, each with its remedy.
    pub fn warnings(&self) -> Vec<&str> {
        of_any!(self, content => content.warnings().collect())
    }
}

impl Geometry for Asset {
    #[inline(always)]
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        of_any!(self, content => content.visit(visitor))
    }
}

impl From<Asset> for SharedGeometry {
    fn from(asset: Asset) -> Self {
        of_any!(asset, content => Arc::new(content).into())
    }
}
