//! A robot: its links as convex bodies, the joints that move them, and obstacles.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use hullmap::Pose;
use hullmap_robot::{CollisionFilter, Description, Frame, Geometry, MeshUse, Places, Shape};

use crate::convex::{self, Convex};
use crate::error::PlanningError;
use crate::kinematics::Kinematics;
use crate::memory::{EdgeMemory, Memory};
use crate::meshes::Packs;
use crate::obstacle::{Obstacle, Placed};
use crate::queries::{Caches, Other, Pairing};

const MAX_POSITION: f64 = 1e15;

/// Number of convex pairs whose last configuration is remembered: about 1.4 MB.
const MAX_CACHED: usize = 1024;

#[derive(Clone)]
pub(crate) struct Body {
    pub(crate) link: usize,
    pub(crate) shape: usize,
    pub(crate) convex: Convex,
    /// Its frame in the link's.
    pub(crate) in_link: Frame,
    /// Centre in the link's frame, and radius of a ball around it.
    pub(crate) ball: (DVec3, f64),
    /// Centre and half edges of its box, in its own frame.
    pub(crate) bounds: [DVec3; 2],
}

impl Body {
    fn new([link, shape]: [usize; 2], convex: Convex, in_link: Frame) -> Self {
        let own = convex.shape();
        let bounds = own.bounds_under(Pose::IDENTITY);
        let [centre, half] = [(bounds.min + bounds.max) / 2.0, (bounds.max - bounds.min) / 2.0];
        let around_box = (centre, half.length());
        let around_inside = (own.interior_point(), own.outer_radius());
        let (inside, radius) = if around_box.1 < around_inside.1 { around_box } else { around_inside };
        let ball = (in_link.apply(inside), radius);
        Self { link, shape, convex, in_link, ball, bounds: [centre, half] }
    }
}

/// The other side of a pair: a body, or an obstacle.
#[derive(Clone, Copy, Debug)]
pub(crate) enum BodyOrObstacle {
    Body(usize),
    Obstacle(usize),
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct BodyPair {
    pub(crate) a: BodyOrObstacle,
    pub(crate) b: usize,
    /// Number of joints from the root that move both.
    pub(crate) shared: usize,
}

#[derive(Clone, Debug)]
pub(crate) struct Couple {
    pub(crate) a: BodyOrObstacle,
    pub(crate) b: usize,
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
/// The bodies of a link are the hulls of its collision meshes, and its primitives. The description
/// decides which pairs are tested ([`CollisionFilter`]), unless the user does
/// ([`allow`](Self::allow), [`disallow`](Self::disallow)). [`skipped`](Self::skipped) lists all
/// that is not tested.
///
/// Lengths are in metres and angles in radians. The world is the frame of the description's root.
#[derive(Clone)]
pub struct Robot {
    pub(crate) links: Vec<String>,
    pub(crate) joints: Vec<JointFacts>,
    pub(crate) kinematics: Kinematics,
    pub(crate) bodies: Arc<Vec<Body>>,
    pub(crate) file: PathBuf,
    pub(crate) of_link: Vec<Range<usize>>,
    /// A ball around each link, in its frame.
    balls: Vec<(DVec3, f64)>,
    pub(crate) filter: CollisionFilter,
    /// Whether pairs of colliders may collide, where that is not for the filter to decide.
    pub(crate) allowed: BTreeMap<[usize; 2], bool>,
    pub(crate) obstacles: Vec<Placed>,
    pub(crate) pairs: Vec<BodyPair>,
    pub(crate) couples: Vec<Couple>,
    /// Geometry that is not tested and joints that are not moved, with the reasons.
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
        let (mut bodies, mut of_link) = (Vec::new(), Vec::new());
        for (index, link) in description.links.iter().enumerate() {
            let first = bodies.len();
            for (at, shape) in link.collisions.iter().enumerate() {
                if matches!(shape.geometry, Geometry::Other(_)) {
                    continue;
                }
                let fault = |cause: String| PlanningError::Collision {
                    file: description.documents[shape.document].path().to_owned(),
                    line: shape.line,
                    link: link.name.clone(),
                    cause,
                };
                let in_link =
                    shape.pose.ok_or_else(|| fault("its pose is not known; state it by numbers".to_owned()))?;
                let shapes = convex_shapes(shape, &mut hulls).map_err(fault)?;
                bodies.extend(shapes.into_iter().map(|convex| Body::new([index, at], convex, in_link)));
            }
            of_link.push(first..bodies.len());
        }
        let joints = kinematics.variables().iter().map(|&joint| {
            let joint = &chain.joints[joint];
            let is_slider = joint.motion == hullmap_robot::Motion::Slide;
            JointFacts { name: joint.name.clone(), limits: joint.limits, neutral: joint.neutral, is_slider }
        });
        let filter = CollisionFilter::new(description);
        let mut robot = Self {
            links: description.links.iter().map(|link| link.name.clone()).collect(),
            joints: joints.collect(),
            kinematics,
            balls: of_link.iter().map(|own: &Range<usize>| ball_around(&bodies[own.clone()])).collect(),
            bodies: Arc::new(bodies),
            file: description.path().to_owned(),
            of_link,
            allowed: BTreeMap::new(),
            notes: [&description.warnings, &chain.warnings, &chain.notes]
                .into_iter()
                .flatten()
                .cloned()
                .chain(filter.untested().map(|own| own.to_string()))
                .collect(),
            filter,
            obstacles: Vec::new(),
            pairs: Vec::new(),
            couples: Vec::new(),
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
        self.allowed.retain(|pair, _| pair[1] < links);
        self.list_pairs();
    }

    /// Memory for queries of this robot by one thread. It is invalid after obstacles or allowed
    /// pairs have changed.
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

    pub(crate) fn shared_joints(&self, [a, b]: [usize; 2]) -> usize {
        let [a, b] = [a, b].map(|link| self.kinematics.path(link));
        a.iter().zip(b).take_while(|(a, b)| a == b).count()
    }

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

    pub(crate) fn place_links(&self, memory: &mut Memory) {
        for (link, (centre, radius)) in self.links_with_balls() {
            let frame = self.kinematics.link(link, &memory.at);
            memory.links[link] = frame;
            memory.centres[link] = frame.apply(*centre);
            memory.noise[link] = self.kinematics.noise(link, centre.length() + radius, &memory.at);
        }
    }

    /// Forward kinematics: the pose of each of [`links`](Self::links) in the world.
    ///
    /// # Errors
    /// The length of `q` is not the number of joints, or a number or a pose is out of range.
    pub fn link_poses(&self, q: &[f64], memory: &mut Memory) -> Result<Vec<Pose>, PlanningError> {
        self.place(q, memory)?;
        let pose = |link: usize| {
            let frame = self.kinematics.link(link, &memory.at);
            Pose::new(frame.translation, frame.rotation)
                .map_err(|error| PlanningError::LinkPose { link: self.links[link].clone(), error })
        };
        (0..self.links.len()).map(pose).collect()
    }

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

    pub(crate) fn pairing(&self, index: usize, memory: &Memory) -> Pairing<'_> {
        let pair = &self.pairs[index];
        let (a, b) = (self.frame_of_a(pair, memory), self.body_frame(pair.b, memory));
        let back = a.rotation.conjugate();
        let b_in_a = Pose::new(back * (b.translation - a.translation), back * b.rotation).ok();
        let other = match pair.a {
            BodyOrObstacle::Body(a) => Other::Body(&self.bodies[a].convex),
            BodyOrObstacle::Obstacle(a) => Other::Obstacle(&self.obstacles[a].obstacle.shape),
        };
        Pairing { index, a: other, b: &self.bodies[pair.b].convex, b_in_a }
    }
}

fn convex_shapes(
    shape: &Shape,
    hulls: impl FnOnce(&MeshUse) -> Result<Arc<hullmap::Pack>, String>,
) -> Result<Vec<Convex>, String> {
    match &shape.geometry {
        Geometry::Mesh(mesh) => hulls(mesh).and_then(|pack| convex::hulls(&pack, mesh)),
        Geometry::Primitive(primitive) => {
            let cause = || format!("the sizes of `{}` are missing or not positive; state them", primitive.name);
            let primitive = primitive.shape.ok_or_else(cause)?;
            Ok(vec![convex::shape_of_primitive(primitive).map_err(|error| error.to_string())?])
        }
        Geometry::Other(cause) => Err(cause.clone()),
    }
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
