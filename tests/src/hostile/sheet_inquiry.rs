//! All queries on a triangle mesh or a height field that opened.

use std::hint::black_box;
use std::sync::Arc;

use glam::{DQuat, DVec3};
use hullmap::compound::{self, BodyManifold, OneSided, SharedSheet};
use hullmap::shapes::{Cuboid, HalfSpace, Sphere};
use hullmap::{
    Cache, CastSettings, CompoundManifolds, HeightField, ManifoldSettings, Motion, MotionSettings, Pose, Ray,
    RigidMotion, Settings, TriangleMesh,
};

/// Places of bodies, as shares of the bounds of a sheet, with turns.
const PLACES: [([f64; 3], [f64; 4]); 8] = [
    ([0.5, 0.5, 0.5], [0.3, -0.2, 0.5, 0.7]),
    ([0.1, 0.8, 1.1], [0.0, 0.0, 0.0, 1.0]),
    ([0.9, 0.3, -0.2], [0.0, 0.6, 0.0, 0.8]),
    ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]),
    ([1.0, 1.0, 1.0], [0.5, 0.5, 0.5, 0.5]),
    ([0.25, 0.75, 0.4], [-0.1, 0.2, 0.9, 0.1]),
    ([-4.0, 3.0, 5.0], [0.1, 0.1, 0.1, 0.9]),
    ([0.7, 0.5, 1e-9], [0.0, 0.0, 1.0, 0.0]),
];

/// Maximum number of triangles of a sheet that is queried with itself, which may test all pairs.
const MAX_AGAINST_ITSELF: usize = 128;

/// Maximum number of support calls of a distance for each triangle. A box needs up to 15.
const MAX_CALLS: usize = 20;

/// Queries at a number of places.
pub struct SheetInquiry {
    places: usize,
}

impl SheetInquiry {
    /// Queries at `places` places, at most all.
    pub fn new(places: usize) -> Self {
        Self { places }
    }

    /// Runs the queries on a mesh. Panics if an answer refers to something that does not exist, or
    /// is not finite although all stored numbers are.
    pub fn run_mesh(&self, mesh: TriangleMesh) {
        black_box((mesh.source_path().len(), mesh.options().len(), mesh.warnings().count(), mesh.bytes().len()));
        black_box((mesh.degenerate_count(), mesh.duplicate_count(), mesh.merged_count()));
        let (triangles, vertices) = (mesh.triangle_count(), mesh.vertex_count());
        assert!(triangles > 0 && vertices > 0, "{triangles} triangles, {vertices} vertices");
        for triangle in [triangles, usize::MAX] {
            assert!(mesh.triangle(triangle).is_none() && mesh.corners(triangle).is_none());
            assert!(mesh.normal(triangle).is_none() && mesh.neighbours(triangle).is_none());
            assert!(mesh.edge_classes(triangle).is_none() && mesh.material(triangle).is_none());
        }
        let [low, high] = mesh.bounds();
        for triangle in 0..triangles {
            let own = mesh.corners(triangle).unwrap_or_else(|| panic!("triangle {triangle} has no corners"));
            for vertex in own.map(|corner| corner as usize) {
                let at = mesh.vertex(vertex).unwrap_or_else(|| panic!("vertex {vertex} does not exist"));
                assert!(at.cmpge(low).all() && at.cmple(high).all(), "vertex {vertex} is outside of the bounds");
                assert!(mesh.vertex_class(vertex).is_some(), "vertex {vertex} has no class");
            }
            let beyond = mesh.neighbours(triangle).unwrap_or_else(|| panic!("triangle {triangle} has no neighbours"));
            assert!(beyond.into_iter().flatten().all(|neighbour| (neighbour as usize) < triangles), "{beyond:?}");
            assert!(mesh.edge_classes(triangle).is_some(), "an edge of triangle {triangle} has no class");
            black_box((mesh.normal(triangle), mesh.material(triangle), mesh.source_triangle(triangle)));
        }
        let mut cache = Cache::new();
        for point in self.poses(&[low.as_dvec3(), high.as_dvec3()]).map(|pose| pose.translation()) {
            if let Ok(found) = compound::surface_distance(&mesh, point, &Settings::default(), &mut cache) {
                assert!((found.part as usize) < triangles && found.distance.is_finite(), "{found:?}");
            }
        }
        self.run(&SharedSheet::Mesh(Arc::new(mesh)), [low, high].map(|corner| corner.as_dvec3()));
    }

    /// Runs the queries on a field. Panics as [`run_mesh`](Self::run_mesh).
    pub fn run_field(&self, field: HeightField) {
        black_box((field.source_path().len(), field.options().len(), field.bytes().len()));
        let (triangles, layout) = (field.triangle_count(), *field.layout());
        assert!(triangles >= 2 && triangles == 2 * layout.cell_count(), "{triangles} triangles");
        for triangle in [triangles, usize::MAX] {
            assert!(field.triangle(triangle).is_none() && field.normal(triangle).is_none());
            assert!(field.neighbours(triangle).is_none() && field.edge_classes(triangle).is_none());
        }
        let bounds = field.bounds();
        let [low, high] = bounds;
        let mut holes = 0;
        for triangle in 0..triangles {
            let Some(own) = field.triangle(triangle) else {
                holes += 1;
                continue;
            };
            let is_inside = own.corners().iter().all(|c| c.cmpge(low).all() && c.cmple(high).all());
            assert!(is_inside, "triangle {triangle} is outside of the bounds");
            let beyond = field.neighbours(triangle).unwrap_or_else(|| panic!("triangle {triangle} has no neighbours"));
            assert!(beyond.into_iter().flatten().all(|near| field.triangle(near).is_some()), "{beyond:?}");
            black_box((field.normal(triangle), field.edge_classes(triangle), field.material(triangle)));
        }
        assert_eq!(holes, 2 * field.hole_count());
        for (column, row) in [(0, 0), (layout.columns, 0), (layout.columns - 1, layout.rows - 1), (0, usize::MAX)] {
            black_box((field.vertex(column, row), field.vertex_class(column, row), field.is_hole(column, row)));
        }
        for point in self.poses(&bounds).map(|pose| pose.translation()) {
            if let Some(ground) = field.height_at(point.x, point.y) {
                assert!(field.triangle(ground.triangle).is_some() && ground.height.is_finite(), "{ground:?}");
            }
        }
        self.run(&SharedSheet::Field(Arc::new(field)), bounds);
    }

    /// Poses of bodies near a sheet with these bounds.
    fn poses(&self, [low, high]: &[DVec3; 2]) -> impl Iterator<Item = Pose> + use<> {
        let (low, size) = (*low, *high - *low);
        PLACES.into_iter().take(self.places).filter_map(move |(share, turn)| {
            Pose::new(low + DVec3::from_array(share) * size, DQuat::from_array(turn)).ok()
        })
    }

    /// Queries of the sheet and bodies of several sizes, and of the sheet with itself.
    fn run(&self, sheet: &SharedSheet, bounds: [DVec3; 2]) {
        let extent = (bounds[1] - bounds[0]).max_element();
        let (mut cache, mut manifolds, mut body) =
            (Cache::with_pairs(2), CompoundManifolds::new(4), BodyManifold::new(8));
        for (index, pose) in self.poses(&bounds).enumerate() {
            // The least and the greatest size that shapes accept are in reach of hostile bounds.
            let size = extent * [0.1, 0.01, 0.5, 1e-6][index % 4];
            self.query_rays(sheet, pose);
            if let (Ok(ball), Ok(die)) = (Sphere::new(size), Cuboid::new(DVec3::splat(size))) {
                self.query_pair(sheet, &ball, pose, &mut cache);
                self.query_pair(sheet, &die, pose, &mut cache);
                black_box(manifolds.update(sheet, &die, pose, &ManifoldSettings::default()));
                body.update(&manifolds);
                assert!(body.points().len() <= compound::MAX_BODY_POINTS);
                black_box(manifolds.update(&OneSided::new(sheet), &die, pose, &ManifoldSettings::default()));
                self.query_moving(sheet, &die, pose, &mut cache);
            }
            if index.is_multiple_of(4) && sheet.triangle_count() <= MAX_AGAINST_ITSELF {
                black_box(hullmap::intersects(sheet, sheet, pose, &mut cache));
            }
            if let Ok(plane) = HalfSpace::new(DVec3::new(0.3, -0.2, 1.0), size) {
                black_box(hullmap::distance(&plane, sheet, pose, &Settings::default(), &mut cache));
            }
        }
    }

    fn query_pair(&self, sheet: &SharedSheet, other: &impl hullmap::Shape, pose: Pose, cache: &mut Cache) {
        let (settings, count) = (Settings::default(), sheet.triangle_count());
        let hit = hullmap::intersects(sheet, other, pose, cache);
        let gap = hullmap::distance(sheet, other, pose, &settings, cache);
        assert!([hit.parts[0], gap.parts[0]].iter().all(|triangle| (*triangle as usize) < count), "{hit:?}, {gap:?}");
        // Damage must not make a query much longer than one that tests every triangle.
        assert!(gap.lower <= gap.upper && gap.support_calls as usize <= MAX_CALLS * count, "{gap:?}");
        let deepest = hullmap::contact(sheet, other, pose, &settings, cache);
        let is_there = !deepest.hit || sheet.triangle(deepest.parts[0] as usize).is_some();
        assert!(is_there && !deepest.depth.is_nan(), "{deepest:?}");
        let mut seen = 0;
        hullmap::contacts(sheet, other, pose, &settings, cache, |found| {
            seen += 1;
            assert!(sheet.triangle(found.parts[0] as usize).is_some(), "{found:?}: there is no such triangle");
        });
        assert!(seen <= count, "a triangle is visited twice");
        black_box(hullmap::contact(&OneSided::new(sheet), other, pose, &settings, cache));
    }

    /// Rays from the place of the body: down, along both axes, slanting, and through the origin.
    fn query_rays(&self, sheet: &SharedSheet, pose: Pose) {
        let from = pose.translation();
        let directions = [
            DVec3::NEG_Z,
            DVec3::Z,
            DVec3::X,
            DVec3::NEG_Y,
            DVec3::new(1.0, -2.0, -0.3),
            DVec3::new(-1e-9, 1.0, 0.0),
            -from,
        ];
        for direction in directions {
            let Ok(ray) = Ray::new(from, direction) else { continue };
            for max_t in [f64::INFINITY, 1.0] {
                let settings = CastSettings { max_t, ..CastSettings::default() };
                let found = hullmap::ray(sheet, &ray, &settings);
                assert!(!found.hit || sheet.triangle(found.part as usize).is_some(), "{found:?}");
                black_box(hullmap::ray(&OneSided::new(sheet), &ray, &settings));
            }
        }
    }

    fn query_moving(&self, sheet: &SharedSheet, other: &impl hullmap::Shape, pose: Pose, cache: &mut Cache) {
        let way = DVec3::new(0.3, -0.2, -1.0) * pose.translation().length().max(1.0);
        if let Ok(motion) = Motion::new(way) {
            let impact = hullmap::cast(sheet, other, pose, motion, &CastSettings::default(), cache);
            assert!(!impact.hit || sheet.triangle(impact.parts[0] as usize).is_some(), "{impact:?}");
        }
        let still = RigidMotion::still(Pose::IDENTITY);
        if let Ok(moving) = RigidMotion::screw(pose, way, DVec3::new(0.2, 0.1, 0.3), pose.translation()) {
            black_box(hullmap::cast_motion(sheet, &still, other, &moving, &MotionSettings::default(), cache));
        }
    }
}
