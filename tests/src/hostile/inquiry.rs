//! All queries on a pack that opened.

use std::hint::black_box;

use glam::{DQuat, DVec3, Vec3};
use hullmap::{
    Cache, CastSettings, Compound, CompoundManifolds, Feature, Hull, Instructions, Manifold, ManifoldSettings, Motion,
    Pack, Pose, Ray, Settings, Shape, SupportMap, cast, contact, distance, intersects, ray, signed_distance,
};
use hullmap_testkit::packs::{cube, tree_pack};

use crate::directions;

/// One direction out of this many is also queried with a hint, with other instructions, and for its
/// cost, feature and face.
const MORE_INTERVAL: usize = 16;

/// One pair out of this many is also queried as two packs and for its manifold.
const MANIFOLD_INTERVAL: usize = 4;

/// Maximum number of support calls of a query of two hulls, as docs/contributors/FORMAT.md states
/// it.
const MAX_SUPPORT_CALLS: u32 = 10_000;

/// Seed of the directions.
const SEED: u64 = 0xdead;

/// The number of queries on a pack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Support queries, over all hulls.
    pub supports: usize,
    /// Contact queries, each with a distance and an intersection query.
    pub pairs: usize,
}

impl Extent {
    /// Counts for thorough tests of every pack that opens.
    pub const FULL: Self = Self { supports: 1000, pairs: 20 };
    /// Counts for quick tests.
    pub const BRIEF: Self = Self { supports: 60, pairs: 3 };
}

/// Queries for the changed files of one pack.
pub struct Inquiry {
    dirs: Vec<Vec3>,
    poses: Vec<Pose>,
    cube: Pack,
    extent: Extent,
    is_judged: bool,
}

impl Inquiry {
    /// Queries for packs like `pack`: in directions of its first hull's faces and edges, and in
    /// random ones. Panics if the pack has no hull.
    pub fn new(pack: &Pack, extent: Extent) -> Self {
        let cube = tree_pack(&cube());
        let own = directions::all(&pack.hull(0).expect("a pack has a hull"), extent.supports, SEED);
        let invalid: Vec<Vec3> = directions::invalid().into_iter().step_by(7).collect();
        let valid = extent.supports.saturating_sub(invalid.len());
        // The directions are ordered by kind, so a stride takes some of each kind.
        let step = (own.len() / valid.max(1)).max(1);
        let dirs = own.into_iter().step_by(step).take(valid).chain(invalid).collect();
        let turned = DQuat::from_array([0.3, -0.2, 0.5, 0.7]);
        let poses = [
            ([0.0, 0.0, 0.0], turned),
            ([0.6, 0.5, 0.4], turned),
            ([9.0, -3.0, 1.0], turned),
            ([1.0, 0.0, 0.0], DQuat::IDENTITY),
            ([0.0, 0.0, 1e-9], DQuat::IDENTITY),
        ]
        .map(|(translation, rotation)| Pose::new(DVec3::from_array(translation), rotation).expect("finite"));
        Self { dirs, poses: poses.to_vec(), cube, extent, is_judged: true }
    }

    /// The same queries, without checks of the answers: for packs that were opened without checks
    /// of their contents.
    pub fn unjudged(self) -> Self {
        Self { is_judged: false, ..self }
    }

    /// Runs the queries. Panics if an answer is out of range, or is not finite although all stored
    /// numbers are finite.
    pub fn run(&self, pack: &Pack) {
        self.require(pack.hull_count() > 0, || "an opened pack has no hull".to_owned());
        self.require(pack.hull(pack.hull_count()).is_err(), || "there is a hull past the last one".to_owned());
        black_box((pack.source_path(), pack.options(), pack.header(), pack.byte_len()));
        // Redundant data may disagree. Then answers are wrong, but must still be in range.
        let agrees = self.is_judged && pack.check_repeats().is_ok();
        let hulls = pack.hulls().count();
        for (index, hull) in pack.hulls().enumerate() {
            self.query_facts(&hull);
            for &dir in self.dirs.iter().skip(index).step_by(hulls) {
                self.query_support(&hull, dir, agrees);
            }
            for &dir in self.dirs.iter().skip(index).step_by(MORE_INTERVAL * hulls) {
                self.query_more(&hull, dir, agrees);
            }
        }
        let cube = self.cube.hull(0).expect("a cube is one hull");
        let mut cache = Cache::default();
        for index in 0..self.extent.pairs {
            let Ok(hull) = pack.hull(index / 3 % pack.hull_count().max(1)) else { continue };
            let [a, b] = [[&hull, &cube], [&cube, &hull], [&hull, &hull]][index % 3];
            self.query_pair(a, b, self.poses[index % self.poses.len()], index, &mut cache);
        }
        self.query_whole(pack);
        if !self.is_judged {
            black_box(pack.check_repeats().is_ok());
        }
    }

    /// Queries all hulls together, through the BVH.
    fn query_whole(&self, pack: &Pack) {
        let (whole, other) = (Compound::new(pack), Compound::new(&self.cube));
        let (mut cache, mut manifolds) = (Cache::with_pairs(2), CompoundManifolds::new(2));
        for (index, &pose) in self.poses.iter().take(self.extent.pairs).enumerate() {
            for (a, b) in [(&whole, &other), (&other, &whole), (&whole, &whole)] {
                black_box(hullmap::intersects(a, b, pose, &mut cache));
                black_box(hullmap::distance(a, b, pose, &Settings::default(), &mut cache));
                let deepest = hullmap::contact(a, b, pose, &Settings::default(), &mut cache);
                let [of_a, of_b] = deepest.parts.map(|part| part as usize);
                let is_there = !deepest.hit || a.hull(of_a).is_some() && b.hull(of_b).is_some();
                self.require(is_there, || "a contact refers to a hull that does not exist".to_owned());
                self.query_whole_moving(a, b, pose, &mut cache);
                if index.is_multiple_of(MANIFOLD_INTERVAL) {
                    black_box(manifolds.update(a, b, pose, &ManifoldSettings::default()));
                }
            }
        }
    }

    /// Asserts `holds`, unless the inquiry is [unjudged](Self::unjudged).
    fn require(&self, holds: bool, what: impl FnOnce() -> String) {
        if self.is_judged {
            assert!(holds, "{}", what());
        }
    }

    fn query_facts(&self, hull: &Hull) {
        let count = hull.vertex_count();
        let sound = count > 0 && hull.rank() <= 3 && hull.vertices().len() == count;
        self.require(sound, || format!("{count} vertices of rank {}", hull.rank()));
        self.require(hull.vertex(count as u32).is_none(), || "there is a vertex past the last one".to_owned());
        self.require(hull.vertices().all(|vertex| vertex.is_finite()), || "a vertex is not finite".to_owned());
        let are_faces = hull.faces().map(|mut face| face.len() >= 3 && face.all(|vertex| (vertex as usize) < count));
        let faces = are_faces.filter(|is_face| *is_face).count();
        self.require(faces == hull.face_count(), || format!("{faces} of {} faces are sound", hull.face_count()));
        let last = [0, count as u32 - u32::from(count > 0), count as u32, u32::MAX];
        for index in last {
            black_box((hull.source_vertex(index), hull.neighbours(index).len(), hull.faces_at(index).len()));
            black_box((hull.face(index).len(), hull.face_normal(index)));
        }
        black_box((hull.name(), hull.bounds(), hull.volume(), hull.surface_area(), hull.second_moments()));
        black_box((hull.centroid(), hull.diameter(), hull.containment_error(), hull.source_point_count()));
        black_box((hull.index_kind(), hull.index_byte_len(), hull.origin(), hull.part(), hull.part_count()));
        black_box((hull.solid(), hull.uncovered(), hull.protrusion(), hull.protrusion_at()));
        black_box((hull.outer_error(), hull.outer_vertices().map(|vertex| vertex.x).sum::<f32>()));
    }

    fn expect_vertex(&self, hull: &Hull, dir: Vec3, index: u32, point: Vec3, agrees: bool) {
        let vertex = hull.vertex(index);
        let sound = vertex == Some(point) || !agrees && vertex.is_some() && point.is_finite();
        self.require(sound, || format!("in direction {dir}: vertex {index} is {vertex:?}, not {point}"));
    }

    fn query_support(&self, hull: &Hull, dir: Vec3, agrees: bool) {
        let got = hull.support(dir);
        self.expect_vertex(hull, dir, got.index, got.point, agrees);
    }

    fn query_more(&self, hull: &Hull, dir: Vec3, agrees: bool) {
        let count = hull.vertex_count();
        let got = hull.support(dir);
        if let Some(portable) = hull.with_instructions(Instructions::Portable) {
            let other = portable.support(dir);
            self.require(other == got, || {
                format!("in direction {dir}: {got:?}, but {other:?} with portable instructions")
            });
        }
        let (cost, max) = (hull.support_cost(dir), hull.worst_cost());
        self.require(cost.nodes <= max.nodes && cost.dots <= max.dots, || format!("{cost:?} exceeds {max:?}"));
        for hint in [got.index, 0, (count as u32).wrapping_sub(1), count as u32, u32::MAX] {
            let got = hull.support_from(dir, hint);
            self.expect_vertex(hull, dir, got.index, got.point, agrees);
        }
        let mut feature = Feature::new();
        hull.feature(dir.as_dvec3(), &mut feature);
        let corners = feature.corners();
        let sound = !corners.is_empty() && corners.iter().all(|corner| (corner.vertex as usize) < count);
        self.require(sound, || format!("in direction {dir}: the feature {corners:?}"));
        let all_there = hull.faces_at(got.index).all(|face| (face as usize) < hull.face_count());
        self.require(all_there, || format!("a face at vertex {} does not exist", got.index));
        let towards = hull.face_towards(dir.as_dvec3());
        self.require(towards.is_none_or(|face| hull.face(face).len() >= 3), || format!("{towards:?} is not a face"));
        let got = SupportMap::support_point(hull, dir.as_dvec3() * 1e200);
        let sound = (got.feature as usize) < count && got.point.is_finite();
        self.require(sound, || format!("in direction {dir} times 1e200: {got:?}"));
    }

    /// Rays, shape casts and points from the place of B.
    fn query_whole_moving(&self, a: &Compound, b: &Compound, b_in_a: Pose, cache: &mut Cache) {
        let (settings, from) = (CastSettings::default(), b_in_a.translation() * 3.0);
        let near = hullmap::signed_distance(a, from, &Settings::default(), cache).expect("the point is finite");
        let is_there = a.hull_count() == 0 || a.hull(near.part as usize).is_some();
        self.require(is_there, || "a signed distance refers to a hull that does not exist".to_owned());
        if let (Ok(towards), Ok(motion)) = (Ray::new(from, -from), Motion::new(-from)) {
            black_box(hullmap::ray(a, &towards, &settings));
            black_box(hullmap::cast(a, b, b_in_a, motion, &settings, cache));
        }
    }
    fn query_pair(&self, a: &Hull, b: &Hull, b_in_a: Pose, index: usize, cache: &mut Cache) {
        let settings = Settings::default();
        black_box(intersects(a, b, b_in_a, cache));
        let found = black_box(contact(a, b, b_in_a, &settings, cache));
        let gap = black_box(distance(a, b, b_in_a, &settings, cache));
        let calls = found.support_calls.max(gap.support_calls);
        self.require(calls <= MAX_SUPPORT_CALLS, || format!("{calls} support calls"));
        self.query_moving(a, b, b_in_a);
        if index.is_multiple_of(MANIFOLD_INTERVAL) {
            let mut manifold = Manifold::new();
            manifold.update(a, b, b_in_a, &ManifoldSettings::default(), cache);
            self.require(manifold.points().len() <= 4, || "a manifold of more than four points".to_owned());
            let parts = (Compound::from(*a), Compound::from(*b));
            black_box(intersects(&parts.0, &parts.1, b_in_a, &mut Cache::with_pairs(1)));
        }
    }
    /// Rays, shape casts and points from the place of B towards A.
    fn query_moving(&self, a: &Hull, b: &Hull, b_in_a: Pose) {
        let (settings, from) = (CastSettings::default(), b_in_a.translation() * 3.0);
        let to = a.interior_point();
        // The check of a pack requires a finite interior point, and paths a limited one.
        let (Ok(towards), Ok(motion)) = (Ray::new(from, to - from), Motion::new(to - b_in_a.translation())) else {
            return;
        };
        let entry = black_box(ray(a, &towards, &settings));
        let impact = black_box(cast(a, b, b_in_a, motion, &settings, &mut Cache::new()));
        black_box(signed_distance(a, from, &Settings::default(), &mut Cache::new()).expect("the point is finite"));
        black_box(a.bounds_under(b_in_a));
        a.feature_within(from, a.diameter() * 0.1, &mut Feature::new());
        a.reduced_feature_within(from, a.diameter() * 0.1, &mut Feature::new());
        let calls = entry.support_calls.max(impact.support_calls);
        self.require(calls <= MAX_SUPPORT_CALLS, || format!("{calls} support calls of a ray or a cast"));
    }
}
