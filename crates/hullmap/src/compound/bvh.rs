//! BVH nodes of two compounds, and lower bounds on the distance between the hulls below them.

use glam::{DMat3, DVec3};
use hullmap_format::archive::ArchivedBvhNode;
use hullmap_format::height_field::pyramid::{Extent, Pyramid};
use hullmap_format::triangle_mesh::tree;

use crate::height_field::HeightField;
use crate::pose::Pose;
use crate::support::{SupportMap, SupportPoint};
use crate::triangle_mesh::TriangleMesh;

/// Rounding error of a distance between boxes, relative to the largest length, in units of
/// [`f64::EPSILON`]. Two products with a matrix and sums of six terms have an error of about 20
/// units.
const ROUNDING_UNITS: f64 = 64.0;

/// Relative rounding error of a length along a path: of a sum, an inverse and a product.
const TRAVEL_ERROR: f64 = 4.0 * f64::EPSILON;

/// Factor by which a length exceeds another one, whatever its rounding error.
const BEYOND: f64 = 1.0 + 1e-9;

/// A BVH node: its box, in the frame of its compound, and its child.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    center: DVec3,
    half: DVec3,
    pub(super) child: Child,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Child {
    /// A leaf: the part with this index.
    Hull(usize),
    /// An inner node: the nodes at this index and the next.
    Nodes(u32),
    /// No part: an area of a height field that has only holes. The box means nothing.
    Nothing,
}

impl Node {
    #[inline]
    fn new(low: DVec3, high: DVec3, child: Child) -> Self {
        // Exact in f64 up to rounding in the last digit.
        Self { center: (low + high) * 0.5, half: (high - low) * 0.5, child }
    }

    fn archived(node: &ArchivedBvhNode) -> Self {
        let [low, high] =
            [&node.bounds_min, &node.bounds_max].map(|c| DVec3::from_array(c.map(|c| c.to_native().into())));
        let target = node.target.to_native();
        let child = if node.hull_count == 1 { Child::Hull(target as usize) } else { Child::Nodes(target) };
        Self::new(low, high, child)
    }

    /// A node of the tree of a triangle mesh.
    #[inline]
    fn of_mesh(mesh: &TriangleMesh, index: u32) -> Option<Self> {
        let ([low, high], [start, end]) = mesh.node(index)?;
        let child = if end - start == 1 { Child::Hull(start) } else { Child::Nodes(tree::first_child(index)) };
        Some(Self::new(low, high, child))
    }

    /// A node of the tree of a height field.
    fn of_field(field: &HeightField, index: u32) -> Option<Self> {
        let extent = field.extent(index)?;
        let Some([low, high]) = field.bounds_of(index, extent) else {
            return Some(Self::new(DVec3::ZERO, DVec3::ZERO, Child::Nothing));
        };
        let child = match extent {
            Extent::Triangle(triangle) => Child::Hull(triangle),
            Extent::Cells(_) => Child::Nodes(Pyramid::first_child(index)),
        };
        Some(Self::new(low, high, child))
    }

    /// Minimum and maximum of the dot product of `dir` with a point of the box.
    pub(super) fn extent(&self, dir: DVec3) -> [f64; 2] {
        let (center, reach) = (self.center.dot(dir), self.half.dot(dir.abs()));
        [center - reach, center + reach]
    }

    /// Distance of a point from the box; 0 inside.
    pub(super) fn distance(&self, point: DVec3) -> f64 {
        ((point - self.center).abs() - self.half).max(DVec3::ZERO).length()
    }

    /// Length of the diagonal of the box: no part below the node is longer.
    pub(super) fn diagonal(&self) -> f64 {
        2.0 * self.half.length()
    }

    /// Square of half the diagonal of the box.
    pub(super) fn size_sq(&self) -> f64 {
        self.half.length_squared()
    }
}

/// The box of a node as a shape, in the frame of its compound.
pub struct BoxShape(pub(crate) Node);

/// Rounding error of the centre and of the half lengths of a box, relative to both.
const BOX_ERROR: f64 = 4.0 * f64::EPSILON;

impl SupportMap for BoxShape {
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        let half = self.0.half;
        let [x, y, z] = [(half.x, dir.x), (half.y, dir.y), (half.z, dir.z)].map(|(half, dir)| half.copysign(dir));
        SupportPoint { point: self.0.center + DVec3::new(x, y, z), feature: 0 }
    }
    fn interior_point(&self) -> DVec3 {
        self.0.center
    }
    fn inner_radius(&self) -> f64 {
        self.0.half.min_element()
    }
    fn outer_radius(&self) -> f64 {
        self.0.half.length()
    }
    fn support_error(&self) -> f64 {
        BOX_ERROR * (self.0.center.length() + self.0.half.length())
    }
}

/// The BVH of a compound or of a single shape.
#[derive(Clone, Copy, Debug)]
pub struct Nodes<'n> {
    tree: Tree<'n>,
}

#[derive(Clone, Copy, Debug)]
enum Tree<'n> {
    Pack(&'n [ArchivedBvhNode]),
    Mesh(&'n TriangleMesh),
    Field(&'n HeightField),
    One(Node),
}

impl<'n> Nodes<'n> {
    pub(super) fn of_pack(nodes: &'n [ArchivedBvhNode]) -> Self {
        Self { tree: Tree::Pack(nodes) }
    }

    pub(super) fn of_mesh(mesh: &'n TriangleMesh) -> Self {
        Self { tree: Tree::Mesh(mesh) }
    }

    pub(super) fn of_field(field: &'n HeightField) -> Self {
        Self { tree: Tree::Field(field) }
    }

    /// The height field whose tree this is.
    pub(super) fn field(&self) -> Option<&'n HeightField> {
        if let Tree::Field(field) = self.tree { Some(field) } else { None }
    }

    /// The triangle mesh whose tree this is.
    pub(super) fn mesh(&self) -> Option<&'n TriangleMesh> {
        if let Tree::Mesh(mesh) = self.tree { Some(mesh) } else { None }
    }

    /// The BVH of one part with this bounding box.
    pub(super) fn one(low: DVec3, high: DVec3) -> Self {
        Self { tree: Tree::One(Node::new(low, high, Child::Hull(0))) }
    }

    #[inline]
    pub(super) fn get(&self, index: u32) -> Option<Node> {
        match self.tree {
            Tree::Pack(nodes) => nodes.get(index as usize).map(Node::archived),
            Tree::Mesh(mesh) => Node::of_mesh(mesh, index),
            Tree::Field(field) => Node::of_field(field, index),
            Tree::One(node) => (index == 0).then_some(node),
        }
    }

    /// Number of nodes, or more.
    pub(super) fn count(&self) -> usize {
        match self.tree {
            Tree::Mesh(mesh) => mesh.node_bound(),
            Tree::Field(field) => field.node_bound(),
            Tree::Pack(nodes) => nodes.len(),
            Tree::One(_) => 1,
        }
    }

    /// Centre and radius of a ball around all parts.
    pub(super) fn ball(&self) -> (DVec3, f64) {
        self.get(0).map_or((DVec3::ZERO, 0.0), |root| (root.center, root.half.length()))
    }

    /// Length of the diagonal of the box around all parts: no part is longer.
    pub(super) fn diagonal(&self) -> f64 {
        self.get(0).map_or(0.0, |root| root.diagonal())
    }
}

/// Two compounds and their relative pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement<'q> {
    pub(super) a: Nodes<'q>,
    pub(super) b: Nodes<'q>,
    b_in_a: Pose,
    rotation: DMat3,
    abs_rotation: DMat3,
    /// Bound on the rounding error of a distance between boxes.
    rounding_error: f64,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedBox {
    /// Half the lengths of its sides.
    half: DVec3,
    /// Its centre, in A's frame.
    center: DVec3,
    /// Half the lengths of the sides of the box around it along A's axes.
    around: DVec3,
}

impl PlacedBox {
    pub(super) fn is_point(&self) -> bool {
        !(self.half.length_squared() > 0.0)
    }

    /// Squared distance between the centres of two boxes, which orders pairs with equal lower
    /// bounds.
    #[inline]
    pub(super) fn center_distance_sq(&self, a: &Node) -> f64 {
        self.center.distance_squared(a.center)
    }
}

impl<'q> Placement<'q> {
    pub(super) fn new(a: Nodes<'q>, b: Nodes<'q>, b_in_a: Pose) -> Self {
        let rotation = b_in_a.rotation_matrix();
        let abs_rotation = DMat3::from_cols(rotation.x_axis.abs(), rotation.y_axis.abs(), rotation.z_axis.abs());
        let reach = |nodes: Nodes| nodes.get(0).map_or(0.0, |root| root.center.length() + root.half.length());
        let largest = reach(a) + reach(b) + b_in_a.translation().length();
        // The centre and the half diagonal of a descendant together are at most twice the centre
        // and half diagonal of the root.
        let rounding_error = 2.0 * ROUNDING_UNITS * f64::EPSILON * largest;
        Self { a, b, b_in_a, rotation, abs_rotation, rounding_error }
    }

    pub(super) fn placed(&self, b: &Node) -> PlacedBox {
        let center = self.b_in_a.transform_point(b.center);
        PlacedBox { half: b.half, center, around: self.abs_rotation * b.half }
    }

    /// Bound on the rounding error of a coordinate of a box.
    pub(super) fn rounding_error(&self) -> f64 {
        self.rounding_error
    }

    /// Lower bound on the distance between two boxes, reduced by the rounding error; 0 if they may
    /// overlap.
    ///
    /// Computes the distance from A's box to the bounding box of B's along A's axes, and the same
    /// with A and B exchanged, and returns the larger one; the first if that exceeds `reach`.
    #[inline]
    pub(super) fn distance_lower_bound(&self, a: &Node, b: &PlacedBox, reach: f64) -> f64 {
        let square = |gap: DVec3| gap.max(DVec3::ZERO).length_squared();
        let between = b.center - a.center;
        let in_a = square(between.abs() - a.half - b.around);
        let enough = (reach + self.rounding_error) * BEYOND;
        let in_b = if in_a > enough * enough {
            0.0
        } else {
            square((self.rotation.transpose() * between).abs() - b.half - self.abs_rotation.transpose() * a.half)
        };
        (in_a.max(in_b).sqrt() - self.rounding_error).max(0.0)
    }

    /// Lower bound on the length that B's box moves along a unit vector until it meets A's:
    /// infinite if it never does. `inverse` has the inverses of the vector's components.
    ///
    /// The box around B's box along A's axes moves through A's box, grown by half of that box.
    pub(super) fn travel_lower_bound(&self, a: &Node, b: &PlacedBox, inverse: DVec3) -> f64 {
        let between = b.center - a.center;
        let reach = a.half + b.around + DVec3::splat(self.rounding_error);
        let [p, q] = [(-between - reach) * inverse, (reach - between) * inverse];
        // Along an axis without motion both are infinite, of the same sign outside.
        let (enter, leave) = (p.min(q).max_element().max(0.0), p.max(q).min_element());
        if enter * (1.0 - TRAVEL_ERROR) > leave * (1.0 + TRAVEL_ERROR) {
            f64::INFINITY
        } else {
            enter * (1.0 - TRAVEL_ERROR)
        }
    }
}
