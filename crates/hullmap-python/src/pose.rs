//! Rows of an array as poses: seven numbers, x y z and a unit quaternion x y z w, or the sixteen
//! numbers of a 4×4 matrix, row by row.

use hullmap::Pose;
use hullmap::glam::{DMat4, DQuat, DVec3};
use numpy::{PyArray2, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::error::{ArrayError, PoseError};
use crate::pairs::Pairs;

/// Maximum deviation of a quaternion's length from 1. Half-precision numbers deviate by 5e-4. A
/// larger deviation is a sign of exchanged columns.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Poses of one argument, copied while the GIL was held.
pub struct Rows {
    name: String,
    numbers: Vec<f64>,
    width: usize,
}

impl Rows {
    /// Copies the rows of `array`. Fails if the array is not contiguous or has another number of
    /// columns, which the Python code prevents.
    pub fn new(name: &str, array: &PyReadonlyArray2<'_, f64>) -> PyResult<Self> {
        let width = array.shape().last().copied().unwrap_or(0);
        let numbers = array.as_slice().map_err(|error| ArrayError::new_err(format!("{name}: {error}")))?;
        if width != 7 && width != 16 {
            return Err(ArrayError::new_err(format!("{name}: a pose has 7 or 16 numbers, found {width}")));
        }
        Ok(Self { name: name.to_owned(), numbers: numbers.to_vec(), width })
    }

    pub fn count(&self) -> usize {
        self.numbers.len() / self.width
    }

    /// Pose `index`; a single pose serves for every index.
    pub fn get(&self, index: usize) -> Result<Pose, String> {
        let row = if self.count() == 1 { 0 } else { index };
        let name = &self.name;
        let numbers = self.numbers.get(row * self.width..(row + 1) * self.width).unwrap_or_default();
        let pose = match *numbers {
            [x, y, z, i, j, k, w] => {
                let (place, turn) = (DVec3::new(x, y, z), DQuat::from_xyzw(i, j, k, w));
                let length = turn.length();
                // Infinite and zero rotations have errors of their own.
                if length.is_finite() && length > 0.0 && !((length - 1.0).abs() <= UNIT_TOLERANCE) {
                    return Err(format!(
                        "{name}[{row}]: rotation must be a unit quaternion in the order x y z w, found \
                         ({i}, {j}, {k}, {w}) of length {length}: normalise it, or check the order of the columns"
                    ));
                }
                Pose::new(place, turn)
            }
            _ => {
                let columns: [f64; 16] = numbers.try_into().unwrap_or([f64::NAN; 16]);
                Pose::from_matrix(DMat4::from_cols_array(&columns).transpose())
            }
        };
        pose.map_err(|error| format!("{name}[{row}]: {error}"))
    }
}

/// Poses as Python passes them.
#[derive(FromPyObject)]
pub enum PoseArrays<'py> {
    /// Poses of B in A, or poses of A and of B in the world; one for each answer.
    OfPairs(PyReadonlyArray2<'py, f64>, Option<PyReadonlyArray2<'py, f64>>),
    /// Poses in the world, one for each shape.
    #[pyo3(transparent)]
    OfShapes(PyReadonlyArray2<'py, f64>),
}

/// Source of the poses of B in A.
pub enum Poses {
    /// They are given.
    InA(Rows),
    /// They follow from the poses of both in the world.
    InWorld(Rows, Rows),
    /// They follow from the poses of all shapes in the world, at one moment after the other.
    OfShapes(Vec<Pose>),
}

impl Poses {
    /// Fails if the arrays have the wrong number of columns, or different numbers of rows; or a
    /// pose of a shape is rejected.
    pub fn new(arrays: &PoseArrays<'_>) -> PyResult<Self> {
        match arrays {
            PoseArrays::OfPairs(b_in_a, None) => Ok(Self::InA(Rows::new("b_in_a", b_in_a)?)),
            PoseArrays::OfPairs(a, Some(b)) => Self::in_world(a, b),
            // Each pose serves many pairs.
            PoseArrays::OfShapes(shapes) => {
                let rows = Rows::new("in_world", shapes)?;
                let poses = (0..rows.count()).map(|row| rows.get(row)).collect::<Result<_, String>>();
                Ok(Self::OfShapes(poses.map_err(PoseError::new_err)?))
            }
        }
    }

    fn in_world(a: &PyReadonlyArray2<'_, f64>, b: &PyReadonlyArray2<'_, f64>) -> PyResult<Self> {
        let (a, b) = (Rows::new("a_in_world", a)?, Rows::new("b_in_world", b)?);
        if a.count() != b.count() && a.count() != 1 && b.count() != 1 {
            return Err(ArrayError::new_err(format!(
                "a_in_world has {} poses and b_in_world has {}: pass as many for both, or one pose for one of them",
                a.count(),
                b.count()
            )));
        }
        Ok(Self::InWorld(a, b))
    }

    /// Number of answers for these pairs.
    pub fn count(&self, pairs: &Pairs) -> usize {
        match self {
            Self::InA(rows) => rows.count(),
            Self::InWorld(a, b) if a.count() == 1 => b.count(),
            Self::InWorld(a, _) => a.count(),
            Self::OfShapes(poses) => poses.len() / pairs.shape_count().max(1) * pairs.len(),
        }
    }

    /// Pose of B in A for answer `row`.
    pub fn get(&self, row: usize, pairs: &Pairs) -> Result<Pose, String> {
        match self {
            Self::InA(rows) => rows.get(row),
            Self::InWorld(a, b) => Pose::relative(a.get(row)?, b.get(row)?)
                .map_err(|error| format!("b_in_world[{row}] relative to a_in_world: {error}")),
            Self::OfShapes(poses) => {
                let first = row / pairs.len().max(1) * pairs.shape_count();
                let pose = |shape: usize| poses.get(first + shape).copied().unwrap_or(Pose::IDENTITY);
                let [a, b] = pairs.members(row);
                Pose::relative(pose(a), pose(b))
                    .map_err(|error| format!("in_world[{}] relative to in_world[{}]: {error}", first + b, first + a))
            }
        }
    }
}

/// Poses of B in A from the poses of both in the world, as rows of seven numbers.
#[pyfunction]
pub fn relative<'py>(
    py: Python<'py>,
    a_in_world: PyReadonlyArray2<'py, f64>,
    b_in_world: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let poses = Poses::in_world(&a_in_world, &b_in_world)?;
    let pairs = Pairs::default();
    into_rows(py, poses.count(&pairs), |row| poses.get(row, &pairs))
}

/// Matrices as rows of seven numbers. `name` is the name of the argument.
#[pyfunction]
pub fn pose_rows<'py>(
    py: Python<'py>,
    name: &str,
    matrices: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows = Rows::new(name, &matrices)?;
    into_rows(py, rows.count(), |row| rows.get(row))
}

fn into_rows<'py>(
    py: Python<'py>,
    count: usize,
    pose: impl Fn(usize) -> Result<Pose, String>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let mut rows = Vec::with_capacity(count);
    for row in 0..count {
        let pose = pose(row).map_err(PoseError::new_err)?;
        rows.push([pose.translation().to_array().as_slice(), pose.rotation().to_array().as_slice()].concat());
    }
    if rows.is_empty() {
        return Ok(PyArray2::zeros(py, [0, 7], false));
    }
    PyArray2::from_vec2(py, &rows).map_err(|error| ArrayError::new_err(error.to_string()))
}
