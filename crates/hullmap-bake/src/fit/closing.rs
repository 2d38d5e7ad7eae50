//! Closes the holes of a mesh, so that every point off its surface has an integer winding number.
//!
//! # Steps
//! 1. Count each directed edge of the triangles against its opposite. The rest is the boundary of
//!    the mesh. It enters every vertex as often as it leaves it.
//! 2. Split the boundary into loops: follow edges, and cut off a loop whenever a vertex is reached
//!    again.
//! 3. Close each loop by a cone over the mean of its vertices.
//!
//! The triangles and the cones have no boundary, even if triangles are not consistently oriented. A
//! reversed triangle leaves a boundary of double edges, whose cones turn it round; [`turn`] does
//! this first, so that cones close holes only.
//!
//! # Complexity
//! O(n log n) for n triangles.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::groups::{find, join};

/// Angle up to which two triangles at an edge lie on each other.
const FOLDED: f64 = 1e-6;

/// Maximum number of triangles at an edge that are compared with each other.
const MAX_AT_EDGE: usize = 64;

/// Triangles that close the mesh of `triangles`, which index `positions`, for each hole. Empty if
/// the mesh is closed. Vertices of equal position must have been merged: only equal indices are one
/// vertex.
pub fn cones(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<Vec<[DVec3; 3]>> {
    let cone = |hole: Vec<u32>| {
        let at = |v: u32| positions[v as usize];
        let apex = hole.iter().map(|v| at(*v)).sum::<DVec3>() / hole.len() as f64;
        let next = hole.iter().cycle().skip(1);
        // The cone runs against the boundary.
        hole.iter().zip(next).map(|(from, to)| [at(*to), at(*from), apex]).collect()
    };
    loops(boundary(triangles)).into_iter().map(cone).collect()
}

/// Turns triangles that face the other way than most others of their surface, and returns their
/// indices. Triangles must be distinct. Surfaces are connected through edges that exactly two
/// triangles share. Changes nothing unless a boundary becomes shorter.
pub fn turn(triangles: &mut [[u32; 3]]) -> Vec<usize> {
    let length = |triangles: &[[u32; 3]]| boundary(triangles).values().map(Vec::len).sum::<usize>();
    let before = length(triangles);
    if before == 0 {
        return Vec::new();
    }
    let neighbours = neighbours(triangles);
    let mut is_turned: Vec<Option<bool>> = vec![None; triangles.len()];
    for start in 0..triangles.len() {
        if is_turned[start].is_some() {
            continue;
        }
        is_turned[start] = Some(false);
        let (mut surface, mut at, mut is_orientable) = (vec![start], 0, true);
        while let Some(&triangle) = surface.get(at) {
            for &(other, is_opposed) in neighbours[triangle].iter().flatten() {
                let expected = is_turned[triangle].map(|is_turned| is_turned != is_opposed);
                match is_turned[other] {
                    None => {
                        is_turned[other] = expected;
                        surface.push(other);
                    }
                    found => is_orientable &= found == expected,
                }
            }
            at += 1;
        }
        let count = surface.iter().filter(|triangle| is_turned[**triangle] == Some(true)).count();
        for triangle in &surface {
            let turned = is_turned[*triangle] == Some(true);
            is_turned[*triangle] = Some(is_orientable && turned != (2 * count > surface.len()));
        }
    }
    let turned: Vec<usize> = (0..triangles.len()).filter(|index| is_turned[*index] == Some(true)).collect();
    turned.iter().for_each(|index| triangles[*index].swap(0, 1));
    if length(triangles) < before {
        return turned;
    }
    turned.iter().for_each(|index| triangles[*index].swap(0, 1));
    Vec::new()
}

/// For each triangle, whether its surface has an edge of one triangle only. Surfaces are connected
/// through edges. Triangles that are not `distinct` repeat another one.
pub fn are_open(triangles: &[[u32; 3]], distinct: &[bool]) -> Vec<bool> {
    let mut edges: Vec<([u32; 2], u32)> = (0..)
        .zip(triangles)
        .flat_map(|(triangle, &[a, b, c])| {
            [(a, b), (b, c), (c, a)].map(|(from, to)| ([from.min(to), from.max(to)], triangle))
        })
        .collect();
    edges.sort_unstable();
    let mut root: Vec<u32> = (0..triangles.len() as u32).collect();
    let mut rims = Vec::new();
    for same in edges.chunk_by(|a, b| a.0 == b.0) {
        same.windows(2).for_each(|pair| join(&mut root, pair[0].1, pair[1].1));
        if same.iter().filter(|(_, triangle)| distinct[*triangle as usize]).count() == 1 {
            rims.push(same[0].1);
        }
    }
    let mut is_open = vec![false; triangles.len()];
    rims.into_iter().for_each(|triangle| is_open[find(&mut root, triangle) as usize] = true);
    (0..triangles.len() as u32).map(|triangle| is_open[find(&mut root, triangle) as usize]).collect()
}

/// The triangles of the layers that face outward, where closed surfaces have triangles on both
/// sides. A layer continues at an edge with the next triangle in front of it. `None` if no such
/// layers bound an inside, or if too many triangles meet at an edge. Volumes of at most `least`
/// times the area count as none.
///
/// # Complexity
/// O(n log n) for n triangles.
pub fn outward(positions: &[DVec3], triangles: &[[u32; 3]], counts: &[bool], least: f64) -> Option<Vec<bool>> {
    let at = |v: u32| positions[v as usize];
    // Edges from their lower end, with the triangle, its third corner, and whether it runs back.
    let mut edges: Vec<([u32; 2], u32, u32, bool)> = (0..)
        .zip(triangles)
        .filter(|(index, _)| counts[*index as usize])
        .flat_map(|(index, &[a, b, c])| {
            [(a, b, c), (b, c, a), (c, a, b)]
                .map(|(from, to, apex)| ([from.min(to), from.max(to)], index, apex, from > to))
        })
        .collect();
    edges.sort_unstable();
    let mut root: Vec<u32> = (0..triangles.len() as u32).collect();
    for same in edges.chunk_by(|a, b| a.0 == b.0) {
        let [low, high] = same[0].0.map(at);
        if same.len() > MAX_AT_EDGE {
            return None;
        }
        let along = (high - low).normalize_or_zero();
        let across = |apex: u32| (at(apex) - low).reject_from_normalized(along).normalize_or_zero();
        for &(_, index, apex, is_back) in same {
            let own = across(apex);
            let normal = if is_back { own.cross(along) } else { along.cross(own) };
            let turn = |other: DVec3| {
                let angle = libm::atan2(other.dot(normal), other.dot(own));
                if angle > FOLDED { angle } else { angle + std::f64::consts::TAU }
            };
            let opposed = same.iter().filter(|other| other.3 != is_back);
            let next = opposed.min_by(|a, b| turn(across(a.2)).total_cmp(&turn(across(b.2))));
            next.into_iter().for_each(|other| join(&mut root, index, other.1));
        }
    }
    let mut layers = vec![[0.0; 2]; triangles.len()];
    for index in (0..triangles.len()).filter(|index| counts[*index]) {
        let [a, b, c] = triangles[index].map(at);
        let normal = (b - a).cross(c - a);
        let layer = &mut layers[find(&mut root, index as u32) as usize];
        layer[0] += (a - positions[0]).dot(normal) / 6.0;
        layer[1] += 0.5 * normal.length();
    }
    let is_outward = |index: usize| {
        let [volume, area] = layers[find(&mut root, index as u32) as usize];
        counts[index] && volume > least * area
    };
    let found: Vec<bool> = (0..triangles.len()).map(is_outward).collect();
    let chosen: Vec<[u32; 3]> = triangles.iter().zip(&found).filter(|(_, own)| **own).map(|(t, _)| *t).collect();
    (!chosen.is_empty() && boundary(&chosen).is_empty()).then_some(found)
}

/// The only other triangle at each edge, and whether it faces the other way.
fn neighbours(triangles: &[[u32; 3]]) -> Vec<[Option<(usize, bool)>; 3]> {
    let mut edges: Vec<([u32; 2], usize, usize, bool)> = Vec::with_capacity(3 * triangles.len());
    for (triangle, &[a, b, c]) in triangles.iter().enumerate() {
        for (edge, (from, to)) in [(a, b), (b, c), (c, a)].into_iter().enumerate() {
            edges.push(([from.min(to), from.max(to)], triangle, edge, from < to));
        }
    }
    edges.sort_unstable();
    let mut neighbours = vec![[None; 3]; triangles.len()];
    for same in edges.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, a, of_a, a_way), (_, b, of_b, b_way)] = *same {
            neighbours[a][of_a] = Some((b, a_way == b_way));
            neighbours[b][of_b] = Some((a, a_way == b_way));
        }
    }
    neighbours
}

/// The edges at which a mesh ends, as the multiset of edges that leave each vertex, ascending.
pub fn boundary(triangles: &[[u32; 3]]) -> BTreeMap<u32, Vec<u32>> {
    let mut edges: Vec<([u32; 2], i32)> = Vec::with_capacity(3 * triangles.len());
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if from != to {
                edges.push(([from.min(to), from.max(to)], if from < to { 1 } else { -1 }));
            }
        }
    }
    edges.sort_unstable_by_key(|(edge, _)| *edge);
    let mut leaving: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for same in edges.chunk_by(|a, b| a.0 == b.0) {
        let [low, high] = same[0].0;
        let net: i32 = same.iter().map(|(_, sign)| sign).sum();
        let (from, to) = if net > 0 { (low, high) } else { (high, low) };
        for _ in 0..net.unsigned_abs() {
            leaving.entry(from).or_default().push(to);
        }
    }
    for targets in leaving.values_mut() {
        // The last is taken first.
        targets.sort_unstable_by(|a, b| b.cmp(a));
    }
    leaving
}

fn loops(mut leaving: BTreeMap<u32, Vec<u32>>) -> Vec<Vec<u32>> {
    let mut loops = Vec::new();
    let mut place: BTreeMap<u32, usize> = BTreeMap::new();
    while let Some((&start, _)) = leaving.first_key_value() {
        let mut path = vec![start];
        place.insert(start, 0);
        // The boundary leaves every vertex as often as it enters it, so the walk ends at `start`.
        while let Some(next) = path.last().and_then(|at| take(&mut leaving, *at)) {
            match place.get(&next) {
                Some(&first) => {
                    loops.push(path[first..].to_vec());
                    for gone in path.drain(first + 1..) {
                        place.remove(&gone);
                    }
                }
                None => {
                    place.insert(next, path.len());
                    path.push(next);
                }
            }
        }
        place.clear();
    }
    loops
}

fn take(leaving: &mut BTreeMap<u32, Vec<u32>>, from: u32) -> Option<u32> {
    let targets = leaving.get_mut(&from)?;
    let next = targets.pop();
    if targets.is_empty() {
        leaving.remove(&from);
    }
    next
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 3]; 5] = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, 1.0]];
    const PYRAMID: [[u32; 3]; 6] = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [2, 1, 0], [3, 2, 0]];

    /// Six volumes of the solid that a mesh and its cones bound.
    fn solid(triangles: &[[u32; 3]]) -> f64 {
        let positions = SQUARE.map(DVec3::from_array);
        let mesh = triangles.iter().map(|t| t.map(|v| positions[v as usize]));
        mesh.chain(cones(&positions, triangles).concat()).map(|[a, b, c]| a.dot(b.cross(c))).sum()
    }

    #[test]
    fn cones_replace_a_missing_base_and_turn_a_reversed_triangle_round() {
        assert!(cones(&SQUARE.map(DVec3::from_array), &PYRAMID).is_empty());
        assert_eq!([solid(&PYRAMID), solid(&PYRAMID[..4])], [2.0; 2]);
        for reversed in 0..6 {
            let mut triangles = PYRAMID;
            triangles[reversed].swap(0, 1);
            assert!((solid(&triangles) - 2.0).abs() < 1e-12, "{reversed}");
        }
    }

    #[test]
    fn reversed_triangles_are_found() {
        for (count, reversed) in [(6, &[][..]), (6, &[0]), (6, &[5]), (6, &[1, 4]), (5, &[2]), (4, &[3])] {
            let mut triangles = PYRAMID[..count].to_vec();
            reversed.iter().for_each(|index: &usize| triangles[*index].swap(1, 2));
            assert_eq!(turn(&mut triangles), reversed);
            assert_eq!(boundary(&triangles), boundary(&PYRAMID[..count]), "{count} {reversed:?}");
        }
        // A Möbius strip has no orientation.
        let strip = [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5], [4, 5, 1], [1, 5, 0]];
        assert_eq!(turn(&mut strip.to_vec()), [0; 0]);
    }

    #[test]
    fn surfaces_with_a_rim_are_open() {
        // Two pyramids, of which the second lacks its base, and three faces at one edge.
        let shifted = PYRAMID[..4].iter().map(|t| t.map(|v| v + 5));
        let both: Vec<[u32; 3]> = PYRAMID.into_iter().chain(shifted).collect();
        assert_eq!(are_open(&both, &[true; 10]), [[false; 6].as_slice(), &[true; 4]].concat());
        assert_eq!(are_open(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]], &[true; 3]), [true; 3]);
        let with_wing = [PYRAMID.as_slice(), &[[0, 2, 4]]].concat();
        assert_eq!(are_open(&with_wing, &[true; 7]), [false; 7]);
        // The two sides of a triangle.
        assert_eq!(are_open(&[[0, 1, 2], [0, 2, 1]], &[true, false]), [true; 2]);
    }

    #[test]
    fn few_triangles_at_an_edge_are_compared() {
        let fan = |count: u32| -> Option<Vec<bool>> {
            let apex = |i: u32| DVec3::new(libm::cos(f64::from(i)), libm::sin(f64::from(i)), 0.5);
            let positions: Vec<DVec3> = [DVec3::ZERO, DVec3::Z].into_iter().chain((0..count).map(apex)).collect();
            // Both sides of a tetrahedron over each two of the corners around the edge.
            let solids =
                (2..count + 1).step_by(2).flat_map(|v| [[0, v, v + 1], [1, v + 1, v], [0, 1, v], [1, 0, v + 1]]);
            let sides: Vec<[u32; 3]> = solids.flat_map(|[a, b, c]| [[a, b, c], [a, c, b]]).collect();
            outward(&positions, &sides, &vec![true; sides.len()], 0.0)
        };
        assert_eq!(fan(2).unwrap().iter().filter(|own| **own).count(), 4);
        assert_eq!(fan(100), None);
    }

    #[test]
    fn loops_that_touch_are_closed_one_by_one() {
        let found = loops(boundary(&[[0, 1, 2], [0, 3, 4]]));
        assert_eq!(found, [vec![0, 1, 2], vec![0, 3, 4]]);
    }
}
