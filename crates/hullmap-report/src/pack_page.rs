use std::fmt::Write;

use crate::analysis::{Analysis, HullRow, MAX_HULLS};
use crate::census::mean;
use crate::display_mesh::EncodedMesh;
use crate::html::{self, count, escape, json, or_dash, origin, short};
use crate::input::{Remarks, VerifiedHull};
use crate::page::{Page, crumb};
use crate::parts_section::{parts_facts, parts_table};
use crate::verdict::{Verdict, headline, worst_place};

const PAGE: Page = Page {
    kind: "pack",
    generator: "bake report",
    style: "",
    contents: include_str!("page/pack.html"),
    scripts: &[
        include_str!("page/arrays.js"),
        include_str!("page/webgl.js"),
        include_str!("page/view3d.js"),
        include_str!("page/gauss.js"),
        include_str!("page/elements.js"),
        include_str!("page/charts.js"),
        include_str!("page/pack.js"),
    ],
};

/// The page of a pack: a function of pack, source and arguments. `index` is the link to the page of
/// its folder.
pub fn pack_page(pack: &Analysis, index: Option<&str>) -> String {
    let title = escape(&pack.file);
    let origin = origin(pack.source.as_deref(), &pack.recorded_source, &pack.options, pack.format_version);
    let alt = if pack.source.is_some() { "The mesh inside its hull" } else { "The hull" };
    let [warnings, notes] = remark_sections(&pack.remarks);
    PAGE.fill(&[
        ("title", &title),
        ("crumb", &crumb(index)),
        ("verdict", &Verdict::new(pack).html()),
        ("headline", &html::sentence(&headline(pack))),
        ("worst", &worst_place(pack)),
        ("warnings", &warnings),
        ("notes", &notes),
        ("origin", &origin),
        ("facts", &facts(pack)),
        ("picture", &pack.picture),
        ("picture_alt", alt),
        ("parts", &parts_table(pack)),
        ("parts_facts", &parts_facts(pack)),
        ("hulls", &hulls(pack)),
        ("verification", &verification(pack)),
        ("sizes", &sizes(pack)),
        ("limits", &limits(pack)),
        ("data", &json(&pack.drawn)),
        ("footer", "Made by <code>bake report</code>."),
    ])
}

/// The sections of faults and warnings, and of notes; empty if there are none.
pub fn remark_sections(remarks: &Remarks) -> [String; 2] {
    let acts = [("bad", "Fault", &remarks.faults), ("odd", "Warning", &remarks.warnings)];
    [section("Warnings", "warnings", &acts), section("Notes", "notes", &[("plain", "Note", &remarks.notes)])]
}

fn section(title: &str, id: &str, lists: &[(&str, &str, &Vec<String>)]) -> String {
    if lists.iter().all(|(.., list)| list.is_empty()) {
        return String::new();
    }
    let mut out = format!(
        "<section aria-labelledby=\"{id}-title\">\n<h2 id=\"{id}-title\">{title}</h2>\n<ul class=\"warnings\">\n"
    );
    for (class, word, list) in lists {
        for text in list.iter().take(MAX_WARNINGS) {
            let _ = writeln!(out, "<li class=\"{class}\"><strong>{word}:</strong> {}</li>", escape(text));
        }
        if list.len() > MAX_WARNINGS {
            let more = count((list.len() - MAX_WARNINGS) as u64);
            let _ = writeln!(out, "<li class=\"{class}\">and {more} more like these</li>");
        }
    }
    out + "</ul>\n</section>\n"
}

/// Maximum faults, warnings, and notes on a page, each.
const MAX_WARNINGS: usize = 40;

fn facts(pack: &Analysis) -> String {
    let total = |pick: fn(&HullRow) -> usize| pack.hulls.iter().map(pick).sum::<usize>();
    let share = |bytes: usize| format!("{:.1}", bytes as f64 / pack.vertex_count.max(1) as f64);
    let mut rows = vec![
        ("Hulls", count(pack.hull_count as u64)),
        ("Hull vertices", count(pack.vertex_count as u64)),
        ("File", format!("{} bytes", count(pack.bytes as u64))),
        ("Bytes per vertex", share(pack.bytes)),
    ];
    if pack.source.is_some() {
        rows.insert(1, ("Source points", count(pack.source_points as u64)));
    }
    if pack.hulls.len() == pack.hull_count {
        rows.push(("Index, bytes per vertex", share(total(|hull| hull.index_bytes))));
    }
    let average = |pick: fn(&HullRow) -> f64| pack.hulls.iter().map(pick).sum::<f64>() / pack.hulls.len().max(1) as f64;
    let worst = |pick: fn(&HullRow) -> u32| pack.hulls.iter().map(pick).max().unwrap_or(0);
    let nodes = (average(|hull| mean(&hull.census.nodes)), worst(|hull| hull.max_nodes));
    let dots = (average(|hull| hull.census.mean_dots), worst(|hull| hull.max_dots));
    rows.push(("Nodes per query", format!("{}, at most {}", short(nodes.0), nodes.1)));
    rows.push(("Dot products per query", format!("{}, at most {}", short(dots.0), count(dots.1.into()))));
    let regrets = pack.verification.hulls.iter().map(|hull| hull.max_regret);
    if let Some(worst) = regrets.reduce(f64::max) {
        rows.push(("Maximum regret", short(worst)));
    }
    html::facts(&rows)
}

/// A table below its caption, which wraps if the table is wider than the screen.
fn table(caption: &str, heads: &str, rows: impl Iterator<Item = Vec<String>>, has_sums: bool) -> String {
    let rows: Vec<_> = rows.map(|cells| (String::new(), cells)).collect();
    format!("<p class=\"soft\">{caption}</p>\n{}", html::table(caption, heads, &rows, has_sums))
}

fn rank_name(rank: u32) -> &'static str {
    match rank {
        0 => "point",
        1 => "segment",
        2 => "polygon",
        _ => "solid",
    }
}

/// The table of the hulls, narrow enough for a screen.
fn hulls(pack: &Analysis) -> String {
    let heads = "hull: | rank: | points | vertices | faces | diameter | area | volume | error | outer error | \
                 uncovered | protrusion";
    let rows = pack.hulls.iter().map(|hull| {
        vec![
            escape(&hull.name),
            rank_name(hull.rank).to_owned(),
            count(hull.points.into()),
            count(hull.vertices as u64),
            count(hull.faces as u64),
            short(hull.diameter),
            short(hull.surface_area),
            short(hull.volume),
            short(hull.containment_error),
            short(hull.outer_error),
            or_dash(hull.uncovered, short),
            or_dash(hull.protrusion, short),
        ]
    });
    table(
        "The hulls of the pack. Error: how far a source point lies outside, relative to the diameter. Outer error: bound on \
         how far a simplified hull extends beyond its source, a length. Uncovered: bound on how far a point of the mesh's surface \
         lies outside all of its parts, a length. Protrusion: bound on how far a point of the part lies outside the mesh's \
         solid, a length.",
        heads,
        rows,
        false,
    )
}

fn verification(pack: &Analysis) -> String {
    let verification = &pack.verification;
    if verification.hulls.is_empty() {
        return "<p class=\"bad\">Not verified: the pack could not be compared with its source.</p>\n".to_owned();
    }
    let reference =
        if verification.is_against_source { "every point of the source" } else { "the stored hull's own vertices" };
    let has_simplified = verification.hulls.iter().any(|hull| hull.is_simplified);
    let simplified = if !has_simplified || pack.source.is_none() {
        ""
    } else {
        " Each simplified hull contains every point of its source and extends beyond it by at most its outer error; \
         its queries are compared with its own vertices."
    };
    let parts = if pack.has_loose_parts() && pack.source.is_some() {
        " A part is within its bounds if no tested point of the mesh refutes its uncovered distance, and no tested point of \
         the part its protrusion."
    } else {
        ""
    };
    let caption = format!(
        "Support queries of the runtime compared with {reference}, by brute force in f64, in {} directions per hull. \
         Regret is how far an answer falls short, relative to the diameter; exact means at most 2e−7.{simplified}{parts}",
        count(verification.directions as u64),
    );
    let heads = "hull: | max regret | mismatches | worst nodes | worst dots | result:";
    let is_listed = |(index, hull): &(usize, &VerifiedHull)| *index < MAX_HULLS || !hull.passed;
    let rows = verification.hulls.iter().enumerate().filter(is_listed).map(|(_, hull)| {
        let (class, word) = match (hull.passed, hull.is_simplified) {
            (false, _) => ("bad", "failed"),
            (true, _) if !hull.flaws.is_empty() => ("odd", "passed with warnings"),
            (true, _) if hull.is_loose_part && hull.is_measured && verification.is_against_source => {
                ("good", "within its bounds")
            }
            (true, _) if hull.is_loose_part && hull.is_measured => ("odd", "bounds unchecked"),
            (true, _) if hull.is_loose_part => ("odd", "unmeasured"),
            (true, false) => ("good", "exact"),
            (true, true) if verification.is_against_source => ("good", "contains its source"),
            (true, true) => ("odd", "simplified"),
        };
        vec![
            escape(&hull.name),
            short(hull.max_regret),
            count(hull.mismatches as u64),
            count(hull.max_nodes.into()),
            count(hull.max_dots.into()),
            format!("<span class=\"chip {class}\">{word}</span>"),
        ]
    });
    table(&caption, heads, rows, false)
}

fn sizes(pack: &Analysis) -> String {
    let heads = "section: | holds: | elements | bytes | per vertex | share | :";
    let per_vertex = |bytes: usize| format!("{:.1}", bytes as f64 / pack.vertex_count.max(1) as f64);
    let percent = |bytes: usize| 100.0 * bytes as f64 / pack.bytes.max(1) as f64;
    let rows = pack.sections.iter().filter(|section| section.bytes > 0).map(|section| {
        let share = percent(section.bytes);
        vec![
            format!("<code>{}</code>", section.name),
            escape(section.purpose),
            count(section.count as u64),
            count(section.bytes as u64),
            per_vertex(section.bytes),
            format!("{share:.1} %"),
            format!("<span class=\"share\" aria-hidden=\"true\"><i style=\"width:{share:.1}%\"></i></span>"),
        ]
    });
    let foot =
        ["whole file", "", "", &count(pack.bytes as u64), &per_vertex(pack.bytes), "100 %", ""].map(str::to_owned);
    table("Bytes of the file by section, in the order of the file", heads, rows.chain([foot.into()]), true)
}

fn limits(pack: &Analysis) -> String {
    let mut list = Vec::new();
    let listed = pack.hulls.len();
    if listed < pack.hull_count {
        list.push(format!(
            "Only the first {1} of {0} hulls are listed.",
            count(pack.hull_count as u64),
            count(listed as u64)
        ));
    }
    if pack.undrawn() > 0 {
        list.push(format!(
            "{} hulls are listed but not drawn, to limit the size of the page.",
            count(pack.undrawn() as u64)
        ));
    }
    let thinned = |shape: &EncodedMesh| shape.shown < shape.whole;
    let drawn = || {
        let of_hulls = pack.drawn.hulls.iter().flat_map(|hull| [&hull.source, &hull.hull]).flatten();
        of_hulls.chain(&pack.drawn.meshes)
    };
    if drawn().any(thinned) {
        let sum = |pick: fn(&EncodedMesh) -> usize| count(drawn().map(pick).sum::<usize>() as u64);
        list.push(format!(
            "Only {1} of {0} triangles are drawn: corners close together are merged. All numbers refer to the complete meshes.",
            sum(|shape| shape.whole),
            sum(|shape| shape.shown)
        ));
    }
    html::left_out(&list)
}
