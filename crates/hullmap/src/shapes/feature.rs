//! Feature of a shape that faces a direction: the vertex, edge or face that a contact manifold
//! clips.
//!
//! For any support mapping, [`ring`] finds the feature with support queries in directions that are
//! tilted slightly to all sides. Shapes with known faces return them directly, which is faster and
//! more accurate.
//!
//! # Reference
//! Kenwright, section 3 ("contact manifold generation"). Tilted directions: Olsen, "Convex
//! collision with Xenocollide", Game Programming Gems 7, which builds the manifold from perturbed
//! contacts.
//!
//! # Deviations
//! - The contact is not perturbed and solved again. Each tilted direction takes one support query
//!   per shape.
//! - Faces within [`TILT`] of the direction are merged. A flat cap of an imported mesh is rarely
//!   flat to the last digit of f32, so its hull has a sliver face at the support vertex. A body
//!   would tip over on a manifold of that sliver.

#![forbid(unsafe_code)]

use crate::support::{SupportMap, SupportPoint};
use crate::vector::{perpendicular, unit};
use arrayvec::ArrayVec;
use glam::DVec3;

/// Maximum number of corners of a [`Feature`]. A face with more corners is represented by its
/// extreme corners in this many directions, and a disc by this many points of its rim, which
/// deviates from their polygon by half a per cent of the radius.
pub const MAX_CORNERS: usize = 32;

/// Tangent of the maximum angle (2.3°) at which a face counts as facing a direction.
///
/// Large compared with the deviation of a flat face through rounding of its coordinates to f32
/// (1e-7), and with the rotation of a resting body in one step; small compared with the 5° to 10°
/// between faces of a coarse round mesh. Decision 13 compares values.
pub const TILT: f64 = 0.04;

/// The reach with which [`Shape::feature_within`] is [`Shape::feature`]: no height is within it.
///
/// [`Shape::feature`]: super::Shape::feature
/// [`Shape::feature_within`]: super::Shape::feature_within
pub(crate) const NO_REACH: f64 = f64::NEG_INFINITY;

/// Sines of 0, 1/32, … 8/32 of a full turn. A table, because the last digits of `sin` depend on the
/// platform.
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
#[expect(clippy::indexing_slicing, reason = "`rest` is a remainder modulo 8, and the table has nine entries")]
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
    /// Position, in the shape's local frame.
    pub point: DVec3,
    /// Id of the vertex, the same in every query.
    pub vertex: u32,
}

/// Maximum number of corners that a manifold keeps of a feature of merged faces.
const MAX_KEPT: usize = 12;

/// The face of a hull that a feature was made of. A manifold keeps it, so that the hull need not
/// look again for the faces around it. [`Feature::clear`] leaves it.
///
/// Even if it is of another hull, the corners are vertices, and a flat feature is a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KeptFace {
    /// Which face: `u32::MAX` for none.
    face: u32,
    /// How far below its plane corners of merged faces may be: a length. NaN if no face beside it
    /// can be merged into it.
    flat: f64,
    /// The vertices of merged faces.
    vertices: [u32; MAX_KEPT],
    /// How many they are; none if the face is the feature.
    count: u8,
}

impl KeptFace {
    /// No face.
    pub(crate) const NONE: Self = Self { face: u32::MAX, flat: 0.0, vertices: [0; MAX_KEPT], count: 0 };

    /// A face that is the feature alone, however large `flat` is.
    pub(crate) fn lone(face: u32) -> Self {
        Self { face, flat: f64::NAN, ..Self::NONE }
    }

    /// The face, if it is the feature alone.
    pub(crate) fn lone_face(&self) -> Option<u32> {
        self.flat.is_nan().then_some(self.face)
    }

    /// A face with all around it that is at most `flat` below its plane: `feature`.
    pub(crate) fn merged(face: u32, flat: f64, feature: &Feature) -> Self {
        let corners = feature.corners();
        let mut kept = Self { face, flat, ..Self::NONE };
        match corners.len() {
            0..3 => return Self::NONE,
            // A flat one is the face itself.
            _ if feature.is_flat() => {}
            count if count > MAX_KEPT => return Self::NONE,
            count => {
                kept.count = count as u8;
                kept.vertices.iter_mut().zip(corners).for_each(|(vertex, corner)| *vertex = corner.vertex);
            }
        }
        kept
    }

    /// The vertices of the feature of a face, or none if it is the face itself; `None` if it is not
    /// kept.
    pub(crate) fn vertices(&self, face: u32, flat: f64) -> Option<&[u32]> {
        let vertices = self.vertices.get(..usize::from(self.count))?;
        (self.face == face && self.flat == flat).then_some(vertices)
    }
}

impl Default for KeptFace {
    fn default() -> Self {
        Self::NONE
    }
}

/// The vertex (one corner), edge (two corners) or face (three or more) that faces a direction.
///
/// The corners of a face are in order around it, clockwise or counter-clockwise. A *reduced*
/// feature has a few corners of a larger one: see [`Shape::reduced_feature_within`]. A *flat*
/// feature lies on the surface of the shape, between its corners as well; of any other one, only
/// the corners do.
///
/// [`Shape::reduced_feature_within`]: super::Shape::reduced_feature_within
#[derive(Clone, Debug, Default)]
pub struct Feature {
    corners: ArrayVec<Corner, MAX_CORNERS>,
    is_reduced: bool,
    is_flat: bool,
    is_rounded: bool,
    /// See [`Self::fall`].
    fall: f64,
    /// The face that a hull made the feature of.
    pub(crate) kept: KeptFace,
}

impl Feature {
    /// A feature without corners.
    pub const fn new() -> Self {
        Self {
            corners: ArrayVec::new_const(),
            is_reduced: false,
            is_flat: false,
            is_rounded: false,
            fall: 0.0,
            kept: KeptFace::NONE,
        }
    }

    /// Whether corners were left out to save time.
    pub fn is_reduced(&self) -> bool {
        self.is_reduced
    }

    /// Records that corners were left out, until the feature is cleared.
    pub fn set_reduced(&mut self) {
        self.is_reduced = true;
    }

    /// Whether the whole feature lies on the surface of the shape.
    pub fn is_flat(&self) -> bool {
        self.is_flat
    }

    /// Records that the whole feature lies on the surface of the shape, until the feature is
    /// cleared. A manifold then needs no rays to find the surface between the corners.
    pub fn set_flat(&mut self) {
        self.is_flat = true;
    }

    /// Whether each corner lies on the surface.
    pub(crate) fn has_exact_corners(&self) -> bool {
        self.is_flat || !self.is_rounded
    }

    /// Records that the corners were moved outward along one normal, which need not be theirs.
    pub(crate) fn set_rounded(&mut self) {
        self.is_rounded = true;
    }

    /// How steeply the shape falls away from a vertex or an edge: the tangent of the greatest angle
    /// by which a direction may be tilted so that its support point is still a corner of the
    /// feature. The shape is lower than the highest corner by at least this multiple of the
    /// distance from the vertex, or from the line of the edge. 0 if it is not known.
    pub(crate) fn fall(&self) -> f64 {
        self.fall
    }

    /// See [`Self::fall`].
    pub(crate) fn set_fall(&mut self, fall: f64) {
        self.fall = fall;
    }

    /// Forgets that the feature is flat.
    pub(crate) fn set_curved(&mut self) {
        self.is_flat = false;
    }

    /// Forgets that corners were left out: whatever a shape returns as its whole feature is final.
    pub(crate) fn set_whole(&mut self) {
        self.is_reduced = false;
    }

    /// The corners, in order around the feature.
    pub fn corners(&self) -> &[Corner] {
        &self.corners
    }

    /// The corners, mutable.
    pub fn corners_mut(&mut self) -> &mut [Corner] {
        &mut self.corners
    }

    /// Removes all corners.
    pub fn clear(&mut self) {
        self.corners.clear();
        (self.is_reduced, self.is_flat, self.is_rounded, self.fall) = (false, false, false, 0.0);
    }

    /// Keeps the corners that satisfy `keep`, in order.
    pub(crate) fn retain(&mut self, keep: impl Fn(&Corner) -> bool) {
        self.corners.retain(|corner| keep(corner));
    }

    /// Adds a corner. If there are [`MAX_CORNERS`] already, the new one is dropped.
    pub fn push(&mut self, corner: Corner) {
        let _ = self.corners.try_push(corner);
    }
}

/// Writes the feature of `shape` that faces `dir` to `out`, using support queries alone.
///
/// The corners are the distinct support points in [`MAX_CORNERS`] directions that are tilted from
/// `dir` by [`TILT`], in order around `dir`. `dir` is in the shape's local frame and need not be of
/// unit length.
///
/// # Complexity
/// 8 support queries for a vertex, at most 12 for an edge, and at most [`MAX_CORNERS`] for a face.
/// If two directions have the same support point, every direction between them has it too, and none
/// of these is queried.
pub fn ring<S: SupportMap + ?Sized>(shape: &S, dir: DVec3, out: &mut Feature) {
    let cone = Cone::new(dir, TILT);
    refine(shape, &cone, coarse_ring(shape, &cone), out);
}

/// Support points in eight directions that are tilted from `dir` to all sides, by the angle whose
/// tangent is `tilt`.
pub fn tilted<S: SupportMap + ?Sized>(shape: &S, dir: DVec3, tilt: f64) -> [SupportPoint; COARSE] {
    coarse_ring(shape, &Cone::new(dir, tilt))
}

/// The support points of [`tilted`] whose direction is tilted to the side of `toward`.
pub(crate) fn tilted_toward<S: SupportMap + ?Sized>(
    shape: &S,
    dir: DVec3,
    tilt: f64,
    toward: DVec3,
) -> impl Iterator<Item = SupportPoint> {
    let cone = Cone::new(dir, tilt);
    (0..COARSE).filter_map(move |i| {
        let tilted = cone.tilted(i * STRIDE);
        ((tilted - cone.n).dot(toward) > 0.0).then(|| shape.support_point(tilted))
    })
}

/// Support points in every fourth direction of the cone.
pub(crate) fn coarse_ring<S: SupportMap + ?Sized>(shape: &S, cone: &Cone) -> [SupportPoint; COARSE] {
    std::array::from_fn(|i| shape.support_point(cone.tilted(i * STRIDE)))
}

/// Second stage of [`ring`]: queries the directions between two neighbouring directions of `coarse`
/// that have different support points.
#[expect(clippy::indexing_slicing, reason = "the index is taken modulo the number of coarse directions")]
pub(crate) fn refine<S: SupportMap + ?Sized>(
    shape: &S,
    cone: &Cone,
    coarse: [SupportPoint; COARSE],
    out: &mut Feature,
) {
    out.clear();
    for (i, start) in coarse.iter().enumerate() {
        let end = &coarse[(i + 1) % COARSE];
        push_new(start, out);
        if start.point == end.point {
            continue;
        }
        let first = i * STRIDE;
        let middle = shape.support_point(cone.tilted(first + STRIDE / 2));
        for (step, from, to) in [(1, start, &middle), (3, &middle, end)] {
            if from.point != to.point {
                push_new(&shape.support_point(cone.tilted(first + step)), out);
            }
            if step == 1 {
                push_new(&middle, out);
            }
        }
    }
    if let [first, .., last] = out.corners()
        && first.point == last.point
    {
        out.corners.pop();
    }
}

/// Number of directions in the first stage of [`ring`].
pub(crate) const COARSE: usize = 8;
/// Steps of the ring between two of them.
const STRIDE: usize = MAX_CORNERS / COARSE;

/// Adds a support point, unless it equals the last one.
fn push_new(support: &SupportPoint, out: &mut Feature) {
    if out.corners().last().is_none_or(|last| last.point != support.point) {
        out.push(Corner { point: support.point, vertex: support.feature });
    }
}

/// Directions tilted from a direction to all sides, by an angle of the same tangent.
pub(crate) struct Cone {
    n: DVec3,
    x: DVec3,
    y: DVec3,
}

impl Cone {
    /// The directions tilted from `dir` by the angle whose tangent is `tilt`.
    pub(crate) fn new(dir: DVec3, tilt: f64) -> Self {
        let n = unit(dir).unwrap_or(DVec3::X);
        let side = perpendicular(n);
        Self { n, x: side * tilt, y: n.cross(side) * tilt }
    }

    /// The direction tilted toward the side at `step`/32 of a full turn.
    pub(crate) fn tilted(&self, step: usize) -> DVec3 {
        let (cosine, sine) = turn(step);
        self.n + self.x * cosine + self.y * sine
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_holds_sines() {
        for step in 0..32 {
            let angle = step as f64 / 32.0 * std::f64::consts::TAU;
            let (cosine, sine) = turn(step);
            assert!((cosine - angle.cos()).abs() < 1e-15 && (sine - angle.sin()).abs() < 1e-15, "{step}");
        }
    }

    /// Convex hull of a list of points, without knowledge of its faces.
    struct Corners(Vec<DVec3>);

    impl SupportMap for Corners {
        fn support_point(&self, dir: DVec3) -> SupportPoint {
            let best = (0..self.0.len()).max_by(|a, b| self.0[*a].dot(dir).total_cmp(&self.0[*b].dot(dir))).unwrap();
            SupportPoint { point: self.0[best], feature: best as u32 }
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
    fn ring_finds_face_edge_and_vertex() {
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
            let distinct = out.corners().windows(2).all(|pair| pair[0].vertex != pair[1].vertex);
            assert!(distinct, "{:?}", out.corners());
        }
    }
}
