//! Gathers what the report shows about a triangle mesh: its source, its verification, and remarks.

use std::path::Path;

use hullmap::TriangleMesh;
use hullmap_report::input::Remarks;
use hullmap_report::mesh::{Checks, MeshInput, MeshReport};

use super::sought::{Sought, seek_source, source_name};
use crate::args::ReportArgs;
use crate::open::BakedFile;
use crate::options::BuildOptions;
use crate::outcome::Failure;
use crate::packs::PackPlace;
use crate::source::{Folders, Source};
use crate::triangle_mesh::{MeshSummary, adapted, t_junctions_of};
use hullmap_verify::triangle_mesh::{MeshVerification, SourceTriangles, verify_mesh};

/// Faults of the mesh are part of the report.
pub fn analyse_mesh(
    place: &PackPlace,
    opened: &BakedFile,
    mesh: &TriangleMesh,
    given: Option<&Path>,
    args: &ReportArgs,
    folders: &Folders,
) -> Result<MeshReport, Failure> {
    let mut remarks = Remarks::default();
    let Sought { source, absent } = seek_source(place, opened, given, args, folders, &mut remarks.faults)?;
    remarks.warnings = opened.kept_warnings();
    if source.is_none() {
        let warning = format!("{absent} the mesh was compared with itself only; name the source with --source");
        remarks.warnings.insert(0, warning);
    }
    let found = verify(mesh, source.as_ref(), args, &mut remarks);
    let t_junctions = t_junctions_of(mesh).count;
    let summary = MeshSummary { t_junctions: Some(t_junctions), ..MeshSummary::of_file(mesh) };
    let flaws = summary.flaws();
    if flaws != "none" {
        remarks.notes.push(format!("kept as they are: {flaws}"));
    }
    if let Some(source) = &source {
        remarks.notes.extend(source.notes.iter().map(|note| adapted(note)));
    }
    Ok(MeshReport::new(MeshInput {
        path: &place.path,
        mesh,
        source: source.map(|source| source_name(&source, mesh.source_path())),
        options: BuildOptions::recorded_in_words(mesh.options()),
        remarks,
        checks: found.map(|found| Checks {
            rays: found.rays.unwrap_or_default(),
            ray_hits: found.ray_hits.unwrap_or_default(),
            points: found.points.unwrap_or_default(),
            seed: args.seed,
            mismatches: found.mismatches.unwrap_or_default(),
        }),
        t_junctions,
        up: args.up,
    }))
}

fn verify(
    mesh: &TriangleMesh,
    source: Option<&Source>,
    args: &ReportArgs,
    remarks: &mut Remarks,
) -> Option<MeshVerification> {
    let triangles = match source {
        Some(source) => SourceTriangles::new(&source.point_sets, &source.faces, &source.materials).map(Some),
        None => Ok(None),
    };
    match triangles {
        Ok(triangles) => {
            let found = verify_mesh(mesh, triangles.as_ref(), args.directions, args.seed);
            remarks.faults.extend(found.problems.iter().cloned());
            Some(found)
        }
        Err(fault) => {
            remarks.faults.push(fault);
            None
        }
    }
}
