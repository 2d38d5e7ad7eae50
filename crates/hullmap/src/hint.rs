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
