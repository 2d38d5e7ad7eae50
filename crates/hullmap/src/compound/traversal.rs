//! Dual-tree traversal of two BVHs, pairs with the least bound first.
//!
//! Of each pair of nodes, the larger node is opened. Its two children, paired with the other node,
//! are pushed onto a stack, the nearer one on top. Each step opens one node, so the stack is at
//! most one entry longer than the sum of the depths of both trees.

use hullmap_format::bvh::MAX_LEVELS;

use super::bvh::{Child, Node, Nodes, Placement};

const MAX_STACK: usize = 2 * MAX_LEVELS as usize + 1;

/// Two BVHs, and a lower bound for the pairs of hulls below two of their boxes.
pub(super) trait BoxPairs {
    /// The BVHs of A and of B.
    fn nodes(&self) -> [Nodes<'_>; 2];

    /// The lower bound of a pair of boxes, and a number that orders pairs with equal bounds.
    /// `outer` is the bound of the pair of boxes that this pair is inside of.
    fn bound(&mut self, a: &Node, b: &Node, outer: f64) -> [f64; 2];
}

/// The bound is the distance of the boxes; the distance of their centres orders equal ones.
impl BoxPairs for Placement<'_> {
    fn nodes(&self) -> [Nodes<'_>; 2] {
        [self.a, self.b]
    }

    fn bound(&mut self, a: &Node, b: &Node, _: f64) -> [f64; 2] {
        [self.distance_lower_bound(a, b), self.center_distance_sq(a, b)]
    }
}

/// Iterates over the pairs of hulls below boxes whose bound is at most some number: for a
/// [`Placement`], whose boxes are within a distance of each other.
pub(super) struct Traversal<P> {
    pairs: P,
    stack: [(u32, u32, f64); MAX_STACK],
    len: usize,
    boxes: u32,
    /// Lower bound of the boxes of the last pair returned.
    lower_bound: f64,
    /// Maximum of `boxes`: the number of pairs of nodes.
    max_boxes: u64,
}

impl<P: BoxPairs> Traversal<P> {
    pub(super) fn new(pairs: P) -> Self {
        let max_boxes = pairs.nodes().map(|nodes| nodes.count() as u64).into_iter().product();
        let mut this = Self { pairs, stack: [(0, 0, 0.0); MAX_STACK], len: 0, boxes: 0, lower_bound: 0.0, max_boxes };
        if let Some((_, _, lower_bound, _)) = this.pair(0, 0, 0.0) {
            this.push((0, 0, lower_bound));
        }
        this
    }

    /// Number of pairs of boxes compared so far.
    pub(super) fn boxes(&self) -> u32 {
        self.boxes
    }

    /// Lower bound of the pair of hulls that was returned last.
    pub(super) fn lower_bound(&self) -> f64 {
        self.lower_bound
    }

    /// Minimum lower bound of all pairs that are left; infinite if there are none.
    pub(super) fn least_bound(&self) -> f64 {
        self.stack.iter().take(self.len).fold(f64::INFINITY, |least, pair| least.min(pair.2))
    }

    /// What gives the bounds.
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
        while let Some(top) = self.len.checked_sub(1) {
            let (node_a, node_b, lower_bound) = *self.stack.get(top)?;
            self.len = top;
            let [nodes_a, nodes_b] = self.pairs.nodes();
            let (a, b) = (nodes_a.get(node_a)?, nodes_b.get(node_b)?);
            // Written so that a NaN would not skip the pair.
            let reach = reach(&a, &b);
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
            let [Some(first), Some(second)] = pairs.map(|(a, b)| self.pair(a, b, lower_bound)) else { return None };
            let is_nearer = (first.2, first.3) <= (second.2, second.3);
            for (node_a, node_b, lower_bound, _) in if is_nearer { [second, first] } else { [first, second] } {
                // Boxes with an infinite bound never meet, whatever the reach is.
                if lower_bound <= reach && lower_bound < f64::INFINITY {
                    self.push((node_a, node_b, lower_bound));
                }
            }
        }
        None
    }

    /// Drops the pair if the stack is full, which requires trees deeper than those of checked
    /// packs.
    fn push(&mut self, pair: (u32, u32, f64)) {
        if let Some(slot) = self.stack.get_mut(self.len) {
            *slot = pair;
            self.len += 1;
        }
    }

    /// The pair of nodes, the lower bound of their boxes, and the number that orders equal ones.
    ///
    /// `None` if a node is missing, or if all pairs of nodes have been compared: the traversal of
    /// trees visits each pair once, so a longer one is in a cycle.
    fn pair(&mut self, a: u32, b: u32, outer: f64) -> Option<(u32, u32, f64, f64)> {
        if u64::from(self.boxes) >= self.max_boxes {
            return None;
        }
        let [nodes_a, nodes_b] = self.pairs.nodes();
        let (node_a, node_b) = (nodes_a.get(a)?, nodes_b.get(b)?);
        self.boxes += 1;
        let [lower_bound, order] = if node_a.child == Child::Nothing || node_b.child == Child::Nothing {
            [f64::INFINITY; 2]
        } else {
            self.pairs.bound(&node_a, &node_b, outer)
        };
        Some((a, b, lower_bound, order))
    }
}
