//! One hull of a pack: its facts, vertices and faces in place, and its support mapping.

use glam::{DVec3, Vec3};
use hullmap_format::{
    archive::{ArchivedBlock, ArchivedHullRecord, ArchivedPack, LANES, NO_SOURCE_VERTEX, index_kind},
    walk::Cost,
};
use rkyv::rend::{f32_le, i16_le, u32_le};

use crate::{
    hint::{AllLeadAway, Edges},
    lookup::{Index, Kind},
    minkowski::unit,
    simd::{Instructions, Level},
    support_map::{Support, SupportMap},
};

/// By how much a support point may fall short of the farthest, over the outer radius. A cut of the index may leave out a
/// vertex whose cone reaches less than 4e-15 beyond it. When that was 1e-13, the worst that was found was 8e-12 of the diameter,
/// on caps with bumps of 1e-11 made for it: 80 times as much, which would be 3e-13 now. See "Intervals" in docs/ARCHITECTURE.md.
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
    neighbour_faces: &'a [u32_le],
    edges: &'a [i16_le],
    outer_vertices: &'a [[f32_le; 3]],
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
                level: Level::best(),
            },
            neighbour_starts: pack.neighbour_starts.get(vertices)?,
            neighbours: run(&pack.neighbours, start.neighbour, end.neighbour)?,
            neighbour_faces: run(&pack.neighbour_faces, start.neighbour, end.neighbour)?,
            edges: run(&pack.edges, start.edge, end.edge)?,
            outer_vertices: run(&pack.outer_vertices, start.outer, end.outer)?,
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
    /// The answer is that of [`support`](Self::support), whatever the hint. The hint is taken only where it is certain: where
    /// all its edges lead away from the direction, by more than rounding. On a convex hull it is then the greatest of all.
    /// Else, as with a hint that is no vertex, this is an ordinary query.
    ///
    /// # Complexity
    /// One dot product for each neighbour of the hint, eight at a time (there are six on average; with more than 16 the hint is
    /// not tried), then at most a query's cost.
    #[inline]
    pub fn support_from(&self, dir: Vec3, hint: u32) -> SupportPoint {
        match self.certain(dir.to_array(), hint) {
            Some(point) => SupportPoint { point: Vec3::from_array(point), index: hint },
            None => self.support(dir),
        }
    }

    /// The position of vertex `hint` if it is certainly the support point in direction `dir`.
    #[inline]
    fn certain(&self, dir: [f32; 3], hint: u32) -> Option<[f32; 3]> {
        let at = hint as usize;
        let start = self.neighbour_starts.get(at)?.to_native() as usize;
        let end = self.neighbour_starts.get(at + 1).map_or(self.neighbours.len(), |next| next.to_native() as usize);
        // Empty but for solids.
        let numbers = self.edges.get(3 * start..)?;
        let edges = Edges { numbers, count: end.saturating_sub(start) };
        let point = self.vertices.get(at)?;
        (!numbers.is_empty() && self.index.level.run(AllLeadAway(edges), dir)).then(|| point.map(f32_le::to_native))
    }

    /// The vector instructions that queries use: the best that this processor has, unless chosen otherwise.
    pub fn instructions(&self) -> Instructions {
        self.index.level.instructions()
    }

    /// The same hull, asked with these instructions; `None` where this processor has them not. The answers are the same.
    pub fn with_instructions(mut self, instructions: Instructions) -> Option<Self> {
        self.index.level = Level::of(instructions)?;
        Some(self)
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

    /// Zero-based number that vertex `index` has in the source file; `None` past the last one, and for a vertex that is none of the
    /// source's: of a simplified hull, or where a convex part was cut off.
    pub fn source_vertex(&self, index: u32) -> Option<u32> {
        self.source_vertices.get(index as usize).map(|v| v.to_native()).filter(|v| *v != NO_SOURCE_VERTEX)
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
        self.neighbours.get(self.neighbour_range(index)).unwrap_or_default()
    }

    #[inline]
    fn neighbour_range(&self, index: u32) -> std::ops::Range<usize> {
        let at = index as usize;
        let place = |at: usize| self.neighbour_starts.get(at).map_or(self.neighbours.len(), |s| s.to_native() as usize);
        place(at)..place(at.saturating_add(1))
    }

    /// Vertex numbers of face `face`, counter-clockwise seen from outside; none past the last face.
    pub fn face(&self, face: u32) -> impl ExactSizeIterator<Item = u32> + 'a {
        let at = face as usize;
        let end =
            self.face_starts.get(at.saturating_add(1)).map_or(self.face_vertices.len(), |s| s.to_native() as usize);
        let start = self.face_starts.get(at).map_or(end, |s| s.to_native() as usize);
        self.face_vertices.get(start..end).unwrap_or_default().iter().map(|v| v.to_native())
    }

    /// The faces that meet at vertex `index`, each once: as many as it has neighbours, and none below rank 2.
    pub fn faces_at(&self, index: u32) -> impl ExactSizeIterator<Item = u32> + 'a {
        let range = if self.record.rank < 2 { 0..0 } else { self.neighbour_range(index) };
        self.neighbour_faces.get(range).unwrap_or_default().iter().map(|f| f.to_native())
    }

    /// Unit outward normal of face `face`; `None` past the last one.
    ///
    /// # Complexity
    /// O(1): three corners a third of the way around from each other span the plane well, as faces are planar.
    pub fn face_normal(&self, face: u32) -> Option<DVec3> {
        let mut corners = self.face(face);
        // A face has three corners or more.
        let third = (corners.len() / 3).max(1);
        let mut after = |skipped| corners.nth(skipped).and_then(|v| self.vertex(v)).map(Vec3::as_dvec3);
        let (first, second, third) = (after(0)?, after(third - 1)?, after(third - 1)?);
        // From the two shorter sides: two long ones of a needle would have lost what is between their ends.
        let (a, b, c) = (second - first, third - second, first - third);
        let [a_sq, b_sq, c_sq] = [a, b, c].map(DVec3::length_squared);
        unit(if c_sq >= a_sq && c_sq >= b_sq {
            a.cross(b)
        } else if a_sq >= b_sq {
            b.cross(c)
        } else {
            c.cross(a)
        })
    }

    /// The face that faces `dir` (local frame, any length): of the faces at the support vertex the one whose normal is nearest
    /// to it. `None` below rank 2, and for a direction that is zero or not finite.
    ///
    /// # Complexity
    /// One support query, and one normal for each face at its vertex: six on average, and as many as the vertex has
    /// neighbours at the tip of a cone. No scan of the faces.
    pub fn face_towards(&self, dir: DVec3) -> Option<u32> {
        let dir = unit(dir)?;
        let vertex = SupportMap::support(self, dir).feature;
        let alignment = |face: u32| self.face_normal(face).map_or(f64::NEG_INFINITY, |n| n.dot(dir));
        let mut best = (f64::NEG_INFINITY, None);
        for face in self.faces_at(vertex) {
            let found = alignment(face);
            if found > best.0 {
                best = (found, Some(face));
            }
        }
        best.1
    }

    /// Vertices of a coarse polytope that holds the hull, exactly, at most 64; none for a hull that has few itself.
    pub fn outer_vertices(&self) -> impl ExactSizeIterator<Item = Vec3> + 'a {
        self.outer_vertices.iter().map(|v| Vec3::from_array(v.map(|c| c.to_native())))
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

    /// How far the hull reaches beyond the convex hull of its source points at most, in source units: 0 for an exact hull, above
    /// for a simplified one.
    pub fn outer_error(&self) -> f64 {
        self.record.outer_error.to_native()
    }

    /// Origin of the hull's frame in the frame of the source file: add it to a point of the hull for the source's coordinates. Zero
    /// unless the bake recentred; the same for all hulls of a pack.
    pub fn origin(&self) -> DVec3 {
        vector(&self.record.origin)
    }

    /// Number of the hull among the convex parts of its source object, counted from 0; 0 for a hull that is no part, too. Parts
    /// of an object stand one after the other.
    pub fn part(&self) -> u32 {
        self.record.part.to_native()
    }

    /// How far a vertex of the source object lies outside all of its convex parts at most, in source units: what a decomposition
    /// lost. The same for all parts of an object; 0 for a hull that is no part.
    pub fn uncovered(&self) -> f64 {
        self.record.uncovered.to_native()
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
    #[inline(always)]
    fn support(&self, dir: DVec3) -> Support {
        // By name, not as arrays: what goes through memory here stalls the processor.
        let (feature, [x, y, z]) = self.index.support([dir.x, dir.y, dir.z]);
        Support { point: DVec3::new(x.into(), y.into(), z.into()), feature }
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
        match self.certain(dir.as_vec3().to_array(), hint) {
            Some(point) => Support { point: DVec3::from_array(point.map(f64::from)), feature: hint },
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

#[cfg(test)]
mod tests {
    use hullmap_bake::{IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
    use shapes::{families, rng::SplitMix64};

    use super::*;
    use crate::Pack;

    fn pack(positions: Vec<[f32; 3]>) -> Pack {
        let set = PointSet {
            name: "hull".into(),
            source_vertices: (0..positions.len() as u32).collect(),
            positions,
            ..PointSet::default()
        };
        let baked = bake_hull(&set, IndexKind::TREE).unwrap();
        Pack::from_bytes(&write_pack(&[baked], &SourceRecord::default()).unwrap()).unwrap()
    }

    #[test]
    fn instructions_change_no_answer() {
        for positions in [families::rock(500, 1), families::prism(500, 0), families::cube_grid(64, 0)] {
            let pack = pack(positions);
            let best = pack.hull(0).unwrap();
            // Every processor has these.
            let portable = best.with_instructions(Instructions::Portable).unwrap();
            assert_eq!(portable.instructions(), Instructions::Portable);
            match best.with_instructions(Instructions::Avx2) {
                Some(hull) => {
                    assert_eq!((hull.instructions(), best.instructions()), (Instructions::Avx2, Instructions::Avx2))
                }
                None => assert_eq!(best.instructions(), Instructions::Portable),
            }
            let mut rng = SplitMix64::new(1);
            let mut hint = 0;
            for round in 0..3_000 {
                let mut dir = rng.direction();
                // On faces and edges some tie.
                dir[round % 3] *= [1.0, 0.0, 1e-8][round / 3 % 3];
                let dir = DVec3::from_array(dir);
                assert_eq!(SupportMap::support(&best, dir), SupportMap::support(&portable, dir), "{dir}");
                let dir = dir.as_vec3();
                assert_eq!(best.support(dir), portable.support(dir), "{dir}");
                assert_eq!(best.support_from(dir, hint), portable.support_from(dir, hint), "{dir} from {hint}");
                assert_eq!(best.support_cost(dir), portable.support_cost(dir));
                hint = best.support(dir).index;
            }
        }
    }

    #[test]
    fn hints_are_certain_within_cones_alone() {
        let pack = pack(families::sphere(300, 4));
        let hull = pack.hull(0).unwrap();
        let (mut certain, mut rng) = (0, SplitMix64::new(2));
        for _ in 0..2_000 {
            let dir = DVec3::from_array(rng.direction()).as_vec3();
            let right = hull.support(dir);
            for hint in 0..hull.vertex_count() as u32 {
                let found = hull.certain(dir.to_array(), hint);
                assert!(
                    found.is_none() || (hint, found) == (right.index, Some(right.point.to_array())),
                    "{dir} {hint}"
                );
            }
            certain += usize::from(hull.certain(dir.to_array(), right.index).is_some());
            assert_eq!(hull.certain(dir.to_array(), u32::MAX), None);
        }
        assert!(certain > 1_900, "{certain} of 2,000");
        // The last vertex, behind whose edges the section ends, too.
        let last = hull.vertex_count() as u32 - 1;
        let outward = hull.vertex(last).unwrap();
        assert_eq!(hull.certain(outward.to_array(), last), Some(outward.to_array()));
    }
}
