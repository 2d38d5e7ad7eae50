//! Caches.
#![allow(unsafe_code)]

use crate::border::{self, Out, call};
use crate::handles::{Cache, Empty};
use crate::types::Result;

/// Makes an empty cache: about 1.3 KB, and 90 KB more at the first query of a compound.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_cache_new(cache: *mut *mut Cache) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let out = unsafe { Out::of_handle("cache", cache)? };
        out.give(Cache::new());
        Ok(())
    })
}

/// Empties a cache, for instance because its pair now consists of other shapes. Not required: a
/// stale cache costs time, and never makes an answer wrong.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_cache_clear(cache: *mut Cache) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let cache = unsafe { border::handle("cache", cache)? };
        cache.0.take("cache")?.empty();
        Ok(())
    })
}

/// Frees a cache; NULL is allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_cache_free(cache: *mut Cache) {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { border::free(cache) }
}
