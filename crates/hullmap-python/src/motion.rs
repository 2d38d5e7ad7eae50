//! Shapes that move and turn, and derivatives: one row for each motion or pose.

use hullmap::glam::{DQuat, DVec3};
use hullmap::{
    self as core, CastSettings, ClearSettings, Derivatives, Differentiability, MotionSettings, Pose, RigidMotion,
    Settings, SharedGeometry,
};
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns::{Columns, Kind, Row, Rows, Spec};
use crate::error::{ArrayError, PoseError, ShapeError};
use crate::pose::Rows as PoseRows;
use crate::query::cache_of;
use crate::shape::Shape;
use crate::solve::Rays;
use crate::task::{Cut, fill};
use crate::threads::Threads;

/// Motions of a piece: some hundred microseconds of work.
const PIECE: usize = 64;

/// Numbers of a motion that stays at a pose, of one between two poses, and of a screw.
const WIDTHS: [usize; 3] = [7, 14, 16];

/// Columns of `derivatives`.
const SLOPES: &[Spec] = &[
    ("value", Kind::Number, 1),
    ("differentiability", Kind::Code, 1),
    ("by_a", Kind::Number, 6),
    ("by_b", Kind::Number, 6),
    ("status", Kind::Code, 1),
];

/// Columns of `witness_derivatives`: matrices of 3 rows and 6 columns.
const WITNESSES: &[Spec] = &[
    ("normal", Kind::Number, 3),
    ("point_a", Kind::Number, 3),
    ("point_b", Kind::Number, 3),
    ("differentiability", Kind::Code, 1),
    ("normal_by_a", Kind::Number, 18),
    ("normal_by_b", Kind::Number, 18),
    ("point_a_by_a", Kind::Number, 18),
    ("point_a_by_b", Kind::Number, 18),
    ("point_b_by_a", Kind::Number, 18),
    ("point_b_by_b", Kind::Number, 18),
    ("status", Kind::Code, 1),
];

fn put_derivatives<'a, 'r>(row: Row<'a, 'r>, by: &core::Derivatives) -> Row<'a, 'r> {
    row.put(by.status).numbers(&by.by_a.to_array()).numbers(&by.by_b.to_array())
}

/// Motions of one argument, copied while the GIL was held.
struct Motions {
    name: &'static str,
    numbers: Vec<f64>,
    width: usize,
}

impl Motions {
    fn new(name: &'static str, array: &PyReadonlyArray2<'_, f64>) -> PyResult<Self> {
        let width = array.shape().last().copied().unwrap_or(0);
        let numbers = array.as_slice().map_err(|error| ArrayError::new_err(format!("{name}: {error}")))?;
        if !WIDTHS.contains(&width) {
            return Err(ArrayError::new_err(format!("{name}: a motion has {WIDTHS:?} numbers, found {width}")));
        }
        Ok(Self { name, numbers: numbers.to_vec(), width })
    }

    fn count(&self) -> usize {
        self.numbers.len() / self.width
    }

    /// Motion `index`; a single motion serves for every index.
    fn get(&self, index: usize) -> Result<RigidMotion, String> {
        let row = if self.count() == 1 { 0 } else { index };
        let numbers = self.numbers.get(row * self.width..(row + 1) * self.width).unwrap_or_default();
        let named = |error: &dyn std::fmt::Display| format!("{}[{row}]: {error}", self.name);
        let (start, rest) = numbers.split_at_checked(7).unwrap_or_default();
        let start = pose(start).map_err(|error| named(&error))?;
        match rest {
            [] => Ok(RigidMotion::still(start)),
            [linear @ .., a, b, c, d, e, f] if linear.len() == 3 => {
                let linear = DVec3::from_slice(linear);
                let (angular, center) = (DVec3::new(*a, *b, *c), DVec3::new(*d, *e, *f));
                RigidMotion::screw(start, linear, angular, center).map_err(|error| named(&error))
            }
            end => {
                let end = pose(end).map_err(|error| named(&error))?;
                RigidMotion::between(start, end).map_err(|error| named(&error))
            }
        }
    }
}

/// A pose from seven numbers.
fn pose(numbers: &[f64]) -> Result<Pose, core::PoseError> {
    match *numbers {
        [x, y, z, i, j, k, w] => Pose::new(DVec3::new(x, y, z), DQuat::from_xyzw(i, j, k, w)),
        _ => Pose::new(DVec3::NAN, DQuat::NAN),
    }
}

/// The motions of both shapes, and their number.
fn motions(a: &PyReadonlyArray2<'_, f64>, b: &PyReadonlyArray2<'_, f64>) -> PyResult<(Motions, Motions, usize)> {
    let (a, b) = (Motions::new("motion_a", a)?, Motions::new("motion_b", b)?);
    let count = if a.count() == 1 { b.count() } else { a.count() };
    if b.count() != count && b.count() != 1 {
        let message = format!("motion_a has {} motions, and motion_b {}: pass as many", a.count(), b.count());
        return Err(ArrayError::new_err(message));
    }
    Ok((a, b, count))
}

/// Fails if the two have no common query.
fn check(query: &str, a: &SharedGeometry, b: &SharedGeometry) -> PyResult<()> {
    a.check_pair(b).map_err(|error| ShapeError::new_err(format!("{query}: {error}")))
}

/// When shapes that move and turn first meet. The settings are target distance, tolerance, and the
/// limit of queries.
#[pyfunction]
#[pyo3(signature = (a, b, motion_a, motion_b, settings, threads))]
pub fn cast_motion<'py>(
    py: Python<'py>,
    a: &Shape,
    b: &Shape,
    motion_a: PyReadonlyArray2<'py, f64>,
    motion_b: PyReadonlyArray2<'py, f64>,
    settings: (f64, f64, u32),
    threads: Threads,
) -> PyResult<Bound<'py, PyDict>> {
    let (a, b) = (a.0.clone(), b.0.clone());
    check("cast_motion", &a, &b)?;
    let (motions_a, motions_b, count) = motions(&motion_a, &motion_b)?;
    let settings = MotionSettings { target_distance: settings.0, tolerance: settings.1, max_iterations: settings.2 };
    let solve = |first: usize, count: usize, mut rows: Rows<'_>| {
        for at in 0..count {
            let row = first + at;
            let own = [&motions_a, &motions_b].map(|motions| motions.get(row));
            let [Ok(motion_a), Ok(motion_b)] = &own else {
                let message = own.into_iter().find_map(Result::err).unwrap_or_default();
                return Err((row, message));
            };
            let found = core::cast_motion(&a, motion_a, &b, motion_b, &settings, &mut cache_of([&a, &b]));
            let with_b =
                |a: &dyn core::Shape| b.with_part(found.parts[1], |b| found.derivatives(a, motion_a, b, motion_b));
            let by = a.with_part(found.parts[0], with_b).flatten();
            // A half-space has no support mapping.
            let unknown = || Derivatives { status: Differentiability::Inaccurate, ..Derivatives::default() };
            put_derivatives(rows.row(at).answer(&found), &by.unwrap_or_else(unknown));
        }
        Ok(())
    };
    let columns = Columns::of::<core::TimeOfImpact>(count)?.with(count, SLOPES.get(1..4).unwrap_or_default())?;
    fill(py, columns, (Cut::free(count, PIECE), threads, None), solve, PoseError::new_err)
}

/// Whether shapes that move and turn stay clear of each other. The settings are margin, tolerance,
/// the limit of queries, and the share.
#[pyfunction]
#[pyo3(signature = (a, b, motion_a, motion_b, settings, threads))]
pub fn clear<'py>(
    py: Python<'py>,
    a: &Shape,
    b: &Shape,
    motion_a: PyReadonlyArray2<'py, f64>,
    motion_b: PyReadonlyArray2<'py, f64>,
    settings: (f64, f64, u32, f64),
    threads: Threads,
) -> PyResult<Bound<'py, PyDict>> {
    let (a, b) = (a.0.clone(), b.0.clone());
    check("clear", &a, &b)?;
    let (motions_a, motions_b, count) = motions(&motion_a, &motion_b)?;
    let (target_distance, tolerance, max_iterations, share) = settings;
    let motion = MotionSettings { target_distance, tolerance, max_iterations };
    let settings = ClearSettings { motion, share };
    let solve = |first: usize, count: usize, mut rows: Rows<'_>| {
        for at in 0..count {
            let row = first + at;
            let motion_a = motions_a.get(row).map_err(|message| (row, message))?;
            let motion_b = motions_b.get(row).map_err(|message| (row, message))?;
            let found = core::clear(&a, &motion_a, &b, &motion_b, &settings, &mut cache_of([&a, &b]));
            rows.put(at, &found);
        }
        Ok(())
    };
    let columns = Columns::of::<core::Clearance>(count)?;
    fill(py, columns, (Cut::free(count, PIECE), threads, None), solve, PoseError::new_err)
}

/// A convex shape, for derivatives.
fn convex_only(side: &SharedGeometry) -> PyResult<&(dyn core::Shape + Send + Sync)> {
    side.as_shape().ok_or_else(|| {
        let remedy = "query a pack or a mesh, and pass the hull or the triangle that decides";
        ShapeError::new_err(format!("derivatives takes convex shapes: {remedy}"))
    })
}

/// Derivatives of the distance or of the depth of convex shapes, by both poses.
#[pyfunction]
#[pyo3(signature = (a, b, b_in_a, of_depth, settings, threads))]
pub fn derivatives<'py>(
    py: Python<'py>,
    a: &Shape,
    b: &Shape,
    b_in_a: PyReadonlyArray2<'py, f64>,
    of_depth: bool,
    settings: (f64, u32),
    threads: Threads,
) -> PyResult<Bound<'py, PyDict>> {
    let (a, b) = (a.0.clone(), b.0.clone());
    let settings = Settings { tolerance: settings.0, max_iterations: settings.1 };
    let (own_a, own_b) = (convex_only(&a)?, convex_only(&b)?);
    let poses = PoseRows::new("b_in_a", &b_in_a)?;
    let solve = |first: usize, count: usize, mut rows: Rows<'_>| {
        for at in 0..count {
            let row = first + at;
            let pose = poses.get(row).map_err(|message| (row, message))?;
            let mut cache = core::Cache::new();
            let (value, status, by) = if of_depth {
                let found = core::contact(own_a, own_b, pose, &settings, &mut cache);
                let by = found.derivatives(own_a, own_b, pose, &settings, &mut cache);
                (found.depth, found.status, by)
            } else {
                let found = core::distance(own_a, own_b, pose, &settings, &mut cache);
                (found.distance, found.status, found.derivatives(own_a, own_b, pose))
            };
            put_derivatives(rows.row(at).put(value), &by).put(status);
        }
        Ok(())
    };
    let columns = Columns::zeros(poses.count(), SLOPES)?;
    fill(py, columns, (Cut::free(poses.count(), PIECE), threads, None), solve, PoseError::new_err)
}

/// Derivatives of the t of rays that meet a convex shape, by the pose of the shape and by the pose
/// of the ray.
#[pyfunction]
#[pyo3(signature = (shape, origins, directions, settings, threads))]
pub fn ray_derivatives<'py>(
    py: Python<'py>,
    shape: &Shape,
    origins: PyReadonlyArray2<'py, f64>,
    directions: PyReadonlyArray2<'py, f64>,
    settings: (f64, f64, u32),
    threads: Threads,
) -> PyResult<Bound<'py, PyDict>> {
    let side = shape.0.clone();
    let settings = CastSettings { max_t: settings.0, tolerance: settings.1, max_iterations: settings.2 };
    let (own, rays) = (convex_only(&side)?, Rays::new(&origins, &directions)?);
    let solve = |first: usize, count: usize, mut rows: Rows<'_>| {
        for at in 0..count {
            let ray = rays.get(first + at)?;
            let hit = core::ray(own, &ray, &settings);
            let by = hit.derivatives(own, &ray);
            put_derivatives(rows.row(at).put(hit.t), &by).put(hit.status);
        }
        Ok(())
    };
    let columns = Columns::zeros(rays.count(), SLOPES)?;
    fill(py, columns, (Cut::free(rays.count(), PIECE), threads, None), solve, ArrayError::new_err)
}

/// Derivatives of the normal and the points of the distance or the contact of convex shapes, by
/// both poses.
#[pyfunction]
#[pyo3(signature = (a, b, b_in_a, of_depth, settings, threads))]
pub fn witness_derivatives<'py>(
    py: Python<'py>,
    a: &Shape,
    b: &Shape,
    b_in_a: PyReadonlyArray2<'py, f64>,
    of_depth: bool,
    settings: (f64, u32),
    threads: Threads,
) -> PyResult<Bound<'py, PyDict>> {
    let (a, b) = (a.0.clone(), b.0.clone());
    let settings = Settings { tolerance: settings.0, max_iterations: settings.1 };
    let (own_a, own_b) = (convex_only(&a)?, convex_only(&b)?);
    let poses = PoseRows::new("b_in_a", &b_in_a)?;
    let solve = |first: usize, count: usize, mut rows: Rows<'_>| {
        for at in 0..count {
            let row = first + at;
            let pose = poses.get(row).map_err(|message| (row, message))?;
            let mut cache = core::Cache::new();
            let (normal, points, status, by) = if of_depth {
                let found = core::contact(own_a, own_b, pose, &settings, &mut cache);
                let by = found.witness_derivatives(own_a, own_b, pose, &settings, &mut cache);
                (found.normal, [found.point_a, found.point_b], found.status, by)
            } else {
                let found = core::distance(own_a, own_b, pose, &settings, &mut cache);
                let by = found.witness_derivatives(own_a, own_b, pose);
                (found.normal, [found.point_a, found.point_b], found.status, by)
            };
            let mut row = rows.row(at).put(normal).put(points[0]).put(points[1]).put(by.status);
            let matrices = [
                (by.by_a.normal, by.by_b.normal),
                (by.by_a.point_a, by.by_b.point_a),
                (by.by_a.point_b, by.by_b.point_b),
            ];
            for (by_a, by_b) in &matrices {
                row = row.numbers(by_a.as_flattened()).numbers(by_b.as_flattened());
            }
            row.put(status);
        }
        Ok(())
    };
    let columns = Columns::zeros(poses.count(), WITNESSES)?;
    fill(py, columns, (Cut::free(poses.count(), PIECE), threads, None), solve, PoseError::new_err)
}
