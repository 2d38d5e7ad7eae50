//! Verification of a pack: each hull against its source, or against its own stored vertices.
//!
//! 1. The direction index of each hull is proven.
//! 2. The source's point sets are cut again, with the recorded options.
//! 3. An exact hull is measured against the points of its part; a simplified hull must contain
//!    them, within its recorded outer error.
//! 4. No point of an object's surface may lie farther outside its parts than recorded, and no part
//!    may protrude farther from its solid than recorded.
//! 5. The recorded mass and voids must be right. A primitive must contain the surface in its part,
//!    and protrude no farther than recorded.
//! 6. Rays at vertices and seams of the parts must not reach a surface behind.
//! 7. Parts that a physics engine cannot use well pass with warnings.

use std::collections::HashSet;

use glam::Vec3;
use hullmap::{CastSettings, Compound, Cost, Hull, Pack, SolidKind};
use hullmap_bake::advice::usability::{Flaw, thickness};
use hullmap_bake::decompose::Cover;
use hullmap_bake::fit::{Solid, SolidRule, mesh_mass};
use hullmap_bake::progress::Stage;
use hullmap_bake::{NO_SOURCE_VERTEX, PointSet};
use hullmap_geometry::number::short;
use serde::Serialize;

use crate::directions::directions;
use crate::fit::{Judge, Witness};
use crate::geometry::polygons;
use crate::index;
use crate::joints::{self, Answer};
use crate::mass;
use crate::outside::measure_outside;
use crate::parts::{PartsFindings, findings};
use crate::primitive;
use crate::support::{Measurement, REGRET_LIMIT, measure};
use crate::truth::Points;
use hullmap_bake::parts::cut::{Part, parts};
use hullmap_bake::parts::estimates::PartsEstimates;
use hullmap_bake::parts::measure::{solid_of, stand_for_one};
use hullmap_geometry::number::rounded;

/// Result of a part that fits its mesh within its recorded bounds.
pub const WITHIN_BOUNDS: &str = "within its bounds";

/// Result of a part with recorded bounds whose mesh was not found.
pub const BOUNDS_UNCHECKED: &str = "bounds unchecked";

/// Result of a part without recorded bounds.
pub const UNMEASURED: &str = "unmeasured";

/// Result of a part that passes, and that an engine cannot use well.
pub const WITH_WARNINGS: &str = "passed with warnings";

/// Reference that the hulls of a pack are compared with.
#[derive(Clone, Copy, Debug)]
pub enum Reference<'a> {
    /// The source's points.
    Source(&'a [PointSet]),
    /// The hull's own stored vertices: a match shows that the index is exact, not the hull.
    StoredHull,
}

/// Result of verifying one hull. Field names are the JSON's; `None` if the pack or its source
/// cannot be used.
#[derive(Clone, Debug, Default, Serialize)]
pub struct HullVerification {
    /// The pack.
    pub file: String,
    /// Name of the hull.
    pub hull: Option<String>,
    /// Number of vertices.
    pub vertices: Option<usize>,
    /// 3 solid, 2 polygon, 1 segment, 0 point.
    pub rank: Option<u32>,
    /// Whether the index is proven: it always leads to the support vertex of the stored hull.
    pub proven: Option<bool>,
    /// Proven bound on the regret in any direction, relative to the diameter.
    pub proven_regret: Option<f64>,
    /// Number of directions tested.
    pub directions: Option<usize>,
    /// Maximum regret. Infinity, which JSON lacks, is written as null.
    pub max_regret: Option<f64>,
    /// Number of directions whose regret exceeds [`REGRET_LIMIT`].
    pub mismatches: Option<usize>,
    /// Stored worst case: nodes read by one query.
    pub max_nodes: Option<u32>,
    /// Stored worst case: dot products of one query.
    pub max_dots: Option<u32>,
    /// Size of the index, in bytes per vertex.
    pub index_bytes_per_vertex: Option<f64>,
    /// Number of rays at its vertices and edges.
    pub joint_rays: Option<usize>,
    /// Whether the hull passed.
    pub pass: bool,
    /// `source` or `stored hull`: what it was compared with.
    pub against: Option<&'static str>,
    /// The source file, if found.
    pub source: Option<String>,
    /// Problems other than mismatches.
    pub problems: Vec<String>,
    /// Direction of the maximum regret.
    pub worst_direction: Option<[f32; 3]>,
    /// Recorded bound on how far the hull extends beyond its source; 0 for an exact hull.
    pub outer_error: Option<f64>,
    /// Recorded bound on how far a point of the source object's surface lies outside all of its
    /// parts; `None` for a hull that was not measured.
    pub uncovered: Option<f64>,
    /// Recorded bound on how far a point of the part lies outside the source object's solid.
    pub protrusion: Option<f64>,
    /// Recorded point of greatest protrusion.
    pub protrusion_at: Option<[f64; 3]>,
    /// Recorded kind of solid: `watertight`, `closed` or `walls`.
    pub solid: Option<&'static str>,
    /// Thickness of a solid: of a plate with its volume and surface area.
    pub thickness: Option<f64>,
    /// Mean protrusion of the part's visible surface, an estimate.
    pub mean_protrusion: Option<f64>,
    /// How the parts of its object fit together, the same for all of them; `None` for a hull that
    /// is not one of several parts.
    pub parts: Option<PartsEstimates>,
    /// Why an engine cannot use the part well, each with its remedy.
    pub warnings: Vec<String>,
    /// Limits of the engine of `--for` that it exceeds.
    pub budget: Vec<String>,
    /// The kinds of these warnings.
    #[serde(skip)]
    pub flaws: Vec<Flaw>,
    /// Index among the parts of its object, and their number: 0 for a hull that is not a part.
    #[serde(skip)]
    pub part_of: [u32; 2],
    /// Maximum distance between two vertices.
    #[serde(skip)]
    pub diameter: Option<f64>,
    /// Whether the pack records it as a part of an object.
    #[serde(skip)]
    pub is_part: bool,
}

impl HullVerification {
    /// The result as one sentence: all problems, or the result in a few words.
    pub fn verdict(&self) -> String {
        let hull = self.hull.as_deref().unwrap_or("-");
        let mut parts = self.problems.clone();
        if let (Some(wrong), Some(tried), Some(regret)) = (self.mismatches, self.directions, self.max_regret)
            && wrong > 0
        {
            parts.push(format!("wrong support point in {wrong} of {tried} directions, max_regret {}", short(regret)));
        }
        let text = if parts.is_empty() { self.result().to_owned() } else { parts.join("; ") };
        format!("hull {hull}: {text}")
    }

    /// Whether this is a simplified hull.
    pub fn is_simplified(&self) -> bool {
        self.outer_error.is_some_and(|error| error > 0.0)
    }

    /// Whether the hull was compared with its source.
    pub fn is_against_source(&self) -> bool {
        self.against == Some("source")
    }

    /// Whether this is a part that is not the solid itself: what the parts cover, or how far this
    /// one protrudes, is only known within bounds, or not at all.
    pub fn is_loose_part(&self) -> bool {
        let limit = REGRET_LIMIT * self.diameter.unwrap_or(0.0);
        // An unmeasured part, and NaN, are loose.
        let is_tight = |bound: Option<f64>| bound.is_some_and(|bound| bound <= limit);
        self.is_part && !(is_tight(self.uncovered) && is_tight(self.protrusion))
    }

    /// The result in a few words. It claims no more than was shown.
    pub fn result(&self) -> &'static str {
        let of_part = match (self.solid, self.is_against_source()) {
            (Some(_), true) => WITHIN_BOUNDS,
            (Some(_), false) => BOUNDS_UNCHECKED,
            (None, _) => UNMEASURED,
        };
        match (self.pass, self.is_simplified(), self.is_against_source()) {
            (false, _, _) => "FAILED",
            (true, _, _) if self.is_loose_part() && of_part != WITHIN_BOUNDS => of_part,
            (true, _, _) if !self.warnings.is_empty() => WITH_WARNINGS,
            (true, _, _) if self.is_loose_part() => of_part,
            (true, true, true) => "contains its source",
            (true, _, false) => "index exact",
            (true, false, true) => "exact",
        }
    }
}

/// Proves the index of every hull of a pack, and verifies the hull in `count` directions. `cover`
/// are the recorded parameters of a decomposition. File names in the results are empty. Fails if
/// the source has another number of hulls, or redundant data in the pack disagree. Complexity:
/// O(points · directions) for each hull; with decomposed meshes, the time to cut them again.
pub fn verify_hulls(
    pack: &Pack,
    reference: Reference,
    cover: Option<&Cover>,
    count: usize,
    seed: u64,
) -> Result<Vec<HullVerification>, String> {
    let whole = Compound::new(pack);
    let answer: &Answer = &|ray| hullmap::ray(&whole, ray, &CastSettings::default());
    verify_answers(pack, reference, cover, count, seed, answer)
}

fn verify_answers(
    pack: &Pack,
    reference: Reference,
    cover: Option<&Cover>,
    count: usize,
    seed: u64,
    answer: &Answer,
) -> Result<Vec<HullVerification>, String> {
    pack.check_repeats().map_err(|error| error.to_string())?;
    let mut results = compare_hulls(pack, reference, cover, count, seed)?;
    for (result, proof) in results.iter_mut().zip(index::prove(pack)) {
        result.proven = Some(proof.is_ok());
        match proof {
            Ok(proof) => result.proven_regret = Some(proof.regret),
            Err(reason) => {
                result.problems.insert(0, format!("its index is not proven: {reason}"));
                result.pass = false;
            }
        }
    }
    let (counts, problem) = joints::cast_rays(pack, seed, answer);
    for (result, count) in results.iter_mut().zip(counts) {
        result.joint_rays = Some(count);
    }
    if let Some((index, problem)) = problem
        && let Some(result) = results.get_mut(index)
    {
        result.problems.push(problem);
        result.pass = false;
    }
    Ok(results)
}

fn compare_hulls(
    pack: &Pack,
    reference: Reference,
    cover: Option<&Cover>,
    count: usize,
    seed: u64,
) -> Result<Vec<HullVerification>, String> {
    let Reference::Source(sets) = reference else {
        return Ok(verify_alone(pack, cover, count, seed));
    };
    let has_collision_parts = sets.iter().any(|points| points.stands_for.is_some());
    let has_own_parts = cover.is_none() && !has_collision_parts && pack.hulls().any(|hull| hull.part_count() > 0);
    // A search that ends by the clock does not find the same parts again.
    let is_timed = matches!(cover, Some(Cover { seconds: Some(_), .. }));
    if has_own_parts || is_timed {
        return verify_parts_of_others(pack, sets, cover, count, seed);
    }
    let parts = parts(sets, cover, Stage::default())?;
    if parts.len() != pack.hull_count() {
        let (found, expected) = (pack.hull_count(), parts.len());
        return Err(format!("the pack has {found} hulls, but its source has {expected}; bake it again"));
    }
    let hulls = pack.hulls().zip(&parts);
    let mut results: Vec<HullVerification> =
        hulls.map(|(hull, part)| verify_hull(&hull, Some(&part.points), count, seed)).collect();
    let hulls: Vec<Hull> = pack.hulls().collect();
    let mut start = 0;
    let is_same_object = |part: &Part, next: &Part| {
        part.set == next.set || cover.is_none() && stand_for_one(&sets[part.set], &sets[next.set])
    };
    for own in parts.chunk_by(is_same_object) {
        let end = start + own.len();
        let points = &sets[own[0].set];
        let mesh = points.stands_for.as_deref().filter(|_| cover.is_none()).unwrap_or(points);
        verify_object(&hulls[start..end], mesh, cover, &mut results[start..end]);
        start = end;
    }
    Ok(results)
}

fn verify_alone(pack: &Pack, cover: Option<&Cover>, count: usize, seed: u64) -> Vec<HullVerification> {
    let hulls: Vec<Hull> = pack.hulls().collect();
    let mut results: Vec<HullVerification> = hulls.iter().map(|hull| verify_hull(hull, None, count, seed)).collect();
    let mut start = 0;
    for own in hulls.chunk_by(|_, next| next.part() > 0) {
        add(findings(own, None, None, cover), &mut results[start..start + own.len()]);
        start += own.len();
    }
    results
}

/// Verifies a pack whose parts were not cut by this program, or cannot be cut again: each hull
/// against its own vertices, and the fit of each object's parts against its mesh.
fn verify_parts_of_others(
    pack: &Pack,
    sets: &[PointSet],
    cover: Option<&Cover>,
    count: usize,
    seed: u64,
) -> Result<Vec<HullVerification>, String> {
    let hulls: Vec<Hull> = pack.hulls().collect();
    let objects: Vec<&[Hull]> = hulls.chunk_by(|_, next| next.part() > 0).collect();
    if objects.len() != sets.len() {
        let (found, expected) = (objects.len(), sets.len());
        return Err(format!("the pack has the parts of {found} objects, but its source has {expected}; bake it again"));
    }
    let mut results = Vec::with_capacity(hulls.len());
    let mut start = 0;
    for (own, points) in objects.into_iter().zip(sets) {
        let source = (own[0].part_count() == 0).then_some(points);
        results.extend(own.iter().map(|hull| verify_hull(hull, source, count, seed)));
        verify_object(own, points, cover, &mut results[start..start + own.len()]);
        start += own.len();
    }
    Ok(results)
}

fn verify_object(hulls: &[Hull], mesh: &PointSet, cover: Option<&Cover>, results: &mut [HullVerification]) {
    let computed = mesh_mass(mesh);
    if let (Some(first), Some(result)) = (hulls.first(), results.first_mut()) {
        result.problems.extend(mass::problem(first, mesh, computed.as_ref()));
    }
    let found = findings(hulls, Some(mesh), computed.map(|mass| mass.volume), cover);
    if let (Some(first), Some(result)) = (hulls.first(), results.first_mut()) {
        let voids = found.as_ref().and_then(|found| found.estimates.voids_share());
        result.problems.extend(mass::voids_problem(first, &mesh.name, voids));
    }
    verify_fit(hulls, mesh, cover, results);
    add(found, results);
}

fn add(found: Option<PartsFindings>, results: &mut [HullVerification]) {
    let Some(PartsFindings { estimates, means, doubts }) = found else { return };
    for (result, mean) in results.iter_mut().zip(means) {
        (result.parts, result.mean_protrusion) = (Some(estimates), mean);
    }
    for doubt in doubts {
        for part in doubt.parts {
            results[part].warnings.push(doubt.remark.text().to_owned());
            results[part].flaws.push(doubt.flaw);
        }
    }
}

/// Checks what the parts of one object record about their fit against its mesh: see [`Judge`].
fn verify_fit(hulls: &[Hull], mesh: &PointSet, cover: Option<&Cover>, results: &mut [HullVerification]) {
    let count = hulls.len();
    for (part, (hull, result)) in hulls.iter().zip(results.iter_mut()).enumerate() {
        let is_part = hull.part_count() > 0 || count > 1;
        if is_part && (hull.part() as usize, hull.part_count() as usize) != (part, count) {
            let (recorded, of) = (hull.part(), hull.part_count());
            let name = &mesh.name;
            result
                .problems
                .push(format!("recorded as part {recorded} of {of} of {name}, but it is part {part} of {count}"));
        }
    }
    let is_measured = hulls.iter().any(|hull| hull.solid().is_some());
    if is_measured && mesh.triangles.is_empty() {
        results[0].problems.push(format!("its parts record a fit, but {} has no faces", mesh.name));
    } else if is_measured {
        judge(hulls, mesh, cover, results);
    }
    for result in results {
        result.pass = result.pass && result.problems.is_empty();
    }
}

/// The solid that the hulls name. Packs of earlier versions closed every hole.
fn named_solid(hulls: &[Hull], mesh: &PointSet, cover: Option<&Cover>) -> Solid {
    let rule = cover.map_or(SolidRule::Auto, |cover| cover.solid);
    let is_closed = hulls.first().and_then(Hull::solid) == Some(SolidKind::Closed);
    let solid = if is_closed && rule == SolidRule::Auto { SolidRule::Closed } else { rule };
    solid_of(mesh, Some(&Cover { solid, ..cover.copied().unwrap_or_default() }))
}

fn judge(hulls: &[Hull], mesh: &PointSet, cover: Option<&Cover>, results: &mut [HullVerification]) {
    let judge = Judge::new(mesh, &named_solid(hulls, mesh, cover));
    let name = &mesh.name;
    let uncovered = hulls.first().and_then(Hull::uncovered).unwrap_or(0.0);
    if let Some(Witness { distance, at }) = judge.uncovered(mesh, hulls, uncovered) {
        let (found, recorded) = (rounded(distance), rounded(uncovered));
        let text = format!(
            "{at} on the surface of {name} is {found} outside all parts, but the pack records at most {recorded}"
        );
        results.iter_mut().for_each(|result| result.problems.push(text.clone()));
    }
    for (hull, result) in hulls.iter().zip(results) {
        let (Some(solid), Some(claim), Some(at)) = (hull.solid(), hull.protrusion(), hull.protrusion_at()) else {
            result.problems.push("its fit was not measured, but the fit of other parts was".to_owned());
            continue;
        };
        if solid != judge.kind() {
            let found = judge.kind();
            result.problems.push(format!("the solid of {name} is recorded as {solid}, but it is {found}"));
        }
        result.problems.extend(primitive::problem(hull, mesh, &judge));
        let is_in = judge.is_in(hull, at);
        if !is_in {
            result.problems.push(format!("its point of greatest protrusion, {at}, is not a point of the part"));
        }
        if let Some(Witness { distance, at }) = judge.protrusion(hull, claim, is_in.then_some(at)) {
            let (found, recorded) = (rounded(distance), rounded(claim));
            result.problems.push(format!(
                "{at} of this part is {found} outside the solid of {name}, but it records at most {recorded}"
            ));
        }
    }
}

fn verify_hull(hull: &Hull, source: Option<&PointSet>, count: usize, seed: u64) -> HullVerification {
    let vertices: Vec<Vec3> = hull.vertices().collect();
    let faces = polygons(hull);
    let directions = directions(&vertices, &faces, count, seed);
    let mut problems = source.map_or_else(Vec::new, |set| identity_problems(hull, &vertices, set));
    if faces.is_empty() && hull.rank() >= 2 {
        problems.push("its vertices are not the vertices of a convex hull".to_owned());
    }
    let source_points = source.map(|set| Points::new(&set.positions));
    let points = match source_points {
        Some(points) if hull.outer_error() == 0.0 => points,
        other => {
            if let Some(points) = other {
                let found = measure_outside(&vertices, &points, &directions);
                problems.extend(found.problem(hull.outer_error()));
            }
            // A simplified hull has other vertices than its source: its index is exact for the
            // stored hull.
            Points::new(&vertices.iter().map(|vertex| vertex.to_array()).collect::<Vec<_>>())
        }
    };
    let measured = measure(hull, &points, &directions);
    problems.extend(query_problems(&measured, hull.worst_cost()));
    let Measurement { max_regret, worst_direction, mismatches, .. } = measured;
    let worst = hull.worst_cost();
    HullVerification {
        file: String::new(),
        hull: Some(hull.name().to_owned()),
        vertices: Some(vertices.len()),
        rank: Some(hull.rank()),
        proven: None,
        proven_regret: None,
        directions: Some(count),
        max_regret: Some(max_regret),
        mismatches: Some(mismatches),
        max_nodes: Some(worst.nodes),
        max_dots: Some(worst.dots),
        index_bytes_per_vertex: Some(hull.index_byte_len() as f64 / vertices.len() as f64),
        joint_rays: None,
        pass: mismatches == 0 && problems.is_empty(),
        against: Some(if source.is_some() { "source" } else { "stored hull" }),
        source: None,
        problems,
        worst_direction: worst_direction.map(|dir| dir.to_array()),
        outer_error: Some(hull.outer_error()),
        uncovered: hull.uncovered(),
        protrusion: hull.protrusion(),
        protrusion_at: hull.protrusion_at().map(|at| at.to_array()),
        solid: hull.solid().map(SolidKind::as_str),
        thickness: (hull.rank() == 3).then(|| thickness(hull.volume(), hull.surface_area())),
        mean_protrusion: None,
        parts: None,
        warnings: Vec::new(),
        budget: Vec::new(),
        flaws: Vec::new(),
        part_of: [hull.part(), hull.part_count()],
        diameter: Some(hull.diameter()),
        is_part: hull.part_count() > 0,
    }
}

fn identity_problems(hull: &Hull, vertices: &[Vec3], set: &PointSet) -> Vec<String> {
    let mut problems = Vec::new();
    if set.name != hull.name() {
        problems.push(format!("the source names this hull {}", set.name));
    }
    if set.origin != hull.origin().to_array() {
        problems.push(format!("its origin is {}, but the source's is {:?}", hull.origin(), set.origin));
    }
    let recorded = (0..vertices.len() as u32).map(|index| hull.source_vertex(index));
    let count = count_mismatched_vertices(vertices, recorded, set, hull.outer_error() > 0.0);
    if count > 0 {
        problems.push(format!("{count} vertices differ from their recorded source vertices"));
    }
    problems
}

fn query_problems(measured: &Measurement, worst: Cost) -> Vec<String> {
    let mut problems = Vec::new();
    let (count, cost) = (measured.invalid_answers, measured.cost);
    if count > 0 {
        problems.push(format!("the support point is not a vertex of the hull in {count} special directions"));
    }
    if cost.nodes > worst.nodes || cost.dots > worst.dots {
        problems.push(format!(
            "a query read {} nodes and took {} dot products, above the recorded worst case of {} and {}",
            cost.nodes, cost.dots, worst.nodes, worst.dots
        ));
    }
    problems
}

/// Hull vertices that differ from their recorded source vertices, in bits, with −0 as +0. Without a
/// source vertex, they must be one of the part's other points, except for simplified hulls.
fn count_mismatched_vertices(
    vertices: &[Vec3],
    recorded: impl Iterator<Item = Option<u32>>,
    set: &PointSet,
    is_simplified: bool,
) -> usize {
    let bits = |position: [f32; 3]| position.map(|x| (x + 0.0).to_bits());
    // Points with a source vertex come first, in ascending order.
    let known = set.source_vertices.partition_point(|&vertex| vertex != NO_SOURCE_VERTEX);
    let others: HashSet<[u32; 3]> = set.positions[known..].iter().map(|position| bits(*position)).collect();
    let matches = |(vertex, source_vertex): &(&Vec3, Option<u32>)| {
        let vertex = bits(vertex.to_array());
        match source_vertex {
            _ if is_simplified => source_vertex.is_none(),
            None => others.contains(&vertex),
            Some(source_vertex) => {
                let found = set.source_vertices[..known].binary_search(source_vertex);
                found.is_ok_and(|index| bits(set.positions[index]) == vertex)
            }
        }
    };
    vertices.iter().zip(recorded).filter(|pair| !matches(pair)).count()
}

#[cfg(test)]
mod tests {
    use hullmap_bake::{BakedHull, IndexKind, SourceRecord, bake_hull, write_pack};

    use super::*;

    #[test]
    fn mismatched_vertices_are_counted() {
        let set = PointSet {
            name: String::new(),
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
            source_vertices: vec![3, 7, 9],
            ..PointSet::default()
        };
        let vertices = [Vec3::new(2.0, -0.0, 0.0), Vec3::new(1.0, 0.0, 0.0)];
        let count =
            |recorded: [u32; 2]| count_mismatched_vertices(&vertices, recorded.into_iter().map(Some), &set, false);
        assert_eq!(count([9, 7]), 0);
        assert_eq!(count([7, 9]), 2);
        assert_eq!(count([9, 8]), 1);
    }

    #[test]
    fn json_has_the_documented_fields() {
        let result = serde_json::to_value(HullVerification::default()).unwrap();
        let keys = "file hull vertices rank proven proven_regret directions max_regret mismatches max_nodes max_dots \
                    index_bytes_per_vertex joint_rays pass";
        for key in keys.split(' ') {
            assert!(result.get(key).is_some(), "{key}");
        }
    }

    /// Two boxes that abut over a floor, and answers that are all from the floor.
    #[test]
    fn an_answer_from_behind_a_part_fails() {
        let part = |[low, high]: [[f32; 3]; 2]| {
            let corner =
                |index: usize| [0, 1, 2].map(|axis| if index >> axis & 1 == 0 { low[axis] } else { high[axis] });
            bake_hull(&PointSet::of_positions((0..8).map(corner).collect()), IndexKind::None).unwrap()
        };
        let pack =
            |hulls: &[BakedHull]| Pack::from_bytes(&write_pack(hulls, &SourceRecord::default()).unwrap()).unwrap();
        let floor = part([[-9.0, -9.0, -1.0], [9.0, 9.0, 0.0]]);
        let boxes = [[[-1.0, -1.0, 2.0], [0.0, 1.0, 3.0]], [[0.0, -1.0, 2.0], [1.0, 1.0, 3.0]]].map(part);
        let (all, floor) = (pack(&[boxes.as_slice(), std::slice::from_ref(&floor)].concat()), pack(&[floor]));
        let (whole, behind) = (Compound::new(&all), Compound::new(&floor));
        for seed in 0..8 {
            let verify = |whole: &Compound| {
                let answer: &Answer = &|ray| hullmap::ray(whole, ray, &CastSettings::default());
                verify_answers(&all, Reference::StoredHull, None, 10, seed, answer).unwrap()
            };
            let right = verify(&whole);
            assert!(right.iter().all(|own| own.pass), "seed {seed}: {:?}", right[0].problems);
            assert!(right.iter().filter_map(|own| own.joint_rays).sum::<usize>() > 12, "seed {seed}");
            let wrong: Vec<HullVerification> = verify(&behind).into_iter().filter(|own| !own.pass).collect();
            assert!(matches!(&wrong[..], [own] if own.problems[0].contains("meets a part at t = 1")), "seed {seed}");
        }
    }

    #[test]
    fn verdict_names_the_problem() {
        let result = HullVerification {
            hull: Some("rock".to_owned()),
            directions: Some(100),
            mismatches: Some(3),
            max_regret: Some(1e-3),
            ..HullVerification::default()
        };
        assert_eq!(result.verdict(), "hull rock: wrong support point in 3 of 100 directions, max_regret 0.001");
    }
}
