//! Triangle meshes: static shapes that keep their triangles.

use std::path::PathBuf;
use std::sync::Arc;

use hullmap::{self as core, EdgeClass};
use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};
use numpy::{Element, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::bake::in_python;
use crate::error::{self, ArrayError, BakeError, Error, InvalidPack};
use crate::shape::Shape;

/// An opened triangle mesh.
#[pyclass(frozen, module = "hullmap._hullmap")]
pub struct TriangleMesh {
    mesh: Arc<core::TriangleMesh>,
    path: Option<PathBuf>,
}

impl TriangleMesh {
    fn of_bytes(bytes: &[u8]) -> PyResult<Self> {
        let mesh = core::TriangleMesh::from_bytes(bytes).map_err(|error| InvalidPack::new_err(error.to_string()))?;
        Ok(Self { mesh: Arc::new(mesh), path: None })
    }
}

#[pymethods]
impl TriangleMesh {
    /// Copies a file into memory.
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let mesh = py.detach(|| core::TriangleMesh::open(&path)).map_err(error::of_open)?;
        Ok(Self { mesh: Arc::new(mesh), path: Some(path) })
    }

    #[staticmethod]
    fn from_bytes(py: Python<'_>, bytes: Vec<u8>) -> PyResult<Self> {
        py.detach(|| Self::of_bytes(&bytes))
    }

    /// Bakes rows of vertices, rows of corners, and a number for each triangle, or none.
    #[staticmethod]
    fn from_arrays(
        py: Python<'_>,
        vertices: PyReadonlyArray2<'_, f32>,
        corners: PyReadonlyArray2<'_, u32>,
        materials: PyReadonlyArray1<'_, u16>,
    ) -> PyResult<Self> {
        let wrong = |error: &dyn std::fmt::Display| ArrayError::new_err(error.to_string());
        let positions = vertices.as_slice().map_err(|error| wrong(&error))?.as_chunks().0.to_vec();
        let corners = corners.as_slice().map_err(|error| wrong(&error))?.as_chunks().0.to_vec();
        let materials = materials.as_slice().map_err(|error| wrong(&error))?.to_vec();
        py.detach(|| {
            let triangles = Triangles { positions: &positions, corners: &corners, materials: &materials };
            let file = bake_triangle_mesh(&triangles).and_then(|baked| write_triangle_mesh(baked, &Default::default()));
            Self::of_bytes(&file.map_err(|error| BakeError::new_err(error.to_string()))?)
        })
    }

    /// A copy of the bytes of the whole file.
    fn bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, self.mesh.bytes())
    }

    #[getter]
    fn path(&self) -> Option<&PathBuf> {
        self.path.as_ref()
    }

    /// Everything that the file records, except arrays.
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (mesh, facts) = (&self.mesh, PyDict::new(py));
        facts.set_item("triangles", mesh.triangle_count())?;
        facts.set_item("vertices", mesh.vertex_count())?;
        facts.set_item("merged", mesh.merged_count())?;
        facts.set_item("degenerate", mesh.degenerate_count())?;
        facts.set_item("duplicate", mesh.duplicate_count())?;
        facts.set_item("bounds", mesh.bounds().map(|corner| corner.as_dvec3().to_array()))?;
        facts.set_item("byte_len", mesh.bytes().len())?;
        facts.set_item("source_path", mesh.source_path())?;
        facts.set_item("options", mesh.options())?;
        facts.set_item("warnings", mesh.warnings().map(in_python).collect::<Vec<_>>())?;
        Ok(facts)
    }

    /// A copy of an array by name.
    fn array<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let mesh = &self.mesh;
        let triangles = 0..mesh.triangle_count();
        match name {
            "vertices" => rows(py, (0..mesh.vertex_count()).filter_map(|at| mesh.vertex(at)).map(|at| at.to_array())),
            "triangles" => rows(py, triangles.filter_map(|at| mesh.corners(at))),
            "neighbours" => {
                // -1 for none.
                let number = |neighbour: Option<u32>| neighbour.map_or(-1, i64::from);
                rows(py, triangles.filter_map(|at| mesh.neighbours(at)).map(|row| row.map(number)))
            }
            "edge_classes" => {
                let codes = |classes: [EdgeClass; 3]| classes.map(EdgeClass::code);
                rows(py, triangles.filter_map(|at| mesh.edge_classes(at)).map(codes))
            }
            "vertex_classes" => {
                Ok(row(py, (0..mesh.vertex_count()).filter_map(|at| mesh.vertex_class(at)).map(|class| class.code())))
            }
            "source_triangles" => Ok(row(py, triangles.filter_map(|at| mesh.source_triangle(at)))),
            "materials" => Ok(row(py, triangles.filter_map(|at| mesh.material(at)))),
            _ => Err(Error::new_err(format!("no array has the name {name:?}"))),
        }
    }

    /// The mesh, for queries.
    fn shape(&self) -> Shape {
        Shape(Arc::clone(&self.mesh).into())
    }
}

/// Rows of three numbers.
pub fn rows<'py, T: Element>(py: Python<'py>, rows: impl Iterator<Item = [T; 3]>) -> PyResult<Bound<'py, PyAny>> {
    let rows: Vec<Vec<T>> = rows.map(Vec::from).collect();
    let array = PyArray2::from_vec2(py, &rows).map_err(|error| Error::new_err(error.to_string()))?;
    Ok(array.into_any())
}

/// A row of numbers.
pub fn row<'py, T: Element>(py: Python<'py>, numbers: impl Iterator<Item = T>) -> Bound<'py, PyAny> {
    PyArray1::from_vec(py, numbers.collect()).into_any()
}
