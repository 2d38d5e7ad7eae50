//! Damaged (corrupted) packs, triangle meshes and height fields: each is rejected, or answers every
//! query without a panic, a hang or a read out of bounds.
//!
//! 1. A changed, cut or lengthened file is rejected: the checksum covers every byte.
//! 2. With a corrected checksum, it represents a malicious file. It is rejected, or it opens and
//!    answers all queries, even if its values are wrong.
//!
//! The tests try a random sample; the program `hostile-packs` tries all. The checksum is computed
//! independently, as the documentation describes it.

use hullmap::{IndexKind, Pack};
use hullmap_testkit::packs::reseal;
use hullmap_tests::hostile::inquiry::Extent;
use hullmap_tests::hostile::samples::{self, Sample};
use hullmap_tests::hostile::series::{MAX_ADDED, Series};
use hullmap_tests::hostile::trial::Tally;
use hullmap_tests::hostile::{sheets, tries};
use shapes::rng::SplitMix64;

/// Seed of the random changes.
const SEED: u64 = 0xdead;

const THREADS: usize = 2;

/// Number of members of a series that are tried on each pack.
const SHARE: usize = 250;

/// About `SHARE` indices below `count`, one from each of `SHARE` equal ranges.
fn share(count: usize) -> Vec<usize> {
    let mut rng = SplitMix64::new(SEED);
    let length = count.div_ceil(SHARE).max(1);
    let mut indices: Vec<usize> = (0..count).step_by(length).map(|start| start + rng.below(length)).collect();
    indices.retain(|index| *index < count);
    indices
}

/// All small files.
fn all() -> Vec<Sample> {
    [samples::small(), sheets::small()].concat()
}

/// Tries some changes of every small file.
fn try_all(series: Series, indices: impl Fn(Option<usize>) -> Vec<usize>) -> Tally {
    let mut sum = Tally::default();
    all().iter().for_each(|sample| sum += tries::checked(sample, series, (SEED, THREADS, Extent::BRIEF), &indices));
    println!("{series:?}: {sum}");
    sum
}

#[test]
fn every_flipped_bit_is_detected() {
    let tally = try_all(Series::Bits, |count| (0..count.unwrap()).collect());
    assert!(tally.tried > 500_000 && tally.opened == 0, "{tally}");
}

#[test]
fn every_cut_or_lengthened_file_is_rejected() {
    // All lengths with the old checksum, and a sample of those with a correct one.
    let tally = try_all(Series::Lengths, |count| {
        let count = count.unwrap();
        let mut indices: Vec<usize> = (0..count).step_by(3).collect();
        indices.extend(share(count).into_iter().filter(|index| index % 3 > 0));
        indices
    });
    assert!(tally.tried > all().len() * MAX_ADDED && tally.opened == 0, "{tally}");
}

#[test]
fn flipped_bits_under_a_correct_checksum_are_rejected_or_harmless() {
    for sample in all() {
        let mut same = sample.file.clone();
        reseal(&mut same);
        assert_eq!(same, sample.file, "{}: the checksum is the documented one", sample.name);
    }
    try_all(Series::SealedBits, |count| share(count.unwrap())).assert_representative();
}

#[test]
fn extreme_words_under_a_correct_checksum_are_rejected_or_harmless() {
    try_all(Series::Words, |count| share(count.unwrap())).assert_representative();
}

/// Several changes at once are the most likely to pass checks of single values.
#[test]
fn several_random_changes_under_a_correct_checksum_are_rejected_or_harmless() {
    try_all(Series::Drawn, |_| (0..SHARE / 2).collect()).assert_representative();
}

/// If damaged files are opened without the checks that would reject them, answers are wrong, but
/// every query ends, and no query panics.
#[test]
fn queries_end_on_damage_that_opening_did_not_check() {
    let some = |count: Option<usize>| share(count.unwrap_or(SHARE)).into_iter().filter(|index| index % 5 == 0);
    let (sum, queried) = tries::unchecked(&samples::small(), (SEED, THREADS), |count| some(count).collect());
    println!("unchecked: {sum}, {queried} sets of queries");
    assert!(queried > sum.tried, "too few files opened");
}

#[test]
fn the_samples_are_of_all_kinds() {
    let (mut ranks, mut kinds, mut several, mut boxes) = ([0; 4], [0; 4], 0, 0);
    let samples = samples::small();
    for sample in &samples {
        let pack = Pack::from_bytes(&sample.file).unwrap();
        several += usize::from(pack.hull_count() > 1);
        boxes = boxes.max(pack.hull_count());
        for hull in pack.hulls() {
            ranks[hull.rank() as usize] += 1;
            let kind = match hull.index_kind() {
                IndexKind::None => 0,
                IndexKind::CubeMap { .. } => 1,
                IndexKind::Binary => 2,
                IndexKind::Tree | IndexKind::Medium | IndexKind::Compact => 3,
            };
            kinds[kind] += 1;
        }
    }
    println!("{} packs, ranks {ranks:?}, kinds {kinds:?}, {several} of several hulls", samples.len());
    assert!(samples.len() >= 20 && several >= 5 && boxes >= 5);
    assert!(ranks.iter().chain(&kinds).all(|count| *count >= 2), "{ranks:?} {kinds:?}");
    let hulls = |name: &str| Pack::from_bytes(&samples::named(name)).unwrap();
    assert!(hulls("simplified, tree").hulls().all(|hull| hull.outer_error() > 0.0 && hull.source_vertex(0).is_none()));
    assert_eq!(hulls("parts, tree").hulls().map(|hull| hull.part()).max(), Some(2));
    assert!(hulls("recentred, tree").hulls().all(|hull| hull.origin().x == 1e7));
    assert!(hulls("sphere, tree").hulls().all(|hull| hull.outer_vertices().len() > 0));
    let drawn: usize = (0..20).map(|index| samples::drawn(SEED, index).file.len()).sum();
    assert_eq!(samples::drawn(SEED, 3).file, samples::drawn(SEED, 3).file);
    assert!(drawn > 100_000, "{drawn}");
}
