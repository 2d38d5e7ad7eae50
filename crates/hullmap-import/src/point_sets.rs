//! Which points each hull is of.
//!
//! A vertex belongs to every object with an element that references it; a vertex that nothing references, where
//! those count, to the object it was declared in. Objects are what `o` lines open, nodes with a mesh, or solids: groups
//! (`g`) cut an object into parts for materials or selection, which are no bodies of their own, so hulls ignore them.
//! An `o` line always opens a new object, even with a name that was there before.

use std::collections::HashSet;
use std::ops::Range;

use hullmap_bake::PointSet;

use crate::conventions;
use crate::fault::Fault;
use crate::limits::Limits;
use crate::mesh::{Mesh, Polygons, Positions};
use crate::options::{ImportOptions, Split, Vertices};
use crate::placement::Placement;

/// Most names that a note lists.
const NAMES_IN_NOTE: usize = 5;

/// The sets of a file, and what came up on the way.
#[derive(Debug, Default)]
pub struct Sets {
    /// One set for each hull, in file order, none of them empty.
    pub point_sets: Vec<PointSet>,
    /// The faces over each set, by the numbers of its own points.
    pub faces: Vec<Polygons>,
    /// What the user may want to know.
    pub notes: Vec<String>,
    /// What the user should look at.
    pub warnings: Vec<String>,
}

/// The point sets of a file.
///
/// `referenced` says for each vertex whether any element references it; `stem` names what has no name.
///
/// # Errors
/// Too many objects to cut at, or points that f32 cannot hold.
#[expect(clippy::indexing_slicing, reason = "`referenced` has an entry for each vertex of the mesh")]
pub fn point_sets(
    mesh: &mut Mesh,
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
        Split::Object => Some(all_objects(mesh, referenced, takes_all, stem, &mut sets)),
        Split::Auto => collision_parts(mesh, referenced, takes_all, stem, &mut sets),
    };
    let Some(objects) = chosen else {
        let is_chosen = |vertex: &u32| takes_all || referenced[*vertex as usize];
        let all = 0..mesh.positions.len() as u32;
        // Counted first: a list that grows by doubling may end at twice its size.
        let mut vertices = Vec::with_capacity(all.clone().filter(is_chosen).count());
        vertices.extend(all.filter(is_chosen));
        let faces = std::mem::take(&mut mesh.faces);
        build(&mut sets, &mut mesh.positions, options, vec![(stem.to_owned(), vertices, faces)])?;
        return Ok(sets);
    };
    let mut parts = Vec::with_capacity(objects.len());
    for object in objects {
        let name = name_of(mesh, object, stem).to_owned();
        let vertices = members(mesh, object, referenced, takes_all);
        parts.push((name, vertices, faces_of(mesh, object)));
    }
    let unique = unique_names(&parts.iter().map(|(name, ..)| name.clone()).collect::<Vec<_>>());
    let mut renamed = 0;
    for (part, name) in parts.iter_mut().zip(unique) {
        renamed += usize::from(part.0 != name);
        part.0 = name;
    }
    if renamed > 0 {
        sets.notes.push(format!("objects renamed since an earlier one has the name: {renamed}"));
    }
    build(&mut sets, &mut mesh.positions, options, parts)?;
    Ok(sets)
}

/// Every object that has points.
fn all_objects(mesh: &Mesh, referenced: &[bool], takes_all: bool, stem: &str, sets: &mut Sets) -> Vec<usize> {
    let (mut chosen, mut skipped) = (Vec::new(), Vec::new());
    for object in 0..mesh.objects.len() {
        if has_members(mesh, object, referenced, takes_all) {
            chosen.push(object);
        } else if object > 0 {
            // What stands before the first `o` line is no object that anyone would miss.
            skipped.push(name_of(mesh, object, stem));
        }
    }
    if !skipped.is_empty() {
        let more = if skipped.len() > NAMES_IN_NOTE { ", …" } else { "" };
        let listed = skipped.get(..NAMES_IN_NOTE).unwrap_or(&skipped).join(", ");
        sets.notes.push(format!("objects without elements, skipped: {} ({listed}{more})", skipped.len()));
    }
    if mesh.has_only_groups {
        sets.notes.push("the file has groups (g) but no objects (o), and is cut at objects only".to_owned());
    }
    chosen
}

/// The objects that artists marked as collision parts; `None` where nothing is marked.
fn collision_parts(
    mesh: &Mesh,
    referenced: &[bool],
    takes_all: bool,
    stem: &str,
    sets: &mut Sets,
) -> Option<Vec<usize>> {
    let objects = (0..mesh.objects.len()).filter(|&object| has_members(mesh, object, referenced, takes_all));
    let objects: Vec<usize> = objects.collect();
    let names: Vec<&str> = objects.iter().map(|&object| name_of(mesh, object, stem)).collect();
    let Some(selection) = conventions::select(&names) else {
        sets.notes.push(
            "no names of collision parts (UCX_…, …-convcolonly, convex_<n>): one hull of the whole file".to_owned(),
        );
        return None;
    };
    sets.notes.extend(selection.notes);
    sets.warnings.extend(selection.warnings);
    Some(objects.into_iter().zip(selection.is_part).filter(|(_, is_part)| *is_part).map(|(object, _)| object).collect())
}

#[expect(clippy::indexing_slicing, reason = "asked only of objects that the mesh has")]
fn name_of<'a>(mesh: &'a Mesh, object: usize, stem: &'a str) -> &'a str {
    let name = &mesh.objects[object].name;
    if name.is_empty() { stem } else { name }
}

/// The vertices, faces and loose references that belong to an object, by their places in the mesh's lists.
///
/// Objects begin one after the other, within those lists: readers count what is there when one begins.
#[expect(clippy::indexing_slicing, reason = "asked only of objects that the mesh has")]
fn extent(mesh: &Mesh, object: usize) -> [Range<usize>; 3] {
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
fn has_members(mesh: &Mesh, object: usize, referenced: &[bool], takes_all: bool) -> bool {
    let [vertices, faces, loose] = extent(mesh, object);
    !faces.is_empty() || !loose.is_empty() || takes_all && vertices.into_iter().any(|vertex| !referenced[vertex])
}

/// Numbers of an object's vertices, ascending.
#[expect(
    clippy::indexing_slicing,
    reason = "`extent` is within the mesh, and `referenced` has an entry for each vertex"
)]
fn members(mesh: &Mesh, object: usize, referenced: &[bool], takes_all: bool) -> Vec<u32> {
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
fn faces_of(mesh: &Mesh, object: usize) -> Polygons {
    let [_, faces, _] = extent(mesh, object);
    let (start, end) = (mesh.faces.start(faces.start), mesh.faces.start(faces.end));
    Polygons {
        corners: mesh.faces.corners[start..end].to_vec(),
        ends: mesh.faces.ends[faces].iter().map(|place| place - start as u32).collect(),
    }
}

/// Places the points of named lists of vertices, and renumbers the faces over them.
#[expect(clippy::indexing_slicing, reason = "`number` has an entry for each vertex when it is read")]
fn build(
    sets: &mut Sets,
    positions: &mut Positions,
    options: &ImportOptions,
    parts: Vec<(String, Vec<u32>, Polygons)>,
) -> Result<(), Fault> {
    let chosen = parts.iter().flat_map(|(_, vertices, _)| vertices.iter().copied());
    let placement = Placement::new(positions, chosen, options);
    let is_only = parts.len() == 1;
    // Number of each vertex in the set at hand; those of other sets are never read.
    let mut number: Vec<u32> = Vec::new();
    for (name, vertices, mut faces) in parts {
        // Ascending and each once: as many as there are is all of them, and they keep their numbers.
        if vertices.len() < positions.len() && !faces.corners.is_empty() {
            number.resize(positions.len(), 0);
            for (own, &vertex) in vertices.iter().enumerate() {
                number[vertex as usize] = own as u32;
            }
            for corner in &mut faces.corners {
                *corner = number[*corner as usize];
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

/// The names, each later repetition with the lowest suffix `_2`, `_3`, … that gives a name not in the list.
fn unique_names(names: &[String]) -> Vec<String> {
    let mut taken: HashSet<String> = names.iter().cloned().collect();
    let mut seen = HashSet::new();
    // Where the search for a free suffix of a name goes on: equal names would else try all suffixes again.
    let mut next = std::collections::HashMap::new();
    let mut unique = Vec::with_capacity(names.len());
    for name in names {
        if seen.insert(name.as_str()) {
            unique.push(name.clone());
            continue;
        }
        let number = next.entry(name.as_str()).or_insert(2_u64);
        let free = loop {
            let free = format!("{name}_{number}");
            *number += 1;
            if taken.insert(free.clone()) {
                break free;
            }
        };
        unique.push(free);
    }
    unique
}

#[cfg(test)]
mod tests {
    use super::unique_names;

    #[test]
    fn names_become_unique_without_stealing() {
        let names = ["a", "a", "a_2", "a", "b", "a_2"].map(str::to_owned);
        assert_eq!(unique_names(&names), ["a", "a_3", "a_2", "a_4", "b", "a_2_2"]);
    }

    #[test]
    fn equal_names_in_great_number_take_no_time() {
        let names = vec![String::from("part"); 100_000];
        let unique = unique_names(&names);
        assert_eq!(unique[99_999], "part_100000");
    }
}
