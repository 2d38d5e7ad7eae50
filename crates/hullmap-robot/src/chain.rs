//! The kinematic chain of a description: which joint moves which link, and forward kinematics.
//!
//! A link is placed in its parent by a frame at rest, then by each of its joints, in their order.
//! This is MuJoCo's model. URDF and SDF are a special case: at most one or two joints per link.
//!
//! # Reference
//! <https://mujoco.readthedocs.io/en/stable/modeling.html#kinematic-tree>

use std::collections::VecDeque;

use glam::{DQuat, DVec3};

use crate::frame::Frame;

/// Degree of the polynomial of a coupling, plus one.
pub const COEFFICIENTS: usize = 5;

/// Placement of a link at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Index of the parent link; `None` for a root.
    pub parent: Option<usize>,
    /// Its frame in the parent's while every joint is at its reference.
    pub rest: Frame,
    /// Whether it is the world, and not a part of a robot.
    pub is_world: bool,
    /// Whether it is a mocap body of MJCF: no joint moves it, but its pose may change.
    pub is_mocap: bool,
}

/// How a joint moves its link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// About its axis, in radians.
    Hinge,
    /// Along its axis, in metres.
    Slide,
    /// About any axis.
    Ball,
    /// In any way. It is not moved here.
    Free,
}

/// The position of a joint follows the position of another joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// Index of the joint that it follows; `None` if it is constant.
    pub leader: Option<usize>,
    /// Coefficients of the polynomial from the leader's displacement to its own, lowest first.
    pub coefficients: [f64; COEFFICIENTS],
}

impl Coupling {
    /// Displacement of the joint for a displacement of the leader.
    pub fn follow(&self, leader: f64) -> f64 {
        self.coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * leader + coefficient)
    }
}

/// A joint that moves its link in the link's parent.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Its name; may be empty in MJCF.
    pub name: String,
    /// Index of the link that it moves.
    pub link: usize,
    /// How it moves the link.
    pub motion: Motion,
    /// Its axis in the frame of the link, of unit length.
    pub axis: DVec3,
    /// A point of the axis, in the frame of the link.
    pub anchor: DVec3,
    /// Minimum and maximum of its position; of a ball, of the angle. `None` if it is not limited.
    pub limits: Option<[f64; 2]>,
    /// Its position while the link is at rest. The displacement is the position minus this.
    pub reference: f64,
    /// Its position in the neutral pose.
    pub neutral: f64,
    /// The joint that it follows, if any.
    pub coupling: Option<Coupling>,
}

impl Joint {
    /// A joint that moves its link in some other way. It is not moved here.
    pub(crate) fn unmoved(name: &str, link: usize) -> Self {
        Self {
            name: name.to_owned(),
            link,
            motion: Motion::Free,
            axis: DVec3::Z,
            anchor: DVec3::ZERO,
            limits: None,
            reference: 0.0,
            neutral: 0.0,
            coupling: None,
        }
    }

    /// The motion from rest at a displacement: a length, or an angle in radians.
    fn moved(&self, displacement: Displacement) -> Frame {
        let rotation = match (self.motion, displacement) {
            (Motion::Slide, Displacement::Scalar(length)) => {
                return Frame { translation: self.axis * length, ..Frame::IDENTITY };
            }
            (Motion::Hinge, Displacement::Scalar(angle)) => DQuat::from_axis_angle(self.axis, angle),
            (Motion::Ball, Displacement::Turn(turn)) => turn,
            _ => DQuat::IDENTITY,
        };
        Frame { rotation, translation: self.anchor - rotation * self.anchor }
    }
}

/// How far a joint is from its reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Displacement {
    /// In radians or metres.
    Scalar(f64),
    /// Rotation of a ball.
    Turn(DQuat),
}

/// The kinematic chain.
#[derive(Clone, Debug, Default)]
pub struct Chain {
    /// One for each link of the description.
    pub links: Vec<Placement>,
    /// The joints that are not fixed. Joints of one link are in the order in which they move it.
    pub joints: Vec<Joint>,
    /// Features that are not modelled.
    pub notes: Vec<String>,
    /// Faults of the description, and what is done instead, each with its line.
    pub warnings: Vec<String>,
    towards_root: Vec<usize>,
}

impl Chain {
    pub(crate) fn new(link_count: usize) -> Self {
        let root = Placement { parent: None, rest: Frame::IDENTITY, is_world: false, is_mocap: false };
        Self { links: vec![root; link_count], towards_root: (0..link_count).collect(), ..Self::default() }
    }

    /// The root of a link's tree. Paths are halved on the way: a long chain takes linear time.
    fn root(&mut self, mut link: usize) -> usize {
        while self.towards_root[link] != link {
            self.towards_root[link] = self.towards_root[self.towards_root[link]];
            link = self.towards_root[link];
        }
        link
    }

    /// Places a link in another one. On an error, which says that it has a parent or would be its
    /// own ancestor, the chain is as before.
    pub(crate) fn attach(&mut self, child: usize, parent: usize, rest: Frame) -> Result<(), &'static str> {
        if self.links[child].parent.is_some() {
            return Err("its child has another joint already, so it closes a loop");
        }
        if self.root(parent) == child {
            return Err("its child is above its parent, so it closes a loop");
        }
        self.towards_root[child] = parent;
        self.links[child].parent = Some(parent);
        self.links[child].rest = rest;
        Ok(())
    }

    /// Removes couplings that depend on themselves, with a note for each.
    pub(crate) fn without_circular_couplings(mut self) -> Self {
        let order = self.coupling_order();
        let mut is_ordered = vec![false; self.joints.len()];
        order.into_iter().for_each(|joint| is_ordered[joint] = true);
        for (joint, _) in self.joints.iter_mut().zip(is_ordered).filter(|(_, is_ordered)| !is_ordered) {
            self.warnings
                .push(format!("joint `{}` follows itself through others, so it moves alone; correct it", joint.name));
            joint.coupling = None;
        }
        self
    }

    /// The joints, each leader before its followers. Joints of circular couplings are left out.
    pub fn coupling_order(&self) -> Vec<usize> {
        let mut followers = vec![Vec::new(); self.joints.len()];
        let mut order = Vec::new();
        for (index, joint) in self.joints.iter().enumerate() {
            match joint.coupling.and_then(|coupling| coupling.leader) {
                Some(leader) => followers[leader].push(index),
                None => order.push(index),
            }
        }
        let mut next = 0;
        while next < order.len() {
            let leader: usize = order[next];
            order.append(&mut followers[leader]);
            next += 1;
        }
        order
    }

    /// The displacement of each joint in the neutral pose.
    pub fn neutral(&self) -> Vec<Displacement> {
        let of = |joint: &Joint| match joint.motion {
            Motion::Ball => Displacement::Turn(DQuat::IDENTITY),
            _ => Displacement::Scalar(joint.neutral - joint.reference),
        };
        self.joints.iter().map(of).collect()
    }

    /// Moves the joints that follow others.
    pub fn follow(&self, displacements: &mut [Displacement]) {
        for index in self.coupling_order() {
            let Some(coupling) = self.joints[index].coupling else { continue };
            let leader = match coupling.leader.map(|leader| displacements[leader]) {
                Some(Displacement::Scalar(leader)) => leader,
                _ => 0.0,
            };
            displacements[index] = Displacement::Scalar(coupling.follow(leader));
        }
    }

    /// The frame of each link in the world, for the displacement of each joint, in O(links +
    /// joints).
    ///
    /// # Panics
    /// There are fewer displacements than joints.
    pub fn poses(&self, displacements: &[Displacement]) -> Vec<Frame> {
        let mut in_parent: Vec<Frame> = self.links.iter().map(|link| link.rest).collect();
        for (joint, displacement) in self.joints.iter().zip(displacements) {
            in_parent[joint.link] = in_parent[joint.link] * joint.moved(*displacement);
        }
        assert!(displacements.len() >= self.joints.len(), "a displacement for each joint");
        let mut children = vec![Vec::new(); self.links.len()];
        let mut ready = VecDeque::new();
        for (index, link) in self.links.iter().enumerate() {
            match link.parent {
                Some(parent) => children[parent].push(index),
                None => ready.push_back(index),
            }
        }
        while let Some(link) = ready.pop_front() {
            let pose = in_parent[link];
            for &child in &children[link] {
                in_parent[child] = pose * in_parent[child];
                ready.push_back(child);
            }
        }
        in_parent
    }

    /// For each link, the nearest link towards the root that it never moves against: itself if it
    /// has a joint, or is a mocap body. Links with the same one are rigidly connected.
    pub fn rigid(&self) -> Vec<usize> {
        let mut is_moved: Vec<bool> = self.links.iter().map(|link| link.is_mocap).collect();
        self.joints.iter().for_each(|joint| is_moved[joint.link] = true);
        self.towards(|link| !is_moved[link])
    }

    /// For each link, the root of its tree, or the nearest ancestor that is a mocap body or has a
    /// free joint. Links with the same one belong to one robot.
    pub fn robots(&self) -> Vec<usize> {
        let mut is_free: Vec<bool> = self.links.iter().map(|link| link.is_mocap).collect();
        self.joints.iter().filter(|joint| joint.motion == Motion::Free).for_each(|joint| is_free[joint.link] = true);
        self.towards(|link| !is_free[link])
    }

    /// For each link, itself or the nearest ancestor for which `goes_on` is false; else the root.
    fn towards(&self, goes_on: impl Fn(usize) -> bool) -> Vec<usize> {
        let next = |link: usize| self.links[link].parent.filter(|_| goes_on(link));
        let mut found: Vec<Option<usize>> = vec![None; self.links.len()];
        for start in 0..self.links.len() {
            let (mut path, mut link) = (Vec::new(), start);
            let end = loop {
                if let Some(end) = found[link] {
                    break end;
                }
                path.push(link);
                match next(link) {
                    Some(parent) => link = parent,
                    None => break link,
                }
            };
            path.into_iter().for_each(|link| found[link] = Some(end));
        }
        found.into_iter().map(Option::unwrap_or_default).collect()
    }
}

/// Neutral position in URDF and SDF: 0, or the middle of limits that exclude 0, as in MoveIt.
pub(crate) fn neutral(limits: Option<[f64; 2]>) -> f64 {
    match limits {
        Some([low, high]) if !(low <= 0.0 && 0.0 <= high) => (low + high) / 2.0,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    fn joint(link: usize, motion: Motion, axis: DVec3, anchor: DVec3) -> Joint {
        Joint {
            name: format!("j{link}"),
            link,
            motion,
            axis,
            anchor,
            limits: None,
            reference: 0.0,
            neutral: 0.0,
            coupling: None,
        }
    }

    fn arm() -> Chain {
        let mut chain = Chain::new(3);
        let at = |x: f64| Frame { translation: DVec3::new(x, 0.0, 0.0), ..Frame::IDENTITY };
        chain.attach(1, 0, at(1.0)).unwrap();
        chain.attach(2, 1, at(1.0)).unwrap();
        assert!(chain.attach(2, 0, at(0.0)).is_err() && chain.attach(0, 2, at(0.0)).is_err());
        chain.joints = vec![
            joint(1, Motion::Hinge, DVec3::Z, DVec3::ZERO),
            joint(2, Motion::Hinge, DVec3::Z, DVec3::ZERO),
            joint(2, Motion::Slide, DVec3::X, DVec3::ZERO),
        ];
        chain
    }

    #[test]
    fn planar_arms_have_the_poses_of_the_textbook() {
        let chain = arm();
        for [a, b, s] in [[0.0, 0.0, 0.0], [0.3, -1.1, 0.2], [2.0, 0.5, -0.4]] {
            let poses = chain.poses(&[a, b, s].map(Displacement::Scalar));
            let end = DVec3::new(1.0 + a.cos() + s * (a + b).cos(), a.sin() + s * (a + b).sin(), 0.0);
            assert!(poses[2].translation.abs_diff_eq(end, 1e-14), "{poses:?}");
            let turned = DVec3::new((a + b).cos(), (a + b).sin(), 0.0);
            assert!((poses[2].rotation * DVec3::X).abs_diff_eq(turned, 1e-14));
        }
    }

    #[test]
    fn anchors_stay_where_they_are() {
        let mut chain = arm();
        let anchor = DVec3::new(0.5, 0.2, 0.1);
        chain.joints = vec![joint(1, Motion::Hinge, DVec3::Y, anchor)];
        let rest = chain.poses(&[Displacement::Scalar(0.0)])[1].apply(anchor);
        for angle in [0.4, FRAC_PI_2, -3.0] {
            let pose = chain.poses(&[Displacement::Scalar(angle)])[1];
            assert!(pose.apply(anchor).abs_diff_eq(rest, 1e-14));
        }
        chain.joints[0].motion = Motion::Ball;
        let pose = chain.poses(&[Displacement::Turn(DQuat::from_rotation_x(1.0))])[1];
        assert!(pose.apply(anchor).abs_diff_eq(rest, 1e-14));
    }

    #[test]
    fn followers_follow_followers_and_circles_are_cut() {
        let mut chain = arm();
        let follow = |leader, coefficients| Some(Coupling { leader: Some(leader), coefficients });
        chain.joints[0].coupling = follow(2, [0.5, 2.0, 0.0, 0.0, 0.0]);
        chain.joints[1].coupling = follow(0, [0.0, 0.0, 1.0, 0.0, 1.0]);
        let mut values = [7.0, 7.0, 1.5].map(Displacement::Scalar);
        chain.follow(&mut values);
        assert_eq!(values, [3.5, 3.5 * 3.5 + 3.5_f64.powi(4), 1.5].map(Displacement::Scalar));
        chain.joints[2].coupling = follow(1, [0.0; 5]);
        let cut = chain.without_circular_couplings();
        assert!(cut.joints.iter().all(|joint| joint.coupling.is_none()) && cut.warnings.len() == 3);
    }

    #[test]
    fn rigid_links_and_robots_are_grouped() {
        let mut chain = Chain::new(6);
        for (child, parent) in [(1, 0), (2, 1), (3, 2), (4, 0), (5, 4)] {
            chain.attach(child, parent, Frame::IDENTITY).unwrap();
        }
        chain.joints = vec![joint(2, Motion::Hinge, DVec3::X, DVec3::ZERO), Joint::unmoved("f", 4)];
        assert_eq!(chain.rigid(), [0, 0, 2, 2, 4, 4]);
        assert_eq!(chain.robots(), [0, 0, 0, 0, 4, 4]);
        chain.links[1].is_mocap = true;
        assert_eq!((chain.rigid(), chain.robots()), (vec![0, 1, 2, 2, 4, 4], vec![0, 1, 1, 1, 4, 4]));
        let mut long = Chain::new(300_000);
        for child in 1..300_000 {
            long.attach(child, child - 1, Frame::IDENTITY).unwrap();
        }
        assert!(long.attach(0, 299_999, Frame::IDENTITY).is_err());
        assert!(long.rigid().iter().all(|end| *end == 0) && long.poses(&[]).len() == 300_000);
    }

    #[test]
    fn the_neutral_position_is_within_the_limits() {
        assert_eq!([None, Some([-1.0, 2.0]), Some([0.0, 1.0]), Some([1.0, 2.0])].map(neutral), [0.0, 0.0, 0.0, 1.5]);
    }
}
