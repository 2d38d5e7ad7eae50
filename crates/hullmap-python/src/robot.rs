//! Whole robots: configurations and edges of arrays, on all threads, with the GIL released.

use std::path::PathBuf;

use hullmap::glam::{DQuat, DVec3};
use hullmap::{Differentiability, Pose, Settings, Verdict};
use hullmap_planning::{
    EdgeSettings, Memory, Obstacle, Packs, PlanningError, Robot as Planner, RobotClearance,
    Skipped,
};
use hullmap_robot::{Description, Places};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns::{Columns, columns, put, put_all, put_fields, put_vector};
use crate::error::{self, ArrayError, Error};
use crate::pose::Rows;
use crate::shape::Shape;
use crate::solve::code;
use crate::task::{Cut, fill_into};
use crate::threads::{self, Threads};

/// Configurations of a piece: about a millisecond of work. They share caches.
const PIECE: usize = 128;

/// Edges of a piece.
const PIECE_OF_EDGES: usize = 8;

columns!(
    /// Answers of `in_collision`.
    Collisions, CollisionRows { hit: bool = 1 }
);

columns!(
    /// Answers of `clearance`, but for the gradient.
    Clearances, ClearanceRows {
        lower: f64 = 1, upper: f64 = 1, pair: u32 = 2, status: u8 = 1, normal: f64 = 3, point_a: f64 = 3,
        point_b: f64 = 3, differentiability: u8 = 1,
    }
);

columns!(
    /// Answers of `clear`.
    Edges, EdgeRows {
        verdict: u8 = 1, status: u8 = 1, clearance: f64 = 1, nearest: f64 = 1, t_lower: f64 = 1, t_upper: f64 = 1,
        pair: u32 = 2, queries: u32 = 1,
    }
);

/// Answers of `clearance`, with a gradient of `width` numbers, or of none.
struct Gradients {
    fixed: Clearances,
    gradient: Vec<f64>,
    width: usize,
}

impl Columns for Gradients {
    type Rows<'a> = (ClearanceRows<'a>, &'a mut [f64]);

    fn zeros(count: usize) -> PyResult<Self> {
        Ok(Self { fixed: Clearances::zeros(count)?, gradient: Vec::new(), width: 0 })
    }

    fn pieces(&mut self, range: std::ops::Range<usize>, size: usize) -> Vec<Self::Rows<'_>> {
        let width = self.width;
        let gradient = self.gradient.get_mut(range.start * width..range.end * width).unwrap_or_default();
        let gradients = gradient.chunks_mut((size * width).max(1)).map(Some).chain(std::iter::repeat_with(|| None));
        let fixed = self.fixed.pieces(range, size);
        fixed.into_iter().zip(gradients).map(|(fixed, own)| (fixed, own.unwrap_or_default())).collect()
    }

    fn into_arrays(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let arrays = self.fixed.into_arrays(py)?;
        if let Some(rows) = self.gradient.len().checked_div(self.width) {
            let gradient = PyArray1::from_vec(py, self.gradient).reshape([rows, self.width])?;
            arrays.set_item("gradient", gradient)?;
        }
        Ok(arrays)
    }
}

/// A robot. It does not change; others are made from it.
#[pyclass(frozen, module = "hullmap._hullmap")]
pub struct Robot {
    robot: Planner,
    format: &'static str,
}

/// Configurations: numbers of joints, or poses of links.
enum Configurations {
    Joints(Vec<f64>),
    Poses(Rows),
}

fn raised(error: PlanningError) -> PyErr {
    match error {
        PlanningError::Description(error) if error.is_unreadable => {
            let kind = std::fs::metadata(&error.file).err().map_or(std::io::ErrorKind::Other, |error| error.kind());
            error::of_io(&std::io::Error::from(kind), error.to_string())
        }
        error => Error::new_err(error.to_string()),
    }
}

/// The code of a differentiability, as in `hullmap.Differentiability`.
pub fn differentiability_code(status: Differentiability) -> u8 {
    match status {
        Differentiability::Unique => 0,
        Differentiability::Touching => 1,
        Differentiability::Parallel => 2,
        Differentiability::Normals => 3,
        Differentiability::Grazing => 4,
        Differentiability::Missing => 5,
        Differentiability::Inaccurate => 6,
        Differentiability::Feature => 7,
        Differentiability::Curved => 8,
    }
}

/// The code of a verdict, as in `hullmap.Verdict`.
pub fn verdict_code(verdict: Verdict) -> u8 {
    match verdict {
        Verdict::Free => 0,
        Verdict::Hit => 1,
        Verdict::Open => 2,
    }
}

fn pair_code(colliders: Option<[usize; 2]>) -> [u32; 2] {
    colliders.map_or([u32::MAX; 2], |pair| pair.map(|index| u32::try_from(index).unwrap_or(u32::MAX)))
}

impl Robot {
    /// The numbers of `array`, and their rows.
    fn joints(&self, name: &str, array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<f64>> {
        let (width, found) = (self.robot.joint_count(), array.shape().last().copied().unwrap_or(0));
        if found != width {
            let message = format!("{name}: a configuration has {width} numbers, one for each joint, found {found}");
            return Err(ArrayError::new_err(message));
        }
        Ok(array.as_slice().map_err(|error| ArrayError::new_err(format!("{name}: {error}")))?.to_vec())
    }

    /// The configurations of a call, and their number.
    fn configurations(
        &self,
        count: usize,
        q: Option<&PyReadonlyArray2<'_, f64>>,
        poses: Option<&PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Configurations> {
        Ok(match (q, poses) {
            (Some(q), None) => Configurations::Joints(self.joints("q", q)?),
            (None, Some(poses)) => {
                let rows = Rows::new("poses", poses)?;
                if rows.count() != count * self.robot.links().len() {
                    return Err(ArrayError::new_err("poses: pass one pose for each link"));
                }
                Configurations::Poses(rows)
            }
            _ => return Err(ArrayError::new_err("pass q, or poses")),
        })
    }

    /// The numbers of row `row`.
    fn row<'q>(&self, numbers: &'q [f64], row: usize) -> &'q [f64] {
        let width = self.robot.joint_count();
        numbers.get(row * width..(row + 1) * width).unwrap_or_default()
    }

    /// The poses of all links of row `row`.
    fn poses(&self, rows: &Rows, row: usize) -> Result<Vec<Pose>, String> {
        let count = self.robot.links().len();
        (row * count..(row + 1) * count).map(|at| rows.get(at)).collect()
    }

    fn changed(&self, change: impl FnOnce(&mut Planner) -> Result<(), PlanningError>) -> PyResult<Self> {
        let mut robot = self.robot.clone();
        change(&mut robot).map_err(raised)?;
        Ok(Self { robot, format: self.format })
    }

    fn clearance_of(
        &self,
        q: &Configurations,
        row: usize,
        settings: &Settings,
        memory: &mut Memory,
        gradient: &mut [f64],
    ) -> Result<(RobotClearance, Differentiability), String> {
        let found = match q {
            Configurations::Joints(numbers) if gradient.is_empty() => {
                let found = self.robot.clearance(self.row(numbers, row), settings, memory);
                found.map(|found| (found, Differentiability::Missing))
            }
            Configurations::Joints(numbers) => {
                self.robot.clearance_gradient(self.row(numbers, row), settings, memory, gradient)
            }
            Configurations::Poses(rows) => {
                let found = self.robot.clearance_at(&self.poses(rows, row)?, settings, memory);
                found.map(|found| (found, Differentiability::Missing))
            }
        };
        found.map_err(|error| error.to_string())
    }
}

#[pymethods]
impl Robot {
    /// Reads a description.
    #[staticmethod]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        packs: Vec<PathBuf>,
        packages: Vec<PathBuf>,
        strict: bool,
    ) -> PyResult<Self> {
        let pool = threads::pool(Threads::default())?;
        let read = || -> Result<Self, PlanningError> {
            // A folder that cannot be read is reported by the reader of the file.
            let beside = Places::beside(&path).unwrap_or_default();
            let places = Places { packages, ..beside };
            let description = Description::read(&path, &places)?;
            let mut packs = Packs::in_folders(packs)?;
            let robot = Planner::new(&description, |mesh| packs.hulls(mesh))?;
            let robot = if strict { robot.strict()? } else { robot };
            Ok(Self { robot, format: description.format.name() })
        };
        py.detach(|| pool.install(read)).map_err(raised)
    }

    #[getter]
    fn format(&self) -> &str {
        self.format
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.robot.notes.clone()
    }

    /// Names of links, and of obstacles.
    fn names(&self) -> (Vec<String>, Vec<String>) {
        let links = self.robot.links().to_vec();
        let obstacles = (links.len()..).map_while(|index| self.robot.collider(index)).map(str::to_owned).collect();
        (links, obstacles)
    }

    /// Names, limits and neutral positions of joints, and whether they are sliders.
    fn joint_facts(&self) -> Vec<(String, Option<[f64; 2]>, f64, bool)> {
        let joints = self.robot.joints().iter();
        joints.map(|joint| (joint.name.clone(), joint.limits, joint.neutral, joint.is_slider)).collect()
    }

    #[getter]
    fn body_count(&self) -> usize {
        self.robot.body_count()
    }

    /// Indices of the colliders of each pair that is tested.
    fn pairs(&self) -> Vec<[usize; 2]> {
        self.robot.tested()
    }

    /// The pairs that are not tested: names of links, names of geoms, and the reason.
    fn skipped(&self) -> Vec<(Vec<String>, Vec<String>, String)> {
        let row = |skipped| match skipped {
            Skipped::Pair { links, geoms, reason } => {
                (links.to_vec(), geoms.map(Vec::from).unwrap_or_default(), reason.to_string())
            }
            Skipped::Geometry { link, geom, line, cause } => {
                (link.into_iter().collect(), vec![geom], format!("line {line}: {cause}"))
            }
        };
        self.robot.skipped().into_iter().map(row).collect()
    }

    fn disallowing(&self, pairs: Vec<(String, String)>) -> PyResult<Self> {
        self.changed(|robot| robot.disallow(pairs.iter().map(|(a, b)| [a, b])))
    }

    fn allowing(&self, pairs: Vec<(String, String)>) -> PyResult<Self> {
        self.changed(|robot| robot.allow(pairs.iter().map(|(a, b)| [a, b])))
    }

    fn allowing_srdf(&self, path: PathBuf) -> PyResult<Self> {
        self.changed(|robot| robot.allow_srdf(&path))
    }

    /// With these obstacles besides those that there are. A pose is x y z and a quaternion x y z w.
    fn with_obstacles(&self, obstacles: Vec<(String, PyRef<'_, Shape>, [f64; 7])>) -> PyResult<Self> {
        let obstacles = obstacles.iter().map(|(name, shape, [x, y, z, i, j, k, w])| {
            let pose = Pose::new(DVec3::new(*x, *y, *z), DQuat::from_xyzw(*i, *j, *k, *w));
            let pose = pose.map_err(|error| error::PoseError::new_err(format!("obstacle {name}: {error}")))?;
            Ok(Obstacle { name: name.clone(), shape: shape.0.clone(), pose })
        });
        let obstacles = obstacles.collect::<PyResult<Vec<_>>>()?;
        self.changed(|robot| robot.add_obstacles(obstacles))
    }

    fn without_obstacles(&self) -> PyResult<Self> {
        self.changed(|robot| {
            robot.clear_obstacles();
            Ok(())
        })
    }

    /// The poses of all links, for each row of `q`: x y z and a quaternion x y z w.
    fn link_poses<'py>(
        &self,
        py: Python<'py>,
        q: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let count = q.shape().first().copied().unwrap_or(0);
        let numbers = self.joints("q", &q)?;
        let solve = || {
            let (mut memory, mut all) = (self.robot.memory(), Vec::new());
            for row in 0..count {
                let poses = self.robot.link_poses(self.row(&numbers, row), &mut memory);
                let poses = poses.map_err(|error| format!("row {row}: {error}"))?;
                let numbers = |pose: &Pose| {
                    pose.translation().to_array().into_iter().chain(pose.rotation().to_array()).collect::<Vec<_>>()
                };
                all.extend(poses.iter().flat_map(numbers));
            }
            Ok(all)
        };
        let found: Result<Vec<f64>, String> = py.detach(solve);
        Ok(PyArray1::from_vec(py, found.map_err(ArrayError::new_err)?))
    }

    /// Indices of the colliders of all pairs that touch.
    fn touching(&self, q: PyReadonlyArray2<'_, f64>) -> PyResult<Vec<[usize; 2]>> {
        let numbers = self.joints("q", &q)?;
        self.robot.touching(self.row(&numbers, 0), &mut self.robot.memory()).map_err(raised)
    }

    #[pyo3(signature = (count, q, poses, margin, threads, report))]
    fn in_collision<'py>(
        &self,
        py: Python<'py>,
        count: usize,
        q: Option<PyReadonlyArray2<'py, f64>>,
        poses: Option<PyReadonlyArray2<'py, f64>>,
        margin: f64,
        threads: Threads,
        report: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let q = self.configurations(count, q.as_ref(), poses.as_ref())?;
        let mut columns = Collisions::zeros(count)?;
        let solve = |first: usize, count: usize, rows: CollisionRows<'_>| {
            let mut memory = self.robot.memory();
            for at in 0..count {
                let row = first + at;
                let rejected = |message: String| (row, format!("row {row}: {message}"));
                let hit = match &q {
                    Configurations::Joints(numbers) => {
                        self.robot.in_collision(self.row(numbers, row), margin, &mut memory)
                    }
                    Configurations::Poses(rows) => {
                        let poses = self.poses(rows, row).map_err(|message| (row, message))?;
                        self.robot.in_collision_at(&poses, margin, &mut memory)
                    }
                };
                put(rows.hit, at, hit.map_err(|error| rejected(error.to_string()))?);
            }
            Ok(())
        };
        let cut = Cut::free(count, PIECE);
        fill_into(py, &mut columns, (cut, threads, report.as_ref()), solve, ArrayError::new_err)?;
        columns.into_arrays(py)
    }

    #[pyo3(signature = (count, q, poses, settings, gradient, threads, report))]
    fn clearance<'py>(
        &self,
        py: Python<'py>,
        count: usize,
        q: Option<PyReadonlyArray2<'py, f64>>,
        poses: Option<PyReadonlyArray2<'py, f64>>,
        settings: (f64, u32),
        gradient: bool,
        threads: Threads,
        report: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let q = self.configurations(count, q.as_ref(), poses.as_ref())?;
        let settings = Settings { tolerance: settings.0, max_iterations: settings.1 };
        let width = if gradient { self.robot.joint_count() } else { 0 };
        let gradient = crate::columns::zeros(count.saturating_mul(width))?;
        let mut columns = Gradients { fixed: Clearances::zeros(count)?, gradient, width };
        let solve = |first: usize, count: usize, (rows, gradients): (ClearanceRows<'_>, &mut [f64])| {
            let mut memory = self.robot.memory();
            for at in 0..count {
                let row = first + at;
                let own = gradients.get_mut(at * width..(at + 1) * width).unwrap_or_default();
                let found = self.clearance_of(&q, row, &settings, &mut memory, own);
                let (found, status) = found.map_err(|message| (row, format!("row {row}: {message}")))?;
                put(rows.lower, at, found.lower);
                put(rows.upper, at, found.upper);
                put_all(rows.pair, at, &pair_code(found.colliders));
                put(rows.status, at, code(found.status));
                put_vector(rows.normal, at, found.normal);
                put_vector(rows.point_a, at, found.points[0]);
                put_vector(rows.point_b, at, found.points[1]);
                put(rows.differentiability, at, differentiability_code(status));
            }
            Ok(())
        };
        let cut = Cut::free(count, PIECE);
        fill_into(py, &mut columns, (cut, threads, report.as_ref()), solve, ArrayError::new_err)?;
        columns.into_arrays(py)
    }

    /// Edges from the rows of `start` to the rows of `end`. The settings are margin, resolution,
    /// share, and the limit of queries.
    #[pyo3(signature = (start, end, settings, threads, report))]
    fn clear<'py>(
        &self,
        py: Python<'py>,
        start: PyReadonlyArray2<'py, f64>,
        end: PyReadonlyArray2<'py, f64>,
        settings: (f64, f64, f64, u32),
        threads: Threads,
        report: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let count = start.shape().first().copied().unwrap_or(0);
        let (start, end) = (self.joints("start", &start)?, self.joints("end", &end)?);
        let (margin, resolution, share, max_queries) = settings;
        let settings = EdgeSettings { margin, resolution, share, max_queries };
        let mut columns = Edges::zeros(count)?;
        let solve = |first: usize, count: usize, rows: EdgeRows<'_>| {
            let mut memory = self.robot.memory();
            for at in 0..count {
                let row = first + at;
                let found = self.robot.clear(self.row(&start, row), self.row(&end, row), &settings, &mut memory);
                let found = found.map_err(|error| (row, format!("edge {row}: {error}")))?;
                put(rows.verdict, at, verdict_code(found.answer.verdict));
                put_fields!(rows, at, found.answer; status, clearance, nearest, t_lower, t_upper);
                put_all(rows.pair, at, &pair_code(found.colliders));
                put(rows.queries, at, found.answer.iterations);
            }
            Ok(())
        };
        let cut = Cut::free(count, PIECE_OF_EDGES);
        fill_into(py, &mut columns, (cut, threads, report.as_ref()), solve, ArrayError::new_err)?;
        columns.into_arrays(py)
    }
}
