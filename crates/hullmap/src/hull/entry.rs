//! Where a ray enters a hull, found by a walk over its faces.
//!
//! # Steps
//! Seen along the ray, the faces that look towards its origin tile the outline of the hull.
//! 1. Start from such a face at the given vertex.
//! 2. If the ray is outside of an edge of the face, go on to the face beyond the edge. If that face
//!    looks away, the ray misses the hull.
//! 3. A face that has the ray inside all of its edges is the one that the ray enters.
//!
//! The hull is below the plane of each face, so the walk may end where that is too low.
//!
//! Each step leads to a face whose plane is higher over the ray, so no face is visited twice.
//! (Edelsbrunner, "An acyclicity theorem for cell complexes in d dimensions", 1990.)

#![forbid(unsafe_code)]

use glam::{DVec3, Vec3};

use super::Hull;
use crate::solver::Ray;

/// Maximum number of edges to look at. A walk that is longer costs more than a ray cast by support
/// queries. It also bounds the walk where rounding errors lead it in a circle.
const MAX_ENTRY_EDGES: usize = 64;

/// Minimum cosine of the angle between the ray and the normal of a face whose plane gives the
/// answer. Steeper planes magnify the rounding errors of normals.
const LEAST_COSINE: f64 = 0.1;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Walk {
    /// The ray enters the hull at this t.
    Entry(f64),
    Miss,
    /// The walk is too long, ends at a steep face, or cannot start.
    Open,
}

/// A face, as a ray sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Seen {
    /// It looks the other way.
    Away,
    /// Its plane is farther than the ray need go.
    TooFar,
    Near,
}

impl Hull<'_> {
    /// Walks from the faces at the vertex `near` to the one that `ray` enters. The ray starts
    /// outside of the hull, so far that all faces that it may enter look towards its origin. A
    /// ray that enters beyond `until` may count as a miss.
    pub(super) fn walk(&self, ray: &Ray, near: u32, until: f64) -> Walk {
        let up = -ray.direction();
        let mut seen = self.faces_at(near).take(MAX_ENTRY_EDGES).map(|face| (face, self.seen(face, ray, until)));
        let Some((mut face, first)) = seen.find(|(_, seen)| *seen != Seen::Away) else { return Walk::Open };
        if first == Seen::TooFar {
            return Walk::Miss;
        }
        let mut edges = 0;
        // The edge by which the walk came: a rounding error must not lead it back.
        let mut entered = None;
        loop {
            edges += self.face_run(face).len();
            if edges > MAX_ENTRY_EDGES {
                return Walk::Open;
            }
            let Some((v, w)) = self.edge_beside(face, ray.origin(), up, entered) else { break };
            // The face on the other side has the edge in the other direction.
            let Some(next) = self.face_left_of(w, v) else { return Walk::Open };
            if self.seen(next, ray, until) != Seen::Near {
                return Walk::Miss;
            }
            (face, entered) = (next, Some((w, v)));
        }
        self.entry_of_face(face, ray).map_or(Walk::Open, Walk::Entry)
    }

    /// How `ray` sees a face. It meets the plane of a face that is too far beyond `until`.
    fn seen(&self, face: u32, ray: &Ray, until: f64) -> Seen {
        let Some([p, q, r]) = self.corners_apart(face) else { return Seen::Away };
        let normal = (q - p).cross(r - p);
        let along = normal.dot(ray.direction());
        // NaN takes the first branch, and then the last one.
        if !(along < 0.0) {
            Seen::Away
        } else if normal.dot(p - ray.origin()) < until * along {
            Seen::TooFar
        } else {
            Seen::Near
        }
    }

    /// An edge of `face`, other than `entered`, outside of which the line through `point` along
    /// `up` is.
    fn edge_beside(&self, face: u32, point: DVec3, up: DVec3, entered: Option<(u32, u32)>) -> Option<(u32, u32)> {
        let corners = self.face_run(face);
        let mut from = corners.last()?.to_native();
        let mut start = self.vertex(from)?.as_dvec3() - point;
        for to in corners {
            let to = to.to_native();
            let end = self.vertex(to)?.as_dvec3() - point;
            if end.cross(start).dot(up) > 0.0 && entered != Some((from, to)) {
                return Some((from, to));
            }
            (from, start) = (to, end);
        }
        None
    }

    /// The t at which `ray` crosses the plane of `face`, between the t of its corners; `None` if
    /// the face is steep.
    fn entry_of_face(&self, face: u32, ray: &Ray) -> Option<f64> {
        let direction = ray.direction();
        let length_squared = direction.length_squared();
        let normal = self.face_normal(face)?;
        let cosine = -normal.dot(direction) / length_squared.sqrt();
        // NaN takes the failing branch.
        if !(cosine >= LEAST_COSINE) {
            return None;
        }
        let corners = || self.face(face).filter_map(|v| self.vertex(v)).map(Vec3::as_dvec3);
        let along = |corner: DVec3| (corner - ray.origin()).dot(direction) / length_squared;
        let (least, most) = corners()
            .map(along)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), t| (least.min(t), most.max(t)));
        let t = (corners().next()? - ray.origin()).dot(normal) / direction.dot(normal);
        // The plane of a sliver is off, but the surface is between its corners.
        Some(t.min(most).max(least))
    }
}
