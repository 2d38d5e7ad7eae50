//! Queries on two hulls, with the memory that makes the next query cheaper.

use hullmap::glam::{DQuat, DVec3};
use hullmap::{Cache, Manifold, ManifoldSettings, Pose, Settings, SharedHull};
use js_sys::Array;
use wasm_bindgen::prelude::*;

use crate::object::{Plain, error};
use crate::pack::Hull;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** How a query ended, and thus how narrow its interval is. */
export type Status =
    "exact" | "within" | "touching" | "overlapping" | "separated" | "iteration_limit" | "stalled";

/** Penetration depth of two hulls. Points and directions are in A's frame. */
export interface Contact {
    /** False only if a separating plane proves the hulls separated. */
    hit: boolean;
    status: Status;
    /** Moving B by this length along `normal` makes the hulls touch. */
    depth: number;
    /** The depth is certainly in this interval. */
    depthLower: number;
    depthUpper: number;
    /** Unit vector from A to B. */
    normal: Float64Array;
    /** The point of A that is deepest in B. */
    pointA: Float64Array;
    /** The point of B that is deepest in A. */
    pointB: Float64Array;
    iterations: number;
    supportCalls: number;
}

/** Distance of two hulls. Points and directions are in A's frame. */
export interface Distance {
    status: Status;
    /** 0 if the hulls overlap or touch. */
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
}

/** One of up to four points of a contact manifold, in A's frame. */
export interface ManifoldPoint {
    pointA: Float64Array;
    pointB: Float64Array;
    /** Negative if the surfaces are separated there. */
    depth: number;
}

/** Contact manifold of two hulls, in A's frame. */
export interface ContactManifold {
    /** Unit vector from A to B. */
    normal: Float64Array;
    points: ManifoldPoint[];
}
"#;

#[wasm_bindgen]
extern "C" {
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "Contact")]
    pub type Contact;
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "Distance")]
    pub type Distance;
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "ContactManifold")]
    pub type ContactManifold;
}

/// Two hulls A and B, and what their queries remember.
///
/// A pose is seven numbers, `tx ty tz qx qy qz qw`: the translation and the quaternion that map B's
/// frame into A's. The quaternion is normalised.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Pair {
    a: SharedHull,
    b: SharedHull,
    cache: Cache,
    manifold_cache: Cache,
    manifold: Manifold,
}

#[wasm_bindgen]
impl Pair {
    /// A pair of hulls. Both remain usable.
    #[wasm_bindgen(constructor)]
    pub fn new(a: &Hull, b: &Hull) -> Pair {
        let (a, b) = (a.0.clone(), b.0.clone());
        Self { a, b, cache: Cache::new(), manifold_cache: Cache::new(), manifold: Manifold::new() }
    }

    /// Forgets earlier queries. Answers then depend on the pose alone, to the last bit.
    pub fn forget(&mut self) {
        (self.cache, self.manifold_cache, self.manifold) = (Cache::new(), Cache::new(), Manifold::new());
    }

    /// Whether the hulls share a point: `separated`, `overlapping`, `touching` or `undecided`.
    ///
    /// # Errors
    /// The pose is not seven finite numbers.
    pub fn intersects(&mut self, pose: &[f64]) -> Result<String, JsError> {
        let found = hullmap::intersects(&self.a, &self.b, pose_of(pose)?, &mut self.cache);
        Ok(found.status.as_str().to_owned())
    }

    /// Penetration depth, with its interval, normal and witness points.
    ///
    /// # Errors
    /// The pose is not seven finite numbers.
    pub fn contact(&mut self, pose: &[f64]) -> Result<Contact, JsError> {
        let found = hullmap::contact(&self.a, &self.b, pose_of(pose)?, &Settings::default(), &mut self.cache);
        Ok(Plain::new()
            .with("hit", found.hit)
            .with("status", found.status.as_str())
            .with("depth", found.depth)
            .with("depthLower", found.depth_lower)
            .with("depthUpper", found.depth_upper)
            .with_vector("normal", found.normal)
            .with_vector("pointA", found.point_a)
            .with_vector("pointB", found.point_b)
            .with("iterations", found.iterations)
            .with("supportCalls", found.support_calls)
            .done())
    }

    /// Distance, with its interval, normal and witness points.
    ///
    /// # Errors
    /// The pose is not seven finite numbers.
    pub fn distance(&mut self, pose: &[f64]) -> Result<Distance, JsError> {
        let found = hullmap::distance(&self.a, &self.b, pose_of(pose)?, &Settings::default(), &mut self.cache);
        Ok(Plain::new()
            .with("status", found.status.as_str())
            .with("distance", found.distance)
            .with("lower", found.lower)
            .with("upper", found.upper)
            .with_vector("normal", found.normal)
            .with_vector("pointA", found.point_a)
            .with_vector("pointB", found.point_b)
            .with("iterations", found.iterations)
            .with("supportCalls", found.support_calls)
            .done())
    }

    /// Contact manifold: up to four points, kept from query to query.
    ///
    /// # Errors
    /// The pose is not seven finite numbers.
    pub fn manifold(&mut self, pose: &[f64]) -> Result<ContactManifold, JsError> {
        let settings = ManifoldSettings::default();
        self.manifold.update(&self.a, &self.b, pose_of(pose)?, &settings, &mut self.manifold_cache);
        let points = Array::new();
        for point in self.manifold.points() {
            let plain = Plain::new().with_vector("pointA", point.point_a).with_vector("pointB", point.point_b);
            points.push(&plain.with("depth", point.depth).done::<JsValue>());
        }
        Ok(Plain::new().with_vector("normal", self.manifold.normal()).with("points", points).done())
    }
}

/// A pose from seven numbers.
fn pose_of(numbers: &[f64]) -> Result<Pose, JsError> {
    let &[x, y, z, qx, qy, qz, qw] = numbers else {
        let found = numbers.len();
        return Err(error(format!("a pose has seven numbers, tx ty tz qx qy qz qw, found {found}")));
    };
    Pose::new(DVec3::new(x, y, z), DQuat::from_xyzw(qx, qy, qz, qw)).map_err(error)
}
