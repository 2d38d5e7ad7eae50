//! Damaged files opened without the checks that would reject them. Queries may then return wrong
//! answers or panic, but they end, and they read nothing out of bounds.

use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
    sync::{Mutex, Once},
};

use hullmap::{OpenError, Pack};

use super::inquiry::Inquiry;

/// A way to open a file.
type Way = fn(&Path) -> Result<Pack, OpenError>;

/// Results of files opened without checks.
#[derive(Debug, Default)]
pub struct Findings {
    /// Number of opened packs that were queried.
    pub queried: usize,
    /// Number of panics in queries, by file and line.
    pub panics: BTreeMap<String, usize>,
}

/// Writes `file` to `path`, opens it in both ways that skip checks, and queries each pack that
/// opens. Returns whether one opened.
///
/// `inquiry` must be [unjudged](Inquiry::unjudged). Panics if the file cannot be written.
pub fn query(path: &Path, file: &[u8], inquiry: &Inquiry, findings: &Mutex<Findings>) -> bool {
    std::fs::write(path, file).expect("the test's folder can be written to");
    let ways: [Way; 2] = [|path| Pack::open_skipping_contents(path), |path| Pack::open_skipping_checks(path)];
    let mut has_opened = false;
    for way in ways {
        let Ok(pack) = way(path) else { continue };
        has_opened = true;
        let panicked_at = panic_location(|| inquiry.run(&pack));
        let mut findings = findings.lock().expect("no thread panics while it holds the lock");
        findings.queried += 1;
        if let Some(location) = panicked_at {
            *findings.panics.entry(location).or_default() += 1;
        }
    }
    std::fs::remove_file(path).expect("the test's own file can be removed");
    has_opened
}

thread_local! {
    static IS_RECORDING: Cell<bool> = const { Cell::new(false) };
    static LOCATION: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// File and line at which `run` panics; `None` if it does not. The panic prints nothing.
fn panic_location(run: impl FnOnce()) -> Option<String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if IS_RECORDING.get() {
                let location = info.location().map(|at| format!("{}:{}", at.file(), at.line()));
                LOCATION.replace(location);
            } else {
                before(info);
            }
        }));
    });
    IS_RECORDING.set(true);
    let result = catch_unwind(AssertUnwindSafe(run));
    IS_RECORDING.set(false);
    result.err().map(|_| LOCATION.take().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panics_are_recorded() {
        assert_eq!(panic_location(|| ()), None);
        let location = panic_location(|| panic!("recorded"));
        assert!(location.as_ref().is_some_and(|text| text.contains("unchecked.rs:")), "{location:?}");
    }
}
