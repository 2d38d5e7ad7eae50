//! Pairs of links whose collisions touch.

use hullmap::{Cache, Overlap, Pose};
use hullmap_robot::Frame;

use super::bodies::Piece;

pub struct Bodies {
    pieces: Vec<Vec<Piece>>,
    balls: Vec<Option<(glam::DVec3, f64)>>,
}

impl Bodies {
    pub fn new(pieces: Vec<Vec<Piece>>) -> Self {
        let ball = |own: &Vec<Piece>| {
            let (centre, _) = own.first()?.ball();
            let reach = |piece: &Piece| {
                let (own, radius) = piece.ball();
                own.distance(centre) + radius
            };
            Some((centre, own.iter().map(reach).fold(0.0, f64::max)))
        };
        let balls = pieces.iter().map(ball).collect();
        Self { pieces, balls }
    }

    pub fn count(&self, link: usize) -> usize {
        self.pieces[link].len()
    }

    pub fn touch(&self, [a, b]: [usize; 2], frames: &[Frame]) -> bool {
        let (Some((centre_a, radius_a)), Some((centre_b, radius_b))) = (self.balls[a], self.balls[b]) else {
            return false;
        };
        let b_in_a = frames[a].inverse() * frames[b];
        if are_apart(centre_a, radius_a, b_in_a.apply(centre_b), radius_b) {
            return false;
        }
        let mut cache = Cache::new();
        for piece_a in &self.pieces[a] {
            let (centre, radius) = piece_a.ball();
            let near = |piece: &&Piece| {
                let (own, own_radius) = piece.ball();
                !are_apart(centre, radius, b_in_a.apply(own), own_radius)
            };
            for piece_b in self.pieces[b].iter().filter(|piece| piece_a.may_meet(piece)).filter(near) {
                let own = piece_a.in_link.inverse() * b_in_a * piece_b.in_link;
                // Undecided pairs count as touching, as do poses that are too far for the solver.
                let is_apart = Pose::new(own.translation, own.rotation).is_ok_and(|pose| {
                    let found = hullmap::intersects(piece_a.shape.shape(), piece_b.shape.shape(), pose, &mut cache);
                    found.status == Overlap::Separated
                });
                cache = Cache::new();
                if !is_apart {
                    return true;
                }
            }
        }
        false
    }
}

/// Whether two balls have no point in common. NaN counts as touching.
fn are_apart(a: glam::DVec3, radius_a: f64, b: glam::DVec3, radius_b: f64) -> bool {
    a.distance(b) > (radius_a + radius_b) * (1.0 + 1e-9)
}
