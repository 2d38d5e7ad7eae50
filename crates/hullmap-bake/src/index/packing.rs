//! Block packing: leaves that list nearly the same vertices share their blocks.
//!
//! The lists of neighbouring cells overlap, and most leaves are not full. An extra vertex in a leaf
//! costs nothing if it takes a lane that would be idle.
//!
//! 1. In tree order, so that neighbours follow one another, each leaf joins the recent group that
//!    shares the most vertices with it and has room for the rest, or else starts a group.
//! 2. A second pass joins the groups in the same way, whether or not they share a vertex.

use std::collections::VecDeque;

use super::subdivide::Tree;

/// Maximum number of recent groups that are considered: per vertex in the first pass, in total in
/// the second.
const WINDOW: usize = 64;

/// In the second pass, a group is closed if at most 1/`NEARLY_FULL` of its capacity is left.
const NEARLY_FULL: usize = 8;

/// Replaces each leaf's list of at most `capacity` vertices by the list of its group.
///
/// # Complexity
/// O(leaves) if each vertex is in few groups, O(leaves · window) if a vertex is in all of them.
pub fn share(trees: &mut [Tree], capacity: usize) {
    let mut lists: Vec<&[u32]> = Vec::new();
    for tree in trees.iter() {
        leaves(tree, &mut |list| lists.push(list));
    }
    let (of_leaf, groups) = join_overlapping(&lists, capacity);
    drop(lists);
    let (of_group, groups) = join_any(groups, capacity);
    let mut of_leaf = of_leaf.into_iter();
    for tree in trees {
        leaves_mut(tree, &mut |list| {
            if let Some(group) = of_leaf.next() {
                list.clone_from(&groups[of_group[group as usize] as usize]);
            }
        });
    }
}

/// Result of joining lists: the group of each list, and the groups.
type Joined = (Vec<u32>, Vec<Vec<u32>>);

#[derive(Default)]
struct Overlap {
    vertices: Vec<u32>,
    shared: u32,
    joined_at: u32,
}

/// For each vertex, the groups that contain it, most recent first: linked lists in one array.
struct VertexGroups {
    last: Vec<u32>,
    /// A group, and the entry before it.
    entries: Vec<(u32, u32)>,
}

const END: u32 = u32::MAX;

impl VertexGroups {
    fn push(&mut self, vertex: u32, group: u32) {
        let entry = self.entries.len() as u32;
        self.entries.push((group, self.last[vertex as usize]));
        self.last[vertex as usize] = entry;
    }

    fn groups(&self, vertex: u32) -> impl Iterator<Item = u32> + '_ {
        let mut next = self.last[vertex as usize];
        std::iter::from_fn(move || {
            let (group, before) = *self.entries.get(next as usize)?;
            next = before;
            Some(group)
        })
    }
}

/// Joins lists that share a vertex into groups of at most `capacity` vertices. A longer list stays
/// alone.
fn join_overlapping<L: AsRef<[u32]>>(lists: &[L], capacity: usize) -> Joined {
    let mut groups: Vec<Overlap> = Vec::new();
    let vertices = lists.iter().flat_map(|list| list.as_ref());
    let vertex_count = vertices.max().map_or(0, |max| *max as usize + 1);
    let mut vertex_groups = VertexGroups { last: vec![END; vertex_count], entries: Vec::new() };
    let mut joined = Vec::with_capacity(lists.len());
    let mut partners: Vec<u32> = Vec::new();
    for (time, list) in (0..).zip(lists) {
        let list = list.as_ref();
        partners.clear();
        for vertex in list {
            for group in vertex_groups.groups(*vertex).take(WINDOW) {
                let overlap = &mut groups[group as usize];
                if overlap.shared == 0 {
                    partners.push(group);
                }
                overlap.shared += 1;
            }
        }
        let of = |group: &u32| &groups[*group as usize];
        let fits = |group: &u32| of(group).vertices.len() + list.len() - of(group).shared as usize <= capacity;
        let key = |group: &u32| (of(group).shared, of(group).joined_at);
        let best = partners.iter().copied().filter(fits).max_by_key(key);
        partners.iter().for_each(|group| groups[*group as usize].shared = 0);
        let group = best.unwrap_or(groups.len() as u32);
        if best.is_none() {
            groups.push(Overlap::default());
        }
        let overlap = &mut groups[group as usize];
        if list.len() <= capacity {
            for vertex in list.iter().filter(|v| overlap.vertices.binary_search(v).is_err()) {
                vertex_groups.push(*vertex, group);
            }
        }
        merge(&mut overlap.vertices, list);
        overlap.joined_at = time;
        joined.push(group);
    }
    (joined, groups.into_iter().map(|group| group.vertices).collect())
}

fn join_any(lists: Vec<Vec<u32>>, capacity: usize) -> Joined {
    let closed = capacity - capacity / NEARLY_FULL;
    let mut groups: Vec<Vec<u32>> = Vec::new();
    let mut open: VecDeque<(u32, u128)> = VecDeque::new();
    let mut joined = Vec::with_capacity(lists.len());
    for list in lists {
        // The first of the open groups that lack the fewest of the vertices, and have room for
        // them.
        let mut best: Option<(usize, usize)> = None;
        let own = signature(&list);
        for (index, &(group, signature)) in open.iter().enumerate() {
            let group = &groups[group as usize];
            let lacking = if signature & own == 0 { list.len() } else { missing(group, &list) };
            if group.len() + lacking <= capacity && best.is_none_or(|(fewest, _)| lacking < fewest) {
                best = Some((lacking, index));
            }
        }
        let best = best.filter(|_| list.len() < closed);
        let new = (groups.len() as u32, 0);
        let (group, signature) = best.and_then(|(_, index)| open.remove(index)).unwrap_or(new);
        if group as usize == groups.len() {
            groups.push(Vec::new());
            open.truncate(WINDOW - 1);
        }
        let grown = &mut groups[group as usize];
        merge(grown, &list);
        if grown.len() < closed {
            open.push_front((group, signature | own));
        }
        joined.push(group);
    }
    (joined, groups)
}

/// A set of bits for the vertices of a list. Lists whose sets share no bit share no vertex.
fn signature(list: &[u32]) -> u128 {
    list.iter().fold(0, |bits, vertex| bits | 1 << (vertex % u128::BITS))
}

/// Number of entries of `list` that are not in `group`. Both must be ascending.
fn missing(group: &[u32], list: &[u32]) -> usize {
    let mut at = 0;
    let mut found = 0;
    for v in list {
        while at < group.len() && group[at] < *v {
            at += 1;
        }
        found += usize::from(at < group.len() && group[at] == *v);
    }
    list.len() - found
}

fn merge(group: &mut Vec<u32>, list: &[u32]) {
    group.extend_from_slice(list);
    group.sort_unstable();
    group.dedup();
}

fn leaves<'a>(tree: &'a Tree, visit: &mut impl FnMut(&'a [u32])) {
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

    /// The leaves of a tree of these leaves, after they were shared.
    fn shared(lists: &[Vec<u32>]) -> Vec<Vec<u32>> {
        let mut tree = lists.iter().cloned().map(Tree::Leaf).reduce(|a, b| Tree::Axis(Box::new([a, b]))).unwrap();
        share(std::slice::from_mut(&mut tree), 8);
        let mut shared = Vec::new();
        leaves(&tree, &mut |list| shared.push(list.to_vec()));
        shared
    }

    #[test]
    fn leaves_keep_their_vertices() {
        let lists: Vec<Vec<u32>> = (0..200_u32).map(|i| (i / 3..i / 3 + 2 + i % 5).collect()).collect();
        let mut shared = shared(&lists);
        assert_eq!(shared.len(), lists.len());
        for (before, after) in lists.iter().zip(&shared) {
            assert!(after.len() <= 8 && missing(after, before) == 0, "{before:?} in {after:?}");
            assert!(after.is_sorted());
        }
        shared.sort();
        shared.dedup();
        assert!(shared.len() < 30, "{} groups of 68 vertices", shared.len());
    }

    #[test]
    fn the_second_pass_joins_disjoint_lists() {
        let lists = vec![vec![0, 1, 2], vec![10, 11, 12], vec![20, 21], (30..37).collect(), vec![40], vec![50, 51, 52]];
        let (of_list, groups) = join_overlapping(&lists, 8);
        assert_eq!((of_list, groups.len()), ((0..6).collect(), 6), "the first pass finds nothing in common");
        let (of_list, groups) = join_any(lists.clone(), 8);
        assert_eq!(of_list, [0, 0, 0, 1, 2, 2]);
        assert_eq!(groups, [vec![0, 1, 2, 10, 11, 12, 20, 21], (30..37).collect(), vec![40, 50, 51, 52]]);
        let expected: Vec<&Vec<u32>> = of_list.iter().map(|group| &groups[*group as usize]).collect();
        assert_eq!(shared(&lists).iter().collect::<Vec<_>>(), expected);
    }

    #[test]
    fn lists_longer_than_a_leaf_are_kept() {
        let lists = vec![(0..9).collect::<Vec<u32>>(), vec![0, 1], (0..9).collect(), vec![1, 2]];
        for (of_list, groups) in [join_overlapping(&lists, 8), join_any(lists.clone(), 8)] {
            assert_eq!(of_list, [0, 1, 2, 1]);
            assert_eq!(groups, [(0..9).collect(), vec![0, 1, 2], (0..9).collect::<Vec<u32>>()]);
        }
    }
}
