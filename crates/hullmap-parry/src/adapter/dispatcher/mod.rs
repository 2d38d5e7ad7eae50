//! `HullDispatcher`: parry's queries, solved by hullmap for pairs with a baked hull or a surface.
//!
//! | module | concept |
//! |---|---|
//! | `pair`, `primitive`, `pieces` | which of parry's shapes hullmap solves |
//! | `split` | which of parry's shapes parry splits into parts |
//! | `cast`, `motion` | casts of a pair |
//! | `persistent` | parry's `contact_manifolds`, which keeps manifolds from step to step |
//! | `memory`, `manifold` | what a pair keeps, and its manifold |
//! | `part_dispatcher`, `compound_union`, `patches` | parts of compounds |
//! | `surface_pair`, `surface_cast`, `surface_manifold`, `nearby` | triangle meshes and height fields |

mod cast;
mod compound_union;
mod manifold;
mod memory;
mod motion;
mod nearby;
mod pair;
mod part_dispatcher;
mod patches;
mod persistent;
mod pieces;
mod primitive;
mod split;
mod surface_cast;
mod surface_manifold;
mod surface_pair;

use hullmap::Distance;

use super::BakedHull;
use super::convert::real;
use super::parry::math::{Pose, Real, Vector};
use super::parry::query::details as default;
use super::parry::query::{
    ClosestPoints, Contact, DefaultQueryDispatcher, NonlinearRigidMotion, QueryDispatcher, ShapeCastHit,
    ShapeCastOptions, ShapeDistance, ShapeIntersection, Unsupported,
};
use super::parry::shape::Shape;
use pair::{Placement, closest_points, hull_pair};
use split::Split::{Composite, Field, Voxels};
use split::split;
use surface_pair::surface_pair;

/// parry's query dispatcher, with hullmap's solver and manifolds for pairs that have a
/// [`BakedHull`] or a [`BakedSurface`](super::BakedSurface).
///
/// hullmap solves a hull against a hull, ball, capsule, cone, cuboid, cylinder, segment or
/// triangle, and against parry's rounded versions of these. parry splits compounds, triangle
/// meshes, height fields and voxels into their parts, and hullmap solves the parts. All other pairs
/// go to parry's [`DefaultQueryDispatcher`], and so do half-spaces, for which parry has a closed
/// form. Contact manifolds with half-spaces are hullmap's.
///
/// hullmap solves a surface against a hull, one of these primitives, or a compound of them. Against
/// other shapes, parry splits the surface into its triangles.
///
/// Casts with rotation are hullmap's for these shapes, for compounds of them, and for half-spaces:
/// [`cast_motion`](hullmap::cast_motion()). The time is the lower end of a proven interval, rounded
/// down: until then, the shapes certainly do not meet, and no body passes through another. Its
/// status is `Converged` if they are then within the tolerance, 1e-6 of the sum of their radii;
/// `OutOfIterations` after 200 queries of a pair, or 4,000 of a tile of a surface, and `Failed`
/// after rounding error: then it is unknown whether they meet. For shapes that meet at the start
/// and must not stop there, parry's rule decides.
///
/// In Rapier, set it once:
///
/// ```ignore
/// let narrow_phase = NarrowPhase::with_query_dispatcher(HullDispatcher);
/// ```
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/../hullmap/doc/rock.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = std::sync::Arc::new(pack());
/// use hullmap_parry::{BakedHull, HullDispatcher};
/// use parry3d::math::{Pose, Vector};
/// use parry3d::query::{ContactManifold, PersistentQueryDispatcher, QueryDispatcher};
/// use parry3d::shape::Cuboid;
///
/// let cube = BakedHull::new(pack.shared_hull_named("cube")?);
/// let floor = Cuboid::new(Vector::new(5.0, 5.0, 1.0));
/// let cube_in_floor = Pose::translation(0.0, 0.0, 1.99);
///
/// let contact = HullDispatcher.contact(&cube_in_floor, &floor, &cube, 0.0)?.ok_or("no contact")?;
/// assert!((contact.dist + 0.01).abs() < 1e-6 && contact.normal1.z > 0.999);
///
/// let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();
/// let mut workspace = None;
/// HullDispatcher.contact_manifolds(
///     &cube_in_floor, &floor, &cube, 0.02, &mut manifolds, &mut workspace)?;
/// assert_eq!(manifolds[0].points.len(), 4);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HullDispatcher;

impl QueryDispatcher for HullDispatcher {
    fn intersection_test(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
    ) -> Result<ShapeIntersection, Unsupported> {
        if let Some(pair) = hull_pair(pos12, shape1, shape2) {
            return Ok(pair.intersects().into());
        }
        if let Some(pair) = surface_pair(pos12, shape1, shape2) {
            return Ok(pair.intersects().into());
        }
        Ok(match split(shape1, shape2) {
            [Composite(a), _] => default::intersection_test_composite_shape_shape(self, pos12, a, shape2),
            [_, Composite(b)] => default::intersection_test_shape_composite_shape(self, pos12, shape1, b),
            [Voxels(a), _] => default::intersection_test_voxels_shape(self, pos12, a, shape2),
            [_, Voxels(b)] => default::intersection_test_shape_voxels(self, pos12, shape1, b),
            _ => return DefaultQueryDispatcher.intersection_test(pos12, shape1, shape2),
        })
    }

    fn distance(&self, pos12: &Pose, shape1: &dyn Shape, shape2: &dyn Shape) -> Result<ShapeDistance, Unsupported> {
        if let Some((found, _)) = solved_distance(pos12, shape1, shape2) {
            return Ok(real(found.distance).into());
        }
        Ok(match split(shape1, shape2) {
            [Composite(a), _] => default::distance_composite_shape_shape(self, pos12, a, shape2),
            [_, Composite(b)] => default::distance_shape_composite_shape(self, pos12, shape1, b),
            _ => return DefaultQueryDispatcher.distance(pos12, shape1, shape2),
        })
    }

    fn contact(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        prediction: Real,
    ) -> Result<Option<Contact>, Unsupported> {
        if let Some(pair) = hull_pair(pos12, shape1, shape2) {
            return Ok(pair.nearest().contact(&pair.placement, prediction));
        }
        if let Some(pair) = surface_pair(pos12, shape1, shape2)
            && let Some((found, _)) = pair.nearest()
        {
            return Ok(found.contact(&pair.placement, prediction));
        }
        Ok(match split(shape1, shape2) {
            [Field(a), _] => default::contact_heightfield_shape(self, pos12, a, shape2, prediction),
            [_, Field(b)] => default::contact_shape_heightfield(self, pos12, shape1, b, prediction),
            [Composite(a), _] => default::contact_composite_shape_shape(self, pos12, a, shape2, prediction),
            [_, Composite(b)] => default::contact_shape_composite_shape(self, pos12, shape1, b, prediction),
            _ => return DefaultQueryDispatcher.contact(pos12, shape1, shape2, prediction),
        })
    }

    fn closest_points(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        max_dist: Real,
    ) -> Result<ClosestPoints, Unsupported> {
        if let Some((found, placement)) = solved_distance(pos12, shape1, shape2) {
            return Ok(closest_points(&found, &placement, max_dist));
        }
        Ok(match split(shape1, shape2) {
            [Composite(a), _] => default::closest_points_composite_shape_shape(self, pos12, a, shape2, max_dist),
            [_, Composite(b)] => default::closest_points_shape_composite_shape(self, pos12, shape1, b, max_dist),
            _ => return DefaultQueryDispatcher.closest_points(pos12, shape1, shape2, max_dist),
        })
    }

    fn cast_shapes(
        &self,
        pos12: &Pose,
        velocity: Vector,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        options: ShapeCastOptions,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        if let Some(pair) = hull_pair(pos12, shape1, shape2)
            && let Some(answer) = cast::cast(&pair, velocity, &options)
        {
            return Ok(answer);
        }
        if let Some(pair) = surface_pair(pos12, shape1, shape2)
            && let Some(answer) = surface_cast::cast(&pair, velocity, &options)
        {
            return Ok(answer);
        }
        Ok(match split(shape1, shape2) {
            [Field(a), _] => default::cast_shapes_heightfield_shape(self, pos12, velocity, a, shape2, options)?,
            [_, Field(b)] => default::cast_shapes_shape_heightfield(self, pos12, velocity, shape1, b, options)?,
            [Composite(a), _] => default::cast_shapes_composite_shape_shape(self, pos12, velocity, a, shape2, options),
            [_, Composite(b)] => default::cast_shapes_shape_composite_shape(self, pos12, velocity, shape1, b, options),
            [Voxels(a), _] => default::cast_shapes_voxels_shape(self, pos12, velocity, a, shape2, options),
            [_, Voxels(b)] => default::cast_shapes_shape_voxels(self, pos12, velocity, shape1, b, options),
            _ => return DefaultQueryDispatcher.cast_shapes(pos12, velocity, shape1, shape2, options),
        })
    }

    /// hullmap solves convex shapes that it supports, compounds of them, surfaces and half-spaces.
    /// The time is the lower end of a proven interval: before it, the shapes certainly do not meet.
    fn cast_shapes_nonlinear(
        &self,
        motion1: &NonlinearRigidMotion,
        shape1: &dyn Shape,
        motion2: &NonlinearRigidMotion,
        shape2: &dyn Shape,
        start: Real,
        end: Real,
        stop: bool,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        use default::{
            cast_shapes_nonlinear_composite_shape_shape as of_composite,
            cast_shapes_nonlinear_shape_composite_shape as onto_composite,
        };
        if let Some(answer) = motion::cast(self, [(shape1, motion1), (shape2, motion2)], [start, end], stop) {
            return Ok(answer);
        }
        Ok(match split(shape1, shape2) {
            [Composite(a), _] => of_composite(self, motion1, a, motion2, shape2, start, end, stop),
            [_, Composite(b)] => onto_composite(self, motion1, shape1, motion2, b, start, end, stop),
            _ => DefaultQueryDispatcher.cast_shapes_nonlinear(motion1, shape1, motion2, shape2, start, end, stop)?,
        })
    }
}

/// The distance of a pair that hullmap solves, in A's frame.
fn solved_distance(pos12: &Pose, shape1: &dyn Shape, shape2: &dyn Shape) -> Option<(Distance, Placement)> {
    if let Some(pair) = hull_pair(pos12, shape1, shape2) {
        return Some((pair.distance(), pair.placement));
    }
    let pair = surface_pair(pos12, shape1, shape2)?;
    Some((pair.distance()?.0, pair.placement))
}
