//! The page of a triangle mesh or height field: its wireframe, with edges coloured by their class,
//! or its shaded relief.

use crate::html::{count, escape, facts, json, origin};
use crate::pack_page::remark_sections;
use crate::page::{Page, crumb};
use crate::surface::{DrawnClass, DrawnTriangles, SurfaceReport, View};

const WIREFRAME: Page = Page {
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

const RELIEF: Page = Page {
    kind: "field",
    generator: "bake report",
    style: ".relief { width: min(100%, 48rem); max-height: 40rem; object-fit: contain; object-position: left; image-rendering: pixelated; border: 1px solid var(--rule); }\n",
    contents: include_str!("page/field.html"),
    scripts: &[],
};

/// The page of a triangle mesh or height field: a function of the file, its source and the
/// arguments. `index` is the link to the page of its folder.
pub fn surface_page(surface: &SurfaceReport, index: Option<&str>) -> String {
    let source = surface.source.as_deref();
    let [warnings, notes] = remark_sections(&surface.remarks);
    let origin = origin(source, &surface.recorded_source, &surface.options, surface.format_version);
    let shared = [
        ("title", &*escape(&surface.file)),
        ("crumb", &crumb(index)),
        ("verdict", &surface.verdict().html()),
        ("headline", &escape(&surface.headline)),
        ("warnings", &warnings),
        ("notes", &notes),
        ("origin", &origin),
        ("facts", &facts(&surface.facts)),
        ("verification", &verification(surface)),
        ("footer", "Made by <code>bake report</code>."),
    ];
    match &surface.view {
        View::Relief(relief) => RELIEF.fill(&[&shared[..], &[("picture", relief)]].concat()),
        View::Wireframe(drawn) => {
            let limits = limits(drawn, surface.triangle_count);
            let own = [
                ("picture", &*surface.picture),
                ("classes", &classes(drawn)),
                ("limits", &limits),
                ("data", &json(drawn)),
            ];
            WIREFRAME.fill(&[&shared[..], &own].concat())
        }
    }
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

fn classes(drawn: &DrawnTriangles) -> String {
    // Only the edges at which something may be wrong are drawn at first.
    let row = |(at, class): (usize, &DrawnClass)| {
        let (name, edges) = (class.name, count(class.count as u64));
        let checked = if ["flat", "convex", "concave"].contains(&name) { "" } else { " checked" };
        format!(
            "<label><input type=\"checkbox\" data-class=\"{at}\"{checked}> \
             <span class=\"swatch\" style=\"background:var(--edge-{name})\"></span><span>{name} ({edges}): {}</span></label>\n",
            meaning(name)
        )
    };
    drawn.classes().iter().enumerate().filter(|(_, class)| class.count > 0).map(row).collect()
}

fn verification(surface: &SurfaceReport) -> String {
    let Some(checks) = &surface.checks else {
        return "<p class=\"bad\">Not verified: the file could not be compared with its source.</p>\n".to_owned();
    };
    let number = |value: usize| count(value as u64);
    let truth = if surface.source.is_some() { "the source" } else { "the file itself" };
    let (rays, hits, seed) = (number(checks.rays), number(checks.ray_hits), checks.seed);
    let compared = match checks.points {
        Some(points) => format!(
            "Every triangle, edge and vertex was compared with {truth}, and the answers for {rays} rays, of which {hits} \
             hit, and {} points with a search of all triangles, one by one, in 64-bit arithmetic (seed {seed}).",
            number(points)
        ),
        None => format!(
            "Every cell was compared with {truth}, and the answers for {rays} vertical rays, of which {hits} hit, with \
             heights between its samples (seed {seed})."
        ),
    };
    format!("<p>{compared} Wrong entries and answers: {}.</p>\n", number(checks.mismatches))
}

fn limits(drawn: &DrawnTriangles, whole: usize) -> String {
    let shown = drawn.shown();
    if shown == whole {
        return String::new();
    }
    format!(
        "<p class=\"soft\">The picture has {} of {} triangles: corners that are close together were merged.</p>\n",
        count(shown as u64),
        count(whole as u64)
    )
}
