//! Levels: the limits for which parts are searched, and which of the results is taken.
//!
//! The limits are a fixed geometric series, relative to the mesh's diagonal. At a level, the surface
//! is divided, and parts are merged; they are merged further at each level above. So the number of
//! parts that a division leads to never rises with the level.
//!
//! A maximum error is served by the divisions at the levels below it, each with mergers up to it. Of
//! their results, the one with the fewest parts is taken, and of equal ones that with the lowest
//! limit. A larger error has the same divisions, and further ones. So it never takes more parts, as
//! long as the search down the levels reaches all divisions that lead to fewer parts.

use super::{
    parameters::Cover,
    partition::{self, Found, PartitionLimits, field::Field, wrap::Bounds},
};
use crate::{PointSet, deadline::Deadline, fit::solid::Solid, mass, progress::Stage};

/// The limit of level 0, relative to the diagonal.
const ORIGIN: f64 = 0.02;

/// Number of levels in which the limit doubles.
const PER_OCTAVE: i32 = 16;

/// Number of levels between those that serve maximum errors. The others serve numbers of parts.
const STEP: i32 = 4;

/// Smallest limit on the protrusion that is searched for, relative to the diagonal. Parts are
/// rounded and moved outward by up to a tenth of that, if the mesh is not far from the origin.
const LEAST_ERROR: f64 = 2e-5;

/// Maximum number of parts made by halving, the result if the time ends at once.
const HALVED: usize = 8;

/// Number of levels in a row that lead to no fewer parts, after which no lower ones are searched.
const MISSES: usize = 3;

/// The least share of the time that is left for finishing parts and for proving that they cover the
/// mesh. It takes about as long as the preparation of the mesh.
const RESERVE: f64 = 0.1;

/// The level of a limit that is never needed: parts may protrude by more than the mesh's size.
const HIGHEST: i32 = 96;

/// Limits for which parts are divided further where there may be more, relative to what they reach.
const FURTHER: [f64; 3] = [0.5, 0.7, 0.85];

/// The lowest level at which the search for a number of parts starts: 1 % of the diagonal.
const LOWEST_FIRST: i32 = -PER_OCTAVE;

/// Number of levels between those at which parts are merged for a number of parts.
const FINE: i32 = 2;

/// Number of levels below the best known one at which the surface is divided for a number of parts.
const BELOW: [i32; 5] = [2, 6, 10, 14, 20];

/// Maximum number of divisions for a number of parts.
const MAX_SEARCHES: usize = 6;

/// Smallest limit that is searched only because parts for a smaller limit are tighter, relative to
/// the diagonal.
const LEAST_FOR_TIGHTNESS: f64 = 1e-3;

/// Smallest limit that is searched for a number of parts, relative to the diagonal. Below it, more
/// parts only follow the tessellation.
const LEAST_FOR_COUNTS: f64 = 2e-3;

/// The greatest proven protrusion of parts.
fn reached(found: &Found) -> f64 {
    found.parts.iter().map(|part| part.bound).fold(0.0, f64::max)
}

/// The better of two results, of which the second may be unproven: one that is within the error, or
/// the one whose parts have the smaller volume.
fn better(best: Option<Found>, found: Option<Found>, error: f64) -> Option<Found> {
    let volume = |found: &Found| found.parts.iter().map(|part| mass::mass(&part.hull).volume).sum::<f64>();
    // Infinity is no proof.
    let is_within = |found: &Found| reached(found) < f64::INFINITY && reached(found) <= error;
    match (best, found) {
        (Some(best), Some(found)) => {
            let is_better = !is_within(&best) && (is_within(&found) || volume(&found) < volume(&best));
            Some(if is_better { found } else { best })
        }
        (best, found) => best.or(found),
    }
}

/// The searches for one mesh.
pub struct Levels<'a> {
    mesh: &'a PointSet,
    /// The mesh's solid.
    pub field: Field<'a>,
    parameters: &'a Cover,
    max_vertices: usize,
    /// When the search ends.
    deadline: Option<Deadline>,
    /// When the parts must be finished.
    last_deadline: Option<Deadline>,
    stage: Stage<'a>,
    /// Number of searches so far.
    searches: i32,
}

impl<'a> Levels<'a> {
    /// # Complexity
    /// That of [`Field::new`].
    pub fn new(
        mesh: &'a PointSet,
        solid: &'a Solid,
        parameters: &'a Cover,
        max_vertices: usize,
        stage: Stage<'a>,
        last_deadline: Option<Deadline>,
    ) -> Self {
        let field = Field::new(solid);
        let deadline = last_deadline.map(|deadline| deadline.with_reserve(RESERVE));
        Self { mesh, field, parameters, max_vertices, deadline, last_deadline, stage, searches: 0 }
    }

    fn diagonal(&self) -> f64 {
        self.field.solid().diagonal()
    }

    /// The limits of a part.
    pub fn bounds(&self, limit: f64) -> Bounds<'a> {
        let (max_vertices, diagonal) = (self.max_vertices, self.diagonal());
        let error = self.parameters.max_error.of(diagonal);
        let allowed = if self.parameters.max_parts.is_some() { limit } else { limit.min(error) };
        let thickness = self.parameters.min_thickness.of(diagonal).min(0.5 * allowed);
        Bounds { limit, max_vertices, diagonal, thickness, deadline: self.deadline, stage: self.stage }
    }

    /// The limits of a part when parts are finished, for which there is more time.
    pub fn last_bounds(&self, limit: f64) -> Bounds<'a> {
        Bounds { deadline: self.last_deadline, ..self.bounds(limit) }
    }

    /// The limits of thin parts that were found within `limit`, but may be as thick as the maximum
    /// error allows.
    pub fn bounds_of_thin_parts(&self, limit: f64) -> Bounds<'a> {
        let is_counted = self.parameters.max_parts.is_some();
        self.last_bounds(if is_counted { limit } else { limit.max(self.parameters.max_error.of(self.diagonal())) })
    }

    fn is_over(&self) -> bool {
        self.bounds(0.0).is_over()
    }

    /// The limit of a level.
    fn limit(&self, level: i32) -> f64 {
        let share = ORIGIN * libm::exp2(f64::from(level) / f64::from(PER_OCTAVE));
        share.max(LEAST_ERROR) * self.diagonal()
    }

    /// The highest level whose limit is at most `error`, of those `step` levels apart.
    fn level(&self, error: f64, step: i32) -> i32 {
        let mut level = HIGHEST;
        while self.limit(level) > error * (1.0 + 1e-9) && self.limit(level) > LEAST_ERROR * self.diagonal() {
            level -= step;
        }
        level
    }

    /// The parts for the parameters; `None` if there are none in time.
    pub fn parts(&mut self) -> Option<Found> {
        let error = self.parameters.max_error.of(self.diagonal());
        match self.parameters.max_parts {
            Some(count) => self.at_most(count as usize, error),
            None => self.fewest(error),
        }
    }

    /// The fewest parts within the limits of some levels: the surface is divided at the first one,
    /// and parts are merged at all. `None` if the time is over, or far more than `enough` parts are
    /// needed.
    fn search(&mut self, levels: impl Iterator<Item = i32>, enough: Option<usize>) -> Option<Found> {
        // Each search is expected to take half of the rest.
        let [from, to] = [self.searches, self.searches + 1].map(|count| 1.0 - libm::exp2(-f64::from(count)));
        self.searches += 1;
        let stage = self.stage.from_to(from, to);
        let bounds: Vec<Bounds> = levels.map(|level| Bounds { stage, ..self.bounds(self.limit(level)) }).collect();
        let (bounds, greater) = bounds.split_first()?;
        let limits = PartitionLimits {
            bounds: *bounds,
            greater,
            overlap: self.parameters.overlap,
            enough,
            wanted: self.parameters.max_parts.map_or(1, |count| count as usize),
        };
        partition::search(self.mesh, &mut self.field, &limits)
    }

    /// The fewest parts within `error`.
    fn fewest(&mut self, error: f64) -> Option<Found> {
        let first = self.level(error, STEP);
        let last = self.level(LEAST_FOR_TIGHTNESS * self.diagonal(), STEP).min(first);
        let rough = self.rough(first);
        let mut best: Option<Found> = None;
        let (mut level, mut misses) = (first, 0);
        while misses < MISSES && level >= last {
            let levels = (level..=first).step_by(STEP as usize);
            let found = self.search(levels, best.as_ref().map(|best| best.parts.len()));
            if self.is_over() {
                return better(best.or(rough), found, error);
            }
            level -= STEP;
            misses += 1;
            let enough = best.as_ref().map_or(usize::MAX, |best| best.parts.len());
            let Some(found) = found.filter(|found| best.as_ref().is_none_or(|best| found.size() < best.size())) else {
                continue;
            };
            if found.parts.len() < enough {
                misses = 0;
            }
            // The levels between would give the same.
            if reached(&found) < self.limit(last) {
                level = level.min(last);
            }
            best = Some(found);
        }
        best.or(rough)
    }

    /// Parts of a larger error, to have some when the time ends; `None` if the time has no limit.
    fn rough(&mut self, first: i32) -> Option<Found> {
        let mut best = self.halved(HALVED);
        for octaves in [3, 1] {
            if best.is_none() || self.is_over() {
                break;
            }
            let found = self.search(std::iter::once(first + octaves * PER_OCTAVE), None);
            // None of them is within the error.
            best = better(best, found, 0.0);
        }
        best
    }

    /// The first parts of a search whose time is limited, at most `count`; `None` if it is not.
    fn halved(&self, count: usize) -> Option<Found> {
        self.deadline?;
        let limit = f64::INFINITY;
        let parts = partition::halved(self.mesh, &self.bounds(limit), count.min(HALVED));
        (parts.len() > 1).then_some(Found { parts, limit })
    }

    /// At most `count` parts, with the least protrusion. The first division is at `error`, or at a
    /// level from which few of them lead to a small number. Each is merged at one level after the
    /// other, until there are few enough parts. Further divisions are a little below the level at
    /// which that was so.
    fn at_most(&mut self, count: usize, error: f64) -> Option<Found> {
        let lowest = self.level(LEAST_FOR_COUNTS * self.diagonal(), FINE);
        let (mut best, mut tried) = (None::<Found>, Vec::new());
        let (mut level, mut stride) = (self.level(error, FINE).max(LOWEST_FIRST), PER_OCTAVE);
        while tried.len() < MAX_SEARCHES && !tried.contains(&level) {
            tried.push(level);
            // Parts may reach less than their limit.
            let least = |found: &Found| self.level(found.limit.min(reached(found)), FINE);
            let highest = best.as_ref().map_or(HIGHEST, |best| least(best) - FINE);
            let found = self.search((level..=highest).step_by(FINE as usize), Some(count));
            let found = found.filter(|found| found.parts.len() <= count);
            if self.is_over() {
                let best = best.or_else(|| self.halved(count));
                return better(best, found, f64::INFINITY);
            }
            let is_at_once = found.as_ref().is_some_and(|found| found.limit <= self.limit(level));
            best = found.or(best);
            let is_new = |level: &i32| tried.iter().all(|other| (other - level).abs() >= FINE);
            let least = best.as_ref().map(|best| self.level(best.limit.min(reached(best)), FINE));
            level = match least {
                None => level + stride,
                Some(least) if is_at_once => least - stride,
                Some(least) => match BELOW.map(|below| least - below).into_iter().find(is_new) {
                    Some(next) => next,
                    None => break,
                },
            };
            stride *= 2;
            level = level.clamp(lowest, HIGHEST);
        }
        best.map(|found| self.refined(found, count))
    }

    /// The same parts, of which some are divided, where there may be more.
    fn refined(&mut self, found: Found, count: usize) -> Found {
        let (worst, mut found) = (reached(&found), found);
        for limit in FURTHER.map(|share| share * worst) {
            let is_useful = limit.is_finite() && limit >= LEAST_FOR_TIGHTNESS * self.diagonal();
            if found.parts.len() >= count || !is_useful {
                break;
            }
            let bounds = self.bounds(limit);
            found.parts = partition::divided_further(self.mesh, &mut self.field, bounds, found.parts, count);
        }
        found
    }
}
