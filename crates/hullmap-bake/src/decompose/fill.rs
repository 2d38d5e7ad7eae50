//! Parts that leave no voids: what they leave of the solid is absorbed by them, or gets parts of
//! its own.
//!
//! # Steps
//! 1. Find what is left, as convex pieces ([`remainder`]).
//! 2. Give each piece to the nearest part. The hull of both replaces the part if it is proven, and
//!    adds little volume besides. Otherwise, try with the nearer half of the pieces, and so on.
//! 3. The hull of all other pieces becomes a part under the same conditions. Otherwise, divide them
//!    in the middle of the longest side. A single piece protrudes nowhere.
//! 4. Repeat with the hulls that are stored, until nothing is left.
//!
//! The search is not symmetric, so the parts of a symmetric mesh may no longer be.
//!
//! # Why it is proven
//! Step 1 measures the hulls that are stored. If it finds nothing, every point of the solid is in a
//! part, grown by [`GROWN`](crate::fit::remainder::GROWN). Parts that grow still contain what they
//! contained, so the surface stays covered.

use glam::DVec3;

use super::{
    part::SourceVertices,
    partition::{
        body::{bounds, longest},
        few,
        field::Field,
        wrap::{self, Bounds},
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

/// Share of the volume that may still be added besides what is filled that one hull may add.
const ONE_HULL: f64 = 0.25;

/// Maximum number of hulls that are tried for one part in a round.
const TRIALS: usize = 24;

/// What is needed to fill voids.
pub struct Filling<'a, 'b> {
    /// From where protrusion counts.
    pub field: &'a Field<'a>,
    /// The solid to be filled.
    pub solid: &'a Solid,
    /// Vertices of the mesh.
    pub vertices: &'a SourceVertices<'a>,
    /// Limits of a part.
    pub bounds: Bounds<'b>,
    /// Volume that parts may have in common, relative to the sum of their volumes.
    pub overlap: f64,
    /// Maximum number of parts. Where it is reached, voids are left.
    pub max_parts: Option<usize>,
}

/// Pieces of the solid in no part, and their volume.
#[derive(Default)]
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

    /// The first half of the pieces in the order of a key, and the rest.
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
        let mut room = self.overlap * hulls.iter().map(|hull| mass::mass(hull).volume).sum::<f64>();
        for _ in 0..ROUNDS {
            let left = remainder(self.solid, &hulls.iter().collect::<Vec<_>>());
            if left.is_empty() || self.bounds.is_over() {
                break;
            }
            let rest = self.absorb(&mut hulls, left, &mut room);
            self.add(&mut hulls, rest, &mut room);
        }
        hulls
    }

    /// Lets parts absorb the pieces next to them, and returns the others.
    fn absorb(&self, hulls: &mut [Hull], left: Vec<Remnant>, room: &mut f64) -> Left {
        let mut rest = Left::default();
        let mut of_parts: Vec<Left> = hulls.iter().map(|_| Left::default()).collect();
        let planes: Vec<_> = hulls.iter().map(crate::fit::planes::half_spaces).collect();
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

    /// Adds parts for pieces that no part absorbs.
    fn add(&self, hulls: &mut Vec<Hull>, left: Left, room: &mut f64) {
        let mut stack = vec![left];
        while let Some(left) = stack.pop() {
            let may_add = self.max_parts.is_none_or(|most| hulls.len() < most);
            if left.pieces.is_empty() || !may_add || self.bounds.is_over() {
                continue;
            }
            match self.hull_of(None, &left, room) {
                Some(hull) => hulls.push(hull),
                None if left.pieces.len() == 1 => hulls.extend(self.alone(&left.pieces[0])),
                None => {
                    let (low, high) = bounds(&left.points().collect::<Vec<_>>());
                    let axis = longest(high - low);
                    stack.extend(left.halves(|piece| piece.body.middle()[axis]));
                }
            }
        }
    }

    /// The hull of a part and of pieces, if it is proven and adds little volume besides.
    fn hull_of(&self, part: Option<&Hull>, left: &Left, room: &mut f64) -> Option<Hull> {
        let mut points: Vec<DVec3> = left.points().collect();
        points.extend(part.iter().flat_map(|hull| hull.positions()));
        let volume = part.map_or(0.0, |hull| mass::mass(hull).volume) + left.volume();
        let hull = self.within_limits(&points)?;
        let added = (mass::mass(&hull).volume - volume).max(0.0);
        // Written so that NaN fails. Infinity is no limit.
        if !(added <= ONE_HULL * *room) {
            return None;
        }
        wrap::prove(self.field, &hull, &self.bounds, wrap::MEASUREMENTS).ok()?;
        *room -= added;
        Some(hull)
    }

    /// The hull of points, if it has few enough vertices.
    fn within_limits(&self, points: &[DVec3]) -> Option<Hull> {
        let Bounds { diagonal, thickness, max_vertices, .. } = self.bounds;
        let hull = self.vertices.built(few::within_vertices(wrap::tight(points, diagonal, thickness)?, max_vertices));
        Some(hull).filter(|hull| hull.vertices.len() <= max_vertices && hull.rank == 3)
    }

    /// Parts for a single piece: of the piece, or of tetrahedra if it has too many vertices.
    fn alone(&self, piece: &Remnant) -> Vec<Hull> {
        let corners: Vec<DVec3> = piece.body.corners().collect();
        let is_proven = |hull: &Hull| wrap::prove(self.field, hull, &self.bounds, wrap::MEASUREMENTS).is_ok();
        match self.within_limits(&corners).filter(is_proven) {
            Some(hull) => vec![hull],
            None => piece.body.tetrahedra().filter_map(|corners| self.within_limits(&corners)).collect(),
        }
    }
}

#[cfg(test)]
mod tests;
