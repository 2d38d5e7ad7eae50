//! Pack writer: turns baked hulls into the bytes of a pack, whole or lean.

use hullmap_format::{
    archive::{HullRecord, LEAN_FACES, MassRecord, Pack, PrimitiveRecord, Span, VoidsRecord},
    edge,
    header::{Header, options_hash},
    mass,
    version::Layout,
};

mod sections;

use sections::{ExtendedSections, Sections};

use crate::{
    baked_hull::{BakedHull, SourceRecord},
    bvh,
    error::BakeError,
    file,
    fit::VoidsShare,
    hull::{Hull, adjacency::Adjacency, bounds, quads::quads},
    mass::Mass,
    primitive::{Primitive, ProvenPrimitive},
};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Detail {
    Full,
    Lean,
}

/// The bytes of a pack that contains `hulls`: a pure function of the arguments.
///
/// # Errors
/// No hulls, different origins, a pack above 2 GiB, or parts of an object that are not consecutive
/// or contradict each other.
pub fn write_pack(hulls: &[BakedHull], source: &SourceRecord) -> Result<Vec<u8>, BakeError> {
    check(hulls)?;
    write(Meshes::from_hulls(hulls), hulls.iter().cloned(), source, Detail::Full)
}

/// Like [`write_pack`], but takes the hulls, and frees the memory of each as soon as it is written.
/// A pack of one large hull then takes half as much memory.
///
/// # Errors
/// The errors of [`write_pack`].
pub fn write_owned_pack(hulls: Vec<BakedHull>, source: &SourceRecord) -> Result<Vec<u8>, BakeError> {
    check(&hulls)?;
    write(Meshes::from_hulls(&hulls), hulls.into_iter(), source, Detail::Full)
}

/// Like [`write_owned_pack`], but writes a *lean* pack: without the data that only manifolds, hints
/// and walks over the surface need. Hulls have no neighbours, quads or edges, and hulls of more
/// than [`LEAN_FACES`] vertices have no faces.
///
/// # Errors
/// The errors of [`write_pack`].
pub fn write_lean_pack(hulls: Vec<BakedHull>, source: &SourceRecord) -> Result<Vec<u8>, BakeError> {
    check(&hulls)?;
    write(Meshes::from_hulls(&hulls), hulls.into_iter(), source, Detail::Lean)
}

fn check(hulls: &[BakedHull]) -> Result<(), BakeError> {
    if hulls.is_empty() {
        return Err(BakeError::Empty);
    }
    if hulls.iter().any(|baked| baked.origin != hulls[0].origin) {
        return Err(BakeError::Origins);
    }
    check_parts(hulls)
}

fn write(
    meshes: Meshes,
    hulls: impl Iterator<Item = BakedHull>,
    source: &SourceRecord,
    detail: Detail,
) -> Result<Vec<u8>, BakeError> {
    let Meshes { masses, voids, primitives } = meshes;
    let options = options_text(source);
    let options_hash = options_hash(&options);
    let mut pack =
        Pack { source_path: source.path.clone().into_bytes(), options: options.into_bytes(), ..Pack::default() };
    pack.spans.push(Span::default());
    for (baked, mass) in hulls.zip(masses) {
        pack.masses.extend(mass);
        append(&mut pack, baked, detail)?;
    }
    pack.nodes = bvh::build(&mut pack.hulls);
    let layout = Layout { is_lean: detail == Detail::Lean, is_extended: !voids.is_empty() || !primitives.is_empty() };
    let header = |payload: &[u8]| Header::for_layout(layout, source.hash, options_hash, payload);
    if layout.is_extended {
        file::bytes(&ExtendedSections::new(pack, voids, primitives), header)
    } else {
        file::bytes(&Sections::from(pack), header)
    }
}

/// The section `options`: the options, then each warning on a line of its own.
pub(crate) fn options_text(source: &SourceRecord) -> String {
    let mut text = source.options.clone();
    for warning in &source.warnings {
        text.push('\n');
        // A name in a warning may hold a line break.
        text.push_str(&warning.replace('\n', " "));
    }
    text
}

/// Checks that each object's parts are consecutive, complete, and measured against one solid.
fn check_parts(hulls: &[BakedHull]) -> Result<(), BakeError> {
    let shared = |baked: &BakedHull| baked.fit.map(|fit| (fit.solid, fit.uncovered));
    let mut rest = hulls;
    while let Some(first) = rest.first() {
        let count = first.part_count.max(1) as usize;
        let own = rest.get(..count).unwrap_or(rest);
        let continues = |(part, baked): (usize, &BakedHull)| {
            (baked.part as usize, baked.part_count) == (part, first.part_count) && shared(baked) == shared(first)
        };
        let sound = own.iter().enumerate().take_while(|part| continues(*part)).count();
        if sound < count || first.part_count == 0 && first.fit.is_some() {
            return Err(BakeError::Parts { hull: hulls.len() - rest.len() + sound.min(count - 1) });
        }
        rest = &rest[count..];
    }
    Ok(())
}

struct Meshes {
    masses: Vec<Option<MassRecord>>,
    voids: Vec<VoidsRecord>,
    primitives: Vec<PrimitiveRecord>,
}

impl Meshes {
    fn from_hulls(hulls: &[BakedHull]) -> Self {
        let masses = mesh_masses(hulls);
        let of_object = |(hull, (baked, mass)): (u32, (&BakedHull, &Option<MassRecord>))| {
            mass.filter(|_| baked.part_count > 0 && baked.part == 0)?;
            let VoidsShare { share, error } = baked.voids?;
            Some(VoidsRecord { hull, share: share as f32, error: error as f32 })
        };
        let voids = (0..).zip(hulls.iter().zip(&masses)).filter_map(of_object).collect();
        let of_hull = |(hull, baked): (u32, &BakedHull)| {
            let ProvenPrimitive { primitive, protrusion } = baked.primitive.filter(|_| baked.fit.is_some())?;
            let Primitive { kind, center, rotation, sizes } = primitive;
            let (kind, center, rotation) = (kind.code(), center.to_array(), rotation.to_array());
            Some(PrimitiveRecord { hull, kind, center, rotation, sizes, protrusion })
        };
        let primitives = (0..).zip(hulls).filter_map(of_hull).collect();
        Self { masses, voids, primitives }
    }
}

/// The mass of the mesh of each object, at its first hull. A mass that a reader would reject is
/// left out: the centre may be outside hulls that were modelled for another purpose than the mesh.
fn mesh_masses(hulls: &[BakedHull]) -> Vec<Option<MassRecord>> {
    let of_object = |(at, baked): (usize, &BakedHull)| {
        let found = baked.mesh_mass.filter(|_| baked.part == 0)?;
        let own = hulls.iter().skip(at).take(baked.part_count.max(1) as usize);
        let [low, high] = bounds(own.flat_map(|baked| &baked.hull.vertices));
        let uncovered = baked.fit.map_or(0.0, |fit| fit.uncovered);
        let Mass { volume, centroid, second_moments, .. } = found;
        let record = MassRecord { volume, centroid, second_moments };
        mass::check(&record, low, high, uncovered).is_ok().then_some(record)
    };
    hulls.iter().enumerate().map(of_object).collect()
}

fn append(pack: &mut Pack, mut baked: BakedHull, detail: Detail) -> Result<(), BakeError> {
    pack.names.extend_from_slice(baked.name.as_bytes());
    if detail == Detail::Full {
        let adjacency = Adjacency::new(&baked.hull);
        pack.hulls.push(record(&baked, adjacency.max_neighbours()));
        pack.quads.extend(quads(&baked.hull, &adjacency));
        if baked.hull.rank == 3 {
            append_edges(&mut pack.edges, &baked.hull, &adjacency);
        }
        let Adjacency { mut starts, neighbours, faces } = adjacency;
        starts.pop();
        append_all(&mut pack.neighbour_starts, starts);
        append_all(&mut pack.neighbours, neighbours);
        append_all(&mut pack.neighbour_faces, faces);
    } else {
        pack.hulls.push(record(&baked, 0));
    }
    if detail == Detail::Full || baked.hull.vertices.len() <= LEAN_FACES as usize {
        append_faces(pack, std::mem::take(&mut baked.hull.faces));
    }
    append_all(&mut pack.vertices, baked.hull.vertices);
    append_all(&mut pack.source_vertices, baked.hull.source_vertices);
    append_all(&mut pack.outer_vertices, baked.outer);
    append_all(&mut pack.slots, baked.index.encoded.slots);
    append_all(&mut pack.blocks, baked.index.encoded.blocks);
    pack.spans.push(end_of(pack)?);
    Ok(())
}

/// Appends a list, without a copy if it is the first.
fn append_all<T>(to: &mut Vec<T>, mut list: Vec<T>) {
    if to.is_empty() {
        *to = list;
    } else {
        to.append(&mut list);
    }
}

/// Appends the faces of one hull: their starts, counted from the first, and their corners.
fn append_faces(pack: &mut Pack, faces: Vec<Vec<u32>>) {
    let mut start = 0;
    pack.face_starts.reserve(faces.len());
    pack.face_vertices.reserve(faces.iter().map(Vec::len).sum());
    for face in faces {
        pack.face_starts.push(start);
        start += face.len() as u32;
        pack.face_vertices.extend_from_slice(&face);
    }
}

fn append_edges(edges: &mut Vec<i16>, hull: &Hull, adjacency: &Adjacency) {
    edges.reserve(3 * adjacency.neighbours.len());
    let mut directions = Vec::new();
    for (v, vertex) in (0..).zip(&hull.vertices) {
        let to = |w: &u32| edge::quantise(*vertex, hull.vertices[*w as usize]);
        directions.clear();
        directions.extend(adjacency.neighbours(v).iter().map(to));
        (0..3).for_each(|axis| edges.extend(directions.iter().map(|direction| direction[axis])));
    }
}

fn end_of(pack: &Pack) -> Result<Span, BakeError> {
    let at = |len: usize| u32::try_from(len).map_err(|_| BakeError::PackTooLarge);
    Ok(Span {
        name: at(pack.names.len())?,
        vertex: at(pack.vertices.len())?,
        face: at(pack.face_starts.len())?,
        face_vertex: at(pack.face_vertices.len())?,
        neighbour: at(pack.neighbours.len())?,
        slot: at(pack.slots.len())?,
        block: at(pack.blocks.len())?,
        edge: at(pack.edges.len())?,
        outer: at(pack.outer_vertices.len())?,
        quad: at(pack.quads.len())?,
        mass: at(pack.masses.len())?,
    })
}

fn record(baked: &BakedHull, max_neighbours: u32) -> HullRecord {
    let BakedHull { hull, mass, index, interior, .. } = baked;
    let [bounds_min, bounds_max] = bounds(&hull.vertices);
    HullRecord {
        diameter: hull.diameter,
        centroid: mass.centroid,
        interior_point: interior.point.to_array(),
        inner_radius: interior.inner_radius,
        outer_radius: interior.outer_radius,
        volume: mass.volume,
        surface_area: mass.surface_area,
        second_moments: mass.second_moments,
        containment_error: hull.containment_error,
        outer_error: baked.outer_error,
        uncovered: baked.fit.map_or(0.0, |fit| fit.uncovered),
        protrusion: baked.fit.map_or(0.0, |fit| fit.protrusion),
        protrusion_at: baked.fit.map_or([0.0; 3], |fit| fit.protrusion_at),
        origin: baked.origin,
        bounds_min,
        bounds_max,
        rank: hull.rank,
        index_kind: index.kind.code(),
        resolution: index.kind.resolution(),
        leaf_blocks: index.kind.leaf_blocks(),
        max_neighbours,
        max_nodes: index.cost.nodes,
        max_dots: index.cost.dots,
        source_points: baked.point_count as u32,
        // Set by `bvh::build`.
        leaf: 0,
        part: baked.part,
        part_count: baked.part_count,
        solid: baked.fit.map_or(0, |fit| fit.solid.code()),
    }
}
