//! Nodes of two trees, one of them placed: how near the hulls below can be.

use glam::{DMat3, DVec3};
use hullmap_format::archive::ArchivedBvhNode;

use super::{Compound, Members};
use crate::Pose;

/// By how many units of rounding of the greatest length a box distance is taken for less: two products with a matrix and sums of six
/// terms come to about 20.
const ROUNDING_UNITS: f64 = 64.0;

/// A node: its box in its compound's frame, and what is below.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    center: DVec3,
    half: DVec3,
    pub(super) below: Below,
}

/// What a node leads to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Below {
    /// A hull.
    Hull(usize),
    /// Two nodes, by the number of the first.
    Nodes(u32),
}

impl Node {
    fn new(low: DVec3, high: DVec3, below: Below) -> Self {
        // Exact in f64, but for the last digit of a half.
        Self { center: (low + high) * 0.5, half: (high - low) * 0.5, below }
    }

    /// Node `number` of a compound; `None` past the last one.
    pub(super) fn of(compound: &Compound, number: u32) -> Option<Self> {
        match compound.members {
            Members::Pack(pack) => pack.nodes().get(number as usize).map(Self::archived),
            Members::One(hull) => {
                let [low, high] = hull.bounds().map(|corner| corner.as_dvec3());
                (number == 0).then(|| Self::new(low, high, Below::Hull(0)))
            }
        }
    }

    fn archived(node: &ArchivedBvhNode) -> Self {
        let [low, high] =
            [&node.bounds_min, &node.bounds_max].map(|c| DVec3::from_array(c.map(|c| c.to_native().into())));
        let target = node.target.to_native();
        let below = if node.hull_count == 1 { Below::Hull(target as usize) } else { Below::Nodes(target) };
        Self::new(low, high, below)
    }

    /// Square of half the box's diagonal.
    pub(super) fn size_sq(&self) -> f64 {
        self.half.length_squared()
    }
}

/// Two compounds, one placed in the frame of the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement<'q, 'a> {
    pub(super) a: &'q Compound<'a>,
    pub(super) b: &'q Compound<'a>,
    b_in_a: Pose,
    turn: DMat3,
    /// Magnitudes of the turn's entries.
    size: DMat3,
    rounding: f64,
}

impl<'q, 'a> Placement<'q, 'a> {
    pub(super) fn new(a: &'q Compound<'a>, b: &'q Compound<'a>, b_in_a: Pose) -> Self {
        let turn = b_in_a.rotation_matrix();
        let size = DMat3::from_cols(turn.x_axis.abs(), turn.y_axis.abs(), turn.z_axis.abs());
        let reach = |compound| Node::of(compound, 0).map_or(0.0, |root| root.center.length() + root.half.length());
        let greatest = reach(a) + reach(b) + b_in_a.translation().length();
        // Lengths of boxes below are within twice those of the root.
        let rounding = 2.0 * ROUNDING_UNITS * f64::EPSILON * greatest;
        Self { a, b, b_in_a, turn, size, rounding }
    }

    /// No point of `a`'s box is nearer to one of `b`'s than this, rounding included; 0 where they may overlap.
    ///
    /// The greater of two distances: of `a`'s box to the box around `b`'s along the same axes, and the other way round.
    pub(super) fn least_distance(&self, a: &Node, b: &Node) -> f64 {
        let between = self.b_in_a.transform_point(b.center) - a.center;
        let in_a = between.abs() - a.half - self.size * b.half;
        let in_b = (self.turn.transpose() * between).abs() - b.half - self.size.transpose() * a.half;
        let length = |gap: DVec3| gap.max(DVec3::ZERO).length();
        (length(in_a).max(length(in_b)) - self.rounding).max(0.0)
    }

    /// Square of the distance of the boxes' middles: what is near by it is looked at first.
    pub(super) fn middles_sq(&self, a: &Node, b: &Node) -> f64 {
        (self.b_in_a.transform_point(b.center)).distance_squared(a.center)
    }
}
