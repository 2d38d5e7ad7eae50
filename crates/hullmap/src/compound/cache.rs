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
    entries: Box<[Entry]>,
    first: Option<[usize; 2]>,
    /// The entry whose cache has the scratch memory, if any was lent.
    lent_to: Option<usize>,
}

#[derive(Clone, Debug, Default)]
struct Entry {
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
    /// An empty cache with `pairs` entries, at least one. A pair of hulls is assigned to an entry
    /// by its indices; if two pairs share an entry, the later one replaces the earlier one.
    pub fn new(pairs: usize) -> Self {
        Self { entries: vec![Entry::default(); pairs.max(1)].into_boxed_slice(), first: None, lent_to: None }
    }

    /// Clears all entries.
    pub fn clear(&mut self) {
        self.first = None;
        for entry in &mut self.entries {
            entry.pair = None;
            entry.cache.clear();
        }
    }

    /// Lends scratch memory to the queries that use this cache, as [`Cache::set_scratch`] does.
    pub fn set_scratch(&mut self, scratch: Box<Scratch>) {
        self.take_scratch();
        if let Some(entry) = self.entries.first_mut() {
            entry.cache.set_scratch(scratch);
            self.lent_to = Some(0);
        }
    }

    /// Returns the scratch memory that the cache was lent, if any.
    pub fn take_scratch(&mut self) -> Option<Box<Scratch>> {
        self.entries.get_mut(self.lent_to.take()?)?.cache.take_scratch()
    }

    /// Solver cache of one pair of hulls, by their indices in A and in B. It is empty if the pair
    /// was not cached. Use it for queries of this pair only.
    #[expect(clippy::indexing_slicing, reason = "taken modulo the number of entries, which is at least one")]
    pub fn pair(&mut self, pair: [usize; 2]) -> &mut Cache {
        // The factor sends neighbouring pairs to different entries.
        let index = (pair[0].wrapping_mul(31).wrapping_add(pair[1])) % self.entries.len();
        // Move the scratch memory to the cache in use.
        if self.lent_to.is_some_and(|lent_to| lent_to != index)
            && let Some(scratch) = self.take_scratch()
        {
            self.entries[index].cache.set_scratch(scratch);
            self.lent_to = Some(index);
        }
        let entry = &mut self.entries[index];
        if entry.pair != Some(pair) {
            entry.pair = Some(pair);
            entry.cache.clear();
        }
        &mut entry.cache
    }

    /// The pair that decided the last query, if it exists in compounds with this many parts.
    pub(super) fn first(&self, counts: [usize; 2]) -> Option<[usize; 2]> {
        self.first.filter(|pair| pair[0] < counts[0] && pair[1] < counts[1])
    }

    pub(super) fn set_first(&mut self, pair: [usize; 2]) {
        self.first = Some(pair);
    }
}
