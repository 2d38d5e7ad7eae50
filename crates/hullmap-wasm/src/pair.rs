//! Queries on two bodies, with the memory that makes the next query cheaper.

use hullmap::glam::{DQuat, DVec3};
use hullmap::{
    Cache, CompoundManifolds, Contact, Distance, Fields, Intersection, ManifoldSettings, Pose, Settings, SharedGeometry,
};
use js_sys::Array;
use wasm_bindgen::prelude::*;

use crate::input::error;
use crate::object::{Columns, Plain, parts_of, vector_of, word_of};
use crate::shape::{Body, geometry_of};

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
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
    /** Unit vector from A to B; for packs, the normal of the first point. NaN if there are no points. */
    normal: Float64Array;
    /** Up to four points for each pair of hulls. */
    points: ManifoldPoint[];
    /** Number of pairs of hulls that touch but were left out, because more than 64 pairs touch. */
    dropped: number;
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
///
/// A pair with parts takes about 300 KB of the module's memory, others far less: keep it, and free
/// it by `free()` when it is done.
#[wasm_bindgen(js_name = Pair)]
pub struct QueryPair {
    pub(crate) a: SharedGeometry,
    pub(crate) b: SharedGeometry,
    pub(crate) cache: Cache,
    manifolds: CompoundManifolds,
}

/// A query of two geometries. All kinds of them share its code, which keeps the module small.
macro_rules! query {
    ($a:expr, $b:expr, |$one:ident, $other:ident| $query:expr) => {
        match hullmap::geometry::AnyPair::new($a, $b) {
            hullmap::geometry::AnyPair::Shapes($one, $other) => $query,
            hullmap::geometry::AnyPair::Parts($one, $other) => $query,
        }
    };
}
pub(crate) use query;

impl QueryPair {
    fn find_intersection(&mut self, pose: Pose) -> Intersection {
        query!(&self.a, &self.b, |a, b| hullmap::intersects(&a, &b, pose, &mut self.cache))
    }

    fn find_contact(&mut self, pose: Pose) -> Contact {
        query!(&self.a, &self.b, |a, b| hullmap::contact(&a, &b, pose, &Settings::default(), &mut self.cache))
    }

    fn find_distance(&mut self, pose: Pose) -> Distance {
        query!(&self.a, &self.b, |a, b| hullmap::distance(&a, &b, pose, &Settings::default(), &mut self.cache))
    }

    /// The answers of `query` for many poses, each as if it were the first.
    fn batch<A: Fields, T: JsCast>(
        &mut self,
        poses: &[f64],
        query: impl Fn(&mut Self, Pose) -> A,
    ) -> Result<T, JsError> {
        let (rows, rest) = poses.as_chunks::<7>();
        if !rest.is_empty() {
            let found = poses.len();
            return Err(error(format!(
                "poses must have seven numbers each, tx ty tz qx qy qz qw, found {found} in all"
            )));
        }
        let mut columns = Columns::of::<A>();
        for (index, row) in rows.iter().enumerate() {
            self.forget();
            let pose = read_pose(row).map_err(|fault| error(format!("pose {index}: {fault}")))?;
            columns.push(&query(self, pose));
        }
        self.forget();
        Ok(columns.done())
    }
}

#[wasm_bindgen(js_class = Pair)]
impl QueryPair {
    /// A pair of bodies: hulls, packs as the union of their hulls, shapes, or levels. Both remain
    /// usable.
    ///
    /// # Errors
    /// A body is not a hull, pack, shape or level, or both are half-spaces.
    #[wasm_bindgen(constructor)]
    pub fn new(a: &Body, b: &Body) -> Result<QueryPair, JsError> {
        let (a, b) = (geometry_of("A", a)?, geometry_of("B", b)?);
        a.check_pair(&b).map_err(error)?;
        let has_parts = a.has_parts() || b.has_parts();
        let cache = if has_parts { Cache::with_pairs(CACHES) } else { Cache::new() };
        Ok(Self { a, b, cache, manifolds: CompoundManifolds::new(if has_parts { MANIFOLDS } else { 1 }) })
    }

    /// Forgets earlier queries. Answers then depend on the pose alone, to the last bit.
    pub fn forget(&mut self) {
        self.cache.clear();
        self.manifolds.clear();
    }

    /// Whether the bodies share a point: `separated`, `overlapping`, `touching` or `undecided`.
    ///
    /// # Errors
    /// The pose is not seven finite numbers.
    pub fn intersects(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] pose: &[f64],
    ) -> Result<Overlap, JsError> {
        let found = self.find_intersection(pose_of(pose)?);
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
        Ok(Plain::from_answer(&self.find_contact(pose_of(pose)?)).done())
    }

    /// Distance, with its interval, normal and witness points.
    ///
    /// # Errors
    /// The pose is not seven finite numbers.
    pub fn distance(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] pose: &[f64],
    ) -> Result<DistanceAnswer, JsError> {
        Ok(Plain::from_answer(&self.find_distance(pose_of(pose)?)).done())
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
        self.batch(poses, Self::find_intersection)
    }

    /// Contacts for many poses, as `intersections`.
    ///
    /// # Errors
    /// A pose is not seven finite numbers; the message has its index.
    pub fn contacts(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] poses: &[f64],
    ) -> Result<Contacts, JsError> {
        self.batch(poses, Self::find_contact)
    }

    /// Distances for many poses, as `intersections`.
    ///
    /// # Errors
    /// A pose is not seven finite numbers; the message has its index.
    pub fn distances(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] poses: &[f64],
    ) -> Result<Distances, JsError> {
        self.batch(poses, Self::find_distance)
    }

    /// Contact manifold: up to four points for each pair of hulls that overlap or are close, within
    /// 2 % of the smaller radius. They are kept from query to query.
    ///
    /// # Errors
    /// The pose is not seven finite numbers.
    pub fn manifold(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] pose: &[f64],
    ) -> Result<ContactManifold, JsError> {
        let (pose, settings) = (pose_of(pose)?, ManifoldSettings::default());
        let counts = query!(&self.a, &self.b, |a, b| self.manifolds.update(&a, &b, pose, &settings));
        let (mut normal, points) = (DVec3::NAN, Array::new());
        for (parts, manifold) in self.manifolds.iter() {
            if normal.is_nan() {
                normal = manifold.normal();
            }
            // One object each for all points of a pair.
            let (own, parts) = (vector_of(manifold.normal()), parts_of(parts.map(|part| part as u32)));
            for point in manifold.points() {
                let plain = Plain::new()
                    .with("pointA", vector_of(point.point_a))
                    .with("pointB", vector_of(point.point_b))
                    .with("depth", point.depth)
                    .with("status", word_of(manifold.status().as_str()))
                    .with("normal", &own)
                    .with("parts", &parts);
                points.push(&plain.done::<JsValue>());
            }
        }
        let plain = Plain::new().with("normal", vector_of(normal)).with("dropped", counts.dropped);
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
