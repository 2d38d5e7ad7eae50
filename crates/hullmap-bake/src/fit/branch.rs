//! Branch and bound: the maximum of a function over a set of cells.
//!
//! # Steps
//! 1. Measure each cell: an upper bound over the cell, and the value at one of its points.
//! 2. Split the cell with the greatest bound, and measure its halves.
//! 3. Stop when the greatest bound is accurate enough, after a number of measurements, or at a
//!    deadline. The bound holds at any time.

use std::{cmp::Ordering, collections::BinaryHeap};

use glam::DVec3;

use crate::deadline::{Deadline, is_over};

/// Number of measurements after which the time is compared with a deadline.
pub const LOOK: usize = 64;

/// When a bound is accurate enough. The first criterion that applies ends the search; the bound
/// holds in each case.
#[derive(Clone, Copy, Debug)]
pub struct Accuracy {
    /// A sufficient bound. A greater value also ends the search, since it decides the comparison.
    pub limit: Option<f64>,
    /// A bound of at most this length is accurate enough.
    pub floor: f64,
    /// Maximum difference between the bound and the value reached, relative to the bound.
    pub relative: f64,
    /// Maximum difference between the bound and the value reached, as a length.
    pub absolute: f64,
    /// Number of measurements after which no more cells are split. Each cell that is given is
    /// measured at least once.
    pub measurements: usize,
    /// When no more cells are split.
    pub deadline: Option<Deadline>,
}

impl Accuracy {
    /// An accuracy of 0.5 %, or of 1e-5 of `diagonal`.
    pub fn tight(diagonal: f64) -> Self {
        let absolute = 1e-5 * diagonal;
        Self { limit: None, floor: 0.0, relative: 0.005, absolute, measurements: 100_000, deadline: None }
    }

    /// Decides whether the maximum is at most `limit`.
    pub fn decide(limit: f64) -> Self {
        Self { limit: Some(limit), floor: 0.0, relative: 0.0, absolute: 0.0, measurements: 100_000, deadline: None }
    }

    /// Whether a bound is accurate enough, given the value reached. NaN is accurate enough, so that
    /// the search ends.
    fn is_enough(&self, bound: f64, reached: f64) -> bool {
        let is_decided = self.limit.is_some_and(|limit| bound <= limit || reached > limit);
        is_decided || bound <= self.floor || !(bound - reached > (self.relative * bound).max(self.absolute))
    }
}

/// Known bounds of a cell.
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    /// Upper bound over the cell.
    pub bound: f64,
    /// Value at a point of the cell, or a lower value.
    pub reached: f64,
    /// That point.
    pub at: DVec3,
}

/// Known bounds of the maximum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Maximum {
    /// Upper bound.
    pub bound: f64,
    /// Greatest value found; 0 if none is greater.
    pub reached: f64,
    /// Where it was found.
    pub at: DVec3,
    /// Number of measurements made.
    pub measurements: usize,
}

/// A cell in a queue, of which the one with the greatest bound is the first.
pub struct Entry<C> {
    /// Upper bound over the cell.
    pub bound: f64,
    /// Number of the cell, by which ties are decided: the lowest is the first.
    pub index: usize,
    /// The cell.
    pub cell: C,
}

impl<C> PartialEq for Entry<C> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<C> Eq for Entry<C> {}

impl<C> PartialOrd for Entry<C> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<C> Ord for Entry<C> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound).then(other.index.cmp(&self.index))
    }
}

/// The maximum over `cells`. The result depends only on the arguments.
///
/// `measure` receives a cell and the greatest value reached so far; smaller values need not be
/// precise. The halves of `split` must cover the cell.
///
/// # Complexity
/// One measurement per cell and two per split, O(log n) for the queue.
pub fn maximum<C>(
    cells: impl IntoIterator<Item = C>,
    accuracy: &Accuracy,
    mut measure: impl FnMut(&mut C, f64) -> Measured,
    split: impl Fn(&C) -> [C; 2],
) -> Maximum {
    let mut queue = BinaryHeap::new();
    let mut found = Maximum { bound: 0.0, reached: 0.0, at: DVec3::ZERO, measurements: 0 };
    let mut add = |mut cell: C, parent: f64, queue: &mut BinaryHeap<Entry<C>>, found: &mut Maximum| {
        let Measured { bound, reached, at } = measure(&mut cell, found.reached);
        if reached > found.reached || found.measurements == 0 {
            (found.reached, found.at) = (reached.max(found.reached), at);
        }
        found.measurements += 1;
        // A half is bounded by its parent's bound as well.
        let bound = bound.min(parent);
        if bound > 0.0 {
            queue.push(Entry { bound, index: found.measurements, cell });
        }
    };
    for cell in cells {
        add(cell, f64::INFINITY, &mut queue, &mut found);
    }
    let mut splits = 0_usize;
    while let Some(top) = queue.peek() {
        found.bound = top.bound.max(found.reached);
        let is_late = || splits.is_multiple_of(LOOK) && is_over(accuracy.deadline);
        let is_spent = found.measurements >= accuracy.measurements || is_late();
        if accuracy.is_enough(found.bound, found.reached) || is_spent {
            return found;
        }
        splits += 1;
        let Some(Entry { bound, cell, .. }) = queue.pop() else { break };
        for half in split(&cell) {
            add(half, bound, &mut queue, &mut found);
        }
    }
    found.bound = found.reached;
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn greatest_square(deadline: Option<Deadline>) -> (f64, usize) {
        let measure = |cell: &mut [f64; 2], _: f64| {
            let [low, high] = *cell;
            Measured { bound: high * high, reached: low * low, at: DVec3::ZERO }
        };
        let split = |[low, high]: &[f64; 2]| {
            let middle = 0.5 * (low + high);
            [[*low, middle], [middle, *high]]
        };
        let cells = (0..10).map(|i| [0.1 * f64::from(i), 0.1 * f64::from(i + 1)]);
        let accuracy = Accuracy { relative: 1e-9, absolute: 0.0, deadline, ..Accuracy::tight(1.0) };
        let found = maximum(cells, &accuracy, measure, split);
        (found.bound, found.measurements)
    }

    #[test]
    fn after_the_deadline_nothing_is_split() {
        let (bound, measurements) = greatest_square(Some(Deadline::after(0.0)));
        assert!((bound - 1.0).abs() < 1e-9 && measurements == 10, "{bound} {measurements}");
        assert!(greatest_square(None).1 > 2 * measurements);
    }
}
