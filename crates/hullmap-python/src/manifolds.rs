//! Contact manifolds over arrays of poses: one for each pose of convex shapes, and one for each
//! pair of parts that touch for packs.

use hullmap::compound::{CompoundManifolds, ManifoldCounts};
use hullmap::glam::DVec3;
use hullmap::manifold::{MAX_POINTS, Manifold, ManifoldPoint, ManifoldSettings, Prediction};
use hullmap::{Cache, Contact, Pose, Settings, SharedGeometry, Status};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns::{Columns, Kind, Row, Rows, Spec};
use crate::error::{ArrayError, PoseError};
use crate::pairs::Queried;
use crate::pose::PoseArrays;
use crate::solve::Pair;
use crate::task::{Cut, Task, fill};
use crate::threads::Threads;

/// Maximum of `max_pairs`: memory of about 300 MB for each thread.
const MAX_PAIRS: usize = 1 << 16;

/// Columns of the points of a manifold.
const POINTS: &[Spec] = &[
    ("point_a", Kind::Number, 3 * MAX_POINTS),
    ("point_b", Kind::Number, 3 * MAX_POINTS),
    ("local_b", Kind::Number, 3 * MAX_POINTS),
    ("depth", Kind::Number, MAX_POINTS),
    ("status", Kind::Code, 1),
];

fn manifold_settings(settings: (f64, u32), prediction: Option<f64>) -> ManifoldSettings {
    ManifoldSettings {
        contact: Settings { tolerance: settings.0, max_iterations: settings.1 },
        prediction: prediction.map_or_else(Prediction::default, Prediction::Length),
    }
}

/// Puts the points of a manifold and its status, with NaN for points that it does not have.
fn put_points(row: Row<'_, '_>, manifold: Option<&Manifold>) {
    let points = manifold.map(Manifold::points).unwrap_or_default();
    let vectors = |pick: fn(&ManifoldPoint) -> DVec3| {
        std::array::from_fn::<_, MAX_POINTS, _>(|place| points.get(place).map_or(DVec3::NAN, pick).to_array())
    };
    let depths: [f64; MAX_POINTS] =
        std::array::from_fn(|place| points.get(place).map_or(f64::NAN, |point| point.depth));
    row.numbers(vectors(|point| point.point_a).as_flattened())
        .numbers(vectors(|point| point.point_b).as_flattened())
        .numbers(vectors(|point| point.local_b).as_flattened())
        .numbers(&depths)
        .put(manifold.map_or(Status::Separated, Manifold::status));
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
    let task = Task::new(&pairs, &poses, coherent, threads)?;
    let own = [("hit", Kind::Flag, 1), ("normal", Kind::Number, 3), ("count", Kind::Code, 1)];
    task.solve(
        py,
        ("manifold", false),
        Columns::zeros(task.count, &own)?.with(task.count, POINTS)?,
        |_| Ok(|sides: Pair<'_>, pose: Pose, cache: &mut Cache| update(sides, pose, &settings, cache)),
        |_| None,
        |rows, at, found| {
            let Some((manifold, contact)) = found else { return };
            let row = rows.row(at).put(contact.hit).put(contact.normal).put(manifold.points().len() as u32);
            put_points(row, Some(manifold));
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
    let solve = |first: usize, count: usize, mut rows: Rows<'_>| {
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
    let own = [
        ("touching", Kind::Count, 1),
        ("dropped", Kind::Count, 1),
        ("parts", Kind::Count, 2),
        ("normal", Kind::Number, 3),
        ("count", Kind::Code, 1),
    ];
    let columns = Columns::zeros(count, &own)?.with(count, POINTS)?;
    let cut = Cut::free(count, task.piece * max_pairs);
    fill(py, columns, (cut, threads, None), solve, PoseError::new_err)
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
fn write(rows: &mut Rows<'_>, first: usize, count: usize, found: &CompoundManifolds, counts: ManifoldCounts) {
    let mut touching: Vec<_> = found.iter().collect();
    touching.sort_unstable_by_key(|(parts, _)| *parts);
    for place in 0..count {
        let (at, pair) = (first + place, touching.get(place));
        let parts = pair.map_or([u32::MAX; 2], |(parts, _)| parts.map(|part| u32::try_from(part).unwrap_or(u32::MAX)));
        // The counts are in the first row.
        let [touching, dropped] = if place == 0 { [counts.touching, counts.dropped] } else { [0; 2] };
        let manifold = pair.map(|(_, manifold)| *manifold);
        let normal = manifold.map_or(DVec3::NAN, Manifold::normal);
        let number = manifold.map_or(0, |manifold| manifold.points().len() as u32);
        put_points(rows.row(at).put(touching).put(dropped).put(parts).put(normal).put(number), manifold);
    }
}
