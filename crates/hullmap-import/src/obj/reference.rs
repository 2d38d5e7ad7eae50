//! Vertex references of an OBJ file, or why they are none.

use crate::fault::{Fault, excerpt};

/// Zero-based vertex number of a reference such as `7`, `7/1`, `7//3`, `7/1/3` or `-1`, with `declared` vertices
/// above it. The numbers of texture coordinates and normals must be numbers; their range does not matter to a hull.
pub fn resolve_reference(word: &str, declared: usize) -> Result<u32, Fault> {
    let bad = || Fault::BadReference { text: excerpt(word) };
    let mut parts = word.split('/');
    let number: i64 = parts.next().unwrap_or("").parse().map_err(|_| bad())?;
    let mut other_count = 0;
    for part in parts {
        other_count += 1;
        if other_count > 2 || !(part.is_empty() || part.parse::<i64>().is_ok()) {
            return Err(bad());
        }
    }
    match number {
        0 => Err(Fault::ZeroIndex { text: excerpt(word) }),
        // Beyond u32 it is out of range whatever follows: the scan says so at its end, with the vertex count.
        1.. => Ok(u32::try_from(number - 1).unwrap_or(u32::MAX)),
        _ => usize::try_from(number.unsigned_abs())
            .ok()
            .and_then(|back| declared.checked_sub(back))
            .map(|index| index as u32)
            .ok_or_else(|| Fault::IndexBeforeFirst { text: excerpt(word), declared }),
    }
}
