//! `HullDispatcher`: parry's queries, solved by hullmap for pairs with a baked hull or a surface.
//!
//! | module | concept |
//! |---|---|
//! | `pair`, `primitive`, `pieces` | which of parry's shapes hullmap solves |
//! | `nearest`, `cast`, `motion` | contacts, closest points, and casts of a pair |
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
mod nearest;
mod pair;
mod part_dispatcher;
mod patches;
mod persistent;
mod pieces;
mod primitive;
mod surface_cast;
mod surface_manifold;
mod surface_pair;

use hullmap::{Cache, Settings};

use super::BakedHull;
use super::convert::real;
use super::parry::math::{Pose, Real, Vector};
use super::parry::query::details as default;
use super::parry::query::{
    ClosestPoints, Contact, DefaultQueryDispatcher, NonlinearRigidMotion, QueryDispatcher, ShapeCastHit,
    ShapeCastOptions, ShapeDistance, ShapeIntersection, Unsupported,
};
use super::parry::shape::Shape;
use nearest::contact_of;
use pair::{HullPair, closest_points, on_pair, pair};
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
        if let Some((pair, placement)) = pair(pos12, shape1, shape2) {
            let found = on_pair!(pair, a, b => hullmap::intersects(a, b, placement.b_in_a, &mut Cache::new()));
            return Ok(found.is_hit().into());
        }
        if let Some(pair) = surface_pair(pos12, shape1, shape2) {
            return Ok(pair.intersects().into());
        }
        if let Some(composite) = shape1.as_composite_shape() {
            return Ok(default::intersection_test_composite_shape_shape(self, pos12, composite, shape2));
        }
        if let Some(composite) = shape2.as_composite_shape() {
            return Ok(default::intersection_test_shape_composite_shape(self, pos12, shape1, composite));
        }
        if let Some(voxels) = shape1.as_voxels() {
            return Ok(default::intersection_test_voxels_shape(self, pos12, voxels, shape2));
        }
        if let Some(voxels) = shape2.as_voxels() {
            return Ok(default::intersection_test_shape_voxels(self, pos12, shape1, voxels));
        }
        DefaultQueryDispatcher.intersection_test(pos12, shape1, shape2)
    }

    fn distance(&self, pos12: &Pose, shape1: &dyn Shape, shape2: &dyn Shape) -> Result<ShapeDistance, Unsupported> {
        if let Some((pair, placement)) = pair(pos12, shape1, shape2) {
            let settings = Settings::default();
            let found = on_pair!(pair, a, b => hullmap::distance(a, b, placement.b_in_a, &settings, &mut Cache::new()));
            return Ok(real(found.distance).into());
        }
        if let Some((found, _)) = surface_pair(pos12, shape1, shape2).and_then(|pair| pair.distance()) {
            return Ok(real(found.distance).into());
        }
        if let Some(composite) = shape1.as_composite_shape() {
            return Ok(default::distance_composite_shape_shape(self, pos12, composite, shape2));
        }
        if let Some(composite) = shape2.as_composite_shape() {
            return Ok(default::distance_shape_composite_shape(self, pos12, shape1, composite));
        }
        DefaultQueryDispatcher.distance(pos12, shape1, shape2)
    }

    fn contact(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        prediction: Real,
    ) -> Result<Option<Contact>, Unsupported> {
        if let Some((pair, placement)) = pair(pos12, shape1, shape2) {
            return Ok(contact_of(&pair, &placement, &Settings::default()).contact(&placement, prediction));
        }
        if let Some(pair) = surface_pair(pos12, shape1, shape2)
            && let Some((found, _)) = pair.nearest()
        {
            return Ok(found.contact(&pair.placement, prediction));
        }
        if let Some(field) = shape1.as_heightfield() {
            return Ok(default::contact_heightfield_shape(self, pos12, field, shape2, prediction));
        }
        if let Some(field) = shape2.as_heightfield() {
            return Ok(default::contact_shape_heightfield(self, pos12, shape1, field, prediction));
        }
        if let Some(composite) = shape1.as_composite_shape() {
            return Ok(default::contact_composite_shape_shape(self, pos12, composite, shape2, prediction));
        }
        if let Some(composite) = shape2.as_composite_shape() {
            return Ok(default::contact_shape_composite_shape(self, pos12, shape1, composite, prediction));
        }
        DefaultQueryDispatcher.contact(pos12, shape1, shape2, prediction)
    }

    fn closest_points(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        max_dist: Real,
    ) -> Result<ClosestPoints, Unsupported> {
        if let Some((pair, placement)) = pair(pos12, shape1, shape2) {
            let settings = Settings::default();
            let found = on_pair!(pair, a, b => hullmap::distance(a, b, placement.b_in_a, &settings, &mut Cache::new()));
            return Ok(closest_points(&found, &placement, max_dist));
        }
        if let Some(pair) = surface_pair(pos12, shape1, shape2)
            && let Some((found, _)) = pair.distance()
        {
            return Ok(closest_points(&found, &pair.placement, max_dist));
        }
        if let Some(composite) = shape1.as_composite_shape() {
            return Ok(default::closest_points_composite_shape_shape(self, pos12, composite, shape2, max_dist));
        }
        if let Some(composite) = shape2.as_composite_shape() {
            return Ok(default::closest_points_shape_composite_shape(self, pos12, shape1, composite, max_dist));
        }
        DefaultQueryDispatcher.closest_points(pos12, shape1, shape2, max_dist)
    }

    fn cast_shapes(
        &self,
        pos12: &Pose,
        local_vel12: Vector,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        options: ShapeCastOptions,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        if let Some(found) = pair(pos12, shape1, shape2)
            && let Some(answer) = cast::cast(&found, local_vel12, &options)
        {
            return Ok(answer);
        }
        if let Some(pair) = surface_pair(pos12, shape1, shape2)
            && let Some(answer) = surface_cast::cast(&pair, local_vel12, &options)
        {
            return Ok(answer);
        }
        if let Some(field) = shape1.as_heightfield() {
            return default::cast_shapes_heightfield_shape(self, pos12, local_vel12, field, shape2, options);
        }
        if let Some(field) = shape2.as_heightfield() {
            return default::cast_shapes_shape_heightfield(self, pos12, local_vel12, shape1, field, options);
        }
        if let Some(composite) = shape1.as_composite_shape() {
            return Ok(default::cast_shapes_composite_shape_shape(
                self,
                pos12,
                local_vel12,
                composite,
                shape2,
                options,
            ));
        }
        if let Some(composite) = shape2.as_composite_shape() {
            return Ok(default::cast_shapes_shape_composite_shape(
                self,
                pos12,
                local_vel12,
                shape1,
                composite,
                options,
            ));
        }
        if let Some(voxels) = shape1.as_voxels() {
            return Ok(default::cast_shapes_voxels_shape(self, pos12, local_vel12, voxels, shape2, options));
        }
        if let Some(voxels) = shape2.as_voxels() {
            return Ok(default::cast_shapes_shape_voxels(self, pos12, local_vel12, shape1, voxels, options));
        }
        DefaultQueryDispatcher.cast_shapes(pos12, local_vel12, shape1, shape2, options)
    }

    /// hullmap solves convex shapes that it supports, compounds of them, surfaces and half-spaces.
    /// The time is the lower end of a proven interval: before it, the shapes certainly do not meet.
    fn cast_shapes_nonlinear(
        &self,
        motion1: &NonlinearRigidMotion,
        shape1: &dyn Shape,
        motion2: &NonlinearRigidMotion,
        shape2: &dyn Shape,
        start_time: Real,
        end_time: Real,
        stop_at_penetration: bool,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        let window = [start_time, end_time];
        if let Some(answer) = motion::cast(self, [(shape1, motion1), (shape2, motion2)], window, stop_at_penetration) {
            return Ok(answer);
        }
        let (composite1, composite2) = (shape1.as_composite_shape(), shape2.as_composite_shape());
        Ok(match (composite1, composite2) {
            (Some(composite), _) => default::cast_shapes_nonlinear_composite_shape_shape(
                self,
                motion1,
                composite,
                motion2,
                shape2,
                start_time,
                end_time,
                stop_at_penetration,
            ),
            (None, Some(composite)) => default::cast_shapes_nonlinear_shape_composite_shape(
                self,
                motion1,
                shape1,
                motion2,
                composite,
                start_time,
                end_time,
                stop_at_penetration,
            ),
            (None, None) => DefaultQueryDispatcher.cast_shapes_nonlinear(
                motion1,
                shape1,
                motion2,
                shape2,
                start_time,
                end_time,
                stop_at_penetration,
            )?,
        })
    }
}
