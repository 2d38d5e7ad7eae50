//! One type for every convex shape, and one for every geometry, so that a program holds each query
//! once or twice instead of once for every two kinds: for WebAssembly, where size counts more.
//!
//! # Steps
//! 1. [`AnyPair::new`] takes two geometries: two convex shapes, or else two geometries with parts,
//!    where a shape is its only part.
//! 2. A query of either goes through the methods of one [`AnyShape`], which calls the shape inside.

#![forbid(unsafe_code)]

use glam::DVec3;

use super::{Geometry, SharedGeometry, Visitor};
use crate::compound::bvh::{BoxShape, Node, Nodes};
use crate::compound::parts::Tree;
use crate::compound::{Compound, SharedSheet};
use crate::facets::Facets;
use crate::hull::Hull;
use crate::pose::Pose;
use crate::shapes::shape::forward_shape;
use crate::shapes::triangle::VisitTriangle;
use crate::shapes::{Feature, HalfSpace, Shape, Triangle};
use crate::solver::Ray;
use crate::support::support_map::forward_support_map;
use crate::support::{Bounds, FeaturePoint, LevelEdges, Lookup, SupportMap, SupportPoint};

/// Two geometries of any kind. Queries of what is inside have the answers of queries of the two
/// [`SharedGeometry`], bit by bit, in a fifth of the code. They take longer: each support query is
/// a call of a function that the compiler does not know.
pub enum AnyPair<'g> {
    /// Two convex shapes.
    Shapes(AnyShape<'g>, AnyShape<'g>),
    /// At least one of them has parts, or is a half-space.
    Parts(AnyGeometry<'g>, AnyGeometry<'g>),
}

impl<'g> AnyPair<'g> {
    /// The pair of two geometries.
    pub fn new(a: &'g SharedGeometry, b: &'g SharedGeometry) -> Self {
        match (AnyShape::new(a), AnyShape::new(b)) {
            (Some(a), Some(b)) => Self::Shapes(a, b),
            _ => Self::Parts(AnyGeometry::new(a), AnyGeometry::new(b)),
        }
    }
}

/// A convex shape of any kind.
pub struct AnyShape<'g>(Kind<'g>);

#[expect(clippy::large_enum_variant, reason = "a hull consists of slices; a pointer to it would require an owner")]
enum Kind<'g> {
    Shape(&'g dyn Shape),
    Hull(Hull<'g>),
    Triangle(Triangle),
}

impl<'g> AnyShape<'g> {
    /// The geometry, if it is a convex shape.
    pub fn new(geometry: &'g SharedGeometry) -> Option<Self> {
        geometry.as_shape().map(|shape| Self(Kind::Shape(shape)))
    }

    fn inner(&self) -> &dyn Shape {
        match &self.0 {
            Kind::Shape(shape) => *shape,
            Kind::Hull(hull) => hull,
            Kind::Triangle(triangle) => triangle,
        }
    }
}

impl SupportMap for AnyShape<'_> {
    forward_support_map!(self => self.inner());

    #[inline(always)]
    fn erased(&self) -> Option<&dyn SupportMap> {
        Some(self.inner())
    }
}

impl Shape for AnyShape<'_> {
    forward_shape!(self => self.inner());
}

/// A geometry of any kind, whose parts are [`AnyShape`]s.
#[expect(clippy::large_enum_variant, reason = "it lives on the stack for one query")]
pub enum AnyGeometry<'g> {
    /// It has parts, or is one.
    Parts(AnyParts<'g>),
    /// A half-space.
    HalfSpace(&'g HalfSpace),
}

impl<'g> AnyGeometry<'g> {
    /// The geometry, as parts: a convex shape is its only part.
    pub fn new(geometry: &'g SharedGeometry) -> Self {
        Self::Parts(AnyParts(match geometry {
            SharedGeometry::Hull(hull) => Source::Shape(hull.hull()),
            SharedGeometry::Shape(shape) => Source::Shape(&**shape),
            SharedGeometry::Compound(pack) => Source::Compound(Compound::new(pack)),
            SharedGeometry::Sheet(sheet) => Source::Sheet(sheet),
            SharedGeometry::HalfSpace(half_space) => return Self::HalfSpace(half_space),
        }))
    }
}

impl Geometry for AnyGeometry<'_> {
    #[inline(always)]
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        match self {
            Self::Parts(parts) => visitor.parts(parts),
            Self::HalfSpace(half_space) => visitor.half_space(half_space),
        }
    }
}

/// Parts of any kind.
pub struct AnyParts<'g>(Source<'g>);

#[expect(clippy::large_enum_variant, reason = "a compound may hold a hull, which consists of slices")]
enum Source<'g> {
    Shape(&'g dyn Shape),
    Compound(Compound<'g>),
    Sheet(&'g SharedSheet),
}

impl Tree for AnyParts<'_> {
    type Part<'p>
        = AnyShape<'p>
    where
        Self: 'p;

    fn part_count(&self) -> usize {
        match &self.0 {
            Source::Shape(_) => 1,
            Source::Compound(compound) => compound.part_count(),
            Source::Sheet(sheet) => sheet.part_count(),
        }
    }

    fn part(&self, index: usize) -> Option<AnyShape<'_>> {
        let kind = match &self.0 {
            Source::Shape(shape) => (index == 0).then_some(Kind::Shape(*shape)),
            Source::Compound(compound) => compound.part(index).map(Kind::Hull),
            Source::Sheet(sheet) => sheet.part(index).map(Kind::Triangle),
        };
        kind.map(AnyShape)
    }

    fn part_as_hull(&self, index: usize) -> Option<Hull<'_>> {
        match &self.0 {
            Source::Compound(compound) => compound.part_as_hull(index),
            Source::Shape(_) | Source::Sheet(_) => None,
        }
    }

    fn sheet_normal(&self, index: usize) -> Option<DVec3> {
        match &self.0 {
            Source::Sheet(sheet) => sheet.sheet_normal(index),
            Source::Shape(_) | Source::Compound(_) => None,
        }
    }

    fn nodes(&self) -> Nodes<'_> {
        match &self.0 {
            Source::Shape(shape) => shape.nodes(),
            Source::Compound(compound) => Tree::nodes(compound),
            Source::Sheet(sheet) => sheet.nodes(),
        }
    }

    fn box_shape(node: Node) -> impl SupportMap {
        AnyBox(BoxShape(node))
    }

    fn any_in_box(&self, bounds: [DVec3; 2], visit: &mut VisitTriangle<'_>) -> Option<(bool, u32)> {
        match &self.0 {
            Source::Sheet(sheet) => sheet.any_in_box(bounds, visit),
            Source::Shape(_) | Source::Compound(_) => None,
        }
    }
}

/// A box of a BVH, for the solver that all shapes share.
struct AnyBox(BoxShape);

impl SupportMap for AnyBox {
    forward_support_map!(self => self.0);

    #[inline(always)]
    fn erased(&self) -> Option<&dyn SupportMap> {
        Some(&self.0)
    }
}
