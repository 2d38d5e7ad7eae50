//! The hull under test: a family of generated shapes, baked.

use std::time::{Duration, Instant};

use glam::{DVec3, Vec3};
use hullmap::Pack;
use hullmap_bake::{BakedHull, IndexKind, PointSet, SourceRecord, bake_hull, index, write_pack};
use shapes::families::Family;

/// Seed of all shapes.
pub const SEED: u64 = 20_261_121;

/// The families in the tables.
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
    /// The family.
    pub family: Family,
    /// The source points; the hull may have fewer vertices.
    pub points: Vec<[f32; 3]>,
    baked: BakedHull,
}

impl Subject {
    /// Generates and bakes `n` points of `family`.
    pub fn new(family: Family, n: usize, seed: u64) -> Self {
        let points = family.points(n, seed);
        let source_vertices = (0..points.len() as u32).collect();
        let set = PointSet {
            name: family.name().to_owned(),
            positions: points.clone(),
            source_vertices,
            ..PointSet::default()
        };
        let baked = bake_hull(&set, IndexKind::None).unwrap_or_else(|e| panic!("{}, {n} points: {e}", family.name()));
        Self { family, points, baked }
    }

    /// The hull's vertices.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = Vec3> + '_ {
        self.baked.hull.vertices.iter().map(|&v| Vec3::from_array(v))
    }

    /// Number of the hull's vertices.
    pub fn vertex_count(&self) -> usize {
        self.baked.hull.vertices.len()
    }

    /// The hull's faces, counter-clockwise seen from outside.
    pub fn faces(&self) -> &[Vec<u32>] {
        &self.baked.hull.faces
    }

    /// Outward unit normals of the faces.
    pub fn face_normals(&self) -> Vec<DVec3> {
        let positions = self.baked.hull.positions();
        let normal = |face: &Vec<u32>| {
            let root = positions[face[0] as usize];
            let spokes: Vec<DVec3> = face[1..].iter().map(|&v| positions[v as usize] - root).collect();
            spokes.windows(2).map(|pair| pair[0].cross(pair[1])).sum::<DVec3>().normalize()
        };
        self.faces().iter().map(normal).collect()
    }

    /// Maximum distance between two vertices.
    pub fn diameter(&self) -> f64 {
        self.baked.hull.diameter
    }

    /// The bytes of a pack with the hull and an index of `kind`, and the time to build that index.
    pub fn pack_bytes(&self, kind: IndexKind) -> (Vec<u8>, Duration) {
        let start = Instant::now();
        let index = index::build(&self.baked.hull, kind).expect("the hull can be indexed");
        let build_time = start.elapsed();
        let indexed = BakedHull { index, ..self.baked.clone() };
        (write_pack(&[indexed], &SourceRecord::default()).expect("the pack can be written"), build_time)
    }

    /// [`pack_bytes`](Self::pack_bytes), opened. Panics as [`pack_bytes`](Self::pack_bytes) does.
    pub fn pack(&self, kind: IndexKind) -> Pack {
        Pack::from_bytes(&self.pack_bytes(kind).0).expect("a pack just written opens")
    }
}
