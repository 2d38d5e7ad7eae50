//! Scheduler: starts the files of a build on one thread pool, within a memory limit.

use std::collections::BTreeSet;
use std::ops::Bound;
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

const TICK: Duration = Duration::from_millis(100);

/// Files in flight per thread: one in progress and one waiting, so that no thread is idle.
const IN_FLIGHT_PER_THREAD: usize = 2;

struct State<R> {
    results: Vec<Option<R>>,
    in_flight: usize,
    in_flight_cost: u64,
}

/// Runs `work(0)`, `work(1)`, … on the pool and returns the results in this order. Items in flight
/// cost at most `budget` in total; an item that costs more is in flight alone.
///
/// The most expensive fitting item is started first, so that no large file is left to the end; ties
/// go to the first. The limit never blocks the pool's threads: while an item waits, they work on
/// others in flight. `tick` runs on the caller's thread ten times a second. Panics if `work` does.
pub fn run_bounded<R: Send>(
    pool: &rayon::ThreadPool,
    costs: &[u64],
    budget: u64,
    work: impl Fn(usize) -> R + Sync,
    mut tick: impl FnMut(),
) -> Vec<R> {
    let state = State { results: costs.iter().map(|_| None).collect(), in_flight: 0, in_flight_cost: 0 };
    let (state, has_ended) = (Mutex::new(state), Condvar::new());
    let max_in_flight = IN_FLIGHT_PER_THREAD * pool.current_num_threads();
    let count = costs.len();
    // Counted from the end: the maximum entry is the first of the most expensive items.
    let mut waiting: BTreeSet<(u64, usize)> = costs.iter().enumerate().map(|(at, &cost)| (cost, count - at)).collect();
    pool.in_place_scope(|scope| {
        let mut now = state.lock().unwrap_or_else(PoisonError::into_inner);
        while !waiting.is_empty() {
            let free = if now.in_flight == 0 { u64::MAX } else { budget.saturating_sub(now.in_flight_cost) };
            let fits = (Bound::Unbounded, Bound::Included((free, usize::MAX)));
            let next = waiting.range(fits).next_back().copied();
            match next.filter(|_| now.in_flight < max_in_flight) {
                Some(entry) => {
                    waiting.remove(&entry);
                    let (cost, at) = (entry.0, count - entry.1);
                    now.in_flight += 1;
                    now.in_flight_cost += cost;
                    let (state, has_ended, work) = (&state, &has_ended, &work);
                    scope.spawn(move |_| {
                        let result = work(at);
                        let mut now = state.lock().unwrap_or_else(PoisonError::into_inner);
                        now.results[at] = Some(result);
                        now.in_flight -= 1;
                        now.in_flight_cost -= cost;
                        drop(now);
                        has_ended.notify_one();
                    });
                }
                None => {
                    let (back, waited) = has_ended.wait_timeout(now, TICK).unwrap_or_else(PoisonError::into_inner);
                    now = back;
                    if waited.timed_out() {
                        drop(now);
                        tick();
                        now = state.lock().unwrap_or_else(PoisonError::into_inner);
                    }
                }
            }
        }
        while now.in_flight > 0 {
            now = has_ended.wait_timeout(now, TICK).unwrap_or_else(PoisonError::into_inner).0;
            drop(now);
            tick();
            now = state.lock().unwrap_or_else(PoisonError::into_inner);
        }
    });
    let state = state.into_inner().unwrap_or_else(PoisonError::into_inner);
    state.results.into_iter().map(|result| result.expect("every item was worked on")).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

    use rayon::prelude::*;

    use super::*;

    fn pool(threads: usize) -> rayon::ThreadPool {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
    }

    fn costs(count: usize) -> Vec<u64> {
        (0..count as u64).map(|index| if index == 7 { 1000 } else { 1 + index * 37 % 60 }).collect()
    }

    #[test]
    fn the_bound_holds_and_the_order_stays() {
        let costs = costs(200);
        for (threads, budget) in [(1, 100), (2, 100), (8, 100), (8, 60), (8, 1)] {
            let (in_flight, peak, alone) = (AtomicU64::new(0), AtomicU64::new(0), AtomicU64::new(0));
            let work = |at: usize| {
                let now = in_flight.fetch_add(costs[at], Ordering::SeqCst) + costs[at];
                if costs[at] > budget {
                    alone.fetch_add(u64::from(now == costs[at]), Ordering::SeqCst);
                } else {
                    peak.fetch_max(now, Ordering::SeqCst);
                }
                let sum: u64 = (0..2000_u64).into_par_iter().map(|number| number % 7).sum();
                std::thread::sleep(Duration::from_micros(50));
                in_flight.fetch_sub(costs[at], Ordering::SeqCst);
                (at, sum)
            };
            let results = run_bounded(&pool(threads), &costs, budget, work, || {});
            assert!(results.iter().enumerate().all(|(index, &(at, _))| index == at));
            let peak = peak.load(Ordering::SeqCst);
            let greater = costs.iter().filter(|&&cost| cost > budget).count() as u64;
            assert!(peak <= budget, "{threads} threads: {peak} of {budget}");
            assert!(threads == 1 || budget < 100 || peak > budget / 2, "{threads} threads: only {peak} of {budget}");
            assert_eq!(alone.load(Ordering::SeqCst), greater, "an item above the budget is alone");
        }
    }

    #[test]
    fn the_costliest_comes_first_and_equals_keep_their_order() {
        let order = Mutex::new(Vec::new());
        let push = |at| order.lock().unwrap().push(at);
        run_bounded(&pool(1), &[5, 9, 5, 5, 7], 5, push, || {});
        assert_eq!(
            order.into_inner().unwrap(),
            [1, 4, 0, 2, 3],
            "an item above the budget is not postponed to the end"
        );
    }

    #[test]
    fn it_ticks_while_it_waits() {
        let ticks = AtomicUsize::new(0);
        let work = |_| std::thread::sleep(Duration::from_millis(350));
        let tick = || {
            ticks.fetch_add(1, Ordering::SeqCst);
        };
        run_bounded(&pool(2), &[1, 1], 10, work, tick);
        assert!(ticks.load(Ordering::SeqCst) >= 2);
        assert!(run_bounded(&pool(2), &[], 10, |_| (), || {}).is_empty());
    }
}
