//! Dual-tree traversal of two BVHs, nearest pairs first.
//!
//! Of each pair of nodes, the larger node is opened. Its two children, paired with the other node,
//! are pushed onto a stack, the nearer one on top. Each step opens one node, so the stack is at
//! most one entry longer than the sum of the depths of both trees.

use hullmap_format::bvh::MAX_LEVELS;

use super::bvh::{Child, Node, Placement};

const MAX_STACK: usize = 2 * MAX_LEVELS as usize + 1;

/// Iterates over the pairs of hulls whose boxes are within a distance of each other.
pub(super) struct Traversal<'q> {
    placement: Placement<'q>,
    stack: [(u32, u32, f64); MAX_STACK],
    len: usize,
    boxes: u32,
    /// Lower bound on the distance of the boxes of the last pair returned.
    lower_bound: f64,
    /// Maximum of `boxes`: the number of pairs of nodes.
    max_boxes: u64,
}

impl<'q> Traversal<'q> {
    pub(super) fn new(placement: Placement<'q>) -> Self {
        let max_boxes = placement.a.count() as u64 * placement.b.count() as u64;
        let mut this =
            Self { placement, stack: [(0, 0, 0.0); MAX_STACK], len: 0, boxes: 0, lower_bound: 0.0, max_boxes };
        if let Some((_, _, lower_bound, _)) = this.pair(0, 0) {
            this.push((0, 0, lower_bound));
        }
        this
    }

    /// Number of pairs of boxes compared so far.
    pub(super) fn boxes(&self) -> u32 {
        self.boxes
    }

    /// Lower bound on the distance of the pair of hulls that was returned last.
    pub(super) fn lower_bound(&self) -> f64 {
        self.lower_bound
    }

    /// The next pair of hulls whose boxes are at most `reach` apart, by index.
    pub(super) fn next(&mut self, reach: f64) -> Option<[usize; 2]> {
        self.next_within(|_, _| reach)
    }

    /// The next pair of hulls whose boxes are at most `reach` apart, which may depend on the boxes.
    /// The reach of smaller boxes must not be greater.
    pub(super) fn next_within(&mut self, reach: impl Fn(&Node, &Node) -> f64) -> Option<[usize; 2]> {
        while let Some(top) = self.len.checked_sub(1) {
            let (node_a, node_b, lower_bound) = *self.stack.get(top)?;
            self.len = top;
            let a = self.placement.a.get(node_a)?;
            let b = self.placement.b.get(node_b)?;
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
            let [Some(first), Some(second)] = pairs.map(|(a, b)| self.pair(a, b)) else { return None };
            let is_nearer = (first.2, first.3) <= (second.2, second.3);
            for (node_a, node_b, lower_bound, _) in if is_nearer { [second, first] } else { [first, second] } {
                if lower_bound <= reach {
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

    /// The pair of nodes, the lower bound on the distance of their boxes, and the squared distance
    /// of their centres.
    ///
    /// `None` if a node is missing, or if all pairs of nodes have been compared: the traversal of
    /// trees visits each pair once, so a longer one is in a cycle.
    fn pair(&mut self, a: u32, b: u32) -> Option<(u32, u32, f64, f64)> {
        if u64::from(self.boxes) >= self.max_boxes {
            return None;
        }
        let (node_a, node_b) = (self.placement.a.get(a)?, self.placement.b.get(b)?);
        self.boxes += 1;
        let lower_bound = self.placement.distance_lower_bound(&node_a, &node_b);
        Some((a, b, lower_bound, self.placement.center_distance_sq(&node_a, &node_b)))
    }
}
