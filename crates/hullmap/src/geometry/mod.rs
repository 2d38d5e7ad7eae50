//! Everything that can be queried: [`Geometry`].
//!
//! | geometry | parts |
//! |---|---|
//! | every [`Shape`]: a [`Hull`](crate::Hull), a primitive, a support mapping of your own | itself |
//! | [`Pack`], [`Compound`]: a concave mesh, as the union of its hulls | hulls |
//! | [`TriangleMesh`], [`HeightField`]: a level, terrain; [`OneSided`]: fronts alone | triangles |
//! | [`HalfSpace`]: a floor, a wall | itself |
//! | [`SharedGeometry`]: any of them, owned, for components and bindings | as above |
//!
//! Queries take any two of them. The compiler chooses the code for their types: two hulls take no
//! branch on what they are, and a [`SharedGeometry`] takes one.

#![forbid(unsafe_code)]

mod any;
mod shared;

use crate::compound::{Compound, OneSided, Parts, SharedSheet};
use crate::height_field::HeightField;
use crate::pack::Pack;
use crate::shapes::{HalfSpace, Shape};
use crate::triangle_mesh::TriangleMesh;
pub use any::{AnyGeometry, AnyPair, AnyParts, AnyShape};
pub use shared::{SharedGeometry, TwoHalfSpaces};

/// Something that can be queried. See the [module](self) for a table of them.
///
/// # Examples
/// An enum of your own is a geometry if it passes the visitor on:
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = two_cubes();
/// use hullmap::geometry::{Geometry, Visitor};
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::{HalfSpace, Sphere};
/// use hullmap::{Cache, Pack, Pose, Settings};
///
/// enum Thing {
///     Floor(HalfSpace),
///     Statue(Pack),
/// }
///
/// impl Geometry for Thing {
///     fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
///         match self {
///             Thing::Floor(floor) => floor.visit(visitor),
///             Thing::Statue(pack) => pack.visit(visitor),
///         }
///     }
/// }
///
/// // A ball above a floor, and between two unit cubes at x from 0 to 1 and from 3 to 4.
/// let (ball, at) = (Sphere::new(0.5)?, Pose::from_translation(DVec3::new(2.25, 0.5, 0.75))?);
/// let things = [Thing::Floor(HalfSpace::new(DVec3::Z, 0.0)?), Thing::Statue(pack)];
/// let gaps = things.map(|thing| {
///     hullmap::distance(&thing, &ball, at, &Settings::default(), &mut Cache::new()).distance
/// });
/// assert!((gaps[0] - 0.25).abs() < 1e-12 && (gaps[1] - 0.25).abs() < 1e-12);
/// # Ok(())
/// # }
/// ```
pub trait Geometry {
    /// Calls the method of `visitor` for what this is.
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output;
}

/// A computation on a geometry, by what it is.
pub trait Visitor {
    /// Its result.
    type Output;

    /// The geometry is convex.
    fn shape<S: Shape + ?Sized>(self, shape: &S) -> Self::Output;

    /// The geometry has parts.
    fn parts<P: Parts + ?Sized>(self, parts: &P) -> Self::Output;

    /// The geometry is a half-space.
    fn half_space(self, half_space: &HalfSpace) -> Self::Output;
}

impl<S: Shape + ?Sized> Geometry for S {
    #[inline(always)]
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.shape(self)
    }
}

impl Geometry for HalfSpace {
    #[inline(always)]
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.half_space(self)
    }
}

impl Geometry for Pack {
    /// The union of all hulls.
    #[inline(always)]
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.parts(&Compound::new(self))
    }
}

impl Geometry for Compound<'_> {
    #[inline(always)]
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.parts(self)
    }
}

impl Geometry for TriangleMesh {
    #[inline(always)]
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.parts(self)
    }
}

impl Geometry for HeightField {
    #[inline(always)]
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.parts(self)
    }
}

impl Geometry for SharedSheet {
    #[inline(always)]
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.parts(self)
    }
}

impl<M: Parts + ?Sized> Geometry for OneSided<'_, M> {
    #[inline(always)]
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.parts(self)
    }
}
