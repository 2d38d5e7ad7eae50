//! Processor time of this thread, so that other programs on the machine do not count.

use std::sync::OnceLock;

use hullmap_testkit::clock::thread_time;

/// Number of readings by which the time of a reading is measured.
const READINGS: usize = 1001;

/// Nanoseconds of processor time that `work` takes. The time of reading the clock, which is a call
/// of the operating system, does not count.
pub fn time_ns(work: impl FnOnce()) -> f64 {
    let reading = reading_ns();
    let start = thread_time();
    work();
    ((thread_time() - start).as_nanos() as f64 - reading).max(0.0)
}

/// Median time from one reading to the next.
fn reading_ns() -> f64 {
    static READING: OnceLock<f64> = OnceLock::new();
    *READING.get_or_init(|| {
        let times = (0..READINGS).map(|_| {
            let start = thread_time();
            (thread_time() - start).as_nanos() as f64
        });
        median(times.collect()).unwrap_or(0.0)
    })
}

/// The median, the upper one of two; `None` without values.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use std::hint::black_box;

    use super::*;

    #[test]
    fn time_grows_with_work() {
        let of = |turns: u64| time_ns(|| assert!((0..turns).map(black_box).sum::<u64>() < u64::MAX));
        let [short, long] = [1_000, 10_000_000].map(of);
        assert!(long > short, "{short} and {long} ns");
    }

    #[test]
    fn medians() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![3.0, 1.0]), Some(3.0));
        assert_eq!(median(Vec::new()), None);
    }
}
