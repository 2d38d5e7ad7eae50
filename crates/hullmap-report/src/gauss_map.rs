//! The Gauss map of a hull on an unfolded cube map: for each direction, its support vertex and its
//! leaf of the index.
//!
//! Every pixel shows the answer of a query to the runtime, in the direction of its centre. The
//! faces are rotated so that neighbours in the cross join: the middle row is +x, +y, −x, −y around
//! z, with +z above +y and −z below.

use std::collections::HashMap;

use glam::Vec3;
use hullmap::{Hull, Pack};
use hullmap_format::cube;
use rayon::prelude::*;
use serde::Serialize;

use crate::cells::{Cells, cells};
use crate::encode::{fraction, joined_runs, runs, words};
use crate::html::json;
use crate::index_reader::{Contents, IndexReader, Leaf};

/// Maximum pixels along a face's edge: a fifth of a degree each, and as many as a screen shows.
const MAX_RESOLUTION: u32 = 256;

/// Minimum pixels along a face's edge: cells of a few degrees remain visible.
const MIN_RESOLUTION: u32 = 32;

/// Pixels of all hulls of a page together: one hull at the maximum resolution.
const PIXEL_BUDGET: u32 = 6 * MAX_RESOLUTION * MAX_RESOLUTION;

const LISTED_CANDIDATES: usize = 32;

#[derive(Clone, Copy, Debug, Serialize)]
pub struct Face {
    /// Its name: the direction of its centre.
    pub name: &'static str,
    /// Column, 0 to 3, and row, 0 to 2, of the cross.
    pub place: [u32; 2],
    pub middle: [i32; 3],
    pub right: [i32; 3],
    pub up: [i32; 3],
}

/// The faces, in the order of their indices.
pub const FACES: [Face; 6] = [
    Face { name: "+x", place: [0, 1], middle: [1, 0, 0], right: [0, 1, 0], up: [0, 0, 1] },
    Face { name: "−x", place: [2, 1], middle: [-1, 0, 0], right: [0, -1, 0], up: [0, 0, 1] },
    Face { name: "+y", place: [1, 1], middle: [0, 1, 0], right: [-1, 0, 0], up: [0, 0, 1] },
    Face { name: "−y", place: [3, 1], middle: [0, -1, 0], right: [1, 0, 0], up: [0, 0, 1] },
    Face { name: "+z", place: [1, 0], middle: [0, 0, 1], right: [-1, 0, 0], up: [0, -1, 0] },
    Face { name: "−z", place: [1, 2], middle: [0, 0, -1], right: [-1, 0, 0], up: [0, 1, 0] },
];

impl Face {
    /// The direction through the point (x, y) ∈ [−1, 1]² of the face, x to the right, y upwards.
    pub fn direction(&self, x: f64, y: f64) -> [f64; 3] {
        [0, 1, 2].map(|i| f64::from(self.middle[i]) + x * f64::from(self.right[i]) + y * f64::from(self.up[i]))
    }

    /// The point of the face through which a direction passes whose largest coordinate is ±1.
    fn point(&self, dir: [f64; 3]) -> [f64; 2] {
        [self.right, self.up].map(|axis| (0..3).map(|i| f64::from(axis[i]) * dir[i]).sum())
    }
}

#[derive(Debug, Serialize)]
pub struct GaussMap {
    /// Pixels along a face's edge.
    pub resolution: u32,
    /// Support vertices, face by face, row by row from the top: see [`runs`].
    pub vertices: String,
    /// Index of each pixel's entry in `table`, encoded likewise.
    pub leaves: String,
    /// The leaves that pixels show, in the order of their first pixel.
    pub table: Vec<LeafEntry>,
    /// Borders of the index's cells: four 16-bit fractions per line, x and y of both ends, from
    /// left and bottom.
    pub lines: String,
    /// Index of each face's first line, and the total number of lines.
    pub line_starts: Vec<usize>,
    /// Depth of each line: see [`runs`].
    pub line_depths: String,
    pub lines_are_cut: bool,
}

#[derive(Clone, Debug, Serialize)]
pub struct LeafEntry {
    pub block: u32,
    pub nodes: u32,
    /// Number of lanes: dot products of a query.
    pub dots: u32,
    pub candidates: usize,
    pub listed: Vec<u32>,
}

pub fn resolution(hull_count: usize) -> u32 {
    let pixels = PIXEL_BUDGET / 6 / u32::try_from(hull_count.max(1)).unwrap_or(u32::MAX);
    pixels.isqrt().clamp(MIN_RESOLUTION, MAX_RESOLUTION)
}

/// Complexity: 6 · resolution² queries, on all threads.
pub fn gauss_map(hull: &Hull, index: &IndexReader, resolution: u32) -> GaussMap {
    let rows: Vec<(&Face, u32)> = FACES.iter().flat_map(|face| (0..resolution).map(move |row| (face, row))).collect();
    let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(resolution) * 2.0 - 1.0;
    // Runs of pixels with the same answer.
    let answers: Vec<Vec<(u32, (u32, Leaf))>> = rows
        .into_par_iter()
        .map(|(face, row)| {
            let pixel = |column: u32| {
                let dir = face.direction(middle(column), -middle(row)).map(|c| c as f32);
                (hull.support(Vec3::from_array(dir)).index, index.leaf(dir))
            };
            joined((0..resolution).map(pixel))
        })
        .collect();
    let runs = || answers.iter().flatten();
    let mut known: HashMap<Leaf, u32> = HashMap::new();
    let mut table = Vec::new();
    let mut leaves = Vec::new();
    let mut before = None;
    for &(count, (_, leaf)) in runs() {
        let entry = match before {
            Some((same, entry)) if same == leaf => entry,
            _ => *known.entry(leaf).or_insert_with(|| {
                let mut listed = index.candidates(leaf);
                let candidates = listed.len();
                listed.truncate(LISTED_CANDIDATES);
                table.push(LeafEntry { block: leaf.first, nodes: leaf.nodes, dots: leaf.dots(), candidates, listed });
                table.len() as u32 - 1
            }),
        };
        before = Some((leaf, entry));
        leaves.push((u64::from(count), entry));
    }
    let vertices = runs().map(|(count, (vertex, _))| (u64::from(*count), *vertex));
    let (lines, line_starts, line_depths, lines_are_cut) = lines(cells(index));
    GaussMap {
        resolution,
        vertices: joined_runs(vertices),
        leaves: joined_runs(leaves),
        table,
        lines,
        line_starts,
        line_depths,
        lines_are_cut,
    }
}

/// The Gauss map of hull `hull`, if there is one, as JSON with the layout of the cube's faces, for
/// the script of other pages. `resolution` is the number of pixels along a face's edge, limited to
/// 32 to 256. Complexity: 6 · resolution² queries, and a copy of the pack.
///
/// # Examples
/// ```
/// # use hullmap_bake::{IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
/// # let corner = |i: usize| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32];
/// # let (positions, source_vertices) = ((0..8).map(corner).collect(), (0..8).collect());
/// # let cube = PointSet { positions, source_vertices, ..PointSet::default() };
/// # let bytes = write_pack(&[bake_hull(&cube, IndexKind::Tree)?], &SourceRecord::default())?;
/// let pack = hullmap::Pack::from_bytes(&bytes)?;
/// let map = hullmap_report::gauss_map_json(&pack, 0, 64).ok_or("no hull")?;
/// assert!(map.starts_with(r#"{"faces":[{"name":"+x","#));
/// assert!(hullmap_report::gauss_map_json(&pack, 1, 64).is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn gauss_map_json(pack: &Pack, hull: usize, resolution: u32) -> Option<String> {
    #[derive(Serialize)]
    struct Page {
        faces: [Face; 6],
        map: GaussMap,
    }
    let contents = Contents::of_pack(pack)?;
    let index = contents.indices.get(hull)?;
    let map = gauss_map(&pack.hull(hull).ok()?, index, resolution.clamp(MIN_RESOLUTION, MAX_RESOLUTION));
    Some(json(&Page { faces: FACES, map }))
}

/// Runs of equal answers: number and answer.
fn joined<A: PartialEq>(answers: impl Iterator<Item = A>) -> Vec<(u32, A)> {
    let mut runs: Vec<(u32, A)> = Vec::new();
    for answer in answers {
        match runs.last_mut() {
            Some((count, same)) if *same == answer => *count += 1,
            _ => runs.push((1, answer)),
        }
    }
    runs
}

/// Lines as the page reads them, sorted by face and depth.
fn lines(Cells { mut lines, is_cut }: Cells) -> (String, Vec<usize>, String, bool) {
    lines.sort_by_key(|line| (line.face, line.depth));
    let starts = (0..=6).map(|face| lines.partition_point(|line| line.face < face)).collect();
    let ends = lines.iter().flat_map(|line| {
        let point = |[u, v]: [f64; 2]| FACES[line.face as usize].point(cube::direction(line.face, u, v));
        line.ends.map(point).into_iter().flatten().map(|x| fraction(x, -1.0, 2.0))
    });
    let depths: Vec<u32> = lines.iter().map(|line| line.depth).collect();
    (words(ends), starts, runs(&depths), is_cut)
}

#[cfg(test)]
mod tests {
    use hullmap_bake::IndexKind;

    use super::*;
    use crate::test_packs::{baked, cloud};

    #[test]
    fn faces_are_numbered_as_in_the_index() {
        for (index, face) in FACES.iter().enumerate() {
            for (x, y) in [(0.0, 0.0), (0.5, -0.25), (-0.75, 0.5)] {
                let dir = face.direction(x, y);
                assert_eq!(cube::locate(dir.map(|c| c as f32)).face, index as u32, "{}", face.name);
                assert_eq!(face.point(dir), [x, y]);
            }
            // Right, up and outward are a right-handed frame: from outside, nothing is mirrored.
            let [right, up, out] = [face.right, face.up, face.middle].map(|v| glam::DVec3::from(v.map(f64::from)));
            assert_eq!(right.cross(up), out, "{}", face.name);
        }
    }

    #[test]
    fn the_cross_has_no_seams_inside() {
        let mut joints = 0;
        for a in &FACES {
            for b in &FACES {
                let [right, down] = [0, 1].map(|i| b.place[i] as i32 - a.place[i] as i32);
                let along = [-0.5, 0.0, 0.75];
                if (right, down) == (1, 0) {
                    joints += 1;
                    assert!(
                        along.iter().all(|&y| a.direction(1.0, y) == b.direction(-1.0, y)),
                        "{} {}",
                        a.name,
                        b.name
                    );
                }
                if (right, down) == (0, 1) {
                    joints += 1;
                    assert!(
                        along.iter().all(|&x| a.direction(x, -1.0) == b.direction(x, 1.0)),
                        "{} {}",
                        a.name,
                        b.name
                    );
                }
            }
        }
        assert_eq!(joints, 5);
    }

    #[test]
    fn resolutions_keep_to_the_budget() {
        assert_eq!(resolution(1), MAX_RESOLUTION);
        assert_eq!(resolution(4), MAX_RESOLUTION / 2);
        assert_eq!(resolution(1_000_000), MIN_RESOLUTION);
        assert_eq!(resolution(0), MAX_RESOLUTION);
    }

    fn slow(hull: &Hull, index: &IndexReader, resolution: u32) -> [String; 2] {
        let (mut vertices, mut leaves, mut table) = (Vec::new(), Vec::new(), Vec::new());
        let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(resolution) * 2.0 - 1.0;
        for face in FACES {
            for row in 0..resolution {
                for column in 0..resolution {
                    let dir = face.direction(middle(column), -middle(row)).map(|c| c as f32);
                    vertices.push(hull.support(Vec3::from_array(dir)).index);
                    let leaf = index.leaf(dir);
                    let known = table.iter().position(|other| *other == leaf);
                    leaves.push(known.unwrap_or(table.len()) as u32);
                    if known.is_none() {
                        table.push(leaf);
                    }
                }
            }
        }
        [runs(&vertices), runs(&leaves)]
    }

    #[test]
    fn pixels_match_single_queries() {
        for points in [cloud(2), cloud(20), cloud(150), vec![[1.0, 2.0, 3.0]]] {
            for kind in [IndexKind::None, IndexKind::Tree] {
                let (pack, contents) = baked(points.clone(), kind);
                let (hull, index) = (pack.hull(0).unwrap(), &contents.indices[0]);
                let map = gauss_map(&hull, index, 37);
                assert_eq!([map.vertices, map.leaves], slow(&hull, index, 37), "{} {kind:?}", points.len());
                assert!(map.table.iter().all(|leaf| leaf.candidates <= leaf.dots as usize));
                assert!(map.table.len() > 10 || points.len() < 150 || kind == IndexKind::None);
                assert!(map.line_starts.len() == 7 && !map.lines_are_cut);
            }
        }
    }
}
