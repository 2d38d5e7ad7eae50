//! Hulls of many kinds and the poses of their pairs.
//!
//! The pairs of a seed are indexed, and each can be generated alone. A third of them is
//! penetrating, a third nearly touching, and a third separated. One half of the nearly touching
//! pairs is uniform within 2 % of touching; the other half has distances from 2 % down to 2e-8. The
//! touching pose of a pair is found by bisection with [`hullmap::intersects`]. This affects the
//! sample, not the truth.

use std::collections::HashMap;

use glam::{DQuat, DVec3};
use hullmap::{Cache, Hull, Pack, Pose, SupportMap, intersects};
use hullmap_bake::IndexKind;
use hullmap_testkit::{packs, polytope::Polytope};
use shapes::{families::Family, rng::SplitMix64};

/// Hulls of 4 to 16 random points.
const SMALL: u64 = 120;

/// Families of shapes, and the numbers of points of each.
const FAMILIES: [(Family, &[usize]); 11] = [
    (Family::Sphere, &[8, 20, 60, 128, 400]),
    (Family::ClusteredEllipsoid, &[8, 20, 60, 128]),
    (Family::Rock, &[8, 20, 60, 128, 400]),
    (Family::Prism, &[8, 13, 32, 100]),
    (Family::RotatedPrism, &[8, 13, 32, 100]),
    (Family::Cone, &[8, 20, 64]),
    (Family::Lens, &[10, 40, 128]),
    (Family::UvSphere, &[14, 62]),
    (Family::CubeGrid, &[8, 27, 30]),
    (Family::FlatSheet, &[8, 20]),
    (Family::Needle, &[8, 24, 60]),
];

/// Families of detailed hulls, and the numbers of points of each.
const DETAILED: [(Family, &[usize]); 7] = [
    (Family::Sphere, &[512, 2_000]),
    (Family::ClusteredEllipsoid, &[512, 2_000]),
    (Family::Rock, &[512, 2_000]),
    (Family::RotatedPrism, &[512]),
    (Family::Cone, &[512]),
    (Family::Lens, &[512, 2_000]),
    (Family::UvSphere, &[512]),
];

/// Scales of a pair's hulls. In most pairs, both are 1.
const SCALES: [[f64; 2]; 10] = [
    [1.0, 1.0],
    [1.0, 1.0],
    [1.0, 1.0],
    [1.0, 1.0],
    [1.0, 1.0],
    [1.0, 1.0],
    [1e-6, 1e-6],
    [1e6, 1e6],
    [1.0, 1e-4],
    [1e-4, 1.0],
];

/// Distance of some hulls from their frame's origin, relative to their size.
const FAR: f64 = 50.0;

/// Number of bisections that find the touching pose of a pair, to 1e-15 of its size.
const BISECTIONS: usize = 50;

/// Intended pose of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// At most 0.9 times the touching distance.
    Deep,
    /// Within 2 % of the touching distance.
    Touching,
    /// At least 1.05 times the touching distance.
    Apart,
}

/// A hull's parameters: enough to generate it again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    kind: Kind,
    scale: f64,
    far: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Kind {
    Small(u64),
    Of(Family, usize),
}

impl Recipe {
    /// The family's name, or `small`.
    pub fn family(&self) -> &'static str {
        match self.kind {
            Kind::Small(_) => "small",
            Kind::Of(family, _) => family.name(),
        }
    }

    /// The points of the hull.
    pub fn points(&self) -> Vec<[f32; 3]> {
        let unit: Vec<[f32; 3]> = match self.kind {
            Kind::Small(seed) => {
                let mut rng = SplitMix64::new(seed);
                let count = 4 + rng.below(13);
                let axes = DVec3::from_array([(); 3].map(|()| rng.between(0.3, 1.0)));
                // In half of the hulls, all points are on an ellipsoid, so all are extreme.
                let least = if seed.is_multiple_of(2) { 1.0 } else { 0.2 };
                let point = |rng: &mut SplitMix64| {
                    (DVec3::from_array(rng.direction()) * axes * rng.between(least, 1.0)).as_vec3().to_array()
                };
                (0..count).map(|_| point(&mut rng)).collect()
            }
            Kind::Of(family, n) => family.points(n, n as u64),
        };
        let shift = if self.far { [1.0, -0.7, 0.4].map(|c| c * FAR) } else { [0.0; 3] };
        unit.into_iter()
            .map(|p| [0, 1, 2].map(|axis| ((f64::from(p[axis]) + shift[axis]) * self.scale) as f32))
            .collect()
    }
}

/// A baked hull, and its polytope for the truth.
pub struct Body {
    pack: Pack,
    /// Its faces and edges.
    pub polytope: Polytope,
}

impl Body {
    fn new(recipe: &Recipe) -> Self {
        let pack = packs::pack(recipe.family(), &recipe.points(), IndexKind::Tree);
        let polytope = Polytope::new(&pack.hull(0).expect("a pack has a hull"));
        Self { pack, polytope }
    }

    /// The hull that the solver is queried with.
    pub fn hull(&self) -> Hull<'_> {
        self.pack.hull(0).expect("a pack has a hull")
    }
}

/// A pair of hulls in a pose.
#[derive(Clone, Copy, Debug)]
pub struct ScenePair {
    /// Index of the pair.
    pub index: u64,
    /// A and B.
    pub recipes: [Recipe; 2],
    /// Intended pose.
    pub class: Class,
    /// Pose of B in A's frame.
    pub b_in_a: Pose,
}

/// Range of the hulls' vertex counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// 4 to 400, a third of them at most 16.
    Few,
    /// 512 to 2,000.
    Many,
}

/// All pairs of one seed. Each hull is baked once.
pub struct Scene {
    seed: u64,
    detail: Detail,
    bodies: HashMap<(Kind, u64, bool), Body>,
}

impl Scene {
    /// Starts without baked hulls.
    pub fn new(seed: u64, detail: Detail) -> Self {
        Self { seed, detail, bodies: HashMap::new() }
    }

    /// The pair `index`, with its hulls.
    pub fn pair(&mut self, index: u64) -> (ScenePair, [&Body; 2]) {
        let mut rng = SplitMix64::new(self.seed ^ index.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let scales = SCALES[rng.below(SCALES.len())];
        let mut recipes =
            scales.map(|scale| Recipe { kind: kind(self.detail, &mut rng), scale, far: rng.below(6) == 0 });
        // The difference of two parallel polygons is not solid, so at most one hull is a polygon.
        if recipes.iter().all(|recipe| recipe.family() == Family::FlatSheet.name()) {
            recipes[1].kind = Kind::Small(0);
        }
        // A hull far from its origin is rounded to 1e-6 of its size; a flat one would not be flat.
        recipes.iter_mut().for_each(|recipe| recipe.far &= recipe.family() != Family::FlatSheet.name());
        for recipe in &recipes {
            self.bodies.entry(key(recipe)).or_insert_with(|| Body::new(recipe));
        }
        let bodies = recipes.each_ref().map(|recipe| &self.bodies[&key(recipe)]);
        let [a, b] = bodies.map(Body::hull);
        let class = [Class::Deep, Class::Touching, Class::Apart][(index % 3) as usize];
        let share = match class {
            Class::Deep => rng.between(0.0, 0.9),
            Class::Apart => rng.between(1.05, 2.0),
            Class::Touching => {
                let smaller = if rng.below(2) == 0 { 1.0 } else { 10_f64.powf(-rng.between(0.0, 6.0)) };
                1.0 + rng.between(-0.02, 0.02) * smaller
            }
        };
        let rotation = rotation(&mut rng);
        let direction = match rng.below(10) {
            0 => DVec3::AXES[rng.below(3)],
            _ => DVec3::from_array(rng.direction()),
        };
        let reach = touching_distance(&a, &b, rotation, direction) * share;
        let center = a.interior_point() + direction * reach;
        let b_in_a = Pose::new(center - rotation * b.interior_point(), rotation).expect("finite");
        (ScenePair { index, recipes, class, b_in_a }, bodies)
    }
}

fn key(recipe: &Recipe) -> (Kind, u64, bool) {
    (recipe.kind, recipe.scale.to_bits(), recipe.far)
}

fn kind(detail: Detail, rng: &mut SplitMix64) -> Kind {
    let families = match detail {
        Detail::Few if rng.below(3) == 0 => return Kind::Small(rng.next_u64() % SMALL),
        Detail::Few => &FAMILIES[..],
        Detail::Many => &DETAILED[..],
    };
    let (family, counts) = families[rng.below(families.len())];
    Kind::Of(family, counts[rng.below(counts.len())])
}

/// Mostly random; some rotations keep axes parallel, exactly or nearly.
fn rotation(rng: &mut SplitMix64) -> DQuat {
    let axis = DVec3::from_array(rng.direction());
    match rng.below(20) {
        0 => DQuat::IDENTITY,
        1 => DQuat::from_axis_angle(DVec3::AXES[rng.below(3)], std::f64::consts::FRAC_PI_2 * rng.below(4) as f64),
        2 => DQuat::from_axis_angle(axis, 10_f64.powf(-rng.between(1.0, 12.0))),
        _ => DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize(),
    }
}

/// Distance of the interior points when B touches A.
fn touching_distance(a: &Hull<'_>, b: &Hull<'_>, rotation: DQuat, direction: DVec3) -> f64 {
    let from = a.interior_point() - rotation * b.interior_point();
    let (mut inside, mut outside) = (0.0, a.outer_radius() + b.outer_radius());
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (inside + outside);
        let b_in_a = Pose::new(from + direction * middle, rotation).expect("finite");
        if intersects(a, b, b_in_a, &mut Cache::default()).is_hit() { inside = middle } else { outside = middle }
    }
    inside
}
