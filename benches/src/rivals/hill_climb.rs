//! Hill climbing: from a vertex to its best neighbour until no neighbour is better, as in MuJoCo,
//! coal, PhysX and programs that use libccd. In f32 it is not exact: it stops on plateaus of
//! rounding error.

use std::marker::PhantomData;

use glam::Vec3;

use crate::{
    query::{Rival, SupportQuery},
    subject::Subject,
};

/// The vertices and edges of a hull, as an adjacency list in compressed rows.
#[derive(Clone, Debug)]
pub struct Graph {
    vertices: Vec<Vec3>,
    /// Start of each vertex's row in `neighbours`, and the end of the last row.
    starts: Vec<u32>,
    neighbours: Vec<u32>,
    /// Extreme vertices along the axes and diagonals.
    seeds: Vec<(Vec3, u32)>,
}

impl Graph {
    /// The graph of the faces of `subject`.
    pub fn new(subject: &Subject) -> Self {
        let vertices: Vec<Vec3> = subject.vertices().collect();
        let mut edges = Vec::new();
        for face in subject.faces() {
            // Each edge occurs once from either side.
            edges.extend(face.iter().copied().zip(face.iter().copied().cycle().skip(1)));
        }
        edges.sort_unstable();
        edges.dedup();
        let row_start = |vertex: usize| edges.partition_point(|&(from, _)| (from as usize) < vertex) as u32;
        let starts = (0..=vertices.len()).map(row_start).collect();
        let neighbours = edges.iter().map(|&(_, to)| to).collect();
        let mut graph = Self { vertices, starts, neighbours, seeds: Vec::new() };
        graph.seeds = graph.extremes();
        graph
    }

    /// Support vertices of the 6 axes and 8 diagonals.
    fn extremes(&self) -> Vec<(Vec3, u32)> {
        let mut seeds: Vec<u32> = Vec::new();
        for corner in 0..27_u8 {
            let [x, y, z] = [corner % 3, corner / 3 % 3, corner / 9].map(|c| f32::from(c) - 1.0);
            let zeros = [x, y, z].iter().filter(|c| **c == 0.0).count();
            if zeros == 0 || zeros == 2 {
                let dir = Vec3::new(x, y, z);
                let farther = |a: &u32, b: &u32| self.dot(*a, dir).total_cmp(&self.dot(*b, dir));
                seeds.extend((0..self.vertices.len() as u32).max_by(farther));
            }
        }
        seeds.sort_unstable();
        seeds.dedup();
        seeds.into_iter().map(|seed| (self.vertices[seed as usize], seed)).collect()
    }

    /// Position of vertex `index`.
    pub fn vertex(&self, index: u32) -> Vec3 {
        self.vertices[index as usize]
    }

    /// Bytes in addition to the coordinates.
    pub fn index_bytes(&self) -> usize {
        size_of_val(self.starts.as_slice()) + size_of_val(self.neighbours.as_slice())
    }

    /// Total bytes.
    pub fn footprint_bytes(&self) -> usize {
        self.index_bytes() + size_of_val(self.vertices.as_slice())
    }

    #[inline]
    fn dot(&self, vertex: u32, dir: Vec3) -> f32 {
        self.vertices[vertex as usize].dot(dir)
    }

    /// Climbs from vertex `from` to the best neighbour until no neighbour is better, and returns
    /// the last vertex. Complexity: one dot product for each neighbour of each vertex on the way.
    /// It ends because the dot product grows with every step.
    #[inline]
    pub fn climb(&self, from: u32, dir: Vec3) -> u32 {
        let mut at = from;
        let mut best = self.dot(at, dir);
        loop {
            let row = self.starts[at as usize] as usize..self.starts[at as usize + 1] as usize;
            let mut next = at;
            for &neighbour in &self.neighbours[row] {
                let dot = self.dot(neighbour, dir);
                // False for NaN, which ends the climb.
                if dot > best {
                    (best, next) = (dot, neighbour);
                }
            }
            if next == at {
                return at;
            }
            at = next;
        }
    }
}

/// Start of a climb.
pub trait Start {
    /// The rival's name.
    const NAME: &'static str;

    /// Starts from the first vertex; `last` is the end of the last climb.
    fn start(graph: &Graph, last: u32, dir: Vec3) -> u32;
}

/// From vertex 0.
#[derive(Clone, Copy, Debug)]
pub struct OneStart;

impl Start for OneStart {
    const NAME: &'static str = "climb from vertex 0";

    #[inline]
    fn start(_: &Graph, _: u32, _: Vec3) -> u32 {
        0
    }
}

/// Starts from the best of up to 14 vertices: the extreme vertices along the axes and diagonals.
#[derive(Clone, Copy, Debug)]
pub struct ManyStarts;

impl Start for ManyStarts {
    const NAME: &'static str = "climb, best of 14 starts";

    #[inline]
    fn start(graph: &Graph, _: u32, dir: Vec3) -> u32 {
        let mut best = (f32::NEG_INFINITY, 0);
        for &(position, vertex) in &graph.seeds {
            let dot = position.dot(dir);
            if dot > best.0 {
                best = (dot, vertex);
            }
        }
        best.1
    }
}

/// From the last answer.
#[derive(Clone, Copy, Debug)]
pub struct LastAnswer;

impl Start for LastAnswer {
    const NAME: &'static str = "climb, warm";

    #[inline]
    fn start(_: &Graph, last: u32, _: Vec3) -> u32 {
        last
    }
}

/// Hill climbing with a given start.
#[derive(Clone, Debug)]
pub struct HillClimb<S> {
    graph: Graph,
    start: PhantomData<S>,
}

impl<S: Start> HillClimb<S> {
    /// Climbs on `graph`.
    pub fn new(graph: Graph) -> Self {
        Self { graph, start: PhantomData }
    }
}

impl<S: Start + 'static> Rival for HillClimb<S> {
    type Query<'a> = Climb<'a, S>;

    fn name(&self) -> &str {
        S::NAME
    }

    fn is_exact(&self) -> bool {
        false
    }

    fn index_bytes(&self) -> usize {
        self.graph.index_bytes()
    }

    fn footprint_bytes(&self) -> usize {
        self.graph.footprint_bytes()
    }

    fn query(&self) -> Climb<'_, S> {
        Climb { graph: &self.graph, last: 0, start: PhantomData }
    }

    fn duplicate(&self) -> Self {
        Self::new(self.graph.clone())
    }
}

/// See [`HillClimb`].
pub struct Climb<'a, S> {
    graph: &'a Graph,
    last: u32,
    start: PhantomData<S>,
}

impl<S: Start> SupportQuery for Climb<'_, S> {
    #[inline]
    fn support(&mut self, dir: Vec3) -> Vec3 {
        self.last = self.graph.climb(S::start(self.graph, self.last, dir), dir);
        self.graph.vertex(self.last)
    }
}
