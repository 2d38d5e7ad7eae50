//! Members of the series, opened and queried: with all checks, and without the checks that would
//! reject them.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use hullmap::Pack;

use super::inquiry::{Extent, Inquiry};
use super::kinds::AnyInquiry;
use super::samples::Sample;
use super::series::{Series, Subject};
use super::trial::{self, Tally};

/// Opens and queries the members of a series that `indices` selects out of their number, which a
/// random series does not have. Panics if a member opens that must be rejected, or as
/// [`trial::run`].
pub fn checked(
    sample: &Sample,
    series: Series,
    (seed, threads, extent): (u64, usize, Extent),
    indices: impl Fn(Option<usize>) -> Vec<usize>,
) -> Tally {
    let (subject, inquiry) = (Subject::new(sample, seed), AnyInquiry::new(&sample.file, extent));
    let name = format!("{series:?}, {}, seed {seed:#x}", sample.name);
    trial::run(&name, &indices(subject.count(series)), threads, |index, file| {
        subject.change(series, index, file);
        let opened = inquiry.run(file).map_err(|error| assert!(!error.to_string().is_empty()));
        assert!(opened.is_err() || !series.is_always_rejected(), "a file that must be rejected opened");
        opened.is_ok()
    })
}

/// As [`checked`], opened in both ways that skip checks. Answers may be wrong, but every query ends
/// without a panic. Returns also the number of packs that opened. Panics if the sample is no pack.
pub fn unchecked(
    samples: &[Sample],
    (seed, threads): (u64, usize),
    indices: impl Fn(Option<usize>) -> Vec<usize>,
) -> (Tally, usize) {
    let folder = tempfile::tempdir().expect("the system has a folder for temporary files");
    let (files, queried, mut sum) = (AtomicUsize::new(0), AtomicUsize::new(0), Tally::default());
    for sample in samples {
        let subject = Subject::new(sample, seed);
        let pack = Pack::from_bytes(&sample.file).expect("a sample opens");
        let inquiry = Inquiry::new(&pack, Extent::BRIEF).unjudged();
        for series in [Series::SealedBits, Series::Words, Series::Drawn] {
            let name = format!("unchecked, {series:?}, {}, seed {seed:#x}", sample.name);
            sum += trial::run(&name, &indices(subject.count(series)), threads, |index, file| {
                subject.change(series, index, file);
                let path: &Path = &folder.path().join(files.fetch_add(1, Ordering::Relaxed).to_string());
                std::fs::write(path, file).expect("the folder can be written to");
                let opened = [Pack::open_skipping_contents(path), Pack::open_skipping_checks(path)];
                let packs: Vec<Pack> = opened.into_iter().flatten().collect();
                packs.iter().for_each(|pack| inquiry.run(pack));
                queried.fetch_add(packs.len(), Ordering::Relaxed);
                std::fs::remove_file(path).expect("the file can be removed");
                !packs.is_empty()
            });
        }
    }
    (sum, queried.into_inner())
}
