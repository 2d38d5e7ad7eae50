//! Rows of an array as poses: seven numbers, x y z and a unit quaternion x y z w, or the sixteen
//! numbers of a 4×4 matrix, row by row.

use hullmap::Pose;
use hullmap::glam::{DMat4, DQuat, DVec3};
use numpy::{PyArray2, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::error::{ArrayError, PoseError};

/// Maximum deviation of a quaternion's length from 1. Half-precision numbers deviate by 5e-4. A
/// larger deviation is a sign of exchanged columns.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Poses of one argument, copied while the GIL was held.
pub struct Rows {
    name: &'static str,
    numbers: Vec<f64>,
    width: usize,
}

impl Rows {
    /// Copies the rows of `array`.
    ///
    /// # Errors
    /// The array is not contiguous or has another number of columns, which the Python code
    /// prevents.
    pub fn new(name: &'static str, array: &PyReadonlyArray2<'_, f64>) -> PyResult<Self> {
        let width = array.shape().last().copied().unwrap_or(0);
        let numbers = array.as_slice().map_err(|error| ArrayError::new_err(format!("{name}: {error}")))?;
        if width != 7 && width != 16 {
            return Err(ArrayError::new_err(format!("{name}: a pose has 7 or 16 numbers, found {width}")));
        }
        Ok(Self { name, numbers: numbers.to_vec(), width })
    }

    pub fn count(&self) -> usize {
        self.numbers.len() / self.width
    }

    /// Pose `index`; a single pose serves for every index.
    pub fn get(&self, index: usize) -> Result<Pose, String> {
        let row = if self.count() == 1 { 0 } else { index };
        let name = self.name;
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

/// Where the poses of B in A come from.
pub enum Poses {
    /// They are given.
    InA(Rows),
    /// They follow from the poses of both in the world.
    InWorld(Rows, Rows),
}

impl Poses {
    /// # Errors
    /// The arrays have the wrong number of columns, or different numbers of rows.
    pub fn new(first: &PyReadonlyArray2<'_, f64>, second: Option<&PyReadonlyArray2<'_, f64>>) -> PyResult<Self> {
        let Some(second) = second else { return Ok(Self::InA(Rows::new("b_in_a", first)?)) };
        let (a, b) = (Rows::new("a_in_world", first)?, Rows::new("b_in_world", second)?);
        if a.count() != b.count() && a.count() != 1 && b.count() != 1 {
            return Err(ArrayError::new_err(format!(
                "a_in_world has {} poses and b_in_world has {}: pass as many for both, or one pose for one of them",
                a.count(),
                b.count()
            )));
        }
        Ok(Self::InWorld(a, b))
    }

    pub fn count(&self) -> usize {
        match self {
            Self::InA(rows) => rows.count(),
            Self::InWorld(a, b) if a.count() == 1 => b.count(),
            Self::InWorld(a, _) => a.count(),
        }
    }

    pub fn get(&self, index: usize) -> Result<Pose, String> {
        match self {
            Self::InA(rows) => rows.get(index),
            Self::InWorld(a, b) => Pose::relative(a.get(index)?, b.get(index)?)
                .map_err(|error| format!("b_in_world[{index}] relative to a_in_world: {error}")),
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
    let poses = Poses::new(&a_in_world, Some(&b_in_world))?;
    let mut rows = Vec::with_capacity(poses.count());
    for index in 0..poses.count() {
        let pose = poses.get(index).map_err(PoseError::new_err)?;
        rows.push([pose.translation().to_array().as_slice(), pose.rotation().to_array().as_slice()].concat());
    }
    if rows.is_empty() {
        return Ok(PyArray2::zeros(py, [0, 7], false));
    }
    PyArray2::from_vec2(py, &rows).map_err(|error| ArrayError::new_err(error.to_string()))
}
