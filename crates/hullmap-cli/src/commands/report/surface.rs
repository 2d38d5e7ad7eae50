//! Gathers what the report shows about a triangle mesh or height field: its verification and
//! remarks.

use std::path::Path;

use hullmap::Asset;
use hullmap_report::input::Remarks;
use hullmap_report::surface::{Checks, SurfaceInput, SurfaceReport};

use super::source::{frame_of, source_name};
use crate::args::ReportArgs;
use hullmap_pipeline::content::{Verified, verify};
use hullmap_pipeline::open::kept_warnings;
use hullmap_pipeline::options::BuildOptions;
use hullmap_pipeline::packs::PackPlace;
use hullmap_pipeline::source::Source;
use hullmap_pipeline::triangle_mesh::{MeshSummary, t_junctions_of};

/// Faults are part of the report.
pub fn analyse_surface(
    place: &PackPlace,
    asset: &Asset,
    source: Option<Source>,
    absent: &str,
    args: &ReportArgs,
    faults: Vec<String>,
) -> SurfaceReport {
    let mut remarks = Remarks { warnings: kept_warnings(asset), faults, ..Remarks::default() };
    if source.is_none() {
        let warning = format!("{absent} the file was compared with itself only; name the source with --source");
        remarks.warnings.insert(0, warning);
    }
    let content = source.as_ref().map(|source| &source.content);
    let checks = match verify(asset, content, args.directions, args.seed) {
        Ok(Verified::Surface(found)) => {
            remarks.faults.extend(found.problems.iter().cloned());
            Some(Checks {
                rays: found.rays.unwrap_or_default(),
                ray_hits: found.ray_hits.unwrap_or_default(),
                points: found.points,
                seed: args.seed,
                mismatches: found.mismatches.unwrap_or_default(),
            })
        }
        Ok(Verified::Hulls(_)) => None,
        Err(fault) => {
            remarks.faults.push(fault);
            None
        }
    };
    let mut t_junctions = 0;
    if let Asset::TriangleMesh(mesh) = asset {
        t_junctions = t_junctions_of(mesh).count;
        let flaws = MeshSummary { t_junctions: Some(t_junctions), ..MeshSummary::of_file(mesh) }.flaws();
        remarks.notes.extend((flaws != "none").then(|| format!("kept as they are: {flaws}")));
    }
    remarks.notes.extend(content.into_iter().flat_map(|content| content.remarks()[0].iter().cloned()));
    let mesh_path = source.as_ref().map_or(Path::new(asset.source_path()), |source| &source.path);
    SurfaceReport::new(SurfaceInput {
        frame: frame_of(mesh_path, asset.options(), args.up),
        path: &place.path,
        asset,
        source: source.map(|source| source_name(&source, asset.source_path())),
        options: BuildOptions::recorded_in_words(asset.options()),
        remarks,
        checks,
        t_junctions,
    })
}
