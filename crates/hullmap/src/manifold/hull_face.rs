//! The feature of a hull that faces a direction: a baked face, found through the index.
//!
//! # Steps
//! 1. support queries in eight directions tilted to all sides; one answer to all means that a vertex faces the direction;
//! 2. the face towards the direction: of the faces at the support vertex the one whose normal is nearest. If all eight answers are
//!    corners of it, it is all that faces the direction, and its corners are the feature, exactly;
//! 3. else (an edge faces it; or several faces do, as where f32 has broken a flat cap into slivers; or the face has more corners
//!    than a feature holds) the support points in [`MAX_CORNERS`] tilted directions.
//!
//! So no face is ever scanned for, and a face of thousands of corners costs what one of a hundred does.

#![forbid(unsafe_code)]

use crate::minkowski::unit;
use crate::shape::{MAX_CORNERS, TILT, coarse_ring, refine};
use crate::{Corner, Feature, Hull, Shape, Support};
use glam::DVec3;

impl Shape for Hull<'_> {
    /// A baked face, or an edge, or a vertex.
    ///
    /// # Complexity
    /// 8 support queries for a vertex, 9 for a face of up to [`MAX_CORNERS`] corners and one normal for each face at its support
    /// vertex, at most 33 for others.
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        let around = coarse_ring(self, dir);
        if !self.baked_face(dir, &around, out) {
            refine(self, dir, around, out);
        }
    }
}

impl Hull<'_> {
    /// Puts the corners of the face towards `dir` into `out`; false if the support points `around` it are not all on it.
    fn baked_face(&self, dir: DVec3, around: &[Support], out: &mut Feature) -> bool {
        out.clear();
        if around.iter().all(|support| support.feature == around[0].feature) {
            return false;
        }
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
        around.iter().all(|support| out.corners().iter().any(|corner| corner.vertex == support.feature))
    }
}
