//! Pack writer: turns baked hulls into the bytes of a pack.

use hullmap_format::{
    archive::{HullRecord, Pack, Span},
    check::MAX_PACK_LEN,
    edge,
    header::{HEADER_LEN, Header, options_hash},
};
use rkyv::{rancor, util::AlignedVec};

use crate::{
    BakeError, BakedHull, SourceRecord, bvh,
    hull::{Hull, quads::quads},
};

/// The bytes of a pack that contains `hulls`: a pure function of the arguments.
///
/// # Errors
/// - [`BakeError::Empty`] if there are no hulls.
/// - [`BakeError::Origins`] if the hulls have different origins.
/// - [`BakeError::Parts`] if the parts of an object are not consecutive, or contradict each other.
/// - [`BakeError::PackTooLarge`] if the pack exceeds 2 GiB.
pub fn write_pack(hulls: &[BakedHull], source: &SourceRecord) -> Result<Vec<u8>, BakeError> {
    if hulls.is_empty() {
        return Err(BakeError::Empty);
    }
    let mut pack = Pack {
        source_path: source.path.clone().into_bytes(),
        options: source.options.clone().into_bytes(),
        ..Pack::default()
    };
    pack.spans.push(Span::default());
    for baked in hulls {
        append(&mut pack, baked)?;
    }
    if hulls.iter().any(|baked| baked.origin != hulls[0].origin) {
        return Err(BakeError::Origins);
    }
    check_parts(hulls)?;
    pack.nodes = bvh::build(&mut pack.hulls);
    let payload = rkyv::api::high::to_bytes_in::<_, rancor::Error>(&pack, AlignedVec::<HEADER_LEN>::new())
        .map_err(|_| BakeError::PackTooLarge)?;
    if payload.len() + HEADER_LEN > MAX_PACK_LEN {
        return Err(BakeError::PackTooLarge);
    }
    let header = Header::for_payload(source.hash, options_hash(&source.options), &payload);
    Ok([&header.to_bytes()[..], &payload].concat())
}

/// Checks that each object's parts are consecutive, complete, and measured against one solid. A
/// reader refuses other packs.
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

/// Appends a hull to every section, and its record.
fn append(pack: &mut Pack, baked: &BakedHull) -> Result<(), BakeError> {
    let hull = &baked.hull;
    pack.names.extend_from_slice(baked.name.as_bytes());
    pack.vertices.extend_from_slice(&hull.vertices);
    pack.source_vertices.extend_from_slice(&hull.source_vertices);
    append_runs(&mut pack.face_starts, &mut pack.face_vertices, &hull.faces);
    let neighbours = hull.neighbours();
    append_runs(&mut pack.neighbour_starts, &mut pack.neighbours, &neighbours);
    let neighbour_faces = hull.neighbour_faces(&neighbours);
    pack.quads.extend(quads(hull, &neighbours, &neighbour_faces));
    pack.neighbour_faces.extend_from_slice(&neighbour_faces);
    if hull.rank == 3 {
        append_edges(&mut pack.edges, hull, &neighbours);
    }
    pack.outer_vertices.extend_from_slice(&baked.outer);
    pack.slots.extend_from_slice(&baked.index.encoded.slots);
    pack.blocks.extend_from_slice(&baked.index.encoded.blocks);
    let max_neighbours = neighbours.iter().map(|list| list.len() as u32).max().unwrap_or(0);
    pack.hulls.push(record(baked, max_neighbours));
    pack.spans.push(end_of(pack)?);
    Ok(())
}

/// Appends lists of one hull: their starts, counted from the first, and their elements.
fn append_runs(starts: &mut Vec<u32>, elements: &mut Vec<u32>, lists: &[Vec<u32>]) {
    let mut start = 0;
    for list in lists {
        starts.push(start);
        start += list.len() as u32;
        elements.extend_from_slice(list);
    }
}

/// Appends the directions to each vertex's neighbours, by component.
fn append_edges(edges: &mut Vec<i16>, hull: &Hull, neighbours: &[Vec<u32>]) {
    for (vertex, list) in hull.vertices.iter().zip(neighbours) {
        let directions: Vec<[i16; 3]> =
            list.iter().map(|&w| edge::quantise(*vertex, hull.vertices[w as usize])).collect();
        (0..3).for_each(|axis| edges.extend(directions.iter().map(|direction| direction[axis])));
    }
}

/// Current end of every section.
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
    })
}

fn record(baked: &BakedHull, max_neighbours: u32) -> HullRecord {
    let BakedHull { hull, mass, index, interior, .. } = baked;
    let component = |pick: fn(f32, f32) -> f32| -> [f32; 3] {
        std::array::from_fn(|i| hull.vertices.iter().map(|v| v[i]).reduce(pick).unwrap_or_default())
    };
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
        bounds_min: component(f32::min),
        bounds_max: component(f32::max),
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
