//! One hull of a pack: its facts, vertices and faces in place, and its support mapping.

mod arrays;
mod entry;
mod faces;
mod facts;
mod feature;
mod mass;
mod replacement;
mod shared;
mod support_mapping;

use std::mem::offset_of;

use glam::{DVec3, Vec3};
use hullmap_format::{
    IndexKind,
    archive::{
        ArchivedHullRecord, ArchivedMassRecord, ArchivedPrimitiveRecord, ArchivedQuad, ArchivedVoidsRecord,
        NO_SOURCE_VERTEX,
    },
    primitive,
    sections::Sections,
    voids,
};
use rkyv::rend::{f32_le, i16_le, u32_le};

use crate::facets::table::FacetTable;
use crate::support::index::Index;
use crate::support::simd::{Dispatch, HOT_BYTES};

pub use arrays::HullArrays;
pub use facts::Voids;
pub use mass::{MassProperties, MassSource};
pub use replacement::Replacement;
pub use shared::SharedHull;
pub use support_mapping::SupportVertex;

/// A convex hull, read in place from its [`Pack`](crate::Pack). Copying it copies a few slices.
///
/// Points, directions and lengths are in the hull's local frame: the frame and units of the source
/// mesh. [`SharedHull`] is a hull without a lifetime.
#[derive(Clone, Copy, Debug)]
// The fields that a query reads first fill the first two cache lines, so that a query on a hull
// that is in no cache does not wait for the record, too.
#[repr(C, align(64))]
pub struct Hull<'a> {
    interior_point: DVec3,
    inner_radius: f64,
    outer_radius: f64,
    index: Index<'a>,
    vertices: &'a [[f32_le; 3]],
    facets: Option<&'a FacetTable>,
    // From here on: hints, manifolds and facts.
    neighbour_starts: &'a [u32_le],
    edges: &'a [i16_le],
    neighbours: &'a [u32_le],
    neighbour_faces: &'a [u32_le],
    record: &'a ArchivedHullRecord,
    mesh_mass: Option<&'a ArchivedMassRecord>,
    voids: Option<&'a ArchivedVoidsRecord>,
    /// The primitive that may replace the hull, if one is recorded.
    primitive: Option<&'a ArchivedPrimitiveRecord>,
    name: &'a [u8],
    source_vertices: &'a [u32_le],
    face_starts: &'a [u32_le],
    face_vertices: &'a [u32_le],
    quads: &'a [ArchivedQuad],
    outer_vertices: &'a [[f32_le; 3]],
}

const _: () = assert!(offset_of!(Hull<'_>, neighbour_starts) <= HOT_BYTES);

impl<'a> Hull<'a> {
    /// Hull `index` of `pack`, whose spans have been checked.
    pub(crate) fn new(pack: &Sections<'a>, facets: Option<&'a FacetTable>, index: usize) -> Option<Self> {
        let record = pack.hulls.get(index)?;
        let (start, end) = (pack.spans.get(index)?, pack.spans.get(index + 1)?);
        let vertices = start.vertex.to_native() as usize..end.vertex.to_native() as usize;
        // A pack that was opened without checks may state no known kind. Scanning all vertices is
        // always exact.
        let kind = IndexKind::of_record(record).unwrap_or(IndexKind::None);
        Some(Self {
            mesh_mass: mesh_mass(pack, index, record),
            voids: voids_of(pack, index, record),
            primitive: u32::try_from(index).ok().and_then(|index| primitive::of_hull(pack.primitives, index)),
            name: run(pack.names, start.name, end.name)?,
            record,
            vertices: pack.vertices.get(vertices.clone())?,
            source_vertices: pack.source_vertices.get(vertices.clone())?,
            face_starts: run(pack.face_starts, start.face, end.face)?,
            face_vertices: run(pack.face_vertices, start.face_vertex, end.face_vertex)?,
            quads: run(pack.quads, start.quad, end.quad)?,
            index: Index {
                kind,
                slots: run(pack.slots, start.slot, end.slot)?,
                blocks: run(pack.blocks, start.block, end.block)?,
                leaf_blocks: record.leaf_blocks.to_native(),
                reach: record
                    .bounds_min
                    .iter()
                    .chain(&record.bounds_max)
                    .fold(0.0, |reach: f32, c| reach.max(c.to_native().abs())),
                dispatch: Dispatch::best(),
            },
            neighbour_starts: if pack.is_lean() { &[] } else { pack.neighbour_starts.get(vertices)? },
            neighbours: run(pack.neighbours, start.neighbour, end.neighbour)?,
            neighbour_faces: run(pack.neighbour_faces, start.neighbour, end.neighbour)?,
            edges: run(pack.edges, start.edge, end.edge)?,
            outer_vertices: run(pack.outer_vertices, start.outer, end.outer)?,
            interior_point: vector(&record.interior_point),
            inner_radius: record.inner_radius.to_native(),
            outer_radius: record.outer_radius.to_native(),
            facets,
        })
    }

    /// Name of the hull: the name of the object in the source file, or the source's file name
    /// without its extension.
    pub fn name(&self) -> &'a str {
        std::str::from_utf8(self.name).unwrap_or_default()
    }

    /// Whether the hull is in a lean pack (option `lean`): its [neighbours](Self::neighbours)
    /// are unknown, and with more than 32 vertices also its [faces](Self::faces).
    ///
    /// All queries work. Support queries, yes or no, distances, rays, casts and contacts return the
    /// same bits. Hints ([`support_from`](Self::support_from)) save no time. Features, and with
    /// them contact manifolds, come from up to 33 support queries in directions around the normal,
    /// as for user shapes: faces that are tilted by more than [`TILT`](crate::shapes::TILT) against
    /// the contact normal become edges or vertices.
    pub fn is_lean(&self) -> bool {
        self.neighbour_starts.is_empty()
    }

    /// Number of vertices, at least 1.
    pub fn vertex_count(&self) -> usize {
        self.vertices.len()
    }

    /// Position of the vertex of index `index`; `None` if there is no such vertex.
    pub fn vertex(&self, index: u32) -> Option<Vec3> {
        self.vertices.get(index as usize).map(|v| Vec3::from_array(v.map(|c| c.to_native())))
    }

    /// [`vertex`](Self::vertex) in f64.
    #[inline]
    pub(crate) fn position(&self, index: u32) -> Option<DVec3> {
        let [x, y, z] = self.vertices.get(index as usize)?;
        Some(DVec3::new(x.to_native().into(), y.to_native().into(), z.to_native().into()))
    }

    /// Positions of all vertices, in the order of their indices.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = Vec3> + 'a {
        self.vertices.iter().map(|v| Vec3::from_array(v.map(|c| c.to_native())))
    }

    /// Zero-based index of vertex `index` in the source file.
    ///
    /// `None` if there is no such vertex, and for a vertex that the bake created, in a simplified
    /// hull or where a convex part was cut off.
    pub fn source_vertex(&self, index: u32) -> Option<u32> {
        self.source_vertices.get(index as usize).map(|v| v.to_native()).filter(|v| *v != NO_SOURCE_VERTEX)
    }

    /// Vertices of the outer hull: a coarse polytope of at most 64 vertices that contains the hull.
    /// Empty for a hull that has few vertices itself.
    pub fn outer_vertices(&self) -> impl ExactSizeIterator<Item = Vec3> + 'a {
        self.outer_vertices.iter().map(|v| Vec3::from_array(v.map(|c| c.to_native())))
    }
}

/// The mass of the mesh of hull `index`. The first part of an object has it.
fn mesh_mass<'a>(pack: &Sections<'a>, index: usize, record: &ArchivedHullRecord) -> Option<&'a ArchivedMassRecord> {
    let first = index.checked_sub(record.part.to_native() as usize)?;
    let (start, end) = (pack.spans.get(first)?, pack.spans.get(first + 1)?);
    run(pack.masses, start.mass, end.mass)?.first()
}

fn voids_of<'a>(pack: &Sections<'a>, index: usize, record: &ArchivedHullRecord) -> Option<&'a ArchivedVoidsRecord> {
    let first = u32::try_from(index).ok()?.checked_sub(record.part.to_native())?;
    voids::of_object(pack.voids, first)
}

fn vector(v: &[rkyv::rend::f64_le; 3]) -> DVec3 {
    DVec3::from_array(v.map(|c| c.to_native()))
}

fn run<T>(section: &[T], start: u32_le, end: u32_le) -> Option<&[T]> {
    section.get(start.to_native() as usize..end.to_native() as usize)
}
