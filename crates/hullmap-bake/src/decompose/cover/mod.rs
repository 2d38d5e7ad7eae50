//! Convex decomposition as a cover, with proven bounds.

pub mod bits;
pub mod body;
pub mod cells;
pub mod choose;
pub mod field;
pub mod grow;
pub mod sample;
pub mod wrap;

use std::collections::BTreeMap;
use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use bits::Bits;
use body::Body;
use cells::Cutting;
use field::Field;
use grow::{Candidate, Ground};

use crate::{PointSet, hull::Hull, parts::solid::Solid, simplify};
use wrap::Bounds;

/// Thickness of flat trial bodies, relative to the diagonal.
const THICKNESS: f64 = 2e-7;

/// Share of the limit that a cell's hull may protrude.
const CELL_SHARE: f64 = 0.12;

/// Share of the limit that parts use while they grow; the rest is for the proof.
const RESERVE: f64 = 0.96;

/// Number of times that parts which could not be proven are replaced.
const MAX_REPAIRS: usize = 4;

/// Directions in which covers start.
const SWEEPS: [[f64; 3]; 8] = [
    [1.0, 0.13, 0.07],
    [-1.0, -0.11, 0.05],
    [0.09, 1.0, 0.12],
    [-0.06, -1.0, 0.1],
    [0.11, -0.05, 1.0],
    [0.07, 0.12, -1.0],
    [0.6, 0.7, 0.8],
    [-0.7, 0.6, -0.5],
];

/// What to search for.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    pub limit: f64,
    pub max_vertices: usize,
    pub rounds: usize,
    pub share: f64,
    pub verbose: bool,
}

pub struct Found {
    pub parts: Vec<(Hull, f64)>,
    pub cells: usize,
    pub pool: usize,
}

pub fn search(mesh: &PointSet, solid: &Solid, what: &Search) -> Found {
    let started = Instant::now();
    let say = |text: String| {
        if what.verbose {
            eprintln!("  {:.3} {text}", started.elapsed().as_secs_f64());
        }
    };
    let at = |v: u32| DVec3::from_array(mesh.positions[v as usize].map(f64::from));
    let triangles: Vec<[DVec3; 3]> = mesh.triangles.iter().map(|t| t.map(at)).collect();
    let field = Field::new(solid);
    say(format!("field"));
    let diagonal = solid.diagonal();
    let cutting = Cutting { limit: what.limit * what.share, hard: what.limit * 0.8, diagonal, max_cells: 3000 };
    let cells = cells::cells(&triangles, &field, &cutting);
    say(format!("{} cells", cells.len()));
    let ground = Ground::new(&cells, &field, what.limit * RESERVE, diagonal);
    let mut forbidden = forbidden(&triangles, &ground);
    say(format!("{} forbidden, {} near", forbidden.len(), ground.near.iter().map(Vec::len).sum::<usize>()));
    let swept: Vec<(Vec<Candidate>, Vec<DVec3>)> =
        SWEEPS.par_iter().map(|direction| sweep(&ground, DVec3::from_array(*direction), forbidden.clone())).collect();
    let known = forbidden.len();
    let mut pool: Vec<Candidate> = Vec::new();
    let mut lengths = Vec::new();
    for (found, points) in swept {
        lengths.push(found.len());
        forbidden.extend(&points[known..]);
        for candidate in found {
            add(&mut pool, candidate);
        }
    }
    say(format!("sweeps {lengths:?}, pool {}, forbidden {}", pool.len(), forbidden.len()));
    let mut chosen = choose(&ground, &pool, 3000);
    say(format!("chosen {}", chosen.len()));
    for round in 0..what.rounds {
        let before = pool.len();
        let grown = regrow(&ground, &pool, &chosen, &forbidden, round);
        for (candidate, points) in grown {
            forbidden.extend(points);
            add(&mut pool, candidate);
        }
        let better = choose(&ground, &pool, 3000);
        say(format!("round {round}: pool {} -> {}, chosen {}", before, pool.len(), better.len()));
        if better.len() >= chosen.len() && round >= 1 {
            if better.len() == chosen.len() { chosen = better; }
            break;
        }
        chosen = better;
    }
    let bounds = Bounds { limit: what.limit, max_vertices: what.max_vertices, diagonal };
    let mut parts = Vec::new();
    let mut known: BTreeMap<Vec<u32>, Outcome> = BTreeMap::new();
    for repair in 0..=MAX_REPAIRS {
        let members = shrink(&ground, &pool, &chosen);
        let outcomes: Vec<Outcome> = members
            .par_iter()
            .map(|members| known.get(members).cloned().unwrap_or_else(|| finish(&ground, members, &bounds)))
            .collect();
        known.extend(members.iter().cloned().zip(outcomes.iter().cloned()));
        let failed = outcomes.iter().filter(|outcome| outcome.is_err()).count();
        say(format!("{} parts, {failed} not proven", members.len()));
        if failed == 0 || repair == MAX_REPAIRS {
            for (outcome, members) in outcomes.into_iter().zip(&members) {
                match outcome {
                    Ok(part) => parts.push(part),
                    Err(_) => split(&ground, members, &bounds, &mut parts),
                }
            }
            break;
        }
        let points: Vec<DVec3> = outcomes.iter().filter_map(|outcome| outcome.as_ref().err().copied().flatten()).collect();
        let mut lost: Vec<Vec<u32>> = Vec::new();
        pool.retain(|candidate| {
            let body = Body::new(&candidate.points, diagonal * THICKNESS);
            let is_kept = !points.iter().any(|p| body.holds(*p, 0.0));
            if !is_kept {
                lost.push(candidate.members.clone());
            }
            is_kept
        });
        // A part of too many vertices is halved.
        for (outcome, members) in outcomes.iter().zip(&members) {
            if matches!(outcome, Err(None)) {
                let all = Bits::of(cells.len(), members);
                pool.retain(|candidate| !all.is_within(&candidate.covers) || candidate.members.len() <= 1);
                for half in halves(&ground, members) {
                    pool.push(ground.part(half));
                }
            }
        }
        forbidden.extend(points);
        let grown: Vec<Vec<Candidate>> = lost.par_iter().map(|members| within(&ground, members, forbidden.clone())).collect();
        for candidate in grown.into_iter().flatten() {
            add(&mut pool, candidate);
        }
        // Every cell stays covered.
        let mut covered = Bits::new(cells.len());
        pool.iter().for_each(|candidate| covered.join(&candidate.covers));
        for cell in 0..cells.len() {
            if !covered.has(cell) {
                pool.push(ground.part(vec![cell as u32]));
            }
        }
        chosen = choose(&ground, &pool, 3000);
    }
    say(format!("{} parts proven", parts.len()));
    Found { parts, cells: cells.len(), pool: pool.len() }
}

/// A proven hull with its protrusion; else a point that is too far, or nothing if it has too many
/// vertices.
type Outcome = Result<(Hull, f64), Option<DVec3>>;

/// The proven hull of a part; else a point that is too far, or nothing if it has too many vertices.
fn finish(ground: &Ground, members: &[u32], bounds: &Bounds) -> Outcome {
    let points: Vec<DVec3> = members.iter().flat_map(|cell| ground.cells[*cell as usize].points.iter().copied()).collect();
    let body = Body::new(&points, ground.diagonal * THICKNESS);
    // A point of the part itself.
    let wrapped = match wrap::wrap(ground.field, &body, bounds) {
        Err(Some(point)) => return Err(Some(point)),
        other => other,
    };
    let Some(tight) = wrap::tight(&body.points, ground.diagonal) else { return wrapped };
    match wrapped {
        Ok(wrapped) if wrapped.0.vertices.len() < tight.vertices.len() => return Ok(wrapped),
        _ => {}
    }
    if tight.vertices.len() <= bounds.max_vertices {
        return wrap::prove(ground.field, &tight, bounds).map(|bound| (tight, bound)).map_err(Some);
    }
    let simplified = simplify::simplify(&tight, simplify::Limit::Vertices(bounds.max_vertices));
    if let Ok(Some(simplified)) = simplified
        && let Ok(bound) = wrap::prove(ground.field, &simplified.hull, bounds)
    {
        return Ok((simplified.hull, bound));
    }
    if members.len() > 1 {
        return Err(None);
    }
    wrap::prove(ground.field, &tight, bounds).map(|bound| (tight, bound)).map_err(Some)
}

/// Proven parts of cells that are no proven part together.
fn split(ground: &Ground, members: &[u32], bounds: &Bounds, parts: &mut Vec<(Hull, f64)>) {
    let mut stack = vec![members.to_vec()];
    while let Some(members) = stack.pop() {
        if let Ok(part) = finish(ground, &members, bounds) {
            parts.push(part);
        } else if members.len() > 1 {
            stack.extend(halves(ground, &members));
        } else {
            // Polygons of the surface protrude nowhere.
            for polygon in members.iter().flat_map(|cell| &ground.cells[*cell as usize].polygons) {
                if let Some(hull) = wrap::tight(polygon, ground.diagonal) {
                    let bound = wrap::prove(ground.field, &hull, bounds).unwrap_or(0.0);
                    parts.push((hull, bound));
                }
            }
        }
    }
}

/// Cells on both sides of the middle of their box.
fn halves(ground: &Ground, members: &[u32]) -> [Vec<u32>; 2] {
    let centres: Vec<DVec3> = members.iter().map(|cell| ground.cells[*cell as usize].centre).collect();
    let (low, high) = body::bounds(&centres);
    let size = high - low;
    let axis = (0..3).fold(0, |longest, axis| if size[axis] > size[longest] { axis } else { longest });
    let mut order: Vec<u32> = members.to_vec();
    let at = |cell: u32| ground.cells[cell as usize].centre[axis];
    order.sort_by(|a, b| at(*a).total_cmp(&at(*b)).then(a.cmp(b)));
    let second = order.split_off(order.len() / 2);
    [order, second]
}

/// Parts of some cells that cover them.
fn within(ground: &Ground, members: &[u32], mut forbidden: Vec<DVec3>) -> Vec<Candidate> {
    let all = Bits::of(ground.cells.len(), members);
    let mut covered = Bits::new(ground.cells.len());
    let mut found = Vec::new();
    for seed in members {
        if covered.has(*seed as usize) {
            continue;
        }
        let centre = ground.cells[*seed as usize].centre;
        let key = |i: u32| {
            let far = if covered.has(i as usize) { 4.0 * ground.diagonal } else { 0.0 };
            all.has(i as usize).then(|| ground.cells[i as usize].centre.distance(centre) + far)
        };
        let candidate = ground.grow(&[*seed], &key, &mut forbidden).unwrap_or_else(|| ground.part(vec![*seed]));
        covered.join(&candidate.covers);
        found.push(candidate);
    }
    found
}

fn choose(ground: &Ground, pool: &[Candidate], steps: usize) -> Vec<usize> {
    let sets: Vec<&Bits> = pool.iter().map(|candidate| &candidate.covers).collect();
    let cost: Vec<f64> = pool.iter().map(|candidate| candidate.points.len() as f64).collect();
    choose::choose(&sets, &cost, ground.cells.len(), steps)
}

/// Adds a candidate, unless another covers the same cells.
fn add(pool: &mut Vec<Candidate>, candidate: Candidate) {
    if !pool.iter().any(|other| candidate.covers.is_within(&other.covers)) {
        pool.push(candidate);
    }
}

/// Points that are too far from the solid, in front of the surface.
fn forbidden(triangles: &[[DVec3; 3]], ground: &Ground) -> Vec<DVec3> {
    let all: Vec<DVec3> = ground.cells.iter().flat_map(|cell| cell.points.iter().copied()).collect();
    let hull = Body::new(&all, ground.diagonal * THICKNESS);
    let area: f64 = triangles.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a).length() * 0.5).sum();
    let spacing = ground.limit.max((area / 3000.0).sqrt());
    let mut found = Vec::new();
    let mut owed = 0.5;
    let step = ground.limit * 1.02;
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
    let field = ground.field;
    found.into_par_iter().filter(|p| field.is_beyond(*p, ground.limit)).collect()
}

/// A cover, part after part in one direction.
fn sweep(ground: &Ground, direction: DVec3, mut forbidden: Vec<DVec3>) -> (Vec<Candidate>, Vec<DVec3>) {
    let cells = ground.cells;
    let mut order: Vec<u32> = (0..cells.len() as u32).collect();
    let height = |i: u32| cells[i as usize].centre.dot(direction);
    order.sort_by(|a, b| height(*a).total_cmp(&height(*b)).then(a.cmp(b)));
    let mut covered = Bits::new(cells.len());
    let mut found = Vec::new();
    for seed in order {
        if covered.has(seed as usize) {
            continue;
        }
        let centre = cells[seed as usize].centre;
        let key = |i: u32| {
            let far = if covered.has(i as usize) { 4.0 * ground.diagonal } else { 0.0 };
            Some(cells[i as usize].centre.distance(centre) + far)
        };
        let candidate = ground.grow(&[seed], &key, &mut forbidden).unwrap_or_else(|| ground.part(vec![seed]));
        covered.join(&candidate.covers);
        found.push(candidate);
    }
    (found, forbidden)
}

/// Parts that replace a chosen one each: what only the chosen part covers, and what only one of its
/// neighbours covers.
fn regrow(ground: &Ground, pool: &[Candidate], chosen: &[usize], forbidden: &[DVec3], _round: usize) -> Vec<(Candidate, Vec<DVec3>)> {
    let cells = ground.cells;
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
            cells_of_p.iter().flat_map(|i| &ground.near[*i as usize]).for_each(|i| bits.insert(*i as usize));
            bits
        };
        for (q, part) in chosen.iter().enumerate() {
            if q != p && pool[*part].covers.iter().any(|i| near.has(i)) {
                pairs.push((p, q));
            }
        }
    }
    pairs
        .par_iter()
        .filter_map(|(p, q)| {
            let start = &own[*q];
            if start.is_empty() {
                return None;
            }
            let mut wanted = Bits::new(cells.len());
            own[*p].iter().for_each(|i| wanted.insert(*i as usize));
            let middle = start.iter().map(|i| cells[*i as usize].centre).sum::<DVec3>() / start.len() as f64;
            let key = |i: u32| {
                let far = if wanted.has(i as usize) { 0.0 } else { 4.0 * ground.diagonal };
                Some(cells[i as usize].centre.distance(middle) + far)
            };
            let mut points = forbidden.to_vec();
            let known = points.len();
            let grown = ground.grow(start, &key, &mut points)?;
            Some((grown, points.split_off(known)))
        })
        .collect()
}

/// The points of the chosen parts, each cell in one of them.
fn shrink(ground: &Ground, pool: &[Candidate], chosen: &[usize]) -> Vec<Vec<u32>> {
    let mut count = vec![0_u32; ground.cells.len()];
    for part in chosen {
        pool[*part].covers.iter().for_each(|i| count[i] += 1);
    }
    let mut kept: Vec<Candidate> = Vec::new();
    let mut taken = Bits::new(ground.cells.len());
    for part in chosen {
        let own: Vec<u32> = pool[*part].covers.iter().filter(|i| count[*i] == 1).map(|i| i as u32).collect();
        let core = ground.part(own);
        taken.join(&core.covers);
        kept.push(core);
    }
    let mut left: Vec<usize> = (0..ground.cells.len()).filter(|i| !taken.has(*i)).collect();
    left.sort_by(|a, b| ground.cells[*b].area.total_cmp(&ground.cells[*a].area).then(a.cmp(b)));
    for cell in left {
        if kept.iter().any(|part| part.covers.has(cell)) {
            continue;
        }
        let holders = (0..chosen.len()).filter(|k| pool[chosen[*k]].covers.has(cell));
        if let Some(k) = holders.max_by_key(|k| (kept[*k].members.len(), usize::MAX - *k)) {
            let mut members = kept[k].members.clone();
            members.push(cell as u32);
            kept[k] = ground.part(members);
        }
    }
    kept.into_iter().map(|part| part.members).filter(|members| !members.is_empty()).collect()
}
