//! Queries on two bodies, with the memory that makes the next query cheaper.

use hullmap::compound::{self, CompoundAnswer, CompoundManifolds, half_space};
use hullmap::glam::{DQuat, DVec3};
use hullmap::{
    Cache, Compound, CompoundCache, Contact, Distance, Intersection, Manifold, ManifoldSettings, Pose, Settings, Status,
};
use js_sys::Array;
use wasm_bindgen::prelude::*;

use crate::object::{Columns, Field, Fields, Plain, error, parts_of, vector_of, word_of};
use crate::shape::{Body, Side};

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** How a query ended, and thus how narrow its interval is. */
export type Status =
    "exact" | "within" | "touching" | "overlapping" | "separated" | "iteration_limit" | "stalled";

/** Whether bodies share a point. */
export type Overlap = "separated" | "overlapping" | "touching" | "undecided";

/** Penetration depth of two bodies. Points and directions are in A's frame. */
export interface Contact {
    /** False only if a separating plane proves the bodies separated. */
    hit: boolean;
    status: Status;
    /** Moving B by this length along `normal` makes the bodies touch. */
    depth: number;
    /** The depth is certainly in this interval. */
    depthLower: number;
    depthUpper: number;
    /** Unit vector from A to B. NaN, as the points, for packs and levels that are separated. */
    normal: Float64Array;
    /** The point of A that is deepest in B. */
    pointA: Float64Array;
    /** The point of B that is deepest in A. */
    pointB: Float64Array;
    iterations: number;
    supportCalls: number;
    /** Indices of the hulls or triangles that decided the answer; 0 for a convex body. */
    parts: Uint32Array;
}

/** Distance of two bodies. Points and directions are in A's frame. */
export interface Distance {
    status: Status;
    /** 0 if the bodies overlap or touch. */
    distance: number;
    /** The distance is certainly in this interval. */
    lower: number;
    upper: number;
    /** Unit vector from A to B. */
    normal: Float64Array;
    /** The point of A closest to B. */
    pointA: Float64Array;
    /** The point of B closest to A. */
    pointB: Float64Array;
    iterations: number;
    supportCalls: number;
    /** Indices of the hulls or triangles that decided the answer; 0 for a convex body. */
    parts: Uint32Array;
}

/** One point of a contact manifold, in A's frame. */
export interface ManifoldPoint {
    pointA: Float64Array;
    pointB: Float64Array;
    /** Negative if the surfaces are separated there. */
    depth: number;
    /** Unit vector from A to B. The hulls of a pack may have different ones. */
    normal: Float64Array;
    /** Indices of the hulls or triangles of A and B that touch there. */
    parts: Uint32Array;
    /** How the query of these two ended that found the normal. */
    status: Status;
}

/** Contact manifold of two bodies, in A's frame. */
export interface ContactManifold {
    /** Unit vector from A to B; for packs, the normal of the first point. */
    normal: Float64Array;
    /** Up to four points for each pair of hulls. */
    points: ManifoldPoint[];
    /** Number of pairs of hulls that touch but were left out, because more than 64 pairs touch. */
    dropped: number;
}

/** Answers for many poses: the fields of `Contact` as arrays. `hit` is 1 or 0. */
export interface Contacts {
    hit: Uint8Array;
    status: Status[];
    depth: Float64Array;
    depthLower: Float64Array;
    depthUpper: Float64Array;
    /** Three numbers for each pose, as `pointA` and `pointB`. */
    normal: Float64Array;
    pointA: Float64Array;
    pointB: Float64Array;
    iterations: Uint32Array;
    supportCalls: Uint32Array;
    /** Two indices for each pose. */
    parts: Uint32Array;
}

/** Answers for many poses: the fields of `Distance` as arrays. */
export interface Distances {
    status: Status[];
    distance: Float64Array;
    lower: Float64Array;
    upper: Float64Array;
    /** Three numbers for each pose, as `pointA` and `pointB`. */
    normal: Float64Array;
    pointA: Float64Array;
    pointB: Float64Array;
    iterations: Uint32Array;
    supportCalls: Uint32Array;
    /** Two indices for each pose. */
    parts: Uint32Array;
}

/** Answers for many poses. `hit` is 1 unless the bodies are certainly separated. */
export interface Intersections {
    hit: Uint8Array;
    status: Overlap[];
    iterations: Uint32Array;
    supportCalls: Uint32Array;
    /** Two indices for each pose. */
    parts: Uint32Array;
}
"#;

#[wasm_bindgen]
extern "C" {
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "Overlap")]
    pub type Overlap;
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "Contact")]
    pub type ContactAnswer;
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "Distance")]
    pub type DistanceAnswer;
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "ContactManifold")]
    pub type ContactManifold;
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "Contacts")]
    pub type Contacts;
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "Distances")]
    pub type Distances;
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "Intersections")]
    pub type Intersections;
}

/// Pairs of hulls of two packs that have a manifold at the same time.
const MANIFOLDS: usize = 64;

/// Pairs of hulls of two packs whose queries are remembered.
const CACHES: usize = 16;

/// Two bodies A and B, and the memory of their queries.
///
/// A pose is seven numbers, `tx ty tz qx qy qz qw`: the translation and the quaternion that map B's
/// frame into A's. The quaternion is normalised.
#[wasm_bindgen(js_name = Pair)]
pub struct QueryPair {
    pub(crate) a: Side,
    pub(crate) b: Side,
    pub(crate) memory: Memory,
}

/// Memory of the queries of a pair.
pub(crate) struct Memory {
    pub(crate) convex: Cache,
    pub(crate) compound: CompoundCache,
    manifold_cache: Cache,
    manifold: Manifold,
    manifolds: Option<Box<CompoundManifolds>>,
}

impl Memory {
    fn new(is_compound: bool) -> Self {
        Self {
            convex: Cache::new(),
            compound: CompoundCache::new(if is_compound { CACHES } else { 0 }),
            manifold_cache: Cache::new(),
            manifold: Manifold::new(),
            manifolds: is_compound.then(|| Box::new(CompoundManifolds::new(MANIFOLDS))),
        }
    }
}

/// Evaluates `$call` with the two bodies by their kinds; one of them is a pack, or A is a level.
macro_rules! of_parts {
    ($a:expr, $b:expr, |$x:ident, $y:ident| $call:expr) => {
        match ($a, $b) {
            (Side::Compound(a), Side::Compound(b)) => {
                let ($x, $y) = (&Compound::new(a), &Compound::new(b));
                Some($call)
            }
            (Side::Sheet($x), Side::Compound(b)) => {
                let $y = &Compound::new(b);
                Some($call)
            }
            (Side::Sheet($x), b) => b.convex().map(|$y| $call),
            (Side::Compound(a), b) => b.convex().map(|$y| {
                let $x = &Compound::new(a);
                $call
            }),
            (a, Side::Compound(b)) => a.convex().map(|$x| {
                let $y = &Compound::new(b);
                $call
            }),
            _ => None,
        }
    };
}
pub(crate) use of_parts;

/// An answer, and the hulls of A and B that decided it.
pub(crate) type Found<T> = (T, [usize; 2]);

// Each query has a case for two hulls, for a half-space and a pack or a convex body, for two convex
// bodies, and for packs and levels. `None`: the constructor rejects such pairs.
impl QueryPair {
    fn find_intersection(&mut self, pose: Pose) -> Option<Found<Intersection>> {
        let (cache, compound) = (&mut self.memory.convex, &mut self.memory.compound);
        Some(match (&self.a, &self.b) {
            (Side::Hull(a), Side::Hull(b)) => (hullmap::intersects(a.hull(), b.hull(), pose, cache), [0, 0]),
            (Side::HalfSpace(a), Side::Compound(b)) => of_compound(half_space::intersects(a, &Compound::new(b), pose)),
            (Side::HalfSpace(a), b) => (a.intersects(b.convex()?, pose), [0, 0]),
            (a, b) => match (a.convex(), b.convex()) {
                (Some(a), Some(b)) => (hullmap::intersects(a, b, pose, cache), [0, 0]),
                _ => of_compound(of_parts!(a, b, |a, b| compound::intersects(a, b, pose, compound))?),
            },
        })
    }

    fn find_contact(&mut self, pose: Pose) -> Option<Found<Contact>> {
        let (cache, compound) = (&mut self.memory.convex, &mut self.memory.compound);
        let settings = &Settings::default();
        Some(match (&self.a, &self.b) {
            (Side::Hull(a), Side::Hull(b)) => (hullmap::contact(a.hull(), b.hull(), pose, settings, cache), [0, 0]),
            (Side::HalfSpace(a), Side::Compound(b)) => of_compound(half_space::contact(a, &Compound::new(b), pose)),
            (Side::HalfSpace(a), b) => (a.contact(b.convex()?, pose), [0, 0]),
            (a, b) => match (a.convex(), b.convex()) {
                (Some(a), Some(b)) => (hullmap::contact(a, b, pose, settings, cache), [0, 0]),
                _ => of_parts!(a, b, |a, b| compound::contact(a, b, pose, settings, compound))?
                    .map_or_else(separated, of_compound),
            },
        })
    }

    fn find_distance(&mut self, pose: Pose) -> Option<Found<Distance>> {
        let (cache, compound) = (&mut self.memory.convex, &mut self.memory.compound);
        let settings = &Settings::default();
        Some(match (&self.a, &self.b) {
            (Side::Hull(a), Side::Hull(b)) => (hullmap::distance(a.hull(), b.hull(), pose, settings, cache), [0, 0]),
            (Side::HalfSpace(a), Side::Compound(b)) => of_compound(half_space::distance(a, &Compound::new(b), pose)),
            (Side::HalfSpace(a), b) => (a.distance(b.convex()?, pose), [0, 0]),
            (a, b) => match (a.convex(), b.convex()) {
                (Some(a), Some(b)) => (hullmap::distance(a, b, pose, settings, cache), [0, 0]),
                _ => of_compound(of_parts!(a, b, |a, b| compound::distance(a, b, pose, settings, compound))?),
            },
        })
    }

    /// The answers of `query` for many poses, each as if it were the first.
    fn batch<A: Default, T: JsCast>(
        &mut self,
        poses: &[f64],
        query: impl Fn(&mut Self, Pose) -> Option<A>,
        fields: impl Fn(&A) -> Fields,
    ) -> Result<T, JsError> {
        let (rows, rest) = poses.as_chunks::<7>();
        if !rest.is_empty() {
            let found = poses.len();
            return Err(error(format!(
                "poses must have seven numbers each, tx ty tz qx qy qz qw, found {found} in all"
            )));
        }
        let mut columns = Columns::like(&fields(&A::default()));
        for (index, row) in rows.iter().enumerate() {
            self.forget();
            let pose = read_pose(row).map_err(|fault| error(format!("pose {index}: {fault}")))?;
            columns.push(&fields(&query(self, pose).ok_or_else(no_query)?));
        }
        self.forget();
        Ok(columns.done())
    }
}

fn intersection_fields((found, parts): &Found<Intersection>) -> Fields {
    vec![
        ("hit", Field::Flag(found.is_hit())),
        ("status", Field::Word(found.status.as_str())),
        ("iterations", Field::Count(found.iterations)),
        ("supportCalls", Field::Count(found.support_calls)),
        ("parts", Field::Parts(*parts)),
    ]
}

fn contact_fields((found, parts): &Found<Contact>) -> Fields {
    vec![
        ("hit", Field::Flag(found.hit)),
        ("status", Field::Word(found.status.as_str())),
        ("depth", Field::Number(found.depth)),
        ("depthLower", Field::Number(found.depth_lower)),
        ("depthUpper", Field::Number(found.depth_upper)),
        ("normal", Field::Vector(found.normal)),
        ("pointA", Field::Vector(found.point_a)),
        ("pointB", Field::Vector(found.point_b)),
        ("iterations", Field::Count(found.iterations)),
        ("supportCalls", Field::Count(found.support_calls)),
        ("parts", Field::Parts(*parts)),
    ]
}

fn distance_fields((found, parts): &Found<Distance>) -> Fields {
    vec![
        ("status", Field::Word(found.status.as_str())),
        ("distance", Field::Number(found.distance)),
        ("lower", Field::Number(found.lower)),
        ("upper", Field::Number(found.upper)),
        ("normal", Field::Vector(found.normal)),
        ("pointA", Field::Vector(found.point_a)),
        ("pointB", Field::Vector(found.point_b)),
        ("iterations", Field::Count(found.iterations)),
        ("supportCalls", Field::Count(found.support_calls)),
        ("parts", Field::Parts(*parts)),
    ]
}

pub(crate) fn of_compound<T>(found: CompoundAnswer<T>) -> Found<T> {
    (found.answer, found.hulls)
}

/// Packs that are separated have no single separating plane, and no points.
fn separated() -> Found<Contact> {
    let nothing = DVec3::NAN;
    let contact = Contact { hit: false, status: Status::Separated, depth_upper: 0.0, ..Contact::default() };
    (Contact { normal: nothing, point_a: nothing, point_b: nothing, ..contact }, [0, 0])
}

/// The constructor rejects such pairs.
pub(crate) fn no_query() -> JsError {
    error("these bodies have no query")
}

#[wasm_bindgen(js_class = Pair)]
impl QueryPair {
    /// A pair of bodies: hulls, packs as the union of their hulls, shapes, or levels. Both remain
    /// usable.
    ///
    /// # Errors
    /// A body is not a hull, pack, shape or level, or B is a half-space or a level.
    #[wasm_bindgen(constructor)]
    pub fn new(a: &Body, b: &Body) -> Result<QueryPair, JsError> {
        let (a, b) = (Side::of_body("A", a)?, Side::of_body("B", b)?);
        let kind = match b {
            Side::HalfSpace(_) => Some(("a half-space", "Two half-spaces have")),
            Side::Sheet(_) => Some(("a level", "A level and a half-space, and two levels, have")),
            _ => None,
        };
        if let Some((kind, others)) = kind {
            let remedy = "make it A, and pass the pose of the other body in its frame";
            return Err(error(format!("B is {kind}: {remedy}. {others} no query")));
        }
        let is_compound = [&a, &b].into_iter().any(|side| matches!(side, Side::Compound(_) | Side::Sheet(_)));
        Ok(Self { a, b, memory: Memory::new(is_compound) })
    }

    /// Forgets earlier queries. Answers then depend on the pose alone, to the last bit.
    pub fn forget(&mut self) {
        let Memory { convex, compound, manifold_cache, manifold, manifolds } = &mut self.memory;
        convex.clear();
        compound.clear();
        manifold_cache.clear();
        manifold.clear();
        if let Some(manifolds) = manifolds {
            manifolds.clear();
        }
    }

    /// Whether the bodies share a point: `separated`, `overlapping`, `touching` or `undecided`.
    ///
    /// # Errors
    /// The pose is not seven finite numbers.
    pub fn intersects(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] pose: &[f64],
    ) -> Result<Overlap, JsError> {
        let (found, _) = self.find_intersection(pose_of(pose)?).ok_or_else(no_query)?;
        Ok(word_of(found.status.as_str()).unchecked_into())
    }

    /// Penetration depth, with its interval, normal and witness points.
    ///
    /// # Errors
    /// The pose is not seven finite numbers.
    pub fn contact(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] pose: &[f64],
    ) -> Result<ContactAnswer, JsError> {
        Ok(Plain::from_fields(&contact_fields(&self.find_contact(pose_of(pose)?).ok_or_else(no_query)?)).done())
    }

    /// Distance, with its interval, normal and witness points.
    ///
    /// # Errors
    /// The pose is not seven finite numbers.
    pub fn distance(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] pose: &[f64],
    ) -> Result<DistanceAnswer, JsError> {
        Ok(Plain::from_fields(&distance_fields(&self.find_distance(pose_of(pose)?).ok_or_else(no_query)?)).done())
    }

    /// Whether the bodies share a point, for many poses of seven numbers each. Each is answered as
    /// if it were the first, and the pair then forgets them.
    ///
    /// # Errors
    /// A pose is not seven finite numbers; the message has its index.
    pub fn intersections(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] poses: &[f64],
    ) -> Result<Intersections, JsError> {
        self.batch(poses, Self::find_intersection, intersection_fields)
    }

    /// Contacts for many poses, as `intersections`.
    ///
    /// # Errors
    /// A pose is not seven finite numbers; the message has its index.
    pub fn contacts(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] poses: &[f64],
    ) -> Result<Contacts, JsError> {
        self.batch(poses, Self::find_contact, contact_fields)
    }

    /// Distances for many poses, as `intersections`.
    ///
    /// # Errors
    /// A pose is not seven finite numbers; the message has its index.
    pub fn distances(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] poses: &[f64],
    ) -> Result<Distances, JsError> {
        self.batch(poses, Self::find_distance, distance_fields)
    }

    /// Contact manifold: up to four points for each pair of hulls, kept from query to query.
    ///
    /// # Errors
    /// The pose is not seven finite numbers.
    pub fn manifold(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] pose: &[f64],
    ) -> Result<ContactManifold, JsError> {
        let (pose, settings) = (pose_of(pose)?, &ManifoldSettings::default());
        let Memory { manifold, manifold_cache, manifolds, .. } = &mut self.memory;
        let points = Array::new();
        let put = |manifold: &Manifold, parts: [usize; 2]| {
            // One object each for all points of a pair.
            let (normal, parts) = (vector_of(manifold.normal()), parts_of(parts));
            for point in manifold.points() {
                let fields = [
                    ("pointA", Field::Vector(point.point_a)),
                    ("pointB", Field::Vector(point.point_b)),
                    ("depth", Field::Number(point.depth)),
                    ("status", Field::Word(manifold.status().as_str())),
                ];
                let plain = Plain::from_fields(&fields).with("normal", &normal).with("parts", &parts);
                points.push(&plain.done::<JsValue>());
            }
        };
        let (mut normal, mut dropped) = (DVec3::NAN, 0);
        if let Some(manifolds) = manifolds {
            let counts = match (&self.a, &self.b) {
                (Side::HalfSpace(a), Side::Compound(b)) => {
                    Some(manifolds.update_half_space(a, &Compound::new(b), pose, settings))
                }
                (a, b) => of_parts!(a, b, |a, b| manifolds.update(a, b, pose, settings)),
            };
            dropped = counts.ok_or_else(no_query)?.dropped;
            for (parts, manifold) in manifolds.iter() {
                if normal.is_nan() {
                    normal = manifold.normal();
                }
                put(manifold, parts);
            }
        } else {
            match (&self.a, &self.b) {
                (Side::Hull(a), Side::Hull(b)) => manifold.update(a.hull(), b.hull(), pose, settings, manifold_cache),
                (Side::HalfSpace(a), b) => {
                    manifold.update_half_space(a, b.convex().ok_or_else(no_query)?, pose, settings)
                }
                (a, b) => match (a.convex(), b.convex()) {
                    (Some(a), Some(b)) => manifold.update(a, b, pose, settings, manifold_cache),
                    _ => return Err(no_query()),
                },
            };
            normal = manifold.normal();
            put(manifold, [0, 0]);
        }
        let plain = Plain::from_fields(&[("normal", Field::Vector(normal)), ("dropped", Field::Count(dropped))]);
        Ok(plain.with("points", points).done())
    }
}

/// A pose from seven numbers.
pub(crate) fn pose_of(numbers: &[f64]) -> Result<Pose, JsError> {
    let Ok(row) = numbers.try_into() else {
        let found = numbers.len();
        return Err(error(format!("a pose has seven numbers, tx ty tz qx qy qz qw, found {found}")));
    };
    read_pose(row).map_err(error)
}

fn read_pose(&[x, y, z, qx, qy, qz, qw]: &[f64; 7]) -> Result<Pose, hullmap::PoseError> {
    Pose::new(DVec3::new(x, y, z), DQuat::from_xyzw(qx, qy, qz, qw))
}
