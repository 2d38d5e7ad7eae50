//! `hullmap._hullmap`: the part of the Python package that is written in Rust.
//!
//! The Python files beside it turn arguments of any layout into contiguous arrays, and name the
//! columns of the answers. The interface for users is documented there.
//!
//! | module | concept |
//! |---|---|
//! | `memory` | views of a pack's arrays, maps of files: the unsafe code |
//! | `pack`, `shape` | packs, hulls, and all other shapes |
//! | `mesh`, `field` | triangle meshes and height fields |
//! | `bake` | bakes, on a thread of their own |
//! | `pairs` | pairs of shapes, of which one call queries all |
//! | `pose` | rows of an array as poses |
//! | `query` | the queries, for each pair of kinds of shapes |
//! | `solve` | arrays of poses, on all threads, with the GIL released |
//! | `gpu` | the same on a GPU |
//! | `manifolds` | the same for contact manifolds |
//! | `motion` | the same for shapes that move and turn, and derivatives |
//! | `robot` | whole robots |
//! | `usd` | layers of Universal Scene Description |
//! | `columns` | answers as columns |
//! | `threads` | thread pools that survive `fork` |
//! | `error` | exceptions |
#![deny(unsafe_code)]

mod bake;
mod columns;
mod error;
mod field;
mod gpu;
mod manifolds;
mod memory;
mod mesh;
mod motion;
mod pack;
mod pairs;
mod pose;
mod query;
mod robot;
mod shape;
mod solve;
mod task;
mod threads;
mod usd;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command, and returns its exit code.
#[pyfunction]
fn run_command(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| hullmap_cli::run(words))
}

/// The native module.
// Arrays are copied while the GIL is held, so that no other thread can write to them meanwhile.
#[pymodule(gil_used = true)]
fn _hullmap(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("has_gpu", cfg!(feature = "gpu"))?;
    module.add("Error", py.get_type::<error::Error>())?;
    module.add("ArrayError", py.get_type::<error::ArrayError>())?;
    module.add("PoseError", py.get_type::<error::PoseError>())?;
    module.add("ShapeError", py.get_type::<error::ShapeError>())?;
    module.add("BakeError", py.get_type::<error::BakeError>())?;
    module.add("InvalidPack", py.get_type::<error::InvalidPack>())?;
    module.add("BakeWarning", py.get_type::<error::BakeWarning>())?;
    module.add_class::<pack::Pack>()?;
    module.add_class::<pack::Hull>()?;
    module.add_class::<mesh::TriangleMesh>()?;
    module.add_class::<field::HeightField>()?;
    module.add_class::<shape::Shape>()?;
    module.add_class::<pairs::Pairs>()?;
    module.add_class::<robot::Robot>()?;
    module.add_function(wrap_pyfunction!(run_command, module)?)?;
    module.add_function(wrap_pyfunction!(bake::bake_arrays, module)?)?;
    module.add_function(wrap_pyfunction!(bake::bake_file, module)?)?;
    module.add_function(wrap_pyfunction!(usd::usd_layer, module)?)?;
    module.add_function(wrap_pyfunction!(pose::pose_rows, module)?)?;
    module.add_function(wrap_pyfunction!(pose::relative, module)?)?;
    module.add_function(wrap_pyfunction!(solve::intersects, module)?)?;
    module.add_function(wrap_pyfunction!(solve::distance, module)?)?;
    module.add_function(wrap_pyfunction!(solve::contact, module)?)?;
    module.add_function(wrap_pyfunction!(manifolds::manifold, module)?)?;
    module.add_function(wrap_pyfunction!(manifolds::manifolds, module)?)?;
    module.add_function(wrap_pyfunction!(solve::cast, module)?)?;
    module.add_function(wrap_pyfunction!(motion::cast_motion, module)?)?;
    module.add_function(wrap_pyfunction!(motion::clear, module)?)?;
    module.add_function(wrap_pyfunction!(motion::derivatives, module)?)?;
    module.add_function(wrap_pyfunction!(motion::ray_derivatives, module)?)?;
    module.add_function(wrap_pyfunction!(motion::witness_derivatives, module)?)?;
    module.add_function(wrap_pyfunction!(solve::ray, module)?)?;
    module.add_function(wrap_pyfunction!(solve::signed_distance, module)?)?;
    module.add_function(wrap_pyfunction!(solve::support, module)?)?;
    Ok(())
}
