//! Points of bodies on many triangles, compared with all points of all manifolds.

use glam::{DQuat, DVec2, DVec3};
use hullmap::compound::{BodyManifold, BodyPoint, MAX_BODY_POINTS};
use hullmap::shapes::Cuboid;
use hullmap::{CompoundManifolds, ManifoldSettings, Pack, Pose, Prediction, SupportMap as _};
use hullmap_testkit::packs::tree_pack;
use shapes::rng::SplitMix64;

use crate::meshes::{body, grid, meshes};

const SEED: u64 = 0x8;

/// Normals within this angle, five degrees, are one group.
const SAME_NORMAL: f64 = 0.9961946980917455;

/// All points of all manifolds, as a body manifold would have them.
fn all_points(manifolds: &CompoundManifolds) -> Vec<BodyPoint> {
    let of = |(pair, manifold): ([usize; 2], &hullmap::Manifold)| {
        let normal = manifold.normal();
        manifold.points().iter().map(|point| BodyPoint { pair, normal, point: *point }).collect::<Vec<_>>()
    };
    manifolds.iter().flat_map(of).collect()
}

/// Checks the chosen points against all points: none is there twice, and every direction has one.
fn judge(body: &BodyManifold, manifolds: &CompoundManifolds, what: &str) {
    let (chosen, all) = (body.points(), all_points(manifolds));
    for (rank, point) in chosen.iter().enumerate() {
        let is_same = |other: &&BodyPoint| (other.pair, other.point.id) == (point.pair, point.point.id);
        assert_eq!(all.iter().filter(is_same).count(), 1, "{what}: a point is not one of the manifolds");
        assert_eq!(chosen[..rank].iter().filter(is_same).count(), 0, "{what}: a point is there twice");
    }
    // Every point's normal is near the normal of a deeper point of its group, up to doubled angles:
    // 80 degrees, if there are many directions.
    for point in &all {
        assert!(chosen.iter().any(|p| p.normal.dot(point.normal) > 0.17), "{what}: a direction has no point");
    }
}

/// A body of up to 40 vertices that is flat and wide, near the plane z = 0.
fn plate(rng: &mut SplitMix64) -> (Pack, Pose) {
    let count = 8 + rng.below(32);
    let point = |rng: &mut SplitMix64| DVec3::from_array(rng.direction()) * DVec3::new(2.0, 1.5, 0.1);
    let points: Vec<[f32; 3]> = (0..count).map(|_| point(rng).as_vec3().to_array()).collect();
    let tilt = DQuat::from_rotation_y(rng.between(-0.02, 0.02)) * DQuat::from_rotation_z(3.0 * rng.unit());
    let at = DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(0.0, 0.12));
    (tree_pack(&points), Pose::new(at, tilt).unwrap())
}

/// `hullmap_tests::sheets` judges depths and areas.
#[test]
fn every_direction_of_many_triangles_has_a_point() {
    println!("seed {SEED}");
    let mut rng = SplitMix64::new(SEED);
    let mut meshes = meshes(&mut rng);
    // Barely rough: many triangles in one group.
    meshes.push(grid(40, |_, _| 0.004 * rng.unit()));
    let settings = ManifoldSettings::default();
    let (mut many, mut touching) = (0, 0);
    for round in 0..2000 {
        let mesh = &meshes[round % meshes.len()];
        let (pack, pose) = if round % 2 == 0 { body(&mut rng) } else { plate(&mut rng) };
        let hull = pack.hull(0).unwrap();
        let mut manifolds = CompoundManifolds::new(256);
        let mut points = BodyManifold::new(256);
        // Twice, with a small motion: the points of the last frame are preferred.
        for frame in 0..2 {
            let shift = DVec3::from_array(rng.direction()) * 0.01 * f64::from(frame);
            let pose = Pose::new(pose.translation() + shift, pose.rotation()).unwrap();
            manifolds.update(mesh, &hull, pose, &settings);
            points.update(&manifolds);
            judge(&points, &manifolds, &format!("round {round}, frame {frame}"));
            touching += usize::from(!manifolds.is_empty());
            many += usize::from(all_points(&manifolds).len() > MAX_BODY_POINTS);
        }
    }
    println!("{touching} touching, {many} with many points");
    assert!(touching > 400 && many > 150);
}

/// A box in a corner touches three sheets.
#[test]
fn every_direction_has_points() {
    let corner = crate::meshes::mesh(
        &[DVec3::ZERO, 9.0 * DVec3::X, 9.0 * DVec3::Y, 9.0 * DVec3::Z],
        &[[0, 1, 2], [0, 2, 3], [0, 3, 1]],
    );
    let die = Cuboid::new(DVec3::splat(0.5)).unwrap();
    let at = Pose::from_translation(DVec3::new(0.499, 0.498, 0.497)).unwrap();
    let (mut manifolds, mut points) = (CompoundManifolds::new(8), BodyManifold::default());
    manifolds.update(&corner, &die, at, &ManifoldSettings::default());
    points.update(&manifolds);
    assert_eq!((manifolds.len(), points.points().len()), (3, 8));
    for (axis, count, depth) in [(DVec3::Z, 3, 0.003), (DVec3::Y, 3, 0.002), (DVec3::X, 2, 0.001)] {
        let of: Vec<_> = points.points().iter().filter(|p| p.normal.distance(axis) < 1e-9).collect();
        assert_eq!(of.len(), count, "{axis}");
        assert!(of.iter().all(|p| (p.point.depth - depth).abs() < 1e-9), "{axis}");
    }
    assert!((points.points()[0].point.depth - 0.003).abs() < 1e-9);
}

/// A box that slides over many triangles keeps its four corners, and their impulses.
#[test]
fn points_last_from_triangle_to_triangle() {
    let ground = grid(20, |_, _| 0.0);
    let die = Cuboid::new(DVec3::new(0.8, 0.6, 0.2)).unwrap();
    let (mut manifolds, mut body) = (CompoundManifolds::new(32), BodyManifold::new(32));
    let (mut triangles, steps) = (std::collections::BTreeSet::new(), 400);
    for step in 0..steps {
        let at = DVec3::new(-4.0 + 0.011 * f64::from(step), 0.37 + 0.004 * f64::from(step), 0.1995);
        manifolds.update(
            &ground,
            &die,
            Pose::new(at, DQuat::from_rotation_z(0.2)).unwrap(),
            &ManifoldSettings::default(),
        );
        body.update(&manifolds);
        let mut ids = Vec::new();
        assert_eq!(body.points().len(), 4, "step {step}");
        for point in body.points_mut() {
            triangles.insert(point.pair[0]);
            assert_eq!(point.point.age, step as u32, "step {step}: a point is new");
            // The point of a corner keeps the corner's number.
            let corner = point.point.local_b.signum().to_array().map(|sign| sign as i64);
            let id = (corner[0] + 3 * corner[1] + 20) as u64;
            assert!(step == 0 || point.point.user_data == id, "step {step}: points are exchanged");
            point.point.user_data = id;
            ids.push(id);
        }
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), 4, "step {step}");
    }
    println!("{} triangles", triangles.len());
    assert!(triangles.len() > 20);
}

/// A plate on a ridge touches it at points between the corners of its contacts. Those were left
/// out, and it sank in by half of its thickness. Planes of rest are found by trying all triangles.
#[test]
fn no_point_is_left_out_that_is_below_the_plane_of_rest() {
    println!("seed {SEED}");
    let mut rng = SplitMix64::new(SEED);
    const PREDICTION: f64 = 0.02;
    let settings = ManifoldSettings { prediction: Prediction::Length(PREDICTION), ..ManifoldSettings::default() };
    let (mut resting, mut between, mut worst) = (0, 0, 0.0_f64);
    for round in 0..500 {
        // A ridge along y, at most 4° steep, and a slight roughness.
        let slope = rng.between(0.005, 0.07);
        let ground = grid(40, |x, _| -slope * (x as f64 - 20.0).abs() + 2e-3 * rng.unit());
        let (pack, pose) = plate(&mut rng);
        let hull = pack.hull(0).unwrap();
        let (mut manifolds, mut body) = (CompoundManifolds::new(256), BodyManifold::new(256));
        // Most plates are above the ridge or deep in it.
        manifolds.update(&ground, &hull, pose, &settings);
        let deepest = all_points(&manifolds).iter().map(|p| p.point.depth).fold(f64::NEG_INFINITY, f64::max);
        if deepest == f64::NEG_INFINITY {
            continue;
        }
        let lift = DVec3::Z * (deepest - 0.8 * PREDICTION * rng.unit());
        let pose = Pose::new(pose.translation() + lift, pose.rotation()).unwrap();
        for frame in 0..3 {
            let shift = DVec3::from_array(rng.direction()) * 0.004 * f64::from(frame);
            let pose = Pose::new(pose.translation() + shift, pose.rotation()).unwrap();
            manifolds.update(&ground, &hull, pose, &settings);
            body.update(&manifolds);
            let (all, chosen) = (all_points(&manifolds), body.points());
            let Some(first) = chosen.first() else { continue };
            // Bodies at rest are not deeper. Deeper ones may need more points for the area.
            let is_shallow = all.iter().all(|p| p.point.depth <= PREDICTION);
            if !is_shallow || !all.iter().all(|p| p.normal.dot(first.normal) > SAME_NORMAL + 1e-9) {
                continue;
            }
            let (x, y) = first.normal.any_orthonormal_pair();
            let over = |p: DVec3| DVec2::new(x.dot(p), y.dot(p));
            let spot = |p: &BodyPoint| over(p.point.point_b).extend(p.point.depth);
            let (all, chosen): (Vec<_>, Vec<_>) = (all.iter().map(spot).collect(), chosen.iter().map(spot).collect());
            let center = over(pose.transform_point(hull.interior_point()));
            let Some(plane) = plane_of_rest(&all, center) else { continue };
            resting += 1;
            between += usize::from(plane.corners.iter().any(|corner| is_inside(corner.truncate(), &all)));
            let left_out = plane_of_rest(&chosen, center).map_or(f64::INFINITY, |plane| {
                all.iter().map(|spot| spot.z - plane.depth(spot.truncate())).fold(0.0, f64::max)
            });
            worst = worst.max(left_out);
            // As in the choice of four points: a twentieth of the prediction.
            assert!(left_out <= 0.05 * PREDICTION + 1e-9, "round {round}, frame {frame}: {left_out}");
        }
    }
    println!("{resting} at rest, {between} of them on points between corners; at most {worst} left out");
    assert!(resting > 200 && between > 100);
}

/// The plane of depth over places through three spots, whose z is a depth.
struct Plane {
    corners: [DVec3; 3],
    normal: DVec3,
}

impl Plane {
    fn depth(&self, at: DVec2) -> f64 {
        let [p, ..] = self.corners;
        p.z - self.normal.truncate().dot(at - p.truncate()) / self.normal.z
    }
}

/// The plane that is deepest at `center`, of all triangles of spots that contain it.
fn plane_of_rest(spots: &[DVec3], center: DVec2) -> Option<Plane> {
    let mut rest: Option<Plane> = None;
    for (i, p) in spots.iter().enumerate() {
        for (j, q) in spots.iter().enumerate().skip(i + 1) {
            for r in &spots[j + 1..] {
                let side = |a: &DVec3, b: &DVec3| (a.truncate() - center).perp_dot(b.truncate() - center);
                let sides = [side(p, q), side(q, r), side(r, p)];
                let plane = Plane { corners: [*p, *q, *r], normal: (*q - *p).cross(*r - *p) };
                let is_in = sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0);
                if is_in
                    && plane.normal.z.abs() > 1e-9
                    && rest.as_ref().is_none_or(|rest| plane.depth(center) > rest.depth(center))
                {
                    rest = Some(plane);
                }
            }
        }
    }
    rest
}

/// Whether a place is in the inside of a triangle of spots.
fn is_inside(at: DVec2, spots: &[DVec3]) -> bool {
    let all = |test: &dyn Fn(DVec2) -> bool| spots.iter().any(|spot| test(spot.truncate()));
    all(&|p| {
        all(&|q| {
            (q - p).perp_dot(at - p) > 1e-6
                && all(&|r| (r - q).perp_dot(at - q) > 1e-6 && (p - r).perp_dot(at - r) > 1e-6)
        })
    })
}
