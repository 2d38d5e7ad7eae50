//! Manifolds of a convex body that is cut into parts, compared with the manifolds of the whole
//! body, which are the truth: the same contacts, and no normal that the whole does not have.

use glam::{DQuat, DVec3};
use hullmap::compound::CompoundManifolds;
use hullmap::manifold::Prediction;
use hullmap::{Cache, Compound, Hull, Manifold, ManifoldSettings, Pack, Pose};
use hullmap_testkit::packs::{self, point_set, tree_pack};
use hullmap_testkit::polytope::{Plane, cut, vertices};
use shapes::{families::Family, rng::SplitMix64};

const SEED: u64 = 0x5ea3;

/// Prediction of the tests; the bodies have a size of 1.
const PREDICTION: f64 = 0.02;

fn pack(parts: &[Vec<DVec3>]) -> Pack {
    let set =
        |points: &Vec<DVec3>| point_set("part", &points.iter().map(|p| p.as_vec3().to_array()).collect::<Vec<_>>());
    packs::parts(&parts.iter().map(set).collect::<Vec<_>>())
}

/// A solid as planes: a box, or a polytope of random planes.
fn solid(rng: &mut SplitMix64, is_box: bool) -> Vec<Plane> {
    let mut planes: Vec<Plane> = DVec3::AXES.into_iter().flat_map(|axis| [(axis, 1.0), (-axis, 1.0)]).collect();
    let more = if is_box { 0 } else { 8 };
    planes.extend((0..more).map(|_| (DVec3::from_array(rng.direction()), rng.between(0.8, 1.1))));
    planes
}

fn bodies() -> Vec<Pack> {
    let scaled = |family: Family, n: usize| {
        tree_pack(&family.points(n, 1).iter().map(|p| p.map(|c| c * 0.4)).collect::<Vec<_>>())
    };
    vec![scaled(Family::Rock, 40), scaled(Family::Prism, 12), scaled(Family::Sphere, 300), scaled(Family::CubeGrid, 27)]
}

fn settings() -> ManifoldSettings {
    ManifoldSettings { prediction: Prediction::Length(PREDICTION), ..ManifoldSettings::default() }
}

/// A pose in which the body touches the solid: from a random direction, to a random depth.
fn touching(whole: &Hull<'_>, body: &Hull<'_>, depth: f64, rng: &mut SplitMix64) -> Pose {
    let rotation = DQuat::from_axis_angle(DVec3::from_array(rng.direction()), rng.between(0.0, 6.0));
    let mut at = DVec3::from_array(rng.direction()) * 4.0;
    let mut cache = Cache::new();
    // Towards the solid until the gap is closed, then out along the normal of the contact.
    for _ in 0..20 {
        let pose = Pose::new(at, rotation).unwrap();
        let gap = hullmap::distance(whole, body, pose, &settings().contact, &mut cache);
        at -= gap.normal * (gap.distance + if gap.distance > 0.0 { depth } else { 0.0 });
        if gap.distance == 0.0 {
            break;
        }
    }
    Pose::new(at, rotation).unwrap()
}

/// Deepest point and the sine of the worst normal of some manifolds.
fn worst<'m>(manifolds: impl Iterator<Item = &'m Manifold>, whole: &Hull<'_>) -> (f64, f64) {
    let (mut depth, mut angle) = (f64::NEG_INFINITY, 0.0_f64);
    for manifold in manifolds {
        for p in manifold.points() {
            depth = depth.max(p.depth);
            // The normal cone of the whole at the point of the contact: the normal is in it if no
            // vertex is above the plane. A vertex at a distance is above it by the sine of an
            // angle.
            let above = whole.vertices().map(|v| {
                let across = v.as_dvec3() - p.point_a;
                across.dot(manifold.normal()) / across.length().max(0.2)
            });
            angle = angle.max(above.fold(0.0, f64::max));
        }
    }
    (depth, angle)
}

#[test]
fn the_parts_of_a_convex_body_have_the_contacts_of_the_whole() {
    let mut rng = SplitMix64::new(SEED);
    let (mut tried, mut unwelded_wrong, mut missing, mut wrong) = (0, 0, 0, 0);
    let mut largest = 0.0_f64;
    for round in 0..24 {
        let planes = solid(&mut rng, round % 3 == 0);
        let whole = pack(&[vertices(&planes)]);
        let grow = [0.0, 0.05, -1e-6][round / 3 % 3];
        let parts = pack(&cut(&planes, 12, grow, || DVec3::from_array(rng.direction())));
        let (hull, union) = (whole.hull(0).unwrap(), Compound::new(&parts));
        for body in bodies() {
            let body = body.hull(0).unwrap();
            for _ in 0..40 {
                let depth = rng.between(-0.4, 1.0) * PREDICTION;
                let pose = touching(&hull, &body, depth, &mut rng);
                let mut reference = Manifold::new();
                let truth = reference.update(&hull, &body, pose, &settings(), &mut Cache::new());
                let deepest = reference.points().iter().map(|p| p.depth).fold(f64::NEG_INFINITY, f64::max);
                let mut manifolds = CompoundManifolds::new(64);
                manifolds.update(&union, &body, pose, &settings());
                let (found, angle) = worst(manifolds.iter().map(|(_, m)| m), &hull);
                // Points beside the contact, on which the body would tip, are on faces that lean:
                // the normal is off there, for the whole body as well.
                let own = worst([&reference].into_iter(), &hull).1;
                tried += 1;
                largest = largest.max(angle - own);
                wrong += usize::from(angle > own + 0.02);
                // A contact that is on the edge of the prediction may be on either side of it.
                if deepest > -0.8 * PREDICTION && !(found > deepest - 0.3 * PREDICTION) {
                    missing += 1;
                    println!("missing: round {round}, depth {deepest}, found {found}, normal {}", truth.normal);
                }
                manifolds.clear();
                manifolds.set_welding(false);
                manifolds.update(&union, &body, pose, &settings());
                unwelded_wrong += usize::from(worst(manifolds.iter().map(|(_, m)| m), &hull).1 > own + 0.02);
            }
        }
    }
    println!("{tried} poses: {wrong} with wrong normals, worst sine {largest:.3}; {missing} without the contact");
    println!("without welding: {unwelded_wrong} with wrong normals");
    assert!(unwelded_wrong * 8 > tried, "{unwelded_wrong} of {tried}: the poses do not meet seams");
    assert_eq!(missing, 0, "of {tried}, seed {SEED:#x}");
    assert!(wrong * 40 <= tried && largest < 0.2, "{wrong} of {tried}, seed {SEED:#x}");
}

/// The corners of a box.
fn block(low: [f64; 3], high: [f64; 3]) -> Vec<DVec3> {
    let pick = |i: usize, k: usize| if i >> k & 1 == 0 { low[k] } else { high[k] };
    (0..8).map(|i| DVec3::new(pick(i, 0), pick(i, 1), pick(i, 2))).collect()
}

/// All points of the manifolds of `body` at a position: normal, point and depth.
fn points(union: &Pack, body: &Pack, at: DVec3) -> Vec<(DVec3, DVec3, f64)> {
    let mut manifolds = CompoundManifolds::new(64);
    let (union, body) = (Compound::new(union), Compound::new(body));
    manifolds.update(&union, &body, Pose::from_translation(at).unwrap(), &settings());
    let each = manifolds.iter().flat_map(|(_, m)| m.points().iter().map(|p| (m.normal(), p.point_a, p.depth)));
    each.collect()
}

/// Four tiles of 1 m, whose tops are z = 0, around the origin.
fn tiles() -> Vec<Vec<DVec3>> {
    let tile = |x: f64, y: f64| block([x, y, -1.0], [x + 1.0, y + 1.0, 0.0]);
    vec![tile(-1.0, -1.0), tile(0.0, -1.0), tile(-1.0, 0.0), tile(0.0, 0.0)]
}

#[test]
fn a_box_on_four_tiles_has_upright_contacts_over_its_whole_bottom() {
    let (floor, die) = (pack(&tiles()), pack(&[block([-0.3; 3], [0.3; 3])]));
    // The second one is over two of the tiles by half of its depth.
    for at in [[0.0, 0.0, 0.299], [-0.2995, -0.2995, 0.299], [0.25, -0.1, 0.29]] {
        let found = points(&floor, &die, DVec3::from_array(at));
        assert!(found.iter().all(|(normal, _, depth)| normal.z > 0.999_999 && *depth > 0.0), "{at:?}: {found:?}");
        for (x, y) in [(-0.3, -0.3), (0.3, -0.3), (-0.3, 0.3), (0.3, 0.3)] {
            let corner = DVec3::new(at[0] + x, at[1] + y, 0.0);
            let nearest = found.iter().map(|(_, p, _)| p.distance(corner)).fold(f64::INFINITY, f64::min);
            assert!(nearest < 0.012, "{at:?}: no point at {corner}: {found:?}");
        }
    }
}

/// Its tip is nearest to the internal faces of all four tiles.
#[test]
fn the_tip_of_a_needle_on_a_seam_is_held() {
    let mut needle = vec![DVec3::ZERO];
    needle.extend(block([-0.02, -0.02, 0.5], [0.02, 0.02, 1.0]));
    let (floor, needle) = (pack(&tiles()), pack(&[needle]));
    for (x, y) in [(0.0, 0.0), (1e-5, -2e-5), (0.0, 0.3), (1e-4, 0.3), (-0.4, 0.0)] {
        for depth in [0.001, 0.005, 0.015] {
            let found = points(&floor, &needle, DVec3::new(x, y, -depth));
            let holds = |(normal, _, found): &&(DVec3, DVec3, f64)| normal.z > 0.999 && *found > 0.9 * depth;
            assert!(found.iter().any(|p| holds(&p)), "{x}, {y}, {depth}: {found:?}");
            assert!(found.iter().all(|(normal, _, _)| normal.z > 0.999), "{x}, {y}, {depth}: {found:?}");
        }
    }
}

#[test]
fn a_concave_corner_keeps_the_contacts_of_both_sides() {
    // A wall on top of the floor, and one that stands beside it.
    let walls = [block([0.5, -1.0, 0.0], [1.0, 1.0, 1.0]), block([1.0, -1.0, -1.0], [2.0, 1.0, 1.0])];
    let die = pack(&[block([-0.3; 3], [0.3; 3])]);
    for (wall, face) in walls.into_iter().zip([0.5, 1.0]) {
        let corner = pack(&tiles().into_iter().chain([wall]).collect::<Vec<_>>());
        let found = points(&corner, &die, DVec3::new(face - 0.299, 0.1, 0.298));
        let count = |axis: DVec3| found.iter().filter(|(normal, _, _)| normal.dot(axis) > 0.999_999).count();
        assert!(count(DVec3::Z) >= 4 && count(DVec3::NEG_X) >= 2, "{found:?}");
        assert_eq!(count(DVec3::Z) + count(DVec3::NEG_X), found.len(), "{found:?}");
        // Also below the wall.
        assert!(found.iter().any(|(normal, p, _)| normal.z > 0.9 && p.x > face - 0.01), "{found:?}");
    }
}

#[test]
fn a_step_is_felt_if_it_is_higher_than_a_seam_is_wide() {
    let die = pack(&[block([-0.3; 3], [0.3; 3])]);
    let floor =
        |rise: f64| pack(&[block([-1.0, -1.0, -1.0], [0.0, 1.0, 0.0]), block([0.0, -1.0, -1.0], [1.0, 1.0, rise])]);
    let is_felt = |rise: f64| {
        points(&floor(rise), &die, DVec3::new(-0.2998, 0.0, 0.2995)).iter().any(|(normal, _, _)| normal.x < -0.9)
    };
    assert!(!is_felt(0.0) && !is_felt(1e-6) && !is_felt(5e-5));
    assert!(is_felt(0.002) && is_felt(0.2));
}

/// Far from the origin, where coordinates in f32 are rounded by 30 µm, and without a prediction.
#[test]
fn rounded_coordinates_and_no_prediction() {
    let moved = |parts: Vec<Vec<DVec3>>, by: DVec3| -> Vec<Vec<DVec3>> {
        parts.into_iter().map(|part| part.into_iter().map(|p| p * 1.000_003 + by).collect()).collect()
    };
    let far = DVec3::new(700.1, -900.3, 0.0);
    let (floor, die) = (pack(&moved(tiles(), far)), pack(&[block([-0.3; 3], [0.3; 3])]));
    let mut rng = SplitMix64::new(SEED);
    for prediction in [0.0, 1e-6, 0.02] {
        let settings = ManifoldSettings { prediction: Prediction::Length(prediction), ..ManifoldSettings::default() };
        for _ in 0..100 {
            let at = far + DVec3::new(rng.between(-0.6, 0.6), rng.between(-0.6, 0.6), 0.2999);
            let mut manifolds = CompoundManifolds::new(8);
            let pose = Pose::from_translation(at).unwrap();
            manifolds.update(&Compound::new(&floor), &Compound::new(&die), pose, &settings);
            let found: Vec<_> = manifolds.iter().map(|(_, m)| (m.normal(), m.points().len())).collect();
            assert!(!found.is_empty() && found.iter().all(|(n, _)| n.z > 0.999), "{prediction}, {at}: {found:?}");
        }
    }
}

/// As the moving body, a compound has the same contacts as the whole.
#[test]
fn a_compound_on_a_plate_and_on_tiles() {
    let legs = [[-0.3, -0.3], [0.25, -0.3], [-0.3, 0.25], [0.25, 0.25]];
    let mut parts: Vec<_> = legs.iter().map(|[x, y]| block([*x, *y, 0.0], [x + 0.05, y + 0.05, 0.5])).collect();
    parts.push(block([-0.3, -0.3, 0.5], [0.3, 0.3, 0.55]));
    let (table, plate, floor) = (pack(&parts), pack(&[block([-1.0, -1.0, -1.0], [1.0, 1.0, 0.0])]), pack(&tiles()));
    let mut rng = SplitMix64::new(SEED);
    for _ in 0..200 {
        let at = DVec3::new(rng.between(-0.6, 0.6), rng.between(-0.6, 0.6), -rng.between(1e-4, 0.003));
        for below in [&plate, &floor] {
            let found = points(below, &table, at);
            assert!(found.iter().all(|(normal, _, _)| normal.z > 0.999_999), "{at}: {found:?}");
            for [x, y] in legs {
                let leg = at + DVec3::new(x + 0.025, y + 0.025, 0.0);
                assert!(found.iter().any(|(_, p, _)| p.distance(leg) < 0.06), "{at}: no point at {leg}: {found:?}");
            }
        }
    }
}

/// Whatever the union: if the body overlaps it, something pushes it out.
#[test]
fn a_body_that_overlaps_a_union_has_a_contact() {
    let mut rng = SplitMix64::new(SEED);
    let (mut overlapping, mut welded) = (0, 0);
    for round in 0..12 {
        let rocks: Vec<Vec<DVec3>> = (0..12)
            .map(|i| {
                let place = DVec3::from_array(rng.direction()) * rng.between(0.2, 0.8);
                let point = |p: &[f32; 3]| DVec3::new(p[0].into(), p[1].into(), p[2].into()) * 0.4 + place;
                Family::Rock.points(24, round * 16 + i).iter().map(point).collect()
            })
            .collect();
        let union = pack(&rocks);
        let whole = Compound::new(&union);
        for body in bodies() {
            let body = Compound::new(&body);
            for _ in 0..400 {
                let rotation = DQuat::from_axis_angle(DVec3::from_array(rng.direction()), rng.between(0.0, 6.0));
                let at = DVec3::from_array(rng.direction()) * rng.between(0.9, 1.7);
                let pose = Pose::new(at, rotation).unwrap();
                let mut manifolds = CompoundManifolds::new(64);
                manifolds.set_welding(false);
                manifolds.update(&whole, &body, pose, &settings());
                let each = manifolds.iter().flat_map(|(_, m)| m.points());
                let deepest = each.map(|p| p.depth).fold(0.0, f64::max);
                if !(deepest > 0.001 && deepest < 0.1) {
                    continue;
                }
                overlapping += 1;
                let before: Vec<_> = manifolds.iter().map(|(pair, m)| (pair, m.normal())).collect();
                let mut manifolds = CompoundManifolds::new(64);
                manifolds.update(&whole, &body, pose, &settings());
                let after: Vec<_> = manifolds.iter().map(|(pair, m)| (pair, m.normal())).collect();
                welded += usize::from(before != after);
                let each = manifolds.iter().flat_map(|(_, m)| m.points());
                let found = each.map(|p| p.depth).fold(0.0, f64::max);
                assert!(found > 0.0, "round {round}: {deepest} deep without a contact; seed {SEED:#x}");
            }
        }
    }
    println!("{overlapping} overlap, {welded} of them corrected");
    assert!(overlapping > 1_000 && welded > 40, "{welded} of {overlapping}");
}
