//! Features: what stands out of a piece between two parallel concave edges, such as the teeth of a
//! gear. Each is cut off as a whole at the plane of both edges, so that equal features become equal
//! parts. Cuts through the whole piece would divide its neighbours, too.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use super::{context::PartitionSearch, links::Links, piece::Piece, shape::Part};
use crate::symmetry::Mirror;
use hullmap_geometry::{bits, planes::HalfSpace};

/// Number of the nearest parallel edges with which an edge is paired.
const PARTNERS: usize = 4;

/// Maximum number of edges. More belong to smooth surfaces, and the time grows with their square.
const MAX_EDGES: usize = 400;

/// Sine of the angle between edges up to which they are parallel.
const PARALLEL: f64 = 0.02;

/// Share of a piece's area that a feature has at most.
const MOST: f64 = 0.4;

/// Two parallel edges. The second is `None` for the image of a piece's edge.
pub struct Pair {
    plane: HalfSpace,
    edges: [Option<[DVec3; 2]>; 2],
}

/// The parts of a piece whose rest without its features is a part: the features and the rest.
/// `None` if they are not fewer than `count`.
///
/// # Complexity
/// O(m n) for n atoms and m pairs.
pub fn parts(search: &PartitionSearch, piece: &Piece, pairs: &[Pair], count: usize) -> Option<Vec<Part>> {
    let pieces = if count > 3 { features(search, piece, pairs) } else { Vec::new() };
    let is_fewer = (1..count).contains(&pieces.len());
    is_fewer.then(|| pieces.par_iter().map(|piece| search.shaped(piece).ok()).collect()).flatten()
}

/// The features of a piece, the largest first, and the rest; nothing if there is at most one, or if
/// the rest is no part: where planes cut it further, they would not know that features bound it.
fn features(search: &PartitionSearch, piece: &Piece, pairs: &[Pair]) -> Vec<Piece> {
    let (mut found, mut rest) = (Vec::new(), Rest::new(search, piece.clone()));
    loop {
        let before = found.len();
        let area = |pair: &Pair| rest.feature(pair).map(|(area, _)| area);
        let mut all: Vec<(f64, &Pair)> = pairs.par_iter().filter_map(|pair| Some((area(pair)?, pair))).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, pair) in all {
            let Some((_, is_own)) = rest.feature(pair) else { continue };
            let Some([feature, below]) = search.scale.cut_off(&rest.piece, &pair.plane, &is_own) else { continue };
            if search.beyond(&feature).is_empty() {
                found.push(feature);
                rest = Rest::new(search, below);
            }
        }
        if search.is_over() {
            return Vec::new();
        }
        if found.len() == before {
            break;
        }
    }
    let rest = rest.piece;
    if found.len() < 2 || !search.beyond(&rest).is_empty() {
        return Vec::new();
    }
    found.push(rest);
    found
}

/// Each edge with the nearest parallel ones, and both sides of their planes.
pub fn pairs(edges: &[[DVec3; 2]], mirrors: &[Mirror]) -> Vec<Pair> {
    if edges.len() > MAX_EDGES {
        return Vec::new();
    }
    let along = |[a, b]: [DVec3; 2]| (b - a).normalize_or_zero();
    let middle = |[a, b]: [DVec3; 2]| a.midpoint(b);
    let images = mirrors.iter().flat_map(|mirror| edges.iter().map(|edge| (edge.map(|p| mirror.image(p)), false)));
    let all: Vec<([DVec3; 2], bool)> = edges.iter().map(|edge| (*edge, true)).chain(images).collect();
    let of_edge = |edge: [DVec3; 2]| {
        let apart = |other: [DVec3; 2]| (middle(other) - middle(edge)).reject_from(along(edge));
        let is_other = |other: [DVec3; 2]| {
            along(edge).cross(along(other)).length() < PARALLEL
                && apart(other).length() > PARALLEL * edge[0].distance(edge[1])
        };
        let others = all.iter().filter(|(other, _)| is_other(*other));
        let mut others: Vec<(f64, [DVec3; 2], bool)> =
            others.map(|(other, is_own)| (middle(*other).distance(middle(edge)), *other, *is_own)).collect();
        others.sort_by(|a, b| a.0.total_cmp(&b.0));
        others.truncate(PARTNERS);
        let pair = move |(_, other, is_own): (f64, [DVec3; 2], bool)| {
            let normal = along(edge).cross(apart(other)).try_normalize()?;
            let plane = HalfSpace { normal, offset: normal.dot(edge[0]) };
            let edges = [Some(edge), is_own.then_some(other)];
            Some([plane, plane.opposite()].map(|plane| Pair { plane, edges }))
        };
        others.into_iter().filter_map(pair).flatten().collect::<Vec<Pair>>()
    };
    edges.iter().copied().flat_map(of_edge).collect()
}

/// The rest of a piece, and the neighbours of its atoms and corners.
struct Rest<'a> {
    search: &'a PartitionSearch<'a>,
    piece: Piece,
    links: Links,
    atoms_at: HashMap<[u64; 3], Vec<u32>>,
}

impl<'a> Rest<'a> {
    fn new(search: &'a PartitionSearch, piece: Piece) -> Self {
        let mut atoms_at: HashMap<[u64; 3], Vec<u32>> = HashMap::new();
        for (index, atom) in (0..).zip(&piece.atoms) {
            atom.patch.points.iter().for_each(|p| atoms_at.entry(bits(*p)).or_default().push(index));
        }
        Self { search, links: search.scale.links(&piece.atoms), piece, atoms_at }
    }

    /// The area of the feature above a plane at its edges, and which atoms belong to it; `None` if
    /// it is no part, or needs none.
    fn feature(&self, Pair { plane, edges }: &Pair) -> Option<(f64, Vec<bool>)> {
        let Self { search, piece, links, .. } = self;
        let scale = &search.scale;
        let at = |p: &DVec3| self.atoms_at.get(&bits(*p)).map_or(&[][..], Vec::as_slice);
        if search.is_over() || edges.iter().flatten().flatten().any(|p| at(p).is_empty()) {
            return None;
        }
        let components = scale.components_above(&piece.atoms, links, plane);
        let of = |edge: &[DVec3; 2]| edge.iter().flat_map(at).map(|atom| components[*atom as usize]).collect();
        let [first, second]: [Option<Vec<u32>>; 2] = edges.each_ref().map(|edge| edge.as_ref().map(of));
        let is_both = |component: &u32| second.as_ref().is_none_or(|second| second.contains(component));
        let own = first?.into_iter().find(|component| *component != u32::MAX && is_both(component))?;
        let above = scale.above(&piece.atoms, links, plane).into_iter().nth(own as usize)?;
        let is_high = above.points.points().any(|p| plane.height(p) > scale.limit);
        let is_part = above.area <= MOST * piece.area() && is_high && scale.is_free(&above.points, &piece.forbidden);
        is_part.then(|| (above.area, components.iter().map(|component| *component == own).collect()))
    }
}
