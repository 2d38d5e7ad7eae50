//! The smallest primitives around points, of each kind: boxes by the normals of faces, balls and
//! circles by steps towards the farthest point.
//!
//! # Reference
//! Bădoiu and Clarkson, "Optimal core-sets for balls", 2008: the steps. O'Rourke, "Finding minimal
//! enclosing boxes", 1985: the smallest box touches the hull along edges.
//!
//! # Deviations
//! - Boxes have a side along a large face. That finds the boxes that parts have, and is far faster.

use glam::{DMat3, DQuat, DVec2, DVec3};
use hullmap_format::PrimitiveKind;

use super::shape::Primitive;
use crate::decompose::partition::{body::Body, cuts};

const FACES: usize = 10;

/// Number of steps towards the farthest point.
const STEPS: usize = 400;

/// Cosine of the angle between axes that count as the same.
const SAME: f64 = 1.0 - 1e-9;

/// At most one primitive of each kind around a body's points, larger by `margin`.
pub fn candidates(body: &Body, margin: f64) -> Vec<Primitive> {
    if body.planes.is_empty() {
        return Vec::new();
    }
    let axes = axes(body);
    let points = &body.points;
    let boxes = axes.iter().flat_map(|first| axes.iter().filter_map(|second| boxed(points, *first, *second, margin)));
    let round = |of: fn(&[DVec3], DVec3, f64) -> Option<Primitive>| {
        smallest(axes.iter().filter_map(|axis| of(points, *axis, margin)))
    };
    let found = [smallest(boxes), Some(ball(points, margin)), round(capsule), round(cylinder)];
    found.into_iter().flatten().collect()
}

fn smallest(found: impl Iterator<Item = Primitive>) -> Option<Primitive> {
    found.min_by(|a, b| a.volume().total_cmp(&b.volume()))
}

/// Directions that a primitive may have: of large faces, principal axes, and coordinate axes.
fn axes(body: &Body) -> Vec<DVec3> {
    let mut order: Vec<usize> = (0..body.planes.len()).collect();
    order.sort_by(|a, b| body.areas[*b].total_cmp(&body.areas[*a]).then(a.cmp(b)));
    let faces = order.iter().take(FACES).map(|face| body.planes[*face].normal);
    let mut axes: Vec<DVec3> = Vec::new();
    for axis in faces.chain(cuts::principal_axes(body.triangles.iter().copied())).chain(DVec3::AXES) {
        if axis.is_finite() && axes.iter().all(|other| other.dot(axis).abs() < SAME) {
            axes.push(axis);
        }
    }
    axes
}

fn frame(axis: DVec3, other: DVec3) -> Option<DQuat> {
    let y = axis.cross(other).try_normalize()?;
    Some(DQuat::from_mat3(&DMat3::from_cols(y.cross(axis).normalize(), y, axis)).normalize())
}

fn extent(points: &[DVec3], rotation: DQuat) -> [DVec3; 2] {
    let back = rotation.inverse();
    points.iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| {
        let p = back * *p;
        [low.min(p), high.max(p)]
    })
}

fn boxed(points: &[DVec3], axis: DVec3, other: DVec3, margin: f64) -> Option<Primitive> {
    let rotation = frame(axis, other)?;
    let [low, high] = extent(points, rotation);
    let sizes = (0.5 * (high - low) + margin).to_array();
    Some(Primitive { kind: PrimitiveKind::Box, center: rotation * (0.5 * (low + high)), rotation, sizes })
}

fn ball(points: &[DVec3], margin: f64) -> Primitive {
    let [low, high] = extent(points, DQuat::IDENTITY);
    let (center, radius) = smallest_ball(points, 0.5 * (low + high));
    let sizes = [radius + margin, 0.0, 0.0];
    Primitive { kind: PrimitiveKind::Sphere, center, rotation: DQuat::IDENTITY, sizes }
}

/// The points along an axis and across it, and the centre and radius of a small circle around them.
fn around_axis(points: &[DVec3], axis: DVec3) -> Option<(DQuat, Vec<DVec3>, DVec2, f64)> {
    let rotation = frame(axis, axis.any_orthonormal_vector())?;
    let back = rotation.inverse();
    let local: Vec<DVec3> = points.iter().map(|p| back * *p).collect();
    let flat: Vec<DVec3> = local.iter().map(|p| p.truncate().extend(0.0)).collect();
    let [low, high] = extent(&flat, DQuat::IDENTITY);
    let (center, radius) = smallest_ball(&flat, 0.5 * (low + high));
    Some((rotation, local, center.truncate(), radius))
}

fn cylinder(points: &[DVec3], axis: DVec3, margin: f64) -> Option<Primitive> {
    let (rotation, local, center, radius) = around_axis(points, axis)?;
    let [low, high] = extent(&local, DQuat::IDENTITY);
    let center = rotation * center.extend(0.5 * (low.z + high.z));
    let sizes = [radius + margin, 0.5 * (high.z - low.z) + margin, 0.0];
    Some(Primitive { kind: PrimitiveKind::Cylinder, center, rotation, sizes })
}

fn capsule(points: &[DVec3], axis: DVec3, margin: f64) -> Option<Primitive> {
    let (rotation, local, center, radius) = around_axis(points, axis)?;
    let cap = |p: &DVec3| (radius * radius - (p.truncate() - center).length_squared()).max(0.0).sqrt();
    let low = local.iter().map(|p| p.z + cap(p)).fold(f64::INFINITY, f64::min);
    let high = local.iter().map(|p| p.z - cap(p)).fold(f64::NEG_INFINITY, f64::max);
    // A ball is smaller otherwise.
    let half = Some(0.5 * (high - low)).filter(|half| *half > 0.0)?;
    let center = rotation * center.extend(0.5 * (low + high));
    Some(Primitive { kind: PrimitiveKind::Capsule, center, rotation, sizes: [radius + margin, half + margin, 0.0] })
}

/// Centre and radius of a nearly smallest ball around points.
fn smallest_ball(points: &[DVec3], start: DVec3) -> (DVec3, f64) {
    let farthest = |center: DVec3| {
        let from = |p: &DVec3| p.distance_squared(center);
        points.iter().copied().max_by(|a, b| from(a).total_cmp(&from(b))).unwrap_or(center)
    };
    let mut center = start;
    let mut best = (center, f64::INFINITY);
    for step in 0..STEPS {
        let p = farthest(center);
        let radius = p.distance(center);
        if radius < best.1 {
            best = (center, radius);
        }
        center += (p - center) / (step + 2) as f64;
    }
    best
}
