//! Height fields beside parry's: bytes, time of the bake, of opening, of rays, contacts and
//! manifolds.
//!
//!     cargo run --release --example height_field --package hullmap-bench
//!
//! Both fields have the same heights: a rough terrain of 1024 × 1024 cells. Each time is the least
//! processor time over several runs of all queries. The variants run in turn, so that other load on
//! the machine affects them equally. parry answers in f32, and without intervals.

use glam::{DQuat, DVec3};
use hullmap::height_field::{Diagonal, Layout};
use hullmap::{
    CastSettings, CompoundCache, CompoundManifolds, HeightField, ManifoldSettings, Pack, Pose, Ray, Settings,
    TriangleMesh, compound,
};
use hullmap_bake::height_field::{HeightGrid, bake_height_field, write_height_field};
use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};
use hullmap_bake::{IndexKind, PointSet, bake_hull, write_pack};
use hullmap_bench::clock::time_ns;
use parry3d::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher, RayCast};
use parry3d::utils::Array2;
use shapes::rng::SplitMix64;

const SEED: u64 = 39;
const RAYS: usize = 20_000;
const BODIES: usize = 1_000;
const RUNS: usize = 5;
const PREDICTION: f32 = 0.02;

type Failure = Box<dyn std::error::Error>;

/// Heights of a rough terrain: hills, plus a random height for each vertex.
fn terrain(size: usize) -> Vec<f32> {
    let mut rng = SplitMix64::new(SEED);
    let wave = |i: usize, length: f64| (i as f64 * std::f64::consts::TAU / length).sin();
    (0..size * size)
        .map(|at| {
            let (column, row) = (at % size, at / size);
            (4.0 * wave(column, 97.0) * wave(row, 61.0) + wave(column + row, 23.0) + 0.3 * rng.unit()) as f32
        })
        .collect()
}

/// A field with cells of 1 m, whose middle is the origin.
fn bake(size: usize, heights: &[f32]) -> Result<Vec<u8>, Failure> {
    let origin = [-0.5 * (size - 1) as f64; 2];
    let layout = Layout { columns: size, rows: size, origin, spacing: [1.0; 2], diagonal: Diagonal::Rising };
    let baked = bake_height_field(&HeightGrid { layout, heights, holes: &[], materials: &[] })?;
    Ok(write_height_field(baked, &Default::default())?)
}

/// The same surface as a triangle mesh.
fn as_mesh(field: &HeightField) -> Result<TriangleMesh, Failure> {
    let layout = field.layout();
    let places = (0..layout.rows).flat_map(|row| (0..layout.columns).map(move |column| (column, row)));
    let positions: Vec<[f32; 3]> =
        places.filter_map(|(column, row)| field.vertex(column, row)).map(|v| v.as_vec3().to_array()).collect();
    let corners: Vec<[u32; 3]> = (0..field.triangle_count())
        .map(|triangle| layout.corners(triangle).map(|[column, row]| layout.vertex(column, row) as u32))
        .collect();
    let baked = bake_triangle_mesh(&Triangles { positions: &positions, corners: &corners, materials: &[] })?;
    Ok(TriangleMesh::from_bytes(&write_triangle_mesh(baked, &Default::default())?)?)
}

/// parry's frame: its y is up, so ours is turned about x.
fn turned(v: DVec3) -> parry3d::math::Vector {
    parry3d::math::Vector::new(v.x as f32, v.z as f32, -v.y as f32)
}

fn parrys(size: usize, heights: &[f32]) -> parry3d::shape::HeightField {
    let cells = (size - 1) as f32;
    // Its rows follow its z, which is our −y.
    let rows = (0..size).flat_map(|column| (0..size).rev().map(move |row| heights[row * size + column]));
    let scale = parry3d::math::Vector::new(cells, 1.0, cells);
    parry3d::shape::HeightField::new(Array2::new(size, size, rows.collect()), scale)
}

/// Minimum time of each variant, per query, in nanoseconds.
fn times<const N: usize>(count: usize, mut variants: [Box<dyn FnMut() -> f64 + '_>; N]) -> [f64; N] {
    let mut least = [f64::INFINITY; N];
    for _ in 0..RUNS {
        for (variant, least) in variants.iter_mut().zip(&mut least) {
            *least = least.min(time_ns(|| _ = std::hint::black_box(variant())));
        }
    }
    least.map(|time| time / count as f64)
}

/// A hull of points on an ellipsoid of about 1 m, and parry's of the same points.
fn body(vertices: usize, rng: &mut SplitMix64) -> Result<(Pack, parry3d::shape::ConvexPolyhedron), Failure> {
    let points: Vec<[f32; 3]> = (0..vertices).map(|_| rng.direction().map(|c| 0.5 * c as f32)).collect();
    let source_vertices = (0..points.len() as u32).collect();
    let set = PointSet { name: "body".into(), positions: points.clone(), source_vertices, ..PointSet::default() };
    let pack = Pack::from_bytes(&write_pack(&[bake_hull(&set, IndexKind::Tree)?], &Default::default())?)?;
    let own: Vec<_> = points.iter().map(|p| parry3d::math::Vector::new(p[0], p[1], p[2])).collect();
    let polyhedron = parry3d::shape::ConvexPolyhedron::from_convex_hull(&own).ok_or("no hull")?;
    Ok((pack, polyhedron))
}

fn rays(field: &HeightField, mesh: &TriangleMesh, other: &parry3d::shape::HeightField) -> Result<(), Failure> {
    println!("\n| rays | hullmap, field | hullmap, mesh | parry, field |\n|---|---|---|---|");
    let high = field.bounds()[1].z;
    // A name, the height above the ground or `None` for just below the highest vertex, and the
    // direction: sideways, and down.
    let kinds = [
        ("from 10 m above, straight down", Some(10.0), [0.0, 1.0]),
        ("from 10 m above, 45 degrees", Some(10.0), [1.0, 1.0]),
        ("from 10 m above, along the ground", Some(10.0), [20.0, 1.0]),
        ("from 1 km above, 45 degrees", Some(1e3), [1.0, 1.0]),
        ("level, 1 cm below the highest vertex", None, [1.0, 0.0]),
    ];
    for (name, above, [slope, down]) in kinds {
        let mut rng = SplitMix64::new(SEED);
        let rays: Vec<(DVec3, DVec3)> = (0..RAYS)
            .map(|_| {
                let (x, y) = (rng.between(-400.0, 400.0), rng.between(-400.0, 400.0));
                let height = field.height_at(x, y).map_or(0.0, |ground| ground.height);
                let [dx, dy, _] = rng.direction();
                let side = DVec3::new(dx, dy, 0.0).normalize() * slope;
                let z = above.map_or(high - 0.01, |above| height + above);
                (DVec3::new(x, y, z), side - down * DVec3::Z)
            })
            .collect();
        let own: Vec<Ray> = rays.iter().map(|(origin, dir)| Ray::new(*origin, *dir)).collect::<Result<_, _>>()?;
        let theirs: Vec<_> = rays.iter().map(|(o, dir)| parry3d::query::Ray::new(turned(*o), turned(*dir))).collect();
        let settings = CastSettings::default();
        let [a, b, c] = times(
            RAYS,
            [
                Box::new(|| own.iter().map(|ray| compound::ray(field, ray, &settings).answer.t.min(1e3)).sum()),
                Box::new(|| own.iter().map(|ray| compound::ray(mesh, ray, &settings).answer.t.min(1e3)).sum()),
                Box::new(|| {
                    let cast = |ray| other.cast_local_ray(ray, f32::MAX, false).map_or(1e3, f64::from);
                    theirs.iter().map(cast).sum()
                }),
            ],
        );
        println!("| {name} | {a:.0} | {b:.0} | {c:.0} |");
    }
    Ok(())
}

/// Bodies a few centimetres deep in the ground.
fn bodies(field: &HeightField, mesh: &TriangleMesh, other: &parry3d::shape::HeightField) -> Result<(), Failure> {
    println!("\n| bodies of 1 m | contact, field | mesh | manifolds, field, plain | corrected | mesh | parry, field |");
    println!("|---|---|---|---|---|---|---|");
    for vertices in [8, 32, 128, 512] {
        let mut rng = SplitMix64::new(SEED);
        let (pack, polyhedron) = body(vertices, &mut rng)?;
        let hull = pack.hull(0)?;
        let mut poses = Vec::new();
        for _ in 0..BODIES {
            let (x, y) = (rng.between(-400.0, 400.0), rng.between(-400.0, 400.0));
            let ground = field.height_at(x, y).ok_or("beyond the field")?;
            let turn = DQuat::from_axis_angle(DVec3::from_array(rng.direction()), rng.between(0.0, 6.3));
            poses.push(Pose::new(DVec3::new(x, y, ground.height) + 0.45 * ground.normal, turn)?);
        }
        let theirs: Vec<parry3d::math::Pose> = poses
            .iter()
            .map(|pose| {
                let turn = DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2) * pose.rotation();
                parry3d::math::Pose::from_parts(turned(pose.translation()), turn.as_quat())
            })
            .collect();
        let (settings, welded) = (Settings::default(), ManifoldSettings::default());
        let contact = |pose: &Pose| {
            let mut cache = CompoundCache::default();
            compound::contact(field, &hull, *pose, &settings, &mut cache).map_or(0.0, |found| found.answer.depth)
        };
        let contact_mesh = |pose: &Pose| {
            let mut cache = CompoundCache::default();
            compound::contact(mesh, &hull, *pose, &settings, &mut cache).map_or(0.0, |found| found.answer.depth)
        };
        let mut manifolds = CompoundManifolds::new(64);
        let mut plain = CompoundManifolds::new(64);
        plain.set_welding(false);
        let mut of_mesh = CompoundManifolds::new(64);
        let t = times(
            BODIES,
            [
                Box::new(|| poses.iter().map(contact).sum()),
                Box::new(|| poses.iter().map(contact_mesh).sum()),
                Box::new(|| {
                    let mut update = |pose: &Pose| {
                        plain.clear();
                        f64::from(plain.update(field, &hull, *pose, &welded).touching)
                    };
                    poses.iter().map(&mut update).sum()
                }),
                Box::new(|| {
                    let mut update = |pose: &Pose| {
                        manifolds.clear();
                        f64::from(manifolds.update(field, &hull, *pose, &welded).touching)
                    };
                    poses.iter().map(&mut update).sum()
                }),
                Box::new(|| {
                    let mut update = |pose: &Pose| {
                        of_mesh.clear();
                        f64::from(of_mesh.update(mesh, &hull, *pose, &welded).touching)
                    };
                    poses.iter().map(&mut update).sum()
                }),
                Box::new(|| {
                    let update = |pose: &parry3d::math::Pose| {
                        let mut found: Vec<ContactManifold<(), ()>> = Vec::new();
                        let mut workspace = None;
                        let dispatcher = DefaultQueryDispatcher;
                        let done = dispatcher.contact_manifolds(
                            pose,
                            other,
                            &polyhedron,
                            PREDICTION,
                            &mut found,
                            &mut workspace,
                        );
                        assert!(done.is_ok(), "parry has no such pair");
                        found.len() as f64
                    };
                    theirs.iter().map(update).sum()
                }),
            ],
        );
        let [a, b, c, d, e, f] = t.map(|time| format!("{time:.0}"));
        println!("| {vertices} vertices | {a} | {b} | {c} | {d} | {e} | {f} |");
    }
    Ok(())
}

fn main() -> Result<(), Failure> {
    for size in [1025, 4096] {
        let heights = terrain(size);
        let bytes = bake(size, &heights)?;
        let mut least = [f64::INFINITY; 2];
        for _ in 0..3 {
            least[0] = least[0].min(time_ns(|| assert!(bake(size, &heights).is_ok())));
            least[1] = least[1].min(time_ns(|| assert!(HeightField::from_bytes(&bytes).is_ok())));
        }
        let cells = ((size - 1) * (size - 1)) as f64;
        let [baked, opened] = least.map(|time| time / 1e6);
        let each = bytes.len() as f64 / cells;
        println!("{size} x {size} vertices: {each:.2} bytes a cell, baked in {baked:.0} ms, opened in {opened:.0} ms");
    }
    let size = 1025;
    let heights = terrain(size);
    let field = HeightField::from_bytes(&bake(size, &heights)?)?;
    let mesh = as_mesh(&field)?;
    let each = mesh.bytes().len() as f64 / field.layout().cell_count() as f64;
    println!("as a triangle mesh: {each:.1} bytes a cell");
    let other = parrys(size, &heights);
    println!("\nTimes are ns a query.");
    rays(&field, &mesh, &other)?;
    bodies(&field, &mesh, &other)
}
