//! Patches: pieces of the mesh's surface.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::groups::{find, join};
use hullmap_geometry::{
    bits,
    planes::{self, HalfSpace},
    triangle,
};

#[derive(Clone, Debug)]
pub struct Patch {
    pub polygons: Vec<Vec<DVec3>>,
    /// The corners, each once.
    pub points: Vec<DVec3>,
}

impl Patch {
    pub fn new(polygons: Vec<Vec<DVec3>>) -> Option<Self> {
        let mut points = polygons.concat();
        points.sort_unstable_by_key(|p| bits(*p));
        points.dedup_by_key(|p| bits(*p));
        (!points.is_empty()).then_some(Self { polygons, points })
    }

    pub fn divided(&self, plane: &HalfSpace, tolerance: f64) -> [Option<Self>; 2] {
        let (mut behind, mut in_front) = (Vec::new(), Vec::new());
        for polygon in &self.polygons {
            let (within, rest) = planes::divide(polygon, &[*plane], tolerance);
            behind.extend((!within.is_empty()).then_some(within));
            in_front.extend(rest);
        }
        [Self::new(behind), Self::new(in_front)]
    }
}

/// The triangles whose middles lie in one cube of this size, and which share corners, as patches.
///
/// # Complexity
/// O(n log n) for n triangles.
pub fn patches(triangles: &[[DVec3; 3]], size: f64) -> Vec<Patch> {
    let mut cubes: BTreeMap<[i64; 3], Vec<Vec<DVec3>>> = BTreeMap::new();
    for corners in triangles {
        let cube = (triangle::centroid(corners) / size).to_array().map(|x| x.floor() as i64);
        cubes.entry(cube).or_default().push(corners.to_vec());
    }
    cubes.into_values().flat_map(connected).filter_map(Patch::new).collect()
}

/// Groups of polygons that share corners.
fn connected(polygons: Vec<Vec<DVec3>>) -> Vec<Vec<Vec<DVec3>>> {
    let mut first: BTreeMap<[u64; 3], u32> = BTreeMap::new();
    let mut root: Vec<u32> = (0..polygons.len() as u32).collect();
    for (index, polygon) in (0..).zip(&polygons) {
        for p in polygon {
            let other = *first.entry(bits(*p)).or_insert(index);
            join(&mut root, index, other);
        }
    }
    let mut found: BTreeMap<u32, Vec<Vec<DVec3>>> = BTreeMap::new();
    for (index, polygon) in (0..).zip(polygons) {
        found.entry(find(&mut root, index)).or_default().push(polygon);
    }
    found.into_values().collect()
}
