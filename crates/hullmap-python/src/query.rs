//! Which pairs of shapes a query takes, and their caches.

use hullmap::{Cache, SharedGeometry};

/// Entries of a cache: pairs of parts that are near each other in one pose.
const PART_PAIRS: usize = 16;

/// An empty cache of a pair. Without parts, it allocates nothing.
pub fn cache_of([a, b]: [&SharedGeometry; 2]) -> Cache {
    if a.has_parts() || b.has_parts() { Cache::with_pairs(PART_PAIRS) } else { Cache::new() }
}

/// Why a pair of shapes cannot be queried.
pub fn obstacle(query: &str, a: &SharedGeometry, b: &SharedGeometry, takes_parts: bool) -> Option<String> {
    if let Err(error) = a.check_pair(b) {
        return Some(format!("{query}: {error}"));
    }
    if takes_parts {
        return None;
    }
    if matches!(b, SharedGeometry::HalfSpace(_)) {
        let remedy = "make it the first shape, and pass the pose of the other one in its frame";
        return Some(format!("{query}: a half-space must be the first shape of a pair: {remedy}"));
    }
    [a, b].into_iter().find_map(|side| match side {
        SharedGeometry::Compound(_) => {
            Some(format!("{query} takes convex shapes, found a pack: query it by {query}s, or its hulls one by one"))
        }
        SharedGeometry::Sheet(sheet) => {
            Some(format!("{query} takes convex shapes, found {}: query it by {query}s", sheet.name()))
        }
        _ => None,
    })
}
