//! Two trees of boxes descended together, nearest first.
//!
//! Of a pair of nodes the larger one is opened. Its two children, each with the other node, go on a stack, the nearer one on top. Each
//! step opens one node of a path, so the stack is never longer than both trees are deep.

use hullmap_format::bvh::MAX_LEVELS;

use super::boxes::{Below, Node, Placement};

/// Pairs on the stack at most.
const STACK: usize = 2 * MAX_LEVELS as usize + 1;

/// Pairs of hulls whose boxes are near each other, one after the other.
pub(super) struct Descent<'q, 'a> {
    placement: Placement<'q, 'a>,
    stack: [(u32, u32, f64); STACK],
    len: usize,
    boxes: u32,
    /// Pairs of nodes there are.
    most_boxes: u64,
}

impl<'q, 'a> Descent<'q, 'a> {
    pub(super) fn new(placement: Placement<'q, 'a>) -> Self {
        let most_boxes = placement.a.node_count() as u64 * placement.b.node_count() as u64;
        let mut this = Self { placement, stack: [(0, 0, 0.0); STACK], len: 0, boxes: 0, most_boxes };
        if let Some((_, _, least, _)) = this.pair(0, 0) {
            this.push((0, 0, least));
        }
        this
    }

    /// Pairs of boxes compared so far.
    pub(super) fn boxes(&self) -> u32 {
        self.boxes
    }

    /// The next pair of hulls whose boxes are not farther from each other than `reach`.
    pub(super) fn next(&mut self, reach: f64) -> Option<[usize; 2]> {
        while let Some(top) = self.len.checked_sub(1) {
            let (number_a, number_b, least) = *self.stack.get(top)?;
            self.len = top;
            // NaN, of which there is none, would be looked at.
            if least > reach {
                continue;
            }
            let a = Node::of(self.placement.a, number_a)?;
            let b = Node::of(self.placement.b, number_b)?;
            let opens_a = match (a.below, b.below) {
                (Below::Hull(hull_a), Below::Hull(hull_b)) => return Some([hull_a, hull_b]),
                (Below::Nodes(_), Below::Hull(_)) => true,
                (Below::Hull(_), Below::Nodes(_)) => false,
                (Below::Nodes(_), Below::Nodes(_)) => a.size_sq() > b.size_sq(),
            };
            let pairs = match (opens_a, a.below, b.below) {
                // Children come after their parents; not in a damaged pack that was opened unchecked, where a walk must end too.
                (true, Below::Nodes(first), _) if first > number_a => {
                    [(first, number_b), (first.saturating_add(1), number_b)]
                }
                (false, _, Below::Nodes(first)) if first > number_b => {
                    [(number_a, first), (number_a, first.saturating_add(1))]
                }
                _ => return None,
            };
            let [Some(first), Some(second)] = pairs.map(|(a, b)| self.pair(a, b)) else { return None };
            let is_nearer = (first.2, first.3) <= (second.2, second.3);
            for (number_a, number_b, least, _) in if is_nearer { [second, first] } else { [first, second] } {
                if least <= reach {
                    self.push((number_a, number_b, least));
                }
            }
        }
        None
    }

    /// There is room, but in trees deeper than those of checked packs.
    fn push(&mut self, pair: (u32, u32, f64)) {
        if let Some(place) = self.stack.get_mut(self.len) {
            *place = pair;
            self.len += 1;
        }
    }

    /// The pair, the least distance of its boxes, and that of their middles squared.
    ///
    /// Nothing, too, once as many were compared as there are pairs of nodes: trees meet each pair once.
    fn pair(&mut self, a: u32, b: u32) -> Option<(u32, u32, f64, f64)> {
        if u64::from(self.boxes) >= self.most_boxes {
            return None;
        }
        let (node_a, node_b) = (Node::of(self.placement.a, a)?, Node::of(self.placement.b, b)?);
        self.boxes += 1;
        let least = self.placement.least_distance(&node_a, &node_b);
        Some((a, b, least, self.placement.middles_sq(&node_a, &node_b)))
    }
}
