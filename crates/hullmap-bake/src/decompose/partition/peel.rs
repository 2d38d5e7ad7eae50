//! Peeling: caps are cut off a piece one after the other, each as large as the limit allows.
//!
//! Cuts that halve a piece give powers of two; peeling gives as many parts as are needed. Caps
//! across one direction only are slabs.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::DVec3;
use rayon::prelude::*;

use super::{
    context::PartitionSearch,
    cuts::{directions, faces, range},
    links::Links,
    piece::{Above, Piece},
};
use hullmap_geometry::planes::HalfSpace;

/// Number of positions along a direction.
const POSITIONS: usize = 32;

/// Number of caps that are tried, the largest first.
const TRIED: usize = 6;

/// Number of caps from which the number that will be needed is estimated, by their area.
const ENOUGH_TO_TELL: usize = 3;

/// Peeling stops when the estimated number of caps exceeds the allowed number by this factor.
const MAX_EXCESS: f64 = 1.2;

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
pub fn peel(search: &PartitionSearch, piece: &Piece, along: Along, most: usize) -> Option<Vec<Piece>> {
    let scale = &search.scale;
    let mut rest = piece.clone();
    let mut found: Vec<Piece> = Vec::new();
    loop {
        if search.is_over() {
            return None;
        }
        let planes = rest.planes.clone();
        let mut known = rest.forbidden.clone();
        let (fine, bad): (Vec<Piece>, Vec<Piece>) =
            scale.parted(rest).into_iter().partition(|piece| search.beyond(piece).is_empty());
        found.extend(fine);
        if bad.is_empty() {
            return (found.len() <= most).then_some(found);
        }
        // Each remaining piece takes at least two parts.
        if found.len() + 2 * bad.len() > most {
            return None;
        }
        // The largest caps come first, so the rest takes more parts than its area suggests.
        let area = |pieces: &[Piece]| pieces.iter().map(Piece::area).sum::<f64>();
        let (done, left) = (area(&found), area(&bad));
        if found.len() >= ENOUGH_TO_TELL && found.len() as f64 * (done + left) > MAX_EXCESS * most as f64 * done {
            return None;
        }
        let corners = bad.iter().flat_map(|piece| &piece.corners).copied().collect();
        let atoms = bad.into_iter().flat_map(|piece| piece.atoms).collect();
        let whole = scale.piece(atoms, corners, planes, &known);
        let mut caps = Caps::new(search, &whole, along);
        let (below, cap) = (0..TRIED).map_while(|_| caps.next()).find_map(|plane| {
            let [below, above] = scale.cut(&whole, &plane)?;
            let cap = scale.parted(above);
            let beyond: Vec<DVec3> = cap.iter().flat_map(|piece| search.beyond(piece)).collect();
            known.extend_from_slice(&beyond);
            beyond.is_empty().then_some((below, cap))
        })?;
        found.extend(cap);
        let forbidden = known.into_iter().filter(|p| scale.is_inside(&below.body, *p)).collect();
        rest = Piece { forbidden, ..below };
    }
}

struct Line {
    normal: DVec3,
    low: f64,
    high: f64,
    /// Number of equal steps between the two heights.
    count: usize,
    /// The lowest position that gives a cap, and the highest that gives none, from the top.
    good: usize,
    bad: usize,
    best: Option<Cap>,
    /// Upper bound on the mean area of a cap's components.
    most: f64,
}

impl Line {
    fn new(normal: DVec3, low: f64, high: f64, count: usize) -> Self {
        Self { normal, low, high, count, good: 0, bad: count, best: None, most: f64::INFINITY }
    }

    fn plane(&self, position: usize) -> HalfSpace {
        let share = position as f64 / self.count as f64;
        HalfSpace { normal: self.normal, offset: self.high - (self.high - self.low) * share }
    }

    fn is_done(&self) -> bool {
        self.bad - self.good <= 1
    }

    fn area(&self) -> f64 {
        self.best.map_or(0.0, |(area, _)| area)
    }
}

/// The caps of a piece, the largest first. A line is searched only as far as its cap may be the
/// largest.
struct Caps<'a> {
    search: &'a PartitionSearch<'a>,
    whole: &'a Piece,
    near: Links,
    lines: Vec<Line>,
}

impl<'a> Caps<'a> {
    fn new(search: &'a PartitionSearch, whole: &'a Piece, along: Along) -> Self {
        let scale = &search.scale;
        let all = match along {
            Along::One(normal) => vec![normal],
            Along::All => {
                let diagonals = [(FRAC_1_SQRT_2, FRAC_1_SQRT_2), (FRAC_1_SQRT_2, -FRAC_1_SQRT_2)]
                    .into_iter()
                    .flat_map(|(x, y)| [DVec3::new(x, y, 0.0), DVec3::new(x, 0.0, y), DVec3::new(0.0, x, y)]);
                directions(whole).into_iter().chain(diagonals).flat_map(|normal| [normal, -normal]).collect()
            }
        };
        let of_direction = |normal: DVec3| {
            let (low, high) = range(whole, normal);
            (high - low >= 0.5 * scale.limit).then(|| Line::new(normal, low, high, POSITIONS))
        };
        let mut lines: Vec<Line> = all.into_iter().filter_map(of_direction).collect();
        if matches!(along, Along::All) {
            // Both sides of each plane, the only position of its line.
            let both = faces(search, whole).flat_map(|plane| [plane, plane.opposite()]);
            lines.extend(both.map(|plane| Line::new(plane.normal, plane.offset, plane.offset, 2)));
        }
        let mut caps = Self { search, whole, near: scale.links(&whole.atoms), lines };
        let most: Vec<f64> = caps.lines.par_iter().map(|line| caps.most(line)).collect();
        caps.lines.iter_mut().zip(most).for_each(|(line, most)| line.most = most);
        caps
    }

    /// Upper bound on the area of a line's cap.
    fn most(&self, line: &Line) -> f64 {
        if line.is_done() {
            line.area()
        } else {
            self.search.scale.area_above(&self.whole.atoms, &line.plane(line.bad - 1))
        }
    }

    fn area(&self, plane: &HalfSpace) -> Option<f64> {
        let scale = &self.search.scale;
        if self.search.is_over() {
            return None;
        }
        let components = scale.above(&self.whole.atoms, &self.near, plane);
        let is_free = |above: &Above| scale.is_free(&above.points, &self.whole.forbidden);
        if components.is_empty() || !components.iter().all(is_free) {
            return None;
        }
        Some(components.iter().map(|component| component.area).sum::<f64>() / components.len() as f64)
    }

    fn halve(&self, line: &mut Line) {
        let middle = (line.good + line.bad) / 2;
        let plane = line.plane(middle);
        match self.area(&plane) {
            Some(area) => (line.good, line.best) = (middle, Some((area, plane))),
            None => line.bad = middle,
        }
        line.most = self.most(line);
    }

    /// The largest of the remaining caps; of equally large ones, the cap of the first line.
    fn next(&mut self) -> Option<HalfSpace> {
        loop {
            let largest = self.lines.iter().map(Line::area).fold(0.0, f64::max);
            let mut lines = std::mem::take(&mut self.lines);
            let open: Vec<&mut Line> =
                lines.iter_mut().filter(|line| !line.is_done() && line.most >= largest).collect();
            let is_found = open.is_empty();
            open.into_par_iter().for_each(|line| self.halve(line));
            self.lines = lines;
            if is_found {
                let first = self.lines.iter().position(|line| line.best.is_some() && line.area() == largest)?;
                return self.lines.remove(first).best.map(|(_, plane)| plane);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use shapes::concave;

    use super::*;
    use crate::decompose::partition::cuts::tests::{gear, with_search};

    #[test]
    fn caps_come_by_size() {
        let (mut found, mut open) = (0, 0);
        for (mesh, share) in [
            (gear(9, 0.4), 0.02),
            (concave::bowl(24, 8), 0.02),
            (concave::mug(24), 0.02),
            (concave::spiral_stair(9), 0.01),
        ] {
            with_search(&mesh, share, |search, piece| {
                for along in [Along::All, Along::One(DVec3::X)] {
                    let (mut caps, mut all) = (Caps::new(search, piece, along), Caps::new(search, piece, along));
                    let mut lines = std::mem::take(&mut all.lines);
                    for line in &mut lines {
                        while !line.is_done() {
                            let most = line.most;
                            all.halve(line);
                            assert!(line.area() <= most * (1.0 + 1e-12));
                        }
                    }
                    let mut expected: Vec<f64> = lines.iter().map(Line::area).filter(|area| *area > 0.0).collect();
                    expected.sort_by(|a, b| b.total_cmp(a));
                    for area in expected.into_iter().take(TRIED) {
                        let next = caps.next().and_then(|plane| caps.area(&plane)).unwrap_or_default();
                        assert!((next - area).abs() <= 1e-12 * area, "{next} instead of {area}");
                        found += 1;
                    }
                    open += caps.lines.iter().filter(|line| !line.is_done()).count();
                }
            });
        }
        assert!(found > 15 && open > 15, "the sample is not representative: {found} caps, {open} lines");
    }
}
