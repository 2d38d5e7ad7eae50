//! Pairs of links whose collisions touch.

use hullmap::{Cache, Overlap, Pose};
use hullmap_robot::{Chain, Frame};

use super::bodies::Piece;

/// Convex pieces of each link, and the balls that hold them.
pub struct Bodies {
    pieces: Vec<Vec<Piece>>,
    balls: Vec<Option<(glam::DVec3, f64)>>,
}

impl Bodies {
    /// The pieces of each link.
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

    /// Number of pieces of a link.
    pub fn count(&self, link: usize) -> usize {
        self.pieces[link].len()
    }

    /// Whether two links touch, each placed in the world.
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
                    let found = hullmap::intersects(&*piece_a.shape, &*piece_b.shape, pose, &mut cache);
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

/// Which links move against each other, and which are neighbours.
pub struct Neighbours {
    /// For each link, one that it is rigidly connected to.
    rigid: Vec<usize>,
    /// For each link, the rigid group of the parent of its own.
    parent: Vec<Option<usize>>,
    robots: Vec<usize>,
    is_world: Vec<bool>,
}

impl Neighbours {
    /// The neighbours of a chain.
    pub fn new(chain: &Chain) -> Self {
        let rigid = chain.rigid();
        let parent = rigid.iter().map(|&own| chain.links[own].parent.map(|parent| rigid[parent])).collect();
        let is_world = chain.links.iter().map(|link| link.is_world).collect();
        Self { rigid, parent, robots: chain.robots(), is_world }
    }

    /// Whether two links are connected by one joint, or by none. Rigid connections count as one
    /// link. The world is no neighbour, as in MuJoCo.
    pub fn are_adjacent(&self, [a, b]: [usize; 2]) -> bool {
        let [own_a, own_b] = [self.rigid[a], self.rigid[b]];
        let joined = self.parent[a] == Some(own_b) || self.parent[b] == Some(own_a);
        own_a == own_b || joined && !self.is_world[own_a] && !self.is_world[own_b]
    }

    /// All pairs of links with collisions, of one robot. The world is not a part of any.
    pub fn pairs(&self, before: &Bodies, after: &Bodies) -> Vec<[usize; 2]> {
        let has_pieces = |link: &usize| before.count(*link) + after.count(*link) > 0 && !self.is_world[*link];
        let has_pieces: Vec<usize> = (0..self.rigid.len()).filter(has_pieces).collect();
        let pairs =
            has_pieces.iter().enumerate().flat_map(|(at, &a)| has_pieces[at + 1..].iter().map(move |&b| [a, b]));
        pairs.filter(|[a, b]| self.robots[*a] == self.robots[*b]).collect()
    }
}
