//! Temporal coherence of two compounds: solver caches of their recent pairs of hulls.

use crate::solver::{Cache, Scratch};

/// Caller-owned memory of one ordered pair of compounds.
///
/// Pass it to every query of that pair. It holds a [`Cache`] for each of the most recent pairs of
/// hulls, and the pair that decided the last query. It makes queries cheaper. It changes answers by
/// no more than rounding error. Its memory, about 1.4 KB per pair of hulls, is allocated once, by
/// [`new`](Self::new).
///
/// # Examples
/// ```
/// use hullmap::{Cache, CompoundCache};
///
/// let mut cache = CompoundCache::new(16);
/// // The solver cache for hull 0 of A and hull 3 of B, empty at first.
/// let pair: &mut Cache = cache.pair([0, 3]);
/// assert_eq!(*pair, Cache::new());
/// cache.clear();
/// ```
#[derive(Clone, Debug)]
pub struct CompoundCache {
    slots: Box<[Slot]>,
    first: Option<[usize; 2]>,
    /// The slot whose cache has the scratch memory, if any was lent.
    lent_to: Option<usize>,
}

#[derive(Clone, Debug, Default)]
struct Slot {
    pair: Option<[usize; 2]>,
    cache: Cache,
}

/// Default number of pairs of hulls: twice what two parts need that are each in contact with a
/// dozen others. 90 KB.
const DEFAULT_PAIRS: usize = 64;

impl Default for CompoundCache {
    fn default() -> Self {
        Self::new(DEFAULT_PAIRS)
    }
}

impl CompoundCache {
    /// An empty cache with `pairs` slots, at least one. A pair of hulls is assigned to a slot by
    /// its indices; if two pairs share a slot, the later one replaces the earlier one.
    pub fn new(pairs: usize) -> Self {
        Self { slots: vec![Slot::default(); pairs.max(1)].into_boxed_slice(), first: None, lent_to: None }
    }

    /// Clears all slots.
    pub fn clear(&mut self) {
        self.first = None;
        for slot in &mut self.slots {
            slot.pair = None;
            slot.cache.clear();
        }
    }

    /// Lends scratch memory to the queries that use this cache, as [`Cache::set_scratch`] does.
    pub fn set_scratch(&mut self, scratch: Box<Scratch>) {
        self.take_scratch();
        if let Some(slot) = self.slots.first_mut() {
            slot.cache.set_scratch(scratch);
            self.lent_to = Some(0);
        }
    }

    /// Returns the scratch memory that the cache was lent, if any.
    pub fn take_scratch(&mut self) -> Option<Box<Scratch>> {
        self.slots.get_mut(self.lent_to.take()?)?.cache.take_scratch()
    }

    /// Solver cache of one pair of hulls, by their indices in A and in B. It is empty if the pair
    /// was not cached. Use it for queries of this pair only.
    #[expect(clippy::indexing_slicing, reason = "taken modulo the number of slots, which is at least one")]
    pub fn pair(&mut self, pair: [usize; 2]) -> &mut Cache {
        // The factor sends neighbouring pairs to different slots.
        let index = (pair[0].wrapping_mul(31).wrapping_add(pair[1])) % self.slots.len();
        // Move the scratch memory to the cache in use.
        if self.lent_to.is_some_and(|lent_to| lent_to != index)
            && let Some(scratch) = self.take_scratch()
        {
            self.slots[index].cache.set_scratch(scratch);
            self.lent_to = Some(index);
        }
        let slot = &mut self.slots[index];
        if slot.pair != Some(pair) {
            slot.pair = Some(pair);
            slot.cache.clear();
        }
        &mut slot.cache
    }

    /// The pair that decided the last query, if it exists in compounds with this many parts.
    pub(super) fn first(&self, counts: [usize; 2]) -> Option<[usize; 2]> {
        self.first.filter(|pair| pair[0] < counts[0] && pair[1] < counts[1])
    }

    pub(super) fn set_first(&mut self, pair: [usize; 2]) {
        self.first = Some(pair);
    }
}
