//! Shards: one build on several machines that share nothing but their inputs.
//!
//! XXH3-64 of a mesh's place, its path relative to the input folder, selects its shard. So shards
//! are disjoint and complete without a database, and a new mesh moves no other.

use std::fmt;
use std::str::FromStr;

use twox_hash::XxHash3_64;

/// One of several shards: `2/8` is the third of eight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: u32,
    count: u32,
}

impl Shard {
    pub fn index(self) -> u32 {
        self.index
    }

    pub fn count(self) -> u32 {
        self.count
    }

    /// Whether the file at a place belongs to this shard.
    pub fn holds(self, place: &str) -> bool {
        shard_of(place, self.count) == self.index
    }
}

pub fn shard_of(place: &str, count: u32) -> u32 {
    (place_hash(place) % u64::from(count.max(1))) as u32
}

pub fn place_hash(place: &str) -> u64 {
    XxHash3_64::oneshot(place.as_bytes())
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("expected I/N, where I counts from 0 to N-1, such as 0/8; found `{text}`");
        let (index, count) = text.split_once('/').ok_or_else(expected)?;
        let number = |text: &str| text.parse::<u32>().map_err(|_| expected());
        let shard = Self { index: number(index)?, count: number(count)? };
        if shard.index < shard.count { Ok(shard) } else { Err(expected()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_disjoint_and_complete_and_of_similar_size() {
        let places: Vec<String> = (0..4000).map(|i| format!("props/{}/mesh {i}.obj", i % 17)).collect();
        for count in [1, 2, 3, 8, 64] {
            let shards: Vec<Shard> = (0..count).map(|index| format!("{index}/{count}").parse().unwrap()).collect();
            let sizes: Vec<usize> =
                shards.iter().map(|shard| places.iter().filter(|place| shard.holds(place)).count()).collect();
            assert!(places.iter().all(|place| shards.iter().filter(|shard| shard.holds(place)).count() == 1));
            assert_eq!(sizes.iter().sum::<usize>(), places.len());
            let fair = places.len() / count as usize;
            assert!(sizes.iter().all(|&size| size * 2 > fair && size < fair * 2), "{count}: {sizes:?}");
        }
    }

    /// Machines with another version must agree. The remainders come from the C library xxHash.
    #[test]
    fn the_shard_of_a_place_never_changes() {
        let shards = ["a.obj", "props/crate.glb", "ünï/ç.stl"].map(|place| shard_of(place, 1000));
        assert_eq!(shards, [489, 645, 282]);
    }

    #[test]
    fn wrong_shards_are_rejected() {
        for text in ["", "1", "8/8", "9/8", "0/0", "-1/8", "a/b", "1/", "/1", "1/2/3", "0/4294967296"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
        assert_eq!("7/8".parse::<Shard>().unwrap().to_string(), "7/8");
    }
}
