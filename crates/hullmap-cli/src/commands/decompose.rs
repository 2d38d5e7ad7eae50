//! `bake decompose`: a mesh file becomes a file of convex parts, without a pack.

use std::iter;
use std::path::Path;
use std::time::Instant;

use hullmap::Pack;
use hullmap_bake::decompose::{CurvePoint, curve};
use hullmap_bake::progress::Stage;
use hullmap_bake::{PointSet, SolidKind, SourceRecord};
use hullmap_geometry::number::{percent, short};
use hullmap_import::{Imported, ReadError, UpAxis, import as import_objects, read};
use serde::Serialize;

use crate::args::DecomposeArgs;
use crate::interrupt;
use crate::progress::Progress;
use crate::rows::Notes;
use crate::table::Table;
use crate::terminal::{self, Output};
use hullmap_bake::parts::estimates::DecomposedObject;
use hullmap_geometry::number::grouped;
use hullmap_pipeline::baker::{BakedPack, bake_pack};
use hullmap_pipeline::mesh_file::body::Body;
use hullmap_pipeline::mesh_file::place::{self, OutputFile};
use hullmap_pipeline::mesh_file::{glb, obj};
use hullmap_pipeline::options::BuildOptions;
use hullmap_pipeline::outcome::{Exit, Failure, end};
use hullmap_pipeline::pack_file::folder_of;
use hullmap_pipeline::runner::rows::Status;
use hullmap_pipeline::runner::{self, Observer, schedule};

/// Share of the time after which the meshes are read.
const READ: f64 = 0.05;

const COST: u64 = 1000;

type Write = fn(&[Body]) -> Result<Vec<u8>, String>;

const FORMATS: [(&str, Write); 2] = [("obj", |bodies| Ok(obj::write(bodies, false))), ("glb", glb::write)];

/// Result of the command. Field names are the JSON's.
#[derive(Debug, Serialize)]
struct Report {
    source: String,
    output: String,
    parts: usize,
    vertices: usize,
    triangles: usize,
    bytes: usize,
    millis: f64,
    notes: Vec<String>,
    warnings: Vec<String>,
    meshes: Vec<MeshReport>,
}

/// Lengths are in the unit of the output. The fit is `None` if unknown, as without faces.
#[derive(Debug, Serialize)]
struct MeshReport {
    name: String,
    parts: usize,
    vertices: usize,
    triangles: usize,
    diagonal: f64,
    solid: Option<&'static str>,
    uncovered: Option<f64>,
    protrusion: Option<f64>,
    overlap: Option<f64>,
    overlap_error: Option<f64>,
}

pub fn run(args: &DecomposeArgs, out: &mut Output) -> Result<Exit, Failure> {
    let start = Instant::now();
    interrupt::catch();
    let Some(output) = args.file() else { return curves(args, out) };
    let write = writer(output)?;
    check_output(args, output)?;
    let (imported, pack) = with_progress(args, |stage| decompose(args, stage))?;
    let fault = |error: String| Failure::rejected(format!("{}: {error}", args.input.display()));
    let opened = Pack::from_bytes(&pack.bytes).map_err(|error| fault(error.to_string()))?;
    let bodies: Vec<Body> = opened.hulls().map(|hull| Body::new(&hull, UpAxis::Keep)).collect();
    let bytes = write(&bodies).map_err(fault)?;
    let length = bytes.len();
    place::update(&[OutputFile { path: output.to_owned(), bytes }], folder_of(output), args.force)?;
    let meshes = describe(&imported.point_sets, &opened, &bodies, &pack.objects);
    let report = Report {
        source: args.input.display().to_string(),
        output: output.display().to_string(),
        parts: bodies.len(),
        vertices: meshes.iter().map(|mesh| mesh.vertices).sum(),
        triangles: meshes.iter().map(|mesh| mesh.triangles).sum(),
        bytes: length,
        millis: (start.elapsed().as_secs_f64() * 1e4).round() / 10.0,
        notes: [imported.notes, pack.notes].concat(),
        warnings: pack.warnings,
        meshes,
    };
    let written =
        if args.json { out.json(&report).map_err(Failure::from) } else { write_text(&report, args.verbose, out) };
    end(Exit::Done, written)
}

fn writer(output: &Path) -> Result<Write, Failure> {
    let extension = output.extension().unwrap_or_default();
    let found = FORMATS.iter().find(|(name, _)| extension.eq_ignore_ascii_case(name));
    found.map(|(_, write)| *write).ok_or_else(|| {
        let formats = FORMATS.map(|(name, _)| format!(".{name}")).join(" or ");
        Failure::usage(format!(
            "{}: the format is unknown; name a file with the extension {formats}, or make a pack by `bake build \
             --decompose`",
            output.display()
        ))
    })
}

fn check_output(args: &DecomposeArgs, output: &Path) -> Result<(), Failure> {
    let shown = output.display();
    if output.is_dir() {
        return Err(Failure::usage(format!("{shown}: is a folder; name the file to write")));
    }
    let [input, target] = [&args.input, output].map(|path| path.canonicalize().ok());
    if input.is_some() && input == target {
        return Err(Failure::usage(format!("{shown}: is the mesh itself; name another file")));
    }
    if args.force { Ok(()) } else { place::check_free(output) }
}

fn with_progress<T: Send>(
    args: &DecomposeArgs,
    work: impl Fn(Stage) -> Result<T, Failure> + Sync,
) -> Result<T, Failure> {
    let pool = runner::threads(args.threads.jobs)?;
    let progress = Progress::new(1, COST);
    let work = |index: usize| {
        let done = progress.begin(index, &args.input, COST);
        let result = work(done.whole());
        progress.end(index, if result.is_ok() { Status::Baked } else { Status::Failed });
        result
    };
    let mut results = schedule::run_bounded(&pool, &[COST], COST, work, || progress.tick());
    results.pop().unwrap_or_else(|| Err(Failure::usage("no thread did the work".to_owned())))
}

fn options(args: &DecomposeArgs) -> BuildOptions {
    let mut layer = args.options.0.clone();
    for (key, value) in [("decompose", "true"), ("index", "none")] {
        layer.set(key, value).expect("the table has the value");
    }
    layer.resolve()
}

fn import(args: &DecomposeArgs) -> Result<Imported, Failure> {
    let (path, file) = (&args.input, args.input.display().to_string());
    let (options, limits) = (options(args), args.limits.limits());
    let source = read(&file, path, &limits).map_err(|error| match error {
        ReadError::Io(error) => Failure::usage(format!("{file}: cannot read: {error}; check the file")),
        ReadError::Import(error) => Failure::rejected(error.to_string()),
    })?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut imported = import_objects(&file, &stem, path, &source, &options.import(), &limits)
        .map_err(|error| Failure::rejected(error.to_string()))?;
    imported.give_triangles();
    Ok(imported)
}

fn decompose(args: &DecomposeArgs, stage: Stage) -> Result<(Imported, BakedPack), Failure> {
    let mut imported = import(args)?;
    stage.reach(READ);
    let (file, options) = (args.input.display().to_string(), options(args));
    let record = SourceRecord { warnings: std::mem::take(&mut imported.warnings), ..SourceRecord::default() };
    let pack = bake_pack(&imported.point_sets, &options, &record, stage.from_to(READ, 1.0))
        .map_err(|error| Failure::rejected(format!("{file}: {error}")))?;
    Ok((imported, pack))
}

/// The curve of a mesh. Field names are the JSON's; lengths are in the unit of the output.
#[derive(Debug, Serialize)]
struct MeshCurve {
    name: String,
    diagonal: f64,
    curve: Vec<CurveRow>,
}

#[derive(Debug, Serialize)]
struct CurveRow {
    max_error: f64,
    parts: usize,
    vertices: usize,
    protrusion: Option<f64>,
}

/// Prints the curve of each mesh.
fn curves(args: &DecomposeArgs, out: &mut Output) -> Result<Exit, Failure> {
    let found = with_progress(args, |stage| {
        let imported = import(args)?;
        let cover = options(args).decompose().unwrap_or_default();
        let row =
            |CurvePoint { max_error, parts, vertices, protrusion }| CurveRow { max_error, parts, vertices, protrusion };
        let steps = stage.steps(imported.point_sets.len());
        let of_mesh = |mesh: &PointSet| {
            let points = curve(mesh, &cover, Stage::default());
            let points = points.map_err(|error| Failure::rejected(format!("{}: {error}", args.input.display())))?;
            steps.take();
            let curve = points.into_iter().map(row).collect();
            Ok(MeshCurve { name: mesh.name.clone(), diagonal: mesh.diagonal(), curve })
        };
        imported.point_sets.iter().map(of_mesh).collect::<Result<Vec<_>, Failure>>()
    })?;
    let written = if args.json { out.json(&found).map_err(Failure::from) } else { write_curves(&found, out) };
    end(Exit::Done, written)
}

fn write_curves(found: &[MeshCurve], out: &mut Output) -> Result<(), Failure> {
    let mut table = Table::headed("mesh: | parts | vertices | protrusion | --max-error");
    for MeshCurve { name, diagonal, curve } in found {
        for row in curve {
            table.push(vec![
                name.clone(),
                grouped(row.parts as u64),
                grouped(row.vertices as u64),
                row.protrusion.map_or_else(|| "unmeasured".to_owned(), |length| percent(length / diagonal)),
                percent(row.max_error / diagonal),
            ]);
        }
    }
    Ok(table.write(out)?)
}

/// Describes the parts of each mesh. The hulls of a mesh are consecutive, and the first is part 0.
/// Objects with parts are in the order of the meshes.
fn describe(meshes: &[PointSet], pack: &Pack, bodies: &[Body], objects: &[DecomposedObject]) -> Vec<MeshReport> {
    let hulls: Vec<_> = pack.hulls().collect();
    let mut own = hulls.chunk_by(|_, next| next.part() > 0);
    let mut bodies = bodies.chunk_by(|_, next| next.part > 0);
    let mut objects = objects.iter().peekable();
    let mut described = Vec::with_capacity(meshes.len());
    for mesh in meshes {
        let (own, bodies) = (own.next().unwrap_or_default(), bodies.next().unwrap_or_default());
        let first = own.first();
        let object = objects.next_if(|object| object.name == mesh.name && object.parts == own.len());
        let single = (own.len() < 2).then_some(0.0);
        described.push(MeshReport {
            name: mesh.name.clone(),
            parts: own.len(),
            vertices: bodies.iter().map(|body| body.positions.len()).sum(),
            triangles: bodies.iter().map(|body| body.triangles().count()).sum(),
            diagonal: mesh.diagonal(),
            solid: first.and_then(|hull| hull.solid()).map(SolidKind::as_str),
            uncovered: first.and_then(|hull| hull.uncovered()),
            protrusion: own.iter().map(|hull| hull.protrusion()).reduce(|a, b| Some(a?.max(b?))).flatten(),
            overlap: object.map_or(single, |object| object.estimates.overlap),
            overlap_error: object.map_or(single, |object| object.estimates.overlap_error),
        });
    }
    described
}

fn write_text(report: &Report, is_verbose: bool, out: &mut Output) -> Result<(), Failure> {
    let Report { source, notes, warnings, .. } = report;
    Notes::new(iter::once((&**source, &**notes)), is_verbose).print(source, notes);
    warnings.iter().for_each(|warning| terminal::warning(format_args!("{source}: {warning}")));
    for mesh in &report.meshes {
        let noun = if mesh.parts == 1 { "part" } else { "parts" };
        let bound = |length: Option<f64>| match length {
            Some(length) => format!("at most {} ({} of the diagonal)", short(length), percent(length / mesh.diagonal)),
            None => "unmeasured".to_owned(),
        };
        out.line(format_args!(
            "{}: {} {noun}, {} vertices; protrusion {}",
            mesh.name,
            grouped(mesh.parts as u64),
            grouped(mesh.vertices as u64),
            bound(mesh.protrusion),
        ))?;
    }
    Ok(out.line(format_args!("{}: {} bytes", report.output, grouped(report.bytes as u64)))?)
}
