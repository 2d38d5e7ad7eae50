//! Bodies that slide over meshes and height fields do not stumble: over edges inside a sheet, nor
//! where two sheets meet.

use glam::{DQuat, DVec3};
use hullmap::compound::{Joined, OneSided, Parts, Tile, seams};
use hullmap::height_field::{Diagonal, Layout};
use hullmap::shapes::Cuboid;
use hullmap::{
    Cache, CompoundManifolds, Geometry, HeightField, Manifold, ManifoldSettings, Overlap, Pose, Prediction, SupportMap,
};
use hullmap_bake::PointSet;
use hullmap_testkit::packs::{self, height_field as field};
use shapes::rng::SplitMix64;

use crate::height_field::centred;
use crate::meshes::{grid, mesh, slide_box};

/// A field of 10 × 10 cells with these heights for each column.
fn ridge(heights: [f32; 11], diagonal: Diagonal) -> HeightField {
    field(centred(11, 11, [1.0, 1.0], diagonal), &heights.repeat(11), &[])
}

/// A box that slides over triangles, a little below their surface, over every kind of edge inside
/// it: all normals are normals of the faces.
#[test]
fn a_box_does_not_stumble_over_edges_inside_a_surface() {
    /// A valley and a ridge: edges where normals differ, along y.
    const FOLDED: [f32; 11] = [0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0];
    fn slide<S: Geometry>(flat: &S, folded: &S) -> usize {
        slide_box(flat, DVec3::new(0.3, 0.3, 0.2), 500, 0.016)
            + slide_box(flat, DVec3::new(0.01, 0.02, 0.01), 500, 0.016)
            + slide_box(folded, DVec3::splat(0.1), 500, 0.0024)
    }
    let meshes = slide(&grid(10, |_, _| 0.0), &grid(10, |x, _| f64::from(FOLDED[x])));
    let fields = Diagonal::ALL.map(|diagonal| slide(&ridge([0.0; 11], diagonal), &ridge(FOLDED, diagonal)));
    println!("{meshes} and {fields:?} poses stumble without welding");
    assert!(meshes > 20 && fields.iter().sum::<usize>() > 50, "the poses are too easy: {meshes}, {fields:?}");
}

/// JoltPhysics#1922: a body slides from one sheet to the next, which lies beside it in one plane,
/// and meets the border. All normals are normals of the plane, for every placement and rotation of
/// the second sheet, and with triangles that collide on one side, too. Returns the number of
/// normals that are wrong if each sheet is alone.
fn cross<S: Parts + Geometry>(sheets: [&S; 2], places: [Pose; 2], half: DVec3) -> usize {
    let (unions, settings) = (sheets.map(seams::union_of), ManifoldSettings::default());
    let tile = |i: usize| Tile { union: &unions[i], parts: sheets[i].part_count(), place: places[i] };
    let tiles = [tile(0), tile(1)];
    let (joined, die) = (Joined::new(&tiles), Cuboid::new(half).unwrap());
    let is_steep = |manifold: &Manifold| manifold.normal().distance(DVec3::Z) > 1e-3;
    let mut stumbles = 0;
    for step in 0..800 {
        let x = 1.6 * half.x * (f64::from(step) / 400.0 - 1.0);
        let at = DVec3::new(x, 0.137 + 0.1 * x, half.z * (1.0 - 1e-3));
        let body = Pose::new(at, DQuat::from_rotation_z(0.3 * x / half.x)).unwrap();
        let mut held = [0; 2];
        for i in 0..2 {
            let b_in_a = Pose::relative(places[i], body).unwrap();
            let mut manifolds = [CompoundManifolds::new(16), CompoundManifolds::new(16)];
            manifolds[0].update(sheets[i], &die, b_in_a, &settings);
            stumbles += manifolds[0].iter().filter(|(_, manifold)| is_steep(manifold)).count();
            manifolds[0].update_joined(&joined, i, sheets[i], &die, b_in_a, &settings);
            manifolds[1].update_joined(&joined, i, &OneSided::new(sheets[i]), &die, b_in_a, &settings);
            for (held, manifolds) in held.iter_mut().zip(&manifolds) {
                for (pair, manifold) in manifolds.iter() {
                    assert!(!is_steep(manifold), "sheet {i}, x = {x}, {pair:?}: {}", manifold.normal());
                    assert!(manifold.points().iter().all(|p| p.depth <= 1.001e-3 * half.z), "x = {x}");
                    *held += manifold.points().len();
                }
            }
        }
        assert!(held.iter().all(|held| *held >= 3), "x = {x}: {held:?} points, with both sides and with fronts");
    }
    stumbles
}

#[test]
fn a_box_does_not_stumble_where_sheets_meet() {
    // Strips of the plane z = 0, in their own frames: x from 0 to 4.
    let strip = |cells: u32| {
        let at = |i: u32, y: f64| DVec3::new(4.0 * f64::from(i) / f64::from(cells), y, 0.0);
        let positions: Vec<DVec3> = (0..=cells).flat_map(|i| [at(i, -4.0), at(i, 4.0)]).collect();
        let quad = |i: u32| [[2 * i, 2 * i + 2, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 1]];
        mesh(&positions, &(0..cells).flat_map(quad).collect::<Vec<_>>())
    };
    let level = |diagonal| field(Layout { origin: [0.0, -4.0], ..centred(5, 9, [1.0; 2], diagonal) }, &[0.0; 45], &[]);
    let (meshes, fields) = ([strip(4), strip(3)], Diagonal::ALL.map(level));
    let left = Pose::from_translation(DVec3::NEG_X * 4.0).unwrap();
    let turned = Pose::new(DVec3::X * 4.0, DQuat::from_rotation_z(std::f64::consts::PI)).unwrap();
    let mut stumbles = [0; 2];
    for half in [DVec3::new(0.3, 0.25, 0.2), DVec3::splat(0.02)] {
        for places in [[left, Pose::IDENTITY], [left, turned]] {
            stumbles[0] += cross(meshes.each_ref(), places, half);
            stumbles[1] += cross(fields.each_ref(), places, half) + cross([&fields[0]; 2], places, half);
        }
    }
    println!("{stumbles:?} normals are wrong if each sheet is alone");
    assert!(stumbles.iter().all(|count| *count > 20), "{stumbles:?}");
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

/// The deepest points of the first part are in the second, which has passed through the sheet, or
/// is more than halfway through. A third part touches, but does not carry the body.
#[test]
fn a_body_whose_lowest_part_has_passed_through_a_sheet_is_carried() {
    let part = |low: [f32; 3], high: [f32; 3]| PointSet::of_positions(packs::corners(low, high));
    let settings = ManifoldSettings { prediction: Prediction::Length(0.01), ..ManifoldSettings::default() };
    let pose = Pose::from_translation(DVec3::new(0.3, 0.2, 0.0)).unwrap();
    let flat = field(centred(11, 11, [1.0, 1.0], Diagonal::Rising), &[0.0; 121], &[]);
    for top in [-0.02, 0.01] {
        let body = packs::parts(&[
            part([0.0, 0.0, -0.03], [1.0, 1.0, 1.0]),
            part([0.0, 0.0, -0.06], [1.0, 1.0, top]),
            part([2.0, 0.0, 5e-4], [3.0, 1.0, 1.0]),
        ]);
        let mut manifolds = CompoundManifolds::new(64);
        for _ in 0..2 {
            manifolds.update(&flat, &body, pose, &settings);
            let carrying = manifolds.iter().filter(|(pair, _)| pair[1] == 0).flat_map(|(_, own)| own.points());
            let deepest = carrying.map(|point| point.depth).fold(f64::NEG_INFINITY, f64::max);
            assert!((0.029..0.031).contains(&deepest), "{top}: {deepest}");
        }
    }
}
