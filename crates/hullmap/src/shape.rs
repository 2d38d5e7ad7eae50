//! What a shape can tell beyond its support mapping: the feature that faces a direction.
//!
//! A contact manifold needs a *feature*: the vertex, edge or face of the shape that faces the contact. Any support
//! mapping can tell it, by being asked in directions tilted a little to all sides ([`ring`]); shapes that know their
//! faces answer better and sooner.
//!
//! # Reference
//! Kenwright, section 3 ("contact manifold generation"). Tilted directions: Olsen, "Convex collision with Xenocollide",
//! Game Programming Gems 7, whose manifold is built from disturbed contacts.
//!
//! # Deviations
//! - The contact itself is not disturbed and solved again: only the two support mappings are asked, once a direction.
//! - Faces within [`TILT`] of the direction count as one. A flat cap of an imported mesh is seldom flat to the last digit of
//!   f32, so that its hull has a sliver of a face at the support vertex; a manifold on that sliver would let the body
//!   tip over.

#![forbid(unsafe_code)]

use crate::minkowski::{perpendicular, unit};
use crate::{Support, SupportMap};
use glam::DVec3;

/// Most corners of a [`Feature`]. A face with more is told by its extreme corners in as many directions; a disc by as
/// many points of its rim, between which it bulges by half a per cent of its radius.
pub const MAX_CORNERS: usize = 32;

/// Tangent of the angle (1.15°) within which a face counts as facing a direction. Large against what f32 coordinates do to a
/// flat face (1e-7) and against how far a body turns in a step while it rests; small against the 5° to 10° between facets of a
/// coarse round mesh.
pub const TILT: f64 = 0.02;

/// Sines of 0, 1/32, … 8/32 of a full turn. Written out, since libraries of different systems compute sines that differ.
const SINES: [f64; 9] = [
    0.0,
    0.19509032201612828,
    0.3826834323650898,
    0.5555702330196022,
    core::f64::consts::FRAC_1_SQRT_2,
    0.8314696123025452,
    0.9238795325112867,
    0.9807852804032304,
    1.0,
];

/// Cosine and sine of `step`/32 of a full turn.
#[expect(clippy::indexing_slicing, reason = "`rest` is a remainder by 8, and there are nine sines")]
pub(crate) fn turn(step: usize) -> (f64, f64) {
    let sine = |step: usize| {
        let (quarter, rest) = (step / 8 % 4, step % 8);
        match quarter {
            0 => SINES[rest],
            1 => SINES[8 - rest],
            2 => -SINES[rest],
            _ => -SINES[8 - rest],
        }
    };
    (sine(step + 8), sine(step))
}

/// A corner of a [`Feature`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Corner {
    /// Where it is, in the shape's local frame.
    pub point: DVec3,
    /// Its number: equal numbers mean the same vertex of the shape, from one query to the next.
    pub vertex: u32,
}

/// The vertex (one corner), edge (two) or face (three or more, in order around it, either way) that faces a direction.
#[derive(Clone, Debug)]
pub struct Feature {
    corners: [Corner; MAX_CORNERS],
    count: usize,
}

impl Feature {
    /// No corners yet.
    pub const fn new() -> Self {
        Self { corners: [Corner { point: DVec3::ZERO, vertex: 0 }; MAX_CORNERS], count: 0 }
    }

    /// The corners, in order.
    #[expect(clippy::indexing_slicing, reason = "`push` counts only corners that it has found room for")]
    pub fn corners(&self) -> &[Corner] {
        &self.corners[..self.count]
    }

    /// The corners, to be moved.
    #[expect(clippy::indexing_slicing, reason = "`push` counts only corners that it has found room for")]
    pub fn corners_mut(&mut self) -> &mut [Corner] {
        &mut self.corners[..self.count]
    }

    /// Takes all corners away.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Adds a corner; one past [`MAX_CORNERS`] is left out.
    pub fn push(&mut self, corner: Corner) {
        if let Some(free) = self.corners.get_mut(self.count) {
            *free = corner;
            self.count += 1;
        }
    }
}

impl Default for Feature {
    fn default() -> Self {
        Self::new()
    }
}

/// A convex shape with features.
///
/// Implement it for a support mapping of your own by `impl Shape for Mine {}`.
///
/// # Examples
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Cuboid;
/// use hullmap::{Feature, Shape};
///
/// let plate = Cuboid::new(DVec3::new(2.0, 2.0, 0.1))?;
/// let mut feature = Feature::new();
/// plate.feature(DVec3::Z, &mut feature);
/// assert_eq!(feature.corners().len(), 4);
/// plate.feature(DVec3::new(1.0, 0.0, 1.0), &mut feature);
/// assert_eq!(feature.corners().len(), 2);
/// # Ok::<(), hullmap::shapes::ShapeError>(())
/// ```
pub trait Shape: SupportMap {
    /// The feature that faces `dir` (local frame, any length but zero), into `out`.
    ///
    /// Faces and edges count as facing `dir` within [`TILT`]. The default asks the support mapping all around, by [`ring`].
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        ring(self, dir, out);
    }
}

/// The feature of any support mapping that faces `dir`: its support points in [`MAX_CORNERS`] directions tilted by [`TILT`], in
/// order around `dir`.
///
/// Directions between two that have the same support point are not asked: they have it too.
///
/// # Complexity
/// 8 support queries for a vertex, at most 12 for an edge, and [`MAX_CORNERS`] at most.
pub fn ring<S: SupportMap + ?Sized>(shape: &S, dir: DVec3, out: &mut Feature) {
    refine(shape, dir, coarse_ring(shape, dir), out);
}

/// Support points in every fourth of the directions.
pub(crate) fn coarse_ring<S: SupportMap + ?Sized>(shape: &S, dir: DVec3) -> [Support; COARSE] {
    let around = Around::new(dir);
    std::array::from_fn(|i| shape.support(around.tilted(i * STRIDE)))
}

/// The feature that `coarse` directions are on, by all directions.
#[expect(clippy::indexing_slicing, reason = "taken modulo the number of coarse directions")]
pub(crate) fn refine<S: SupportMap + ?Sized>(shape: &S, dir: DVec3, coarse: [Support; COARSE], out: &mut Feature) {
    let around = Around::new(dir);
    out.clear();
    for (i, start) in coarse.iter().enumerate() {
        let end = &coarse[(i + 1) % COARSE];
        push_new(start, out);
        if start.point == end.point {
            continue;
        }
        let first = i * STRIDE;
        let middle = shape.support(around.tilted(first + STRIDE / 2));
        for (step, from, to) in [(1, start, &middle), (3, &middle, end)] {
            if from.point != to.point {
                push_new(&shape.support(around.tilted(first + step)), out);
            }
            if step == 1 {
                push_new(&middle, out);
            }
        }
    }
    if let [first, .., last] = out.corners()
        && first.point == last.point
    {
        out.count -= 1;
    }
}

/// Directions of a ring that are asked first, and how many steps there are between them.
const COARSE: usize = 8;
const STRIDE: usize = MAX_CORNERS / COARSE;

/// Adds a support point, unless it is the last one.
fn push_new(support: &Support, out: &mut Feature) {
    if out.corners().last().is_none_or(|last| last.point != support.point) {
        out.push(Corner { point: support.point, vertex: support.feature });
    }
}

/// Directions around one.
struct Around {
    n: DVec3,
    x: DVec3,
    y: DVec3,
}

impl Around {
    fn new(dir: DVec3) -> Self {
        let n = unit(dir).unwrap_or(DVec3::X);
        let side = perpendicular(n);
        Self { n, x: side * TILT, y: n.cross(side) * TILT }
    }

    /// The direction tilted by [`TILT`] toward `step`/32 of a turn around it.
    fn tilted(&self, step: usize) -> DVec3 {
        let (cosine, sine) = turn(step);
        self.n + self.x * cosine + self.y * sine
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_that_of_sines() {
        for step in 0..32 {
            let angle = step as f64 / 32.0 * std::f64::consts::TAU;
            let (cosine, sine) = turn(step);
            assert!((cosine - angle.cos()).abs() < 1e-15 && (sine - angle.sin()).abs() < 1e-15, "{step}");
        }
    }

    /// A box by its corners, numbered: what the ring sees of it.
    struct Corners(Vec<DVec3>);

    impl SupportMap for Corners {
        fn support(&self, dir: DVec3) -> Support {
            let best = (0..self.0.len()).max_by(|a, b| self.0[*a].dot(dir).total_cmp(&self.0[*b].dot(dir))).unwrap();
            Support { point: self.0[best], feature: best as u32 }
        }
        fn interior_point(&self) -> DVec3 {
            DVec3::ZERO
        }
        fn inner_radius(&self) -> f64 {
            0.0
        }
        fn outer_radius(&self) -> f64 {
            2.0
        }
    }

    #[test]
    fn the_ring_finds_face_edge_and_vertex() {
        let sign = |i: usize, bit: usize| if i & bit == 0 { -1.0 } else { 1.0 };
        let cube = Corners((0..8).map(|i| DVec3::new(sign(i, 1), sign(i, 2), sign(i, 4))).collect());
        let mut out = Feature::new();
        for (dir, count) in [
            (DVec3::Z, 4),
            (DVec3::new(1e-3, -2e-3, -7.0), 4),
            (DVec3::new(1.0, 1.0, 0.0), 2),
            (DVec3::new(1.0, -1.0, 1.0), 1),
        ] {
            ring(&cube, dir, &mut out);
            assert_eq!(out.corners().len(), count, "{dir}");
            let turns = out.corners().windows(2).all(|pair| pair[0].vertex != pair[1].vertex);
            assert!(turns, "{:?}", out.corners());
        }
    }
}
