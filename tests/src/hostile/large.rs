//! Large packs: how the time of the slowest query grows with the size of the pack.
//!
//! Requirement: every query on a pack that opened takes time at most proportional to the pack's
//! size, and a malicious pack is at most [`MAX_RATIO`] times as slow as the slowest honest pack of
//! that size.
//!
//! # Deviations
//! - A query of two compounds takes time proportional to the product of their numbers of hulls, if
//!   all of them overlap, as the documentation of [`hullmap::compound`] states. So compounds are
//!   queried against one cube here.

use std::{
    fmt,
    hint::black_box,
    time::{Duration, Instant},
};

use glam::{DVec3, Vec3};
use hullmap::{
    Cache, CastSettings, Compound, Feature, Hull, Manifold, ManifoldSettings, Motion, Pack, Pose, Ray, Settings, Shape,
    SupportMap, cast, contact, distance, intersects, ray, signed_distance,
};
use hullmap_bake::{
    BakedHull, IndexKind, PointSet, SourceRecord, bake_hull,
    index::{Index, encode::Encoded},
    write_pack,
};
use hullmap_format::{archive::LANES, slot::Slot, walk::Cost};
use hullmap_testkit::packs::{self, cube, point_set};
use shapes::{families::Family, rng::SplitMix64};

/// Maximum time of the slowest query on a malicious pack, relative to an honest pack of that size.
pub const MAX_RATIO: f64 = 100.0;

/// Maximum exponent of the time of the slowest query over the size of the pack.
///
/// Linear work has more than 1 if the smaller pack fits into the processor's cache and the larger
/// one does not: up to 1.5 was measured. Quadratic work has 2 or more for the same reason.
pub const MAX_EXPONENT: f64 = 1.75;

/// Points from which the number of bytes per vertex is estimated.
const TRIAL_POINTS: usize = 4_096;

/// Repetitions of each query. The fastest one counts.
const REPETITIONS: usize = 3;

/// Directions of support queries for each hull.
const DIRECTIONS: usize = 60;

/// Hulls that are queried alone.
const HULLS: usize = 3;

/// A way to make a pack of any size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Large {
    /// One hull of a family, with an index.
    Honest(Family, IndexKind),
    /// Tetrahedra in a row.
    Row,
    /// Tetrahedra in one place. An honest mesh can have them too, but would be useless.
    Heap,
    /// A sphere, all of whose leaves are one list of all vertices.
    OneList,
}

impl Large {
    /// All ways.
    pub const ALL: [Self; 8] = [
        Self::OneList,
        Self::Heap,
        Self::Row,
        // One vertex has all others as neighbours.
        Self::Honest(Family::Cone, IndexKind::Tree),
        Self::Honest(Family::Sphere, IndexKind::Tree),
        Self::Honest(Family::Sphere, IndexKind::None),
        // Two faces have half of all vertices each.
        Self::Honest(Family::Prism, IndexKind::Tree),
        Self::Honest(Family::Prism, IndexKind::Compact),
    ];

    /// Whether the baker makes such packs.
    pub fn is_honest(self) -> bool {
        matches!(self, Self::Honest(..) | Self::Row)
    }

    /// The bytes of a pack of about `len` bytes.
    pub fn file(self, len: usize) -> Vec<u8> {
        let made = match self {
            Self::Honest(family, index) => sized(len, |n| packs::bytes(&[solid(family, n)], index, &source())),
            Self::Row => sized(len, |n| write_pack(&tetrahedra(n, Vec3::X * 2.0), &source())),
            Self::Heap => sized(len, |n| write_pack(&tetrahedra(n, Vec3::ZERO), &source())),
            Self::OneList => sized(len, |n| write_pack(&[one_list(n)], &source())),
        };
        made.unwrap_or_else(|error| panic!("{self}: {error}"))
    }
}

impl fmt::Display for Large {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Honest(family, index) => write!(f, "{}, {index}", family.name()),
            Self::Row => f.write_str("tetrahedra in a row"),
            Self::Heap => f.write_str("tetrahedra in one place"),
            Self::OneList => f.write_str("sphere, one list"),
        }
    }
}

/// The slowest query on a pack.
#[derive(Clone, Copy, Debug)]
pub struct Slowest {
    /// Its name.
    pub query: &'static str,
    /// Its time.
    pub time: Duration,
}

/// Runs every kind of query on a pack and returns the slowest. Panics if the pack has no hull.
pub fn slowest(pack: &Pack) -> Slowest {
    let mut clock = Clock { slowest: Slowest { query: "", time: Duration::ZERO } };
    let cube = packs::tree_pack(&cube());
    let block = cube.hull(0).expect("a cube is one hull");
    for hull in pack.hulls().take(HULLS) {
        let size = hull.diameter().max(f64::MIN_POSITIVE);
        let poses = [DVec3::ZERO, DVec3::X * 0.3 * size, DVec3::new(0.2, -0.4, 0.3) * size, DVec3::Z * 3.0 * size]
            .map(|offset| Pose::from_translation(hull.centroid() + offset).expect("finite"));
        alone(&hull, &mut clock);
        for pose in poses {
            pair(&hull, &block, pose, &mut clock);
        }
    }
    let (whole, other) = (Compound::new(pack), Compound::new(&cube));
    let settings = Settings::default();
    for pose in [DVec3::ZERO, DVec3::new(0.3, 0.2, 0.1), DVec3::splat(1e4)] {
        let pose = Pose::from_translation(pose).expect("finite");
        let mut cache = Cache::with_pairs(2);
        clock.time("compound intersects", || hullmap::intersects(&whole, &other, pose, &mut cache));
        clock.time("compound distance", || hullmap::distance(&whole, &other, pose, &settings, &mut cache));
        clock.time("compound contact", || hullmap::contact(&whole, &other, pose, &settings, &mut cache));
    }
    clock.slowest
}

/// The exponent p of time ~ sizeᵖ between two packs.
pub fn exponent(small: (usize, Duration), large: (usize, Duration)) -> f64 {
    (large.1.as_secs_f64() / small.1.as_secs_f64()).ln() / (large.0 as f64 / small.0 as f64).ln()
}

fn alone(hull: &Hull, clock: &mut Clock) {
    let mut rng = SplitMix64::new(7);
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
    let random = (0..DIRECTIONS).map(|_| Vec3::from_array(rng.direction().map(|c| c as f32)));
    for dir in axes.into_iter().chain(random) {
        let found = clock.time("support", || hull.support(dir));
        clock.time("support_from", || hull.support_from(dir, found.index));
        clock.time("face_towards", || hull.face_towards(dir.as_dvec3()));
        clock.time("feature", || {
            let mut feature = Feature::new();
            hull.feature(dir.as_dvec3(), &mut feature);
            feature.corners().len()
        });
        for face in hull.faces_at(found.index).take(8) {
            clock.time("face_normal", || hull.face_normal(face));
        }
    }
}

fn pair(hull: &Hull, block: &Hull, pose: Pose, clock: &mut Clock) {
    let settings = Settings::default();
    for (a, b) in [(hull, block), (hull, hull)] {
        clock.time("intersects", || intersects(a, b, pose, &mut Cache::new()));
        clock.time("contact", || contact(a, b, pose, &settings, &mut Cache::new()));
        clock.time("distance", || distance(a, b, pose, &settings, &mut Cache::new()));
        let to = a.interior_point() - pose.translation();
        let (path, motion) = (Ray::new(pose.translation(), to).expect("finite"), Motion::new(to).expect("finite"));
        let far = CastSettings::default();
        clock.time("ray", || ray(a, &path, &far));
        clock.time("cast", || cast(a, b, pose, motion, &far, &mut Cache::new()));
        let point = pose.translation();
        clock.time("signed distance", || signed_distance(a, point, &settings, &mut Cache::new()).is_ok());
        clock.time("bounds_under", || a.bounds_under(pose));
        clock.time("feature_within", || a.feature_within(to, f64::INFINITY, &mut Feature::new()));
        clock.time("reduced_feature_within", || {
            a.reduced_feature_within(to, f64::INFINITY, &mut Feature::new());
        });
        clock.time("manifold", || Manifold::new().update(a, b, pose, &ManifoldSettings::default(), &mut Cache::new()));
    }
}

struct Clock {
    slowest: Slowest,
}

impl Clock {
    fn time<T>(&mut self, query: &'static str, mut run: impl FnMut() -> T) -> T {
        let mut once = || {
            let start = Instant::now();
            let answer = black_box(run());
            (start.elapsed(), answer)
        };
        let (mut time, answer) = once();
        // A query that is not the slowest at its first run need not be repeated.
        for _ in 1..REPETITIONS {
            if time > self.slowest.time {
                time = time.min(once().0);
            }
        }
        if time > self.slowest.time {
            self.slowest = Slowest { query, time };
        }
        answer
    }
}

/// Result of `make` for a count at which the file has about `len` bytes. A second trial is made
/// nearby, because the bytes per vertex depend on the count.
fn sized<E>(len: usize, make: impl Fn(usize) -> Result<Vec<u8>, E>) -> Result<Vec<u8>, E> {
    let mut count = TRIAL_POINTS;
    for _ in 0..2 {
        count = (len as f64 / make(count)?.len() as f64 * count as f64) as usize;
    }
    make(count)
}

fn source() -> SourceRecord {
    SourceRecord::default()
}

fn solid(family: Family, count: usize) -> PointSet {
    point_set(family.name(), &family.points(count, 1))
}

fn tetrahedra(count: usize, step: Vec3) -> Vec<BakedHull> {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let at = |i: usize| corners.map(|corner| (corner + step * i as f32).to_array());
    (0..count)
        .map(|i| bake_hull(&point_set("", &at(i)), IndexKind::Tree).expect("a tetrahedron can be baked"))
        .collect()
}

/// A sphere of `count` vertices, with a tree whose six roots are one list of all vertices.
fn one_list(count: usize) -> BakedHull {
    let mut baked = bake_hull(&solid(Family::Sphere, count), IndexKind::None).expect("a sphere can be baked");
    let blocks = baked.index.encoded.blocks;
    let slots = [[Slot::List(6).encode(); 6].as_slice(), &[0, blocks.len() as u32]].concat();
    let cost = Cost { nodes: 0, dots: (LANES * blocks.len()) as u32 };
    baked.index = Index { kind: IndexKind::Tree, cost, encoded: Encoded { slots, blocks }, replaces: None };
    baked
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times of packs that are rejected, or of another size, would be meaningless.
    #[test]
    fn all_open_and_have_the_requested_size() {
        for large in Large::ALL {
            let file = large.file(200_000);
            assert!((100_000..400_000).contains(&file.len()), "{large}: {} bytes", file.len());
            let pack = Pack::from_bytes(&file).unwrap_or_else(|error| panic!("{large}: {error}"));
            assert!(slowest(&pack).time > Duration::ZERO, "{large}");
        }
    }

    #[test]
    fn exponents_of_powers() {
        let seconds = Duration::from_secs;
        assert_eq!(exponent((1, seconds(1)), (4, seconds(4))), 1.0);
        assert_eq!(exponent((10, seconds(2)), (20, seconds(8))), 2.0);
    }
}
