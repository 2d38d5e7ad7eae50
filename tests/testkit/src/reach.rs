//! Reach: the support function of a shape, by its definition; and the way out of a pair, the reach
//! of the Minkowski difference.

use glam::{DMat3, DVec3};
use hullmap::{Hull, Pose};

/// A shape by its support function.
pub trait Reach {
    /// The maximum of the dot product of a point of the shape with `dir`, in the shape's frame.
    fn reach(&self, dir: DVec3) -> f64;
}

impl<R: Reach + ?Sized> Reach for &R {
    fn reach(&self, dir: DVec3) -> f64 {
        (**self).reach(dir)
    }
}

/// The convex hull of points.
impl Reach for [DVec3] {
    fn reach(&self, dir: DVec3) -> f64 {
        self.iter().map(|p| p.dot(dir)).fold(f64::NEG_INFINITY, f64::max)
    }
}

impl Reach for Hull<'_> {
    fn reach(&self, dir: DVec3) -> f64 {
        self.vertices().map(|v| v.as_dvec3().dot(dir)).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// A shape at a pose: B in A's frame.
#[derive(Clone, Copy, Debug)]
pub struct Placed<R> {
    shape: R,
    /// Maps directions from A's frame to the shape's own frame.
    unturn: DMat3,
    shift: DVec3,
}

impl<R: Reach> Placed<R> {
    /// `shape` at the pose `b_in_a`, which maps its frame to the frame of the directions.
    pub fn new(shape: R, b_in_a: Pose) -> Self {
        let unturn = DMat3::from_quat(b_in_a.rotation()).transpose();
        Self { shape, unturn, shift: b_in_a.translation() }
    }
}

impl<R: Reach> Reach for Placed<R> {
    fn reach(&self, dir: DVec3) -> f64 {
        self.shape.reach(self.unturn * dir) + dir.dot(self.shift)
    }
}

/// The length by which B has to move along the unit vector `n` to be out of A; negative if `n`
/// separates them. Both are in one frame.
///
/// For every `n` this is an upper bound of the penetration depth, and its negative a lower bound of
/// the distance.
pub fn way_out(a: &(impl Reach + ?Sized), b: &(impl Reach + ?Sized), n: DVec3) -> f64 {
    a.reach(n) + b.reach(-n)
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;

    /// Two cubes of edge 2, the second rotated by a quarter turn and moved by (1.75, 0, 0).
    #[test]
    fn the_way_out_of_two_cubes() {
        let corners: Vec<DVec3> = (0..8)
            .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 2.0 - DVec3::ONE)
            .collect();
        let quarter = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2);
        let b = Placed::new(&corners[..], Pose::new(DVec3::X * 1.75, quarter).unwrap());
        let close = |way: f64, expected: f64| (way - expected).abs() < 1e-15;
        assert!(close(way_out(&corners[..], &b, DVec3::X), 0.25));
        assert!(close(way_out(&corners[..], &b, DVec3::NEG_X), 3.75));
        assert!(close(way_out(&corners[..], &b, DVec3::Y), 2.0));
        let beyond = Placed::new(&corners[..], Pose::from_translation(DVec3::X * 3.0).unwrap());
        assert!(close(way_out(&corners[..], &beyond, DVec3::X), -1.0));
    }
}
