//! Shapes that can be queried: hulls, packs as the union of their hulls, primitives, half-spaces,
//! levels; and rays against them.

use hullmap::geometry::{AnyGeometry, AnyShape};
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, HalfSpace, Segment, Sphere, Triangle};
use hullmap::{CastSettings, Ray, RayHit, ShapeError, SharedGeometry};
use wasm_bindgen::prelude::*;

use crate::input::{error, rows_of};
use crate::object::{Columns, Plain, vector_from};

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** A body of a pair: a hull, a pack as the union of its hulls, a shape, or a level. */
export type Body = Hull | Pack | Shape | Level;
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

/// The geometry of a body.
///
/// # Errors
/// It is not a body.
pub fn geometry_of(name: &str, body: &Body) -> Result<SharedGeometry, JsError> {
    let wrong = |_| error(format!("{name}: expected a Hull, a Pack, a Shape or a Level that was not freed"));
    body.shape_of().map(|shape| shape.0).map_err(wrong)
}

/// A shape: a primitive, a half-space, a hull, or the union of all hulls of a pack.
#[wasm_bindgen]
#[derive(Clone)]
pub struct Shape(pub(crate) SharedGeometry);

fn convex(made: Result<impl hullmap::Shape + Send + Sync + 'static, ShapeError>) -> Result<Shape, JsError> {
    made.map(|shape| Shape(SharedGeometry::from_shape(shape))).map_err(error)
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
    /// Two of them have no query.
    ///
    /// # Errors
    /// The normal is zero or not finite, or the offset is NaN or too large.
    #[wasm_bindgen(js_name = halfSpace)]
    pub fn half_space(
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] normal: &[f64],
        offset: f64,
    ) -> Result<Shape, JsError> {
        HalfSpace::new(vector_from("normal", normal)?, offset).map(|made| Shape(made.into())).map_err(error)
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
        Ok(Plain::from_answer(&cast_ray(&self.0, &ray, &settings(max_t))).done())
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
        let mut columns = Columns::of::<RayHit>();
        for index in 0..count {
            // An endless iterator, unless the array is empty.
            let (Some(&origin), Some(&direction)) = (origins.next(), directions.next()) else { break };
            let ray = Ray::new(origin.into(), direction.into());
            let ray = ray.map_err(|fault| error(format!("ray {index}: {fault}")))?;
            columns.push(&cast_ray(&self.0, &ray, &settings));
        }
        Ok(columns.done())
    }
}

/// A ray at a geometry. All kinds of them share its code, as in `pair`.
fn cast_ray(geometry: &SharedGeometry, ray: &Ray, settings: &CastSettings) -> RayHit {
    match AnyShape::new(geometry) {
        Some(shape) => hullmap::ray(&shape, ray, settings),
        None => hullmap::ray(&AnyGeometry::new(geometry), ray, settings),
    }
}

fn settings(max_t: Option<f64>) -> CastSettings {
    let usual = CastSettings::default();
    CastSettings { max_t: max_t.unwrap_or(usual.max_t), ..usual }
}
