//! Pairs of shapes that a single call queries: two shapes under many poses, or many pairs of any
//! shapes.

use std::sync::{Mutex, OnceLock};

use hullmap::{Cache, SharedGeometry};
use numpy::PyReadonlyArray1;
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;

use crate::error::{ArrayError, ShapeError};
use crate::query::{cache_of, obstacle};
use crate::shape::Shape;

/// Shapes, and pairs of them by their indices.
///
/// Answer `row` belongs to pair `row % len`: all pairs at one moment, then all at the next.
#[pyclass(frozen, module = "hullmap._hullmap")]
#[derive(Default)]
pub struct Pairs {
    shapes: Vec<SharedGeometry>,
    members: Vec<[u32; 2]>,
    /// Memory of each pair from call to call. Created by the first query of a motion.
    memory: OnceLock<Vec<Mutex<Cache>>>,
}

impl Pairs {
    fn two(a: &Shape, b: &Shape) -> Self {
        Self { shapes: vec![a.0.clone(), b.0.clone()], members: vec![[0, 1]], memory: OnceLock::new() }
    }

    /// Number of pairs.
    pub fn len(&self) -> usize {
        self.members.len()
    }

    /// Number of shapes.
    pub fn shape_count(&self) -> usize {
        self.shapes.len()
    }

    /// Indices of the shapes of answer `row`.
    pub fn members(&self, row: usize) -> [usize; 2] {
        let members = self.members.get(row % self.len().max(1)).copied().unwrap_or_default();
        members.map(|shape| shape as usize)
    }

    /// The shapes of answer `row`. `None` if there are no pairs.
    pub fn sides(&self, row: usize) -> Option<[&SharedGeometry; 2]> {
        let [a, b] = self.members(row);
        Some([self.shapes.get(a)?, self.shapes.get(b)?])
    }

    /// All shapes.
    pub fn shapes(&self) -> &[SharedGeometry] {
        &self.shapes
    }

    /// The memory of each pair. Fails if there is not enough memory.
    pub fn memory(&self) -> PyResult<&[Mutex<Cache>]> {
        if let Some(memory) = self.memory.get() {
            return Ok(memory);
        }
        let mut made = Vec::new();
        made.try_reserve_exact(self.len()).map_err(|_| {
            PyMemoryError::new_err(format!("not enough memory for {} pairs: query fewer at a time", self.len()))
        })?;
        made.extend((0..self.len()).filter_map(|pair| self.sides(pair)).map(|sides| Mutex::new(cache_of(sides))));
        Ok(self.memory.get_or_init(|| made))
    }

    /// Fails if a pair cannot be queried.
    pub fn check(&self, query: &str, takes_parts: bool) -> PyResult<()> {
        let found = (0..self.len()).find_map(|pair| {
            let [a, b] = self.sides(pair)?;
            Some((pair, obstacle(query, a, b, takes_parts)?))
        });
        match found {
            None => Ok(()),
            Some((_, obstacle)) if self.len() == 1 => Err(ShapeError::new_err(obstacle)),
            Some((pair, obstacle)) => Err(ShapeError::new_err(format!("pair {pair}: {obstacle}"))),
        }
    }
}

#[pymethods]
impl Pairs {
    #[new]
    fn new(
        shapes: Vec<PyRef<'_, Shape>>,
        a: PyReadonlyArray1<'_, u32>,
        b: PyReadonlyArray1<'_, u32>,
    ) -> PyResult<Self> {
        let members: Vec<[u32; 2]> = a.as_array().iter().zip(b.as_array()).map(|(a, b)| [*a, *b]).collect();
        let (count, wrong) = (shapes.len(), |shape: &u32| *shape as usize >= shapes.len());
        for (at, pair) in members.iter().enumerate() {
            if let Some((name, shape)) = ["a", "b"].iter().zip(pair).find(|(_, shape)| wrong(shape)) {
                let range = format!("there are {count} shapes, counted from 0");
                return Err(ArrayError::new_err(format!("{name}[{at}]: index {shape} is out of range: {range}")));
            }
        }
        let shapes = shapes.iter().map(|shape| shape.0.clone()).collect();
        Ok(Self { shapes, members, memory: OnceLock::new() })
    }
}

/// The pairs of a query.
pub enum Queried<'py> {
    /// Two shapes.
    Two(Pairs),
    /// Many pairs.
    Many(Bound<'py, Pairs>),
}

impl<'py> FromPyObject<'_, 'py> for Queried<'py> {
    type Error = PyErr;

    fn extract(argument: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(pairs) = argument.cast::<Pairs>() {
            return Ok(Self::Many(pairs.to_owned()));
        }
        let (a, b): (PyRef<'_, Shape>, PyRef<'_, Shape>) = argument.extract()?;
        Ok(Self::Two(Pairs::two(&a, &b)))
    }
}

impl Queried<'_> {
    pub fn get(&self) -> &Pairs {
        match self {
            Self::Two(pairs) => pairs,
            Self::Many(pairs) => pairs.get(),
        }
    }
}
