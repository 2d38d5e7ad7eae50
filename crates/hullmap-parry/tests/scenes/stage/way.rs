//! Which shapes and which dispatcher a scene uses.

use hullmap_parry::HullDispatcher;
use rapier3d::prelude::*;

/// A way of using hulls in Rapier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Way {
    /// parry's own convex polyhedra, of the same points
    Parry,
    /// Baked hulls, parry's default dispatcher
    #[value(name = "baked")]
    Shapes,
    /// Baked hulls, `HullDispatcher`
    Dispatcher,
}

impl Way {
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
