//! Contact manifolds over arrays of poses: one for each pose of convex shapes, and one for each
//! pair of parts that touch for packs.

use hullmap::compound::{CompoundManifolds, ManifoldCounts};
use hullmap::glam::DVec3;
use hullmap::manifold::{MAX_POINTS, Manifold, ManifoldPoint, ManifoldSettings, Prediction};
use hullmap::{Cache, Contact, Pose, Settings, SharedGeometry, Status};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns::{Columns, columns, put, put_all, put_fields, put_vector};
use crate::error::{ArrayError, PoseError};
use crate::pairs::Queried;
use crate::pose::PoseArrays;
use crate::solve::{Pair, code};
use crate::task::{Cut, Task, fill};
use crate::threads::Threads;

/// Maximum of `max_pairs`: memory of about 300 MB for each thread.
const MAX_PAIRS: usize = 1 << 16;

columns!(
    /// Answers of `manifold`: the contact, and up to four points.
    Manifolds, ManifoldRows {
        count: u8 = 1, normal: f64 = 3, point_a: f64 = 12, point_b: f64 = 12, local_b: f64 = 12, depth: f64 = 4,
        hit: bool = 1, status: u8 = 1,
    }
);

columns!(
    /// Answers of `manifolds`: `max_pairs` rows for each pose. The counts are in the first one.
    PairManifolds, PairRows {
        touching: u32 = 1, dropped: u32 = 1, parts: u32 = 2, count: u8 = 1, normal: f64 = 3, point_a: f64 = 12,
        point_b: f64 = 12, local_b: f64 = 12, depth: f64 = 4, status: u8 = 1,
    }
);

fn manifold_settings(settings: (f64, u32), prediction: Option<f64>) -> ManifoldSettings {
    ManifoldSettings {
        contact: Settings { tolerance: settings.0, max_iterations: settings.1 },
        prediction: prediction.map_or_else(Prediction::default, Prediction::Length),
    }
}

/// Writes the points of a manifold to row `$at`, and NaN for those that it does not have.
macro_rules! put_points {
    ($rows:expr, $at:expr, $manifold:expr) => {{
        let points = $manifold.map(Manifold::points).unwrap_or_default();
        put($rows.count, $at, u8::try_from(points.len()).unwrap_or(u8::MAX));
        for place in 0..MAX_POINTS {
            let point = points.get(place);
            let vector = |pick: fn(&ManifoldPoint) -> DVec3| point.map_or(DVec3::NAN, pick);
            let to = MAX_POINTS * $at + place;
            put_vector($rows.point_a, to, vector(|point| point.point_a));
            put_vector($rows.point_b, to, vector(|point| point.point_b));
            put_vector($rows.local_b, to, vector(|point| point.local_b));
            put($rows.depth, to, point.map_or(f64::NAN, |point| point.depth));
        }
    }};
}

/// Contact manifolds of convex shapes. `prediction` is a length, or relative to the smaller shape.
#[pyfunction]
#[pyo3(signature = (pairs, poses, settings, prediction, coherent, threads))]
pub fn manifold<'py>(
    py: Python<'py>,
    pairs: Queried<'py>,
    poses: PoseArrays<'py>,
    settings: (f64, u32),
    prediction: Option<f64>,
    coherent: bool,
    threads: Threads,
) -> PyResult<Bound<'py, PyDict>> {
    let settings = manifold_settings(settings, prediction);
    Task::new(&pairs, &poses, coherent, threads)?.solve::<Manifolds, _, _>(
        py,
        ("manifold", false),
        |_| Ok(|sides: Pair<'_>, pose: Pose, cache: &mut Cache| update(sides, pose, &settings, cache)),
        |_| None,
        |rows, at, found| {
            let Some((manifold, contact)) = found else { return };
            put_fields!(rows, at, contact; normal, hit);
            put(rows.status, at, code(manifold.status()));
            put_points!(rows, at, Some(manifold));
        },
    )
}

/// Contact manifolds of shapes of any kind: one for each pair of parts that touch.
#[pyfunction]
#[pyo3(signature = (pairs, poses, settings, prediction, max_pairs, coherent, threads))]
pub fn manifolds<'py>(
    py: Python<'py>,
    pairs: Queried<'py>,
    poses: PoseArrays<'py>,
    settings: (f64, u32),
    prediction: Option<f64>,
    max_pairs: usize,
    coherent: bool,
    threads: Threads,
) -> PyResult<Bound<'py, PyDict>> {
    if !(1..=MAX_PAIRS).contains(&max_pairs) {
        let message = format!("max_pairs must be from 1 to {MAX_PAIRS}, found {max_pairs}");
        return Err(ArrayError::new_err(message));
    }
    let settings = manifold_settings(settings, prediction);
    let task = Task::new(&pairs, &poses, coherent, threads)?;
    task.pairs.check("manifolds", true)?;
    let too_many = || PyMemoryError::new_err("not enough memory for all pairs of all poses: query fewer at a time");
    let count = task.count.checked_mul(max_pairs).ok_or_else(too_many)?;
    // More places than pairs of parts would never be used.
    let parts_of = |[a, b]: Pair<'_>| part_count(a).saturating_mul(part_count(b));
    let most = (0..task.pairs.len()).filter_map(|pair| task.pairs.sides(pair)).map(parts_of).max();
    let places = max_pairs.min(most.unwrap_or(1));
    let solve = |first: usize, count: usize, mut rows: PairRows<'_>| {
        let mut found = CompoundManifolds::new(places);
        for at in 0..count / max_pairs {
            let pose = first / max_pairs + at;
            // The memory of one pair is useless for the next.
            if !coherent || task.pairs.len() > 1 {
                found.clear();
            }
            let Some([a, b]) = task.pairs.sides(pose) else { continue };
            let b_in_a = task.poses.get(pose, task.pairs).map_err(|message| (pose, message))?;
            let counts = found.update(a, b, b_in_a, &settings);
            write(&mut rows, at * max_pairs, max_pairs, &found, counts);
        }
        Ok(())
    };
    let cut = Cut::free(count, task.piece * max_pairs);
    fill::<PairManifolds>(py, cut, threads, solve, PoseError::new_err)?.into_arrays(py)
}

fn part_count(side: &SharedGeometry) -> usize {
    match side {
        SharedGeometry::Compound(pack) => pack.hull_count(),
        SharedGeometry::Sheet(sheet) => sheet.triangle_count(),
        _ => 1,
    }
}

/// The manifold and the contact for one pose. `None` for pairs that [`obstacle`] reports.
///
/// [`obstacle`]: crate::query::obstacle
fn update(
    [a, b]: Pair<'_>,
    b_in_a: Pose,
    settings: &ManifoldSettings,
    cache: &mut Cache,
) -> Option<(Manifold, Contact)> {
    let (mut manifold, b) = (Manifold::new(), b.as_shape()?);
    let contact = match a {
        SharedGeometry::HalfSpace(a) => manifold.update_half_space(a, b, b_in_a, settings),
        a => manifold.update(a.as_shape()?, b, b_in_a, settings, cache),
    };
    Some((manifold, contact))
}

/// Writes the manifolds of one pose, ordered by their parts, to the rows that start at `first`.
fn write(rows: &mut PairRows<'_>, first: usize, count: usize, found: &CompoundManifolds, counts: ManifoldCounts) {
    let mut touching: Vec<_> = found.iter().collect();
    touching.sort_unstable_by_key(|(parts, _)| *parts);
    put(rows.touching, first, counts.touching);
    put(rows.dropped, first, counts.dropped);
    for place in 0..count {
        let (at, pair) = (first + place, touching.get(place));
        let parts = pair.map_or([u32::MAX; 2], |(parts, _)| parts.map(|part| u32::try_from(part).unwrap_or(u32::MAX)));
        put_all(rows.parts, at, &parts);
        put_vector(rows.normal, at, pair.map_or(DVec3::NAN, |(_, manifold)| manifold.normal()));
        put(rows.status, at, code(pair.map_or(Status::Separated, |(_, manifold)| manifold.status())));
        put_points!(rows, at, pair.map(|(_, manifold)| *manifold));
    }
}
