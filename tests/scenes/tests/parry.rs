//! parry3d in f64 as a second opinion: on `bake query` of real meshes, a thousand poses in one
//! process, and on the vertices of hulls.

use std::{fmt::Write, path::Path};

use glam::{DQuat, DVec3};
use hullmap::{Hull, Pack, Pose};
use hullmap_bake::{PointSet, hull};
use hullmap_outside::{command::bake, files};
use parry3d_f64::{
    math::{Pose as Pose3, Rotation as Rot3},
    query,
    shape::ConvexPolyhedron,
};
use shapes::{families::Family, rng::SplitMix64};

const SEED: u64 = 1_000;
const POSES: usize = 1_000;

/// Depth or distance, relative to the sum of the diameters, below which the two may disagree on
/// intersection.
const UNSURE: f64 = 1e-4;

/// Error of parry, relative to the sum of the diameters.
const PARRY_ERROR: f64 = 3e-3;

#[test]
fn teapot_against_cornell_box_agrees_with_parry() {
    agrees_with_parry(&files::workspace().join("tests/meshes"), "vhacd_teapot", "tinyobj_cornell_box");
}

#[test]
fn bunny_against_koala_agrees_with_parry() {
    let Some(meshes) = files::path("HULLMAP_MESHES", "bunny_against_koala_agrees_with_parry") else { return };
    agrees_with_parry(&meshes, "stanford_bunny", "odedstein_koala");
}

/// Queries the hulls of two meshes, the second far larger than the first.
fn agrees_with_parry(meshes: &Path, small: &str, large: &str) {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let packs = [small, large].map(|name| {
        let mesh = meshes.join(name).with_extension("obj");
        bake(["build", mesh.to_str().unwrap(), "--out", &path("")]).expect(0);
        path(&format!("{name}.hullmap"))
    });
    let [pack_a, pack_b] = packs.each_ref().map(|pack| Pack::open(pack).unwrap());
    let (a, b) = (pack_a.hull(0).unwrap(), pack_b.hull(0).unwrap());
    let size = a.diameter() + b.diameter();

    let mut rng = SplitMix64::new(SEED);
    let mut poses = Vec::new();
    let mut text = format!("# {small} against {large}\n");
    for _ in 0..POSES {
        let rotation = DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize();
        // The second is at least fifty times as large: about half of the offsets are in it.
        let offset = DVec3::from_array(rng.direction()) * (rng.between(0.1, 0.55) * b.diameter());
        let pose = Pose::new(a.centroid() - rotation * b.centroid() + offset, rotation).unwrap();
        let (t, q) = (pose.translation(), pose.rotation());
        writeln!(text, "{} {} {} {} {} {} {}", t.x, t.y, t.z, q.x, q.y, q.z, q.w).unwrap();
        poses.push(pose);
    }
    std::fs::write(path("poses.txt"), text).unwrap();

    let query = |mode: &str| {
        let run =
            bake(["query", &packs[0], &packs[1], "--poses", &path("poses.txt"), "--mode", mode, "--json"]).expect(0);
        let answers = run.json();
        assert_eq!(answers.len(), POSES);
        answers
    };
    let (hits, contacts, distances) = (query("intersect"), query("contact"), query("distance"));
    let (parry_a, parry_b) = (polyhedron(&a), polyhedron(&b));
    let (mut overlapping, mut unsure, mut worst) = (0, 0, 0.0_f64);
    for (index, pose) in poses.into_iter().enumerate() {
        let truth = opinion(&parry_a, &parry_b, pose);
        let signed = truth.signed_distance.unwrap_or(truth.distance);
        overlapping += usize::from(truth.intersects);
        if signed.abs() <= UNSURE * size {
            unsure += 1;
            continue;
        }
        let what = format!("pose {index}, seed {SEED}: {truth:?}");
        assert_eq!(hits[index]["hit"], truth.intersects, "{what}");
        assert_eq!(contacts[index]["hit"], truth.intersects, "{what}");
        assert_eq!(distances[index]["hit"], truth.intersects, "{what}");
        let difference = if truth.intersects {
            // parry may stop at a face that is not the nearest, so its depth may be larger than
            // ours, never smaller.
            contacts[index]["depth"].as_f64().unwrap() + signed
        } else {
            (distances[index]["distance"].as_f64().unwrap() - truth.distance).abs()
        };
        assert!(difference <= PARRY_ERROR * size, "{what}: {}", contacts[index]);
        worst = worst.max(difference / size);
    }
    println!(
        "{POSES} poses, {overlapping} overlap, {unsure} too close to call, worst difference {worst:.1e} of the size"
    );
    assert!((300..=700).contains(&overlapping), "the sample is one-sided: {overlapping}");
    assert!(unsure < POSES / 20);
}

/// Families whose points are either inside or extreme by more than parry's tolerances.
#[test]
fn parry_finds_the_same_hull_vertices() {
    for family in [Family::Sphere, Family::Ball, Family::Rock, Family::Prism, Family::Cone, Family::Lens] {
        let positions = family.points(400, 8);
        let points: Vec<DVec3> = positions.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
        let source_vertices = (0..positions.len() as u32).collect();
        let set = PointSet { positions, source_vertices, ..PointSet::default() };
        let bits = |p: DVec3| p.to_array().map(|c| (c + 0.0).to_bits());
        let mut ours: Vec<_> = hull::build(&set).unwrap().positions().into_iter().map(bits).collect();
        let (theirs, _) = parry3d_f64::transformation::try_convex_hull(&points).expect("parry builds a hull");
        let mut theirs: Vec<_> = theirs.into_iter().map(bits).collect();
        ours.sort_unstable();
        theirs.sort_unstable();
        assert!(ours.len() > 40);
        assert_eq!(ours, theirs, "{}", family.name());
    }
}

/// A baked solid as parry's convex polyhedron. Panics if parry rejects the mesh.
fn polyhedron(hull: &Hull) -> ConvexPolyhedron {
    let points: Vec<_> = hull.vertices().map(|v| v.as_dvec3()).collect();
    let mut triangles = Vec::new();
    for face in hull.faces() {
        let corners: Vec<u32> = face.collect();
        triangles.extend(corners[1..].windows(2).map(|w| [corners[0], w[0], w[1]]));
    }
    ConvexPolyhedron::from_convex_mesh(points, &triangles).expect("parry takes a certified convex mesh")
}

/// parry's answers about a pair.
#[derive(Clone, Copy, Debug)]
struct Opinion {
    /// `intersection_test`.
    intersects: bool,
    /// Distance, or negative depth, by `contact`; `None` if parry finds no contact.
    signed_distance: Option<f64>,
    /// `distance`; 0 where they overlap.
    distance: f64,
}

/// parry's answers about `a`, and `b` at the pose `b_in_a`.
fn opinion(a: &ConvexPolyhedron, b: &ConvexPolyhedron, b_in_a: Pose) -> Opinion {
    let (here, there) = poses(b_in_a);
    Opinion {
        intersects: query::intersection_test(&here, a, &there, b).expect("supported").intersecting,
        signed_distance: query::contact(&here, a, &there, b, f64::MAX).expect("supported").map(|c| c.dist),
        distance: query::distance(&here, a, &there, b).expect("supported").distance,
    }
}

/// A's pose and B's, in A's frame.
fn poses(b_in_a: Pose) -> (Pose3, Pose3) {
    let rotation = Rot3::from_array(b_in_a.rotation().to_array());
    (Pose3::from_translation(DVec3::ZERO), Pose3::from_parts(b_in_a.translation(), rotation))
}
