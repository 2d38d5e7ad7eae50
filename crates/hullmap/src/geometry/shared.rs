//! A geometry of any kind as one type.

use std::fmt;
use std::sync::Arc;

use super::{Geometry, Visitor};
use crate::compound::SharedSheet;
use crate::height_field::HeightField;
use crate::hull::SharedHull;
use crate::pack::Pack;
use crate::pose::Pose;
use crate::shapes::{HalfSpace, Shape};
use crate::support::Bounds;
use crate::triangle_mesh::TriangleMesh;

/// A geometry of any kind, owned: for components, robots, and programs that open files of several
/// kinds. A clone shares the data.
///
/// A query takes one branch for each side. Then it runs the same code as for the type inside.
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = two_cubes();
/// use std::sync::Arc;
///
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::{HalfSpace, Sphere};
/// use hullmap::{Cache, Pose, SharedGeometry};
///
/// let ball = SharedGeometry::from_shape(Sphere::new(0.5)?);
/// let scene = [HalfSpace::new(DVec3::Z, 0.0)?.into(), Arc::new(pack).into(), ball.clone()];
/// let at = Pose::from_translation(DVec3::new(0.0, 0.0, 0.25))?;
/// let hits = |thing: &SharedGeometry| hullmap::intersects(thing, &ball, at, &mut Cache::new()).is_hit();
/// assert!(scene.iter().all(hits));
/// assert_eq!(scene.each_ref().map(SharedGeometry::name), ["a half-space", "a compound", "a primitive"]);
/// # Ok(())
/// # }
/// ```
#[derive(Clone)]
pub enum SharedGeometry {
    /// A hull.
    Hull(SharedHull),
    /// Another convex shape.
    Shape(Arc<dyn Shape + Send + Sync>),
    /// The union of the hulls of a pack.
    Compound(Arc<Pack>),
    /// A triangle mesh or a height field.
    Sheet(SharedSheet),
    /// A half-space.
    HalfSpace(HalfSpace),
}

/// Both sides of a pair are half-spaces. See [`SharedGeometry::check_pair`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("two half-spaces have no query, since both are unbounded: replace one of them by a bounded shape")]
pub struct TwoHalfSpaces;

impl SharedGeometry {
    /// A primitive, or a shape of your own.
    pub fn from_shape(shape: impl Shape + Send + Sync + 'static) -> Self {
        Self::Shape(Arc::new(shape))
    }

    /// Name of its kind, with the article.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Hull(_) => "a hull",
            Self::Shape(_) => "a primitive",
            Self::Compound(_) => "a compound",
            Self::Sheet(sheet) => sheet.name(),
            Self::HalfSpace(_) => "a half-space",
        }
    }

    /// The convex shape, if it is one.
    pub fn as_shape(&self) -> Option<&(dyn Shape + Send + Sync)> {
        match self {
            Self::Hull(hull) => Some(hull),
            Self::Shape(shape) => Some(&**shape),
            Self::Compound(_) | Self::Sheet(_) | Self::HalfSpace(_) => None,
        }
    }

    /// Whether it has parts: hulls or triangles.
    pub fn has_parts(&self) -> bool {
        matches!(self, Self::Compound(_) | Self::Sheet(_))
    }

    /// Checks that this and `other` have common queries: all but two half-spaces have.
    ///
    /// # Errors
    /// Both are half-spaces. Queries of them claim nothing.
    pub fn check_pair(&self, other: &Self) -> Result<(), TwoHalfSpaces> {
        match (self, other) {
            (Self::HalfSpace(_), Self::HalfSpace(_)) => Err(TwoHalfSpaces),
            _ => Ok(()),
        }
    }

    /// Calls `run` with the part that an answer names: a hull, a triangle, or the convex shape
    /// itself. `None` if there is no such part, and for a half-space.
    ///
    /// Derivatives of an answer take the two parts that decided it.
    pub fn with_part<T>(&self, part: u32, run: impl FnOnce(&dyn Shape) -> T) -> Option<T> {
        match self {
            Self::Hull(hull) => Some(run(hull.hull())),
            Self::Shape(shape) => Some(run(&**shape)),
            Self::Compound(pack) => Some(run(&pack.hull(part as usize).ok()?)),
            Self::Sheet(sheet) => Some(run(&sheet.triangle(part as usize)?)),
            Self::HalfSpace(_) => None,
        }
    }

    /// The box around it at a pose, along the axes. `None` for a half-space, which is unbounded,
    /// and for a compound or a mesh without parts.
    ///
    /// # Complexity
    /// As [`SupportMap::bounds_under`](crate::SupportMap::bounds_under) of each part.
    pub fn bounds_under(&self, pose: Pose) -> Option<Bounds> {
        let count = match self {
            Self::Compound(pack) => pack.hull_count(),
            Self::Sheet(sheet) => sheet.triangle_count(),
            _ => 1,
        };
        let boxes = (0..count).filter_map(|part| self.with_part(part as u32, |part| part.bounds_under(pose)));
        boxes.reduce(|p, q| Bounds { min: p.min.min(q.min), max: p.max.max(q.max) })
    }
}

impl Geometry for SharedGeometry {
    #[inline(always)]
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        match self {
            Self::Hull(hull) => visitor.shape(hull.hull()),
            // Without the marks for threads: one instance of each query for all shapes.
            Self::Shape(shape) => visitor.shape::<dyn Shape>(&**shape),
            Self::Compound(pack) => pack.visit(visitor),
            Self::Sheet(sheet) => sheet.visit(visitor),
            Self::HalfSpace(half_space) => half_space.visit(visitor),
        }
    }
}

impl fmt::Debug for SharedGeometry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl From<SharedHull> for SharedGeometry {
    fn from(hull: SharedHull) -> Self {
        Self::Hull(hull)
    }
}

impl From<Arc<Pack>> for SharedGeometry {
    fn from(pack: Arc<Pack>) -> Self {
        Self::Compound(pack)
    }
}

impl From<Arc<TriangleMesh>> for SharedGeometry {
    fn from(mesh: Arc<TriangleMesh>) -> Self {
        Self::Sheet(SharedSheet::Mesh(mesh))
    }
}

impl From<Arc<HeightField>> for SharedGeometry {
    fn from(field: Arc<HeightField>) -> Self {
        Self::Sheet(SharedSheet::Field(field))
    }
}

impl From<HalfSpace> for SharedGeometry {
    fn from(half_space: HalfSpace) -> Self {
        Self::HalfSpace(half_space)
    }
}
