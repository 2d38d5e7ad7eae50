//! Bakes of meshes in memory and of single files, without writing a pack to disk: for bindings to
//! other languages. Options have the keys and values of `hullmap.toml`.

use std::io;
use std::path::Path;

use hullmap_bake::SourceRecord;
use hullmap_bake::progress::Stage;
use hullmap_import::{self as import, ImportError, Imported, Limits, MeshArrays, ReadError, SourceFile};

use crate::baker::{BakedPack, bake_pack};
use crate::config::most_similar;
use crate::options::removed::instead_of_option;
use crate::options::table::{BuildOption, OPTIONS, Record, Scope, named};
use crate::options::{BuildOptions, OptionLayer};
use crate::triangle_mesh::{BakedTriangles, adapted, bake_triangles};

/// Why a mesh was not baked.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum InMemoryError {
    /// An option is unknown, has an invalid value, or excludes another one.
    #[error("{0}")]
    Option(String),
    /// The file cannot be read.
    #[error("{file}: cannot read: {source}; check the file")]
    Io { file: String, source: io::Error },
    /// The mesh is faulty.
    #[error("{0}")]
    Import(#[from] ImportError),
    /// A hull could not be baked.
    #[error("{0}")]
    Bake(String),
}

/// Bakes meshes in memory. Also returns them as imported: scaled and turned as the options say.
///
/// `name` is the name of meshes without one, and stands for the file in messages. `options` are
/// pairs of a key of `hullmap.toml` and a value, such as `("max_vertices", "64")`. With
/// `("split", "object")`, each mesh becomes a hull of its own. The pack records no source. `stage`
/// shows the progress, and may be cancelled.
///
/// # Errors
/// See [`InMemoryError`].
///
/// # Examples
/// ```
/// use hullmap_pipeline::Progress;
/// use hullmap_import::MeshArrays;
///
/// let corner = |i: usize| [0, 1, 2].map(|axis| f64::from((i >> axis & 1) as u8));
/// let cube = MeshArrays { positions: (0..8).map(corner).collect(), ..MeshArrays::default() };
/// let progress = Progress::default();
/// let (baked, _) = hullmap_pipeline::bake_arrays("cube", vec![cube], &[("index", "compact")], progress.whole())?;
/// assert_eq!(progress.share(), 1.0);
/// let pack = hullmap::Pack::from_bytes(&baked.bytes)?;
/// assert_eq!(pack.hull(0)?.vertex_count(), 8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn bake_arrays(
    name: &str,
    meshes: Vec<MeshArrays>,
    options: &[(&str, &str)],
    stage: Stage,
) -> Result<(BakedPack, Imported), InMemoryError> {
    let options = resolve(options)?;
    let imported = import::import_arrays(name, meshes, &options.import(), &Limits::DEFAULT)?;
    bake(imported, &options, SourceRecord::default(), name, stage)
}

/// Bakes a mesh file: OBJ, glTF, GLB, STL, PLY, COLLADA or MSH.
///
/// In the folder of the mesh, `bake build` with the same options makes the same bytes, which record
/// the file's name and hash, and the options. `stage` shows the progress, and may be cancelled.
///
/// # Errors
/// See [`InMemoryError`].
pub fn bake_file(path: &Path, options: &[(&str, &str)], stage: Stage) -> Result<BakedPack, InMemoryError> {
    // Report invalid options before the file is read.
    resolve(options)?;
    let file = path.display().to_string();
    let source = import::read(&file, path, &Limits::DEFAULT).map_err(|error| match error {
        ReadError::Io(source) => InMemoryError::Io { file, source },
        ReadError::Import(error) => error.into(),
    })?;
    bake_source(path, &source, options, stage).map(|(pack, _)| pack)
}

/// Bakes the contents of a mesh file, as [`bake_file`] does. Also returns the mesh as imported.
///
/// # Errors
/// See [`InMemoryError`].
pub fn bake_source(
    path: &Path,
    source: &SourceFile,
    options: &[(&str, &str)],
    stage: Stage,
) -> Result<(BakedPack, Imported), InMemoryError> {
    let options = resolve(options)?;
    let (imported, record) = import_source(path, source, &options)?;
    let file = path.display().to_string();
    bake(imported, &options, record, &file, stage)
}

/// Bakes the contents of a mesh file as a triangle mesh: the bytes of `bake build --keep-triangles`
/// in the folder of the mesh. `options` are the options of [`bake_file`] that apply to triangles.
///
/// # Errors
/// See [`InMemoryError`]. A file without faces cannot be baked.
///
/// ```
/// let square = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n".to_vec();
/// let source = hullmap_import::SourceFile::alone(square);
/// let baked = hullmap_pipeline::bake_level("square.obj".as_ref(), &source, &[])?;
/// assert_eq!(hullmap::TriangleMesh::from_bytes(&baked.bytes)?.triangle_count(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn bake_level(path: &Path, source: &SourceFile, options: &[(&str, &str)]) -> Result<BakedTriangles, InMemoryError> {
    let options = resolve_of(Kind::Triangles, options)?;
    let (mut imported, record) = import_source(path, source, &options)?;
    imported.give_triangles();
    let [mut notes, warnings] = [&mut imported.notes, &mut imported.warnings]
        .map(|remarks| remarks.drain(..).map(|remark| adapted(&remark)).collect::<Vec<_>>());
    let record = SourceRecord { options: options.to_string(), warnings, ..record };
    let file = path.display();
    let mut baked =
        bake_triangles(&imported, &record).map_err(|error| InMemoryError::Bake(format!("{file}: {error}")))?;
    notes.append(&mut baked.notes);
    Ok(BakedTriangles { notes, ..baked })
}

/// Imports the contents of a mesh file. Also returns the record of it, without options.
fn import_source(
    path: &Path,
    source: &SourceFile,
    options: &BuildOptions,
) -> Result<(Imported, SourceRecord), InMemoryError> {
    let file = path.display().to_string();
    let [stem, name] = [path.file_stem(), path.file_name()].map(|part| part.unwrap_or_default().to_string_lossy());
    let imported = import::import(&file, &stem, path, source, &options.import(), &Limits::DEFAULT)?;
    Ok((imported, SourceRecord { path: name.into_owned(), hash: source.hash, ..SourceRecord::default() }))
}

/// Limits that only callers of the command can raise.
const LIMITS: [&str; 3] = ["max_input_bytes", "max_objects", "max_instanced"];

/// A message of the command for callers without flags: `--max-vertices` becomes `name` of the key
/// `max_vertices`, and so does `--set max_vertices`. Flags that are no options, and commands in
/// backticks, stay.
///
/// # Examples
/// ```
/// let text = "split it, or raise --set max_objects; use --split none, or run `bake build --prune`";
/// let expected = "split it; use split none, or run `bake build --prune`";
/// assert_eq!(hullmap_pipeline::without_flags(text, str::to_owned), expected);
/// ```
pub fn without_flags(message: &str, name: impl Fn(&str) -> String) -> String {
    let message =
        LIMITS.iter().fold(message.to_owned(), |text, key| text.replace(&format!(", or raise --set {key}"), ""));
    let mut text = String::with_capacity(message.len());
    for (at, part) in message.split('`').enumerate() {
        if at > 0 {
            text.push('`');
        }
        let mut words = part.split("--");
        text += words.next().unwrap_or_default();
        for word in words {
            let (set, word) = word.strip_prefix("set ").map_or(("", word), |word| ("set ", word));
            let end = word.find(|c: char| !(c.is_ascii_lowercase() || "-_".contains(c))).unwrap_or(word.len());
            let (flag, rest) = word.split_at(end);
            let key = flag.replace('-', "_");
            match named(&key).filter(|_| at % 2 == 0) {
                Some(index) => text += &name(OPTIONS[index].key),
                None => text += &format!("--{set}{flag}"),
            }
            text += rest;
        }
    }
    text
}

fn bake(
    mut imported: Imported,
    options: &BuildOptions,
    record: SourceRecord,
    file: &str,
    stage: Stage,
) -> Result<(BakedPack, Imported), InMemoryError> {
    // For the mass of the mesh, and for its parts.
    imported.give_triangles();
    let warnings = std::mem::take(&mut imported.warnings);
    let record = SourceRecord { options: options.to_string(), warnings, ..record };
    let mut pack = bake_pack(&imported.point_sets, options, &record, stage)
        .map_err(|error| InMemoryError::Bake(format!("{file}: {error}")))?;
    pack.notes.splice(0..0, std::mem::take(&mut imported.notes));
    Ok((pack, imported))
}

/// The alternatives to the option `keep_triangles`.
const NO_PACK: &str = "makes no pack; use TriangleMesh (Python), bake_level (Rust), or `bake build --keep-triangles`";

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Hulls,
    Triangles,
}

fn resolve(options: &[(&str, &str)]) -> Result<BuildOptions, InMemoryError> {
    resolve_of(Kind::Hulls, options)
}

fn resolve_of(kind: Kind, options: &[(&str, &str)]) -> Result<BuildOptions, InMemoryError> {
    let is_accepted = |option: &&BuildOption| {
        option.record != Record::Never
            && option.scope != Scope::Terrains
            && !["keep_triangles", "terrain"].contains(&option.key)
    };
    let accepted = || OPTIONS.iter().filter(is_accepted).map(|option| option.key);
    let mut layer = OptionLayer::default();
    for (key, value) in options {
        if !accepted().any(|known| known == *key) {
            let known: Vec<&str> = accepted().collect();
            let unknown = || match most_similar(key, &known) {
                Some(near) => format!("unknown option {key}; did you mean {near}?"),
                None => format!("unknown option {key}: the options are {}", known.join(", ")),
            };
            let instead = instead_of_option(key).or((*key == "keep_triangles").then_some(NO_PACK));
            let instead = instead.map(|instead| format!("option {key}: {instead}"));
            return Err(InMemoryError::Option(instead.unwrap_or_else(unknown)));
        }
        layer
            .set(key, value)
            .map_err(|expected| InMemoryError::Option(format!("invalid value {value} of option {key}: {expected}")))?;
    }
    if kind == Kind::Triangles {
        layer.set("keep_triangles", "true").map_err(InMemoryError::Option)?;
    }
    let resolved = layer.resolve();
    match layer.clash().or_else(|| layer.without_effect(std::iter::once(&resolved))) {
        Some(clash) => {
            let of_triangles = "with keep_triangles, which writes no hulls; remove one of them";
            let message =
                clash.message(str::to_owned).replace(of_triangles, "on a level, which has no hulls; remove it");
            Err(InMemoryError::Option(message))
        }
        None => Ok(resolved),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_options_are_rejected() {
        let error = |options: &[(&str, &str)]| resolve(options).unwrap_err().to_string();
        assert!(error(&[("oak", "1")]).starts_with("unknown option oak: the options are split, vertices, index"));
        assert_eq!(error(&[("maxparts", "1")]), "unknown option maxparts; did you mean max_parts?");
        let on_level = resolve_of(Kind::Triangles, &[("lean", "true")]).unwrap_err().to_string();
        assert_eq!(on_level, "lean has no effect on a level, which has no hulls; remove it");
        for key in ["pack_names", "terrain", "spacing"] {
            assert!(error(&[(key, "1")]).starts_with(&format!("unknown option {key}: ")), "{key}");
        }
        assert_eq!(error(&[("keep_triangles", "true")]), format!("option keep_triangles: {NO_PACK}"));
        assert!(error(&[("index", "oak")]).starts_with("invalid value oak of option index: expected one of tree,"));
        assert!(error(&[("vhacd_fill", "flood")]).contains("V-HACD was removed"));
        assert!(error(&[("max_error", "1"), ("max_vertices", "8")]).contains("exclude each other"));
        assert!(error(&[("max_parts", "8")]).starts_with("max_parts has no effect without decompose"));
    }

    #[test]
    fn a_missing_file_is_an_io_error() {
        let error = bake_file(Path::new("missing.obj"), &[], Stage::default()).unwrap_err();
        assert!(matches!(error, InMemoryError::Io { .. }), "{error}");
        assert!(error.to_string().starts_with("missing.obj: cannot read: "));
    }
}
