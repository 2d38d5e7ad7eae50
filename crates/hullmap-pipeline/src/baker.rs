//! All calls into the baking crate, `hullmap-bake`.

use hullmap_bake::advice::{self, Remark};
use hullmap_bake::progress::Stage;
use hullmap_bake::simplify::Limit;
use hullmap_bake::{
    BakeError, BakedHull, IndexKind, PointSet, SourceRecord, bake_hull_in, write_lean_pack, write_owned_pack,
};
use rayon::prelude::*;

use crate::budget::{Budget, Figures};
use crate::options::BuildOptions;
use hullmap_bake::parts::cut::{Part, parts};
use hullmap_bake::parts::estimates::DecomposedObject;
use hullmap_bake::parts::measure::{self, Measured};

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
/// into one pack with the warnings. The error names the first hull that could not be baked.
pub fn bake_pack(
    point_sets: &[PointSet],
    options: &BuildOptions,
    source: &SourceRecord,
    stage: Stage,
) -> Result<BakedPack, String> {
    let decompose = options.decompose();
    // Finding and measuring parts takes longer than building their hulls.
    let [cut, built] = if decompose.is_some() { [0.7, 0.8] } else { [0.0, 1.0] };
    let parts = parts(point_sets, decompose.as_ref(), stage.from_to(0.0, cut))?;
    if stage.is_cancelled() {
        return Err("cancelled".to_owned());
    }
    let steps = stage.from_to(cut, built).steps(parts.len());
    let inner = if parts.len() == 1 { stage.from_to(cut, built) } else { stage.from_to(0.0, 0.0) };
    let bake = |part: &Part| {
        let baked = bake_within_budget(&part.points, options, inner);
        steps.take();
        baked
    };
    let baked: Vec<_> = parts.par_iter().map(bake).collect();
    let mut hulls = Vec::with_capacity(baked.len());
    let mut over_budget = Vec::new();
    for (hull, part) in baked.into_iter().zip(&parts) {
        let (hull, remark) = hull.map_err(|error| format!("hull {}: {error}", part.points.name))?;
        over_budget.extend(remark);
        hulls.push(BakedHull { part: part.index, ..hull });
    }
    let Measured { mut remarks, objects } = match &decompose {
        Some(decompose) => {
            let wanted = (decompose, options.has_primitives());
            measure::parts(point_sets, &parts, &mut hulls, wanted, stage.from_to(built, 1.0))
        }
        None => measure::collision_parts(point_sets, &mut hulls),
    };
    remarks.extend(point_sets.iter().filter(|points| points.stands_for.is_none()).filter_map(advice::reversed));
    remarks.append(&mut over_budget);
    if let Some(budget) = options.budget() {
        remarks.extend(hulls.iter().filter_map(|baked| form_warning(baked, budget)));
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

/// The hull of these points, as simple as the options and the budget of an engine demand, with a
/// note if the budget decided. A hull that is within the budget as it is stays exact.
fn bake_within_budget(
    points: &PointSet,
    options: &BuildOptions,
    stage: Stage,
) -> Result<(BakedHull, Option<Remark>), BakeError> {
    let (limit, index) = (options.simplify(points.diagonal()), options.index());
    let Some(budget) = options.budget() else {
        return Ok((bake_hull_in(points, limit, index, stage)?, None));
    };
    // The index takes most of the time, and is useless if the hull is too large.
    let is_doubtful = limit.is_none() && points.positions.len() > budget.vertices();
    let first = if is_doubtful { IndexKind::None } else { index };
    let baked = bake_hull_in(points, limit, first, stage)?;
    let exceeded = budget.exceeded_counts(&figures(&baked));
    if exceeded.is_empty() && !is_doubtful {
        return Ok((baked, None));
    }
    if exceeded.is_empty() {
        return Ok((bake_hull_in(points, limit, index, stage)?, None));
    }
    let vertices = match limit {
        Some(Limit::Vertices(vertices)) => vertices.min(budget.sure_vertices() as usize),
        _ => budget.sure_vertices() as usize,
    };
    let simplified = bake_hull_in(points, Some(Limit::Vertices(vertices)), index, stage)?;
    let kind = format!("simplified for {}", budget.name);
    let (count, name) = (simplified.hull.vertices.len(), &points.name);
    let text =
        format!("hull {name}: simplified to {count} vertices for {}: it had {}", budget.name, exceeded.join(", "));
    Ok((simplified, Some(Remark::note(kind, name, text))))
}

fn figures(baked: &BakedHull) -> Figures {
    Figures::new(&baked.hull.vertices, &baked.hull.faces, baked.interior.point)
}

fn form_warning(baked: &BakedHull, budget: &Budget) -> Option<Remark> {
    let exceeded = budget.exceeded_form(&figures(baked));
    if exceeded.is_empty() || baked.hull.rank < 3 {
        return None;
    }
    let (name, kind) = (&baked.name, format!("not of a form for {}", budget.name));
    let text = format!(
        "hull {name}: not within the budget of {}: it has {}; thicken or divide the mesh, or allow thicker parts with \
         --set wall and --max-error",
        budget.name,
        exceeded.join(" and ")
    );
    Some(Remark::warning(kind, name, text))
}

fn replacement_warning(baked: &BakedHull) -> Option<Remark> {
    let (name, kind) = (&baked.name, baked.index.kind);
    let (requested, reason) = baked.index.replaces.as_ref()?;
    let used = if kind == IndexKind::None { "no index".to_owned() } else { format!("{kind} index") };
    let kinds = format!("{used} instead of {requested}, which could not be proven");
    let text = format!("hull {name}: {kinds} ({reason}); queries are exact, but slower; please report this mesh");
    Some(Remark::warning(kinds, name, text))
}
