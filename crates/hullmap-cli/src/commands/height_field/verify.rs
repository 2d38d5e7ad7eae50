//! `bake verify`: checks height fields against their sources.
//!
//! 1. Opening checks the file itself.
//! 2. The source has the recorded hash, and bakes to the same bytes.
//! 3. Random vertical rays meet the surface at heights computed from the samples alone. Every other
//!    ray is exactly above an edge or a sample.

use std::path::Path;

use hullmap::glam::DVec3;
use hullmap::height_field::{Diagonal, Layout};
use hullmap::{CastSettings, HeightField, Ray, Status};
use hullmap_bake::SourceRecord;
use hullmap_bake::height_field::write_height_field;
use hullmap_import::height_field::Heights;
use hullmap_random::SplitMix64;
use serde::Serialize;

use super::bake::{FieldSource, layout};
use super::open::open;
use super::options::FieldOptions;
use super::source;
use crate::args::verify::VerifyArgs;
use crate::outcome::{Exit, Failure};
use crate::pack_file::shown_from;
use crate::terminal::{self, Output};
use hullmap_bake::number::grouped;

/// Difference of heights that rounding explains, relative to the largest height of the field and
/// to its extent: of a few sums in f64, and of the ray's interval.
const ROUNDING: f64 = 1e-12;

/// Result for a height field. Field names are the JSON's.
#[derive(Debug, Serialize)]
struct Verification {
    file: String,
    pass: bool,
    source: Option<String>,
    rays: usize,
    problems: Vec<String>,
}

pub fn run(args: &VerifyArgs, out: &mut Output) -> Result<Exit, Failure> {
    let mut exit = Exit::Done;
    for path in &args.inputs {
        let mut result =
            Verification { file: path.display().to_string(), pass: false, source: None, rays: 0, problems: Vec::new() };
        match verify(path, args, &mut result) {
            Ok(()) => result.pass = result.problems.is_empty(),
            Err(failure) => {
                exit = exit.max(failure.exit);
                result.problems.push(failure.message);
            }
        }
        if !result.pass {
            exit = exit.max(Exit::Rejected);
            result.problems.iter().for_each(terminal::error);
        }
        if args.json {
            out.json(&result)?;
            continue;
        }
        let verdict = if result.pass { "pass" } else { "FAIL" };
        let against = match &result.source {
            Some(source) => format!("{source} bakes to the same bytes; {} rays agree", grouped(result.rays as u64)),
            None => "compared with no source".to_owned(),
        };
        let against = if result.pass { format!(": {against}") } else { String::new() };
        out.line(format_args!("{verdict} {}{against}", result.file))?;
    }
    Ok(exit)
}

fn verify(path: &Path, args: &VerifyArgs, result: &mut Verification) -> Result<(), Failure> {
    let field = open(path)?;
    let file = path.display();
    let Some(options) = FieldOptions::from_recorded(field.options()) else {
        if field.source_path().is_empty() && args.source.is_none() && !args.require_source {
            terminal::note(format_args!("{file}: no source is recorded; only the file itself was checked"));
            return Ok(());
        }
        let options = field.options();
        let text = format!("{file}: unknown options `{options}`; bake the source again with this version");
        return Err(Failure::rejected(text));
    };
    let source = match source::find(path, &field, args.source.as_deref(), options.hole_image.as_deref())? {
        Ok(source) => source,
        Err(why) if args.require_source => {
            return Err(Failure::rejected(format!("{file}: {why}; name the source with --source")));
        }
        Err(why) => {
            terminal::note(format_args!(
                "{file}: {why}; only the file itself was checked (name the source with --source)"
            ));
            return Ok(());
        }
    };
    let shown = if source.is_absolute() { shown_from(&source, Path::new(".")) } else { source.clone() };
    let shown = shown.display().to_string();
    let files = FieldSource::read(&source, &options, &args.limits.limits())?;
    if files.hash() != field.header().source_hash {
        let text = format!("{file}: stale: {shown} has changed since it was baked, or is another file; bake it again");
        return Err(Failure::rejected(text));
    }
    result.source = Some(shown.clone());
    let (path, options_text) = (field.source_path().to_owned(), field.options().to_owned());
    let record = SourceRecord { path, hash: files.hash(), options: options_text, warnings: Vec::new() };
    let (heights, holes) = files.import(&options)?;
    let bytes = write_height_field(files.bake(&heights, &holes, &options)?, &record)
        .map_err(|error| Failure::rejected(format!("{shown}: {error}")))?;
    if bytes != field.bytes() {
        result.problems.push(format!("{file}: differs from what {shown} bakes to; bake it again"));
    }
    let layout = layout(&shown, &heights, &options)?;
    let mut random = SplitMix64::new(args.seed);
    result.rays = args.directions;
    for index in 0..args.directions {
        let place = [random.unit(), random.unit()];
        if let Some(problem) = compare(&field, &layout, &heights, &holes, place, index % 2 == 0) {
            result.problems.push(format!("{file}: {problem}; please report this file"));
            break;
        }
    }
    Ok(())
}

/// Compares a vertical ray with the samples around it, at a place between 0 and 1 along x and y, or
/// on the nearest edge or sample below it. Returns what is wrong.
fn compare(
    field: &HeightField,
    layout: &Layout,
    heights: &Heights,
    holes: &[bool],
    place: [f64; 2],
    is_on_edge: bool,
) -> Option<String> {
    let [across, along] = layout.cells();
    let [(column, u), (row, v)] = [(place[0], across), (place[1], along)].map(|(share, cells)| {
        let at = share * cells as f64;
        let cell = (at as usize).min(cells - 1);
        (cell, at - cell as f64)
    });
    let (u, v) = if is_on_edge { (0.0, if v < 0.5 { 0.0 } else { v }) } else { (u, v) };
    // Places near edges of triangles belong to two of them.
    let near_diagonal = match layout.diagonal {
        Diagonal::Rising => u - v,
        Diagonal::Falling => u + v - 1.0,
    };
    let is_near_edge = [u, v, 1.0 - u, 1.0 - v, near_diagonal.abs()].iter().any(|distance| *distance < 1e-6);
    if is_near_edge && !is_on_edge {
        return None;
    }
    let sample = |dx: usize, dy: usize| f64::from(heights.heights[layout.vertex(column + dx, row + dy)]);
    let [z00, z10, z01, z11] = [sample(0, 0), sample(1, 0), sample(0, 1), sample(1, 1)];
    let expected = match (layout.diagonal, near_diagonal > 0.0) {
        (Diagonal::Rising, true) => z00 + u * (z10 - z00) + v * (z11 - z10),
        (Diagonal::Rising, false) => z00 + v * (z01 - z00) + u * (z11 - z01),
        (Diagonal::Falling, false) => z00 + u * (z10 - z00) + v * (z01 - z00),
        (Diagonal::Falling, true) => z11 + (1.0 - u) * (z01 - z11) + (1.0 - v) * (z10 - z11),
    };
    let is_hole = [z00, z10, z01, z11].iter().any(|z| z.is_nan())
        || holes.get(layout.cell(column, row)).copied().unwrap_or_default();
    if is_hole && is_on_edge {
        // The cells beyond the edge decide.
        return None;
    }
    let between = |at: f64, low: f64, high: f64| low + at * (high - low);
    let x = between(u, layout.x(column), layout.x(column + 1));
    let y = between(v, layout.y(row), layout.y(row + 1));
    let [low, high] = field.bounds();
    let top = high.z + (high.z - low.z).max(layout.spacing[0]);
    let ray = Ray::new(DVec3::new(x, y, top), DVec3::NEG_Z).ok()?;
    let found = hullmap::ray(field, &ray, &CastSettings::default());
    if found.hit == is_hole {
        let what = if is_hole { "the samples have a hole" } else { "the samples have ground" };
        return Some(format!("a ray at x {x}, y {y} {} where {what}", if found.hit { "hits" } else { "misses" }));
    }
    let slack = ROUNDING * (low.abs().max(high.abs()).max_element() + (high - low).length())
        + 1e-9 * (z00 - z11).abs().max((z10 - z01).abs());
    let (below, above) = (top - found.t_upper, top - found.t_lower);
    if found.status == Status::Touching {
        return Some(format!("a ray at x {x}, y {y} has no certain answer"));
    }
    let agrees = is_hole || below - slack <= expected && expected <= above + slack;
    (!agrees).then(|| format!("a ray at x {x}, y {y} hits at z {} where the samples have {expected}", top - found.t))
}
