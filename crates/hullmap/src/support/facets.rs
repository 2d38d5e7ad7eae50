//! Faces of a small polytope, laid out for the separating axis test (SAT): normals and offsets,
//! vertices, and the arcs of the Gauss map.
//!
//! A hull of at most [`MAX_VERTICES`] vertices gets a [`FacetTable`] when its pack is opened,
//! unless the tables of the pack would be too large, or a proof fails. A box makes its table for
//! each query. The solver reads both through [`Facets`].

use glam::DVec3;

use super::simd::Dispatch;
use crate::hull::Hull;
use crate::support::SupportMap;

/// Maximum number of vertices of a polytope with a table. Above it, deep contacts gain less, and
/// pairs near touching lose.
pub(crate) const MAX_VERTICES: usize = 128;

/// Maximum number of vertices of hulls that keep their tables if the tables of larger hulls take
/// too much memory.
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
    chord: u16,
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
const CHORD_UNIT: f32 = 2.0 / u16::MAX as f32;

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
    /// See [`View::stretches`].
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
    /// See [`Facets::slack`].
    pub(crate) slack: f64,
}

/// The faces of a small polytope, from [`SupportMap::facets`].
///
/// Small hulls and boxes have them. They cannot be constructed outside this crate.
#[derive(Clone, Copy, Debug)]
pub struct Facets<'a>(Kind<'a>);

#[derive(Clone, Copy, Debug)]
enum Kind<'a> {
    Hull(&'a FacetTable, &'a Hull<'a>),
    Cuboid(DVec3),
}

/// The blocks and arcs of a box, made for one query.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Buffer {
    normals: [NormalBlock; 1],
    points: [PointBlock; 1],
}

/// The arrays that the scan reads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View<'v> {
    pub(crate) normals: &'v [NormalBlock],
    /// For each face, the inverse of the least length of a point of the chords of its arcs.
    pub(crate) stretches: &'v [[f32; LANES]],
    pub(crate) points: &'v [PointBlock],
    sides: &'v [Side],
    side_starts: &'v [u16],
    /// Each arc once, for shapes of at most [`FLAT_VERTICES`] vertices.
    pub(crate) edges: &'v [Edge],
}

impl View<'_> {
    /// The sides of a face.
    #[inline(always)]
    pub(crate) fn sides(&self, face: usize) -> &[Side] {
        let start = self.side_starts.get(face).copied().unwrap_or_default();
        let end = self.side_starts.get(face + 1).copied().unwrap_or_default();
        self.sides.get(usize::from(start)..usize::from(end)).unwrap_or_default()
    }
}

/// The sides of a box. Vertices are numbered by the signs of their coordinates as in
/// [`Cuboid`](crate::shapes::Cuboid), faces by axis and sign.
const BOX_SIDES: [Side; 24] = box_sides();

/// Each face of a box has four sides.
const BOX_SIDE_STARTS: [u16; 7] = [0, 4, 8, 12, 16, 20, 24];

/// √2 for each face, rounded up.
const BOX_STRETCHES: [[f32; LANES]; 1] = [[std::f32::consts::SQRT_2 * (1.0 + 1e-6); LANES]];

/// √2 in units of [`Side`], rounded up.
const BOX_CHORD: u16 = 46_341;
const _: () = assert!(BOX_CHORD as f64 * CHORD_UNIT as f64 > std::f64::consts::SQRT_2);

#[expect(clippy::indexing_slicing, reason = "six faces of four sides each")]
const fn box_sides() -> [Side; 24] {
    let mut sides = [Side { beyond: 0, vertex: 0, chord: BOX_CHORD }; 24];
    let mut side = 0;
    while side < 24 {
        let (face, beyond) = (side / 4, (2 * (side / 8) + 2 + side % 4) % 6);
        sides[side].beyond = beyond as u8;
        // Of the two ends of the edge, the one with the positive third coordinate.
        sides[side].vertex = ((face & 1) << (face / 2) | (beyond & 1) << (beyond / 2)) as u8;
        side += 1;
    }
    sides
}

/// The arcs of a box, from its sides.
const BOX_EDGES: [Edge; 12] = box_edges();

#[expect(clippy::indexing_slicing, reason = "12 of the 24 sides are those of the face with the lower number")]
const fn box_edges() -> [Edge; 12] {
    let mut edges = [Edge { faces: [0; 2], vertex: 0, cosine: 0.0 }; 12];
    let (mut side, mut edge) = (0, 0);
    while side < 24 {
        let Side { beyond, vertex, .. } = BOX_SIDES[side];
        if side / 4 < beyond as usize {
            edges[edge] = Edge { faces: [(side / 4) as u8, beyond], vertex, cosine: 0.0 };
            edge += 1;
        }
        side += 1;
    }
    edges
}

impl<'a> Facets<'a> {
    #[inline(always)]
    pub(crate) fn of_hull(table: &'a FacetTable, hull: &'a Hull<'a>) -> Self {
        Self(Kind::Hull(table, hull))
    }

    /// The faces of a box; `None` if it is flat.
    #[inline(always)]
    pub(crate) fn of_box(half: DVec3) -> Option<Self> {
        (half.min_element() > 0.0).then_some(Self(Kind::Cuboid(half)))
    }

    /// Number of faces.
    #[inline(always)]
    pub(crate) fn face_count(&self) -> usize {
        match self.0 {
            Kind::Hull(table, _) => table.exact.len(),
            Kind::Cuboid(_) => 6,
        }
    }

    /// Number of vertices, at most [`MAX_VERTICES`].
    #[inline(always)]
    pub(crate) fn vertex_count(&self) -> usize {
        match self.0 {
            Kind::Hull(_, hull) => hull.vertex_count().min(MAX_VERTICES),
            Kind::Cuboid(_) => 8,
        }
    }

    /// The arrays; those of a box are written to `buffer`.
    #[inline(always)]
    #[expect(clippy::indexing_slicing, reason = "a box has 3 axes, 6 faces and 8 vertices, of 8 lanes")]
    pub(crate) fn view<'v>(&self, buffer: &'v mut Buffer) -> View<'v>
    where
        'a: 'v,
    {
        match self.0 {
            Kind::Hull(table, _) => View {
                normals: &table.normals,
                stretches: &table.stretches,
                points: &table.points,
                sides: &table.sides,
                side_starts: &table.side_starts,
                edges: &table.edges,
            },
            Kind::Cuboid(half) => {
                let half = half.as_vec3().to_array();
                let NormalBlock { normal, offset } = &mut buffer.normals[0];
                *offset = [f32::INFINITY; LANES];
                for face in 0..6 {
                    offset[face] = half[face / 2];
                    normal[face / 2][face] = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
                }
                for (axis, components) in buffer.points[0].0.iter_mut().enumerate() {
                    for (vertex, component) in components.iter_mut().enumerate() {
                        *component = if vertex >> axis & 1 == 0 { half[axis] } else { -half[axis] };
                    }
                }
                View {
                    normals: &buffer.normals,
                    stretches: &BOX_STRETCHES,
                    points: &buffer.points,
                    sides: &BOX_SIDES,
                    side_starts: &BOX_SIDE_STARTS,
                    edges: &BOX_EDGES,
                }
            }
        }
    }

    /// Unit outward normal of a face. It defines the end of the face's arcs.
    #[inline]
    pub(crate) fn normal(&self, face: usize) -> Option<DVec3> {
        match self.0 {
            Kind::Hull(table, _) => table.exact.get(face).copied(),
            Kind::Cuboid(_) => {
                let axis = [DVec3::X, DVec3::Y, DVec3::Z].get(face / 2).copied()?;
                Some(if face.is_multiple_of(2) { axis } else { -axis })
            }
        }
    }

    /// The vertex that is farthest along a face's normal, of several the one with the lowest index.
    /// It is the support point of the shape in that direction.
    #[inline(always)]
    pub(crate) fn support(&self, face: usize) -> Option<usize> {
        match self.0 {
            Kind::Hull(table, _) => table.supports.get(face).map(|vertex| usize::from(*vertex)),
            // The corner with positive coordinates except for the face's axis.
            Kind::Cuboid(_) => Some((face & 1) << (face / 2)),
        }
    }

    /// Position of a vertex, which has the number of its feature.
    #[inline(always)]
    pub(crate) fn vertex(&self, vertex: usize) -> Option<DVec3> {
        match self.0 {
            Kind::Hull(_, hull) => SupportMap::point(hull, vertex as u32),
            Kind::Cuboid(half) => {
                let side = |bit: usize, half: f64| if vertex & bit == 0 { half } else { -half };
                Some(DVec3::new(side(1, half.x), side(2, half.y), side(4, half.z)))
            }
        }
    }

    /// Maximum height by which the shape extends beyond a vertex in a direction of the cone that is
    /// spanned by the normals of the vertex's faces.
    #[inline(always)]
    pub(crate) fn slack(&self) -> f64 {
        match self.0 {
            Kind::Hull(table, _) => table.slack,
            Kind::Cuboid(_) => 0.0,
        }
    }

    /// The instruction set of the hull, or the best one.
    #[inline(always)]
    pub(crate) fn dispatch(&self) -> Option<Dispatch> {
        match self.0 {
            Kind::Hull(_, hull) => Some(hull.dispatch()),
            Kind::Cuboid(_) => None,
        }
    }
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
