//! One hull of a pack: its facts, vertices and faces in place, and its support mapping.

use glam::{DVec3, Vec3};
use hullmap_format::{
    archive::{ArchivedBlock, ArchivedHullRecord, ArchivedPack, LANES, index_kind},
    walk::Cost,
};
use rkyv::rend::{f32_le, u32_le};

use crate::{
    candidates,
    lookup::{Index, Kind},
    support_map::{Support, SupportMap},
};

/// Neighbours of a hint beyond which an ordinary query is cheaper.
const MOST_TRIED: usize = 16;

/// By how much a support point may fall short of the farthest, over the outer radius. A cut of the index may leave out a
/// vertex whose cone reaches less than 1e-13 beyond it, which costs at most that share of the diameter, twice the radius; this
/// allows for five such cuts, one within the other; see "Intervals" in docs/ARCHITECTURE.md.
const SUPPORT_ERROR: f64 = 1e-12;

/// A convex hull, read in place from its [`Pack`](crate::Pack). Copying it copies a few slices.
///
/// Points, directions and lengths are in the hull's local frame: that of the source mesh, in its units.
#[derive(Clone, Copy, Debug)]
pub struct Hull<'a> {
    name: &'a [u8],
    record: &'a ArchivedHullRecord,
    vertices: &'a [[f32_le; 3]],
    source_vertices: &'a [u32_le],
    face_starts: &'a [u32_le],
    face_vertices: &'a [u32_le],
    index: Index<'a>,
    neighbour_starts: &'a [u32_le],
    neighbours: &'a [u32_le],
    interior_point: DVec3,
}

/// Answer of [`Hull::support`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupportPoint {
    /// The vertex.
    pub point: Vec3,
    /// Its number, see [`Hull::vertex`].
    pub index: u32,
}

/// Which direction index a hull was baked with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IndexKind {
    /// None: a query scans all vertices.
    None,
    /// A uniform cube map with `resolution`² cells a face.
    CubeMap {
        /// Cells along the edge of a face.
        resolution: u32,
    },
    /// The level-compressed tree.
    Tree {
        /// Candidates of a leaf: 8, 16 or 32.
        leaf: u32,
    },
    /// The paper's binary tree.
    Binary,
}

impl<'a> Hull<'a> {
    /// Hull number `index` of `pack`, whose spans have been checked.
    pub(crate) fn new(pack: &'a ArchivedPack, index: usize) -> Option<Self> {
        let record = pack.hulls.get(index)?;
        let (start, end) = (pack.spans.get(index)?, pack.spans.get(index + 1)?);
        let vertices = start.vertex.to_native() as usize..end.vertex.to_native() as usize;
        let kind = match record.index_kind.to_native() {
            index_kind::CUBE_MAP => Kind::CubeMap { resolution: record.resolution.to_native() },
            index_kind::BINARY => Kind::Binary,
            index_kind::TREE => Kind::Tree,
            _ => Kind::Scan,
        };
        Some(Self {
            name: run(&pack.names, start.name, end.name)?,
            record,
            vertices: pack.vertices.get(vertices.clone())?,
            source_vertices: pack.source_vertices.get(vertices.clone())?,
            face_starts: run(&pack.face_starts, start.face, end.face)?,
            face_vertices: run(&pack.face_vertices, start.face_vertex, end.face_vertex)?,
            index: Index {
                kind,
                slots: run(&pack.slots, start.slot, end.slot)?,
                blocks: run(&pack.blocks, start.block, end.block)?,
                leaf_blocks: record.leaf_blocks.to_native(),
                reach: record
                    .bounds_min
                    .iter()
                    .chain(&record.bounds_max)
                    .fold(0.0, |reach: f32, c| reach.max(c.to_native().abs())),
            },
            neighbour_starts: pack.neighbour_starts.get(vertices)?,
            neighbours: run(&pack.neighbours, start.neighbour, end.neighbour)?,
            interior_point: vector(&record.interior_point),
        })
    }

    /// Support point of the hull in direction `dir`: a vertex with the greatest dot product with it.
    ///
    /// `dir` need not be of unit length. Of several vertices with the same dot product one that is lowest among the
    /// candidates of `dir`'s cell is returned. For a direction that is zero or not finite some vertex comes back.
    ///
    /// # Complexity
    /// With a tree: at most [`worst_cost`](Self::worst_cost) nodes and dot products, whatever `dir`. No allocation.
    ///
    /// # Reference
    /// Kenwright, "Generic Convex Collision Detection using Support Mapping", 4.2, 4.8 and 4.9.
    #[inline]
    pub fn support(&self, dir: Vec3) -> SupportPoint {
        let (index, point) = self.index.support(dir.to_array());
        SupportPoint { point: Vec3::from_array(point), index }
    }

    /// Support point in direction `dir`, tried first at vertex `hint`: the answer to a direction close by, mostly.
    ///
    /// The answer is that of [`support`](Self::support), whatever the hint. The hint is taken only where it is certain:
    /// where each neighbour's dot product is smaller by more than rounding. On a convex hull it is then the greatest of
    /// all. Else, as with a hint that is no vertex, this is an ordinary query.
    ///
    /// # Complexity
    /// One dot product a neighbour of the hint (six on average, at most 16 are tried), then at most a query's cost.
    #[inline]
    pub fn support_from(&self, dir: Vec3, hint: u32) -> SupportPoint {
        match self.certain(dir, hint) {
            Some(point) => SupportPoint { point, index: hint },
            None => self.support(dir),
        }
    }

    /// The position of vertex `hint` if it is certainly the support point in direction `dir`.
    #[inline]
    fn certain(&self, dir: Vec3, hint: u32) -> Option<Vec3> {
        let neighbours = self.neighbour_run(hint);
        // A polygon's neighbours say nothing of directions across its plane, beyond which its points may lie a little.
        if neighbours.len() > MOST_TRIED || neighbours.len() < 3 || self.record.rank != 3 {
            return None;
        }
        let margin = candidates::margin(dir.to_array(), self.index.reach)?;
        let point = self.vertex(hint)?;
        let least = point.dot(dir) - margin;
        // NaN takes the failing branch.
        let beaten = |v: &u32_le| self.vertex(v.to_native()).is_some_and(|w| w.dot(dir) < least);
        neighbours.iter().all(beaten).then_some(point)
    }

    /// What [`support`](Self::support) costs in direction `dir`.
    pub fn support_cost(&self, dir: Vec3) -> Cost {
        self.index.cost(dir.to_array())
    }

    /// The most that [`support`](Self::support) costs in any direction. Checked when the pack is opened.
    pub fn worst_cost(&self) -> Cost {
        Cost { nodes: self.record.max_nodes.to_native(), dots: self.record.max_dots.to_native() }
    }

    /// Name of the hull: the OBJ object's, or the source's file name without its extension.
    pub fn name(&self) -> &'a str {
        std::str::from_utf8(self.name).unwrap_or_default()
    }

    /// Dimension of the hull: 3 solid, 2 polygon, 1 segment, 0 point.
    pub fn rank(&self) -> u32 {
        self.record.rank.to_native()
    }

    /// Number of vertices, at least 1.
    pub fn vertex_count(&self) -> usize {
        self.vertices.len()
    }

    /// Vertex number `index`; `None` past the last one.
    pub fn vertex(&self, index: u32) -> Option<Vec3> {
        self.vertices.get(index as usize).map(|v| Vec3::from_array(v.map(|c| c.to_native())))
    }

    /// All vertices, in order.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = Vec3> + 'a {
        self.vertices.iter().map(|v| Vec3::from_array(v.map(|c| c.to_native())))
    }

    /// Zero-based number that vertex `index` has in the source file; `None` past the last one.
    pub fn source_vertex(&self, index: u32) -> Option<u32> {
        self.source_vertices.get(index as usize).map(|v| v.to_native())
    }

    /// Number of source points the hull was built of.
    pub fn source_point_count(&self) -> u32 {
        self.record.source_points.to_native()
    }

    /// Number of faces: facets of a solid, both sides of a polygon, none below.
    pub fn face_count(&self) -> usize {
        self.face_starts.len()
    }

    /// The faces' vertex numbers, each face counter-clockwise seen from outside.
    pub fn faces(&self) -> impl Iterator<Item = impl ExactSizeIterator<Item = u32> + 'a> + 'a {
        let (starts, vertices) = (self.face_starts, self.face_vertices);
        starts.iter().enumerate().map(move |(face, start)| {
            let start = start.to_native() as usize;
            let end = starts.get(face + 1).map_or(vertices.len(), |next| next.to_native() as usize);
            vertices.get(start..end).unwrap_or_default().iter().map(|v| v.to_native())
        })
    }

    /// The vertices that share an edge with vertex `index`, ascending; none past the last vertex.
    pub fn neighbours(&self, index: u32) -> impl ExactSizeIterator<Item = u32> + 'a {
        self.neighbour_run(index).iter().map(|v| v.to_native())
    }

    #[inline]
    fn neighbour_run(&self, index: u32) -> &'a [u32_le] {
        let at = index as usize;
        let place = |at: usize| self.neighbour_starts.get(at).map_or(self.neighbours.len(), |s| s.to_native() as usize);
        self.neighbours.get(place(at)..place(at.saturating_add(1))).unwrap_or_default()
    }

    /// Greatest distance between two vertices.
    pub fn diameter(&self) -> f64 {
        self.record.diameter.to_native()
    }

    /// Volume; 0 below rank 3.
    pub fn volume(&self) -> f64 {
        self.record.volume.to_native()
    }

    /// Surface area; both sides of a polygon; 0 below rank 2.
    pub fn surface_area(&self) -> f64 {
        self.record.surface_area.to_native()
    }

    /// Centre of mass at uniform density.
    pub fn centroid(&self) -> DVec3 {
        vector(&self.record.centroid)
    }

    /// Second moments about the centroid over the volume (area, length): xx, yy, zz, yz, zx, xy.
    ///
    /// The inertia tensor of a solid of mass m has `m · (yy + zz)` in its first place, `−m · xy` beside it, and so on.
    pub fn second_moments(&self) -> [f64; 6] {
        self.record.second_moments.map(|m| m.to_native())
    }

    /// Least and greatest coordinates.
    pub fn bounds(&self) -> [Vec3; 2] {
        [&self.record.bounds_min, &self.record.bounds_max].map(|b| Vec3::from_array(b.map(|c| c.to_native())))
    }

    /// How far the worst source point lies outside the hull, divided by the diameter; at most 1e-7.
    pub fn containment_error(&self) -> f64 {
        self.record.containment_error.to_native()
    }

    /// Which direction index the hull was baked with.
    pub fn index_kind(&self) -> IndexKind {
        match self.index.kind {
            Kind::Scan => IndexKind::None,
            Kind::CubeMap { resolution } => IndexKind::CubeMap { resolution },
            Kind::Tree => IndexKind::Tree { leaf: LANES as u32 * self.index.leaf_blocks },
            Kind::Binary => IndexKind::Binary,
        }
    }

    /// Bytes that the direction index takes in the file: words and candidate blocks.
    pub fn index_byte_len(&self) -> usize {
        size_of_val(self.index.slots) + size_of_val::<[ArchivedBlock]>(self.index.blocks)
    }
}

impl SupportMap for Hull<'_> {
    #[inline]
    fn support(&self, dir: DVec3) -> Support {
        let dir = dir.to_array();
        let (feature, point) = self.index.support(dir);
        Support { point: DVec3::from_array(point.map(f64::from)), feature }
    }

    #[inline]
    fn interior_point(&self) -> DVec3 {
        self.interior_point
    }

    #[inline]
    fn inner_radius(&self) -> f64 {
        self.record.inner_radius.to_native()
    }

    #[inline]
    fn outer_radius(&self) -> f64 {
        self.record.outer_radius.to_native()
    }

    #[inline]
    fn support_error(&self) -> f64 {
        SUPPORT_ERROR * self.record.outer_radius.to_native()
    }

    #[inline]
    fn point(&self, feature: u32) -> Option<DVec3> {
        let [x, y, z] = self.vertices.get(feature as usize)?;
        Some(DVec3::new(x.to_native().into(), y.to_native().into(), z.to_native().into()))
    }

    #[inline]
    fn support_from(&self, dir: DVec3, hint: u32) -> Support {
        match self.certain(dir.as_vec3(), hint) {
            Some(point) => Support { point: point.as_dvec3(), feature: hint },
            None => SupportMap::support(self, dir),
        }
    }
}

fn vector(v: &[rkyv::rend::f64_le; 3]) -> DVec3 {
    DVec3::from_array(v.map(|c| c.to_native()))
}

fn run<T>(section: &[T], start: u32_le, end: u32_le) -> Option<&[T]> {
    section.get(start.to_native() as usize..end.to_native() as usize)
}
