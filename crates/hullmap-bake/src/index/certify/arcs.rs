//! Arcs of a hull's edges on the Gauss map, and their pieces on a face of the cube.
//!
//! The arc of an edge leads from the normal of one face to the other's, at right angles to the
//! edge. An arc longer than a right angle is cut in two at the direction out of one face across the
//! edge, because interpolation along it loses digits. At a polygon (rank 2), the arc of a side
//! leads over the side's normal to the other face.

use glam::DVec3;
use hullmap_format::cube;
use hullmap_geometry::planes::between;

use crate::hull::{
    Hull,
    area::{accurate_cross, area_vector},
    edges,
};

pub struct Arcs(Vec<Arc>);

struct Arc {
    ends: [DVec3; 2],
    vertices: [u32; 2],
}

/// Part of an arc in the plane of a cube's face: a segment.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// The ends, as (u, v).
    pub ends: [[f64; 2]; 2],
    /// The ends of the edge: both are support vertices along the arc.
    pub vertices: [u32; 2],
}

impl Piece {
    pub fn middle(&self) -> [f64; 2] {
        let [p, q] = self.ends;
        [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])]
    }

    pub fn clip(mut self, height: impl Fn([f64; 2]) -> f64) -> Option<Self> {
        let [from, to] = self.ends.map(height);
        let [p, q] = self.ends;
        let at = |share: f64| between(p, q, share);
        match (from >= 0.0, to >= 0.0) {
            (true, true) => {}
            (true, false) => self.ends[1] = at(from / (from - to)),
            (false, true) => self.ends[0] = at(from / (from - to)),
            (false, false) => return None,
        }
        Some(self)
    }
}

impl Arcs {
    pub fn new(hull: &Hull) -> Self {
        let positions = hull.positions();
        let normals: Vec<DVec3> = hull.faces.iter().map(|face| area_vector(face, &positions).normalize()).collect();
        // Each edge twice: once from its lower to its higher vertex, and once back.
        let mut sides: Vec<([u32; 2], bool, u32)> = Vec::with_capacity(hull.faces.iter().map(Vec::len).sum());
        for (face, outline) in (0..).zip(&hull.faces) {
            sides.extend(edges(outline).map(|(a, b)| ([a.min(b), a.max(b)], a > b, face)));
        }
        sides.sort_unstable();
        let mut arcs = Vec::with_capacity(sides.len() / 2 + 16);
        for pair in sides.chunk_by(|a, b| a.0 == b.0) {
            let [(vertices, _, left), (.., right)] = *pair else { continue };
            let [from, to] = [left, right].map(|face| normals[face as usize]);
            let [a, b] = vertices.map(|vertex| positions[vertex as usize]);
            if from.dot(to) < 0.0 {
                // Faces run counter-clockwise: what lies to the right of a side is outside.
                let middle = accurate_cross(b - a, from).normalize();
                arcs.extend([[from, middle], [middle, to]].map(|ends| Arc { ends, vertices }));
            } else {
                arcs.push(Arc { ends: [from, to], vertices });
            }
        }
        Self(arcs)
    }

    /// The pieces on `face` of the cube, widened by `slack`.
    pub fn on_face(&self, face: u32, slack: f64) -> Vec<Piece> {
        let axis = (face / 2) as usize;
        let towards = DVec3::from_array(cube::direction(face, 0.0, 0.0));
        let sides = [(axis + 1) % 3, (axis + 2) % 3].map(|axis| DVec3::AXES[axis]);
        let planes = [-sides[0], sides[0], -sides[1], sides[1]].map(|side| towards * (1.0 + slack) + side);
        self.0.iter().filter_map(|arc| piece(arc, &planes, towards, sides)).collect()
    }
}

/// The piece of an arc in front of the planes, projected onto the plane towards the face.
fn piece(arc: &Arc, planes: &[DVec3; 4], towards: DVec3, sides: [DVec3; 2]) -> Option<Piece> {
    let [mut p, mut q] = arc.ends;
    for plane in planes {
        let (from, to) = (plane.dot(p), plane.dot(q));
        match (from >= 0.0, to >= 0.0) {
            (true, true) => {}
            (true, false) => q = p + (q - p) * (from / (from - to)),
            (false, true) => p += (q - p) * (from / (from - to)),
            (false, false) => return None,
        }
    }
    // All planes pass through the origin. So does an arc that ends behind the face.
    let project = |d: DVec3| {
        let depth = d.dot(towards);
        (depth > 0.0).then(|| sides.map(|side| d.dot(side) / depth))
    };
    Some(Piece { ends: [project(p)?, project(q)?], vertices: arc.vertices })
}
