//! Bodies that slide over height fields do not stumble: over edges inside a field, nor where two
//! fields meet.

use glam::{DQuat, DVec3};
use hullmap::compound::{Joined, OneSided, Tile, seams};
use hullmap::height_field::{Diagonal, Layout};
use hullmap::shapes::Cuboid;
use hullmap::{
    Cache, CompoundManifolds, HeightField, Manifold, ManifoldSettings, Overlap, Pose, Prediction, SupportMap,
};
use shapes::rng::SplitMix64;

use crate::height_field::{centred, field};
use crate::meshes::{grid, slide_box};

/// A field of 10 × 10 cells with these heights for each column.
fn ridge(heights: [f32; 11], diagonal: Diagonal) -> HeightField {
    field(centred(11, 11, [1.0, 1.0], diagonal), &heights.repeat(11), &[])
}

/// A box that slides over triangles, a little below their surface, over every kind of edge inside
/// it: all normals are normals of the faces.
#[test]
fn a_box_does_not_stumble_over_edges_inside_a_field() {
    const FOLDED: [f32; 11] = [0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0];
    let mut replaced = 0;
    for diagonal in Diagonal::ALL {
        let (flat, folded) = (ridge([0.0; 11], diagonal), ridge(FOLDED, diagonal));
        replaced += slide_box(&flat, DVec3::new(0.3, 0.3, 0.2), 500, 0.016);
        replaced += slide_box(&flat, DVec3::new(0.01, 0.02, 0.01), 500, 0.016);
        replaced += slide_box(&folded, DVec3::splat(0.1), 500, 0.0024);
    }
    println!("{replaced} poses stumble without welding");
    assert!(replaced > 50, "the poses are too easy: {replaced}");
}

/// A box that slides on the ground keeps its height: the depth of its deepest point does not jump
/// from cell to cell, on a surface that undulates gently.
#[test]
fn the_depth_of_a_sliding_ball_of_points_does_not_jump() {
    let (columns, rows) = (41, 5);
    let layout = centred(columns, rows, [0.25, 0.25], Diagonal::Falling);
    let heights: Vec<f32> = (0..columns * rows).map(|i| (0.05 * ((i % columns) as f64 * 0.3).sin()) as f32).collect();
    let field = field(layout, &heights, &[]);
    let die = Cuboid::new(DVec3::new(0.02, 0.02, 0.02)).unwrap();
    let settings = ManifoldSettings::default();
    let mut last: Option<f64> = None;
    let mut manifolds = CompoundManifolds::new(32);
    for step in 0..2000 {
        let x = -4.0 + 0.004 * f64::from(step);
        let ground = field.height_at(x, 0.1).unwrap();
        let turn = DQuat::from_rotation_arc(DVec3::Z, ground.normal);
        let pose = Pose::new(DVec3::new(x, 0.1, ground.height) + 0.0199 * ground.normal, turn).unwrap();
        manifolds.update(&field, &die, pose, &settings);
        let depth = manifolds.iter().flat_map(|(_, m)| m.points().iter().map(|p| p.depth)).fold(0.0, f64::max);
        assert!(depth > 0.0, "x = {x}");
        if let Some(last) = last {
            // A step of 4 mm on a slope that changes by at most a few percent from cell to cell.
            assert!((depth - last).abs() < 1e-3, "x = {x}: {last} then {depth}");
        }
        last = Some(depth);
    }
}

/// The scene of jrouwe/JoltPhysics#1922: a box slides from one height field onto the next, and no
/// normal points along its way. With triangles that collide on one side, too.
#[test]
fn a_box_does_not_stumble_where_two_fields_meet() {
    let layout = |diagonal| Layout { origin: [0.0, -2.0], ..centred(5, 5, [1.0, 1.0], diagonal) };
    let settings = ManifoldSettings::default();
    let mut stumbles = 0;
    for (left, right) in [(Diagonal::Rising, Diagonal::Rising), (Diagonal::Rising, Diagonal::Falling)] {
        let fields = [field(layout(left), &[0.0; 25], &[]), field(layout(right), &[0.0; 25], &[])];
        let places = [-4.0, 0.0].map(|x| Pose::from_translation(DVec3::new(x, 0.0, 0.0)).unwrap());
        let unions = fields.each_ref().map(seams::union_of);
        let tile = |i: usize| Tile { union: &unions[i], parts: fields[i].triangle_count(), place: places[i] };
        let tiles = [tile(0), tile(1)];
        let joined = Joined::new(&tiles);
        let half = DVec3::new(0.2, 0.3, 0.1);
        let die = Cuboid::new(half).unwrap();
        for step in 0..600 {
            let x = -0.6 + 0.002 * f64::from(step);
            let body = Pose::from_translation(DVec3::new(x, 0.05 * x, half.z - 1e-3)).unwrap();
            let (mut held, mut held_by_fronts) = (0, 0);
            for i in 0..2 {
                let in_field = Pose::relative(places[i], body).unwrap();
                let mut manifolds = CompoundManifolds::new(16);
                manifolds.update(&fields[i], &die, in_field, &settings);
                let is_steep = |manifold: &Manifold| manifold.normal().distance(DVec3::Z) > 1e-3;
                stumbles += manifolds.iter().filter(|(_, manifold)| is_steep(manifold)).count();
                let check = |manifolds: &CompoundManifolds, held: &mut usize| {
                    for (_, manifold) in manifolds.iter() {
                        assert!(!is_steep(manifold), "x = {x}: {}", manifold.normal());
                        *held += manifold.points().len();
                    }
                };
                manifolds.update_joined(&joined, i, &fields[i], &die, in_field, &settings);
                check(&manifolds, &mut held);
                let mut manifolds = CompoundManifolds::new(16);
                manifolds.update_joined(&joined, i, &OneSided::new(&fields[i]), &die, in_field, &settings);
                check(&manifolds, &mut held_by_fronts);
            }
            assert!(held >= 3 && held_by_fronts >= 3, "x = {x}: {held} points, {held_by_fronts} on fronts");
        }
    }
    println!("{stumbles} normals are wrong if each field is alone");
    assert!(stumbles > 20);
}

/// A plate that lies on rough ground, tilted, and has sunk in by at most half a millimetre: no
/// contact pushes it down. Where it reaches over a peak, its middle is below the plane of a
/// triangle beyond the peak, which it touches at the peak only.
#[test]
fn a_plate_that_reaches_over_a_peak_is_not_pushed_down() {
    const SEED: u64 = 0x39;
    println!("seed {SEED}");
    let mut rng = SplitMix64::new(SEED);
    let plate = Cuboid::new(DVec3::new(0.9, 0.7, 0.05)).unwrap();
    let mut cache = Cache::new();
    let near = ManifoldSettings { prediction: Prediction::Length(0.02), ..Default::default() };
    let (mut beyond, mut touching) = (0, 0);
    for round in 0..2000 {
        let ground = grid(6, |_, _| rng.between(-0.2, 0.2));
        let turn = DQuat::from_rotation_z(rng.between(0.0, 6.0))
            * DQuat::from_rotation_x(rng.between(-0.5, 0.5))
            * DQuat::from_rotation_y(rng.between(-0.5, 0.5));
        let at = DVec3::new(rng.between(-0.5, 0.5), rng.between(-0.5, 0.5), 0.0);
        let pose = |height: f64| Pose::new(at.with_z(height), turn).unwrap();
        let [mut low, mut high] = [-0.5, 2.0];
        while high - low > 2.5e-4 {
            let middle = 0.5 * (low + high);
            let meets = hullmap::intersects(&ground, &plate, pose(middle), &mut cache).status != Overlap::Separated;
            *(if meets { &mut low } else { &mut high }) = middle;
        }
        let body = pose(low - 2.5e-4);
        let mut manifolds = CompoundManifolds::new(64);
        manifolds.update(&ground, &plate, body, &near);
        touching += usize::from(!manifolds.is_empty());
        for ([triangle, _], manifold) in manifolds.iter() {
            let normal = manifold.normal();
            assert!(normal.z > 0.0, "round {round}: triangle {triangle} has the normal {normal}");
        }
        let is_beyond = |triangle: usize| {
            let [a, b, c] = ground.triangle(triangle).unwrap().corners();
            let depth = (body.transform_point(plate.interior_point()) - a).dot((b - a).cross(c - a));
            let part = ground.triangle(triangle).unwrap();
            depth < 0.0 && hullmap::intersects(&part, &plate, body, &mut Cache::new()).status != Overlap::Separated
        };
        beyond += usize::from((0..ground.triangle_count()).any(is_beyond));
    }
    println!("{touching} plates touch, {beyond} are beyond a peak");
    assert!(touching > 1900 && beyond > 50, "{touching}, {beyond}");
}
