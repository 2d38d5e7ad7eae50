//! The section of a page about the parts of decomposed meshes: how they fit together, a picture in
//! which each has a colour, and a table with the worst part first.

use std::fmt::Write;

use crate::analysis::{Analysis, HullRow, MAX_HULLS};
use crate::html::{self, count, escape, or_dash, short};
use crate::input::{PartsEstimates, VerifiedHull};
use crate::part_colours::COLOURS;

/// A part: its index in the pack, its row, and its verification.
type Part<'a> = (usize, &'a HullRow, &'a VerifiedHull);

/// The section; empty if no mesh was cut into parts, or the pack could not be verified.
pub fn parts_section(pack: &Analysis) -> String {
    let hulls = pack.hulls.iter().zip(&pack.verification.hulls).enumerate();
    let parts: Vec<Part> =
        hulls.map(|(number, (row, verified))| (number, row, verified)).filter(|part| part.2.part_count > 1).collect();
    if parts.is_empty() {
        return String::new();
    }
    let mut out =
        "<section aria-labelledby=\"parts-title\" class=\"long\" id=\"parts\">\n<h2 id=\"parts-title\">Parts</h2>\n"
            .to_owned();
    out += &verdict(&parts, pack.verification.is_against_source);
    let _ = writeln!(
        out,
        "<div class=\"parts\"><figure><img src=\"{}\" width=\"320\" height=\"240\" alt=\"The parts, each in its colour\"></figure>\n{}</div>",
        pack.picture,
        table(worst_first(parts))
    );
    let more = if pack.hull_count > MAX_HULLS { " Only the hulls that are listed below have rows." } else { "" };
    out + "<p class=\"soft\">The worst part first. Point at a row to show its part in the picture above; press the button in it to \
           keep it shown. Protrusion: bound on how far the part lies outside the solid, a length. Mean: of its visible \
           surface, an estimate. Thickness: of a plate with the volume and the area of the part."
        + more
        + "</p>\n</section>\n"
}

/// Parts with flaws first, then by protrusion, mean protrusion, and thickness.
fn worst_first(mut parts: Vec<Part>) -> Vec<Part> {
    // NaN is worst.
    let worse = |a: Option<f64>, b: Option<f64>| b.unwrap_or(f64::INFINITY).total_cmp(&a.unwrap_or(f64::INFINITY));
    parts.sort_by(|(_, a, checked_a), (_, b, checked_b)| {
        let flaws = checked_b.flaws.len().cmp(&checked_a.flaws.len());
        let means = checked_b.mean_protrusion.unwrap_or(0.0).total_cmp(&checked_a.mean_protrusion.unwrap_or(0.0));
        flaws
            .then(worse(a.protrusion, b.protrusion))
            .then(means)
            .then(checked_a.thickness.total_cmp(&checked_b.thickness))
    });
    parts
}

/// Whether an engine can use the parts, and the measures of each object.
fn verdict(parts: &[Part], is_against_source: bool) -> String {
    let mut words: Vec<&str> = parts.iter().flat_map(|part| &part.2.flaws).copied().collect();
    words.sort_unstable();
    words.dedup();
    let chip = if !words.is_empty() {
        format!("<span class=\"chip odd\">parts are {}</span>", words.join(" and "))
    } else if !is_against_source || parts.iter().any(|part| !part.2.is_measured) {
        "<span class=\"chip odd\">not compared with their mesh</span>".to_owned()
    } else if parts.iter().any(|part| !part.2.passed) {
        "<span class=\"chip bad\">failed</span>".to_owned()
    } else {
        "<span class=\"chip good\">fit for physics engines</span>".to_owned()
    };
    let remedy = if words.is_empty() { "" } else { " The warnings at the top give the reasons and the remedies." };
    let mut out = format!("<p>{chip}{remedy}</p>\n");
    for (object, own) in parts.chunk_by(|_, next| next.2.part > 0).take(MAX_OBJECTS).enumerate() {
        if object > 0 {
            out.push_str("<hr>\n");
        }
        out += &facts(own);
    }
    out
}

const MAX_OBJECTS: usize = 20;

/// The measures of one object, or a dash for each that is not known.
fn facts(parts: &[Part]) -> String {
    let PartsEstimates { overlap, overlap_error, mean_protrusion, outside_hull, voids, voids_error, symmetry } =
        parts[0].2.estimates.clone().unwrap_or_default();
    let percent = |share: f64| format!("{} %", short(100.0 * share));
    let bound = |pick: fn(&HullRow) -> Option<f64>| parts.iter().filter_map(|part| pick(part.1)).reduce(f64::max);
    let thinnest = parts.iter().map(|part| part.2.thickness).reduce(f64::min);
    let within = |share: Option<f64>, error: Option<f64>| match (share, error) {
        (Some(share), Some(error)) => format!("{} ± {}", percent(share), percent(error)),
        _ => "–".to_owned(),
    };
    let empty = within(voids, voids_error);
    let rows = [
        ("Parts", count(parts.len() as u64)),
        ("Overlap, of their union", within(overlap, overlap_error)),
        ("Mean protrusion", or_dash(mean_protrusion, short)),
        ("Worst protrusion, at most", or_dash(bound(|row| row.protrusion), short)),
        ("Surface uncovered, at most", or_dash(bound(|row| row.uncovered), short)),
        ("Outside the mesh's hull", or_dash(outside_hull, short)),
        ("Solid in no part", empty),
        ("Thinnest part", or_dash(thinnest, short)),
        ("Symmetric about", or_dash(symmetry, |plane| plane)),
    ];
    format!("<dl class=\"facts\">\n{}</dl>\n", html::facts(&rows))
}

fn table(parts: Vec<Part>) -> String {
    let mut out = "<div class=\"scroll rows\" tabindex=\"0\" role=\"region\" aria-label=\"Parts, the worst first\">\
                   <table aria-label=\"Parts, the worst first\">\n<thead><tr>"
        .to_owned();
    for (head, class) in [
        ("part", " class=\"word\""),
        ("protrusion", ""),
        ("mean", ""),
        ("thickness", ""),
        ("vertices", ""),
        ("volume", ""),
        ("result", " class=\"word\""),
    ] {
        let _ = write!(out, "<th scope=\"col\"{class}>{head}</th>");
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    for (number, row, verified) in parts {
        let [red, green, blue] = COLOURS[row.colour];
        let result = match (verified.passed, verified.flaws.as_slice()) {
            (false, _) => "<span class=\"chip bad\">failed</span>".to_owned(),
            (true, []) => String::new(),
            (true, flaws) => format!("<span class=\"chip odd\">{}</span>", flaws.join(", ")),
        };
        let _ = writeln!(
            out,
            "<tr data-part=\"{number}\"><td class=\"word name\"><button type=\"button\" aria-pressed=\"false\"><i class=\"swatch\" \
             style=\"background:rgb({red},{green},{blue})\"></i>{}</button></td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>\
             <td>{}</td><td class=\"word\">{result}</td></tr>",
            escape(&row.name),
            or_dash(row.protrusion, short),
            or_dash(verified.mean_protrusion, short),
            short(verified.thickness),
            count(row.vertices as u64),
            short(row.volume),
        );
    }
    out + "</tbody>\n</table></div>\n"
}
