//! The parts of a compound near a body, found once: for the search of the parts that touch, and for
//! all tests of normals.
//!
//! The correction of normals needs the parts at a point several times, and all points are near one
//! body. A list of the parts near the body replaces the descents from the root.

#![forbid(unsafe_code)]

use std::cell::OnceCell;

use arrayvec::ArrayVec;
use glam::DVec3;

use super::parts::Parts;
use super::seams::{self, Neighbour, SIGHT_REACH, Union};
use crate::manifold::ManifoldSettings;
use crate::pose::Pose;
use crate::shapes::triangle::is_beside_box;
use crate::shapes::{Shape, Triangle};
use crate::support::SupportMap;

/// Maximum number of parts in the list. With more, each test descends from the root.
const MAX_NEAR: usize = 48;

/// Allowance for the rounding error of distances, relative to them and to the coordinates.
const ROUNDING: f64 = 1e-12;

/// Triangles near a body: the memory of a [`NearParts`].
pub(super) struct NearTriangles {
    found: ArrayVec<NearTriangle, MAX_NEAR>,
    /// Whether these are all.
    is_whole: bool,
}

#[derive(Clone, Copy)]
struct NearTriangle {
    index: usize,
    corners: [DVec3; 3],
}

impl NearTriangles {
    pub(super) fn new() -> Self {
        Self { found: ArrayVec::new(), is_whole: true }
    }

    /// The triangles whose boxes overlap a box, or may.
    fn in_box(&self, bounds: [DVec3; 2]) -> impl Iterator<Item = &NearTriangle> {
        self.found.iter().filter(move |near| !is_beside_box(near.corners, bounds))
    }
}

/// A compound as a [`Union`], with a list of the parts near a body.
pub(super) struct NearParts<'p, P: ?Sized> {
    parts: &'p P,
    /// Corners of a box around the body and the prediction, along the axes of the compound.
    bounds: [DVec3; 2],
    /// Width of the margin around that box in which parts are listed.
    margin: f64,
    /// All triangles near the body, if the parts are triangles.
    triangles: Option<&'p NearTriangles>,
    /// Number of boxes compared for them.
    boxes: Option<u32>,
    balls: OnceCell<Balls>,
}

/// Parts near the body that are not listed as triangles.
struct Balls {
    found: ArrayVec<Ball, MAX_NEAR>,
    /// Whether these are all.
    is_whole: bool,
}

#[derive(Clone, Copy)]
struct Ball {
    index: usize,
    center: DVec3,
    radius: f64,
}

impl<'p, P: Parts + ?Sized> NearParts<'p, P> {
    /// For the manifolds of `parts` and a body `b` at `b_in_a`.
    pub(super) fn new<B: Parts + ?Sized>(
        (parts, b, b_in_a): (&'p P, &B, Pose),
        settings: &ManifoldSettings,
        triangles: &'p mut NearTriangles,
    ) -> Self {
        let single = b.part(0).filter(|_| b.part_count() == 1);
        let ([low, high], radius) = single.map_or_else(
            || {
                let (center, radius) = b.nodes().ball();
                let (center, reach) = (b_in_a.transform_point(center), DVec3::splat(radius));
                ([center - reach, center + reach], radius)
            },
            |part| {
                let bounds = part.bounds_under(b_in_a);
                ([bounds.min, bounds.max], part.outer_radius())
            },
        );
        let prediction = settings.prediction.length(radius);
        let reach = DVec3::splat(prediction) + ROUNDING * (low.abs().max(high.abs()) + DVec3::splat(prediction));
        let (bounds, margin) = ([low - reach, high + reach], SIGHT_REACH * prediction);
        let wide = [bounds[0] - DVec3::splat(margin), bounds[1] + DVec3::splat(margin)];
        let found = parts.any_in_box(wide, &mut |index, corners| {
            triangles.is_whole = triangles.found.try_push(NearTriangle { index, corners }).is_ok();
            !triangles.is_whole
        });
        let is_whole = found.is_some() && triangles.is_whole;
        let triangles = Some(&*triangles).filter(|_| is_whole);
        Self { parts, bounds, margin, triangles, boxes: found.map(|(_, boxes)| boxes), balls: OnceCell::new() }
    }

    /// Calls `visit` with all triangles near the body, and maybe with others, and returns the
    /// number of boxes compared; `None`, and no calls, if the parts are not triangles that are
    /// searched by a box.
    pub(super) fn triangles(&self, visit: &mut dyn FnMut(usize, [DVec3; 3])) -> Option<u32> {
        let boxes = self.boxes?;
        if let Some(triangles) = self.triangles {
            triangles.in_box(self.bounds).for_each(|near| visit(near.index, near.corners));
            return Some(boxes);
        }
        let found = self.parts.any_in_box(self.bounds, &mut |index, corners| {
            visit(index, corners);
            false
        });
        found.map(|(_, more)| boxes.saturating_add(more))
    }

    fn balls(&self) -> &Balls {
        self.balls.get_or_init(|| {
            let mut balls = Balls { found: ArrayVec::new(), is_whole: true };
            let [low, high] = self.bounds;
            let reach = 0.5 * (high - low).length() * (1.0 + ROUNDING) + self.margin;
            seams::union_of(self.parts).any_near((low + high) * 0.5, reach, &mut |near| {
                let (center, radius) = (near.shape.interior_point(), near.shape.outer_radius());
                balls.is_whole = balls.found.try_push(Ball { index: near.index, center, radius }).is_ok();
                !balls.is_whole
            });
            balls
        })
    }

    /// Whether all parts within `reach` of a point are listed, if any are.
    fn is_listed(&self, point: DVec3, reach: f64) -> bool {
        let reach = DVec3::splat(reach - self.margin) + ROUNDING * point.abs();
        // NaN takes the failing branch.
        (point - reach).cmpge(self.bounds[0]).all() && (point + reach).cmple(self.bounds[1]).all()
    }
}

impl<P: Parts + ?Sized> Union for NearParts<'_, P> {
    fn any_near(&self, point: DVec3, reach: f64, test: &mut dyn FnMut(Neighbour<'_>) -> bool) -> bool {
        let mut meets = |index: usize, shape: &dyn Shape| test(Neighbour { index, shape, place: Pose::IDENTITY });
        let is_listed = self.is_listed(point, reach);
        if let Some(triangles) = self.triangles.filter(|_| is_listed) {
            let side = DVec3::splat(reach) + ROUNDING * (point.abs() + DVec3::splat(reach));
            return triangles
                .in_box([point - side, point + side])
                .any(|near| meets(near.index, &Triangle::of_finite(near.corners)));
        }
        if self.boxes.is_some() || !is_listed || !self.balls().is_whole {
            return seams::union_of(self.parts).any_near(point, reach, test);
        }
        let slack = ROUNDING * point.abs().element_sum();
        let found = &self.balls().found;
        found
            .iter()
            // Written so that a NaN would not skip the part.
            .filter(|ball| !(ball.center.distance(point) > (ball.radius + reach) * (1.0 + ROUNDING) + slack))
            .any(|ball| self.parts.part(ball.index).is_some_and(|part| meets(ball.index, &part)))
    }

    fn face_towards(&self, part: usize, dir: DVec3) -> Option<DVec3> {
        seams::union_of(self.parts).face_towards(part, dir)
    }

    fn faces_near(&self, part: usize, vertex: u32, visit: &mut dyn FnMut(DVec3, DVec3)) {
        seams::union_of(self.parts).faces_near(part, vertex, visit);
    }
}
