//! Scenes of many different hulls: queries whose working set is larger than the caches.
//!
//! A benchmark that queries one hull repeatedly finds everything in the first-level cache. Games
//! and robots query a different hull each time.
//!
//! | module | content |
//! |---|---|
//! | this one | the hulls of a scene, for hullmap and parry3d |
//! | [`pairs`] | random pairs, and the neighbours in a moving crowd |
//! | [`race`] | interleaved timing |

pub mod pairs;
pub mod race;

use hullmap::{Hull, Pack};
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_testkit::packs::{bytes, point_set};
use parry3d::shape::ConvexPolyhedron;
use rayon::prelude::*;
use shapes::{families::Family, rng::SplitMix64};

use crate::subject::{SEED, polyhedron};

/// Maximum number of vertices in a pack: sections of a pack hold at most 2 GiB.
const VERTICES_OF_A_PACK: usize = 2_048_000;

/// Minimum and maximum semi-axis of a hull.
const SEMI_AXES: [f64; 2] = [0.7, 1.3];

/// Different hulls with the same number of vertices, for each engine.
pub struct Scene {
    packs: Vec<Pack>,
    /// As parry's polyhedra.
    pub polyhedra: Vec<ConvexPolyhedron>,
}

impl Scene {
    /// Bakes `count` ellipsoids of `vertices` random points each. Panics if parry3d rejects a hull.
    pub fn bake(count: usize, vertices: usize, index: IndexKind) -> Self {
        let numbers: Vec<usize> = (0..count).collect();
        let packs: Vec<Pack> = numbers
            .chunks((VERTICES_OF_A_PACK / vertices).max(1))
            .map(|numbers| {
                let sets: Vec<_> =
                    numbers.iter().map(|number| point_set("hull", &ellipsoid(vertices, *number))).collect();
                let files: Vec<u8> = bytes(&sets, index, &SourceRecord::default()).expect("ellipsoids can be baked");
                Pack::from_bytes(&files).expect("a new pack opens")
            })
            .collect();
        let hulls: Vec<Hull<'_>> = packs.iter().flat_map(Pack::hulls).collect();
        let in_parry = |hull: &Hull<'_>| {
            let convex_hull = || ConvexPolyhedron::from_convex_hull(&hull.vertices().collect::<Vec<_>>());
            polyhedron(hull).or_else(convex_hull).expect("parry accepts ellipsoids")
        };
        let polyhedra = hulls.par_iter().map(in_parry).collect();
        Self { packs, polyhedra }
    }

    /// All hulls.
    pub fn hulls(&self) -> Vec<Hull<'_>> {
        self.packs.iter().flat_map(Pack::hulls).collect()
    }

    /// Bytes of all packs.
    pub fn byte_len(&self) -> usize {
        self.packs.iter().map(Pack::byte_len).sum()
    }
}

/// Points on an ellipsoid. All of them are vertices of their hull.
fn ellipsoid(vertices: usize, number: usize) -> Vec<[f32; 3]> {
    let seed = SEED + number as u64;
    let mut rng = SplitMix64::new(seed);
    let axes = [(); 3].map(|()| rng.between(SEMI_AXES[0], SEMI_AXES[1]) as f32);
    Family::Sphere.points(vertices, seed).iter().map(|p| std::array::from_fn(|i| p[i] * axes[i])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hulls_differ_and_have_all_vertices() {
        let scene = Scene::bake(20, 40, IndexKind::Tree);
        let hulls = scene.hulls();
        assert_eq!((hulls.len(), scene.polyhedra.len()), (20, 20));
        assert!(hulls.iter().all(|hull| hull.vertex_count() == 40));
        assert!(scene.polyhedra.iter().all(|polyhedron| polyhedron.points().len() == 40));
        let mut diameters: Vec<f64> = hulls.iter().map(Hull::diameter).collect();
        diameters.sort_by(f64::total_cmp);
        diameters.dedup();
        assert_eq!(diameters.len(), 20, "seed {SEED}");
    }
}
