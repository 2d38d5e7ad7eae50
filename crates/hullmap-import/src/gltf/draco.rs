//! glTF 2.0: primitives compressed by `KHR_draco_mesh_compression`, decoded by the crate
//! `draco-core`.
//!
//! The data of such a primitive is always triangles, whatever its mode: the mode says how a
//! renderer may arrange them.
//!
//! # Reference
//! Khronos, "KHR_draco_mesh_compression"; Google, "Draco Bitstream Specification", version 2.2.

use draco_core::{DecodeLimits, DecoderBuffer, DracoError, ErrorKind, Mesh, MeshDecoder};

/// Bytes of decoded attributes that a vertex may have: some sets of normals, tangents, texture
/// coordinates, colours, joints and weights. They are decoded too, and dropped.
const ATTRIBUTE_BYTES: u64 = 256;

/// A decoded primitive.
pub struct DracoMesh {
    /// Positions, before a normalization by the accessor.
    pub positions: Vec<[f32; 3]>,
    /// Triangles, as indices into `positions`, all in range.
    pub triangles: Vec<[u32; 3]>,
}

/// Why a primitive cannot be decoded.
pub enum DracoFault {
    /// It has more vertices or triangles than the limit.
    TooLarge,
    /// It is damaged, or is not a mesh.
    Damaged(String),
}

impl From<DracoError> for DracoFault {
    fn from(error: DracoError) -> Self {
        match error.kind() {
            ErrorKind::LimitExceeded => Self::TooLarge,
            _ => Self::Damaged(error.to_string()),
        }
    }
}

/// Decodes a primitive. `position` is the id of the attribute with positions. `limit` is the
/// maximum number of vertices, and of triangles.
///
/// # Errors
/// See [`DracoFault`].
///
/// # Complexity
/// O(bytes + vertices + triangles).
pub fn decode(bytes: &[u8], position: u32, limit: usize) -> Result<DracoMesh, DracoFault> {
    let limit = limit as u64;
    let limits = DecodeLimits::default().with_max_points(limit).with_max_faces(limit);
    let limits = limits.with_max_decoded_bytes(limit.saturating_mul(ATTRIBUTE_BYTES));
    let mut mesh = Mesh::new();
    MeshDecoder::new().decode(&mut DecoderBuffer::new(bytes).with_limits(limits), &mut mesh)?;
    let damaged = |text: &str| DracoFault::Damaged(text.to_owned());
    let attribute = mesh.attribute_by_unique_id(position).ok_or_else(|| damaged("it has no positions"))?;
    if attribute.num_components() != 3 {
        return Err(damaged("its positions do not have three coordinates"));
    }
    let vertex_count = mesh.num_points();
    let coordinates = attribute.read_f32s(vertex_count, 3);
    let (positions, _) = coordinates.as_chunks::<3>();
    let triangles: Vec<[u32; 3]> = mesh.faces().iter().map(|face| face.map(|corner| corner.0)).collect();
    if triangles.as_flattened().iter().any(|&corner| corner as usize >= vertex_count) {
        return Err(damaged("a vertex index is out of range"));
    }
    Ok(DracoMesh { positions: positions.to_vec(), triangles })
}
