//! Obstacles: shapes that a robot must not touch.

use std::sync::Arc;

use glam::DVec3;
use hullmap::compound::SharedSheet;
use hullmap::shapes::HalfSpace;
use hullmap::{Compound, Pack, Pose};
use hullmap_robot::Frame;

use crate::convex::Convex;

/// The shape of an obstacle.
#[derive(Clone)]
pub enum ObstacleShape {
    /// A hull or a primitive.
    Convex(Convex),
    /// The union of all hulls of a pack.
    Compound(Arc<Pack>),
    /// A triangle mesh or a height field, which has no inside.
    Sheet(SharedSheet),
    /// A half-space.
    HalfSpace(HalfSpace),
}

/// An obstacle at a fixed pose.
#[derive(Clone)]
pub struct Obstacle {
    /// Its name, which no other obstacle and no link has.
    pub name: String,
    /// Its shape.
    pub shape: ObstacleShape,
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
        let bounds = match &obstacle.shape {
            ObstacleShape::Convex(convex) => {
                let bounds = convex.shape().bounds_under(Pose::IDENTITY);
                Some([bounds.min, bounds.max])
            }
            ObstacleShape::Compound(pack) => {
                let hulls = Compound::new(pack);
                let own = (0..hulls.hull_count()).filter_map(|hull| Some(hulls.hull(hull)?.bounds()));
                let start = [DVec3::INFINITY, DVec3::NEG_INFINITY];
                Some(own.fold(start, |[min, max], [low, high]| [min.min(low.as_dvec3()), max.max(high.as_dvec3())]))
            }
            ObstacleShape::Sheet(SharedSheet::Mesh(mesh)) => Some(mesh.bounds().map(|corner| corner.as_dvec3())),
            ObstacleShape::Sheet(SharedSheet::Field(field)) => Some(field.bounds()),
            ObstacleShape::HalfSpace(_) => None,
        };
        let extent = match &obstacle.shape {
            ObstacleShape::HalfSpace(plane) => plane.offset().abs(),
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
            (ObstacleShape::HalfSpace(plane), _) => plane.normal().dot(local) - plane.offset() - radius,
            (_, Some([min, max])) => local.distance(local.clamp(min, max)) - radius,
            _ => f64::NEG_INFINITY,
        }
    }
}
