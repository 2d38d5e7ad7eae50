//! Ways to change a file. Each is a series with indexed members.

use hullmap_format::header::FileKind;
use hullmap_testkit::packs::reseal;
use shapes::rng::SplitMix64;

use super::{HEADER_LEN, kinds, samples::Sample};

/// Maximum number of bytes added to a file.
pub const MAX_ADDED: usize = 4096;

/// Maximum number of draws for a change with which alone the file still opens. Two thirds of the
/// draws succeed.
const DRAWS: usize = 12;

/// Bytes of the payload's length in the header.
const LENGTH_AT: std::ops::Range<usize> = 16..24;

/// A way to change files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Series {
    /// Each bit flipped; the checksum left as it is.
    Bits,
    /// Each bit flipped; the checksum corrected.
    SealedBits,
    /// Each prefix, and each extension by 1 to [`MAX_ADDED`] bytes: unchanged, with a corrected
    /// checksum, and with the length corrected too.
    Lengths,
    /// Each 32-bit word after the header set to each of [`Subject::values`]; the checksum
    /// corrected.
    Words,
    /// Two to six words changed at once. With each of these changes alone, the file opens. One
    /// member in four has another change, with which it may not open. Such combinations are the
    /// most likely to pass checks of single values. The checksum is corrected.
    Drawn,
}

/// A file to change.
pub struct Subject<'s> {
    /// The file.
    pub sample: &'s Sample,
    /// Values that are most likely to cause faults: ends of ranges, lengths and offsets in this
    /// file, special floats.
    pub values: Vec<u32>,
    kind: FileKind,
    seed: u64,
}

impl<'s> Subject<'s> {
    /// A subject from a file and the seed of the random changes. Panics if the file does not open.
    pub fn new(sample: &'s Sample, seed: u64) -> Self {
        Self { sample, values: values(&sample.file), kind: kinds::kind_of(&sample.file), seed }
    }

    /// Writes member `index` of a series to `out`.
    pub fn change(&self, series: Series, index: usize, out: &mut Vec<u8>) {
        let file = &self.sample.file;
        out.clear();
        out.extend_from_slice(file);
        match series {
            Series::Bits => flip(out, index),
            Series::SealedBits => {
                flip(out, index);
                reseal(out);
            }
            Series::Lengths => {
                let (index, sealed) = (index / 3, index % 3);
                let filler = [0, 0xff, b'\n'][index % 3];
                let len = if index < file.len() { index } else { index + 1 };
                out.resize(len, filler);
                if sealed > 1 && len >= HEADER_LEN {
                    out[LENGTH_AT].copy_from_slice(&((len - HEADER_LEN) as u64).to_le_bytes());
                }
                if sealed > 0 {
                    reseal(out);
                }
            }
            Series::Words => {
                set_word(out, index / self.values.len(), self.values[index % self.values.len()]);
                reseal(out);
            }
            Series::Drawn => self.draw(index, out),
        }
    }

    /// Number of members of a finite series; `None` for a random one.
    pub fn count(&self, series: Series) -> Option<usize> {
        let len = self.sample.file.len();
        match series {
            Series::Bits | Series::SealedBits => Some(8 * len),
            Series::Lengths => Some(3 * (len + MAX_ADDED)),
            Series::Words => Some((len - HEADER_LEN) / 4 * self.values.len()),
            Series::Drawn => None,
        }
    }

    fn draw(&self, index: usize, out: &mut [u8]) {
        let mut rng = SplitMix64::new(self.seed ^ (index as u64) << 20);
        let words = (out.len() - HEADER_LEN) / 4;
        for _ in 0..2 + rng.below(5) {
            for _ in 0..DRAWS {
                let (word, value) = (rng.below(words), self.values[rng.below(self.values.len())]);
                let mut alone = self.sample.file.clone();
                set_word(&mut alone, word, value);
                reseal(&mut alone);
                if alone != self.sample.file && kinds::opens(self.kind, &alone) {
                    set_word(out, word, value);
                    break;
                }
            }
        }
        if rng.below(4) == 0 {
            let (at, other) = (HEADER_LEN + 4 * rng.below(words), HEADER_LEN + 4 * rng.below(words));
            match rng.below(3) {
                0 => flip(out, 8 * at + rng.below(32)),
                1 => out[at..at + 4].copy_from_slice(&(rng.next_u64() as u32).to_le_bytes()),
                _ => out.copy_within(other..other + 4, at),
            }
        }
        reseal(out);
    }
}

impl Series {
    /// Whether every member must be rejected.
    pub fn is_always_rejected(self) -> bool {
        matches!(self, Self::Bits | Self::Lengths)
    }
}

fn flip(file: &mut [u8], bit: usize) {
    file[bit / 8] ^= 1 << (bit % 8);
}

fn set_word(file: &mut [u8], word: usize, value: u32) {
    file[HEADER_LEN + 4 * word..][..4].copy_from_slice(&value.to_le_bytes());
}

fn values(file: &[u8]) -> Vec<u32> {
    let payload = (file.len() - HEADER_LEN) as u32;
    let [vertices, faces] = kinds::counts(file);
    let floats = [f32::NAN, f32::INFINITY, f32::MAX, -1.0].map(f32::to_bits);
    // High words of an f64: NaN, infinity, 1e308.
    let doubles = [f64::NAN, f64::INFINITY, 1e308].map(|x| (x.to_bits() >> 32) as u32);
    let mut values = vec![0, 1, 2, 6, u32::MAX, i32::MAX as u32, 1 << 31, 1 << 30, 0xffff];
    values.extend([payload, payload / 4, payload - 1, vertices, vertices - 1, vertices + 1, faces, faces + 1]);
    values.extend(floats.into_iter().chain(doubles));
    values.sort_unstable();
    values.dedup();
    values
}
