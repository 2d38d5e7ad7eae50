//! The clearance of a robot in one configuration, and its derivatives: the distance of the nearest
//! pair, or minus the depth of the deepest pair.
//!
//! 1. Bound the distance of each couple of links from below, by the balls around them.
//! 2. Compute the distance of the couple with the least bound, then of all with lower bounds than
//!    the least distance.
//! 3. If bodies overlap, compute the depths of all pairs whose balls overlap.

use glam::DVec3;
use hullmap::{Contact, Derivatives, Differentiability, Distance, Pose, PoseDerivative, Settings, Status};
use hullmap_robot::Motion;

use crate::error::PlanningError;
use crate::memory::Memory;
use crate::robot::{BodyOrObstacle, Robot};

/// Clearance of a robot in a configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotClearance {
    /// Lower bound of the clearance, with allowance for rounding: the least distance of all tested
    /// pairs, minus the depth of the deepest one if pairs overlap, or infinity without pairs.
    pub lower: f64,
    /// Upper bound: the pair that decides is at most this far apart.
    pub upper: f64,
    /// The colliders of the pair that decides, the lower index first; `None` if there is no pair.
    pub colliders: Option<[usize; 2]>,
    /// How the query of the pair ended.
    pub status: Status,
    /// Unit vector from the first collider to the second one, in the world.
    pub normal: DVec3,
    /// Points of the colliders that are closest to each other, or deepest inside, in the world.
    pub points: [DVec3; 2],
}

impl RobotClearance {
    /// The clearance of a robot without pairs.
    pub const NO_PAIR: Self = Self {
        lower: f64::INFINITY,
        upper: f64::INFINITY,
        colliders: None,
        status: Status::Separated,
        normal: DVec3::X,
        points: [DVec3::ZERO; 2],
    };
}

impl Default for RobotClearance {
    fn default() -> Self {
        Self::NO_PAIR
    }
}

#[derive(Clone, Copy)]
enum Answer {
    Apart(Distance),
    Overlapping(Contact),
}

struct Decided {
    pair: usize,
    answer: Answer,
    lower: f64,
    upper: f64,
    /// Whether another pair is as near within the interval.
    is_tied: bool,
}

struct Least {
    first: (f64, usize),
    second: f64,
}

impl Least {
    const NONE: Self = Self { first: (f64::INFINITY, usize::MAX), second: f64::INFINITY };

    fn add(&mut self, lower: f64, pair: usize) {
        if lower < self.first.0 {
            self.second = self.first.0;
            self.first = (lower, pair);
        } else {
            self.second = self.second.min(lower);
        }
    }

    fn of_others(&self, pair: usize) -> f64 {
        if self.first.1 == pair { self.second } else { self.first.0 }
    }
}

impl Robot {
    /// The clearance in a configuration, against the robot itself and all obstacles.
    ///
    /// # Errors
    /// The length of `q` is not the number of joints, or a number is out of range.
    ///
    /// # Complexity
    /// A few comparisons for each couple of links, and a distance query for each pair that may be
    /// the nearest. No allocation after the first calls.
    pub fn clearance(
        &self,
        q: &[f64],
        settings: &Settings,
        memory: &mut Memory,
    ) -> Result<RobotClearance, PlanningError> {
        self.place(q, memory)?;
        Ok(self.decide(settings, memory).map_or(RobotClearance::NO_PAIR, |found| self.answer(&found, memory)))
    }

    /// As [`clearance`](Self::clearance), for given poses of all links in the world.
    ///
    /// # Errors
    /// There are more or fewer poses than links.
    pub fn clearance_at(
        &self,
        poses: &[Pose],
        settings: &Settings,
        memory: &mut Memory,
    ) -> Result<RobotClearance, PlanningError> {
        self.place_at(poses, memory)?;
        Ok(self.decide(settings, memory).map_or(RobotClearance::NO_PAIR, |found| self.answer(&found, memory)))
    }

    /// The clearance in a configuration, and its derivatives by the configuration's numbers, in
    /// `gradient`: metres for each radian of a hinge and for each metre of a slider.
    ///
    /// If the status is not [`Unique`](Differentiability::Unique), they are only a direction for an
    /// optimiser, not derivatives: see [`Derivatives`]. If another pair is equally near within the
    /// interval, it is [`Normals`](Differentiability::Normals).
    ///
    /// # Errors
    /// As for [`clearance`](Self::clearance), or `gradient` has another length than `q`.
    ///
    /// # Complexity
    /// As [`clearance`](Self::clearance), plus a dozen support queries and O(joints).
    pub fn clearance_gradient(
        &self,
        q: &[f64],
        settings: &Settings,
        memory: &mut Memory,
        gradient: &mut [f64],
    ) -> Result<(RobotClearance, Differentiability), PlanningError> {
        if gradient.len() != self.joints.len() {
            return Err(PlanningError::JointCount { expected: self.joints.len(), found: gradient.len() });
        }
        self.place(q, memory)?;
        gradient.fill(0.0);
        let Some(decided) = self.decide(settings, memory) else {
            return Ok((RobotClearance::NO_PAIR, Differentiability::Missing));
        };
        let answer = self.answer(&decided, memory);
        let pairing = self.pairing(decided.pair, memory);
        let found = match &decided.answer {
            Answer::Apart(found) => pairing.distance_derivatives(found),
            Answer::Overlapping(found) => pairing.contact_derivatives(found, settings, &mut memory.caches),
        };
        let Some(found) = found else { return Ok((answer, Differentiability::Inaccurate)) };
        let sign = if matches!(decided.answer, Answer::Overlapping(_)) { -1.0 } else { 1.0 };
        self.by_joints(decided.pair, &found, sign, memory, gradient);
        let is_tied = decided.is_tied && found.status == Differentiability::Unique;
        Ok((answer, if is_tied { Differentiability::Normals } else { found.status }))
    }

    fn decide(&self, settings: &Settings, memory: &mut Memory) -> Option<Decided> {
        let gap = |couple: usize, memory: &Memory| self.couple_gap(&self.couples[couple], memory);
        let count = self.couples.len();
        let first = (0..count).map(|couple| (gap(couple, memory), couple)).min_by(|a, b| a.0.total_cmp(&b.0))?.1;
        let mut least = Least::NONE;
        let mut nearest: Option<(f64, usize, Distance)> = None;
        let others = (0..count).filter(|couple| *couple != first);
        for couple in std::iter::once(first).chain(others) {
            let limit = nearest.as_ref().map_or(f64::INFINITY, |found| found.0);
            if self.couple_gap(&self.couples[couple], memory) > limit {
                continue;
            }
            for index in self.couples[couple].pairs.clone() {
                let pair = &self.pairs[index];
                let limit = nearest.as_ref().map_or(f64::INFINITY, |found| found.0);
                if self.pair_gap(pair, memory) > limit {
                    continue;
                }
                let found = self.pairing(index, memory).distance(settings, &mut memory.caches);
                let noise = self.pair_noise(pair, memory);
                if found.status == Status::Overlapping {
                    // If no depth is certain, it is only known that the pair overlaps.
                    let (lower, upper) = (f64::NEG_INFINITY, noise);
                    let unknown = Decided { pair: index, answer: Answer::Apart(found), lower, upper, is_tied: false };
                    return self.deepest(index, settings, memory).or(Some(unknown));
                }
                least.add(found.lower - noise, index);
                let upper = found.upper + noise;
                if nearest.as_ref().is_none_or(|best| upper < best.0) {
                    nearest = Some((upper, index, found));
                }
            }
        }
        let (upper, pair, found) = nearest?;
        memory.last = pair;
        let is_tied = least.of_others(pair) <= upper;
        Some(Decided { pair, answer: Answer::Apart(found), lower: least.first.0, upper, is_tied })
    }

    /// The pair that overlaps most. `known` overlaps.
    fn deepest(&self, known: usize, settings: &Settings, memory: &mut Memory) -> Option<Decided> {
        let mut least = Least::NONE;
        let mut deepest: Option<(f64, usize, Contact)> = None;
        for couple in 0..self.couples.len() {
            if self.couple_gap(&self.couples[couple], memory) > 0.0 {
                continue;
            }
            for index in self.couples[couple].pairs.clone() {
                let pair = &self.pairs[index];
                if index != known && self.pair_gap(pair, memory) > 0.0 {
                    continue;
                }
                let found = self.pairing(index, memory).contact(settings, &mut memory.caches);
                if !found.hit {
                    continue;
                }
                let noise = self.pair_noise(pair, memory);
                least.add(-found.depth_upper - noise, index);
                let upper = -found.depth_lower + noise;
                if deepest.as_ref().is_none_or(|best| upper < best.0) {
                    deepest = Some((upper, index, found));
                }
            }
        }
        let (upper, pair, found) = deepest?;
        memory.last = pair;
        let is_tied = least.of_others(pair) <= upper;
        Some(Decided { pair, answer: Answer::Overlapping(found), lower: least.first.0, upper, is_tied })
    }

    fn answer(&self, decided: &Decided, memory: &Memory) -> RobotClearance {
        let pair = &self.pairs[decided.pair];
        let a = self.frame_of_a(pair, memory);
        let (status, normal, points) = match &decided.answer {
            Answer::Apart(found) => (found.status, found.normal, [found.point_a, found.point_b]),
            Answer::Overlapping(found) => (found.status, found.normal, [found.point_a, found.point_b]),
        };
        let (normal, mut points) = (a.rotation * normal, points.map(|point| a.apply(point)));
        // The link comes first.
        let is_obstacle = matches!(pair.a, BodyOrObstacle::Obstacle(_));
        if is_obstacle {
            points.reverse();
        }
        RobotClearance {
            lower: decided.lower,
            upper: decided.upper,
            colliders: Some(self.colliders_of(decided.pair)),
            status,
            normal: if is_obstacle { -normal } else { normal },
            points,
        }
    }

    /// Derivatives with respect to the numbers of a configuration, from derivatives with respect to
    /// the poses of a pair.
    fn by_joints(&self, pair: usize, found: &Derivatives, sign: f64, memory: &Memory, gradient: &mut [f64]) {
        let pair = &self.pairs[pair];
        let frame_a = self.frame_of_a(pair, memory);
        let Ok(a_in_world) = Pose::new(frame_a.translation, frame_a.rotation) else { return };
        let found = found.in_world(a_in_world);
        let mut by_joints = vec![0.0; memory.at.axes.len()];
        let mut add = |body: usize, by: PoseDerivative| {
            let origin = self.body_frame(body, memory).translation;
            for &joint in &self.kinematics.path(self.bodies[body].link)[pair.shared..] {
                let [axis, anchor] = memory.at.axes[joint];
                by_joints[joint] += sign
                    * match self.kinematics.joint(joint).motion {
                        Motion::Hinge => by.linear.dot(axis.cross(origin - anchor)) + by.angular.dot(axis),
                        _ => by.linear.dot(axis),
                    };
            }
        };
        if let BodyOrObstacle::Body(a) = pair.a {
            add(a, found.by_a);
        }
        add(pair.b, found.by_b);
        self.kinematics.by_variables(&memory.at, &mut by_joints, gradient);
    }
}
