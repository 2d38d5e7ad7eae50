//! Leaves that list nearly the same vertices share their blocks.
//!
//! Neighbouring cells list overlapping sets: most leaves are not full, and what a leaf lists beyond its own cell's needs
//! costs nothing but a lane that would be idle. Leaves are taken in the order of the tree, neighbours after one another;
//! each joins the recent group that shares a vertex with it, grows the least by it and still fits, or starts a new one. In a
//! second pass the groups join in the same way, whether they share a vertex or not.

use std::collections::VecDeque;

use super::subdivide::Tree;

/// Groups that a leaf may still join.
const WINDOW: usize = 256;

/// Groups with less than this part of their room left are not joined with others that they share nothing with.
const NEARLY_FULL: usize = 8;

/// Replaces every leaf's list of at most `capacity` vertices by that of its group; longer lists stay as they are.
///
/// # Complexity
/// O(leaves · window).
pub fn share(trees: &mut [Tree], capacity: usize) {
    let mut lists = Vec::new();
    for tree in trees.iter() {
        leaves(tree, &mut |list| lists.push(list.to_vec()));
    }
    let (of_leaf, groups) = join(lists, capacity, Partners::Overlapping);
    let (of_group, groups) = join(groups, capacity, Partners::Any);
    let mut of_leaf = of_leaf.into_iter();
    for tree in trees {
        leaves_mut(tree, &mut |list| {
            if let Some(group) = of_leaf.next() {
                list.clone_from(&groups[of_group[group]]);
            }
        });
    }
}

/// Which groups a list may join.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Partners {
    /// Those that list one of its vertices.
    Overlapping,
    /// All.
    Any,
}

/// Joins lists into groups of at most `capacity` vertices; a longer list stays alone. Returns the group of each list, and
/// the groups.
fn join(lists: Vec<Vec<u32>>, capacity: usize, partners: Partners) -> (Vec<usize>, Vec<Vec<u32>>) {
    let mut groups: Vec<Vec<u32>> = Vec::new();
    // The groups that may grow, most recent first.
    let mut open: VecDeque<usize> = VecDeque::new();
    let mut joined = Vec::with_capacity(lists.len());
    for list in lists {
        let mut best = None;
        let (mut least, closed) = match partners {
            Partners::Overlapping => (list.len(), capacity + 1),
            Partners::Any => (list.len() + 1, capacity - capacity / NEARLY_FULL),
        };
        if list.len() >= closed {
            groups.push(list);
            joined.push(groups.len() - 1);
            continue;
        }
        for (place, &group) in open.iter().enumerate() {
            let room = capacity.saturating_sub(groups[group].len());
            let growth = missing(&groups[group], &list);
            if growth < least && growth <= room {
                (best, least) = (Some(place), growth);
                if growth == 0 {
                    break;
                }
            }
        }
        let group = match best.and_then(|place| open.remove(place)) {
            Some(group) => {
                merge(&mut groups[group], &list);
                group
            }
            None => {
                groups.push(list);
                open.truncate(WINDOW - 1);
                groups.len() - 1
            }
        };
        if groups[group].len() < closed {
            open.push_front(group);
        }
        joined.push(group);
    }
    (joined, groups)
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
        Tree::Axis(halves) | Tree::Wedges(halves) | Tree::Plane(_, halves) => {
            halves.iter().for_each(|half| leaves(half, visit));
        }
        Tree::Fan(_, wedges) => leaves(wedges, visit),
    }
}

fn leaves_mut(tree: &mut Tree, visit: &mut impl FnMut(&mut Vec<u32>)) {
    match tree {
        Tree::Leaf(list) => visit(list),
        Tree::Axis(halves) | Tree::Wedges(halves) | Tree::Plane(_, halves) => {
            halves.iter_mut().for_each(|half| leaves_mut(half, visit));
        }
        Tree::Fan(_, wedges) => leaves_mut(wedges, visit),
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

    /// Lists that share nothing are joined where both fit; what is nearly full is left alone.
    #[test]
    fn the_second_pass_joins_what_shares_nothing() {
        let lists = vec![vec![0, 1, 2], vec![10, 11, 12], vec![20, 21], (30..37).collect(), vec![40], vec![50, 51, 52]];
        let (of_list, groups) = join(lists.clone(), 8, Partners::Overlapping);
        assert_eq!((of_list, groups.len()), ((0..6).collect(), 6), "the first pass finds nothing in common");
        let (of_list, groups) = join(lists.clone(), 8, Partners::Any);
        assert_eq!(of_list, [0, 0, 0, 1, 2, 2]);
        assert_eq!(groups, [vec![0, 1, 2, 10, 11, 12, 20, 21], (30..37).collect(), vec![40, 50, 51, 52]]);
        // The same in both passes, over a tree.
        let mut tree = lists.iter().cloned().map(Tree::Leaf).reduce(|a, b| Tree::Axis(Box::new([a, b]))).unwrap();
        share(std::slice::from_mut(&mut tree), 8);
        let mut at = 0;
        leaves(&tree, &mut |list| {
            assert_eq!(list, groups[of_list[at]]);
            at += 1;
        });
        assert_eq!(at, lists.len());
    }

    #[test]
    fn lists_longer_than_a_leaf_stay_as_they_are() {
        let lists = vec![(0..9).collect::<Vec<u32>>(), vec![0, 1], (0..9).collect(), vec![1, 2]];
        for partners in [Partners::Overlapping, Partners::Any] {
            let (of_list, groups) = join(lists.clone(), 8, partners);
            assert_eq!(of_list, [0, 1, 2, 1]);
            assert_eq!(groups, [(0..9).collect(), vec![0, 1, 2], (0..9).collect::<Vec<u32>>()]);
        }
    }
}
