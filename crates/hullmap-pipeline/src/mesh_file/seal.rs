//! The seal of a written file: a hash in the file itself, of all its other bytes.
//!
//! Writers put [`SEAL`] into a comment, then [`sealed`] replaces its zeros by the hash (XXH3). So a
//! later run knows a file that is still as it was written, and may replace it. A file that was
//! edited meanwhile, or that another program wrote, has no seal that matches. The hash shows
//! changes, not origin: anyone can write it.

use twox_hash::XxHash3_64;

const START: &str = "exported by bake, seal ";
const ZEROS: &str = "0000000000000000";

/// Maximum number of seals that are checked, each by a pass over the file.
const MAX_SEALS: usize = 8;

/// A writer puts it into the file, once.
pub const SEAL: &str = "exported by bake, seal 0000000000000000";

/// The file with its hash in place of the zeros of the first [`SEAL`].
#[must_use]
pub fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let open = places(&bytes).find(|&at| bytes[at..].starts_with(ZEROS.as_bytes()));
    if let Some(at) = open {
        let hash = digits(&bytes);
        bytes[at..at + ZEROS.len()].copy_from_slice(hash.as_bytes());
    }
    bytes
}

/// Whether a file is as [`sealed`] left it. A file that was added to another sealed file has two.
pub fn is_sealed(mut bytes: Vec<u8>) -> bool {
    let places: Vec<usize> = places(&bytes).take(MAX_SEALS).collect();
    places.into_iter().any(|at| {
        let own = at..at + ZEROS.len();
        let Some(found) = bytes.get(own.clone()).map(<[u8]>::to_vec) else { return false };
        bytes[own.clone()].copy_from_slice(ZEROS.as_bytes());
        let is_own = digits(&bytes).as_bytes() == found;
        bytes[own].copy_from_slice(&found);
        is_own
    })
}

/// Where digits of seals start.
fn places(bytes: &[u8]) -> impl Iterator<Item = usize> {
    let windows = bytes.windows(START.len()).enumerate();
    windows.filter(|(_, window)| *window == START.as_bytes()).map(|(at, _)| at + START.len())
}

fn digits(bytes: &[u8]) -> String {
    format!("{:016x}", XxHash3_64::oneshot(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_change_breaks_the_seal() {
        assert_eq!(SEAL, format!("{START}{ZEROS}"));
        let bytes = sealed(format!("# Hulls, {SEAL}\nv 1 2 3\n").into_bytes());
        assert!(is_sealed(bytes.clone()) && !String::from_utf8_lossy(&bytes).contains(ZEROS));
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 1;
            assert!(!is_sealed(changed), "{at}");
            assert!(!is_sealed(bytes[..at].to_vec()), "cut after {at} bytes");
        }
        // A file that was made from a sealed one.
        let second = [&bytes, format!("# {SEAL}\nv 4 5 6\n").as_bytes()].concat();
        assert!(!is_sealed(second.clone()) && is_sealed(sealed(second)));
        assert!(!is_sealed(b"no seal".to_vec()));
    }
}
