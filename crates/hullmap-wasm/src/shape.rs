//! Shapes that can be queried: hulls, packs as the union of their hulls, primitives, half-spaces,
//! levels; and rays against them.

use std::rc::Rc;
use std::sync::Arc;

use hullmap::compound::{self, CompoundAnswer, SharedSheet};
use hullmap::glam::DVec3;
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, HalfSpace, Segment, Sphere, Triangle};
use hullmap::{CastSettings, Compound, Ray, RayHit, ShapeError, SharedHull};
use wasm_bindgen::prelude::*;

use crate::object::{Columns, Field, Fields, Plain, error, rows_of, vector_from};

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** A body of a pair: a hull, a pack as the union of its hulls, a shape, or a level. */
export type Body = Hull | Pack | Shape | Level;

/** Where a ray enters a shape. */
export interface RayHit {
    /** False only if the ray certainly misses the shape up to `maxT`. */
    hit: boolean;
    status: Status;
    /** The ray enters the shape at `origin + t direction`; infinite without a hit. */
    t: number;
    /** t is certainly in this interval. */
    tLower: number;
    tUpper: number;
    /** The point at t. */
    point: Float64Array;
    /** Outward unit normal of the shape there. */
    normal: Float64Array;
    /** Index of the hull or the triangle that is hit; 0 for a convex shape. */
    part: number;
    iterations: number;
    supportCalls: number;
}

/** Answers of many rays: the fields of `RayHit` as arrays. `hit` is 1 or 0. */
export interface RayHits {
    hit: Uint8Array;
    status: Status[];
    t: Float64Array;
    tLower: Float64Array;
    tUpper: Float64Array;
    /** Three numbers for each ray, as `normal`. */
    point: Float64Array;
    normal: Float64Array;
    part: Uint32Array;
    iterations: Uint32Array;
    supportCalls: Uint32Array;
}
"#;

#[wasm_bindgen]
extern "C" {
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "Body")]
    pub type Body;
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "RayHit")]
    pub type Hit;
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "RayHits")]
    pub type Hits;

    /// The method `shape` of `Hull`, `Pack`, `Shape` and `Level`. It makes a new `Shape`, which is
    /// passed into WebAssembly while the body remains usable.
    #[wasm_bindgen(method, catch, js_name = shape)]
    fn shape_of(this: &Body) -> Result<Shape, JsValue>;
}

/// One side of a query.
#[derive(Clone)]
pub enum Side {
    Hull(SharedHull),
    Compound(Arc<hullmap::Pack>),
    Convex(Rc<dyn hullmap::Shape>),
    HalfSpace(HalfSpace),
    Sheet(SharedSheet),
}

impl Side {
    /// The kind of a body.
    ///
    /// # Errors
    /// It is not a body.
    pub fn of_body(name: &str, body: &Body) -> Result<Self, JsError> {
        let wrong = |_| error(format!("{name}: expected a Hull, a Pack, a Shape or a Level that was not freed"));
        body.shape_of().map(|shape| shape.0).map_err(wrong)
    }

    /// The shape as one convex body.
    pub fn convex(&self) -> Option<&dyn hullmap::Shape> {
        match self {
            Self::Hull(hull) => Some(hull),
            Self::Convex(shape) => Some(&**shape),
            Self::Compound(_) | Self::HalfSpace(_) | Self::Sheet(_) => None,
        }
    }

    /// Where a ray enters the shape.
    fn ray(&self, ray: &Ray, settings: &CastSettings) -> Fields {
        let (found, part) = match self {
            Self::Hull(hull) => (hullmap::ray(hull, ray, settings), 0),
            Self::Convex(shape) => (hullmap::ray(&**shape, ray, settings), 0),
            Self::HalfSpace(half_space) => (half_space.ray(ray, settings), 0),
            Self::Compound(pack) => of_parts(compound::ray(&Compound::new(pack), ray, settings)),
            Self::Sheet(sheet) => of_parts(compound::ray(sheet, ray, settings)),
        };
        let RayHit { hit, status, t, t_lower, t_upper, point, normal, iterations, support_calls, .. } = found;
        vec![
            ("hit", Field::Flag(hit)),
            ("status", Field::Word(status.as_str())),
            ("t", Field::Number(t)),
            ("tLower", Field::Number(t_lower)),
            ("tUpper", Field::Number(t_upper)),
            ("point", Field::Vector(point)),
            ("normal", Field::Vector(normal)),
            ("part", Field::Count(part as u32)),
            ("iterations", Field::Count(iterations)),
            ("supportCalls", Field::Count(support_calls)),
        ]
    }
}

/// The answer, and the part that is hit.
fn of_parts(CompoundAnswer { answer, hulls: [part, _], .. }: CompoundAnswer<RayHit>) -> (RayHit, usize) {
    (answer, part)
}

/// A shape: a primitive, a half-space, a hull, or the union of all hulls of a pack.
#[wasm_bindgen]
#[derive(Clone)]
pub struct Shape(pub(crate) Side);

fn convex(made: Result<impl hullmap::Shape + 'static, ShapeError>) -> Result<Shape, JsError> {
    made.map(|shape| Shape(Side::Convex(Rc::new(shape)))).map_err(error)
}

#[wasm_bindgen]
impl Shape {
    /// A sphere about the origin.
    ///
    /// # Errors
    /// `radius` is negative, NaN or too large. The same holds for the lengths of the other shapes.
    pub fn sphere(radius: f64) -> Result<Shape, JsError> {
        convex(Sphere::new(radius))
    }

    /// A box about the origin, which extends by its half edges along x, y and z, both ways.
    ///
    /// # Errors
    /// As for `sphere`.
    #[wasm_bindgen(js_name = box)]
    pub fn cuboid(
        #[wasm_bindgen(js_name = halfEdges, unchecked_param_type = "ArrayLike<number>")] half_edges: &[f64],
    ) -> Result<Shape, JsError> {
        convex(Cuboid::new(vector_from("halfEdges", half_edges)?))
    }

    /// All points within `radius` of the segment on the z axis from −`halfLength` to `halfLength`.
    ///
    /// # Errors
    /// As for `sphere`.
    pub fn capsule(#[wasm_bindgen(js_name = halfLength)] half_length: f64, radius: f64) -> Result<Shape, JsError> {
        convex(Capsule::new(half_length, radius))
    }

    /// A cylinder from −`halfHeight` to `halfHeight` on the z axis.
    ///
    /// # Errors
    /// As for `sphere`.
    pub fn cylinder(#[wasm_bindgen(js_name = halfHeight)] half_height: f64, radius: f64) -> Result<Shape, JsError> {
        convex(Cylinder::new(half_height, radius))
    }

    /// A cone with its apex at `halfHeight` on the z axis and its base at −`halfHeight`.
    ///
    /// # Errors
    /// As for `sphere`.
    pub fn cone(#[wasm_bindgen(js_name = halfHeight)] half_height: f64, radius: f64) -> Result<Shape, JsError> {
        convex(Cone::new(half_height, radius))
    }

    /// A segment between two points.
    ///
    /// # Errors
    /// A coordinate is NaN or too large.
    pub fn segment(
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] start: &[f64],
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] end: &[f64],
    ) -> Result<Shape, JsError> {
        convex(Segment::new(vector_from("start", start)?, vector_from("end", end)?))
    }

    /// A triangle with these corners.
    ///
    /// # Errors
    /// A coordinate is NaN or too large.
    pub fn triangle(
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] a: &[f64],
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] b: &[f64],
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] c: &[f64],
    ) -> Result<Shape, JsError> {
        convex(Triangle::new([vector_from("a", a)?, vector_from("b", b)?, vector_from("c", c)?]))
    }

    /// The half-space of all points p with `normal` · p ≤ `offset`, after `normal` is normalised.
    /// In a pair it must be A.
    ///
    /// # Errors
    /// The normal is zero or not finite, or the offset is NaN or too large.
    #[wasm_bindgen(js_name = halfSpace)]
    pub fn half_space(
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] normal: &[f64],
        offset: f64,
    ) -> Result<Shape, JsError> {
        HalfSpace::new(vector_from("normal", normal)?, offset).map(|made| Shape(Side::HalfSpace(made))).map_err(error)
    }

    /// The same shape again.
    pub fn shape(&self) -> Shape {
        self.clone()
    }

    /// Where a ray first enters the shape, for t from 0 to `maxT`, infinite by default. t is a
    /// factor of `direction`, which need not be of unit length.
    ///
    /// # Errors
    /// Origin or direction is not three finite numbers.
    pub fn ray(
        &self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] origin: &[f64],
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] direction: &[f64],
        #[wasm_bindgen(js_name = maxT)] max_t: Option<f64>,
    ) -> Result<Hit, JsError> {
        let ray = Ray::new(vector_from("origin", origin)?, vector_from("direction", direction)?).map_err(error)?;
        Ok(Plain::from_fields(&self.0.ray(&ray, &settings(max_t))).done())
    }

    /// Many rays, three numbers for each origin and direction. One origin or direction serves for
    /// all.
    ///
    /// # Errors
    /// The arrays do not fit, or a ray is not finite; the message has its index.
    pub fn rays(
        &self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] origins: &[f64],
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] directions: &[f64],
        #[wasm_bindgen(js_name = maxT)] max_t: Option<f64>,
    ) -> Result<Hits, JsError> {
        let (origins, directions) = (rows_of("origins", origins)?, rows_of("directions", directions)?);
        let (starts, ways) = (origins.len(), directions.len());
        if starts != ways && starts != 1 && ways != 1 {
            let remedy = "pass as many of both, or one of either";
            return Err(error(format!("{starts} origins do not fit {ways} directions: {remedy}")));
        }
        let settings = settings(max_t);
        let count = if starts == 1 { ways } else { starts };
        let (mut origins, mut directions) = (origins.iter().cycle(), directions.iter().cycle());
        // All answers have the same kinds of fields.
        let any = Ray::new(DVec3::ZERO, DVec3::ZERO).map_err(error)?;
        let mut columns = Columns::like(&self.0.ray(&any, &settings));
        for index in 0..count {
            // An endless iterator, unless the array is empty.
            let (Some(&origin), Some(&direction)) = (origins.next(), directions.next()) else { break };
            let ray = Ray::new(origin.into(), direction.into());
            columns.push(&self.0.ray(&ray.map_err(|fault| error(format!("ray {index}: {fault}")))?, &settings));
        }
        Ok(columns.done())
    }
}

fn settings(max_t: Option<f64>) -> CastSettings {
    let usual = CastSettings::default();
    CastSettings { max_t: max_t.unwrap_or(usual.max_t), ..usual }
}
