//! Point sets: the source points of each hull.
//!
//! A vertex belongs to every object with an element that references it. With `vertices=all`, an
//! unreferenced vertex belongs to the object that declares it. Objects are `o` lines, nodes with a
//! mesh, or solids. Groups (`g`) are not: they divide an object for materials or selection, not
//! into bodies. Every `o` line starts a new object, even if its name is not new.

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

use hullmap_geometry::PointSet;

use crate::conventions;
use crate::fault::{Fault, excerpt};
use crate::limits::Limits;
use crate::mesh::{Polygons, Positions, SourceCollider, SourceMesh};
use crate::options::{ImportOptions, Split, Vertices};
use crate::placement::Placement;

const NAMES_IN_NOTE: usize = 5;

#[derive(Debug, Default)]
pub struct Sets {
    /// One set for each hull, in file order. No set is empty.
    pub point_sets: Vec<PointSet>,
    pub faces: Vec<Polygons>,
    pub notes: Vec<String>,
    pub warnings: Vec<String>,
}

/// `referenced`: whether any element references each vertex. `stem` is the name of objects without
/// one. Fails for too many objects, or points that `f32` cannot hold.
#[expect(clippy::indexing_slicing, reason = "`referenced` has an entry for each vertex of the mesh")]
pub fn point_sets(
    mesh: &mut SourceMesh,
    referenced: &[bool],
    stem: &str,
    options: &ImportOptions,
    limits: &Limits,
) -> Result<Sets, Fault> {
    let takes_all = options.vertices == Vertices::All || !mesh.has_elements();
    if options.split != Split::None && mesh.has_too_many_objects {
        return Err(Fault::TooManyObjects { limit: limits.objects });
    }
    let mut sets = Sets::default();
    let chosen = match options.split {
        Split::None => None,
        Split::Object => {
            let objects = all_objects(mesh, referenced, takes_all, stem, &mut sets);
            Some(objects.into_iter().map(|object| (object, None)).collect())
        }
        Split::Auto => collision_parts(mesh, referenced, takes_all, stem, &mut sets),
    };
    let Some(objects) = chosen else {
        let is_chosen = |vertex: &u32| takes_all || referenced[*vertex as usize];
        let all = 0..mesh.positions.len() as u32;
        // Counted first, since a list that grows by doubling can end at twice its size.
        let mut vertices = Vec::with_capacity(all.clone().filter(is_chosen).count());
        vertices.extend(all.filter(is_chosen));
        let faces = std::mem::take(&mut mesh.faces);
        let parts = vec![(stem.to_owned(), vertices, faces)];
        let placement = placement_of(&mesh.positions, &parts, options);
        build(&mut sets, &mut mesh.positions, &placement, parts)?;
        return Ok(sets);
    };
    let mut parts = Vec::with_capacity(objects.len());
    let stands_for: Vec<Option<usize>> = objects.iter().map(|(_, stands_for)| *stands_for).collect();
    for (object, _) in objects {
        let name = name_of(mesh, object, stem).to_owned();
        let vertices = members(mesh, object, referenced, takes_all);
        parts.push((name, vertices, faces_of(mesh, object)));
    }
    let unique = unique_names(parts.iter().map(|(name, ..)| name.clone()).collect(), str::to_owned);
    let mut renamed = 0;
    for (part, name) in parts.iter_mut().zip(unique) {
        renamed += usize::from(part.0 != name);
        part.0 = name;
    }
    if renamed > 0 {
        sets.notes.push(format!("objects renamed because an earlier one has the same name: {renamed}"));
    }
    let placement = placement_of(&mesh.positions, &parts, options);
    // Before the positions of the parts are placed, which may take them out of the mesh.
    let mut meshes: HashMap<usize, Option<Arc<PointSet>>> = HashMap::new();
    let stands_for: Vec<Option<Arc<PointSet>>> = stands_for
        .into_iter()
        .map(|object| {
            let object = object?;
            let place = || place_mesh(mesh, object, referenced, takes_all, stem, &placement);
            meshes.entry(object).or_insert_with(place).clone()
        })
        .collect();
    build(&mut sets, &mut mesh.positions, &placement, parts)?;
    for (set, stands_for) in sets.point_sets.iter_mut().zip(stands_for) {
        set.stands_for = stands_for;
    }
    Ok(sets)
}

fn placement_of(positions: &Positions, parts: &[(String, Vec<u32>, Polygons)], options: &ImportOptions) -> Placement {
    Placement::new(positions, parts.iter().flat_map(|(_, vertices, _)| vertices.iter().copied()), options)
}

/// The mesh in the frame of the parts; `None` without triangles, or with coordinates beyond f32.
fn place_mesh(
    mesh: &SourceMesh,
    object: usize,
    referenced: &[bool],
    takes_all: bool,
    stem: &str,
    placement: &Placement,
) -> Option<Arc<PointSet>> {
    let vertices = members(mesh, object, referenced, takes_all);
    let place = |vertex: &u32| placement.place(&mesh.positions, *vertex).ok();
    let positions: Vec<[f32; 3]> = vertices.iter().map(place).collect::<Option<_>>()?;
    let mut faces = faces_of(mesh, object);
    for corner in &mut faces.corners {
        *corner = vertices.binary_search(corner).ok()? as u32;
    }
    let triangles = faces.triangles(&positions);
    let name = name_of(mesh, object, stem).to_owned();
    let set =
        PointSet { name, positions, source_vertices: vertices, origin: placement.origin, triangles, stands_for: None };
    (!set.triangles.is_empty()).then(|| Arc::new(set))
}

/// The objects with points, each with the name of its hull if the file is split by object.
#[expect(clippy::indexing_slicing, reason = "readers reject references out of range")]
pub fn object_names(mesh: &SourceMesh, stem: &str) -> Vec<(usize, String)> {
    let mut referenced = vec![false; mesh.positions.len()];
    for &vertex in mesh.faces.corners.iter().chain(&mesh.loose) {
        referenced[vertex as usize] = true;
    }
    let objects = all_objects(mesh, &referenced, !mesh.has_elements(), stem, &mut Sets::default());
    let names = objects.iter().map(|&object| name_of(mesh, object, stem).to_owned()).collect();
    objects.into_iter().zip(unique_names(names, str::to_owned)).collect()
}

fn all_objects(mesh: &SourceMesh, referenced: &[bool], takes_all: bool, stem: &str, sets: &mut Sets) -> Vec<usize> {
    let (mut chosen, mut skipped) = (Vec::new(), Vec::new());
    for object in 0..mesh.objects.len() {
        if has_members(mesh, object, referenced, takes_all) {
            chosen.push(object);
        } else if object > 0 {
            // The first object is only what precedes the first `o` line, and needs no note.
            skipped.push(name_of(mesh, object, stem));
        }
    }
    if !skipped.is_empty() {
        let more = if skipped.len() > NAMES_IN_NOTE { ", …" } else { "" };
        let listed: Vec<String> = skipped.iter().take(NAMES_IN_NOTE).map(|name| excerpt(name)).collect();
        let listed = listed.join(", ");
        sets.notes.push(format!("objects without elements, skipped: {} ({listed}{more})", skipped.len()));
    }
    if mesh.has_only_groups {
        sets.notes.push("the file has groups (g) but no objects (o); only objects become separate hulls".to_owned());
    }
    chosen
}

/// Parts by an extension of the file, or else by name, each with its object. Parts of one object
/// are consecutive.
fn collision_parts(
    mesh: &SourceMesh,
    referenced: &[bool],
    takes_all: bool,
    stem: &str,
    sets: &mut Sets,
) -> Option<Vec<(usize, Option<usize>)>> {
    let objects = (0..mesh.objects.len()).filter(|&object| has_members(mesh, object, referenced, takes_all));
    let objects: Vec<usize> = objects.collect();
    let colliders = colliders(mesh, &objects, sets);
    let chosen = if colliders.is_empty() { named_parts(mesh, &objects, stem, sets)? } else { colliders };
    Some(grouped(chosen))
}

fn colliders(mesh: &SourceMesh, objects: &[usize], sets: &mut Sets) -> Vec<(usize, Option<usize>)> {
    let has_points = |collider: &&SourceCollider| objects.binary_search(&collider.object).is_ok();
    let chosen: Vec<(usize, Option<usize>)> =
        mesh.colliders.iter().filter(has_points).map(|collider| (collider.object, collider.stands_for)).collect();
    if !chosen.is_empty() {
        sets.notes.push(format!("colliders of a physics extension, one hull each: {}", chosen.len()));
        let others = objects.len() - chosen.len();
        if others > 0 {
            sets.notes.push(format!("objects that are not collision parts, left out: {others}"));
        }
    }
    chosen
}

fn named_parts(
    mesh: &SourceMesh,
    objects: &[usize],
    stem: &str,
    sets: &mut Sets,
) -> Option<Vec<(usize, Option<usize>)>> {
    let names: Vec<&str> = objects.iter().map(|&object| name_of(mesh, object, stem)).collect();
    let Some(selection) = conventions::select(&names) else {
        sets.notes.push(
            "no object has the name of a collision part (UCX_…, …-convcolonly, convex_<n>): one hull of the whole file"
                .to_owned(),
        );
        return None;
    };
    sets.notes.extend(selection.notes);
    sets.warnings.extend(selection.warnings);
    let stands_for = selection.stands_for.into_iter().map(|index| index.and_then(|index| objects.get(index).copied()));
    let chosen = objects.iter().zip(stands_for).zip(selection.is_part).filter(|(_, is_part)| *is_part);
    Some(chosen.map(|((object, mesh), _)| (*object, mesh)).collect())
}

/// The parts, ordered so that the parts of one object are consecutive.
fn grouped(chosen: Vec<(usize, Option<usize>)>) -> Vec<(usize, Option<usize>)> {
    // An object's parts take the place of the first one. A part that stands for no object is alone.
    let mut first = HashMap::new();
    for (place, (_, stands_for)) in chosen.iter().enumerate() {
        if let Some(mesh) = stands_for {
            first.entry(*mesh).or_insert(place);
        }
    }
    let places: Vec<usize> = chosen
        .iter()
        .enumerate()
        .map(|(place, (_, mesh))| mesh.and_then(|mesh| first.get(&mesh).copied()).unwrap_or(place))
        .collect();
    let mut order: Vec<_> = places.into_iter().zip(chosen).collect();
    order.sort_by_key(|(place, _)| *place);
    order.into_iter().map(|(_, chosen)| chosen).collect()
}

#[expect(clippy::indexing_slicing, reason = "callers pass objects of the mesh")]
fn name_of<'a>(mesh: &'a SourceMesh, object: usize, stem: &'a str) -> &'a str {
    let name = &mesh.objects[object].name;
    if name.is_empty() { stem } else { name }
}

/// Ranges of an object's vertices, faces and loose references. Objects start in ascending order and
/// within the lists, since readers record the lengths at that time.
#[expect(clippy::indexing_slicing, reason = "callers pass objects of the mesh")]
fn extent(mesh: &SourceMesh, object: usize) -> [Range<usize>; 3] {
    let start = &mesh.objects[object];
    let end = mesh.objects.get(object + 1);
    let range = |start: u32, end: Option<u32>, len: usize| start as usize..end.map_or(len, |end| end as usize);
    [
        range(start.first_vertex, end.map(|end| end.first_vertex), mesh.positions.len()),
        range(start.first_face, end.map(|end| end.first_face), mesh.faces.len()),
        range(start.first_loose, end.map(|end| end.first_loose), mesh.loose.len()),
    ]
}

#[expect(
    clippy::indexing_slicing,
    reason = "`extent` is within the mesh, and `referenced` has an entry for each vertex"
)]
fn has_members(mesh: &SourceMesh, object: usize, referenced: &[bool], takes_all: bool) -> bool {
    let [vertices, faces, loose] = extent(mesh, object);
    !faces.is_empty() || !loose.is_empty() || takes_all && vertices.into_iter().any(|vertex| !referenced[vertex])
}

/// Indices of an object's vertices, ascending and without repetition.
#[expect(
    clippy::indexing_slicing,
    reason = "`extent` is within the mesh, and `referenced` has an entry for each vertex"
)]
fn members(mesh: &SourceMesh, object: usize, referenced: &[bool], takes_all: bool) -> Vec<u32> {
    let [declared, faces, loose] = extent(mesh, object);
    let mut vertices = mesh.faces.corners[mesh.faces.start(faces.start)..mesh.faces.start(faces.end)].to_vec();
    vertices.extend_from_slice(&mesh.loose[loose]);
    if takes_all {
        vertices.extend(declared.filter(|&vertex| !referenced[vertex]).map(|vertex| vertex as u32));
    }
    vertices.sort_unstable();
    vertices.dedup();
    vertices.shrink_to_fit();
    vertices
}

#[expect(clippy::indexing_slicing, reason = "`extent` is within the mesh, and so are a polygon's corners")]
fn faces_of(mesh: &SourceMesh, object: usize) -> Polygons {
    let [_, faces, _] = extent(mesh, object);
    let (start, end) = (mesh.faces.start(faces.start), mesh.faces.start(faces.end));
    Polygons {
        corners: mesh.faces.corners[start..end].to_vec(),
        ends: mesh.faces.ends[faces].iter().map(|place| place - start as u32).collect(),
    }
}

/// Builds point sets from named lists of vertices, with faces that index the points of their set.
#[expect(clippy::indexing_slicing, reason = "`own_index` has an entry for each vertex when it is read")]
fn build(
    sets: &mut Sets,
    positions: &mut Positions,
    placement: &Placement,
    parts: Vec<(String, Vec<u32>, Polygons)>,
) -> Result<(), Fault> {
    let is_only = parts.len() == 1;
    // Index of each vertex in the current set. Entries of earlier sets are stale and never read.
    let mut own_index: Vec<u32> = Vec::new();
    for (name, vertices, mut faces) in parts {
        // Without repetition, a list as long as the mesh holds all vertices: indices stay the same.
        if vertices.len() < positions.len() && !faces.corners.is_empty() {
            own_index.resize(positions.len(), 0);
            for (own, &vertex) in vertices.iter().enumerate() {
                own_index[vertex as usize] = own as u32;
            }
            for corner in &mut faces.corners {
                *corner = own_index[*corner as usize];
            }
        }
        let points = if is_only && vertices.len() == positions.len() {
            placement.place_all(positions)?
        } else {
            let mut points = Vec::with_capacity(vertices.len());
            for &vertex in &vertices {
                points.push(placement.place(positions, vertex)?);
            }
            points
        };
        sets.point_sets.push(PointSet {
            name,
            positions: points,
            source_vertices: vertices,
            origin: placement.origin,
            ..PointSet::default()
        });
        sets.faces.push(faces);
    }
    Ok(())
}

/// The names, where each repetition gets the lowest suffix `_2`, `_3`, … that gives a new name.
/// Names with the same `key` are repetitions, for instance the names in lower case.
///
/// ```
/// let names = ["a", "A", "b"].map(str::to_owned).into();
/// assert_eq!(hullmap_import::unique_names(names, str::to_lowercase), ["a", "A_2", "b"]);
/// ```
pub fn unique_names(names: Vec<String>, key: impl Fn(&str) -> String) -> Vec<String> {
    let mut taken: HashSet<String> = names.iter().map(|name| key(name)).collect();
    let mut seen = HashSet::new();
    // Next suffix to try for each name. Without this, n equal names would try O(n²) suffixes.
    let mut next: HashMap<String, u64> = HashMap::new();
    let mut unique = |name: String| {
        let own = key(&name);
        if seen.insert(own.clone()) {
            return name;
        }
        let number = next.entry(own).or_insert(2);
        loop {
            let free = format!("{name}_{number}");
            *number += 1;
            if taken.insert(key(&free)) {
                return free;
            }
        }
    };
    names.into_iter().map(&mut unique).collect()
}

#[cfg(test)]
mod tests {
    use super::unique_names;

    #[test]
    fn suffixes_never_repeat_an_existing_name() {
        let names = ["a", "a", "a_2", "a", "b", "a_2"].map(str::to_owned).into();
        assert_eq!(unique_names(names, str::to_owned), ["a", "a_3", "a_2", "a_4", "b", "a_2_2"]);
    }

    #[test]
    fn a_hundred_thousand_equal_names_become_unique() {
        let names = vec![String::from("part"); 100_000];
        let unique = unique_names(names, str::to_owned);
        assert_eq!(unique[99_999], "part_100000");
    }
}
