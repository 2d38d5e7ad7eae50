//! A body of the soak: a shape, and its definition.

use glam::{DVec3, Vec3};
use hullmap::{Hull, Shape};

use super::model::Model;

/// Any shape.
pub type Any<'p> = dyn Shape + Sync + 'p;

/// Kind of a body, as named in the counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A game hull.
    Game,
    /// A hull of a family of `shapes`.
    Family,
    /// A box, tetrahedron or polygon that is nearly flat or nearly a line.
    Sliver,
    /// A polygon, segment or point.
    Flat,
    /// A shape in closed form, or a hull scaled or rounded.
    Closed,
}

/// A shape that the solver is queried with.
#[expect(clippy::large_enum_variant, reason = "most of them are hulls")]
pub enum Solid<'p> {
    /// A hull, by its own type.
    Hull(Hull<'p>),
    /// Any shape, through its trait object.
    Shape(Box<Any<'p>>),
}

/// A shape, and its definition.
pub struct Body<'p> {
    /// Kind and size, for messages.
    pub name: String,
    /// Kind of shape.
    pub kind: Kind,
    /// The shape that the solver is queried with.
    pub solid: Solid<'p>,
    /// The shape by its definition, for the certificates.
    pub model: Model,
}

impl Body<'_> {
    /// The shape as a trait object.
    pub fn shape(&self) -> &Any<'_> {
        match &self.solid {
            Solid::Hull(hull) => hull,
            Solid::Shape(shape) => &**shape,
        }
    }
}

/// Size of a body, which scales the lengths in its poses: about half its diameter.
pub(super) fn size(body: &Body<'_>) -> f64 {
    body.shape().outer_radius()
}

/// The point in the body's frame at which bodies are made to touch: a hull's support vertex, or the
/// support point of another shape. It affects the sample, not the judgement.
pub(super) fn support(body: &Body<'_>, dir: DVec3) -> DVec3 {
    match &body.solid {
        Solid::Hull(hull) => hull.support(dir.as_vec3()).point.as_dvec3(),
        Solid::Shape(shape) => shape.support_point(dir).point,
    }
}

/// Rounds to [`Vec3`], the precision of poses in games.
pub(super) fn single(v: DVec3) -> DVec3 {
    Vec3::as_dvec3(v.as_vec3())
}
