//! Measures how the parts of each object fit its mesh: uncovered surface, protrusion, how they fit
//! together, and whether an engine can use them.

use std::borrow::Cow;
use std::sync::Arc;

use crate::advice::usability::{Flaw, ObjectMeasures, PartMeasures, doubts, excess, thickness};
use crate::advice::{self, Remark};
use crate::baked_hull::BakedHull;
use crate::deadline::{Deadline, is_over};
use crate::decompose::{Cover, vertices_of_one_part};
use crate::fit::{Fit, Solid, fits_around, mesh_mass};
use crate::hull::Hull;
use crate::primitive::{PrimitiveLimits, primitives};
use crate::progress::Stage;
use hullmap_format::SolidKind;
use hullmap_geometry::PointSet;

use super::cut::Part;
use super::estimates::{DecomposedObject, PartsEstimates};

/// Findings about the parts of all objects.
#[derive(Debug, Default)]
pub struct Measured {
    /// Remarks on them.
    pub remarks: Vec<Remark>,
    /// A summary of each object that has parts.
    pub objects: Vec<DecomposedObject>,
}

/// Counts and measures the parts of each point set, and records both in their hulls. The hulls of a
/// set are consecutive, in the order of the sets.
///
/// A set without triangles has no surface to measure; its hull is no part. With `has_primitives`,
/// each part gets a primitive, if one is found. `stage` shows the progress.
pub fn parts(
    point_sets: &[PointSet],
    parts: &[Part],
    hulls: &mut [BakedHull],
    (cover, has_primitives): (&Cover, bool),
    stage: Stage,
) -> Measured {
    let mut measured = Measured::default();
    let mut start = 0;
    let allows_one_part = cover.max_parts == Some(1);
    let steps = stage.steps(point_sets.len());
    for (set, points) in point_sets.iter().enumerate() {
        let count = parts[start..].iter().take_while(|part| part.set == set).count();
        let own = &mut hulls[start..start + count];
        start += count;
        let name = &points.name;
        let is_whole = !parts.get(start - count).is_some_and(is_cut) || allows_one_part;
        if count == 1 && is_whole {
            let why = if allows_one_part { "at most one part is allowed" } else { "it is convex or thin" };
            measured.remarks.push(if points.triangles.is_empty() {
                advice::without_faces(name)
            } else {
                Remark::note(why, name, format!("{name}: not decomposed, because {why}"))
            });
        }
        let is_divided = count > 1 || !is_whole;
        if !points.triangles.is_empty() {
            // With a maximum number of parts, the limit is not proven.
            let limit = cover.max_parts.is_none().then(|| cover.max_error.resolve(points.diagonal()));
            let spent = parts.get(start - count).map_or(0.0, |part| part.seconds);
            let deadline = cover.seconds.map(|seconds| Deadline::after((seconds - spent).max(0.0)));
            let (estimates, holes) = record(points, own, limit, Some(cover), is_divided, deadline);
            measured.remarks.extend(advice::openings(name, holes));
            if has_primitives {
                measured.remarks.extend(record_primitives(points, own, cover, deadline));
            }
            let words = judge(name, points.diagonal(), own, Some(cover), estimates, &mut measured);
            if is_divided {
                let is_free = cover.max_parts.is_none() && cover.seconds.is_none() && own.len() > 1;
                let alone = is_free.then(|| vertices_of_one_part(points, &cover.solid_of(points), cover)).flatten();
                measured.remarks.extend(alone.map(|count| advice::divided_by_vertices(name, count, cover)));
                measured.remarks.push(about_parts(name, own, words.as_deref()));
                measured.remarks.extend(advice::many_walls(name, own.len(), parts_fit(own), cover));
            }
        }
        steps.take();
    }
    measured
}

/// Whether the decomposition made a part. Otherwise its points are the points of its mesh.
pub fn is_cut(part: &Part) -> bool {
    matches!(part.points, Cow::Owned(_))
}

/// Counts and measures hulls that are the collision parts of a mesh in the same file. There is one
/// hull for each point set, and the parts of one mesh are consecutive.
pub fn collision_parts(point_sets: &[PointSet], hulls: &mut [BakedHull]) -> Measured {
    let mut measured = Measured::default();
    let mut start = 0;
    for own in point_sets.chunk_by(stand_for_one) {
        let hulls = &mut hulls[start..start + own.len()];
        start += own.len();
        let Some(mesh) = own.first().and_then(|points| points.stands_for.as_deref()) else { continue };
        let (estimates, _) = record(mesh, hulls, None, None, hulls.len() > 1, None);
        (0..).zip(hulls.iter_mut()).for_each(|(part, baked)| baked.part = part);
        let words = judge(&mesh.name, mesh.diagonal(), hulls, None, estimates, &mut measured);
        if hulls.len() > 1 {
            measured.remarks.push(about_parts(&hulls[0].name, hulls, words.as_deref()));
        }
    }
    measured
}

/// Whether two point sets are collision parts of one mesh.
pub fn stand_for_one(a: &PointSet, b: &PointSet) -> bool {
    a.stands_for.as_ref().zip(b.stands_for.as_ref()).is_some_and(|(a, b)| Arc::ptr_eq(a, b))
}

/// The solid from which protrusion counts. `cover` are the parameters of the parts, if known.
pub fn solid_of(mesh: &PointSet, cover: Option<&Cover>) -> Solid {
    cover.map_or_else(|| Solid::new(mesh), |cover| cover.solid_of(mesh))
}

fn about_parts(name: &str, own: &[BakedHull], estimates: Option<&str>) -> Remark {
    let size = own.iter().map(|baked| baked.hull.diameter).fold(0.0, f64::max);
    advice::parts(name, own.len(), parts_fit(own), size, estimates)
}

fn parts_fit(own: &[BakedHull]) -> Option<advice::PartsFit> {
    let fits: Option<Vec<Fit>> = own.iter().map(|baked| baked.fit).collect();
    fits.as_deref().map(advice::PartsFit::from_fits)
}

/// Counts and measures the parts of one mesh, and records both in their hulls, with the mass of the
/// mesh and the voids of its solid. `limit` is the proven protrusion, if any. Parts of a divided
/// mesh, with the parameters `cover`, are compared with each other. After the deadline, measures
/// are coarse. Also returns [`Solid::hole_share`].
fn record(
    mesh: &PointSet,
    own: &mut [BakedHull],
    limit: Option<f64>,
    cover: Option<&Cover>,
    is_divided: bool,
    deadline: Option<Deadline>,
) -> (Option<PartsEstimates>, f64) {
    let count = own.len() as u32;
    // A hull of the whole mesh has its mass already.
    if let Some(first) = own.first_mut().filter(|first| first.mesh_mass.is_none()) {
        first.mesh_mass = mesh_mass(mesh);
    }
    let volume = own.first().and_then(|first| first.mesh_mass).map(|mass| mass.volume);
    let hulls: Vec<&Hull> = own.iter().map(|baked| &baked.hull).collect();
    let solid = (!mesh.triangles.is_empty()).then(|| solid_of(mesh, cover));
    let fits = solid.as_ref().and_then(|solid| fits_around(solid, mesh, &hulls, limit, deadline));
    let holes = solid.as_ref().filter(|solid| solid.kind() == SolidKind::Closed).map_or(0.0, Solid::hole_share);
    let estimates =
        solid.filter(|_| is_divided).map(|solid| PartsEstimates::new(mesh, &solid, &hulls, volume, deadline).0);
    // Voids are recorded only for several parts.
    if let [first, _, ..] = own {
        first.voids = estimates.as_ref().and_then(|estimates| estimates.voids_share());
    }
    for (index, baked) in own.iter_mut().enumerate() {
        baked.part_count = count;
        baked.fit = fits.as_ref().and_then(|fits| fits.get(index)).copied();
    }
    (estimates, holes)
}

/// Returns a note on the number of primitives. They protrude by at most the maximum error or, with
/// a maximum number of parts, as much as the parts. There is no search after the deadline.
fn record_primitives(
    mesh: &PointSet,
    own: &mut [BakedHull],
    cover: &Cover,
    deadline: Option<Deadline>,
) -> Option<Remark> {
    let fits: Vec<Fit> = own.iter().filter_map(|baked| baked.fit).collect();
    if fits.len() < own.len() {
        return None;
    }
    let reached = fits.iter().map(|fit| fit.protrusion).fold(0.0, f64::max);
    let limit = if cover.max_parts.is_some() { reached } else { cover.max_error.resolve(mesh.diagonal()) };
    let hulls: Vec<&Hull> = own.iter().map(|baked| &baked.hull).collect();
    let limits = PrimitiveLimits { protrusion: limit, deadline };
    let found = if is_over(deadline) {
        vec![None; own.len()]
    } else {
        primitives(&solid_of(mesh, Some(cover)), mesh, &hulls, &fits, &limits)
    };
    let count = found.iter().flatten().count();
    own.iter_mut().zip(found).for_each(|(baked, primitive)| baked.primitive = primitive);
    Some(advice::primitives(&mesh.name, count, own.len(), is_over(deadline)))
}

/// Adds remarks on what an engine cannot use, and returns the estimates in words. `estimates` are
/// for a divided mesh.
fn judge(
    name: &str,
    diagonal: f64,
    own: &[BakedHull],
    cover: Option<&Cover>,
    estimates: Option<PartsEstimates>,
    measured: &mut Measured,
) -> Option<String> {
    let of_part = |baked: &BakedHull| (baked.mass.volume, baked.mass.surface_area);
    let parts: Vec<PartMeasures> = own
        .iter()
        .map(|baked| {
            let (volume, area) = of_part(baked);
            let protrusion = baked.fit.map(|fit| fit.protrusion);
            PartMeasures { name: &baked.name, thickness: thickness(volume, area), protrusion }
        })
        .collect();
    let fit = own.first().and_then(|baked| baked.fit);
    let object = ObjectMeasures {
        name,
        diagonal,
        solid: fit.map(|fit| fit.solid),
        uncovered: fit.map_or(0.0, |fit| fit.uncovered),
        overlap: estimates.and_then(|estimates| estimates.overlap),
        overlap_error: estimates.and_then(|estimates| estimates.overlap_error).unwrap_or(0.0),
        parts: &parts,
        is_cut: estimates.is_some(),
        cover,
    };
    let doubts = doubts(&object);
    measured.remarks.extend(excess(&object).filter(|remark| !remark.is_warning));
    // Another remark states what the parts leave uncovered.
    measured
        .remarks
        .extend(doubts.iter().filter(|doubt| doubt.flaw != Flaw::Uncovered).map(|doubt| doubt.remark.clone()));
    let estimates = estimates?;
    let symmetry = estimates.symmetry.map(|plane| plane.in_words());
    let words = estimates.looseness().map(|found| advice::estimates(&found, estimates.voids, symmetry.as_deref()));
    let outside = cover.zip(estimates.outside_hull);
    measured.remarks.extend(outside.and_then(|(cover, outside)| advice::bulge(name, outside, diagonal, cover)));
    let may_be_empty = estimates.voids.filter(|_| cover.is_some_and(|cover| cover.max_parts.is_none()));
    measured.remarks.extend(may_be_empty.and_then(|voids| advice::empty(name, voids)));
    measured.objects.push(DecomposedObject::new(&object, &doubts, estimates));
    words
}
