//! Manifolds of sheets: every point is on both surfaces, and separated by at most the prediction.
//!
//! | claim | truth |
//! |---|---|
//! | the point of the sheet is on the triangle of its pair | distance from that triangle, by its plane and its edges |
//! | the point of the body is on its surface | the body's definition ([`Model`]) |
//! | the depth is along the normal | the two points differ by the depth times the normal |
//! | the point is within the prediction | the depth |
//! | no point is missing | `missing` |
//!
//! Bodies of all kinds stand, lie and lean on sheets of all kinds, welded and not, on both sides or
//! on fronts, as A or as B, while they slide. They are sunk in by up to a tenth of their radius, or
//! their middle is in the plane of a triangle.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use hullmap::Geometry;
use hullmap::compound::{BodyManifold, Joined, OneSided, Parts, Tile, seams};
use hullmap::height_field::{Diagonal, Layout};
use hullmap::manifold::{FeatureId, Manifold, ManifoldPoint};
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, HalfSpace, Rounded, Scaled, Sphere, Triangle};
use hullmap::{Compound, CompoundManifolds, ManifoldSettings, Pack, Pose, Prediction, Shape, Status};
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_testkit::gap::distance_by_features;
use hullmap_testkit::packs::{self, point_set};
use hullmap_testkit::random::RandomPoses;
use hullmap_testkit::triangles::distance_from_triangle;
use shapes::rng::SplitMix64;

use super::{scene::stream, tally::Tally};
use crate::soak::model::{Core, Model};

/// Maximum distance of a point from a surface, relative to the outer radius of the smaller one of
/// triangle and body: the slack of clipping, and what a slope adds.
const OFF_SURFACE: f64 = 2e-6;

/// Rounding error of coordinates relative to their greatest: 0.2 micrometres at 1,000 km.
const F64: f64 = 1024.0 * f64::EPSILON;

/// Distance of corners of a hull's face from its plane, relative to its size: rounding to f32.
const F32: f64 = f32::EPSILON as f64;

/// Tolerance of points on curved surfaces, relative to the body's own radius.
const CURVED: f64 = 1e-10;

/// Updates of each body.
const FRAMES: u32 = 3;

/// Bodies of each sheet.
const BODIES: usize = 12;

/// Kinds of sheets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ground {
    /// A grid of squares of size 1 with random heights.
    Rough,
    /// The same, as a height field with holes.
    Field,
    /// A level grid.
    Level,
    /// A slope of few whole numbers, so that many planes are equal.
    Steps,
    /// Rectangles 1,000 times as long as wide.
    Needles,
    /// Two triangles of 20 km to 1,000 km.
    Huge,
    /// Triangles at random places, of sizes from 0.001 to 3.
    Soup,
    /// A rough grid 10 km from the origin.
    Far,
}

const GROUNDS: [Ground; 8] = [
    Ground::Rough,
    Ground::Field,
    Ground::Level,
    Ground::Steps,
    Ground::Needles,
    Ground::Huge,
    Ground::Soup,
    Ground::Far,
];

/// A sheet, and the corners of its triangles; `None` in holes.
pub(super) struct Sheet {
    parts: Box<dyn AnySheet>,
    pub(super) triangles: Vec<Option<[DVec3; 3]>>,
    pub(super) greatest: f64,
    /// Half of the side of a level square.
    pub(super) level: Option<f64>,
}

/// A mesh or a height field beside a body of one part or several.
trait AnySheet {
    fn update(&self, found: &mut CompoundManifolds, body: &Body, pose: Pose, query: Query);
}

/// How a pair is queried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// The sheet is A.
    First,
    /// The sheet is B.
    Second,
    /// The sheet is A, and one of two tiles.
    Joined,
}

/// A query of a sheet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Query {
    pub(super) way: Way,
    pub(super) is_one_sided: bool,
    /// A length.
    pub(super) prediction: f64,
}

impl<S: Geometry + Parts> AnySheet for S {
    fn update(&self, found: &mut CompoundManifolds, body: &Body, pose: Pose, query: Query) {
        if query.is_one_sided {
            update(&OneSided::new(self), found, body, pose, query)
        } else {
            update(self, found, body, pose, query)
        }
    }
}

fn update<S: Geometry + Parts>(sheet: &S, found: &mut CompoundManifolds, body: &Body, pose: Pose, query: Query) {
    let union = seams::union_of(sheet);
    let tiles = [Tile { union: &union, parts: sheet.part_count(), place: Pose::IDENTITY }; 2];
    let joined = Joined::new(&tiles);
    let settings =
        &ManifoldSettings { prediction: Prediction::Length(query.prediction), ..ManifoldSettings::default() };
    match (&body.solid, query.way) {
        (Solid::Convex(b), Way::First) => found.update(sheet, &**b, pose, settings),
        (Solid::Convex(b), Way::Second) => found.update(&**b, sheet, pose.inverse(), settings),
        (Solid::Convex(b), Way::Joined) => found.update_joined(&joined, 1, sheet, &**b, pose, settings),
        (Solid::Parts(b), Way::First) => found.update(sheet, &Compound::new(b), pose, settings),
        (Solid::Parts(b), Way::Second) => found.update(&Compound::new(b), sheet, pose.inverse(), settings),
        (Solid::Parts(b), Way::Joined) => found.update_joined(&joined, 1, sheet, &Compound::new(b), pose, settings),
        (Solid::HalfSpace(b), Way::Second) => found.update(b, sheet, pose.inverse(), settings),
        (Solid::HalfSpace(b), _) => found.update(sheet, b, pose, settings),
    };
}

enum Solid {
    Convex(Box<dyn Shape>),
    Parts(Pack),
    HalfSpace(HalfSpace),
}

/// A body, and the definition of each of its parts.
pub(super) struct Body {
    pub(super) name: &'static str,
    solid: Solid,
    pub(super) models: Vec<Model>,
    /// Distance of a point from the surface, where the model has only a lower bound.
    off: Option<Box<dyn Fn(DVec3) -> f64>>,
    /// Radius of a ball around its origin.
    pub(super) radius: f64,
    /// Distance of its corners from the planes of its faces.
    rough: f64,
}

impl Body {
    /// Distance of a point from the surface of a part.
    fn off(&self, part: usize, point: DVec3) -> f64 {
        self.off.as_ref().map_or_else(|| self.models[part].outside(point), |off| off(point)).abs()
    }

    /// Calls `run` with a part; `None` for a half-space.
    pub(super) fn with_part<T>(&self, part: usize, run: impl FnOnce(&dyn Shape) -> T) -> Option<T> {
        match &self.solid {
            Solid::Convex(shape) => Some(run(&**shape)),
            Solid::Parts(pack) => Some(run(&pack.hull(part).ok()?)),
            Solid::HalfSpace(_) => None,
        }
    }
}

fn grid(rng: &mut SplitMix64, ground: Ground) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let cells = 1 + rng.below(6);
    let steep = rng.between(0.0, 1.5);
    let far = if ground == Ground::Far { 1e4 } else { 0.0 };
    let long = if ground == Ground::Needles { 1e3 } else { 1.0 };
    let (mut positions, mut corners) = (Vec::new(), Vec::new());
    for at in 0..(cells + 1) * (cells + 1) {
        let [x, y] = [at % (cells + 1), at / (cells + 1)].map(|i| i as f64 - 0.5 * cells as f64);
        let z = match ground {
            Ground::Level => 0.0,
            Ground::Steps => 0.25 * rng.below(5) as f64,
            _ => steep * rng.unit(),
        };
        positions.push([(x * long + far) as f32, (y - far) as f32, z as f32]);
    }
    for at in 0..cells * cells {
        let first = (at / cells * (cells + 1) + at % cells) as u32;
        let [a, b, c, d] = [first, first + 1, first + cells as u32 + 2, first + cells as u32 + 1];
        corners.extend(if rng.below(2) == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
    }
    (positions, corners)
}

fn loose(rng: &mut SplitMix64) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let count = 1 + rng.below(24) as u32;
    let mut positions = Vec::new();
    for _ in 0..count {
        let (middle, size) = (rng.unit_vector() * rng.unit(), 10_f64.powf(rng.between(-3.0, 0.5)));
        positions.extend([(); 3].map(|()| (middle + size * rng.unit_vector()).as_vec3().to_array()));
    }
    (positions, (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

fn sheet(rng: &mut SplitMix64, ground: Ground) -> Sheet {
    if ground == Ground::Field {
        let (columns, rows) = (2 + rng.below(5), 2 + rng.below(5));
        let diagonal = [Diagonal::Rising, Diagonal::Falling][rng.below(2)];
        let layout = Layout { columns, rows, origin: [-1.0, 2.0], spacing: [1.0, 1.0], diagonal };
        let steep = rng.between(0.0, 1.5);
        let heights: Vec<f32> = (0..columns * rows).map(|_| (steep * rng.unit()) as f32).collect();
        let cells = (columns - 1) * (rows - 1);
        let holes: Vec<bool> = (0..cells).map(|cell| cell > 0 && rng.below(5) == 0).collect();
        let field = packs::height_field(layout, &heights, &holes);
        let triangles = (0..field.triangle_count()).map(|i| Some(field.triangle(i)?.corners())).collect();
        return Sheet::new(Box::new(field), triangles);
    }
    let (positions, corners) = match ground {
        Ground::Huge => {
            let side = [2e4, 1e6][rng.below(2)] as f32;
            let low = (rng.between(-0.3, 0.0) * f64::from(side)) as f32;
            let positions = vec![[0.0, 0.0, 0.0], [side, 0.0, 0.0], [side, side, low], [0.0, side, 0.0]];
            (positions, vec![[0, 1, 3], [1, 2, 3]])
        }
        Ground::Soup => loose(rng),
        _ => grid(rng, ground),
    };
    let mesh = packs::triangle_mesh(&positions, &corners);
    let triangles = (0..mesh.triangle_count()).map(|i| Some(mesh.triangle(i)?.corners())).collect();
    Sheet::new(Box::new(mesh), triangles)
}

impl Sheet {
    fn new(parts: Box<dyn AnySheet>, triangles: Vec<Option<[DVec3; 3]>>) -> Self {
        let greatest = triangles.iter().flatten().flatten().map(|corner| corner.length()).fold(0.0, f64::max);
        let corners = || triangles.iter().flatten().flatten();
        let level = corners().all(|corner| corner.z == 0.0).then(|| corners().map(|c| c.x).fold(0.0, f64::max));
        Self { parts, triangles, greatest, level }
    }
}

impl Body {
    fn convex(name: &'static str, shape: Box<dyn Shape>, model: Model) -> Self {
        let radius = model.greatest;
        Self { name, solid: Solid::Convex(shape), models: vec![model], off: None, radius, rough: CURVED * radius }
    }

    /// The hulls of points.
    fn parts(name: &'static str, clouds: &[Vec<[f32; 3]>]) -> Self {
        let sets: Vec<_> = clouds.iter().map(|cloud| point_set(name, cloud)).collect();
        let bytes = packs::bytes(&sets, IndexKind::Tree, &SourceRecord::default()).expect("hulls");
        let pack = Pack::from_bytes(&bytes).expect("a pack");
        let models: Vec<Model> = pack.hulls().map(|hull| Model::of_hull(&hull)).collect();
        let radius = models.iter().map(|model| model.greatest).fold(0.0, f64::max);
        Self { name, solid: Solid::Parts(pack), models, off: None, radius, rough: F32 * radius }
    }
}

fn cloud(rng: &mut SplitMix64, size: f64, middle: DVec3) -> Vec<[f32; 3]> {
    let corner = |rng: &mut SplitMix64| (middle + 0.6 * size * rng.unit_vector()).as_vec3();
    (0..5 + rng.below(12)).map(|_| corner(rng).to_array()).collect()
}

fn body(rng: &mut SplitMix64, size: f64, is_box: bool) -> Body {
    let s = |rng: &mut SplitMix64| size * rng.between(0.2, 1.0);
    let convex = Body::convex;
    match if is_box { 0 } else { rng.below(14) } {
        0 | 1 => {
            let half = DVec3::new(s(rng), s(rng), s(rng));
            convex("cuboid", Box::new(Cuboid::new(half).expect("lengths")), Model::new(Core::Cuboid(half)))
        }
        2 => convex("ball", Box::new(Sphere::new(size).expect("a radius")), Model::new(Core::Ball(size))),
        3 => {
            let (half, radius) = (s(rng), s(rng));
            let shape = Box::new(Capsule::new(half, radius).expect("lengths"));
            convex("capsule", shape, Model::new(Core::Segment(half)).rounded(radius))
        }
        4 => {
            let (half, radius) = (s(rng), s(rng));
            let shape = Box::new(Cylinder::new(half, radius).expect("lengths"));
            convex("cylinder", shape, Model::new(Core::Cylinder(half, radius)))
        }
        5 => {
            let (half, radius) = (s(rng), s(rng));
            convex("cone", Box::new(Cone::new(half, radius).expect("lengths")), Model::new(Core::Cone(half, radius)))
        }
        6 => {
            let (half, radius) = (s(rng), 0.3 * s(rng));
            let shape = Rounded::new(Cylinder::new(0.0, half).expect("lengths"), radius).expect("a radius");
            convex("rounded disc", Box::new(shape), Model::new(Core::Cylinder(0.0, half)).rounded(radius))
        }
        7 => Body::parts("hull", &[cloud(rng, size, DVec3::ZERO)]),
        8 => {
            let middles = [DVec3::ZERO, DVec3::X, DVec3::new(0.4, 0.8, 0.0)].map(|middle| middle * size * 0.7);
            Body::parts("compound", &middles.map(|middle| cloud(rng, size, middle)))
        }
        _ => derived(rng, size),
    }
}

/// Bodies made of other shapes, a triangle and a half-space.
fn derived(rng: &mut SplitMix64, size: f64) -> Body {
    let convex = Body::convex;
    let single = |rng: &mut SplitMix64| {
        let hull = Arc::new(packs::tree_pack(&cloud(rng, size, DVec3::ZERO))).shared_hull(0).expect("one hull");
        let model = Model::of_hull(hull.hull());
        (hull, model)
    };
    match rng.below(5) {
        0 => {
            let scale = DVec3::new(rng.between(0.3, 1.0), -rng.between(0.3, 1.0), rng.between(0.3, 1.0));
            let shape = Scaled::new(Sphere::new(size).expect("a radius"), scale).expect("a scale");
            let body = convex("ellipsoid", Box::new(shape), Model::new(Core::Ball(size)).scaled(scale));
            // To first order: the height in the frame of the ball, over its gradient.
            let off = move |point: DVec3| {
                let q = point / scale;
                (q.length() - size) * q.length() / (q / scale).length()
            };
            Body { off: Some(Box::new(off)), ..body }
        }
        1 => {
            let ((hull, model), scale) = (single(rng), DVec3::new(0.5, -1.5, rng.between(0.3, 1.0)));
            let body = convex("scaled hull", Box::new(Scaled::new(hull, scale).expect("a scale")), model.scaled(scale));
            Body { rough: F32 * body.radius, ..body }
        }
        2 => {
            let ((hull, model), radius) = (single(rng), size * rng.between(0.06, 0.3));
            let vertices: Vec<_> = hull.hull().vertices().map(|v| v.as_dvec3()).collect();
            let off = move |point| distance_by_features(&[point], &vertices) - radius;
            let shape = Rounded::new(hull, radius).expect("a radius");
            let body = convex("rounded hull", Box::new(shape), model.rounded(radius));
            Body { rough: F32 * body.radius, off: Some(Box::new(off)), ..body }
        }
        3 => {
            let corners = [(); 3].map(|()| size * rng.unit_vector());
            convex("triangle", Box::new(Triangle::new(corners).expect("points")), Model::of_triangle(corners))
        }
        _ => {
            let (normal, offset) = (-DVec3::AXES[rng.below(3)], size * rng.between(-1.0, 1.0));
            let core =
                Core::Points { points: vec![normal * offset], planes: vec![(normal, offset)], edges: Vec::new() };
            let solid = Solid::HalfSpace(HalfSpace::new(normal, offset).expect("a plane"));
            let mut model = Model::new(core);
            model.greatest = f64::INFINITY;
            Body { name: "half-space", solid, models: vec![model], off: None, radius: size, rough: CURVED * size }
        }
    }
}

/// A pose in which a body touches the sheet near a random place, and its size relative to the
/// triangle there.
fn place(rng: &mut SplitMix64, sheet: &Sheet, body: &Body) -> Pose {
    let triangles: Vec<[DVec3; 3]> = sheet.triangles.iter().flatten().copied().collect();
    let [a, b, c] = triangles[rng.below(triangles.len())];
    // In the triangle, on an edge, or at a corner; of a large triangle, often within reach of an
    // edge.
    let mut shares = [rng.unit() + 1e-3, rng.unit(), rng.unit()];
    (0..rng.below(3)).for_each(|zero| shares[2 - zero] = 0.0);
    let sum: f64 = shares.iter().sum();
    let on = (a * shares[0] + b * shares[1] + c * shares[2]) / sum;
    let face = (b - a).cross(c - a).normalize_or(DVec3::Z);
    let aside = rng.unit_vector() * body.radius * rng.unit();
    let on = if rng.below(3) == 0 { on } else { on + aside - face * aside.dot(face) };
    let up = if rng.below(4) == 0 { -face } else { face };
    let up = if rng.below(3) == 0 { (up + 0.3 * rng.unit_vector()).normalize() } else { up };
    // An axis of the body along the normal, nearly, or any.
    let axis = [DVec3::X, DVec3::Y, DVec3::Z, rng.unit_vector()][rng.below(4)];
    let spin = DQuat::from_axis_angle(up, rng.between(0.0, 6.0)) * DQuat::from_rotation_arc(axis, up);
    let lean = [0.0, 1e-9, 1e-3, 0.02][rng.below(4)];
    let turn = DQuat::from_axis_angle(up.any_orthonormal_vector(), lean) * spin;
    let lowest = body.models.iter().map(|model| lowest(model, turn.inverse() * up)).fold(f64::INFINITY, f64::min);
    let sunk = [0.0, 0.005, 0.02, 0.1, -0.005, 0.3][rng.below(6)] * body.radius;
    let height = match rng.below(8) {
        // The middle in the plane, or nearly.
        0 => [0.0, 1e-9, -1e-9, 1e-4][rng.below(4)] * body.radius,
        _ => -lowest - sunk,
    };
    Pose::new(on + up * height, turn.normalize()).expect("finite")
}

/// Height of the lowest point along `up`.
fn lowest(model: &Model, up: DVec3) -> f64 {
    use hullmap_testkit::reach::Reach;
    -model.reach(-up)
}

impl Tally {
    /// Judges the manifolds of the sheet with this index.
    pub fn judge_manifolds(&mut self, seed: u64, index: u64) {
        let mut rng = stream(seed, index);
        let ground = GROUNDS[(index % GROUNDS.len() as u64) as usize];
        let sheet = sheet(&mut rng, ground);
        for number in 0..BODIES {
            let size = if ground == Ground::Huge { 0.01 } else { 10_f64.powf(rng.between(-2.0, 1.0)) };
            let is_box = ground == Ground::Level && rng.below(2) == 0;
            let body = body(&mut rng, size, is_box);
            let mut pose = place(&mut rng, &sheet, &body);
            let way = [Way::First, Way::First, Way::Second, Way::Joined][rng.below(4)];
            let prediction = [0.0, 0.02, 0.02, 0.3][rng.below(4)] * body.radius;
            let query = Query { way, is_one_sided: rng.below(4) == 0, prediction };
            let step = rng.unit_vector() * body.radius * [1e-6, 1e-3, 0.05][rng.below(3)];
            let mut found = [(); 2].map(|()| (CompoundManifolds::new(256), BodyManifold::new(256)));
            found[0].0.set_welding(false);
            for frame in 0..FRAMES {
                for (welds, (found, chosen)) in found.iter_mut().enumerate() {
                    sheet.parts.update(found, &body, pose, query);
                    let name = format!("{ground:?}, --seed {seed} --first {index}, body {number}, frame {frame}");
                    let judge = Judge { sheet: &sheet, body: &body, pose, query, welds: welds == 1, name };
                    found.iter().for_each(|(pair, manifold)| judge.manifold(self, pair, manifold));
                    judge.missing(self, found);
                    let before = chosen.points().to_vec();
                    chosen.update(found);
                    judge.chosen(self, found, &before, chosen.points());
                }
                self.compare(found.each_ref().map(|(found, _)| found));
                pose = Pose::new(pose.translation() + step, pose.rotation()).expect("finite");
            }
        }
    }

    /// Counts the manifolds that welding changes.
    fn compare(&mut self, [alone, welded]: [&CompoundManifolds; 2]) {
        for (pair, manifold) in alone.iter() {
            let normal = welded.get(pair).map(Manifold::normal);
            match normal {
                Some(normal) if normal == manifold.normal() => {}
                Some(_) => self.note("welding", "corrected"),
                None => self.note("welding", "removed"),
            }
        }
    }
}

pub(super) struct Judge<'s> {
    pub(super) sheet: &'s Sheet,
    pub(super) body: &'s Body,
    pub(super) pose: Pose,
    pub(super) query: Query,
    pub(super) welds: bool,
    name: String,
}

impl Judge<'_> {
    /// The triangle and the body's part of a pair.
    pub(super) fn indices(&self, [a, b]: [usize; 2]) -> [usize; 2] {
        if self.query.way == Way::Second { [b, a] } else { [a, b] }
    }

    /// A point on the sheet, in its frame, and the one on the body, in its own.
    pub(super) fn local(&self, point: &ManifoldPoint) -> [DVec3; 2] {
        if self.query.way == Way::Second { [point.local_b, point.point_a] } else { [point.point_a, point.local_b] }
    }

    /// Rounding error of a coordinate.
    pub(super) fn rounding(&self) -> f64 {
        F64 * (self.sheet.greatest + self.pose.translation().length() + self.body.radius)
    }

    /// The smaller and the larger outer radius of a triangle and a part.
    pub(super) fn radii(&self, corners: [DVec3; 3], part: usize) -> [f64; 2] {
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let triangle = corners.map(|corner| corner.distance(middle)).into_iter().fold(0.0, f64::max);
        let part = self.body.models[part].greatest;
        [triangle.min(part), triangle.max(part)]
    }

    /// Maximum distance of a point from a triangle and from a part.
    pub(super) fn bound(&self, corners: [DVec3; 3], part: usize) -> f64 {
        OFF_SURFACE * self.radii(corners, part)[0] + self.rounding() + self.body.rough
    }

    /// The body, its pose and the query.
    pub(super) fn place(&self) -> String {
        let Body { name, radius, .. } = self.body;
        let welds = self.welds;
        format!("{}; {name} of radius {radius:e} at {:?}, {:?}, welds {welds}", self.name, self.pose, self.query)
    }

    fn manifold(&self, tally: &mut Tally, pair: [usize; 2], manifold: &Manifold) {
        let [triangle, part] = self.indices(pair);
        let Some(corners) = self.sheet.triangles[triangle] else {
            return tally.wrong.push(format!("{}: a manifold of a hole", self.name));
        };
        let normal = manifold.normal();
        let (rounding, bound) = (self.rounding(), self.bound(corners, part));
        tally.note("status", manifold.status().as_str());
        tally.note("welded", if self.welds { "yes" } else { "no" });
        let mut wrong = |what: &str, by: f64, point: &ManifoldPoint| {
            // NaN takes the failing branch.
            if !(by <= 1.0) {
                let status = manifold.status();
                tally.wrong.push(format!(
                    "{what}, {by:e} times the bound {bound:e}: {}\n  triangle {triangle} {corners:?}\n  normal {normal:?} {status:?} {point:?}",
                    self.place(),
                ));
            }
        };
        for point in manifold.points() {
            let is_second = self.query.way == Way::Second;
            let [on_sheet, on_body] = self.local(point);
            wrong("the sheet's point is off its triangle", distance_from_triangle(corners, on_sheet) / bound, point);
            wrong("the body's point is off its surface", self.body.off(part, on_body) / bound, point);
            let aside = (point.point_a - point.point_b - normal * point.depth).length();
            wrong("the depth differs from the points", aside / rounding, point);
            wrong("beyond the prediction", (-point.depth - self.query.prediction) / rounding, point);
            let frame = if is_second { self.pose.inverse() } else { self.pose };
            wrong("B's points differ", frame.transform_point(point.local_b).distance(point.point_b) / rounding, point);
            wrong("the normal is not of unit length", (normal.length() - 1.0).abs() / 1e-14, point);
            wrong("separated", f64::from(u8::from(manifold.status() == Status::Separated)) * 2.0, point);
        }
        for point in manifold.points() {
            let is_clipped = [point.id.on_a(), point.id.on_b()].iter().all(|id| matches!(id, FeatureId::Edge(..)));
            tally.note("point", self.body.name);
            if is_clipped {
                tally.note("clipped", self.body.name);
            }
        }
    }
}
