//! Convex pieces of a parry shape, which hullmap solves.

use hullmap::geometry::{Geometry, Visitor};

use super::super::convert::wide_pose;
use super::super::parry::math::Pose;
use super::super::parry::shape::{Compound, Shape};
use super::BakedHull;
use super::primitive::Primitive;

pub(super) enum Convex<'s> {
    Hull(&'s BakedHull),
    Primitive(Primitive),
}

impl<'s> Convex<'s> {
    /// `None` for a shape that hullmap does not solve.
    #[inline]
    pub(super) fn from_shape(shape: &'s dyn Shape) -> Option<Self> {
        match shape.as_shape::<BakedHull>() {
            Some(hull) => Some(Self::Hull(hull)),
            None => Primitive::from_shape(shape).map(Self::Primitive),
        }
    }

    pub(super) fn shape(&self) -> &dyn hullmap::Shape {
        match self {
            Self::Hull(hull) => *hull,
            Self::Primitive(primitive) => primitive.shape(),
        }
    }
}

impl Geometry for Convex<'_> {
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        match self {
            Self::Hull(hull) => visitor.shape(*hull),
            Self::Primitive(primitive) => visitor.shape(primitive.shape()),
        }
    }
}

pub(super) struct Piece<'s> {
    convex: Convex<'s>,
    pub(super) of_parry: &'s dyn Shape,
    /// Its pose in the frame of the body.
    pub(super) place: hullmap::Pose,
    /// `place` in parry's precision.
    pub(super) pose: Pose,
    pub(super) subshape: u32,
}

impl Piece<'_> {
    pub(super) fn shape(&self) -> &dyn hullmap::Shape {
        self.convex.shape()
    }
}

/// A convex shape, or the parts of a compound. `None` if hullmap does not solve one of them.
pub(super) fn pieces(shape: &dyn Shape) -> Option<Vec<Piece<'_>>> {
    let Some(compound) = shape.as_shape::<Compound>() else {
        return Some(vec![piece(shape, &Pose::IDENTITY, 0)?]);
    };
    let parts = (0..).zip(compound.shapes()).map(|(subshape, (pose, part))| piece(&**part, pose, subshape));
    parts.collect()
}

fn piece<'s>(of_parry: &'s dyn Shape, pose: &Pose, subshape: u32) -> Option<Piece<'s>> {
    Some(Piece { convex: Convex::from_shape(of_parry)?, of_parry, place: wide_pose(pose)?, pose: *pose, subshape })
}
