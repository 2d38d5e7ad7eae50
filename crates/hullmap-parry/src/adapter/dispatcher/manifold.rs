//! The contact manifold of one pair: computed by hullmap, and written to parry's. `persistent.rs`
//! calls it; manifolds on surfaces are in `surface_manifold.rs`.
//!
//! # Steps
//! 1. If the shapes have barely moved, keep the points (parry's coherence test).
//! 2. Update hullmap's manifold of the pair.
//! 3. Correct its normal if it comes from an internal edge of a compound.
//! 4. Write its points. A point that hullmap kept retains the data that the engine stored in it.

use hullmap::compound::seams::{self, Side, Union};
use hullmap::glam::DVec3;
use hullmap::manifold::FeatureId;
use hullmap::shapes::HalfSpace;
use hullmap::{Cache, Manifold, ManifoldSettings, Prediction};

use super::super::convert::{double, real, wide};
use super::super::parry::math::{Pose, Real};
use super::super::parry::query::details::NormalConstraints;
use super::super::parry::query::{
    ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher as _, TrackedContact, Unsupported,
};
use super::super::parry::shape::{PackedFeatureId, Shape};
use super::super::polygon::{edge_id, face_id, vertex_id};
use super::BakedHull;
use super::pair::{HullPair, Placement, hull_pair, placement};
use super::pieces::Convex;

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

/// A pair that has one manifold, which hullmap computes.
pub(super) enum Touching<'s> {
    Hull(HullPair<'s>),
    /// A is the half-space.
    HalfSpace(HalfSpace, &'s BakedHull, Placement),
}

impl<'s> Touching<'s> {
    /// `None` if hullmap does not solve the pair.
    #[inline]
    pub(super) fn new(pos12: &Pose, shape1: &'s dyn Shape, shape2: &'s dyn Shape) -> Option<Self> {
        if let Some(pair) = hull_pair(pos12, shape1, shape2) {
            return Some(Self::Hull(pair));
        }
        let (plane, body, flipped) = match (shape1.as_halfspace(), shape2.as_halfspace()) {
            (Some(plane), _) => (plane, shape2, false),
            (None, Some(plane)) => (plane, shape1, true),
            (None, None) => return None,
        };
        let plane = HalfSpace::new(wide(plane.normal), 0.0).ok()?;
        Some(Self::HalfSpace(plane, body.as_shape()?, placement(pos12, flipped)?))
    }

    /// Updates the points of `out`. `kept` and `cache` belong to the pair; if empty, a few more
    /// support calls are needed. `parts` are the compounds of parry's two shapes, if they are
    /// parts.
    pub(super) fn update<M, C: Default + Copy>(
        &self,
        prediction: Real,
        (kept, cache): (&mut Manifold, &mut Cache),
        parts: [Option<PartOf<'_>>; 2],
        out: &mut ContactManifold<M, C>,
    ) {
        stamp(kept, out);
        let settings = settings(prediction);
        let (Self::Hull(HullPair { placement, .. }) | Self::HalfSpace(_, _, placement)) = self;
        let parts = if placement.flipped { [parts[1], parts[0]] } else { parts };
        match self {
            // Two branches, so that the code for two hulls has no virtual calls.
            Self::Hull(HullPair { a, b: Convex::Hull(b), .. }) => {
                update_welded((*a, *b, placement.b_in_a), parts, (kept, cache), &settings);
            }
            Self::Hull(HullPair { a, b: Convex::Primitive(b), .. }) => {
                update_welded((*a, b.shape(), placement.b_in_a), parts, (kept, cache), &settings);
            }
            Self::HalfSpace(plane, hull, _) => {
                kept.update_half_space_from((plane, *hull, placement.b_in_a), &settings, out.points.is_empty());
            }
        }
        write(kept, placement, out);
    }

    /// The normal of the last step, from A to B in A's frame.
    fn axis<M, C>(&self, last: &ContactManifold<M, C>) -> DVec3 {
        let (Self::Hull(HullPair { placement, .. }) | Self::HalfSpace(_, _, placement)) = self;
        placement.axis(wide(last.local_n1))
    }
}

/// Updates a manifold, and corrects its normal at internal edges of the compounds in `parts`.
fn update_welded<B: hullmap::Shape + ?Sized>(
    (a, b, b_in_a): (&BakedHull, &B, hullmap::Pose),
    [of_a, of_b]: [Option<PartOf<'_>>; 2],
    (kept, cache): (&mut Manifold, &mut Cache),
    settings: &ManifoldSettings,
) {
    let before = (of_a.is_some() || of_b.is_some()).then(|| kept.clone());
    kept.update(a, b, b_in_a, settings, cache);
    if let Some(before) = before {
        let (side_a, side_b) = (Side { shape: a, union: of_a }, Side { shape: b, union: of_b });
        seams::weld(kept, &before, &side_a, &side_b, b_in_a, settings);
    }
}

/// parry's method of this name. `parts` are the compounds of the two shapes, if they are parts.
/// Parts have no [`Memory`](super::memory::Memory): each update starts only from the last normal.
pub(super) fn contact_manifold_convex_convex<M, C>(
    pos12: &Pose,
    [shape1, shape2]: [&dyn Shape; 2],
    constraints: [Option<&dyn NormalConstraints>; 2],
    prediction: Real,
    parts: [Option<PartOf<'_>>; 2],
    manifold: &mut ContactManifold<M, C>,
) -> Result<(), Unsupported>
where
    M: Default + Clone + Send + Sync,
    C: Default + Copy + Send + Sync,
{
    // Constraints change the normal between the contact and the features; only parry does that.
    if let [None, None] = constraints
        && let Some(pair) = Touching::new(pos12, shape1, shape2)
    {
        if !barely_moved(pos12, manifold) {
            let cache = &mut Cache::from_axis(pair.axis(manifold));
            pair.update(prediction, (&mut Manifold::new(), cache), parts, manifold);
        }
        return Ok(());
    }
    let [constraints1, constraints2] = constraints;
    DefaultQueryDispatcher.contact_manifold_convex_convex(
        pos12,
        shape1,
        shape2,
        constraints1,
        constraints2,
        prediction,
        manifold,
    )
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
