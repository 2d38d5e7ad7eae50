//! The face table of a small hull, laid out for the separating axis test (SAT): normals and
//! offsets, vertices, and the arcs of the Gauss map.
//!
//! A hull of at most [`MAX_VERTICES`] vertices gets a [`FacetTable`] when its pack is opened,
//! unless the tables of the pack would be too large, or a proof fails.

use glam::DVec3;

/// Maximum number of vertices of a polytope with a table. Above it, the general path is as fast.
pub(crate) const MAX_VERTICES: usize = 32;

// Their faces are in lean packs, too, so that contacts are the same.
const _: () = assert!(MAX_VERTICES == hullmap_format::archive::LEAN_FACES as usize);

/// Maximum number of faces of a polytope with so few vertices, by Euler's formula.
pub(crate) const MAX_FACES: usize = 2 * MAX_VERTICES - 4;

/// Number of faces or vertices in a block.
pub(crate) const LANES: usize = 8;

/// Maximum number of blocks of normals.
pub(crate) const NORMAL_BLOCKS: usize = MAX_FACES.div_ceil(LANES);

/// Maximum number of blocks of vertices.
pub(crate) const POINT_BLOCKS: usize = MAX_VERTICES.div_ceil(LANES);

/// Unit outward normals of eight faces, and the offsets of their planes from the interior point,
/// both rounded to f32. Unused lanes have no normal and an infinite offset, so they are never the
/// lowest.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(crate) struct NormalBlock {
    pub(crate) normal: [[f32; LANES]; 3],
    pub(crate) offset: [f32; LANES],
}

/// Eight points relative to an interior point, rounded to f32. The last point fills unused lanes.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(crate) struct PointBlock(pub(crate) [[f32; LANES]; 3]);

/// An arc of the Gauss map, between the normals of two faces with a common edge.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Edge {
    pub(crate) faces: [u8; 2],
    pub(crate) vertex: u8,
    /// Cosine of the angle between the normals.
    pub(crate) cosine: f32,
}

/// The face table of a hull, held by its pack.
#[derive(Debug)]
pub(crate) struct FacetTable {
    pub(crate) normals: Box<[NormalBlock]>,
    /// Unit outward normals of the faces in f64. They define the ends of the arcs.
    pub(crate) exact: Box<[DVec3]>,
    pub(crate) supports: Box<[u8]>,
    pub(crate) points: Box<[PointBlock]>,
    /// Each arc once.
    pub(crate) edges: Box<[Edge]>,
    /// See [`Facets::slack`](super::Facets::slack).
    pub(crate) slack: f64,
}

/// Unit normal of a triangle, from its two shorter sides: the cross product of two long sides of a
/// needle would lose the short side to rounding errors.
#[inline]
pub(crate) fn triangle_normal(p: DVec3, q: DVec3, r: DVec3) -> Option<DVec3> {
    let (a, b, c) = (q - p, r - q, p - r);
    let [a_sq, b_sq, c_sq] = [a, b, c].map(DVec3::length_squared);
    crate::vector::unit(if c_sq >= a_sq && c_sq >= b_sq {
        a.cross(b)
    } else if a_sq >= b_sq {
        b.cross(c)
    } else {
        c.cross(a)
    })
}
