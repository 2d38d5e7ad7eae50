//! Batches: meshes that are baked together elsewhere, because a task for each mesh would cost
//! more than its bake.
//!
//! The size of a mesh is its [`work`].
//!
//! 1. A large mesh is a batch of its own.
//! 2. The others go to 2^k buckets by the hash of their places; k is the least with which the
//!    average bucket is within the limits.
//!
//! Batches depend on the places and sizes of meshes alone: an edit or a new mesh changes one batch,
//! unless the number of buckets doubles, and colleagues with the same meshes have the same batches.

use std::collections::BTreeMap;

use super::shard::place_hash;
use crate::options::BuildOptions;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BatchSize {
    /// Number of meshes; buckets may hold some more, because their sizes vary by chance.
    pub meshes: usize,
    pub bytes: u64,
}

impl Default for BatchSize {
    /// A scheduler may take 60 ms for a task; with 256 meshes that is negligible. Larger batches
    /// would make an edit costlier and keep fewer machines busy.
    fn default() -> Self {
        Self { meshes: 256, bytes: 32 << 20 }
    }
}

/// Share of a batch's bytes from which a mesh is a batch of its own.
const LARGE: u64 = 4;

/// Work of a decomposition, whatever its size: as much as for hulls of a file of 16 MiB, 1 s. The
/// gear in `docs/guides/cost.md` takes 0.7 s, the pawn 2 s.
const DECOMPOSITION: u64 = 16 << 20;

/// Work of a decomposition per byte of source, 4 s per MB: a scan of 69,451 faces takes 20 s.
const DECOMPOSITION_PER_BYTE: u64 = 64;

/// Estimated work for a mesh, in bytes of a source whose hulls take as long to bake.
pub fn work(bytes: u64, options: &BuildOptions) -> u64 {
    match options.decompose() {
        Some(_) => bytes.saturating_mul(DECOMPOSITION_PER_BYTE).saturating_add(DECOMPOSITION),
        None => bytes,
    }
}

/// Batches as ascending indices by place, buckets before large meshes. Complexity: O(n log n).
pub fn batches(meshes: &[(&str, u64)], size: BatchSize) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..meshes.len()).collect();
    order.sort_by_key(|&index| meshes[index].0);
    let (large, small): (Vec<usize>, Vec<usize>) =
        order.into_iter().partition(|&index| meshes[index].1 > size.bytes / LARGE);
    let bytes: u64 = small.iter().map(|&index| meshes[index].1).sum();
    let least = (small.len().div_ceil(size.meshes.max(1)) as u64).max(bytes.div_ceil(size.bytes.max(1)));
    let mask = least.max(1).next_power_of_two() - 1;
    let mut buckets: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for index in small {
        buckets.entry(place_hash(meshes[index].0) & mask).or_default().push(index);
    }
    buckets.into_values().chain(large.into_iter().map(|index| vec![index])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::resolved::tests::options;

    fn places(count: usize) -> Vec<String> {
        (0..count).map(|i| format!("a/{i}.obj")).collect()
    }

    fn batched(places: &[String], bytes: u64, size: BatchSize) -> Vec<Vec<&str>> {
        let meshes: Vec<(&str, u64)> = places.iter().map(|place| (place.as_str(), bytes)).collect();
        let name = |batch: Vec<usize>| batch.into_iter().map(|index| meshes[index].0).collect();
        batches(&meshes, size).into_iter().map(name).collect()
    }

    #[test]
    fn every_mesh_is_in_one_batch_of_about_the_size() {
        let places = places(10_000);
        let batches = batched(&places, 20_000, BatchSize::default());
        assert_eq!(batches.len(), 64);
        assert!(batches.iter().all(|batch| (90..256).contains(&batch.len()) && batch.is_sorted()));
        let mut all: Vec<&str> = batches.concat();
        all.sort_unstable();
        let mut expected: Vec<&str> = places.iter().map(String::as_str).collect();
        expected.sort_unstable();
        assert_eq!(all, expected);
        assert_eq!(batched(&places, 1 << 20, BatchSize::default()).len(), 512);
        assert_eq!(batched(&places[..300], 1, BatchSize { meshes: 1000, bytes: 1000 }).len(), 1);
        assert!(batched(&[], 1, BatchSize::default()).is_empty());
    }

    #[test]
    fn one_more_mesh_changes_one_batch() {
        let places = places(10_001);
        let (before, after) =
            (batched(&places[..10_000], 1, BatchSize::default()), batched(&places, 1, BatchSize::default()));
        assert_eq!(before.iter().zip(&after).filter(|(a, b)| a != b).count(), 1);
    }

    /// All decompositions were one task, which one core baked.
    #[test]
    fn decompositions_are_alone() {
        let decomposed = options(&[("decompose", "true")]);
        let meshes = [("a", &decomposed), ("b", &decomposed), ("c", &BuildOptions::default())];
        let meshes = meshes.map(|(place, options)| (place, work(5000, options)));
        assert_eq!(batches(&meshes, BatchSize::default()), [vec![2], vec![0], vec![1]]);
    }

    #[test]
    fn large_meshes_are_alone_and_change_no_other_batch() {
        let meshes = [("a", 1), ("big", 9 << 20), ("b", 1), ("c", 1)];
        assert_eq!(batches(&meshes, BatchSize::default()), [vec![0, 2, 3], vec![1]]);
    }
}
