//! Many pairs at once.
#![allow(unsafe_code)]

use crate::batch;
use crate::border::{self, call};
use crate::failure::{Failure, Fallible};
use crate::handles::{Cache, Manifold, Shape};
use crate::query::CheckedPair;
use crate::types::{Contact, Distance, Intersection, ManifoldPoints, ManifoldSettings, Pose, Result, Settings};

/// Two shapes and the pose of B in A's frame.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ShapePair {
    /// The first shape.
    pub a: *const Shape,
    /// The second shape.
    pub b: *const Shape,
    /// The pose of B in A's frame.
    pub b_in_a: Pose,
}

/// Checks all pairs, so that a wrong one fails before any is solved.
///
/// # Safety
/// The pointers are as the rules at the head of the header require.
unsafe fn pairs<'p>(pairs: *const ShapePair, count: usize) -> Fallible<Vec<CheckedPair<'p>>> {
    // SAFETY: this function's contract.
    let pairs = unsafe { border::array("pairs", pairs, count)? };
    let mut found = Vec::with_capacity(count);
    for (index, pair) in pairs.iter().enumerate() {
        // SAFETY: this function's contract.
        let pair = unsafe { super::query::pair(pair.a, pair.b, &raw const pair.b_in_a) };
        found.push(pair.map_err(|failure: Failure| failure.of_pair(index))?);
    }
    Ok(found)
}

/// An array of handles.
///
/// # Safety
/// The pointers are as the rules at the head of the header require.
unsafe fn handles<'h, T>(name: &str, handles: *const *mut T, count: usize) -> Fallible<Vec<&'h T>> {
    // SAFETY: this function's contract.
    let handles = unsafe { border::array(name, handles, count)? };
    // SAFETY: as above.
    let each = handles.iter().enumerate().map(|(index, handle)| unsafe {
        border::handle("", *handle)
            .map_err(|failure| Failure { message: format!("{name}[{index}]{}", failure.message), ..failure })
    });
    each.collect()
}

/// # Safety
/// The pointers are as the rules at the head of the header require.
unsafe fn optional_caches<'h>(caches: *const *mut Cache, count: usize) -> Fallible<Option<Vec<&'h Cache>>> {
    if caches.is_null() {
        return Ok(None);
    }
    // SAFETY: this function's contract.
    unsafe { handles("caches", caches, count) }.map(Some)
}

/// Answers a query of each pair.
///
/// # Safety
/// The pointers are as the rules at the head of the header require.
unsafe fn of_pairs<S: Copy, T: Send, Q: Fn(&CheckedPair<'_>, &mut hullmap::Cache) -> T + Sync>(
    (pairs, count): (*const ShapePair, usize),
    (settings, caches, out): (*const S, *const *mut Cache, *mut T),
    query: impl FnOnce(Option<S>) -> Q,
) -> Result {
    call(|| {
        // SAFETY: this function's contract.
        let (pairs, settings, caches, out) = unsafe {
            let (pairs, settings) = (self::pairs(pairs, count)?, border::read_sized("settings", settings)?);
            (pairs, settings, optional_caches(caches, count)?, border::answers("out", out, count)?)
        };
        batch::each(&pairs, caches.as_deref(), out, query(settings))
    })
}

/// hullmap_intersects() of `count` pairs, on all cores.
///
/// Pair i uses `caches[i]` and writes `out[i]`. caches may be NULL; otherwise no cache may occur
/// twice. Answers have the same bits as in single queries with the same caches. All pairs are
/// checked first: if one is wrong, the message has its index, and nothing is written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_batch_intersects(
    pairs: *const ShapePair,
    count: usize,
    caches: *const *mut Cache,
    out: *mut Intersection,
) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe {
        of_pairs((pairs, count), (std::ptr::null::<Settings>(), caches, out), |_| {
            |pair: &CheckedPair<'_>, memory: &mut hullmap::Cache| {
                hullmap::intersects(&pair.a.0, &pair.b.0, pair.b_in_a, memory)
            }
        })
    }
}

/// hullmap_distance() of `count` pairs, on all cores. As hullmap_batch_intersects(); settings may
/// be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_batch_distance(
    pairs: *const ShapePair,
    count: usize,
    settings: *const Settings,
    caches: *const *mut Cache,
    out: *mut Distance,
) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe {
        of_pairs((pairs, count), (settings, caches, out), |settings| {
            let settings = super::settings(settings);
            move |pair: &CheckedPair<'_>, memory: &mut hullmap::Cache| {
                hullmap::distance(&pair.a.0, &pair.b.0, pair.b_in_a, &settings, memory)
            }
        })
    }
}

/// hullmap_contact() of `count` pairs, on all cores. As hullmap_batch_intersects(); settings may be
/// NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_batch_contact(
    pairs: *const ShapePair,
    count: usize,
    settings: *const Settings,
    caches: *const *mut Cache,
    out: *mut Contact,
) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe {
        of_pairs((pairs, count), (settings, caches, out), |settings| {
            let settings = super::settings(settings);
            move |pair: &CheckedPair<'_>, memory: &mut hullmap::Cache| {
                hullmap::contact(&pair.a.0, &pair.b.0, pair.b_in_a, &settings, memory)
            }
        })
    }
}

/// hullmap_manifold_update() of `count` pairs, on all cores. As hullmap_batch_intersects(): pair i
/// updates `manifolds[i]`, and no manifold may occur twice. settings may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_batch_manifolds(
    pairs: *const ShapePair,
    count: usize,
    settings: *const ManifoldSettings,
    manifolds: *const *mut Manifold,
    out: *mut ManifoldPoints,
) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (pairs, settings, manifolds, out) = unsafe {
            let (pairs, settings) = (self::pairs(pairs, count)?, border::read_sized("settings", settings)?);
            (pairs, settings, handles("manifolds", manifolds, count)?, border::answers("out", out, count)?)
        };
        batch::manifolds(&pairs, &super::manifold_settings(settings)?, &manifolds, out)
    })
}
