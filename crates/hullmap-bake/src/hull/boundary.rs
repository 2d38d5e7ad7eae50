use glam::DVec3;
use hullmap_geometry::planes::{HalfSpace, of_face};

/// A certified convex hull.
#[derive(Clone, Debug)]
pub struct Hull {
    /// Dimension: 3 solid, 2 polygon, 1 segment, 0 point.
    pub rank: u32,
    /// Positions of the vertices in source order, then of the vertices that the source lacks.
    /// Negative zeros are replaced by positive ones.
    pub vertices: Vec<[f32; 3]>,
    /// For each vertex, the first source vertex with that position;
    /// [`NO_SOURCE_VERTEX`](crate::NO_SOURCE_VERTEX) if there is none.
    pub source_vertices: Vec<u32>,
    /// Faces as polygons of vertex indices, counter-clockwise seen from outside. A solid has its
    /// facets; a polygon has both of its sides.
    pub faces: Vec<Vec<u32>>,
    /// Maximum distance between two vertices.
    pub diameter: f64,
    /// Maximum distance of a source point outside the hull, relative to the diameter.
    pub containment_error: f64,
}

impl Hull {
    /// Vertex positions in f64.
    pub fn positions(&self) -> Vec<DVec3> {
        self.vertices.iter().map(|v| DVec3::from_array(v.map(f64::from))).collect()
    }

    /// One half-space per face of a solid hull with area, each containing the whole face.
    pub fn half_spaces(&self) -> Vec<HalfSpace> {
        let positions = self.positions();
        let of_face = |face: &Vec<u32>| {
            let corners: Vec<DVec3> = face.iter().map(|v| positions[*v as usize]).collect();
            Some(of_face(&corners, &positions)?.0)
        };
        self.faces.iter().filter_map(of_face).collect()
    }
}

/// Directed edges of a polygon.
pub(crate) fn edges(face: &[u32]) -> impl Iterator<Item = (u32, u32)> + '_ {
    face.iter().copied().zip(face.iter().copied().cycle().skip(1))
}

/// The least and the greatest coordinates of points; infinite without points.
pub(crate) fn bounds<'a>(points: impl IntoIterator<Item = &'a [f32; 3]>) -> [[f32; 3]; 2] {
    let pick = |pick: fn(f32, f32) -> f32, a: [f32; 3], b: &[f32; 3]| [0, 1, 2].map(|axis| pick(a[axis], b[axis]));
    let start = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    points.into_iter().fold(start, |[low, high], p| [pick(f32::min, low, p), pick(f32::max, high, p)])
}
