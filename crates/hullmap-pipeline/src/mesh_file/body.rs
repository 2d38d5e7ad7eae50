use std::f64::consts::FRAC_PI_2;

use glam::DQuat;
use hullmap::{Hull, MassProperties, PrimitiveKind, Replacement};
use hullmap_import::UpAxis;
use serde::Serialize;

use hullmap_verify::geometry::{polygons, positions};

/// Density of water, and MuJoCo's default, in kilograms per cubic metre.
pub const DENSITY: f64 = 1000.0;

/// Mass, centre of mass, and inertia tensor about it, in the axes of the export.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Inertial {
    /// In kilograms, for a density in kilograms per cubic unit.
    pub mass: f64,
    pub center: [f64; 3],
    /// Rows of the symmetric tensor.
    pub inertia: [[f64; 3]; 3],
}

impl Inertial {
    /// Mass properties, rotated; `None` for a body without mass.
    pub fn new(properties: &MassProperties, up_axis: UpAxis) -> Option<Self> {
        // R I Rᵀ: rotate the columns, then the rows.
        let columns = properties.inertia.to_cols_array_2d().map(|column| rotated(column, up_axis));
        // -0 becomes 0.
        let inertia = rotated_rows(columns, up_axis).map(|row| row.map(|entry| entry + 0.0));
        // NaN takes the failing branch.
        let has_mass = properties.mass > 0.0 && properties.mass < f64::INFINITY;
        let center = rotated(properties.center_of_mass.to_array(), up_axis);
        has_mass.then_some(Self { mass: properties.mass, center, inertia })
    }
}

fn rotated_rows(columns: [[f64; 3]; 3], up_axis: UpAxis) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|row| rotated(columns.map(|column| column[row]), up_axis))
}

/// A hull to be written. Field names are the JSON's.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Body {
    pub name: String,
    /// 3 solid, 2 polygon, 1 segment, 0 point.
    pub rank: u32,
    pub part: u32,
    /// Origin of the hull's frame in the frame of the source.
    pub origin: [f64; 3],
    pub positions: Vec<[f32; 3]>,
    /// Vertex indices of each face, counter-clockwise seen from outside.
    pub polygons: Vec<Vec<u32>>,
    pub primitive: Option<BodyPrimitive>,
    /// Mass of the hull's mesh at density 1, if the pack records it; equal for all parts of a mesh.
    pub mesh: Option<Inertial>,
}

/// A primitive instead of a hull. Field names are the JSON's.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct BodyPrimitive {
    #[serde(serialize_with = "name_of_kind")]
    pub kind: PrimitiveKind,
    pub center: [f64; 3],
    /// A unit quaternion x, y, z, w from its own axes. The axis of capsules and cylinders is z.
    pub rotation: [f64; 4],
    /// Box: half extents. Sphere: radius. Capsule and cylinder: radius, and half the length of the
    /// axis, without the ends of a capsule.
    pub sizes: [f64; 3],
    /// Bound on how far it protrudes from the solid of the mesh.
    pub protrusion: f64,
}

fn name_of_kind<S: serde::Serializer>(kind: &PrimitiveKind, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(kind.as_str())
}

impl BodyPrimitive {
    pub fn from_hull(hull: &Hull, up_axis: UpAxis) -> Option<Self> {
        let turn = match up_axis {
            UpAxis::Keep => DQuat::IDENTITY,
            UpAxis::YToZ => DQuat::from_rotation_x(FRAC_PI_2),
            UpAxis::ZToY => DQuat::from_rotation_x(-FRAC_PI_2),
        };
        let Replacement { kind, center, rotation, sizes, protrusion } = hull.primitive()?;
        let (center, rotation) = (rotated(center.to_array(), up_axis), (turn * rotation).to_array());
        Some(Self { kind, center, rotation, sizes, protrusion })
    }

    pub fn turn(&self) -> DQuat {
        DQuat::from_array(self.rotation)
    }
}

impl Body {
    /// The hull, rotated. Rotations are exact: coordinates are swapped and negated.
    pub fn new(hull: &Hull, up_axis: UpAxis) -> Self {
        let mut positions = positions(hull);
        for position in &mut positions {
            *position = rotated(*position, up_axis);
        }
        Self {
            name: hull.name().to_owned(),
            rank: hull.rank(),
            part: hull.part(),
            origin: rotated(hull.origin().to_array(), up_axis),
            positions,
            polygons: polygons(hull),
            primitive: BodyPrimitive::from_hull(hull, up_axis),
            mesh: hull.mesh_mass_properties(1.0).and_then(|mesh| Inertial::new(&mesh, up_axis)),
        }
    }

    /// Extras of the hull's glTF node: at the first part of a mesh, its volume, its centre of mass,
    /// and its inertia about it at density 1. The hulls have another mass.
    pub fn extras(&self) -> Option<serde_json::Value> {
        let Inertial { mass, center, inertia } = self.mesh.filter(|_| self.part == 0)?;
        Some(
            serde_json::json!({ "hullmap": { "mesh_volume": mass, "mesh_centroid": center, "mesh_inertia": inertia } }),
        )
    }

    /// All faces, each triangulated from its first vertex, since faces are planar and convex.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.polygons.iter().flat_map(|polygon| {
            let first = polygon.first().copied().unwrap_or_default();
            polygon.get(1..).unwrap_or_default().windows(2).map(move |pair| [first, pair[0], pair[1]])
        })
    }
}

pub fn rotated<T: Copy + std::ops::Neg<Output = T>>([x, y, z]: [T; 3], up_axis: UpAxis) -> [T; 3] {
    match up_axis {
        UpAxis::Keep => [x, y, z],
        UpAxis::YToZ => [x, -z, y],
        UpAxis::ZToY => [x, z, -y],
    }
}

#[cfg(test)]
pub fn cube(name: &str) -> Body {
    let positions = (0..8_u8).map(|i| [0, 1, 2].map(|axis| f32::from(i >> axis & 1) * 2.0 - 1.0)).collect();
    let polygons =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]].map(Vec::from).into();
    Body { name: name.to_owned(), rank: 3, part: 0, origin: [0.0; 3], positions, polygons, primitive: None, mesh: None }
}

/// Numbers of bodies, of their vertices and of their triangles.
pub fn counts(bodies: &[Body]) -> [usize; 3] {
    let vertices = bodies.iter().map(|body| body.positions.len()).sum();
    let triangles = bodies.iter().map(|body| body.triangles().count()).sum();
    [bodies.len(), vertices, triangles]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_cover_faces() {
        let cube = cube("cube");
        assert_eq!(cube.triangles().count(), 12);
        assert!(cube.triangles().take(2).eq([[0, 4, 6], [0, 6, 2]]));
        for polygon in [vec![], vec![1], vec![1, 2]] {
            assert_eq!(Body { polygons: vec![polygon], ..cube.clone() }.triangles().count(), 0);
        }
    }

    /// A slab in x and y stands up: moments about y and z change places, and products their sign.
    #[test]
    fn a_tensor_turns_with_its_body() {
        let inertia = glam::DMat3::from_cols_array(&[1.0, 0.1, 0.2, 0.1, 2.0, 0.3, 0.2, 0.3, 4.0]);
        let center_of_mass = glam::DVec3::new(1.0, 2.0, 3.0);
        let properties = MassProperties { mass: 5.0, center_of_mass, inertia, ..MassProperties::default() };
        let turned = Inertial::new(&properties, UpAxis::YToZ).unwrap();
        assert_eq!((turned.mass, turned.center), (5.0, [1.0, -3.0, 2.0]));
        assert_eq!(turned.inertia, [[1.0, -0.2, 0.1], [-0.2, 4.0, -0.3], [0.1, -0.3, 2.0]]);
        assert!(Inertial::new(&MassProperties::default(), UpAxis::Keep).is_none());
    }

    #[test]
    fn rotations_undo_each_other() {
        let point = [1.0_f32, 2.0, -3.0];
        assert_eq!(rotated(point, UpAxis::YToZ), [1.0, 3.0, 2.0]);
        assert_eq!(rotated(rotated(point, UpAxis::YToZ), UpAxis::ZToY), point);
    }
}
