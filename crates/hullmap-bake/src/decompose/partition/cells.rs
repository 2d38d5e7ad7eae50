//! Cells: small pieces of the mesh's surface, of which parts are made.
//!
//! # Steps
//! 1. Start with all triangles as one piece. Find the concave edges: those whose faces lie in front
//!    of each other.
//! 2. A piece whose hull stays near the solid is a cell.
//! 3. Split any other piece into its connected components. If it is connected, cut it by a plane:
//!    of a face at a concave edge, between two such faces, or across the piece's box. Among a few
//!    candidates, choose the plane that leaves the least volume in the hulls of both sides.
//! 4. Split a piece that cannot be cut any more into its polygons, which protrude nowhere.
//!
//! Triangles are clipped, never replaced, so a hull of whole cells covers their polygons.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::body::{Body, THICKNESS};
use super::field::Field;
use super::wrap;
use crate::decompose::patch::Patch;
use crate::fit::triangle_tree::{Bounds, TriangleTree};
use crate::hull;
use hullmap_geometry::planes::{self, HalfSpace};

/// Maximum number of cuts that lead to a cell.
const MAX_DEPTH: u32 = 40;

/// Maximum number of polygons by which a trial cut is judged.
const TRIAL_POLYGONS: usize = 200;

/// Maximum number of corners by which a large piece is tested before its hull is built.
const MAX_SAMPLED: usize = 200;

/// Maximum number of corners of a piece whose hull is built. A larger piece is cut without a test.
const MAX_CORNERS: usize = 20_000;

/// Sine of the angle at which faces must lie in front of each other for their edge to be concave.
const CONCAVE: f64 = 0.02;

/// Share of the concave edges that must lie in a plane for it to be chosen without a trial.
const DECISIVE: f64 = 0.3;

/// A later candidate is better if it leaves less than this share of the least volume so far.
const BETTER: f64 = 0.97;

/// Distance from a plane up to which a corner lies in it, relative to the diagonal.
const IN_PLANE: f64 = 1e-9;

#[derive(Clone, Debug)]
struct Edge {
    ends: [DVec3; 2],
    planes: [HalfSpace; 2],
    sine: f64,
}

#[derive(Clone, Debug, Default)]
struct Piece {
    corners: Vec<DVec3>,
    ends: Vec<u32>,
    normals: Vec<DVec3>,
    edges: Vec<Edge>,
}

impl Piece {
    fn new(triangles: &[[DVec3; 3]], diagonal: f64) -> Self {
        let mut piece = Self::default();
        for t in triangles {
            piece.push(t, (t[1] - t[0]).cross(t[2] - t[0]).normalize_or_zero());
        }
        piece.edges = concave_edges(triangles, diagonal);
        piece
    }

    fn face_planes(&self) -> FacePlanes {
        let of_polygon = |(corners, normal): (&[DVec3], DVec3)| {
            let area: f64 = planes::fan(corners).iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a).length()).sum();
            (area, HalfSpace { normal, offset: normal.dot(corners[0]) }, corners[0])
        };
        let all = grouped(self, self.polygons().map(of_polygon).filter(|(area, ..)| *area > 0.0));
        let total: f64 = all.iter().map(|(area, _)| area).sum();
        let large = all.into_iter().take_while(|(area, _)| *area >= LARGE * total).map(|(_, plane)| plane).collect();
        FacePlanes { concave: ranked(self).into_iter().map(|(_, plane)| plane).collect(), large }
    }

    fn polygons(&self) -> impl Iterator<Item = (&[DVec3], DVec3)> {
        (0..self.ends.len()).map(|i| self.polygon(i))
    }

    fn polygon(&self, i: usize) -> (&[DVec3], DVec3) {
        let start = if i == 0 { 0 } else { self.ends[i - 1] as usize };
        (&self.corners[start..self.ends[i] as usize], self.normals[i])
    }

    fn push(&mut self, corners: &[DVec3], normal: DVec3) {
        self.corners.extend_from_slice(corners);
        self.ends.push(self.corners.len() as u32);
        self.normals.push(normal);
    }

    /// Standard deviation of the normals along each axis.
    fn spread(&self) -> DVec3 {
        let (mut sum, mut squares, mut total) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for (corners, normal) in self.polygons() {
            let area: f64 = (1..corners.len() - 1)
                .map(|i| (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]).length())
                .sum();
            sum += normal * area;
            squares += normal * normal * area;
            total += area;
        }
        let mean = sum / total;
        let variance = (squares / total - mean * mean).max(DVec3::ZERO);
        DVec3::new(variance.x.sqrt(), variance.y.sqrt(), variance.z.sqrt())
    }

    fn split(&self, plane: &HalfSpace, slack: f64, stride: usize) -> [Self; 2] {
        let mut sides = [Self::default(), Self::default()];
        let mut halves = [Vec::new(), Vec::new()];
        for (corners, normal) in (0..self.ends.len()).step_by(stride).map(|i| self.polygon(i)) {
            clip(corners, plane, slack, &mut halves);
            match [halves[0].len() >= 3, halves[1].len() >= 3] {
                [true, true] => (0..2).for_each(|k| sides[k].push(&halves[k], normal)),
                [true, false] => sides[0].push(corners, normal),
                [false, true] => sides[1].push(corners, normal),
                // In the plane: the solid is behind the polygon.
                [false, false] => sides[usize::from(normal.dot(plane.normal) < 0.0)].push(corners, normal),
            }
        }
        for edge in &self.edges {
            let heights = edge.ends.map(|p| plane.height(p));
            for (k, sign) in [(0, 1.0), (1, -1.0)] {
                let h = heights.map(|h| h * sign);
                if h[0].max(h[1]) <= slack && h[0].min(h[1]) < -slack {
                    sides[k].edges.push(edge.clone());
                } else if h[0].min(h[1]) < -slack {
                    let t = h[0] / (h[0] - h[1]);
                    let cut = edge.ends[0].lerp(edge.ends[1], t);
                    let ends = if h[0] < 0.0 { [edge.ends[0], cut] } else { [cut, edge.ends[1]] };
                    sides[k].edges.push(Edge { ends, ..edge.clone() });
                }
            }
        }
        sides
    }

    /// The connected components: polygons that share edges.
    fn components(&self, slack: f64) -> Vec<Self> {
        let count = self.ends.len();
        let key = |p: DVec3| (p + DVec3::ZERO).to_array().map(f64::to_bits);
        let mut sides: Vec<([[u64; 3]; 2], u32)> = Vec::with_capacity(self.corners.len());
        for (i, (corners, _)) in self.polygons().enumerate() {
            for (k, p) in corners.iter().enumerate() {
                let (a, b) = (key(*p), key(corners[(k + 1) % corners.len()]));
                sides.push((if a < b { [a, b] } else { [b, a] }, i as u32));
            }
        }
        sides.sort_unstable();
        let mut root: Vec<u32> = (0..count as u32).collect();
        for pair in sides.windows(2) {
            if pair[0].0 == pair[1].0 {
                let (a, b) = (find(&mut root, pair[0].1), find(&mut root, pair[1].1));
                let (low, high) = (a.min(b), a.max(b));
                root[high as usize] = low;
            }
        }
        let mut piece_of = vec![u32::MAX; count];
        let mut pieces: Vec<Self> = Vec::new();
        for i in 0..count {
            let r = find(&mut root, i as u32) as usize;
            if piece_of[r] == u32::MAX {
                piece_of[r] = pieces.len() as u32;
                pieces.push(Self::default());
            }
            let (corners, normal) = self.polygon(i);
            pieces[piece_of[r] as usize].push(corners, normal);
        }
        if pieces.len() == 1 {
            pieces[0].edges.clone_from(&self.edges);
        } else {
            // Cuts of edges and of polygons differ by rounding.
            let boxes: Vec<Bounds> = pieces
                .iter()
                .map(|piece| super::body::bounds(&piece.corners))
                .map(|(low, high)| Bounds { low: low - DVec3::splat(slack), high: high + DVec3::splat(slack) })
                .collect();
            let tree = TriangleTree::of_boxes(boxes.into_iter());
            for edge in &self.edges {
                tree.for_each(
                    |bounds| edge.ends.iter().all(|p| bounds.contains(*p)),
                    |piece| pieces[piece as usize].edges.push(edge.clone()),
                );
            }
        }
        pieces
    }
}

fn find(root: &mut [u32], mut i: u32) -> u32 {
    while root[i as usize] != i {
        let above = root[root[i as usize] as usize];
        root[i as usize] = above;
        i = above;
    }
    i
}

fn clip(corners: &[DVec3], plane: &HalfSpace, slack: f64, halves: &mut [Vec<DVec3>; 2]) {
    let [below, above] = halves;
    below.clear();
    above.clear();
    let (mut is_below, mut is_above) = (false, false);
    for (k, p) in corners.iter().enumerate() {
        let q = corners[(k + 1) % corners.len()];
        let (h, g) = (plane.height(*p), plane.height(q));
        if h <= slack {
            below.push(*p);
            is_below |= h < -slack;
        }
        if h >= -slack {
            above.push(*p);
            is_above |= h > slack;
        }
        if h.abs() > slack && g.abs() > slack && (h < 0.0) != (g < 0.0) {
            // From below, so that both polygons of an edge are cut at the same point.
            let cut = if h < 0.0 { p.lerp(q, h / (h - g)) } else { q.lerp(*p, g / (g - h)) };
            below.push(cut);
            above.push(cut);
        }
    }
    if !is_below {
        below.clear();
    }
    if !is_above {
        above.clear();
    }
}

/// Limits of the cells.
#[derive(Clone, Copy, Debug)]
pub struct Cutting<'a> {
    /// Maximum distance of a cell's hull from the solid, as far as samples show.
    pub limit: f64,
    /// The limits of a cell's hull that are proven, and when to stop.
    pub hard: wrap::HullLimits<'a>,
    /// Number of cells above which only what protrudes beyond `hard` is cut.
    pub max_cells: usize,
}

/// The cells of a surface.
pub struct Cells {
    /// The cells.
    pub cells: Vec<Patch>,
    /// Planes that may divide pieces.
    pub planes: FacePlanes,
}

/// Planes of faces that may divide pieces.
#[derive(Debug, Default)]
pub struct FacePlanes {
    /// Planes of faces at concave edges, the longest and sharpest edges first.
    pub concave: Vec<HalfSpace>,
    /// Planes of large faces, the largest first. Where shells touch, there are no concave edges.
    pub large: Vec<HalfSpace>,
}

impl FacePlanes {
    /// Planes of a surface's faces.
    pub fn new(triangles: &[[DVec3; 3]], diagonal: f64) -> Self {
        Piece::new(triangles, diagonal).face_planes()
    }
}

/// The cells of a surface; `None` if the time is over before they are found.
pub fn cells(triangles: &[[DVec3; 3]], field: &Field, cutting: &Cutting) -> Option<Cells> {
    let root = Piece::new(triangles, cutting.hard.diagonal);
    let planes = root.face_planes();
    // Level by level, so that pieces are independent of each other.
    let mut level = vec![(root, 0_u32)];
    let mut cells = Vec::new();
    while !level.is_empty() {
        let budget = cutting.max_cells.saturating_sub(cells.len() + level.len());
        let step = |(piece, depth)| (!cutting.hard.is_over()).then(|| step(piece, depth, field, cutting, budget > 0));
        let next: Option<Vec<Step>> = level.into_par_iter().map(step).collect();
        let next = next?;
        level = Vec::new();
        for outcome in next {
            match outcome {
                Ok(pieces) => level.extend(pieces),
                Err(found) => cells.extend(found),
            }
        }
    }
    Some(Cells { cells, planes })
}

type Step = Result<Vec<(Piece, u32)>, Vec<Patch>>;

fn step(piece: Piece, depth: u32, field: &Field, cutting: &Cutting, may_cut: bool) -> Step {
    let thickness = cutting.hard.diagonal * THICKNESS;
    let is_large = piece.corners.len() > MAX_CORNERS;
    let limit = if may_cut { cutting.limit } else { cutting.hard.limit };
    // If the hull of some corners protrudes, so does the hull of all.
    let is_refuted = piece.corners.len() > 2 * MAX_SAMPLED && {
        let stride = piece.corners.len().div_ceil(MAX_SAMPLED);
        let some: Vec<DVec3> = piece.corners.iter().step_by(stride).copied().collect();
        let body = Body::new(&some, thickness);
        super::sample::face_points(&body, 96, limit).into_iter().any(|p| field.is_beyond(p, limit))
    };
    if !is_large && !is_refuted {
        let body = Body::new(&piece.corners, thickness);
        if !protrudes(&piece, &body, field, limit) && (piece.ends.len() == 1 || is_proven(&body, field, cutting)) {
            return Err(vec![cell(&piece, &body)]);
        }
    }
    if piece.ends.len() == 1 || depth >= if may_cut { MAX_DEPTH } else { MAX_DEPTH / 2 } {
        return Err(polygons(&piece, cutting));
    }
    let slack = IN_PLANE * cutting.hard.diagonal;
    let components = piece.components(slack);
    if components.len() > 1 {
        return Ok(components.into_iter().map(|piece| (piece, depth)).collect());
    }
    match plane(&piece, slack, thickness) {
        Some(plane) => {
            let [below, above] = piece.split(&plane, slack, 1);
            if below.ends.is_empty() || above.ends.is_empty() {
                return Err(polygons(&piece, cutting));
            }
            Ok(vec![(below, depth + 1), (above, depth + 1)])
        }
        None => Err(polygons(&piece, cutting)),
    }
}

fn cell(piece: &Piece, body: &Body) -> Patch {
    Patch { polygons: piece.polygons().map(|(corners, _)| corners.to_vec()).collect(), points: body.points.clone() }
}

fn polygons(piece: &Piece, cutting: &Cutting) -> Vec<Patch> {
    let one = |(corners, normal): (&[DVec3], DVec3)| {
        let mut single = Piece::default();
        single.push(corners, normal);
        cell(&single, &Body::new(corners, cutting.hard.diagonal * THICKNESS))
    };
    piece.polygons().map(one).collect()
}

/// Maximum number of polygons of a piece in front of which its hull is sampled.
const RAYS: usize = 64;

/// Whether a sample of a piece's hull, in front of its polygons or on the largest faces of the
/// hull, is farther than `limit` from the solid.
fn protrudes(piece: &Piece, body: &Body, field: &Field, limit: f64) -> bool {
    let stride = piece.ends.len().div_ceil(RAYS).max(1);
    for (corners, normal) in (0..piece.ends.len()).step_by(stride).map(|i| piece.polygon(i)) {
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        for direction in [normal, -normal] {
            let exit = body.exit(middle, direction);
            if exit > limit && [0.5, 1.0].iter().any(|t| field.is_beyond(middle + direction * (exit * t), limit)) {
                return true;
            }
        }
    }
    super::sample::face_points(body, 96, limit).into_iter().any(|p| field.is_beyond(p, limit))
}

/// Maximum number of measurements by which a cell is proven.
const MEASUREMENTS: usize = 4_000;

fn is_proven(body: &Body, field: &Field, cutting: &Cutting) -> bool {
    let rounded = body.points.iter().map(|p| p.as_vec3().to_array().map(|c| c + 0.0)).collect();
    hull::of_positions(rounded).is_some_and(|hull| wrap::prove(field, &hull, &cutting.hard, MEASUREMENTS).is_ok())
}

fn plane(piece: &Piece, slack: f64, thickness: f64) -> Option<HalfSpace> {
    let (low, high) = super::body::bounds(&piece.corners);
    let size = high - low;
    let diagonal = size.length();
    let ranked = ranked(piece);
    // Each edge has two planes.
    let total = 0.5 * ranked.iter().map(|(weight, _)| weight).sum::<f64>();
    // A plane at the border of the piece cuts nothing.
    let is_inner = |plane: &HalfSpace| {
        let heights = || piece.corners.iter().map(|p| plane.height(*p));
        heights().fold(f64::INFINITY, f64::min) < -1e-4 * diagonal
            && heights().fold(f64::NEG_INFINITY, f64::max) > 1e-4 * diagonal
    };
    let mut candidates: Vec<(f64, HalfSpace)> =
        ranked.into_iter().take(24).filter(|(_, plane)| is_inner(plane)).take(4).collect();
    if let Some((weight, plane)) = candidates.first()
        && *weight >= DECISIVE * total
    {
        return Some(*plane);
    }
    candidates.truncate(3);
    let middle = (low + high) * 0.5;
    let mut first: Vec<(f64, HalfSpace)> = Vec::new();
    // Between the faces at the edge in the middle.
    let from_middle = |edge: &&Edge| edge.ends.iter().map(|p| p.distance_squared(middle)).fold(f64::INFINITY, f64::min);
    let central = piece.edges.iter().min_by(|a, b| from_middle(a).total_cmp(&from_middle(b)));
    if let Some(Edge { ends, planes, .. }) = central {
        let normal = (planes[0].normal - planes[1].normal).normalize_or_zero();
        let plane = HalfSpace { normal, offset: normal.dot(ends[0]) };
        if normal != DVec3::ZERO && is_inner(&plane) {
            first.push((0.0, plane));
        }
    }
    // Across the axes along which the piece bends most.
    let bends = (piece.spread() * size).to_array();
    let mut axes: Vec<(f64, DVec3)> = bends.into_iter().zip([DVec3::X, DVec3::Y, DVec3::Z]).collect();
    axes.sort_by(|a, b| b.0.total_cmp(&a.0));
    let most = axes.first().map_or(0.0, |axis| axis.0);
    for (bend, normal) in axes {
        if bend >= 0.4 * most && normal.dot(size) > 1e-3 * diagonal {
            first.push((0.0, HalfSpace { normal, offset: normal.dot(middle) }));
        }
    }
    first.append(&mut candidates);
    let candidates = first;
    let stride = piece.ends.len().div_ceil(TRIAL_POLYGONS).max(1);
    let cost = |plane: &HalfSpace| -> f64 {
        let sides = piece.split(plane, slack, stride);
        if sides.iter().any(|side| side.ends.is_empty()) {
            return f64::INFINITY;
        }
        sides.iter().map(|side| Body::new(&side.corners, thickness).volume()).sum()
    };
    let mut best: Option<(f64, HalfSpace)> = None;
    for (_, plane) in candidates {
        let cost = cost(&plane);
        if cost.is_finite() && best.is_none_or(|(least, _)| cost < BETTER * least) {
            best = Some((cost, plane));
        }
    }
    best.map(|(_, plane)| plane)
}

/// Share of the area of all faces from which faces in one plane count as large.
const LARGE: f64 = 0.005;

/// Planes of faces at concave edges, weighted by the edges' lengths and sines, the greatest first.
fn ranked(piece: &Piece) -> Vec<(f64, HalfSpace)> {
    let weight = |edge: &Edge| edge.ends[0].distance(edge.ends[1]) * edge.sine;
    grouped(piece, piece.edges.iter().flat_map(|edge| edge.planes.map(|plane| (weight(edge), plane, edge.ends[0]))))
}

/// Planes with their weights and a point of each, the greatest weight first. Planes that nearly
/// agree are one.
fn grouped(piece: &Piece, planes: impl Iterator<Item = (f64, HalfSpace, DVec3)>) -> Vec<(f64, HalfSpace)> {
    let (low, high) = super::body::bounds(&piece.corners);
    let diagonal = low.distance(high);
    let mut groups: BTreeMap<[i32; 4], (f64, HalfSpace)> = BTreeMap::new();
    for (weight, plane, at) in planes {
        // One sign for both sides of a plane.
        let sign = if plane.normal.dot(DVec3::new(1.0, 0.618, 0.381)) < 0.0 { -1.0 } else { 1.0 };
        let n = plane.normal * sign;
        let key = [n.x * 64.0, n.y * 64.0, n.z * 64.0, n.dot(at - low) / diagonal * 512.0].map(|x| x.round() as i32);
        groups.entry(key).or_insert((0.0, HalfSpace { normal: n, offset: n.dot(at) })).0 += weight;
    }
    let mut ranked: Vec<(f64, HalfSpace)> = groups.into_values().collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    ranked
}

fn concave_edges(triangles: &[[DVec3; 3]], diagonal: f64) -> Vec<Edge> {
    let key = |p: DVec3| (p + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut sides: Vec<([[u64; 3]; 2], u32, u32)> = Vec::with_capacity(3 * triangles.len());
    for (i, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (key(t[k]), key(t[(k + 1) % 3]));
            if a != b {
                sides.push((if a < b { [a, b] } else { [b, a] }, i as u32, k as u32));
            }
        }
    }
    sides.sort_unstable();
    let mut edges = Vec::new();
    for run in sides.chunk_by(|a, b| a.0 == b.0) {
        // An edge of more than two faces is not an edge of a solid.
        if run.len() < 2 || run.len() > 8 {
            continue;
        }
        for (i, first) in run.iter().enumerate() {
            for second in &run[i + 1..] {
                let (t, u) = (triangles[first.1 as usize], triangles[second.1 as usize]);
                let normal = |t: [DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).normalize_or_zero();
                let (n, m) = (normal(t), normal(u));
                let (a, b) = (t[first.2 as usize], t[(first.2 as usize + 1) % 3]);
                let apex = u[(second.2 as usize + 2) % 3];
                let away = (apex - a).reject_from_normalized((b - a).normalize_or_zero());
                let sine = n.dot(away) / away.length();
                // Written so that NaN is not concave.
                if !(sine > CONCAVE) || a.distance(b) <= 1e-9 * diagonal {
                    continue;
                }
                let plane = |n: DVec3| HalfSpace { normal: n, offset: n.dot(a) };
                edges.push(Edge { ends: [a, b], planes: [plane(n), plane(m)], sine });
            }
        }
    }
    edges.retain(|edge| edge.planes.iter().all(|plane| plane.normal != DVec3::ZERO));
    edges
}
