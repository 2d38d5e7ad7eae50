//! parry3d in f64 as a second opinion on pairs of hulls, for the tests of this package. They
//! compile an engine, so they are not among the workspace's default members.

use glam::DVec3;
use hullmap::{Hull, Pose};
use parry3d_f64::{
    math::{Pose as Pose3, Rotation as Rot3},
    query,
    shape::ConvexPolyhedron,
};

/// A baked solid as parry's convex polyhedron. Panics if parry rejects the mesh.
pub fn polyhedron(hull: &Hull) -> ConvexPolyhedron {
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
pub struct Opinion {
    /// `intersection_test`.
    pub intersects: bool,
    /// Distance, or negative depth, by `contact`; `None` if parry finds no contact.
    pub signed_distance: Option<f64>,
    /// `distance`; 0 where they overlap.
    pub distance: f64,
}

/// parry's answers about `a`, and `b` at the pose `b_in_a`.
pub fn opinion(a: &ConvexPolyhedron, b: &ConvexPolyhedron, b_in_a: Pose) -> Opinion {
    let (here, there) = poses(b_in_a);
    Opinion {
        intersects: query::intersection_test(&here, a, &there, b).expect("supported").intersecting,
        signed_distance: query::contact(&here, a, &there, b, f64::MAX).expect("supported").map(|c| c.dist),
        distance: query::distance(&here, a, &there, b).expect("supported").distance,
    }
}

/// Whether they overlap according to parry.
pub fn overlap(a: &ConvexPolyhedron, b: &ConvexPolyhedron, b_in_a: Pose) -> bool {
    let (here, there) = poses(b_in_a);
    query::intersection_test(&here, a, &there, b).expect("supported").intersecting
}

/// A's pose and B's, in A's frame.
fn poses(b_in_a: Pose) -> (Pose3, Pose3) {
    let rotation = Rot3::from_array(b_in_a.rotation().to_array());
    (Pose3::from_translation(DVec3::ZERO), Pose3::from_parts(b_in_a.translation(), rotation))
}
