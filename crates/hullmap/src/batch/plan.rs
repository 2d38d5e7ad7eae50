//! Plan of a batch: a plain loop, shapes fetched ahead, or several queries in flight. The size of a
//! few of its shapes decides.
//!
//! Queries wait for memory only if the shapes are larger together than the caches. Then there are
//! two ways to use the time: plain queries that fetch the next shapes as a whole ([`ahead`]), or
//! several queries in flight that fetch what each of them reads next ([`in_flight`]). The first
//! takes little time even if memory is fast, but it helps only if a query reads most of a shape.
//!
//! [`ahead`]: super::ahead
//! [`in_flight`]: super::in_flight

use super::pair::Pair;
use crate::shapes::Shape;

/// Working set from which a batch fetches shapes ahead, in bytes: a core's share of cache.
/// Fetching costs almost nothing if the caches hold more.
const CACHED: usize = 512 << 10;

/// Working set from which queries are in flight, in bytes: more than the cache of a core holds on
/// any current processor. Suspending costs 10 to 20 % of the time of a query.
const LARGE: usize = 3 << 20;

/// Mean working set of a shape up to which it is fetched as a whole even in a large scene, in
/// bytes: about what one support query, or another short query, reads. A hull of at most
/// 32 vertices, which has no index, is smaller.
const SCANNED: usize = 1536;

/// Bytes that a contact reads: much of a shape. It computes long enough to fetch the next.
const READ_BY_CONTACTS: usize = 18 << 10;

/// Number of shapes sampled to estimate the working set.
const SAMPLES: usize = 128;

/// Number of bits of the set of shapes seen: enough that two of the samples rarely share a bit.
const SEEN_BITS: usize = 4096;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Plan {
    Loop,
    /// The same, while the memory of the next queries is fetched.
    Ahead,
    /// Several queries in flight.
    InFlight,
}

impl Plan {
    pub(super) fn of_shapes<'s, S: Shape + ?Sized + 's>(count: usize, shape: impl Fn(usize) -> Option<&'s S>) -> Self {
        WorkingSet::estimate(count, shape).plan(SCANNED)
    }

    pub(super) fn of_pairs<A: Shape + ?Sized, B: Shape + ?Sized>(pairs: &[Pair<'_, A, B>]) -> Self {
        WorkingSet::of_pairs(pairs).plan(SCANNED)
    }

    pub(super) fn of_contacts<A: Shape + ?Sized, B: Shape + ?Sized>(pairs: &[Pair<'_, A, B>]) -> Self {
        WorkingSet::of_pairs(pairs).plan(READ_BY_CONTACTS)
    }

    /// For manifolds, which are not in flight.
    pub(super) fn of_manifolds<A: Shape + ?Sized, B: Shape + ?Sized>(pairs: &[Pair<'_, A, B>]) -> Self {
        match Self::of_contacts(pairs) {
            Self::InFlight => Self::Loop,
            plan => plan,
        }
    }
}

/// An estimate of what queries read, in bytes.
#[derive(Clone, Copy, Debug)]
struct WorkingSet {
    /// Mean per shape.
    mean: usize,
    /// Total over all distinct shapes.
    total: usize,
}

impl WorkingSet {
    /// The plan for queries that fetch shapes of up to `whole` bytes as a whole.
    fn plan(self, whole: usize) -> Plan {
        let Self { mean, total } = self;
        if total < CACHED {
            Plan::Loop
        } else if mean <= whole || total < LARGE {
            Plan::Ahead
        } else {
            Plan::InFlight
        }
    }

    /// Samples s ≤ [`SAMPLES`] of `count` shapes. If there are many shapes, N, about s² / 2N of the
    /// samples repeat an earlier one, which gives an estimate of N. If there are few, all have been
    /// seen.
    ///
    /// # Complexity
    /// O(1).
    fn estimate<'s, S: Shape + ?Sized + 's>(count: usize, shape: impl Fn(usize) -> Option<&'s S>) -> Self {
        let samples = count.min(SAMPLES);
        let mut seen = [0_u64; SEEN_BITS / 64];
        let (mut different, mut bytes) = (0, 0_usize);
        for sample in 0..samples {
            // Never overflows: both are counts of elements in memory.
            let Some(shape) = shape(sample * (count / samples)) else { continue };
            // Fibonacci hashing: the top bits of the product depend on all bits of the address.
            let address = std::ptr::from_ref(shape).cast::<u8>().addr() as u64;
            let bit = (address.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 52) as usize % SEEN_BITS;
            let Some(word) = seen.get_mut(bit / 64) else { continue };
            if *word & 1 << (bit % 64) == 0 {
                *word |= 1 << (bit % 64);
                different += 1;
                bytes = bytes.saturating_add(shape.working_set_len());
            }
        }
        let shapes = if 2 * different <= samples {
            different
        } else {
            (samples * samples).checked_div(2 * (samples - different)).unwrap_or(count).min(count)
        };
        let mean = bytes / different.max(1);
        Self { mean, total: mean.saturating_mul(shapes) }
    }

    /// For the first or the second shapes, whichever are larger in total.
    fn of_pairs<A: Shape + ?Sized, B: Shape + ?Sized>(pairs: &[Pair<'_, A, B>]) -> Self {
        let a = Self::estimate(pairs.len(), |at| pairs.get(at).map(|pair| pair.a));
        let b = Self::estimate(pairs.len(), |at| pairs.get(at).map(|pair| pair.b));
        if a.total > b.total { a } else { b }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use shapes::rng::SplitMix64;

    use super::*;
    use crate::{Pose, SupportMap, SupportPoint};

    /// A shape that reads this number of bytes.
    struct Reads(usize);

    impl SupportMap for Reads {
        fn support_point(&self, _: DVec3) -> SupportPoint {
            SupportPoint { point: DVec3::ZERO, feature: 0 }
        }
        fn interior_point(&self) -> DVec3 {
            DVec3::ZERO
        }
        fn inner_radius(&self) -> f64 {
            0.0
        }
        fn outer_radius(&self) -> f64 {
            0.0
        }
        fn working_set_len(&self) -> usize {
            self.0
        }
    }

    impl Shape for Reads {}

    /// The plans of support queries, of intersection tests and of contacts, for `count` pairs of
    /// `different` shapes of `bytes` each.
    fn plans(different: usize, bytes: usize, count: usize) -> [Plan; 3] {
        let mut rng = SplitMix64::new(9);
        let shapes: Vec<Reads> = (0..different).map(|_| Reads(bytes)).collect();
        let floor = Reads(0);
        let pairs: Vec<_> =
            (0..count).map(|_| Pair { a: &floor, b: &shapes[rng.below(different)], b_in_a: Pose::IDENTITY }).collect();
        let of_shapes = Plan::of_shapes(count, |at| pairs.get(at).map(|pair| pair.b));
        [of_shapes, Plan::of_pairs(&pairs), Plan::of_contacts(&pairs)]
    }

    #[test]
    fn only_many_large_shapes_are_more_than_a_loop() {
        use Plan::{Ahead, InFlight, Loop};
        for (different, bytes, count) in
            [(1, 60_000, 100_000), (16, 8_000, 100_000), (10_000, 0, 10_000), (50, 8_000, 100), (50, 8_000, 8_192)]
        {
            assert_eq!(plans(different, bytes, count), [Loop; 3]);
        }
        assert_eq!(plans(1, 8_000, 0), [Loop; 3]);
        assert_eq!(plans(10_000, 900, 8_192), [Ahead; 3]);
        assert_eq!(plans(200, 8_000, 8_192), [Ahead; 3]);
        assert_eq!(plans(1_000, 8_000, 8_192), [InFlight, InFlight, Ahead]);
        assert_eq!(plans(8_000, 8_000, 8_192), [InFlight, InFlight, Ahead]);
        assert_eq!(plans(60, 60_000, 8_192), [InFlight; 3]);
        assert_eq!(plans(1_000, 30_000, 8_192), [InFlight; 3]);
        assert_eq!(plans(3, LARGE, 3), [InFlight; 3]);
    }
}
