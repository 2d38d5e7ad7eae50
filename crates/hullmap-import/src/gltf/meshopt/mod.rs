//! glTF 2.0: buffer views compressed by `EXT_meshopt_compression` or `KHR_meshopt_compression`.
//!
//! 1. Only views with positions or vertex indices of the scene are decoded, unless a fallback
//!    buffer has them uncompressed.
//! 2. [`attributes`] decodes positions, and [`indices`] vertex indices.
//! 3. The filter `EXPONENTIAL` is applied to positions.
//!
//! # Deviations
//! `EXT_meshopt_compression` may use version 1 of attributes, as in its decoders. The filters
//! `OCTAHEDRAL`, `QUATERNION` and `COLOR` are rejected: normals, rotations and colours are not
//! read.
//!
//! # Reference
//! Khronos, "KHR_meshopt_compression" (release candidate of 2026) and "EXT_meshopt_compression",
//! appendices A and B. Decision 17 has the reason for a decoder of our own.

mod attributes;
mod bytes;
mod indices;

use std::collections::HashMap;

use super::container::Container;
use super::document::{BufferView, Filter, Meshopt, Mode};
use crate::fault::LineFault;
use crate::limits::Limits;
use bytes::Damage;

/// Bytes of decoded data that count as one repeated vertex, with half of the memory of one.
const BYTES_PER_VERTEX: usize = 32;

const MAX_STRIDE: u64 = 256;

#[derive(Debug, Default)]
pub struct DecodedViews {
    pub views: HashMap<u32, Vec<u8>>,
    pub repeated_count: usize,
}

/// Decodes the compressed ones of these views, within the limit.
pub fn decode(
    container: &Container,
    buffers: &[Option<&[u8]>],
    views: &[u32],
    limits: &Limits,
) -> Result<DecodedViews, LineFault> {
    let mut decoded = DecodedViews::default();
    for &index in views {
        let Some(view) = container.document.buffer_views.get(index as usize) else {
            continue;
        };
        let Some((extension, data)) = container.compression(view).filter(|_| !decoded.views.contains_key(&index))
        else {
            continue;
        };
        let fault = |text: &str| {
            LineFault::of_file(format!("buffer view {index}, compressed by {extension}, {text}; export the file again"))
        };
        let size = check(view, data).map_err(fault)?;
        decoded.repeated_count = decoded.repeated_count.saturating_add(size.div_ceil(BYTES_PER_VERTEX));
        if decoded.repeated_count > limits.repeated_vertices {
            return Err(limits.too_much_repetition().of_file());
        }
        let bytes = bytes_of(buffers, data).ok_or_else(|| fault("has its data beyond the end of a buffer"))?;
        let bytes = decode_view(bytes, data).map_err(|damage| fault(&format!("is damaged: {damage}")))?;
        decoded.views.insert(index, bytes);
    }
    Ok(decoded)
}

fn bytes_of<'a>(buffers: &[Option<&'a [u8]>], data: &Meshopt) -> Option<&'a [u8]> {
    let buffer: &[u8] = (*buffers.get(data.buffer as usize)?)?;
    let rest = buffer.get(usize::try_from(data.byte_offset).ok()?..)?;
    rest.get(..usize::try_from(data.byte_length).ok()?)
}

/// Size of a decoded view in bytes. Fails if its properties contradict one another.
fn check(view: &BufferView, data: &Meshopt) -> Result<usize, &'static str> {
    let stride = data.byte_stride;
    let is_stride_valid = match data.mode {
        Mode::Attributes => stride.is_multiple_of(4) && (4..=MAX_STRIDE).contains(&stride),
        Mode::Triangles | Mode::Indices => stride == 2 || stride == 4,
        Mode::Other => return Err("has an unknown mode"),
    };
    if !is_stride_valid {
        return Err("has an invalid stride");
    }
    if data.mode == Mode::Triangles && !data.count.is_multiple_of(3) {
        return Err("does not have three indices for each triangle");
    }
    match (data.filter, data.mode) {
        (Filter::None, _) | (Filter::Exponential, Mode::Attributes) => {}
        (Filter::Exponential, _) => return Err("has a filter on vertex indices"),
        (Filter::Other, _) => return Err("has a filter that is not for positions"),
    }
    let size = data.count.checked_mul(stride).filter(|&size| size == view.byte_length);
    size.and_then(|size| usize::try_from(size).ok()).ok_or("has another size than its elements")
}

fn decode_view(bytes: &[u8], data: &Meshopt) -> Result<Vec<u8>, Damage> {
    let (count, stride) = (data.count as usize, data.byte_stride as usize);
    let decoded = match data.mode {
        Mode::Triangles => indices::decode_triangles(bytes, count)?,
        Mode::Indices => indices::decode_sequence(bytes, count)?,
        Mode::Attributes | Mode::Other => {
            let mut decoded = attributes::decode(bytes, count, stride)?;
            if data.filter == Filter::Exponential {
                attributes::expand_exponents(&mut decoded);
            }
            return Ok(decoded);
        }
    };
    let mut bytes = Vec::with_capacity(count * stride);
    for index in decoded {
        // Indices of two bytes wrap around.
        bytes.extend(index.to_le_bytes().into_iter().take(stride));
    }
    Ok(bytes)
}
