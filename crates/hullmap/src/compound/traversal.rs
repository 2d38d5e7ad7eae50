//! Dual-tree traversal of two BVHs, pairs with the least bound first.
//!
//! In each pair of nodes, the larger node is opened. Its two children, paired with the other node,
//! are pushed onto a stack, the nearer one on top. Each step opens one node, so the stack is at
//! most one entry longer than the sum of the depths of both trees.

use arrayvec::ArrayVec;
use hullmap_format::bvh::MAX_LEVELS;

use super::bvh::{Child, Node, Nodes, PlacedBox, Placement};

const MAX_STACK: usize = 2 * MAX_LEVELS as usize + 1;

#[cfg(test)]
thread_local! {
    /// Number of pairs of boxes compared by all traversals of this thread.
    pub(super) static BOXES: std::cell::Cell<u32> = const { std::cell::Cell::new(0) };
}

/// Two BVHs, and a lower bound for the pairs of hulls below two of their boxes.
pub(super) trait BoxPairs {
    /// Facts about a box of B that do not depend on the box of A.
    type Placed: Copy;

    fn nodes(&self) -> [Nodes<'_>; 2];

    fn placed(&self, b: &Node) -> Self::Placed;

    /// The lower bound of a pair of boxes, and a number that orders pairs with equal bounds.
    /// `outer` is the bound of the pair of boxes that this pair is inside of. A bound above `reach`
    /// need not be tight.
    fn bound(&mut self, a: &Node, b: &Self::Placed, outer: f64, reach: f64) -> [f64; 2];
}

/// The bound is the distance of the boxes; the distance of their centres orders equal ones.
impl BoxPairs for Placement<'_> {
    type Placed = PlacedBox;

    fn nodes(&self) -> [Nodes<'_>; 2] {
        [self.a, self.b]
    }

    fn placed(&self, b: &Node) -> PlacedBox {
        Self::placed(self, b)
    }

    #[inline]
    fn bound(&mut self, a: &Node, b: &PlacedBox, _: f64, reach: f64) -> [f64; 2] {
        [self.distance_lower_bound(a, b, reach), b.center_distance_sq(a)]
    }
}

/// Iterates over the pairs of hulls below boxes whose bound is at most some number: for a
/// [`Placement`], whose boxes are within a distance of each other.
pub(super) struct Traversal<P: BoxPairs> {
    pairs: P,
    /// The last box of B, by its index.
    placed: Option<(u32, Node, P::Placed)>,
    stack: ArrayVec<(u32, u32, f64), MAX_STACK>,
    boxes: u32,
    /// Lower bound of the boxes of the last pair returned.
    lower_bound: f64,
    /// Maximum of `boxes`: the number of pairs of nodes.
    max_boxes: u64,
}

impl<P: BoxPairs> Traversal<P> {
    pub(super) fn new(pairs: P) -> Self {
        let max_boxes = pairs.nodes().map(|nodes| nodes.count() as u64).into_iter().product();
        let mut this = Self { pairs, placed: None, stack: ArrayVec::new(), boxes: 0, lower_bound: 0.0, max_boxes };
        if let Some((_, _, lower_bound, _)) = this.pair(0, 0, 0.0, f64::INFINITY) {
            this.stack.push((0, 0, lower_bound));
        }
        this
    }

    pub(super) fn boxes(&self) -> u32 {
        self.boxes
    }

    /// Lower bound of the pair of hulls that was returned last.
    pub(super) fn lower_bound(&self) -> f64 {
        self.lower_bound
    }

    /// Minimum lower bound of all pairs that are left; infinite if there are none.
    pub(super) fn least_bound(&self) -> f64 {
        self.stack.iter().fold(f64::INFINITY, |least, pair| least.min(pair.2))
    }

    pub(super) fn pairs(&mut self) -> &mut P {
        &mut self.pairs
    }

    /// The next pair of hulls whose bound is at most `reach`, by index.
    pub(super) fn next(&mut self, reach: f64) -> Option<[usize; 2]> {
        self.next_within(|_, _| reach)
    }

    /// The next pair of hulls whose bound is at most `reach`, which may depend on the boxes.
    /// The reach of smaller boxes must not be greater.
    pub(super) fn next_within(&mut self, reach: impl Fn(&Node, &Node) -> f64) -> Option<[usize; 2]> {
        while let Some((node_a, node_b, lower_bound)) = self.stack.pop() {
            let a = self.pairs.nodes()[0].get(node_a)?;
            self.place(node_b)?;
            let Some((_, b, _)) = &self.placed else { return None };
            // Written so that a NaN would not skip the pair.
            let reach = reach(&a, b);
            if lower_bound > reach {
                continue;
            }
            let opens_a = match (a.child, b.child) {
                (Child::Hull(hull_a), Child::Hull(hull_b)) => {
                    self.lower_bound = lower_bound;
                    return Some([hull_a, hull_b]);
                }
                (Child::Nothing, _) | (_, Child::Nothing) => continue,
                (Child::Nodes(_), Child::Hull(_)) => true,
                (Child::Hull(_), Child::Nodes(_)) => false,
                (Child::Nodes(_), Child::Nodes(_)) => a.size_sq() > b.size_sq(),
            };
            let pairs = match (opens_a, a.child, b.child) {
                // Children follow their parents, except in a damaged pack that was opened
                // unchecked. The traversal must end there as well.
                (true, Child::Nodes(first), _) if first > node_a => {
                    [(first, node_b), (first.saturating_add(1), node_b)]
                }
                (false, _, Child::Nodes(first)) if first > node_b => {
                    [(node_a, first), (node_a, first.saturating_add(1))]
                }
                _ => return None,
            };
            let [first, second] = pairs;
            let first = self.pair(first.0, first.1, lower_bound, reach)?;
            let second = self.pair(second.0, second.1, lower_bound, reach)?;
            let is_nearer = (first.2, first.3) <= (second.2, second.3);
            for (node_a, node_b, lower_bound, _) in if is_nearer { [second, first] } else { [first, second] } {
                // Boxes with an infinite bound never meet, whatever the reach is. The stack is full
                // only in trees that are deeper than in checked packs.
                if lower_bound <= reach && lower_bound < f64::INFINITY {
                    let _ = self.stack.try_push((node_a, node_b, lower_bound));
                }
            }
        }
        None
    }

    /// The pair of nodes, the lower bound of their boxes, and the number that orders equal ones.
    ///
    /// `None` if a node is missing, or if all pairs of nodes have been compared: the traversal of
    /// trees visits each pair once, so a longer one is in a cycle.
    #[inline]
    fn pair(&mut self, a: u32, b: u32, outer: f64, reach: f64) -> Option<(u32, u32, f64, f64)> {
        if u64::from(self.boxes) >= self.max_boxes {
            return None;
        }
        self.place(b)?;
        let (node_a, Some((_, node_b, placed))) = (self.pairs.nodes()[0].get(a)?, &self.placed) else { return None };
        self.boxes += 1;
        #[cfg(test)]
        BOXES.set(BOXES.get() + 1);
        let [lower_bound, order] = if node_a.child == Child::Nothing || node_b.child == Child::Nothing {
            [f64::INFINITY; 2]
        } else {
            self.pairs.bound(&node_a, placed, outer, reach)
        };
        Some((a, b, lower_bound, order))
    }

    /// Makes a box of B the last one; `None` if it is missing.
    #[inline]
    fn place(&mut self, index: u32) -> Option<()> {
        if self.placed.as_ref().is_none_or(|(known, _, _)| *known != index) {
            let node = self.pairs.nodes()[1].get(index)?;
            self.placed = Some((index, node, self.pairs.placed(&node)));
        }
        Some(())
    }
}
