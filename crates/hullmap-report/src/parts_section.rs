//! The parts of decomposed meshes: a table with the worst part first, and how they fit together.

use crate::analysis::{Analysis, HullRow, MAX_HULLS};
use crate::html::{self, count, escape, or_dash, percent, short};
use crate::input::{PartsEstimates, VerifiedHull};
use crate::part_colours::COLOURS;

/// A part: its row and its verification.
type Part<'a> = (&'a HullRow, &'a VerifiedHull);

/// Parts of meshes that were cut; none if the pack could not be verified.
fn parts(pack: &Analysis) -> Vec<Part<'_>> {
    pack.hulls.iter().zip(&pack.verification.hulls).filter(|part| part.1.part_count > 1).collect()
}

/// The section with a row for each part; empty if there are none.
pub fn parts_table(pack: &Analysis) -> String {
    let parts = parts(pack);
    if parts.is_empty() {
        return String::new();
    }
    let more = if pack.hull_count > MAX_HULLS { " Only the first parts have rows." } else { "" };
    format!(
        "<section aria-labelledby=\"parts-title\" class=\"long\" id=\"parts\">\n<h2 id=\"parts-title\">Parts, the worst first</h2>\n\
         <p class=\"soft\">Point at a row to show its part in the picture, or press its button to keep it shown. Leaves the \
         mesh: a proven bound for the worst point, and an estimate of the mean over the visible surface, in {}. \
         Thickness: of a plate with the volume and the area of the part.{more}</p>\n{}</section>\n",
        if pack.unit == "m" { "metres" } else { "units of the mesh" },
        table(worst_first(parts))
    )
}

/// Parts with flaws first, then by protrusion, mean protrusion, and thickness.
fn worst_first(mut parts: Vec<Part>) -> Vec<Part> {
    // NaN is worst.
    let worse = |a: Option<f64>, b: Option<f64>| b.unwrap_or(f64::INFINITY).total_cmp(&a.unwrap_or(f64::INFINITY));
    parts.sort_by(|(a, checked_a), (b, checked_b)| {
        let flaws = checked_b.flaws.len().cmp(&checked_a.flaws.len());
        let means = checked_b.mean_protrusion.unwrap_or(0.0).total_cmp(&checked_a.mean_protrusion.unwrap_or(0.0));
        flaws
            .then(worse(a.protrusion, b.protrusion))
            .then(means)
            .then(checked_a.thickness.total_cmp(&checked_b.thickness))
    });
    parts
}

const MAX_OBJECTS: usize = 20;

/// The section with the measures of each object; empty if there are none.
pub fn parts_facts(pack: &Analysis) -> String {
    let parts = parts(pack);
    let objects = parts.chunk_by(|_, next| next.1.part > 0).take(MAX_OBJECTS).map(facts).collect::<Vec<_>>();
    if objects.is_empty() {
        return String::new();
    }
    format!(
        "<section aria-labelledby=\"fit-title\">\n<h2 id=\"fit-title\">Fit of the parts</h2>\n{}</section>\n",
        objects.join("<hr>\n")
    )
}

/// The measures of one object, or a dash for each that is not known.
fn facts(parts: &[Part]) -> String {
    let PartsEstimates { overlap, overlap_error, mean_protrusion, outside_hull, voids, voids_error, symmetry } =
        parts[0].1.estimates.clone().unwrap_or_default();
    let bound = |pick: fn(&HullRow) -> Option<f64>| parts.iter().filter_map(|part| pick(part.0)).reduce(f64::max);
    let thinnest = parts.iter().map(|part| part.1.thickness).reduce(f64::min);
    let within = |share: Option<f64>, error: Option<f64>| match (share, error) {
        (Some(share), Some(error)) => format!("{} ± {}", percent(share), percent(error)),
        _ => "–".to_owned(),
    };
    let rows = [
        ("Parts", count(parts.len() as u64)),
        ("Overlap, of their union", within(overlap, overlap_error)),
        ("Mean protrusion", or_dash(mean_protrusion, short)),
        ("Worst protrusion, at most", or_dash(bound(|row| row.protrusion), short)),
        ("Surface uncovered, at most", or_dash(bound(|row| row.uncovered), short)),
        ("Outside the mesh's hull", or_dash(outside_hull, short)),
        ("Solid in no part", within(voids, voids_error)),
        ("Thinnest part", or_dash(thinnest, short)),
        ("Symmetric about", or_dash(symmetry, |plane| plane)),
    ];
    format!("<dl class=\"facts\">\n{}</dl>\n", html::facts(&rows))
}

fn table(parts: Vec<Part>) -> String {
    let heads = "part: | leaves the mesh by | of the diagonal | on average | thickness | vertices | volume | result:";
    let row = |(row, verified): Part| {
        let number = row.number;
        let [red, green, blue] = COLOURS[row.colour];
        let swatch = format!("<i class=\"swatch\" style=\"background:rgb({red},{green},{blue})\"></i>");
        let result = match (verified.passed, verified.flaws.as_slice()) {
            (false, _) => "<span class=\"chip bad\">failed</span>".to_owned(),
            (true, []) => String::new(),
            (true, flaws) => format!("<span class=\"chip odd\">{}</span>", flaws.join(", ")),
        };
        let cells = vec![
            html::button(&format!("{swatch}#{number} {}", escape(&row.name))),
            or_dash(row.protrusion, short),
            or_dash(row.protrusion, |protrusion| percent(protrusion / row.diagonal)),
            or_dash(verified.mean_protrusion, short),
            short(verified.thickness),
            count(row.vertices as u64),
            short(row.volume),
            result,
        ];
        (format!(" data-part=\"{number}\""), cells)
    };
    html::table("Parts, the worst first", heads, &parts.into_iter().map(row).collect::<Vec<_>>(), false)
}
