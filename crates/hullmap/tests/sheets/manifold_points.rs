//! Points of manifolds are on both surfaces: inputs on which they were not. The program
//! `mesh-truth --manifolds` judges random ones.

use glam::{DQuat, DVec3};
use hullmap::shapes::{Capsule, Cuboid, Sphere, Triangle};
use hullmap::{
    Cache, CompoundManifolds, Manifold, ManifoldSettings, Pose, Prediction, Settings, Shape, Status, TriangleMesh,
};
use hullmap_testkit::triangles::distance_from_triangle;

use crate::meshes::mesh;

/// Maximum distance of a point from a surface, relative to the smaller outer radius.
const OFF: f64 = 2e-6;

fn within(prediction: f64) -> ManifoldSettings {
    ManifoldSettings { prediction: Prediction::Length(prediction), ..ManifoldSettings::default() }
}

/// Checks the points of a manifold of a triangle with these `corners`. `off_body` is the distance
/// of a point in B's frame from the surface of B.
fn judge(manifold: &Manifold, corners: [DVec3; 3], off_body: impl Fn(DVec3) -> f64, reach: f64, prediction: f64) {
    for point in manifold.points() {
        let off = distance_from_triangle(corners, point.point_a);
        assert!(off <= OFF * reach, "{off} off the triangle: {point:?}");
        assert!(off_body(point.local_b).abs() <= OFF * reach, "off the body: {point:?}");
        assert!(point.depth >= -prediction, "beyond the prediction: {point:?}");
        let aside = point.point_a - point.point_b - manifold.normal() * point.depth;
        assert!(aside.length() <= 1e-9 * reach, "{point:?}");
    }
}

/// Checks the welded manifolds of a cube on a mesh, and returns the number of points, and of
/// triangles whose normal is corrected.
fn judge_cube(ground: &TriangleMesh, half: f64, at: DVec3, prediction: f64) -> [usize; 2] {
    let (cube, pose) = (Cuboid::new(DVec3::splat(half)).unwrap(), Pose::from_translation(at).unwrap());
    let (mut welded, mut alone) = (CompoundManifolds::new(8), CompoundManifolds::new(8));
    alone.set_welding(false);
    for found in [&mut welded, &mut alone] {
        found.update(ground, &cube, pose, &within(prediction));
    }
    for (pair, manifold) in welded.iter().chain(alone.iter()) {
        let corners = ground.triangle(pair[0]).unwrap().corners();
        judge(manifold, corners, |p| (p.abs() - half).max_element(), half, prediction);
    }
    let is_corrected = |pair| welded.get(pair).map(Manifold::normal) != alone.get(pair).map(Manifold::normal);
    let points = welded.iter().map(|(_, manifold)| manifold.points().len()).sum();
    [points, alone.iter().filter(|(pair, _)| is_corrected(*pair)).count()]
}

/// The point of a corrected normal was the foot of the body's point on the plane of the triangle,
/// far beside the triangle, and up to 30 times the prediction away.
#[test]
fn corrected_normals_have_points_on_the_mesh() {
    let folded = |heights: [f64; 4]| {
        let at = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let corner = |(at, z): ([f64; 2], f64)| DVec3::new(at[0], at[1], z);
        let positions: Vec<DVec3> = at.into_iter().zip(heights).map(corner).collect();
        mesh(&positions, &[[0, 1, 2], [0, 2, 3]])
    };
    for (heights, at) in [
        ([-0.5, 0.5, -0.5, -0.5], DVec3::new(0.125, 0.125, -0.4375)),
        ([-0.25, 0.5, 0.25, -0.5], DVec3::new(1.375, 1.625, 0.0625)),
    ] {
        let [points, corrected] = judge_cube(&folded(heights), 0.5, at, 0.02);
        assert!(points >= 2 && corrected >= 1, "{points} points, {corrected} corrected");
    }
}

/// The search of the contact stalled, with a point of the triangle that is not on the line through
/// the point of the ball: the point halfway was 260 radii away from the ball.
#[test]
fn a_ball_whose_middle_is_nearly_in_a_large_triangle() {
    for (middle, radius) in [([0.42123897142561395, 5e-8], 5e-4), ([0.42, 5e-8], 5e-4), ([0.5, 1e-9], 5e-5)] {
        for rise in [0.0, 1e-7] {
            let corners = [DVec3::ZERO, DVec3::new(1.0, 1.0, rise), DVec3::Y];
            let (triangle, ball) = (Triangle::new(corners).unwrap(), Sphere::new(radius).unwrap());
            let at = Pose::from_translation(DVec3::new(middle[0], middle[0], middle[1])).unwrap();
            let mut manifold = Manifold::new();
            let contact = manifold.update(&triangle, &ball, at, &ManifoldSettings::default(), &mut Cache::new());
            judge(&manifold, corners, |p| p.length() - radius, radius, 0.0);
            assert_eq!((manifold.points().len(), manifold.status()), (1, contact.status), "{middle:?}");
        }
    }
}

/// Both ends of a capsule that leans were moved along the normal: the lower one is then inside.
#[test]
fn a_capsule_that_leans_has_points_on_its_side() {
    let (half, radius) = (0.5, 1.0);
    let (floor, capsule) = (Cuboid::new(DVec3::new(9.0, 9.0, 1.0)).unwrap(), Capsule::new(half, radius).unwrap());
    for tilt in [0.0, 1e-3, 0.03, 0.3, 0.42, 1.2, 1.57] {
        let turn = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2 - tilt);
        let at = Pose::new(DVec3::Z * (0.9 + radius + half * tilt.sin()), turn).unwrap();
        let mut manifold = Manifold::new();
        manifold.update(&floor, &capsule, at, &within(0.45), &mut Cache::new());
        assert_eq!(manifold.points().len() >= 2, tilt < 0.45, "{tilt}: {manifold:?}");
        for point in manifold.points() {
            let core = DVec3::Z * point.local_b.z.clamp(-half, half);
            let off = point.local_b.distance(core) - radius;
            assert!(off.abs() < OFF && (point.point_a.z - 1.0).abs() < OFF, "{tilt}: {off} {point:?}");
        }
    }
}

/// A manifold tells how the query of its normal ended.
#[test]
fn a_manifold_has_the_status_of_its_query() {
    let (cube, ball) = (Cuboid::new(DVec3::ONE).unwrap(), Sphere::new(1.0).unwrap());
    let status = |b: &dyn Shape, z: f64, limit: u32| {
        let contact = Settings { max_iterations: limit, ..Settings::default() };
        let settings = ManifoldSettings { contact, ..ManifoldSettings::default() };
        let (mut manifold, at) = (Manifold::new(), Pose::from_translation(DVec3::new(0.1, 0.2, z)).unwrap());
        manifold.update(&cube, b, at, &settings, &mut Cache::new());
        (manifold.status(), manifold.points().is_empty())
    };
    assert_eq!(status(&cube, 1.99, 1000), (Status::Exact, false));
    assert_eq!(status(&cube, 2.01, 1000), (Status::Exact, false));
    assert_eq!(status(&cube, 2.1, 1000), (Status::Separated, true));
    assert_eq!(status(&cube, 2.0, 1000), (Status::Touching, false));
    assert_eq!(status(&ball, 0.3, 0).0, Status::IterationLimit);
    let mut cleared = Manifold::new();
    cleared.update(&cube, &ball, Pose::IDENTITY, &ManifoldSettings::default(), &mut Cache::new());
    cleared.clear();
    assert_eq!(cleared.status(), Status::Separated);
}
