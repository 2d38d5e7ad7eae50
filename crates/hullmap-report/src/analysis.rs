//! Everything a page shows about one pack, before any of it is HTML.

use glam::DVec3;
use hullmap::{Hull, Pack};
use serde::Serialize;

use crate::census::{Census, census, direction_count, even_directions};
use crate::display_mesh::{DisplayMesh, EncodedMesh, triangle_limit};
use crate::gauss_map::{FACES, Face, GaussMap, gauss_map, resolution};
use crate::html;
use crate::index_reader::Contents;
use crate::input::{Frame, Input, Remarks, Up, Verification};
use crate::part_colours::{COLOURS, assigned};
use crate::picture::{picture, picture_of_parts};
use crate::sizes::Section;

/// Maximum number of hulls with a row and pictures. Failed hulls beyond it are still listed under
/// verification.
pub const MAX_HULLS: usize = 1_000;

/// Bytes of pictures and maps on a page. Later hulls only have their rows.
const PICTURE_BUDGET: usize = 8_000_000;

/// Triangles in the still picture: more than it has pixels to show.
const STILL_TRIANGLES: usize = 60_000;

/// One pack.
#[derive(Debug)]
pub struct Analysis {
    /// The pack's path, as given or found.
    pub file: String,
    /// Size of the file in bytes.
    pub bytes: usize,
    /// Version of the file format.
    pub format_version: u32,
    /// The build options, as recorded or in words.
    pub options: String,
    /// The recorded path of the source.
    pub recorded_source: String,
    /// Name of the source, if it was found.
    pub source: Option<String>,
    /// Number of source points, over all hulls.
    pub source_points: usize,
    /// The hulls in the file's order; at most `MAX_HULLS`.
    pub hulls: Vec<HullRow>,
    /// Number of hulls in the pack.
    pub hull_count: usize,
    /// Number of vertices, over all hulls.
    pub vertex_count: usize,
    /// Unit of lengths, after a number.
    pub unit: &'static str,
    /// Verification results of every hull.
    pub verification: Verification,
    /// Faults, warnings and notes.
    pub remarks: Remarks,
    /// Bytes by section.
    pub sections: Vec<Section>,
    /// The meshes that the page draws.
    pub drawn: Drawn,
    /// A still picture, as a `data:` URL.
    pub picture: String,
}

#[derive(Debug)]
pub struct HullRow {
    pub number: usize,
    pub name: String,
    /// Number of parts of its object; 0 for a hull that is not a part.
    pub part_count: u32,
    /// Diagonal of its mesh's box; without the mesh, of the box of its object's hulls.
    pub diagonal: f64,
    /// Excess of its volume over its mesh's, if it fills hollows.
    pub excess: Option<f64>,
    pub is_mesh_volume_known: bool,
    /// 3 solid, 2 polygon, 1 segment, 0 point.
    pub rank: u32,
    /// Number of source points the hull was built from.
    pub points: u32,
    pub vertices: usize,
    pub faces: usize,
    pub volume: f64,
    pub surface_area: f64,
    pub diameter: f64,
    /// How far the worst source point lies outside, relative to the diameter.
    pub containment_error: f64,
    /// Bound on how far the hull extends beyond its source, a length; 0 for an exact hull.
    pub outer_error: f64,
    /// A length; `None` if it was not measured.
    pub uncovered: Option<f64>,
    /// Bound on how far a point of the part lies outside the object's solid, a length.
    pub protrusion: Option<f64>,
    pub colour: usize,
    pub index: String,
    pub index_bytes: usize,
    pub max_nodes: u32,
    pub max_dots: u32,
    pub census: Census,
}

#[derive(Debug, Serialize)]
pub struct Drawn {
    pub faces: [Face; 6],
    pub up: Up,
    pub unit: &'static str,
    pub hull_count: usize,
    pub hulls: Vec<DrawnHull>,
    /// The source's meshes, unless there is one for each hull: of objects that were cut into parts.
    pub meshes: Vec<EncodedMesh>,
}

#[derive(Debug, Serialize)]
pub struct DrawnHull {
    pub number: usize,
    /// Its name, without invisible or direction-changing characters.
    pub name: String,
    rank: u32,
    points: u32,
    vertices: usize,
    faces: usize,
    index: String,
    /// Number of parts of its object; 0 for a hull that is not a part.
    part_count: u32,
    colour: [u8; 3],
    /// Bound on how far the part protrudes from the mesh's solid, a length; `None`: not measured.
    protrusion: Option<f64>,
    /// Where it protrudes most, unless that is rounding.
    protrusion_at: Option<[f64; 3]>,
    /// The source mesh, if it was found and there is room.
    pub source: Option<EncodedMesh>,
    pub hull: Option<EncodedMesh>,
    pub gauss: Option<GaussMap>,
    census: Census,
}

impl Analysis {
    /// Whether every hull equals the hull of its source points, and all parts equal their mesh.
    pub fn is_exact(&self) -> bool {
        self.verification.hulls.iter().all(|hull| !hull.is_simplified && !hull.is_loose_part)
    }

    /// Whether there are parts that do not equal their mesh.
    pub fn has_loose_parts(&self) -> bool {
        self.verification.hulls.iter().any(|hull| hull.is_loose_part)
    }

    /// Why an engine cannot use some parts well, in one word each.
    pub fn flaws(&self) -> Vec<&'static str> {
        let mut words: Vec<&str> = self.verification.hulls.iter().flat_map(|hull| &hull.flaws).copied().collect();
        words.sort_unstable();
        words.dedup();
        words
    }

    /// Whether the fit of some parts is not known.
    pub fn has_unmeasured_parts(&self) -> bool {
        self.verification.hulls.iter().any(|hull| hull.is_loose_part && !hull.is_measured)
    }

    /// Number of hulls that have a row but are not drawn.
    pub fn undrawn(&self) -> usize {
        self.drawn.hulls.iter().filter(|hull| hull.hull.is_none()).count()
    }
}

/// `None` if the pack is damaged, and was opened without its checks.
pub fn analyse(input: Input) -> Option<Analysis> {
    let Input { path, pack, source, verification, remarks, polygons, excess, frame } = input;
    let contents = Contents::of_pack(pack)?;
    let hull_count = pack.hull_count();
    let shown_count = hull_count.min(MAX_HULLS);
    let directions = even_directions(direction_count(shown_count));
    let mut hulls = Vec::new();
    let colours = assigned(&pack.hulls().take(shown_count).map(|hull| hull.bounds()).collect::<Vec<_>>());
    let diagonals = diagonals(pack, source.as_ref().map_or(&[], |source| &source.meshes));
    for (number, (((hull, index), colour), diagonal)) in
        pack.hulls().zip(&contents.indices).zip(&colours).zip(diagonals).enumerate()
    {
        let census = census(index, &directions);
        let row = hull_row(&hull, polygons, census);
        hulls.push(HullRow { number, colour: *colour, diagonal, excess: excess(&hull), ..row });
    }
    let shown_meshes = source.as_ref().map(|source| source.meshes.as_slice());
    let drawn = draw(pack, &contents, shown_meshes, &hulls, polygons, frame);
    let (source, source_points, meshes) = match source {
        Some(source) => (Some(source.name), source.point_count, source.meshes),
        None => (None, 0, Vec::new()),
    };
    Some(Analysis {
        file: path.display().to_string(),
        bytes: pack.byte_len(),
        format_version: pack.header().format_version,
        options: pack.options().to_owned(),
        recorded_source: pack.source_path().to_owned(),
        source,
        source_points,
        hull_count,
        unit: frame.unit,
        vertex_count: pack.hulls().map(|hull| hull.vertex_count()).sum(),
        verification,
        remarks,
        sections: contents.sections,
        picture: still(pack, &meshes, &colours, polygons, frame.up),
        hulls,
        drawn,
    })
}

type Polygons = fn(&Hull) -> Vec<Vec<u32>>;

fn hull_row(hull: &Hull, polygons: Polygons, census: Census) -> HullRow {
    let worst = hull.worst_cost();
    HullRow {
        number: 0,
        name: hull.name().to_owned(),
        part_count: hull.part_count(),
        diagonal: 0.0,
        excess: None,
        is_mesh_volume_known: hull.mesh_mass_properties(1.0).is_some(),
        rank: hull.rank(),
        points: hull.source_point_count(),
        vertices: hull.vertex_count(),
        faces: if hull.is_lean() { polygons(hull).len() } else { hull.face_count() },
        volume: hull.volume(),
        surface_area: hull.surface_area(),
        diameter: hull.diameter(),
        containment_error: hull.containment_error(),
        outer_error: hull.outer_error(),
        uncovered: hull.uncovered(),
        protrusion: hull.protrusion(),
        colour: 0,
        index: hull.index_kind().to_string(),
        index_bytes: hull.index_byte_len(),
        max_nodes: worst.nodes,
        max_dots: worst.dots,
        census,
    }
}

/// Diagonal of each hull's mesh, or of the hulls of its object.
fn diagonals(pack: &Pack, meshes: &[DisplayMesh]) -> Vec<f64> {
    let hulls: Vec<Hull> = pack.hulls().collect();
    let mut meshes = meshes.iter();
    let objects = hulls.chunk_by(|_, next| next.part() > 0).flat_map(|own| {
        let of_hulls = || {
            let corners = own.iter().map(Hull::bounds);
            corners.reduce(|[low, high], [from, to]| [low.min(from), high.max(to)]).map(|box_of| box_of.map(Into::into))
        };
        let corners = meshes.next().filter(|mesh| !mesh.points.is_empty()).map(DisplayMesh::bounds).or_else(of_hulls);
        let [low, high] = corners.unwrap_or_default().map(|corner| DVec3::from(corner.map(f64::from)));
        vec![low.distance(high); own.len()]
    });
    objects.collect()
}

/// Draws hulls in their order until the page is full.
fn draw(
    pack: &Pack,
    contents: &Contents,
    meshes: Option<&[DisplayMesh]>,
    rows: &[HullRow],
    polygons: Polygons,
    frame: Frame,
) -> Drawn {
    let (limit, resolution) = (triangle_limit(rows.len()), resolution(rows.len()));
    let paired = meshes.filter(|meshes| meshes.len() == pack.hull_count());
    let unpaired = meshes.filter(|_| paired.is_none()).unwrap_or_default();
    let unpaired_limit = triangle_limit(unpaired.len());
    let unpaired = unpaired.iter().take(MAX_HULLS).map(|mesh| mesh.with_at_most(unpaired_limit).encoded(mesh));
    let meshes: Vec<EncodedMesh> = unpaired.collect();
    let mut room = PICTURE_BUDGET.saturating_sub(html::json(&meshes).len());
    let mut drawn = Vec::new();
    for (number, (hull, row)) in pack.hulls().zip(rows).enumerate() {
        let mut next = DrawnHull {
            number,
            name: html::plain(&row.name),
            rank: row.rank,
            points: row.points,
            vertices: row.vertices,
            faces: row.faces,
            index: row.index.clone(),
            part_count: row.part_count,
            colour: COLOURS[row.colour],
            protrusion: hull.protrusion(),
            protrusion_at: hull.protrusion_at().filter(|_| row.leaves_its_mesh()).map(|at| at.to_array()),
            source: None,
            hull: None,
            gauss: None,
            census: row.census.clone(),
        };
        if room > 0 {
            let encoded = |mesh: &DisplayMesh| mesh.with_at_most(limit).encoded(mesh);
            next.source = paired.and_then(|meshes| meshes.get(number)).map(encoded);
            next.hull = Some(encoded(&DisplayMesh::of_hull(&hull, &polygons(&hull))));
            next.gauss = contents.indices.get(number).map(|index| gauss_map(&hull, index, resolution));
            room = room.saturating_sub(html::json(&next).len());
        }
        drawn.push(next);
    }
    Drawn { faces: FACES, up: frame.up, unit: frame.unit, hull_count: pack.hull_count(), hulls: drawn, meshes }
}

/// Hulls around the meshes, or alone without a source. Parts are drawn alone, each in a colour.
fn still(pack: &Pack, meshes: &[DisplayMesh], colours: &[usize], polygons: Polygons, up: Up) -> String {
    let limit = STILL_TRIANGLES.div_ceil(pack.hull_count());
    let drawn = |hull: Hull| DisplayMesh::of_hull(&hull, &polygons(&hull)).with_at_most(limit);
    let hulls: Vec<DisplayMesh> = pack.hulls().map(drawn).collect();
    if pack.hulls().any(|hull| hull.part_count() > 1) {
        picture_of_parts(&hulls, colours, up)
    } else {
        picture(&hulls, meshes, up)
    }
}
