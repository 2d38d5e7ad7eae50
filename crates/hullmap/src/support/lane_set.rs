//! Sets of lanes and lists of blocks: faces or vertices of a small polytope.

use super::facet_table::LANES;

/// Number of blocks in a word.
const WORD: usize = u64::BITS as usize / LANES;

/// Maximum number of words.
const WORDS: usize = 4;

/// Lanes of `N` ≤ 32 blocks, one bit each. A lane's index is that in all blocks as one slice.
///
/// The set is made of words. The processor cannot forward bytes that were just stored to the load
/// of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LaneSet<const N: usize>([u64; WORDS]);

/// A list of at most `N` block indices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocks<const N: usize> {
    pub(crate) items: [u8; N],
    pub(crate) count: usize,
}

impl<const N: usize> Blocks<N> {
    /// The empty list.
    pub(crate) const NONE: Self = Self { items: [0; N], count: 0 };

    /// The first `count` blocks.
    #[inline(always)]
    pub(crate) fn first(count: usize) -> Self {
        let mut items = [0; N];
        for (index, item) in items.iter_mut().enumerate() {
            *item = index as u8;
        }
        Self { items, count: count.min(N) }
    }

    /// Adds a block. The list must not be full.
    #[cfg(test)]
    pub(crate) fn push(&mut self, block: usize) {
        self.items[self.count] = block as u8;
        self.count += 1;
    }

    #[inline(always)]
    pub(crate) fn iter(&self) -> impl Iterator<Item = usize> {
        self.items.iter().take(self.count).map(|item| usize::from(*item))
    }
}

impl<const N: usize> LaneSet<N> {
    /// Number of words in use.
    const USED: usize = {
        assert!(N <= WORD * WORDS);
        N.div_ceil(WORD)
    };

    /// No lane.
    pub(crate) const EMPTY: Self = Self([0; WORDS]);

    /// Adds the lanes of a block that are the bits of `lanes`.
    #[inline(always)]
    pub(crate) fn add_block(&mut self, block: usize, lanes: u32) {
        if let Some(word) = self.0.get_mut(block / WORD) {
            *word |= u64::from(lanes) << (LANES * (block % WORD));
        }
    }

    #[inline(always)]
    pub(crate) fn contains(&self, lane: usize) -> bool {
        self.0.get(lane / 64).is_some_and(|word| word >> (lane % 64) & 1 == 1)
    }

    #[inline(always)]
    pub(crate) fn insert(&mut self, lane: usize) {
        if let Some(word) = self.0.get_mut(lane / 64) {
            *word |= 1 << (lane % 64);
        }
    }

    #[inline(always)]
    pub(crate) fn remove(&mut self, lane: usize) {
        if let Some(word) = self.0.get_mut(lane / 64) {
            *word &= !(1 << (lane % 64));
        }
    }

    /// The lanes that are not in `other`.
    #[inline(always)]
    pub(crate) fn without(mut self, other: &Self) -> Self {
        for (word, other) in self.0.iter_mut().zip(&other.0).take(Self::USED) {
            *word &= !other;
        }
        self
    }

    /// Number of lanes in the set.
    #[inline(always)]
    pub(crate) fn len(&self) -> u32 {
        let mut len = 0;
        for word in self.0.iter().take(Self::USED) {
            len += word.count_ones();
        }
        len
    }

    /// The lanes, ascending.
    #[inline(always)]
    pub(crate) fn iter(self) -> impl Iterator<Item = usize> {
        let (mut at, [mut bits, ..]) = (0, self.0);
        std::iter::from_fn(move || {
            while bits == 0 {
                at += 1;
                bits = *self.0.get(at).filter(|_| at < Self::USED)?;
            }
            let bit = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            Some(at * 64 + bit)
        })
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use shapes::rng::SplitMix64;

    use super::*;

    /// Compares the sets with those of the standard library.
    fn compare<const N: usize>(rng: &mut SplitMix64) {
        let mut sets = [(); 2].map(|()| (LaneSet::<N>::EMPTY, BTreeSet::new()));
        for _ in 0..200 {
            let (lane, which) = (rng.below(N * LANES), rng.below(2));
            let (set, expected) = &mut sets[which];
            match rng.below(4) {
                0 => {
                    set.remove(lane);
                    expected.remove(&lane);
                }
                1 => {
                    set.add_block(lane / LANES, 0b1001);
                    expected.extend([lane / LANES * LANES, lane / LANES * LANES + 3]);
                }
                _ => {
                    set.insert(lane);
                    expected.insert(lane);
                }
            }
            assert!(set.iter().eq(expected.iter().copied()));
            assert_eq!((set.len() as usize, set.contains(lane)), (expected.len(), expected.contains(&lane)));
            let [(a, in_a), (b, in_b)] = &sets;
            assert!(a.without(b).iter().eq(in_a.difference(in_b).copied()));
        }
    }

    #[test]
    fn lane_sets_are_sets() {
        let mut rng = SplitMix64::new(17);
        for _ in 0..20 {
            compare::<1>(&mut rng);
            compare::<4>(&mut rng);
            compare::<8>(&mut rng);
            compare::<32>(&mut rng);
        }
    }
}
