//! Which points each hull is of.
//!
//! A vertex belongs to every object with an element that references it; a vertex that nothing references, where
//! those count, to the object it was declared in. Objects are what `o` lines open: groups (`g`) cut an object into
//! parts for materials or selection, which are no bodies of their own, so hulls ignore them. An `o` line always opens
//! a new object, even with a name that was there before.

use std::collections::HashSet;

use hullmap_bake::PointSet;

use super::scan::Scan;
use crate::options::{ImportOptions, Split, Vertices};

/// Most names that a note lists.
const NAMES_IN_NOTE: usize = 5;

/// The point sets of a file, in file order, and notes for the user.
///
/// `referenced` says for each vertex whether any element references it; `stem` names what has no name.
pub fn point_sets(
    scan: &Scan,
    referenced: &[bool],
    stem: &str,
    options: ImportOptions,
) -> (Vec<PointSet>, Vec<String>) {
    let takes_all = options.vertices == Vertices::All || scan.elements.is_empty();
    match options.split {
        Split::None | Split::Auto => {
            let chosen = (0..scan.positions.len() as u32).filter(|&v| takes_all || referenced[v as usize]);
            (vec![point_set(scan, stem.to_owned(), chosen.collect())], Vec::new())
        }
        Split::Object => split_at_objects(scan, referenced, stem, takes_all),
    }
}

fn split_at_objects(scan: &Scan, referenced: &[bool], stem: &str, takes_all: bool) -> (Vec<PointSet>, Vec<String>) {
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); scan.objects.len()];
    for (number, element) in scan.elements.iter().enumerate() {
        members[element.object as usize].extend_from_slice(scan.references_of(number));
    }
    if takes_all {
        let declared = scan.vertex_objects.iter().enumerate();
        for (vertex, &object) in declared.filter(|&(vertex, _)| !referenced[vertex]) {
            members[object as usize].push(vertex as u32);
        }
    }

    let mut names = Vec::new();
    let mut sets = Vec::new();
    let mut skipped = Vec::new();
    for (object, mut vertices) in members.into_iter().enumerate() {
        let name = &scan.objects[object];
        let name = if name.is_empty() { stem } else { name };
        if vertices.is_empty() {
            // What stands before the first `o` line is no object that anyone would miss.
            if object > 0 {
                skipped.push(name);
            }
            continue;
        }
        vertices.sort_unstable();
        vertices.dedup();
        names.push(name.to_owned());
        sets.push(vertices);
    }

    let mut notes = Vec::new();
    if !skipped.is_empty() {
        let more = if skipped.len() > NAMES_IN_NOTE { ", …" } else { "" };
        let listed = skipped[..skipped.len().min(NAMES_IN_NOTE)].join(", ");
        notes.push(format!("objects without elements, skipped: {} ({listed}{more})", skipped.len()));
    }
    let unique = unique_names(&names);
    let renamed = unique.iter().zip(&names).filter(|(new, old)| new != old).count();
    if renamed > 0 {
        notes.push(format!("objects renamed since an earlier one has the name: {renamed}"));
    }
    let sets = unique.into_iter().zip(sets).map(|(name, vertices)| point_set(scan, name, vertices));
    (sets.collect(), notes)
}

fn point_set(scan: &Scan, name: String, vertices: Vec<u32>) -> PointSet {
    let positions = vertices.iter().map(|&vertex| scan.positions[vertex as usize]).collect();
    PointSet { name, positions, source_vertices: vertices, ..PointSet::default() }
}

/// The names, each later repetition with the lowest suffix `_2`, `_3`, … that gives a name not in the list.
fn unique_names(names: &[String]) -> Vec<String> {
    let mut taken: HashSet<String> = names.iter().cloned().collect();
    let mut seen = HashSet::new();
    let mut unique = Vec::with_capacity(names.len());
    for name in names {
        if seen.insert(name.as_str()) {
            unique.push(name.clone());
            continue;
        }
        let free = (2..).map(|number| format!("{name}_{number}")).find(|name| !taken.contains(name));
        let free = free.expect("finitely many names are taken");
        taken.insert(free.clone());
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
}
