//! All calls into the baking crate, `hullmap-bake`.

use hullmap_bake::advice::{self, Remark};
use hullmap_bake::progress::Stage;
use hullmap_bake::{
    BakedHull, IndexChoice, IndexKind, PointSet, SourceRecord, bake_hull_in, write_lean_pack, write_owned_pack,
};
use rayon::prelude::*;

use crate::estimates::DecomposedObject;
use crate::measure::{self, Measured};
use crate::options::BuildOptions;
use crate::part::{Part, diagonal, parts};

/// A pack in memory.
#[derive(Clone, Debug, Default)]
pub struct BakedPack {
    /// The bytes of the file.
    pub bytes: Vec<u8>,
    /// Rank of each hull.
    pub ranks: Vec<u32>,
    /// Number of vertices, over all hulls.
    pub vertex_count: usize,
    /// Findings of interest.
    pub notes: Vec<String>,
    /// Findings to act on, including findings of the import. The pack keeps them.
    pub warnings: Vec<String>,
    /// Objects whose meshes were decomposed, or whose parts came with them.
    pub objects: Vec<DecomposedObject>,
}

/// Builds, certifies and indexes a hull of each point set, or of each of its parts, and writes them
/// into one pack. It keeps the warnings of `source`, and those about the hulls. `stage` shows the
/// progress.
///
/// # Errors
/// A hull could not be baked; the error names the first one. Or the stage is cancelled.
pub fn bake_pack(
    point_sets: &[PointSet],
    options: &BuildOptions,
    source: &SourceRecord,
    stage: Stage,
) -> Result<BakedPack, String> {
    let (decompose, index) = (options.decompose(), options.index());
    // Finding and measuring parts takes longer than building their hulls.
    let [cut, built] = if decompose.is_some() { [0.7, 0.8] } else { [0.0, 1.0] };
    let parts = parts(point_sets, decompose.as_ref(), stage.from_to(0.0, cut))?;
    if stage.is_cancelled() {
        return Err("cancelled".to_owned());
    }
    let steps = stage.from_to(cut, built).steps(parts.len());
    let inner = if parts.len() == 1 { stage.from_to(cut, built) } else { stage.from_to(0.0, 0.0) };
    let bake = |part: &Part| {
        let baked = bake_hull_in(&part.points, options.simplify(diagonal(&part.points)), index, inner);
        steps.take();
        baked
    };
    let baked: Vec<_> = parts.par_iter().map(bake).collect();
    let mut hulls = Vec::with_capacity(baked.len());
    for (hull, part) in baked.into_iter().zip(&parts) {
        let hull = hull.map_err(|error| format!("hull {}: {error}", part.points.name))?;
        hulls.push(BakedHull { part: part.index, ..hull });
    }
    let Measured { mut remarks, objects } = match &decompose {
        Some(decompose) => measure::parts(point_sets, &parts, &mut hulls, decompose, stage.from_to(built, 1.0)),
        None => measure::collision_parts(point_sets, &mut hulls),
    };
    if let IndexChoice::Budget { bytes_per_vertex } = index {
        remarks.extend(hulls.iter().map(|baked| budget_note(baked, bytes_per_vertex)));
    }
    remarks.extend(hulls.iter().filter_map(replacement_warning));
    // One part is the hull of its mesh.
    let is_divided = decompose.as_ref().is_some_and(|cover| cover.max_parts != Some(1));
    remarks.extend(advice::of_hulls(&hulls, |index| is_divided && measure::is_cut(&parts[index])));
    let (notes, own_warnings) = advice::summarise(remarks);
    let mut source = source.clone();
    source.warnings.extend(own_warnings);
    let ranks = hulls.iter().map(|baked| baked.hull.rank).collect();
    let vertex_count = hulls.iter().map(|baked| baked.hull.vertices.len()).sum();
    let write = if options.is_lean() { write_lean_pack } else { write_owned_pack };
    let bytes = write(hulls, &source).map_err(|error| error.to_string())?;
    Ok(BakedPack { bytes, ranks, vertex_count, notes, warnings: source.warnings, objects })
}

/// Warning about an index that replaces another one, since that could not be proven.
fn replacement_warning(baked: &BakedHull) -> Option<Remark> {
    let (name, kind) = (&baked.name, baked.index.kind);
    let (requested, reason) = baked.index.replaces.as_ref()?;
    let used = if kind == IndexKind::None { "no index".to_owned() } else { format!("{kind} index") };
    let kinds = format!("{used} instead of {requested}, which could not be proven");
    let text = format!("hull {name}: {kinds} ({reason}); queries are exact, but slower; please report this mesh");
    Some(Remark::warning(kinds, name, text))
}

/// Note on the index that a budget allowed, by its name on the command line.
fn budget_note(baked: &BakedHull, bytes_per_vertex: u32) -> Remark {
    let (name, kind) = (&baked.name, baked.index.kind);
    let vertex_count = baked.hull.vertices.len();
    let bytes = baked.index.byte_len() as f64 / vertex_count as f64;
    let is_kept = baked.index.byte_len() <= bytes_per_vertex as usize * vertex_count;
    let verdict = if is_kept { "" } else { ", above the budget, but no index is smaller" };
    let text = format!("hull {name}: index {kind}, {bytes:.1} bytes per vertex{verdict}");
    Remark::note(format!("index {kind}{verdict}"), name, text)
}
