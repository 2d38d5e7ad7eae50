//! Builds the face table of a small hull, and proves that the separating axis test may rely on it.
//!
//! # Steps
//! 1. Normals in f64. A normal is the number that was computed, not the true normal: no later step
//!    depends on its error, except through the slack.
//! 2. Sort the faces, such that those of a block have similar normals; order them around each
//!    vertex.
//! 3. Prove that the cones of the vertices, each spanned by the normals of the vertex's faces, are
//!    convex and cover all directions (docs/intervals.md, section 12).
//! 4. Bound the height by which the hull extends beyond a vertex in a direction of its cone: the
//!    slack.
//!
//! # Deviations
//! - A hull that fails a proof has no table, and its queries take the general path. The same holds
//!   in packs whose tables would exceed [`MAX_BYTES`]: first for hulls of more than
//!   [`SMALL_VERTICES`] vertices, then for all.

#![forbid(unsafe_code)]

use glam::DVec3;
use hullmap_format::sections::Sections;

use super::Hull;
use crate::support::SupportMap;
use crate::support::facet_table::{
    Edge, FLAT_VERTICES, FacetTable, LANES, MAX_FACES, MAX_VERTICES, NormalBlock, PointBlock, SMALL_VERTICES, Side,
    stretch, triangle_normal,
};

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
/// a pack: about 255 hulls of 128 vertices, or 1,070 of 32, which take 35 ms.
const MAX_BYTES: usize = 4 << 20;

impl FacetTable {
    /// The tables of a pack, one for each hull; `None` for a hull without a table.
    ///
    /// # Complexity
    /// O(number of hulls), and about 1 µs for each vertex of a hull with a table: at most about 35
    /// ms together.
    pub(crate) fn of_pack(pack: &Sections<'_>) -> Box<[Option<Self>]> {
        Self::of_hulls(MAX_BYTES, pack.hulls.len(), |index| Hull::new(pack, None, index))
    }

    /// The tables of `count` hulls, with at most `bytes` bytes together.
    fn of_hulls<'a>(bytes: usize, count: usize, hull: impl Fn(usize) -> Option<Hull<'a>>) -> Box<[Option<Self>]> {
        let hulls = || (0..count).map(&hull);
        let suitable = |most: usize| move |hull: &Hull<'_>| is_suitable(hull, most);
        let fits = |most: &usize| {
            hulls().flatten().filter(suitable(*most)).map(|hull| byte_len(&hull)).sum::<usize>() <= bytes
        };
        let most = [MAX_VERTICES, SMALL_VERTICES].into_iter().find(fits).unwrap_or(0);
        hulls().map(|hull| hull.filter(suitable(most)).and_then(|hull| Self::of_hull(&hull))).collect()
    }

    /// The table of `hull`; `None` if the hull is flat, has more than [`MAX_VERTICES`] vertices, or
    /// if a proof fails.
    ///
    /// # Complexity
    /// O(n²); in practice about 1 µs a vertex.
    fn of_hull(hull: &Hull<'_>) -> Option<Self> {
        if !is_suitable(hull, MAX_VERTICES) {
            return None;
        }
        let count = hull.vertex_count();
        let center = hull.interior_point();
        let radius = hull.outer_radius();
        let points: Vec<DVec3> = hull.vertices().map(|v| v.as_dvec3()).collect();
        // 1. and 2.
        let columns = Columns::new(&points, center);
        let mut faces: Vec<Face> = Vec::with_capacity(2 * count);
        for face in hull.faces() {
            let vertices: Vec<u8> = face.map(|v| u8::try_from(v).ok()).collect::<Option<_>>()?;
            if vertices.len() < 3 || vertices.len() > count || vertices.iter().any(|v| usize::from(*v) >= count) {
                return None;
            }
            faces.push(Face::new(vertices, &points, &columns, center)?);
        }
        sort_by_direction(&mut faces);
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
        let (sides, side_starts) = map.sides(&faces)?;
        let edges = if count <= FLAT_VERTICES { edges(&faces, &sides, &side_starts)? } else { Box::default() };
        Some(Self {
            normals: blocks(&faces),
            stretches: map.stretches(&faces)?,
            exact: faces.iter().map(|face| face.normal).collect(),
            supports: faces.iter().map(|face| face.support).collect(),
            points: point_blocks(&points, center),
            sides: sides.into(),
            side_starts: side_starts.into(),
            edges,
            slack,
        })
    }
}

/// Each arc once, from the sides of its two faces.
fn edges(faces: &[Face], sides: &[Side], starts: &[u16]) -> Option<Box<[Edge]>> {
    let mut face = 0;
    let mut edges = Vec::with_capacity(sides.len() / 2);
    for (index, side) in sides.iter().enumerate() {
        while starts.get(face + 1).is_some_and(|start| usize::from(*start) <= index) {
            face += 1;
        }
        if face < side.beyond.into() {
            let cosine = faces.get(face)?.normal.dot(faces.get(usize::from(side.beyond))?.normal) as f32;
            edges.push(Edge { faces: [face as u8, side.beyond], vertex: side.vertex, cosine });
        }
    }
    Some(edges.into())
}

/// Whether a hull is solid, has faces, and has at most `most` vertices.
fn is_suitable(hull: &Hull<'_>, most: usize) -> bool {
    hull.rank() == 3 && (4..=most).contains(&hull.vertex_count()) && (4..=MAX_FACES).contains(&hull.face_count())
}

/// Size of the table of a triangulated hull, in bytes.
fn byte_len(hull: &Hull<'_>) -> usize {
    let face = size_of::<NormalBlock>() / LANES + size_of::<f32>() + size_of::<DVec3>() + 3 * size_of::<Side>() + 3;
    let edges = if hull.vertex_count() <= FLAT_VERTICES { hull.vertex_count() + hull.face_count() - 2 } else { 0 };
    hull.face_count() * face + hull.vertex_count() * size_of::<PointBlock>() / LANES + edges * size_of::<Edge>()
}

/// A face with its computed normal.
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
    fn new(vertices: Vec<u8>, points: &[DVec3], columns: &Columns, center: DVec3) -> Option<Self> {
        let third = (vertices.len() / 3).max(1);
        let corners = [*vertices.first()?, *vertices.get(third)?, *vertices.get(2 * third)?];
        let [p, q, r] = corners.map(|v| points.get(usize::from(v)).copied());
        let normal = triangle_normal(p?, q?, r?)?;
        let offset = columns.relative.iter().fold(f64::NEG_INFINITY, |max, four| max.max(highest(four, normal)));
        // As a support query: of equal products, the one with the lowest index.
        let product = columns.absolute.iter().fold(f64::NEG_INFINITY, |max, four| max.max(highest(four, normal)));
        let is_support = |point: &DVec3| point.x * normal.x + point.y * normal.y + point.z * normal.z == product;
        let support = points.iter().position(is_support)?;
        let own = vertices.iter().filter_map(|v| points.get(usize::from(*v)));
        let lowest = own.fold(f64::INFINITY, |min, point| min.min((*point - center).dot(normal)));
        Some(Self { vertices, normal, support: support as u8, offset, sag: offset - lowest })
    }
}

/// Points by coordinate, in blocks of four for loops that the compiler vectorises. The last point
/// pads the last block.
struct Columns {
    absolute: Vec<Four>,
    /// Relative to the interior point.
    relative: Vec<Four>,
}

/// The coordinates of four points.
type Four = [[f64; 4]; 3];

impl Columns {
    fn new(points: &[DVec3], center: DVec3) -> Self {
        let fours = |shift: DVec3| {
            let four = |points: &[DVec3]| {
                let at = |lane: usize| points.get(lane).or(points.last()).map_or(DVec3::ZERO, |point| *point - shift);
                let four = [at(0), at(1), at(2), at(3)];
                [four.map(|p| p.x), four.map(|p| p.y), four.map(|p| p.z)]
            };
            points.chunks(4).map(four).collect()
        };
        Self { absolute: fours(DVec3::ZERO), relative: fours(center) }
    }
}

/// The greatest dot product of four points with `dir`. Each product and each sum is rounded once,
/// in the order x, y, z.
fn highest([x, y, z]: &Four, dir: DVec3) -> f64 {
    let mut dots = [0.0; 4];
    for (((dot, x), y), z) in dots.iter_mut().zip(x).zip(y).zip(z) {
        *dot = x * dir.x + y * dir.y + z * dir.z;
    }
    let [a, b, c, d] = dots;
    let greater = |a: f64, b: f64| if a > b { a } else { b };
    greater(greater(a, b), greater(c, d))
}

/// Sorts faces such that those of a block have similar normals: halves of whole blocks, along the
/// axis on which the normals differ most.
fn sort_by_direction(faces: &mut [Face]) {
    if faces.len() <= LANES {
        return;
    }
    let (low, high) = faces.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), face| {
        (low.min(face.normal), high.max(face.normal))
    });
    let extent = high - low;
    let axis = if extent.x >= extent.y && extent.x >= extent.z {
        0
    } else if extent.y >= extent.z {
        1
    } else {
        2
    };
    // Stable, so that the order depends on the hull only.
    faces.sort_by(|f, g| f.normal[axis].total_cmp(&g.normal[axis]));
    let blocks = faces.len().div_ceil(LANES);
    let (first, rest) = faces.split_at_mut(blocks.div_ceil(2) * LANES);
    sort_by_direction(first);
    sort_by_direction(rest);
}

/// The face to the left of each directed edge.
struct Edges {
    left: Vec<[u8; MAX_VERTICES]>,
    /// Of each vertex, one face and the number of faces.
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

    /// The stretch of each face: see [`View::stretches`](crate::support::facets::View::stretches).
    #[expect(clippy::indexing_slicing, reason = "there are as many lanes as faces")]
    fn stretches(&self, faces: &[Face]) -> Option<Box<[[f32; LANES]]>> {
        let mut stretches = vec![[1.0; LANES]; faces.len().div_ceil(LANES)];
        for (index, face) in faces.iter().enumerate() {
            let ends = face.vertices.iter().zip(face.vertices.iter().cycle().skip(1));
            let mut longest = 0.0_f64;
            for (v, w) in ends {
                let beyond = self.left_of(usize::from(*w), usize::from(*v))?;
                longest = longest.max(face.normal.distance(faces.get(beyond)?.normal));
            }
            stretches[index / LANES][index % LANES] = stretch(longest);
        }
        Some(stretches.into())
    }

    /// The sides of all faces, and where those of each face start.
    fn sides(&self, faces: &[Face]) -> Option<(Vec<Side>, Vec<u16>)> {
        let mut sides = Vec::with_capacity(self.half_edges);
        let mut starts = vec![0];
        for face in faces {
            let ends = face.vertices.iter().zip(face.vertices.iter().cycle().skip(1));
            for (v, w) in ends {
                let beyond = self.left_of(usize::from(*w), usize::from(*v))?;
                let chord = face.normal.distance(faces.get(beyond)?.normal);
                sides.push(Side::new(beyond as u8, *v, chord));
            }
            starts.push(u16::try_from(sides.len()).ok()?);
        }
        Some((sides, starts))
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
            for n in [4, 5, 6, 8, 11, 16, 24, 32, 64, 128] {
                for seed in 0..if n > 32 { 1 } else { 4 } {
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
        assert_eq!((table.exact.len(), table.sides.len()), (hull.face_count(), hull.neighbours.len()));
        // Each arc once, with the faces on both sides and a vertex of both.
        let sides = (0..table.exact.len()).flat_map(|face| {
            let starts = [face, face + 1].map(|at| usize::from(table.side_starts[at]));
            table.sides[starts[0]..starts[1]].iter().map(move |side| ([face as u8, side.beyond], side.vertex))
        });
        let expected: Vec<_> = sides.filter(|([face, beyond], _)| face < beyond).collect();
        let edges: Vec<_> = table.edges.iter().map(|edge| (edge.faces, edge.vertex)).collect();
        assert_eq!(edges, if hull.vertex_count() <= FLAT_VERTICES { expected } else { Vec::new() });
        // No point of an arc's chord is shorter than the stretches of both faces allow.
        for face in 0..table.exact.len() {
            let starts = [face, face + 1].map(|at| usize::from(table.side_starts[at]));
            let lengths = table.sides[starts[0]..starts[1]].iter().map(|side| {
                let middle = 0.5 * (table.exact[face] + table.exact[usize::from(side.beyond)]);
                middle.length()
            });
            let product = f64::from(table.stretches[face / LANES][face % LANES]) * lengths.fold(1.0, f64::min);
            assert!((1.0..1.000_01).contains(&product), "{product}");
        }
        // The table has the same normals in another order.
        let points: Vec<DVec3> = hull.vertices().map(|v| v.as_dvec3()).collect();
        let normal = |face: &mut dyn Iterator<Item = u32>| {
            let vertices: Vec<u8> = face.map(|v| v as u8).collect();
            let columns = Columns::new(&points, hull.interior_point());
            Face::new(vertices, &points, &columns, hull.interior_point()).unwrap().normal
        };
        let normals: Vec<DVec3> = hull.faces().map(|mut face| normal(&mut face)).collect();
        let sorted = |normals: &[DVec3]| {
            let mut normals: Vec<_> = normals.iter().map(|n| n.to_array().map(f64::to_bits)).collect();
            normals.sort_unstable();
            normals
        };
        assert_eq!(sorted(&normals), sorted(&table.exact));
        let (mut rng, mut certain) = (SplitMix64::new(seed), 0);
        for round in 0..300 {
            // Face normals too, where cones meet.
            let dir = match table.exact.get(round / 2) {
                Some(normal) if round % 2 == 0 => *normal,
                _ => DVec3::from_array(rng.direction()),
            };
            let mut covered = false;
            for vertex in 0..hull.vertex_count() as u32 {
                let normals: Vec<DVec3> = hull.faces_at(vertex).map(|f| normals[f as usize]).collect();
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
        let points = [120, 20, 200, 32].map(|n| shapes::families::sphere(n, 1));
        let sets: Vec<_> = points.iter().map(|points| packs::point_set("hull", points)).collect();
        let bytes = packs::bytes(&sets, IndexKind::Tree, &SourceRecord::default()).unwrap();
        let pack = Pack::from_bytes(&bytes).unwrap();
        let sizes: Vec<usize> = pack.hulls().map(|hull| byte_len(&hull)).collect();
        let small = sizes[1] + sizes[3];
        let all = small + sizes[0];
        for (limit, expected) in [
            (MAX_BYTES, [true, true, false, true]),
            (all, [true, true, false, true]),
            (all - 1, [false, true, false, true]),
            (small, [false, true, false, true]),
            (small - 1, [false; 4]),
        ] {
            let tables = FacetTable::of_hulls(limit, sets.len(), |index| pack.hull(index).ok());
            assert_eq!(tables.iter().map(Option::is_some).collect::<Vec<_>>(), expected, "{limit}");
        }
    }
}
