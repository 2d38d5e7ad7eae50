//! Answers of every query, hashed by kind.

use glam::{DQuat, DVec3};
use hullmap::batch::{self, Pair};
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, Rounded, Scaled, Sphere};
use hullmap::{
    Cache, Compound, Hull, Manifold, ManifoldSettings, Pack, Pose, Settings, Shape, contact, distance, intersects,
};
use shapes::rng::SplitMix64;

use crate::bits::Bits;

/// Kinds of answers, as the golden file names them.
pub const KINDS: [&str; 8] =
    ["support", "support_from", "intersects", "contact", "distance", "parts", "manifold", "batch"];

/// Number of answers of each kind in one chunk.
pub const PER_CHUNK: usize = 200;

/// Number of chunks of the large set: 102,400 answers, and as many warm answers about pairs.
pub const CHUNKS: u64 = 64;

const SEED: u64 = 0x901d;

/// One hash for each kind, over `per_kind` answers of chunk `index`.
pub fn chunk(packs: &[Pack], index: u64, per_kind: usize) -> [u64; KINDS.len()] {
    let mut rng = SplitMix64::new(SEED ^ index.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let hulls: Vec<Hull<'_>> = packs.iter().flat_map(Pack::hulls).collect();
    let shapes = shapes(&hulls);
    let mut bits: [Bits; KINDS.len()] = Default::default();
    let [support, support_from, yes, deep, near, parts, held, batched] = &mut bits;
    for _ in 0..per_kind {
        let hull = &hulls[rng.below(hulls.len())];
        let dir = DVec3::from_array(rng.direction()).as_vec3();
        let found = hull.support(dir);
        support.support(found);
        let beside = dir + DVec3::from_array(rng.direction()).as_vec3() * 0.1;
        support_from.support(hull.support_from(beside, found.index));
    }
    let settings = Settings::default();
    let mut drawn = Vec::new();
    for i in 0..per_kind {
        // Half of the shapes are plain hulls.
        let (a, b) = (&hulls[rng.below(hulls.len())], &hulls[rng.below(hulls.len())]);
        let (any_a, any_b) = (&*shapes[rng.below(shapes.len())], &*shapes[rng.below(shapes.len())]);
        let b_in_a = pose(&mut rng);
        let moved =
            Pose::new(b_in_a.translation() + DVec3::new(0.01, -0.005, 0.002), b_in_a.rotation()).expect("finite");
        let mut caches = [(); 5].map(|()| Cache::new());
        for b_in_a in [b_in_a, moved] {
            if i % 2 == 0 {
                yes.intersection(&intersects(a, b, b_in_a, &mut caches[0]));
                deep.contact(&contact(a, b, b_in_a, &settings, &mut caches[1]));
                near.distance(&distance(a, b, b_in_a, &settings, &mut caches[2]));
            } else {
                yes.intersection(&intersects(any_a, any_b, b_in_a, &mut caches[0]));
                deep.contact(&contact(any_a, any_b, b_in_a, &settings, &mut caches[1]));
                near.distance(&distance(any_a, any_b, b_in_a, &settings, &mut caches[2]));
            }
            parts.intersection(&intersects(&Compound::from(*a), &Compound::from(*b), b_in_a, &mut caches[3]));
        }
        let mut manifold = Manifold::new();
        for b_in_a in [b_in_a, moved] {
            manifold.update(any_a, any_b, b_in_a, &ManifoldSettings::default(), &mut caches[4]);
            held.manifold(&manifold);
        }
        drawn.push(Pair { a: any_a, b: any_b, b_in_a });
    }
    let mut caches = vec![Cache::new(); drawn.len()];
    let none = contact(&hulls[0], &hulls[0], Pose::IDENTITY, &settings, &mut Cache::new());
    let mut contacts = vec![none; drawn.len()];
    for _ in 0..2 {
        batch::contact(&drawn, &settings, &mut caches, &mut contacts).expect("as many of each");
        contacts.iter().for_each(|c| batched.contact(c));
    }
    bits.map(|bits| bits.finish())
}

/// Joins the hashes of many chunks, in order, into one hash for each kind.
pub fn joined(chunks: &[[u64; KINDS.len()]]) -> Vec<(String, u64)> {
    let join = |(column, kind): (usize, &&str)| {
        let mut bits = Bits::default();
        chunks.iter().for_each(|chunk| bits.hash(chunk[column]));
        (format!("answers {kind}"), bits.finish())
    };
    KINDS.iter().enumerate().map(join).collect()
}

fn shapes<'h>(hulls: &[Hull<'h>]) -> Vec<Box<dyn Shape + Sync + 'h>> {
    let some = hulls[0];
    let length = "a length";
    let mut all: Vec<Box<dyn Shape + Sync + 'h>> = vec![
        Box::new(Sphere::new(0.8).expect(length)),
        Box::new(Cuboid::new(DVec3::new(0.5, 0.8, 1.0)).expect(length)),
        Box::new(Capsule::new(0.5, 0.3).expect(length)),
        Box::new(Cylinder::new(0.5, 0.7).expect(length)),
        Box::new(Cone::new(0.6, 0.5).expect(length)),
        Box::new(Rounded::new(some, 0.1).expect(length)),
        Box::new(Scaled::new(some, DVec3::new(-1.0, 0.5, 0.7)).expect("a scale")),
    ];
    for hull in hulls {
        all.push(Box::new(*hull));
    }
    all
}

/// Separated, touching and penetrating poses; in some, axes remain parallel. Computed without a
/// sine: see the documentation of the package.
fn pose(rng: &mut SplitMix64) -> Pose {
    let rotation = match rng.below(4) {
        0 => DQuat::IDENTITY,
        _ => DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0) + 1e-9)),
    };
    let translation = match rng.below(4) {
        0 => DVec3::AXES[rng.below(3)] * (0.25 * rng.below(12) as f64),
        _ => DVec3::from_array(rng.direction()) * rng.between(0.0, 2.5),
    };
    Pose::new(translation, rotation).expect("finite")
}
