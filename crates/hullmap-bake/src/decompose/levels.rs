//! Levels: the limits for which parts are searched, and which of the results is taken.
//!
//! The limits are a fixed geometric series, relative to the mesh's diagonal. A maximum error uses
//! the levels below it. The result with the fewest parts is taken, then the one with the lowest
//! limit. A larger error has the same candidates and some more; it takes more parts only if step 2
//! leaves out the level with fewer.
//!
//! # Steps
//! 1. Search the highest level, then lower ones, down to 0.5 % of the diagonal. End when conflicts
//!    prove that all lower levels have more parts.
//! 2. Give up a level when it has far more parts before mergers than the best level had. End when
//!    lower levels cannot be better, which keeps meshes with many parts from taking minutes.
//! 3. If conflicts prove that no level has fewer parts than the best, lower levels only give
//!    tighter parts. Search whole octaves, and other levels only below the last octave with such
//!    parts.

use super::{
    parameters::Cover,
    partition::{self, Part, PartitionLimits, Samples, Useful, field::Field, surface::Surface, wrap::HullLimits},
};
use crate::{
    deadline::{Deadline, Reserve},
    fit::solid::Solid,
    mass,
    progress::Stage,
};

/// The limit of level 0, relative to the diagonal.
const ORIGIN: f64 = 0.02;

/// Number of levels in which the limit doubles.
const PER_OCTAVE: i32 = 16;

/// Number of levels between those that serve maximum errors. The others serve numbers of parts.
const STEP: i32 = 4;

/// Smallest limit of a search, relative to the diagonal. Parts are moved outward by up to a tenth.
const LEAST_ERROR: f64 = 2e-5;

/// Smallest limit relative to the greatest coordinate, for meshes far from the origin. Rounding to
/// f32 moves a vertex by up to 2e-7 of the coordinate; a cell may protrude by 8 % of the limit.
const LEAST_ROUNDED: f64 = 1e-5;

/// Maximum number of parts made by halving, the result if the deadline has already passed.
const HALVED: usize = 8;

/// Smallest limit that is searched for fewer parts, relative to the diagonal.
const LEAST_FOR_FEWER: f64 = 5e-3;

/// Number of levels that serve a maximum error below that.
const FEW: i32 = 3;

/// A level is given up when it has more parts before mergers than the first of these times the
/// number of the best level, plus the second.
const FEWER_LATER: (f64, f64) = (1.35, 24.0);

/// Factor if the parts of the best level were merged to far fewer.
const MERGED_LATER: f64 = 2.0;

/// Factor and addend: parts were merged to far fewer if there were more before mergers than this.
const FAR_FEWER: (f64, f64) = (1.35, 8.0);

/// A level ends the search if it has more parts than this after mergers, and more than the best
/// level's plus an eighth and 4. Searches for fewer parts do not take long.
const MAX_MERGED_PARTS: usize = 40;

/// A level also ends the search if it is given up, or is not merged, at more parts before mergers
/// than this.
const MAX_PARTS_BEFORE_MERGERS: usize = 200;

/// Number of parts before mergers, of all levels together, after which a search ends if the best
/// level has more than [`MAX_MERGED_PARTS`] parts. Each takes about 0.04 s: this bounds the time.
const MOST_IN_ALL: usize = 500;

/// The level of a limit that is never needed: parts may protrude by more than the mesh's size.
const HIGHEST: i32 = 96;

/// First distance between levels that are tried for a number of parts. It doubles upward.
const STRIDE: i32 = 16;

/// Number of levels between few enough parts and too many at which the search ends.
const CLOSE_ENOUGH: i32 = 2;

/// Limits for which parts are divided further where there may be more, relative to what they reach.
const FURTHER: [f64; 3] = [0.5, 0.7, 0.85];

/// The lowest level at which the search for a number of parts starts: 1 % of the diagonal.
const LOWEST_FIRST: i32 = -PER_OCTAVE;

/// Maximum number of searches for a number of parts.
const MAX_SEARCHES: usize = 5;

/// Maximum number of searches of a whole surface after its half: slower, but they start near the
/// end.
const MAX_AFTER_HALF: usize = 2;

/// Smallest limit, relative to the diagonal, that is searched only for tighter parts.
const LEAST_FOR_TIGHTNESS: f64 = 1e-3;

/// Smallest limit that is searched for a number of parts, relative to the diagonal. Below it, more
/// parts only follow the tessellation.
const LEAST_FOR_COUNTS: f64 = 2e-3;

/// Time that a search leaves for final hulls.
const FINISHING: Reserve = Reserve { share: 0.2, seconds: 4.0 };

/// Number of levels down to about `count` parts, assuming an inverse proportion to the limit.
fn stride(count: usize, found: usize) -> i32 {
    let octaves = libm::log2(count as f64 / found.max(1) as f64);
    ((octaves * f64::from(PER_OCTAVE)) as i32 + 1).clamp(CLOSE_ENOUGH, 2 * STRIDE)
}

fn most_before_mergers(parts: usize) -> usize {
    (FAR_FEWER.0 * parts as f64 + FAR_FEWER.1) as usize
}

fn about(parts: usize) -> Useful {
    Useful { parts, divided: most_before_mergers(parts) }
}

pub struct Found {
    pub parts: Vec<Part>,
    /// Further parts, each of which stands for its mirror image, too.
    pub mirrored: Vec<Part>,
    pub fewest: usize,
    pub divided: usize,
    pub limit: f64,
}

impl Found {
    pub fn count(&self) -> usize {
        self.parts.len() + 2 * self.mirrored.len()
    }

    pub fn reached(&self) -> f64 {
        self.parts.iter().chain(&self.mirrored).map(|part| part.bound).fold(0.0, f64::max)
    }

    pub fn is_merged(&self) -> bool {
        self.divided > most_before_mergers(self.count())
    }

    fn useful(&self) -> Useful {
        let (factor, more) = if self.is_merged() { (MERGED_LATER, 0.0) } else { FEWER_LATER };
        let divided = (factor * self.divided as f64 + more) as usize;
        Useful { parts: self.count(), divided }
    }

    fn volume(&self) -> f64 {
        let volume = |parts: &[Part]| parts.iter().map(|part| mass::mass(&part.hull).volume).sum::<f64>();
        volume(&self.parts) + 2.0 * volume(&self.mirrored)
    }
}

/// The better of two results: one that is within the error, or the one whose parts have the smaller
/// volume. The second may be unproven.
fn better(best: Option<Found>, found: Option<Found>, error: f64) -> Option<Found> {
    // Infinity is no proof.
    let is_within = |found: &Found| found.reached() < f64::INFINITY && found.reached() <= error;
    match (best, found) {
        (Some(best), Some(found)) => {
            let is_better = !is_within(&best) && (is_within(&found) || found.volume() < best.volume());
            Some(if is_better { found } else { best })
        }
        (best, found) => best.or(found),
    }
}

pub struct Levels<'a> {
    pub surface: &'a Surface,
    pub field: Field<'a>,
    parameters: &'a Cover,
    max_vertices: usize,
    /// When the parts must be finished.
    deadline: Option<Deadline>,
    stage: Stage<'a>,
    /// Number of parts above which a result is unusable, if known.
    pub enough: Option<usize>,
    /// Protrusion above which a result with a maximum number of parts is unusable, if known.
    pub within: Option<f64>,
    searches: i32,
}

impl<'a> Levels<'a> {
    pub fn new(
        surface: &'a Surface,
        solid: &'a Solid,
        parameters: &'a Cover,
        max_vertices: usize,
        deadline: Option<Deadline>,
        stage: Stage<'a>,
    ) -> Self {
        Self {
            surface,
            field: Field::new(solid),
            parameters,
            max_vertices,
            deadline,
            stage,
            enough: None,
            within: None,
            searches: 0,
        }
    }

    fn diagonal(&self) -> f64 {
        self.field.solid().diagonal()
    }

    fn bounds(&self, limit: f64) -> HullLimits<'a> {
        let deadline = self.deadline.map(|deadline| deadline.with_reserve(FINISHING));
        HullLimits { deadline, ..self.final_bounds(limit) }
    }

    pub fn final_bounds(&self, limit: f64) -> HullLimits<'a> {
        let (max_vertices, diagonal) = (self.max_vertices, self.diagonal());
        let error = self.parameters.max_error.resolve(diagonal);
        let allowed = if self.parameters.max_parts.is_some() { limit } else { limit.min(error.max(self.least())) };
        let thickness = self.parameters.wall.resolve(diagonal).min(0.5 * allowed);
        HullLimits { limit, max_vertices, diagonal, thickness, deadline: self.deadline, stage: self.stage }
    }

    /// The final limits of thin parts that were found within `limit`, but may be as thick as the
    /// maximum error allows.
    pub fn bounds_of_thin_parts(&self, limit: f64) -> HullLimits<'a> {
        let is_counted = self.parameters.max_parts.is_some();
        self.final_bounds(if is_counted {
            limit
        } else {
            limit.max(self.parameters.max_error.resolve(self.diagonal()))
        })
    }

    fn is_over(&self) -> bool {
        self.bounds(0.0).is_over()
    }

    fn least(&self) -> f64 {
        let greatest = self.field.solid().bounds().map(|p| p.abs().max_element()).into_iter().fold(0.0, f64::max);
        (LEAST_ERROR * self.diagonal()).max(LEAST_ROUNDED * greatest)
    }

    fn limit(&self, level: i32) -> f64 {
        let share = ORIGIN * libm::exp2(f64::from(level) / f64::from(PER_OCTAVE));
        (share * self.diagonal()).max(self.least())
    }

    /// The highest level whose limit is at most `error`, of those `step` levels apart.
    fn level(&self, error: f64, step: i32) -> i32 {
        let mut level = HIGHEST;
        while self.limit(level) > error * (1.0 + 1e-9) && self.limit(level) > self.least() {
            level -= step;
        }
        level
    }

    pub fn parts(&mut self) -> Option<Found> {
        let error = self.parameters.max_error.resolve(self.diagonal());
        match self.parameters.max_parts {
            Some(count) => self.at_most(count as usize, error),
            None => self.fewest(error),
        }
    }

    /// Parts within the limit of a level; `None` if the time is over, or more than about `enough`
    /// parts are needed. Without peeling, the search takes less time.
    fn search(&mut self, level: i32, useful: Option<Useful>, peels: bool) -> Option<Found> {
        if self.is_over() {
            return None;
        }
        // Each search is expected to take half of the rest.
        let [from, to] = [self.searches, self.searches + 1].map(|count| 1.0 - libm::exp2(-f64::from(count)));
        self.searches += 1;
        let (limit, stage) = (self.limit(level), self.stage.from_to(from, to));
        let limits = PartitionLimits {
            bounds: HullLimits { stage, ..self.bounds(limit) },
            overlap: self.parameters.overlap,
            useful,
            wanted: self.parameters.max_parts.map_or(1, |count| count as usize),
            peels,
            bridges: self.parameters.max_parts.is_some(),
        };
        let partition::Merged { parts, mirrored, fewest, divided } =
            partition::search(self.surface, &mut self.field, &limits)?;
        Some(Found { parts, mirrored, fewest, divided, limit })
    }

    fn fewest(&mut self, error: f64) -> Option<Found> {
        let first = self.level(error, STEP);
        let last = self.last(first);
        let mut best: Option<Found> = self.rough(first);
        let samples = Samples::new(self.surface);
        let (mut level, mut needed, mut in_all) = (first, 0, 0);
        loop {
            let within = best.as_ref().filter(|best| best.limit <= error);
            let useful = within.map(Found::useful).or(self.enough.map(about));
            if let Some(Useful { parts: enough, .. }) = useful {
                // Lower limits need as many.
                needed = samples.needed(&self.field, self.limit(level)).max(needed);
                if needed > enough {
                    break;
                }
                if needed == enough && within.is_some_and(|best| !best.is_merged()) {
                    return best.map(|best| self.tightest(best, level, &samples));
                }
            }
            if level < last {
                break;
            }
            let found = self.search(level, useful, true);
            if self.is_over() {
                return better(best, found, error);
            }
            level -= STEP;
            let is_hopeless = useful.is_some_and(|useful| match &found {
                Some(found) if found.count() < found.divided => {
                    found.count() > MAX_MERGED_PARTS.max(useful.parts + useful.parts / 8 + 4)
                }
                Some(found) => found.divided > MAX_PARTS_BEFORE_MERGERS,
                None => useful.divided > MAX_PARTS_BEFORE_MERGERS,
            });
            in_all += found.as_ref().map_or(useful.map_or(0, |useful| useful.divided), |found| found.divided);
            let is_useful = |found: &Found| useful.is_none_or(|useful| found.count() <= useful.parts);
            best = found.filter(is_useful).or(best);
            let is_long = in_all > MOST_IN_ALL && best.as_ref().is_some_and(|best| best.count() > MAX_MERGED_PARTS);
            if is_hopeless || is_long {
                break;
            }
        }
        best
    }

    fn last(&self, first: i32) -> i32 {
        let [fewer, tighter] = [LEAST_FOR_FEWER, LEAST_FOR_TIGHTNESS].map(|s| self.level(s * self.diagonal(), STEP));
        if first >= fewer { fewer } else { (first - (FEW - 1) * STEP).max(tighter.min(first)) }
    }

    /// The next of the levels from `level` down to `last` for tighter parts.
    fn next(&self, found: &Found, level: i32, last: i32) -> i32 {
        // The levels between would give parts that are no tighter.
        if found.reached() < self.limit(last) { level.min(last) } else { level }
    }

    /// The parts with the lowest limit among those as few as `best`, which is known to be the
    /// fewest.
    fn tightest(&mut self, best: Found, level: i32, samples: &Samples) -> Found {
        let last = self.level(LEAST_FOR_TIGHTNESS * self.diagonal(), STEP);
        let of_level = |levels: &mut Self, level: i32, best: &Found| {
            let needed = samples.needed(&levels.field, levels.limit(level));
            let useful = Some(best.useful()).filter(|useful| needed <= useful.parts)?;
            let found = levels.search(level, Some(useful), true)?;
            (found.count() <= useful.parts && !levels.is_over()).then_some(found)
        };
        let octave = |level: i32| level.div_euclid(PER_OCTAVE) * PER_OCTAVE;
        let (mut level, mut best) = (self.next(&best, level, last), best);
        while octave(level) >= last {
            let Some(found) = of_level(self, octave(level), &best) else { break };
            level = self.next(&found, octave(level) - STEP, last);
            best = found;
        }
        let end = last.max(octave(level) + 1);
        while level >= end {
            let Some(found) = of_level(self, level, &best) else { break };
            level = self.next(&found, level - STEP, last);
            best = found;
        }
        best
    }

    /// Parts of a larger error, in case the time runs out; `None` without a deadline.
    fn rough(&mut self, first: i32) -> Option<Found> {
        let mut best = self.halved(HALVED);
        for octaves in [3, 1] {
            if best.is_none() || self.is_over() {
                break;
            }
            let found = self.search(first + octaves * PER_OCTAVE, None, false);
            best = better(best, found, 0.0);
        }
        best
    }

    /// The first parts of a search whose time is limited, at most `count`; `None` if it is not.
    fn halved(&self, count: usize) -> Option<Found> {
        self.deadline?;
        // Nothing protrudes by more.
        let limit = self.diagonal();
        let is_half = self.surface.mirror.is_some();
        let count = if is_half { count / 2 } else { count };
        let halved = partition::halved(self.surface, &self.bounds(limit), count.min(HALVED));
        let (parts, mirrored) = if is_half { (Vec::new(), halved) } else { (halved, Vec::new()) };
        let mut found = Found { parts, mirrored, fewest: 0, divided: 0, limit };
        (found.fewest, found.divided) = (found.count(), found.count());
        (found.fewest > 1).then_some(found)
    }

    /// At most `count` parts, with the least protrusion. The search starts at `error`, or at a
    /// level that needs few searches for a small number. With `within`, it starts there and goes no
    /// higher.
    fn at_most(&mut self, count: usize, error: f64) -> Option<Found> {
        // The lowest level known to have few enough parts, and the highest with too many.
        let (mut best, mut low) = (None::<(i32, Found)>, None::<i32>);
        let usual = || self.level(error, 1).max(LOWEST_FIRST);
        let (mut level, mut rise) = (self.within.map_or_else(usual, |within| self.level(within, 1)), STRIDE / 2);
        // Strides, until a level with few enough parts and one with too many are known; then
        // halves.
        let searches = if self.within.is_some() { MAX_AFTER_HALF } else { MAX_SEARCHES };
        for _ in 0..searches {
            if self.limit(level) < LEAST_FOR_COUNTS * self.diagonal() {
                break;
            }
            let enough = count + (count / 4).max(2);
            let found = self.search(level, Some(about(enough)), true);
            if self.is_over() {
                let best = best.map(|(_, found)| found).or_else(|| self.halved(count));
                return better(best, found.filter(|found| found.count() <= count), f64::INFINITY);
            }
            match found {
                Some(found) if found.count() <= count => {
                    best = Some((self.level(found.reached(), 1).min(level), found));
                }
                _ => low = Some(level),
            }
            level = match (&best, low) {
                (Some((best, _)), Some(low)) if best - low <= CLOSE_ENOUGH => break,
                (Some((best, _)), Some(low)) => low + (best - low) / 2,
                (Some((best, found)), None) => best - stride(count, found.fewest),
                (None, _) if level == HIGHEST || self.within.is_some() => break,
                (None, _) => {
                    rise *= 2;
                    (level + rise).min(HIGHEST)
                }
            };
        }
        best.map(|(_, found)| self.refined(found, count))
    }

    /// Divides some parts if more are allowed.
    fn refined(&mut self, found: Found, count: usize) -> Found {
        let (reached, mut found) = (found.reached(), found);
        for limit in FURTHER.map(|share| share * reached) {
            let is_useful = limit.is_finite() && limit >= LEAST_FOR_TIGHTNESS * self.diagonal();
            if found.count() >= count || !is_useful {
                break;
            }
            let bounds = self.bounds(limit);
            // A part that is its own image cannot be divided into such parts.
            let (divisible, count) = match self.surface.mirror {
                Some(_) => (&mut found.mirrored, (count - found.parts.len()) / 2),
                None => (&mut found.parts, count),
            };
            let parts = std::mem::take(divisible);
            *divisible = partition::divided_further(self.surface, &mut self.field, bounds, parts, count);
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use shapes::{concave, mesh::Mesh};

    use super::*;
    use crate::decompose::tests::point_set;

    /// 150 bodies in the shape of an L, in a grid. Their hulls protrude by 1.75 % of the diagonal:
    /// one part each within the level of 2 %, and two within the next one, of 1.68 %.
    fn bodies() -> Mesh {
        let body = concave::l();
        let mut mesh = Mesh::default();
        for place in 0..150 {
            let corner = [place % 5, place / 5 % 5, place / 25].map(|n| 4.6 * n as f32);
            let first = mesh.vertices.len() as u32;
            mesh.vertices.extend(body.vertices.iter().map(|p| [0, 1, 2].map(|k| p[k] + corner[k])));
            mesh.faces.extend(body.faces.iter().map(|face| face.iter().map(|v| v + first).collect::<Vec<_>>()));
        }
        mesh
    }

    #[test]
    fn lower_levels_with_many_more_parts_end_the_search() {
        let mesh = point_set(&bodies());
        let (surface, solid, cover) = (Surface::new(&mesh), Solid::new(&mesh), Cover::default());
        let mut levels = Levels::new(&surface, &solid, &cover, 64, None, Stage::default());
        assert_eq!((levels.parts().unwrap().count(), levels.searches), (150, 2));
    }
}
