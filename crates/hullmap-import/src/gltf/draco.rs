//! glTF 2.0: primitives compressed by `KHR_draco_mesh_compression`, decoded by the crate
//! `draco-core`.
//!
//! The data is always triangles: the mode states how a renderer may arrange them.
//!
//! # Reference
//! Khronos, "KHR_draco_mesh_compression"; Google, "Draco Bitstream Specification", version 2.2.

use draco_core::metadata::METADATA_FLAG_MASK;
use draco_core::version::version_at_least;
use draco_core::{DecodeLimits, DecoderBuffer, DracoError, ErrorKind, GeometryMetadata, Mesh, MeshDecoder};

/// Bytes of decoded attributes that a vertex may have: some sets of normals, tangents, texture
/// coordinates, colours, joints and weights. They are decoded too, and dropped.
const ATTRIBUTE_BYTES: u64 = 256;

pub struct DracoMesh {
    /// Positions, before a normalisation by the accessor.
    pub positions: Vec<[f32; 3]>,
    /// Triangles, as indices into `positions`, all in range.
    pub triangles: Vec<[u32; 3]>,
}

pub enum DracoFault {
    TooLarge,
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

#[derive(Clone, Copy)]
pub struct Claim {
    /// Number of vertices. The data can have more: up to three for each triangle.
    pub vertices: usize,
    pub triangles: usize,
}

/// Geometry byte of a header: triangles, and not a point cloud.
const TRIANGLES: u8 = 1;

/// Method byte of a header: connectivity by Edgebreaker, or else a list of triangles.
const EDGEBREAKER: u8 = 1;

/// Maximum size of a header with its metadata, which take up to 270 times as much memory: 808 bytes
/// for a nested entry of three bytes. Exporters of glTF write no metadata.
const MAX_HEADER: usize = 1 << 16;

/// Fails if the header is damaged, longer than [`MAX_HEADER`], or not a mesh's.
pub fn claim(bytes: &[u8]) -> Result<Claim, DracoFault> {
    let mut header = DecoderBuffer::new(bytes.get(..MAX_HEADER).unwrap_or(bytes));
    header.decode_slice(b"DRACO".len())?;
    let (major, minor) = (header.decode_u8()?, header.decode_u8()?);
    header.set_version(major, minor);
    let (geometry, method, flags) = (header.decode_u8()?, header.decode_u8()?, header.decode_u16()?);
    if geometry != TRIANGLES {
        return Err(DracoFault::Damaged("it is not a mesh".to_owned()));
    }
    if version_at_least(major, minor, (1, 3)) && flags & METADATA_FLAG_MASK != 0 {
        GeometryMetadata::decode(&mut header)?;
    }
    let is_edgebreaker = method == EDGEBREAKER;
    if is_edgebreaker {
        let _traversal = header.decode_u8()?;
    }
    let is_at_least = |version| version_at_least(major, minor, version);
    let is_short = is_at_least(if is_edgebreaker { (2, 0) } else { (2, 2) });
    let mut count = || -> Result<usize, DracoError> {
        let count = if is_short { header.decode_varint()? } else { header.decode_u32()?.into() };
        Ok(usize::try_from(count).unwrap_or(usize::MAX))
    };
    if !is_edgebreaker {
        let triangles = count()?;
        return Ok(Claim { vertices: count()?, triangles });
    }
    if !is_at_least((2, 2)) {
        let _new_vertices = count()?;
    }
    Ok(Claim { vertices: count()?, triangles: count()? })
}

/// `position` is the id of the attribute with positions.
pub fn decode(bytes: &[u8], position: u32, claim: Claim) -> Result<DracoMesh, DracoFault> {
    let points = claim.vertices.max(claim.triangles.saturating_mul(3)) as u64;
    let limits = DecodeLimits::default().with_max_points(points).with_max_faces(claim.triangles as u64);
    let limits = limits.with_max_decoded_bytes(points.saturating_mul(ATTRIBUTE_BYTES));
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
