//! Processor time, which other programs on the machine affect less than elapsed time.

use std::time::Duration;

/// Processor time of this thread. Elapsed time on systems other than Linux.
pub fn thread_time() -> Duration {
    #[cfg(target_os = "linux")]
    return duration(rustix::time::ClockId::ThreadCPUTime);
    #[cfg(not(target_os = "linux"))]
    elapsed()
}

/// Processor time of all threads of this process. Elapsed time on systems other than Linux.
pub fn process_time() -> Duration {
    #[cfg(target_os = "linux")]
    return duration(rustix::time::ClockId::ProcessCPUTime);
    #[cfg(not(target_os = "linux"))]
    elapsed()
}

#[cfg(target_os = "linux")]
fn duration(clock: rustix::time::ClockId) -> Duration {
    let time = rustix::time::clock_gettime(clock);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

#[cfg(not(target_os = "linux"))]
fn elapsed() -> Duration {
    use std::{sync::OnceLock, time::Instant};
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed()
}

/// The result of `work`, and its time on this thread in seconds.
pub fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = thread_time();
    let result = work();
    (result, (thread_time() - start).as_secs_f64())
}
