//! Damaged files opened without the checks that would refuse them. Queries may then return wrong
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
    pub asked: usize,
    /// Number of panics in queries, by file and line.
    pub panics: BTreeMap<String, usize>,
}

/// Writes `file` to `path`, opens it in both ways that skip checks, and queries each pack that
/// opens. Returns whether one opened.
///
/// `inquiry` must be [unjudged](Inquiry::unjudged).
///
/// # Panics
/// If the file cannot be written.
pub fn ask(path: &Path, file: &[u8], inquiry: &Inquiry, findings: &Mutex<Findings>) -> bool {
    std::fs::write(path, file).expect("the test's folder can be written to");
    let ways: [Way; 2] = [|path| Pack::open_skipping_contents(path), |path| Pack::open_skipping_checks(path)];
    let mut has_opened = false;
    for way in ways {
        let Ok(pack) = way(path) else { continue };
        has_opened = true;
        let panicked_at = place_of_panic(|| inquiry.ask(&pack));
        let mut findings = findings.lock().expect("no panic while it is held");
        findings.asked += 1;
        if let Some(place) = panicked_at {
            *findings.panics.entry(place).or_default() += 1;
        }
    }
    std::fs::remove_file(path).expect("the test's own file can be removed");
    has_opened
}

thread_local! {
    static IS_LISTENING: Cell<bool> = const { Cell::new(false) };
    static HEARD: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// File and line at which `run` panics, if it does. Nothing is printed.
fn place_of_panic(run: impl FnOnce()) -> Option<String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if IS_LISTENING.get() {
                let place = info.location().map(|at| format!("{}:{}", at.file(), at.line()));
                HEARD.replace(place);
            } else {
                before(info);
            }
        }));
    });
    IS_LISTENING.set(true);
    let result = catch_unwind(AssertUnwindSafe(run));
    IS_LISTENING.set(false);
    result.err().map(|_| HEARD.take().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panics_are_heard() {
        assert_eq!(place_of_panic(|| ()), None);
        let heard = place_of_panic(|| panic!("heard"));
        assert!(heard.as_ref().is_some_and(|place| place.contains("unchecked.rs:")), "{heard:?}");
    }
}
