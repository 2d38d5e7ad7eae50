//! Gathers what the report shows about a file: its source, its verification, and remarks.

use std::collections::BTreeMap;
use std::path::Path;

use hullmap::Asset;
use hullmap_bake::advice;
use hullmap_report::input::{self as report, Verification, VerifiedHull};
use hullmap_report::surface::SurfaceReport;
use hullmap_report::{Analysis, Card, Input, analyse, pack_page, surface_page};

use super::remarks::{excess, remarks};
use super::source::{FoundSource, frame_of, source_name, source_of};
use super::surface::analyse_surface;
use crate::args::ReportArgs;
use crate::source_mesh::display_mesh;
use hullmap_bake::parts::estimates::PartsEstimates;
use hullmap_pipeline::content::{Content, Verified, verify};
use hullmap_pipeline::open::{kept_warnings, open_asset};
use hullmap_pipeline::options::BuildOptions;
use hullmap_pipeline::outcome::Failure;
use hullmap_pipeline::packs::PackPlace;
use hullmap_pipeline::source::{Folders, Source};
use hullmap_verify::geometry::polygons;
use hullmap_verify::pack::HullVerification;

pub enum Analysed {
    Pack(Box<Analysis>),
    Surface(Box<SurfaceReport>),
}

impl Analysed {
    /// The page. `index` is the link from it to the page of its folder.
    pub fn page(&self, index: Option<&str>) -> String {
        match self {
            Self::Pack(pack) => pack_page(pack, index),
            Self::Surface(surface) => surface_page(surface, index),
        }
    }

    pub fn card(&self, name: String, link: String) -> Card {
        match self {
            Self::Pack(pack) => Card::new(name, pack, link),
            Self::Surface(surface) => Card::of_surface(name, surface, link),
        }
    }

    pub fn file(&self) -> &str {
        match self {
            Self::Pack(pack) => &pack.file,
            Self::Surface(surface) => &surface.file,
        }
    }

    pub fn faults(&self) -> &[String] {
        match self {
            Self::Pack(pack) => &pack.remarks.faults,
            Self::Surface(surface) => &surface.remarks.faults,
        }
    }
}

const MAX_WARNINGS: usize = 100;

/// Opens, verifies and analyses a file; `given` is its path by `--source`. `folders` remembers
/// folders read before. Faults of a file that opens are part of the analysis.
pub fn analyse_file(
    place: &PackPlace,
    given: Option<&Path>,
    args: &ReportArgs,
    folders: &Folders,
) -> Result<Analysed, Failure> {
    let asset = open_asset(&place.path)?;
    let mut faults = Vec::new();
    let FoundSource { source, absent } = source_of(place, &asset, given, args, folders, &mut faults)?;
    let pack = match &asset {
        Asset::Pack(pack) => pack,
        Asset::TriangleMesh(_) | Asset::HeightField(_) => {
            let report = analyse_surface(place, &asset, source, &absent, args, faults);
            return Ok(Analysed::Surface(Box::new(report)));
        }
    };
    let results = verified(&asset, source.as_ref(), args, &mut faults);
    let mut remarks = remarks(pack, kept_warnings(&asset), source.as_ref(), &estimates_in_words(&results));
    for text in results.iter().flat_map(|result| &result.warnings) {
        if remarks.warnings.len() < MAX_WARNINGS && !remarks.warnings.contains(text) {
            remarks.warnings.push(text.clone());
        }
    }
    if source.is_none() {
        let warning = format!(
            "{absent} the hull is shown alone and was compared with itself only; name the source with --source"
        );
        remarks.warnings.insert(0, warning);
    }
    let verification = Verification {
        is_against_source: source.is_some(),
        directions: args.directions,
        hulls: results.into_iter().map(verified_hull).collect(),
    };
    remarks.faults = faults;
    let mesh_path = source.as_ref().map_or(Path::new(pack.source_path()), |source| &source.path);
    let frame = frame_of(mesh_path, pack.options(), args.up);
    let source = source.map(|source| report::Source {
        name: source_name(&source, pack.source_path()),
        point_count: source.content.point_sets().iter().map(|set| set.positions.len()).sum(),
        meshes: match &source.content {
            Content::Mesh(mesh) => mesh
                .point_sets
                .iter()
                .zip(&mesh.faces)
                .map(|(set, faces)| display_mesh(&set.positions, faces))
                .collect(),
            Content::Terrain(_) => Vec::new(),
        },
    });
    let input = Input { path: &place.path, pack, source, verification, remarks, polygons, excess, frame };
    let mut analysis = analyse(input).expect("the pack was opened with all checks");
    analysis.options = BuildOptions::recorded_in_words(pack.options());
    Ok(Analysed::Pack(Box::new(analysis)))
}

/// Verifies the pack as `bake verify` does. Failures are added to `faults`.
fn verified(
    asset: &Asset,
    source: Option<&Source>,
    args: &ReportArgs,
    faults: &mut Vec<String>,
) -> Vec<HullVerification> {
    let results = match verify(asset, source.map(|source| &source.content), args.directions, args.seed) {
        Ok(Verified::Hulls(results)) => results,
        Ok(Verified::Surface(_)) => Vec::new(),
        Err(error) => {
            faults.push(error);
            Vec::new()
        }
    };
    faults.extend(results.iter().filter(|result| !result.pass).map(HullVerification::verdict));
    results
}

fn estimates(found: PartsEstimates) -> report::PartsEstimates {
    report::PartsEstimates {
        overlap: found.overlap,
        overlap_error: found.overlap_error,
        mean_protrusion: found.mean_protrusion,
        outside_hull: found.outside_hull,
        voids: found.voids,
        voids_error: found.voids_error,
        symmetry: found.symmetry.map(|plane| plane.in_words()),
    }
}

/// How the parts of each object fit together, in words, by the object's name.
fn estimates_in_words(results: &[HullVerification]) -> BTreeMap<String, String> {
    let of = |result: &HullVerification| {
        let (estimates, hull) = result.parts.filter(|_| result.part_of[0] == 0).zip(result.hull.as_deref())?;
        let name = hull.rsplit_once("_part_").map_or(hull, |(name, _)| name);
        let symmetry = estimates.symmetry.map(|plane| plane.in_words());
        let words = advice::estimates(&estimates.looseness()?, estimates.voids, symmetry.as_deref());
        Some((name.to_owned(), words))
    };
    results.iter().filter_map(of).collect()
}

fn verified_hull(result: HullVerification) -> VerifiedHull {
    VerifiedHull {
        is_simplified: result.is_simplified(),
        is_loose_part: result.is_loose_part(),
        is_measured: result.solid.is_some(),
        part: result.part_of[0],
        part_count: result.part_of[1],
        thickness: result.thickness.unwrap_or(0.0),
        mean_protrusion: result.mean_protrusion,
        estimates: result.parts.map(estimates),
        flaws: result.flaws.iter().map(|flaw| flaw.as_str()).collect(),
        name: result.hull.unwrap_or_default(),
        passed: result.pass,
        max_regret: result.max_regret.unwrap_or(f64::NAN),
        mismatches: result.mismatches.unwrap_or_default(),
        max_nodes: result.max_nodes.unwrap_or_default(),
        max_dots: result.max_dots.unwrap_or_default(),
    }
}
