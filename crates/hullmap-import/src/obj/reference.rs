//! Wavefront OBJ: vertex references, resolved to zero-based indices.

use crate::fault::{Fault, excerpt};

/// For instance `7`, `7/1`, `7//3`, `7/1/3` or `-1`, with `declared` `v` lines above. Indices of
/// texture coordinates and normals must be integers in any range. An index that `u32` cannot hold
/// becomes `u32::MAX`, which no file has. Fails for other words, 0, and indices before the first
/// vertex.
pub fn resolve_reference(word: &str, declared: usize) -> Result<u32, Fault> {
    let bad = || Fault::BadReference { text: excerpt(word) };
    let mut parts = word.split('/');
    let index: i64 = parts.next().unwrap_or("").parse().map_err(|_| bad())?;
    let mut other_count = 0;
    for part in parts {
        other_count += 1;
        if other_count > 2 || !(part.is_empty() || part.parse::<i64>().is_ok()) {
            return Err(bad());
        }
    }
    match index {
        0 => Err(Fault::ZeroIndex { text: excerpt(word) }),
        1.. => Ok(u32::try_from(index - 1).unwrap_or(u32::MAX)),
        _ => usize::try_from(index.unsigned_abs())
            .ok()
            .and_then(|back| declared.checked_sub(back))
            .map(|index| index as u32)
            .ok_or_else(|| Fault::IndexBeforeFirst { text: excerpt(word), declared }),
    }
}
