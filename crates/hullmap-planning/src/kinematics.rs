//! Forward kinematics without allocation: where links are, and how joints move them.
//!
//! # Steps
//! 1. Links without a joint are rigid parts of the nearest link above them that has one. So only
//!    links with joints are computed, parents first.
//! 2. Each of them is placed in its parent by its frame at rest, then by each of its joints.
//!
//! A configuration has one number for each hinge and each slider that follows no other joint. Ball
//! joints and free joints stay where they are at rest. To move them, pass the poses of links.

use glam::{DQuat, DVec3};
use hullmap_robot::{Chain, Coupling, Frame, Motion};

#[derive(Clone, Debug)]
pub struct Joint {
    pub motion: Motion,
    axis: DVec3,
    anchor: DVec3,
    reference: f64,
    coupling: Option<Coupling>,
    variable: Option<usize>,
}

#[derive(Clone, Debug)]
struct Mover {
    parent: Option<usize>,
    /// Its frame in the parent's while its joints are at their references.
    rest: Frame,
    /// Its joints, in the order in which they move it.
    joints: Vec<usize>,
}

/// A link, and the moved link that it is a rigid part of.
#[derive(Clone, Debug)]
struct Carried {
    mover: usize,
    in_mover: Frame,
    /// Number of compositions of frames from the root to the link.
    steps: f64,
    /// Sum of all lengths on the path from the root, without the displacements of sliders.
    length: f64,
}

#[derive(Clone, Debug)]
pub struct Kinematics {
    movers: Vec<Mover>,
    joints: Vec<Joint>,
    /// The joints that follow others, leaders first.
    followers: Vec<usize>,
    variables: Vec<usize>,
    links: Vec<Carried>,
    /// For each mover, the hinges and sliders from the root to it.
    paths: Vec<Vec<usize>>,
}

#[derive(Clone, Debug, Default)]
pub struct Placement {
    displacements: Vec<f64>,
    movers: Vec<Frame>,
    /// Axis of each joint, and a point of it, in the world.
    pub axes: Vec<[DVec3; 2]>,
    turn: f64,
    slide: f64,
}

impl Placement {
    /// Sums of the magnitudes of all angles, and of all lengths of sliders.
    pub fn magnitudes(&self) -> [f64; 2] {
        [self.turn, self.slide]
    }

    /// Counts rounding errors as for an edge with these magnitudes at its ends.
    pub fn set_magnitudes(&mut self, [turn, slide]: [f64; 2]) {
        (self.turn, self.slide) = (turn, slide);
    }
}

/// Rounding errors of a composition of frames, in units of `f64::EPSILON` times the length of the
/// chain. docs/contributors/intervals.md, section 17, derives 86.
const STEP_ROUNDINGS: f64 = 128.0;

/// Rounding errors for each radian of a hinge, and for each metre of a slider, in the same unit.
const TURN_ROUNDINGS: f64 = 4.0;

impl Kinematics {
    pub fn new(chain: &Chain) -> Self {
        let mut variables = Vec::new();
        let mut joints = Vec::new();
        for (index, joint) in chain.joints.iter().enumerate() {
            let is_free = matches!(joint.motion, Motion::Hinge | Motion::Slide) && joint.coupling.is_none();
            let variable = is_free.then_some(variables.len());
            variables.extend(variable.map(|_| index));
            let (motion, axis, anchor) = (joint.motion, joint.axis, joint.anchor);
            joints.push(Joint { motion, axis, anchor, reference: joint.reference, coupling: joint.coupling, variable });
        }
        let followers = chain.coupling_order().into_iter().filter(|joint| joints[*joint].coupling.is_some()).collect();
        let mut own = Self { movers: Vec::new(), joints, followers, variables, links: Vec::new(), paths: Vec::new() };
        own.add_links(chain);
        own
    }

    fn add_links(&mut self, chain: &Chain) {
        let mut joints_of = vec![Vec::new(); chain.links.len()];
        chain.joints.iter().enumerate().for_each(|(index, joint)| joints_of[joint.link].push(index));
        let mut children = vec![Vec::new(); chain.links.len()];
        let mut order: Vec<usize> = Vec::new();
        for (index, link) in chain.links.iter().enumerate() {
            match link.parent {
                Some(parent) => children[parent].push(index),
                None => order.push(index),
            }
        }
        let mut links: Vec<Option<Carried>> = vec![None; chain.links.len()];
        let mut next = 0;
        while next < order.len() {
            let link = order[next];
            next += 1;
            let above = chain.links[link].parent.and_then(|parent| links[parent].clone());
            links[link] = Some(self.carried(above, chain.links[link].rest, std::mem::take(&mut joints_of[link])));
            order.append(&mut children[link]);
        }
        self.links = links.into_iter().flatten().collect();
    }

    /// A link below `above`, with its frame at rest and its joints.
    fn carried(&mut self, above: Option<Carried>, rest: Frame, joints: Vec<usize>) -> Carried {
        let anchors: f64 = joints.iter().map(|joint| 2.0 * self.joints[*joint].anchor.length()).sum();
        let (steps, length) = above.as_ref().map_or((0.0, 0.0), |above| (above.steps, above.length));
        let steps = steps + 1.0 + joints.len() as f64;
        let length = length + rest.translation.length() + anchors;
        if let Some(above) = above.as_ref().filter(|_| joints.is_empty()) {
            return Carried { mover: above.mover, in_mover: above.in_mover * rest, steps, length };
        }
        let (parent, rest) = match &above {
            Some(above) => (Some(above.mover), above.in_mover * rest),
            None => (None, rest),
        };
        let mut path = parent.map_or_else(Vec::new, |parent| self.paths[parent].clone());
        let moves = |joint: &&usize| matches!(self.joints[**joint].motion, Motion::Hinge | Motion::Slide);
        path.extend(joints.iter().filter(moves).copied());
        self.paths.push(path);
        self.movers.push(Mover { parent, rest, joints });
        Carried { mover: self.movers.len() - 1, in_mover: Frame::IDENTITY, steps, length }
    }

    /// The joint of each number of a configuration, as indices into the chain.
    pub fn variables(&self) -> &[usize] {
        &self.variables
    }

    pub fn joint(&self, joint: usize) -> &Joint {
        &self.joints[joint]
    }

    /// The hinges and sliders that move a link, the root's first.
    pub fn path(&self, link: usize) -> &[usize] {
        &self.paths[self.links[link].mover]
    }

    /// Places everything for a configuration, in O(joints): a sine and a cosine of `libm` for each
    /// hinge, with the same bits everywhere. No allocation after the first call.
    pub fn place(&self, q: &[f64], out: &mut Placement) {
        out.displacements.clear();
        let own = |joint: &Joint| joint.variable.map_or(0.0, |variable| q[variable] - joint.reference);
        out.displacements.extend(self.joints.iter().map(own));
        for &joint in &self.followers {
            if let Some(coupling) = self.joints[joint].coupling {
                let leader = coupling.leader.map_or(0.0, |leader| out.displacements[leader]);
                out.displacements[joint] = coupling.follow(leader);
            }
        }
        out.axes.resize(self.joints.len(), [DVec3::ZERO; 2]);
        out.movers.clear();
        (out.turn, out.slide) = (0.0, 0.0);
        for mover in &self.movers {
            let mut frame = mover.parent.map_or(mover.rest, |parent| out.movers[parent] * mover.rest);
            for &index in &mover.joints {
                let (joint, displacement) = (&self.joints[index], out.displacements[index]);
                out.axes[index] = [frame.rotation * joint.axis, frame.apply(joint.anchor)];
                match joint.motion {
                    Motion::Hinge => {
                        let rotation = turn(joint.axis, displacement);
                        frame = frame * Frame { rotation, translation: joint.anchor - rotation * joint.anchor };
                        out.turn += displacement.abs() + joint.reference.abs();
                    }
                    Motion::Slide => {
                        frame.translation += out.axes[index][0] * displacement;
                        out.slide += displacement.abs() + joint.reference.abs();
                    }
                    Motion::Ball | Motion::Free => {}
                }
            }
            out.movers.push(frame);
        }
    }

    /// The frame of a link in the world.
    pub fn link(&self, link: usize, at: &Placement) -> Frame {
        let Carried { mover, in_mover, .. } = &self.links[link];
        let frame = at.movers[*mover];
        if *in_mover == Frame::IDENTITY { frame } else { frame * *in_mover }
    }

    /// Upper bound of the rounding error of points within `reach` of a link's origin: a length. It
    /// covers two more compositions, with the point's own frame and a relative pose.
    pub fn noise(&self, link: usize, reach: f64, at: &Placement) -> f64 {
        let Carried { steps, length, .. } = self.links[link];
        let units = STEP_ROUNDINGS * (steps + 3.0) + TURN_ROUNDINGS * (at.turn + at.slide);
        units * f64::EPSILON * (length + at.slide + reach)
    }

    /// For each joint, an upper bound of how far its displacement is from its displacement at `at`,
    /// if each number of the configuration is within `widths`.
    pub fn spans(&self, widths: impl Fn(usize) -> f64, at: &Placement, out: &mut Vec<f64>) {
        out.clear();
        out.extend(self.joints.iter().map(|joint| joint.variable.map_or(0.0, &widths)));
        for &joint in &self.followers {
            let Some(coupling) = self.joints[joint].coupling else { continue };
            out[joint] = coupling.leader.map_or(0.0, |leader| {
                let greatest = at.displacements[leader].abs() + out[leader];
                steepest(&coupling, greatest) * out[leader]
            });
        }
    }

    /// Derivatives with respect to the numbers of a configuration, from derivatives with respect to
    /// the displacement of each joint, which are overwritten.
    pub fn by_variables(&self, at: &Placement, by_joints: &mut [f64], out: &mut [f64]) {
        for &joint in self.followers.iter().rev() {
            let own = std::mem::take(&mut by_joints[joint]);
            if let Some((coupling, leader)) = self.joints[joint].coupling.and_then(|own| Some((own, own.leader?))) {
                by_joints[leader] += own * slope(&coupling, at.displacements[leader]);
            }
        }
        out.iter_mut().zip(&self.variables).for_each(|(out, joint)| *out = by_joints[*joint]);
    }
}

/// Upper bound of the rounding error of points of a body whose pose is given, in relative poses: a
/// length. `length` is the greatest length from which their positions are computed.
pub fn noise_of_pose(length: f64) -> f64 {
    3.0 * STEP_ROUNDINGS * f64::EPSILON * length
}

fn turn(axis: DVec3, angle: f64) -> DQuat {
    let (sine, cosine) = (libm::sin(0.5 * angle), libm::cos(0.5 * angle));
    DQuat::from_xyzw(axis.x * sine, axis.y * sine, axis.z * sine, cosine)
}

fn slope(coupling: &Coupling, leader: f64) -> f64 {
    let terms = coupling.coefficients.iter().enumerate().skip(1).rev();
    terms.fold(0.0, |sum, (degree, coefficient)| sum * leader + degree as f64 * coefficient)
}

/// Bound on the slope of a coupling while the leader is within `greatest` of its reference.
fn steepest(coupling: &Coupling, greatest: f64) -> f64 {
    let magnitudes = Coupling { coefficients: coupling.coefficients.map(f64::abs), ..*coupling };
    slope(&magnitudes, greatest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_those_of_the_polynomial() {
        let coupling = Coupling { leader: Some(0), coefficients: [7.0, 2.0, -3.0, 0.5, -0.25] };
        for at in [-1.5, 0.0, 0.3, 2.0] {
            let (below, above) = (coupling.follow(at - 1e-6), coupling.follow(at + 1e-6));
            assert!((slope(&coupling, at) - (above - below) / 2e-6).abs() < 1e-8);
            assert!(slope(&coupling, at).abs() <= steepest(&coupling, at.abs()));
        }
    }
}
