//! What two compounds remember from one query to the next.

use super::Compound;
use crate::Cache;

/// Caller-owned memory of one ordered pair of compounds, to be passed to every query of that pair: a [`Cache`] for each of the pairs of
/// hulls that were asked lately, as many as it was made for, and the pair that decided last.
///
/// It changes what a query costs, never its answer beyond rounding. Memory is taken once, when it is made: some 1.4 KB a pair.
#[derive(Clone, Debug)]
pub struct CompoundCache {
    slots: Box<[Slot]>,
    first: Option<[usize; 2]>,
}

#[derive(Clone, Debug, Default)]
struct Slot {
    pair: Option<[usize; 2]>,
    cache: Cache,
}

/// Pairs of hulls that are remembered by default: two parts in contact with a dozen others, twice over. 90 KB.
const DEFAULT_PAIRS: usize = 64;

impl Default for CompoundCache {
    fn default() -> Self {
        Self::new(DEFAULT_PAIRS)
    }
}

impl CompoundCache {
    /// Room for `pairs` pairs of hulls, and for one at least. Pairs share places by their numbers: when two meet, the later one stays.
    pub fn new(pairs: usize) -> Self {
        Self { slots: vec![Slot::default(); pairs.max(1)].into_boxed_slice(), first: None }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.first = None;
        self.slots.iter_mut().for_each(|slot| *slot = Slot::default());
    }

    /// The cache of a pair of hulls, by their numbers in A and in B, for queries of this pair alone: its own, or an empty one.
    #[expect(clippy::indexing_slicing, reason = "taken modulo the number of slots, of which `new` makes one at least")]
    pub fn pair(&mut self, pair: [usize; 2]) -> &mut Cache {
        // Neighbouring pairs go to different places.
        let place = (pair[0].wrapping_mul(31).wrapping_add(pair[1])) % self.slots.len();
        let slot = &mut self.slots[place];
        if slot.pair != Some(pair) {
            slot.pair = Some(pair);
            slot.cache.clear();
        }
        &mut slot.cache
    }

    /// The pair that decided last, if these compounds have it.
    pub(super) fn first(&self, a: &Compound, b: &Compound) -> Option<[usize; 2]> {
        self.first.filter(|pair| pair[0] < a.hull_count() && pair[1] < b.hull_count())
    }

    pub(super) fn set_first(&mut self, pair: [usize; 2]) {
        self.first = Some(pair);
    }
}
