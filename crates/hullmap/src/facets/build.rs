//! Builds the face table of a small hull, and proves that the separating axis test may rely on it.
//!
//! # Steps
//! 1. Normals in f64. A normal is the number that was computed, not the true normal: no later step
//!    depends on its error, except through the slack.
//! 2. Order the faces around each vertex.
//! 3. Prove that the cones of the vertices, each spanned by the normals of the vertex's faces, are
//!    convex and cover all directions (docs/contributors/intervals.md, section 12).
//! 4. Bound the height by which the hull extends beyond a vertex in a direction of its cone: the
//!    slack.
//!
//! # Deviations
//! - A hull that fails a proof has no table, and its queries take the general path. The same holds
//!   in packs whose tables would exceed [`MAX_BYTES`].

#![forbid(unsafe_code)]

use glam::DVec3;
use hullmap_format::sections::Sections;

use crate::facets::table::{
    Edge, FacetTable, LANES, MAX_FACES, MAX_VERTICES, NormalBlock, PointBlock, triangle_normal,
};
use crate::hull::Hull;
use crate::support::SupportMap;

/// Rounding error of the height of a vertex over a plane, in units of `f64::EPSILON` times the
/// outer radius.
const HEIGHT_ROUNDINGS: f64 = 4.0;

/// A triple product is certainly positive above this many units of `f64::EPSILON` times the lengths
/// of its factors. Two rounded differences, a cross product and a dot product have an error of at
/// most 10 half units.
const CERTAIN: f64 = 8.0;

/// Maximum slack over the outer radius. A hull with more takes the general path, whose intervals
/// are narrower.
const MAX_SLACK: f64 = 1e-11;

/// Minimum distance of the origin from the convex hull of a vertex's normals. It is small at the
/// tip of a needle, where normals are nearly opposite.
const MIN_HEIGHT: f64 = 1e-6;

/// No face: the value of an unused entry.
const NO_FACE: u8 = u8::MAX;

/// Maximum size of the tables of a pack, in bytes. Beyond that they are in no cache when a query
/// reads them, and the general path, which reads less, is as fast. It also limits the time to open
/// a pack: about 1,180 hulls of 32 vertices, which take 40 ms.
const MAX_BYTES: usize = 4 << 20;

impl FacetTable {
    /// The tables of a pack, one for each hull; `None` for a hull without a table.
    ///
    /// # Complexity
    /// O(number of hulls), and about 1 µs for each vertex of a hull with a table: at most about 40
    /// ms together.
    pub(crate) fn of_pack(pack: &Sections<'_>) -> Box<[Option<Self>]> {
        Self::of_hulls(MAX_BYTES, pack.hulls.len(), |index| Hull::new(pack, None, index))
    }

    /// The tables of `count` hulls, or none if they would take more than `bytes` bytes together.
    fn of_hulls<'a>(bytes: usize, count: usize, hull: impl Fn(usize) -> Option<Hull<'a>>) -> Box<[Option<Self>]> {
        let hulls = || (0..count).map(|index| hull(index).filter(is_suitable));
        let fits = hulls().flatten().map(|hull| byte_len(&hull)).sum::<usize>() <= bytes;
        hulls().map(|hull| hull.filter(|_| fits).and_then(|hull| Self::of_hull(&hull))).collect()
    }

    /// The table of `hull`; `None` if the hull is flat, has more than [`MAX_VERTICES`] vertices, or
    /// if a proof fails.
    ///
    /// # Complexity
    /// O(n²); in practice about 1 µs a vertex.
    fn of_hull(hull: &Hull<'_>) -> Option<Self> {
        if !is_suitable(hull) {
            return None;
        }
        let count = hull.vertex_count();
        let center = hull.interior_point();
        let radius = hull.outer_radius();
        let points: Vec<DVec3> = hull.vertices().map(|v| v.as_dvec3()).collect();
        // 1. and 2.
        let mut faces: Vec<Face> = Vec::with_capacity(2 * count);
        for face in hull.faces() {
            let vertices: Vec<u8> = face.map(|v| u8::try_from(v).ok()).collect::<Option<_>>()?;
            if vertices.len() < 3 || vertices.len() > count || vertices.iter().any(|v| usize::from(*v) >= count) {
                return None;
            }
            faces.push(Face::new(vertices, &points, center)?);
        }
        let map = Edges::new(&faces, count)?;
        // 3. and 4.
        let farthest = points.iter().fold(0.0, |max: f64, point| max.max(point.distance_squared(center))).sqrt();
        let rounding = HEIGHT_ROUNDINGS * f64::EPSILON * farthest;
        let mut slack = 0.0_f64;
        for vertex in 0..count {
            let ring = map.ring(vertex, &faces)?;
            slack = slack.max(cone_slack(&ring, *points.get(vertex)? - center, &faces, rounding)?);
        }
        // NaN takes the failing branch.
        if !(slack <= MAX_SLACK * radius) {
            return None;
        }
        Some(Self {
            normals: blocks(&faces),
            exact: faces.iter().map(|face| face.normal).collect(),
            supports: faces.iter().map(|face| face.support).collect(),
            points: point_blocks(&points, center),
            edges: map.arcs(&faces)?,
            slack,
        })
    }
}

/// Whether a hull is solid, has faces, and has at most [`MAX_VERTICES`] vertices.
fn is_suitable(hull: &Hull<'_>) -> bool {
    hull.rank() == 3
        && (4..=MAX_VERTICES).contains(&hull.vertex_count())
        && (4..=MAX_FACES).contains(&hull.face_count())
}

/// Size of the table of a triangulated hull, in bytes.
fn byte_len(hull: &Hull<'_>) -> usize {
    let face = size_of::<NormalBlock>() / LANES + size_of::<DVec3>() + 1;
    let edges = hull.vertex_count() + hull.face_count() - 2;
    hull.face_count() * face + hull.vertex_count() * size_of::<PointBlock>() / LANES + edges * size_of::<Edge>()
}

struct Face {
    /// Counter-clockwise, seen from outside.
    vertices: Vec<u8>,
    normal: DVec3,
    /// The support vertex along the normal: its dot product is computed as a support query does.
    support: u8,
    /// Maximum height of the hull along the normal, over the interior point.
    offset: f64,
    /// Height of the hull over the face's lowest vertex.
    sag: f64,
}

impl Face {
    fn new(vertices: Vec<u8>, points: &[DVec3], center: DVec3) -> Option<Self> {
        let third = (vertices.len() / 3).max(1);
        let corners = [*vertices.first()?, *vertices.get(third)?, *vertices.get(2 * third)?];
        let [p, q, r] = corners.map(|v| points.get(usize::from(v)).copied());
        let normal = triangle_normal(p?, q?, r?)?;
        let (mut offset, mut highest, mut support) = (f64::NEG_INFINITY, f64::NEG_INFINITY, 0);
        for (index, point) in points.iter().enumerate() {
            offset = offset.max((*point - center).dot(normal));
            // As a support query: of equal products, the one with the lowest index.
            let product = point.dot(normal);
            if product > highest {
                (highest, support) = (product, index);
            }
        }
        let own = vertices.iter().filter_map(|v| points.get(usize::from(*v)));
        let lowest = own.fold(f64::INFINITY, |min, point| min.min((*point - center).dot(normal)));
        Some(Self { vertices, normal, support: support as u8, offset, sag: offset - lowest })
    }
}

/// The face to the left of each directed edge.
struct Edges {
    left: Vec<[u8; MAX_VERTICES]>,
    /// For each vertex, one face and the number of faces.
    at: Vec<(u8, usize)>,
    half_edges: usize,
}

impl Edges {
    /// `None` if an edge does not have exactly two faces.
    fn new(faces: &[Face], vertices: usize) -> Option<Self> {
        let mut left = vec![[NO_FACE; MAX_VERTICES]; vertices];
        let mut at = vec![(NO_FACE, 0); vertices];
        let mut half_edges = 0;
        for (index, face) in faces.iter().enumerate() {
            let ends = face.vertices.iter().zip(face.vertices.iter().cycle().skip(1));
            for (v, w) in ends {
                let entry = left.get_mut(usize::from(*v))?.get_mut(usize::from(*w))?;
                if *entry != NO_FACE || v == w {
                    return None;
                }
                *entry = u8::try_from(index).ok()?;
                let (first, count) = at.get_mut(usize::from(*v))?;
                (*first, *count) = (*entry, *count + 1);
                half_edges += 1;
            }
        }
        let found = Self { left, at, half_edges };
        // Euler's formula: the surface is a sphere.
        (2 * vertices + 2 * faces.len() == half_edges + 4).then_some(found)
    }

    fn left_of(&self, v: usize, w: usize) -> Option<usize> {
        self.left.get(v)?.get(w).filter(|face| **face != NO_FACE).map(|face| usize::from(*face))
    }

    /// The faces around a vertex, clockwise seen from outside. `None` if they are not one ring.
    fn ring(&self, vertex: usize, faces: &[Face]) -> Option<Vec<usize>> {
        let (first, degree) = *self.at.get(vertex)?;
        let first = usize::from(first);
        let mut ring = Vec::with_capacity(degree);
        let mut face = first;
        loop {
            ring.push(face);
            let corners = &faces.get(face)?.vertices;
            let at = corners.iter().position(|v| usize::from(*v) == vertex)?;
            let next = usize::from(*corners.get((at + 1) % corners.len())?);
            face = self.left_of(next, vertex)?;
            if face == first {
                break;
            }
            if ring.len() >= degree {
                return None;
            }
        }
        (ring.len() == degree && degree >= 3).then_some(ring)
    }

    /// Each arc once, with the lower one of its faces first.
    fn arcs(&self, faces: &[Face]) -> Option<Box<[Edge]>> {
        let mut arcs = Vec::with_capacity(self.half_edges / 2);
        for (index, face) in faces.iter().enumerate() {
            let ends = face.vertices.iter().zip(face.vertices.iter().cycle().skip(1));
            for (v, w) in ends {
                let beyond = self.left_of(usize::from(*w), usize::from(*v))?;
                if index < beyond {
                    let cosine = face.normal.dot(faces.get(beyond)?.normal) as f32;
                    arcs.push(Edge { faces: [index as u8, beyond as u8], vertex: *v, cosine });
                }
            }
        }
        Some(arcs.into())
    }
}

/// Proves that the cone of a vertex is convex, with consecutive normals of the ring as its edges,
/// and returns its slack: the maximum height by which the hull extends beyond the vertex in a
/// direction of the cone. The vertex is at `offset` from the interior point; `rounding` is the
/// rounding error of a height.
fn cone_slack(ring: &[usize], offset: DVec3, faces: &[Face], rounding: f64) -> Option<f64> {
    let normals: Vec<DVec3> = ring.iter().filter_map(|face| faces.get(*face)).map(|face| face.normal).collect();
    for (i, c) in normals.iter().enumerate() {
        let next_index = (i + 1) % normals.len();
        let next = normals.get(next_index)?;
        let to_next = *next - *c;
        for (j, other) in normals.iter().enumerate() {
            if j == i || j == next_index {
                continue;
            }
            let to_other = *other - *c;
            // Clockwise. NaN takes the failing branch.
            let volume = c.dot(to_other.cross(to_next));
            let certain = CERTAIN * f64::EPSILON * (to_next.length_squared() * to_other.length_squared()).sqrt();
            if !(volume > certain) {
                return None;
            }
        }
    }
    // The faces that contain the vertex extend beyond it by at most their sag.
    let sag = ring.iter().filter_map(|face| faces.get(*face)).fold(0.0_f64, |max, face| max.max(face.sag));
    let mean = normals.iter().sum::<DVec3>().normalize_or_zero();
    let outward = offset.normalize_or_zero();
    let narrowest = |axis: DVec3| normals.iter().fold(f64::INFINITY, |min, n| min.min(n.dot(axis)));
    // Distance of the origin from the convex hull of the normals, or less.
    let height = narrowest(mean).max(narrowest(outward));
    (height > MIN_HEIGHT).then(|| (sag + rounding) / height)
}

#[expect(clippy::indexing_slicing, reason = "blocks are filled lane by lane, of three components each")]
fn blocks(faces: &[Face]) -> Box<[NormalBlock]> {
    let mut blocks = vec![NormalBlock::default(); faces.len().div_ceil(LANES)];
    for (b, block) in blocks.iter_mut().enumerate() {
        for lane in 0..LANES {
            let Some(face) = faces.get(LANES * b + lane) else {
                block.offset[lane] = f32::INFINITY;
                continue;
            };
            let normal = face.normal.as_vec3().to_array();
            for (to, from) in block.normal.iter_mut().zip(normal) {
                to[lane] = from;
            }
            block.offset[lane] = face.offset as f32;
        }
    }
    blocks.into()
}

#[expect(clippy::indexing_slicing, reason = "blocks are filled lane by lane, of three components each")]
fn point_blocks(points: &[DVec3], center: DVec3) -> Box<[PointBlock]> {
    let mut blocks = vec![PointBlock::default(); points.len().div_ceil(LANES)];
    for (b, block) in blocks.iter_mut().enumerate() {
        for lane in 0..LANES {
            let Some(point) = points.get((LANES * b + lane).min(points.len() - 1)) else { continue };
            let offset = (*point - center).as_vec3().to_array();
            for (to, from) in block.0.iter_mut().zip(offset) {
                to[lane] = from;
            }
        }
    }
    blocks.into()
}

#[cfg(test)]
mod tests {
    use hullmap_bake::{IndexKind, SourceRecord};
    use hullmap_testkit::packs;
    use shapes::{families::Family, rng::SplitMix64};

    use super::*;
    use crate::pack::Pack;

    /// The cones of the vertices contain every direction, and in its cone a vertex is a support
    /// point to within the slack.
    #[test]
    fn cones_cover_all_directions() {
        let mut tables = [0, 0];
        for family in Family::ALL {
            for n in [4, 5, 6, 8, 11, 16, 24, 32, 33] {
                for seed in 0..4 {
                    let bytes = packs::tree_bytes(&family.points(n.max(shapes::families::MIN_POINTS), seed));
                    let pack = Pack::from_bytes(&bytes).unwrap();
                    let hull = pack.hull(0).unwrap();
                    if hull.rank() != 3 || hull.vertex_count() > MAX_VERTICES {
                        assert!(FacetTable::of_hull(&hull).is_none());
                        continue;
                    }
                    tables[0] += 1;
                    let Some(table) = FacetTable::of_hull(&hull) else { continue };
                    tables[1] += 1;
                    check(&hull, &table, seed);
                }
            }
        }
        // Needles and thin cones may fail a proof.
        assert!(tables[0] > 150 && tables[1] * 20 > tables[0] * 19, "{tables:?}");
    }

    fn check(hull: &Hull<'_>, table: &FacetTable, seed: u64) {
        let neighbours = (0..hull.vertex_count() as u32).map(|vertex| hull.neighbours(vertex).count()).sum();
        assert_eq!((table.exact.len(), 2 * table.edges.len()), (hull.face_count(), neighbours));
        // Each arc once, with a vertex that both faces have.
        for (index, Edge { faces, vertex, cosine }) in table.edges.iter().enumerate() {
            assert!(faces[0] < faces[1] && table.edges[..index].iter().all(|other| other.faces != *faces));
            let [c, d] = faces.map(|face| table.exact[usize::from(face)]);
            assert_eq!(*cosine, c.dot(d) as f32);
            let point = hull.vertex(u32::from(*vertex)).unwrap().as_dvec3();
            for normal in [c, d] {
                let highest = hull.vertices().map(|v| v.as_dvec3().dot(normal)).fold(f64::NEG_INFINITY, f64::max);
                assert!(point.dot(normal) >= highest - table.slack - 1e-14 * hull.outer_radius());
            }
        }
        let (mut rng, mut certain) = (SplitMix64::new(seed), 0);
        for round in 0..300 {
            // Face normals too, where cones meet.
            let dir = match table.exact.get(round / 2) {
                Some(normal) if round % 2 == 0 => *normal,
                _ => DVec3::from_array(rng.direction()),
            };
            let mut covered = false;
            for vertex in 0..hull.vertex_count() as u32 {
                let normals: Vec<DVec3> = hull.faces_at(vertex).map(|f| table.exact[f as usize]).collect();
                // The cone contains the direction if a triangle of its normals does, by more than
                // `margin`.
                let within = |p: DVec3, q: DVec3, r: DVec3, margin: f64| {
                    let sides = [p.cross(q).dot(dir), q.cross(r).dot(dir), r.cross(p).dot(dir)];
                    p.cross(q).dot(r) > 0.0 && sides.iter().all(|side| *side >= margin)
                };
                let contains = |margin: f64| {
                    normals.iter().any(|p| normals.iter().any(|q| normals.iter().any(|r| within(*p, *q, *r, margin))))
                };
                covered |= contains(-1e-15);
                if contains(1e-14) {
                    certain += 1;
                    let height = |v: DVec3| v.dot(dir);
                    let highest = hull.vertices().map(|v| height(v.as_dvec3())).fold(f64::NEG_INFINITY, f64::max);
                    let own = height(hull.vertex(vertex).unwrap().as_dvec3());
                    let rounding = 1e-14 * hull.outer_radius();
                    assert!(own >= highest - table.slack - rounding, "{} {vertex} {dir}", hull.name());
                }
            }
            assert!(covered, "{dir}, seed {seed}");
        }
        assert!(certain > 100, "{certain}, seed {seed}");
    }

    #[test]
    fn tables_are_limited_by_vertices_and_by_bytes() {
        let points = [24, 33, 32].map(|n| shapes::families::sphere(n, 1));
        let sets: Vec<_> = points.iter().map(|points| packs::point_set("hull", points)).collect();
        let bytes = packs::bytes(&sets, IndexKind::Tree, &SourceRecord::default()).unwrap();
        let pack = Pack::from_bytes(&bytes).unwrap();
        let sizes: Vec<usize> = pack.hulls().map(|hull| byte_len(&hull)).collect();
        let all = sizes[0] + sizes[2];
        for (limit, expected) in [(MAX_BYTES, [true, false, true]), (all, [true, false, true]), (all - 1, [false; 3])] {
            let tables = FacetTable::of_hulls(limit, sets.len(), |index| pack.hull(index).ok());
            assert_eq!(tables.iter().map(Option::is_some).collect::<Vec<_>>(), expected, "{limit}");
        }
    }
}
