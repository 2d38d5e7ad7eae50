//! Whether an edge in joint space is free: proven for all configurations, not only for samples.
//!
//! # Steps
//! 1. Test both ends. An end that certainly touches is a hit.
//! 2. In the middle of an interval, bound how far each body moves from there (`motion_bound`). A
//!    pair whose distance exceeds the motion of both is apart in the whole interval.
//! 3. Test the remaining pairs in both halves of the interval, the earlier half first.
//! 4. If the edge is free, but the proven clearance is low, repeat with a higher target.
//!
//! # Reference
//! Schwarzer, Saha, Latombe 2005. docs/contributors/intervals.md, section 17, has the proof.

use hullmap::{Clearance, Settings, Status, Verdict};

use crate::error::PlanningError;
use crate::memory::Memory;
use crate::motion_bound::motions;
use crate::robot::{BodyOrObstacle, Robot};

/// Maximum number of halvings: a link of a metre then moves by less than a picometre per radian.
const MAX_DEPTH: u32 = 40;

const DISTANCES: Settings = Settings { tolerance: 1e-3, max_iterations: Settings::DEFAULT_MAX_ITERATIONS };

/// Settings of a distance that decides whether a pair is within the margin: with a tolerance, pairs
/// near the margin would be undecided for longer than the resolution.
const EXACT: Settings = Settings { tolerance: 0.0, ..DISTANCES };

/// Greatest share of the least distance for a clearance: 1 leaves no room for motion.
const MAX_SHARE: f64 = 0.95;

/// Settings of [`Robot::clear`]: what it proves, and at what cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeSettings {
    /// Pairs that come within this distance hit each other: a length, 0 by default. NaN and
    /// negative values count as 0.
    pub margin: f64,
    /// The interval of the first hit is at most this share of the edge, or its status is not
    /// [`Within`](Status::Within). The default is 1e-3. NaN and negative values count as 0.
    pub resolution: f64,
    /// The clearance of a free edge is at least this share of the least distance that was computed,
    /// or its status is not [`Within`](Status::Within). The default is 0.5. 0 saves the second
    /// search. NaN and negative values count as 0, values above 0.95 as 0.95.
    pub share: f64,
    /// Maximum number of distance and contact queries. The default is 10,000. If it is reached, the
    /// edge may be open.
    pub max_queries: u32,
}

impl Default for EdgeSettings {
    fn default() -> Self {
        Self { margin: 0.0, resolution: 1e-3, share: 0.5, max_queries: 10_000 }
    }
}

/// Answer of [`Robot::clear`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EdgeClearance {
    /// Whether the edge is free, and with which clearance; or where the first hit is. Times are
    /// shares of the edge. `support_calls` is 0.
    ///
    /// The status is [`Within`](Status::Within) for a hit whose interval is as narrow as the
    /// resolution, and for a free edge whose clearance is the requested share. Otherwise it is
    /// [`IterationLimit`](Status::IterationLimit), or [`Stalled`](Status::Stalled): rounding error
    /// leaves the rest undecided.
    pub answer: Clearance,
    /// The colliders that hit each other, or are nearest, the lower index first; `None` if unknown.
    pub colliders: Option<[usize; 2]>,
}

impl Robot {
    /// Whether the robot stays clear of itself and of all obstacles along an edge: while the
    /// numbers of its configuration change linearly from `start` to `end`.
    ///
    /// A *free* edge is free in each of its configurations. For a *hit*, the first touch is in the
    /// interval from `t_lower` to `t_upper`. An *open* edge is free up to `t_lower`; what follows
    /// grazes, or the limit of queries was reached.
    ///
    /// # Errors
    /// The length of `start` or `end` is not the number of joints, or a number is out of range.
    ///
    /// # Complexity
    /// One or two configurations if the clearance is large compared with the edge; otherwise about
    /// the length of the edge divided by its clearance. No allocation after the first calls.
    pub fn clear(
        &self,
        start: &[f64],
        end: &[f64],
        settings: &EdgeSettings,
        memory: &mut Memory,
    ) -> Result<EdgeClearance, PlanningError> {
        let mut magnitudes = [0.0; 2];
        let margin = settings.margin.max(0.0);
        let mut search = EdgeSearch {
            robot: self,
            ends: [start, end],
            magnitudes,
            margin,
            share: 0.0,
            resolution: settings.resolution.max(0.0),
            budget: settings.max_queries,
            until: f64::INFINITY,
            open_from: None,
            clearance: f64::INFINITY,
            nearest: (f64::INFINITY, None),
            hit: None,
        };
        for (t, q) in [(0.0, start), (1.0, end)] {
            self.place(q, memory)?;
            let own = memory.at.magnitudes();
            magnitudes = [magnitudes[0] + own[0], magnitudes[1] + own[1]];
            search.try_end(t, memory);
            if search.until == 0.0 {
                self.place(end, memory)?;
                return Ok(search.answer(settings));
            }
        }
        search.magnitudes = magnitudes;
        search.run(memory);
        let mut found = search.answer(settings);
        search.share = settings.share.clamp(0.0, MAX_SHARE).max(0.0);
        if found.answer.verdict == Verdict::Free && found.answer.clearance < search.target() {
            search.clearance = f64::INFINITY;
            search.run(memory);
            if search.until == f64::INFINITY && search.open_from.is_none() {
                found.answer.clearance = found.answer.clearance.max(search.clearance);
            } else {
                found.answer.status = search.stopped();
            }
            found.answer.iterations = settings.max_queries - search.budget;
            found.answer.nearest = search.nearest.0;
        }
        Ok(found)
    }
}

struct EdgeSearch<'s> {
    robot: &'s Robot,
    ends: [&'s [f64]; 2],
    /// Sums of the displacements of both ends, for rounding errors.
    magnitudes: [f64; 2],
    margin: f64,
    /// Share of the least distance to prove for each pair; 0 at first.
    share: f64,
    resolution: f64,
    budget: u32,
    /// The earliest time at which a pair is certainly within the margin.
    until: f64,
    /// The start of the first interval that is not decided.
    open_from: Option<f64>,
    /// Proven distance of all pairs.
    clearance: f64,
    nearest: (f64, Option<usize>),
    hit: Option<usize>,
}

impl EdgeSearch<'_> {
    /// Tests whether the robot, which is placed at an end, certainly hits.
    fn try_end(&mut self, t: f64, memory: &mut Memory) {
        let robot = self.robot;
        for couple in &robot.couples {
            if robot.couple_gap(couple, memory) > self.margin {
                continue;
            }
            for pair in couple.pairs.clone() {
                if robot.pair_gap(&robot.pairs[pair], memory) > self.margin || self.budget == 0 {
                    continue;
                }
                let found = self.query(pair, memory);
                if found.is_hit {
                    (self.until, self.hit) = (t, Some(pair));
                    return;
                }
            }
        }
    }

    fn run(&mut self, memory: &mut Memory) {
        let count = self.robot.pairs.len();
        memory.edge.open.clear();
        memory.edge.open.extend(0..count as u32);
        self.visit([0.0, 1.0], MAX_DEPTH, count, memory);
    }

    /// The distance to prove for each pair. It never rises.
    fn target(&self) -> f64 {
        if self.share > 0.0 { self.margin.max(self.share * self.nearest.0) } else { self.margin }
    }

    /// Whether the remaining intervals cannot change the answer.
    fn is_done(&self) -> bool {
        self.open_from.is_some() && (self.until < f64::INFINITY || self.budget == 0 || self.share > 0.0)
    }

    /// Decides the last `count` open pairs in an interval, whose start is certainly free.
    fn visit(&mut self, [start, end]: [f64; 2], depth: u32, count: usize, memory: &mut Memory) {
        if start >= self.until || self.is_done() {
            return;
        }
        if self.budget == 0 {
            self.open_from.get_or_insert(start);
            return;
        }
        let mid = 0.5 * (start + end);
        self.place(mid, 0.5 * (end - start), memory);
        let first = memory.edge.open.len();
        for at in first - count..first {
            let pair = memory.edge.open[at];
            if !self.is_proven(pair as usize, mid, memory) {
                memory.edge.open.push(pair);
            }
        }
        let left = memory.edge.open.len() - first;
        if left > 0 {
            let is_fine = self.until.min(end) - start <= self.resolution;
            // Stop at this width if a hit follows in the interval, or if an earlier interval is
            // open: then only hits matter.
            let is_last = is_fine && (self.until <= end || self.open_from.is_some());
            if depth == 0 || is_last {
                self.open_from.get_or_insert(start);
            } else {
                self.visit([start, mid], depth - 1, left, memory);
                self.visit([mid, end], depth - 1, left, memory);
            }
        }
        memory.edge.open.truncate(first);
    }

    /// Places the robot at a time, with bounds for times that are at most `half` away.
    fn place(&self, t: f64, half: f64, memory: &mut Memory) {
        let (robot, [start, end]) = (self.robot, self.ends);
        let mut q = std::mem::take(&mut memory.edge.q);
        q.clear();
        q.extend(start.iter().zip(end).map(|(start, end)| start + (end - start) * t));
        robot.kinematics.place(&q, &mut memory.at);
        memory.edge.q = q;
        memory.at.set_magnitudes(self.magnitudes);
        robot.place_links(memory);
        let width = |variable: usize| (end[variable] - start[variable]).abs() * half;
        robot.kinematics.spans(width, &memory.at, &mut memory.edge.spans);
        memory.edge.stamp += 1;
    }

    /// Upper bound of how far the joints of its path from `shared` on move a body in the interval.
    fn motion(&self, body: usize, shared: usize, memory: &mut Memory) -> f64 {
        if memory.edge.stamps[body] != memory.edge.stamp {
            let robot = self.robot;
            let own = &robot.bodies[body];
            let frame = robot.body_frame(body, memory);
            let path = (&robot.kinematics, robot.kinematics.path(own.link));
            let placed = (frame, own.bounds, memory.noise[own.link]);
            motions(path, placed, &memory.at, &memory.edge.spans, &mut memory.edge.motions[body]);
            memory.edge.stamps[body] = memory.edge.stamp;
        }
        memory.edge.motions[body].get(shared).copied().unwrap_or(0.0)
    }

    /// Whether a pair is certainly farther apart than the target in the interval around `mid`.
    fn is_proven(&mut self, index: usize, mid: f64, memory: &mut Memory) -> bool {
        let robot = self.robot;
        let pair = &robot.pairs[index];
        let mut motion = self.motion(pair.b, pair.shared, memory);
        if let BodyOrObstacle::Body(a) = pair.a {
            motion += self.motion(a, pair.shared, memory);
        }
        let gap = robot.pair_gap(pair, memory);
        if self.proves(gap - motion) {
            return true;
        }
        let far = robot.reach(pair, memory);
        if let Some(far) = far.filter(|far| *far < self.nearest.0) {
            self.nearest = (far, Some(index));
        }
        // Balls that are apart do not hit, and points of the bodies may be too near for a proof.
        let is_hopeless = gap > self.margin && far.is_some_and(|far| far - motion <= self.target());
        if is_hopeless || self.budget == 0 {
            return false;
        }
        let found = self.query(index, memory);
        if found.is_hit && mid < self.until {
            (self.until, self.hit) = (mid, Some(index));
        }
        self.proves(found.lower - motion)
    }

    fn proves(&mut self, least: f64) -> bool {
        // NaN takes the failing branch.
        let is_proof = least > self.target();
        if is_proof {
            self.clearance = self.clearance.min(least);
        }
        is_proof
    }

    fn query(&mut self, index: usize, memory: &mut Memory) -> Queried {
        let pair = &self.robot.pairs[index];
        let noise = self.robot.pair_noise(pair, memory);
        let pairing = self.robot.pairing(index, memory);
        let mut gap = pairing.distance(&DISTANCES, &mut memory.caches);
        self.budget -= 1;
        let is_undecided = gap.lower - noise <= self.margin && self.margin < gap.upper + noise;
        if self.margin > 0.0 && is_undecided && self.budget > 0 {
            gap = pairing.distance(&EXACT, &mut memory.caches);
            self.budget -= 1;
        }
        let upper = gap.upper + noise;
        if upper < self.nearest.0 {
            self.nearest = (upper, Some(index));
        }
        let mut is_hit = self.margin > 0.0 && upper <= self.margin;
        if gap.status == Status::Overlapping && !is_hit && self.budget > 0 {
            // The poses have rounding errors, too.
            let found = pairing.contact(&DISTANCES, &mut memory.caches);
            self.budget -= 1;
            is_hit = found.hit && found.depth_lower > noise;
        }
        Queried { lower: gap.lower - noise, is_hit }
    }

    fn stopped(&self) -> Status {
        if self.budget == 0 { Status::IterationLimit } else { Status::Stalled }
    }

    fn answer(&self, settings: &EdgeSettings) -> EdgeClearance {
        let iterations = settings.max_queries - self.budget;
        let (nearest, near) = self.nearest;
        let known = Clearance { status: Status::Within, nearest, iterations, ..Clearance::default() };
        let colliders = |pair: Option<usize>| pair.map(|pair| self.robot.colliders_of(pair));
        if self.until < f64::INFINITY {
            let t_lower = self.open_from.map_or(self.until, |open| open.min(self.until));
            // NaN takes the failing branch.
            let is_narrow = self.until - t_lower <= self.resolution;
            let status = if is_narrow { Status::Within } else { self.stopped() };
            let answer = Clearance { verdict: Verdict::Hit, status, t_lower, t_upper: self.until, ..known };
            return EdgeClearance { answer, colliders: colliders(self.hit) };
        }
        let colliders = colliders(near);
        match self.open_from {
            Some(t_lower) => {
                let answer = Clearance { verdict: Verdict::Open, status: self.stopped(), t_lower, ..known };
                EdgeClearance { answer, colliders }
            }
            None => {
                let (clearance, t_lower) = (self.clearance, f64::INFINITY);
                EdgeClearance { answer: Clearance { verdict: Verdict::Free, clearance, t_lower, ..known }, colliders }
            }
        }
    }
}

struct Queried {
    /// Lower bound of its distance, with allowance for rounding.
    lower: f64,
    /// Whether the distance is certainly within the margin.
    is_hit: bool,
}
