//! The contact on the face of the last one: proven again by one support query.
//!
//! # Steps
//! 1. Recall the corners of the face under the new pose.
//! 2. The support point along its normal bounds the depth from above. It has to be in the plane.
//! 3. The origin's foot has to be inside the face, at least ρ from its border. The disc of this
//!    radius around the foot and the ball around the interior points are in the difference. If each
//!    direction has a point of one of them that is as far as the plane, no plane is nearer.
//!
//! docs/contributors/intervals.md, section 12, proves the bound. The face is a triangle of the
//! polytope of EPA, or three of the sums of vertices with which SAT has made the witness points.

#![forbid(unsafe_code)]

use glam::DVec3;

use super::answer::deeper;
use super::barycentric::blend;
use super::bound::Bound;
use super::cache::Cache;
use super::minkowski::{Minkowski, Point};
use crate::support::SupportMap;

/// Depths up to this many rounding errors are left to EPA, which distinguishes touching from
/// penetrating.
const TINY_ROUNDINGS: f64 = 32.0;

/// Depth up to which a face is kept, relative to the outer radii. Few faces of deeper contacts
/// could be proven.
const SHALLOW: f64 = 0.05;

/// Keeps the face with these corners, on which a contact of this depth was found, unless it is too
/// deep. A face that is kept takes the place of the axis.
pub(super) fn keep_face<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    (depth, corners): (f64, [[u32; 2]; 3]),
    cache: &mut Cache,
) {
    if depth <= SHALLOW * m.outer_radius() {
        cache.forget_axis();
        cache.keep_face(corners);
    } else {
        cache.forget_face();
    }
}

/// A depth that was found on the face of the last contact.
pub(super) struct Found {
    pub(super) bound: Bound,
    pub(super) lower: f64,
    /// The features of a corner.
    pub(super) features: [u32; 2],
    /// Lower bound of the depth along other normals.
    pub(super) others: f64,
}

/// The depth on the face of the last contact; `None` if it is not proven.
///
/// # Complexity
/// One support query. No allocation.
pub(super) fn depth_on_kept_face<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    corners: [[u32; 2]; 3],
) -> Option<Found> {
    // 1. and 3.
    let KeptFace { face, normal, offset, weights, delta } = KeptFace::recall(m, corners)?;
    // 2.
    let upper = m.point(normal).w.dot(normal).max(offset);
    // NaN takes the failing branch.
    if !(upper - offset <= m.rounding_error()) {
        return None;
    }
    let (point_a, point_b) = (blend(&weights, face.map(|v| v.a)), blend(&weights, face.map(|v| v.b())));
    Some(Found {
        bound: Bound { upper, normal, point_a, point_b },
        lower: offset,
        features: Point::first_features(face.iter().map(|point| point.features)),
        others: upper + 4.0 * delta,
    })
}

/// A face whose disc and whose ball prove that no plane is nearer to the origin.
struct KeptFace {
    face: [Point; 3],
    /// Outward, of unit length.
    normal: DVec3,
    offset: f64,
    /// Weights of the corners at the origin's foot.
    weights: [f64; 3],
    delta: f64,
}

impl KeptFace {
    #[inline(always)]
    fn recall<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &Minkowski<'_, A, B>,
        [p, q, r]: [[u32; 2]; 3],
    ) -> Option<Self> {
        let face = [m.recall(p)?, m.recall(q)?, m.recall(r)?];
        let [p, q, r] = face.map(|corner| corner.w);
        let across = (q - p).cross(r - p);
        let normal = across / across.length().copysign(across.dot(p));
        // The least offset of a corner, for rounding.
        let offset = p.dot(normal).min(q.dot(normal)).min(r.dot(normal));
        let rounding = m.rounding_error();
        // NaN takes the failing branch, here and below.
        if !(offset > TINY_ROUNDINGS * rounding) {
            return None;
        }
        let delta = deeper([offset - m.noise(), offset + 2.0 * rounding], m.outer_radius());
        let (weights, border) = foot([p, q, r], normal, offset)?;
        let is_proven = border > 0.0 && no_plane_is_nearer(m, normal, offset, border, delta);
        is_proven.then_some(Self { face, normal, offset, weights, delta })
    }
}

/// The weights of the corners at the origin's foot on the plane of the face, and how far the border
/// is from there. `None` if the foot is outside.
fn foot(corners: [DVec3; 3], normal: DVec3, offset: f64) -> Option<([f64; 3], f64)> {
    let foot = normal * offset;
    let [p, q, r] = corners.map(|corner| corner - foot);
    let sides = [(q, r), (r, p), (p, q)];
    let areas = sides.map(|(s, t)| s.cross(t).dot(normal));
    let sum = areas[0] + areas[1] + areas[2];
    let weights = areas.map(|area| area / sum);
    if !weights.iter().all(|weight| *weight >= 0.0) {
        return None;
    }
    let mut border = f64::INFINITY;
    for ((s, t), area) in sides.into_iter().zip(areas) {
        border = border.min(area * area / s.distance_squared(t));
    }
    Some((weights, border.sqrt()))
}

/// Whether each unit vector at an angle φ from `normal` has a support value of at least
/// d + δ (1 − cos φ), where d is the offset of the plane.
fn no_plane_is_nearer<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    normal: DVec3,
    offset: f64,
    border: f64,
    delta: f64,
) -> bool {
    let (height, center) = (offset + delta, m.center_point().w);
    // The disc is enough up to this angle.
    let (square, border_sq) = (height * height, border * border);
    let sum = square + border_sq;
    let (cosine, sine) = ((square - border_sq) / sum, 2.0 * height * border / sum);
    // Beyond it, the ball has to be.
    let along = center.dot(normal);
    let (length, aside) = (center.length(), (center - normal * along).length());
    let reach = if cosine * length <= -along { along * cosine - aside * sine } else { -length };
    m.inner_radius() + reach >= offset + 2.0 * delta
}

#[cfg(test)]
mod tests {
    use ::shapes::{families, rng::SplitMix64};
    use glam::{DQuat, DVec3};
    use hullmap_testkit::packs;

    use super::*;
    use crate::{Pack, Pose, Settings, Shape, contact};

    const SEED: u64 = 20_261_129;

    /// Contacts of two copies of a shape after small steps and two large ones, beside contacts
    /// without a cache. Returns how many were proven by one support query, and how many were not.
    fn judge<S: Shape>(shape: &S, rng: &mut SplitMix64) -> [usize; 2] {
        let mut counts = [0, 0];
        let size = shape.outer_radius();
        for path in 0..200 {
            let mut cache = Cache::new();
            let turn = DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize();
            let out = DVec3::from_array(rng.direction());
            let at = |distance: f64, turn: DQuat| Pose::new(out * distance, turn).unwrap();
            let touches =
                |distance: f64| contact(shape, shape, at(distance, turn), &Settings::default(), &mut Cache::new()).hit;
            let (mut near, mut far) = (0.0, 3.0 * size);
            for _ in 0..30 {
                let middle = 0.5 * (near + far);
                if touches(middle) { near = middle } else { far = middle }
            }
            for frame in 0..8 {
                // From 0.3 % deep in small steps, then to any depth.
                let depth = if frame < 6 { 0.003 * size } else { rng.between(0.0, near) };
                let step = DQuat::from_axis_angle(DVec3::from_array(rng.direction()), 1e-3 * rng.between(-1.0, 1.0));
                let pose = at(near - depth, step * turn);
                let cold = contact(shape, shape, pose, &Settings::default(), &mut Cache::new());
                let warm = contact(shape, shape, pose, &Settings::default(), &mut cache);
                assert_eq!(warm.hit, cold.hit, "seed {SEED}, path {path}, frame {frame}");
                let both = [warm.depth_lower.max(cold.depth_lower), warm.depth_upper.min(cold.depth_upper)];
                assert!(both[0] <= both[1], "seed {SEED}, path {path}, frame {frame}: {warm:?} {cold:?}");
                let is_kept = warm.hit && warm.support_calls == 1;
                counts[usize::from(!is_kept)] += usize::from(frame > 0);
            }
        }
        counts
    }

    #[test]
    fn contacts_on_a_kept_face_are_those_without_a_cache() {
        let mut rng = SplitMix64::new(SEED);
        for half in [[1.0; 3], [1.0, 1.0, 0.02], [1.0, 0.01, 0.02]] {
            let signs =
                |corner: usize| [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { -half[axis] } else { half[axis] });
            let corners: Vec<[f32; 3]> = (0..8).map(signs).collect();
            let pack = Pack::from_bytes(&packs::tree_bytes(&corners)).unwrap();
            let [kept, others] = judge(&pack.hull(0).unwrap(), &mut rng);
            println!("{half:?}: {kept} of {}", kept + others);
            assert!(kept > 200 && others > 200, "{half:?}: {kept} of {}", kept + others);
        }
        for count in [8, 32, 200] {
            let pack = Pack::from_bytes(&packs::tree_bytes(&families::sphere(count, 1))).unwrap();
            let [kept, others] = judge(&pack.hull(0).unwrap(), &mut rng);
            assert!(kept > 600 && others > 200, "{count}: {kept} of {}", kept + others);
        }
    }
}
