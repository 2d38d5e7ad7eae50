//! Measures how the parts of each object fit its mesh: what they leave uncovered, and how far they
//! protrude.

use std::borrow::Cow;
use std::sync::Arc;

use hullmap_bake::advice::{self, Remark};
use hullmap_bake::decompose::Cover;
use hullmap_bake::fit::{Fit, fits, mesh_mass};
use hullmap_bake::progress::Stage;
use hullmap_bake::{BakedHull, PointSet};

use crate::part::{Part, diagonal};

/// Ratio of a protrusion to the requested one up to which rounding may explain the difference.
const ROOM: f64 = 1.0 + 1e-6;

/// Counts and measures the parts of each point set, records both in their hulls, and returns
/// remarks on them. The hulls of a set are consecutive, in the order of the sets.
///
/// A set without triangles has no surface to measure; its hull is no part. `stage` shows the
/// progress.
pub fn parts(
    point_sets: &[PointSet],
    parts: &[Part],
    hulls: &mut [BakedHull],
    cover: &Cover,
    stage: Stage,
) -> Vec<Remark> {
    let mut remarks = Vec::new();
    let mut start = 0;
    let allows_one_part = cover.max_parts == Some(1);
    let steps = stage.steps(point_sets.len());
    for (set, points) in point_sets.iter().enumerate() {
        let count = parts[start..].iter().take_while(|part| part.set == set).count();
        let own = &mut hulls[start..start + count];
        start += count;
        let name = &points.name;
        let is_cut = |part: &Part| matches!(part.points, Cow::Owned(_));
        let is_whole = !parts.get(start - count).is_some_and(is_cut) || allows_one_part;
        if count == 1 && is_whole {
            let why = if allows_one_part { "at most one part is allowed" } else { "it is convex or thin" };
            remarks.push(if points.triangles.is_empty() {
                advice::without_faces(name)
            } else {
                Remark::note(why, name, format!("{name}: not decomposed, because {why}"))
            });
        }
        if !points.triangles.is_empty() {
            // With a maximum number of parts, the limit is not proven.
            let limit = cover.max_parts.is_none().then(|| cover.max_error.of(diagonal(points)));
            record(points, own, limit);
            remarks.extend(beyond(cover, points, own));
        }
        steps.take();
        if count > 1 || !is_whole {
            let size = own.iter().map(|baked| baked.hull.diameter).fold(0.0, f64::max);
            let fits: Option<Vec<Fit>> = own.iter().map(|baked| baked.fit).collect();
            remarks.push(advice::parts(name, count, fits.as_deref().map(advice::PartsFit::of), size));
        }
    }
    remarks
}

/// Counts and measures hulls that are the collision parts of a mesh in the same file, and returns
/// remarks on them. There is one hull for each point set, and the parts of one mesh are
/// consecutive.
pub fn collision_parts(point_sets: &[PointSet], hulls: &mut [BakedHull]) -> Vec<Remark> {
    let mut remarks = Vec::new();
    let mut start = 0;
    for own in point_sets.chunk_by(stand_for_one) {
        let hulls = &mut hulls[start..start + own.len()];
        start += own.len();
        let Some(mesh) = own.first().and_then(|points| points.stands_for.as_deref()) else { continue };
        record(mesh, hulls, None);
        (0..).zip(hulls.iter_mut()).for_each(|(part, baked)| baked.part = part);
        let size = hulls.iter().map(|baked| baked.hull.diameter).fold(0.0, f64::max);
        let fits: Option<Vec<Fit>> = hulls.iter().map(|baked| baked.fit).collect();
        if hulls.len() > 1 {
            remarks.push(advice::parts(&hulls[0].name, hulls.len(), fits.as_deref().map(advice::PartsFit::of), size));
        }
    }
    remarks
}

/// Whether two point sets are collision parts of one mesh.
pub fn stand_for_one(a: &PointSet, b: &PointSet) -> bool {
    a.stands_for.as_ref().zip(b.stands_for.as_ref()).is_some_and(|(a, b)| Arc::ptr_eq(a, b))
}

/// Remark about parts that protrude more than the maximum error of a cover.
fn beyond(cover: &Cover, points: &PointSet, own: &[BakedHull]) -> Option<Remark> {
    let fits: Option<Vec<Fit>> = own.iter().map(|baked| baked.fit).collect();
    let reached = advice::PartsFit::of(fits.as_deref().filter(|fits| !fits.is_empty())?).protrusion;
    let size = diagonal(points);
    let requested = cover.max_error.of(size);
    let is_timed = cover.seconds.is_some();
    (reached > requested * ROOM)
        .then(|| advice::beyond(&points.name, cover.max_parts, is_timed, [reached, requested, size]))
}

/// Counts and measures the parts of one mesh, and records both in their hulls, with the mass of the
/// mesh. `limit` is the protrusion that they were proven not to exceed; `None` if there is no
/// proof.
fn record(mesh: &PointSet, own: &mut [BakedHull], limit: Option<f64>) {
    let fits = fits(mesh, &own.iter().map(|baked| &baked.hull).collect::<Vec<_>>(), limit);
    let count = own.len() as u32;
    // A hull of the whole mesh has its mass already.
    if let Some(first) = own.first_mut().filter(|first| first.mesh_mass.is_none()) {
        first.mesh_mass = mesh_mass(mesh);
    }
    for (index, baked) in own.iter_mut().enumerate() {
        baked.part_count = count;
        baked.fit = fits.as_ref().and_then(|fits| fits.get(index)).copied();
    }
}
