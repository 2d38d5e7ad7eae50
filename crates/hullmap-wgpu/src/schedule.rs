//! Assigns pairs to threads of the GPU. No answer depends on the order.

use crate::records::{AnswerRecord, PairRecord};

/// Threads that run in step on most GPUs.
const WARP: usize = 32;

/// Steps after which the unfinished pairs of a compacted batch move together.
const ROUNDS: [u32; 4] = [4, 8, 12, 20];

/// Order in which the pairs of a batch are given to the threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Order {
    /// As they are given.
    #[default]
    AsGiven,
    /// By the indices of both hulls, so that neighbours read the same tables.
    ByHulls,
    /// By the number of steps of the pair with the same index in the last batch, then by hulls.
    BySteps,
}

/// How a batch is laid out on the threads of a GPU. Answers are the same in each order, and with or
/// without compaction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Schedule {
    /// Order of the pairs.
    pub order: Order,
    /// Whether the unfinished pairs move together after a few steps, by stable prefix sums.
    pub is_compacted: bool,
    /// Whether each pair starts from the simplex with which the pair of the same index ended in the
    /// last batch on this device. Answers then differ within their intervals.
    pub is_warm: bool,
}

impl Schedule {
    /// Steps after which each round ends. The last is `max_steps`.
    pub(crate) fn rounds(&self, max_steps: u32) -> Vec<u32> {
        let mut rounds = Vec::new();
        if self.is_compacted {
            rounds.extend(ROUNDS.into_iter().filter(|steps| *steps < max_steps));
        }
        rounds.push(max_steps);
        rounds
    }

    /// Indices of the pairs of each chunk, counted from its start, in this order.
    pub(crate) fn indices(&self, pairs: &[PairRecord], last: &[AnswerRecord], chunk: usize) -> Vec<u32> {
        let mut indices = Vec::with_capacity(pairs.len());
        for (at, part) in pairs.chunks(chunk).enumerate() {
            let start = indices.len();
            indices.extend(0..part.len() as u32);
            let hulls = |index: &u32| part.get(*index as usize).map(|pair| (pair.a, pair.b));
            let steps = |index: &u32| last.get(at * chunk + *index as usize).map_or(0, |answer| answer.steps);
            // Both sorts are stable.
            match self.order {
                Order::AsGiven => {}
                Order::ByHulls => indices[start..].sort_by_key(hulls),
                Order::BySteps => indices[start..].sort_by_key(|index| (steps(index), hulls(index))),
            }
        }
        indices
    }
}

/// Share of the steps of all threads in which they have a pair that is not finished, if `WARP`
/// threads run in step. 1 for an empty batch.
pub(crate) fn efficiency(order: &[u32], answers: &[AnswerRecord], rounds: &[u32], chunk: usize) -> f64 {
    let (mut used, mut spent) = (0_u64, 0_u64);
    let mut count = |steps: &[u32]| {
        used += steps.iter().map(|steps| u64::from(*steps)).sum::<u64>();
        spent += steps.chunks(WARP).map(|warp| 32 * u64::from(warp.iter().copied().max().unwrap_or(0))).sum::<u64>();
    };
    for (order, answers) in order.chunks(chunk).zip(answers.chunks(chunk)) {
        let in_order: Vec<&AnswerRecord> = order.iter().filter_map(|index| answers.get(*index as usize)).collect();
        let mut before = 0;
        for until in rounds {
            let of = |answer: &&AnswerRecord| answer.gjk_steps.min(*until).saturating_sub(before);
            // The first round has all pairs, the others only those that are left.
            let left = in_order.iter().filter(|answer| before == 0 || answer.gjk_steps > before);
            count(&left.map(of).collect::<Vec<_>>());
            before = *until;
        }
        let expanded =
            in_order.iter().map(|answer| answer.steps.saturating_sub(answer.gjk_steps)).filter(|steps| *steps > 0);
        count(&expanded.collect::<Vec<_>>());
    }
    if spent == 0 { 1.0 } else { used as f64 / spent as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(gjk_steps: u32, steps: u32) -> AnswerRecord {
        AnswerRecord { gjk_steps, steps, ..AnswerRecord::default() }
    }

    #[test]
    fn threads_that_wait_count() {
        // One warp: a thread takes 20 steps, the others 4.
        let mut answers = vec![answer(4, 4); 32];
        answers[7] = answer(20, 20);
        let order: Vec<u32> = (0..32).collect();
        assert_eq!(efficiency(&order, &answers, &[64], 64), (31.0 * 4.0 + 20.0) / (32.0 * 20.0));
        // Two: they are not helped by rounds, unless the rest of both fits into one.
        let answers = [answers.clone(), answers].concat();
        let order: Vec<u32> = (0..64).collect();
        assert_eq!(efficiency(&order, &answers, &[4, 64], 64), (62.0 * 4.0 + 40.0) / (64.0 * 4.0 + 32.0 * 16.0));
        // Sorted by steps.
        let schedule = Schedule { order: Order::BySteps, ..Schedule::default() };
        let order = schedule.indices(&vec![PairRecord::default(); 64], &answers, 64);
        assert_eq!(order[62..], [7, 39]);
        assert_eq!(efficiency(&order, &answers, &[64], 64), (62.0 * 4.0 + 40.0) / (32.0 * 4.0 + 32.0 * 20.0));
        // EPA has only the pairs that need it.
        assert_eq!(efficiency(&[0, 1], &[answer(2, 2), answer(2, 12)], &[64], 64), 14.0 / (32.0 * 2.0 + 32.0 * 10.0));
    }

    #[test]
    fn each_chunk_has_all_its_pairs() {
        let pairs: Vec<PairRecord> = (0..10).map(|at| PairRecord { a: 9 - at, ..PairRecord::default() }).collect();
        let schedule = Schedule { order: Order::ByHulls, ..Schedule::default() };
        assert_eq!(schedule.indices(&pairs, &[], 4), [3, 2, 1, 0, 3, 2, 1, 0, 1, 0]);
        assert_eq!(Schedule::default().indices(&pairs, &[], 4), [0, 1, 2, 3, 0, 1, 2, 3, 0, 1]);
    }

    #[test]
    fn rounds_end_with_the_last_step() {
        let compacted = Schedule { is_compacted: true, ..Schedule::default() };
        assert_eq!(compacted.rounds(64), [4, 8, 12, 20, 64]);
        assert_eq!(compacted.rounds(8), [4, 8]);
        assert_eq!(Schedule::default().rounds(64), [64]);
    }
}
