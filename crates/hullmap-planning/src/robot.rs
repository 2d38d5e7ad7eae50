//! A robot: its links as convex bodies, the joints that move them, what may touch, and obstacles.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use hullmap::Pose;
use hullmap_robot::{Description, Frame, Geometry, MeshUse, Neighbours, Places, disabled_pairs};

use crate::convex::{self, Convex};
use crate::error::PlanningError;
use crate::kinematics::Kinematics;
use crate::memory::{EdgeMemory, Memory};
use crate::meshes::Packs;
use crate::obstacle::{Obstacle, Placed};
use crate::queries::{Caches, Other, Pairing};

/// Greatest magnitude of a joint's position.
const MAX_POSITION: f64 = 1e15;

/// Number of convex pairs whose last configuration is remembered: about 1.4 MB.
const MAX_CACHED: usize = 1024;

/// Number of names in messages.
const NAMES_SHOWN: usize = 12;

/// A convex body of a link.
#[derive(Clone)]
pub(crate) struct Body {
    pub(crate) link: usize,
    pub(crate) convex: Convex,
    /// Its frame in the link's.
    pub(crate) in_link: Frame,
    contact_bits: [i32; 2],
    /// Centre in the link's frame, and radius of a ball around it.
    pub(crate) ball: (DVec3, f64),
    /// Centre and half edges of its box, in its own frame.
    pub(crate) bounds: [DVec3; 2],
}

impl Body {
    fn new(link: usize, convex: Convex, in_link: Frame, contact_bits: [i32; 2]) -> Self {
        let shape = convex.shape();
        let bounds = shape.bounds_under(Pose::IDENTITY);
        let [centre, half] = [(bounds.min + bounds.max) / 2.0, (bounds.max - bounds.min) / 2.0];
        let around_box = (centre, half.length());
        let around_inside = (shape.interior_point(), shape.outer_radius());
        let (inside, radius) = if around_box.1 < around_inside.1 { around_box } else { around_inside };
        let ball = (in_link.apply(inside), radius);
        Self { link, convex, in_link, contact_bits, ball, bounds: [centre, half] }
    }

    /// Whether `contype` and `conaffinity` of MuJoCo let the two collide.
    fn may_meet(&self, other: &Self) -> bool {
        let ([type_a, affinity_a], [type_b, affinity_b]) = (self.contact_bits, other.contact_bits);
        type_a & affinity_b != 0 || type_b & affinity_a != 0
    }
}

/// What a body may touch: another body, or an obstacle.
#[derive(Clone, Copy, Debug)]
pub(crate) enum BodyOrObstacle {
    Body(usize),
    Obstacle(usize),
}

/// A pair of convex bodies, or of an obstacle and a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodyPair {
    pub(crate) a: BodyOrObstacle,
    pub(crate) b: usize,
    /// Number of joints from the root that move both.
    pub(crate) shared: usize,
}

/// The pairs of two links, or of an obstacle and a link.
#[derive(Clone, Debug)]
pub(crate) struct Couple {
    /// The link or the obstacle, and the link.
    a: BodyOrObstacle,
    b: usize,
    pub(crate) pairs: Range<usize>,
}

/// A joint that a configuration has a number for.
#[derive(Clone, Debug, PartialEq)]
pub struct JointFacts {
    /// Its name.
    pub name: String,
    /// Minimum and maximum of its position, in radians or metres; `None` if it is not limited.
    pub limits: Option<[f64; 2]>,
    /// Its position in the neutral configuration.
    pub neutral: f64,
    /// Whether it is a slider, and not a hinge.
    pub is_slider: bool,
}

/// A robot for collision queries of planners.
///
/// The bodies of a link are the hulls of its collision meshes, and its primitives. Links that a
/// joint connects, links that are connected rigidly, and pairs that are allowed to touch are not
/// tested against each other.
///
/// Lengths are in metres and angles in radians, as in the description. The world is the frame of
/// the description's root.
#[derive(Clone)]
pub struct Robot {
    pub(crate) links: Vec<String>,
    pub(crate) joints: Vec<JointFacts>,
    pub(crate) kinematics: Kinematics,
    pub(crate) bodies: Arc<Vec<Body>>,
    /// The bodies of each link.
    of_link: Vec<Range<usize>>,
    /// A ball around each link, in its frame.
    balls: Vec<(DVec3, f64)>,
    /// Pairs of links that are never tested: neighbours, and pairs that the description excludes.
    untested: BTreeSet<[usize; 2]>,
    /// Pairs of colliders that may touch.
    allowed: BTreeSet<[usize; 2]>,
    pub(crate) obstacles: Vec<Placed>,
    pub(crate) pairs: Vec<BodyPair>,
    pub(crate) couples: Vec<Couple>,
    /// Geometry that is ignored, and the reason.
    pub notes: Vec<String>,
}

impl Robot {
    /// Reads a robot from a URDF, MJCF or SDF file. `places` has the folders of its packages, and
    /// `packs` the hulls of its meshes.
    ///
    /// # Errors
    /// The description or a mesh cannot be read, or a collision has no shape that can be queried.
    ///
    /// # Complexity
    /// The time to read or build the hulls: O(n log n) for a mesh of n points without a pack.
    pub fn read(file: &Path, places: &Places, packs: &mut Packs) -> Result<Self, PlanningError> {
        let description = Description::read(file, places)?;
        Self::new(&description, |mesh| packs.hulls(mesh))
    }

    /// A robot from a description. `hulls` returns the hulls of a mesh.
    ///
    /// # Errors
    /// As for [`read`](Self::read).
    pub fn new(
        description: &Description,
        mut hulls: impl FnMut(&MeshUse) -> Result<Arc<hullmap::Pack>, String>,
    ) -> Result<Self, PlanningError> {
        let chain = &description.chain;
        let kinematics = Kinematics::new(chain);
        let mut notes = [description.warnings.as_slice(), &chain.warnings, &chain.notes].concat();
        let (mut bodies, mut of_link) = (Vec::new(), Vec::new());
        for (index, link) in description.links.iter().enumerate() {
            let first = bodies.len();
            for shape in &link.collisions {
                let fault = |cause: String| PlanningError::Collision {
                    file: description.documents[shape.document].path().to_owned(),
                    line: shape.line,
                    link: link.name.clone(),
                    cause,
                };
                let Some(in_link) = shape.pose else {
                    return Err(fault("its pose is not known; state it by numbers".to_owned()));
                };
                let shapes = match &shape.geometry {
                    Geometry::Mesh(mesh) => hulls(mesh).and_then(|pack| convex::hulls(&pack, mesh)).map_err(fault)?,
                    Geometry::Primitive(primitive) => {
                        let cause =
                            format!("the sizes of `{}` are missing or not positive; state them", primitive.name);
                        let primitive = primitive.shape.ok_or_else(|| fault(cause))?;
                        vec![convex::shape_of_primitive(primitive).map_err(|error| fault(error.to_string()))?]
                    }
                    Geometry::Other(reason) => {
                        notes.push(format!("link `{}`, line {}: not tested: {reason}", link.name, shape.line));
                        Vec::new()
                    }
                };
                bodies.extend(shapes.into_iter().map(|convex| Body::new(index, convex, in_link, shape.contact_bits)));
            }
            of_link.push(first..bodies.len());
        }
        let balls = of_link.iter().map(|own| ball_around(&bodies[own.clone()])).collect();
        let neighbours = Neighbours::new(chain);
        let with_bodies: Vec<usize> = (0..of_link.len()).filter(|link| !of_link[*link].is_empty()).collect();
        let excluded: BTreeSet<[usize; 2]> = description.excluded.iter().map(|pair| sorted(*pair)).collect();
        let pairs =
            with_bodies.iter().enumerate().flat_map(|(at, &a)| with_bodies[at + 1..].iter().map(move |&b| [a, b]));
        let untested = pairs.filter(|pair| neighbours.are_connected(*pair) || excluded.contains(pair)).collect();
        let joints = kinematics.variables().iter().map(|&joint| {
            let joint = &chain.joints[joint];
            let is_slider = joint.motion == hullmap_robot::Motion::Slide;
            JointFacts { name: joint.name.clone(), limits: joint.limits, neutral: joint.neutral, is_slider }
        });
        let mut robot = Self {
            links: description.links.iter().map(|link| link.name.clone()).collect(),
            joints: joints.collect(),
            kinematics,
            bodies: Arc::new(bodies),
            of_link,
            balls,
            untested,
            allowed: BTreeSet::new(),
            obstacles: Vec::new(),
            pairs: Vec::new(),
            couples: Vec::new(),
            notes,
        };
        robot.list_pairs();
        Ok(robot)
    }

    /// Names of the links, in the order of the description.
    pub fn links(&self) -> &[String] {
        &self.links
    }

    /// The joints that a configuration has a number for, in the order of its numbers: hinges and
    /// sliders that follow no other joint.
    pub fn joints(&self) -> &[JointFacts] {
        &self.joints
    }

    /// How many numbers a configuration has.
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    /// The neutral configuration.
    pub fn neutral(&self) -> Vec<f64> {
        self.joints.iter().map(|joint| joint.neutral).collect()
    }

    /// The name of a collider: links first, then obstacles.
    pub fn collider(&self, index: usize) -> Option<&str> {
        let obstacle = || self.obstacles.get(index.checked_sub(self.links.len())?);
        self.links.get(index).map(String::as_str).or_else(|| Some(obstacle()?.obstacle.name.as_str()))
    }

    /// Number of convex bodies, over all links.
    pub fn body_count(&self) -> usize {
        self.bodies.len()
    }

    /// The pairs of colliders that are tested, as indices of [`collider`](Self::collider), the
    /// lower one first.
    pub fn tested(&self) -> Vec<[usize; 2]> {
        self.couples.iter().map(|couple| self.colliders(couple.a, couple.b)).collect()
    }

    /// Adds obstacles.
    ///
    /// # Errors
    /// A name is in use. Then nothing is added.
    pub fn add_obstacles(&mut self, obstacles: impl IntoIterator<Item = Obstacle>) -> Result<(), PlanningError> {
        let added: Vec<Obstacle> = obstacles.into_iter().collect();
        let mut names: BTreeSet<&str> = self.links.iter().map(String::as_str).collect();
        names.extend(self.obstacles.iter().map(|own| own.obstacle.name.as_str()));
        if let Some(twice) = added.iter().find(|own| !names.insert(&own.name)) {
            return Err(PlanningError::NameInUse { name: twice.name.clone() });
        }
        self.obstacles.extend(added.into_iter().map(Placed::new));
        self.list_pairs();
        Ok(())
    }

    /// Removes all obstacles, and the allowed pairs with them.
    pub fn clear_obstacles(&mut self) {
        self.obstacles.clear();
        let links = self.links.len();
        self.allowed.retain(|pair| pair[1] < links);
        self.list_pairs();
    }

    /// Allows pairs of links, or of links and obstacles, to touch: they are no longer tested.
    ///
    /// # Errors
    /// A name is unknown. Then nothing changes.
    pub fn allow<N: AsRef<str>>(&mut self, pairs: impl IntoIterator<Item = [N; 2]>) -> Result<(), PlanningError> {
        let index = self.indices();
        let find = |name: &str| {
            index.get(name).copied().ok_or_else(|| PlanningError::UnknownName {
                name: name.to_owned(),
                known: index.keys().take(NAMES_SHOWN).map(|name| (*name).to_owned()).collect(),
            })
        };
        let mut added = BTreeSet::new();
        for [a, b] in pairs {
            added.insert(sorted([find(a.as_ref())?, find(b.as_ref())?]));
        }
        self.allowed.extend(added);
        self.list_pairs();
        Ok(())
    }

    /// Allows the pairs that an SRDF file disables. Names of links without a collision, and of
    /// other robots, are ignored.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn allow_srdf(&mut self, file: &Path) -> Result<(), PlanningError> {
        let index = self.indices();
        let pairs = disabled_pairs(file)?;
        let known = pairs.iter().filter_map(|[a, b]| Some(sorted([*index.get(a.as_str())?, *index.get(b.as_str())?])));
        let known: Vec<[usize; 2]> = known.collect();
        self.allowed.extend(known);
        self.list_pairs();
        Ok(())
    }

    fn indices(&self) -> BTreeMap<&str, usize> {
        let obstacles = self.obstacles.iter().map(|own| own.obstacle.name.as_str());
        let names = self.links.iter().map(String::as_str).chain(obstacles);
        names.enumerate().map(|(index, name)| (name, index)).collect()
    }

    /// Memory for queries of this robot, by one thread. It must not be used after obstacles or
    /// allowed pairs have changed.
    pub fn memory(&self) -> Memory {
        Memory {
            at: Default::default(),
            links: vec![Frame::IDENTITY; self.links.len()],
            centres: vec![DVec3::ZERO; self.links.len()],
            noise: vec![0.0; self.links.len()],
            caches: Caches::new(self.pairs.len().min(MAX_CACHED)),
            last: 0,
            edge: EdgeMemory {
                motions: vec![Vec::new(); self.bodies.len()],
                stamps: vec![0; self.bodies.len()],
                ..EdgeMemory::default()
            },
        }
    }

    /// Lists the pairs that are tested.
    fn list_pairs(&mut self) {
        let with_bodies: Vec<usize> = (0..self.links.len()).filter(|link| !self.of_link[*link].is_empty()).collect();
        let (mut pairs, mut couples) = (Vec::new(), Vec::new());
        let mut add = |a: BodyOrObstacle, b: usize, own: Vec<BodyPair>| {
            let first = pairs.len();
            pairs.extend(own);
            if pairs.len() > first {
                couples.push(Couple { a, b, pairs: first..pairs.len() });
            }
        };
        let is_left_out = |pair: [usize; 2]| self.untested.contains(&pair) || self.allowed.contains(&pair);
        for (at, &a) in with_bodies.iter().enumerate() {
            for &b in with_bodies[at + 1..].iter().filter(|b| !is_left_out([a, **b])) {
                let shared = self.shared_joints([a, b]);
                let all = self.of_link[a].clone().flat_map(|a| self.of_link[b].clone().map(move |b| [a, b]));
                let may_meet = |[a, b]: &[usize; 2]| self.bodies[*a].may_meet(&self.bodies[*b]);
                let pair = |[a, b]: [usize; 2]| BodyPair { a: BodyOrObstacle::Body(a), b, shared };
                add(BodyOrObstacle::Body(a), b, all.filter(may_meet).map(pair).collect());
            }
        }
        for obstacle in 0..self.obstacles.len() {
            let collider = self.links.len() + obstacle;
            for &b in with_bodies.iter().filter(|b| !self.allowed.contains(&[**b, collider])) {
                let a = BodyOrObstacle::Obstacle(obstacle);
                add(a, b, self.of_link[b].clone().map(|b| BodyPair { a, b, shared: 0 }).collect());
            }
        }
        (self.pairs, self.couples) = (pairs, couples);
    }

    /// Number of joints from the root that move both links.
    fn shared_joints(&self, [a, b]: [usize; 2]) -> usize {
        let [a, b] = [a, b].map(|link| self.kinematics.path(link));
        a.iter().zip(b).take_while(|(a, b)| a == b).count()
    }

    /// Places all links for a configuration.
    ///
    /// # Errors
    /// It has another length, or a number is out of range.
    pub(crate) fn place(&self, q: &[f64], memory: &mut Memory) -> Result<(), PlanningError> {
        if q.len() != self.joints.len() {
            return Err(PlanningError::JointCount { expected: self.joints.len(), found: q.len() });
        }
        // NaN takes the failing branch.
        if let Some((joint, value)) = self.joints.iter().zip(q).find(|(_, value)| !(value.abs() <= MAX_POSITION)) {
            return Err(PlanningError::Position { joint: joint.name.clone(), value: *value });
        }
        self.kinematics.place(q, &mut memory.at);
        self.place_links(memory);
        Ok(())
    }

    /// Places the links for the joints' positions in memory.
    pub(crate) fn place_links(&self, memory: &mut Memory) {
        for (link, (centre, radius)) in self.links_with_balls() {
            let frame = self.kinematics.link(link, &memory.at);
            memory.links[link] = frame;
            memory.centres[link] = frame.apply(*centre);
            memory.noise[link] = self.kinematics.noise(link, centre.length() + radius, &memory.at);
        }
    }

    /// Places all links at poses in the world, which the caller has from another program.
    ///
    /// # Errors
    /// There are more or fewer poses than links.
    pub(crate) fn place_at(&self, poses: &[Pose], memory: &mut Memory) -> Result<(), PlanningError> {
        if poses.len() != self.links.len() {
            return Err(PlanningError::LinkCount { expected: self.links.len(), found: poses.len() });
        }
        for (link, (centre, radius)) in self.links_with_balls() {
            let frame = Frame { rotation: poses[link].rotation(), translation: poses[link].translation() };
            memory.links[link] = frame;
            memory.centres[link] = frame.apply(*centre);
            let length = frame.translation.length() + centre.length() + radius;
            memory.noise[link] = crate::kinematics::noise_of_pose(length);
        }
        Ok(())
    }

    fn links_with_balls(&self) -> impl Iterator<Item = (usize, &(DVec3, f64))> {
        self.balls.iter().enumerate().filter(|(link, _)| !self.of_link[*link].is_empty())
    }

    /// The colliders of a pair, the lower index first.
    pub(crate) fn colliders_of(&self, pair: usize) -> [usize; 2] {
        let BodyPair { a, b, .. } = self.pairs[pair];
        match a {
            BodyOrObstacle::Body(a) => self.colliders(BodyOrObstacle::Body(self.bodies[a].link), self.bodies[b].link),
            BodyOrObstacle::Obstacle(_) => self.colliders(a, self.bodies[b].link),
        }
    }

    /// The colliders of a link or an obstacle `a`, and of a link.
    fn colliders(&self, a: BodyOrObstacle, b: usize) -> [usize; 2] {
        match a {
            BodyOrObstacle::Body(a) => [a, b],
            BodyOrObstacle::Obstacle(obstacle) => [b, self.links.len() + obstacle],
        }
    }

    /// Lower bound of a couple's distance, by the balls around links, with allowance for rounding.
    pub(crate) fn couple_gap(&self, couple: &Couple, memory: &Memory) -> f64 {
        let (centre, radius, noise) = (memory.centres[couple.b], self.balls[couple.b].1, memory.noise[couple.b]);
        match couple.a {
            BodyOrObstacle::Body(a) => {
                memory.centres[a].distance(centre) - self.balls[a].1 - radius - noise - memory.noise[a]
            }
            BodyOrObstacle::Obstacle(a) => self.obstacles[a].gap(centre, radius) - noise - self.obstacle_noise(a),
        }
    }

    /// Lower bound of the distance of a pair, by the balls around bodies.
    pub(crate) fn pair_gap(&self, pair: &BodyPair, memory: &Memory) -> f64 {
        let centre = |body: &Body| memory.links[body.link].apply(body.ball.0);
        let b = &self.bodies[pair.b];
        let noise = self.pair_noise(pair, memory);
        match pair.a {
            BodyOrObstacle::Body(a) => {
                let a = &self.bodies[a];
                centre(a).distance(centre(b)) - a.ball.1 - b.ball.1 - noise
            }
            BodyOrObstacle::Obstacle(a) => self.obstacles[a].gap(centre(b), b.ball.1) - noise,
        }
    }

    /// Upper bound of the distance of two bodies, by points inside of them; `None` if not known.
    pub(crate) fn reach(&self, pair: &BodyPair, memory: &Memory) -> Option<f64> {
        let inside =
            |body: usize| self.body_frame(body, memory).apply(self.bodies[body].convex.shape().interior_point());
        match pair.a {
            BodyOrObstacle::Body(a) => Some(inside(a).distance(inside(pair.b)) + self.pair_noise(pair, memory)),
            BodyOrObstacle::Obstacle(_) => None,
        }
    }

    /// Upper bound of the rounding error of the relative position of two bodies: a length.
    pub(crate) fn pair_noise(&self, pair: &BodyPair, memory: &Memory) -> f64 {
        let a = match pair.a {
            BodyOrObstacle::Body(a) => memory.noise[self.bodies[a].link],
            BodyOrObstacle::Obstacle(a) => self.obstacle_noise(a),
        };
        a + memory.noise[self.bodies[pair.b].link]
    }

    fn obstacle_noise(&self, obstacle: usize) -> f64 {
        crate::kinematics::noise_of_pose(self.obstacles[obstacle].length)
    }

    /// The frame of a body in the world.
    pub(crate) fn body_frame(&self, body: usize, memory: &Memory) -> Frame {
        let Body { link, in_link, .. } = &self.bodies[body];
        let frame = memory.links[*link];
        if *in_link == Frame::IDENTITY { frame } else { frame * *in_link }
    }

    /// The frame of A in the world.
    pub(crate) fn frame_of_a(&self, pair: &BodyPair, memory: &Memory) -> Frame {
        match pair.a {
            BodyOrObstacle::Body(a) => self.body_frame(a, memory),
            BodyOrObstacle::Obstacle(a) => self.obstacles[a].frame,
        }
    }

    /// A pair in the form that queries take.
    pub(crate) fn pairing(&self, index: usize, memory: &Memory) -> Pairing<'_> {
        let pair = &self.pairs[index];
        let (a, b) = (self.frame_of_a(pair, memory), self.body_frame(pair.b, memory));
        let back = a.rotation.conjugate();
        let b_in_a = Pose::new(back * (b.translation - a.translation), back * b.rotation).ok();
        let other = match pair.a {
            BodyOrObstacle::Body(a) => Other::Convex(&self.bodies[a].convex),
            BodyOrObstacle::Obstacle(a) => Other::from(&self.obstacles[a].obstacle.shape),
        };
        Pairing { index, a: other, b: &self.bodies[pair.b].convex, b_in_a }
    }
}

fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// A ball around the bodies of a link, in its frame.
fn ball_around(bodies: &[Body]) -> (DVec3, f64) {
    if let [body] = bodies {
        return body.ball;
    }
    let corners = bodies.iter().flat_map(|body| [body.ball.0 - body.ball.1, body.ball.0 + body.ball.1]);
    let [min, max] =
        corners.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[min, max], corner| [min.min(corner), max.max(corner)]);
    if bodies.is_empty() {
        return (DVec3::ZERO, 0.0);
    }
    let centre = (min + max) / 2.0;
    (centre, bodies.iter().map(|body| body.ball.0.distance(centre) + body.ball.1).fold(0.0, f64::max))
}
