//! How the parts of an object fit together, and whether a physics engine can use them.

use glam::Vec3;
use hullmap::Hull;
use hullmap_bake::advice::usability::{Doubt, ObjectMeasures, PartMeasures, doubts, thickness};
use hullmap_bake::decompose::Cover;
use hullmap_bake::{PointSet, hull};

use crate::geometry::rebuilt;
use hullmap_bake::parts::estimates::PartsEstimates;
use hullmap_bake::parts::measure::solid_of;

/// Findings about the parts of one object.
#[derive(Debug, Default)]
pub struct PartsFindings {
    /// How they fit together.
    pub estimates: PartsEstimates,
    /// Mean protrusion of each part, where it is known.
    pub means: Vec<Option<f64>>,
    /// Why an engine cannot use them well; empty if it can.
    pub doubts: Vec<Doubt>,
}

/// Compares the parts of one object with each other, and with their mesh if it is known; `volume`
/// is the volume of its solid. `cover` are the parameters that the pack records. `None` for a hull
/// that is not a part, or the only part of an object that was not cut.
pub fn findings(
    hulls: &[Hull],
    mesh: Option<&PointSet>,
    volume: Option<f64>,
    cover: Option<&Cover>,
) -> Option<PartsFindings> {
    let first = hulls.first().filter(|first| first.part_count() > 0)?;
    let is_made = |hull: &Hull| (0..hull.vertex_count() as u32).any(|vertex| hull.source_vertex(vertex).is_none());
    if hulls.len() == 1 && !(cover.is_some_and(|cover| cover.max_parts != Some(1)) && is_made(first)) {
        return None;
    }
    let built: Option<Vec<hull::Hull>> = hulls.iter().map(rebuilt).collect();
    let built = built.as_ref().map(|built| built.iter().collect::<Vec<_>>());
    let mesh = mesh.filter(|mesh| !mesh.triangles.is_empty());
    let (estimates, means) = match (&built, mesh) {
        (Some(built), Some(mesh)) => PartsEstimates::new(mesh, &solid_of(mesh, cover), built, volume, None),
        (Some(built), None) => (PartsEstimates::without_mesh(built), vec![None; hulls.len()]),
        (None, _) => (PartsEstimates::default(), vec![None; hulls.len()]),
    };
    let of_part = |hull: &Hull| thickness(hull.volume(), hull.surface_area());
    let names: Vec<&str> = hulls.iter().map(Hull::name).collect();
    let parts: Vec<PartMeasures> = hulls
        .iter()
        .zip(&names)
        .map(|(hull, name)| PartMeasures { name, thickness: of_part(hull), protrusion: hull.protrusion() })
        .collect();
    let object = ObjectMeasures {
        name: mesh.map_or_else(|| names[0].rsplit_once("_part_").map_or(names[0], |(name, _)| name), |mesh| &mesh.name),
        diagonal: mesh.map_or_else(|| around(hulls), PointSet::diagonal),
        solid: first.solid(),
        uncovered: first.uncovered().unwrap_or(0.0),
        overlap: estimates.overlap,
        overlap_error: estimates.overlap_error.unwrap_or(0.0),
        parts: &parts,
        is_cut: true,
        cover,
    };
    Some(PartsFindings { doubts: doubts(&object), estimates, means })
}

fn around(hulls: &[Hull]) -> f64 {
    let [mut low, mut high] = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    for [from, to] in hulls.iter().map(Hull::bounds) {
        (low, high) = (low.min(from), high.max(to));
    }
    low.as_dvec3().distance(high.as_dvec3())
}
