//! Whole robots: configurations and edges of arrays, on all threads, with the GIL released.

use std::path::PathBuf;

use hullmap::glam::{DQuat, DVec3};
use hullmap::{Differentiability, Pose, Settings};
use hullmap_planning::{
    EdgeSettings, Memory, Obstacle, Packs, PlanningError, Robot as Planner, RobotClearance, Skipped,
};
use hullmap_robot::{Description, Places};
use numpy::{PyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns::{Columns, Kind, Rows, Spec};
use crate::error::{self, ArrayError, Error};
use crate::pose::Rows as PoseRows;
use crate::shape::Shape;
use crate::task::{Cut, fill};
use crate::threads::{self, Threads};

/// Configurations of a piece: about a millisecond of work. They share caches.
const PIECE: usize = 128;

/// Edges of a piece.
const PIECE_OF_EDGES: usize = 8;

/// Columns of `clearance`, but for the gradient.
const CLEARANCES: &[Spec] = &[
    ("lower", Kind::Number, 1),
    ("upper", Kind::Number, 1),
    ("pair", Kind::Count, 2),
    ("status", Kind::Code, 1),
    ("normal", Kind::Number, 3),
    ("point_a", Kind::Number, 3),
    ("point_b", Kind::Number, 3),
    ("differentiability", Kind::Code, 1),
];

/// Columns of `clear`.
const EDGES: &[Spec] = &[
    ("verdict", Kind::Code, 1),
    ("status", Kind::Code, 1),
    ("clearance", Kind::Number, 1),
    ("nearest", Kind::Number, 1),
    ("t_lower", Kind::Number, 1),
    ("t_upper", Kind::Number, 1),
    ("pair", Kind::Count, 2),
    ("queries", Kind::Count, 1),
];

/// A robot. It does not change; others are made from it.
#[pyclass(frozen, module = "hullmap._hullmap")]
pub struct Robot {
    robot: Planner,
    format: &'static str,
}

/// Configurations: numbers of joints, or poses of links.
enum Configurations {
    Joints(Vec<f64>),
    Poses(PoseRows),
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
                let rows = PoseRows::new("poses", poses)?;
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
    fn poses(&self, rows: &PoseRows, row: usize) -> Result<Vec<Pose>, String> {
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
        self.robot.skipped().into_iter().map(Skipped::row).collect()
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
    fn link_poses<'py>(&self, py: Python<'py>, q: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
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
        let columns = Columns::zeros(count, &[("hit", Kind::Flag, 1)])?;
        let solve = |first: usize, count: usize, mut rows: Rows<'_>| {
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
                rows.row(at).put(hit.map_err(|error| rejected(error.to_string()))?);
            }
            Ok(())
        };
        let cut = Cut::free(count, PIECE);
        fill(py, columns, (cut, threads, report.as_ref()), solve, ArrayError::new_err)
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
        let mut columns = Columns::zeros(count, CLEARANCES)?;
        if width > 0 {
            columns = columns.with(count, &[("gradient", Kind::Number, width)])?;
        }
        let solve = |first: usize, count: usize, mut rows: Rows<'_>| {
            let (mut memory, mut gradient) = (self.robot.memory(), vec![0.0; width]);
            for at in 0..count {
                let row = first + at;
                gradient.fill(0.0);
                let found = self.clearance_of(&q, row, &settings, &mut memory, &mut gradient);
                let (found, status) = found.map_err(|message| (row, format!("row {row}: {message}")))?;
                let pair = pair_code(found.colliders);
                let row = rows.row(at).put(found.lower).put(found.upper).put(pair).put(found.status).put(found.normal);
                let row = row.put(found.points[0]).put(found.points[1]).put(status);
                if width > 0 {
                    row.numbers(&gradient);
                }
            }
            Ok(())
        };
        let cut = Cut::free(count, PIECE);
        fill(py, columns, (cut, threads, report.as_ref()), solve, ArrayError::new_err)
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
        let columns = Columns::zeros(count, EDGES)?;
        let solve = |first: usize, count: usize, mut rows: Rows<'_>| {
            let mut memory = self.robot.memory();
            for at in 0..count {
                let row = first + at;
                let found = self.robot.clear(self.row(&start, row), self.row(&end, row), &settings, &mut memory);
                let found = found.map_err(|error| (row, format!("edge {row}: {error}")))?;
                let (answer, pair) = (found.answer, pair_code(found.colliders));
                let row = rows.row(at).put(answer.verdict).put(answer.status).put(answer.clearance);
                let row = row.put(answer.nearest).put(answer.t_lower).put(answer.t_upper);
                row.put(pair).put(answer.iterations);
            }
            Ok(())
        };
        let cut = Cut::free(count, PIECE_OF_EDGES);
        fill(py, columns, (cut, threads, report.as_ref()), solve, ArrayError::new_err)
    }
}
