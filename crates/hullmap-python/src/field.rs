//! Height fields: static ground whose heights are known on a grid.

use std::path::PathBuf;
use std::sync::Arc;

use hullmap::height_field::{Diagonal, Layout};
use hullmap::{self as core, EdgeClass};
use hullmap_bake::height_field::{HeightGrid, bake_height_field, write_height_field};
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::bake::in_python;
use crate::error::{self, ArrayError, BakeError, Error, InvalidPack};
use crate::mesh::{row, rows};
use crate::shape::Shape;

/// An opened height field.
#[pyclass(frozen, module = "hullmap._hullmap")]
pub struct HeightField {
    field: Arc<core::HeightField>,
    path: Option<PathBuf>,
}

impl HeightField {
    fn of_bytes(bytes: &[u8]) -> PyResult<Self> {
        let field = core::HeightField::from_bytes(bytes).map_err(|error| InvalidPack::new_err(error.to_string()))?;
        Ok(Self { field: Arc::new(field), path: None })
    }
}

#[pymethods]
impl HeightField {
    /// Copies a file into memory.
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let field = py.detach(|| core::HeightField::open(&path)).map_err(error::of_open)?;
        Ok(Self { field: Arc::new(field), path: Some(path) })
    }

    #[staticmethod]
    fn from_bytes(py: Python<'_>, bytes: Vec<u8>) -> PyResult<Self> {
        py.detach(|| Self::of_bytes(&bytes))
    }

    /// Bakes rows of heights; holes and materials are by cell, row by row, or empty.
    #[staticmethod]
    fn from_array(
        py: Python<'_>,
        heights: PyReadonlyArray2<'_, f32>,
        grid: ([f64; 2], [f64; 2], String),
        holes: PyReadonlyArray1<'_, bool>,
        materials: PyReadonlyArray1<'_, u16>,
    ) -> PyResult<Self> {
        let wrong = |error: &dyn std::fmt::Display| ArrayError::new_err(error.to_string());
        let (origin, spacing, diagonal) = grid;
        let Some(diagonal) = Diagonal::ALL.into_iter().find(|known| known.as_str() == diagonal) else {
            let known = Diagonal::ALL.map(Diagonal::as_str).join("\" or \"");
            return Err(ArrayError::new_err(format!("diagonal: expected \"{known}\", found \"{diagonal}\"")));
        };
        let (rows, columns) = (heights.shape().first(), heights.shape().get(1));
        let (rows, columns) = (rows.copied().unwrap_or_default(), columns.copied().unwrap_or_default());
        let heights = heights.as_slice().map_err(|error| wrong(&error))?.to_vec();
        let holes = holes.as_slice().map_err(|error| wrong(&error))?.to_vec();
        let materials = materials.as_slice().map_err(|error| wrong(&error))?.to_vec();
        py.detach(|| {
            let layout = Layout { columns, rows, origin, spacing, diagonal };
            let grid = HeightGrid { layout, heights: &heights, holes: &holes, materials: &materials };
            let file = bake_height_field(&grid).and_then(|baked| write_height_field(baked, &Default::default()));
            Self::of_bytes(&file.map_err(|error| BakeError::new_err(error.to_string()))?)
        })
    }

    /// A copy of the bytes of the whole file.
    fn bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, self.field.bytes())
    }

    #[getter]
    fn path(&self) -> Option<&PathBuf> {
        self.path.as_ref()
    }

    /// Everything that the file records, except arrays.
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (field, facts) = (&self.field, PyDict::new(py));
        let Layout { columns, rows, origin, spacing, diagonal } = *field.layout();
        facts.set_item("columns", columns)?;
        facts.set_item("rows", rows)?;
        facts.set_item("origin", origin)?;
        facts.set_item("spacing", spacing)?;
        facts.set_item("diagonal", diagonal.as_str())?;
        facts.set_item("holes", field.hole_count())?;
        facts.set_item("triangles", field.triangle_count())?;
        facts.set_item("bounds", field.bounds().map(|corner| corner.to_array()))?;
        facts.set_item("byte_len", field.bytes().len())?;
        facts.set_item("source_path", field.source_path())?;
        facts.set_item("options", field.options())?;
        facts.set_item("warnings", field.warnings().map(in_python).collect::<Vec<_>>())?;
        Ok(facts)
    }

    /// A copy of an array by name. Triangles in holes have rows, too.
    fn array<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let (field, layout) = (&self.field, self.field.layout());
        let triangles = 0..field.triangle_count();
        let vertices = || (0..layout.rows).flat_map(|row| (0..layout.columns).map(move |column| (column, row)));
        match name {
            "vertices" => {
                let at = |(column, row): (usize, usize)| field.vertex(column, row).map(|vertex| vertex.to_array());
                rows(py, vertices().filter_map(at))
            }
            "triangles" => {
                rows(py, triangles.map(|at| layout.corners(at).map(|[column, row]| layout.vertex(column, row) as u32)))
            }
            "neighbours" => {
                // -1 for none.
                let number = |neighbour: Option<usize>| neighbour.map_or(-1, |own| own as i64);
                rows(py, triangles.map(|at| field.neighbours(at).map_or([-1; 3], |row| row.map(number))))
            }
            "edge_classes" => {
                let codes = |classes: [EdgeClass; 3]| classes.map(EdgeClass::code);
                rows(py, triangles.map(|at| field.edge_classes(at).map_or([0; 3], codes)))
            }
            "materials" => Ok(row(py, triangles.step_by(2).map(|at| field.material(at).unwrap_or_default()))),
            "holes" => Ok(row(py, triangles.step_by(2).map(|at| field.triangle(at).is_none()))),
            _ => Err(Error::new_err(format!("no array has the name {name:?}"))),
        }
    }

    /// Heights of the ground at rows of x and y; NaN in holes and beyond the field.
    fn heights_at<'py>(&self, py: Python<'py>, points: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyAny>> {
        let points = points.as_slice().map_err(|error| ArrayError::new_err(error.to_string()))?.as_chunks().0;
        let height = |[x, y]: [f64; 2]| self.field.height_at(x, y).map_or(f64::NAN, |ground| ground.height);
        Ok(row(py, points.iter().copied().map(height)))
    }

    /// The field, for queries.
    fn shape(&self) -> Shape {
        Shape(Arc::clone(&self.field).into())
    }
}
