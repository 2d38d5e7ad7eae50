//! The pairs of a scene: random ones, and the neighbours in a moving crowd.

use glam::{DQuat, DVec3};
use hullmap::{Hull, SupportMap};
use shapes::rng::SplitMix64;

use crate::{
    solver::pairs::{Class, Placed, STEP, TURN_RAD, random_rotation, touching_distance},
    subject::SEED,
};

/// Two hulls, by their indices in the scene, and the pose of the second.
#[derive(Clone, Copy, Debug)]
pub struct ScenePair {
    /// First hull.
    pub a: usize,
    /// Second hull.
    pub b: usize,
    /// Pose of B in A's frame.
    pub placed: Placed,
}

/// `count` pairs of random hulls. A third penetrate, a third are within 2 % of touching, a third
/// are separated, in turn.
pub fn random(hulls: &[Hull<'_>], count: usize) -> Vec<ScenePair> {
    let mut rng = SplitMix64::new(SEED);
    let index = |rng: &mut SplitMix64| (rng.between(0.0, hulls.len() as f64) as usize).min(hulls.len() - 1);
    (0..count)
        .map(|i| {
            let [a, b] = [(); 2].map(|()| index(&mut rng));
            let (rotation, direction) = (random_rotation(&mut rng), DVec3::from_array(rng.direction()));
            let [low, high] = Class::ALL[i % Class::ALL.len()].shares();
            let reach = touching_distance(&hulls[a], &hulls[b], rotation, direction) * rng.between(low, high);
            let center = hulls[a].interior_point() + direction * reach;
            ScenePair { a, b, placed: Placed::new(center - rotation * hulls[b].interior_point(), rotation) }
        })
        .collect()
}

/// Distance between neighbours of a crowd at rest. Hulls have a mean radius of 1, so about half of
/// the neighbours overlap.
const SPACING: f64 = 1.75;

/// Maximum distance of a body from its place, in each coordinate.
const JITTER: f64 = 0.2;

/// A cube of bodies. Each moves by 1 % of its size and turns by one degree from frame to frame.
pub struct Crowd {
    bodies: Vec<CrowdBody>,
    /// Neighbours, in the order of the first body.
    neighbours: Vec<[usize; 2]>,
    hull_count: usize,
}

struct CrowdBody {
    at: DVec3,
    rotation: DQuat,
    way: DVec3,
    axis: DVec3,
}

impl Crowd {
    /// `bodies` bodies, of which number i has hull i modulo `hull_count`.
    pub fn new(bodies: usize, hull_count: usize) -> Self {
        let mut rng = SplitMix64::new(SEED);
        let side = (1..).find(|side: &usize| side.pow(3) >= bodies).unwrap_or(1);
        let places = [1, side, side * side];
        let neighbours = (0..bodies).flat_map(|i| {
            let inner = (0..3).filter(move |axis| i / places[*axis] % side + 1 < side);
            inner.map(move |axis| [i, i + places[axis]]).filter(|[_, other]| *other < bodies)
        });
        let neighbours = neighbours.collect();
        let bodies = (0..bodies)
            .map(|i| {
                let place = DVec3::from_array(places.map(|place| (i / place % side) as f64)) * SPACING;
                let jitter = DVec3::from_array([(); 3].map(|()| rng.between(-JITTER, JITTER)));
                let [way, axis] = [(); 2].map(|()| DVec3::from_array(rng.direction()));
                CrowdBody { at: place + jitter, rotation: random_rotation(&mut rng), way, axis }
            })
            .collect();
        Self { bodies, neighbours, hull_count }
    }

    /// Number of pairs.
    pub fn pair_count(&self) -> usize {
        self.neighbours.len()
    }

    /// All pairs of neighbours at a frame.
    pub fn frame(&self, frame: usize) -> Vec<ScenePair> {
        let time = frame as f64;
        let pose = |body: &CrowdBody| {
            let rotation = DQuat::from_axis_angle(body.axis, TURN_RAD * time) * body.rotation;
            (body.at + body.way * (2.0 * STEP * time), rotation)
        };
        let pair = |[a, b]: &[usize; 2]| {
            let ((at_a, rotation_a), (at_b, rotation_b)) = (pose(&self.bodies[*a]), pose(&self.bodies[*b]));
            let back = rotation_a.conjugate();
            let placed = Placed::new(back * (at_b - at_a), back * rotation_b);
            ScenePair { a: a % self.hull_count, b: b % self.hull_count, placed }
        };
        self.neighbours.iter().map(pair).collect()
    }
}

#[cfg(test)]
mod tests {
    use hullmap::{Cache, intersects};
    use hullmap_bake::IndexKind;

    use super::*;
    use crate::scene::Scene;

    fn share_of_hits(hulls: &[Hull<'_>], pairs: &[ScenePair]) -> f64 {
        let hits = pairs.iter().filter(|pair| {
            intersects(&hulls[pair.a], &hulls[pair.b], pair.placed.b_in_a, &mut Cache::default()).is_hit()
        });
        hits.count() as f64 / pairs.len() as f64
    }

    #[test]
    fn about_half_of_the_pairs_overlap() {
        let scene = Scene::bake(30, 32, IndexKind::Tree);
        let hulls = scene.hulls();
        let share = share_of_hits(&hulls, &random(&hulls, 600));
        assert!((0.4..0.6).contains(&share), "{share} of random pairs, seed {SEED}");
        let crowd = Crowd::new(125, 30);
        assert_eq!(crowd.pair_count(), 3 * 25 * 4);
        for frame in [0, 7] {
            let share = share_of_hits(&hulls, &crowd.frame(frame));
            assert!((0.3..0.8).contains(&share), "{share} of neighbours in frame {frame}, seed {SEED}");
        }
    }
}
