//! The parts of a compound near a body, found once for all tests of its normals.
//!
//! The correction of normals asks several times for the parts at a point, and all points are near
//! one body. A list of the parts near the body replaces the descents from the root.

#![forbid(unsafe_code)]

use std::cell::OnceCell;

use glam::DVec3;

use super::parts::Parts;
use super::seams::{self, Neighbour, Union};
use crate::pose::Pose;

/// Maximum number of parts in the list. With more, each test descends from the root.
const MAX_NEAR: usize = 48;

/// Allowance for the rounding error of distances, relative to them and to the coordinates.
const ROUNDING: f64 = 1e-12;

/// A compound as a [`Union`], with a list of the parts near a ball.
pub(super) struct NearParts<'p, P: ?Sized> {
    parts: &'p P,
    center: DVec3,
    radius: f64,
    list: OnceCell<List>,
}

/// Parts near the ball.
struct List {
    found: [Entry; MAX_NEAR],
    count: usize,
    /// Whether these are all.
    is_whole: bool,
}

/// A part, and a ball around it.
#[derive(Clone, Copy)]
struct Entry {
    index: usize,
    center: DVec3,
    radius: f64,
}

impl<'p, P: Parts + ?Sized> NearParts<'p, P> {
    /// For tests within `radius` of `center`, in the frame of the compound.
    pub(super) fn new(parts: &'p P, center: DVec3, radius: f64) -> Self {
        Self { parts, center, radius, list: OnceCell::new() }
    }

    fn list(&self) -> &List {
        self.list.get_or_init(|| {
            let empty = Entry { index: 0, center: DVec3::ZERO, radius: 0.0 };
            let mut list = List { found: [empty; MAX_NEAR], count: 0, is_whole: true };
            seams::of(self.parts).any_near(self.center, self.radius, &mut |near| {
                let Some(free) = list.found.get_mut(list.count) else {
                    list.is_whole = false;
                    return true;
                };
                let (center, radius) = (near.shape.interior_point(), near.shape.outer_radius());
                *free = Entry { index: near.index, center, radius };
                list.count += 1;
                false
            });
            list
        })
    }
}

impl<P: Parts + ?Sized> Union for NearParts<'_, P> {
    fn any_near(&self, point: DVec3, reach: f64, test: &mut dyn FnMut(Neighbour<'_>) -> bool) -> bool {
        let is_within = point.distance(self.center) + reach <= self.radius * (1.0 - ROUNDING);
        if !is_within || !self.list().is_whole {
            return seams::of(self.parts).any_near(point, reach, test);
        }
        let slack = ROUNDING * point.abs().element_sum();
        let found = self.list().found.iter().take(self.list().count);
        found
            // Written so that a NaN would not skip the part.
            .filter(|entry| !(entry.center.distance(point) > (entry.radius + reach) * (1.0 + ROUNDING) + slack))
            .any(|entry| {
                self.parts
                    .part(entry.index)
                    .is_some_and(|part| test(Neighbour { index: entry.index, shape: &part, place: Pose::IDENTITY }))
            })
    }

    fn face_towards(&self, part: usize, dir: DVec3) -> Option<DVec3> {
        seams::of(self.parts).face_towards(part, dir)
    }

    fn faces_near(&self, part: usize, vertex: u32, visit: &mut dyn FnMut(DVec3, DVec3)) {
        seams::of(self.parts).faces_near(part, vertex, visit);
    }
}
