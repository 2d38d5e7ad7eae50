//! Peeling: caps are cut off a piece one after the other, each as large as the limit allows.
//!
//! Cuts that halve a piece give powers of two; peeling gives as many parts as are needed. Caps
//! across one direction only are slabs.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::DVec3;
use rayon::prelude::*;

use super::{
    context::Search,
    cuts::{directions, faces, range},
    piece::Piece,
};
use crate::fit::planes::HalfSpace;

/// Number of positions along a direction.
const POSITIONS: usize = 32;

/// Number of caps that are tried, the largest first.
const TRIED: usize = 6;

/// Number of caps from which the number that will be needed is estimated, by their area.
const ENOUGH_TO_TELL: usize = 3;

/// Peeling stops when the estimated number of caps exceeds the allowed number by this factor.
const HOPELESS: f64 = 1.2;

/// The directions in which caps are cut off.
#[derive(Clone, Copy, Debug)]
pub enum Along {
    /// One direction.
    One(DVec3),
    /// All axes, the diagonals between them, and planes of faces at concave edges.
    All,
}

/// The mean area of a cap's components, and its plane.
type Cap = (f64, HalfSpace);

/// The caps and the rest of a piece, at most `most`; `None` if there are more, or the time is over.
pub fn peel(search: &Search, piece: &Piece, along: Along, most: usize) -> Option<Vec<Piece>> {
    let scale = &search.scale;
    let mut rest = piece.atoms.clone();
    let mut planes = piece.planes.clone();
    let mut forbidden = piece.forbidden.clone();
    let mut found: Vec<Piece> = Vec::new();
    loop {
        if search.is_over() {
            return None;
        }
        let pieces = scale.components(&rest).into_iter().map(|atoms| scale.piece(atoms, planes.clone(), &forbidden));
        let (fine, bad): (Vec<Piece>, Vec<Piece>) = pieces.partition(|piece| search.beyond(piece).is_empty());
        found.extend(fine);
        if bad.is_empty() {
            return (found.len() <= most).then_some(found);
        }
        // What is not fine takes two parts at least.
        if found.len() + 2 * bad.len() > most {
            return None;
        }
        // The largest caps come first, so the rest takes more parts than its area suggests.
        let area = |pieces: &[Piece]| pieces.iter().map(Piece::area).sum::<f64>();
        let (done, left) = (area(&found), area(&bad));
        if found.len() >= ENOUGH_TO_TELL && found.len() as f64 * (done + left) > HOPELESS * most as f64 * done {
            return None;
        }
        rest = bad.into_iter().flat_map(|piece| piece.atoms).collect();
        let whole = scale.piece(rest.clone(), Vec::new(), &forbidden);
        let mut caps = caps(search, &whole, along);
        caps.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (below, cap, plane) = caps.into_iter().take(TRIED).find_map(|(_, plane)| {
            let [below, above] = scale.divided(&rest, &plane);
            if below.is_empty() || above.is_empty() {
                return None;
            }
            let back = plane.opposite();
            let inside = [planes.as_slice(), &[back]].concat();
            let cap: Vec<Piece> = scale
                .components(&above)
                .into_iter()
                .map(|atoms| scale.piece(atoms, inside.clone(), &forbidden))
                .collect();
            let beyond: Vec<DVec3> = cap.iter().flat_map(|piece| search.beyond(piece)).collect();
            forbidden.extend_from_slice(&beyond);
            beyond.is_empty().then_some((below, cap, plane))
        })?;
        found.extend(cap);
        planes.push(plane);
        rest = below;
    }
}

/// The largest cap in each direction.
fn caps(search: &Search, whole: &Piece, along: Along) -> Vec<Cap> {
    let scale = &search.scale;
    let near = scale.neighbours(&whole.atoms);
    let area = |plane: &HalfSpace| -> Option<f64> {
        if search.is_over() {
            return None;
        }
        let components = scale.above(&whole.atoms, &near, plane);
        if components.is_empty() || !components.iter().all(|above| scale.is_free(&above.points, &whole.forbidden)) {
            return None;
        }
        Some(components.iter().map(|component| component.area).sum::<f64>() / components.len() as f64)
    };
    let largest = |normal: &DVec3| -> Option<Cap> {
        let (low, high) = range(whole, *normal);
        if high - low < 0.5 * scale.limit {
            return None;
        }
        let at = |k: usize| HalfSpace { normal: *normal, offset: high - (high - low) * k as f64 / POSITIONS as f64 };
        let (mut good, mut bad) = (0, POSITIONS);
        let mut best = None;
        while bad - good > 1 {
            let middle = (good + bad) / 2;
            match area(&at(middle)) {
                Some(area) => (good, best) = (middle, Some((area, at(middle)))),
                None => bad = middle,
            }
        }
        best
    };
    let all = match along {
        Along::One(normal) => vec![normal],
        Along::All => {
            let diagonals = [(FRAC_1_SQRT_2, FRAC_1_SQRT_2), (FRAC_1_SQRT_2, -FRAC_1_SQRT_2)]
                .into_iter()
                .flat_map(|(x, y)| [DVec3::new(x, y, 0.0), DVec3::new(x, 0.0, y), DVec3::new(0.0, x, y)]);
            directions(whole).into_iter().chain(diagonals).flat_map(|normal| [normal, -normal]).collect()
        }
    };
    let mut found: Vec<Cap> = all.par_iter().filter_map(largest).collect();
    if matches!(along, Along::All) {
        let both = |plane: HalfSpace| [plane, plane.opposite()];
        let planes: Vec<HalfSpace> = faces(whole, scale, search.planes).flat_map(both).collect();
        found.extend(planes.into_par_iter().filter_map(|plane| Some((area(&plane)?, plane))).collect::<Vec<_>>());
    }
    found
}
