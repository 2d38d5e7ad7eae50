//! Two hulls of a family and the poses they meet in.
//!
//! A third of the poses is deep, a third within 2 % of touching, a third apart: the distance at which a pair touches is
//! found by bisection, for every pose anew. The hulls have n points each and different seeds.
//!
//! Poses are rounded to single precision before anybody sees them, so that parry and we are asked the same.

use glam::{DQuat, DVec3, Quat, Vec3};
use hullmap::{Cache, Hull, Pack, Pose, intersects};
use hullmap_bake::IndexKind;
use parry3d::{math, shape::ConvexPolyhedron};
use shapes::{families::Family, rng::SplitMix64};

use crate::{rivals::parry::Parry, subject::Subject};

/// The families whose pairs are compared.
pub const FAMILIES: [Family; 3] = [Family::Sphere, Family::ClusteredEllipsoid, Family::Rock];

/// Bisections that find where a pair touches: to a millionth of its size.
const BISECTIONS: usize = 20;

/// How far B moves from one frame to the next, over the mean of the diameters.
pub const STEP: f64 = 0.01;

/// How far B turns from one frame to the next.
pub const TURN_RAD: f64 = std::f64::consts::PI / 180.0;

/// How a pair lies, by its distance over the distance at which it touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// At most 0.9 of it.
    Deep,
    /// Within 2 % of it.
    Touching,
    /// At least 1.05 of it.
    Apart,
}

impl Class {
    /// All classes, in the order of tables.
    pub const ALL: [Class; 3] = [Class::Deep, Class::Touching, Class::Apart];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Class::Deep => "deep",
            Class::Touching => "touching",
            Class::Apart => "apart",
        }
    }

    /// Least and greatest distance, over the distance at which the pair touches.
    pub const fn shares(self) -> [f64; 2] {
        match self {
            Class::Deep => [0.0, 0.9],
            Class::Touching => [0.98, 1.02],
            Class::Apart => [1.05, 2.0],
        }
    }
}

/// Where B is, for parry and for us.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// How the pair lies.
    pub class: Class,
    /// For us.
    pub b_in_a: Pose,
    /// The same numbers for parry.
    pub parry: math::Pose,
}

impl Placed {
    fn new(class: Class, translation: DVec3, rotation: DQuat) -> Self {
        let (translation, rotation): (Vec3, Quat) = (translation.as_vec3(), rotation.as_quat());
        Self {
            class,
            b_in_a: Pose::from_f32(translation, rotation).expect("finite"),
            parry: math::Pose::from_parts(translation, rotation),
        }
    }
}

/// Two hulls of a family, baked for us and for parry.
pub struct Pair {
    /// The family.
    pub family: Family,
    packs: [Pack; 2],
    polyhedra: [ConvexPolyhedron; 2],
    /// Vertices of both hulls together; fewer than 2 n where the family's points are not all extreme.
    pub vertices: usize,
}

impl Pair {
    /// Bakes two hulls of `n` points; `None` where parry refuses one of them or drops vertices.
    ///
    /// # Panics
    /// Where a hull cannot be baked: a bug.
    pub fn bake(family: Family, n: usize, seed: u64) -> Option<Self> {
        let subjects = [0, 1].map(|number| Subject::new(family, n, seed + number));
        let [a, b] = subjects.each_ref().map(|subject| Parry::new(subject).map(Parry::into_polyhedron));
        Some(Self {
            family,
            packs: subjects.each_ref().map(|subject| subject.pack(IndexKind::TREE)),
            polyhedra: [a?, b?],
            vertices: subjects.iter().map(Subject::vertex_count).sum(),
        })
    }

    /// A and B.
    ///
    /// # Panics
    /// If a pack has no hull: a bug.
    pub fn hulls(&self) -> [Hull<'_>; 2] {
        self.packs.each_ref().map(|pack| pack.hull(0).expect("a pack has a hull"))
    }

    /// A and B, parry's.
    pub fn polyhedra(&self) -> &[ConvexPolyhedron; 2] {
        &self.polyhedra
    }

    /// The mean of both diameters.
    pub fn diameter(&self) -> f64 {
        let [a, b] = self.hulls();
        0.5 * (a.diameter() + b.diameter())
    }

    /// Random poses, `count` of each class in turn.
    pub fn poses(&self, count: usize, rng: &mut SplitMix64) -> Vec<Placed> {
        let classes = (0..count).flat_map(|_| Class::ALL);
        classes.map(|class| self.somewhere(class, rng).at(0.0)).collect()
    }

    /// Straight paths past each other, `count` of each class: at the middle frame B is as far away as the class says,
    /// and it moves across. Paths take turns, as the pairs of a scene do: first all at their first frame, the classes in
    /// turn, then all at their second. A frame's class is that of its path.
    pub fn frames(&self, count: usize, frames: usize, rng: &mut SplitMix64) -> Vec<Placed> {
        let middles: Vec<Middle> =
            (0..count).flat_map(|_| Class::ALL).map(|class| self.somewhere(class, rng)).collect();
        let times = (0..frames).map(|frame| frame as f64 - 0.5 * (frames - 1) as f64);
        times.flat_map(|time| middles.iter().map(move |middle| middle.at(time))).collect()
    }

    fn somewhere(&self, class: Class, rng: &mut SplitMix64) -> Middle {
        let [a, b] = self.hulls();
        let rotation = DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize();
        let direction = DVec3::from_array(rng.direction());
        let [low, high] = class.shares();
        let reach = touching_distance(&a, &b, rotation, direction) * rng.between(low, high);
        let axis = DVec3::from_array(rng.direction());
        let across = direction.cross(axis).normalize() * STEP * self.diameter();
        let center_b = hullmap::SupportMap::interior_point(&b);
        let center = hullmap::SupportMap::interior_point(&a) + direction * reach;
        Middle { class, center, center_b, rotation, axis, across }
    }
}

/// The middle of a path.
struct Middle {
    class: Class,
    /// B's interior point, in A's frame and in B's.
    center: DVec3,
    center_b: DVec3,
    rotation: DQuat,
    /// What B turns about.
    axis: DVec3,
    /// How far B moves in a frame.
    across: DVec3,
}

impl Middle {
    fn at(&self, frame: f64) -> Placed {
        let rotation = DQuat::from_axis_angle(self.axis, TURN_RAD * frame) * self.rotation;
        Placed::new(self.class, self.center + self.across * frame - rotation * self.center_b, rotation)
    }
}

/// How far apart the interior points are when B, turned by `rotation`, touches A in `direction` of it.
///
/// # Panics
/// If the rotation is not finite: a bug.
pub fn touching_distance(a: &Hull<'_>, b: &Hull<'_>, rotation: DQuat, direction: DVec3) -> f64 {
    use hullmap::SupportMap;
    let from = a.interior_point() - rotation * b.interior_point();
    let (mut inside, mut outside) = (0.0, a.outer_radius() + b.outer_radius());
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (inside + outside);
        let b_in_a = Pose::new(from + direction * middle, rotation).expect("finite");
        if intersects(a, b, b_in_a, &mut Cache::default()).is_hit() { inside = middle } else { outside = middle }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subject::SEED;

    #[test]
    fn poses_are_what_their_class_says() {
        for family in FAMILIES {
            let pair = Pair::bake(family, 60, SEED).expect("parry takes it");
            let [a, b] = pair.hulls();
            let hits = |class: Class| {
                let poses = pair.poses(60, &mut SplitMix64::new(SEED));
                let of = poses.iter().filter(|placed| placed.class == class);
                of.filter(|placed| intersects(&a, &b, placed.b_in_a, &mut Cache::default()).is_hit()).count()
            };
            assert_eq!((hits(Class::Deep), hits(Class::Apart)), (60, 0), "{}, seed {SEED}", family.name());
            let touching = hits(Class::Touching);
            assert!((15..=45).contains(&touching), "{}: {touching} of 60 overlap, seed {SEED}", family.name());
        }
    }

    #[test]
    fn frames_are_a_step_and_a_degree_apart() {
        let pair = Pair::bake(Family::Rock, 40, SEED).expect("parry takes it");
        let center = hullmap::SupportMap::interior_point(&pair.hulls()[1]);
        let frames = pair.frames(2, 9, &mut SplitMix64::new(SEED));
        let paths = 2 * Class::ALL.len();
        assert_eq!(frames.len(), 9 * paths);
        for (from, to) in frames.iter().zip(&frames[paths..]) {
            assert_eq!(from.class, to.class);
            let [from, to] = [from.b_in_a, to.b_in_a];
            let step = from.transform_point(center).distance(to.transform_point(center)) / pair.diameter();
            let turn = from.rotation().angle_between(to.rotation());
            assert!((step - STEP).abs() < 1e-6 && (turn - TURN_RAD).abs() < 1e-5, "{step} {turn}");
        }
    }
}
