//! `bake robot`: replaces the collision meshes of robot descriptions by hulls.
//!
//! 1. `hullmap_robot` reads each description, and finds its meshes.
//! 2. [`choice`] decides what happens to each collision. Equal meshes with equal options are one
//!    job, whatever their scales: the description keeps its scales.
//! 3. [`runner`](hullmap_pipeline::runner) bakes the jobs of all descriptions, as `bake build`
//!    does.
//! 4. The hulls are written as OBJ files beside the packs, and the description last, so that it
//!    never names a file that does not exist.
//!
//! Nothing is written for a description that fails, except packs. The others are still processed.

mod bodies;
mod choice;
mod files;
mod hulls;
mod inertia;
mod inline;
mod meshes;
mod page;
mod pairs;
mod rows;
mod sampling;
mod target;
mod touching;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use hullmap_robot::{
    Change, Description, Format, Geometry, Link, Places, RobotError, Scheme, Skipped, escaped, relative,
};

use hullmap_geometry::number::short;

use crate::args::{DECIDED_BY_ROBOTS, FromVisual, RobotArgs, reason_of_robots};
use crate::interrupt;
use crate::rows::{Notes, run_jobs};
use crate::terminal::{self, Output};
use choice::{Choice, Choices, Chooser};
use files::{Outputs, OwnHulls};
use hullmap_pipeline::baker::bake_pack;
use hullmap_pipeline::config::Configs;
use hullmap_pipeline::glob::Glob;
use hullmap_pipeline::jobs::Job;
use hullmap_pipeline::mesh_file::place::{OutputFile, State, check_free};
use hullmap_pipeline::options::flag;
use hullmap_pipeline::outcome::{Exit, Failure, end};
use hullmap_pipeline::pack_file::{folder_of, plain, shown_from, sweep};
use hullmap_pipeline::packs::PackPlace;
use hullmap_pipeline::project::Project;
use hullmap_pipeline::runner::one::Build;
use hullmap_pipeline::runner::rows as build_rows;
use hulls::{Fault, Hulls, read_hulls};
use meshes::Meshes;
use pairs::{Pairs, Sampling};
use rows::{Collision, ExcludedPair, Row, SkippedRow, Status};
use target::{Target, is_same_file};

struct Robot {
    description: Description,
    target: Target,
    /// Where each of its documents is written.
    documents: Vec<PathBuf>,
    choices: Choices,
    inline: Vec<OutputFile>,
    /// Names of packages that lead to no file from the output.
    unreachable: Vec<String>,
    /// Index of its first job among the jobs of all descriptions.
    first_job: usize,
}

pub fn run(args: &RobotArgs, out: &mut Output) -> Result<Exit, Failure> {
    interrupt::catch();
    check_flags(args)?;
    let project = Path::new(".");
    let mut configs = Configs::new(args.config.as_deref())?;
    let (mut robots, mut job_count) = (Vec::new(), 0);
    let mut outputs = Outputs::default();
    let read: Vec<(Row, Read)> = args.inputs.iter().map(|input| read(args, input)).collect();
    let descriptions: Vec<&Description> = read.iter().filter_map(|(_, own)| Some(&own.as_ref().ok()?.0)).collect();
    let target = |(_, own): &(Row, Read)| match own {
        Ok((description, _)) => Target::new(args, description, &descriptions),
        Err(failure) => Err(failure.clone()),
    };
    let targets: Vec<Result<Target, Failure>> = read.iter().map(target).collect();
    for ((input, (mut row, own)), target) in args.inputs.iter().zip(read).zip(targets) {
        let start = Instant::now();
        let ready = target.and_then(|target| Ok((own?, target))).map_err(|failure| vec![failure]);
        let prepared = ready.and_then(|(own, target)| prepare(args, own, target, &mut configs)).and_then(|robot| {
            if let Some(first) = outputs.documents.get(&robot.target.file) {
                let message = "would both be written to the same file; write them to separate folders";
                return Err(vec![Failure::usage(format!("{} and {} {message}", first.display(), input.display()))]);
            }
            let sources = robot.description.documents.iter().map(|own| own.path().to_owned());
            outputs.documents.extend(robot.documents.iter().cloned().zip(sources));
            Ok(robot)
        });
        row.millis += millis(start);
        let prepared = prepared.map(|mut robot| {
            robot.first_job = job_count;
            job_count += robot.choices.jobs.len();
            robot
        });
        robots.push((row, prepared));
    }
    for glob in args.exclude.iter().filter(|glob| !robots.iter().any(|(_, robot)| has_link(robot, glob))) {
        terminal::warning(format_args!("--exclude: no link matches `{}`", glob.text));
    }
    configs.warnings_of_links().iter().for_each(terminal::warning);
    configs.overridden(&args.options.0).iter().for_each(terminal::note);
    let baked = bake(args, &robots, project)?;
    let mut exit = Exit::Done;
    let (mut rows, mut finished): (Vec<Row>, _) = (Vec::new(), Vec::new());
    for (mut row, robot) in robots {
        let start = Instant::now();
        let result = robot.and_then(|robot| {
            let jobs = &baked[robot.first_job..robot.first_job + robot.choices.jobs.len()];
            finish(args, robot, jobs, &mut row, &mut outputs).map_err(|failure| vec![failure])
        });
        match result {
            Ok((own, hulls)) => {
                exit = exit.max(own);
                finished.extend(hulls.map(|hulls| (rows.len(), hulls)));
            }
            Err(failures) => {
                row.status = Status::Failed;
                exit = failures.iter().map(|failure| failure.exit).chain([exit]).max().unwrap_or(exit);
                row.errors.extend(failures.into_iter().map(|failure| failure.message));
            }
        }
        row.millis += millis(start);
        rows.push(row);
    }
    for (row, hulls) in finished {
        let unused = hulls.left_over(&outputs);
        if !unused.is_empty() {
            let (row, names) = (&mut rows[row], listed(unused.iter().map(|path| shown(path))));
            row.warnings.push(format!("{}: hulls of earlier runs are not in use: {names}; remove them", row.file));
        }
    }
    let changed = rows.iter().filter(|row| row.status != Status::Fresh).map(|row| (&*row.file, &*row.notes));
    let mut notes = Notes::new(changed, args.run.verbose);
    rows.iter().for_each(|row| row.print_messages(&mut notes));
    let written = match args.run.json {
        true => rows.iter().try_for_each(|row| out.json(row)).map_err(Failure::from),
        false => rows.iter().try_for_each(|row| row.write(args.run.verbose, out)),
    };
    end(exit, written)
}

/// Whether a description has a link of this name. One that cannot be read may have it.
fn has_link(robot: &Result<Robot, Vec<Failure>>, glob: &Glob) -> bool {
    robot.as_ref().map_or(true, |robot| robot.description.links.iter().any(|link| choice::matches(glob, &link.name)))
}

fn millis(start: Instant) -> f64 {
    (start.elapsed().as_secs_f64() * 1e4).round() / 10.0
}

fn check_flags(args: &RobotArgs) -> Result<(), Failure> {
    if let Some(key) = DECIDED_BY_ROBOTS.iter().find(|key| args.options.0.get(key).is_some()) {
        let (flag, reason) = (flag(key), reason_of_robots(key));
        let message = format!("{flag} has no effect on robots, {reason}; remove it");
        return Err(Failure::usage(message));
    }
    let is_single = args.inputs.len() == 1;
    if !is_single && target::is_file(args) {
        return Err(Failure::usage(format!(
            "{}: is a file, but there are several descriptions; name a folder with --out",
            args.out.display()
        )));
    }
    if args.report.is_some() && !is_single {
        let message = "--report writes the page of one description, but there are several; run it once for each";
        return Err(Failure::usage(message.to_owned()));
    }
    if let Some(missing) = args.packages.iter().find(|package| !package.is_dir()) {
        return Err(Failure::usage(format!(
            "--package-path {}: is not a folder; name a folder of packages",
            missing.display()
        )));
    }
    Ok(())
}

type Read = Result<(Description, Places), Failure>;

fn read(args: &RobotArgs, input: &Path) -> (Row, Read) {
    let start = Instant::now();
    let place = PackPlace { path: input.to_owned(), below: PathBuf::new() };
    let project = Project::of_pack(&place, Path::new("."));
    let roots = project.iter().map(|project| project.root().to_owned()).collect();
    let remedy = Some("restore it, or leave its link alone with `bake robot --exclude`");
    let places = Places { packages: args.packages.clone(), roots, remedy, ..Places::default() };
    let read = Description::read(input, &places).map_err(|error| failure(&error)).and_then(|description| {
        if args.exclude_pairs && description.format == Format::Sdf {
            let message = "--exclude-pairs is for URDF and MJCF: in SDF, links of a model meet only with self_collide";
            return Err(Failure::usage(format!("{}: {message}; remove the flag", input.display())));
        }
        Ok((description, places))
    });
    let mut row = Row::new(input.display().to_string());
    row.millis = millis(start);
    (row, read)
}

/// Decides on the collisions of a description. Several faults are reported together.
fn prepare(
    args: &RobotArgs,
    (mut description, places): (Description, Places),
    target: Target,
    configs: &mut Configs,
) -> Result<Robot, Vec<Failure>> {
    let one = |failure| vec![failure];
    let inline = inline::extract(&mut description, &target);
    let chooser = Chooser { args, description: &description, target: &target };
    let mut choices = chooser.choose(configs).map_err(one)?;
    // Before meshes are baked, which may take minutes.
    if !args.force && !choices.jobs.is_empty() && is_same_file(description.path(), &target.file) {
        return Err(one(would_be_replaced(description.path())));
    }
    if !choices.errors.is_empty() {
        return Err(std::mem::take(&mut choices.errors).into_iter().map(Failure::rejected).collect());
    }
    let resolved = choices.jobs.iter().map(|job| &job.options);
    let unused = args.options.0.without_effect(resolved).filter(|_| !choices.jobs.is_empty());
    if let Some(unused) = unused {
        return Err(one(Failure::usage(unused.message(flag))));
    }
    if !args.check {
        let warnings = huge_links(&description, &choices, &mut Meshes::new(args.limits.limits()));
        // A decomposition of such a mesh may take hours, so the warning is not for its end.
        match args.run.json {
            true => choices.warnings.extend(warnings),
            false => warnings.iter().for_each(terminal::warning),
        }
    }
    let unreachable = unreachable(&description, &target, &choices, &places);
    let documents = document_paths(&description, &target).map_err(one)?;
    Ok(Robot { description, target, documents, choices, inline, unreachable, first_job: 0 })
}

/// Diagonal of a link's mesh, in metres, above which its unit is in doubt.
const HUGE: f64 = 20.0;

/// Warnings about meshes that are as large as if their unit were the millimetre.
fn huge_links(description: &Description, choices: &Choices, meshes: &mut Meshes) -> Vec<String> {
    let mut warnings = Vec::new();
    for (index, own) in choices.hulls.iter().enumerate() {
        let Some(length) = meshes.get(&own.mesh).map(|mesh| mesh.diagonal() * own.mesh.stretch()) else { continue };
        let user = choices.shapes.iter().find(|shape| matches!(shape.choice, Choice::Hulls(at) if at == index));
        if let Some(user) = user.filter(|_| length > HUGE) {
            let shape = choices.shape(user, description);
            let (file, link) = (description.documents[shape.document].path(), &description.links[user.link].name);
            warnings.push(format!(
                "{}:{}: the mesh of link `{link}` is {} m long; if its unit is the millimetre, scale it by 0.001 in \
                 the description",
                file.display(),
                shape.line,
                short(length)
            ));
        }
    }
    warnings
}

fn failure(error: &RobotError) -> Failure {
    if error.is_unreadable { Failure::usage(error.to_string()) } else { Failure::rejected(error.to_string()) }
}

/// Fails if another description of this run has written other bytes to one of these files.
fn check_clashes(files: &[OutputFile], outputs: &Outputs, file: &str) -> Result<(), Failure> {
    for OutputFile { path, bytes } in files {
        if let Some((_, other)) = outputs.written.get(path).filter(|(other, _)| other != bytes) {
            return Err(Failure::usage(format!(
                "{}: {other} and {file} would write different files there; write them to separate folders, or name \
                 only the one that contains the other",
                shown(path)
            )));
        }
    }
    Ok(())
}

type Prepared = (Row, Result<Robot, Vec<Failure>>);

fn bake(args: &RobotArgs, robots: &[Prepared], project: &Path) -> Result<Vec<(build_rows::Row, Exit)>, Failure> {
    let ready = || robots.iter().filter_map(|(_, robot)| robot.as_ref().ok());
    let jobs: Vec<&Job> = ready().flat_map(|robot| &robot.choices.jobs).collect();
    if jobs.is_empty() {
        return Ok(Vec::new());
    }
    if !args.check {
        let folders: BTreeSet<&Path> =
            ready().flat_map(|robot| [robot.target.meshes.as_path(), &robot.target.folder]).collect();
        folders.into_iter().for_each(sweep);
        for robot in ready() {
            let out = folder_of(&robot.target.file);
            let mut changed = robot.inline.iter().filter(|own| own.state().is_ok_and(|state| state != State::Same));
            changed.try_for_each(|own| own.write(out))?;
        }
    }
    let out = if target::is_file(args) { folder_of(&args.out) } else { &args.out };
    let build = Build {
        limits: args.limits.limits(),
        verify: false,
        force: args.force,
        check: args.check,
        cache: None,
        out,
        project,
        baker: &bake_pack,
    };
    run_jobs(&jobs, &build, &args.run)
}

/// The mesh and the reason, if its hulls are stale or missing.
fn why_stale(own: &build_rows::Row) -> Option<String> {
    let is_stale = matches!(own.status, build_rows::Status::Stale | build_rows::Status::Missing);
    is_stale.then(|| format!("{}: {}", shown(Path::new(&own.source)), own.reason.as_deref().unwrap_or("stale")))
}

fn finish(
    args: &RobotArgs,
    robot: Robot,
    baked: &[(build_rows::Row, Exit)],
    row: &mut Row,
    outputs: &mut Outputs,
) -> Result<(Exit, Option<OwnHulls>), Failure> {
    row.format = Some(robot.description.format.name());
    row.links = Some(robot.description.links.len());
    row.output = Some(shown(&robot.target.file));
    remarks(args, &robot, outputs, row);
    let Robot { description, target, choices, inline, documents: paths, .. } = robot;
    remarks_of_bakes(args, baked, row);
    let states: Vec<State> = inline.iter().map(OutputFile::state).collect::<Result<_, _>>()?;
    if let Some((own, _)) = inline.iter().zip(states).find(|(_, state)| *state != State::Same) {
        row.status = if target.file.exists() { Status::Stale } else { Status::Missing };
        row.reason = Some(format!("{} is not the mesh in the description", shown(&own.path)));
        return Ok((Exit::Rejected, None));
    }
    let failed: Vec<String> = baked.iter().filter_map(|(own, _)| own.error.clone()).collect();
    if let Some((last, others)) = failed.split_last() {
        row.errors.extend(others.iter().cloned());
        let exit = baked.iter().map(|(_, exit)| *exit).max().unwrap_or(Exit::Rejected);
        return Err(Failure { exit, message: format!("{last}; a rule or --exclude leaves its link alone") });
    }
    let stale: Vec<String> = baked.iter().filter_map(|(own, _)| why_stale(own)).collect();
    if !stale.is_empty() {
        row.status = if target.file.exists() { Status::Stale } else { Status::Missing };
        row.reason = Some(stale.join("; "));
        return Ok((Exit::Rejected, None));
    }
    let mut meshes = Meshes::new(args.limits.limits());
    let read = choices.hulls.iter().map(|own| read_hulls(&choices.jobs, own, &mut meshes));
    let mut hulls: Vec<Hulls> = read.collect::<Result<_, _>>()?;
    let mut changes = changes(&description, &target, &choices, &hulls, row)?;
    if args.run.json {
        let (skipped, note) = pairs::skipped(&description, &changes);
        let rows = skipped.into_iter().map(Skipped::row);
        row.skipped = Some(rows.map(|(links, geoms, reason)| SkippedRow { links, geoms, reason }).collect());
        row.notes.extend(note);
    }
    if args.inertia {
        changes.extend(inertias(&description, &choices, &hulls, row));
    }
    let (mut files, mut page) = (Vec::new(), None);
    if args.exclude_pairs || args.report.is_some() {
        let sampling = Sampling { count: args.samples, seed: args.seed };
        let pairs = Pairs::new(&description, &choices, &hulls, &mut meshes, sampling);
        if args.exclude_pairs {
            changes.push(pairs.change());
            files.extend(exclude(args, &description, &target, &pairs, row)?);
            row.warnings.extend(pairs.unread(&description));
            if !description.others.is_empty() {
                let message = "bodies of models in other files were not tested, and none of their pairs is excluded";
                row.warnings.push(format!("{}: {message}", row.file));
            }
            row.warnings.extend(pairs.filled(&description, &choices, &hulls, &mut meshes));
        }
        if args.report.is_some() {
            let gatherer =
                page::Gatherer { description: &description, choices: &choices, hulls: &hulls, meshes: &mut meshes };
            page = Some(page::page(gatherer, &pairs, row));
        }
    }
    let documents = description.changed(&changes).map_err(|error| failure(&error))?;
    files.extend(hulls.iter_mut().filter(|own| own.fault.is_none()).flat_map(|own| std::mem::take(&mut own.files)));
    files.extend(copies(&description, &target, &documents, &outputs.documents)?);
    // The description itself is last.
    files.extend(paths.into_iter().zip(documents).rev().map(|(path, bytes)| OutputFile { path, bytes }));
    check_inputs(args, &description, &files)?;
    check_clashes(&files, outputs, &row.file)?;
    let exit = settle(args, &target, &files, row)?;
    if let Some((file, page)) = args.report.as_ref().zip(page) {
        OutputFile { path: file.clone(), bytes: page.into_bytes() }.write_if_changed()?;
    }
    let own_hulls = OwnHulls::new(&description, &target.folder, &target.meshes);
    outputs.written.extend(files.into_iter().map(|file| (file.path, (file.bytes, row.file.clone()))));
    Ok((exit, own_hulls))
}

fn remarks_of_bakes(args: &RobotArgs, baked: &[(build_rows::Row, Exit)], row: &mut Row) {
    for (own, _) in baked {
        row.baked += usize::from(own.status == build_rows::Status::Baked);
        // A warning says why a mesh is one hull although parts are wanted.
        let is_news = |note: &&String| args.options.0.get("decompose").is_none() || !note.ends_with("use --decompose");
        let notes = own.notes.iter().filter(is_news);
        row.notes.extend(notes.map(|note| format!("{}: {note}", shown(Path::new(&own.source)))));
        row.warnings.extend(own.warnings.iter().map(|warning| format!("{}: {warning}", shown(Path::new(&own.source)))));
    }
}

fn remarks(args: &RobotArgs, robot: &Robot, outputs: &Outputs, row: &mut Row) {
    let Robot { description, target, choices, unreachable, .. } = robot;
    row.notes.extend(description.notes.iter().cloned());
    row.notes.extend(links_without_collision(description, choices, args.from_visual));
    row.warnings.extend(description.warnings.iter().cloned());
    row.warnings.extend(description.chain.warnings.iter().map(|own| format!("{}: {own}", row.file)));
    row.warnings.extend(choices.warnings.iter().cloned());
    row.warnings.extend(models_in_other_files(description, outputs, &row.file));
    if !unreachable.is_empty() {
        let (names, out) = (listed(unreachable.iter().map(|name| format!("`{name}`"))), shown(&target.folder));
        let remedy = "write the output into the package, or tell programs where the package is";
        row.warnings.push(format!("{}: names that lead to no file from {out}: {names}; {remedy}", row.file));
    }
}

/// Warning about attached and included models that are not inputs of this run.
fn models_in_other_files(description: &Description, outputs: &Outputs, file: &str) -> Option<String> {
    let inputs: Vec<PathBuf> = outputs.documents.values().filter_map(|input| input.canonicalize().ok()).collect();
    let is_input = |path: &PathBuf| inputs.iter().any(|input| input.starts_with(path));
    let others = description.others.iter().filter(|other| !other.path.as_ref().is_some_and(is_input));
    let names: Vec<String> = others.map(|other| format!("`{}` (line {})", other.written, other.line)).collect();
    (!names.is_empty()).then(|| {
        let names = listed(names.into_iter());
        format!("{file}: models in other files keep their collisions: {names}; name these files in the same run, too")
    })
}

const NAMES_IN_NOTE: usize = 5;

fn listed(names: impl ExactSizeIterator<Item = String>) -> String {
    let others = names.len().saturating_sub(NAMES_IN_NOTE);
    let first: Vec<String> = names.take(NAMES_IN_NOTE).collect();
    if others == 0 { first.join(", ") } else { format!("{} and {others} more", first.join(", ")) }
}

fn links_without_collision(description: &Description, choices: &Choices, from_visual: FromVisual) -> Option<String> {
    let gets_one = choices.shapes.iter().filter(|own| own.from_visual && !matches!(own.choice, Choice::Kept(_)));
    let gets_one: BTreeSet<usize> = gets_one.map(|own| own.link).collect();
    let links = description.links.iter().enumerate().filter(|(_, link)| link.collisions.is_empty());
    let (with, without): (Vec<_>, Vec<_>) = links
        .filter(|(_, link)| link.takes_visuals && !link.visuals.is_empty())
        .partition(|(at, _)| gets_one.contains(at));
    let names = |links: &[(usize, &Link)]| listed(links.iter().map(|(_, link)| format!("`{}`", link.name)));
    if !with.is_empty() {
        return Some(format!(
            "links without a collision get one from their visuals: {}; --from-visual never leaves them without",
            names(&with)
        ));
    }
    (from_visual == FromVisual::Missing && description.format == Format::Mjcf && !without.is_empty()).then(|| {
        format!(
            "bodies whose geoms do not collide stay so: {}; --from-visual always makes collisions of their geoms",
            names(&without)
        )
    })
}

/// The pairs of a URDF file go to a separate file, unless one exists that this command did not
/// write.
fn exclude(
    args: &RobotArgs,
    description: &Description,
    target: &Target,
    pairs: &Pairs,
    row: &mut Row,
) -> Result<Option<OutputFile>, Failure> {
    row.excluded_pairs = Some(pairs.excluded.iter().map(|pair| ExcludedPair::new(pair, description)).collect());
    row.exclusions = Some(format!("excluded pairs of links: {}. {}", pairs.excluded.len(), pairs.in_words()));
    if description.format != Format::Urdf {
        return Ok(None);
    }
    let output = OutputFile { path: target.file.with_extension("srdf"), bytes: pairs.srdf(description) };
    if !args.force && !args.check && output.state()? == State::Other {
        check_free(Path::new(&shown(&output.path)))?;
    }
    Ok(Some(output))
}

/// Packages or models of kept meshes whose names lead elsewhere from the description's new place.
fn unreachable(description: &Description, target: &Target, choices: &Choices, places: &Places) -> Vec<String> {
    let kept = choices.shapes.iter().filter(|own| matches!(own.choice, Choice::Kept(_)));
    let kept = kept.map(|own| choices.shape(own, description));
    let shapes = description.links.iter().flat_map(|link| &link.visuals).chain(kept);
    let meshes: BTreeMap<&str, &PathBuf> = shapes
        .filter_map(|shape| match &shape.geometry {
            Geometry::Mesh(mesh) => {
                Some((Scheme::split(&mesh.written).map(|_| mesh.written.as_str())?, mesh.file.as_ref().ok()?))
            }
            _ => None,
        })
        .collect();
    // Other programs do not search the project.
    let places = Places { found: Arc::new(Vec::new().into()), ..places.clone() };
    let is_reached =
        |name: &str, file: &Path| places.resolve(name, &target.folder).is_ok_and(|found| is_same_file(&found, file));
    let lost = meshes.into_iter().filter(|(name, file)| target.is_elsewhere() && !is_reached(name, file));
    lost.map(|(name, _)| name.to_owned()).collect()
}

fn shown(path: &Path) -> String {
    let path = if path.is_absolute() { shown_from(path, Path::new(".")) } else { path.to_owned() };
    path.display().to_string()
}

fn changes(
    description: &Description,
    target: &Target,
    choices: &Choices,
    hulls: &[Hulls],
    row: &mut Row,
) -> Result<Vec<Change>, Failure> {
    let mut changes = Vec::new();
    for own in &choices.shapes {
        let link = &description.links[own.link];
        let shape = choices.shape(own, description);
        let mut collision = Collision {
            link: link.name.clone(),
            name: shape.name.clone(),
            line: shape.line,
            action: "kept",
            reason: None,
            from_visual: own.from_visual,
            source: None,
            pack: None,
            meshes: Vec::new(),
            vertices: None,
            protrusion_mm: None,
            uncovered_mm: None,
        };
        let (link_index, index) = (own.link, own.shape);
        match &own.choice {
            Choice::Kept(reason) => collision.reason = Some(reason.clone()),
            Choice::Removed => {
                collision.action = "removed";
                changes.push(Change::Remove { link: link_index, collision: index });
            }
            Choice::Primitive => {
                collision.action = "primitive";
                changes.push(Change::FromVisual { link: link_index, visual: index, meshes: None });
            }
            Choice::Hulls(at) => {
                let own_hulls = &hulls[*at];
                collision.source = Some(shown(&choices.jobs[choices.hulls[*at].job].source));
                if let Some(fault) = &own_hulls.fault {
                    let Fault { reason, remedy } = fault;
                    let source = collision.source.as_deref().unwrap_or_default();
                    let name = &link.name;
                    row.warnings.push(format!("{source}: {reason}, so link `{name}` keeps it; {remedy}"));
                    collision.reason = Some(reason.clone());
                    row.collisions.push(collision);
                    continue;
                }
                let name = |file: &OutputFile| description.mesh_name(&file.path, &target.folder);
                let meshes: Vec<String> =
                    own_hulls.files.iter().map(name).collect::<Result<_, _>>().map_err(|error| failure(&error))?;
                let stretch = match &shape.geometry {
                    Geometry::Mesh(mesh) => mesh.stretch(),
                    _ => 1.0,
                };
                let millimetres = |bound: Option<f64>| bound.map(|bound| bound * stretch * 1000.0);
                collision.action = if own_hulls.is_parts { "parts" } else { "hull" };
                collision.pack = Some(shown(&own_hulls.file));
                collision.meshes.clone_from(&meshes);
                collision.vertices = Some(own_hulls.vertices);
                collision.protrusion_mm = millimetres(own_hulls.protrusion);
                collision.uncovered_mm = millimetres(own_hulls.uncovered);
                changes.push(if own.from_visual {
                    Change::FromVisual { link: link_index, visual: index, meshes: Some(meshes) }
                } else {
                    Change::Replace { link: link_index, collision: index, meshes }
                });
            }
        }
        row.collisions.push(collision);
    }
    Ok(changes)
}

/// Inertias of the links whose collisions are all watertight meshes. A warning names each other
/// link that states a mass.
fn inertias(description: &Description, choices: &Choices, hulls: &[Hulls], row: &mut Row) -> Vec<Change> {
    let mut changes = Vec::new();
    for (index, link) in description.links.iter().enumerate() {
        let Some(mass) = link.mass else { continue };
        let own = choices.shapes.iter().filter(|own| own.link == index && !matches!(own.choice, Choice::Removed));
        let body = |own: &choice::ShapeChoice| {
            let shape = choices.shape(own, description);
            let (Choice::Hulls(own), Geometry::Mesh(mesh)) = (&own.choice, &shape.geometry) else { return None };
            Some(inertia::Body { own: hulls[*own].mass?, mesh: mesh.clone(), pose: shape.pose? })
        };
        let bodies: Option<Vec<inertia::Body>> = own.map(body).collect();
        match bodies.and_then(|bodies| inertia::inertia(&bodies, mass)) {
            Some((center, tensor)) => changes.push(Change::Inertia {
                link: index,
                center: center.to_array(),
                inertia: tensor.transpose().to_cols_array_2d(),
            }),
            None => row.warnings.push(format!(
                "{}:{}: link `{}` keeps its inertia, because not all of its collisions are watertight meshes that were baked",
                row.file, link.line, link.name
            )),
        }
    }
    changes
}

/// Files that the description names by relative paths, but for those that this run edits.
fn copies(
    description: &Description,
    target: &Target,
    documents: &[Vec<u8>],
    edited: &BTreeMap<PathBuf, PathBuf>,
) -> Result<Vec<OutputFile>, Failure> {
    if !target.is_elsewhere() {
        return Ok(Vec::new());
    }
    let is_document = |file: &Path| {
        let real = file.canonicalize().ok();
        description.documents.iter().any(|document| document.path().canonicalize().ok() == real)
    };
    let texts: Vec<_> = documents.iter().map(|text| String::from_utf8_lossy(text)).collect();
    // Names of meshes that were replaced do not appear any more. Text that is not UTF-8 is not
    // searched: too many copies do no harm.
    let is_named = |written: &str| {
        let is_searched = written.is_ascii() && texts.iter().all(|text| matches!(text, Cow::Borrowed(_)));
        !is_searched || texts.iter().any(|text| text.contains(written) || text.contains(&escaped(written)))
    };
    let mut outputs: BTreeMap<PathBuf, OutputFile> = BTreeMap::new();
    for reference in &description.references {
        let path = plain(&target.folder.join(&reference.path));
        let is_edited = edited.get(&path).is_some_and(|document| is_same_file(document, &reference.file));
        if is_edited || outputs.contains_key(&path) || is_document(&reference.file) || !is_named(&reference.written) {
            continue;
        }
        let bytes = std::fs::read(&reference.file).map_err(|error| {
            Failure::usage(format!("{}: cannot read: {error}; check the file", reference.file.display()))
        })?;
        outputs.insert(path.clone(), OutputFile { path, bytes });
    }
    Ok(outputs.into_values().collect())
}

/// Where the description is written, and then the files that it includes.
fn document_paths(description: &Description, target: &Target) -> Result<Vec<PathBuf>, Failure> {
    let included = description.documents.iter().skip(1).map(|document| {
        let file = document.path().canonicalize().unwrap_or_else(|_| document.path().to_owned());
        let below = relative(&file, &target.source).ok_or_else(|| {
            Failure::usage(format!("{}: is on another drive; move it to the drive of the model", file.display()))
        })?;
        Ok(plain(&target.folder.join(below)))
    });
    std::iter::once(Ok(target.file.clone())).chain(included).collect()
}

fn would_be_replaced(input: &Path) -> Failure {
    let message = "is an input, and would be replaced; name another file or folder with --out, or pass --force";
    Failure::usage(format!("{}: {message}", input.display()))
}

fn check_inputs(args: &RobotArgs, description: &Description, outputs: &[OutputFile]) -> Result<(), Failure> {
    if args.force {
        return Ok(());
    }
    for document in &description.documents {
        let real = document.path().canonicalize().ok();
        let own = outputs.iter().find(|output| output.path.canonicalize().ok() == real && real.is_some());
        if own.is_some_and(|own| own.bytes != document.bytes()) {
            return Err(would_be_replaced(document.path()));
        }
    }
    Ok(())
}

fn settle(args: &RobotArgs, target: &Target, outputs: &[OutputFile], row: &mut Row) -> Result<Exit, Failure> {
    let states: Vec<State> = outputs.iter().map(OutputFile::state).collect::<Result<_, _>>()?;
    let changed: Vec<&OutputFile> =
        outputs.iter().zip(&states).filter(|(_, state)| **state != State::Same).map(|(own, _)| own).collect();
    let Some(first) = changed.first() else {
        row.status = Status::Fresh;
        return Ok(Exit::Done);
    };
    if args.check {
        row.status = if states.last() == Some(&State::Missing) { Status::Missing } else { Status::Stale };
        row.reason = Some(format!("{} files differ, the first is {}", changed.len(), shown(&first.path)));
        return Ok(Exit::Rejected);
    }
    // The folder of `--out` may be a link; folders in it may not.
    let out = folder_of(&target.file);
    changed.iter().try_for_each(|output| output.write(out))?;
    row.status = Status::Written;
    Ok(Exit::Done)
}
