//! Uneven ground of the rest scenes: a rough height field, and a terrain from a scanned mesh.

use std::path::Path;
use std::sync::OnceLock;

use hullmap::glam::{DMat4, DVec3, DVec4};
use hullmap::height_field::Diagonal;
use hullmap::{Cache, CastSettings, Ray, Settings};
use hullmap_parry::{BakedSurface, Sheet, SurfaceTile};
use hullmap_random::SplitMix64;
use rapier3d::parry::query::RayCast as _;
use rapier3d::parry::shape::Shape as _;
use rapier3d::prelude::*;

use crate::model::{Model, triangles};
use crate::sheets::{self, Heights};
use crate::way::Way;

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

    /// The relief of a scanned body around its axis z, laid out on a plane: a mesh of 3,200
    /// triangles of 0.5 m. The distances from the centre within 40° of the axis, minus the
    /// paraboloid that fits them best, become heights. Panics if the file cannot be read, or a ray
    /// from the centre misses the mesh.
    pub fn of_scan(path: &Path) -> Self {
        let (positions, corners) = triangles(path);
        let sheet = sheets::mesh(&positions, &corners);
        let Some(Sheet::Mesh(mesh)) = sheet.tiles().first().map(SurfaceTile::sheet) else { panic!("a mesh") };
        let center =
            positions.iter().map(|p| DVec3::from_array(p.map(f64::from))).sum::<DVec3>() / positions.len() as f64;
        let cells = 40;
        let angle = |i: usize| (i as f64 / cells as f64 - 0.5) * 80_f64.to_radians();
        let distance = |column: usize, row: usize| {
            let dir = DVec3::new(angle(column).tan(), angle(row).tan(), 1.0).normalize();
            let hit = hullmap::ray(&**mesh, &Ray::new(center, dir).expect("a ray"), &CastSettings::default());
            assert!(hit.hit, "{}: a ray from the centre misses the mesh", path.display());
            hit.t
        };
        let row = cells + 1;
        let distances: Vec<f64> = (0..row * row).map(|i| distance(i % row, i / row)).collect();
        let mean = distances.iter().sum::<f64>() / distances.len() as f64;
        // The arc of 80° is as long as the ground.
        let scale = 2.0 * HALF / (80_f64.to_radians() * mean);
        let over = |i: usize| [i % row, i / row].map(|i| 2.0 * HALF * (i as f64 / cells as f64 - 0.5));
        let shape = paraboloid((0..row * row).map(|i| (over(i), distances[i] * scale)));
        let place = |i: usize| {
            let [x, z] = over(i);
            [x as f32, (distances[i] * scale - terms([x, z]).dot(shape)) as f32, z as f32]
        };
        let ground: Vec<[f32; 3]> = (0..row * row).map(place).collect();
        let corners: Vec<[u32; 3]> = (0..cells * cells)
            .flat_map(|i| {
                let a = (i / cells * row + i % cells) as u32;
                let row = row as u32;
                [[a, a + row, a + 1], [a + 1, a + row, a + row + 1]]
            })
            .collect();
        let surface = sheets::mesh(&ground, &corners);
        let of_parry = sheets::shape(&surface, Way::Parry);
        Self::new(surface, (Pose::IDENTITY, of_parry))
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

/// Terms of a paraboloid at a place.
fn terms([x, z]: [f64; 2]) -> DVec4 {
    DVec4::new(1.0, x, z, x * x + z * z)
}

/// The paraboloid that fits heights at places best, by least squares.
fn paraboloid(heights: impl Iterator<Item = ([f64; 2], f64)>) -> DVec4 {
    let (mut matrix, mut right) = (DMat4::ZERO, DVec4::ZERO);
    for (place, height) in heights {
        let terms = terms(place);
        matrix += DMat4::from_cols(terms * terms.x, terms * terms.y, terms * terms.z, terms * terms.w);
        right += terms * height;
    }
    matrix.inverse() * right
}

/// The terrain of the scenes, once it is loaded.
static TERRAIN: OnceLock<Relief> = OnceLock::new();

/// Loads the terrain from a mesh file. Panics as [`Relief::of_scan`] does.
pub fn load_terrain(path: &Path) {
    TERRAIN.get_or_init(|| Relief::of_scan(path));
}

/// The terrain; `None` before it is loaded.
pub fn terrain() -> Option<&'static Relief> {
    TERRAIN.get()
}
