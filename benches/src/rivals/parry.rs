//! parry3d's support query in f32: `ConvexPolyhedron::local_support_point`, a linear scan. Exact up
//! to the rounding error of f32.

use glam::Vec3;
use parry3d::shape::{ConvexPolyhedron, SupportMap};

use crate::{
    query::{Rival, SupportQuery},
    subject::Subject,
};

/// Estimated bytes of a vertex with its edges and faces in parry's polyhedron, which does not
/// report its size.
const BYTES_PER_VERTEX: usize = 400;

/// A baked hull as a convex polyhedron of parry.
#[derive(Clone)]
pub struct Parry {
    polyhedron: ConvexPolyhedron,
}

impl Parry {
    /// The hull of `subject`; `None` if parry rejects the mesh.
    pub fn new(subject: &Subject) -> Option<Self> {
        let points: Vec<_> = subject.vertices().collect();
        let fan = |face: &Vec<u32>| face[1..].windows(2).map(|w| [face[0], w[0], w[1]]).collect::<Vec<_>>();
        let triangles: Vec<[u32; 3]> = subject.faces().iter().flat_map(fan).collect();
        let polyhedron = ConvexPolyhedron::from_convex_mesh(points, &triangles)?;
        // parry merges near-coplanar faces. If it dropped vertices, it would have fewer to scan.
        (polyhedron.points().len() == subject.vertex_count()).then_some(Self { polyhedron })
    }

    /// The polyhedron, for parry's own queries.
    pub fn into_polyhedron(self) -> ConvexPolyhedron {
        self.polyhedron
    }
}

impl Rival for Parry {
    type Query<'a> = Polyhedron<'a>;

    fn name(&self) -> &str {
        "parry3d"
    }

    /// The polyhedron uses only the points in support queries.
    fn index_bytes(&self) -> usize {
        0
    }

    fn footprint_bytes(&self) -> usize {
        BYTES_PER_VERTEX * self.polyhedron.points().len()
    }

    fn query(&self) -> Polyhedron<'_> {
        Polyhedron { polyhedron: &self.polyhedron }
    }

    fn duplicate(&self) -> Self {
        self.clone()
    }
}

/// See [`Parry`].
pub struct Polyhedron<'a> {
    polyhedron: &'a ConvexPolyhedron,
}

impl SupportQuery for Polyhedron<'_> {
    #[inline]
    fn support(&mut self, dir: Vec3) -> Vec3 {
        self.polyhedron.local_support_point(dir)
    }
}
