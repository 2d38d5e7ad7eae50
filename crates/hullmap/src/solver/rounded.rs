//! Rays and casts against rounded shapes: Newton's method on the distance of the cores.
//!
//! Let f(t) be the distance of the cores at time t minus the sum r of the convex radii. The shapes
//! touch where f is 0. f is convex, since the distance from a convex set is. Newton's method from
//! below therefore never steps beyond the first zero, and doubles its digits in each step.
//!
//! # Reference
//! van den Bergen, "Ray casting against general convex objects with application to continuous
//! collision detection", 2004. docs/contributors/intervals.md proves the interval.
//!
//! # Steps
//! 1. Compute the distance of the cores at t (GJK, from the simplex of the last step). Its plane
//!    proves that they are at least r apart up to a later t. Continue from there.
//! 2. If the plane separates the shapes until the limit, the cast misses.
//! 3. When t no longer advances, take a slightly later t. If the cores are certainly within r
//!    there, it is an upper bound. Otherwise move on, farther each time.

use glam::DVec3;

use super::cache::Cache;
use super::distance::{Distance, core_distance};
use super::line::{Entry, LineQuery};
use super::queries::{Core, outward, rounded_points, rounding};
use super::settings::Settings;
use super::status::Status;
use crate::pose::Pose;
use crate::support::SupportMap;

/// Maximum number of distances on the way to the entry. Newton's method needs 3 to 6. Where the
/// motion grazes the shape, each step halves what is left.
const MAX_STEPS: u32 = 100;

/// Maximum number of distances beyond the entry, each eight times as far.
const MAX_TRIALS: u32 = 24;

/// Error of a point of the path, in units of `f64::EPSILON` times its distance from the origin of
/// A's frame, including the error of the difference of two distances.
const PATH_ROUNDINGS: f64 = 8.0;

/// An interval up to this many errors wide is as narrow as rounding error allows.
const EXACT_ERRORS: f64 = 64.0;

/// Share of the tolerance that a step, a trial and the error of a distance may take.
const SHARE: f64 = 0.125;

struct Cores<'q, A: ?Sized, B: ?Sized> {
    a: Core<'q, A>,
    b: Core<'q, B>,
    b_in_a: Pose,
    direction: DVec3,
    radius: f64,
    /// Length of the path after which B has certainly passed A.
    end: f64,
    settings: Settings,
    iterations: u32,
    support_calls: u32,
}

struct Sample {
    gap: Distance,
    /// Lower bound of the gap between the shapes; negative where they may overlap.
    lower: f64,
    upper: f64,
    along: f64,
    error: f64,
    length: f64,
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> Cores<'_, A, B> {
    fn sample(&mut self, length: f64, cache: &mut Cache) -> Sample {
        let moved = self.b_in_a.moved(self.direction * length);
        let gap = core_distance(&self.a, &self.b, moved, &self.settings, cache);
        self.iterations += gap.iterations + 1;
        self.support_calls += gap.support_calls;
        let path = PATH_ROUNDINGS * f64::EPSILON * (self.b_in_a.translation().length() + length);
        let error = rounding(self.radius, gap.upper) + path;
        Sample {
            lower: gap.lower - self.radius - error,
            upper: gap.upper - self.radius + error,
            along: gap.normal.dot(self.direction),
            error,
            length,
            gap,
        }
    }

    /// Steps 1 and 2: the length up to which the shapes are certainly separated. `Err` has the
    /// normal of a miss.
    fn approach(&mut self, first: Sample, query: &LineQuery, cache: &mut Cache) -> Result<Progress, DVec3> {
        let mut progress = Progress { lower: 0.0, normal: first.gap.normal, sample: first };
        for _ in 0..query.max_iterations.min(MAX_STEPS) {
            let Progress { lower: at, sample, .. } = &progress;
            // NaN ends the search.
            if !(sample.lower > 0.0) {
                break;
            }
            let slope = PATH_ROUNDINGS * f64::EPSILON - sample.along;
            let step = sample.lower / slope;
            let next = at + step - PATH_ROUNDINGS * f64::EPSILON * (at + step);
            if slope <= 0.0 || next > self.end.min(query.limit) {
                return Err(sample.gap.normal);
            }
            if !(next > *at) {
                break;
            }
            progress.normal = sample.gap.normal;
            progress.lower = next;
            if step <= SHARE * query.tolerance {
                break;
            }
            progress.sample = self.sample(next, cache);
        }
        Ok(progress)
    }

    /// Step 3: the upper bound of the entry, and the cores there if it is certain that the shapes
    /// meet up to there.
    fn bracket(&mut self, progress: &mut Progress, query: &LineQuery, cache: &mut Cache) -> (f64, Option<Sample>) {
        let mut trial = (SHARE * query.tolerance).max(4.0 * progress.sample.error);
        for _ in 0..MAX_TRIALS {
            let at = progress.lower + trial;
            if !(at < self.end) {
                break;
            }
            let beyond = self.sample(at, cache);
            if beyond.upper <= 0.0 {
                return (at, Some(beyond));
            }
            let is_separated = beyond.lower > PATH_ROUNDINGS * f64::EPSILON * trial;
            if is_separated && beyond.along >= 0.0 {
                // From here on they move apart.
                return (at, None);
            }
            if is_separated {
                // They still approach each other, and did so before.
                *progress = Progress { lower: at, normal: beyond.gap.normal, sample: beyond };
            } else {
                trial *= 8.0;
            }
        }
        (self.end.max(progress.lower), None)
    }

    fn find(&mut self, radii: [f64; 2], query: &LineQuery, cache: &mut Cache) -> Entry {
        let first = self.sample(0.0, cache);
        if first.upper < 0.0 {
            let points = rounded_points(&first.gap, radii);
            let (status, normal) = (Status::Overlapping, -self.direction);
            return Entry { status, at: 0.0, lower: 0.0, upper: 0.0, normal, points, iterations: 0 };
        }
        let mut progress = match self.approach(first, query, cache) {
            Ok(progress) => progress,
            Err(normal) => return Entry::miss(normal, 0),
        };
        let (upper, meeting) = self.bracket(&mut progress, query, cache);
        let Progress { lower, normal, sample: Sample { gap, error, length, .. } } = progress;
        if lower > query.limit {
            return Entry::miss(normal, 0);
        }
        let width = upper - lower;
        // NaN takes the last branch.
        let status = match () {
            () if meeting.is_none() => Status::Touching,
            () if width <= EXACT_ERRORS * error => Status::Exact,
            () if width <= query.tolerance => Status::Within,
            () => Status::Stalled,
        };
        // B has moved on since the sample.
        let out = outward(&gap, EXACT_ERRORS * error);
        let point_b = gap.point_b - out * radii[1] + self.direction * (lower - length);
        let mut points = [gap.point_a + out * radii[0], point_b];
        if let Some(Sample { gap, .. }) = meeting
            && !(points[0].distance(points[1]) <= width)
        {
            // The closest points were uncertain, or are far from where the shapes meet. At the
            // upper bound they overlap.
            let [on_a, on_b] = rounded_points(&gap, radii);
            points = [on_a, on_b - self.direction * width];
        }
        Entry { status, at: lower, lower, upper, normal, points, iterations: 0 }
    }
}

struct Progress {
    /// The shapes are certainly separated up to this length.
    lower: f64,
    normal: DVec3,
    /// The last sample at this length or before.
    sample: Sample,
}

/// Where B, on its way in `query`, meets A, for convex radii of which one is positive; and the
/// number of support calls.
pub(super) fn enter_rounded<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    radii: [f64; 2],
    query: &LineQuery,
    cache: &mut Cache,
) -> (Entry, u32) {
    let radius = radii[0] + radii[1];
    // Where the shapes meet, the distance of the cores is the radius.
    let tolerance = (SHARE * query.tolerance / radius).min(Settings::DEFAULT_TOLERANCE);
    let between = b_in_a.transform_point(b.interior_point()) - a.interior_point();
    let reach = a.outer_radius() + b.outer_radius() + between.length() * PATH_ROUNDINGS * f64::EPSILON;
    let mut cores = Cores {
        a: Core(a),
        b: Core(b),
        b_in_a,
        direction: query.direction,
        radius,
        end: reach * (1.0 + PATH_ROUNDINGS * f64::EPSILON) - between.dot(query.direction),
        settings: Settings { tolerance, ..Settings::default() },
        iterations: 0,
        support_calls: 0,
    };
    let entry = cores.find(radii, query, cache);
    (Entry { iterations: cores.iterations, ..entry }, cores.support_calls)
}
