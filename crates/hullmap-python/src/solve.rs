//! The Python functions that run a query over arrays, one for each query.

use hullmap::glam::DVec3;
use hullmap::{
    self as core, Cache, CastSettings, Motion, Overlap, Pose, Ray, Settings, SharedGeometry, Status, SupportMap,
    SupportPoint,
};
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns::{Columns, Field, columns, put, put_all, put_fields, put_vector};
use crate::error::{ArrayError, ShapeError};
use crate::gpu;
use crate::pairs::Queried;
use crate::pose::PoseArrays;
use crate::query::cache_of;
use crate::shape::Shape;
use crate::task::{Cut, PIECE, Task, fill};
use crate::threads::Threads;

columns!(
    /// Answers of `intersects`.
    Intersections, IntersectionRows {
        hit: bool = 1, status: u8 = 1, iterations: u32 = 1, support_calls: u32 = 1, parts: u32 = 2,
    }
);

columns!(
    /// Answers of `distance`.
    Distances, DistanceRows {
        distance: f64 = 1, lower: f64 = 1, upper: f64 = 1, status: u8 = 1, normal: f64 = 3, point_a: f64 = 3,
        point_b: f64 = 3, iterations: u32 = 1, support_calls: u32 = 1, parts: u32 = 2,
    }
);

columns!(
    /// Answers of `contact`.
    Contacts, ContactRows {
        hit: bool = 1, depth: f64 = 1, depth_lower: f64 = 1, depth_upper: f64 = 1, status: u8 = 1, normal: f64 = 3,
        point_a: f64 = 3, point_b: f64 = 3, iterations: u32 = 1, support_calls: u32 = 1, parts: u32 = 2,
    }
);

columns!(
    /// Answers of `cast`.
    Impacts, ImpactRows {
        hit: bool = 1, t: f64 = 1, t_lower: f64 = 1, t_upper: f64 = 1, status: u8 = 1, normal: f64 = 3,
        point_a: f64 = 3, point_b: f64 = 3, iterations: u32 = 1, support_calls: u32 = 1, parts: u32 = 2,
    }
);

columns!(
    /// Answers of `ray`.
    RayHits, RayRows {
        hit: bool = 1, t: f64 = 1, t_lower: f64 = 1, t_upper: f64 = 1, status: u8 = 1, normal: f64 = 3, point: f64 = 3,
        iterations: u32 = 1, support_calls: u32 = 1, parts: u32 = 1,
    }
);

columns!(
    /// Answers of `signed_distance`.
    SignedDistances, SignedRows {
        distance: f64 = 1, lower: f64 = 1, upper: f64 = 1, status: u8 = 1, normal: f64 = 3, point: f64 = 3,
        iterations: u32 = 1, support_calls: u32 = 1, parts: u32 = 1,
    }
);

columns!(
    /// Answers of `support`.
    Supports, SupportRows { point: f64 = 3, vertex: u32 = 1, parts: u32 = 1 }
);

/// The two sides of a query.
pub type Pair<'s> = [&'s SharedGeometry; 2];

/// The code of a status, as in `hullmap.Status`.
pub fn code(status: Status) -> u8 {
    match status {
        Status::Exact => 0,
        Status::Within => 1,
        Status::Touching => 2,
        Status::Overlapping => 3,
        Status::Separated => 4,
        Status::IterationLimit => 5,
        Status::Stalled => 6,
    }
}

impl Field for Status {
    type Number = u8;

    fn write(self, column: &mut [u8], at: usize) {
        put(column, at, code(self));
    }
}

/// The code of an overlap, as in `hullmap.Overlap`.
fn overlap_code(overlap: Overlap) -> u8 {
    match overlap {
        Overlap::Separated => 0,
        Overlap::Overlapping => 1,
        Overlap::Touching => 2,
        Overlap::Undecided => 3,
    }
}

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
    task.solve::<Intersections, _, _>(
        py,
        ("intersects", true),
        |_| Ok(|[a, b]: Pair<'_>, pose: Pose, cache: &mut Cache| core::intersects(a, b, pose, cache)),
        known,
        |rows, at, found| {
            put(rows.hit, at, found.is_hit());
            put(rows.status, at, overlap_code(found.status));
            put(rows.iterations, at, found.iterations);
            put(rows.support_calls, at, found.support_calls);
            put_all(rows.parts, at, &found.parts);
        },
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
    task.solve::<Distances, _, _>(
        py,
        ("distance", true),
        |_| Ok(|[a, b]: Pair<'_>, pose: Pose, cache: &mut Cache| core::distance(a, b, pose, &settings, cache)),
        known,
        |rows, at, found| {
            put_fields!(
                rows, at, found;
                distance, lower, upper, status, normal, point_a, point_b, iterations, support_calls
            );
            put_all(rows.parts, at, &found.parts);
        },
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
    task.solve::<Contacts, _, _>(
        py,
        ("contact", true),
        |_| Ok(|[a, b]: Pair<'_>, pose: Pose, cache: &mut Cache| core::contact(a, b, pose, &settings, cache)),
        known,
        |rows, at, found| {
            put_fields!(
                rows, at, found;
                hit, depth, depth_lower, depth_upper, status, normal, point_a, point_b, iterations, support_calls
            );
            put_all(rows.parts, at, &found.parts);
        },
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
    task.solve::<Impacts, _, _>(
        py,
        ("cast", true),
        |row| {
            let motion = Motion::new(velocities.get(row)).map_err(|error| format!("velocity[{row}]: {error}"))?;
            Ok(move |[a, b]: Pair<'_>, pose: Pose, cache: &mut Cache| core::cast(a, b, pose, motion, &settings, cache))
        },
        |_| None,
        |rows, at, found| {
            put_fields!(
                rows, at, found;
                hit, t, t_lower, t_upper, status, normal, point_a, point_b, iterations, support_calls
            );
            put_all(rows.parts, at, &found.parts);
        },
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
    let solve = |first: usize, count: usize, rows: RayRows<'_>| {
        for at in 0..count {
            let ray = rays.get(first + at)?;
            let hit = core::ray(&side, &ray, &settings);
            put_fields!(rows, at, hit; hit, t, t_lower, t_upper, status, normal, point, iterations, support_calls);
            put(rows.parts, at, hit.part);
        }
        Ok(())
    };
    fill::<RayHits>(py, Cut::free(rays.count(), PIECE), threads, solve, ArrayError::new_err)?.into_arrays(py)
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
    let solve = |first: usize, count: usize, rows: SignedRows<'_>| {
        let mut cache = cache_of([&side; 2]);
        for at in 0..count {
            let row = first + at;
            if !coherent {
                cache.clear();
            }
            let found = core::signed_distance(&side, points.get(row), &settings, &mut cache);
            let found = found.map_err(|error| (row, format!("points[{row}]: {error}")))?;
            put_fields!(rows, at, found; distance, lower, upper, status, normal, point, iterations, support_calls);
            put(rows.parts, at, found.part);
        }
        Ok(())
    };
    fill::<SignedDistances>(py, Cut::free(points.numbers.len(), PIECE), threads, solve, ArrayError::new_err)?
        .into_arrays(py)
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
    let solve = |first: usize, count: usize, rows: SupportRows<'_>| {
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
            put_vector(rows.point, at, found.point);
            put(rows.vertex, at, found.feature);
            put(rows.parts, at, part);
        }
        Ok(())
    };
    fill::<Supports>(py, Cut::free(directions.numbers.len(), PIECE), threads, solve, ArrayError::new_err)?
        .into_arrays(py)
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
