//! The page of a robot: its links in 3D with visuals and collisions, a slider for each joint, and
//! the pairs of links that touch.

use std::fmt::Write;

use hullmap::glam::{DQuat, DVec3, Vec3};
use serde::Serialize;

use crate::DisplayMesh;
use crate::display_mesh::{EncodedMesh, triangle_limit};
use crate::html::{self, count, escape, json, or_dash};
use crate::input::Up;
use crate::pack_page::remark_sections;
use crate::page::Page;
use crate::part_colours::{COLOURS, assigned};
use crate::picture::picture_of_parts;
use crate::robot::{Joint, Layer, Link, Placement, Robot, Touching};
use crate::verdict::FAILED;

const PAGE: Page = Page {
    kind: "robot",
    generator: "bake robot",
    style: "",
    contents: include_str!("page/robot.html"),
    scripts: &[
        include_str!("page/arrays.js"),
        include_str!("page/webgl.js"),
        include_str!("page/view3d.js"),
        include_str!("page/elements.js"),
        include_str!("page/chain.js"),
        include_str!("page/robot.js"),
    ],
};

/// Bytes of meshes on a page. Later meshes are not drawn.
const MESH_BUDGET: usize = 12_000_000;

const MAX_ROWS: usize = 2_000;

#[derive(Serialize)]
struct Drawn {
    up: Up,
    meshes: Vec<Option<EncodedMesh>>,
    links: Vec<DrawnLink>,
    joints: Vec<Joint>,
}

#[derive(Serialize)]
struct DrawnLink {
    name: String,
    parent: Option<usize>,
    rest: Placement,
    neutral: Placement,
    shapes: Vec<DrawnShape>,
}

#[derive(Serialize)]
struct DrawnShape {
    layer: Layer,
    mesh: usize,
    in_link: [[f64; 3]; 4],
    colour: [u8; 3],
}

/// The page of a robot. It depends on its argument alone.
pub fn robot_page(robot: &Robot) -> String {
    let limit = triangle_limit(robot.meshes.len());
    let meshes: Vec<DisplayMesh> = robot.meshes.iter().map(|mesh| mesh.with_at_most(limit)).collect();
    let (colours, picture) = colours_and_picture(robot, &meshes);
    let drawn = draw(robot, &meshes, &colours);
    let undrawn =
        drawn.meshes.iter().zip(&meshes).filter(|(own, mesh)| own.is_none() && !mesh.points.is_empty()).count();
    let title = escape(&robot.file);
    let origin = format!("{} · written to {}", escape(&robot.format), escape(&robot.output));
    let [warnings, notes] = remark_sections(&robot.remarks);
    PAGE.fill(&[
        ("title", &title),
        ("verdict", &verdict(robot)),
        ("headline", &headline(robot)),
        ("warnings", &warnings),
        ("notes", &notes),
        ("origin", &origin),
        ("facts", &facts(robot)),
        ("picture", &picture),
        ("links", &links(robot)),
        ("touching", &touching(robot)),
        ("excluded", &excluded(robot)),
        ("limits", &limits(robot, &meshes, undrawn)),
        ("data", &json(&drawn)),
        ("footer", "Made by <code>bake robot --report</code>. Lengths are in metres unless another unit is stated."),
    ])
}

/// Every new collision, with the point of a mesh mapped into the world in the neutral pose.
fn after(robot: &Robot) -> impl Iterator<Item = (usize, impl Fn([f32; 3]) -> Vec3)> {
    robot.links.iter().flat_map(|link| {
        let (turn, origin) = (DQuat::from_array(link.neutral.rotation), DVec3::from_array(link.neutral.translation));
        link.shapes.iter().filter(|shape| shape.layer == Layer::After).map(move |shape| {
            let [x, y, z, at] = shape.in_link.map(DVec3::from_array);
            let place = move |point: [f32; 3]| {
                let [a, b, c] = point.map(f64::from);
                (turn * (x * a + y * b + z * c + at) + origin).as_vec3()
            };
            (shape.mesh, place)
        })
    })
}

/// The colour of each new collision, so that neighbours differ in the neutral pose, and a picture.
fn colours_and_picture(robot: &Robot, meshes: &[DisplayMesh]) -> (Vec<usize>, String) {
    let placed: Vec<DisplayMesh> = after(robot)
        .map(|(mesh, place)| {
            let own = &meshes[mesh];
            let points = own.points.iter().map(|point| place(*point).to_array()).collect();
            DisplayMesh { points, ..own.clone() }
        })
        .collect();
    let boxes: Vec<[Vec3; 2]> = placed.iter().map(|mesh| mesh.bounds().map(Vec3::from_array)).collect();
    let colours = assigned(&boxes);
    let picture = picture_of_parts(&placed, &colours, Up::Z);
    (colours, picture)
}

fn draw(robot: &Robot, meshes: &[DisplayMesh], colours: &[usize]) -> Drawn {
    let mut room = MESH_BUDGET;
    let mut encode = |(mesh, whole): (&DisplayMesh, &DisplayMesh)| {
        // A mesh without points has no box.
        if room == 0 || mesh.points.is_empty() {
            return None;
        }
        let encoded = mesh.encoded(whole);
        room = room.saturating_sub(html::json(&encoded).len());
        Some(encoded)
    };
    let meshes = meshes.iter().zip(&robot.meshes).map(&mut encode).collect();
    let mut next = colours.iter();
    let links = robot.links.iter().map(|link| DrawnLink {
        name: html::plain(&link.name),
        parent: link.parent,
        rest: link.rest,
        neutral: link.neutral,
        shapes: link
            .shapes
            .iter()
            .map(|shape| {
                let colour = if shape.layer == Layer::After { next.next().map_or(0, |colour| *colour) } else { 0 };
                DrawnShape { layer: shape.layer, mesh: shape.mesh, in_link: shape.in_link, colour: COLOURS[colour] }
            })
            .collect(),
    });
    let links = links.collect();
    let joints = robot.joints.iter().map(|joint| Joint { name: html::plain(&joint.name), ..joint.clone() }).collect();
    Drawn { up: Up::Z, meshes, links, joints }
}

/// Pairs that engines test and that touch, before and after.
fn touching_counts(robot: &Robot) -> [usize; 2] {
    let count = |side: usize| robot.touching.iter().filter(|pair| !pair.is_untested && pair.touches[side]).count();
    [count(0), count(1)]
}

fn verdict(robot: &Robot) -> String {
    let chip = |class: &str, text: &str| format!("<span class=\"chip {class}\">{text}</span>");
    match touching_counts(robot) {
        _ if !robot.remarks.faults.is_empty() => chip("bad", "failed"),
        [_, 0] => chip("good", "no links touch"),
        [_, after] => chip("odd", &format!("{} touch", pairs(after))),
    }
}

fn headline(robot: &Robot) -> String {
    if !robot.remarks.faults.is_empty() {
        return FAILED.to_owned();
    }
    let sum = |side: usize| robot.links.iter().map(|link| link.pieces[side]).sum::<usize>() as u64;
    let touching = match touching_counts(robot)[1] {
        0 => "no links touch in the neutral pose".to_owned(),
        1 => "1 pair of links touches in the neutral pose".to_owned(),
        some => format!("{} pairs of links touch in the neutral pose", count(some as u64)),
    };
    let far = worst(robot, |link| link.protrusion_mm[1]);
    let far = far.map_or_else(String::new, |far| format!("; no shape leaves its link by more than {far:.2}\u{a0}mm"));
    format!("{} convex shapes instead of {}; {touching}{far}.", count(sum(1)), count(sum(0)))
}

fn pairs(n: usize) -> String {
    format!("{} {}", count(n as u64), if n == 1 { "pair" } else { "pairs" })
}

fn mm(length: Option<f64>) -> String {
    or_dash(length, |length| format!("{length:.2}"))
}

fn worst(robot: &Robot, pick: impl Fn(&Link) -> Option<f64>) -> Option<f64> {
    robot.links.iter().filter_map(pick).reduce(f64::max)
}

fn facts(robot: &Robot) -> String {
    let sum = |side: usize| count(robot.links.iter().map(|link| link.pieces[side]).sum::<usize>() as u64);
    let [before, after] = touching_counts(robot);
    let millimetres = |length: Option<f64>| or_dash(length, |length| format!("{length:.2} mm"));
    let rows = [
        ("Links", count(robot.links.len() as u64)),
        ("Joints that move", count(robot.joints.len() as u64)),
        ("Convex pieces before", sum(0)),
        ("Convex pieces after", sum(1)),
        ("Worst protrusion before", millimetres(worst(robot, |link| link.protrusion_mm[0]))),
        ("Worst protrusion after", millimetres(worst(robot, |link| link.protrusion_mm[1]))),
        ("Pairs that touch before", count(before as u64)),
        ("Pairs that touch after", count(after as u64)),
    ];
    html::facts(&rows)
}

/// A table whose rows have the links that they show, and cells; the first becomes a button.
fn table(label: &str, heads: &str, rows: &[(Vec<usize>, Vec<String>)]) -> String {
    let shown = rows.iter().take(MAX_ROWS).map(|(links, cells)| {
        let links: Vec<String> = links.iter().map(usize::to_string).collect();
        let mut cells = cells.clone();
        cells[0] = html::button(&cells[0]);
        (format!(" data-links=\"{}\"", links.join(" ")), cells)
    });
    let mut out = html::table(label, heads, &shown.collect::<Vec<_>>(), false);
    if rows.len() > MAX_ROWS {
        let _ = writeln!(out, "<p class=\"soft\">and {} more</p>", count((rows.len() - MAX_ROWS) as u64));
    }
    out
}

fn links(robot: &Robot) -> String {
    let mut shown: Vec<(usize, &Link)> =
        robot.links.iter().enumerate().filter(|(_, link)| link.pieces != [0, 0] || !link.becomes.is_empty()).collect();
    // The worst first; links whose bound is not known are last.
    shown.sort_by(|(_, a), (_, b)| {
        let bound = |link: &Link| link.protrusion_mm[1].unwrap_or(-1.0);
        bound(b).total_cmp(&bound(a))
    });
    let rows: Vec<(Vec<usize>, Vec<String>)> = shown
        .into_iter()
        .map(|(index, link)| {
            let [before, after] = link.pieces.map(|pieces| count(pieces as u64));
            let cells = vec![
                escape(&link.name),
                escape(&link.becomes),
                before,
                after,
                or_dash(link.vertices, |vertices| count(vertices as u64)),
                mm(link.protrusion_mm[0]),
                mm(link.protrusion_mm[1]),
                mm(link.uncovered_mm),
            ];
            (vec![index], cells)
        })
        .collect();
    let heads =
        "link: | becomes: | pieces before | after | vertices | protrusion before, mm | after, mm | uncovered, mm";
    "<p class=\"soft\">The worst link first. Point at a row to show its link in the pictures; press the button in it to keep \
     it shown. Protrusion: bound on how far a collision lies outside of the solid that its mesh bounds. Before: of the \
     convex hull of the mesh, which engines use in its place. Uncovered: bound on how far the surface of the mesh lies \
     outside of the new collisions.</p>\n"
        .to_owned()
        + &table("Links, the worst first", heads, &rows)
}

fn touching(robot: &Robot) -> String {
    let row = |pair: &&Touching| {
        let [a, b] = pair.links.map(|link| escape(&robot.links[link].name));
        let [before, after] = pair.touches.map(|touches| if touches { "touch" } else { "–" }.to_owned());
        (pair.links.to_vec(), vec![a, b, before, after])
    };
    let heads = "link: | link: | before: | after:";
    let section = |is_untested: bool, label: &str| {
        let rows: Vec<_> =
            robot.touching.iter().filter(|pair| pair.is_untested == is_untested).map(|pair| row(&pair)).collect();
        if rows.is_empty() { "<p>None.</p>\n".to_owned() } else { table(label, heads, &rows) }
    };
    let untested = robot.touching.iter().filter(|pair| pair.is_untested).count();
    format!(
        "<p class=\"soft\">Before: the convex hull of each collision mesh, which is what engines test, and primitives. After: \
         the new collisions. Planes and height fields are not tested.</p>\n{}\
         <details><summary>{} that engines do not test: neighbours in the chain, and pairs that the description excludes</summary>\n{}</details>\n",
        section(false, "Links that touch"),
        pairs(untested),
        section(true, "Links that touch and are not tested"),
    )
}

fn excluded(robot: &Robot) -> String {
    let rows: Vec<_> = robot
        .excluded
        .iter()
        .map(|pair| {
            let [a, b] = pair.links.map(|link| escape(&robot.links[link].name));
            (pair.links.to_vec(), vec![a, b, escape(pair.reason)])
        })
        .collect();
    let note = format!("<p class=\"soft\">{}</p>\n", escape(&robot.exclusion));
    let heads = "link: | link: | reason:";
    note + &if rows.is_empty() { "<p>None.</p>\n".to_owned() } else { table("Pairs to exclude", heads, &rows) }
}

fn limits(robot: &Robot, meshes: &[DisplayMesh], undrawn: usize) -> String {
    let mut list = Vec::new();
    let sum = |meshes: &[DisplayMesh]| meshes.iter().map(|mesh| mesh.triangles.len()).sum::<usize>();
    let (shown, whole) = (sum(meshes), sum(&robot.meshes));
    if shown < whole {
        list.push(format!(
            "Only {} of {} triangles are drawn: corners close together are merged. All numbers refer to the complete meshes.",
            count(shown as u64),
            count(whole as u64)
        ));
    }
    if undrawn > 0 {
        list.push(format!("Meshes not drawn, to limit the size of the page: {}.", count(undrawn as u64)));
    }
    html::left_out(&list)
}
