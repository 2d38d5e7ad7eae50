//! Support mapping of a hull: a hint if the caller has one, else the path that `support/index.rs`
//! chooses.

use glam::{DVec3, Vec3};
use hullmap_format::{IndexKind, archive::ArchivedBlock, walk::Cost};
use rkyv::rend::f32_le;

use super::Hull;
use crate::facets::view::Facets;
use crate::support::hint::{Edges, LevelOrRising};
use crate::support::simd::{Dispatch, Instructions, fetch};
use crate::support::{LevelEdges, Lookup, SupportMap, SupportPoint};

/// Maximum amount by which the dot product of the support point falls short of the maximum, divided
/// by the outer radius. Measured, not proved: a cut of the index may omit a vertex whose normal
/// cone reaches less than 4e-15 beyond the cut. The worst hulls that were constructed lost 80 times
/// as much, 3e-13, and this is three times the latter. See docs/contributors/intervals.md, section
/// 9.
const SUPPORT_ERROR: f64 = 1e-12;

/// Maximum number of edges of a vertex whose level edges are determined. The tip of a cone may have
/// more.
const MAX_LEVEL_EDGES: usize = 32;

/// Answer of [`Hull::support`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupportVertex {
    /// The vertex.
    pub point: Vec3,
    /// Its index, see [`Hull::vertex`].
    pub index: u32,
}

impl Hull<'_> {
    /// Support vertex of the hull in direction `dir`: a vertex whose dot product with `dir` is
    /// maximal.
    ///
    /// `dir` is in the hull's local frame and need not be of unit length. If several vertices have
    /// the same dot product, the lowest index among the candidates of `dir`'s cell is returned. If
    /// `dir` is zero or not finite, some vertex is returned.
    ///
    /// # Complexity
    /// With an index, at most [`worst_cost`](Self::worst_cost) nodes and dot products in every
    /// direction. No allocation.
    ///
    /// # Reference
    /// Kenwright, "Generic Convex Collision Detection using Support Mapping", 4.2, 4.8 and 4.9.
    #[inline]
    pub fn support(&self, dir: Vec3) -> SupportVertex {
        let (index, point) = self.index.support(dir.to_array());
        SupportVertex { point: Vec3::from_array(point), index }
    }

    /// Support vertex in direction `dir`, with vertex `hint` tried first. A good hint is the answer
    /// to a nearby direction.
    ///
    /// The hint is returned only if it is certainly a support vertex: if all its edges lead away
    /// from the direction by more than the rounding error. On a convex hull, its dot product is
    /// then the maximum. Otherwise, and if `hint` is not a vertex, this is an ordinary query.
    ///
    /// So the dot product is the same as for [`support`](Self::support) with every hint, and in
    /// practice the vertex is the same too. It may differ only if vertices are so close that f64
    /// cannot order them along `dir`: 1e-30 apart on a hull of size 1.
    ///
    /// # Complexity
    /// One dot product for each neighbour of the hint, eight at a time, then at most the cost of a
    /// query. A vertex has six neighbours on average. A hint with more than 16 is not tried.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// use hullmap::glam::Vec3;
    ///
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// let first = cube.support(Vec3::new(1.0, 1.0, 1.0));
    /// let dir = Vec3::new(1.0, 1.1, 0.9);
    /// assert_eq!(cube.support_from(dir, first.index), cube.support(dir));
    /// # }
    /// ```
    #[inline]
    pub fn support_from(&self, dir: Vec3, hint: u32) -> SupportVertex {
        match self.certain(dir.to_array(), hint) {
            Some(point) => SupportVertex { point: Vec3::from_array(point), index: hint },
            None => self.support(dir),
        }
    }

    /// The position of vertex `hint` if it is certainly the support point in direction `dir`.
    #[inline]
    fn certain(&self, dir: [f32; 3], hint: u32) -> Option<[f32; 3]> {
        let point = self.vertices.get(hint as usize)?;
        (self.level_or_rising(dir, hint, 0.0)? == 0).then(|| point.map(f32_le::to_native))
    }

    /// The edges at a vertex that may not fall by more than `tangent` of their length in direction
    /// `dir`, one bit each, in the order of the neighbours. `None` if there are no edges, or if f32
    /// cannot decide.
    #[inline]
    fn level_or_rising(&self, dir: [f32; 3], vertex: u32, tangent: f32) -> Option<u32> {
        let at = vertex as usize;
        let start = self.neighbour_starts.get(at)?.to_native() as usize;
        let end = self.neighbour_starts.get(at + 1).map_or(self.neighbours.len(), |next| next.to_native() as usize);
        // Empty for hulls of rank below 3.
        let components = self.edges.get(3 * start..).filter(|components| !components.is_empty())?;
        let edges = Edges { components, count: end.saturating_sub(start) };
        self.index.dispatch.run(LevelOrRising { edges, tangent }, dir)
    }

    /// Vector instructions that queries on this hull use. By default, the best that the processor
    /// supports.
    pub fn instructions(&self) -> Instructions {
        self.index.dispatch.instructions()
    }

    #[inline(always)]
    pub(crate) fn dispatch(&self) -> Dispatch {
        self.index.dispatch
    }

    /// The same hull, queried with `instructions`; `None` if the processor does not have them. The
    /// answers are the same.
    pub fn with_instructions(mut self, instructions: Instructions) -> Option<Self> {
        self.index.dispatch = Dispatch::detect(instructions)?;
        Some(self)
    }

    /// Cost of [`support`](Self::support) in direction `dir`: nodes visited and dot products.
    pub fn support_cost(&self, dir: Vec3) -> Cost {
        self.index.cost(dir.to_array())
    }

    /// Maximum cost of [`support`](Self::support) over all directions. Opening a pack checks it.
    pub fn worst_cost(&self) -> Cost {
        Cost { nodes: self.record.max_nodes.to_native(), dots: self.record.max_dots.to_native() }
    }

    /// Kind of the direction index that the hull was baked with.
    pub fn index_kind(&self) -> IndexKind {
        self.index.kind
    }

    /// Size of the direction index in the file, in bytes: words and candidate blocks.
    pub fn index_byte_len(&self) -> usize {
        size_of_val(self.index.slots) + size_of_val::<[ArchivedBlock]>(self.index.blocks)
    }
}

impl SupportMap for Hull<'_> {
    #[inline(always)]
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        // By name, not as arrays: a round trip through memory would stall the processor here.
        let (feature, [x, y, z]) = self.index.support([dir.x, dir.y, dir.z]);
        SupportPoint { point: DVec3::new(x.into(), y.into(), z.into()), feature }
    }

    #[inline]
    fn fetch_ahead(&self) {
        self.index.fetch_ahead();
        self.facets.into_iter().for_each(fetch);
    }

    #[inline]
    fn fetch_part(&self, part: usize) -> bool {
        self.index.fetch_part(part)
    }

    #[inline]
    fn start_lookup(&self, dir: DVec3) -> Lookup {
        self.index.start_lookup(dir.x, dir.y, dir.z)
    }

    #[inline]
    fn continue_lookup(&self, dir: DVec3, lookup: Lookup) -> Lookup {
        self.index.continue_lookup([dir.x, dir.y, dir.z], lookup)
    }

    #[inline(always)]
    fn finish_lookup(&self, dir: DVec3, lookup: Lookup) -> SupportPoint {
        let (feature, [x, y, z]) = self.index.finish_lookup([dir.x, dir.y, dir.z], lookup);
        SupportPoint { point: DVec3::new(x.into(), y.into(), z.into()), feature }
    }

    #[inline]
    fn working_set_len(&self) -> usize {
        size_of::<Self>() + self.index_byte_len()
    }

    #[inline]
    fn interior_point(&self) -> DVec3 {
        self.interior_point
    }

    #[inline]
    fn inner_radius(&self) -> f64 {
        self.inner_radius
    }

    #[inline]
    fn outer_radius(&self) -> f64 {
        self.outer_radius
    }

    #[inline]
    fn support_error(&self) -> f64 {
        SUPPORT_ERROR * self.outer_radius
    }

    #[inline]
    fn point(&self, feature: u32) -> Option<DVec3> {
        self.position(feature)
    }

    fn polytope_vertex(&self, index: u32) -> Option<DVec3> {
        self.position(index)
    }

    #[inline(always)]
    fn facets(&self) -> Option<Facets<'_>> {
        Some(Facets::of_hull(self.facets?, self))
    }

    fn stored_bounds(&self) -> Option<[DVec3; 2]> {
        Some(self.bounds().map(Vec3::as_dvec3))
    }

    /// # Complexity
    /// One dot product for each edge at the vertex, of at most [`MAX_LEVEL_EDGES`].
    fn level_edges(&self, feature: u32, dir: DVec3, tangent: f64) -> Option<LevelEdges> {
        let (from, neighbours) = (self.position(feature)?, self.neighbours(feature));
        // A solid has three edges at each vertex.
        if !(3..=MAX_LEVEL_EDGES).contains(&neighbours.len()) {
            return None;
        }
        let mut found = LevelEdges { shortest: f64::INFINITY, ..LevelEdges::default() };
        for neighbour in neighbours {
            let edge = self.position(neighbour)? - from;
            let (length_sq, rise) = (edge.length_squared(), edge.dot(dir));
            let is_level = rise * rise <= tangent * tangent * length_sq;
            if rise > 0.0 && !is_level {
                return None;
            }
            if is_level {
                found.count += 1;
                found.shortest = found.shortest.min(length_sq.sqrt());
                if length_sq > found.longest.length_squared() {
                    found.longest = edge;
                }
            }
        }
        Some(found)
    }

    /// # Complexity
    /// One dot product in f32 for each edge at the vertex, of at most 16.
    #[inline]
    fn only_level_edge(&self, feature: u32, dir: DVec3, tangent: f64) -> Option<DVec3> {
        let left = self.level_or_rising(dir.as_vec3().to_array(), feature, tangent as f32)?;
        if left == 0 {
            return Some(DVec3::ZERO);
        }
        let end = self.neighbour_run(feature).get(left.trailing_zeros() as usize)?.to_native();
        let edge = self.position(end)? - self.position(feature)?;
        // It may rise.
        (left & (left - 1) == 0 && edge.dot(dir) <= tangent * edge.length()).then_some(edge)
    }

    #[inline]
    fn support_point_from(&self, dir: DVec3, hint: u32) -> SupportPoint {
        match self.certain(dir.as_vec3().to_array(), hint) {
            Some(point) => SupportPoint { point: DVec3::from_array(point.map(f64::from)), feature: hint },
            None => SupportMap::support_point(self, dir),
        }
    }
}

#[cfg(test)]
mod tests {
    use shapes::{families, rng::SplitMix64};

    use super::*;
    use crate::pack::Pack;

    fn pack(positions: Vec<[f32; 3]>) -> Pack {
        Pack::from_bytes(&hullmap_testkit::packs::tree_bytes(&positions)).unwrap()
    }

    #[test]
    fn instructions_change_no_answer() {
        for positions in [families::rock(500, 1), families::prism(500, 0), families::cube_grid(64, 0)] {
            let pack = pack(positions);
            let best = pack.hull(0).unwrap();
            // Every processor supports these.
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
                // In directions normal to faces and edges, several vertices tie.
                dir[round % 3] *= [1.0, 0.0, 1e-8][round / 3 % 3];
                let dir = DVec3::from_array(dir);
                assert_eq!(SupportMap::support_point(&best, dir), SupportMap::support_point(&portable, dir), "{dir}");
                let dir = dir.as_vec3();
                assert_eq!(best.support(dir), portable.support(dir), "{dir}");
                assert_eq!(best.support_from(dir, hint), portable.support_from(dir, hint), "{dir} from {hint}");
                assert_eq!(best.support_cost(dir), portable.support_cost(dir));
                hint = best.support(dir).index;
            }
        }
    }

    /// Two vertices 1e-30 apart: the hint distinguishes them, and f64 does not.
    #[test]
    fn hints_may_return_another_vertex_of_equal_dot_product() {
        let mut points: Vec<[f32; 3]> =
            (0..8).map(|i| [(i & 1) as f32 - 0.5, (i >> 1 & 1) as f32 - 0.5, (i >> 2) as f32]).collect();
        points.extend([[0.0, 0.0, 2.0], [1e-30, 0.0, 2.0]]);
        let pack = pack(points);
        let hull = pack.hull(0).unwrap();
        let mut others = 0;
        let mut rng = SplitMix64::new(3);
        for _ in 0..2_000 {
            let dir = DVec3::from_array(rng.direction()).as_vec3();
            let right = hull.support(dir);
            for hint in 0..hull.vertex_count() as u32 {
                let found = hull.support_from(dir, hint);
                let dot = |point: Vec3| point.as_dvec3().dot(dir.as_dvec3());
                assert_eq!(dot(found.point), dot(right.point), "{dir} from {hint}");
                others += usize::from(found.index != right.index);
            }
        }
        assert!(others > 0, "no tie was found: the documentation allows for too much");
    }

    #[test]
    fn hints_are_certain_only_within_cones() {
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
        // Also the last vertex, at whose edges the section ends.
        let last = hull.vertex_count() as u32 - 1;
        let outward = hull.vertex(last).unwrap();
        assert_eq!(hull.certain(outward.to_array(), last), Some(outward.to_array()));
    }
}
