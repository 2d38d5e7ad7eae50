//! `bake export`: exports hulls and triangle meshes as meshes that other programs read.
//! Coordinates keep all bits of `f32`, so that an exported hull bakes to the same hull.

mod robot;
mod scene;
mod surface;
pub mod usd;

use std::cell::Cell;
use std::collections::HashMap;
use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};

use hullmap::{Asset, MassProperties, MassSource, Pack};
use hullmap_format::header::FileKind;
use hullmap_import::{Limits, Split, UpAxis};
use serde::Serialize;

use crate::args::export::{ExportArgs, Format, Target};
use crate::selection::hull_index;
use crate::terminal::{self, Output};
use hullmap_geometry::number::{grouped, rounded};
use hullmap_pipeline::mesh_file::body::{Body, DENSITY, Inertial, counts};
use hullmap_pipeline::mesh_file::names::{self, NAMES_IN_MESSAGE};
use hullmap_pipeline::mesh_file::place::{self, OutputFile, State};
use hullmap_pipeline::mesh_file::seal::{SEAL, sealed};
use hullmap_pipeline::mesh_file::{glb, obj, stl};
use hullmap_pipeline::open::{noun, open_asset};
use hullmap_pipeline::options::BuildOptions;
use hullmap_pipeline::outcome::{Exit, Failure, end};
use hullmap_pipeline::pack_file::{folder_of, sweep, sweep_below};
use hullmap_pipeline::packs::{PackPlace, find_packs, is_baked, kind_by_name};
use hullmap_pipeline::source::{Folders, Recorded, SourceSearch, find_source};
use hullmap_verify::geometry::rank_name;
use robot::{Geometry, Robot};
use scene::Added;

/// The hulls of a pack as JSON. Field names are the JSON's.
#[derive(Debug, Serialize)]
struct ExportedPack<'a> {
    generator: &'a str,
    source: &'a str,
    options: &'a str,
    hulls: &'a [Body],
}

#[derive(Debug)]
struct ExportedFile {
    name: String,
    bytes: Vec<u8>,
    /// Number of hulls, vertices and triangles in it; `None` for a document that names meshes.
    counts: Option<[usize; 3]>,
}

struct Export<'a> {
    args: &'a ExportArgs,
    format: Format,
    is_many: bool,
    is_folder: bool,
    folders: Folders,
    /// Number of files that are as this export would write them.
    unchanged: Cell<usize>,
}

/// Fails for wrong flags, or if the only pack cannot be exported. Failures of one of several packs
/// are reported, and the others exported.
pub fn run(args: &ExportArgs, out: &mut Output) -> Result<Exit, Failure> {
    let is_many = args.packs.len() > 1 || args.packs.iter().any(|pack| pack.is_dir());
    let is_folder = args.parts || args.target.is_some_and(Target::is_document);
    check_flags(args, is_many, is_folder)?;
    let format = format(args, is_many || is_folder)?;
    if is_many && args.out.is_none() && format != Format::Json {
        return Err(Failure::usage("several packs are exported; name a folder with --out"));
    }
    let export = Export { args, format, is_many, is_folder, folders: Folders::default(), unchanged: Cell::new(0) };
    if let Some(folder) = args.out.as_deref().filter(|_| is_many) {
        sweep_below(folder);
    }
    let (mut exit, mut is_nothing, mut is_changed, mut left_out) = (Exit::Done, true, false, Vec::new());
    let mut taken: HashMap<String, PathBuf> = HashMap::new();
    for place in find_packs(&args.packs)? {
        // A folder may hold levels, too.
        let kind = kind_by_name(&place.path).unwrap_or(FileKind::Pack);
        if !args.packs.contains(&place.path)
            && let Some(remedy) = export.unfit(kind)
        {
            let (file, noun) = (place.path.display(), noun(kind));
            left_out.push(format!("{file}: left out, because it is a {noun}; {remedy}"));
            continue;
        }
        is_nothing = false;
        let target = export.target(&place);
        let lowered = target.as_ref().map(|target| target.to_string_lossy().to_lowercase());
        let first = lowered.and_then(|target| taken.insert(target, place.path.clone()));
        let result = match (first, &target) {
            (Some(first), Some(target)) => Err(Failure::usage(format!(
                "{} and {} would both become {}; export them to separate folders",
                first.display(),
                place.path.display(),
                target.display()
            ))),
            _ => terminal::with_notes_of_changes(|| export.pack(&place, target.as_deref(), out)),
        };
        match result {
            Err(failure) if is_many && !failure.message.is_empty() => {
                terminal::error(&failure);
                exit = exit.max(failure.exit);
            }
            other => is_changed |= other?,
        }
    }
    left_out.iter().filter(|_| is_changed || is_nothing).for_each(terminal::note);
    if is_nothing {
        return Err(Failure::usage("nothing to export: there are only files without hulls"));
    }
    end(exit, write_unchanged(export.unchanged.get(), out).map_err(Failure::from))
}

impl Export<'_> {
    /// The file of a pack, or the folder of its files; `None`: standard output.
    fn target(&self, place: &PackPlace) -> Option<PathBuf> {
        let out = self.args.out.as_ref()?;
        if !self.is_many {
            return Some(out.clone());
        }
        let mut name = place.path.file_stem().unwrap_or_default().to_owned();
        if !self.is_folder {
            name.push(".");
            name.push(self.format.extension());
        }
        Some(out.join(&place.below).join(name))
    }

    /// Returns whether something was written.
    fn pack(&self, place: &PackPlace, target: Option<&Path>, out: &mut Output) -> Result<bool, Failure> {
        let (args, path) = (self.args, place.path.as_path());
        let pack = match open_asset(path)? {
            Asset::Pack(pack) => pack,
            other => return self.write(self.surface(path, &other)?, target, out),
        };
        let (indices, mut bodies) = selected(args, path, &pack)?;
        leave_out(args, path, self.format, &mut bodies)?;
        if bodies.is_empty() {
            return Ok(false);
        }
        if bodies.len() > 1 && self.format == Format::Stl && !self.is_folder {
            return Err(Failure::usage(format!(
                "{}: has {} hulls, and an STL file holds one; add --parts, select one with --hull, or use another format",
                path.display(),
                bodies.len()
            )));
        }
        self.rename(place, &pack, &mut bodies);
        let files = if let Some(into) = &args.into {
            let is_solid = |&index: &usize| pack.hull(index).is_ok_and(|hull| hull.rank() == 3);
            let indices: Vec<usize> = indices.into_iter().filter(is_solid).collect();
            let (bytes, counts) = Added { args, path, pack: &pack, indices: &indices }.file(into, bodies)?;
            vec![ExportedFile { name: String::new(), bytes, counts: Some(counts) }]
        } else {
            let mass = self.mass(place, &pack, &indices);
            files(args, path, &pack, self.format, self.is_folder, bodies, mass.as_ref())?
        };
        self.write(files, target, out)
    }

    fn write(&self, files: Vec<ExportedFile>, target: Option<&Path>, out: &mut Output) -> Result<bool, Failure> {
        let Some(target) = target else {
            let written = files.iter().try_for_each(|file| out.verbatim(&file.bytes));
            return end(Exit::Done, written.map_err(Failure::from)).map(|_| true);
        };
        let targets: Vec<PathBuf> = if self.is_folder {
            files.iter().map(|file| target.join(&file.name)).collect()
        } else {
            vec![target.to_owned()]
        };
        let root = if self.is_many { self.args.out.as_deref() } else { None };
        let [written, unchanged] = put(self.args, targets, files, root, out)?;
        self.unchanged.set(self.unchanged.get() + unchanged);
        Ok(written > 0)
    }
}

/// The given format, the one of the target's extension, or the best one for the engine.
fn format(args: &ExportArgs, is_folder: bool) -> Result<Format, Failure> {
    if let Some(into) = &args.into {
        check_into(args, into)?;
        return Ok(Format::Glb);
    }
    let allowed: &[Format] = match args.target {
        None => &[Format::Obj, Format::Stl, Format::Glb, Format::Json, Format::F32],
        Some(Target::Unreal) => &[Format::Glb, Format::Obj],
        Some(Target::Godot | Target::KhrPhysics | Target::Omi | Target::Both) => &[Format::Glb],
        Some(Target::Mjcf | Target::Urdf | Target::Sdf) => &[Format::Obj, Format::Stl],
        // `usd` writes it.
        Some(Target::Usd) => &[],
    };
    let extension = args.out.as_deref().and_then(Path::extension).map(|extension| extension.to_ascii_lowercase());
    let named = || allowed.iter().find(|format| extension.as_ref().is_some_and(|ending| ending == format.extension()));
    let format = args.format.or_else(|| named().copied()).or(args.target.and(allowed.first().copied()));
    let listed = || allowed.iter().map(|format| format.extension()).collect::<Vec<_>>().join(", ");
    match format {
        Some(format) if allowed.contains(&format) => {
            check_output(args, format, is_folder)?;
            Ok(format)
        }
        Some(format) => {
            let target = args.target.map_or("", Target::name);
            Err(Failure::usage(format!(
                "--format {}: {target} takes {}; name one of these, or leave out --format",
                format.extension(),
                listed()
            )))
        }
        None if is_folder => Err(Failure::usage(format!("the format is unknown; add --format: {}", listed()))),
        None => Err(Failure::usage(format!(
            "the format is unknown; add --format, or name a file in --out with one of these extensions: {}",
            listed()
        ))),
    }
}

/// Rejects binary data for a terminal, and an extension of another format without `--format`.
fn check_output(args: &ExportArgs, format: Format, is_folder: bool) -> Result<(), Failure> {
    let name = format.extension();
    let Some(target) = &args.out else {
        if matches!(format, Format::Glb | Format::Stl | Format::F32) && terminal::shows_output() {
            return Err(Failure::usage(format!("{name} is binary; name a file with --out, or redirect the output")));
        }
        return Ok(());
    };
    let is_other = target.extension().is_some_and(|extension| !extension.eq_ignore_ascii_case(name));
    if is_other && !is_folder && args.format.is_none() {
        let shown = target.display();
        return Err(Failure::usage(format!(
            "--out {shown}: the format would be {name}; name a file with this extension, or add --format {name}"
        )));
    }
    Ok(())
}

fn check_into(args: &ExportArgs, into: &Path) -> Result<(), Failure> {
    let usage = |message: String| Err(Failure::usage(message));
    let Some(out) = &args.out else {
        return usage("--into: name the file to write with --out".to_owned());
    };
    if args.format.is_some() || args.parts {
        return usage("--into: the file keeps its format; leave out --format and --parts".to_owned());
    }
    let extension = |path: &Path| path.extension().map(|extension| extension.to_ascii_lowercase());
    let is_unreal = args.target == Some(Target::Unreal);
    let is_ours = |extension: &OsStr| extension == "glb" || extension == "gltf" || is_unreal && extension == "obj";
    if !extension(into).is_some_and(|extension| is_ours(&extension)) {
        let or_obj = if is_unreal { ", or an OBJ file" } else { "" };
        return usage(format!("--into {}: expected a glTF file (.glb or .gltf){or_obj}", into.display()));
    }
    if extension(into) != extension(out) {
        let name = extension(into).unwrap_or_default();
        let (out, name) = (out.display(), name.display());
        return usage(format!("--out {out}: the file keeps its form; name a file with the extension {name}"));
    }
    Ok(())
}

fn check_flags(args: &ExportArgs, is_many: bool, is_folder: bool) -> Result<(), Failure> {
    let usage = |message: String| Err(Failure::usage(message));
    let is_physics = args.target.is_some_and(Target::is_physics);
    let is_unreal = args.target == Some(Target::Unreal);
    if args.is_visible && !is_physics {
        return usage("--visible: only for colliders in glTF; add --for godot, khr-physics, omi or both".to_owned());
    }
    if args.into.is_some() && !is_physics && !is_unreal {
        return usage("--into: adds colliders; add --for khr-physics, omi, both, godot or unreal".to_owned());
    }
    if args.is_static && is_unreal {
        return usage("--static: Unreal reads no masses from the file; leave it out".to_owned());
    }
    if args.into.is_some() && is_many {
        return usage("--into: takes one pack; export the packs one after the other".to_owned());
    }
    if args.into.is_some() && args.up_axis != UpAxis::Keep {
        return usage("--up-axis: hulls keep the axes of the glTF file; leave it out with --into".to_owned());
    }
    if args.mesh_prefix.is_some() && !args.target.is_some_and(Target::is_document) {
        return usage("--set mesh_prefix: only for documents that name files; add --for mjcf, urdf or sdf".to_owned());
    }
    let has_mass = args.target.is_some_and(Target::is_document) || args.into.is_some() && !args.is_static && !is_unreal;
    if args.density.is_some() && !has_mass {
        return usage("--density: only for files with masses; add --for mjcf, urdf, sdf or usd, or --into".to_owned());
    }
    if let Some(flag) = args.usd.given() {
        return usage(format!("{flag}: only for USD; add --for usd"));
    }
    if is_many && args.name.is_some() {
        return usage("--name: several packs are exported, and each needs a name; export this one alone".to_owned());
    }
    let Some(target) = &args.out else {
        if is_folder {
            return usage("several files are written; name a folder with --out".to_owned());
        }
        return Ok(());
    };
    let shown = target.display();
    if is_folder || is_many {
        let names_a_file = target.extension().is_some_and(|extension| {
            [Format::Obj, Format::Stl, Format::Glb, Format::Json, Format::F32]
                .iter()
                .any(|format| extension.eq_ignore_ascii_case(format.extension()))
        });
        if target.exists() && !target.is_dir() || !target.exists() && names_a_file {
            return usage(format!("--out {shown}: names a file, but several files are written; name a folder"));
        }
        return Ok(());
    }
    if target.is_dir() || target.file_name().is_none() {
        return usage(format!("--out {shown}: is a folder; name the file to write, or add --parts"));
    }
    if is_baked(target) {
        return usage(format!("--out {shown}: has the extension of packs; name another file"));
    }
    Ok(())
}

fn selected(args: &ExportArgs, path: &Path, pack: &Pack) -> Result<(Vec<usize>, Vec<Body>), Failure> {
    let names: Vec<&str> = pack.hulls().map(|hull| hull.name()).collect();
    let mut is_chosen = vec![args.hulls.is_empty(); names.len()];
    for hull in &args.hulls {
        is_chosen[hull_index(path, hull, &names)?] = true;
    }
    let chosen = pack.hulls().enumerate().zip(is_chosen).filter(|(_, is_chosen)| *is_chosen);
    let (indices, bodies): (Vec<usize>, Vec<Body>) =
        chosen.map(|((index, hull), _)| (index, Body::new(&hull, args.up_axis))).unzip();
    if let Some(body) = bodies.iter().find(|body| body.origin != [0.0; 3]) {
        terminal::note(format_args!(
            "{}: coordinates are relative to the recorded origin, {} in the source (option recentre)",
            path.display(),
            body.origin.map(rounded).join(" ")
        ));
    }
    Ok((indices, bodies))
}

/// Removes hulls that the target does not take, with a warning. None may be left of a pack in a
/// folder.
fn leave_out(args: &ExportArgs, path: &Path, format: Format, bodies: &mut Vec<Body>) -> Result<(), Failure> {
    let (least_rank, holder, holds) = match (args.target, format) {
        (Some(target), _) => (3, target.name(), "solids"),
        (None, Format::Stl) => (2, "STL", "triangles"),
        (None, _) => return Ok(()),
    };
    let unfit: Vec<&Body> = bodies.iter().filter(|body| body.rank < least_rank).collect();
    if unfit.is_empty() {
        return Ok(());
    }
    let described = |body: &&&Body| format!("{} ({})", body.name, rank_name(body.rank));
    let listed: Vec<String> = unfit.iter().take(NAMES_IN_MESSAGE).map(|body| described(&body)).collect();
    let more = if unfit.len() > NAMES_IN_MESSAGE { ", …" } else { "" };
    let message = format!("{holder} takes {holds} only: {}{more}", listed.join(", "));
    let (pack, count) = (path.display(), unfit.len());
    // A folder may hold a flat mesh, too.
    if count == bodies.len() && args.packs.iter().any(|named| named == path) {
        return Err(Failure::rejected(format!("{pack}: nothing to export, because {message}; export as obj or json")));
    }
    let hulls = if count == 1 { "hull" } else { "hulls" };
    terminal::warning(format_args!("{pack}: {count} {hulls} left out, because {message}; export as obj or json"));
    bodies.retain(|body| body.rank >= least_rank);
    Ok(())
}

impl Export<'_> {
    /// Mass properties of the hulls of these indices as one body, for a document that states them.
    /// Prints a note if they are not the mass properties of the mesh.
    fn mass(&self, place: &PackPlace, pack: &Pack, indices: &[usize]) -> Option<MassProperties> {
        if !self.args.target.is_some_and(Target::is_document) {
            return None;
        }
        let density = self.args.density.unwrap_or(DENSITY);
        let mass = pack.mass_properties_of(indices.iter().copied(), density).ok()?;
        if mass.source == MassSource::Hulls {
            let of = if indices.len() > 1 { "hulls, whose overlaps count twice" } else { "hull" };
            terminal::note(format_args!(
                "{}: the mass comes from the {of}, because the pack does not record the mass of the mesh (it is \
                 open, triangles are reversed, or only some of its parts are exported)",
                place.path.display()
            ));
        }
        Some(mass)
    }

    fn rename(&self, place: &PackPlace, pack: &Pack, bodies: &mut [Body]) {
        let args = self.args;
        let own: Vec<(&str, u32)> = bodies.iter().map(|body| (body.name.as_str(), body.part)).collect();
        let new = match args.target {
            None | Some(Target::Usd) => return,
            // They get the names of their nodes.
            Some(Target::Unreal) if args.into.is_some() => return,
            Some(Target::Unreal) => {
                let mesh = args.name.clone().or_else(|| self.render_mesh(place, pack));
                names::unreal(&own, mesh.as_deref())
            }
            Some(Target::KhrPhysics | Target::Omi | Target::Both) => return,
            Some(Target::Godot) => names::godot(&own, args.name.as_deref()),
            Some(Target::Mjcf | Target::Urdf | Target::Sdf) => {
                names::unique(own.iter().map(|(name, _)| names::token(name)).collect())
            }
        };
        for (body, name) in bodies.iter_mut().zip(new) {
            body.name = name;
        }
    }

    /// Name of the node or object of the source mesh, by which Unreal finds collision parts, if the
    /// hulls of the pack are named after the file instead. Prints a note if it is unknown.
    fn render_mesh(&self, place: &PackPlace, pack: &Pack) -> Option<String> {
        let options = BuildOptions::from_recorded(pack.options())?;
        if options.import().split != Split::None || pack.source_path().is_empty() {
            return None;
        }
        let split = pack.options().replacen("split none", "split object", 1);
        let recorded = Recorded { options: &split, ..Recorded::from_pack(pack) };
        let note = |why: &str| {
            let pack = place.path.display();
            terminal::note(format_args!("{pack}: {why}, so names refer to the mesh by its file; see --name"));
            None
        };
        match find_source(place, recorded, None, &Limits::DEFAULT, &self.folders) {
            Ok(SourceSearch::Found(source)) => match source.content.point_sets() {
                [mesh] => Some(mesh.name.clone()),
                meshes => note(&format!("its hulls stand for {} meshes of the source", meshes.len())),
            },
            Ok(SourceSearch::Absent(_)) => note("its source was not found"),
            Err(_) => note("its source has changed"),
        }
    }
}

fn files(
    args: &ExportArgs,
    path: &Path,
    pack: &Pack,
    format: Format,
    is_folder: bool,
    bodies: Vec<Body>,
    mass: Option<&MassProperties>,
) -> Result<Vec<ExportedFile>, Failure> {
    let fault = |message: String| Failure::rejected(format!("{}: {message}", path.display()));
    if !is_folder {
        // `--out` states the name.
        return Ok(vec![file(args, pack, format, String::new(), &bodies).map_err(fault)?]);
    }
    let stems = names::unique(bodies.iter().map(|body| names::token(&body.name)).collect());
    let mut files = Vec::with_capacity(bodies.len() + 1);
    let mut colliders = Vec::with_capacity(bodies.len());
    for (body, stem) in bodies.iter().zip(stems) {
        let primitive = body.primitive.filter(|primitive| robot::can_hold(args.target, primitive.kind));
        let geometry = if let Some(primitive) = primitive {
            Geometry::Primitive(primitive)
        } else {
            let name = format!("{stem}.{}", format.extension());
            files.push(file(args, pack, format, name.clone(), std::slice::from_ref(body)).map_err(fault)?);
            Geometry::Mesh(name)
        };
        colliders.push((body.name.clone(), geometry));
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let name = names::token(args.name.as_deref().unwrap_or(&stem));
    let prefix = args.mesh_prefix.as_deref().unwrap_or_default();
    let inertial = mass.and_then(|mass| Inertial::new(mass, args.up_axis));
    let robot = Robot { name: &name, prefix, colliders: &colliders, inertial };
    let document = match args.target {
        Some(Target::Mjcf) => Some((format!("{name}.xml"), robot.mjcf())),
        Some(Target::Urdf) => Some((format!("{name}.urdf"), robot.urdf())),
        Some(Target::Sdf) => Some((format!("{name}.sdf"), robot.sdf())),
        _ => None,
    };
    // Last, so that the files that it names exist.
    files.extend(document.map(|(name, text)| ExportedFile { name, bytes: sealed(text.into_bytes()), counts: None }));
    Ok(files)
}

fn file(args: &ExportArgs, pack: &Pack, format: Format, name: String, bodies: &[Body]) -> Result<ExportedFile, String> {
    let bytes = match format {
        Format::Obj => obj::write(bodies, args.target == Some(Target::Unreal)),
        Format::Glb if args.target.is_some_and(Target::is_physics) => scene::alone(args, bodies.to_vec())?,
        Format::Glb => glb::write(bodies)?,
        Format::Json => {
            let exported =
                ExportedPack { generator: SEAL, source: pack.source_path(), options: pack.options(), hulls: bodies };
            let mut text = terminal::json(&exported).map_err(|error| error.to_string())?;
            text.push(b'\n');
            sealed(text)
        }
        Format::Stl => bodies.first().map_or(Ok(Vec::new()), stl::write)?,
        Format::F32 => return Err("has no heights; f32 is for height fields: name another format".to_owned()),
    };
    Ok(ExportedFile { name, bytes, counts: Some(counts(bodies)) })
}

/// Writes the files that have changed, with a line for each. Returns their number, and the number
/// of the others.
/// `root`: the folder of many files, in which no link is followed.
fn put(
    args: &ExportArgs,
    targets: Vec<PathBuf>,
    files: Vec<ExportedFile>,
    root: Option<&Path>,
    out: &mut Output,
) -> Result<[usize; 2], Failure> {
    let Some(folder) = targets.first().map(|first| folder_of(first).to_owned()) else { return Ok([0; 2]) };
    if root.is_none() {
        sweep(&folder);
    }
    let lines: Vec<String> = targets.iter().zip(&files).map(|(target, file)| summary(target, file)).collect();
    // A file that gets its own colliders is an input.
    let real = |path: &Path| path.canonicalize().ok();
    let is_input = |target: &PathBuf| args.into.as_deref().is_some_and(|into| real(into) == real(target));
    if let Some(input) = targets.iter().find(|target| target.exists() && is_input(target) && !args.force) {
        return Err(place::exists(input));
    }
    let outputs: Vec<OutputFile> =
        targets.into_iter().zip(files).map(|(path, file)| OutputFile { path, bytes: file.bytes }).collect();
    let states = place::update(&outputs, root.unwrap_or(&folder), args.force)?;
    let written = lines.iter().zip(&states).filter(|(_, state)| **state != State::Same);
    end(Exit::Done, written.clone().try_for_each(|(line, _)| out.line(line)).map_err(Failure::from))?;
    let count = written.count();
    Ok([count, states.len() - count])
}

fn write_unchanged(count: usize, out: &mut Output) -> io::Result<()> {
    match count {
        0 => Ok(()),
        1 => out.line("1 file is unchanged"),
        _ => out.line(format_args!("{} files are unchanged", grouped(count as u64))),
    }
}

fn summary(target: &Path, file: &ExportedFile) -> String {
    let bytes = grouped(file.bytes.len() as u64);
    let Some([hulls, vertices, triangles]) = file.counts.map(|counts| counts.map(|count| count as u64)) else {
        return format!("{}: {bytes} bytes", target.display());
    };
    let hulls = match hulls {
        // A triangle mesh.
        0 => String::new(),
        1 => "1 hull, ".to_owned(),
        _ => format!("{} hulls, ", grouped(hulls)),
    };
    format!(
        "{}: {hulls}{} vertices, {} triangles, {bytes} bytes",
        target.display(),
        grouped(vertices),
        grouped(triangles)
    )
}
