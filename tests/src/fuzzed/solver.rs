//! Reads bytes as two shapes and their poses, and judges the solver's answers by brute force over
//! the shapes' points.
//!
//! The answers contain their own certificates. The way out along any direction is an upper bound of
//! the depth, and its negative is a lower bound of the distance.

use glam::{DMat3, DVec3};
use hullmap::shapes::{Rounded, Scaled};
use hullmap::{
    Cache, Contact, Distance, Hull, Manifold, ManifoldSettings, Overlap, Pack, Pose, Settings, Status, contact,
    distance, intersects,
};
use hullmap_bake::IndexKind;
use hullmap_testkit::{
    packs::{self, point_set},
    reach::{Placed, Reach, way_out},
};

use super::bytes::Bytes;
use crate::soak::body::Any;

const MAX_POINTS: usize = 32;

/// Maximum iterations and support calls of a query: the limits of all phases together, twice,
/// because rounded shapes are solved twice.
const MAX_STEPS: u32 = 2 * 1600;

/// Rounding error of brute force, in units of the greatest length times the f64 epsilon. A rotated
/// point has an error of about 40 units.
const ROUNDING_UNITS: f64 = 64.0;

/// Maximum number of face normals tested for each shape.
const MAX_NORMALS: usize = 64;

/// Tolerance of a unit vector's length.
const UNIT: f64 = 1e-14;

/// Poses that share a cache.
const POSES: usize = 3;

/// A hull, its scale, and its convex radius.
struct Body {
    pack: Pack,
    scale: DVec3,
    radius: f64,
    points: Vec<DVec3>,
}

/// Builds two shapes, runs all queries in a few poses, and judges the answers. Panics if an answer
/// is NaN, exceeds a limit, or contradicts brute force.
pub fn solver(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let (Some(a), Some(b)) = (Body::read(&mut bytes), Body::read(&mut bytes)) else { return };
    let hulls = [&a, &b].map(|body| body.pack.hull(0).expect("a pack has a hull"));
    let (shape_a, shape_b) = (a.shape(hulls[0]), b.shape(hulls[1]));
    let mut caches = Caches::default();
    for _ in 0..POSES {
        let Some(b_in_a) = pose(&mut bytes, &a, &b) else { return };
        let scene = Scene::new(&a, &b, b_in_a, &hulls);
        ask(&*shape_a, &*shape_b, &scene, &mut caches);
        if bytes.is_empty() {
            return;
        }
    }
}

/// Caches of the pair, one for each query.
#[derive(Default)]
struct Caches {
    yes: Cache,
    deep: Cache,
    near: Cache,
    manifold: Manifold,
    manifold_cache: Cache,
}

/// Runs all queries and judges the answers.
fn ask(a: &Any<'_>, b: &Any<'_>, scene: &Scene<'_>, caches: &mut Caches) {
    let (settings, b_in_a) = (Settings::default(), scene.b_in_a);
    let yes = intersects(a, b, b_in_a, &mut caches.yes);
    let deep = contact(a, b, b_in_a, &settings, &mut caches.deep);
    let near = distance(a, b, b_in_a, &settings, &mut caches.near);
    let steps =
        [yes.iterations, yes.support_calls, deep.iterations, deep.support_calls, near.iterations, near.support_calls];
    assert!(steps.iter().all(|count| *count <= MAX_STEPS), "a limit is exceeded: {steps:?}");
    // The nearest points up to rounding error: no lower bound may exceed their distance.
    let nearest = Settings { tolerance: 0.0, ..settings };
    let nearest = distance(a, b, b_in_a, &nearest, &mut Cache::default());
    for near in [&near, &nearest] {
        scene.judge(yes.status, &deep, near, nearest.point_a.distance(nearest.point_b));
    }
    let Caches { manifold, manifold_cache, .. } = caches;
    manifold.update(a, b, b_in_a, &ManifoldSettings::default(), manifold_cache);
    let points = manifold.points();
    assert!(points.len() <= 4 && points.iter().all(|p| p.point_a.is_finite() && p.point_b.is_finite()));
}

impl Body {
    fn read(bytes: &mut Bytes) -> Option<Self> {
        let shape = bytes.byte();
        let size = 10_f64.powi(i32::from(shape / 8 % 13) - 6);
        let positions: Vec<[f32; 3]> =
            bytes.points(MAX_POINTS, false).iter().map(|p| p.map(|c| (f64::from(c) * size) as f32)).collect();
        let index = [IndexKind::Tree, IndexKind::None][usize::from(shape >> 7)];
        let file = packs::bytes(&[point_set("body", &positions)], index, &Default::default());
        let file = file.unwrap_or_else(|error| panic!("{error}: {positions:?}"));
        let pack = Pack::from_bytes(&file).expect("a baked pack opens");
        let scale = match shape % 4 {
            2 => DVec3::new(bytes.share(), bytes.share(), bytes.share()) * 4.0,
            _ => DVec3::ONE,
        };
        let radius = if shape % 4 == 3 { bytes.share().abs() * size } else { 0.0 };
        if scale.abs().min_element() <= 0.0 {
            return None;
        }
        let points = pack.hull(0).ok()?.vertices().map(|v| v.as_dvec3() * scale).collect();
        Some(Self { pack, scale, radius, points })
    }

    fn shape<'h>(&self, hull: Hull<'h>) -> Box<Any<'h>> {
        if self.radius > 0.0 {
            Box::new(Rounded::new(hull, self.radius).expect("the radius is positive"))
        } else if self.scale == DVec3::ONE {
            Box::new(hull)
        } else {
            Box::new(Scaled::new(hull, self.scale).expect("all factors are nonzero"))
        }
    }

    /// Maximum distance of a point from the frame's origin.
    fn greatest(&self) -> f64 {
        self.points.iter().map(|p| p.length()).fold(0.0, f64::max) + self.radius
    }

    /// Unit normals of the faces, in the shape's own frame.
    fn normals(&self, hull: &Hull) -> Vec<DVec3> {
        (0..hull.face_count().min(MAX_NORMALS) as u32)
            .filter_map(|face| (hull.face_normal(face)? / self.scale).try_normalize())
            .collect()
    }
}

/// Only for unit vectors.
impl Reach for Body {
    fn reach(&self, dir: DVec3) -> f64 {
        self.points.reach(dir) + self.radius
    }
}

/// A pose anywhere near, or one that touches along some axis up to an offset of any size.
fn pose(bytes: &mut Bytes, a: &Body, b: &Body) -> Option<Pose> {
    let (kind, rotation) = (bytes.below(3), bytes.rotation());
    let size = a.greatest() + b.greatest();
    let translation = match kind {
        0 => DVec3::new(bytes.share(), bytes.share(), bytes.share()) * size,
        1 => DVec3::new(bytes.float().into(), bytes.float().into(), bytes.float().into()),
        _ => {
            let axis = bytes.axis();
            let hair = bytes.signed() * 10_f64.powi(-(bytes.below(17) as i32)) * size / 128.0;
            axis * (a.reach(axis) + b.reach(rotation.inverse() * -axis) + hair)
        }
    };
    Pose::new(translation, rotation).ok()
}

struct Scene<'s> {
    a: &'s Body,
    b: &'s Body,
    b_in_a: Pose,
    turn: DMat3,
    /// Directions in A's frame that may be a shorter way out.
    normals: Vec<DVec3>,
    slack: f64,
}

impl<'s> Scene<'s> {
    fn new(a: &'s Body, b: &'s Body, b_in_a: Pose, hulls: &[Hull; 2]) -> Self {
        let turn = b_in_a.rotation_matrix();
        let mut normals = a.normals(&hulls[0]);
        normals.extend(b.normals(&hulls[1]).into_iter().map(|n| -(turn * n)));
        let slack = ROUNDING_UNITS * f64::EPSILON * (a.greatest() + b.greatest() + b_in_a.translation().length());
        Self { a, b, b_in_a, turn, normals, slack }
    }

    fn way_out(&self, n: DVec3) -> f64 {
        way_out(self.a, &Placed::new(self.b, self.b_in_a), n)
    }

    /// Judges the answers. `nearest` is the distance between two points, one of each shape.
    fn judge(&self, yes: Overlap, deep: &Contact, near: &Distance, nearest: f64) {
        let slack = self.slack;
        let context = || format!("{yes:?}\n{deep:?}\n{near:?}\nslack {slack:e} at {:?}", self.b_in_a);
        // NaN takes the failing branch.
        let at_most = |what: &str, found: f64, limit: f64| {
            assert!(found <= limit, "{what}: {found:e} exceeds {limit:e}\n{}", context());
        };
        for normal in [deep.normal, near.normal] {
            at_most("a normal is not of unit length", (normal.length() - 1.0).abs(), UNIT);
        }
        let (way_deep, way_near) = (self.way_out(deep.normal), self.way_out(near.normal));
        at_most("the depth's lower bound is negative", -deep.depth_lower, 0.0);
        at_most("the depth is below its interval", deep.depth_lower, deep.depth);
        at_most("the depth is above its interval", deep.depth, deep.depth_upper);
        at_most("the distance's lower bound is negative", -near.lower, 0.0);
        at_most("the distance is below its interval", near.lower, near.distance);
        at_most("the distance is above its interval", near.distance, near.upper);
        if deep.hit {
            at_most("the contact's normal is not the way out", way_deep, deep.depth_upper + slack);
        } else {
            at_most("the contact's axis does not separate", way_deep, slack);
        }
        if deep.depth_lower > 0.0 {
            for way in self.normals.iter().map(|n| self.way_out(*n)).chain([way_deep, way_near]) {
                at_most("the depth's lower bound exceeds a way out", deep.depth_lower, way + slack);
            }
            at_most("contact reports a depth, distance reports separated", near.lower, slack);
            assert!(yes != Overlap::Separated, "contact reports a depth, intersects reports separated\n{}", context());
        }
        let apart = near.point_a.distance(near.point_b);
        if near.status == Status::Overlapping {
            at_most("distance reports overlapping, an axis separates", -way_near.min(way_deep), slack);
        } else {
            at_most("the distance's points are farther apart than its upper bound", apart, near.upper + slack);
        }
        if near.lower > 0.0 {
            at_most("the distance's lower bound exceeds a distance of points", near.lower, apart.min(nearest) + slack);
        }
        if yes == Overlap::Overlapping {
            at_most("intersects reports overlapping, an axis separates", -way_near.min(way_deep), slack);
        }
        // A point of a shape is behind the planes of all its faces.
        for (point_a, point_b) in [(deep.point_a, deep.point_b), (near.point_a, near.point_b)] {
            let in_b = self.turn.transpose() * (point_b - self.b_in_a.translation());
            for &n in &self.normals {
                at_most("a point is not in A", point_a.dot(n), self.a.reach(n) + slack);
                let n = self.turn.transpose() * n;
                at_most("a point is not in B", in_b.dot(n), self.b.reach(n) + slack);
            }
        }
    }
}
