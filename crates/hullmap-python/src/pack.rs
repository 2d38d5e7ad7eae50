//! Packs and hulls: facts, and arrays without a copy.

use std::path::PathBuf;
use std::sync::Arc;

use hullmap::{self as core, SharedHull};
use pyo3::exceptions::{PyIndexError, PyKeyError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::error::{self, Error, InvalidPack};
use crate::memory;
use crate::shape::Shape;
use crate::threads::{self, Threads};

/// An opened pack.
#[pyclass(frozen, module = "hullmap._hullmap")]
pub struct Pack {
    pack: Arc<core::Pack>,
    path: Option<PathBuf>,
    notes: Vec<String>,
}

impl Pack {
    pub fn baked(bytes: &[u8], notes: Vec<String>) -> PyResult<Self> {
        let pack = core::Pack::from_bytes(bytes).map_err(|error| InvalidPack::new_err(error.to_string()))?;
        Ok(Self { pack: Arc::new(pack), path: None, notes })
    }

    /// The pack of the crate.
    pub fn core(&self) -> &core::Pack {
        &self.pack
    }
}

#[pymethods]
impl Pack {
    /// Maps a file, or copies it.
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf, mmap: bool) -> PyResult<Self> {
        // Large packs are checked by two threads.
        let pool = threads::pool(Threads::default())?;
        let opened = py.detach(|| pool.install(|| if mmap { memory::map(&path) } else { core::Pack::open(&path) }));
        let pack = Arc::new(opened.map_err(error::of_open)?);
        Ok(Self { pack, path: Some(path), notes: Vec::new() })
    }

    #[staticmethod]
    fn from_bytes(py: Python<'_>, bytes: Vec<u8>) -> PyResult<Self> {
        let pool = threads::pool(Threads::default())?;
        py.detach(|| pool.install(|| Self::baked(&bytes, Vec::new())))
    }

    /// A copy of the bytes of the whole file.
    fn bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, self.pack.bytes())
    }

    #[getter]
    fn path(&self) -> Option<&PathBuf> {
        self.path.as_ref()
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    #[getter]
    fn byte_len(&self) -> usize {
        self.pack.byte_len()
    }

    #[getter]
    fn source_path(&self) -> &str {
        self.pack.source_path()
    }

    #[getter]
    fn options(&self) -> &str {
        self.pack.options()
    }

    fn __len__(&self) -> usize {
        self.pack.hull_count()
    }

    fn names(&self) -> Vec<String> {
        self.pack.hulls().map(|hull| hull.name().to_owned()).collect()
    }

    /// Hull of an index from 0.
    fn hull(&self, index: usize) -> PyResult<Hull> {
        let hull = self.pack.shared_hull(index).map_err(|error| PyIndexError::new_err(error.to_string()))?;
        Ok(Hull { hull })
    }

    fn hull_named(&self, name: &str) -> PyResult<Hull> {
        let hull = self.pack.shared_hull_named(name).map_err(|error| PyKeyError::new_err(error.to_string()))?;
        Ok(Hull { hull })
    }

    /// Mass properties of hulls as one body: mass, centre, rows of the tensor, and their source.
    fn mass_properties(&self, hulls: Vec<usize>, density: f64) -> PyResult<Mass> {
        let found = self.pack.mass_properties_of(hulls, density);
        found.map(|found| mass(&found)).map_err(|error| PyIndexError::new_err(error.to_string()))
    }

    /// Compares the data that the file holds twice.
    fn check_repeats(&self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| self.pack.check_repeats()).map_err(|error| InvalidPack::new_err(error.to_string()))
    }

    /// The union of all hulls, for queries.
    fn shape(&self) -> Shape {
        Shape(Arc::clone(&self.pack).into())
    }
}

/// Mass, centre of mass, rows of the inertia tensor, and the name of their source.
type Mass = (f64, [f64; 3], [[f64; 3]; 3], &'static str);

fn mass(found: &core::MassProperties) -> Mass {
    let inertia = found.inertia.transpose().to_cols_array_2d();
    (found.mass, found.center_of_mass.to_array(), inertia, found.source.as_str())
}

/// A hull of a pack.
#[pyclass(frozen, module = "hullmap._hullmap")]
pub struct Hull {
    hull: SharedHull,
}

#[pymethods]
impl Hull {
    fn shape(&self) -> Shape {
        Shape(self.hull.clone().into())
    }

    #[getter]
    fn index(&self) -> usize {
        self.hull.index()
    }

    #[getter]
    fn name(&self) -> &str {
        self.hull.hull().name()
    }

    /// Everything that the pack records about the hull, except arrays.
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let hull = self.hull.hull();
        let facts = PyDict::new(py);
        let (_, _, inertia, _) = mass(&hull.mass_properties(1.0));
        facts.set_item("rank", hull.rank())?;
        facts.set_item("volume", hull.volume())?;
        facts.set_item("surface_area", hull.surface_area())?;
        facts.set_item("diameter", hull.diameter())?;
        facts.set_item("centroid", hull.centroid().to_array())?;
        facts.set_item("inertia", inertia)?;
        facts.set_item("mesh", hull.mesh_mass_properties(1.0).as_ref().map(mass))?;
        facts.set_item("bounds", hull.bounds().map(|corner| corner.as_dvec3().to_array()))?;
        facts.set_item("containment_error", hull.containment_error())?;
        facts.set_item("outer_error", hull.outer_error())?;
        facts.set_item("solid", hull.solid().map(hullmap::SolidKind::as_str))?;
        facts.set_item("uncovered", hull.uncovered())?;
        facts.set_item("protrusion", hull.protrusion())?;
        facts.set_item("protrusion_at", hull.protrusion_at().map(|at| at.to_array()))?;
        facts.set_item("voids", hull.voids().map(|voids| (voids.share, voids.error)))?;
        let primitive = hull.primitive().map(|found| {
            let core::Replacement { kind, center, rotation, sizes, protrusion } = found;
            (kind.as_str(), center.to_array(), rotation.to_array(), sizes, protrusion)
        });
        facts.set_item("primitive", primitive)?;
        facts.set_item("origin", hull.origin().to_array())?;
        facts.set_item("part", hull.part())?;
        facts.set_item("part_count", hull.part_count())?;
        facts.set_item("index_kind", hull.index_kind().to_string())?;
        facts.set_item("index_bytes", hull.index_byte_len())?;
        facts.set_item("source_point_count", hull.source_point_count())?;
        Ok(facts)
    }

    /// An array of the pack by name, without a copy.
    fn array<'py>(this: Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let owner = this.clone().into_any();
        let arrays = this.get().hull.hull().arrays();
        let arrays = arrays.ok_or_else(|| {
            Error::new_err("arrays require a little-endian processor, like the numbers of a pack: use another machine")
        })?;
        let numbers = match name {
            "vertices" => return Ok(memory::view(owner, arrays.vertices).into_any()),
            "source_vertices" => arrays.source_vertices,
            "face_starts" => arrays.face_starts,
            "face_vertices" => arrays.face_vertices,
            "neighbour_starts" => arrays.neighbour_starts,
            "neighbours" => arrays.neighbours,
            _ => return Err(Error::new_err(format!("no array has the name {name:?}"))),
        };
        Ok(memory::view(owner, numbers.as_chunks::<1>().0).into_any())
    }
}
