//! The page of a triangle mesh: its wireframe, with edges coloured by their class.

use crate::html::{count, escape, json};
use crate::mesh::MeshReport;
use crate::pack_page::warnings;
use crate::page::{Page, crumb};

const PAGE: Page = Page {
    kind: "mesh",
    generator: "bake report",
    style: "",
    contents: include_str!("page/mesh.html"),
    scripts: &[
        include_str!("page/arrays.js"),
        include_str!("page/webgl.js"),
        include_str!("page/view3d.js"),
        include_str!("page/mesh.js"),
    ],
};

/// The page of a triangle mesh: a function of the file, its source and the arguments. `index` is
/// the link to the page of its folder.
pub fn mesh_page(mesh: &MeshReport, index: Option<&str>) -> String {
    let source = match &mesh.source {
        Some(source) => format!("source {}", escape(source)),
        None if mesh.recorded_source.is_empty() => "no source found".to_owned(),
        None => format!("source {} not found", escape(&mesh.recorded_source)),
    };
    let subtitle = format!("{source} · options: {} · format {}", escape(&mesh.options), mesh.format_version);
    let facts: String =
        mesh.facts.iter().map(|(name, value)| format!("<div><dt>{name}</dt><dd>{value}</dd></div>\n")).collect();
    PAGE.fill(&[
        ("title", &escape(&mesh.file)),
        ("crumb", &crumb(index)),
        ("verdict", &mesh.verdict().html()),
        ("subtitle", &subtitle),
        ("warnings", &warnings(&mesh.remarks)),
        ("facts", &facts),
        ("picture", &mesh.picture),
        ("classes", &classes(mesh)),
        ("verification", &verification(mesh)),
        ("limits", &limits(mesh)),
        ("data", &json(&mesh.drawn)),
        ("footer", "Made by <code>bake report</code>. Lengths are in the source's units."),
    ])
}

fn meaning(class: &str) -> &'static str {
    match class {
        "border" => "no other triangle has the edge",
        "flat" => "the neighbour continues in the same plane",
        "convex" => "a ridge: the neighbour falls behind the plane of the triangle",
        "concave" => "a valley: the neighbour rises before the plane of the triangle",
        "non-manifold" => "more than two triangles have the edge",
        _ => "the neighbour has the other side in front",
    }
}

fn classes(mesh: &MeshReport) -> String {
    let row = |(at, class): (usize, &crate::mesh::DrawnClass)| {
        let (name, edges) = (class.name, count(class.count as u64));
        format!(
            "<label title=\"{}\"><input type=\"checkbox\" data-class=\"{at}\" checked> \
             <span class=\"swatch\" style=\"background:var(--edge-{name})\"></span>{name} ({edges})</label>\n",
            meaning(name)
        )
    };
    mesh.drawn.classes().iter().enumerate().map(row).collect()
}

fn verification(mesh: &MeshReport) -> String {
    let Some(checks) = &mesh.checks else {
        return "<p class=\"bad\">Not verified: the mesh could not be compared with its source.</p>\n".to_owned();
    };
    let number = |value: usize| count(value as u64);
    let truth = if mesh.source.is_some() { "the source" } else { "the file itself" };
    format!(
        "<p>Every triangle, edge and vertex was compared with {truth}, and the answers for {} rays, of which {} hit, and \
         {} points with a search of all triangles, one by one, in 64-bit arithmetic (seed {}). Wrong entries and answers: \
         {}.</p>\n",
        number(checks.rays),
        number(checks.ray_hits),
        number(checks.points),
        checks.seed,
        number(checks.mismatches)
    )
}

fn limits(mesh: &MeshReport) -> String {
    let (shown, whole) = (mesh.drawn.shown(), mesh.triangle_count);
    if shown == whole {
        return String::new();
    }
    format!(
        "<p class=\"soft\">The picture has {} of {} triangles: corners that are close together were merged.</p>\n",
        count(shown as u64),
        count(whole as u64)
    )
}
