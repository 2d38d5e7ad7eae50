//! The pose of a pair: most pairs nearly touch, where solvers fail.
//!
//! The touching position of B follows from a support point of each shape, without a search. From
//! there B is not moved, or moved by one unit in the last place of a coordinate, or in or out by
//! 1e-16 to 1e-3 of its size.

use glam::{DQuat, DVec3};
use hullmap::Pose;
use hullmap_testkit::random::RandomPoses;
use shapes::rng::SplitMix64;

use super::body::{Body, single, size, support};

/// The intended pose of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Meeting {
    /// Touching in any direction, or in the direction of a face's normal.
    Kissing,
    /// A face of B on one of A, parallel or nearly.
    Faces,
    /// An edge of B parallel to one of A.
    Edges,
    /// Concentric, or nearly.
    Concentric,
    /// A small or thin body deep inside of another one, in half of the cases with parallel axes.
    Inside,
    /// From penetrating to separated.
    Anywhere,
}

const THIRTEEN_TENTHS: f64 = 1.3;

/// Powers of ten, exactly rounded: the same on every machine.
const TENTHS: [f64; 17] =
    [1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14, 1e-15, 1e-16];

/// A relative offset of 10^-`least` to 10^-16, in or out; 0 in one case out of four.
fn offset(rng: &mut SplitMix64, least: usize) -> f64 {
    match rng.below(8) {
        0 | 1 => 0.0,
        _ => rng.between(-1.0, 1.0) * TENTHS[least + rng.below(TENTHS.len() - least)],
    }
}

fn direction(rng: &mut SplitMix64) -> DVec3 {
    match rng.below(8) {
        0 => DVec3::AXES[rng.below(3)],
        _ => rng.unit_vector(),
    }
}

/// A quarter turn about an axis.
fn quarter_turn(rng: &mut SplitMix64) -> DQuat {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let axis = DVec3::AXES[rng.below(3)] * half;
    DQuat::from_xyzw(axis.x, axis.y, axis.z, half)
}

/// Mostly random; some rotations keep axes parallel, exactly or nearly.
fn rotation(rng: &mut SplitMix64) -> DQuat {
    let axis = rng.unit_vector();
    match rng.below(10) {
        0 => DQuat::IDENTITY,
        1 => quarter_turn(rng),
        2 => {
            let axis = axis * TENTHS[1 + rng.below(14)];
            DQuat::from_xyzw(axis.x, axis.y, axis.z, 1.0).normalize()
        }
        _ => DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0) + 1e-9)).normalize(),
    }
}

/// The shortest rotation that takes the unit vector `from` to `to`, then a random rotation about
/// `to`.
fn aligning(rng: &mut SplitMix64, from: DVec3, to: DVec3) -> DQuat {
    let (cross, dot) = (from.cross(to), from.dot(to));
    let arc = if dot > -0.999_999 {
        DQuat::from_xyzw(cross.x, cross.y, cross.z, 1.0 + dot).normalize()
    } else {
        let side = from.cross(if from.x.abs() < 0.5 { DVec3::X } else { DVec3::Y }).normalize();
        let half_turn = DQuat::from_xyzw(side.x, side.y, side.z, 0.0);
        let turned = half_turn * from;
        let (cross, dot) = (turned.cross(to), turned.dot(to));
        DQuat::from_xyzw(cross.x, cross.y, cross.z, 1.0 + dot).normalize() * half_turn
    };
    let around = to * if rng.below(4) == 0 { 0.0 } else { rng.between(-3.0, 3.0) };
    let spin = DQuat::from_xyzw(around.x, around.y, around.z, 1.0).normalize();
    // In half of the cases, tilted by a tiny angle.
    let tilt = direction(rng) * if rng.below(2) == 0 { 0.0 } else { offset(rng, 3) };
    DQuat::from_xyzw(tilt.x, tilt.y, tilt.z, 1.0).normalize() * spin * arc
}

/// Draws the pose of `b` in the frame of `a`.
pub(super) fn meet(rng: &mut SplitMix64, a: &Body<'_>, b: &Body<'_>) -> (Meeting, Pose) {
    let drawn = rng.below(16);
    let (meeting, turn, translation) = match drawn {
        0..6 => {
            let turn = rotation(rng);
            let normal = match rng.below(3) {
                0 => a.model.face_normal(rng.below(1 << 20)),
                1 => b.model.face_normal(rng.below(1 << 20)).map(|n| -(turn * n)),
                _ => None,
            };
            let normal = normal.unwrap_or_else(|| direction(rng));
            (Meeting::Kissing, turn, touching(rng, a, b, turn, normal))
        }
        6..9 => {
            let on_a = a.model.face_normal(rng.below(1 << 20)).unwrap_or_else(|| direction(rng));
            let on_b = b.model.face_normal(rng.below(1 << 20)).unwrap_or_else(|| direction(rng));
            let turn = aligning(rng, on_b, -on_a);
            (Meeting::Faces, turn, touching(rng, a, b, turn, on_a))
        }
        9..11 => {
            let random = (direction(rng), direction(rng));
            let (along_a, out) = a.model.edge(rng.below(1 << 20), rng.unit()).unwrap_or(random);
            let along_b = b.model.edge(rng.below(1 << 20), 0.5).unwrap_or(random).0;
            let turn = aligning(rng, along_b, along_a);
            (Meeting::Edges, turn, touching(rng, a, b, turn, out))
        }
        11 | 12 => {
            let turn = rotation(rng);
            let centers = a.shape().interior_point() - turn * b.shape().interior_point();
            (Meeting::Concentric, turn, centers + direction(rng) * (offset(rng, 0) * size(a).min(size(b))))
        }
        13 => {
            let turn = if rng.below(2) == 0 { quarter_turn(rng) } else { rotation(rng) };
            let centers = a.shape().interior_point() - turn * b.shape().interior_point();
            let thick = a.shape().inner_radius().max(b.shape().inner_radius());
            (Meeting::Inside, turn, centers + direction(rng) * (rng.between(0.0, 0.8) * thick))
        }
        _ => {
            let turn = rotation(rng);
            let centers = a.shape().interior_point() - turn * b.shape().interior_point();
            let far = rng.between(0.0, THIRTEEN_TENTHS) * (size(a) + size(b));
            (Meeting::Anywhere, turn, centers + direction(rng) * far)
        }
    };
    // Poses of games are in single precision.
    let translation = if rng.below(8) == 0 { single(translation) } else { translation };
    (meeting, Pose::new(translation, turn).expect("finite"))
}

/// A translation in which B touches A from outside, in a plane perpendicular to `normal`, or lies a
/// tiny offset from there.
fn touching(rng: &mut SplitMix64, a: &Body<'_>, b: &Body<'_>, turn: DQuat, normal: DVec3) -> DVec3 {
    let on_a = support(a, normal);
    let on_b = support(b, turn.conjugate() * -normal);
    let reach = size(a).min(size(b));
    // In half of the cases, moved along the plane: a vertex touches the inside of a face, or faces
    // overlap in part.
    let slide = if rng.below(2) == 0 { 0.0 } else { rng.between(-1.0, 1.0) * reach };
    let aside = normal.cross(direction(rng)) * slide;
    let mut at = on_a - turn * on_b + aside;
    match rng.below(8) {
        0 => {}
        1 => at.x = at.x.next_up(),
        2 => at.y = at.y.next_down(),
        3 => at.z = at.z.next_up(),
        _ => at += normal * (offset(rng, 3) * reach),
    }
    at
}
