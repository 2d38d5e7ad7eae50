//! Contact manifolds: their points, the area that these span, and what persists from frame to
//! frame.

use crate::any_shape::update;
use crate::solver::shapes::PointCloud;
use glam::{DQuat, DVec2, DVec3};
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, Rounded, Scaled, Sphere};
use hullmap::{Cache, Feature, Manifold, ManifoldSettings, Pack, Pose, Prediction, Shape, SupportMap};
use hullmap_testkit::{packs::tree_pack, polytope::height_over_faces};
use shapes::{families::Family, rng::SplitMix64, solids};

const SEED: u64 = 0x005e_ed06;

/// A prism around z with caps at −1 and 1.
fn prism(n: usize, radius: f64) -> Pack {
    tree_pack(&solids::extrusion(&solids::regular_polygon(n, radius), -1.0, 1.0).vertices)
}

fn pose_at(x: f64, y: f64, z: f64, rotation: DQuat) -> Pose {
    Pose::new(DVec3::new(x, y, z), rotation).unwrap()
}

fn manifold(a: &(dyn Shape + Sync), b: &(dyn Shape + Sync), pose: Pose) -> Manifold {
    let mut manifold = Manifold::new();
    update(&mut manifold, a, b, pose, &ManifoldSettings::default(), &mut Cache::new());
    manifold
}

/// `polygon` clipped by the half-planes to the left of the sides of `by`, in the obvious way. Both
/// are counter-clockwise.
fn clipped(polygon: &[DVec2], by: &[DVec2]) -> Vec<DVec2> {
    let mut polygon = polygon.to_vec();
    for (i, start) in by.iter().enumerate() {
        let along = by[(i + 1) % by.len()] - *start;
        let inside = |p: DVec2| along.perp_dot(p - *start);
        let mut kept = Vec::new();
        for (k, p) in polygon.iter().enumerate() {
            let q = polygon[(k + 1) % polygon.len()];
            let (dp, dq) = (inside(*p), inside(q));
            if dp >= 0.0 {
                kept.push(*p);
            }
            if (dp >= 0.0) != (dq >= 0.0) {
                kept.push(p.lerp(q, dp / (dp - dq)));
            }
        }
        polygon = kept;
    }
    polygon
}

/// Maximum area that four corners of a convex polygon span, from all diagonals.
fn max_area_of_four(polygon: &[DVec2]) -> f64 {
    let mut max_area: f64 = 0.0;
    for p in polygon {
        for q in polygon {
            let height = |r: &DVec2| (*q - *p).perp_dot(*r - *p);
            let left = polygon.iter().map(height).fold(0.0, f64::max);
            let right = polygon.iter().map(height).fold(0.0, f64::min);
            max_area = max_area.max(0.5 * (left - right));
        }
    }
    max_area
}

fn area_of(points: &[DVec2]) -> f64 {
    let center = points.iter().sum::<DVec2>() / points.len() as f64;
    let mut sorted = points.to_vec();
    sorted.sort_by(|p, q| (*p - center).to_angle().total_cmp(&(*q - center).to_angle()));
    0.5 * sorted.iter().zip(sorted.iter().cycle().skip(1)).map(|(p, q)| p.perp_dot(*q)).sum::<f64>()
}

/// n-gons on m-gons, moved and rotated: the points are where the faces overlap, and span nearly the
/// maximum area of four points.
#[test]
fn face_contacts_span_nearly_the_maximum_area() {
    println!("seed {SEED:#x}");
    let mut rng = SplitMix64::new(SEED);
    let (mut min_fraction, mut sum) = ([f64::INFINITY; 2], [[0.0; 2]; 2]);
    for (n, m) in [(3, 3), (4, 4), (3, 7), (4, 16), (32, 4), (64, 4), (4, 1000), (100, 100), (2000, 3), (3000, 1500)] {
        let (below, above) = (prism(n, 1.0), prism(m, 0.7));
        let (below, above) = (below.hull(0).unwrap(), above.hull(0).unwrap());
        for i in 0..60 {
            let turn = DQuat::from_rotation_z(rng.between(0.0, 6.0));
            let pose = pose_at(rng.between(-0.9, 0.9), rng.between(-0.9, 0.9), 1.99, turn);
            let outline = |n: usize, radius: f64| -> Vec<DVec2> {
                solids::regular_polygon(n, radius).into_iter().map(DVec2::from_array).collect()
            };
            let placed: Vec<DVec2> =
                outline(m, 0.7).iter().map(|p| pose.transform_point(p.extend(0.0)).truncate()).collect();
            let ground = outline(n, 1.0);
            let region = clipped(&placed, &ground);
            // Skip slivers, and nine in ten of the faces with thousands of corners, to save time.
            if region.len() < 3 || area_of(&region) < 0.05 || (region.len() > 200 && i % 10 != 0) {
                continue;
            }
            let every = region.len().div_ceil(150);
            let max_area = max_area_of_four(&region.iter().copied().step_by(every).collect::<Vec<_>>());
            for swapped in [false, true] {
                let found =
                    if swapped { manifold(&above, &below, pose.inverse()) } else { manifold(&below, &above, pose) };
                let label = format!("{n} on {m}, pose {i}, swapped {swapped}: {found:?}");
                let place = |p: DVec3| if swapped { pose.transform_point(p) } else { p };
                let flat: Vec<DVec2> = found.points().iter().map(|p| place(p.point_a).truncate()).collect();
                assert!(flat.len() >= 3, "{label}");
                for (p, flat) in found.points().iter().zip(&flat) {
                    assert!((p.depth - 0.01).abs() < 1e-6, "{label}");
                    assert!(((p.point_a - p.point_b) - found.normal() * p.depth).length() < 1e-6, "{label}");
                    // At max_area 1e-5 outside the region.
                    let beside = |outline: &[DVec2]| {
                        let next = outline.iter().cycle().skip(1);
                        let side = |(p, q): (&DVec2, &DVec2)| (*q - *p).normalize().perp_dot(*flat - *p);
                        outline.iter().zip(next).map(side).fold(f64::INFINITY, f64::min)
                    };
                    assert!(beside(&ground).min(beside(&placed)) > -1e-5, "{label}");
                }
                let fraction = area_of(&flat) / max_area;
                let class = usize::from(n.max(m) > 32);
                min_fraction[class] = min_fraction[class].min(fraction);
                sum[class] = [sum[class][0] + fraction, sum[class][1] + 1.0];
                assert!(fraction > 0.7, "{fraction} of {max_area}, {label}");
            }
        }
    }
    println!(
        "minimum fraction of the maximum area: {:.3} for small faces, {:.3} for large ones",
        min_fraction[0], min_fraction[1]
    );
    let mean = sum.map(|[sum, count]| sum / count);
    println!("mean fractions: {mean:?}");
    assert!(mean.iter().all(|mean| *mean > 0.95), "{mean:?}");
    assert!(min_fraction[0] < 1.01 && min_fraction[1] < 1.01, "the maximum area is wrong: {min_fraction:?}");
}

#[test]
fn each_pair_of_features_has_the_expected_number_of_points() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let floor = Cuboid::new(DVec3::new(5.0, 5.0, 1.0)).unwrap();
    let cube = Cuboid::new(DVec3::ONE).unwrap();
    let baked = prism(4, 2_f64.sqrt());
    let baked = baked.hull(0).unwrap();
    let edge = DQuat::from_rotation_x(0.5 * quarter);
    let vertex = DQuat::from_rotation_arc(DVec3::new(1.0, 1.0, 1.0).normalize(), DVec3::NEG_Z);
    let up = DQuat::from_rotation_z(0.5 * quarter);
    let capsule = Capsule::new(1.0, 0.5).unwrap();
    let cylinder = Cylinder::new(1.0, 0.5).unwrap();
    let cone = Cone::new(1.0, 0.5).unwrap();
    let lie = DQuat::from_rotation_x(quarter);
    // The cone lies on its side: rotated by a quarter turn plus its half angle.
    let slant = DQuat::from_rotation_x(-(quarter + 0.25_f64.atan()));
    let high = 1.0 / 17_f64.sqrt();
    let (root, third) = (2_f64.sqrt(), 3_f64.sqrt());
    let ball = Sphere::new(0.5).unwrap();
    for (name, shape, pose, count) in [
        ("face", &cube as &(dyn Shape + Sync), pose_at(0.0, 0.0, 1.99, up), 4),
        ("baked face", &baked, pose_at(0.0, 0.0, 1.99, up), 4),
        ("edge", &cube, pose_at(0.0, 0.0, 0.99 + root, edge), 2),
        (
            "baked edge",
            &baked,
            pose_at(
                0.0,
                0.0,
                0.99 + root,
                up * DQuat::from_rotation_x(0.5 * quarter) * DQuat::from_rotation_z(0.5 * quarter),
            ),
            2,
        ),
        ("vertex", &cube, pose_at(0.0, 0.0, 0.99 + third, vertex), 1),
        ("sphere", &ball, pose_at(0.0, 0.0, 1.49, up), 1),
        ("standing capsule", &capsule, pose_at(0.0, 0.0, 2.49, up), 1),
        ("lying capsule", &capsule, pose_at(0.0, 0.0, 1.49, lie), 2),
        ("standing cylinder", &cylinder, pose_at(0.0, 0.0, 1.99, up), 4),
        ("lying cylinder", &cylinder, pose_at(0.0, 0.0, 1.49, lie), 2),
        ("leaning cylinder", &cylinder, pose_at(0.0, 0.0, 0.99 + 1.5 / root, edge), 1),
        ("standing cone", &cone, pose_at(0.0, 0.0, 1.99, up), 4),
        ("cone on its tip", &cone, pose_at(0.0, 0.0, 1.99, lie * lie), 1),
        ("cone on its side", &cone, pose_at(0.0, 0.0, 0.99 + high, slant), 2),
    ] {
        for swapped in [false, true] {
            let found = if swapped { manifold(shape, &floor, pose.inverse()) } else { manifold(&floor, shape, pose) };
            assert_eq!(found.points().len(), count, "{name}, swapped {swapped}: {found:?}");
            let normal = if swapped { pose.transform_vector(-found.normal()) } else { found.normal() };
            assert!(normal.distance(DVec3::Z) < 1e-2, "{name}, {found:?}");
            let deepest = found.points().iter().map(|p| p.depth).fold(f64::NEG_INFINITY, f64::max);
            assert!((deepest - 0.01).abs() < 1e-4, "{name}: {found:?}");
        }
    }
    // Crossed edges meet in one point. Parallel capsules meet along their common length. Parallel
    // edges of solids are never the closest features, since a face is.
    let crossed = edge.inverse() * DQuat::from_rotation_z(quarter) * edge;
    let crossed = Pose::new(edge.inverse() * (DVec3::Z * (2.0 * root - 0.01)), crossed).unwrap();
    assert_eq!(manifold(&cube, &cube, crossed).points().len(), 1);
    let found = manifold(&capsule, &capsule, pose_at(0.99, 0.0, 0.5, DQuat::from_rotation_x(1e-3)));
    assert_eq!(found.points().len(), 2);
    assert!((found.points()[0].point_a.distance(found.points()[1].point_a) - 1.5).abs() < 1e-3, "{found:?}");
}

/// A cap that f32 rounding broke into slivers counts as one face, also if it is scaled or rounded.
#[test]
fn nearly_flat_caps_are_one_face() {
    let turn = DQuat::from_xyzw(0.3, -0.5, 0.2, 0.7).normalize();
    let floor = Cuboid::new(DVec3::new(5.0, 5.0, 1.0)).unwrap();
    for n in [5, 24, 500] {
        let upright = solids::extrusion(&solids::regular_polygon(n, 1.0), -1.0, 1.0).vertices;
        let turned: Vec<[f32; 3]> =
            upright.iter().map(|p| (turn * DVec3::from_array(p.map(f64::from))).as_vec3().to_array()).collect();
        let pack = tree_pack(&turned);
        let hull = pack.hull(0).unwrap();
        let cap = hull.face_towards(turn * DVec3::NEG_Z).unwrap();
        // Otherwise the cap is exactly flat, and the test is vacuous.
        assert!(hull.face(cap).len() < n, "{n}: the cap is one face of {} corners", hull.face(cap).len());
        let rounded = Rounded::new(hull, 0.25).unwrap();
        let scaled = Scaled::new(hull, DVec3::splat(0.5)).unwrap();
        for (name, shape, height, radius) in [
            ("hull", &hull as &(dyn Shape + Sync), 1.0, 1.0),
            ("rounded", &rounded, 1.25, 1.0),
            ("scaled", &scaled, 0.5, 0.5),
        ] {
            let found = manifold(&floor, shape, pose_at(0.3, 0.2, 0.99 + height, turn.inverse()));
            let flat: Vec<DVec2> = found.points().iter().map(|p| p.point_b.truncate()).collect();
            let outline: Vec<DVec2> = solids::regular_polygon(n, radius).into_iter().map(DVec2::from_array).collect();
            let max_area = max_area_of_four(&outline.iter().copied().step_by(n.div_ceil(100)).collect::<Vec<_>>());
            assert!(area_of(&flat) > 0.95 * max_area, "{name} of {n}: {found:?}");
        }
    }
}

#[test]
fn points_persist_with_their_impulses() {
    println!("seed {SEED:#x}");
    let mut rng = SplitMix64::new(SEED + 2);
    let floor = Cuboid::new(DVec3::new(5.0, 5.0, 1.0)).unwrap();
    for n in [4, 6, 12, 40, 700] {
        let pack = prism(n, 1.0);
        let hull = pack.hull(0).unwrap();
        let (mut manifold, mut cache) = (Manifold::new(), Cache::new());
        let (mut lasting, mut same, mut total) = (0, 0, 0);
        for frame in 0..200 {
            // The prism slides, turns slowly, and rocks by a few thousandths of a degree.
            let t = f64::from(frame) / 60.0;
            let mut slight = || rng.between(-1e-4, 1e-4);
            let rock = DQuat::from_scaled_axis(DVec3::new(slight(), slight(), 0.1 * t));
            let pose = pose_at(0.5 * t, 0.2 * t, 1.995, rock);
            let before: Vec<_> = manifold.points().iter().map(|p| (p.id, p.impulse, p.age)).collect();
            let contact = update(&mut manifold, &floor, &hull, pose, &ManifoldSettings::default(), &mut cache);
            assert!(contact.hit && manifold.points().len() == 4, "{manifold:?}");
            for p in manifold.points() {
                // Each frame adds one.
                assert_eq!(p.impulse, [f64::from(p.age), 0.0, 0.0], "{n}, {frame}");
                lasting += usize::from(p.age > 0);
                let old = before.iter().find(|old| old.0 == p.id);
                if let Some((_, impulse, age)) = old {
                    assert_eq!((p.impulse, p.age), (*impulse, age + 1), "{n}, {frame}");
                    same += 1;
                }
                total += usize::from(frame > 0);
                let back = pose.transform_point(p.local_b);
                assert!(back.distance(p.point_b) < 1e-12, "{p:?}");
            }
            let deepest = manifold.points().iter().map(|p| p.depth).fold(f64::NEG_INFINITY, f64::max);
            assert!((deepest - contact.depth).abs() < 3e-4, "{deepest} {contact:?}");
            manifold.points_mut().iter_mut().for_each(|p| p.impulse[0] += 1.0);
        }
        println!("prism of {n}: {lasting} of {total} points persist, {same} with the same features");
        assert!(lasting as f64 > 0.95 * f64::from(total as u32), "{n}: {lasting} of {total}");
        // On a large face with many corners, the outermost corner may alternate between neighbours.
        assert!(n > 32 || same == total, "{n}: {same} of {total}");
    }
}

/// Points appear as soon as the shapes are separated by less than the prediction, with negative
/// depths, and stay.
#[test]
fn gaps_within_the_prediction_keep_the_points() {
    let (floor, cube) = (Cuboid::new(DVec3::new(5.0, 5.0, 1.0)).unwrap(), Cuboid::new(DVec3::ONE).unwrap());
    let mut manifold = Manifold::new();
    let mut cache = Cache::new();
    let settings = ManifoldSettings::default();
    let prediction = settings.prediction.length(cube.outer_radius());
    let mut ages = Vec::new();
    for gap in [-0.01, 0.5 * prediction, -0.01, 0.99 * prediction, 1.01 * prediction, 10.0, -0.01] {
        let c =
            update(&mut manifold, &floor, &cube, pose_at(0.2, 0.1, 2.0 + gap, DQuat::IDENTITY), &settings, &mut cache);
        assert_eq!(c.hit, gap < 0.0);
        assert_eq!(manifold.points().len(), if gap <= prediction { 4 } else { 0 }, "{gap}: {manifold:?}");
        assert!(manifold.points().iter().all(|p| (p.depth + gap).abs() < 1e-9), "{gap}: {manifold:?}");
        ages.push(manifold.points().first().map(|p| p.age));
    }
    assert_eq!(ages, [Some(0), Some(1), Some(2), Some(3), None, None, Some(0)]);
    // A prediction in units holds for bodies of any size.
    let length = ManifoldSettings { prediction: Prediction::Length(0.02), ..settings };
    for (half, gap) in [0.05, 1.0, 4.0].into_iter().flat_map(|half| [(half, 0.019), (half, 0.021)]) {
        let (cube, pose) =
            (Cuboid::new(DVec3::splat(half)).unwrap(), pose_at(0.0, 0.0, 1.0 + half + gap, DQuat::IDENTITY));
        update(&mut manifold, &floor, &cube, pose, &length, &mut Cache::new());
        assert_eq!(manifold.points().len(), if gap < 0.02 { 4 } else { 0 }, "half edge {half}, gap {gap}");
    }
    let nothing = [f64::NAN, -1.0, 0.0].into_iter().flat_map(|p| [Prediction::Relative(p), Prediction::Length(p)]);
    for prediction in nothing {
        let none = ManifoldSettings { prediction, ..settings };
        update(&mut manifold, &floor, &cube, pose_at(0.0, 0.0, 2.0 + 1e-3, DQuat::IDENTITY), &none, &mut cache);
        assert!(manifold.points().is_empty());
    }
}

#[test]
fn nothing_changes_with_the_scale() {
    let points = Family::Rock.points(300, 1);
    let scales = [2_f32.powi(-20), 1.0, 2_f32.powi(20)];
    let packs = scales.map(|s| tree_pack(&points.iter().map(|p| p.map(|c| c * s)).collect::<Vec<_>>()));
    let mut rng = SplitMix64::new(SEED + 3);
    for _ in 0..100 {
        let dir = DVec3::from_array(rng.direction());
        let turn = DQuat::from_axis_angle(DVec3::from_array(rng.direction()), rng.between(0.0, 6.0));
        let all: Vec<_> = packs
            .iter()
            .zip(scales)
            .map(|(pack, scale)| {
                let hull = pack.hull(0).unwrap();
                let found = manifold(&hull, &hull, Pose::new(dir * 1.2 * f64::from(scale), turn).unwrap());
                found.points().iter().map(|p| (p.id, p.depth / f64::from(scale))).collect::<Vec<_>>()
            })
            .collect();
        assert!(all[0] == all[1] && all[1] == all[2], "{all:?}");
    }
}

/// The face found through the index agrees with a scan of all faces at the support point.
#[test]
fn faces_are_found_without_a_scan() {
    println!("seed {SEED:#x}");
    let mut rng = SplitMix64::new(SEED + 4);
    for family in
        [Family::Rock, Family::Prism, Family::Cone, Family::Sphere, Family::Lens, Family::CubeGrid, Family::FlatSheet]
    {
        let pack = tree_pack(&family.points(400, 1));
        let hull = pack.hull(0).unwrap();
        let normals: Vec<DVec3> = (0..hull.face_count() as u32).map(|f| hull.face_normal(f).unwrap()).collect();
        for (number, normal) in normals.iter().enumerate() {
            // The normal of a face finds that face or one with nearly the same normal.
            let found = hull.face_towards(*normal).unwrap();
            assert!(normals[found as usize].dot(*normal) > 1.0 - 1e-9, "{family:?}, face {number}");
            let corners: Vec<u32> = hull.face(number as u32).collect();
            let height = |v: u32| hull.vertex(v).unwrap().as_dvec3().dot(*normal);
            let top = SupportMap::support_point(&hull, *normal).point.dot(*normal);
            assert!(corners.iter().all(|v| top - height(*v) < 1e-6), "{family:?}: the normal belongs to the face");
        }
        for _ in 0..500 {
            let dir = DVec3::from_array(rng.direction());
            let found = hull.face_towards(dir).unwrap();
            let top = hull.support(dir.as_vec3()).index;
            let best = (0..hull.face_count() as u32)
                .filter(|f| hull.face(*f).any(|v| v == top))
                .map(|f| normals[f as usize].dot(dir))
                .fold(f64::NEG_INFINITY, f64::max);
            assert!(normals[found as usize].dot(dir) >= best - 1e-9, "{family:?}");
        }
        assert_eq!(hull.face_towards(DVec3::ZERO), None);
        assert_eq!(hull.face(u32::MAX).len(), 0);
        assert_eq!(hull.face_normal(hull.face_count() as u32), None);
    }
}

/// The feature of a small hull is the baked face with all its corners.
#[test]
fn a_small_face_has_all_its_corners() {
    for n in [3, 4, 7, 20, 32, 33, 1000] {
        let pack = prism(n, 1.0);
        let hull = pack.hull(0).unwrap();
        let mut feature = Feature::new();
        for tilt in [0.0, 1e-3] {
            hull.feature(DVec3::new(tilt, 0.0, 1.0), &mut feature);
            assert_eq!(feature.corners().len(), n.min(32), "{n}");
            assert!(feature.corners().iter().all(|c| c.point.z == 1.0));
        }
        // On a rim of a thousand vertices several are within the tilt tolerance of the direction.
        hull.feature(DVec3::new(1.0, 0.0, 1.0), &mut feature);
        assert!(n > 100 || feature.corners().len() <= 2, "{n}: {:?}", feature.corners());
    }
}

/// Shapes without volume and shapes without features rest stably too.
#[test]
fn flat_thin_and_featureless_shapes_have_manifolds() {
    let floor = Cuboid::new(DVec3::new(5.0, 5.0, 1.0)).unwrap();
    let sheet = tree_pack(&[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 1.5, 0.0]]);
    let stick = tree_pack(&[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    let dot = tree_pack(&[[0.0, 0.0, 0.0]]);
    let [sheet, stick, dot] = [&sheet, &stick, &dot].map(|pack| pack.hull(0).unwrap());
    assert_eq!([sheet.rank(), stick.rank(), dot.rank()], [2, 1, 0]);
    let cloud = PointCloud::new(
        Family::ClusteredEllipsoid
            .points(500, 1)
            .iter()
            .map(|p| DVec3::from_array(p.map(f64::from)).with_z(f64::from(p[2]).max(0.0)))
            .collect(),
    );
    let edge = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    for (name, shape, pose, count) in [
        ("sheet", &sheet as &(dyn Shape + Sync), pose_at(0.0, 0.0, 0.99, DQuat::IDENTITY), 4),
        ("sheet on its edge", &sheet, pose_at(0.0, 0.0, 1.99, edge), 2),
        ("stick", &stick, pose_at(0.0, 0.0, 0.99, DQuat::IDENTITY), 2),
        ("stick on its end", &stick, pose_at(0.0, 0.0, 1.99, DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2)), 1),
        ("dot", &dot, pose_at(0.0, 0.0, 0.99, DQuat::IDENTITY), 1),
        ("cloud", &cloud, pose_at(0.0, 0.0, 0.99, DQuat::IDENTITY), 4),
    ] {
        for swapped in [false, true] {
            let found = if swapped { manifold(shape, &floor, pose.inverse()) } else { manifold(&floor, shape, pose) };
            assert_eq!(found.points().len(), count, "{name}, swapped {swapped}: {found:?}");
            let deepest = found.points().iter().map(|p| p.depth).fold(f64::NEG_INFINITY, f64::max);
            assert!((deepest - 0.01).abs() < 1e-6, "{name}: {found:?}");
        }
    }
    // The sheet hangs over the edge of the floor, which supports only a part of it.
    let found = manifold(&floor, &sheet, pose_at(5.5, 0.0, 0.99, DQuat::IDENTITY));
    assert!(found.points().iter().all(|p| p.point_a.x <= 5.0 + 1e-5) && found.points().len() == 4, "{found:?}");
    let reach = found.points().iter().map(|p| p.point_a.x).fold(f64::NEG_INFINITY, f64::max);
    assert!((reach - 5.0).abs() < 1e-5);
}

/// Wedges lie on each other, tip over tip. Clipping has a slack at each side, and a point within it
/// of both sides of a sharp corner may be far beyond the corner.
#[test]
fn points_are_not_beyond_sharp_corners() {
    println!("seed {SEED:#x}");
    let mut rng = SplitMix64::new(SEED);
    let wedge = |half_width: f64| {
        let outline = [[0.0, 0.0], [1.0, -half_width], [1.0, half_width]];
        tree_pack(&solids::extrusion(&outline, -0.1, 0.1).vertices)
    };
    let packs = [wedge(0.002), wedge(0.01), wedge(0.3)];
    let mut points = 0;
    for round in 0..3_000 {
        let [a, b] = [round % 3, round / 3 % 3].map(|i| packs[i].hull(0).unwrap());
        let apart = [1e-7, 1e-6, 1e-5, 1e-3][rng.below(4)];
        let [x, y] = [0, 1].map(|_| rng.between(-apart, apart));
        let pose = pose_at(x, y, 0.1999, DQuat::from_rotation_z(rng.between(0.0, 6.3)));
        for p in manifold(&a, &b, pose).points() {
            let off = [height_over_faces(&a, p.point_a), height_over_faces(&b, p.local_b)];
            assert!(off.iter().all(|off| off.abs() <= 2e-6), "{round}, {pose:?}: {off:?}, {p:?}");
            points += 1;
        }
    }
    assert!(points > 3_000, "{points}");
}
