//! The face table of a small hull, laid out for the separating axis test (SAT): normals and
//! offsets, vertices, and the arcs of the Gauss map.
//!
//! A hull of at most [`MAX_VERTICES`] vertices gets a [`FacetTable`] when its pack is opened,
//! unless the tables of the pack would be too large, or a proof fails.

use glam::DVec3;

/// Maximum number of vertices of a polytope with a table. Above it, deep contacts gain less, and
/// pairs near touching lose.
pub(crate) const MAX_VERTICES: usize = 128;

/// Maximum number of vertices of hulls that keep their tables where those of larger hulls are too
/// large.
pub(crate) const SMALL_VERTICES: usize = 32;

// Their faces are in lean packs, too, so that contacts are the same.
const _: () = assert!(SMALL_VERTICES == hullmap_format::archive::LEAN_FACES as usize);

/// Maximum number of vertices of shapes whose support values at all faces may be computed.
pub(crate) const FLAT_VERTICES: usize = 16;

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

/// An edge of a face, and its arc on the Gauss map: the directions from the normal of the face to
/// that of the face beyond. Each arc belongs to two faces.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Side {
    /// The face beyond the edge.
    pub(crate) beyond: u8,
    /// A vertex of the edge.
    pub(crate) vertex: u8,
    /// See [`chord`](Self::chord).
    pub(super) chord: u16,
}

/// An arc of the Gauss map, between the normals of two faces with a common edge.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Edge {
    /// The two faces.
    pub(crate) faces: [u8; 2],
    /// A vertex of the edge.
    pub(crate) vertex: u8,
    /// Cosine of the angle between the normals.
    pub(crate) cosine: f32,
}

/// Unit of the chord of a [`Side`]: the greatest chord is 2.
pub(super) const CHORD_UNIT: f32 = 2.0 / u16::MAX as f32;

impl Side {
    /// The side of `vertex` to the face `beyond`. `chord` is the distance between the unit normals.
    pub(crate) fn new(beyond: u8, vertex: u8, chord: f64) -> Self {
        // One unit more than rounded, for the rounding and for that of the product in `chord`.
        let units = chord / f64::from(CHORD_UNIT) + 1.5;
        Self { beyond, vertex, chord: units.clamp(0.0, u16::MAX.into()) as u16 }
    }

    /// Distance between the two unit normals, rounded up.
    #[inline(always)]
    pub(crate) fn chord(self) -> f32 {
        // The greatest number of units stands for 2 and a rounding error.
        f32::from(self.chord) * (CHORD_UNIT * (1.0 + 1e-6))
    }
}

/// The inverse of the least length of a point of a chord between two unit vectors at the distance
/// `chord`, rounded up.
pub(crate) fn stretch(chord: f64) -> f32 {
    (1.0 / (1.0 - 0.25 * chord * chord).max(1e-6).sqrt()) as f32 * (1.0 + 1e-6)
}

/// The face table of a hull, held by its pack.
#[derive(Debug)]
pub(crate) struct FacetTable {
    pub(crate) normals: Box<[NormalBlock]>,
    /// See [`View::stretches`](super::facets::View::stretches).
    pub(crate) stretches: Box<[[f32; LANES]]>,
    /// Unit outward normals of the faces in f64. They define the ends of the arcs.
    pub(crate) exact: Box<[DVec3]>,
    /// The support vertex along each normal.
    pub(crate) supports: Box<[u8]>,
    pub(crate) points: Box<[PointBlock]>,
    /// The sides of all faces, face by face.
    pub(crate) sides: Box<[Side]>,
    /// Where the sides of each face start, and the number of all sides.
    pub(crate) side_starts: Box<[u16]>,
    /// Each arc once, for hulls of at most [`FLAT_VERTICES`] vertices.
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
