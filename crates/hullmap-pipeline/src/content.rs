//! Content of a source file: a mesh, or a grid of heights. The options decide. Reads, imports and
//! verifies both.

use std::io;
use std::path::{Path, PathBuf};

use hullmap::Asset;
use hullmap_bake::PointSet;
use hullmap_format::header::FileKind;
use hullmap_import::height_field::{import_heights, import_holes, read_heights};
use hullmap_import::{self as import, ImportError, Imported, Limits, ReadError, SourceFile};
use hullmap_verify::height_field::{SourceHeights, verify_field};
use hullmap_verify::pack::{HullVerification, Reference, verify_hulls};
use hullmap_verify::triangle_mesh::{SourceTriangles, SurfaceVerification, verify_mesh};

use crate::options::BuildOptions;
use crate::outcome::Failure;
use crate::triangle_mesh::adapted;

/// Directions tested on each hull by default.
pub const DEFAULT_DIRECTIONS: usize = 10_000;

#[derive(Debug)]
pub enum Content {
    Mesh(Box<Imported>),
    Terrain(Terrain),
}

#[derive(Debug)]
pub struct Terrain {
    pub source: SourceHeights,
    pub warnings: Vec<String>,
}

/// Reads a source whose name in messages is `file`, and the files beside it.
pub fn read(file: &str, path: &Path, options: &BuildOptions, limits: &Limits) -> Result<SourceFile, ReadError> {
    match options.file_kind() {
        FileKind::HeightField => read_heights(file, path, options.hole_image().as_deref(), limits),
        FileKind::Pack | FileKind::TriangleMesh => import::read(file, path, limits),
    }
}

/// The files beside a source that are read with it.
pub fn beside(path: &Path, options: &BuildOptions) -> io::Result<Vec<PathBuf>> {
    match options.file_kind() {
        FileKind::HeightField => Ok(options.hole_image().iter().map(|name| path.with_file_name(&**name)).collect()),
        FileKind::Pack | FileKind::TriangleMesh => import::buffers_of(path),
    }
}

impl Content {
    pub fn import(path: &Path, source: &SourceFile, options: &BuildOptions, limits: &Limits) -> Result<Self, Failure> {
        let file = path.display().to_string();
        let rejected = |error: ImportError| Failure::rejected(error.to_string());
        let kind = options.file_kind();
        if kind == FileKind::HeightField {
            return Terrain::import(&file, path, source, options).map(Self::Terrain);
        }
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let mut imported = import::import(&file, &stem, path, source, &options.import(), limits).map_err(rejected)?;
        // For the mass of the mesh, and for its parts.
        imported.give_triangles();
        if kind == FileKind::TriangleMesh {
            for remark in imported.notes.iter_mut().chain(&mut imported.warnings) {
                *remark = adapted(remark);
            }
        }
        Ok(Self::Mesh(Box::new(imported)))
    }

    /// Notes and warnings of the import.
    pub fn remarks(&self) -> [&[String]; 2] {
        match self {
            Self::Mesh(mesh) => [&mesh.notes, &mesh.warnings],
            Self::Terrain(terrain) => [&[], &terrain.warnings],
        }
    }

    /// The point sets of a mesh; none of a terrain.
    pub fn point_sets(&self) -> &[PointSet] {
        match self {
            Self::Mesh(mesh) => &mesh.point_sets,
            Self::Terrain(_) => &[],
        }
    }
}

impl Terrain {
    fn import(file: &str, path: &Path, source: &SourceFile, options: &BuildOptions) -> Result<Self, Failure> {
        let rejected = |error: ImportError| Failure::rejected(error.to_string());
        let samples = options.samples();
        let heights = import_heights(file, &source.bytes, &samples).map_err(rejected)?;
        if heights.is_image && !options.has_height_scale() {
            let message = "an image has no unit; name the height of white above black with --set height_scale=S";
            return Err(Failure::usage(format!("{file}: {message}")));
        }
        let holes = match source.beside.first() {
            Some((name, image)) => {
                let name = path.with_file_name(name).display().to_string();
                import_holes(&name, image, heights.columns, heights.rows).map_err(rejected)?
            }
            None => Vec::new(),
        };
        let unused = samples.hole.filter(|_| heights.hole_samples == 0);
        let warnings = unused.map(|hole| format!("no sample is {hole}, so --set hole makes no holes; check the value"));
        let layout = options.layout(&heights).map_err(|error| Failure::usage(format!("{file}: {error}")))?;
        let source = SourceHeights { layout, heights: heights.heights, holes };
        Ok(Self { source, warnings: warnings.into_iter().collect() })
    }
}

pub enum Verified {
    Hulls(Vec<HullVerification>),
    Surface(Box<SurfaceVerification>),
}

impl Verified {
    /// The faults of the first hull that fails, or of the surface; `None` if all pass.
    pub fn verdict(&self) -> Option<String> {
        match self {
            Self::Hulls(hulls) => hulls.iter().find(|result| !result.pass).map(HullVerification::verdict),
            Self::Surface(surface) => surface.verdict(),
        }
    }
}

/// Verifies a file against its source; without one, against itself. Fails if the two do not fit.
pub fn verify(asset: &Asset, source: Option<&Content>, directions: usize, seed: u64) -> Result<Verified, String> {
    let mesh = match source {
        Some(Content::Mesh(mesh)) => Some(mesh),
        _ => None,
    };
    let terrain = match source {
        Some(Content::Terrain(terrain)) => Some(&terrain.source),
        _ => None,
    };
    let surface = |found: SurfaceVerification| Ok(Verified::Surface(Box::new(found)));
    match asset {
        Asset::Pack(pack) if terrain.is_none() => {
            let reference = mesh.map_or(Reference::StoredHull, |mesh| Reference::Source(&mesh.point_sets));
            let cover = BuildOptions::recorded_cover(pack.options());
            verify_hulls(pack, reference, cover.as_ref(), directions, seed).map(Verified::Hulls)
        }
        Asset::TriangleMesh(own) if terrain.is_none() => {
            let triangles = mesh.map(|mesh| SourceTriangles::new(&mesh.point_sets, &mesh.faces, &mesh.materials));
            let triangles = triangles.transpose()?;
            surface(verify_mesh(own, triangles.as_ref(), directions, seed))
        }
        Asset::HeightField(field) if mesh.is_none() => surface(verify_field(field, terrain, directions, seed)),
        _ => Err("the options in its record are of another kind of file; bake its source again".to_owned()),
    }
}
