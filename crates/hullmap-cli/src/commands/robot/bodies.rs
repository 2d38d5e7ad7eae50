//! The collisions of links as convex shapes that can be queried.

use std::sync::Arc;

use glam::DVec3;
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, Scaled, ShapeError, Sphere};
use hullmap::{Hull, Pack, SupportMap};
use hullmap_bake::{IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
use hullmap_robot::{Frame, MeshUse, Solid};

/// A shape of any kind.
pub type AnyShape = Box<dyn SupportMap + Send + Sync>;

/// A convex piece of a link.
pub struct Piece {
    /// The shape.
    pub shape: AnyShape,
    /// Its frame in the link's.
    pub in_link: Frame,
    /// `contype` and `conaffinity`.
    pub contact_bits: [i32; 2],
}

impl Piece {
    /// Centre and radius of a ball that holds it, in the frame of the link.
    pub fn ball(&self) -> (DVec3, f64) {
        (self.in_link.apply(self.shape.interior_point()), self.shape.outer_radius())
    }

    /// Whether MuJoCo lets the two meet.
    pub fn may_meet(&self, other: &Self) -> bool {
        let [type_a, affinity_a] = self.contact_bits;
        let [type_b, affinity_b] = other.contact_bits;
        type_a & affinity_b != 0 || type_b & affinity_a != 0
    }
}

/// A primitive.
///
/// # Errors
/// It is too small or too large.
pub fn solid(solid: Solid) -> Result<AnyShape, ShapeError> {
    Ok(match solid {
        Solid::Box(half) => Box::new(Cuboid::new(DVec3::from_array(half))?),
        Solid::Sphere(radius) => Box::new(Sphere::new(radius)?),
        Solid::Cylinder([radius, half_length]) => Box::new(Cylinder::new(half_length, radius)?),
        Solid::Capsule([radius, half_length]) => Box::new(Capsule::new(half_length, radius)?),
        Solid::Cone([radius, half_length]) => Box::new(Cone::new(half_length, radius)?),
        Solid::Ellipsoid(radii) => Box::new(Scaled::new(Sphere::new(1.0)?, DVec3::from_array(radii))?),
    })
}

/// The hulls of a pack, as a description scales and turns their mesh.
///
/// # Errors
/// A factor is too small or too large, or a hull is degenerate.
pub fn hulls(pack: &Arc<Pack>, mesh: &MeshUse) -> Result<Vec<AnyShape>, String> {
    let mut shapes: Vec<AnyShape> = Vec::new();
    for (index, hull) in pack.hulls().enumerate() {
        if mesh.reference == Frame::IDENTITY {
            let own = pack.shared_hull(index).map_err(|error| error.to_string())?;
            let scaled = Scaled::new(own, DVec3::from_array(mesh.scale)).map_err(|error| error.to_string())?;
            shapes.push(Box::new(scaled));
        } else {
            shapes.push(turned(&hull, mesh)?);
        }
    }
    Ok(shapes)
}

/// A hull that is turned before it is scaled, which shears it: it is built again.
fn turned(hull: &Hull, mesh: &MeshUse) -> Result<AnyShape, String> {
    let placed = |vertex: glam::Vec3| mesh.placed(vertex.as_dvec3()).as_vec3().to_array();
    let positions: Vec<[f32; 3]> = hull.vertices().map(placed).collect();
    let source_vertices = (0..positions.len() as u32).collect();
    let points = PointSet { positions, source_vertices, ..PointSet::default() };
    let baked = bake_hull(&points, IndexKind::None).map_err(|error| error.to_string())?;
    let bytes = write_pack(&[baked], &SourceRecord::default()).map_err(|error| error.to_string())?;
    let pack = Pack::from_bytes(&bytes).map_err(|error| error.to_string())?;
    Ok(Box::new(Arc::new(pack).shared_hull(0).map_err(|error| error.to_string())?))
}
