//! Convex shapes of links and obstacles: hulls of packs, and primitives.

use std::sync::Arc;

use glam::DVec3;
use hullmap::geometry::{Geometry, Visitor};
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, Scaled, ShapeError, Sphere};
use hullmap::{Hull, Pack, Shape, SharedGeometry, SharedHull};
use hullmap_bake::{IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
use hullmap_robot::{Frame, MeshUse, Primitive};

/// A convex shape of any kind.
pub type AnyShape = dyn Shape + Send + Sync;

/// A convex shape: a hull of a pack, or another shape.
#[derive(Clone)]
pub enum Convex {
    /// A hull, as it is in its pack.
    Hull(SharedHull),
    /// A primitive, or a hull that is scaled.
    Shape(Arc<AnyShape>),
}

impl Convex {
    /// The shape that queries take.
    pub fn shape(&self) -> &AnyShape {
        match self {
            Self::Hull(hull) => hull,
            Self::Shape(shape) => &**shape,
        }
    }
}

impl Geometry for Convex {
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        match self {
            Self::Hull(hull) => visitor.shape(hull.hull()),
            Self::Shape(shape) => visitor.shape::<dyn Shape>(&**shape),
        }
    }
}

impl From<Convex> for SharedGeometry {
    fn from(convex: Convex) -> Self {
        match convex {
            Convex::Hull(hull) => Self::Hull(hull),
            Convex::Shape(shape) => Self::Shape(shape),
        }
    }
}

/// The shape of a primitive of a description.
///
/// # Errors
/// It is too small or too large.
pub fn shape_of_primitive(primitive: Primitive) -> Result<Convex, ShapeError> {
    let shape: Arc<AnyShape> = match primitive {
        Primitive::Box(half) => Arc::new(Cuboid::new(DVec3::from_array(half))?),
        Primitive::Sphere(radius) => Arc::new(Sphere::new(radius)?),
        Primitive::Cylinder([radius, half_length]) => Arc::new(Cylinder::new(half_length, radius)?),
        Primitive::Capsule([radius, half_length]) => Arc::new(Capsule::new(half_length, radius)?),
        Primitive::Cone([radius, half_length]) => Arc::new(Cone::new(half_length, radius)?),
        Primitive::Ellipsoid(radii) => Arc::new(Scaled::new(Sphere::new(1.0)?, DVec3::from_array(radii))?),
    };
    Ok(Convex::Shape(shape))
}

/// The hulls of a pack, as a description scales and turns their mesh.
///
/// # Errors
/// A factor is too small or too large, or a hull is degenerate.
pub fn hulls(pack: &Arc<Pack>, mesh: &MeshUse) -> Result<Vec<Convex>, String> {
    let mut shapes = Vec::new();
    for (index, hull) in pack.hulls().enumerate() {
        if mesh.reference == Frame::IDENTITY {
            let own = pack.shared_hull(index).map_err(|error| error.to_string())?;
            shapes.push(if mesh.scale == [1.0; 3] {
                Convex::Hull(own)
            } else {
                let scaled = Scaled::new(own, DVec3::from_array(mesh.scale)).map_err(|error| error.to_string())?;
                Convex::Shape(Arc::new(scaled))
            });
        } else {
            shapes.push(turned(&hull, mesh)?);
        }
    }
    Ok(shapes)
}

/// A hull that is turned before it is scaled, which shears it: it is built again.
fn turned(hull: &Hull, mesh: &MeshUse) -> Result<Convex, String> {
    let placed = |vertex: glam::Vec3| mesh.placed(vertex.as_dvec3()).as_vec3().to_array();
    let positions: Vec<[f32; 3]> = hull.vertices().map(placed).collect();
    let points = PointSet::of_positions(positions);
    let pack = hull_of(&points, IndexKind::None)?;
    Ok(Convex::Hull(pack.shared_hull(0).map_err(|error| error.to_string())?))
}

/// The convex hull of points, as a pack of one.
///
/// # Errors
/// There are no points, or one is out of range.
pub fn hull_of(points: &PointSet, index: IndexKind) -> Result<Arc<Pack>, String> {
    let baked = bake_hull(points, index).map_err(|error| error.to_string())?;
    let bytes = write_pack(&[baked], &SourceRecord::default()).map_err(|error| error.to_string())?;
    Pack::from_bytes(&bytes).map(Arc::new).map_err(|error| error.to_string())
}
