//! Fills voids: parts absorb what they leave of the solid, or it gets parts of its own.
//!
//! # Steps
//! 1. Find what is left, as convex pieces ([`remainder`]).
//! 2. Give each piece to the nearest part. The hull of both replaces the part if it is proven, and
//!    adds little volume besides. Otherwise, try with the nearer half of the pieces, and so on.
//! 3. The hull of all other pieces becomes a part if it is proven, and adds little volume besides,
//!    or stands for many pieces. Otherwise, divide them in the middle of the longest side. A single
//!    piece protrudes nowhere.
//! 4. Join new parts in pairs, the cheapest in volume first, under the same conditions.
//! 5. Repeat with the hulls that are stored, until nothing is left.
//!
//! Why it is proven: step 1 measures the stored hulls. If it finds nothing, every point of the
//! solid is in a part, grown by [`GROWN`](crate::fit::remainder::GROWN). Parts that grow keep what
//! they contained.

use glam::DVec3;

use super::{
    part::SourceVertices,
    partition::{
        body::{Body, bounds, longest},
        few,
        field::Field,
        wrap::{self, HullLimits},
    },
};
use crate::{
    fit::{
        remainder::{Remnant, remainder},
        solid::Solid,
    },
    hull::Hull,
    mass,
};

/// Maximum number of times that what is left is measured and filled.
const ROUNDS: usize = 6;

/// Number of new parts up to which all pairs are compared to join them.
const FEW: usize = 48;

/// Number of pieces from which their hull may overlap parts by more than allowed: otherwise, each
/// becomes a part.
const MANY_PIECES: usize = 8;

/// Maximum number of hulls that are tried for one part in a round.
const TRIALS: usize = 24;

pub struct Filling<'a, 'b> {
    /// From where protrusion counts.
    pub field: &'a Field<'a>,
    pub solid: &'a Solid,
    pub vertices: &'a SourceVertices<'a>,
    pub bounds: HullLimits<'b>,
    /// Volume that parts may have in common, relative to the sum of their volumes.
    pub overlap: f64,
    /// Maximum number of parts. Where it is reached, voids are left.
    pub max_parts: Option<usize>,
}

#[derive(Clone, Default)]
struct Left {
    pieces: Vec<Remnant>,
}

impl Left {
    fn points(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.pieces.iter().flat_map(|piece| piece.body.corners())
    }

    fn volume(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.body.volume()).sum()
    }

    fn room(&self, room: f64) -> f64 {
        if self.pieces.len() < MANY_PIECES { room } else { f64::INFINITY }
    }

    fn halves(mut self, key: impl Fn(&Remnant) -> f64) -> [Self; 2] {
        self.pieces.sort_by(|a, b| key(a).total_cmp(&key(b)));
        let rest = self.pieces.split_off(self.pieces.len() / 2);
        [self, Self { pieces: rest }]
    }
}

impl Filling<'_, '_> {
    /// Hulls that contain `hulls`, and more, and leave no voids if they are allowed to be enough.
    pub fn filled(&self, hulls: Vec<Hull>) -> Vec<Hull> {
        let mut hulls = hulls;
        let volume = |hulls: &[Hull]| hulls.iter().map(|hull| mass::mass(hull).volume).sum::<f64>();
        // Volume that may be added besides what is filled.
        let mut spare = self.overlap * volume(&hulls);
        for _ in 0..ROUNDS {
            let pieces = remainder(self.solid, &hulls.iter().collect::<Vec<_>>());
            if pieces.is_empty() || self.bounds.is_over() {
                break;
            }
            let left = Left { pieces };
            let (before, filled) = (volume(&hulls), left.volume());
            let room = spare / filled;
            let rest = self.absorb(&mut hulls, left.pieces, room);
            let new = self.joined(self.divided(rest, hulls.len(), room), room);
            hulls.extend(new.into_iter().map(|(hull, _)| hull));
            spare = (spare - (volume(&hulls) - before - filled).max(0.0)).max(0.0);
        }
        hulls
    }

    /// Lets parts absorb the pieces next to them, and returns the others.
    fn absorb(&self, hulls: &mut [Hull], left: Vec<Remnant>, room: f64) -> Left {
        let mut rest = Left::default();
        let mut of_parts: Vec<Left> = hulls.iter().map(|_| Left::default()).collect();
        let planes: Vec<_> = hulls.iter().map(Hull::half_spaces).collect();
        let outside = |part: usize, piece: &Remnant| {
            let middle = piece.body.middle();
            planes[part].iter().map(|plane| plane.height(middle)).fold(f64::NEG_INFINITY, f64::max)
        };
        for piece in left {
            let near = piece.near.iter().map(|part| (outside(*part as usize, &piece), *part as usize));
            match near.min_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((_, part)) => of_parts[part].pieces.push(piece),
                None => rest.pieces.push(piece),
            }
        }
        for (part, (hull, left)) in hulls.iter_mut().zip(of_parts).enumerate() {
            let mut stack = vec![left];
            let mut trials = 0;
            while let Some(left) = stack.pop() {
                if left.pieces.is_empty() {
                    continue;
                }
                let grown = Some(()).filter(|()| trials < TRIALS && !self.bounds.is_over());
                trials += 1;
                match grown.and_then(|()| self.hull_of(Some(hull), &left, room)) {
                    Some(grown) => *hull = grown,
                    None if left.pieces.len() == 1 || trials >= TRIALS => rest.pieces.extend(left.pieces),
                    None => {
                        let [near, far] = left.halves(|piece| outside(part, piece));
                        stack.extend([far, near]);
                    }
                }
            }
        }
        rest
    }

    /// Parts for pieces that no part absorbs, with the pieces of each, beside `count` other parts.
    fn divided(&self, left: Left, count: usize, room: f64) -> Vec<(Hull, Left)> {
        let mut found = Vec::new();
        let mut stack = vec![left];
        while let Some(left) = stack.pop() {
            let may_add = self.max_parts.is_none_or(|most| count + found.len() < most);
            if left.pieces.is_empty() || !may_add || self.bounds.is_over() {
                continue;
            }
            match self.hull_of(None, &left, left.room(room)) {
                Some(hull) => found.push((hull, left)),
                None if left.pieces.len() == 1 => {
                    let alone = self.alone(&left.pieces[0]);
                    found.extend(alone.into_iter().map(|hull| (hull, left.clone())));
                }
                None => {
                    let (low, high) = bounds(&left.points().collect::<Vec<_>>());
                    let axis = longest(high - low);
                    stack.extend(left.halves(|piece| piece.body.middle()[axis]));
                }
            }
        }
        found
    }

    fn joined(&self, parts: Vec<(Hull, Left)>, room: f64) -> Vec<(Hull, Left)> {
        if parts.len() > FEW {
            return parts;
        }
        let mut parts: Vec<Option<(Hull, Left)>> = parts.into_iter().map(Some).collect();
        let mut pairs = Vec::new();
        (1..parts.len()).for_each(|last| pairs.extend(pairs_with(&parts, last)));
        while let Some(next) = (0..pairs.len()).min_by(|a, b| pairs[*a].added.total_cmp(&pairs[*b].added)) {
            let PartPair { of: [a, b], .. } = pairs.swap_remove(next);
            let (Some((_, left)), Some((_, other))) = (&parts[a], &parts[b]) else { continue };
            let left = Left { pieces: left.pieces.iter().chain(&other.pieces).cloned().collect() };
            let Some(hull) = self.hull_of(None, &left, left.room(room)) else { continue };
            (parts[a], parts[b]) = (None, None);
            parts.push(Some((hull, left)));
            pairs.extend(pairs_with(&parts, parts.len() - 1));
        }
        parts.into_iter().flatten().collect()
    }

    fn hull_of(&self, part: Option<&Hull>, left: &Left, room: f64) -> Option<Hull> {
        let mut points: Vec<DVec3> = left.points().collect();
        points.extend(part.iter().flat_map(|hull| hull.positions()));
        let (before, filled) = (part.map_or(0.0, |hull| mass::mass(hull).volume), left.volume());
        let hull = self.within_limits(&points)?;
        let added = (mass::mass(&hull).volume - before - filled).max(0.0);
        // Written so that NaN fails. Infinity is no limit.
        if !(added <= room * filled) {
            return None;
        }
        wrap::prove(self.field, &hull, &self.bounds, wrap::MEASUREMENTS).ok().map(|_| hull)
    }

    fn within_limits(&self, points: &[DVec3]) -> Option<Hull> {
        let HullLimits { diagonal, thickness, max_vertices, .. } = self.bounds;
        let hull = self.vertices.built(few::within_vertices(wrap::tight(points, diagonal, thickness)?, max_vertices));
        Some(hull).filter(|hull| hull.vertices.len() <= max_vertices && hull.rank == 3)
    }

    fn alone(&self, piece: &Remnant) -> Vec<Hull> {
        let corners: Vec<DVec3> = piece.body.corners().collect();
        let is_proven = |hull: &Hull| wrap::prove(self.field, hull, &self.bounds, wrap::MEASUREMENTS).is_ok();
        match self.within_limits(&corners).filter(is_proven) {
            Some(hull) => vec![hull],
            None => piece.body.tetrahedra().filter_map(|corners| self.within_limits(&corners)).collect(),
        }
    }
}

struct PartPair {
    added: f64,
    of: [usize; 2],
}

fn pairs_with(parts: &[Option<(Hull, Left)>], last: usize) -> Vec<PartPair> {
    let Some((hull, _)) = &parts[last] else { return Vec::new() };
    let pair = |(index, other): (usize, &Option<(Hull, Left)>)| {
        let (other, _) = other.as_ref()?;
        let points = [hull.positions(), other.positions()].concat();
        let volumes = mass::mass(hull).volume + mass::mass(other).volume;
        Some(PartPair { added: Body::new(&points, 0.0).volume() - volumes, of: [index, last] })
    };
    parts[..last].iter().enumerate().filter_map(pair).collect()
}

#[cfg(test)]
mod tests;
