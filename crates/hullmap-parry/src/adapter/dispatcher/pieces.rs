//! Convex pieces of a parry shape, which hullmap solves.

use super::super::convert::wide_pose;
use super::super::parry::math::Pose;
use super::super::parry::shape::{Compound, Shape};
use super::BakedHull;
use super::primitive::Primitive;

pub(super) enum Convex<'s> {
    Hull(&'s BakedHull),
    Primitive(Primitive),
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
        match &self.convex {
            Convex::Hull(hull) => *hull,
            Convex::Primitive(primitive) => primitive.shape(),
        }
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

fn piece<'s>(shape: &'s dyn Shape, pose: &Pose, subshape: u32) -> Option<Piece<'s>> {
    let convex = match shape.as_shape::<BakedHull>() {
        Some(hull) => Convex::Hull(hull),
        None => Convex::Primitive(Primitive::from_shape(shape)?),
    };
    Some(Piece { convex, of_parry: shape, place: wide_pose(pose)?, pose: *pose, subshape })
}
