//! Derivatives of distances, depths, rays and times of impact of the soak's hulls, against central
//! differences of truths that do not come from the solver.
//!
//! | answer | truth |
//! |---|---|
//! | distance | Wolfe's algorithm |
//! | depth | all facets of the Minkowski difference |
//! | t of a ray, time of impact of a cast | the line, clipped by all these facets |
//!
//! Differences are taken with two step lengths. Where they disagree, there is a kink within the
//! step: such a derivative is counted, and not judged. Poses are random, and not those of the soak
//! of pairs.

use glam::{DQuat, DVec3};
use hullmap::{
    Cache, CastSettings, Derivatives, Differentiability, Hull, Motion, Pose, PoseDerivative, Ray, Settings, cast,
    contact, distance, ray,
};
use hullmap_testkit::{depth::signed_depth, entry::passage, gap::gap, polytope::Polytope};
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

/// A hull as a polytope, and its size; `None` if the truths do not take it.
fn polytope(body: &Body<'_>) -> Option<(Polytope, f64)> {
    let Solid::Hull(hull) = &body.solid else { return None };
    let takes = |hull: &Hull<'_>| matches!(body.kind, Kind::Game | Kind::Family) && hull.vertices().len() <= VERTICES;
    (takes(hull) && hull.faces().count() > 3).then(|| (Polytope::new(hull), size(body)))
}

/// The pose after a twist: it moves by `v` and turns by `w` about its own origin.
fn twisted(pose: Pose, v: DVec3, w: DVec3) -> Pose {
    Pose::new(pose.translation() + v, DQuat::from_scaled_axis(w) * pose.rotation()).expect("in range")
}

/// Central differences of `truth` by the poses of A and of B, each with the step of its kind and
/// its half; `None` if there is a kink.
fn differences(
    poses: [Pose; 2],
    [linear, angular]: [f64; 2],
    lever: f64,
    truth: &impl Fn([Pose; 2]) -> f64,
) -> Option<[PoseDerivative; 2]> {
    let mut found = [PoseDerivative::default(); 2];
    let mut entries: Vec<[f64; 2]> = Vec::new();
    for which in 0..2 {
        for axis in 0..6 {
            let step = if axis < 3 { linear } else { angular };
            let difference = |step: f64| {
                let value = |step: f64| {
                    let unit = DVec3::AXES[axis % 3] * step;
                    let (v, w) = if axis < 3 { (unit, DVec3::ZERO) } else { (DVec3::ZERO, unit) };
                    let mut moved = poses;
                    moved[which] = twisted(poses[which], v, w);
                    truth(moved)
                };
                (value(step) - value(-step)) / (2.0 * step)
            };
            let [whole, half] = [difference(step), difference(0.5 * step)];
            entries.push([whole, half].map(|d| d / if axis < 3 { 1.0 } else { lever }));
            let part = if axis < 3 { &mut found[which].linear } else { &mut found[which].angular };
            part[axis % 3] = half;
        }
    }
    let greatest = entries.iter().map(|[whole, _]| whole.abs()).fold(0.0, f64::max);
    // NaN takes the failing branch.
    let is_smooth = entries.iter().all(|[whole, half]| (whole - half).abs() <= SMOOTH * greatest);
    is_smooth.then_some(found)
}

/// Greatest difference of two derivatives by both poses, relative to the greatest entry.
fn off(found: &Derivatives, truth: &[PoseDerivative; 2], lever: f64) -> f64 {
    let entries = |by: &PoseDerivative| {
        let entries = by.to_array();
        std::array::from_fn::<f64, 6, _>(|i| if i < 3 { entries[i] } else { entries[i] / lever })
    };
    let (mut greatest, mut off) = (0.0_f64, 0.0_f64);
    for (found, truth) in [(&found.of_a, &truth[0]), (&found.of_b, &truth[1])] {
        for (found, truth) in entries(found).into_iter().zip(entries(truth)) {
            greatest = greatest.max(truth.abs());
            off = off.max((found - truth).abs());
        }
    }
    off / greatest
}

/// Judges the derivatives of one kind of answer for a random pose of the pair.
pub(super) fn judge(pair: &BodyPair<'_, '_>, rng: &mut SplitMix64, tally: &mut Tally) {
    let [Some((a, size_a)), Some((b, size_b))] = pair.bodies.map(polytope) else {
        *tally.lines.entry("not taken").or_default() += 1;
        return;
    };
    let [Solid::Hull(hull_a), Solid::Hull(hull_b)] = pair.bodies.map(|body| &body.solid) else { return };
    let turn = |rng: &mut SplitMix64| DQuat::from_axis_angle(DVec3::from_array(rng.direction()), rng.between(0.0, 6.0));
    let sizes = size_a + size_b;
    let (inside_a, inside_b) = (pair.bodies[0].shape().interior_point(), pair.bodies[1].shape().interior_point());
    let rotation = turn(rng);
    // How far the interior points are from each other.
    let apart = DVec3::from_array(rng.direction()) * (sizes * rng.between(0.1, 2.5));
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
        let aim = -apart + DVec3::from_array(rng.direction()) * (0.5 * sizes);
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
                entry_of_ray(&a, origin, turned * aim)
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
        *tally.lines.entry("missing").or_default() += 1;
        return;
    }
    let mut judge = Claims { wrong: None, tightest: 0.0, queries: "derivatives", tally };
    let what = match found.status {
        Differentiability::Unique => {
            let scale = STEP * length.min(0.1 * sizes);
            // Rounding errors of the truth, divided by the step.
            let noise = 8.0 * f64::EPSILON * greatest / scale;
            match differences(poses, [scale, scale / lever], lever, &truth) {
                _ if noise > 0.1 * SMOOTH => "too near to judge",
                None => "kink in the step",
                Some(truth) => {
                    judge.at_most(kind, off(&found, &truth, lever), 0.0, TOLERANCE);
                    "judged"
                }
            }
        }
        status => status.as_str(),
    };
    *judge.tally.lines.entry(kind).or_default() += 1;
    *judge.tally.lines.entry(what).or_default() += 1;
    judge.finish(pair, || format!("{kind} {b_in_a:?} {found:?}"));
}

/// The t at which a ray enters a polytope: the latest of the planes that it enters through.
fn entry_of_ray(hull: &Polytope, origin: DVec3, direction: DVec3) -> f64 {
    let offset = |n: &DVec3| hull.points.iter().map(|p| p.dot(*n)).fold(f64::NEG_INFINITY, f64::max);
    let enters = hull.normals.iter().filter(|n| n.dot(direction) < 0.0);
    enters.map(|n| (offset(n) - n.dot(origin)) / n.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
}
