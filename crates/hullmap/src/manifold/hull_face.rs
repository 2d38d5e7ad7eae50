//! The feature of a hull that faces a direction: a baked face, found through the index.
//!
//! # Steps
//! 1. the face towards the direction: of the faces at the support vertex the one whose normal is nearest;
//! 2. support queries in eight directions tilted to all sides: if all answers are corners of that face, it is all that faces
//!    the direction, and its corners are the feature, exactly;
//! 3. else (an edge or a vertex faces it; or several faces do, as where f32 has broken a flat cap into slivers; or the face
//!    has more corners than a feature holds) the support points in [`MAX_CORNERS`] tilted directions.
//!
//! So no face is ever scanned for, and a face of thousands of corners costs what one of a hundred does.

#![forbid(unsafe_code)]

use crate::minkowski::unit;
use crate::shape::{MAX_CORNERS, TILT, ring, tilted};
use crate::{Corner, Feature, Hull, Shape, SupportMap};
use glam::DVec3;

/// Every how many'th of the directions of a ring is asked in step 2.
const STRIDE: usize = 4;

impl Shape for Hull<'_> {
    /// A baked face, or an edge, or a vertex.
    ///
    /// # Complexity
    /// 9 to 41 support queries, and one normal for each face at the support vertex.
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        if !self.baked_face(dir, out) {
            ring(self, dir, out);
        }
    }
}

impl Hull<'_> {
    /// Puts the corners of the face towards `dir` into `out`; false if they are not all that faces it.
    fn baked_face(&self, dir: DVec3, out: &mut Feature) -> bool {
        out.clear();
        let Some((dir, face)) = unit(dir).and_then(|dir| Some((dir, self.face_towards(dir)?))) else { return false };
        let corners = self.face(face);
        let tilt = self.face_normal(face).map_or(f64::INFINITY, |normal| normal.cross(dir).length());
        // NaN takes the failing branch.
        if !(tilt <= TILT && corners.len() <= MAX_CORNERS) {
            return false;
        }
        for vertex in corners {
            let Some(point) = self.vertex(vertex) else { return false };
            out.push(Corner { point: point.as_dvec3(), vertex });
        }
        (0..MAX_CORNERS).step_by(STRIDE).all(|step| {
            let found = SupportMap::support(self, tilted(dir, step)).feature;
            out.corners().iter().any(|corner| corner.vertex == found)
        })
    }
}
