//! Finds the points of each hull of a pack: the point sets of the source, or their convex parts.

use std::borrow::Cow;

use hullmap_geometry::PointSet;
use rayon::prelude::*;

use crate::deadline::monotonic;
use crate::decompose::{Cover, decompose_in};
use crate::progress::Stage;

/// The points of one hull: a point set of the source, or a convex part of it.
#[derive(Clone, Debug)]
pub struct Part<'a> {
    /// The points.
    pub points: Cow<'a, PointSet>,
    /// Index among the parts of its set; 0 for a whole set.
    pub index: u32,
    /// Index of the set in the source.
    pub set: usize,
    /// Seconds in which the parts of the set were found.
    pub seconds: f64,
}

/// The points of each hull that point sets become: the sets themselves, or their convex parts.
///
/// Without a time limit, the result depends on the sets and the parameters only, so that `bake
/// verify` can compute it again. With a limit, sets are decomposed one after the other, so that
/// each has its time on all threads. `stage` shows the progress.
///
/// # Errors
/// A point set has no hull; the error names the first one.
pub fn parts<'a>(point_sets: &'a [PointSet], cover: Option<&Cover>, stage: Stage) -> Result<Vec<Part<'a>>, String> {
    let steps = stage.steps(point_sets.len());
    // Stages of sets that are cut at the same time do not add up.
    let inner = if point_sets.len() == 1 { stage } else { stage.from_to(0.0, 0.0) };
    let cut = |points: &PointSet| {
        let start = monotonic();
        let found = cover.map_or(Ok(None), |cover| decompose_in(points, cover, inner));
        steps.take();
        (found, (monotonic() - start).as_secs_f64())
    };
    let is_timed = cover.is_some_and(|cover| cover.seconds.is_some());
    let cut: Vec<_> =
        if is_timed { point_sets.iter().map(cut).collect() } else { point_sets.par_iter().map(cut).collect() };
    let mut parts = Vec::with_capacity(point_sets.len());
    for (set, ((found, seconds), points)) in cut.into_iter().zip(point_sets).enumerate() {
        match found.map_err(|error| format!("hull {}: {error}", points.name))? {
            None => parts.push(Part { points: Cow::Borrowed(points), index: 0, set, seconds }),
            Some(found) => {
                let part = |(index, points)| Part { points: Cow::Owned(points), index, set, seconds };
                parts.extend((0..).zip(found).map(part));
            }
        }
    }
    Ok(parts)
}
