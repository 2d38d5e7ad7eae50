//! Block packing: leaves that list nearly the same vertices share their blocks.
//!
//! The lists of neighbouring cells overlap, and most leaves are not full. An extra vertex in a leaf
//! costs nothing if it takes a lane that would be idle.
//!
//! 1. Leaves are processed in tree order, so that neighbours follow one another. Each leaf joins
//!    the recent group that shares the most vertices with it and has room for the rest. If there is
//!    no such group, the leaf starts a new one.
//! 2. A second pass joins the groups in the same way, whether or not they share a vertex.

use std::collections::VecDeque;

use super::subdivide::Tree;

/// Maximum number of recent groups that are considered: per vertex in the first pass, in total in
/// the second.
const WINDOW: usize = 64;

/// In the second pass, a group is closed if at most 1/`NEARLY_FULL` of its capacity is left.
const NEARLY_FULL: usize = 8;

/// Replaces each leaf's list of at most `capacity` vertices by the list of its group. Longer lists
/// are kept.
///
/// # Complexity
/// O(leaves) if each vertex is in few groups, O(leaves · window) if a vertex is in all of them.
pub fn share(trees: &mut [Tree], capacity: usize) {
    let mut lists = Vec::new();
    for tree in trees.iter() {
        leaves(tree, &mut |list| lists.push(list.to_vec()));
    }
    let (of_leaf, groups) = join_overlapping(lists, capacity);
    let (of_group, groups) = join_any(groups, capacity);
    let mut of_leaf = of_leaf.into_iter();
    for tree in trees {
        leaves_mut(tree, &mut |list| {
            if let Some(group) = of_leaf.next() {
                list.clone_from(&groups[of_group[group]]);
            }
        });
    }
}

/// Result of joining lists: the group of each list, and the groups.
type Joined = (Vec<usize>, Vec<Vec<u32>>);

/// Joins lists that share a vertex into groups of at most `capacity` vertices. A longer list stays
/// alone.
fn join_overlapping(lists: Vec<Vec<u32>>, capacity: usize) -> Joined {
    let mut groups: Vec<Vec<u32>> = Vec::new();
    // For each group: the number of vertices it shares with the current list, and the time of its
    // last change.
    let (mut shared, mut joined_at) = (Vec::<usize>::new(), Vec::<usize>::new());
    let vertex_count = lists.iter().flatten().max().map_or(0, |max| *max as usize + 1);
    let mut groups_of: Vec<Vec<usize>> = vec![Vec::new(); vertex_count];
    let mut joined = Vec::with_capacity(lists.len());
    let mut partners = Vec::new();
    for (time, list) in lists.into_iter().enumerate() {
        partners.clear();
        for vertex in &list {
            for &group in groups_of[*vertex as usize].iter().rev().take(WINDOW) {
                if shared[group] == 0 {
                    partners.push(group);
                }
                shared[group] += 1;
            }
        }
        let fits = |group: &usize| groups[*group].len() + list.len() - shared[*group] <= capacity;
        let best = partners.iter().copied().filter(fits).max_by_key(|group| (shared[*group], joined_at[*group]));
        partners.iter().for_each(|group| shared[*group] = 0);
        let group = best.unwrap_or(groups.len());
        if best.is_none() {
            groups.push(Vec::new());
            shared.push(0);
            joined_at.push(0);
        }
        if list.len() <= capacity {
            for vertex in list.iter().filter(|v| groups[group].binary_search(v).is_err()) {
                groups_of[*vertex as usize].push(group);
            }
        }
        merge(&mut groups[group], &list);
        joined_at[group] = time;
        joined.push(group);
    }
    (joined, groups)
}

/// Joins groups that have room left, whether or not they share a vertex.
fn join_any(lists: Vec<Vec<u32>>, capacity: usize) -> Joined {
    let closed = capacity - capacity / NEARLY_FULL;
    let mut groups: Vec<Vec<u32>> = Vec::new();
    // Groups that may still grow, most recent first.
    let mut open: VecDeque<usize> = VecDeque::new();
    let mut joined = Vec::with_capacity(lists.len());
    for list in lists {
        let grown = |group: usize| groups[group].len() + missing(&groups[group], &list);
        let fitting = open.iter().enumerate().filter(|(_, group)| grown(**group) <= capacity);
        let best = fitting.min_by_key(|(_, group)| missing(&groups[**group], &list)).map(|(index, _)| index);
        let best = best.filter(|_| list.len() < closed);
        let group = best.and_then(|index| open.remove(index)).unwrap_or(groups.len());
        if group == groups.len() {
            groups.push(Vec::new());
            open.truncate(WINDOW - 1);
        }
        merge(&mut groups[group], &list);
        if groups[group].len() < closed {
            open.push_front(group);
        }
        joined.push(group);
    }
    (joined, groups)
}

/// Number of entries of `list` that are not in `group`. Both must be ascending.
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
    fn leaves_keep_their_vertices() {
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

    /// Lists that share no vertex are joined if they fit together. A nearly full list is left
    /// alone.
    #[test]
    fn the_second_pass_joins_disjoint_lists() {
        let lists = vec![vec![0, 1, 2], vec![10, 11, 12], vec![20, 21], (30..37).collect(), vec![40], vec![50, 51, 52]];
        let (of_list, groups) = join_overlapping(lists.clone(), 8);
        assert_eq!((of_list, groups.len()), ((0..6).collect(), 6), "the first pass finds nothing in common");
        let (of_list, groups) = join_any(lists.clone(), 8);
        assert_eq!(of_list, [0, 0, 0, 1, 2, 2]);
        assert_eq!(groups, [vec![0, 1, 2, 10, 11, 12, 20, 21], (30..37).collect(), vec![40, 50, 51, 52]]);
        // The same result after both passes over a tree.
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
    fn lists_longer_than_a_leaf_are_kept() {
        let lists = vec![(0..9).collect::<Vec<u32>>(), vec![0, 1], (0..9).collect(), vec![1, 2]];
        for join in [join_overlapping, join_any] {
            let (of_list, groups) = join(lists.clone(), 8);
            assert_eq!(of_list, [0, 1, 2, 1]);
            assert_eq!(groups, [(0..9).collect(), vec![0, 1, 2], (0..9).collect::<Vec<u32>>()]);
        }
    }
}
