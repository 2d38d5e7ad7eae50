//! Pairs of any kind, as the browser queries them: the bits of pairs of known types. Here, because
//! this crate compiles the queries of all pairs.

use super::meshes::mesh_file;
use super::*;
use hullmap::geometry::{AnyGeometry, AnyPair, AnyShape};
use hullmap::{
    Cache as Memory, CastSettings, CompoundManifolds, ManifoldSettings, Motion, MotionSettings, Pose, Ray, RigidMotion,
    Settings, TriangleMesh,
};

macro_rules! any {
    ($a:expr, $b:expr, |$one:ident, $other:ident| $query:expr) => {
        match AnyPair::new($a, $b) {
            AnyPair::Shapes($one, $other) => $query,
            AnyPair::Parts($one, $other) => $query,
        }
    };
}

#[test]
fn pairs_of_any_kind_have_the_same_bits() {
    let mut all = all_twins(&twin_pack(&file()));
    all.push(Arc::new(TriangleMesh::from_bytes(&mesh_file(3)).unwrap()).into());
    let mut rng = SplitMix64::new(7);
    let (mut hits, mut queries) = (0, 0);
    let pairs = all.iter().flat_map(|a| all.iter().map(move |b| (a, b)));
    for (a, b) in pairs.filter(|(a, b)| a.check_pair(b).is_ok()) {
        for _ in 0..4 {
            let ((pose, _), (end, _)) = (random_pose(&mut rng, 1.2), random_pose(&mut rng, 2.0));
            let (settings, memory) = (Settings::default(), Memory::new);
            let found = any!(a, b, |a, b| hullmap::contact(&a, &b, pose, &settings, &mut memory()));
            same(&found, &hullmap::contact(a, b, pose, &settings, &mut memory()));
            hits += u32::from(found.hit);
            queries += 1;
            let found = any!(a, b, |a, b| hullmap::distance(&a, &b, pose, &settings, &mut memory()));
            same(&found, &hullmap::distance(a, b, pose, &settings, &mut memory()));
            let found = any!(a, b, |a, b| hullmap::intersects(&a, &b, pose, &mut memory()));
            same(&found, &hullmap::intersects(a, b, pose, &mut memory()));

            let (motion, settings) = (Motion::new(end.translation()).unwrap(), CastSettings::default());
            let found = any!(a, b, |a, b| hullmap::cast(&a, &b, pose, motion, &settings, &mut memory()));
            same(&found, &hullmap::cast(a, b, pose, motion, &settings, &mut memory()));
            let (still, by) = (RigidMotion::still(Pose::IDENTITY), RigidMotion::between(pose, end).unwrap());
            let settings = MotionSettings::default();
            let found = any!(a, b, |a, b| hullmap::cast_motion(&a, &still, &b, &by, &settings, &mut memory()));
            same(&found, &hullmap::cast_motion(a, &still, b, &by, &settings, &mut memory()));

            let [mut found, mut expected] = [(); 2].map(|()| CompoundManifolds::new(64));
            let settings = ManifoldSettings::default();
            any!(a, b, |a, b| found.update(&a, &b, pose, &settings));
            expected.update(a, b, pose, &settings);
            let points = |all: &CompoundManifolds| {
                all.iter().map(|(parts, manifold)| format!("{parts:?} {:?}", manifold.points())).collect::<Vec<_>>()
            };
            assert_eq!(points(&found), points(&expected));
        }
    }
    assert!(hits * 5 > queries && hits * 5 < queries * 4, "{hits} of {queries} pairs overlap");
    for geometry in &all {
        for _ in 0..20 {
            let ((from, _), (to, _)) = (random_pose(&mut rng, 4.0), random_pose(&mut rng, 0.7));
            let ray = Ray::new(from.translation(), to.translation() - from.translation()).unwrap();
            let settings = CastSettings::default();
            let found = match AnyShape::new(geometry) {
                Some(shape) => hullmap::ray(&shape, &ray, &settings),
                None => hullmap::ray(&AnyGeometry::new(geometry), &ray, &settings),
            };
            same(&found, &hullmap::ray(geometry, &ray, &settings));
        }
    }
}
