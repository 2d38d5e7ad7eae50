//! Prints the steps of one body.
use hullmap_scenes::{floor::Floor, model::mesh, rest::rotations, way::Way};
use rapier3d::prelude::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let size: f32 = a[2].parse().unwrap();
    let model = mesh(a[1].as_ref(), size).unwrap();
    let rotation = rotations(1, 6)[a[3].parse::<usize>().unwrap()];
    let way = Way::ALL.into_iter().find(|w| w.name() == a[4]).unwrap();
    let floor = Floor::ALL.into_iter().find(|f| f.name() == a[5]).unwrap();
    let (from, to): (u32, u32) = (a[6].parse().unwrap(), a[7].parse().unwrap());
    let mut world = way.world();
    world.insert_collider(floor.collider(way), None);
    let height = model.depth_below_origin(rotation) + 0.5 * size;
    let body = RigidBodyBuilder::dynamic().pose(Pose::from_parts(Vector::new(0.31, height, 0.17), rotation));
    let (body, _) = world.insert(body, ColliderBuilder::new(model.shape(way)));
    let ex = model.hull.hull().bounds();
    println!("bounds {:?} com {:?}", ex, world.bodies[body].local_center_of_mass());
    for step in 0..to {
        world.step();
        if step < from {
            continue;
        }
        let b = &world.bodies[body];
        let below = model.depth_below_origin(*b.rotation()) - b.translation().y;
        println!(
            "{step}: y {:.4} below {:.4} v {:.3} w {:.3} sleep {} lin {:?} ang {:?}",
            b.translation().y,
            below,
            b.linvel().length(),
            b.angvel().length(),
            b.is_sleeping(),
            b.linvel(),
            b.angvel()
        );
        for pair in world.contact_pairs() {
            for m in pair.rigid().unwrap().manifolds.iter() {
                if m.points.is_empty() && m.data.solver_contacts.is_empty() {
                    continue;
                }
                println!("   n1 {:?} n {:?} subs {} {}", m.local_n1, m.data.normal, m.subshape1, m.subshape2);
                for p in &m.points {
                    println!(
                        "      p1 {:?} p2 {:?} dist {:.5} imp {:.4}  {:x} {:x}",
                        p.local_p1, p.local_p2, p.dist, p.data.impulse, p.fid1.0, p.fid2.0
                    );
                }
                println!("      solver {}", m.data.solver_contacts.len());
            }
        }
    }
}
