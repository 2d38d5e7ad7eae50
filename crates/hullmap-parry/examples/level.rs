//! A body on a level: rays, casts and contact points, with parry's interface.
//!
//! ```text
//! bake build assets/gear.obj --keep-triangles --out baked
//! cargo run -p hullmap-parry --features dispatcher --example level
//! ```

use std::sync::Arc;

use hullmap::TriangleMesh;
use hullmap_parry::{BakedSurface, HullDispatcher};
use parry3d::math::{Pose, Vector};
use parry3d::query::details::ShapeCastOptions;
use parry3d::query::{ContactManifold, NonlinearRigidMotion, PersistentQueryDispatcher, QueryDispatcher, Ray, RayCast};
use parry3d::shape::{Cuboid, Shape};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let level = BakedSurface::new(Arc::new(TriangleMesh::open("baked/gear.hullmesh")?));
    let bounds = level.compute_local_aabb();
    let (size, middle) = (0.1 * bounds.half_extents().max_element(), bounds.center());
    let above = Vector::new(middle.x + 3.0 * size, middle.y, bounds.maxs.z + 2.0 * size);
    println!("{} triangles in {bounds:?}", level.triangle_count());

    let down = Ray::new(above, -Vector::Z);
    let hit = level.cast_local_ray_and_get_normal(&down, f32::MAX, true).ok_or("nothing is below")?;
    println!("a ray falls by {} onto triangle {}, whose normal is {}", hit.time_of_impact, hit.subshape, hit.normal);

    // A box falls onto the level.
    let (body, start) = (Cuboid::new(Vector::splat(size)), Pose::from_translation(above));
    let options = ShapeCastOptions::default();
    let fall = HullDispatcher.cast_shapes(&start, -Vector::Z, &level, &body, options)?.ok_or("nothing is below")?;
    println!("a box falls by {}", fall.time_of_impact);

    // It has sunk in a little, and has a few points, whatever the number of triangles.
    let landed = Pose::from_translation(above - Vector::Z * (fall.time_of_impact + 1e-3 * size));
    let (mut manifolds, mut workspace) = (Vec::<ContactManifold<(), ()>>::new(), None);
    HullDispatcher.contact_manifolds(&landed, &level, &body, 0.02 * size, &mut manifolds, &mut workspace)?;
    for manifold in &manifolds {
        println!("{} points with the normal {}", manifold.points.len(), manifold.local_n1);
    }

    // It falls and turns: until the time of impact, it certainly does not touch the level.
    let still = NonlinearRigidMotion::constant_position(Pose::IDENTITY);
    let tumbling = NonlinearRigidMotion::new(start, Vector::ZERO, -Vector::Z * size, Vector::new(3.0, 1.0, 0.0));
    let hit = HullDispatcher.cast_shapes_nonlinear(&still, &level, &tumbling, &body, 0.0, 9.0, true)?;
    println!("a tumbling box meets it at {:?}", hit.map(|hit| hit.time_of_impact));
    Ok(())
}
