//! The feature of a hull that faces a direction: a face, an edge or a vertex, found through the
//! direction index.
//!
//! # Steps
//! 1. Support queries in eight directions, tilted to all sides. If all answers are the same vertex,
//!    the feature is that vertex.
//! 2. Of the faces at the support vertex, the one whose normal is closest to the direction. If all
//!    eight answers are its corners, its corners are the feature, exactly.
//! 3. Otherwise the support points in [`MAX_CORNERS`] tilted directions. This happens for an edge,
//!    for several faces (f32 can break a flat cap into slivers), and for a face with more corners
//!    than a feature holds.
//!
//! No step scans all faces, and the cost does not grow with the number of a face's corners beyond
//! [`MAX_CORNERS`].

#![forbid(unsafe_code)]

use super::Hull;
use crate::shapes::feature::{COARSE, coarse_ring, refine};
use crate::shapes::{Corner, Feature, MAX_CORNERS, Shape, TILT};
use crate::support::SupportPoint;
use crate::vector::unit;
use glam::DVec3;

impl Shape for Hull<'_> {
    /// A baked face, or an edge, or a vertex.
    ///
    /// # Complexity
    /// For a vertex, 8 support queries. For a face of at most [`MAX_CORNERS`] corners, 9 support
    /// queries and one normal for each face at the support vertex. Otherwise at most 33 support
    /// queries.
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        let around = coarse_ring(self, dir);
        if !self.baked_face(dir, &around, out) {
            refine(self, dir, around, out);
        }
    }
}

impl Hull<'_> {
    /// Puts the corners of the face towards `dir` into `out`. Returns false if the support points
    /// `around` the direction are not all corners of that face.
    fn baked_face(&self, dir: DVec3, around: &[SupportPoint; COARSE], out: &mut Feature) -> bool {
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
