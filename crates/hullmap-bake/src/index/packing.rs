//! Leaves that list nearly the same vertices share their blocks.
//!
//! Neighbouring cells list overlapping sets: most leaves are not full, and what a leaf lists beyond its own cell's needs
//! costs nothing but a lane that would be idle. Leaves are taken in the order of the tree, neighbours after one another;
//! each joins the recent group that grows the least by it and still fits, or starts a new one.

use std::collections::VecDeque;

use super::subdivide::Tree;

/// Groups that a leaf may still join.
const WINDOW: usize = 256;

/// Replaces every leaf's list of at most `capacity` vertices by that of its group; longer lists stay as they are.
///
/// # Complexity
/// O(leaves · window).
pub fn share(trees: &mut [Tree], capacity: usize) {
    let mut groups = Groups { capacity, lists: Vec::new(), open: VecDeque::new() };
    let mut joined = Vec::new();
    for tree in trees.iter() {
        leaves(tree, &mut |list| joined.push(groups.join(list)));
    }
    let mut joined = joined.into_iter();
    for tree in trees {
        leaves_mut(tree, &mut |list| {
            if let Some(Some(group)) = joined.next() {
                list.clone_from(&groups.lists[group]);
            }
        });
    }
}

struct Groups {
    capacity: usize,
    lists: Vec<Vec<u32>>,
    /// The groups that may grow, most recent first.
    open: VecDeque<usize>,
}

impl Groups {
    /// The group that a leaf with this list joins; none for a list that is too long.
    fn join(&mut self, list: &[u32]) -> Option<usize> {
        if list.len() > self.capacity {
            return None;
        }
        let mut best = None;
        let mut least = usize::MAX;
        for (place, &group) in self.open.iter().enumerate() {
            let growth = missing(&self.lists[group], list);
            if growth < least && self.lists[group].len() + growth <= self.capacity {
                (best, least) = (Some(place), growth);
                if growth == 0 {
                    break;
                }
            }
        }
        let group = match best {
            // A group that grows by the whole list has nothing in common with it.
            Some(place) if least < list.len() => {
                let group = self.open.remove(place)?;
                merge(&mut self.lists[group], list);
                group
            }
            _ => {
                self.lists.push(list.to_vec());
                self.open.truncate(WINDOW - 1);
                self.lists.len() - 1
            }
        };
        self.open.push_front(group);
        Some(group)
    }
}

/// How many of `list` are not in `group`. Both ascend.
fn missing(group: &[u32], list: &[u32]) -> usize {
    let mut group = group.iter().peekable();
    list.iter()
        .filter(|v| {
            while group.next_if(|g| g < v).is_some() {}
            group.peek() != Some(v)
        })
        .count()
}

fn merge(group: &mut Vec<u32>, list: &[u32]) {
    group.extend_from_slice(list);
    group.sort_unstable();
    group.dedup();
}

fn leaves(tree: &Tree, visit: &mut impl FnMut(&[u32])) {
    match tree {
        Tree::Leaf(list) => visit(list),
        Tree::Axis(halves) | Tree::Plane(_, halves) => halves.iter().for_each(|half| leaves(half, visit)),
    }
}

fn leaves_mut(tree: &mut Tree, visit: &mut impl FnMut(&mut Vec<u32>)) {
    match tree {
        Tree::Leaf(list) => visit(list),
        Tree::Axis(halves) | Tree::Plane(_, halves) => halves.iter_mut().for_each(|half| leaves_mut(half, visit)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_keep_what_they_listed() {
        let lists: Vec<Vec<u32>> = (0..200_u32).map(|i| (i / 3..i / 3 + 2 + i % 5).collect()).collect();
        let mut tree = lists.iter().cloned().map(Tree::Leaf).reduce(|a, b| Tree::Axis(Box::new([a, b]))).unwrap();
        share(std::slice::from_mut(&mut tree), 8);
        let mut shared = Vec::new();
        leaves(&tree, &mut |list| shared.push(list.to_vec()));
        assert_eq!(shared.len(), lists.len());
        for (before, after) in lists.iter().zip(&shared) {
            assert!(after.len() <= 8 && missing(after, before) == 0, "{before:?} in {after:?}");
            assert!(after.is_sorted());
        }
        shared.sort();
        shared.dedup();
        assert!(shared.len() < 30, "{} groups of 68 vertices", shared.len());
    }
}
