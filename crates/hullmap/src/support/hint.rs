//! Local-maximum test of a hint: is the vertex of the previous query still the support vertex?
//!
//! On a convex hull, a vertex with a larger dot product than all its neighbours is the support
//! vertex (hill climbing with zero steps). The test uses the stored edge directions
//! ([`hullmap_format::edge`]), eight at a time, with a margin for their rounding error. It succeeds
//! only if the result of an ordinary query would be the same vertex; otherwise the caller runs that
//! query.

use hullmap_format::{archive::LANES, cube, edge};
use rkyv::rend::i16_le;

use super::simd::{Kernel, Simd};

/// Maximum number of edges to test. With more, an ordinary query is cheaper.
const MAX_HINT_EDGES: usize = 16;

/// Quantised directions of the edges at one vertex, in structure-of-arrays order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edges<'a> {
    /// `count` x components, then as many y and z components, then data of other vertices.
    pub(crate) components: &'a [i16_le],
    pub(crate) count: usize,
}

impl Edges<'_> {
    /// Eight components along `axis`, from edge `first` on. Lanes past `count` hold unrelated data.
    #[inline(always)]
    fn eight(&self, axis: usize, first: usize) -> Option<&[i16_le; LANES]> {
        self.components.get(axis * self.count + first..)?.first_chunk()
    }
}

/// Kernel that finds the edges that may not descend in the query direction: one bit each; `None` if
/// f32 cannot decide. Without any, the vertex is certainly the support vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LevelOrRising<'a> {
    pub(crate) edges: Edges<'a>,
    /// An edge descends if it falls by more than this share of its length, and by more than the
    /// rounding error.
    pub(crate) tangent: f32,
}

impl Kernel for LevelOrRising<'_> {
    type Scalar = f32;
    type Output = Option<u32>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S, dir: [f32; 3]) -> Option<u32> {
        let edges = self.edges;
        let threshold = threshold(edges, dir, self.tangent)?;
        let (mut first, mut found) = (0, 0);
        while first < edges.count {
            let (Some(x), Some(y), Some(z)) = (edges.eight(0, first), edges.eight(1, first), edges.eight(2, first))
            else {
                // Fewer than eight components are left in the hull's table.
                return Some(one_by_one(edges, dir, threshold));
            };
            let all = if edges.count - first < LANES { (1 << (edges.count - first)) - 1 } else { 0xff };
            found |= (all & !simd.edges_below([x, y, z], dir, threshold)) << first;
            first += LANES;
        }
        Some(found)
    }
}

/// Upper bound that every edge's dot product must stay below; `None` where f32 cannot decide (`dir`
/// is out of range) or an ordinary query is cheaper (too many edges).
#[inline(always)]
fn threshold(edges: Edges, dir: [f32; 3], tangent: f32) -> Option<f32> {
    let is_testable = (1..=MAX_HINT_EDGES).contains(&edges.count) && cube::IN_RANGE.contains(&cube::largest(dir));
    let fall = edge::DOUBT + edge::SCALE as f32 * tangent;
    is_testable.then(|| -fall * (dir[0].abs() + dir[1].abs() + dir[2].abs()))
}

/// Tests one edge after the other: the slow, obvious twin.
fn one_by_one(edges: Edges, dir: [f32; 3], threshold: f32) -> u32 {
    let descends = |edge: usize| {
        let component = |axis: usize| edges.components.get(axis * edges.count + edge).map(|c| f32::from(c.to_native()));
        let (Some(x), Some(y), Some(z)) = (component(0), component(1), component(2)) else { return false };
        x * dir[0] + y * dir[1] + z * dir[2] < threshold
    };
    (0..edges.count).map(|edge| u32::from(!descends(edge)) << edge).sum()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use rkyv::rend::i16_le;
    use shapes::rng::SplitMix64;

    use super::*;
    use crate::support::simd::dispatches;

    /// Components of `count` edges that descend along x, followed by `more` unrelated ones.
    fn components(rng: &mut SplitMix64, count: usize, more: usize) -> Vec<i16_le> {
        let edges: Vec<[i16; 3]> = (0..count)
            .map(|_| {
                let [x, y, z] = rng.direction();
                DVec3::new(-x.abs() - 0.1, y, z).normalize().to_array().map(|c| (c * edge::SCALE).round() as i16)
            })
            .collect();
        let by_axis = (0..3).flat_map(|axis| edges.iter().map(move |edge| edge[axis]));
        by_axis.chain((0..more).map(|_| rng.next_u64() as i16)).map(i16_le::from_native).collect()
    }

    /// The fast path against its slow twin, for every edge count, with and without unrelated data
    /// after the edges.
    #[test]
    fn simd_and_scalar_tests_agree() {
        let mut rng = SplitMix64::new(7);
        let mut yes = 0;
        let rounds = 4_000;
        for round in 0..rounds {
            let count = 1 + round % MAX_HINT_EDGES;
            let more = [0, 1, 7, 8, 60][rng.below(5)];
            let components = components(&mut rng, count, more);
            let edges = Edges { components: &components, count };
            let spread = rng.unit();
            let size = [1.0, 1e-29, 1e29, 3.0][rng.below(4)];
            let dir = (DVec3::X + DVec3::from_array(rng.direction()) * spread * 1.5) * size;
            let dir = dir.as_vec3().to_array();
            let tangent = [0.0, 1e-3][round % 2];
            let slow = one_by_one(edges, dir, threshold(edges, dir, tangent).unwrap());
            for dispatch in dispatches() {
                let fast = dispatch.run(LevelOrRising { edges, tangent }, dir);
                assert_eq!(fast, Some(slow), "{:?}, {count} edges, {dir:?}", dispatch.instructions());
            }
            yes += usize::from(slow == 0);
        }
        assert!((rounds / 5..rounds * 4 / 5).contains(&yes), "{yes} of {rounds} tests pass");
    }

    /// The threshold covers the rounding error: edges that descend by the test also descend in f64,
    /// before quantisation.
    #[test]
    fn edges_that_pass_descend_in_f64() {
        let mut rng = SplitMix64::new(8);
        let mut certain = 0;
        for _ in 0..20_000 {
            let components = components(&mut rng, 1, 9);
            let q: [f64; 3] = std::array::from_fn(|axis| f64::from(components[axis].to_native()));
            // Nearly perpendicular to the edge.
            let q = DVec3::from_array(q);
            let beside = q.cross(DVec3::from_array(rng.direction())).normalize();
            let dir = (beside - q.normalize() * rng.unit() * 1e-4).as_vec3();
            for dispatch in dispatches() {
                let edges = Edges { components: &components, count: 1 };
                if dispatch.run(LevelOrRising { edges, tangent: 0.0 }, dir.to_array()) == Some(0) {
                    // Quantisation moved the edge by at most half a unit in each component.
                    let dir = dir.as_dvec3();
                    assert!(q.dot(dir) + 0.5 * dir.abs().element_sum() < 0.0);
                    certain += 1;
                }
            }
        }
        assert!(certain > 1_000, "{certain}");
    }

    #[test]
    fn undecidable_tests_fail() {
        let mut rng = SplitMix64::new(9);
        let components = components(&mut rng, MAX_HINT_EDGES + 1, 8);
        let passes = |count: usize, dir: [f32; 3]| -> Vec<bool> {
            let edges = Edges { components: &components, count };
            dispatches().map(|dispatch| dispatch.run(LevelOrRising { edges, tangent: 0.0 }, dir) == Some(0)).collect()
        };
        let away = [1.0, 0.0, 0.0];
        assert!(passes(MAX_HINT_EDGES, away).iter().all(|passes| *passes));
        assert!(passes(1, [1e30, 0.0, 0.0]).iter().all(|passes| *passes));
        // No edges, too many, and more than there are components.
        for count in [0, MAX_HINT_EDGES + 1, 1_000, usize::MAX / 4] {
            assert!(passes(count, away).iter().all(|passes| !passes), "{count}");
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
            assert!(passes(MAX_HINT_EDGES, dir).iter().all(|passes| !passes), "{dir:?}");
        }
        let short = LevelOrRising { edges: Edges { components: &components[..5], count: 2 }, tangent: 0.0 };
        assert!(dispatches().all(|dispatch| dispatch.run(short, away) != Some(0)));
    }
}
