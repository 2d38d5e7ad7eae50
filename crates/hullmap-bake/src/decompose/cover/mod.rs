//! Convex decomposition as a cover: few convex parts that contain the whole surface of a mesh, none
//! of which protrudes from its solid by more than a limit. Both are proven: `fit/coverage.rs`
//! certifies the cover, and `fit/protrusion.rs` the protrusion.
//!
//! | file | concept |
//! |---|---|
//! | [`cells`] | small pieces of the surface, of which parts are made |
//! | [`field`] | which points are too far from the solid |
//! | [`grow`](mod@grow) | parts, cell after cell |
//! | [`choose`](mod@choose) | the fewest parts that cover all cells |
//! | [`wrap`](mod@wrap) | hulls of few vertices around a part, proven |
//! | [`body`], [`bits`], [`sample`] | trial hulls, sets of cells, points on faces |
//!
//! # Steps
//! 1. Clip the mesh's triangles into cells whose hulls stay near the solid.
//! 2. Sweep over the cells in several directions. Each sweep grows parts as large as they get, one
//!    after the other, until all cells are covered. Parts may overlap each other and the solid.
//!    After two sweeps, a few parts are proven. If many proofs fail, start again with more reserve.
//! 3. Choose the fewest of all parts that cover all cells. Grow parts that could replace two of
//!    them, and choose again.
//! 4. Take from each part the cells that others cover, and wrap it in a hull of few vertices.
//! 5. Prove each hull's protrusion. Where a proof fails, forbid the point that refutes it, and grow
//!    other parts.
//!
//! # Why the bounds hold
//! - Cells are clipped triangles, and together they are the whole surface. A hull of all corners of
//!   a cell contains the cell. Hulls are rounded outward, and tests check that they contain all
//!   corners.
//! - Each hull's protrusion is bounded by [`protrusion`](mod@crate::fit::protrusion). It measures
//!   the f32 vertices that are stored.
//!
//! # Complexity
//! O(n log n) for the cells of n triangles. The time of the growth depends on the number of cells,
//! which exceeds 3,000 only where larger cells would protrude too far.

pub mod bits;
pub mod body;
pub mod cells;
pub mod choose;
mod deadline;
pub mod field;
pub mod grow;
pub mod sample;
pub mod wrap;

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use rayon::prelude::*;

use bits::Bits;
use body::{Body, THICKNESS};
use cells::Cutting;
pub use deadline::Deadline;
use field::Field;
use grow::{Candidate, CellGraph};
use wrap::Bounds;

use crate::{PointSet, decompose::patch::Patch, fit::planes::HalfSpace, hull::Hull, progress::Stage, simplify};

/// Share of the limit that a cell's hull may protrude, as far as samples show. Smaller cells fit
/// together better and take longer.
const CELL_SHARE: f64 = 0.08;

/// Share of the limit that no cell's hull may exceed, proven.
const HARD_SHARE: f64 = 0.8;

/// Shares of the limit that parts use while they grow; the rest is for the proof. The next share is
/// tried if proofs fail and the parts that replace the failed ones are too many.
const RESERVES: [f64; 2] = [0.96, 0.8];

/// Maximum number of proven parts that is accepted, relative to the number before proofs.
const ACCEPTED: f64 = 1.1;

/// Number of cells above which cells are cut only where necessary.
const MAX_CELLS: usize = 3000;

const COVER_STEPS: usize = 3000;

/// Maximum number of rounds in which parts are grown to replace others.
const MAX_ROUNDS: usize = 3;

/// Maximum number of times that parts which could not be proven are replaced.
const MAX_REPAIRS: usize = 2;

/// Share of the parts whose proofs may fail before more reserve is tried.
const HOPELESS: f64 = 0.3;

/// Number of sweeps after which a few parts are proven, to see whether there is enough reserve.
const PROBED: usize = 2;

/// Number of parts after the first sweeps, relative to the most that further steps may lead to.
const FEWER_LATER: f64 = 1.25;

/// Number of parts that are proven at that point.
const PROBES: usize = 6;

/// Distance between forbidden points that count as close, relative to the limit.
const CLOSE: f64 = 0.25;

/// Maximum number of cells for which parts are grown to replace others. With more, that takes too
/// long.
const MAX_REGROWN: usize = 4000;

/// Approximate number of places on the surface beside which forbidden points are sought at the
/// start.
const FORBIDDEN: f64 = 3000.0;

/// Maximum number of times that a part is grown again before it is halved.
const MAX_SPLITS: usize = 6;

/// Distance by which a refuted point is moved into its part, relative to the diagonal.
const INWARD_SHIFT: f64 = 1e-5;

/// Directions of the sweeps, none along an axis, so that few cells are at the same height.
const SWEEPS: [[f64; 3]; 5] =
    [[1.0, 0.13, 0.07], [-1.0, -0.11, 0.05], [0.09, 1.0, 0.12], [-0.06, -1.0, 0.1], [0.11, -0.05, 1.0]];

/// Share of a search after which its cells are cut.
const CELLS: f64 = 0.1;

/// Shares of a search at which its attempts start. The second is rarely needed.
const ATTEMPTS: [f64; RESERVES.len() + 1] = [CELLS, 0.9, 1.0];

/// Shares of an attempt at which the first sweeps start, the others start, and all have ended.
const SWEPT: [f64; 3] = [0.0, 0.2, 0.5];

/// Share of an attempt after which parts are proven.
const REGROWN: f64 = 0.8;

/// Limits of a search.
#[derive(Clone, Copy, Debug)]
pub struct CoverLimits<'a> {
    /// Maximum protrusion of a part, above 0.
    pub limit: f64,
    /// Maximum number of vertices of a part.
    pub max_vertices: usize,
    /// Number of parts above which the search gives up, as far as its first sweeps show.
    pub enough: Option<usize>,
    /// When to stop.
    pub deadline: Option<Deadline>,
    /// The progress of the search.
    pub stage: Stage<'a>,
}

impl CoverLimits<'_> {
    fn bounds(&self, diagonal: f64) -> Bounds<'_> {
        let Self { limit, max_vertices, deadline, stage, .. } = *self;
        Bounds { limit, max_vertices, diagonal, deadline, stage }
    }

    fn is_over(&self) -> bool {
        self.stage.is_cancelled() || self.deadline.is_some_and(|deadline| deadline.is_over())
    }
}

/// A part of a cover.
#[derive(Clone, Debug)]
pub struct CoverPart {
    /// The surface that it must contain.
    pub patches: Vec<Patch>,
    /// A hull that contains it.
    pub hull: Hull,
    /// Half-spaces that contain the surface: those of the hull, and of planes between parts. Empty
    /// before parts are separated.
    pub planes: Vec<HalfSpace>,
    /// Proven bound on the hull's protrusion; infinite if it is not known.
    pub bound: f64,
}

/// Hulls that together contain the surface of `mesh`, each with the proven bound on its protrusion
/// from the mesh's solid.
///
/// Without a deadline, the result depends on the mesh and the limits only. In the worst case, a
/// part is one thickened polygon of the surface. When the deadline passes, the parts chosen so far
/// are returned, and the bound of those that are not proven is infinite; `None` if they do not
/// contain the surface yet.
pub fn search(mesh: &PointSet, field: &mut Field, what: &CoverLimits) -> Option<Vec<CoverPart>> {
    let at = |v: &u32| mesh.positions.get(*v as usize).map(|p| DVec3::from_array(p.map(f64::from)));
    let corners = |[a, b, c]: &[u32; 3]| Some([at(a)?, at(b)?, at(c)?]);
    let triangles: Vec<[DVec3; 3]> = mesh.triangles.iter().filter_map(corners).collect();
    field.find_peaks(what.limit * HARD_SHARE);
    let field = &*field;
    let diagonal = field.solid().diagonal();
    let cutting =
        Cutting { limit: what.limit * CELL_SHARE, hard: what.limit * HARD_SHARE, diagonal, max_cells: MAX_CELLS };
    let cells = cells::cells(&triangles, field, &cutting, &|| what.is_over())?;
    what.stage.reach(CELLS);
    let mut best: Option<Vec<CoverPart>> = None;
    let mut failed: Vec<(usize, f64, Attempt)> = Vec::new();
    // Points that are too far for one attempt are too far for the next, which has a lower limit.
    let mut known: Vec<DVec3> = Vec::new();
    for (index, reserve) in RESERVES.into_iter().enumerate() {
        let graph = CellGraph::new(&cells, field, what.limit * reserve, diagonal);
        let is_last = index + 1 == RESERVES.len();
        let what = &CoverLimits { stage: what.stage.from_to(ATTEMPTS[index], ATTEMPTS[index + 1]), ..*what };
        let Some(attempt) = cover(&graph, &triangles, what, is_last, &mut known) else { break };
        let accepted = ((ACCEPTED * attempt.hoped as f64) as usize).max(attempt.hoped + 1);
        if attempt.is_probe {
            continue;
        }
        if attempt.fails() > 0 && attempt.least() > accepted && !what.is_over() {
            failed.push((attempt.least(), reserve, attempt));
            continue;
        }
        let found = attempt.finished(&graph, what);
        let is_good = found.len() <= accepted;
        if best.as_ref().is_none_or(|best| found.len() < best.len()) {
            best = Some(found);
        }
        if is_good || what.is_over() {
            break;
        }
    }
    // Finish a failed attempt only if it may need fewer parts.
    failed.sort_by_key(|(least, ..)| *least);
    for (least, reserve, attempt) in failed {
        if best.as_ref().is_none_or(|best| least < best.len() && !what.is_over()) {
            let graph = CellGraph::new(&cells, field, what.limit * reserve, diagonal);
            let found = attempt.finished(&graph, what);
            if best.as_ref().is_none_or(|best| found.len() < best.len()) {
                best = Some(found);
            }
        }
    }
    best
}

/// Chosen parts, and the outcome of their proofs.
struct Attempt {
    /// Number of parts chosen before the proofs.
    hoped: usize,
    /// Whether the attempt ended because proofs of its first parts failed.
    is_probe: bool,
    /// The cells of each part, and its proof.
    parts: Vec<(Vec<u32>, Outcome)>,
    /// Points that are known to be too far from the solid.
    forbidden: Vec<DVec3>,
}

impl Attempt {
    /// Number of parts whose proofs failed.
    fn fails(&self) -> usize {
        self.parts.iter().filter(|(_, outcome)| outcome.is_err()).count()
    }

    /// Minimum number of parts once failed parts are split.
    fn least(&self) -> usize {
        self.parts.len() + self.fails()
    }

    /// Proven hulls: a part whose proof failed is split.
    fn finished(self, graph: &CellGraph, what: &CoverLimits) -> Vec<CoverPart> {
        let bounds = what.bounds(graph.diagonal);
        let owned = owned(graph, self.parts.iter().map(|(members, _)| members));
        let finished: Vec<Vec<CoverPart>> = self
            .parts
            .into_par_iter()
            .zip(owned)
            .map(|((members, outcome), owned)| match outcome {
                Ok((hull, bound)) => {
                    vec![CoverPart { patches: patches(graph, &owned), hull, bound, planes: Vec::new() }]
                }
                Err(_) => split(graph, members, &bounds, self.forbidden.clone()),
            })
            .collect();
        finished.concat()
    }
}

/// Parts that cover all cells; `None` if the deadline passed before. Unless this is the last
/// attempt, it ends when many proofs fail.
///
/// Forbidden points that are `known` are used, and those that are found are added to them.
fn cover(
    graph: &CellGraph,
    triangles: &[[DVec3; 3]],
    what: &CoverLimits,
    is_last: bool,
    known: &mut Vec<DVec3>,
) -> Option<Attempt> {
    let cells = graph.cells;
    let mut forbidden = forbidden(triangles, graph);
    let start = forbidden.len();
    forbid(&mut forbidden, known, graph);
    let mut pool: Vec<Candidate> = Vec::new();
    for (phase, sweeps) in [&SWEEPS[..PROBED], &SWEEPS[PROBED..]].into_iter().enumerate() {
        if phase > 0 && what.is_over() {
            break;
        }
        let count = forbidden.len();
        let stage = what.stage.from_to(SWEPT[phase], SWEPT[phase + 1]);
        let what = &CoverLimits { stage, ..*what };
        let swept: Vec<Swept> = sweeps
            .par_iter()
            .map(|direction| sweep(graph, DVec3::from_array(*direction), forbidden.clone(), what))
            .collect();
        if phase == 0 && !swept.iter().any(|swept| swept.is_complete) {
            return None;
        }
        for Swept { found, forbidden: points, .. } in swept {
            forbid(&mut forbidden, points.get(count..).unwrap_or_default(), graph);
            found.into_iter().for_each(|candidate| add(&mut pool, candidate));
        }
        if phase == 0 && !what.is_over() && is_hopeless(graph, &pool, what) {
            return None;
        }
        if phase == 0 && !is_last && !what.is_over() {
            let attempt = probe(graph, &pool, what);
            if attempt.fails() as f64 > HOPELESS * attempt.parts.len() as f64 && !what.is_over() {
                known.clear();
                known.extend_from_slice(forbidden.get(start..).unwrap_or_default());
                return Some(attempt);
            }
        }
    }
    let mut chosen = choose(graph, &pool);
    for round in 0..MAX_ROUNDS {
        if what.is_over() || cells.len() > MAX_REGROWN {
            break;
        }
        let [from, to] = [round, round + 1].map(|k| SWEPT[2] + (REGROWN - SWEPT[2]) * k as f64 / MAX_ROUNDS as f64);
        let stage = what.stage.from_to(from, to);
        for (candidate, points) in regrow(graph, &pool, &chosen, &forbidden, &CoverLimits { stage, ..*what }) {
            forbid(&mut forbidden, &points, graph);
            add(&mut pool, candidate);
        }
        let better = choose(graph, &pool);
        let is_done = better.len() >= chosen.len() && round > 0;
        if better.len() <= chosen.len() {
            chosen = better;
        }
        if is_done {
            break;
        }
    }
    let what = &CoverLimits { stage: what.stage.from_to(REGROWN, 1.0), ..*what };
    let attempt = prove(graph, pool, chosen, forbidden, what, is_last);
    known.clear();
    known.extend_from_slice(attempt.forbidden.get(start..).unwrap_or_default());
    Some(attempt)
}

/// Whether many more parts than enough are needed, as far as the first sweeps show.
fn is_hopeless(graph: &CellGraph, pool: &[Candidate], what: &CoverLimits) -> bool {
    let most = |enough: usize| (FEWER_LATER * enough as f64) as usize + 1;
    what.enough.is_some_and(|enough| choose(graph, pool).len() > most(enough))
}

/// The largest of the parts that a few sweeps found, and their proofs.
fn probe(graph: &CellGraph, pool: &[Candidate], what: &CoverLimits) -> Attempt {
    let chosen = choose(graph, pool);
    let mut parts = shrink(graph, pool, &chosen);
    parts.sort_by_key(|part| std::cmp::Reverse(part.members.len()));
    parts.truncate(PROBES);
    let bounds = what.bounds(graph.diagonal);
    let proven = |part: Candidate| {
        let outcome = finish(graph, &part.points, &bounds);
        (part.members, outcome)
    };
    Attempt {
        hoped: chosen.len(),
        is_probe: true,
        parts: parts.into_par_iter().map(proven).collect(),
        forbidden: Vec::new(),
    }
}

/// Adds forbidden points, unless others are close.
fn forbid(forbidden: &mut Vec<DVec3>, points: &[DVec3], graph: &CellGraph) {
    let step = CLOSE * graph.limit;
    let key = |p: &DVec3| (*p / step).floor().to_array().map(|x| x as i64);
    let mut taken: BTreeSet<[i64; 3]> = forbidden.iter().map(key).collect();
    forbidden.extend(points.iter().filter(|p| taken.insert(key(p))));
}

/// Proven hulls of the chosen parts, or of others where a proof fails.
fn prove(
    graph: &CellGraph,
    mut pool: Vec<Candidate>,
    mut chosen: Vec<usize>,
    mut forbidden: Vec<DVec3>,
    what: &CoverLimits,
    is_last: bool,
) -> Attempt {
    let diagonal = graph.diagonal;
    let bounds = what.bounds(diagonal);
    let hoped = chosen.len();
    let mut known: BTreeMap<Vec<u32>, Outcome> = BTreeMap::new();
    let mut repair = 0;
    loop {
        let parts = shrink(graph, &pool, &chosen);
        let steps = what.stage.steps(parts.len());
        let outcomes: Vec<Outcome> = parts
            .par_iter()
            .map(|part| {
                let outcome = known.get(&part.members).cloned();
                let outcome = outcome.unwrap_or_else(|| finish(graph, &part.points, &bounds));
                steps.take();
                outcome
            })
            .collect();
        let members: Vec<Vec<u32>> = parts.into_iter().map(|part| part.members).collect();
        known.extend(members.iter().cloned().zip(outcomes.iter().cloned()));
        let fails = outcomes.iter().filter(|outcome| outcome.is_err()).count();
        let is_hopeless = !is_last && fails as f64 > HOPELESS * members.len() as f64;
        if fails == 0 || is_hopeless || repair >= MAX_REPAIRS || what.is_over() {
            return Attempt { hoped, is_probe: false, parts: members.into_iter().zip(outcomes).collect(), forbidden };
        }
        repair += 1;
        let failed =
            || outcomes.iter().zip(&members).filter_map(|(outcome, members)| Some((outcome.as_ref().err()?, members)));
        let points: Vec<DVec3> =
            failed().filter_map(|(point, members)| Some(moved_inward(graph, members, (*point)?))).collect();
        let mut lost: Vec<Vec<u32>> = Vec::new();
        pool.retain(|candidate| {
            let body = Body::new(&candidate.points, diagonal * THICKNESS);
            let is_kept = !points.iter().any(|p| body.holds(*p, graph.coarse()));
            if !is_kept {
                lost.push(candidate.members.clone());
            }
            is_kept
        });
        // A part with too many vertices is halved.
        for (_, members) in failed().filter(|(point, _)| point.is_none()) {
            let all = Bits::from_numbers(graph.cells.len(), members);
            pool.retain(|candidate| candidate.members.len() <= 1 || !all.is_within(&candidate.covers));
            pool.extend(halves(graph, members).map(|half| graph.part(half)));
        }
        forbidden.extend(points);
        let grown: Vec<Vec<Candidate>> =
            lost.par_iter().map(|members| grow_within(graph, members, &mut forbidden.clone())).collect();
        grown.into_iter().flatten().for_each(|candidate| add(&mut pool, candidate));
        // Every cell stays covered.
        let mut covered = Bits::new(graph.cells.len());
        pool.iter().for_each(|candidate| covered.join(&candidate.covers));
        let missing = (0..graph.cells.len()).filter(|cell| !covered.has(*cell));
        pool.extend(missing.map(|cell| graph.part(vec![cell as u32])));
        chosen = choose(graph, &pool);
    }
}

/// A point that refutes a part, moved into it if it is at its border.
fn moved_inward(graph: &CellGraph, members: &[u32], point: DVec3) -> DVec3 {
    let middle = members.iter().map(|cell| graph.cells[*cell as usize].centre).sum::<DVec3>() / members.len() as f64;
    point + (middle - point).normalize_or_zero() * (INWARD_SHIFT * graph.diagonal)
}

/// A proven hull with its protrusion; otherwise a point that is too far, or `None` if the hull has
/// too many vertices.
type Outcome = Result<(Hull, f64), Option<DVec3>>;

/// Builds and proves the hull of points of the surface. It has at most the allowed number of
/// vertices. After the deadline, nothing is proven.
fn finish(graph: &CellGraph, points: &[DVec3], bounds: &Bounds) -> Outcome {
    let body = Body::new(points, graph.diagonal * THICKNESS);
    let mut least = None;
    if !bounds.is_over() {
        match wrap::wrap(graph.field, &body, bounds, None) {
            // A point of the part itself.
            Err(Some(point)) => return Err(Some(point)),
            Err(None) => {}
            Ok(wrapped) => least = Some(wrapped),
        }
    }
    let Some(tight) = wrap::tight(&body.points, graph.diagonal, bounds.thickness()) else {
        return least.ok_or(None);
    };
    if let Some(wrapped) = least.filter(|(wrapped, _)| wrapped.vertices.len() < tight.vertices.len()) {
        return Ok(wrapped);
    }
    if tight.vertices.len() <= bounds.max_vertices {
        return proven(graph, tight, bounds);
    }
    // The point that refutes a simplified hull may lie outside the part.
    let simplified = simplify::simplify(&tight, simplify::Limit::Vertices(bounds.max_vertices));
    match simplified {
        Ok(Some(simplified)) => proven(graph, simplified.hull, bounds).map_err(|_| None),
        _ => Err(None),
    }
}

/// A hull and its proof.
fn proven(graph: &CellGraph, hull: Hull, bounds: &Bounds) -> Outcome {
    if bounds.is_over() {
        return Ok((hull, f64::INFINITY));
    }
    wrap::prove(graph.field, &hull, bounds, wrap::MEASUREMENTS).map(|bound| (hull, bound)).map_err(Some)
}

/// The cells of each part, of which `members` span its hull: every cell belongs to one part.
fn owned<'a>(graph: &CellGraph, members: impl Iterator<Item = &'a Vec<u32>>) -> Vec<Vec<u32>> {
    let parts: Vec<Candidate> = members.map(|members| graph.part(members.clone())).collect();
    let mut owned = vec![Vec::new(); parts.len()];
    for cell in 0..graph.cells.len() as u32 {
        let is_member = |part: &Candidate| part.members.contains(&cell);
        let covers = |part: &Candidate| part.covers.has(cell as usize);
        let owner = parts.iter().position(is_member).or_else(|| parts.iter().position(covers));
        owner.into_iter().for_each(|owner| owned[owner].push(cell));
    }
    owned
}

/// The surface of cells.
fn patches(graph: &CellGraph, cells: &[u32]) -> Vec<Patch> {
    cells.iter().map(|cell| Patch::of_cell(&graph.cells[*cell as usize])).collect()
}

/// The surface of polygons.
fn patch(polygons: &[&[DVec3]]) -> Vec<Patch> {
    Patch::new(polygons.iter().map(|polygon| polygon.to_vec()).collect()).into_iter().collect()
}

/// Proven parts that replace a part that could not be proven: together they contain its cells.
fn split(graph: &CellGraph, members: Vec<u32>, bounds: &Bounds, mut forbidden: Vec<DVec3>) -> Vec<CoverPart> {
    let size = graph.cells.len();
    // A cell in the part's hull may be in none of its pieces.
    let all: Vec<u32> = graph.part(members).covers.iter().map(|i| i as u32).collect();
    let mut parts = Vec::new();
    let mut stack = vec![(all, 0)];
    while let Some((members, depth)) = stack.pop() {
        match finish(graph, &graph.part(members.clone()).points, bounds) {
            Ok((hull, bound)) => {
                parts.push(CoverPart { patches: patches(graph, &members), hull, bound, planes: Vec::new() })
            }
            Err(Some(point)) if members.len() > 1 && depth < MAX_SPLITS => {
                forbidden.push(moved_inward(graph, &members, point));
                let pieces = grow_within(graph, &members, &mut forbidden);
                if pieces.len() > 1 {
                    let mut left = Bits::from_numbers(size, &members);
                    for piece in pieces {
                        // Each cell goes to one piece.
                        let own: Vec<u32> = piece.covers.iter().filter(|i| left.has(*i)).map(|i| i as u32).collect();
                        own.iter().for_each(|i| left.remove(*i as usize));
                        if !own.is_empty() {
                            stack.push((own, depth + 1));
                        }
                    }
                } else {
                    stack.extend(halves(graph, &members).map(|half| (half, depth + 1)));
                }
            }
            Err(_) if members.len() > 1 => stack.extend(halves(graph, &members).map(|half| (half, depth))),
            Err(_) => {
                for cell in members {
                    let polygons: Vec<&[DVec3]> =
                        graph.cells[cell as usize].polygons.iter().map(Vec::as_slice).collect();
                    parts.extend(of_polygons(graph, polygons, bounds));
                }
            }
        }
    }
    parts
}

/// Proven parts of a cell that cannot be one part: of halves of its polygons, of halves of those,
/// and so on. A single polygon protrudes nowhere.
fn of_polygons(graph: &CellGraph, polygons: Vec<&[DVec3]>, bounds: &Bounds) -> Vec<CoverPart> {
    let mut parts = Vec::new();
    let mut stack = vec![polygons];
    while let Some(polygons) = stack.pop() {
        if let [polygon] = polygons.as_slice() {
            let found = wrap::of_polygon(polygon, graph.diagonal, bounds.thickness(), bounds.max_vertices);
            for (piece, hull) in found {
                let bound = wrap::prove(graph.field, &hull, bounds, wrap::MEASUREMENTS).unwrap_or(f64::INFINITY);
                parts.push(CoverPart { patches: patch(&[&piece]), hull, bound, planes: Vec::new() });
            }
            continue;
        }
        match finish(graph, &polygons.concat(), bounds) {
            Ok((hull, bound)) => parts.push(CoverPart { patches: patch(&polygons), hull, bound, planes: Vec::new() }),
            Err(_) => {
                let centre = |polygon: &[DVec3]| polygon.iter().sum::<DVec3>() / polygon.len() as f64;
                let (low, high) = body::bounds(&polygons.concat());
                let axis = body::longest(high - low);
                let mut order = polygons;
                order.sort_by(|a, b| centre(a)[axis].total_cmp(&centre(b)[axis]));
                let second = order.split_off(order.len() / 2);
                stack.extend([order, second]);
            }
        }
    }
    parts
}

/// Two halves of some cells, by their order along the longest side of their box.
fn halves(graph: &CellGraph, members: &[u32]) -> [Vec<u32>; 2] {
    let centres: Vec<DVec3> = members.iter().map(|cell| graph.cells[*cell as usize].centre).collect();
    let (low, high) = body::bounds(&centres);
    let axis = body::longest(high - low);
    let mut order: Vec<u32> = members.to_vec();
    let at = |cell: u32| graph.cells[cell as usize].centre[axis];
    order.sort_by(|a, b| at(*a).total_cmp(&at(*b)).then(a.cmp(b)));
    let second = order.split_off(order.len() / 2);
    [order, second]
}

/// Parts that are grown from the cells of `members` alone, and cover all of them.
fn grow_within(graph: &CellGraph, members: &[u32], forbidden: &mut Vec<DVec3>) -> Vec<Candidate> {
    let all = Bits::from_numbers(graph.cells.len(), members);
    let mut covered = Bits::new(graph.cells.len());
    let mut found = Vec::new();
    for seed in members {
        if covered.has(*seed as usize) {
            continue;
        }
        let centre = graph.cells[*seed as usize].centre;
        let key = |i: u32| {
            let far = if covered.has(i as usize) { 4.0 * graph.diagonal } else { 0.0 };
            all.has(i as usize).then(|| graph.cells[i as usize].centre.distance(centre) + far)
        };
        let candidate = graph.grow(&[*seed], &key, None, forbidden).unwrap_or_else(|| graph.part(vec![*seed]));
        covered.join(&candidate.covers);
        found.push(candidate);
    }
    found
}

fn choose(graph: &CellGraph, pool: &[Candidate]) -> Vec<usize> {
    let sets: Vec<&Bits> = pool.iter().map(|candidate| &candidate.covers).collect();
    let cost: Vec<f64> = pool.iter().map(|candidate| candidate.points.len() as f64).collect();
    choose::choose(&sets, &cost, graph.cells.len(), COVER_STEPS)
}

/// Adds a candidate, unless another covers the same cells.
fn add(pool: &mut Vec<Candidate>, candidate: Candidate) {
    if !pool.iter().any(|other| candidate.covers.is_within(&other.covers)) {
        pool.push(candidate);
    }
}

/// Points that are too far from the solid, in front of the surface.
fn forbidden(triangles: &[[DVec3; 3]], graph: &CellGraph) -> Vec<DVec3> {
    let all: Vec<DVec3> = graph.cells.iter().flat_map(|cell| cell.points.iter().copied()).collect();
    let hull = Body::new(&all, graph.diagonal * THICKNESS);
    let area: f64 = triangles.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a).length() * 0.5).sum();
    let spacing = graph.limit.max((area / FORBIDDEN).sqrt());
    let mut found = Vec::new();
    let mut owed = 0.5;
    let step = graph.limit * 1.02;
    for [a, b, c] in triangles {
        let cross = (*b - *a).cross(*c - *a);
        let normal = cross.normalize_or_zero();
        owed += cross.length() * 0.5 / (spacing * spacing);
        let count = (owed as usize).min(4000);
        owed -= count as f64;
        for k in 0..count {
            // A low-discrepancy sequence in the triangle.
            let (mut u, mut v) = ((0.5 + k as f64 * 0.754_877_666) % 1.0, (0.5 + k as f64 * 0.569_840_29) % 1.0);
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let p = *a + (*b - *a) * u + (*c - *a) * v;
            for sign in [1.0, -1.0] {
                let q = p + normal * (step * sign);
                if hull.holds(q, 0.0) {
                    found.push(q);
                }
            }
        }
    }
    let field = graph.field;
    found.into_par_iter().filter(|p| field.is_beyond(*p, graph.limit)).collect()
}

/// Result of a sweep.
struct Swept {
    /// The parts.
    found: Vec<Candidate>,
    /// All points that are known to be too far from the solid.
    forbidden: Vec<DVec3>,
    /// Whether the parts cover all cells; otherwise the deadline passed.
    is_complete: bool,
}

/// A cover, part after part in one direction.
fn sweep(graph: &CellGraph, direction: DVec3, mut forbidden: Vec<DVec3>, what: &CoverLimits) -> Swept {
    let cells = graph.cells;
    let mut order: Vec<u32> = (0..cells.len() as u32).collect();
    let height = |i: u32| cells[i as usize].centre.dot(direction);
    order.sort_by(|a, b| height(*a).total_cmp(&height(*b)).then(a.cmp(b)));
    let mut covered = Bits::new(cells.len());
    let mut found = Vec::new();
    for (done, seed) in order.into_iter().enumerate() {
        if covered.has(seed as usize) {
            continue;
        }
        what.stage.reach(done as f64 / cells.len() as f64);
        if what.is_over() {
            return Swept { found, forbidden, is_complete: false };
        }
        let centre = cells[seed as usize].centre;
        let key = |i: u32| {
            let far = if covered.has(i as usize) { 4.0 * graph.diagonal } else { 0.0 };
            Some(cells[i as usize].centre.distance(centre) + far)
        };
        let candidate = graph.grow(&[seed], &key, None, &mut forbidden).unwrap_or_else(|| graph.part(vec![seed]));
        covered.join(&candidate.covers);
        found.push(candidate);
    }
    Swept { found, forbidden, is_complete: true }
}

/// Parts that may replace two chosen neighbours: each starts with the cells that only one of them
/// covers, and grows first into those that only the other one covers.
fn regrow(
    graph: &CellGraph,
    pool: &[Candidate],
    chosen: &[usize],
    forbidden: &[DVec3],
    what: &CoverLimits,
) -> Vec<(Candidate, Vec<DVec3>)> {
    let cells = graph.cells;
    let mut count = vec![0_u32; cells.len()];
    for part in chosen {
        pool[*part].covers.iter().for_each(|i| count[i] += 1);
    }
    let own: Vec<Vec<u32>> = chosen
        .iter()
        .map(|part| pool[*part].covers.iter().filter(|i| count[*i] == 1).map(|i| i as u32).collect())
        .collect();
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    for (p, cells_of_p) in own.iter().enumerate() {
        let near: Bits = {
            let mut bits = Bits::new(cells.len());
            cells_of_p.iter().flat_map(|i| &graph.near[*i as usize]).for_each(|i| bits.insert(*i as usize));
            bits
        };
        for (q, part) in chosen.iter().enumerate() {
            if q != p && pool[*part].covers.iter().any(|i| near.has(i)) {
                pairs.push((p, q));
            }
        }
    }
    let steps = what.stage.steps(pairs.len());
    pairs
        .par_iter()
        .filter_map(|(p, q)| {
            steps.take();
            let start = &own[*q];
            if start.is_empty() || what.is_over() {
                return None;
            }
            let mut wanted = Bits::new(cells.len());
            own[*p].iter().for_each(|i| wanted.insert(*i as usize));
            let middle = start.iter().map(|i| cells[*i as usize].centre).sum::<DVec3>() / start.len() as f64;
            let key = |i: u32| {
                let far = if wanted.has(i as usize) { 0.0 } else { 4.0 * graph.diagonal };
                Some(cells[i as usize].centre.distance(middle) + far)
            };
            let mut points = forbidden.to_vec();
            let known = points.len();
            let grown = graph.grow(start, &key, Some(&wanted), &mut points)?;
            Some((grown, points.split_off(known)))
        })
        .collect()
}

/// The cells of the chosen parts, as few as possible: a cell that several parts contain is left to
/// one of them.
fn shrink(graph: &CellGraph, pool: &[Candidate], chosen: &[usize]) -> Vec<Candidate> {
    let mut count = vec![0_u32; graph.cells.len()];
    for part in chosen {
        pool[*part].covers.iter().for_each(|i| count[i] += 1);
    }
    let mut kept: Vec<Candidate> = Vec::new();
    let mut taken = Bits::new(graph.cells.len());
    for part in chosen {
        let own: Vec<u32> = pool[*part].covers.iter().filter(|i| count[*i] == 1).map(|i| i as u32).collect();
        let core = graph.part(own);
        taken.join(&core.covers);
        kept.push(core);
    }
    let mut left: Vec<usize> = (0..graph.cells.len()).filter(|i| !taken.has(*i)).collect();
    left.sort_by(|a, b| graph.cells[*b].area.total_cmp(&graph.cells[*a].area).then(a.cmp(b)));
    // Twice as many each time, because each time costs a hull of all points.
    let mut count = 1;
    while !left.is_empty() {
        let mut added: Vec<Vec<u32>> = vec![Vec::new(); kept.len()];
        for cell in left.drain(..count.min(left.len())) {
            let holders = (0..chosen.len()).filter(|k| pool[chosen[*k]].covers.has(cell));
            if let Some(k) = holders.max_by_key(|k| (kept[*k].members.len(), usize::MAX - *k)) {
                added[k].push(cell as u32);
            }
        }
        for (part, cells) in kept.iter_mut().zip(&added).filter(|(_, cells)| !cells.is_empty()) {
            *part = graph.with(part, cells);
        }
        left.retain(|cell| !kept.iter().any(|part| part.covers.has(*cell)));
        count *= 2;
    }
    kept.retain(|part| !part.members.is_empty());
    kept
}

#[cfg(test)]
mod tests;
