//! Notes and warnings of the import and bake of a pack. A pack stores its warnings. Notes, and
//! warnings of packs that store none, are computed again from the pack and its source.

use std::collections::BTreeMap;

use hullmap::{Hull, Pack, SupportMap};
use hullmap_bake::advice::{self, HullMeasures, PartsFit, Remark};
use hullmap_report::input::Remarks;

use hullmap_pipeline::options::BuildOptions;
use hullmap_pipeline::source::Source;

/// Remarks about the import and the hulls. `estimates` are words about the parts of each object, by
/// its name. Without a source, hulls are checked for far coordinates.
pub fn remarks(
    pack: &Pack,
    kept: Vec<String>,
    source: Option<&Source>,
    estimates: &BTreeMap<String, String>,
) -> Remarks {
    let mut remarks = Remarks::default();
    if let Some(source) = source {
        [remarks.notes, remarks.warnings] = source.content.remarks().map(<[String]>::to_vec);
    }
    let hulls: Vec<Hull> = pack.hulls().collect();
    let cover = BuildOptions::recorded_cover(pack.options());
    let mut found = Vec::new();
    // The parts of one object follow one another; the first has part number 0.
    for parts in hulls.chunk_by(|_, next| next.part() > 0) {
        found.extend(about_object(parts, source.is_some(), estimates, &mut remarks.warnings));
    }
    let is_decomposed = cover.is_some();
    found.extend(hulls.iter().flat_map(|hull| about_hull(hull, is_decomposed && hull.part_count() > 1)));
    let (notes, warnings) = advice::summarise(found);
    remarks.notes.extend(notes);
    remarks.warnings.extend(warnings);
    if !kept.is_empty() {
        remarks.warnings = kept;
    }
    remarks
}

fn about_object(
    parts: &[Hull],
    has_source: bool,
    estimates: &BTreeMap<String, String>,
    warnings: &mut Vec<String>,
) -> Option<Remark> {
    let first = parts.first()?;
    let is_cut = parts.len() > 1;
    let name =
        if is_cut { first.name().rsplit_once("_part_").map_or(first.name(), |(name, _)| name) } else { first.name() };
    if !has_source {
        let vertices: Vec<[f32; 3]> = parts.iter().flat_map(Hull::vertices).map(|v| v.to_array()).collect();
        warnings.extend(hullmap_import::far_away(name, &vertices));
    }
    let size = parts.iter().map(Hull::diameter).fold(0.0, f64::max);
    let words = estimates.get(name).map(String::as_str);
    is_cut.then(|| advice::parts(name, parts.len(), fit(parts), size, words))
}

fn fit(parts: &[Hull]) -> Option<PartsFit> {
    let first = parts.first()?;
    let protrusion = parts.iter().filter_map(Hull::protrusion).fold(0.0, f64::max);
    Some(PartsFit { solid: first.solid()?, uncovered: first.uncovered()?, protrusion })
}

fn about_hull(hull: &Hull, is_cut: bool) -> Vec<Remark> {
    let max_coordinate = hull.bounds().iter().map(|corner| corner.abs().max_element()).fold(0.0, f32::max);
    let measures = HullMeasures {
        name: hull.name(),
        rank: hull.rank(),
        point_count: hull.source_point_count() as usize,
        vertex_count: hull.vertex_count(),
        diameter: hull.diameter(),
        inner_radius: hull.inner_radius(),
        max_coordinate: max_coordinate.into(),
        outer_error: hull.outer_error(),
        is_cut,
    };
    let about_shape = excess(hull).map(|excess| advice::concave(hull.name(), excess));
    advice::of_hull(&measures).into_iter().chain(advice::simplified(&measures)).chain(about_shape).collect()
}

/// Excess of the volume of a hull that stands for a whole mesh, if it fills hollows of the mesh;
/// `None` for a part, which was measured against its mesh.
pub fn excess(hull: &Hull) -> Option<f64> {
    let mesh = hull
        .mesh_mass_properties(1.0)
        .filter(|_| hull.part_count() <= 1 && hull.solid().is_none() && hull.rank() == 3)?;
    advice::excess(hull.volume(), mesh.mass)
}
