//! Large flat faces of a solid, which stay flat: no part may stand out of one, except near its rim.

use std::{
    collections::{BTreeMap, HashSet},
    ops::ControlFlow,
};

use glam::DVec3;

use crate::fit::{
    Solid, SolidKind,
    triangle_tree::{Bounds, TriangleTree},
};
use hullmap_geometry::{
    bits,
    planes::HalfSpace,
    triangle::{self, Triangle},
};

/// Height above a flat face up to which a part may stand out, relative to the diagonal.
const EXCESS: f64 = 1e-3;

/// Share of the area of all faces from which a flat face counts as large.
const LARGE: f64 = 0.02;

/// Limit of parts from which faces are kept flat, relative to the height that is too much.
const LEAST: f64 = 2.0;

/// Lengths by which normals, and offsets relative to the diagonal, are rounded: triangles that
/// agree are in one face.
const STEPS: [f64; 2] = [1e-4, 1e-5];

/// Distance from a face's triangles up to which a point is on it, relative to the limit.
const ON_FACE: f64 = 1e-3;

/// Share of the height within which nothing else may be nearer.
const NEAREST: f64 = 1.0 - 1e-6;

/// Large flat faces.
#[derive(Default)]
pub struct Flats {
    faces: Vec<Flat>,
    /// The height above a face that is too much, and the maximum distance of parts from the solid.
    heights: [f64; 2],
}

/// Triangles in one plane, whose normal points out of the solid.
struct Flat {
    plane: HalfSpace,
    face: Nearest,
    /// Edges of one triangle only.
    rim: Nearest,
}

struct Nearest {
    triangles: Vec<Triangle>,
    tree: TriangleTree,
}

impl Flats {
    /// The large flat faces of a solid whose parts are within a limit. Walls have two sides, from
    /// which the thickness of their parts stands out.
    ///
    /// # Complexity
    /// O(n log n) for n triangles.
    pub fn new(solid: &Solid, limit: f64, thickness: f64) -> Self {
        let are_walls = solid.kind() == SolidKind::Walls;
        let heights = [EXCESS * solid.diagonal() + if are_walls { 0.5 * thickness } else { 0.0 }, limit];
        if LEAST * heights[0] > limit {
            return Self::default();
        }
        let mut total = 0.0;
        let mut groups: BTreeMap<[i64; 4], (f64, Vec<Triangle>)> = BTreeMap::new();
        let own = &solid.triangles()[..solid.mesh_count()];
        // A doubled wall has both sides already.
        let mut seen = HashSet::new();
        let other = own.iter().filter(|_| are_walls).map(|[a, b, c]| [*a, *c, *b]);
        for corners in
            &own.iter().copied().chain(other).filter(|corners| seen.insert(side(corners))).collect::<Vec<_>>()
        {
            let Some(normal) = area(corners).try_normalize() else { continue };
            let height = normal.dot(corners[0]) / (STEPS[1] * solid.diagonal());
            let [x, y, z] = (normal / STEPS[0]).to_array();
            // Planes along the axes are not at an end of a step.
            let key = [x, y, z, height].map(|x| (x + 0.137).floor() as i64);
            let group = groups.entry(key).or_default();
            let own = area(corners).length();
            (group.0, total) = (group.0 + own, total + own);
            group.1.push(*corners);
        }
        let large = groups.into_values().filter(|(area, _)| *area >= LARGE * total);
        let faces: Vec<Flat> = large.filter_map(|(_, triangles)| Flat::new(triangles)).collect();
        if faces.is_empty() { Self::default() } else { Self { faces, heights } }
    }

    /// The height above a face that is too much; 0 without faces.
    pub fn height(&self) -> f64 {
        self.heights[0]
    }

    /// Whether a point outside of the solid stands out of a face: it is nearest to it, and farther
    /// from its rim than parts may be from the solid.
    pub fn are_exceeded(&self, solid: &Solid, p: DVec3) -> bool {
        let [least, limit] = self.heights;
        self.faces.iter().any(|Flat { plane, face, rim }| {
            let height = plane.height(p);
            let foot = p - plane.normal * height;
            height > least
                && height <= limit
                && face.is_within(foot, ON_FACE * limit)
                && !rim.is_within(foot, limit)
                && !solid.is_near(p, height * NEAREST)
        })
    }

    /// Whether a point of a triangle may stand out of a face.
    pub fn may_be_exceeded(&self, corners: &Triangle) -> bool {
        let [least, limit] = self.heights;
        let centre = triangle::centroid(corners);
        let radius = corners.iter().map(|p| p.distance(centre)).fold(0.0, f64::max);
        self.faces.iter().any(|Flat { plane, face, rim }| {
            let heights = corners.map(|p| plane.height(p));
            let foot = centre - plane.normal * plane.height(centre);
            heights.into_iter().any(|h| h > least)
                && heights.into_iter().any(|h| h <= limit)
                && face.is_within(foot, radius + ON_FACE * limit)
                && !(limit > radius && rim.is_within(foot, limit - radius))
        })
    }
}

impl Flat {
    fn new(triangles: Vec<Triangle>) -> Option<Self> {
        let largest = triangles.iter().max_by(|a, b| area(a).length().total_cmp(&area(b).length()))?;
        let normal = area(largest).try_normalize()?;
        let plane = HalfSpace { normal, offset: normal.dot(largest[0]) };
        let mut edges: BTreeMap<[[u64; 3]; 2], (Triangle, usize)> = BTreeMap::new();
        for [a, b, c] in &triangles {
            for [p, q] in [[*a, *b], [*b, *c], [*c, *a]] {
                let [u, v] = [bits(p), bits(q)];
                edges.entry(if u < v { [u, v] } else { [v, u] }).or_insert(([p, q, q], 0)).1 += 1;
            }
        }
        let rim = edges.into_values().filter(|(_, count)| *count == 1).map(|(edge, _)| edge).collect();
        Some(Self { plane, face: Nearest::new(triangles), rim: Nearest::new(rim) })
    }
}

impl Nearest {
    fn new(triangles: Vec<Triangle>) -> Self {
        Self { tree: TriangleTree::new(&triangles), triangles }
    }

    fn is_within(&self, p: DVec3, distance: f64) -> bool {
        let is_near = |bounds: &Bounds| bounds.distance(p) <= distance;
        let take = |index: u32| {
            let is_found = triangle::nearest(&self.triangles[index as usize], p).distance(p) <= distance;
            if is_found { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        self.tree.visit(is_near, take).is_break()
    }
}

/// The corners of a triangle, the least first: equal for equal sides of equal triangles.
fn side(corners: &Triangle) -> [[u64; 3]; 3] {
    let bits = corners.map(bits);
    let least = (0..3).min_by_key(|k| bits[*k]).unwrap_or_default();
    [0, 1, 2].map(|k| bits[(least + k) % 3])
}

fn area([a, b, c]: &Triangle) -> DVec3 {
    (*b - *a).cross(*c - *a)
}

#[cfg(test)]
mod tests {
    use hullmap_geometry::PointSet;
    use shapes::{rng::SplitMix64, solids::extrusion};

    use super::*;
    use crate::decompose::{Cover, Length, decompose, partition::field::Field};
    use crate::fit::SolidRule;
    use crate::test_meshes::{open_block, point_set};

    /// A block with a step of 1.2 % of its diagonal.
    fn step() -> PointSet {
        // Fans of the caps start at the concave corner.
        let outline = [[2.0, 1.0], [2.0, 1.06], [0.0, 1.06], [0.0, 0.0], [4.0, 0.0], [4.0, 1.0]];
        let mut mesh = extrusion(&outline, 0.0, 3.0);
        mesh.faces[0].rotate_right(1);
        point_set(&mesh)
    }

    #[test]
    fn points_above_a_flat_face_are_beyond_except_near_its_rim() {
        let seed = 66;
        println!("seed {seed}");
        let mut rng = SplitMix64::new(seed);
        let solid = Solid::new(&step());
        let (limit, least) = (0.02 * solid.diagonal(), 1e-3 * solid.diagonal());
        let mut field = Field::new(&solid);
        field.keep_flats(limit, 0.0);
        let (mut left, mut near) = (0, 0);
        for _ in 0..20_000 {
            let p = DVec3::new(rng.between(2.0, 4.0), rng.between(1.0, 1.12), rng.between(0.0, 3.0));
            let [x, height, z] = [p.x, p.y - 1.0, p.z];
            let is_inner = x >= 2.0 + limit && x <= 4.0 - limit && z >= limit && z <= 3.0 - limit;
            let to_step = (p - DVec3::new(2.0, p.y.min(1.06), p.z)).length();
            let expected = height.min(to_step) > limit || is_inner && height > least;
            assert_eq!(field.is_beyond(p, limit), expected, "{p}");
            left += usize::from(expected && height <= limit);
            near += usize::from(!expected && height > least);
        }
        assert!(left > 5_000 && near > 500, "the sample is not representative: {left} left, {near} near the rim");
    }

    #[test]
    fn walls_stay_flat_on_both_sides() {
        let seed = 67;
        println!("seed {seed}");
        let mut rng = SplitMix64::new(seed);
        let solid = Solid::by(&open_block([0.0; 3], [4.0, 3.0, 2.0]), SolidRule::Walls);
        let [limit, thickness] = [0.03, 0.01].map(|share| share * solid.diagonal());
        let mut field = Field::new(&solid);
        field.keep_flats(limit, thickness);
        let least = 1e-3 * solid.diagonal() + 0.5 * thickness;
        let mut counts = [0; 2];
        for _ in 0..2_000 {
            let height = rng.between(-1.0, 1.0) * limit;
            let p = DVec3::new(rng.between(limit, 4.0 - limit), rng.between(limit, 3.0 - limit), height);
            let is_beyond = field.is_beyond(p, limit);
            assert_eq!(is_beyond, height.abs() > least, "{p}");
            counts[usize::from(is_beyond)] += 1;
        }
        assert!(counts.iter().all(|count| *count > 300), "the sample is not representative: {counts:?}");
    }

    #[test]
    fn parts_keep_steps() {
        let mesh = step();
        let parts = decompose(&mesh, &Cover { max_error: Length::Relative(0.02), ..Cover::default() });
        let parts = parts.unwrap().unwrap();
        let top = |part: &PointSet| part.positions.iter().map(|p| p[1]).fold(0.0, f32::max);
        let mut tops: Vec<f32> = parts.iter().map(top).collect();
        tops.sort_by(f32::total_cmp);
        assert!(matches!(*tops, [low, high] if (low - 1.0).abs() < 1e-3 && (high - 1.06).abs() < 1e-3), "{tops:?}");
        // No point of a face is as far from its rim as this error.
        let coarse = decompose(&mesh, &Cover { max_error: Length::Relative(0.5), ..Cover::default() });
        assert_eq!(coarse.unwrap().unwrap().len(), 1);
    }
}
