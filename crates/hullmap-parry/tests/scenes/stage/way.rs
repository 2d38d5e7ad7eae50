//! Which shapes and which dispatcher a scene uses.

use hullmap_parry::HullDispatcher;
use rapier3d::prelude::*;

/// A way of using hulls in Rapier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// parry's `convex_hull` of the same points.
    Parry,
    /// Baked hulls with parry's default dispatcher.
    Shapes,
    /// Baked hulls with `HullDispatcher`.
    Dispatcher,
}

impl Way {
    /// Name for messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Parry => "parry",
            Self::Shapes => "A",
            Self::Dispatcher => "B",
        }
    }

    /// An empty world with gravity along −y.
    pub fn world(self) -> PhysicsWorld {
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::new(0.0, -9.81, 0.0);
        if self == Self::Dispatcher {
            world.narrow_phase = NarrowPhase::with_query_dispatcher(HullDispatcher);
        }
        world
    }
}
