//! The calls into the baking crate, all of them.

use hullmap_bake::{BakedHull, IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
use rayon::prelude::*;

use crate::import::advice::{self, HullFacts};
use crate::options::BuildOptions;

/// A pack in memory.
#[derive(Clone, Debug, Default)]
pub struct BakedPack {
    /// The bytes of the file.
    pub bytes: Vec<u8>,
    /// Rank of each hull.
    pub ranks: Vec<u32>,
    /// Vertices over all hulls.
    pub vertex_count: usize,
    /// What the user may want to know of the bake.
    pub notes: Vec<String>,
    /// What the user should look at.
    pub warnings: Vec<String>,
}

/// Builds, certifies and indexes a hull of each point set, and puts them into one pack.
///
/// # Errors
/// The first hull, in their order, that could not be baked, by name.
pub fn bake_pack(point_sets: &[PointSet], options: &BuildOptions, source: &SourceRecord) -> Result<BakedPack, String> {
    let baked: Vec<_> = point_sets.par_iter().map(|points| bake_hull(points, options.index)).collect();
    let mut hulls = Vec::with_capacity(baked.len());
    for (hull, points) in baked.into_iter().zip(point_sets) {
        hulls.push(hull.map_err(|error| format!("hull {}: {error}", points.name))?);
    }
    let bytes = write_pack(&hulls, source).map_err(|error| error.to_string())?;
    let ranks = hulls.iter().map(|baked| baked.hull.rank).collect();
    let vertex_count = hulls.iter().map(|baked| baked.hull.vertices.len()).sum();
    let mut notes = Vec::new();
    if let IndexKind::Budget { bytes_per_vertex } = options.index {
        notes.extend(hulls.iter().map(|baked| budget_note(baked, bytes_per_vertex)));
    }
    let warnings = hulls.iter().flat_map(|baked| advice::of_hull(&facts(baked))).collect();
    Ok(BakedPack { bytes, ranks, vertex_count, notes, warnings })
}

/// What warnings are given by.
fn facts(baked: &BakedHull) -> HullFacts<'_> {
    let coordinates = baked.hull.vertices.iter().flatten();
    HullFacts {
        name: &baked.name,
        rank: baked.hull.rank,
        point_count: baked.point_count,
        vertex_count: baked.hull.vertices.len(),
        diameter: baked.hull.diameter,
        inner_radius: baked.interior.inner_radius,
        greatest_coordinate: coordinates.map(|x| f64::from(x.abs())).fold(0.0, f64::max),
    }
}

/// Which index a budget bought.
fn budget_note(baked: &BakedHull, bytes_per_vertex: u32) -> String {
    let vertex_count = baked.hull.vertices.len();
    let chosen = baked.index.describe(vertex_count);
    let is_kept = baked.index.byte_len() <= bytes_per_vertex as usize * vertex_count;
    let verdict = if is_kept { "" } else { ": above the budget, but nothing is smaller" };
    format!("hull {}: {chosen}{verdict}", baked.name)
}
