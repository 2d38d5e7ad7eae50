//! Linear scan without SIMD: one f32 dot product for each vertex, in the memory layout of a mesh.
//! parry, Jolt, Bullet and the paper's Listing 1 do the same. Exact up to rounding in f32.

use glam::Vec3;

use crate::{
    query::{Rival, SupportQuery},
    subject::Subject,
};

/// The vertices alone.
#[derive(Clone, Debug)]
pub struct ScalarScan {
    vertices: Vec<Vec3>,
}

impl ScalarScan {
    /// The vertices of `subject`.
    pub fn new(subject: &Subject) -> Self {
        Self { vertices: subject.vertices().collect() }
    }
}

impl Rival for ScalarScan {
    type Query<'a> = Scan<'a>;

    fn name(&self) -> &str {
        "scalar scan"
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn index_bytes(&self) -> usize {
        0
    }

    fn footprint_bytes(&self) -> usize {
        size_of_val(self.vertices.as_slice())
    }

    fn query(&self) -> Scan<'_> {
        Scan { vertices: &self.vertices }
    }

    fn duplicate(&self) -> Self {
        self.clone()
    }
}

/// See [`ScalarScan`].
pub struct Scan<'a> {
    vertices: &'a [Vec3],
}

impl SupportQuery for Scan<'_> {
    #[inline]
    fn support(&mut self, dir: Vec3) -> Vec3 {
        let mut best = (f32::NEG_INFINITY, 0);
        for (index, vertex) in self.vertices.iter().enumerate() {
            let dot = vertex.dot(dir);
            if dot > best.0 {
                best = (dot, index);
            }
        }
        self.vertices[best.1]
    }
}
