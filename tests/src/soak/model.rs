//! A shape by its definition: its extent in a direction, and the distance of a point from it.

use glam::DVec3;
use hullmap::Hull;
use hullmap_testkit::{
    polytope::{Edge, Polytope},
    reach::Reach,
};

/// The core of a shape, before scale and convex radius.
#[derive(Clone, Debug)]
pub enum Core {
    /// The convex hull of points, and the planes of its faces: outward normals and offsets. Without
    /// planes it is a segment or a point, whose ends are the first and the last point.
    Points {
        /// The vertices.
        points: Vec<DVec3>,
        /// Unit normal, and the maximum extent of the points along it.
        planes: Vec<(DVec3, f64)>,
        /// The edges of a hull with faces.
        edges: Vec<Edge>,
    },
    /// A box about the origin, by its half edges.
    Cuboid(DVec3),
    /// A segment along z about the origin, by its half length.
    Segment(f64),
    /// A cylinder about z, by half height and radius.
    Cylinder(f64, f64),
    /// A cone about z, tip up, by half height and radius of the base.
    Cone(f64, f64),
    /// A ball about the origin, by its radius.
    Ball(f64),
}

/// A core, scaled along the axes, summed with a ball. In the shape's own frame and units.
#[derive(Clone, Debug)]
pub struct Model {
    core: Core,
    scale: DVec3,
    radius: f64,
    /// Upper bound of the distance of a point from the frame's origin.
    pub greatest: f64,
}

impl Model {
    /// `core`, without scale and convex radius.
    pub fn new(core: Core) -> Self {
        let greatest = match &core {
            Core::Points { points, .. } => points.iter().map(|p| p.length()).fold(0.0, f64::max),
            Core::Cuboid(half) => half.length(),
            Core::Segment(half) => *half,
            Core::Cylinder(half, radius) | Core::Cone(half, radius) => half + radius,
            Core::Ball(radius) => *radius,
        };
        Self { core, scale: DVec3::ONE, radius: 0.0, greatest }
    }

    /// The hull's own vertices, and planes through its faces.
    pub fn of_hull(hull: &Hull<'_>) -> Self {
        if hull.rank() < 2 {
            let points: Vec<DVec3> = hull.vertices().map(|v| v.as_dvec3()).collect();
            assert!(points.len() <= 2, "{} has rank below 2 but more than two vertices", hull.name());
            return Self::new(Core::Points { points, planes: Vec::new(), edges: Vec::new() });
        }
        let Polytope { points, normals, edges } = Polytope::new(hull);
        // A sliver's normal may be rounding error, but a plane in front of all points still bounds
        // the hull.
        let planes = normals.into_iter().map(|n| (n, reach(&points, n))).collect();
        Self::new(Core::Points { points, planes, edges })
    }

    /// The triangle with these corners: its plane on both sides, and the planes through its edges
    /// perpendicular to it.
    pub fn of_triangle(corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize();
        let sides = [b - a, c - b, a - c].map(|side| side.cross(normal).normalize());
        // The true maximum of each plane, whatever rounding error did to its normal.
        let planes = [normal, -normal].into_iter().chain(sides).map(|n| (n, reach(&corners, n))).collect();
        Self::new(Core::Points { points: corners.to_vec(), planes, edges: Vec::new() })
    }

    /// Scaled along the axes, before the convex radius is added.
    pub fn scaled(self, scale: DVec3) -> Self {
        assert_eq!(self.radius, 0.0, "scale first");
        Self { scale, greatest: self.greatest * scale.abs().max_element(), ..self }
    }

    /// Summed with a ball.
    pub fn rounded(self, radius: f64) -> Self {
        Self { radius: self.radius + radius, greatest: self.greatest + radius, ..self }
    }

    /// Lower bound of the distance of `p` from the shape; negative inside.
    pub fn outside(&self, p: DVec3) -> f64 {
        let q = if self.scale == DVec3::ONE { p } else { p / self.scale };
        let size = self.scale.abs();
        let across = (q.x * q.x + q.y * q.y).sqrt();
        let core = match &self.core {
            Core::Points { points, planes, .. } if planes.is_empty() => {
                let [first, last] = [points[0], points[points.len() - 1]].map(|p| p * self.scale);
                to_segment(p, first, last)
            }
            Core::Points { planes, .. } if size == DVec3::ONE => {
                planes.iter().map(|(n, offset)| n.dot(p) - offset).fold(f64::NEG_INFINITY, more)
            }
            Core::Points { planes, .. } => {
                let height = |(n, offset): &(DVec3, f64)| (n.dot(q) - offset) / (*n / self.scale).length();
                planes.iter().map(height).fold(f64::NEG_INFINITY, more)
            }
            Core::Cuboid(half) => to_corner((q.abs() - *half) * size),
            Core::Segment(half) => {
                let end = DVec3::Z * (*half * self.scale.z);
                to_segment(p, end, -end)
            }
            Core::Cylinder(half, radius) => {
                let beside = (across - radius) * size.x.min(size.y);
                to_corner(DVec3::new(beside, (q.z.abs() - half) * size.z, f64::NEG_INFINITY))
            }
            Core::Cone(half, radius) => {
                let slant = (4.0 * half * half + radius * radius).sqrt();
                let side = if slant > 0.0 {
                    // Behind the side's line in the plane through the axis.
                    let height = (2.0 * half * across + radius * (q.z - half)) / slant;
                    if height > 0.0 { height * size.min_element() } else { height }
                } else {
                    q.length()
                };
                ((-half - q.z) * size.z).max(side)
            }
            Core::Ball(radius) => {
                let height = q.length() - radius;
                if height > 0.0 { height * size.min_element() } else { height }
            }
        };
        core - self.radius
    }

    /// Outward normals of all planes of a polytope; `None` for other shapes.
    pub fn planes(&self) -> Option<Vec<DVec3>> {
        match &self.core {
            Core::Points { planes, .. } if !planes.is_empty() && self.radius == 0.0 => {
                Some(self.face_normals().collect())
            }
            Core::Cuboid(_) if self.radius == 0.0 => {
                Some(DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]).collect())
            }
            _ => None,
        }
    }

    /// Outward face normals; empty for shapes without faces.
    pub fn face_normals(&self) -> impl Iterator<Item = DVec3> {
        let planes = match &self.core {
            Core::Points { planes, .. } => &planes[..],
            _ => &[],
        };
        planes.iter().map(|(n, _)| (*n / self.scale).normalize())
    }

    /// Normal of face `index`, modulo the number of faces; `None` for shapes without faces.
    pub fn face_normal(&self, index: usize) -> Option<DVec3> {
        match &self.core {
            Core::Points { planes, .. } if !planes.is_empty() => {
                Some((planes[index % planes.len()].0 / self.scale).normalize())
            }
            Core::Cuboid(_) => Some(DVec3::AXES[index % 3] * if index.is_multiple_of(2) { 1.0 } else { -1.0 }),
            Core::Cylinder(..) | Core::Cone(..) => Some(DVec3::NEG_Z),
            _ => None,
        }
    }

    /// Direction of edge `index`, modulo the number of edges, and an outward direction across it.
    pub fn edge(&self, index: usize, lean: f64) -> Option<(DVec3, DVec3)> {
        match &self.core {
            Core::Points { planes, edges, .. } if !edges.is_empty() => {
                let edge = &edges[index % edges.len()];
                let [left, right] = edge.faces.map(|face| planes[face].0);
                let out = left * lean + right * (1.0 - lean);
                Some(((edge.dir * self.scale).normalize(), (out / self.scale).normalize()))
            }
            Core::Cuboid(_) => {
                let axis = index % 3;
                let out = DVec3::AXES[(axis + 1) % 3] * lean + DVec3::AXES[(axis + 2) % 3] * (1.0 - lean);
                Some((DVec3::AXES[axis], out.normalize()))
            }
            Core::Segment(_) => Some((DVec3::Z, DVec3::X)),
            _ => None,
        }
    }
}

impl Reach for Model {
    fn reach(&self, dir: DVec3) -> f64 {
        let d = dir * self.scale;
        let across = |d: DVec3| (d.x * d.x + d.y * d.y).sqrt();
        let core = match &self.core {
            Core::Points { points, .. } => reach(points, d),
            Core::Cuboid(half) => d.abs().dot(*half),
            Core::Segment(half) => d.z.abs() * half,
            Core::Cylinder(half, radius) => d.z.abs() * half + across(d) * radius,
            Core::Cone(half, radius) => (d.z * half).max(across(d) * radius - d.z * half),
            Core::Ball(radius) => d.length() * radius,
        };
        if self.radius > 0.0 { core + dir.length() * self.radius } else { core }
    }
}

fn more(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// Four maxima at a time, because each maximum waits for the one before.
fn reach(points: &[DVec3], dir: DVec3) -> f64 {
    let mut greatest = [f64::NEG_INFINITY; 4];
    let (fours, rest) = points.as_chunks::<4>();
    for four in fours {
        for (greatest, p) in greatest.iter_mut().zip(four) {
            *greatest = more(*greatest, p.dot(dir));
        }
    }
    rest.iter().map(|p| p.dot(dir)).chain(greatest).fold(f64::NEG_INFINITY, more)
}

/// Distance from the inside of a right angle: `heights` are those above its planes.
fn to_corner(heights: DVec3) -> f64 {
    let highest = heights.max_element();
    if highest > 0.0 { heights.max(DVec3::ZERO).length() } else { highest }
}

fn to_segment(p: DVec3, q: DVec3, r: DVec3) -> f64 {
    let side = r - q;
    let length_sq = side.length_squared();
    let share = if length_sq > 0.0 { ((p - q).dot(side) / length_sq).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(q + side * share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hullmap::SupportMap;
    use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, Rounded, Scaled, Sphere, Triangle};
    use hullmap_testkit::random::RandomPoses;
    use shapes::rng::SplitMix64;

    /// Support points define a shape independently of its model. Their extent agrees with the
    /// model, and they are on its surface.
    #[test]
    fn models_agree_with_support_mappings() {
        let scale = DVec3::new(2.0, -0.5, 0.75);
        let half = DVec3::new(0.3, 0.5, 0.7);
        let pairs: Vec<(Box<dyn SupportMap>, Model)> = vec![
            (Box::new(Sphere::new(0.7).unwrap()), Model::new(Core::Segment(0.0)).rounded(0.7)),
            (Box::new(Cuboid::new(half).unwrap()), Model::new(Core::Cuboid(half))),
            (Box::new(Capsule::new(0.6, 0.2).unwrap()), Model::new(Core::Segment(0.6)).rounded(0.2)),
            (Box::new(Cylinder::new(0.6, 0.2).unwrap()), Model::new(Core::Cylinder(0.6, 0.2))),
            (Box::new(Cone::new(0.6, 0.4).unwrap()), Model::new(Core::Cone(0.6, 0.4))),
            (Box::new(Cone::new(0.0, 0.4).unwrap()), Model::new(Core::Cone(0.0, 0.4))),
            (Box::new(Cone::new(0.6, 0.0).unwrap()), Model::new(Core::Cone(0.6, 0.0))),
            (Box::new(Triangle::new([half, -half, scale]).unwrap()), Model::of_triangle([half, -half, scale])),
            (
                Box::new(Scaled::new(Cone::new(0.6, 0.4).unwrap(), scale).unwrap()),
                Model::new(Core::Cone(0.6, 0.4)).scaled(scale),
            ),
            (
                Box::new(Scaled::new(Sphere::new(0.7).unwrap(), scale).unwrap()),
                Model::new(Core::Ball(0.7)).scaled(scale),
            ),
            (
                Box::new(Rounded::new(Scaled::new(Cuboid::new(half).unwrap(), scale).unwrap(), 0.1).unwrap()),
                Model::new(Core::Cuboid(half)).scaled(scale).rounded(0.1),
            ),
        ];
        let mut rng = SplitMix64::new(3);
        for (index, (shape, model)) in pairs.iter().enumerate() {
            for _ in 0..500 {
                let dir = rng.unit_vector();
                let point = shape.support_point(dir).point;
                assert!((point.dot(dir) - model.reach(dir)).abs() < 1e-14, "{index} {dir} {point}");
                assert!(model.outside(point) < 1e-14, "{index} {dir} {point} {}", model.outside(point));
                // Beside the corners of a rounded shape, the planes give only a lower bound.
                if index < pairs.len() - 1 {
                    assert!(model.outside(point) > -1e-14, "{index} {dir} {point} {}", model.outside(point));
                    assert!(model.outside(point + dir * 0.01) > 0.0, "{index} {dir}");
                }
                assert!(point.length() <= model.greatest + 1e-14);
                let inner = shape.interior_point();
                assert!(model.outside(inner.lerp(point, 0.9)) < 1e-14, "{index} {dir}");
            }
        }
    }
}
