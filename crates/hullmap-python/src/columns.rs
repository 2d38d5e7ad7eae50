//! Answers as columns: each field of an answer is one array over all poses.

use std::ops::Range;

use hullmap::{Fields, Value};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Type of the values of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Flag,
    /// A number of a word, as in `hullmap.Status`; or a small count.
    Code,
    Count,
    Number,
}

/// Name of a column, kind, and number of entries of each row.
pub type Spec = (&'static str, Kind, usize);

/// Numbers of one kind: a column, or a slice of one.
enum Cells<F, C, N, X> {
    Flags(F),
    Codes(C),
    Counts(N),
    Numbers(X),
}

type Whole = Cells<Vec<bool>, Vec<u8>, Vec<u32>, Vec<f64>>;
type Piece<'a> = Cells<&'a mut [bool], &'a mut [u8], &'a mut [u32], &'a mut [f64]>;

/// Answers of many poses.
#[derive(Default)]
pub struct Columns(Vec<(&'static str, usize, Whole)>);

/// The same rows of all columns.
pub struct Rows<'a>(Vec<Piece<'a>>);

/// One row. Its values are put in the order of the columns.
pub struct Row<'a, 'r> {
    columns: std::slice::IterMut<'r, Piece<'a>>,
    at: usize,
}

/// `count` zeros. An absurd count is an exception instead of the end of the process.
fn zeros<T: Clone + Default>(count: usize, width: usize) -> PyResult<Vec<T>> {
    let error = |_| PyMemoryError::new_err(format!("not enough memory for {count} answers: query fewer at a time"));
    let length = count.saturating_mul(width);
    Vec::<T>::new().try_reserve_exact(length).map_err(error)?;
    Ok(vec![T::default(); length])
}

impl Columns {
    /// Columns filled with zeros. Fails if there is not enough memory.
    pub fn zeros(count: usize, columns: &[Spec]) -> PyResult<Self> {
        Self::default().with(count, columns)
    }

    /// Columns of an answer: its fields.
    pub fn of<T: Fields>(count: usize) -> PyResult<Self> {
        let spec = |(name, value)| match value {
            Value::Flag(_) => (name, Kind::Flag, 1),
            Value::Word(..) => (name, Kind::Code, 1),
            Value::Count(_) => (name, Kind::Count, 1),
            Value::Parts(_) => (name, Kind::Count, 2),
            Value::Number(_) => (name, Kind::Number, 1),
            Value::Vector(_) => (name, Kind::Number, 3),
        };
        Self::zeros(count, &T::default().fields().map(spec).collect::<Vec<_>>())
    }

    /// With these columns after those that there are.
    pub fn with(mut self, count: usize, columns: &[Spec]) -> PyResult<Self> {
        for &(name, kind, width) in columns {
            let cells = match kind {
                Kind::Flag => Whole::Flags(zeros(count, width)?),
                Kind::Code => Whole::Codes(zeros(count, width)?),
                Kind::Count => Whole::Counts(zeros(count, width)?),
                Kind::Number => Whole::Numbers(zeros(count, width)?),
            };
            self.0.push((name, width, cells));
        }
        Ok(self)
    }

    /// The rows in `range`, cut into pieces of `size`.
    pub fn pieces(&mut self, range: Range<usize>, size: usize) -> Vec<Rows<'_>> {
        let mut pieces: Vec<_> = range.clone().step_by(size).map(|_| Rows(Vec::new())).collect();
        for (_, width, cells) in &mut self.0 {
            let (range, size) = (range.start * *width..range.end * *width, size * *width);
            macro_rules! cut {
                ($($kind:ident)*) => {
                    match cells {
                        $(Whole::$kind(cells) => {
                            let cells = cells.get_mut(range).unwrap_or_default().chunks_mut(size);
                            pieces.iter_mut().zip(cells).for_each(|(piece, cells)| piece.0.push(Piece::$kind(cells)));
                        })*
                    }
                };
            }
            cut!(Flags Codes Counts Numbers);
        }
        pieces
    }

    /// The columns as NumPy arrays, by name. Returns the errors of NumPy.
    pub fn into_arrays(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        fn array<'py, T: numpy::Element>(py: Python<'py>, cells: Vec<T>, width: usize) -> PyResult<Bound<'py, PyAny>> {
            let (rows, array) = (cells.len() / width, PyArray1::from_vec(py, cells));
            Ok(if width == 1 { array.into_any() } else { array.reshape([rows, width])?.into_any() })
        }
        let arrays = PyDict::new(py);
        for (name, width, cells) in self.0 {
            let array = match cells {
                Whole::Flags(cells) => array(py, cells, width),
                Whole::Codes(cells) => array(py, cells, width),
                Whole::Counts(cells) => array(py, cells, width),
                Whole::Numbers(cells) => array(py, cells, width),
            };
            arrays.set_item(name, array?)?;
        }
        Ok(arrays)
    }
}

impl<'a> Rows<'a> {
    /// Row `at`, whose first value is put next.
    pub fn row(&mut self, at: usize) -> Row<'a, '_> {
        Row { columns: self.0.iter_mut(), at }
    }

    /// Puts an answer into row `at`.
    pub fn put<T: Fields>(&mut self, at: usize, answer: &T) {
        self.row(at).answer(answer);
    }
}

impl Row<'_, '_> {
    /// Puts all fields of an answer.
    pub fn answer(self, answer: &impl Fields) -> Self {
        answer.fields().fold(self, |row, (_, value)| row.put(value))
    }

    /// Puts a value.
    pub fn put(mut self, value: impl Into<Value>) -> Self {
        match (self.columns.next(), value.into()) {
            (Some(Piece::Flags(cells)), Value::Flag(flag)) => copy(cells, self.at, &[flag]),
            (Some(Piece::Codes(cells)), Value::Word(_, code)) => copy(cells, self.at, &[code as u8]),
            (Some(Piece::Codes(cells)), Value::Count(count)) => copy(cells, self.at, &[count as u8]),
            (Some(Piece::Counts(cells)), Value::Count(count)) => copy(cells, self.at, &[count]),
            (Some(Piece::Counts(cells)), Value::Parts(parts)) => copy(cells, self.at, &parts),
            (Some(Piece::Numbers(cells)), Value::Number(number)) => copy(cells, self.at, &[number]),
            (Some(Piece::Numbers(cells)), Value::Vector(vector)) => copy(cells, self.at, &vector.to_array()),
            (_, value) => debug_assert!(false, "no column for {value:?}"),
        }
        self
    }

    /// Puts as many numbers as the column has in a row.
    pub fn numbers(mut self, numbers: &[f64]) -> Self {
        match self.columns.next() {
            Some(Piece::Numbers(cells)) => copy(cells, self.at, numbers),
            _ => debug_assert!(false, "no column for {numbers:?}"),
        }
        self
    }
}

/// Copies `row` to row `at`, which is as long.
fn copy<T: Copy>(cells: &mut [T], at: usize, row: &[T]) {
    if let Some(cells) = cells.get_mut(at * row.len()..(at + 1) * row.len()) {
        cells.copy_from_slice(row);
    }
}
