//! Several queries in flight in one thread: while the memory that one query needs is on its way,
//! the others compute.
//!
//! A look-up in a hull that is in no cache waits for two or three dependent cache misses. One query
//! needs the answer before it can state its next direction, so it waits for each of them. The
//! queries of a batch do not depend on each other.
//!
//! 1. Each of [`LANES`] lanes holds a suspended test, which has told the processor what to fetch: a
//!    word of a direction index, or the blocks of a leaf.
//! 2. The lanes take turns. Each continues up to the next memory that it reads, by when the others
//!    have given its turn some 100 ns.
//! 3. A lane that is done takes the next pair, whose shapes have been fetched in the meantime.
//!
//! The bits of the answers are those of single queries. Suspending costs time when everything is in
//! the first caches, so a batch does it only if its shapes are larger ([`is_worthwhile`]).
//!
//! # Tried and rejected
//! Fetching only the blocks of a leaf, with the words above it read at once, saved nothing: a
//! branch that is predicted wrongly keeps the processor from starting on the next lane until the
//! word has come.

use super::{Pair, SupportQuery};
use crate::shapes::Shape;
use crate::solver::{Cache, Intersection, Suspended, queries};
use crate::support::simd::fetch_start;
use crate::support::{Lookup, SupportPoint};

/// Number of queries in flight. A processor core can wait for 10 to 16 cache lines at a time.
const LANES: usize = 8;

/// Working set from which queries are kept in flight, in bytes: what the second-level caches of
/// current processors hold.
const LARGE: usize = 2 << 20;

/// Number of shapes that are looked at to estimate the working set.
const SAMPLES: usize = 128;

/// Number of bits of the set of shapes seen: enough that two of the samples rarely share a bit.
const SEEN_BITS: usize = 4096;

/// Whether the shapes are so large together that queries wait for memory.
///
/// Looks at s ≤ [`SAMPLES`] of `count` shapes. Of s samples from many shapes N, about s² / 2N are
/// the same as an earlier one, which gives an estimate of N. Few shapes have all been seen.
///
/// # Complexity
/// O(1).
pub(super) fn is_worthwhile<'s, S: Shape + ?Sized + 's>(count: usize, shape: impl Fn(usize) -> Option<&'s S>) -> bool {
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
    let estimate = bytes.saturating_mul(shapes) / different.max(1);
    estimate >= LARGE
}

/// [`crate::intersects`] of all pairs. The slices have equal lengths.
pub(super) fn intersects<A, B>(pairs: &[Pair<'_, A, B>], caches: &mut [Cache], out: &mut [Intersection])
where
    A: Shape + ?Sized,
    B: Shape + ?Sized,
{
    let mut lanes = [const { None::<(usize, Suspended<'_, A, B>)> }; LANES];
    let mut rest = 0..pairs.len();
    let mut write = |at: usize, answer| {
        if let Some(slot) = out.get_mut(at) {
            *slot = answer;
        }
    };
    // Starts the next test that takes a support query.
    let mut start = |caches: &mut [Cache], write: &mut dyn FnMut(usize, Intersection)| {
        for at in rest.by_ref() {
            if let Some(ahead) = pairs.get(at + LANES) {
                fetch_start(ahead.a);
                fetch_start(ahead.b);
            }
            let (Some(Pair { a, b, b_in_a }), Some(cache)) = (pairs.get(at), caches.get_mut(at)) else { break };
            if a.convex_radius() + b.convex_radius() > 0.0 {
                write(at, queries::intersects(*a, *b, *b_in_a, cache));
                continue;
            }
            match Suspended::start(*a, *b, *b_in_a, cache) {
                Ok(test) => return Some((at, test)),
                Err(answer) => write(at, answer),
            }
        }
        None
    };
    for lane in &mut lanes {
        *lane = start(caches, &mut write);
    }
    while lanes.iter().any(Option::is_some) {
        for lane in &mut lanes {
            let Some((at, test)) = lane else { continue };
            let Some(cache) = caches.get_mut(*at) else { continue };
            if let Some(answer) = test.step(cache) {
                write(*at, answer);
                *lane = start(caches, &mut write);
            }
        }
    }
}

/// The support points of all queries. The slices have equal lengths.
pub(super) fn support_points<S: Shape + ?Sized>(queries: &[SupportQuery<'_, S>], out: &mut [SupportPoint]) {
    let mut ahead = queries.chunks(LANES).skip(1);
    for (queries, out) in queries.chunks(LANES).zip(out.chunks_mut(LANES)) {
        ahead.next().unwrap_or_default().iter().for_each(|query| fetch_start(query.shape));
        let mut lookups = [Lookup::Whole; LANES];
        for (lookup, query) in lookups.iter_mut().zip(queries) {
            *lookup = query.shape.start_lookup(query.dir);
        }
        while lookups.iter().any(|lookup| matches!(lookup, Lookup::Word { .. })) {
            for (lookup, query) in lookups.iter_mut().zip(queries) {
                *lookup = query.shape.continue_lookup(query.dir, *lookup);
            }
        }
        for ((query, lookup), out) in queries.iter().zip(lookups).zip(out) {
            *out = query.shape.finish_lookup(query.dir, lookup);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};
    use shapes::{families, rng::SplitMix64};

    use super::*;
    use crate::pack::Pack;
    use crate::shapes::{Cuboid, Sphere};
    use crate::{Hull, Overlap, Pose, SupportMap};

    fn packs() -> Vec<Pack> {
        // With a tree, without an index, flat, and a segment.
        let sheet = (0..9).map(|i| [(i % 3) as f32, (i / 3) as f32, 0.0]).collect();
        let sets = [
            families::rock(300, 1),
            families::sphere(20, 2),
            families::sphere(900, 3),
            families::cube_grid(64, 1),
            sheet,
            vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.5]],
        ];
        sets.map(|set: Vec<[f32; 3]>| Pack::from_bytes(&hullmap_testkit::packs::tree_bytes(&set)).unwrap()).into()
    }

    fn random_pose(rng: &mut SplitMix64) -> Pose {
        let rotation = DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize();
        // Some shapes are centred on each other, some far apart, most close to touching.
        let reach = [0.0, 1e6, 1.0, 1.5, 2.0, 2.2][rng.between(0.0, 6.0) as usize];
        Pose::new(DVec3::from_array(rng.direction()) * reach, rotation).unwrap()
    }

    /// Answers and caches of both ways are equal, on first queries and on warm ones.
    #[test]
    fn intersections_have_the_bits_of_single_queries() {
        let seed = 17;
        println!("seed {seed}");
        let mut rng = SplitMix64::new(seed);
        let packs = packs();
        let hulls: Vec<Hull<'_>> = packs.iter().map(|pack| pack.hull(0).unwrap()).collect();
        let (cube, ball) = (Cuboid::new(DVec3::ONE).unwrap(), Sphere::new(0.7).unwrap());
        let mut shapes: Vec<&(dyn Shape + Sync)> = hulls.iter().map(|hull| hull as _).collect();
        shapes.extend([&cube as &(dyn Shape + Sync), &ball]);
        let mut kinds = [0; 4];
        for count in [0, 1, 7, 8, 9, 64, 2000] {
            let mut pick = || shapes[(rng.between(0.0, shapes.len() as f64) as usize).min(shapes.len() - 1)];
            let chosen: Vec<_> = (0..count).map(|_| (pick(), pick())).collect();
            let mut single = vec![Cache::default(); count];
            let mut caches = single.clone();
            for _ in 0..3 {
                let pairs: Vec<_> =
                    chosen.iter().map(|(a, b)| Pair { a: *a, b: *b, b_in_a: random_pose(&mut rng) }).collect();
                let mut out = vec![Intersection::default(); count];
                intersects(&pairs, &mut caches, &mut out);
                for (((pair, cache), answer), cache_in_flight) in pairs.iter().zip(&mut single).zip(&out).zip(&caches) {
                    let expected = queries::intersects(pair.a, pair.b, pair.b_in_a, cache);
                    assert_eq!(*answer, expected);
                    assert_eq!(cache, cache_in_flight);
                    kinds[expected.status as usize] += 1;
                }
            }
        }
        let hits = kinds[Overlap::Overlapping as usize];
        assert!(hits > 1000 && kinds.iter().sum::<usize>() - hits > 1000, "{kinds:?}");
    }

    #[test]
    fn support_points_are_those_of_single_queries() {
        let packs = packs();
        let hulls: Vec<Hull<'_>> = packs.iter().map(|pack| pack.hull(0).unwrap()).collect();
        let cube = Cuboid::new(DVec3::ONE).unwrap();
        let mut shapes: Vec<&(dyn Shape + Sync)> = hulls.iter().map(|hull| hull as _).collect();
        shapes.push(&cube);
        let mut rng = SplitMix64::new(3);
        let odd = [0.0, f64::NAN, 1e300, 1e-300, 5e-324, f64::INFINITY, 1e-30, 1e38];
        let queries: Vec<_> = (0..4000)
            .map(|i| {
                let scale = if i % 5 == 0 { odd[i / 5 % odd.len()] } else { 1.0 };
                let axis = DVec3::AXES[i % 3];
                let dir = if i % 7 == 0 { axis } else { DVec3::from_array(rng.direction()) };
                SupportQuery { shape: shapes[i % shapes.len()], dir: dir * scale }
            })
            .collect();
        for count in [0, 1, 8, 9, 4000] {
            let mut out = vec![SupportPoint { point: DVec3::NAN, feature: 77 }; count];
            support_points(&queries[..count], &mut out);
            for (query, found) in queries.iter().zip(&out) {
                let expected = query.shape.support_point(query.dir);
                assert_eq!((found.point, found.feature), (expected.point, expected.feature), "{}", query.dir);
            }
        }
    }

    #[test]
    fn only_many_large_shapes_are_worthwhile() {
        struct Sized(usize);
        impl SupportMap for Sized {
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
        impl Shape for Sized {}
        let verdict = |different: usize, bytes: usize, count: usize| {
            let mut rng = SplitMix64::new(9);
            let shapes: Vec<Sized> = (0..different).map(|_| Sized(bytes)).collect();
            let chosen: Vec<_> = (0..count).map(|_| shapes.get(rng.between(0.0, different as f64) as usize)).collect();
            is_worthwhile(count, |at| chosen.get(at).copied().flatten())
        };
        assert!(!verdict(1, 60_000, 100_000));
        assert!(!verdict(16, 8_000, 100_000));
        assert!(!verdict(10_000, 0, 10_000));
        assert!(!verdict(100, 8_000, 100));
        assert!(!verdict(100, 8_000, 8_192));
        assert!(verdict(1_000, 8_000, 8_192));
        assert!(verdict(8_000, 8_000, 8_192));
        assert!(verdict(3, LARGE, 3));
        assert!(!verdict(0, 8_000, 0));
    }
}
