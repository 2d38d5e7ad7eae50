//! Two hulls of a family, and their poses.
//!
//! A third of the poses penetrate, a third are within 2 % of touching, a third are separated. The
//! distance at which a pair touches is found by bisection for every pose. The hulls have n points
//! each and different seeds.
//!
//! Poses are rounded to single precision first, so that both engines get the same ones.

use glam::{DQuat, DVec3, Quat, Vec3};
use hullmap::SupportMap as _;
use hullmap::{Cache, Hull, Pack, Pose, intersects};
use hullmap_bake::IndexKind;
use parry3d::{math, shape::ConvexPolyhedron};
use shapes::{families::Family, rng::SplitMix64};

use crate::subject::{Subject, first_hull, polyhedron};

/// The families whose pairs are compared.
pub const FAMILIES: [Family; 3] = [Family::Sphere, Family::ClusteredEllipsoid, Family::Rock];

/// Number of bisections that find the touching distance: to a millionth of the size.
const BISECTIONS: usize = 20;

/// Distance by which B moves from one frame to the next, over the mean diameter.
pub const STEP: f64 = 0.01;

/// Angle by which B turns from one frame to the next.
pub const TURN_RAD: f64 = std::f64::consts::PI / 180.0;

/// State of a pair, by its distance over its touching distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// At most 0.9 times the touching distance.
    Penetrating,
    /// Within 2 % of the touching distance.
    NearTouching,
    /// At least 1.05 times the touching distance.
    Separated,
}

impl Class {
    /// All classes, in the order of tables.
    pub const ALL: [Class; 3] = [Class::Penetrating, Class::NearTouching, Class::Separated];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Class::Penetrating => "penetrating",
            Class::NearTouching => "near touching",
            Class::Separated => "separated",
        }
    }

    /// Minimum and maximum distance, over the touching distance.
    pub const fn shares(self) -> [f64; 2] {
        match self {
            Class::Penetrating => [0.0, 0.9],
            Class::NearTouching => [0.98, 1.02],
            Class::Separated => [1.05, 2.0],
        }
    }
}

/// Pose of B, for both engines.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// Pose for hullmap.
    pub b_in_a: Pose,
    /// The same pose for parry.
    pub parry: math::Pose,
}

impl Placed {
    /// Rounds a pose to single precision.
    pub fn new(translation: DVec3, rotation: DQuat) -> Self {
        let (translation, rotation): (Vec3, Quat) = (translation.as_vec3(), rotation.as_quat());
        let b_in_a = Pose::from_f32(translation, rotation).expect("finite");
        Self { b_in_a, parry: math::Pose::from_parts(translation, rotation) }
    }
}

/// Selection of poses, in which the classes alternate: all, or one class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mix {
    /// All classes, a third each.
    All,
    /// One class.
    Only(Class),
}

impl Mix {
    /// All mixes, in the order of tables.
    pub const ALL: [Mix; 4] =
        [Mix::All, Mix::Only(Class::Penetrating), Mix::Only(Class::NearTouching), Mix::Only(Class::Separated)];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Mix::All => "all",
            Mix::Only(class) => class.name(),
        }
    }

    /// Index of the first pose, and the step to the next.
    pub fn stride(self) -> (usize, usize) {
        match self {
            Mix::All => (0, 1),
            Mix::Only(class) => (class as usize, Class::ALL.len()),
        }
    }

    /// The selected poses.
    pub fn select(self, poses: &[Placed]) -> Vec<Placed> {
        let (first, step) = self.stride();
        poses.iter().skip(first).step_by(step).copied().collect()
    }
}

/// Two hulls of a family, for both engines.
pub struct BakedPair {
    packs: [Pack; 2],
    polyhedra: [ConvexPolyhedron; 2],
}

impl BakedPair {
    /// Bakes two hulls of `n` points; `None` if parry rejects one of them or drops vertices.
    pub fn bake(family: Family, n: usize, seed: u64) -> Option<Self> {
        let packs = [0, 1].map(|index| Subject::new(family, n, seed + index).pack(IndexKind::Tree).0);
        let [a, b] = packs.each_ref().map(|pack| polyhedron(&first_hull(pack)));
        Some(Self { packs, polyhedra: [a?, b?] })
    }

    /// A and B.
    pub fn hulls(&self) -> [Hull<'_>; 2] {
        self.packs.each_ref().map(first_hull)
    }

    /// A and B as parry's polyhedra.
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
        classes.map(|class| self.somewhere(class, rng).at_frame(0.0)).collect()
    }

    /// Straight paths past A, `count` of each class. At the middle frame B has the distance of its
    /// class, and it moves sideways. Paths take turns, as the pairs of a scene do: all first
    /// frames, with alternating classes, then all second frames.
    pub fn frames(&self, count: usize, frames: usize, rng: &mut SplitMix64) -> Vec<Placed> {
        let middles: Vec<Middle> =
            (0..count).flat_map(|_| Class::ALL).map(|class| self.somewhere(class, rng)).collect();
        let times = (0..frames).map(|frame| frame as f64 - 0.5 * (frames - 1) as f64);
        times.flat_map(|time| middles.iter().map(move |middle| middle.at_frame(time))).collect()
    }

    fn somewhere(&self, class: Class, rng: &mut SplitMix64) -> Middle {
        let [a, b] = self.hulls();
        let rotation = random_rotation(rng);
        let direction = DVec3::from_array(rng.direction());
        let [low, high] = class.shares();
        let reach = touching_distance(&a, &b, rotation, direction) * rng.between(low, high);
        let axis = DVec3::from_array(rng.direction());
        let across = direction.cross(axis).normalize() * STEP * self.diameter();
        let center = a.interior_point() + direction * reach;
        Middle { center, center_b: b.interior_point(), rotation, axis, across }
    }
}

/// The middle of a path.
struct Middle {
    /// B's interior point, in A's frame and in B's.
    center: DVec3,
    center_b: DVec3,
    rotation: DQuat,
    /// Rotation axis of B.
    axis: DVec3,
    /// Translation of B in a frame.
    across: DVec3,
}

impl Middle {
    fn at_frame(&self, frame: f64) -> Placed {
        let rotation = DQuat::from_axis_angle(self.axis, TURN_RAD * frame) * self.rotation;
        Placed::new(self.center + self.across * frame - rotation * self.center_b, rotation)
    }
}

/// A random rotation.
pub fn random_rotation(rng: &mut SplitMix64) -> DQuat {
    DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize()
}

/// Distance of the interior points when B, rotated by `rotation`, touches A in direction
/// `direction`.
pub fn touching_distance(a: &Hull<'_>, b: &Hull<'_>, rotation: DQuat, direction: DVec3) -> f64 {
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
    fn poses_match_their_class() {
        for family in FAMILIES {
            let pair = BakedPair::bake(family, 60, SEED).expect("parry accepts it");
            let [a, b] = pair.hulls();
            let poses = pair.poses(60, &mut SplitMix64::new(SEED));
            let hit = |placed: &Placed| intersects(&a, &b, placed.b_in_a, &mut Cache::default()).is_hit();
            let hits = |class: Class| Mix::Only(class).select(&poses).into_iter().filter(hit).count();
            assert_eq!((hits(Class::Penetrating), hits(Class::Separated)), (60, 0), "{}, seed {SEED}", family.name());
            let touching = hits(Class::NearTouching);
            assert!((15..=45).contains(&touching), "{}: {touching} of 60 overlap, seed {SEED}", family.name());
        }
    }

    #[test]
    fn frames_are_a_step_and_a_degree_apart() {
        let pair = BakedPair::bake(Family::Rock, 40, SEED).expect("parry accepts it");
        let center = pair.hulls()[1].interior_point();
        let frames = pair.frames(2, 9, &mut SplitMix64::new(SEED));
        let paths = 2 * Class::ALL.len();
        assert_eq!(frames.len(), 9 * paths);
        for (from, to) in frames.iter().zip(&frames[paths..]) {
            let [from, to] = [from.b_in_a, to.b_in_a];
            let step = from.transform_point(center).distance(to.transform_point(center)) / pair.diameter();
            let turn = from.rotation().angle_between(to.rotation());
            assert!((step - STEP).abs() < 1e-6 && (turn - TURN_RAD).abs() < 1e-5, "{step} {turn}");
        }
    }
}
