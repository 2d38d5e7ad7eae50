//! `bake verify`: checks baked files against their sources.

mod surfaces;

use std::path::Path;

use hullmap::{Asset, Pack};
use hullmap_geometry::number::{percent, short};

use crate::args::verify::VerifyArgs;
use crate::rows::Notes;
use crate::table::{Table, or_dash};
use crate::terminal::{self, Output};
use hullmap_geometry::number::grouped;
use hullmap_pipeline::budget::{Figures, budget};
use hullmap_pipeline::content::{Verified, verify};
use hullmap_pipeline::open::open_asset;
use hullmap_pipeline::outcome::{Exit, Failure, end};
use hullmap_pipeline::packs::{PackPlace, find_packs};
use hullmap_pipeline::source::{Folders, Recorded, Source, SourceSearch, find_source, given_sources};
use hullmap_verify::geometry::{polygons, positions};
use hullmap_verify::pack::{BOUNDS_UNCHECKED, HullVerification, UNMEASURED, WITH_WARNINGS, WITHIN_BOUNDS};

/// Maximum number of warnings that are printed about one pack. JSON has all of them.
const MAX_WARNINGS: usize = 8;

pub fn run(args: &VerifyArgs, out: &mut Output) -> Result<Exit, Failure> {
    if let Some(budget) = args.engine.as_deref().and_then(budget).filter(|_| args.verbose || args.json) {
        terminal::note(format_args!("the limits of {} are from {}", budget.name, budget.source));
    }
    let mut exit = Exit::Done;
    let (mut results, mut surfaces) = (Vec::new(), Vec::new());
    let places = find_packs(&args.inputs)?;
    let sources = given_sources(args.source.as_deref(), &places)?;
    let folders = Folders::default();
    let mut remarks: Vec<(String, Vec<String>)> = Vec::new();
    for (place, given) in places.iter().zip(sources) {
        match verify_file(place, given, args, &folders, &mut remarks) {
            Ok(verified) => {
                exit = exit.max(if verified.verdict().is_some() { Exit::Rejected } else { Exit::Done });
                match verified {
                    Verified::Hulls(mut hulls) => results.append(&mut hulls),
                    Verified::Surface(surface) => surfaces.push(*surface),
                }
            }
            Err(failure) => {
                exit = exit.max(failure.exit);
                let file = place.path.display().to_string();
                results.push(HullVerification { file, problems: vec![failure.message], ..HullVerification::default() });
            }
        }
        if args.json {
            for result in results.drain(..) {
                out.json(&result)?;
            }
            for surface in surfaces.drain(..) {
                out.json(&surface)?;
            }
            out.flush()?;
        }
    }
    let mut notes = Notes::new(remarks.iter().map(|(file, notes)| (&**file, &**notes)), args.verbose);
    remarks.iter().for_each(|(file, own)| notes.print(file, own));
    if args.json {
        return Ok(exit);
    }
    let has_hulls = !results.is_empty() || surfaces.is_empty();
    let mut written = if has_hulls { write_text(&results, args.verbose, out) } else { Ok(()) };
    if !surfaces.is_empty() && written.is_ok() {
        let gap = if has_hulls { out.line("").map_err(Failure::from) } else { Ok(()) };
        written = gap.and_then(|()| surfaces::write_text(&surfaces, out));
    }
    end(exit, written)
}

fn verify_file(
    place: &PackPlace,
    given: Option<&Path>,
    args: &VerifyArgs,
    folders: &Folders,
    remarks: &mut Vec<(String, Vec<String>)>,
) -> Result<Verified, Failure> {
    let asset = open_asset(&place.path)?;
    let file = place.path.display().to_string();
    let source = source_of(place, &asset, given, args, folders, remarks)?;
    let shown = source.as_ref().map(|source| source.path.display().to_string());
    let content = source.as_ref().map(|source| &source.content);
    let mut verified = verify(&asset, content, args.directions, args.seed)
        .map_err(|error| Failure::rejected(format!("{file}: {error}")))?;
    match &mut verified {
        Verified::Hulls(results) => {
            for result in results.iter_mut() {
                result.file.clone_from(&file);
                result.source.clone_from(&shown);
            }
            if let (Some(name), Asset::Pack(pack)) = (&args.engine, &asset) {
                judge_budget(name, pack, results);
            }
        }
        Verified::Surface(surface) => (surface.file, surface.source) = (file, shown),
    }
    Ok(verified)
}

/// Source of a file. Without one, adds a note, or fails if `--require-source` is given.
fn source_of(
    place: &PackPlace,
    asset: &Asset,
    given: Option<&Path>,
    args: &VerifyArgs,
    folders: &Folders,
    remarks: &mut Vec<(String, Vec<String>)>,
) -> Result<Option<Source>, Failure> {
    let file = place.path.display();
    match find_source(place, Recorded::from_asset(asset), given, &args.limits.limits(), folders)? {
        SourceSearch::Found(source) => Ok(Some(*source)),
        SourceSearch::Absent(why) if args.require_source => {
            let recorded = asset.source_path();
            let why =
                why.unwrap_or_else(|| format!("no source found beside the pack or at the recorded path `{recorded}`"));
            Err(Failure::rejected(format!("{file}: {why}; name the source with --source")))
        }
        SourceSearch::Absent(why) => {
            let why = why.as_deref().unwrap_or("no source found");
            let stored = match asset {
                Asset::Pack(_) => "the stored hull",
                Asset::TriangleMesh(_) => "the stored triangles",
                Asset::HeightField(_) => "the stored heights",
            };
            let note = format!("{why}; compared with {stored} only; name the source with --source");
            remarks.push((file.to_string(), vec![note]));
            Ok(None)
        }
    }
}

fn judge_budget(name: &str, pack: &Pack, results: &mut [HullVerification]) {
    let Some(budget) = budget(name) else {
        return;
    };
    for (hull, result) in pack.hulls().zip(results) {
        let figures = Figures::new(&positions(&hull), &polygons(&hull), hull.centroid());
        let exceeded = match (hull.rank() < 3, budget.takes_flat) {
            (false, _) => budget.exceeded(&figures),
            (true, true) => budget.exceeded(&Figures { thickness: f64::INFINITY, ..figures }),
            (true, false) => vec![format!("not within the budget of {name}: it is flat, and the engine takes solids")],
        };
        result.pass &= exceeded.is_empty();
        result.problems.extend(exceeded.iter().cloned());
        result.budget = exceeded;
    }
}

fn print_warnings(hulls: &[HullVerification]) {
    let mut texts: Vec<&str> = Vec::new();
    for text in hulls.iter().flat_map(|hull| &hull.warnings) {
        if !texts.contains(&text.as_str()) {
            texts.push(text);
        }
        if texts.len() > MAX_WARNINGS {
            break;
        }
    }
    let file = &hulls[0].file;
    for text in texts.iter().take(MAX_WARNINGS) {
        terminal::warning(format_args!("{file}: {text}"));
    }
    if texts.len() > MAX_WARNINGS {
        terminal::warning(format_args!("{file}: and more like these; --json has all of them"));
    }
}

fn write_text(results: &[HullVerification], lists_hulls: bool, out: &mut Output) -> Result<(), Failure> {
    for result in results.iter().filter(|result| !result.pass) {
        terminal::error(if result.hull.is_some() {
            format!("{}: {}", result.file, result.verdict())
        } else {
            result.problems.join("; ")
        });
    }
    results.chunk_by(|result, next| result.file == next.file).for_each(print_warnings);
    let table = if lists_hulls { hull_table(results) } else { pack_table(results) };
    table.write(out)?;
    out.line("")?;
    Ok(out.line(summary(results))?)
}

fn count(value: Option<usize>) -> String {
    or_dash(value, |value| grouped(value as u64))
}

fn index_word(hulls: &[HullVerification]) -> &'static str {
    if hulls.iter().any(|hull| hull.proven.is_none()) {
        "-"
    } else if hulls.iter().all(|hull| hull.proven == Some(true)) {
        "proven"
    } else {
        "NOT PROVEN"
    }
}

fn pack_table(results: &[HullVerification]) -> Table {
    let has_simplified = results.iter().any(HullVerification::is_simplified);
    let outer = if has_simplified { " | outer error:" } else { "" };
    let mut table = Table::headed(&format!(
        "file: | hulls | vertices | index: | max_regret | mismatches | nodes | dots | against: | result:{outer}"
    ));
    for hulls in results.chunk_by(|result, next| result.file == next.file) {
        let first = &hulls[0];
        let hull_count = hulls.iter().filter(|result| result.hull.is_some()).count();
        let sum = |of: &dyn Fn(&HullVerification) -> Option<usize>| hulls.iter().map(of).sum::<Option<usize>>();
        let max = |of: &dyn Fn(&HullVerification) -> Option<u32>| hulls.iter().filter_map(of).max();
        let regret = hulls.iter().filter_map(|result| result.max_regret).max_by(f64::total_cmp);
        // The most cautious of the words, failures first.
        let order = [
            "FAILED",
            UNMEASURED,
            BOUNDS_UNCHECKED,
            WITH_WARNINGS,
            "index exact",
            WITHIN_BOUNDS,
            "contains its source",
            "exact",
        ];
        let words = hulls.iter().map(HullVerification::result);
        let result = words.min_by_key(|word| order.iter().position(|known| known == word)).unwrap_or("-");
        let mut cells = vec![
            first.file.clone(),
            count((hull_count > 0).then_some(hull_count)),
            count(sum(&|result| result.vertices)),
            index_word(hulls).to_owned(),
            or_dash(regret, short),
            count(sum(&|result| result.mismatches)),
            count(max(&|result| result.max_nodes).map(|nodes| nodes as usize)),
            count(max(&|result| result.max_dots).map(|dots| dots as usize)),
            first.against.unwrap_or("-").to_owned(),
            result.to_owned(),
        ];
        if has_simplified {
            let error = |result: &&HullVerification| result.outer_error.unwrap_or(0.0);
            let widest = hulls.iter().max_by(|a, b| error(a).total_cmp(&error(b)));
            cells.push(or_dash(widest, outer_error));
        }
        table.push(cells);
    }
    table
}

fn hull_table(results: &[HullVerification]) -> Table {
    let has_simplified = results.iter().any(HullVerification::is_simplified);
    let outer = if has_simplified { " | outer error:" } else { "" };
    let mut table = Table::headed(&format!(
        "file: | hull: | vertices | rank | index: | max_regret | mismatches | nodes | dots | index B/vertex | against: | \
         result:{outer}"
    ));
    let small_count = |value: Option<u32>| count(value.map(|value| value as usize));
    for result in results {
        let mut cells = vec![
            result.file.clone(),
            or_dash(result.hull.clone(), |hull| hull),
            count(result.vertices),
            small_count(result.rank),
            index_word(std::slice::from_ref(result)).to_owned(),
            or_dash(result.max_regret, short),
            count(result.mismatches),
            small_count(result.max_nodes),
            small_count(result.max_dots),
            or_dash(result.index_bytes_per_vertex, |bytes| format!("{bytes:.1}")),
            result.against.unwrap_or("-").to_owned(),
            result.result().to_owned(),
        ];
        if has_simplified {
            cells.push(outer_error(result));
        }
        table.push(cells);
    }
    table
}

fn outer_error(result: &HullVerification) -> String {
    match (result.outer_error, result.diameter) {
        (Some(error), Some(diameter)) if error > 0.0 => {
            format!("{} ({} of the diameter)", short(error), percent(error / diameter))
        }
        _ => "-".to_owned(),
    }
}

/// `3 exact, 1 simplified, 0 failed`, and what was shown for simplified hulls and without a source.
fn summary(results: &[HullVerification]) -> String {
    let passed: Vec<&HullVerification> = results.iter().filter(|result| result.pass).collect();
    let parts = passed.iter().filter(|result| result.result() == WITHIN_BOUNDS).count();
    let doubtful = passed.iter().filter(|result| result.result() == WITH_WARNINGS).count();
    let unknown = passed.iter().filter(|result| [UNMEASURED, BOUNDS_UNCHECKED].contains(&result.result())).count();
    let is_simplified = |result: &&&HullVerification| {
        result.is_simplified() && !result.is_loose_part() && result.result() != WITH_WARNINGS
    };
    let simplified = passed.iter().filter(is_simplified).count();
    let held = passed.iter().filter(is_simplified).filter(|result| result.is_against_source()).count();
    let unsourced = passed.iter().filter(|result| !result.is_against_source()).count();
    let mut text = format!("{} exact", passed.len() - simplified - parts - unknown - doubtful);
    if parts > 0 {
        let noun = if parts == 1 { "part within its bounds" } else { "parts within their bounds" };
        text += &format!(", {parts} {noun}");
    }
    if doubtful > 0 {
        text += &format!(", {doubtful} passed with warnings");
    }
    if unknown > 0 {
        text += &format!(", {unknown} with unknown or unchecked bounds");
    }
    if simplified > 0 {
        text += &format!(", {simplified} simplified");
    }
    text += &format!(", {} failed", results.len() - passed.len());
    if held > 0 {
        text += "; each simplified hull contains its source and extends beyond it by at most its outer error";
    }
    if unsourced > 0 {
        text += &format!(
            "; {unsourced} compared with the stored hull only, because no source was found (name it with --source)"
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_exact_only_if_its_bounds_are_0() {
        let tight = HullVerification {
            pass: true,
            against: Some("source"),
            outer_error: Some(0.0),
            diameter: Some(2.0),
            is_part: true,
            uncovered: Some(1e-8),
            protrusion: Some(1e-8),
            solid: Some("watertight"),
            ..HullVerification::default()
        };
        let loose = HullVerification { protrusion: Some(0.1), ..tight.clone() };
        let open = HullVerification { uncovered: Some(f64::NAN), ..tight.clone() };
        let unmeasured = HullVerification { solid: None, uncovered: None, protrusion: None, ..tight.clone() };
        let unsourced = HullVerification { against: Some("stored hull"), ..loose.clone() };
        let words = [&tight, &loose, &open, &unmeasured, &unsourced].map(HullVerification::result);
        assert_eq!(words, ["exact", WITHIN_BOUNDS, WITHIN_BOUNDS, UNMEASURED, BOUNDS_UNCHECKED]);
        assert_eq!(summary(&[tight, loose.clone(), open]), "1 exact, 2 parts within their bounds, 0 failed");
        assert_eq!(summary(std::slice::from_ref(&loose)), "0 exact, 1 part within its bounds, 0 failed");
        let warnings = vec!["thin".to_owned()];
        let thin = HullVerification { warnings, ..loose.clone() };
        assert_eq!(thin.result(), WITH_WARNINGS);
        assert_eq!(summary(&[loose, thin]), "0 exact, 1 part within its bounds, 1 passed with warnings, 0 failed");
    }

    #[test]
    fn a_pack_is_shown_by_its_worst_hull() {
        let hull = |file: &str, regret: f64, pass: bool| HullVerification {
            file: file.to_owned(),
            hull: Some("h".to_owned()),
            vertices: Some(1000),
            proven: Some(true),
            directions: Some(10_000),
            max_regret: Some(regret),
            mismatches: Some(usize::from(!pass)),
            max_nodes: Some(2),
            max_dots: Some((1e9 * regret) as u32),
            pass,
            against: Some("source"),
            ..HullVerification::default()
        };
        let unread = HullVerification { file: "c".to_owned(), ..HullVerification::default() };
        let results = [
            hull("a", 1e-9, true),
            hull("a", 8e-9, true),
            hull("b", 0.5, false),
            hull("b", 0.0, true),
            unread,
            hull("d", 0.0, true),
        ];
        let mut bytes = Vec::new();
        pack_table(&results).write(&mut Output::new(&mut bytes)).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let rows: Vec<Vec<&str>> = text
            .lines()
            .skip(1)
            .map(|line| line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect())
            .collect();
        assert_eq!(rows[0], ["a", "2", "2 000", "proven", "8e-9", "0", "2", "8", "source", "exact"]);
        assert_eq!((rows[1][0], rows[1][5], rows[1][9]), ("b", "1", "FAILED"));
        assert_eq!(rows[2], ["c", "-", "-", "-", "-", "-", "-", "-", "-", "FAILED"]);
        assert_eq!(rows[3][..6], ["d", "1", "1 000", "proven", "0", "0"]);
        assert_eq!(rows.len(), 4);
    }
}
