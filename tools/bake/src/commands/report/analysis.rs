//! All that a report says of one pack, before any of it is HTML.

use std::path::Path;
use std::time::{Duration, Instant};

use hullmap::{Hull, IndexKind, Pack};
use serde::Serialize;

use super::census::{Census, Pace, census, direction_count, even_directions, pace};
use super::gauss_map::{FACES, Face, GaussMap, gauss_map, resolution};
use super::index_reader::Contents;
use super::picture::picture;
use super::shape::{Shape, ShownShape, triangle_cap};
use super::sizes::Section;
use super::source_mesh::source_shapes;
use super::warnings::{Remarks, of_hull, of_pack};
use crate::args::{ReportArgs, Up};
use crate::commands::verify::{HullReport, Truth, verify_hulls};
use crate::open::open_pack;
use crate::outcome::{Exit, Failure};
use crate::packs::PackPlace;
use crate::source::{Recorded, Source, find_source};

/// Hulls of one pack that a page has rows and pictures of; what fails beyond is named all the same.
pub const MAX_HULLS: usize = 1_000;

/// Bytes of pictures and maps on a page; hulls that come after have their rows alone.
const PICTURE_BUDGET: usize = 8_000_000;

/// Triangles of the still picture: more than it has pixels to show.
const STILL_TRIANGLES: usize = 60_000;

/// One pack.
#[derive(Debug)]
pub struct Analysis {
    /// The pack's path, as it was given or found.
    pub file: String,
    /// Bytes of the file.
    pub bytes: usize,
    /// Version of its format.
    pub format_version: u32,
    /// The options that shaped the bake.
    pub options: String,
    /// The path of the source that the pack records.
    pub recorded_source: String,
    /// The source that was found.
    pub source: Option<String>,
    /// Points of the source, over all hulls.
    pub source_points: usize,
    /// The hulls, in the file's order; [`MAX_HULLS`] at most.
    pub hulls: Vec<HullFacts>,
    /// Hulls of the pack.
    pub hull_count: usize,
    /// Vertices over all hulls.
    pub vertex_count: usize,
    /// What verification found, of every hull.
    pub verification: Vec<HullReport>,
    /// What is wrong: the pack is found wanting.
    pub faults: Vec<String>,
    /// What one should look at.
    pub warnings: Vec<String>,
    /// What one may want to know.
    pub notes: Vec<String>,
    /// Bytes by section.
    pub sections: Vec<Section>,
    /// What the page draws.
    pub drawn: Drawn,
    /// A still picture, as a `data:` address.
    pub picture: String,
    /// What was timed.
    pub times: Times,
}

/// Facts about a hull.
#[derive(Debug)]
pub struct HullFacts {
    /// Name.
    pub name: String,
    /// 3 solid, 2 polygon, 1 segment, 0 point.
    pub rank: u32,
    /// Source points that it was built of.
    pub points: u32,
    /// Vertices.
    pub vertices: usize,
    /// Faces.
    pub faces: usize,
    /// Volume.
    pub volume: f64,
    /// Surface area.
    pub surface_area: f64,
    /// Greatest distance between two vertices.
    pub diameter: f64,
    /// How far the worst source point lies outside, over the diameter.
    pub containment_error: f64,
    /// How far it may reach beyond its source, a length; 0 for an exact one.
    pub outer_error: f64,
    /// How far a vertex of the object may lie outside of all of its parts, a length.
    pub uncovered: f64,
    /// Kind of index, in words.
    pub index: String,
    /// Bytes of the index.
    pub index_bytes: usize,
    /// Most nodes of a query.
    pub max_nodes: u32,
    /// Most dot products of a query.
    pub max_dots: u32,
    /// What queries cost on average.
    pub census: Census,
}

/// What was timed while reporting. Nothing else in a report differs from run to run.
#[derive(Debug)]
pub struct Times {
    /// Opening the pack, all checks included.
    pub open: Duration,
    /// Verification of all hulls.
    pub verification: Duration,
    /// Queries and scans of each hull that has facts.
    pub paces: Vec<Pace>,
}

/// The data of a page's pictures.
#[derive(Debug, Serialize)]
pub struct Drawn {
    /// How the cube's faces lie in the cross.
    pub faces: [Face; 6],
    /// Which axis points up at first.
    pub up: Up,
    /// Hulls of the pack.
    pub hull_count: usize,
    /// The hulls that have facts.
    pub hulls: Vec<DrawnHull>,
    /// The source's meshes, where they are not one for each hull, as of a mesh that was cut into parts.
    pub meshes: Vec<ShownShape>,
}

/// The data of one hull's pictures.
#[derive(Debug, Serialize)]
pub struct DrawnHull {
    /// Its number in the pack.
    pub number: usize,
    /// Its name, with nothing in it that could hide the rest.
    pub name: String,
    rank: u32,
    points: u32,
    vertices: usize,
    faces: usize,
    /// Kind of index.
    index: String,
    /// The source mesh, where it was found and there is room.
    pub source: Option<ShownShape>,
    /// The hull, where there is room.
    pub hull: Option<ShownShape>,
    /// The Gauss map, where there is room.
    pub gauss: Option<GaussMap>,
    census: Census,
}

impl Analysis {
    /// Whether the pack is found wanting.
    pub fn exit(&self) -> Exit {
        if self.faults.is_empty() { Exit::Done } else { Exit::Wanting }
    }

    /// Whether every hull is that of its points, and none was simplified.
    pub fn is_exact(&self) -> bool {
        self.verification.iter().all(|report| report.outer_error == Some(0.0))
    }

    /// Hulls that have facts but are not drawn.
    pub fn undrawn(&self) -> usize {
        self.drawn.hulls.iter().filter(|hull| hull.hull.is_none()).count()
    }
}

/// Opens, verifies, counts and draws a pack; `asked` is what `--source` says for it.
///
/// # Errors
/// The pack cannot be read or is none; `--source` names nothing. What is wrong with a pack that opens is among its faults.
pub fn analyse(place: &PackPlace, asked: Option<&Path>, args: &ReportArgs) -> Result<Analysis, Failure> {
    let start = Instant::now();
    let pack = open_pack(&place.path)?;
    let open = start.elapsed();
    let contents = Contents::read(&place.path, &pack)?;
    let mut faults = Vec::new();
    let source = match find_source(place, Recorded::of(&pack), asked) {
        Err(failure) if failure.exit == Exit::Wanting => {
            faults.push(failure.message);
            None
        }
        found => found?,
    };

    let start = Instant::now();
    let verification = verify(&pack, source.as_ref(), args, &mut faults);
    let verified = start.elapsed();

    let hull_count = pack.hull_count();
    let shown_count = hull_count.min(MAX_HULLS);
    let directions = even_directions(direction_count(shown_count));
    let Remarks { mut notes, mut warnings } = of_pack(&pack, source.as_ref());
    if source.is_none() {
        let found = if faults.is_empty() { "was not found" } else { "cannot be used" };
        let told = format!(
            "the source {found}, so the hull stands alone and was compared with itself only; --source names the file"
        );
        warnings.insert(0, told);
    }
    let meshes = source.as_ref().map(source_shapes);
    let mut hulls = Vec::new();
    let mut paces = Vec::new();
    for (number, hull) in pack.hulls().take(shown_count).enumerate() {
        let census = census(&contents.indices[number], &directions);
        let found = of_hull(&hull, &census);
        notes.extend(found.notes);
        warnings.extend(found.warnings);
        paces.push(pace(&hull, &directions, shown_count));
        hulls.push(facts(&hull, census));
    }
    let drawn = draw(&pack, &contents, meshes.as_deref(), &hulls, args.up);
    Ok(Analysis {
        file: place.path.display().to_string(),
        bytes: pack.byte_len(),
        format_version: pack.header().format_version,
        options: pack.options().to_owned(),
        recorded_source: pack.source_path().to_owned(),
        source: source.as_ref().map(|source| source_name(source, &pack)),
        source_points: source.iter().flat_map(|source| &source.point_sets).map(|set| set.positions.len()).sum(),
        hull_count,
        vertex_count: pack.hulls().map(|hull| hull.vertex_count()).sum(),
        verification,
        faults,
        warnings,
        notes,
        sections: contents.sections,
        picture: still(&pack, meshes.unwrap_or_default(), args.up),
        hulls,
        drawn,
        times: Times { open, verification: verified, paces },
    })
}

/// How a page names the source. The path that leads to it from the pack names the machine's folders: what the pack records
/// stands for it.
fn source_name(source: &Source, pack: &Pack) -> String {
    if source.path.is_absolute() && !pack.source_path().is_empty() {
        return pack.source_path().to_owned();
    }
    source.path.display().to_string()
}

fn verify(pack: &Pack, source: Option<&Source>, args: &ReportArgs, faults: &mut Vec<String>) -> Vec<HullReport> {
    let truth = source.map_or(Truth::Stored, |source| Truth::Source(&source.point_sets));
    match verify_hulls(pack, &truth, args.directions, args.seed) {
        Ok(reports) => {
            let failed = reports.iter().filter(|report| !report.pass);
            faults.extend(failed.map(|report| report.verdict()));
            reports
        }
        Err(error) => {
            faults.push(error);
            Vec::new()
        }
    }
}

fn facts(hull: &Hull, census: Census) -> HullFacts {
    let worst = hull.worst_cost();
    HullFacts {
        name: hull.name().to_owned(),
        rank: hull.rank(),
        points: hull.source_point_count(),
        vertices: hull.vertex_count(),
        faces: hull.face_count(),
        volume: hull.volume(),
        surface_area: hull.surface_area(),
        diameter: hull.diameter(),
        containment_error: hull.containment_error(),
        outer_error: hull.outer_error(),
        uncovered: hull.uncovered(),
        index: match hull.index_kind() {
            IndexKind::Tree { leaf } => format!("tree, leaves of {leaf}"),
            IndexKind::Binary => "binary".to_owned(),
            IndexKind::CubeMap { resolution } => format!("cubemap {resolution}"),
            IndexKind::None => "none".to_owned(),
        },
        index_bytes: hull.index_byte_len(),
        max_nodes: worst.nodes,
        max_dots: worst.dots,
        census,
    }
}

/// Draws hulls in their order for as long as there is room on the page.
fn draw(pack: &Pack, contents: &Contents, meshes: Option<&[Shape]>, hulls: &[HullFacts], up: Up) -> Drawn {
    let (cap, resolution) = (triangle_cap(hulls.len()), resolution(hulls.len()));
    let pairs = meshes.filter(|meshes| meshes.len() == pack.hull_count());
    let of_all = meshes.filter(|_| pairs.is_none()).unwrap_or_default();
    let mesh_cap = triangle_cap(of_all.len());
    let whole = of_all.iter().take(MAX_HULLS).map(|mesh| mesh.with_at_most(mesh_cap).shown(mesh));
    let meshes: Vec<ShownShape> = whole.collect();
    let mut room = PICTURE_BUDGET.saturating_sub(super::html::json(&meshes).len());
    let mut drawn = Vec::new();
    for (number, (hull, facts)) in pack.hulls().zip(hulls).enumerate() {
        let mut next = DrawnHull {
            number,
            name: super::html::plain(&facts.name),
            rank: facts.rank,
            points: facts.points,
            vertices: facts.vertices,
            faces: facts.faces,
            index: facts.index.clone(),
            source: None,
            hull: None,
            gauss: None,
            census: facts.census.clone(),
        };
        if room > 0 {
            let shown = |shape: &Shape| shape.with_at_most(cap).shown(shape);
            next.source = pairs.and_then(|meshes| meshes.get(number)).map(shown);
            next.hull = Some(shown(&Shape::of_hull(&hull)));
            next.gauss = Some(gauss_map(&hull, &contents.indices[number], resolution));
            room = room.saturating_sub(super::html::json(&next).len());
        }
        drawn.push(next);
    }
    Drawn { faces: FACES, up, hull_count: pack.hull_count(), hulls: drawn, meshes }
}

/// The still picture: hulls around the mesh; of a pack whose source is gone the hulls alone.
fn still(pack: &Pack, meshes: Vec<Shape>, up: Up) -> String {
    let cap = STILL_TRIANGLES.div_ceil(pack.hull_count());
    let hulls: Vec<Shape> = pack.hulls().map(|hull| Shape::of_hull(&hull).with_at_most(cap)).collect();
    picture(&hulls, &meshes, up)
}
