//! Emptying the caches between cold queries.
//!
//! One word in each cache line of a buffer of twice the last-level cache is read and written. That
//! evicts everything else from all cache levels and from the TLB. The size is what Linux reports
//! for processor 0, or 32 MiB if it reports none. On a shared machine the real cache may be larger.

use std::{fs, hint::black_box};

/// Size of the buffer, in sizes of the last-level cache. Twice, since caches do not always replace
/// the oldest line.
const LAST_LEVEL_FACTOR: usize = 2;

/// Assumed last-level cache of a machine that does not report it, in bytes.
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
        // Not zeros: until they are written, all pages of zeros are the same physical page.
        Self { buffer: vec![1; bytes / size_of::<u64>()] }
    }

    /// Size of the buffer, in bytes.
    pub fn byte_len(&self) -> usize {
        size_of_val(self.buffer.as_slice())
    }

    /// Evicts everything else from the caches.
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

/// Size of the largest cache of processor 0, in bytes; `None` if the system does not report it.
pub fn last_level_bytes() -> Option<usize> {
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
