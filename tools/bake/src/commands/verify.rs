//! `bake verify`: packs against the meshes they were baked from.

use std::collections::HashSet;
use std::io::Write;
use std::path::Path;

use glam::Vec3;
use hullmap::{Hull, Pack};
use hullmap_bake::{NO_SOURCE_VERTEX, PointSet};
use serde::Serialize;

use crate::args::VerifyArgs;
use crate::baker::parts;
use crate::messages;
use crate::open::open_pack;
use crate::options::BuildOptions;
use crate::outcome::{Exit, Failure, end};
use crate::packs::{PackPlace, find_packs};
use crate::source::{Recorded, find_source};
use crate::table::{Align, Table, grouped};
use crate::verification::directions::directions;
use crate::verification::outside::{measure_outside, uncovered};
use crate::verification::truth::Points;
use crate::verification::{Measurement, REGRET_LIMIT, measure};

/// What a pack is compared with.
#[derive(Debug)]
pub enum Truth<'a> {
    /// The source's points.
    Source(&'a [PointSet]),
    /// The stored hull's own vertices: shows that the index is exact, not that the hull is the source's.
    Stored,
}

/// What is said of a hull. The names are those of the JSON; `None` where a pack or its source could not be used.
#[derive(Clone, Debug, Default, Serialize)]
pub struct HullReport {
    /// The pack.
    pub file: String,
    /// Name of the hull.
    pub hull: Option<String>,
    /// Vertices of the hull.
    pub vertices: Option<usize>,
    /// 3 solid, 2 polygon, 1 segment, 0 point.
    pub rank: Option<u32>,
    /// Directions tried.
    pub directions: Option<usize>,
    /// Greatest regret; infinity, which JSON lacks, reads as null.
    pub max_regret: Option<f64>,
    /// Directions with too great a regret.
    pub mismatches: Option<usize>,
    /// Stored worst case: nodes that a query reads.
    pub max_nodes: Option<u32>,
    /// Stored worst case: dot products of a query.
    pub max_dots: Option<u32>,
    /// Bytes of the index by vertex.
    pub index_bytes_per_vertex: Option<f64>,
    /// Whether all is well.
    pub pass: bool,
    /// `source` or `stored hull`: what it was compared with.
    pub against: Option<&'static str>,
    /// The source file, where there is one.
    pub source: Option<String>,
    /// What is wrong, beside mismatches.
    pub problems: Vec<String>,
    /// Direction of the greatest regret.
    pub worst_direction: Option<[f32; 3]>,
    /// How far the hull may reach beyond the source's, as it says; 0 for an exact one.
    pub outer_error: Option<f64>,
    /// How far a vertex of the source object may lie outside of all of its parts, as they say.
    pub uncovered: Option<f64>,
    /// Greatest distance between two of its vertices.
    #[serde(skip)]
    pub diameter: Option<f64>,
}

impl HullReport {
    /// The outcome in a sentence.
    pub fn verdict(&self) -> String {
        let hull = self.hull.as_deref().unwrap_or("-");
        let mut parts = self.problems.clone();
        if let (Some(wrong), Some(tried), Some(regret)) = (self.mismatches, self.directions, self.max_regret)
            && wrong > 0
        {
            parts.push(format!("{wrong} of {tried} directions are wrong, max_regret {regret:.2e}"));
        }
        let text = if parts.is_empty() { self.result().to_owned() } else { parts.join("; ") };
        format!("hull {hull}: {text}")
    }

    /// Whether the hull is an outer one, of fewer vertices than its source's.
    fn is_simplified(&self) -> bool {
        self.outer_error.is_some_and(|error| error > 0.0)
    }

    fn is_of_source(&self) -> bool {
        self.against == Some("source")
    }

    /// The outcome in a few words: what was shown, and no more.
    fn result(&self) -> &'static str {
        match (self.pass, self.is_simplified(), self.is_of_source()) {
            (false, _, _) => "FAILED",
            (true, true, true) => "holds its source",
            (true, true, false) => "index exact",
            (true, false, _) => "exact",
        }
    }
}

/// Runs the command.
///
/// # Errors
/// An input that cannot be read or a folder without packs. What is wrong with one pack is told in its rows.
pub fn run(args: &VerifyArgs, out: &mut dyn Write) -> Result<Exit, Failure> {
    let mut exit = Exit::Done;
    let mut reports = Vec::new();
    let places = find_packs(&args.inputs)?;
    let sources = asked_sources(args.source.as_deref(), &places)?;
    for (place, asked) in places.iter().zip(sources) {
        match verify_pack(place, asked, args) {
            Ok(mut hulls) => {
                if hulls.iter().any(|report| !report.pass) {
                    exit = exit.max(Exit::Wanting);
                }
                reports.append(&mut hulls);
            }
            Err(failure) => {
                exit = exit.max(failure.exit);
                let file = place.path.display().to_string();
                reports.push(HullReport { file, problems: vec![failure.message], ..HullReport::default() });
            }
        }
        if args.json {
            for report in reports.drain(..) {
                serde_json::to_writer(&mut *out, &report).map_err(std::io::Error::from)?;
                writeln!(out)?;
            }
            out.flush()?;
        }
    }
    if args.json { Ok(exit) } else { end(exit, write_table(&reports, out)) }
}

/// What `--source` says for each pack. One mesh is the source of the packs that are called like it; if there are any, the
/// others are left to the usual search.
///
/// # Errors
/// `--source` names a mesh, there are several packs, and none is called like it.
pub fn asked_sources<'a>(asked: Option<&'a Path>, places: &[PackPlace]) -> Result<Vec<Option<&'a Path>>, Failure> {
    let Some(mesh) = asked.filter(|path| !path.is_dir() && places.len() > 1) else {
        return Ok(vec![asked; places.len()]);
    };
    let is_meant = |place: &PackPlace| {
        // A pack that does not open is told of later.
        let pack = open_pack(&place.path).ok();
        let recorded = pack.as_ref().and_then(|pack| pack.source_path().rsplit('/').next());
        place.path.file_stem() == mesh.file_stem()
            || recorded.is_some_and(|name| mesh.file_name().is_some_and(|file| file == name))
    };
    let sources: Vec<Option<&Path>> = places.iter().map(|place| asked.filter(|_| is_meant(place))).collect();
    if sources.iter().all(Option::is_none) {
        return Err(Failure::usage(format!(
            "--source {}: none of the {} packs is called like it; name its pack, or a folder of meshes",
            mesh.display(),
            places.len()
        )));
    }
    Ok(sources)
}

fn verify_pack(place: &PackPlace, asked: Option<&Path>, args: &VerifyArgs) -> Result<Vec<HullReport>, Failure> {
    let pack = open_pack(&place.path)?;
    let source = find_source(place, Recorded::of(&pack), asked)?;
    let file = place.path.display().to_string();
    let truth = match &source {
        Some(source) => Truth::Source(&source.point_sets),
        None if args.require_source => {
            let recorded = pack.source_path();
            return Err(Failure::wanting(format!(
                "{file}: no source found, neither beside it nor at the recorded `{recorded}`; name it by --source"
            )));
        }
        None => {
            messages::note(format_args!(
                "{file}: no source found; compared with the stored hull only (--source names one)"
            ));
            Truth::Stored
        }
    };
    let mut reports = verify_hulls(&pack, &truth, args.directions, args.seed)
        .map_err(|error| Failure::wanting(format!("{file}: {error}")))?;
    for report in &mut reports {
        report.file.clone_from(&file);
        report.source = source.as_ref().map(|source| source.path.display().to_string());
    }
    Ok(reports)
}

/// Verifies every hull of a pack; the names of files in the reports are left out.
///
/// # Errors
/// The source has other hulls than the pack, or what the pack holds twice does not agree.
pub fn verify_hulls(pack: &Pack, truth: &Truth, count: usize, seed: u64) -> Result<Vec<HullReport>, String> {
    pack.check_repeats().map_err(|error| error.to_string())?;
    let Truth::Source(sets) = truth else {
        return Ok(pack.hulls().map(|hull| verify_hull(&hull, None, count, seed)).collect());
    };
    let options = BuildOptions::from_recorded(pack.options());
    let parts = parts(sets, options.as_ref().and_then(|options| options.decompose.as_ref()))?;
    if parts.len() != pack.hull_count() {
        return Err(format!("{} hulls where the source has {}; bake it again", pack.hull_count(), parts.len()));
    }
    let hulls = pack.hulls().zip(&parts);
    let mut reports: Vec<HullReport> =
        hulls.map(|(hull, part)| verify_hull(&hull, Some(&part.points), count, seed)).collect();
    for (set, points) in sets.iter().enumerate() {
        let own: Vec<usize> = (0..parts.len()).filter(|number| parts[*number].set == set).collect();
        verify_parts(pack, &own, points, &mut reports);
    }
    Ok(reports)
}

/// Whether the parts of a set leave out no more of its points than they say.
fn verify_parts(pack: &Pack, numbers: &[usize], points: &PointSet, reports: &mut [HullReport]) {
    let hulls: Vec<Hull> = numbers.iter().filter_map(|number| pack.hull(*number).ok()).collect();
    let said = hulls.iter().map(Hull::uncovered).fold(0.0, f64::max);
    let found = if hulls.len() > 1 { uncovered(points, &hulls) } else { 0.0 };
    let size = hulls.iter().map(Hull::diameter).fold(0.0, f64::max);
    for (place, number) in numbers.iter().enumerate() {
        let report = &mut reports[*number];
        if hulls[place].part() as usize != place {
            report.problems.push(format!("it is part {place} of {}, not {}", points.name, hulls[place].part()));
        }
        // NaN fails.
        if !(found <= said + REGRET_LIMIT * size) {
            report.problems.push(format!(
                "a vertex of {} lies {found:.3e} outside of all parts, where {said:.3e} is said",
                points.name
            ));
        }
        report.pass = report.pass && report.problems.is_empty();
    }
}

fn verify_hull(hull: &Hull, source: Option<&PointSet>, count: usize, seed: u64) -> HullReport {
    let vertices: Vec<Vec3> = hull.vertices().collect();
    let faces: Vec<Vec<u32>> = hull.faces().map(Iterator::collect).collect();
    let own = || Points::new(&vertices.iter().map(|vertex| vertex.to_array()).collect::<Vec<_>>());
    let directions = directions(&vertices, &faces, count, seed);
    let is_simplified = hull.outer_error() > 0.0;
    let mut problems = Vec::new();
    let points = match source {
        Some(set) => {
            if set.name != hull.name() {
                problems.push(format!("the source calls this hull {}", set.name));
            }
            if set.origin != hull.origin().to_array() {
                problems.push(format!("its origin is {}, where the source's is {:?}", hull.origin(), set.origin));
            }
            let numbers = (0..vertices.len() as u32).map(|index| hull.source_vertex(index));
            let strangers = count_strangers(&vertices, numbers, set, is_simplified);
            if strangers > 0 {
                problems.push(format!("{strangers} vertices are not the source vertices they are recorded as"));
            }
            let truth = Points::new(&set.positions);
            if is_simplified {
                let found = measure_outside(&vertices, &truth, &directions);
                problems.extend(found.problem(hull.outer_error()));
                // The index is exact for the hull that is stored.
                own()
            } else {
                truth
            }
        }
        None => own(),
    };
    let Measurement { max_regret, worst_direction, mismatches, invalid_answers, cost } =
        measure(hull, &points, &directions);
    if invalid_answers > 0 {
        problems.push(format!("{invalid_answers} special directions have an answer that is no vertex"));
    }
    let worst = hull.worst_cost();
    if cost.nodes > worst.nodes || cost.dots > worst.dots {
        problems.push(format!(
            "a query took {} nodes and {} dot products, more than the worst case stored",
            cost.nodes, cost.dots
        ));
    }
    HullReport {
        file: String::new(),
        hull: Some(hull.name().to_owned()),
        vertices: Some(vertices.len()),
        rank: Some(hull.rank()),
        directions: Some(count),
        max_regret: Some(max_regret),
        mismatches: Some(mismatches),
        max_nodes: Some(worst.nodes),
        max_dots: Some(worst.dots),
        index_bytes_per_vertex: Some(hull.index_byte_len() as f64 / vertices.len() as f64),
        pass: mismatches == 0 && problems.is_empty(),
        against: Some(if source.is_some() { "source" } else { "stored hull" }),
        source: None,
        problems,
        worst_direction: worst_direction.map(|dir| dir.to_array()),
        outer_error: Some(hull.outer_error()),
        uncovered: Some(hull.uncovered()),
        diameter: Some(hull.diameter()),
    }
}

/// Hull vertices that are not, bit by bit, the source vertex that they are recorded as. The two zeros are equal.
///
/// A vertex that is none of the source's must be one of the part's other points; the vertices of a simplified hull are nobody's.
fn count_strangers(
    vertices: &[Vec3],
    numbers: impl Iterator<Item = Option<u32>>,
    set: &PointSet,
    is_simplified: bool,
) -> usize {
    let bits = |position: [f32; 3]| position.map(|x| (x + 0.0).to_bits());
    // Source vertices ascend, those that are none come last.
    let known = set.source_vertices.partition_point(|number| *number != NO_SOURCE_VERTEX);
    let others: HashSet<[u32; 3]> = set.positions[known..].iter().map(|position| bits(*position)).collect();
    let is_known = |(vertex, number): &(&Vec3, Option<u32>)| {
        let vertex = bits(vertex.to_array());
        match number {
            _ if is_simplified => number.is_none(),
            None => others.contains(&vertex),
            Some(number) => {
                let place = set.source_vertices[..known].binary_search(number);
                place.is_ok_and(|place| bits(set.positions[place]) == vertex)
            }
        }
    };
    vertices.iter().zip(numbers).filter(|pair| !is_known(pair)).count()
}

fn write_table(reports: &[HullReport], out: &mut dyn Write) -> Result<(), Failure> {
    let has_simplified = reports.iter().any(HullReport::is_simplified);
    let mut columns = vec![
        ("file", Align::Left),
        ("hull", Align::Left),
        ("vertices", Align::Right),
        ("rank", Align::Right),
        ("directions", Align::Right),
        ("max_regret", Align::Right),
        ("mismatches", Align::Right),
        ("nodes", Align::Right),
        ("dots", Align::Right),
        ("index B/vertex", Align::Right),
        ("against", Align::Left),
        ("result", Align::Left),
    ];
    if has_simplified {
        columns.push(("outer error", Align::Left));
    }
    let mut table = Table::new(&columns);
    let number = |value: Option<usize>| value.map_or_else(|| "-".to_owned(), |value| grouped(value as u64));
    let word = |value: Option<u32>| number(value.map(|value| value as usize));
    for report in reports {
        let mut cells = vec![
            report.file.clone(),
            report.hull.clone().unwrap_or_else(|| "-".to_owned()),
            number(report.vertices),
            word(report.rank),
            number(report.directions),
            report.max_regret.map_or_else(|| "-".to_owned(), |regret| format!("{regret:.1e}")),
            number(report.mismatches),
            word(report.max_nodes),
            word(report.max_dots),
            report.index_bytes_per_vertex.map_or_else(|| "-".to_owned(), |bytes| format!("{bytes:.1}")),
            report.against.unwrap_or("-").to_owned(),
            report.result().to_owned(),
        ];
        if has_simplified {
            cells.push(outer_error(report));
        }
        table.push(cells);
        if !report.pass {
            let message = if report.hull.is_some() {
                format!("{}: {}", report.file, report.verdict())
            } else {
                report.problems.join("; ")
            };
            messages::error(message);
        }
    }
    table.write(out)?;
    writeln!(out, "\n{}", summary(reports))?;
    Ok(())
}

/// What an outer hull promises, which was found to hold.
fn outer_error(report: &HullReport) -> String {
    match (report.outer_error, report.diameter) {
        (Some(error), Some(diameter)) if error > 0.0 => {
            format!("{error:.3e} ({:.1e} of the diameter)", error / diameter)
        }
        _ => "-".to_owned(),
    }
}

/// `3 exact, 1 simplified, 0 failed`, and what simplified hulls and those without a source were found to be.
fn summary(reports: &[HullReport]) -> String {
    let passed: Vec<&HullReport> = reports.iter().filter(|report| report.pass).collect();
    let simplified = passed.iter().filter(|report| report.is_simplified()).count();
    let held = passed.iter().filter(|report| report.is_simplified() && report.is_of_source()).count();
    let unsourced = passed.iter().filter(|report| !report.is_of_source()).count();
    let mut text = format!("{} exact", passed.len() - simplified);
    if simplified > 0 {
        text += &format!(", {simplified} simplified");
    }
    text += &format!(", {} failed", reports.len() - passed.len());
    if held > 0 {
        text += "; a simplified hull holds its source and leaves it by its outer error at most";
    }
    if unsourced > 0 {
        text +=
            &format!("; {unsourced} compared with the stored hull only, for want of the source (--source names it)");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strangers_are_counted() {
        let set = PointSet {
            name: String::new(),
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
            source_vertices: vec![3, 7, 9],
            ..PointSet::default()
        };
        let vertices = [Vec3::new(2.0, -0.0, 0.0), Vec3::new(1.0, 0.0, 0.0)];
        let count = |numbers: [u32; 2]| count_strangers(&vertices, numbers.into_iter().map(Some), &set, false);
        assert_eq!(count([9, 7]), 0);
        assert_eq!(count([7, 9]), 2);
        assert_eq!(count([9, 8]), 1);
    }

    #[test]
    fn a_report_has_the_fields_others_rely_on() {
        let report = serde_json::to_value(HullReport::default()).unwrap();
        for key in [
            "file",
            "hull",
            "vertices",
            "rank",
            "directions",
            "max_regret",
            "mismatches",
            "max_nodes",
            "max_dots",
            "index_bytes_per_vertex",
            "pass",
        ] {
            assert!(report.get(key).is_some(), "{key}");
        }
    }

    #[test]
    fn a_simplified_hull_is_not_called_exact() {
        let exact = HullReport {
            pass: true,
            against: Some("source"),
            outer_error: Some(0.0),
            diameter: Some(2.0),
            ..HullReport::default()
        };
        let outer = HullReport { outer_error: Some(0.12), ..exact.clone() };
        assert_eq!(summary(std::slice::from_ref(&exact)), "1 exact, 0 failed");
        assert!(
            summary(&[exact, outer.clone()]).starts_with("1 exact, 1 simplified, 0 failed; a simplified hull holds")
        );
        assert_eq!(
            (outer.result(), outer_error(&outer)),
            ("holds its source", "1.200e-1 (6.0e-2 of the diameter)".to_owned())
        );
        let unsourced = HullReport { against: Some("stored hull"), ..outer };
        assert_eq!(unsourced.result(), "index exact");
        assert!(!summary(&[unsourced]).contains("holds its source"));
    }

    #[test]
    fn verdicts_say_what_is_wrong() {
        let report = HullReport {
            hull: Some("rock".to_owned()),
            directions: Some(100),
            mismatches: Some(3),
            max_regret: Some(1e-3),
            ..HullReport::default()
        };
        assert_eq!(report.verdict(), "hull rock: 3 of 100 directions are wrong, max_regret 1.00e-3");
    }
}
