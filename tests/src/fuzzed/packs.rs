//! Reads bytes as a pack, as a triangle mesh and as a height field.

use hullmap_testkit::packs::reseal;
use shapes::rng::SplitMix64;

use crate::hostile::{HEADER_LEN, inquiry::Extent, kinds::AnyInquiry, samples, sheets};

/// The bytes of a valid header before the payload's length: magic, version, header length.
const FRONT: usize = 16;

/// Maximum number of words changed at once.
const MAX_WORDS: usize = 4;

/// A valid file's front, and the queries for files of its kind.
type Kind = (Vec<u8>, AnyInquiry);

thread_local! {
    static PACK: Kind = kind(&samples::named("sphere, tree"));
    static SHEETS: [Kind; 2] =
        ["mesh, rough floor", "field, square with holes"].map(|name| kind(&sheets::named(name)));
}

fn kind(file: &[u8]) -> Kind {
    (file[..FRONT].to_vec(), AnyInquiry::new(file, Extent::BRIEF))
}

/// Opens the bytes unchanged, then with a corrected header. Queries each pack that opens. Panics if
/// a query panics, or its answer refers to something that does not exist.
pub fn open_and_query(data: &[u8]) {
    PACK.with(|pack| try_kind(data, pack));
}

/// As [`open_and_query`], as a triangle mesh and as a height field.
pub fn open_sheets(data: &[u8]) {
    SHEETS.with(|sheets| sheets.iter().for_each(|sheet| try_kind(data, sheet)));
}

fn try_kind(data: &[u8], (front, inquiry): &Kind) {
    // The file may be rejected.
    let _ = inquiry.run(data);
    if data.len() < HEADER_LEN {
        return;
    }
    let mut file = data.to_vec();
    file[..FRONT].copy_from_slice(front);
    file[FRONT..24].copy_from_slice(&((data.len() - HEADER_LEN) as u64).to_le_bytes());
    file[48..56].fill(0);
    reseal(&mut file);
    let _ = inquiry.run(&file);
}

/// Changes a few aligned words of a pack's payload in place: to small numbers, to other words of
/// the pack, by a small amount, or to arbitrary values. The result is almost a valid pack. A file
/// with inserted or removed bytes would fail the first check.
pub fn change_pack(file: &mut [u8], seed: u32) {
    let words = file.len().saturating_sub(HEADER_LEN) / 4;
    if words == 0 {
        return;
    }
    let mut rng = SplitMix64::new(seed.into());
    for _ in 0..1 + rng.below(MAX_WORDS) {
        let at = HEADER_LEN + 4 * rng.below(words);
        let other = HEADER_LEN + 4 * rng.below(words);
        let word = |at: usize| u32::from_le_bytes([file[at], file[at + 1], file[at + 2], file[at + 3]]);
        let (old, taken) = (word(at), word(other));
        let new = match rng.below(8) {
            0 => rng.below(16) as u32,
            1 => taken,
            2 => old.wrapping_add(1),
            3 => old.wrapping_sub(1),
            4 => old ^ 1 << rng.below(32),
            5 => rng.next_u64() as u32,
            6 => (words as u32).wrapping_sub(rng.below(4) as u32),
            _ => [u32::MAX, 1 << 31, f32::NAN.to_bits(), f32::MAX.to_bits()][rng.below(4)],
        };
        file[at..at + 4].copy_from_slice(&new.to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Files of one or two words caused a panic.
    #[test]
    fn files_of_any_length_can_be_changed() {
        for len in [0, 1, 63, 64, 67, 68, 71, 72, 500] {
            for seed in 0..200 {
                let mut file = vec![7; len];
                change_pack(&mut file, seed);
                assert_eq!(file.len(), len);
                assert!(file.iter().take(HEADER_LEN).all(|byte| *byte == 7), "the header is not touched");
            }
        }
    }
}
