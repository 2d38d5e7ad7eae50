//! Derivatives of distances, depths, rays and times of impact of the soak's hulls, against central
//! differences of truths that do not come from the solver.
//!
//! | answer | truth |
//! |---|---|
//! | distance | Wolfe's algorithm |
//! | depth | all facets of the Minkowski difference |
//! | t of a ray, time of impact of a cast | the line, clipped by all these facets |
//! | normal and points of a distance or a depth | the same answers, which the soak of pairs judges |
//!
//! Differences are taken with two step lengths. Where they disagree, there is a kink within the
//! step: such a derivative is counted, and not judged. Poses are random, and differ from the
//! soak of pairs.

use glam::{DQuat, DVec3};
use hullmap::{
    Cache, CastSettings, Differentiability, Hull, Motion, Pose, Ray, Settings, cast, contact, distance, ray,
};
use hullmap_testkit::{
    depth::signed_depth,
    entry::{passage, passage_of_point},
    gap::gap,
    polytope::Polytope,
    random::RandomPoses,
    reach::Reach,
};
use shapes::rng::SplitMix64;

use super::bodies::BodyPair;
use super::body::{Body, Kind, Solid, size};
use super::claims::Claims;
use super::tally::Tally;

/// Maximum number of vertices of a hull: the truths are of O(n²).
const VERTICES: usize = 32;

/// Greatest relative difference of a derivative and of the central difference.
const TOLERANCE: f64 = 1e-6;

/// Greatest relative difference of two central differences without a kink in the step.
const SMOOTH: f64 = 2.5e-7;

/// Step of a difference, as a fraction of the length within which the answer changes.
const STEP: f64 = 1e-4;

/// Settings of the answers that are differentiated.
const EXACT: Settings = Settings { tolerance: 0.0, max_iterations: Settings::DEFAULT_MAX_ITERATIONS };

/// A hull as a polytope, and its size; `None` if the truths do not support it.
fn polytope(body: &Body<'_>) -> Option<(Polytope, f64)> {
    let Solid::Hull(hull) = &body.solid else { return None };
    let takes = |hull: &Hull<'_>| matches!(body.kind, Kind::Game | Kind::Family) && hull.vertices().len() <= VERTICES;
    (takes(hull) && hull.faces().count() > 3).then(|| (Polytope::new(hull), size(body)))
}

/// The pose after a twist: it moves by `v` and turns by `w` about its own origin.
fn twisted(pose: Pose, v: DVec3, w: DVec3) -> Pose {
    Pose::new(pose.translation() + v, DQuat::from_scaled_axis(w) * pose.rotation()).expect("in range")
}

/// Derivatives of a number by the poses of A and of B: six by each, per unit of length.
type Row = [f64; 12];

/// The row of derivatives by both poses, whose angular parts are divided by `lever`.
fn row(by_a: &[f64; 6], by_b: &[f64; 6], lever: f64) -> Row {
    std::array::from_fn(|i| {
        let entry = if i < 6 { by_a[i] } else { by_b[i - 6] };
        if i % 6 < 3 { entry } else { entry / lever }
    })
}

/// Greatest difference of two derivatives of a vector, relative to the greatest entry.
fn off(found: &[Row], truth: &[Row]) -> f64 {
    let pairs = found.iter().flatten().zip(truth.iter().flatten());
    let greatest = truth.iter().flatten().fold(0.0, |greatest: f64, entry| greatest.max(entry.abs()));
    pairs.map(|(found, truth)| (found - truth).abs()).fold(0.0, f64::max) / greatest
}

/// Central differences of `truth` by the poses of A and of B, each with the step of its kind and
/// its half. `truth` has vectors of `width` numbers; `None` if there is a kink in one of them.
fn differences<const N: usize>(
    poses: [Pose; 2],
    [linear, angular]: [f64; 2],
    width: usize,
    truth: &impl Fn([Pose; 2]) -> [f64; N],
) -> Option<[Row; N]> {
    let lever = linear / angular;
    let mut found = [[[0.0; 12]; N]; 2];
    for column in 0..12 {
        let (which, axis) = (column / 6, column % 6);
        let step = if axis < 3 { linear } else { angular };
        for (share, rows) in [1.0, 0.5].into_iter().zip(&mut found) {
            let value = |step: f64| {
                let unit = DVec3::AXES[axis % 3] * step;
                let (v, w) = if axis < 3 { (unit, DVec3::ZERO) } else { (DVec3::ZERO, unit) };
                let mut moved = poses;
                moved[which] = twisted(poses[which], v, w);
                truth(moved)
            };
            let (after, before) = (value(step * share), value(-step * share));
            let length = if axis < 3 { 2.0 * step * share } else { 2.0 * step * share * lever };
            for (row, (after, before)) in rows.iter_mut().zip(after.into_iter().zip(before)) {
                row[column] = (after - before) / length;
            }
        }
    }
    let [whole, half] = found;
    // NaN takes the failing branch.
    let is_smooth = whole.chunks(width).zip(half.chunks(width)).all(|(whole, half)| off(half, whole) <= SMOOTH);
    is_smooth.then_some(half)
}

/// Judges the derivatives of one kind of answer for a random pose of the pair.
pub(super) fn judge(pair: &BodyPair<'_, '_>, rng: &mut SplitMix64, tally: &mut Tally) {
    let [Some((a, size_a)), Some((b, size_b))] = pair.bodies.map(polytope) else {
        tally.note("not taken");
        return;
    };
    let [Solid::Hull(hull_a), Solid::Hull(hull_b)] = pair.bodies.map(|body| &body.solid) else { return };
    let sizes = size_a + size_b;
    let (inside_a, inside_b) = (pair.bodies[0].shape().interior_point(), pair.bodies[1].shape().interior_point());
    let rotation = DQuat::from_axis_angle(rng.unit_vector(), rng.between(0.0, 6.0));
    // How far the interior points are from each other.
    let apart = rng.unit_vector() * (sizes * rng.between(0.1, 2.5));
    let b_in_a = Pose::new(inside_a + apart - rotation * inside_b, rotation).expect("in range");
    let poses = [Pose::IDENTITY, b_in_a];
    let placed = |poses: [Pose; 2]| (a.placed(poses[0]), b.placed(poses[1]));
    let greatest = a.greatest() + b.greatest() + b_in_a.translation().length();
    let lever = sizes + greatest;

    let near = distance(hull_a, hull_b, b_in_a, &EXACT, &mut Cache::new());
    let way = rng.below(3);
    let (kind, found, length, truth): (_, _, _, Box<dyn Fn([Pose; 2]) -> f64>) = if near.lower > 0.0 && way == 0 {
        let truth = |poses| {
            let (a, b) = placed(poses);
            gap(&a, &b).upper
        };
        ("distance", near.derivatives(hull_a, hull_b, b_in_a), near.distance, Box::new(truth))
    } else if near.lower > 0.0 {
        let aim = -apart + rng.unit_vector() * (0.5 * sizes);
        let is_ray = way == 1;
        let settings = CastSettings { tolerance: 0.0, ..CastSettings::default() };
        let found = if is_ray {
            let line = Ray::new(inside_a + apart, aim).expect("finite");
            ray(hull_a, &line, &settings).derivatives(hull_a, &line)
        } else {
            let motion = Motion::new(aim).expect("finite");
            cast(hull_a, hull_b, b_in_a, motion, &settings, &mut Cache::new())
                .derivatives(hull_a, hull_b, b_in_a, motion)
        };
        let (point, a, b) = (inside_a + apart, &a, &b);
        let truth = move |poses: [Pose; 2]| {
            let a = a.placed(poses[0]);
            if is_ray {
                // The frame of the ray has its origin at the ray's.
                let turned = poses[1].rotation() * rotation.conjugate();
                let origin = point + (poses[1].translation() - b_in_a.translation());
                let offsets: Vec<f64> = a.normals.iter().map(|n| a.reach(*n)).collect();
                passage_of_point(&a, &offsets, origin, turned * aim, 0.0).enter[0]
            } else {
                passage(&a, &b.placed(poses[1]), aim, 0.0).enter[0]
            }
        };
        (if is_ray { "ray" } else { "cast" }, found, 0.1 * sizes, Box::new(truth))
    } else {
        let deep = contact(hull_a, hull_b, b_in_a, &EXACT, &mut Cache::new());
        let found = deep.derivatives(hull_a, hull_b, b_in_a, &EXACT, &mut Cache::new());
        let truth = |poses| {
            let (a, b) = placed(poses);
            signed_depth(&a, &b, f64::NEG_INFINITY).0
        };
        ("depth", found, deep.depth, Box::new(truth))
    };
    if found.status == Differentiability::Missing {
        tally.note("missing");
        return;
    }
    if found.status == Differentiability::Unique && (kind == "distance" || kind == "depth") {
        let step = STEP * length.min(0.1 * sizes);
        judge_witness(pair, [hull_a, hull_b], poses, (kind, step, lever), tally);
    }
    let mut judge = Claims::new("derivatives", tally);
    let what = match found.status {
        Differentiability::Unique => {
            let scale = STEP * length.min(0.1 * sizes);
            // Rounding errors of the truth, divided by the step.
            let rounding = 8.0 * f64::EPSILON * greatest / scale;
            match differences(poses, [scale, scale / lever], 1, &|poses| [truth(poses)]) {
                _ if rounding > 0.1 * SMOOTH => "too near to judge",
                None => "kink in the step",
                Some(truth) => {
                    let own = row(&found.by_a.to_array(), &found.by_b.to_array(), lever);
                    judge.at_most(kind, off(&[own], &truth), 0.0, TOLERANCE);
                    "judged"
                }
            }
        }
        status => status.as_str(),
    };
    judge.tally.note(kind);
    judge.tally.note(what);
    judge.finish(pair, || format!("{kind} {b_in_a:?} {found:?}"));
}

/// Judges the derivatives of the normal and the points of a distance or a depth.
fn judge_witness(
    pair: &BodyPair<'_, '_>,
    [a, b]: [&Hull<'_>; 2],
    poses: [Pose; 2],
    (kind, step, lever): (&'static str, f64, f64),
    tally: &mut Tally,
) {
    let is_distance = kind == "distance";
    let answer = |[pose_a, pose_b]: [Pose; 2]| {
        let b_in_a = Pose::relative(pose_a, pose_b).expect("in range");
        let (normal, points) = if is_distance {
            let found = distance(a, b, b_in_a, &EXACT, &mut Cache::new());
            (found.normal, [found.point_a, found.point_b])
        } else {
            let found = contact(a, b, b_in_a, &EXACT, &mut Cache::new());
            (found.normal, [found.point_a, found.point_b])
        };
        let (n, [p, q]) = (pose_a.transform_vector(normal), points.map(|point| pose_a.transform_point(point)));
        [n.x, n.y, n.z, p.x, p.y, p.z, q.x, q.y, q.z]
    };
    let (b_in_a, cache) = (poses[1], &mut Cache::new());
    let found = if is_distance {
        distance(a, b, b_in_a, &EXACT, cache).witness_derivatives(a, b, b_in_a)
    } else {
        contact(a, b, b_in_a, &EXACT, cache).witness_derivatives(a, b, b_in_a, &EXACT, cache)
    };
    let mut judge = Claims::new("derivatives", tally);
    let what = match found.status {
        Differentiability::Unique => match differences(poses, [step, step / lever], 3, &answer) {
            None => "witness: kink in the step",
            Some(truth) => {
                let (by_a, by_b) = (found.by_a, found.by_b);
                for (what, by_a, by_b, truth) in [
                    ("normal", by_a.normal, by_b.normal, &truth[..3]),
                    ("point of A", by_a.point_a, by_b.point_a, &truth[3..6]),
                    ("point of B", by_a.point_b, by_b.point_b, &truth[6..]),
                ] {
                    let rows: [Row; 3] = std::array::from_fn(|i| row(&by_a[i], &by_b[i], lever));
                    judge.at_most(what, off(&rows, truth), 0.0, TOLERANCE);
                }
                "witness: judged"
            }
        },
        Differentiability::Feature => "witness: feature",
        Differentiability::Curved => "witness: curved",
        _ => "witness: other reason",
    };
    judge.tally.note(what);
    judge.finish(pair, || format!("{kind} {b_in_a:?} {found:?}"));
}
