//! `bake query`: intersection, distance or contact of hulls or baked files, in many poses.

use hullmap::{Asset, Hull, Pose};
use serde::Serialize;

use crate::args::{Mode, QueryArgs};
use crate::pair::{PairAnswer, PairSolver, Side};
use crate::pose::{parse_pose, read_poses};
use crate::selection::{Selection, hull_index};
use crate::table::{Table, or_dash};
use crate::terminal::Output;
use hullmap_geometry::number::rounded;
use hullmap_pipeline::open::{noun, open_asset};
use hullmap_pipeline::outcome::{Exit, Failure};

/// A line of JSON, or a row of the table.
#[derive(Debug, Serialize)]
struct PoseAnswer {
    pose: usize,
    #[serde(flatten)]
    answer: PairAnswer,
    /// Name of the deciding hull of A, if A or B has several, or the index of a triangle.
    hull_a: Option<String>,
    hull_b: Option<String>,
}

/// All arguments are checked before the first answer.
pub fn run(args: &QueryArgs, out: &mut Output) -> Result<Exit, Failure> {
    let poses = poses(args)?;
    let (select_a, select_b) = (Selection::parse(&args.a), Selection::parse(&args.b));
    let (file_a, file_b) = (open_asset(&select_a.file)?, open_asset(&select_b.file)?);
    let (a, b) = (choose(&select_a, &file_a)?, choose(&select_b, &file_b)?);
    let names_parts = a.has_parts() || b.has_parts();
    let mut solver = PairSolver::new(&a, &b);
    let mut table = table(args.mode, names_parts);
    for (index, pose) in poses.into_iter().enumerate() {
        let answer = solver.query(pose, args.mode);
        let names = |[in_a, in_b]: [u32; 2]| [a.part_name(in_a), b.part_name(in_b)];
        let [hull_a, hull_b] = answer.parts.filter(|_| names_parts).map_or([None, None], names);
        let report = PoseAnswer { pose: index, answer, hull_a, hull_b };
        if args.json {
            out.json(&report)?;
        } else {
            table.push(row(&report, args.mode, names_parts));
        }
    }
    if !args.json {
        table.write(out)?;
    }
    Ok(Exit::Done)
}

/// The poses of `--pose` in their order, then the poses of `--poses`; without both, the identity.
fn poses(args: &QueryArgs) -> Result<Vec<Pose>, Failure> {
    let mut poses = Vec::new();
    for text in &args.poses {
        poses.push(parse_pose(text).map_err(|error| Failure::usage(format!("--pose \"{text}\": {error}")))?);
    }
    if let Some(file) = &args.pose_file {
        poses.extend(read_poses(file)?);
    }
    if poses.is_empty() {
        poses.push(Pose::IDENTITY);
    }
    Ok(poses)
}

/// The selected hull, or all that the file holds.
fn choose<'a>(selection: &Selection, asset: &'a Asset) -> Result<Side<'a>, Failure> {
    let pack = match (asset, &selection.hull) {
        (Asset::Pack(pack), _) => pack,
        (_, None) => return Ok(Side::Asset(asset)),
        (_, Some(hull)) => {
            let (path, noun) = (selection.file.display(), noun(asset.header().kind));
            return Err(Failure::usage(format!("{path}: is a {noun}, which has no hulls; leave out `#{hull}`")));
        }
    };
    let hulls: Vec<Hull> = pack.hulls().collect();
    let Some(wanted) = &selection.hull else {
        return Ok(if let [only] = hulls[..] { Side::Hull(Box::new(only)) } else { Side::Asset(asset) });
    };
    let names: Vec<&str> = hulls.iter().map(|hull| hull.name()).collect();
    let index = hull_index(&selection.file, wanted, &names)?;
    Ok(Side::Hull(Box::new(hulls[index])))
}

fn table(mode: Mode, names_hulls: bool) -> Table {
    let hulls = if names_hulls { "hull of A: | hull of B: | " } else { "" };
    let lengths = match mode {
        Mode::Intersect => "",
        Mode::Distance => "distance | normal: | point on A: | point on B: | ",
        Mode::Contact => "depth | distance | normal: | point on A: | point on B: | ",
    };
    Table::headed(&format!("pose | hit: | status: | {hulls}{lengths}iterations | supports"))
}

fn row(report: &PoseAnswer, mode: Mode, names_hulls: bool) -> Vec<String> {
    let answer = &report.answer;
    let hit = or_dash(answer.hit, |hit| if hit { "yes" } else { "no" }.to_owned());
    let mut cells = vec![report.pose.to_string(), hit, answer.status.to_owned()];
    if names_hulls {
        cells.extend([&report.hull_a, &report.hull_b].map(|name| or_dash(name.as_ref(), String::clone)));
    }
    let length = |value: Option<f64>| or_dash(value, rounded);
    let triple = |value: Option<[f64; 3]>| or_dash(value, |value| value.map(rounded).join(" "));
    if mode == Mode::Contact {
        cells.push(length(answer.depth));
    }
    if mode != Mode::Intersect {
        cells.push(length(answer.distance));
        cells.extend([answer.normal, answer.point_a, answer.point_b].map(triple));
    }
    cells.extend([answer.iterations, answer.support_calls].map(|count| count.to_string()));
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_numbers_keep_their_digits() {
        let answer = PairAnswer { depth: Some(1.25e-7), normal: Some([0.0, 1.0, -3e-9]), ..PairAnswer::default() };
        let cells = row(&PoseAnswer { pose: 0, answer, hull_a: None, hull_b: None }, Mode::Contact, false);
        assert!(cells.contains(&"1.25e-7".to_owned()) && cells.contains(&"0 1 -3e-9".to_owned()), "{cells:?}");
    }
}
