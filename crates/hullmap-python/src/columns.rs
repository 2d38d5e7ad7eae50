//! Answers as columns: each field of an answer is one array over all poses.

use std::ops::Range;

use hullmap::glam::DVec3;
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Columns of one kind of answer.
pub trait Columns: Sized + Send {
    /// The same rows of all columns.
    type Rows<'a>: Send
    where
        Self: 'a;

    /// Columns of this length, filled with zeros. Fails if there is not enough memory.
    fn zeros(count: usize) -> PyResult<Self>;

    /// The rows in `range`, cut into pieces of `size`.
    fn pieces(&mut self, range: Range<usize>, size: usize) -> Vec<Self::Rows<'_>>;

    /// The columns as NumPy arrays, by name. Returns the errors of NumPy.
    fn into_arrays(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>>;
}

/// `count` zeros. An absurd count is an exception instead of the end of the process.
pub fn zeros<T: Clone + Default>(count: usize) -> PyResult<Vec<T>> {
    let error = |_| PyMemoryError::new_err(format!("not enough memory for {count} answers: query fewer at a time"));
    Vec::<T>::new().try_reserve_exact(count).map_err(error)?;
    Ok(vec![T::default(); count])
}

/// Declares columns: the fields, their types, and the number of entries that each row has.
macro_rules! columns {
    ($(#[$doc:meta])* $name:ident, $rows:ident { $($field:ident: $kind:ty = $width:expr),* $(,)? }) => {
        $(#[$doc])*
        pub struct $name {
            $($field: Vec<$kind>,)*
        }

        /// Rows of the columns.
        pub struct $rows<'a> {
            $(pub $field: &'a mut [$kind],)*
        }

        impl Columns for $name {
            type Rows<'a>
                = $rows<'a>
            where
                Self: 'a;

            fn zeros(count: usize) -> PyResult<Self> {
                Ok(Self { $($field: $crate::columns::zeros(count.saturating_mul($width))?,)* })
            }

            fn pieces(&mut self, range: std::ops::Range<usize>, size: usize) -> Vec<$rows<'_>> {
                $(let mut $field = self.$field
                    .get_mut(range.start * $width..range.end * $width)
                    .unwrap_or_default()
                    .chunks_mut(size * $width);)*
                let mut pieces = Vec::new();
                while let ($(Some($field),)*) = ($($field.next(),)*) {
                    pieces.push($rows { $($field,)* });
                }
                pieces
            }

            fn into_arrays(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
                let arrays = PyDict::new(py);
                $(
                    let rows = self.$field.len() / $width;
                    let array = numpy::PyArray1::from_vec(py, self.$field);
                    if $width == 1 {
                        arrays.set_item(stringify!($field), array)?;
                    } else {
                        let array = numpy::PyArrayMethods::reshape(&array, [rows, $width])?;
                        arrays.set_item(stringify!($field), array)?;
                    }
                )*
                Ok(arrays)
            }
        }
    };
}
pub(crate) use columns;

/// The value of a field, which becomes one or more numbers of a row.
pub trait Field {
    /// Type of the numbers.
    type Number;

    /// Writes the value to row `at`.
    fn write(self, column: &mut [Self::Number], at: usize);
}

macro_rules! numbers {
    ($($kind:ty),*) => {
        $(impl Field for $kind {
            type Number = $kind;

            fn write(self, column: &mut [$kind], at: usize) {
                put(column, at, self);
            }
        })*
    };
}
numbers!(bool, u32, f64);

impl Field for DVec3 {
    type Number = f64;

    fn write(self, column: &mut [f64], at: usize) {
        put_vector(column, at, self);
    }
}

/// Writes these fields of an answer to row `at` of the columns of the same names.
macro_rules! put_fields {
    ($rows:expr, $at:expr, $answer:expr; $($field:ident),* $(,)?) => {
        $($crate::columns::Field::write($answer.$field, $rows.$field, $at);)*
    };
}
pub(crate) use put_fields;

/// Writes `value` to entry `at`.
pub fn put<T>(column: &mut [T], at: usize, value: T) {
    if let Some(entry) = column.get_mut(at) {
        *entry = value;
    }
}

/// Writes a vector to row `at`.
pub fn put_vector(column: &mut [f64], at: usize, value: DVec3) {
    put_all(column, at, &value.to_array());
}

/// Writes `values` to row `at`, which is as long.
pub fn put_all<T: Copy>(column: &mut [T], at: usize, values: &[T]) {
    if let Some(row) = column.get_mut(at * values.len()..(at + 1) * values.len()) {
        row.copy_from_slice(values);
    }
}
