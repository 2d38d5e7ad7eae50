//! Sets of lanes: faces or vertices of a small polytope.

use super::table::LANES;

/// Lanes of up to eight blocks, one bit each. A lane's index is that in all blocks as one slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LaneSet(u64);

impl LaneSet {
    pub(crate) const EMPTY: Self = Self(0);

    /// Adds the lanes of a block that are the bits of `lanes`.
    #[inline(always)]
    pub(crate) fn add_block(&mut self, block: usize, lanes: u32) {
        self.0 |= u64::from(lanes) << (LANES * block);
    }

    /// The lanes, ascending.
    #[inline(always)]
    pub(crate) fn iter(self) -> impl Iterator<Item = usize> {
        let mut bits = self.0;
        std::iter::from_fn(move || {
            let lane = bits.trailing_zeros();
            bits &= bits.wrapping_sub(1);
            (lane < u64::BITS).then_some(lane as usize)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_are_listed_in_ascending_order() {
        let mut set = LaneSet::EMPTY;
        assert_eq!(set.iter().count(), 0);
        set.add_block(7, 0b1000_0001);
        set.add_block(1, 0b101);
        set.add_block(1, 0b100);
        assert!(set.iter().eq([8, 10, 56, 63]));
    }
}
