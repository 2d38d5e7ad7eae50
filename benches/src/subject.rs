//! The hull under test: a family of generated shapes, baked.

use std::time::{Duration, Instant};

use glam::Vec3;
use hullmap::{Hull, Pack};
use hullmap_bake::{BakedHull, IndexKind, SourceRecord, bake_hull, index, write_pack};
use hullmap_testkit::packs::point_set;
use parry3d::shape::ConvexPolyhedron;
use shapes::families::Family;

/// Seed of all shapes.
pub const SEED: u64 = 20_261_121;

/// The families in the tables of support queries.
pub const FAMILIES: [Family; 8] = [
    Family::Sphere,
    Family::ClusteredEllipsoid,
    Family::Rock,
    Family::Prism,
    Family::RotatedPrism,
    Family::Cone,
    Family::Lens,
    Family::UvSphere,
];

/// A baked hull and its source points.
pub struct Subject {
    /// The source points; the hull may have fewer vertices.
    pub points: Vec<[f32; 3]>,
    baked: BakedHull,
}

impl Subject {
    /// Generates and bakes `n` points of `family`.
    pub fn new(family: Family, n: usize, seed: u64) -> Self {
        let points = family.points(n, seed);
        let set = point_set(family.name(), &points);
        let baked = bake_hull(&set, IndexKind::None).unwrap_or_else(|e| panic!("{}, {n} points: {e}", family.name()));
        Self { points, baked }
    }

    /// A pack with the hull and an index of `kind`, and the time to build that index.
    pub fn pack(&self, kind: IndexKind) -> (Pack, Duration) {
        let start = Instant::now();
        let index = index::build(&self.baked.hull, kind).expect("the hull can be indexed");
        let build_time = start.elapsed();
        let indexed = BakedHull { index, ..self.baked.clone() };
        let bytes = write_pack(&[indexed], &SourceRecord::default()).expect("the pack can be written");
        (Pack::from_bytes(&bytes).expect("a pack just written opens"), build_time)
    }
}

/// The first hull of a pack. Panics if there is none.
pub fn first_hull(pack: &Pack) -> Hull<'_> {
    pack.hull(0).expect("a pack has a hull")
}

/// A hull as a convex polyhedron of parry. `None` if parry rejects it, or drops vertices: then it
/// would have fewer to scan.
pub fn polyhedron(hull: &Hull<'_>) -> Option<ConvexPolyhedron> {
    let vertices: Vec<Vec3> = hull.vertices().collect();
    let fan = |face: Vec<u32>| face[1..].windows(2).map(|pair| [face[0], pair[0], pair[1]]).collect::<Vec<_>>();
    let triangles: Vec<[u32; 3]> = hull.faces().flat_map(|face| fan(face.collect())).collect();
    let polyhedron = ConvexPolyhedron::from_convex_mesh(vertices, &triangles)?;
    (polyhedron.points().len() == hull.vertex_count()).then_some(polyhedron)
}
