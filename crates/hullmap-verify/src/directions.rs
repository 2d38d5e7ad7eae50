//! Directions in which a hull is likely to be wrong.
//!
//! In turn, by the index in the list modulo 8:
//! - 0, 1, 2: random on the sphere, with lengths from 2^-30 to 2^30;
//! - 3, 4: face normals, exact to f32 and perturbed by 1, 0.1, … 1e-8: several vertices nearly tie;
//! - 5: edge normals, anywhere between the normals of the two faces, perturbed likewise;
//! - 6: axes, diagonals, and seams of the cube map (|x| = |y|), perturbed likewise;
//! - 7: borders of cube-map cells, up to 1024 per side, and one ulp beside them.
//!
//! Hulls without faces (ranks 0 and 1) get random directions in place of 3, 4 and 5.

use glam::{DVec3, Vec3};

use crate::random::SplitMix;

/// Perturbations, relative to the direction's length.
const DISTURBANCES: [f64; 10] = [0.0, 1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];

/// Lengths of random directions range from 2^−30 to 2^30.
const LENGTH_BITS: u64 = 30;

/// Squared sum of two unit normals below which they are opposite, as at the rim of a flat hull.
const OPPOSITE_NORMALS_SQ: f64 = 1e-20;

/// Finest cube map whose cell borders are tried, as a power of two.
const BORDER_BITS: u64 = 10;

/// `count` finite directions other than zero for a hull with these vertices and faces.
pub fn directions(vertices: &[Vec3], faces: &[Vec<u32>], count: usize, seed: u64) -> Vec<Vec3> {
    let normals: Vec<DVec3> = faces.iter().map(|face| normal(vertices, face)).collect();
    let edges = edges(vertices, faces, &normals);
    let mut random = SplitMix::new(seed);
    let mut list = Vec::with_capacity(count);
    while list.len() < count {
        let index = list.len();
        let round = index / 8;
        let dir = match index % 8 {
            kind @ (3 | 4) if !normals.is_empty() => {
                let share = count / 4;
                let turn = 2 * round + kind - 3;
                let face = pick(&mut random, turn / DISTURBANCES.len(), normals.len(), share / DISTURBANCES.len());
                disturb(&mut random, normals[face], turn)
            }
            5 if !edges.is_empty() => {
                let share = count / 8;
                let edge = pick(&mut random, round / DISTURBANCES.len(), edges.len(), share / DISTURBANCES.len());
                let [from, to] = edges[edge];
                let along = 0.5 + 0.5 * random.signed();
                disturb(&mut random, from.lerp(to, along), round)
            }
            6 => {
                let seam = seam(&mut random, round / DISTURBANCES.len());
                disturb(&mut random, seam, round)
            }
            7 => cell_border(&mut random),
            _ => {
                let exponent = random.below(2 * LENGTH_BITS as usize + 1) as i32 - LENGTH_BITS as i32;
                random.in_ball_f64() * f64::from(exponent).exp2()
            }
        };
        let dir = dir.as_vec3();
        // Opposite faces of a needle can cancel; a random direction takes their place.
        if dir.is_finite() && dir.length_squared() > f32::MIN_POSITIVE {
            list.push(dir);
        } else {
            list.push(random.in_ball());
        }
    }
    list
}

/// Zero, denormal, huge, infinite and NaN directions, for which any vertex is a valid answer.
pub fn special_directions() -> Vec<Vec3> {
    let tiny = f32::from_bits(1);
    let values = [0.0, -0.0, 1.0, tiny, -tiny, 1e-38, f32::MAX, f32::MIN, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
    let mut list = Vec::with_capacity(values.len().pow(3));
    for x in values {
        for y in values {
            list.extend(values.map(|z| Vec3::new(x, y, z)));
        }
    }
    list
}

/// Every index below `len` in turn if they fit into `share` picks, otherwise a random one.
fn pick(random: &mut SplitMix, turn: usize, len: usize, share: usize) -> usize {
    if len <= share { turn % len } else { random.below(len) }
}

fn disturb(random: &mut SplitMix, dir: DVec3, turn: usize) -> DVec3 {
    dir + random.in_ball_f64() * DISTURBANCES[turn % DISTURBANCES.len()]
}

/// Unit normal of a polygon by Newell's sums; zero for one without area.
fn normal(vertices: &[Vec3], face: &[u32]) -> DVec3 {
    let corner = |i: usize| vertices[face[i % face.len()] as usize].as_dvec3();
    let origin = corner(0);
    let sum: DVec3 = (1..face.len()).map(|i| (corner(i) - origin).cross(corner(i + 1) - origin)).sum();
    sum.normalize_or_zero()
}

/// Arcs of directions in which both ends of an edge are extreme, none longer than a right angle:
/// from the normal of one of its faces to the middle, and from there to the normal of the other. At
/// the rim of a flat hull the middle lies in the plane.
fn edges(vertices: &[Vec3], faces: &[Vec<u32>], normals: &[DVec3]) -> Vec<[DVec3; 2]> {
    let mut sides = Vec::new();
    for (index, face) in faces.iter().enumerate() {
        for (i, &from) in face.iter().enumerate() {
            let to = face[(i + 1) % face.len()];
            sides.push((from.min(to), from.max(to), from > to, index));
        }
    }
    sides.sort_unstable();
    let mut arcs = Vec::with_capacity(sides.len());
    for group in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let (low, high, is_reversed, face) = group[0];
        let first = normals[face];
        let second = group.get(1).map_or(-first, |side| normals[side.3]);
        let middle = first + second;
        let middle = if middle.length_squared() > OPPOSITE_NORMALS_SQ {
            middle.normalize()
        } else {
            // Faces run counter-clockwise, so what lies to the right of a side is outside.
            let along = (vertices[high as usize] - vertices[low as usize]).as_dvec3();
            let along = if is_reversed { -along } else { along };
            along.cross(first).normalize_or_zero()
        };
        arcs.push([first, middle]);
        arcs.push([middle, second]);
    }
    arcs
}

/// One of the 26 directions with components −1, 0, 1, or a random one on a seam.
fn seam(random: &mut SplitMix, turn: usize) -> DVec3 {
    let corner = turn % 53;
    if corner < 27 && corner != 13 {
        let component = |divisor: usize| (corner / divisor % 3) as f64 - 1.0;
        return DVec3::new(component(1), component(3), component(9));
    }
    let sign = |random: &mut SplitMix| if random.bits() & 1 == 0 { 1.0 } else { -1.0 };
    let (first, second, third) = (sign(random), sign(random), random.signed());
    turned(DVec3::new(first, second, third), random.below(3))
}

/// A point on a cell border of a cube map, or one ulp beside it.
fn cell_border(random: &mut SplitMix) -> DVec3 {
    let cells = 1_u64 << random.below(BORDER_BITS as usize + 1);
    let line = |random: &mut SplitMix| 2.0 * random.below(cells as usize + 1) as f64 / cells as f64 - 1.0;
    let across = line(random) as f32;
    let across = match random.below(3) {
        0 => across,
        1 => across.next_up(),
        _ => across.next_down(),
    };
    let along = if random.bits() & 1 == 0 { line(random) } else { random.signed() };
    let major = if random.bits() & 1 == 0 { 1.0 } else { -1.0 };
    turned(DVec3::new(major, f64::from(across), along), random.below(3))
}

/// The components rotated by `by` positions.
fn turned(v: DVec3, by: usize) -> DVec3 {
    match by {
        0 => v,
        1 => DVec3::new(v.z, v.x, v.y),
        _ => DVec3::new(v.y, v.z, v.x),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cube with corners at ±1; bit k of a vertex index is the sign of axis k.
    fn cube() -> (Vec<Vec3>, Vec<Vec<u32>>) {
        let sign = |bit: u32| if bit == 0 { -1.0 } else { 1.0 };
        let vertices = (0..8).map(|i| Vec3::new(sign(i & 1), sign(i & 2), sign(i & 4))).collect();
        let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        (vertices, faces.map(|face| face.to_vec()).to_vec())
    }

    #[test]
    fn the_list_is_seeded_and_finite() {
        let (vertices, faces) = cube();
        let list = directions(&vertices, &faces, 10_001, 7);
        assert_eq!(list.len(), 10_001);
        assert_eq!(list, directions(&vertices, &faces, 10_001, 7));
        assert_ne!(list, directions(&vertices, &faces, 10_001, 8));
        assert!(list.iter().all(|dir| dir.is_finite() && *dir != Vec3::ZERO));
    }

    #[test]
    fn every_face_and_edge_is_tried_exactly() {
        let (vertices, faces) = cube();
        let list = directions(&vertices, &faces, 10_000, 0);
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            assert!(list.contains(&axis) && list.contains(&-axis));
        }
        let is_between = |dir: &Vec3| dir.x > 0.0 && dir.y > 0.0 && dir.z == 0.0 && dir.x != dir.y;
        assert!(list.iter().any(is_between));
        let on_seam = |dir: &&Vec3| dir.x.abs() == dir.y.abs() && dir.z != 0.0;
        assert!(list.iter().filter(on_seam).count() > 20);
    }

    fn check_arcs(vertices: &[Vec3], faces: &[Vec<u32>], count: usize) {
        let normals: Vec<DVec3> = faces.iter().map(|face| normal(vertices, face)).collect();
        let arcs = edges(vertices, faces, &normals);
        assert_eq!(arcs.len(), count);
        for [from, to] in arcs {
            for along in [0.0, 0.3, 1.0] {
                let dir = from.lerp(to, along);
                assert!(dir.length() > 0.7);
                let dots: Vec<f64> = vertices.iter().map(|v| v.as_dvec3().dot(dir)).collect();
                let greatest = dots.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                assert!(dots.iter().filter(|&&dot| dot > greatest - 1e-12).count() >= 2, "{dir}");
            }
        }
    }

    #[test]
    fn a_cube_has_outward_normals_and_arcs_between_them() {
        let (vertices, faces) = cube();
        for face in &faces {
            let corner = vertices[face[0] as usize].as_dvec3();
            assert!((normal(&vertices, face).dot(corner) - 1.0).abs() < 1e-15);
        }
        check_arcs(&vertices, &faces, 24);
    }

    #[test]
    fn flat_hulls_and_those_without_faces_get_directions_too() {
        let square = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        for faces in [vec![vec![0, 1, 2, 3]], vec![vec![0, 1, 2, 3], vec![3, 2, 1, 0]]] {
            check_arcs(&square, &faces, 8);
        }
        assert_eq!(directions(&square, &[vec![0, 1, 2, 3]], 500, 0).len(), 500);
        assert_eq!(directions(&square[..1], &[], 500, 0).len(), 500);
    }

    #[test]
    fn special_directions_include_zero_denormal_huge_and_nan() {
        let list = special_directions();
        assert!(list.contains(&Vec3::ZERO) && list.contains(&Vec3::splat(f32::MAX)));
        assert!(list.iter().any(|dir| dir.is_nan()) && list.contains(&Vec3::splat(f32::from_bits(1))));
    }
}
