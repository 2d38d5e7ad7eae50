//! Features within reach of a support plane, compared with scans of all vertices and faces in f64.

use glam::DVec3;
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, Rounded, Scaled, Sphere, TILT};
use hullmap::{Feature, Hull, Pack, Shape, SupportMap};
use hullmap_testkit::{packs::tree_pack, random::RandomPoses};
use shapes::{families::Family, rng::SplitMix64, solids};

const SEED: u64 = 0x005e_ed14;

/// Merged faces are at most this fraction of the reach below the plane.
const MERGED_SHARE: f64 = 0.25;

/// A generated hull, scaled to the outer radius `size`.
fn sized(points: &[[f32; 3]], size: f64) -> Pack {
    let factor = size / tree_pack(points).hull(0).unwrap().outer_radius();
    tree_pack(&points.iter().map(|p| p.map(|c| (f64::from(c) * factor) as f32)).collect::<Vec<_>>())
}

fn vertices(hull: &Hull) -> Vec<DVec3> {
    hull.vertices().map(|v| v.as_dvec3()).collect()
}

fn feature_within(shape: &(dyn Shape + Sync), dir: DVec3, reach: f64) -> Feature {
    let mut out = Feature::new();
    shape.feature_within(dir, reach, &mut out);
    out
}

/// Area of the corners, projected along `n`.
fn area(corners: &[DVec3], n: DVec3) -> f64 {
    let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
    0.5 * pairs.map(|(p, q)| (*p - corners[0]).cross(*q - corners[0])).sum::<DVec3>().dot(n).abs()
}

/// The twin: a scan of all vertices for the support plane, and of all faces for the closest one.
struct Scan {
    normal: DVec3,
    on_face: DVec3,
    corners: Vec<DVec3>,
    /// Number of the face's corners within reach of the support plane.
    near: usize,
}

/// All faces that are closest to `n` up to rounding errors.
fn scan(hull: &Hull, n: DVec3, reach: f64) -> Vec<Scan> {
    let all = vertices(hull);
    let height = all.iter().map(|v| v.dot(n)).fold(f64::NEG_INFINITY, f64::max);
    let size = hull.outer_radius();
    let faces: Vec<(u32, f64)> = (0..hull.face_count() as u32)
        .filter(|face| hull.face(*face).any(|v| height - all[v as usize].dot(n) <= 1e-9 * size))
        .map(|face| (face, hull.face_normal(face).unwrap().dot(n)))
        .collect();
    let best = faces.iter().map(|(_, dot)| *dot).fold(f64::NEG_INFINITY, f64::max);
    let closest = faces.iter().filter(|(_, dot)| *dot >= best - 1e-9);
    let scanned = |face: &(u32, f64)| {
        let corners: Vec<DVec3> = hull.face(face.0).map(|v| all[v as usize]).collect();
        let near = corners.iter().filter(|c| height - c.dot(n) <= reach).count();
        Scan { normal: hull.face_normal(face.0).unwrap(), on_face: corners[0], corners, near }
    };
    closest.map(scanned).collect()
}

#[test]
fn features_within_reach_agree_with_a_scan() {
    println!("seed {SEED:#x}");
    let mut rng = SplitMix64::new(SEED);
    let families = [Family::Sphere, Family::Rock, Family::Prism, Family::Cone, Family::Lens, Family::CubeGrid];
    let (mut faces, mut others, mut merged, mut leaning) = (0, 0, 0, 0);
    for family in families {
        for (size, n) in [(0.01, 40), (0.1, 300), (1.0, 60), (1.0, 500)] {
            let pack = sized(&family.points(n, 1), size);
            let hull = pack.hull(0).unwrap();
            let all = vertices(&hull);
            for round in 0..200 {
                let reach = [0.0, 0.002, 0.02][round % 3];
                let mut dir = rng.unit_vector();
                if round % 2 == 0 {
                    // Close to a face.
                    let face = rng.below(hull.face_count()) as u32;
                    dir = (hull.face_normal(face).unwrap() + dir * [1e-9, 1e-3, 0.03, 0.1][round % 4]).normalize();
                }
                let found = feature_within(&hull, dir, reach);
                let label = format!("{family:?} of {n}, size {size}, {dir}, reach {reach}: {found:?}");
                assert!(found.corners().iter().all(|c| all[c.vertex as usize] == c.point), "{label}");
                let scans = scan(&hull, dir, reach);
                let is_face = |s: &Scan| s.near >= 3 || s.normal.cross(dir).length() <= TILT;
                // Ties and samples of large faces aside, the scan decides.
                let sure = scans.iter().all(|s| s.corners.len() <= 32);
                if sure && scans.iter().all(|s| !is_face(s)) {
                    let mut expected = Feature::new();
                    hull.feature(dir, &mut expected);
                    assert_eq!(found.corners(), expected.corners(), "{label}");
                    others += 1;
                } else if sure && scans.iter().all(is_face) {
                    let slack = 2e-6 * size;
                    let fits = |s: &Scan| {
                        let below = |p: DVec3| (s.on_face - p).dot(s.normal);
                        let flat = found.corners().iter().all(|c| below(c.point) <= MERGED_SHARE * reach + slack);
                        let points: Vec<DVec3> = found.corners().iter().map(|c| c.point).collect();
                        flat && area(&points, s.normal) >= 0.999 * area(&s.corners, s.normal)
                    };
                    assert!(found.corners().len() >= 3 && scans.iter().any(fits), "{label}");
                    let own = scans.iter().map(|s| s.corners.len()).max().unwrap();
                    merged += usize::from(found.corners().len() > own);
                    leaning += usize::from(scans.iter().all(|s| s.normal.cross(dir).length() > TILT));
                    faces += 1;
                }
            }
        }
    }
    println!("{faces} faces, {merged} of them merged, {leaning} beyond the tilt; {others} edges and vertices");
    assert!(faces > 1000 && merged > 200 && leaning > 200 && others > 500, "not representative");
}

#[test]
fn an_infinite_reach_finds_a_face() {
    let mut rng = SplitMix64::new(SEED + 1);
    for family in [Family::Rock, Family::Prism, Family::Cone, Family::Sphere, Family::FlatSheet] {
        let pack = tree_pack(&family.points(300, 1));
        let hull = pack.hull(0).unwrap();
        for _ in 0..500 {
            let dir = rng.unit_vector() * 7.0;
            assert!(feature_within(&hull, dir, f64::INFINITY).corners().len() >= 3, "{family:?} {dir}");
        }
        for reach in [f64::NAN, -1.0, f64::NEG_INFINITY, 0.0, f64::INFINITY] {
            for dir in [DVec3::ZERO, DVec3::splat(f64::NAN), DVec3::X] {
                let corners = feature_within(&hull, dir, reach);
                assert!(!corners.corners().is_empty(), "{family:?} {dir} {reach}");
            }
        }
    }
}

/// The tip of a cone has thousands of faces. Lying on its side, it rests on one of them.
#[test]
fn a_cone_lies_on_a_face() {
    for n in [20, 200, 5_000] {
        let base = solids::regular_polygon(n, 0.03).into_iter().map(|[x, y]| [x as f32, y as f32, -0.05]);
        let pack = tree_pack(&base.chain([[0.0, 0.0, 0.05]]).collect::<Vec<_>>());
        let hull = pack.hull(0).unwrap();
        let up = 0.03_f64.atan2(0.1);
        for i in 0..50 {
            let around = f64::from(i) * 0.13;
            for lean in [-0.05, 0.0, 0.05] {
                let (sine, cosine) = (up + lean).sin_cos();
                let dir = DVec3::new(cosine * around.cos(), cosine * around.sin(), sine);
                let found = feature_within(&hull, dir, 0.02);
                let low = found.corners().iter().map(|c| c.point.dot(dir)).fold(f64::INFINITY, f64::min);
                let height = vertices(&hull).iter().map(|v| v.dot(dir)).fold(f64::NEG_INFINITY, f64::max);
                assert!(found.corners().len() >= 3, "{n}, {i}, {lean}: {found:?}");
                assert!(found.corners().iter().any(|c| c.point.z > 0.0), "{n}, {i}, {lean}: no apex in {found:?}");
                assert!(height - low < 0.02, "{n}, {i}, {lean}: {found:?}");
            }
        }
    }
}

/// Corners of primitive shapes are within reach, or belong to a feature within the tilt.
#[test]
fn primitive_shapes_keep_their_faces_within_reach() {
    let mut rng = SplitMix64::new(SEED + 2);
    let cuboid = Cuboid::new(DVec3::new(0.05, 0.03, 0.02)).unwrap();
    let cylinder = Cylinder::new(0.05, 0.03).unwrap();
    let capsule = Capsule::new(0.05, 0.03).unwrap();
    let cone = Cone::new(0.05, 0.03).unwrap();
    let rounded = Rounded::new(cuboid, 0.01).unwrap();
    let scaled = Scaled::new(cuboid, DVec3::new(0.5, -2.0, 1.0)).unwrap();
    let ball = Sphere::new(0.05).unwrap();
    let shapes: [(&str, &(dyn Shape + Sync)); 7] = [
        ("cuboid", &cuboid),
        ("cylinder", &cylinder),
        ("capsule", &capsule),
        ("cone", &cone),
        ("rounded", &rounded),
        ("scaled", &scaled),
        ("sphere", &ball),
    ];
    for (name, shape) in shapes {
        let mut larger = 0;
        for round in 0..2_000 {
            let n = rng.unit_vector();
            let reach = [0.0, 0.005, 0.02][round % 3];
            let found = feature_within(shape, n, reach);
            let mut narrow = Feature::new();
            shape.feature(n, &mut narrow);
            // Angles of a scaled shape differ from the angles of the inner shape.
            let keeps = name == "scaled" || found.corners().len() >= narrow.corners().len();
            assert!(keeps, "{name} {n} {reach}");
            larger += usize::from(found.corners().len() > narrow.corners().len());
            let height = shape.support_point(n).point.dot(n);
            for corner in found.corners() {
                let low = height - corner.point.dot(n);
                let tilted = TILT * 2.0 * shape.outer_radius() * 1.5;
                // The fourth corner of a box's face is as low as two others together.
                assert!((-1e-12..=2.0 * reach.max(tilted) + 1e-12).contains(&low), "{name} {n} {reach}: {low}");
            }
        }
        assert!(name == "sphere" || larger > 100, "{name}: {larger}");
        for wild in [DVec3::ZERO, DVec3::splat(f64::NAN), DVec3::INFINITY] {
            for reach in [f64::NAN, f64::INFINITY, -1.0] {
                let found = feature_within(shape, wild, reach);
                assert!(found.corners().iter().all(|c| c.point.is_finite()) && !found.corners().is_empty(), "{name}");
            }
        }
    }
}

/// A prism whose sides are upright, or lean by `lean`, with random corners on a circle.
fn prism(n: usize, lean: f64, rng: &mut SplitMix64) -> Vec<[f32; 3]> {
    let mut angles: Vec<f64> = (0..n).map(|_| rng.between(0.0, std::f64::consts::TAU)).collect();
    angles.sort_by(f64::total_cmp);
    let ring = |radius: f64, z: f64| angles.iter().map(move |a| [radius * a.cos(), radius * a.sin(), z]);
    let all = ring(1.0, -0.5).chain(ring(1.0 + lean, 0.5));
    all.map(|p| p.map(|c| c as f32)).collect()
}

/// The four corners of a reduced face span the largest area, by trying all. No other feature is
/// reduced: not below five corners, and not where faces are merged.
#[test]
fn reduced_features_are_the_best_four_corners() {
    println!("seed {SEED:#x}");
    let mut rng = SplitMix64::new(SEED + 4);
    let (mut reduced, mut whole) = (0, 0);
    for n in [3, 4, 5, 6, 7, 9, 12, 20] {
        for lean in [0.0, 0.3, 0.01] {
            let pack = tree_pack(&prism(n, lean, &mut rng));
            let hull = pack.hull(0).unwrap();
            for _ in 0..40 {
                let side = rng.unit_vector() * 0.01;
                let dir = if rng.below(2) == 0 { DVec3::Z } else { DVec3::NEG_Z } + side;
                let mut found = Feature::new();
                hull.reduced_feature_within(dir, 0.02, &mut found);
                let all: Vec<DVec3> = feature_within(&hull, dir, 0.02).corners().iter().map(|c| c.point).collect();
                let corners: Vec<DVec3> = found.corners().iter().map(|c| c.point).collect();
                if !found.is_reduced() {
                    assert!(corners == all, "{n} {lean} {dir}");
                    whole += 1;
                    continue;
                }
                reduced += 1;
                assert!(all.len() > 4 && corners.len() == 4, "{n} {lean} {dir}: {corners:?}");
                assert!(corners.iter().all(|c| all.contains(c)));
                let mut best: f64 = 0.0;
                for d in 3..all.len() {
                    for c in 2..d {
                        for b in 1..c {
                            (0..b).for_each(|a| best = best.max(area(&[a, b, c, d].map(|i| all[i]), DVec3::Z)));
                        }
                    }
                }
                assert!(area(&corners, DVec3::Z) >= best * (1.0 - 1e-9), "{n} {lean} {dir}");
            }
        }
    }
    println!("{reduced} reduced, {whole} whole");
    assert!(reduced > 200 && whole > 200, "not representative");
}

/// A face alone is the feature where the surface falls away steeply, and one step less of fall
/// merges it with its neighbours: the stored fall decides as the ring of queries would.
#[test]
fn faces_are_merged_on_either_side_of_the_tilt() {
    for (lean, merges) in [(2.5 * TILT, false), (1.05 * TILT, false), (0.75 * TILT, true), (0.25 * TILT, true)] {
        for n in [4, 5, 12, 40] {
            // A low pyramid frustum around the cap: its sides fall by the tangent `lean`.
            let ring = |radius: f64, z: f64| {
                (0..n).map(move |i| {
                    let (sine, cosine) = (f64::from(i) / f64::from(n) * std::f64::consts::TAU).sin_cos();
                    [(radius * cosine) as f32, (radius * sine) as f32, z as f32]
                })
            };
            let points: Vec<[f32; 3]> = ring(1.0, 0.0).chain(ring(2.0, -lean)).chain(ring(1.5, -1.0)).collect();
            let pack = tree_pack(&points);
            let hull = pack.hull(0).unwrap();
            for reach in [f64::INFINITY, 0.5] {
                for reduced in [false, true] {
                    let mut found = Feature::new();
                    if reduced {
                        hull.reduced_feature_within(DVec3::Z, reach, &mut found);
                    } else {
                        hull.feature_within(DVec3::Z, reach, &mut found);
                    }
                    let outer = found.corners().iter().any(|c| c.point.truncate().length() > 1.1);
                    assert_eq!(outer, merges, "lean {lean}, {n} sides, reach {reach}, reduced {reduced}");
                    assert_eq!(found.is_reduced(), reduced && n > 4 && !merges);
                }
            }
        }
    }
}
