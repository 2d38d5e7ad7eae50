//! The contact manifold of one pair: computed by hullmap, and written to parry's. `persistent.rs`
//! calls it; manifolds on surfaces are in `surface_manifold.rs`.
//!
//! # Steps
//! 1. If the shapes have barely moved, keep the points (parry's coherence test).
//! 2. Update hullmap's manifold of the pair.
//! 3. Correct its normal if it comes from an internal edge of a compound.
//! 4. Write its points. A point that hullmap kept retains the data that the engine stored in it.

use hullmap::compound::seams::{self, Side, Union};
use hullmap::manifold::FeatureId;
use hullmap::shapes::HalfSpace;
use hullmap::{Cache, Manifold, ManifoldSettings, Prediction};

use super::super::convert::{double, real, wide};
use super::super::parry::math::{Pose, Real};
use super::super::parry::query::{ContactManifold, TrackedContact};
use super::super::parry::shape::{PackedFeatureId, Shape};
use super::super::polygon::{edge_id, face_id, vertex_id};
use super::BakedHull;
use super::pair::{HullPair, Placement, on_pair, pair, plane};

/// Cosine of the angle (1°) up to which shapes have barely turned, as in parry.
/// docs/contributors/decisions/0020-engines.md has the measurements.
const BARELY_TURNED: Real = 0.999_847_7;

/// Square of the distance (1 mm) up to which a point has barely moved, as in parry.
const BARELY_MOVED_SQ: Real = 1e-6;

/// Whether the shapes have barely moved, so that the points of `manifold` stay, with updated
/// distances.
pub(super) fn barely_moved<M, C: Default + Copy>(pos12: &Pose, manifold: &mut ContactManifold<M, C>) -> bool {
    manifold.try_update_contacts_eps(pos12, BARELY_TURNED, BARELY_MOVED_SQ)
}

pub(super) type PartOf<'u> = (&'u dyn Union, usize, hullmap::Pose);

/// `kept` and `cache` belong to the pair; if empty, a few more support calls are needed. `parts`
/// are the compounds of parry's two shapes, if they are parts.
pub(super) fn update<M, C: Default + Copy>(
    (pair, placement): &(HullPair<'_>, Placement),
    prediction: Real,
    (kept, cache): (&mut Manifold, &mut Cache),
    parts: [Option<PartOf<'_>>; 2],
    out: &mut ContactManifold<M, C>,
) {
    stamp(kept, out);
    let (settings, b_in_a) = (settings(prediction), placement.b_in_a);
    let [of_a, of_b] = if placement.flipped { [parts[1], parts[0]] } else { parts };
    let before = (of_a.is_some() || of_b.is_some()).then(|| kept.clone());
    on_pair!(*pair, a, b => {
        kept.update(a, b, b_in_a, &settings, cache);
        if let Some(before) = before {
            let (side_a, side_b) = (Side { shape: a, union: of_a }, Side { shape: b, union: of_b });
            seams::weld(kept, &before, &side_a, &side_b, b_in_a, &settings);
        }
    });
    write(kept, placement, out);
}

pub(super) fn update_plane<M, C: Default + Copy>(
    (plane, hull, placement): &(HalfSpace, &BakedHull, Placement),
    prediction: Real,
    kept: &mut Manifold,
    out: &mut ContactManifold<M, C>,
) {
    stamp(kept, out);
    let is_new = out.points.is_empty();
    kept.update_half_space_from((plane, *hull, placement.b_in_a), &settings(prediction), is_new);
    write(kept, placement, out);
}

/// `parts` are the compounds of the two shapes. Returns false if hullmap does not solve the pair.
pub(super) fn solve<M, C: Default + Copy>(
    pos12: &Pose,
    shape1: &dyn Shape,
    shape2: &dyn Shape,
    prediction: Real,
    parts: [Option<PartOf<'_>>; 2],
    manifold: &mut ContactManifold<M, C>,
) -> bool {
    if let Some(found) = plane(pos12, shape1, shape2) {
        if !barely_moved(pos12, manifold) {
            update_plane(&found, prediction, &mut Manifold::new(), manifold);
        }
        return true;
    }
    let Some(found) = pair(pos12, shape1, shape2) else { return false };
    if !barely_moved(pos12, manifold) {
        let cache = &mut Cache::from_axis(found.1.axis(wide(manifold.local_n1)));
        update(&found, prediction, (&mut Manifold::new(), cache), parts, manifold);
    }
    true
}

pub(super) fn settings(prediction: Real) -> ManifoldSettings {
    ManifoldSettings { prediction: Prediction::Length(double(prediction)), ..ManifoldSettings::default() }
}

/// Marks the points of `kept` with their places in `out` from 1, or 0 if the engine changed them.
fn stamp<M, C>(kept: &mut Manifold, out: &ContactManifold<M, C>) {
    let is_ours = kept.points().len() == out.points.len();
    for (index, point) in kept.points_mut().iter_mut().enumerate() {
        point.user_data = if is_ours { index as u64 + 1 } else { 0 };
    }
}

/// Replaces the points of `out`. A new point takes the data of the old one that hullmap kept, or
/// else of the old one on the same features.
fn write<M, C: Default + Copy>(kept: &Manifold, placement: &Placement, out: &mut ContactManifold<M, C>) {
    let old = std::mem::take(&mut out.points);
    for point in kept.points() {
        let (on_a, on_b) = (packed(point.id.on_a()), packed(point.id.on_b()));
        let [fid1, fid2] = if placement.flipped { [on_b, on_a] } else { [on_a, on_b] };
        let [local_p1, local_p2] = placement.order(point.point_a, point.local_b);
        let mut contact = TrackedContact::new(local_p1, local_p2, fid1, fid2, real(-point.depth));
        let kept_from = (point.user_data as usize).checked_sub(1).and_then(|index| old.get(index));
        let same_features = || old.iter().find(|old| old.fid1 == fid1 && old.fid2 == fid2);
        if let Some(from) = kept_from.or_else(same_features) {
            contact.data = from.data;
        }
        out.points.push(contact);
    }
    if !out.points.is_empty() {
        [out.local_n1, out.local_n2] = placement.normals(kept.normal());
    }
}

pub(super) fn packed(feature: FeatureId) -> PackedFeatureId {
    match feature {
        FeatureId::Vertex(vertex) => vertex_id(vertex),
        FeatureId::Edge(start, end) => edge_id(start, end),
        FeatureId::Face => face_id(),
    }
}
