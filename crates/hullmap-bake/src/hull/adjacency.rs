//! Adjacency of a hull: for each vertex, its neighbours and the faces between them, in one array.

use super::{Hull, edges};

/// For each vertex, the vertices that share an edge with it, ascending, and the faces to the left
/// of these edges.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Adjacency {
    /// For each vertex, the start of its run; then the end of the last one.
    pub starts: Vec<u32>,
    /// Neighbours of each vertex, ascending.
    pub neighbours: Vec<u32>,
    /// For each neighbour w of v, the index of the face in which w follows v; 0 without faces.
    pub faces: Vec<u32>,
}

impl Adjacency {
    /// The adjacency of `hull`.
    ///
    /// # Complexity
    /// O(number of face corners), plus sorting the neighbours of each vertex.
    pub fn new(hull: &Hull) -> Self {
        let count = hull.vertices.len();
        if hull.rank == 1 {
            return Self { starts: vec![0, 1, 2], neighbours: vec![1, 0], faces: vec![0, 0] };
        }
        let mut next = vec![0_u32; count + 1];
        hull.faces.iter().flatten().for_each(|v| next[*v as usize + 1] += 1);
        (0..count).for_each(|v| next[v + 1] += next[v]);
        let (mut neighbours, mut faces) = (vec![0; next[count] as usize], vec![0; next[count] as usize]);
        for (face, outline) in (0..).zip(&hull.faces) {
            for (a, b) in edges(outline) {
                let at = next[a as usize] as usize;
                (neighbours[at], faces[at]) = (b, face);
                next[a as usize] += 1;
            }
        }
        // Each run now ends at its next place. Sort the runs, and close gaps of removed entries.
        let mut adjacency = Self { starts: next, neighbours, faces };
        let (mut run, mut start, mut kept) = (Vec::new(), 0, 0);
        for vertex in 0..count {
            let end = adjacency.starts[vertex] as usize;
            run.clear();
            let both = adjacency.neighbours[start..end].iter().zip(&adjacency.faces[start..end]);
            run.extend(both.map(|(neighbour, face)| (*neighbour, *face)));
            run.sort_unstable();
            adjacency.starts[vertex] = kept as u32;
            let first = kept;
            for &(neighbour, face) in &run {
                // An edge that is in several faces the same way, which no certified hull has.
                if kept > first && adjacency.neighbours[kept - 1] == neighbour {
                    kept -= 1;
                }
                (adjacency.neighbours[kept], adjacency.faces[kept]) = (neighbour, face);
                kept += 1;
            }
            start = end;
        }
        adjacency.starts[count] = kept as u32;
        adjacency.neighbours.truncate(kept);
        adjacency.faces.truncate(kept);
        adjacency
    }

    /// Neighbours of a vertex, ascending.
    pub fn neighbours(&self, vertex: u32) -> &[u32] {
        &self.neighbours[self.run(vertex)]
    }

    /// The face in which `to` follows `from`; `None` if they do not share an edge.
    pub fn left_of(&self, from: u32, to: u32) -> Option<u32> {
        let run = self.run(from);
        let at = self.neighbours[run.clone()].binary_search(&to).ok()?;
        self.faces.get(run.start + at).copied()
    }

    /// Maximum number of neighbours of a vertex.
    pub fn max_neighbours(&self) -> u32 {
        self.starts.windows(2).map(|run| run[1] - run[0]).max().unwrap_or(0)
    }

    fn run(&self, vertex: u32) -> std::ops::Range<usize> {
        self.starts[vertex as usize] as usize..self.starts[vertex as usize + 1] as usize
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use shapes::families::Family;

    use super::*;
    use crate::test_meshes::hull_of;

    fn agrees(positions: Vec<[f32; 3]>, name: &str) -> u32 {
        let hull = hull_of(positions);
        let adjacency = Adjacency::new(&hull);
        // The slow, obvious twin: for each vertex, its neighbours and the faces that they follow it
        // in.
        let mut lists = vec![BTreeMap::new(); hull.vertices.len()];
        for (face, corners) in (0..).zip(&hull.faces) {
            edges(corners).for_each(|(a, b)| _ = lists[a as usize].insert(b, face));
        }
        if hull.rank == 1 {
            lists = vec![BTreeMap::from([(1, 0)]), BTreeMap::from([(0, 0)])];
        }
        for (v, list) in (0..).zip(&lists) {
            assert!(adjacency.neighbours(v).iter().eq(list.keys()), "{name} {v}");
        }
        assert!(adjacency.faces.iter().eq(lists.iter().flat_map(BTreeMap::values)), "{name}");
        assert_eq!(adjacency.max_neighbours() as usize, lists.iter().map(BTreeMap::len).max().unwrap(), "{name}");
        hull.rank
    }

    #[test]
    fn agrees_with_lists_of_each_vertex() {
        for family in Family::ALL {
            agrees(family.points(300, 2), family.name());
        }
        let line = |n: usize| (0..n).map(|i| [i as f32, 0.0, 1.0]).collect::<Vec<_>>();
        assert_eq!([agrees(line(1), "point"), agrees(line(3), "segment")], [0, 1]);
        assert_eq!(agrees([line(3), vec![[1.0, 2.0, 1.0]]].concat(), "polygon"), 2);
    }
}
