//! `bake inspect`: describes the hulls in packs, triangle meshes and height fields.

mod surface;

use hullmap::{Asset, Hull, IndexKind, Pack, SolidKind};
use hullmap_geometry::number::{percent, short};
use hullmap_import::UpAxis;
use serde::Serialize;

use crate::args::InspectArgs;
use crate::table::shortest;
use crate::terminal::{self, Output};
use hullmap_bake::advice::REVERSED;
use hullmap_bake::parts::estimates::MirrorPlane;
use hullmap_geometry::number::{grouped, rounded};
use hullmap_pipeline::mesh_file::body::BodyPrimitive;
use hullmap_pipeline::open::{kept_warnings, open_asset};
use hullmap_pipeline::options::BuildOptions;
use hullmap_pipeline::outcome::{Exit, Failure};
use hullmap_pipeline::packs::find_packs;
use hullmap_verify::geometry::{polygons, positions, rank_name};
use surface::{Surface, SurfaceDescription};

/// Description of a pack. Field names are the JSON's.
#[derive(Debug, Serialize)]
struct PackDescription {
    file: String,
    format_version: u32,
    lean: bool,
    bytes: u64,
    source: String,
    options: String,
    /// XXH3-128 of the source, 32 hexadecimal digits.
    source_hash: String,
    warnings: Vec<String>,
    hulls: Vec<HullDescription>,
}

/// Description of a hull. Lengths are in source units; the containment error in diameters.
#[derive(Debug, Serialize)]
struct HullDescription {
    name: String,
    rank: u32,
    vertices: usize,
    faces: usize,
    points: usize,
    volume: f64,
    surface_area: f64,
    centroid: [f64; 3],
    bounds: [[f32; 3]; 2],
    diameter: f64,
    containment_error: f64,
    outer_error: f64,
    uncovered: Option<f64>,
    protrusion: Option<f64>,
    protrusion_at: Option<[f64; 3]>,
    /// Kind of the mesh's solid: `watertight`, `closed` or `walls`.
    solid: Option<&'static str>,
    part: u32,
    part_count: u32,
    symmetry: Option<MirrorPlane>,
    origin: [f64; 3],
    positions: Option<Vec<[f32; 3]>>,
    polygons: Option<Vec<Vec<u32>>>,
    /// Volume, centre of mass and inertia tensor (about it, at density 1) of the mesh, if recorded.
    mesh_volume: Option<f64>,
    mesh_centroid: Option<[f64; 3]>,
    mesh_inertia: Option<[[f64; 3]; 3]>,
    voids: Option<f64>,
    voids_error: Option<f64>,
    primitive: Option<BodyPrimitive>,
    index: IndexDescription,
}

#[derive(Debug, Serialize)]
struct IndexDescription {
    kind: String,
    /// Cells along each edge of a cube face, for a cube map.
    resolution: Option<u32>,
    bytes: u64,
    max_nodes: u32,
    max_dots: u32,
}

pub fn run(args: &InspectArgs, out: &mut Output) -> Result<Exit, Failure> {
    let mut exit = Exit::Done;
    for (index, place) in find_packs(&args.inputs)?.iter().enumerate() {
        let asset = match open_asset(&place.path) {
            Ok(asset) => asset,
            Err(failure) => {
                exit = exit.max(failure.exit);
                terminal::error(failure);
                continue;
            }
        };
        if index > 0 && !args.json {
            out.line("")?;
        }
        let path = place.path.display().to_string();
        let surface = match &asset {
            Asset::Pack(pack) => {
                let described = report(path, pack, kept_warnings(&asset), args.vertices);
                if args.json {
                    out.json(&described)?
                } else {
                    write_text(&described, out)?
                }
                continue;
            }
            Asset::TriangleMesh(mesh) => Surface::of_mesh(mesh, args.vertices),
            Asset::HeightField(field) => Surface::of_field(field, args.vertices),
        };
        let described = SurfaceDescription::new(path, &asset, surface);
        if args.json { out.json(&described)? } else { described.write_text(out)? }
    }
    Ok(exit)
}

fn report(file: String, pack: &Pack, warnings: Vec<String>, has_vertices: bool) -> PackDescription {
    let header = pack.header();
    PackDescription {
        file,
        format_version: header.format_version,
        lean: pack.is_lean(),
        bytes: pack.byte_len() as u64,
        source: pack.source_path().to_owned(),
        options: pack.options().to_owned(),
        source_hash: format!("{:032x}", header.source_hash),
        warnings,
        hulls: described(&pack.hulls().collect::<Vec<_>>(), has_vertices),
    }
}

fn described(hulls: &[Hull], has_vertices: bool) -> Vec<HullDescription> {
    let of_object = |own: &[Hull]| {
        let vertices: Vec<Vec<[f32; 3]>> = own.iter().map(positions).collect();
        let symmetry = MirrorPlane::find(&vertices.iter().map(Vec::as_slice).collect::<Vec<_>>());
        own.iter().map(|hull| describe(hull, symmetry, has_vertices)).collect::<Vec<_>>()
    };
    hulls.chunk_by(|_, next| next.part() > 0).flat_map(of_object).collect()
}

fn describe(hull: &Hull, symmetry: Option<MirrorPlane>, has_vertices: bool) -> HullDescription {
    let worst = hull.worst_cost();
    let kind = hull.index_kind();
    let mesh = hull.mesh_mass_properties(1.0);
    HullDescription {
        name: hull.name().to_owned(),
        rank: hull.rank(),
        vertices: hull.vertex_count(),
        faces: hull.face_count(),
        points: hull.source_point_count() as usize,
        volume: hull.volume(),
        surface_area: hull.surface_area(),
        centroid: hull.centroid().to_array(),
        bounds: hull.bounds().map(|corner| corner.to_array()),
        diameter: hull.diameter(),
        containment_error: hull.containment_error(),
        outer_error: hull.outer_error(),
        uncovered: hull.uncovered(),
        protrusion: hull.protrusion(),
        protrusion_at: hull.protrusion_at().map(|at| at.to_array()),
        solid: hull.solid().map(SolidKind::as_str),
        part: hull.part(),
        part_count: hull.part_count(),
        symmetry,
        origin: hull.origin().to_array(),
        positions: has_vertices.then(|| positions(hull)),
        polygons: has_vertices.then(|| polygons(hull)),
        mesh_volume: mesh.map(|mesh| mesh.mass),
        mesh_centroid: mesh.map(|mesh| mesh.center_of_mass.to_array()),
        mesh_inertia: mesh.map(|mesh| mesh.inertia.to_cols_array_2d()),
        voids: hull.voids().map(|voids| voids.share),
        voids_error: hull.voids().map(|voids| voids.error),
        primitive: BodyPrimitive::from_hull(hull, UpAxis::Keep),
        index: IndexDescription {
            kind: kind.as_str().to_owned(),
            resolution: matches!(kind, IndexKind::CubeMap { .. }).then_some(kind.resolution()),
            bytes: hull.index_byte_len() as u64,
            max_nodes: worst.nodes,
            max_dots: worst.dots,
        },
    }
}

fn write_text(report: &PackDescription, out: &mut Output) -> Result<(), Failure> {
    let number = |value: usize| grouped(value as u64);
    out.line(format_args!("{}", report.file))?;
    let lean = if report.lean { " (lean)" } else { "" };
    out.line(format_args!("  format version     {}{lean}", report.format_version))?;
    out.line(format_args!("  bytes              {}", grouped(report.bytes)))?;
    out.line(format_args!("  source             {} (xxh3 {})", report.source, report.source_hash))?;
    out.line(format_args!("  options            {}", BuildOptions::recorded_in_words(&report.options)))?;
    for warning in &report.warnings {
        out.line(format_args!("  warning            {warning}"))?;
    }
    for (hull_index, hull) in report.hulls.iter().enumerate() {
        let [low, high] = hull.bounds.map(|corner| corner.map(shortest).join(" "));
        let index = &hull.index;
        out.line("")?;
        out.line(format_args!("hull #{hull_index} {}", hull.name))?;
        out.line(format_args!("  rank               {} ({})", hull.rank, rank_name(hull.rank)))?;
        out.line(format_args!("  points             {}", number(hull.points)))?;
        out.line(format_args!("  vertices           {}", number(hull.vertices)))?;
        let is_left_out = hull.faces == 0 && hull.rank >= 2;
        let faces = if is_left_out { "not in the pack".to_owned() } else { number(hull.faces) };
        out.line(format_args!("  faces              {faces}"))?;
        out.line(format_args!("  volume             {}", rounded(hull.volume)))?;
        out.line(format_args!("  surface area       {}", rounded(hull.surface_area)))?;
        out.line(format_args!("  centroid           {}", hull.centroid.map(rounded).join(" ")))?;
        out.line(format_args!("  bounds             {low} to {high}"))?;
        out.line(format_args!("  diameter           {}", rounded(hull.diameter)))?;
        out.line(format_args!("  containment error  {} of the diameter", short(hull.containment_error)))?;
        if hull.outer_error > 0.0 {
            let share = percent(hull.outer_error / hull.diameter);
            out.line(format_args!("  outer error        {} ({share} of the diameter)", short(hull.outer_error)))?;
        }
        if let (Some(volume), Some(centroid), 0) = (hull.mesh_volume, hull.mesh_centroid, hull.part) {
            let centroid = centroid.map(rounded).join(" ");
            out.line(format_args!("  mesh               volume {}, centre of mass {centroid}", rounded(volume)))?;
        } else if hull.part == 0 {
            out.line(format_args!("  mesh               mass unknown: {}", no_mass(report, hull)))?;
        }
        if hull.part_count > 0 {
            write_part(hull, out)?;
        }
        if hull.origin != [0.0; 3] {
            out.line(format_args!("  origin             {} in the source", hull.origin.map(rounded).join(" ")))?;
        }
        out.line(format_args!(
            "  index              {}, {} bytes ({:.1} per vertex), at most {} nodes and {} dot products per query",
            index.kind,
            grouped(index.bytes),
            index.bytes as f64 / hull.vertices.max(1) as f64,
            index.max_nodes,
            index.max_dots
        ))?;
    }
    Ok(())
}

/// Why the mass of the first part's mesh is unknown. Builds warn of reversed triangles, and name
/// only some meshes if there are many.
fn no_mass(report: &PackDescription, hull: &HullDescription) -> &'static str {
    let mut reversed = report.warnings.iter().filter(|warning| warning.contains(REVERSED)).peekable();
    let is_only_mesh = report.hulls.iter().filter(|hull| hull.part == 0).count() == 1;
    let is_closed = hull.solid == Some(SolidKind::Watertight.as_str());
    if reversed.peek().is_none() && !is_closed {
        "the mesh is not watertight"
    } else if is_closed || is_only_mesh || reversed.any(|warning| warning.starts_with(&format!("{}: ", hull.name))) {
        "some triangles are reversed"
    } else {
        "it is open, or some triangles are reversed"
    }
}

fn write_part(hull: &HullDescription, out: &mut Output) -> Result<(), Failure> {
    let symmetric = hull.symmetry.map_or_else(String::new, |plane| format!(", symmetric about {}", plane.in_words()));
    out.line(format_args!("  part               {} of {} of its object{symmetric}", hull.part, hull.part_count))?;
    let (Some(solid), Some(uncovered), Some(protrusion), Some(at)) =
        (hull.solid, hull.uncovered, hull.protrusion, hull.protrusion_at)
    else {
        return Ok(out.line(format_args!("  fit                unmeasured: its mesh is not known"))?);
    };
    out.line(format_args!("  solid              {solid}"))?;
    out.line(format_args!("  uncovered          at most {}, of the surface outside all parts", short(uncovered)))?;
    let at = at.map(rounded).join(" ");
    out.line(format_args!("  protrusion         at most {}, greatest at {at}", short(protrusion)))?;
    if let (Some(voids), Some(error)) = (hull.voids, hull.voids_error) {
        let error = short(100.0 * error);
        out.line(format_args!("  voids              {} ± {error} % of the solid is in no part", short(100.0 * voids)))?;
    }
    if let Some(primitive) = &hull.primitive {
        let BodyPrimitive { kind, protrusion, .. } = primitive;
        out.line(format_args!("  primitive          {kind}, protrudes by at most {}", short(*protrusion)))?;
    }
    Ok(())
}
