//! A box that slides over ten slabs of triangles, by a small solver of impulses: its path is that
//! over one slab.

use glam::{DMat3, DQuat, DVec3};
use hullmap::compound::{BodyManifold, Joined, OneSided, Tile, seams};
use hullmap::shapes::Cuboid;
use hullmap::{CompoundManifolds, ManifoldSettings, Pose, Prediction, TriangleMesh};

use crate::meshes::mesh;

/// Length of a step, in seconds.
const STEP: f64 = 1.0 / 60.0;

/// Gravity, in m/s².
const GRAVITY: DVec3 = DVec3::new(0.0, 0.0, -9.81);

/// Half the sides of the box, which weighs 1 kg, in metres.
const HALF: DVec3 = DVec3::new(0.5, 0.4, 0.3);

/// A floor of tiles.
struct Floor {
    tiles: Vec<TriangleMesh>,
    /// Whether only the points of a body manifold push.
    is_reduced: bool,
    is_one_sided: bool,
}

/// `count` slabs along x from −4 to 4, each two triangles of the plane z = 0 and four walls below.
/// All are one mesh, or each is one. The walls between slabs lean by `lean`: one to the left, the
/// next to the right; and their tops are as much out of line with y.
fn floor(count: usize, is_one_mesh: bool, lean: f64) -> Vec<TriangleMesh> {
    let slab = |i: usize| {
        let x = |i: usize, y: f64, z: f64| {
            let side = if i.is_multiple_of(2) { lean } else { -lean };
            let between = if i == 0 || i == count { 0.0 } else { side * (y / 8.0 - z) };
            -4.0 + 8.0 * i as f64 / count as f64 + between
        };
        let corners = [(i, -4.0), (i + 1, -4.0), (i + 1, 4.0), (i, 4.0)];
        let at = |z: f64| corners.map(|(i, y)| DVec3::new(x(i, y, z), y, z));
        [0.0, -0.5].into_iter().flat_map(at).collect::<Vec<_>>()
    };
    let sides = |first: u32| {
        let mut found = vec![[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]];
        for i in 0..4 {
            let next = (i + 1) % 4;
            found.extend([[i, i + 4, next + 4], [i, next + 4, next]]);
        }
        found.into_iter().map(|corners: [u32; 3]| corners.map(|corner| first + corner)).collect::<Vec<_>>()
    };
    if is_one_mesh {
        let positions: Vec<DVec3> = (0..count).flat_map(slab).collect();
        let corners: Vec<[u32; 3]> = (0..count as u32).flat_map(|i| sides(8 * i)).collect();
        vec![mesh(&positions, &corners)]
    } else {
        (0..count).map(|i| mesh(&slab(i), &sides(0))).collect()
    }
}

/// A moment of the path: position and velocity.
type Moment = (DVec3, DVec3);

/// The path of the box in two seconds.
fn run(floor: &Floor, turn: f64) -> Vec<Moment> {
    let unions: Vec<_> = floor.tiles.iter().map(seams::union_of).collect();
    let tile = |(union, tile): (_, &TriangleMesh)| Tile { union, parts: tile.triangle_count(), place: Pose::IDENTITY };
    let tiles: Vec<Tile> = unions.iter().map(|union| union as &dyn seams::Union).zip(&floor.tiles).map(tile).collect();
    let joined = Joined::new(&tiles);
    let mut manifolds = vec![CompoundManifolds::new(32); floor.tiles.len()];
    let mut reduced = vec![BodyManifold::new(32); floor.tiles.len()];
    let die = Cuboid::new(HALF).unwrap();
    let settings = ManifoldSettings { prediction: Prediction::Length(0.02), ..ManifoldSettings::default() };
    let (mut position, mut rotation) = (DVec3::new(-3.3, -0.43, HALF.z), DQuat::from_rotation_z(turn));
    let (mut velocity, mut spin) = (DVec3::new(3.0, 0.33, 0.0), DVec3::ZERO);
    let inertia = (DVec3::splat(HALF.length_squared()) - HALF * HALF) / 3.0;
    let mut moments = Vec::new();
    for _ in 0..120 {
        velocity += GRAVITY * STEP;
        let pose = Pose::new(position, rotation).unwrap();
        // Points, normals, depths, and impulses.
        let mut contacts: Vec<(DVec3, DVec3, f64, f64)> = Vec::new();
        for (i, (manifolds, reduced)) in manifolds.iter_mut().zip(&mut reduced).enumerate() {
            if floor.is_one_sided {
                manifolds.update_joined(&joined, i, &OneSided::new(&floor.tiles[i]), &die, pose, &settings);
            } else {
                manifolds.update_joined(&joined, i, &floor.tiles[i], &die, pose, &settings);
            }
            reduced.update(manifolds);
            if floor.is_reduced {
                contacts.extend(reduced.points().iter().map(|p| (p.point.point_b, p.normal, p.point.depth, 0.0)));
            } else {
                for (_, manifold) in manifolds.iter() {
                    contacts.extend(manifold.points().iter().map(|p| (p.point_b, manifold.normal(), p.depth, 0.0)));
                }
            }
        }
        let turned = DMat3::from_quat(rotation);
        let inverse = turned * DMat3::from_diagonal(1.0 / inertia) * turned.transpose();
        for _ in 0..60 {
            for (point, normal, depth, total) in &mut contacts {
                let arm = *point - position;
                let lever = arm.cross(*normal);
                let mass = 1.0 / (1.0 + lever.dot(inverse * lever));
                // A gap may close within the step; a depth above 5 mm opens slowly.
                let bias = if *depth < 0.0 { *depth / STEP } else { 0.2 * (*depth - 0.005).max(0.0) / STEP };
                let speed = (velocity + spin.cross(arm)).dot(*normal);
                let before = *total;
                *total = (before + mass * (bias - speed)).max(0.0);
                let push = *normal * (*total - before);
                velocity += push;
                spin += inverse * arm.cross(push);
            }
        }
        position += velocity * STEP;
        rotation = (DQuat::from_scaled_axis(spin * STEP) * rotation).normalize();
        moments.push((position, velocity));
    }
    moments
}

/// The bounds of the table of slides: 0.2 mm, 0.2 %, and no jump.
fn slides_as_over_one(lean: f64) {
    for turn in [0.0, 0.3, -1.1] {
        for is_reduced in [false, true] {
            for is_one_sided in [false, true] {
                let with = |tiles: Vec<TriangleMesh>| run(&Floor { tiles, is_reduced, is_one_sided }, turn);
                let whole = with(floor(1, true, 0.0));
                let last = whole.last().unwrap().0;
                assert!(last.x > 2.0 && (last.z - HALF.z).abs() < 0.01, "{last}");
                for is_one_mesh in [true, false] {
                    let cut = with(floor(10, is_one_mesh, lean));
                    let what = format!(
                        "lean {lean}, turn {turn}, reduced {is_reduced}, one-sided {is_one_sided}, one mesh {is_one_mesh}"
                    );
                    for (step, (a, b)) in whole.iter().zip(&cut).enumerate() {
                        // Until it leaves the floor.
                        if a.0.x > 3.4 {
                            break;
                        }
                        assert!((a.0.z - b.0.z).abs() < 2e-4, "{what}, step {step}: {a:?} {b:?}");
                        assert!(a.0.distance(b.0) < 2e-3, "{what}, step {step}: {a:?} {b:?}");
                        assert!((a.1.length() - b.1.length()).abs() < 2e-3 * 3.0, "{what}, step {step}: {a:?} {b:?}");
                        assert!(b.1.z < a.1.z.max(0.0) + 0.02, "{what}, step {step}: it jumps: {a:?} {b:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_box_slides_over_ten_slabs_as_over_one() {
    slides_as_over_one(0.0);
}

/// Walls that lean are below the floor, too, but their normals point up.
#[test]
fn a_box_slides_over_walls_that_lean_below_the_floor() {
    for lean in [0.1, 0.3, 0.577] {
        slides_as_over_one(lean);
    }
}
