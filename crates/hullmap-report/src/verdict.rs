//! The verdict on a pack: a chip of a few words, a sentence in plain words, and the worst place.

use serde::{Deserialize, Serialize};

use crate::analysis::{Analysis, HullRow};
use crate::html::{count, escape, percent, short};

/// Distance relative to the diagonal, below which a part does not leave its mesh: the rounding of
/// coordinates in f32.
const ROUNDING: f64 = 1e-6;

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    NotOpened,
    Failed,
    /// It has parts without measures.
    Unmeasured,
    SourceNotFound,
    /// It has parts that an engine cannot use well.
    PartsNeedAttention,
    /// It has a hull that is much larger than its mesh.
    FillsHollows,
    /// No hull is simplified; or a triangle mesh equals its source.
    Exact,
    /// It has parts that differ from their mesh.
    WithinItsBounds,
    /// It has simplified hulls.
    ContainsItsSource,
}

impl Verdict {
    pub fn new(pack: &Analysis) -> Self {
        if !pack.remarks.faults.is_empty() {
            Self::Failed
        } else if pack.has_unmeasured_parts() {
            Self::Unmeasured
        } else if pack.source.is_none() {
            Self::SourceNotFound
        } else if !pack.flaws().is_empty() {
            Self::PartsNeedAttention
        } else if most_hollow(pack).is_some() {
            Self::FillsHollows
        } else if pack.is_exact() {
            Self::Exact
        } else if pack.has_loose_parts() {
            Self::WithinItsBounds
        } else {
            Self::ContainsItsSource
        }
    }

    /// The verdicts that are not good, the worst first.
    pub const DOUBTS: [Self; 6] = [
        Self::NotOpened,
        Self::Failed,
        Self::Unmeasured,
        Self::SourceNotFound,
        Self::PartsNeedAttention,
        Self::FillsHollows,
    ];

    /// The verdict in a few words, and the class of its chip: `bad`, `odd` or `good`.
    pub fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::NotOpened => ("bad", "not opened"),
            Self::Failed => ("bad", "failed"),
            Self::Unmeasured => ("odd", "not measured"),
            Self::SourceNotFound => ("odd", "mesh not found"),
            Self::PartsNeedAttention => ("odd", "parts need attention"),
            Self::FillsHollows => ("odd", "fills hollows"),
            Self::Exact => ("good", "exact"),
            Self::WithinItsBounds => ("good", "verified"),
            Self::ContainsItsSource => ("good", "contains its mesh"),
        }
    }

    pub fn html(self) -> String {
        let (class, word) = self.words();
        format!("<span class=\"chip {class}\">{word}</span>")
    }
}

pub const FAILED: &str = "Do not use this file: its check failed. The faults below give the reasons.";

/// The sentence under the title, as plain text.
pub fn headline(pack: &Analysis) -> String {
    let is_one = pack.hull_count == 1;
    let noun = if pack.hulls.iter().any(|hull| hull.part_count > 0) { "part" } else { "hull" };
    let shapes =
        if is_one { format!("One convex {noun}") } else { format!("{} convex {noun}s", count(pack.hull_count as u64)) };
    let stands = if is_one { "stands" } else { "stand" };
    match Verdict::new(pack) {
        Verdict::NotOpened | Verdict::Failed => FAILED.to_owned(),
        Verdict::Unmeasured => {
            format!("{shapes} {stands} in for the mesh. How far they leave it was not measured.")
        }
        Verdict::SourceNotFound => {
            format!("{shapes}. The mesh was not found, so nothing was compared with it.")
        }
        Verdict::PartsNeedAttention => format!(
            "{shapes} {stands} in for the mesh, but some are {}, which engines handle badly. The warnings below \
             name the remedy.",
            pack.flaws().join(" and ")
        ),
        Verdict::FillsHollows => {
            let (name, excess) = most_hollow(pack).unwrap_or_default();
            let of = if is_one { String::new() } else { format!(" of {name}") };
            format!(
                "The convex hull{of} fills the hollows of the mesh: +{} volume. For convex parts that follow the mesh, \
                 bake it with --decompose.",
                percent(excess)
            )
        }
        Verdict::Exact if noun == "part" => {
            format!("{shapes}, exact: {} the mesh itself.", if is_one { "it is" } else { "together they are" })
        }
        Verdict::Exact => {
            let is_unknown = |hull: &HullRow| hull.rank == 3 && !hull.is_mesh_volume_known;
            let unknown = if pack.hulls.iter().any(is_unknown) {
                " The mesh is not watertight, so its hollows are unknown; if it has any, bake it with --decompose."
            } else {
                ""
            };
            let fit = if is_one { "fits the mesh tightly" } else { "fit their meshes tightly" };
            format!("{shapes}, exact: {} {fit}, and nothing stands out.{unknown}", if is_one { "it" } else { "they" })
        }
        Verdict::WithinItsBounds => {
            let far = worst(pack).map_or_else(
                || "nothing leaves it".to_owned(),
                |part| format!("nothing leaves it by more than {}", length(part.protrusion, part, pack.unit)),
            );
            format!("{shapes} {} the mesh: {far}.", if is_one { "follows" } else { "follow" })
        }
        Verdict::ContainsItsSource => {
            let farthest = pack.hulls.iter().max_by(|a, b| a.outer_error.total_cmp(&b.outer_error));
            let far = farthest.map(|hull| length(Some(hull.outer_error), hull, pack.unit)).unwrap_or_default();
            format!(
                "{shapes}, simplified to {} vertices, {} the mesh and {} beyond its exact hull by at most {far}.",
                count(pack.vertex_count as u64),
                if is_one { "contains" } else { "contain" },
                if is_one { "extends" } else { "extend" },
            )
        }
    }
}

/// A length with its unit, and as a share of the diagonal of the hull's mesh.
fn length(length: Option<f64>, hull: &HullRow, unit: &str) -> String {
    let length = length.unwrap_or(f64::NAN);
    format!("{}\u{a0}{unit} ({} of the mesh's diagonal)", short(length), percent(length / hull.diagonal))
}

/// Name and excess volume of the hull that fills the largest hollows.
fn most_hollow(pack: &Analysis) -> Option<(&str, f64)> {
    let hollow = pack.hulls.iter().filter_map(|hull| Some((hull.name.as_str(), hull.excess?)));
    hollow.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The part that leaves its mesh furthest; the first of equals, as in the pictures.
fn worst(pack: &Analysis) -> Option<&HullRow> {
    let far = pack.hulls.iter().filter(|hull| hull.leaves_its_mesh());
    far.reduce(|worst, next| if next.protrusion > worst.protrusion { next } else { worst })
}

impl HullRow {
    /// Whether it is a part that leaves its mesh by more than rounding.
    pub fn leaves_its_mesh(&self) -> bool {
        self.protrusion.is_some_and(|protrusion| protrusion > ROUNDING * self.diagonal)
    }
}

/// The worst place in plain words, with a button that shows it; empty if no part leaves the mesh.
pub fn worst_place(pack: &Analysis) -> String {
    let Some(part) = worst(pack) else { return String::new() };
    let missed = match part.uncovered {
        Some(uncovered) if uncovered > ROUNDING * part.diagonal => {
            format!(" Between the parts, the mesh stands out by at most {}.", length(Some(uncovered), part, pack.unit))
        }
        _ => String::new(),
    };
    format!(
        "<p class=\"worst\"><i class=\"spot\" aria-hidden=\"true\"></i> <strong>Worst place:</strong> part #{} \
         (<span class=\"name\">{}</span>) leaves the mesh by at most {}.{missed} \
         <button type=\"button\" id=\"show-worst\" class=\"controls3d\" aria-pressed=\"false\">Show it</button></p>\n",
        part.number,
        escape(&part.name),
        length(part.protrusion, part, pack.unit),
    )
}
