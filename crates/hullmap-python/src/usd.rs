//! Layers of Universal Scene Description (USD): packs and prims from Python, as text. Python reads
//! the stage; the layer is written by the code of `bake export --for usd`.

use hullmap_import::UpAxis;
use hullmap_pipeline::mesh_file::usda::{self, UsdGroup, UsdLayer, UsdMass};
use pyo3::prelude::*;

use crate::error::BakeError;
use crate::pack::Pack;

/// The stage that a layer is for: a dictionary in Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Stage {
    asset: Option<String>,
    default_prim: Option<String>,
    meters_per_unit: f64,
    kilograms_per_unit: f64,
    up_axis: char,
}

/// Hulls that stand for one mesh: a dictionary in Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Group {
    parent: String,
    name: String,
    mesh: String,
    transform: Option<[[f64; 4]; 4]>,
    resets_transforms: bool,
    pack: Py<Pack>,
    hulls: Vec<usize>,
    /// In the stage's unit of mass; in its place a density; `None` for both: no mass is written.
    mass: Option<f64>,
    density: Option<f64>,
    scale: [f64; 3],
}

impl Group {
    fn of_layer(&self) -> UsdGroup<'_> {
        let scale = self.scale;
        let mass = match (self.mass, self.density) {
            (Some(mass), _) => UsdMass::Total { mass, scale },
            (None, Some(density)) => UsdMass::Density { density, scale },
            (None, None) => UsdMass::None,
        };
        UsdGroup {
            parent: self.parent.clone(),
            name: self.name.clone(),
            mesh: self.mesh.clone(),
            transform: self.transform,
            resets_transforms: self.resets_transforms,
            pack: self.pack.get().core(),
            hulls: self.hulls.clone(),
            rotation: UpAxis::Keep,
            mass,
        }
    }
}

/// The layer as text, and the meshes whose mass comes from their hulls.
#[pyfunction]
pub fn usd_layer(stage: Stage, groups: Vec<Group>, off: Vec<String>) -> PyResult<(String, Vec<String>)> {
    let layer = UsdLayer {
        asset: stage.asset,
        default_prim: stage.default_prim,
        meters_per_unit: stage.meters_per_unit,
        kilograms_per_unit: stage.kilograms_per_unit,
        up_axis: stage.up_axis,
        groups: groups.iter().map(Group::of_layer).collect(),
        off,
    };
    usda::write(&layer).map_err(|error| BakeError::new_err(error.to_string()))
}
