//! Links between the atoms of a piece: common corners, gaps too narrow for the limit to see, and
//! lines of sight through the solid. Where a plane cuts a piece, only links on one side hold its
//! atoms together.

use std::sync::Arc;

use glam::DVec3;

use super::{atom::Atom, field::Field};
use crate::{
    fit::triangle_tree::TriangleTree,
    groups::{find, join},
};
use hullmap_geometry::bits;

/// Distance up to which a line of sight ends at an atom, relative to the diagonal.
const SEEN: f64 = 1e-6;

/// A corner, and the atoms that have it.
struct Corner {
    at: DVec3,
    atoms: Vec<u32>,
}

/// Two atoms, and the points of them that are linked.
struct Bridge {
    atoms: [u32; 2],
    ends: [DVec3; 2],
}

/// Links between the atoms of a piece.
pub struct Links {
    count: usize,
    corners: Vec<Corner>,
    bridges: Vec<Bridge>,
}

impl Links {
    /// The links between atoms. A `gap` between surfaces is no gap.
    ///
    /// # Complexity
    /// O(n log n) for n corners.
    pub fn new(atoms: &[Arc<Atom>], field: &Field, gap: f64) -> Self {
        let mut keyed: Vec<([u64; 3], u32)> = Vec::new();
        for (index, atom) in (0..).zip(atoms) {
            keyed.extend(atom.patch.points.iter().map(|p| (bits(*p), index)));
        }
        keyed.sort_unstable();
        let shared = keyed.chunk_by(|a, b| a.0 == b.0).filter(|run| run.len() > 1);
        let corner = |run: &[([u64; 3], u32)]| Corner {
            at: DVec3::from_array(run[0].0.map(f64::from_bits)),
            atoms: run.iter().map(|(_, atom)| *atom).collect(),
        };
        let mut links = Self { count: atoms.len(), corners: shared.map(corner).collect(), bridges: Vec::new() };
        let tree = TriangleTree::of_boxes(atoms.iter().map(|atom| atom.bounds()));
        links.see(atoms, field, &tree);
        links.touch(atoms, gap, &tree);
        links
    }

    /// Lines of sight through the solid.
    fn see(&mut self, atoms: &[Arc<Atom>], field: &Field, tree: &TriangleTree) {
        let slack = SEEN * field.solid().diagonal();
        for (index, atom) in (0..).zip(atoms) {
            let Some(ends) = atom.across(field) else { continue };
            tree.for_each(
                |bounds| bounds.distance(ends[1]) <= slack,
                |other| {
                    if other != index && atoms[other as usize].distance(ends[1]) <= slack {
                        self.bridges.push(Bridge { atoms: [index, other], ends });
                    }
                },
            );
        }
    }

    /// Narrow gaps between atoms that are not linked otherwise.
    fn touch(&mut self, atoms: &[Arc<Atom>], gap: f64, tree: &TriangleTree) {
        let groups = self.groups(|_| true, |_| true);
        if groups.len() < 2 {
            return;
        }
        let mut group_of = vec![0; atoms.len()];
        for (group, members) in groups.iter().enumerate() {
            members.iter().for_each(|atom| group_of[*atom as usize] = group);
        }
        for (index, atom) in (0..).zip(atoms) {
            let around = atom.bounds().grown(gap);
            let mut near = Vec::new();
            tree.for_each(|bounds| bounds.touches(&around), |other| near.push(other));
            for other in near.into_iter().filter(|other| group_of[*other as usize] != group_of[index as usize]) {
                let ends = atom.patch.points.iter().find_map(|p| Some([*p, atoms[other as usize].near(*p, gap)?]));
                self.bridges.extend(ends.map(|ends| Bridge { atoms: [index, other], ends }));
            }
        }
    }

    /// Connected groups of the atoms that are `in`, by links all of whose ends are held; each in
    /// ascending order.
    pub fn groups(&self, is_in: impl Fn(u32) -> bool, holds: impl Fn(DVec3) -> bool) -> Vec<Vec<u32>> {
        let mut root: Vec<u32> = (0..self.count as u32).collect();
        let is_in: Vec<bool> = (0..self.count as u32).map(is_in).collect();
        for corner in &self.corners {
            let mut own = corner.atoms.iter().copied().filter(|atom| is_in[*atom as usize]);
            if let Some(first) = own.next() {
                let mut own = own.peekable();
                if own.peek().is_some() && holds(corner.at) {
                    own.for_each(|other| join(&mut root, first, other));
                }
            }
        }
        for Bridge { atoms: [a, b], ends } in &self.bridges {
            if is_in[*a as usize] && is_in[*b as usize] && ends.iter().all(|p| holds(*p)) {
                join(&mut root, *a, *b);
            }
        }
        grouped(&mut root, &is_in)
    }
}

/// Groups of atoms that share edges, each in ascending order.
///
/// # Complexity
/// O(n log n) for n edges.
pub fn shells(atoms: &[Arc<Atom>]) -> Vec<Vec<u32>> {
    let mut edges: Vec<([[u64; 3]; 2], u32)> = Vec::new();
    for (index, atom) in (0..).zip(atoms) {
        for polygon in &atom.patch.polygons {
            let ends = polygon.iter().zip(polygon.iter().cycle().skip(1));
            edges.extend(
                ends.map(|(p, q)| (bits(*p).min(bits(*q)), bits(*p).max(bits(*q)))).map(|(p, q)| ([p, q], index)),
            );
        }
    }
    edges.sort_unstable();
    let mut root: Vec<u32> = (0..atoms.len() as u32).collect();
    for pair in edges.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        join(&mut root, pair[0].1, pair[1].1);
    }
    grouped(&mut root, &vec![true; atoms.len()])
}

/// The groups of the items that are `in`.
fn grouped(root: &mut [u32], is_in: &[bool]) -> Vec<Vec<u32>> {
    let mut group_of = vec![u32::MAX; root.len()];
    let mut found: Vec<Vec<u32>> = Vec::new();
    for item in (0..root.len() as u32).filter(|item| is_in[*item as usize]) {
        let first = find(root, item) as usize;
        if group_of[first] == u32::MAX {
            group_of[first] = found.len() as u32;
            found.push(Vec::new());
        }
        found[group_of[first] as usize].push(item);
    }
    found
}
