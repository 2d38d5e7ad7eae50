//! Whether a vertex is the support point for certain: what a query that remembers asks first.
//!
//! On a convex hull, a vertex that beats its neighbours beats all. Whether it does is told from the stored directions of its
//! edges ([`hullmap_format::edge`]), eight at a time, with a margin for all that is rounded in them. So the answer is that of
//! an ordinary query, or there is none.

use hullmap_format::{archive::LANES, cube, edge};
use rkyv::rend::i16_le;

use crate::simd::{Simd, Work};

/// Edges of a vertex beyond which an ordinary query is cheaper.
const MOST_EDGES: usize = 16;

/// The edges of one vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edges<'a> {
    /// First coordinates, second ones, third ones, and whatever lies behind them.
    pub(crate) numbers: &'a [i16_le],
    /// How many edges there are.
    pub(crate) count: usize,
}

impl Edges<'_> {
    /// Eight coordinates along `axis` from edge `first` on, some of which may be those of something else.
    #[inline(always)]
    fn eight(&self, axis: usize, first: usize) -> Option<&[i16_le; LANES]> {
        self.numbers.get(axis * self.count + first..)?.first_chunk()
    }
}

/// Whether all edges lead away from a direction of these numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AllLeadAway<'a>(pub(crate) Edges<'a>);

impl Work for AllLeadAway<'_> {
    type Scalar = f32;
    type Answer = bool;

    #[inline(always)]
    fn with<S: Simd>(self, simd: S, dir: [f32; 3]) -> bool {
        let edges = self.0;
        let Some(least) = least(edges, dir) else { return false };
        let mut first = 0;
        while first < edges.count {
            let (Some(x), Some(y), Some(z)) = (edges.eight(0, first), edges.eight(1, first), edges.eight(2, first))
            else {
                // The last vertices of a hull, behind whose edges there are not eight numbers.
                return all_lead_away(edges, dir, least);
            };
            let all = if edges.count - first < LANES { (1 << (edges.count - first)) - 1 } else { 0xff };
            if simd.edges_below([x, y, z], dir, least) & all != all {
                return false;
            }
            first += LANES;
        }
        true
    }
}

/// What every edge's dot product must be less than; `None` where f32 cannot tell, or should not.
#[inline(always)]
fn least(edges: Edges, dir: [f32; 3]) -> Option<f32> {
    let askable = (1..=MOST_EDGES).contains(&edges.count) && cube::IN_RANGE.contains(&cube::largest(dir));
    askable.then(|| -edge::DOUBT * (dir[0].abs() + dir[1].abs() + dir[2].abs()))
}

/// One edge after the other: the slow, obvious twin.
fn all_lead_away(edges: Edges, dir: [f32; 3], least: f32) -> bool {
    (0..edges.count).all(|place| {
        let number = |axis: usize| edges.numbers.get(axis * edges.count + place).map(|c| f32::from(c.to_native()));
        let (Some(x), Some(y), Some(z)) = (number(0), number(1), number(2)) else { return false };
        x * dir[0] + y * dir[1] + z * dir[2] < least
    })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use rkyv::rend::i16_le;
    use shapes::rng::SplitMix64;

    use super::*;
    use crate::simd::{Instructions, Level};

    /// All that this processor has.
    fn levels() -> impl Iterator<Item = Level> {
        [Instructions::Portable, Instructions::Avx2].into_iter().filter_map(Level::of)
    }

    /// `count` edges that lead away from x, by first coordinates, second ones and third ones, and `more` numbers of others.
    fn numbers(rng: &mut SplitMix64, count: usize, more: usize) -> Vec<i16_le> {
        let edges: Vec<[i16; 3]> = (0..count)
            .map(|_| {
                let [x, y, z] = rng.direction();
                DVec3::new(-x.abs() - 0.1, y, z).normalize().to_array().map(|c| (c * edge::SCALE).round() as i16)
            })
            .collect();
        let by_axis = (0..3).flat_map(|axis| edges.iter().map(move |edge| edge[axis]));
        by_axis.chain((0..more).map(|_| rng.next_u64() as i16)).map(i16_le::from_native).collect()
    }

    /// The fast path against its slow twin, for every number of edges, with and without others behind them.
    #[test]
    fn eight_at_a_time_is_one_after_the_other() {
        let mut rng = SplitMix64::new(7);
        let mut yes = 0;
        let rounds = 4_000;
        for round in 0..rounds {
            let count = 1 + round % MOST_EDGES;
            let more = [0, 1, 7, 8, 60][rng.below(5)];
            let numbers = numbers(&mut rng, count, more);
            let edges = Edges { numbers: &numbers, count };
            let spread = rng.unit();
            let size = [1.0, 1e-29, 1e29, 3.0][rng.below(4)];
            let dir = (DVec3::X + DVec3::from_array(rng.direction()) * spread * 1.5) * size;
            let dir = dir.as_vec3().to_array();
            let least = least(edges, dir).unwrap();
            let slow = all_lead_away(edges, dir, least);
            for level in levels() {
                let fast = level.run(AllLeadAway(edges), dir);
                assert_eq!(fast, slow, "{:?}, {count} edges, {dir:?}", level.instructions());
            }
            yes += usize::from(slow);
        }
        assert!((rounds / 5..rounds * 4 / 5).contains(&yes), "{yes} of {rounds} are certain");
    }

    /// Sums within rounding of the threshold are no matter: what is certain in one order of operations is so in f64.
    #[test]
    fn what_is_certain_leads_away_for_certain() {
        let mut rng = SplitMix64::new(8);
        let mut certain = 0;
        for _ in 0..20_000 {
            let numbers = numbers(&mut rng, 1, 9);
            let q: [f64; 3] = std::array::from_fn(|axis| f64::from(numbers[axis].to_native()));
            // Nearly at right angles to the edge.
            let q = DVec3::from_array(q);
            let beside = q.cross(DVec3::from_array(rng.direction())).normalize();
            let dir = (beside - q.normalize() * rng.unit() * 1e-4).as_vec3();
            for level in levels() {
                if level.run(AllLeadAway(Edges { numbers: &numbers, count: 1 }), dir.to_array()) {
                    // The edge before it was rounded is half a unit off in each coordinate at most.
                    let dir = dir.as_dvec3();
                    assert!(q.dot(dir) + 0.5 * dir.abs().element_sum() < 0.0);
                    certain += 1;
                }
            }
        }
        assert!(certain > 1_000, "{certain}");
    }

    #[test]
    fn what_cannot_be_told_is_not_certain() {
        let mut rng = SplitMix64::new(9);
        let numbers = numbers(&mut rng, MOST_EDGES + 1, 8);
        let sure = |count: usize, dir: [f32; 3]| -> Vec<bool> {
            let edges = Edges { numbers: &numbers, count };
            levels().map(|level| level.run(AllLeadAway(edges), dir)).collect()
        };
        let away = [1.0, 0.0, 0.0];
        assert!(sure(MOST_EDGES, away).iter().all(|sure| *sure));
        assert!(sure(1, [1e30, 0.0, 0.0]).iter().all(|sure| *sure));
        // No edges, too many, more than there are numbers.
        for count in [0, MOST_EDGES + 1, 1_000, usize::MAX / 4] {
            assert!(sure(count, away).iter().all(|sure| !sure), "{count}");
        }
        let (nan, inf) = (f32::NAN, f32::INFINITY);
        for dir in [
            [0.0; 3],
            [nan; 3],
            [1.0, nan, 0.0],
            [inf, 0.0, 0.0],
            [1.0, -inf, 0.0],
            [f32::MAX, 0.0, 0.0],
            [1e-31, 0.0, 0.0],
            [1e-44, 0.0, 0.0],
        ] {
            assert!(sure(MOST_EDGES, dir).iter().all(|sure| !sure), "{dir:?}");
        }
        let short = Edges { numbers: &numbers[..5], count: 2 };
        assert!(levels().all(|level| !level.run(AllLeadAway(short), away)));
    }
}
