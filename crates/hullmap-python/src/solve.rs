//! The Python functions that run a query over arrays, one for each query.

use hullmap::glam::DVec3;
use hullmap::{
    self as core, Cache, CastSettings, Motion, Pose, Ray, Settings, SharedGeometry, SupportMap, SupportPoint,
};
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns::{Columns, Kind, Rows};
use crate::error::{ArrayError, ShapeError};
use crate::gpu;
use crate::pairs::Queried;
use crate::pose::PoseArrays;
use crate::query::cache_of;
use crate::shape::Shape;
use crate::task::{Cut, PIECE, Task, fill};
use crate::threads::Threads;

/// The two sides of a query.
pub type Pair<'s> = [&'s SharedGeometry; 2];

/// Whether shapes share a point.
#[pyfunction]
#[pyo3(signature = (pairs, poses, coherent, threads, device))]
pub fn intersects<'py>(
    py: Python<'py>,
    pairs: Queried<'py>,
    poses: PoseArrays<'py>,
    coherent: bool,
    threads: Threads,
    device: &str,
) -> PyResult<Bound<'py, PyDict>> {
    let task = Task::new(&pairs, &poses, coherent, threads)?;
    let known = gpu::known(py, device, &task, &Settings::default())?;
    task.solve(
        py,
        ("intersects", true),
        Columns::of::<core::Intersection>(task.count)?,
        |_| Ok(|[a, b]: Pair<'_>, pose: Pose, cache: &mut Cache| core::intersects(a, b, pose, cache)),
        known,
        |rows, at, found| rows.put(at, found),
    )
}

/// Distances of shapes.
#[pyfunction]
#[pyo3(signature = (pairs, poses, settings, coherent, threads, device))]
pub fn distance<'py>(
    py: Python<'py>,
    pairs: Queried<'py>,
    poses: PoseArrays<'py>,
    settings: (f64, u32),
    coherent: bool,
    threads: Threads,
    device: &str,
) -> PyResult<Bound<'py, PyDict>> {
    let settings = Settings { tolerance: settings.0, max_iterations: settings.1 };
    let task = Task::new(&pairs, &poses, coherent, threads)?;
    let known = gpu::known(py, device, &task, &settings)?;
    task.solve(
        py,
        ("distance", true),
        Columns::of::<core::Distance>(task.count)?,
        |_| Ok(|[a, b]: Pair<'_>, pose: Pose, cache: &mut Cache| core::distance(a, b, pose, &settings, cache)),
        known,
        |rows, at, found| rows.put(at, found),
    )
}

/// Contacts of shapes.
#[pyfunction]
#[pyo3(signature = (pairs, poses, settings, coherent, threads, device))]
pub fn contact<'py>(
    py: Python<'py>,
    pairs: Queried<'py>,
    poses: PoseArrays<'py>,
    settings: (f64, u32),
    coherent: bool,
    threads: Threads,
    device: &str,
) -> PyResult<Bound<'py, PyDict>> {
    let settings = Settings { tolerance: settings.0, max_iterations: settings.1 };
    let task = Task::new(&pairs, &poses, coherent, threads)?;
    let known = gpu::known(py, device, &task, &settings)?;
    task.solve(
        py,
        ("contact", true),
        Columns::of::<core::Contact>(task.count)?,
        |_| Ok(|[a, b]: Pair<'_>, pose: Pose, cache: &mut Cache| core::contact(a, b, pose, &settings, cache)),
        known,
        |rows, at, found| rows.put(at, found),
    )
}

/// When shapes that translate first meet.
#[pyfunction]
#[pyo3(signature = (pairs, poses, velocities, settings, coherent, threads))]
pub fn cast<'py>(
    py: Python<'py>,
    pairs: Queried<'py>,
    poses: PoseArrays<'py>,
    velocities: PyReadonlyArray2<'py, f64>,
    settings: (f64, f64, u32),
    coherent: bool,
    threads: Threads,
) -> PyResult<Bound<'py, PyDict>> {
    let settings = CastSettings { max_t: settings.0, tolerance: settings.1, max_iterations: settings.2 };
    let velocities = Vectors::new("velocity", &velocities)?;
    let task = Task::new(&pairs, &poses, coherent, threads)?;
    velocities.check_count(task.count)?;
    task.solve(
        py,
        ("cast", true),
        Columns::of::<core::Impact>(task.count)?,
        |row| {
            let motion = Motion::new(velocities.get(row)).map_err(|error| format!("velocity[{row}]: {error}"))?;
            Ok(move |[a, b]: Pair<'_>, pose: Pose, cache: &mut Cache| core::cast(a, b, pose, motion, &settings, cache))
        },
        |_| None,
        |rows, at, found| rows.put(at, found),
    )
}

/// Vectors of one argument, copied while the GIL was held.
struct Vectors {
    name: &'static str,
    numbers: Vec<[f64; 3]>,
}

impl Vectors {
    fn new(name: &'static str, array: &PyReadonlyArray2<'_, f64>) -> PyResult<Self> {
        let numbers = array.as_slice().map_err(|error| ArrayError::new_err(format!("{name}: {error}")))?;
        if array.shape().last() != Some(&3) {
            return Err(ArrayError::new_err(format!("{name}: a vector has 3 numbers, found {:?}", array.shape())));
        }
        Ok(Self { name, numbers: numbers.as_chunks().0.to_vec() })
    }

    /// Vector `index`; a single vector serves for every index.
    fn get(&self, index: usize) -> DVec3 {
        let index = if self.numbers.len() == 1 { 0 } else { index };
        self.numbers.get(index).map_or(DVec3::NAN, |vector| DVec3::from_array(*vector))
    }

    fn check_count(&self, count: usize) -> PyResult<()> {
        if self.numbers.len() == count || self.numbers.len() == 1 {
            return Ok(());
        }
        let (name, found) = (self.name, self.numbers.len());
        Err(ArrayError::new_err(format!("{name} has {found} rows, expected {count}, or one for all")))
    }
}

/// Rays of two arguments, of which either may be one vector for all.
pub(crate) struct Rays {
    origins: Vectors,
    directions: Vectors,
}

impl Rays {
    pub(crate) fn new(origins: &PyReadonlyArray2<'_, f64>, directions: &PyReadonlyArray2<'_, f64>) -> PyResult<Self> {
        let rays =
            Self { origins: Vectors::new("origins", origins)?, directions: Vectors::new("directions", directions)? };
        rays.directions.check_count(rays.count())?;
        Ok(rays)
    }

    pub(crate) fn count(&self) -> usize {
        if self.origins.numbers.len() == 1 { self.directions.numbers.len() } else { self.origins.numbers.len() }
    }

    /// The ray of a row; the error has the row, too.
    pub(crate) fn get(&self, row: usize) -> Result<Ray, (usize, String)> {
        Ray::new(self.origins.get(row), self.directions.get(row)).map_err(|error| (row, format!("ray {row}: {error}")))
    }
}

/// Where rays enter a shape. For a pack, where they first enter one of its hulls.
#[pyfunction]
#[pyo3(signature = (shape, origins, directions, settings, threads))]
pub fn ray<'py>(
    py: Python<'py>,
    shape: &Shape,
    origins: PyReadonlyArray2<'py, f64>,
    directions: PyReadonlyArray2<'py, f64>,
    settings: (f64, f64, u32),
    threads: Threads,
) -> PyResult<Bound<'py, PyDict>> {
    let settings = CastSettings { max_t: settings.0, tolerance: settings.1, max_iterations: settings.2 };
    let rays = Rays::new(&origins, &directions)?;
    let side = shape.0.clone();
    let solve = |first: usize, count: usize, mut rows: Rows<'_>| {
        for at in 0..count {
            let ray = rays.get(first + at)?;
            let hit = core::ray(&side, &ray, &settings);
            rows.put(at, &hit);
        }
        Ok(())
    };
    let (count, columns) = (rays.count(), Columns::of::<core::RayHit>(rays.count())?);
    fill(py, columns, (Cut::free(count, PIECE), threads, None), solve, ArrayError::new_err)
}

/// Signed distances of points from a shape. For a pack, the minimum over its hulls.
#[pyfunction]
#[pyo3(signature = (shape, points, settings, coherent, threads))]
pub fn signed_distance<'py>(
    py: Python<'py>,
    shape: &Shape,
    points: PyReadonlyArray2<'py, f64>,
    settings: (f64, u32),
    coherent: bool,
    threads: Threads,
) -> PyResult<Bound<'py, PyDict>> {
    let settings = Settings { tolerance: settings.0, max_iterations: settings.1 };
    let points = Vectors::new("points", &points)?;
    let side = shape.0.clone();
    if let SharedGeometry::Sheet(sheet) = &side {
        let (name, remedy) = (sheet.name(), "query the distance of Sphere(0)");
        let message = format!("signed_distance takes a shape with an inside, found {name}: {remedy}");
        return Err(ShapeError::new_err(message));
    }
    let solve = |first: usize, count: usize, mut rows: Rows<'_>| {
        let mut cache = cache_of([&side; 2]);
        for at in 0..count {
            let row = first + at;
            if !coherent {
                cache.clear();
            }
            let found = core::signed_distance(&side, points.get(row), &settings, &mut cache);
            let found = found.map_err(|error| (row, format!("points[{row}]: {error}")))?;
            rows.put(at, &found);
        }
        Ok(())
    };
    let count = points.numbers.len();
    let columns = Columns::of::<core::SignedDistance>(count)?;
    fill(py, columns, (Cut::free(count, PIECE), threads, None), solve, ArrayError::new_err)
}

/// Support points of a bounded shape; for a pack, of the hull that reaches farthest.
#[pyfunction]
#[pyo3(signature = (shape, directions, threads))]
pub fn support<'py>(
    py: Python<'py>,
    shape: &Shape,
    directions: PyReadonlyArray2<'py, f64>,
    threads: Threads,
) -> PyResult<Bound<'py, PyDict>> {
    let directions = Vectors::new("directions", &directions)?;
    let side = shape.0.clone();
    if let SharedGeometry::Sheet(sheet) = &side {
        let message = format!("support takes a convex shape or a pack, found {}: use its vertices", sheet.name());
        return Err(ShapeError::new_err(message));
    }
    if matches!(side, SharedGeometry::HalfSpace(_)) {
        return Err(ShapeError::new_err(
            "support takes a bounded shape, found a half-space: it reaches to infinity in all directions but one",
        ));
    }
    let solve = |first: usize, count: usize, mut rows: Rows<'_>| {
        for at in 0..count {
            let row = first + at;
            let direction = directions.get(row);
            // The largest component decides: a zero or NaN direction has no support point.
            let greatest = direction.abs().max_element();
            if !(direction.is_finite() && greatest > 0.0) {
                let DVec3 { x, y, z } = direction;
                let remedy = "remove it, or check where it comes from";
                return Err((
                    row,
                    format!(
                        "directions[{row}]: a direction must be finite and not zero, found ({x}, {y}, {z}): {remedy}"
                    ),
                ));
            }
            let (found, part) = match &side {
                SharedGeometry::Compound(pack) => match farthest(pack, direction) {
                    Some(found) => found,
                    None => continue,
                },
                side => match side.as_shape() {
                    Some(shape) => (shape.support_point(direction), 0),
                    // Rejected above.
                    None => continue,
                },
            };
            rows.row(at).put(found.point).put(found.feature).put(part);
        }
        Ok(())
    };
    let count = directions.numbers.len();
    let columns =
        Columns::zeros(count, &[("point", Kind::Number, 3), ("vertex", Kind::Count, 1), ("parts", Kind::Count, 1)])?;
    fill(py, columns, (Cut::free(count, PIECE), threads, None), solve, ArrayError::new_err)
}

/// The farthest support point of all hulls, and the index of its hull: the first of equal ones.
fn farthest(pack: &core::Pack, direction: DVec3) -> Option<(SupportPoint, u32)> {
    let mut best: Option<(SupportPoint, u32)> = None;
    for (part, hull) in (0..).zip(pack.hulls()) {
        let found = SupportMap::support_point(&hull, direction);
        if best.is_none_or(|(best, _)| found.point.dot(direction) > best.point.dot(direction)) {
            best = Some((found, part));
        }
    }
    best
}
