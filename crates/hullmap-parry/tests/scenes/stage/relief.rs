//! Uneven ground of the rest scenes: a rough height field.

use std::sync::OnceLock;

use hullmap::height_field::Diagonal;
use hullmap::{Cache, Settings};
use hullmap_parry::BakedSurface;
use hullmap_random::SplitMix64;
use rapier3d::parry::query::RayCast as _;
use rapier3d::parry::shape::Shape as _;
use rapier3d::prelude::*;

use super::model::Model;
use super::sheets::Heights;
use super::way::Way;

/// Half the side of the ground, in metres.
const HALF: f64 = 10.0;

/// Uneven ground around the origin.
pub struct Relief {
    surface: BakedSurface,
    /// parry's own shape, and its pose.
    of_parry: (Pose, SharedShape),
    /// Greatest height near the place where bodies fall.
    pub top: f32,
    /// Least height.
    pub lowest: f32,
}

impl Relief {
    fn new(surface: BakedSurface, of_parry: (Pose, SharedShape)) -> Self {
        let height = |x: f32, z: f32| {
            let ray = rapier3d::parry::query::Ray::new(Vector::new(x, 100.0, z), -Vector::Y);
            surface.cast_local_ray(&ray, 200.0, true).map(|fall| 100.0 - fall)
        };
        let around = (0..441).filter_map(|i| height((i % 21) as f32 * 0.1 - 0.7, (i / 21) as f32 * 0.1 - 0.8));
        let top = around.fold(f32::NEG_INFINITY, f32::max);
        let lowest = surface.compute_local_aabb().mins.y;
        Self { surface, of_parry, top, lowest }
    }

    /// A height field of cells of 0.5 m, whose vertices are up to 10 cm above or below y = 0.
    pub fn rough() -> &'static Self {
        static ROUGH: OnceLock<Relief> = OnceLock::new();
        ROUGH.get_or_init(|| {
            let mut rng = SplitMix64::new(39);
            let heights =
                Heights::new([40, 40], [-HALF; 2], [0.5; 2], Diagonal::Rising, |_, _| rng.between(-0.1, 0.1) as f32);
            Self::new(heights.surface(), heights.of_parry())
        })
    }

    /// The collider for a way of using shapes.
    pub fn collider(&self, way: Way) -> ColliderBuilder {
        match way {
            Way::Parry => ColliderBuilder::new(self.of_parry.1.clone()).position(self.of_parry.0),
            Way::Shapes | Way::Dispatcher => ColliderBuilder::new(self.surface.clone().into()),
        }
    }

    /// Depth of the body at `pose` in the deepest triangle.
    pub fn depth(&self, model: &Model, pose: &Pose) -> f32 {
        let body = hullmap::Pose::from_f32(pose.translation, pose.rotation).expect("a finite pose");
        let (settings, mut cache) = (Settings::default(), Cache::with_pairs(1));
        let mut deepest = 0.0_f64;
        for tile in self.surface.tiles() {
            let in_tile = hullmap::Pose::relative(tile.place(), body).expect("a pose in range");
            for part in &model.parts {
                deepest = deepest.max(hullmap::contact(tile, part.hull(), in_tile, &settings, &mut cache).depth);
            }
        }
        deepest as f32
    }
}
