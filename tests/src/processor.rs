//! Processor time, which other programs on the machine affect less than elapsed time.

use std::time::Instant;

/// The result of `work`, and its processor time on this thread in seconds; elapsed time on systems
/// that do not state it.
pub fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = (Instant::now(), processor_time());
    let result = work();
    let seconds = processor_time().zip(start.1).map(|(end, start)| end - start);
    (result, seconds.unwrap_or_else(|| start.0.elapsed().as_secs_f64()))
}

/// Processor time of this thread in seconds.
fn processor_time() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(text.split_whitespace().next()?.parse::<f64>().ok()? * 1e-9)
}
