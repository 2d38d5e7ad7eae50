//! The shapes of the soak: game hulls, generated hulls from slivers to points, and shapes in closed
//! form, from 1e-6 to 1e6 in size and also far from their frames' origins.

use std::{collections::BTreeMap, fmt};

use glam::DVec3;
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, Rounded, Scaled, Segment, Sphere, Triangle};
use hullmap::{Hull, Pack, Pose};
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_testkit::{packs, random::RandomPoses};
use shapes::{families::Family, rng::SplitMix64};

use super::{
    body::{Any, Body, Kind, Solid},
    meeting::{self, Meeting},
    model::{Core, Model},
};

/// Sizes of generated hulls and of shapes in closed form.
const SIZES: [f64; 7] = [1e-6, 1e-3, 0.1, 1.0, 10.0, 1e3, 1e6];

/// Distance of some hulls from their frame's origin, relative to their size.
const FAR: [f64; 3] = [1.0, -0.7, 0.4];
const FAR_SIZES: f64 = 50.0;

/// Thicknesses of slivers, relative to their length. Below 5e-8 a hull is a polygon or a segment.
const THICKNESSES: [f64; 5] = [1e-2, 1e-4, 1e-6, 2e-7, 1e-8];

/// Families of shapes, and the numbers of points of each.
const FAMILIES: [(Family, &[usize]); 10] = [
    (Family::Sphere, &[8, 30, 128, 2_000]),
    (Family::ClusteredEllipsoid, &[20, 128]),
    (Family::Rock, &[30, 400]),
    (Family::UvSphere, &[14, 62]),
    (Family::Prism, &[8, 13, 64, 200]),
    (Family::RotatedPrism, &[13, 64]),
    (Family::Cone, &[20]),
    (Family::Lens, &[40]),
    (Family::CubeGrid, &[8, 27]),
    (Family::Needle, &[24]),
];

/// Two bodies and their pose.
pub struct BodyPair<'c, 'p> {
    /// Index of the pair.
    pub index: u64,
    /// Seed of the run.
    pub seed: u64,
    /// A and B.
    pub bodies: [&'c Body<'p>; 2],
    /// Intended pose.
    pub meeting: Meeting,
    /// Pose of B in A's frame.
    pub b_in_a: Pose,
}

impl fmt::Display for BodyPair<'_, '_> {
    /// Everything needed to reproduce the pair.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (t, r) = (self.b_in_a.translation(), self.b_in_a.rotation());
        write!(
            f,
            "{:?}: {} and {}\n  pose {:e} {:e} {:e} {:e} {:e} {:e} {:e}\n  reproduce: cargo program \
             solver-soak -- --seed {} --first {} --pairs 1",
            self.meeting,
            self.bodies[0].name,
            self.bodies[1].name,
            t.x,
            t.y,
            t.z,
            r.x,
            r.y,
            r.z,
            r.w,
            self.seed,
            self.index,
        )
    }
}

/// The packs that bodies are read from.
pub struct Stock {
    pack: Pack,
    kinds: Vec<(Kind, String)>,
    /// Point sets that the baker rejected, and the reasons.
    pub rejected: Vec<String>,
}

impl Stock {
    /// Bakes all generated hulls, and every `stride`-th of the clouds.
    pub fn bake(clouds: &[Vec<[f32; 3]>], stride: usize) -> Self {
        let (mut kinds, mut baked, mut rejected) = (Vec::new(), Vec::new(), Vec::new());
        let mut add = |kind: Kind, name: String, points: &[[f32; 3]]| {
            let set = packs::point_set(&name, points);
            match hullmap_bake::bake_hull(&set, IndexKind::Tree) {
                Ok(hull) => {
                    baked.push(hull);
                    kinds.push((kind, name));
                }
                Err(error) => rejected.push(format!("{name}: {error}")),
            }
        };
        for (index, cloud) in clouds.iter().enumerate().step_by(stride.max(1)) {
            add(Kind::Game, format!("game hull {index}"), cloud);
        }
        for (kind, name, points) in generated() {
            for size in SIZES {
                for far in [0.0, FAR_SIZES] {
                    // Moving a flat set rounds it again, so that it is no longer flat but a sliver.
                    let at = |p: &[f64; 3]| [0, 1, 2].map(|axis| ((p[axis] + FAR[axis] * far) * size) as f32);
                    let points: Vec<[f32; 3]> = points.iter().map(at).collect();
                    add(kind, format!("{name} of size {size:e}, {far} away"), &points);
                }
            }
        }
        let bytes = hullmap_bake::write_pack(&baked, &SourceRecord::default()).expect("there are hulls");
        Self { pack: Pack::from_bytes(&bytes).expect("a written pack opens"), kinds, rejected }
    }

    /// The hull with this name.
    pub fn hull(&self, name: &str) -> Option<Hull<'_>> {
        let index = self.kinds.iter().position(|(_, known)| known == name)?;
        self.pack.hull(index).ok()
    }
}

/// Generated point sets of about unit size.
fn generated() -> Vec<(Kind, String, Vec<[f64; 3]>)> {
    let mut sets = Vec::new();
    for (family, counts) in FAMILIES {
        for &n in counts {
            let points = family.points(n, n as u64).into_iter().map(|p| p.map(f64::from)).collect();
            sets.push((Kind::Family, format!("{} {n}", family.name()), points));
        }
    }
    for n in [4, 5, 6] {
        let points = Family::Sphere.points(8, n as u64).into_iter().take(n).map(|p| p.map(f64::from));
        sets.push((Kind::Family, format!("{n} points of a sphere"), points.collect()));
    }
    let mut rng = SplitMix64::new(0x51);
    for thickness in THICKNESSES {
        // Along the axes, and turned: then rounding bends the shape.
        for turned in [false, true] {
            let rows = if turned { turn(&mut rng) } else { [DVec3::X, DVec3::Y, DVec3::Z] };
            let make = |corners: Vec<DVec3>| -> Vec<[f64; 3]> {
                corners.iter().map(|p| rows.map(|row| row.dot(*p))).collect()
            };
            let name = |what: &str| format!("{what} {thickness:e} thick{}", if turned { ", turned" } else { "" });
            let corner = |i: u32, half: DVec3| {
                DVec3::from_array([1, 2, 4].map(|bit| if i & bit == 0 { -1.0 } else { 1.0 })) * half
            };
            let sheet = DVec3::new(1.0, 0.7, 0.5 * thickness);
            let rod = DVec3::new(1.0, 0.5 * thickness, 0.4 * thickness);
            let slab = (0..8).map(|i| corner(i, sheet)).collect();
            let bar = (0..8).map(|i| corner(i, rod)).collect();
            let tetrahedron = vec![DVec3::X, DVec3::NEG_X, DVec3::Y * 0.8, DVec3::new(0.1, 0.2, thickness)];
            let kite = vec![DVec3::X, DVec3::NEG_X, DVec3::Y * thickness, DVec3::new(0.0, 0.5 * thickness, 0.9)];
            let disc = (0..24).flat_map(|i| {
                let p = DVec3::from_array(Family::Prism.points(48, 1)[i].map(f64::from));
                [p * DVec3::new(1.0, 1.0, 0.5 * thickness), p * DVec3::new(1.0, 1.0, -0.5 * thickness)]
            });
            sets.push((Kind::Sliver, name("slab"), make(slab)));
            sets.push((Kind::Sliver, name("bar"), make(bar)));
            sets.push((Kind::Sliver, name("tetrahedron"), make(tetrahedron)));
            sets.push((Kind::Sliver, name("kite"), make(kite)));
            sets.push((Kind::Sliver, name("disc"), make(disc.collect())));
        }
    }
    let flat = |points: &[[f64; 2]]| points.iter().map(|[x, y]| [*x, *y, 0.25]).collect::<Vec<_>>();
    let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    sets.push((Kind::Flat, "square".into(), flat(&square)));
    sets.push((Kind::Flat, "triangle".into(), flat(&square[..3])));
    sets.push((Kind::Flat, "sliver of a triangle".into(), flat(&[[-1.0, 0.0], [1.0, 0.0], [0.3, 1e-5]])));
    let sheet = Family::FlatSheet.points(40, 1).into_iter().map(|p| p.map(f64::from)).collect();
    sets.push((Kind::Flat, "flat sheet".into(), sheet));
    sets.push((Kind::Flat, "segment along x".into(), vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]));
    sets.push((Kind::Flat, "segment".into(), vec![[-0.3, 0.2, 0.9], [0.5, -0.4, -0.7]]));
    sets.push((Kind::Flat, "point".into(), vec![[0.25, -0.5, 0.125]]));
    sets
}

/// Three random perpendicular unit vectors.
fn turn(rng: &mut SplitMix64) -> [DVec3; 3] {
    let x = rng.unit_vector();
    let y = x.cross(rng.unit_vector()).normalize();
    [x, y, x.cross(y)]
}

/// All bodies, by the decade of their size.
pub struct Bodies<'p> {
    decades: BTreeMap<i32, Vec<Body<'p>>>,
    keys: Vec<i32>,
    /// Numbers of bodies by kind.
    pub counts: BTreeMap<Kind, usize>,
}

impl<'p> Bodies<'p> {
    /// All bodies that can be made from `stock`.
    pub fn new(stock: &'p Stock) -> Self {
        let mut bodies: Vec<Body<'p>> = Vec::new();
        for (hull, (kind, name)) in stock.pack.hulls().zip(&stock.kinds) {
            let model = Model::of_hull(&hull);
            bodies.push(Body { name: name.clone(), kind: *kind, solid: Solid::Hull(hull), model });
        }
        let step = (bodies.len() / 40).max(1);
        let some: Vec<(Hull<'p>, String)> = (stock.pack.hulls().zip(&stock.kinds))
            .step_by(step)
            .map(|(hull, (_, name))| (hull, name.clone()))
            .collect();
        for (hull, name) in some {
            let radius = 0.2 * hull.diameter();
            let mut add = |what: &str, shape: Box<Any<'p>>, model: Model| {
                let name = format!("{what} {name}");
                bodies.push(Body { name, kind: Kind::Closed, solid: Solid::Shape(shape), model });
            };
            let scale = DVec3::new(-1.0, 0.5, 2.0);
            let scaled = Scaled::new(hull, scale).expect("a scale");
            add(
                "rounded",
                Box::new(Rounded::new(hull, radius).expect("a radius")),
                Model::of_hull(&hull).rounded(radius),
            );
            add("scaled", Box::new(scaled), Model::of_hull(&hull).scaled(scale));
            let thin = DVec3::new(1.0, 1e-6, 1.0);
            add("squeezed", Box::new(Scaled::new(hull, thin).expect("a scale")), Model::of_hull(&hull).scaled(thin));
            add(
                "scaled and rounded",
                Box::new(Rounded::new(scaled, radius).expect("a radius")),
                Model::of_hull(&hull).scaled(scale).rounded(radius),
            );
        }
        for size in SIZES {
            closed(size, &mut bodies);
        }
        let mut decades: BTreeMap<i32, Vec<Body<'p>>> = BTreeMap::new();
        let mut counts = BTreeMap::new();
        for body in bodies {
            *counts.entry(body.kind).or_default() += 1;
            decades.entry(decade(body.shape().outer_radius())).or_default().push(body);
        }
        Self { keys: decades.keys().copied().collect(), decades, counts }
    }

    /// Pair `index` of `seed`.
    pub fn pair(&self, seed: u64, index: u64) -> BodyPair<'_, 'p> {
        // The seed is mixed, so that neighbouring seeds have no pairs in common.
        let mut rng = SplitMix64::new(SplitMix64::new(seed).next_u64() ^ index.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let a = self.pick(self.any_decade(&mut rng), &mut rng);
        // B usually has the size of A, sometimes is smaller, and sometimes is A.
        let size = decade(a.shape().outer_radius());
        let b = match rng.below(16) {
            0 => a,
            1 => self.pick(self.any_decade(&mut rng), &mut rng),
            2 | 3 if self.decades.contains_key(&(size - 1)) => self.pick(size - 1, &mut rng),
            _ => self.pick(size, &mut rng),
        };
        let (meeting, b_in_a) = meeting::meet(&mut rng, a, b);
        BodyPair { index, seed, bodies: [a, b], meeting, b_in_a }
    }

    /// In half of the draws, the usual decade of game hulls; otherwise any decade.
    fn any_decade(&self, rng: &mut SplitMix64) -> i32 {
        let usual = decade(1.0);
        if rng.below(2) == 0 && self.decades.contains_key(&usual) {
            usual
        } else {
            self.keys[rng.below(self.keys.len())]
        }
    }

    fn pick(&self, decade: i32, rng: &mut SplitMix64) -> &Body<'p> {
        let bodies = &self.decades[&decade];
        &bodies[rng.below(bodies.len())]
    }
}

/// The power of ten below a size; 0 for points, which meet hulls of about unit size.
fn decade(size: f64) -> i32 {
    if !(size > 0.0) {
        return 0;
    }
    let (mut rest, mut power) = (size, 0);
    while rest >= 10.0 {
        (rest, power) = (rest / 10.0, power + 1);
    }
    while rest < 1.0 {
        (rest, power) = (rest * 10.0, power - 1);
    }
    power
}

/// Shapes in closed form of one size, flat and thin ones among them.
fn closed(size: f64, bodies: &mut Vec<Body<'_>>) {
    let mut add = |what: &str, shape: Box<Any<'static>>, model: Model| {
        let name = format!("{what} of size {size:e}");
        bodies.push(Body { name, kind: Kind::Closed, solid: Solid::Shape(shape), model });
    };
    let s = |share: f64| share * size;
    add("sphere", Box::new(Sphere::new(s(0.8)).expect("a radius")), Model::new(Core::Segment(0.0)).rounded(s(0.8)));
    for half in [[0.5, 0.8, 1.0], [0.2, 0.3, 0.05], [1.0, 1.0, 1e-7], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0]] {
        let half = DVec3::from_array(half) * size;
        add(&format!("box {half}"), Box::new(Cuboid::new(half).expect("lengths")), Model::new(Core::Cuboid(half)));
    }
    for (half, radius) in [(0.7, 0.3), (0.7, 1e-6), (0.7, 0.0), (0.0, 0.5)] {
        let (half, radius) = (s(half), s(radius));
        let shape = Box::new(Capsule::new(half, radius).expect("lengths"));
        add(&format!("capsule {half} {radius}"), shape, Model::new(Core::Segment(half)).rounded(radius));
    }
    for (half, radius) in [(0.7, 0.5), (0.9, 0.01), (0.0, 0.8), (1e-6, 0.8), (0.1, 0.24)] {
        let (half, radius) = (s(half), s(radius));
        let shape = Box::new(Cylinder::new(half, radius).expect("lengths"));
        add(&format!("cylinder {half} {radius}"), shape, Model::new(Core::Cylinder(half, radius)));
    }
    for (half, radius) in [(0.7, 0.5), (0.9, 0.01), (0.05, 0.8), (0.0, 0.8)] {
        let (half, radius) = (s(half), s(radius));
        let shape = Box::new(Cone::new(half, radius).expect("lengths"));
        add(&format!("cone {half} {radius}"), shape, Model::new(Core::Cone(half, radius)));
    }
    let corners = [[0.6, -0.2, 0.1], [-0.3, 0.5, 0.2], [-0.2, -0.4, -0.3]].map(|c| DVec3::from_array(c) * size);
    let ends = Model::new(Core::Points { points: corners[..2].to_vec(), planes: Vec::new(), edges: Vec::new() });
    let segment = Segment::new(corners[0], corners[1]).expect("points");
    add("oblique segment", Box::new(segment), ends.clone());
    let capsule = Capsule::between(corners[0], corners[1], s(0.3)).expect("lengths");
    add("oblique capsule", Box::new(capsule), ends.rounded(s(0.3)));
    let sliver = [DVec3::X * size, DVec3::NEG_X * size, DVec3::new(0.3, 1e-6, 0.0) * size];
    for corners in [corners, sliver, sliver.map(|p| p + DVec3::new(3.0, -7.0, 5.0) * size)] {
        let triangle = Triangle::new(corners).expect("points");
        add(&format!("triangle {corners:?}"), Box::new(triangle), Model::of_triangle(corners));
        let rounded = Rounded::new(triangle, s(0.2)).expect("a radius");
        add(&format!("rounded triangle {corners:?}"), Box::new(rounded), Model::of_triangle(corners).rounded(s(0.2)));
    }
    let scale = DVec3::new(1.0, 0.6, 0.3);
    let ellipsoid = Scaled::new(Sphere::new(size).expect("a radius"), scale).expect("a scale");
    add("ellipsoid", Box::new(ellipsoid), Model::new(Core::Ball(size)).scaled(scale));
    let half = DVec3::new(0.6, 0.4, 0.2) * size;
    let rounded = Rounded::new(Cuboid::new(half).expect("lengths"), s(0.1)).expect("a radius");
    add("rounded box", Box::new(rounded), Model::new(Core::Cuboid(half)).rounded(s(0.1)));
}
