//! Groups of items that are joined by pairs: a forest, in which each item names one of its group.

/// The first item of a group.
pub fn find(root: &mut [u32], mut i: u32) -> u32 {
    while root[i as usize] != i {
        let above = root[root[i as usize] as usize];
        root[i as usize] = above;
        i = above;
    }
    i
}

/// Unites the groups of two items.
pub fn join(root: &mut [u32], a: u32, b: u32) {
    let (a, b) = (find(root, a), find(root, b));
    root[a.max(b) as usize] = a.min(b);
}
