//! glTF 2.0: elements of an accessor, from a buffer view, from zeros, and from sparse replacements.

use std::collections::HashMap;

use super::document::{Accessor, Document, Kind};
use crate::fault::{Fault, counted};

/// Component types, as OpenGL numbers them.
const BYTE: u32 = 5120;
const UNSIGNED_BYTE: u32 = 5121;
const SHORT: u32 = 5122;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;

pub struct Data<'a> {
    pub document: &'a Document<'a>,
    /// Bytes of each buffer. `None` for a buffer without bytes, and for one that is not required.
    pub buffers: Vec<Option<&'a [u8]>>,
    pub decoded: &'a HashMap<u32, Vec<u8>>,
}

/// Sparse replacements: indices of the elements, ascending, and their values as bytes.
type Replaced<'a> = (Vec<u32>, &'a [u8]);

/// A checked accessor: all of its elements and replacements lie within their buffers.
pub struct AccessorReader<'a> {
    /// Bytes from the first element on. `None` stands for zeros.
    bytes: Option<&'a [u8]>,
    stride: usize,
    component_type: u32,
    is_normalized: bool,
    pub count: usize,
    replaced: Option<Replaced<'a>>,
    /// Number of components of an element.
    width: usize,
}

/// The remedy for most faults, which are mistakes of exporters.
const AGAIN: &str = "export the file again";

fn is_unsigned(component_type: u32) -> bool {
    matches!(component_type, UNSIGNED_BYTE | UNSIGNED_SHORT | UNSIGNED_INT)
}

fn component_name(component_type: u32) -> String {
    let name = match component_type {
        BYTE => "signed bytes",
        UNSIGNED_BYTE => "unsigned bytes",
        SHORT => "signed shorts",
        UNSIGNED_SHORT => "unsigned shorts",
        UNSIGNED_INT => "unsigned ints",
        FLOAT => "floats",
        _ => "an unknown type",
    };
    format!("{name} (component type {component_type})")
}

fn component_size(component_type: u32) -> Option<usize> {
    match component_type {
        BYTE | UNSIGNED_BYTE => Some(1),
        SHORT | UNSIGNED_SHORT => Some(2),
        UNSIGNED_INT | FLOAT => Some(4),
        _ => None,
    }
}

impl<'a> Data<'a> {
    /// Fails if it does not exist, is of another kind, or reaches beyond its buffer.
    pub fn accessor(&self, index: u32, kind: Kind) -> Result<AccessorReader<'a>, Fault> {
        let fault = |text: String| Fault::format(format!("accessor {index} {text}"));
        let Some(accessor) = self.document.accessors.get(index as usize) else {
            return Err(fault(format!("does not exist (the file has {}); {AGAIN}", self.document.accessors.len())));
        };
        if accessor.kind != kind {
            return Err(fault(format!("is not of type {}; {AGAIN}", kind.name())));
        }
        let Some(size) = component_size(accessor.component_type) else {
            return Err(fault(format!("has the unknown component type {}; {AGAIN}", accessor.component_type)));
        };
        let (purpose, is_allowed, expected) = match kind {
            Kind::Scalar => ("vertex indices", is_unsigned(accessor.component_type), "unsigned bytes, shorts or ints"),
            _ => ("positions", accessor.component_type != UNSIGNED_INT, "floats, bytes or shorts"),
        };
        if !is_allowed {
            let found = component_name(accessor.component_type);
            return Err(fault(format!("has {purpose} stored as {found}; expected {expected}: {AGAIN}")));
        }
        let width = if kind == Kind::Vec3 { 3 } else { 1 };
        if accessor.count > u64::from(u32::MAX - 1) {
            return Err(fault(format!(
                "has {} elements, more than 32-bit indices can address; split the file",
                accessor.count
            )));
        }
        let count = accessor.count as usize;
        let (bytes, stride) = match accessor.buffer_view {
            None => (None, 0),
            Some(view) => {
                let (bytes, stride) = self.view(view).map_err(fault)?;
                let stride = stride.unwrap_or(size * width);
                let bytes =
                    strided(bytes, accessor.byte_offset, stride, size * width, accessor.count).ok_or_else(|| {
                        let elements = counted(accessor.count, "element", "elements");
                        fault(format!("has {elements}, more than its buffer view holds; {AGAIN}"))
                    })?;
                (Some(bytes), stride)
            }
        };
        let replaced = self.replaced(accessor, size * width).map_err(fault)?;
        let (component_type, is_normalized) = (accessor.component_type, accessor.normalized);
        Ok(AccessorReader { bytes, stride, component_type, is_normalized, count, replaced, width })
    }

    fn replaced(&self, accessor: &Accessor, size: usize) -> Result<Option<Replaced<'a>>, String> {
        let Some(sparse) = &accessor.sparse else {
            return Ok(None);
        };
        let short = || {
            let elements = counted(sparse.count, "element", "elements");
            format!("replaces {elements}, more than its buffer view holds; {AGAIN}")
        };
        let (values, _) = self.view(sparse.values.buffer_view)?;
        let values = strided(values, sparse.values.byte_offset, size, size, sparse.count).ok_or_else(short)?;
        let (indices, _) = self.view(sparse.indices.buffer_view)?;
        let kind = sparse.indices.component_type;
        let width = component_size(kind).filter(|_| is_unsigned(kind)).ok_or_else(|| {
            let found = component_name(kind);
            format!("has sparse indices stored as {found}; expected unsigned bytes, shorts or ints: {AGAIN}")
        })?;
        let indices = strided(indices, sparse.indices.byte_offset, width, width, sparse.count).ok_or_else(short)?;
        let elements: Vec<u32> = (0..sparse.count as usize)
            .map(|at| unsigned(indices.get(at * width..)?, kind))
            .map(|element| element.unwrap_or(u32::MAX))
            .collect();
        let is_ascending = elements.is_sorted_by(|a, b| a < b);
        if !is_ascending || elements.last().is_some_and(|&last| u64::from(last) >= accessor.count) {
            return Err(format!("has sparse indices that are out of range or out of order; {AGAIN}"));
        }
        Ok(Some((elements, values)))
    }

    /// Bytes of a buffer view. Fails if it does not exist, or reaches beyond its buffer.
    pub fn view_bytes(&self, index: u32) -> Result<&'a [u8], String> {
        self.view(index).map(|(bytes, _)| bytes)
    }

    /// Bytes and stride of a buffer view.
    fn view(&self, index: u32) -> Result<(&'a [u8], Option<usize>), String> {
        let view = self.document.buffer_views.get(index as usize);
        let view = view.ok_or_else(|| format!("references buffer view {index}, which does not exist; {AGAIN}"))?;
        let stride = view.byte_stride.map(|stride| usize::try_from(stride).unwrap_or(usize::MAX));
        if let Some(bytes) = self.decoded.get(&index) {
            return Ok((bytes, stride));
        }
        let buffer = self.buffers.get(view.buffer as usize);
        let buffer =
            buffer.ok_or_else(|| format!("references buffer {}, which does not exist; {AGAIN}", view.buffer))?;
        let Some(buffer) = *buffer else {
            return Err(format!("references buffer {}, which has neither a URI nor a BIN chunk; {AGAIN}", view.buffer));
        };
        let bytes = usize::try_from(view.byte_offset).ok().and_then(|start| buffer.get(start..));
        let bytes = bytes.and_then(|rest| rest.get(..usize::try_from(view.byte_length).ok()?));
        let bytes = bytes.ok_or_else(|| {
            let (start, length, have) = (view.byte_offset, view.byte_length, buffer.len());
            let length = counted(length, "byte", "bytes");
            format!("references buffer view {index}: {length} at offset {start}, but its buffer has {have}; {AGAIN}")
        })?;
        Ok((bytes, stride))
    }
}

/// Bytes from `offset` on, if they hold `count` elements of `size` bytes at intervals of `stride`.
fn strided(bytes: &[u8], offset: u64, stride: usize, size: usize, count: u64) -> Option<&[u8]> {
    let rest = bytes.get(usize::try_from(offset).ok()?..)?;
    if count == 0 {
        return Some(rest);
    }
    // Overlapping elements would repeat bytes without limit.
    let need = (count - 1).checked_mul(stride as u64)?.checked_add(size as u64)?;
    (stride >= size && need <= rest.len() as u64).then_some(rest)
}

fn unsigned(bytes: &[u8], component_type: u32) -> Option<u32> {
    Some(match component_type {
        UNSIGNED_BYTE => u32::from(*bytes.first()?),
        UNSIGNED_SHORT => u32::from(u16::from_le_bytes(*bytes.first_chunk()?)),
        UNSIGNED_INT => u32::from_le_bytes(*bytes.first_chunk()?),
        _ => return None,
    })
}

impl AccessorReader<'_> {
    pub fn has_no_bytes(&self) -> bool {
        self.bytes.is_none()
    }

    #[expect(clippy::indexing_slicing, reason = "callers pass elements below `count`, and `strided` has checked those")]
    fn element(&self, at: usize) -> Option<&[u8]> {
        if let Some((elements, values)) = &self.replaced
            && let Ok(rank) = elements.binary_search(&(at as u32))
        {
            let size = self.width * component_size(self.component_type)?;
            return Some(&values[rank * size..]);
        }
        self.bytes.map(|bytes| &bytes[at * self.stride..])
    }

    /// Exactly as stored. `KHR_mesh_quantization` allows integers, normalized or not.
    #[expect(
        clippy::indexing_slicing,
        reason = "callers pass accessors of three components, which all their elements have"
    )]
    pub fn position(&self, at: usize) -> [f64; 3] {
        let Some(bytes) = self.element(at) else {
            return [0.0; 3];
        };
        let short = |axis: usize| [bytes[2 * axis], bytes[2 * axis + 1]];
        self.normalized([0, 1, 2].map(|axis| match self.component_type {
            BYTE => f64::from(bytes[axis] as i8),
            UNSIGNED_BYTE => f64::from(bytes[axis]),
            SHORT => f64::from(i16::from_le_bytes(short(axis))),
            UNSIGNED_SHORT => f64::from(u16::from_le_bytes(short(axis))),
            // Floats: `Data::accessor` allows no other type.
            _ => {
                let b = &bytes[4 * axis..];
                f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            }
        }))
    }

    /// A position as stored, divided by the maximum of its type if the accessor is normalized.
    pub fn normalized(&self, position: [f64; 3]) -> [f64; 3] {
        let maximum = match self.component_type {
            BYTE => 127.0,
            UNSIGNED_BYTE => 255.0,
            SHORT => 32767.0,
            UNSIGNED_SHORT => 65535.0,
            _ => return position,
        };
        if self.is_normalized { position.map(|value| (value / maximum).max(-1.0)) } else { position }
    }

    pub fn index(&self, at: usize) -> u32 {
        // `Data::accessor` allows unsigned types alone.
        self.element(at).and_then(|bytes| unsigned(bytes, self.component_type)).unwrap_or_default()
    }

    /// Largest index of its type, which restarts a strip where that is allowed.
    pub fn restart_index(&self) -> u32 {
        match self.component_type {
            UNSIGNED_BYTE => u8::MAX.into(),
            UNSIGNED_SHORT => u16::MAX.into(),
            _ => u32::MAX,
        }
    }
}
