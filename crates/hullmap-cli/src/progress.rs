//! Progress of a build: bars on a terminal, otherwise an occasional line, or nothing with
//! `--quiet`.

use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use hullmap_bake::progress::Progress as Done;
use indicatif::{HumanDuration, MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::interrupt;
use crate::terminal::{self, Escaped};
use hullmap_geometry::number::grouped;
use hullmap_pipeline::runner::Observer;
use hullmap_pipeline::runner::rows::Status;

/// Shorter builds show no bars, which would only flicker.
const BARS_AFTER: Duration = Duration::from_millis(300);

const NAME_AFTER: Duration = Duration::from_millis(300);

const MAX_NAMES: usize = 6;

const LINE_INTERVAL: Duration = Duration::from_secs(10);

const ESTIMATE_FROM: f64 = 0.02;

/// Maximum change of the estimated total time, relative to itself, in the second half of the time
/// so far. A less steady estimate is not shown: files differ in how long a byte takes.
const STEADY: f64 = 0.2;

/// Progress of one build. Methods may be called from any thread.
#[derive(Debug)]
pub struct Progress {
    start: Instant,
    display: Display,
    state: Mutex<State>,
}

#[derive(Debug)]
enum Display {
    None,
    Lines,
    Bars { screen: MultiProgress, overall: ProgressBar, names: Vec<ProgressBar> },
}

#[derive(Debug, Default)]
struct State {
    files: usize,
    cost: u64,
    done: usize,
    done_cost: u64,
    baked: usize,
    failed: usize,
    in_work: BTreeMap<usize, InWork>,
    last_line: Option<Instant>,
    /// Estimates of the total time, in seconds, in the second half of the time so far, and one
    /// before.
    totals: VecDeque<(Duration, f64)>,
}

#[derive(Debug)]
struct InWork {
    name: String,
    start: Instant,
    cost: u64,
    done: Arc<Done>,
}

impl Progress {
    pub fn new(files: usize, cost: u64) -> Self {
        let display = match terminal::screen() {
            _ if terminal::is_quiet() => Display::None,
            None => Display::Lines,
            Some(screen) => bars(screen, cost),
        };
        let state = State { files, cost, ..State::default() };
        Self { start: Instant::now(), display, state: Mutex::new(state) }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Observer for Progress {
    fn begin(&self, index: usize, name: &Path, cost: u64) -> Arc<Done> {
        let done = Arc::new(Done::default());
        let file =
            InWork { name: Escaped(name.display()).to_string(), start: Instant::now(), cost, done: Arc::clone(&done) };
        self.state().in_work.insert(index, file);
        done
    }

    fn end(&self, index: usize, status: Status) {
        let mut state = self.state();
        state.done_cost += state.in_work.remove(&index).map_or(0, |file| file.cost);
        state.done += 1;
        match status {
            Status::Baked => state.baked += 1,
            Status::Failed => state.failed += 1,
            _ => {}
        }
    }

    fn tick(&self) {
        let now = Instant::now();
        match &self.display {
            Display::None => {}
            Display::Lines => {
                let mut state = self.state();
                state.estimate(now - self.start);
                if now - state.last_line.unwrap_or(self.start) >= LINE_INTERVAL {
                    state.last_line = Some(now);
                    terminal::say(state.line(now - self.start, now));
                }
            }
            Display::Bars { overall, names, .. } if now - self.start >= BARS_AFTER => {
                let mut state = self.state();
                state.estimate(now - self.start);
                overall.set_message(state.summary(now - self.start));
                overall.set_position(state.reached());
                let mut shown = state.longest(now, NAME_AFTER).into_iter();
                for bar in names {
                    bar.set_message(shown.next().unwrap_or_default());
                    bar.tick();
                }
            }
            Display::Bars { .. } => {}
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Display::Bars { screen, .. } = &self.display {
            let _ = screen.clear();
            interrupt::show(None);
        }
    }
}

fn bars(screen: ProgressDrawTarget, cost: u64) -> Display {
    let screen = MultiProgress::with_draw_target(screen);
    let style = |template| ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = |length: Option<u64>, template| {
        let bar = ProgressBar::with_draw_target(length, ProgressDrawTarget::hidden());
        screen.add(bar.with_style(style(template)))
    };
    let overall = bar(Some(cost.max(1)), "{wide_bar} {msg}");
    let names = (0..MAX_NAMES).map(|_| bar(None, "  {wide_msg}")).collect();
    interrupt::show(Some(screen.clone()));
    Display::Bars { screen, overall, names }
}

impl State {
    /// `120 of 10 000 files, 7 baked, 1 failed, about 2 minutes left`.
    fn summary(&self, elapsed: Duration) -> String {
        let mut text = format!("{} of {} files", grouped(self.done as u64), grouped(self.files as u64));
        for (count, word) in [(self.baked, "baked"), (self.failed, "failed")] {
            if count > 0 {
                text += &format!(", {} {word}", grouped(count as u64));
            }
        }
        if let Some(left) = self.time_left(elapsed) {
            text += &format!(", about {} left", HumanDuration(left));
        }
        text
    }

    /// Notes the total time, in proportion to the work done.
    fn estimate(&mut self, elapsed: Duration) {
        let share = self.reached() as f64 / self.cost.max(1) as f64;
        if share >= ESTIMATE_FROM {
            self.totals.push_back((elapsed, elapsed.as_secs_f64() / share));
        }
        while self.totals.get(1).is_some_and(|(at, _)| *at <= elapsed / 2) {
            self.totals.pop_front();
        }
    }

    /// `None` until the estimate was steady for half of the time so far.
    fn time_left(&self, elapsed: Duration) -> Option<Duration> {
        let (&(first, _), &(_, total)) = (self.totals.front()?, self.totals.back()?);
        let is_steady = self.totals.iter().all(|(_, then)| (then - total).abs() <= STEADY * total);
        let left = total - elapsed.as_secs_f64();
        (first <= elapsed / 2 && is_steady && left > 0.0).then(|| Duration::from_secs_f64(left))
    }

    /// Cost of all that is done, also of files in progress.
    fn reached(&self) -> u64 {
        let in_work = self.in_work.values().map(|file| (file.done.share() * file.cost as f64) as u64);
        self.done_cost + in_work.sum::<u64>()
    }

    fn line(&self, elapsed: Duration, now: Instant) -> String {
        let longest = self.longest(now, NAME_AFTER).into_iter().next();
        format!(
            "{}{}",
            self.summary(elapsed),
            longest.map_or_else(String::new, |name| format!("; in progress: {name}"))
        )
    }

    /// Names, times and shares of the files in progress longest, if for at least `least`.
    fn longest(&self, now: Instant, least: Duration) -> Vec<String> {
        let age = |start: Instant| now.saturating_duration_since(start);
        let mut files: Vec<&InWork> = self.in_work.values().filter(|file| age(file.start) >= least).collect();
        files.sort_by_key(|file| file.start);
        files.truncate(MAX_NAMES);
        let line = |file: &InWork| {
            let (seconds, percent) = (age(file.start).as_secs_f64(), (100.0 * file.done.share()) as u32);
            // Unknown for a batch on a farm.
            let done = if percent > 0 { format!(", {percent}%") } else { String::new() };
            format!("{} ({seconds:.1} s{done})", file.name)
        };
        files.into_iter().map(line).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The build said 16, 21, 38 and 52 seconds left in turn.
    #[test]
    fn time_left_is_shown_once_it_is_steady() {
        let left = |done: &dyn Fn(u64) -> u64, seconds: u64| {
            let mut state = State { cost: 1000, ..State::default() };
            for second in 1..=seconds {
                state.done_cost = done(second);
                state.estimate(Duration::from_secs(second));
            }
            state.time_left(Duration::from_secs(seconds)).map(|left| left.as_secs_f64().round())
        };
        assert_eq!(left(&|second| 10 * second, 20), Some(80.0));
        assert_eq!(left(&|second| 10 * second, 3), None, "too little is done");
        assert_eq!(left(&|_| 1000, 20), None, "all is done");
        assert_eq!(left(&|second| (second as f64).sqrt() as u64 * 100, 20), None, "ever slower");
        assert_eq!(left(&|second| if second < 10 { 10 } else { 10 * second }, 19), None);
        assert_eq!(left(&|second| if second < 10 { 10 } else { 10 * second }, 20), Some(80.0));
        assert_eq!(State::default().time_left(Duration::ZERO), None);
    }

    #[test]
    fn a_line_has_counts_time_left_and_the_longest_file() {
        let start = Instant::now();
        let now = start + Duration::from_secs(60);
        let mut state = State { files: 12_000, cost: 400, done: 3000, done_cost: 100, ..State::default() };
        let steady = |state: &mut State| {
            state.totals = [30, 60].map(|at| (Duration::from_secs(at), 24e3 / state.reached() as f64)).into()
        };
        steady(&mut state);
        assert_eq!(state.line(now - start, now), "3 000 of 12 000 files, about 3 minutes left");
        (state.baked, state.failed) = (5, 1);
        let mut insert = |index, name: &str, seconds| {
            let (start, done) = (start + Duration::from_secs(seconds), Arc::new(Done::default()));
            let file = InWork { name: name.to_owned(), start, cost: 200, done: Arc::clone(&done) };
            state.in_work.insert(index, file);
            done
        };
        insert(3, "new.obj", 60);
        let done = insert(4, "big.obj", 48);
        insert(9, "mid.obj", 50);
        let line = state.line(now - start, now);
        assert_eq!(
            line,
            "3 000 of 12 000 files, 5 baked, 1 failed, about 3 minutes left; in progress: big.obj (12.0 s)"
        );
        // The bar stood still while one mesh was decomposed.
        done.whole().reach(0.5);
        assert_eq!(state.reached(), 200);
        steady(&mut state);
        let line = state.line(now - start, now);
        assert!(line.contains("about 60 seconds left; in progress: big.obj (12.0 s, 50%)"), "{line}");
        assert_eq!(state.longest(now, NAME_AFTER).len(), 2);
    }
}
