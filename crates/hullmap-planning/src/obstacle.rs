//! Obstacles: shapes that a robot must not touch.

use glam::DVec3;
use hullmap::{Pose, SharedGeometry};
use hullmap_robot::Frame;

/// An obstacle at a fixed pose.
#[derive(Clone)]
pub struct Obstacle {
    /// Its name, which no other obstacle and no link has.
    pub name: String,
    /// Its shape. The inside of a triangle mesh, and the space below a height field, are free.
    pub shape: SharedGeometry,
    /// Its pose in the world.
    pub pose: Pose,
}

#[derive(Clone)]
pub(crate) struct Placed {
    pub(crate) obstacle: Obstacle,
    pub(crate) frame: Frame,
    /// Minimum and maximum of its coordinates in its own frame; `None` for a half-space.
    bounds: Option<[DVec3; 2]>,
    /// The greatest length from which positions are computed.
    pub(crate) length: f64,
}

impl Placed {
    pub(crate) fn new(obstacle: Obstacle) -> Self {
        let bounds = obstacle.shape.bounds_under(Pose::IDENTITY).map(|bounds| [bounds.min, bounds.max]);
        let extent = match &obstacle.shape {
            SharedGeometry::HalfSpace(plane) => plane.offset().abs(),
            _ => bounds.map_or(0.0, |[min, max]| min.abs().max(max.abs()).length()),
        };
        let frame = Frame { rotation: obstacle.pose.rotation(), translation: obstacle.pose.translation() };
        Self { length: extent + frame.translation.length(), obstacle, frame, bounds }
    }

    /// Lower bound of the distance of the obstacle from a ball, up to rounding errors. Negative if
    /// they may overlap.
    pub(crate) fn gap(&self, centre: DVec3, radius: f64) -> f64 {
        let local = self.frame.rotation.conjugate() * (centre - self.frame.translation);
        match (&self.obstacle.shape, self.bounds) {
            (SharedGeometry::HalfSpace(plane), _) => plane.normal().dot(local) - plane.offset() - radius,
            (_, Some([min, max])) => local.distance(local.clamp(min, max)) - radius,
            _ => f64::NEG_INFINITY,
        }
    }
}
