//! Two hulls of a family, and their poses.
//!
//! A third of the poses penetrate, a third are within 2 % of touching, a third are separated. The
//! distance at which a pair touches is found by bisection for every pose. The hulls have n points
//! each and different seeds.
//!
//! Poses are rounded to single precision first, so that both engines get the same ones.

use glam::{DQuat, DVec3, Quat, Vec3};
use hullmap::{Cache, Hull, Pack, Pose, intersects};
use hullmap_bake::IndexKind;
use parry3d::{math, shape::ConvexPolyhedron};
use shapes::{families::Family, rng::SplitMix64};

use crate::{rivals::parry::Parry, subject::Subject};

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
    /// State of the pair.
    pub class: Class,
    /// Pose for hullmap.
    pub b_in_a: Pose,
    /// The same pose for parry.
    pub parry: math::Pose,
}

impl Placed {
    /// A pose for hullmap, and parry's rounding of it.
    pub fn from_pose(class: Class, b_in_a: Pose) -> Self {
        Self::new(class, b_in_a.translation(), b_in_a.rotation())
    }

    fn new(class: Class, translation: DVec3, rotation: DQuat) -> Self {
        let (translation, rotation): (Vec3, Quat) = (translation.as_vec3(), rotation.as_quat());
        Self {
            class,
            b_in_a: Pose::from_f32(translation, rotation).expect("finite"),
            parry: math::Pose::from_parts(translation, rotation),
        }
    }
}

/// Two hulls of a family, for both engines.
pub struct BakedPair {
    /// The family.
    pub family: Family,
    packs: [Pack; 2],
    polyhedra: [ConvexPolyhedron; 2],
    /// Vertices of both hulls together: fewer than 2 n if some points are not extreme.
    pub vertices: usize,
}

impl BakedPair {
    /// Bakes two hulls of `n` points; `None` if parry rejects one of them or drops vertices.
    pub fn bake(family: Family, n: usize, seed: u64) -> Option<Self> {
        let subjects = [0, 1].map(|index| Subject::new(family, n, seed + index));
        let [a, b] = subjects.each_ref().map(|subject| Parry::new(subject).map(Parry::into_polyhedron));
        Some(Self {
            family,
            packs: subjects.each_ref().map(|subject| subject.pack(IndexKind::Tree)),
            polyhedra: [a?, b?],
            vertices: subjects.iter().map(Subject::vertex_count).sum(),
        })
    }

    /// A and B.
    pub fn hulls(&self) -> [Hull<'_>; 2] {
        self.packs.each_ref().map(|pack| pack.hull(0).expect("a pack has a hull"))
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
    /// frames, with alternating classes, then all second frames. A frame has the class of its path.
    pub fn frames(&self, count: usize, frames: usize, rng: &mut SplitMix64) -> Vec<Placed> {
        let middles: Vec<Middle> =
            (0..count).flat_map(|_| Class::ALL).map(|class| self.somewhere(class, rng)).collect();
        let times = (0..frames).map(|frame| frame as f64 - 0.5 * (frames - 1) as f64);
        times.flat_map(|time| middles.iter().map(move |middle| middle.at_frame(time))).collect()
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
    /// Rotation axis of B.
    axis: DVec3,
    /// Translation of B in a frame.
    across: DVec3,
}

impl Middle {
    fn at_frame(&self, frame: f64) -> Placed {
        let rotation = DQuat::from_axis_angle(self.axis, TURN_RAD * frame) * self.rotation;
        Placed::new(self.class, self.center + self.across * frame - rotation * self.center_b, rotation)
    }
}

/// Distance of the interior points when B, rotated by `rotation`, touches A in direction
/// `direction`.
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
    fn poses_match_their_class() {
        for family in FAMILIES {
            let pair = BakedPair::bake(family, 60, SEED).expect("parry accepts it");
            let [a, b] = pair.hulls();
            let hits = |class: Class| {
                let poses = pair.poses(60, &mut SplitMix64::new(SEED));
                let of = poses.iter().filter(|placed| placed.class == class);
                of.filter(|placed| intersects(&a, &b, placed.b_in_a, &mut Cache::default()).is_hit()).count()
            };
            assert_eq!((hits(Class::Penetrating), hits(Class::Separated)), (60, 0), "{}, seed {SEED}", family.name());
            let touching = hits(Class::NearTouching);
            assert!((15..=45).contains(&touching), "{}: {touching} of 60 overlap, seed {SEED}", family.name());
        }
    }

    #[test]
    fn frames_are_a_step_and_a_degree_apart() {
        let pair = BakedPair::bake(Family::Rock, 40, SEED).expect("parry accepts it");
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
