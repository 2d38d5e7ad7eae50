//! Planes of faces that may divide pieces.

use std::collections::BTreeMap;

use glam::DVec3;

use hullmap_geometry::{bits, bounds, planes::HalfSpace};

/// Sine of the angle at which faces must lie in front of each other for their edge to be concave.
const CONCAVE: f64 = 0.02;

/// Sine of that angle for sharp edges, at which features begin.
const SHARP: f64 = 0.3;

/// Share of the area of all faces from which faces in one plane count as large.
const LARGE: f64 = 0.005;

/// Numbers of steps by which normals and offsets are rounded: planes that agree are one.
const STEPS: [f64; 2] = [64.0, 512.0];

/// Maximum number of faces at an edge for it to be an edge of a solid.
const MAX_FACES: usize = 8;

/// Planes of faces that may divide pieces.
#[derive(Debug, Default)]
pub struct FacePlanes {
    /// Planes of faces at concave edges, the longest and sharpest edges first.
    pub concave: Vec<HalfSpace>,
    /// Planes of large faces, the largest first. Where shells touch, there are no concave edges.
    pub large: Vec<HalfSpace>,
    /// Sharp concave edges.
    pub edges: Vec<[DVec3; 2]>,
}

/// A weight, a plane, and a point of it.
type Weighted = (f64, HalfSpace, DVec3);

impl FacePlanes {
    /// Planes of a surface's faces.
    ///
    /// # Complexity
    /// O(n log n) for n triangles.
    pub fn new(triangles: &[[DVec3; 3]]) -> Self {
        let [low, high] = bounds(triangles.as_flattened().iter().copied());
        let of_face = |t: &[DVec3; 3]| {
            let normal = normal(t);
            let area = (t[1] - t[0]).cross(t[2] - t[0]).length();
            (area, HalfSpace { normal, offset: normal.dot(t[0]) }, t[0])
        };
        let faces = grouped(triangles.iter().map(of_face).filter(|(area, ..)| *area > 0.0), low, high);
        let total: f64 = faces.iter().map(|(area, _)| area).sum();
        let large = faces.into_iter().take_while(|(area, _)| *area >= LARGE * total);
        let (concave, edges) = concave_edges(triangles);
        let concave = grouped(concave.into_iter(), low, high);
        let plane = |(_, plane)| plane;
        Self { concave: concave.into_iter().map(plane).collect(), large: large.map(plane).collect(), edges }
    }
}

/// Planes with the sums of their weights, the greatest first.
fn grouped(planes: impl Iterator<Item = Weighted>, low: DVec3, high: DVec3) -> Vec<(f64, HalfSpace)> {
    let mut groups: BTreeMap<[i32; 4], (f64, HalfSpace)> = BTreeMap::new();
    for (weight, plane, at) in planes {
        // One sign for both sides of a plane.
        let sign = if plane.normal.dot(DVec3::new(1.0, 0.618, 0.381)) < 0.0 { -1.0 } else { 1.0 };
        let n = plane.normal * sign;
        let height = n.dot(at - low) / low.distance(high);
        let key = [n.x * STEPS[0], n.y * STEPS[0], n.z * STEPS[0], height * STEPS[1]].map(|x| x.round() as i32);
        groups.entry(key).or_insert((0.0, HalfSpace { normal: n, offset: n.dot(at) })).0 += weight;
    }
    let mut ranked: Vec<(f64, HalfSpace)> = groups.into_values().collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    ranked
}

fn normal([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (*b - *a).cross(*c - *a).normalize_or_zero()
}

/// The planes of both faces at each concave edge, weighted by its length and sine, and the sharp
/// edges.
fn concave_edges(triangles: &[[DVec3; 3]]) -> (Vec<Weighted>, Vec<[DVec3; 2]>) {
    let mut sides: Vec<([[u64; 3]; 2], u32, u32)> = Vec::with_capacity(3 * triangles.len());
    for (i, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (bits(t[k]), bits(t[(k + 1) % 3]));
            if a != b {
                sides.push((if a < b { [a, b] } else { [b, a] }, i as u32, k as u32));
            }
        }
    }
    sides.sort_unstable();
    let (mut found, mut edges) = (Vec::new(), Vec::new());
    for run in sides.chunk_by(|a, b| a.0 == b.0).filter(|run| (2..=MAX_FACES).contains(&run.len())) {
        for (i, first) in run.iter().enumerate() {
            for second in &run[i + 1..] {
                let (t, u) = (triangles[first.1 as usize], triangles[second.1 as usize]);
                let normals = [normal(&t), normal(&u)];
                let (a, b) = (t[first.2 as usize], t[(first.2 as usize + 1) % 3]);
                let apex = u[(second.2 as usize + 2) % 3];
                let away = (apex - a).reject_from_normalized((b - a).normalize_or_zero());
                let sine = normals[0].dot(away) / away.length();
                // Written so that NaN is not concave.
                if sine > CONCAVE && normals.iter().all(|normal| *normal != DVec3::ZERO) {
                    let weight = a.distance(b) * sine;
                    edges.extend((sine > SHARP).then_some([a, b]));
                    found.extend(normals.map(|normal| (weight, HalfSpace { normal, offset: normal.dot(a) }, a)));
                }
            }
        }
    }
    (found, edges)
}
