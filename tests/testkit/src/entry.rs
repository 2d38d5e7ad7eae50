//! Where a moving hull enters another, by all facets of their Minkowski difference.
//!
//! # Reference
//! Cyrus, Beck 1978: a line is clipped by every facet's plane. [`depth`](crate::depth) finds the
//! facets.

use std::ops::ControlFlow;

use glam::DVec3;

use crate::{
    depth::{axes, facets},
    polytope::Polytope,
    reach::way_out,
};

/// The times at which a moving hull enters and leaves another, each as an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// Lower and upper bound of the time of entry. Negative if it is before the start.
    pub enter: [f64; 2],
    /// Lower and upper bound of the time of exit.
    pub exit: [f64; 2],
}

impl Passage {
    /// The passage through a set without planes.
    pub const UNBOUNDED: Self = Self { enter: [f64::NEG_INFINITY; 2], exit: [f64::INFINITY; 2] };

    /// Clips by a plane: the path is inside where `along · t ≤ offset`. `slack` is the error of the
    /// offset, and the plane is ignored if it is parallel to the path and the path is behind it.
    pub fn clip(&mut self, along: f64, offset: f64, slack: f64) {
        let [least, most] = [offset - slack, offset + slack];
        if along < 0.0 {
            self.enter[0] = self.enter[0].max(most / along);
            self.enter[1] = self.enter[1].max(least / along);
        } else if along > 0.0 {
            self.exit[0] = self.exit[0].min(least / along);
            self.exit[1] = self.exit[1].min(most / along);
        } else {
            if most < 0.0 {
                self.exit[1] = f64::NEG_INFINITY;
            }
            if least < 0.0 {
                self.exit[0] = f64::NEG_INFINITY;
            }
        }
    }

    /// Whether the hulls certainly share a point at a time from 0 to `limit`.
    pub fn certainly_hits(&self, limit: f64) -> bool {
        self.enter[1].max(0.0) <= self.exit[0].min(limit)
    }

    /// Whether they certainly share no point.
    pub fn certainly_misses(&self, limit: f64) -> bool {
        self.enter[0].max(0.0) > self.exit[1].min(limit)
    }
}

/// The passage of `b`, which starts in A's frame as given and moves by `velocity`, through `a`.
/// `slack` is the error of a support value.
pub fn passage(a: &Polytope, b: &Polytope, velocity: DVec3, slack: f64) -> Passage {
    let mut passage = Passage::UNBOUNDED;
    facets(a, b, |n, _| {
        passage.clip(n.dot(velocity), way_out(a, b, n), slack);
        ControlFlow::Continue(())
    });
    passage
}

/// The passage of the hulls of a few points, which may be flat: along all [`axes`] except for
/// sides that are nearly parallel.
pub fn passage_by_points(a: &[DVec3], b: &[DVec3], velocity: DVec3, slack: f64) -> Passage {
    let mut passage = Passage::UNBOUNDED;
    axes(a, b, 1e-9, |n| [n, -n].into_iter().for_each(|n| passage.clip(n.dot(velocity), way_out(a, b, n), slack)));
    passage
}

/// The passage of a point, which starts at `origin`, through the planes of `hull`. `slack` is the
/// error of a plane's offset.
pub fn passage_of_point(hull: &Polytope, offsets: &[f64], origin: DVec3, direction: DVec3, slack: f64) -> Passage {
    let mut passage = Passage::UNBOUNDED;
    for (n, offset) in hull.normals.iter().zip(offsets) {
        passage.clip(n.dot(direction), offset - n.dot(origin), slack);
    }
    passage
}
