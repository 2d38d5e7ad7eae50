//! Emptying the caches between cold queries.
//!
//! A buffer of twice the last-level cache is read and written once a cache line, which pushes
//! everything else out of all levels, and out of the TLB. The size is what Linux says of the first processor; where it
//! says nothing, 32 MiB. On a shared machine the cache may be larger than a guest is told.

use std::{fs, hint::black_box};

/// How many times the last-level cache is swept through. Twice, as caches replace not quite the oldest line.
const LAST_LEVEL_FACTOR: usize = 2;

/// Last-level cache of a machine that does not tell, in bytes.
const FALLBACK_BYTES: usize = 32 << 20;

/// Length of a cache line, in 8-byte words.
const LINE_WORDS: usize = 8;

/// The buffer.
pub struct Eviction {
    buffer: Vec<u64>,
}

impl Eviction {
    /// A buffer for this machine.
    pub fn new() -> Self {
        let bytes = LAST_LEVEL_FACTOR * last_level_bytes().unwrap_or(FALLBACK_BYTES);
        // Not of zeros: pages of zeros are all the same physical page until they are written.
        Self { buffer: vec![1; bytes / size_of::<u64>()] }
    }

    /// Size of the buffer, in bytes.
    pub fn byte_len(&self) -> usize {
        size_of_val(self.buffer.as_slice())
    }

    /// Sweeps the caches.
    pub fn evict(&mut self) {
        for line in self.buffer.chunks_mut(LINE_WORDS) {
            line[0] = line[0].wrapping_add(1);
        }
        black_box(&mut self.buffer);
    }
}

impl Default for Eviction {
    fn default() -> Self {
        Self::new()
    }
}

/// The largest cache of processor 0, in bytes.
fn last_level_bytes() -> Option<usize> {
    let caches = fs::read_dir("/sys/devices/system/cpu/cpu0/cache").ok()?;
    caches
        .filter_map(|cache| {
            let text = fs::read_to_string(cache.ok()?.path().join("size")).ok()?;
            let text = text.trim();
            let (digits, unit) = text.split_at(text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len()));
            let unit = match unit {
                "" => 1,
                "K" => 1 << 10,
                "M" => 1 << 20,
                _ => return None,
            };
            digits.parse::<usize>().ok()?.checked_mul(unit)
        })
        .max()
}
