//! Cliques: items of which any two are in conflict, so that each needs a part of its own.

use rayon::prelude::*;

/// Maximum number of items from which a clique is grown: those with the most conflicts.
const STARTS: usize = 64;

/// The size of a large clique of `count` items, 0 if there are none: grown from single items,
/// taking next the item that leaves the most candidates. `are_in_conflict` gets the lower index
/// first.
///
/// # Complexity
/// For n items, n² / 2 conflicts, and at most 64 cliques of k items, each in O(k n²).
pub fn large_clique(count: usize, are_in_conflict: impl Fn(usize, usize) -> bool + Sync) -> usize {
    let earlier = |j: usize| (0..j).map(|i| are_in_conflict(i, j)).collect();
    let earlier: Vec<Vec<bool>> = (0..count).into_par_iter().map(earlier).collect();
    let mut rows = vec![vec![0_u64; count.div_ceil(64)]; count];
    for (i, j) in (0..count).flat_map(|j| (0..j).map(move |i| (i, j))).filter(|(i, j)| earlier[*j][*i]) {
        rows[i][j / 64] |= 1 << (j % 64);
        rows[j][i / 64] |= 1 << (i % 64);
    }
    let common = |a: &[u64], b: &[u64]| a.iter().zip(b).map(|(a, b)| (a & b).count_ones()).sum::<u32>();
    let grown = |start: &usize| {
        let (mut candidates, mut size) = (rows[*start].clone(), 1);
        while let Some(next) = (0..count)
            .filter(|i| candidates[i / 64] >> (i % 64) & 1 == 1)
            .max_by_key(|i| common(&rows[*i], &candidates))
        {
            candidates.iter_mut().zip(&rows[next]).for_each(|(word, other)| *word &= other);
            size += 1;
        }
        size
    };
    let mut starts: Vec<usize> = (0..count).collect();
    starts.sort_by_key(|i| std::cmp::Reverse(common(&rows[*i], &rows[*i])));
    starts.iter().take(STARTS).map(grown).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use shapes::rng::SplitMix64;

    use super::*;

    #[test]
    fn cliques_are_cliques_and_mostly_the_largest() {
        let seed = 4;
        println!("seed {seed}");
        let mut rng = SplitMix64::new(seed);
        let (mut largest, mut sizes) = (0, [0; 13]);
        for _ in 0..300 {
            let density = rng.between(0.1, 0.9);
            let mut rows = [0_u32; 12];
            for (i, j) in (0..12).flat_map(|j| (0..j).map(move |i| (i, j))) {
                if rng.unit() < density {
                    rows[i] |= 1 << j;
                    rows[j] |= 1 << i;
                }
            }
            let is_clique = |set: &u32| (0..12).all(|i| set >> i & 1 == 0 || set & !rows[i] == 1 << i);
            let expected = (1..1 << 12).filter(is_clique).map(u32::count_ones).max().unwrap() as usize;
            let found = large_clique(12, |i, j| rows[i] >> j & 1 == 1);
            let is_used = |i: usize| i.is_multiple_of(13);
            let is_edge = |i: usize, j: usize| is_used(i) && is_used(j) && rows[i / 13] >> (j / 13) & 1 == 1;
            assert_eq!(large_clique(12 * 13, is_edge), found);
            assert!(found <= expected, "{found} of {expected}");
            largest += usize::from(found == expected);
            sizes[expected] += 1;
        }
        assert!(largest > 270 && sizes.iter().filter(|count| **count > 10).count() > 4, "{largest} {sizes:?}");
    }

    #[test]
    fn items_without_conflicts_are_cliques_of_one() {
        assert_eq!(large_clique(0, |_, _| true), 0);
        assert_eq!(large_clique(100, |_, _| false), 1);
    }
}
