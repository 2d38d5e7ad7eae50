//! Set cover: the fewest candidates that cover all cells.
//!
//! # Reference
//! Gao, Weise, Li, "An efficient local search heuristic with row weighting for the unicost set
//! covering problem", 2015.

use super::bits::Bits;

/// Indices of sets that cover everything the sets cover together, ascending, as few as the search
/// finds in `steps` steps. Ties are broken by `cost`. The result depends only on the arguments.
pub fn choose(sets: &[&Bits], cost: &[f64], size: usize, steps: usize) -> Vec<usize> {
    let lists: Vec<Vec<u32>> = sets.iter().map(|set| set.iter().map(|i| i as u32).collect()).collect();
    let mut holders: Vec<Vec<u32>> = vec![Vec::new(); size];
    for (s, list) in lists.iter().enumerate() {
        list.iter().for_each(|i| holders[*i as usize].push(s as u32));
    }
    let mut search = SetCoverSearch {
        lists: &lists,
        is_in: vec![false; sets.len()],
        count: vec![0; size],
        weight: vec![1; size],
        changed: vec![0; sets.len()],
        // Ignore numbers that no set covers.
        uncovered: (0..size).filter(|i| !holders[*i].is_empty()).count(),
    };
    // Greedy start.
    while search.uncovered > 0 {
        let gains = (0..sets.len()).filter(|s| !search.is_in[*s]).map(|s| (search.gain(s), s));
        let Some((gain, best)) =
            gains.max_by(|a, b| a.0.cmp(&b.0).then(cost[b.1].total_cmp(&cost[a.1])).then(b.1.cmp(&a.1)))
        else {
            break;
        };
        if gain == 0 {
            break;
        }
        search.add(best);
    }
    let mut best: Vec<usize> = search.chosen();
    let mut random = 0x9E37_79B9_7F4A_7C15_u64;
    let mut forbidden = usize::MAX;
    for step in 1..=steps as u64 {
        while search.uncovered == 0 {
            let chosen = search.chosen();
            let total = |list: &[usize]| list.iter().map(|s| cost[*s]).sum::<f64>();
            if chosen.len() < best.len() || (chosen.len() == best.len() && total(&chosen) < total(&best)) {
                best = chosen;
            }
            match search.cheapest(usize::MAX) {
                Some(out) => search.remove(out, step),
                None => return best,
            }
        }
        if let Some(out) = search.cheapest(forbidden) {
            search.remove(out, step);
        }
        let open: Vec<usize> = (0..size).filter(|i| search.count[*i] == 0 && !holders[*i].is_empty()).collect();
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        let Some(row) = open.get((random % open.len().max(1) as u64) as usize) else { continue };
        let options = holders[*row].iter().map(|s| *s as usize).filter(|s| search.changed[*s] != step);
        let best_in = options.max_by(|a, b| {
            search.gain(*a).cmp(&search.gain(*b)).then(search.changed[*b].cmp(&search.changed[*a])).then(b.cmp(a))
        });
        if let Some(set) = best_in.or_else(|| holders[*row].first().map(|s| *s as usize)) {
            search.add(set);
            search.changed[set] = step;
            forbidden = set;
        }
        for i in 0..size {
            if search.count[i] == 0 {
                search.weight[i] += 1;
            }
        }
    }
    best
}

struct SetCoverSearch<'a> {
    lists: &'a [Vec<u32>],
    is_in: Vec<bool>,
    /// Number of chosen sets that cover each number.
    count: Vec<u32>,
    weight: Vec<u64>,
    /// The step in which a set was last added or removed.
    changed: Vec<u64>,
    uncovered: usize,
}

impl SetCoverSearch<'_> {
    fn gain(&self, set: usize) -> u64 {
        self.lists[set].iter().filter(|i| self.count[**i as usize] == 0).map(|i| self.weight[*i as usize]).sum()
    }

    fn loss(&self, set: usize) -> u64 {
        self.lists[set].iter().filter(|i| self.count[**i as usize] == 1).map(|i| self.weight[*i as usize]).sum()
    }

    fn chosen(&self) -> Vec<usize> {
        (0..self.is_in.len()).filter(|s| self.is_in[*s]).collect()
    }

    /// The chosen set whose removal uncovers the least weight, except `kept`.
    fn cheapest(&self, kept: usize) -> Option<usize> {
        let chosen = (0..self.is_in.len()).filter(|s| self.is_in[*s] && *s != kept);
        chosen.min_by_key(|s| (self.loss(*s), self.changed[*s], *s))
    }

    fn add(&mut self, set: usize) {
        if std::mem::replace(&mut self.is_in[set], true) {
            return;
        }
        for i in &self.lists[set] {
            let count = &mut self.count[*i as usize];
            self.uncovered -= usize::from(*count == 0);
            *count += 1;
        }
    }

    fn remove(&mut self, set: usize, step: u64) {
        self.is_in[set] = false;
        self.changed[set] = step;
        for i in &self.lists[set] {
            let count = &mut self.count[*i as usize];
            *count -= 1;
            self.uncovered += usize::from(*count == 0);
        }
    }
}
