//! Prints the time of queries of a triangle mesh beside parry3d's `TriMesh`: manifolds of bodies
//! that lie on a rough ground of 100,352 triangles, new and kept, and rays from above. Manifolds of
//! Box3D and Jolt are measured, too, if their sources are given.
//!
//! Ours and theirs alternate, so that a busy machine slows both down. Times are processor times,
//! except Box3D's, which it measures itself.

use std::hint::black_box;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use glam::{DQuat, DVec3};
use hullmap::compound::BodyManifold;
use hullmap::{
    Cache, CastSettings, CompoundManifolds, ManifoldSettings, Motion, Pack, Pose, Prediction, Ray, TriangleMesh,
};
use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};
use hullmap_bench::clock::time_ns;
use hullmap_bench::mesh_peer::{self, MeshPeer, Scene};
use hullmap_testkit::packs::tree_pack;
use parry3d::math;
use parry3d::query::{
    ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher, QueryDispatcher, RayCast, ShapeCastOptions,
};
use parry3d::shape::{ConvexPolyhedron, TriMesh, TriMeshFlags};
use shapes::{families::rock, rng::SplitMix64};

/// Measures manifolds and rays on a mesh, beside parry's.
///
/// The table goes to standard output.
#[derive(Parser)]
#[command(after_help = "Example:\n  cargo run --release -p hullmap-bench --bin mesh-table -- --rounds 5")]
struct Arguments {
    /// Number of rounds; the result is the median
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Number of bodies, and of rays
    #[arg(long, default_value_t = 1_000)]
    bodies: usize,
    /// Measure our manifolds of bodies with this number of vertices, for a profiler
    #[arg(long, value_name = "VERTICES")]
    profile: Option<usize>,
    /// Folder with the source of Box3D, which is compiled with `cc` and measured, too
    #[arg(long, value_name = "FOLDER")]
    box3d: Option<PathBuf>,
    /// Folder with the source of Jolt, which is compiled with `c++` and measured, too
    #[arg(long, value_name = "FOLDER")]
    jolt: Option<PathBuf>,
}

/// Other engines that are measured.
#[derive(Default)]
struct Engines {
    parry: bool,
    box3d: Option<MeshPeer>,
    jolt: Option<MeshPeer>,
}

impl Engines {
    /// Compiles the engines whose source is given.
    fn compile(box3d: Option<PathBuf>, jolt: Option<PathBuf>) -> Result<Self, String> {
        let box3d = box3d.map(|folder| MeshPeer::box3d(&folder)).transpose().map_err(|e| format!("Box3D: {e}"))?;
        let jolt = jolt.map(|folder| MeshPeer::jolt(&folder)).transpose().map_err(|e| format!("Jolt: {e}"))?;
        Ok(Self { parry: true, box3d, jolt })
    }
}

/// Squares of 1 m along each side of the ground of bodies: 100,352 triangles.
const CELLS: usize = 224;

/// Squares along each side of the ground of rays and casts: 1,002,528 triangles.
const MANY_CELLS: usize = 708;

/// Prediction of manifolds, in metres.
const PREDICTION: f64 = 0.02;

struct GroundMeshes {
    /// Squares along each side.
    cells: usize,
    mesh: TriangleMesh,
    positions: Vec<[f32; 3]>,
    corners: Vec<[u32; 3]>,
    parry: TriMesh,
    heights: Vec<f64>,
}

impl GroundMeshes {
    fn new(cells: usize) -> Self {
        let mut rng = SplitMix64::new(28);
        let heights: Vec<f64> = (0..(cells + 1) * (cells + 1)).map(|_| 0.2 * rng.unit()).collect();
        let half = cells as f64 * 0.5;
        let position = |(i, z): (usize, &f64)| {
            [(i % (cells + 1)) as f64 - half, (i / (cells + 1)) as f64 - half, *z].map(|c| c as f32)
        };
        let positions: Vec<[f32; 3]> = heights.iter().enumerate().map(position).collect();
        let at = |x: usize, y: usize| (y * (cells + 1) + x) as u32;
        let square = |i: usize| {
            let (x, y) = (i % cells, i / cells);
            [[at(x, y), at(x + 1, y), at(x + 1, y + 1)], [at(x, y), at(x + 1, y + 1), at(x, y + 1)]]
        };
        let corners: Vec<[u32; 3]> = (0..cells * cells).flat_map(square).collect();
        let triangles = Triangles { positions: &positions, corners: &corners, materials: &[] };
        let baked = bake_triangle_mesh(&triangles).expect("the ground can be baked");
        let file = write_triangle_mesh(baked, &Default::default()).expect("it is small enough");
        let points = positions.iter().map(|p| math::Vector::from_array(*p)).collect();
        let parry = TriMesh::with_flags(points, corners.clone(), TriMeshFlags::FIX_INTERNAL_EDGES);
        Self {
            cells,
            mesh: TriangleMesh::from_bytes(&file).expect("the file is valid"),
            positions,
            corners,
            parry: parry.expect("parry takes it"),
            heights,
        }
    }

    /// Height of the ground's highest corner near a place.
    fn height(&self, at: DVec3) -> f64 {
        let cells = self.cells;
        let cell = |c: f64| (c + cells as f64 * 0.5).floor().clamp(0.0, (cells - 1) as f64) as usize;
        let (x, y) = (cell(at.x), cell(at.y));
        let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
        corners.iter().map(|(x, y)| self.heights[y * (cells + 1) + x]).sum::<f64>() / 4.0
    }
}

/// A body of 1 m, for both.
struct Body {
    pack: Pack,
    parry: ConvexPolyhedron,
}

impl Body {
    fn new(vertices: usize) -> Self {
        let points: Vec<[f32; 3]> = rock(vertices, 3).iter().map(|p| p.map(|c| 0.5 * c)).collect();
        let parry = ConvexPolyhedron::from_convex_hull(
            &points.iter().map(|p| math::Vector::from_array(*p)).collect::<Vec<_>>(),
        );
        Self { pack: tree_pack(&points), parry: parry.expect("parry takes the rock") }
    }

    /// Poses in which the body lies on the ground, and poses a step later.
    fn poses(&self, ground: &GroundMeshes, count: usize) -> [Vec<Pose>; 2] {
        let mut rng = SplitMix64::new(29);
        let lowest = |turn: DQuat| {
            let hull = self.pack.hull(0).expect("one hull");
            hull.vertices().map(|v| (turn * v.as_dvec3()).z).fold(f64::INFINITY, f64::min)
        };
        let poses = (0..count).map(|_| {
            let turn = DQuat::from_xyzw(rng.unit() - 0.5, rng.unit() - 0.5, rng.unit() - 0.5, rng.unit() - 0.5);
            let turn = turn.normalize();
            let half = ground.cells as f64 * 0.5 - 3.0;
            let at = DVec3::new(rng.between(-half, half), rng.between(-half, half), 0.0);
            Pose::new(at.with_z(ground.height(at) - lowest(turn) - 0.01), turn).expect("finite")
        });
        let poses: Vec<Pose> = poses.collect();
        let step = DVec3::new(2e-3, 1e-3, -1e-3);
        let later = poses.iter().map(|p| Pose::new(p.translation() + step, p.rotation()).expect("finite")).collect();
        [poses, later]
    }
}

/// Microseconds of processor time of each of `count` calls.
fn time(count: usize, call: impl FnMut(usize)) -> f64 {
    time_ns(|| (0..count).for_each(call)) * 1e-3 / count as f64
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or_default()
}

fn for_parry(pose: &Pose) -> math::Pose {
    math::Pose::from_parts(pose.translation().as_vec3(), pose.rotation().as_quat())
}

fn main() -> ExitCode {
    let Arguments { rounds, bodies, profile, box3d, jolt } = Arguments::parse();
    let engines = match Engines::compile(box3d, jolt) {
        Ok(engines) => engines,
        Err(error) => {
            eprintln!("mesh-table: {error}");
            return ExitCode::FAILURE;
        }
    };
    let ground = GroundMeshes::new(CELLS);
    if let Some(vertices) = profile {
        let found = manifolds(&ground, vertices, bodies, rounds, &Engines::default());
        println!("{found:?}");
        return ExitCode::SUCCESS;
    }
    [&engines.box3d, &engines.jolt].into_iter().flatten().for_each(|peer| println!("{}", peer.proof));
    println!(
        "µs a body or a ray, {} triangles, {bodies} bodies, median of {rounds} rounds\n",
        ground.mesh.triangle_count()
    );
    let columns = ["triangles", "new, not corrected", "new", "kept, not corrected", "kept", "eight points"];
    let of_peers = ["Box3D new", "Box3D kept", "its points", "Jolt new", "Jolt, edges removed", "its points"];
    println!("| vertices | {} | parry new | parry kept | {} |", columns.join(" | "), of_peers.join(" | "));
    println!("|{}", "---|".repeat(15));
    for vertices in [32, 128, 512] {
        let found = manifolds(&ground, vertices, bodies, rounds, &engines);
        let Times { ours: [plain, corrected], reduced, parry, touching, box3d, jolt } = found;
        // Not every engine supports every hull.
        let cells = |times: Option<mesh_peer::Times>| {
            times.map_or(
                ["–".to_owned(), "–".to_owned(), "–".to_owned()],
                |mesh_peer::Times { us, points, .. }| [us[0], us[1], points].map(|number| format!("{number:.1}")),
            )
        };
        println!(
            "| {vertices} | {touching:.1} | {:.1} | {:.1} | {:.1} | {:.1} | {reduced:.1} | {:.1} | {:.1} | {} | {} |",
            plain[0],
            corrected[0],
            plain[1],
            corrected[1],
            parry[0],
            parry[1],
            cells(box3d).join(" | "),
            cells(jolt).join(" | ")
        );
    }
    rays(&ground, 20 * bodies, rounds);
    let large = GroundMeshes::new(MANY_CELLS);
    rays(&large, 20 * bodies, rounds);
    casts(&large, bodies, rounds);
    ExitCode::SUCCESS
}

/// Times of manifolds, new and kept.
#[derive(Debug)]
struct Times {
    /// Our times, without the correction of normals and with it.
    ours: [[f64; 2]; 2],
    /// Our time of choosing eight points.
    reduced: f64,
    parry: [f64; 2],
    /// `None` if Box3D is not measured, or does not support the hull.
    box3d: Option<mesh_peer::Times>,
    jolt: Option<mesh_peer::Times>,
    /// Mean number of triangles that touch.
    touching: f64,
}

fn manifolds(ground: &GroundMeshes, vertices: usize, count: usize, rounds: usize, engines: &Engines) -> Times {
    let body = Body::new(vertices);
    let hull = body.pack.hull(0).expect("one hull");
    let poses = body.poses(ground, count);
    let settings = ManifoldSettings { prediction: Prediction::Length(PREDICTION), ..ManifoldSettings::default() };
    let theirs = poses.each_ref().map(|poses| poses.iter().map(for_parry).collect::<Vec<_>>());
    let own: Vec<glam::Vec3> = hull.vertices().collect();
    let scene = Scene { positions: &ground.positions, triangles: &ground.corners, hull: &own, poses: &poses };
    let mut peers = [&engines.box3d, &engines.jolt]
        .map(|engine| (engine.as_ref().and_then(|engine| engine.start(&scene).ok()), Vec::new()));
    let mut times: [Vec<f64>; 7] = Default::default();
    let mut touching = 0;
    for _ in 0..rounds {
        for (session, times) in &mut peers {
            times.extend(session.as_mut().and_then(|session| session.round().ok()));
        }
        for (plain, welds) in [(0, false), (1, true)] {
            let mut kept = vec![CompoundManifolds::new(8); count];
            kept.iter_mut().for_each(|manifolds| manifolds.set_welding(welds));
            let mut reduced = vec![BodyManifold::new(8); count];
            for (step, poses) in poses.iter().enumerate() {
                let update = |i: usize| _ = black_box(kept[i].update(&ground.mesh, &hull, poses[i], &settings));
                times[2 * plain + step].push(time(count, update));
                touching = kept.iter().map(CompoundManifolds::len).sum();
                let mut choose = |i: usize| reduced[i].update(&kept[i]);
                times[6].push(time(count, &mut choose));
            }
        }
        let mut kept: Vec<(Vec<ContactManifold<(), ()>>, Option<_>)> = (0..count).map(|_| (Vec::new(), None)).collect();
        for (step, poses) in theirs.iter().enumerate() {
            let update = |i: usize| {
                let (manifolds, workspace) = &mut kept[i];
                let shapes = (&ground.parry, &body.parry);
                let (pose, near) = (&poses[i], PREDICTION as f32);
                let found =
                    DefaultQueryDispatcher.contact_manifolds(pose, shapes.0, shapes.1, near, manifolds, workspace);
                black_box(found.is_ok());
            };
            if engines.parry {
                times[4 + step].push(time(count, update));
            }
        }
    }
    let [plain_new, plain_kept, new, kept, parry_new, parry_kept, reduced] = times.map(median);
    let [box3d, jolt] = peers.map(|(_, times): (_, Vec<mesh_peer::Times>)| {
        let us = |step: usize| median(times.iter().map(|times| times.us[step]).collect());
        times.first().map(|first| mesh_peer::Times { us: [us(0), us(1)], ..*first })
    });
    Times {
        ours: [[plain_new, plain_kept], [new, kept]],
        reduced,
        parry: [parry_new, parry_kept],
        box3d,
        jolt,
        touching: touching as f64 / count as f64,
    }
}

/// Paths from 10 m above the ground, down and slanting: origins and unit directions.
fn paths(ground: &GroundMeshes, count: usize) -> Vec<(DVec3, DVec3)> {
    let mut rng = SplitMix64::new(30);
    let reach = 0.45 * ground.cells as f64;
    let mut place = |z: f64| DVec3::new(rng.between(-reach, reach), rng.between(-reach, reach), z);
    let slant = 1.0 / reach;
    (0..count).map(|_| (place(10.0), (DVec3::NEG_Z + slant * place(0.0).with_z(0.0)).normalize())).collect()
}

fn rays(ground: &GroundMeshes, count: usize, rounds: usize) {
    let lines = paths(ground, count);
    let rays: Vec<Ray> = lines.iter().map(|(from, dir)| Ray::new(*from, *dir).expect("finite")).collect();
    let theirs: Vec<parry3d::query::Ray> =
        lines.iter().map(|(from, dir)| parry3d::query::Ray::new(from.as_vec3(), dir.as_vec3())).collect();
    let (mut ours, mut parry) = (Vec::new(), Vec::new());
    let mut hits = [0; 2];
    for _ in 0..rounds {
        hits = [0; 2];
        let settings = CastSettings { max_t: 1e3, ..CastSettings::default() };
        ours.push(time(count, |i| {
            let found = hullmap::ray(&ground.mesh, &rays[i], &settings);
            hits[0] += usize::from(found.hit);
        }));
        parry.push(time(count, |i| {
            hits[1] += usize::from(ground.parry.cast_local_ray_and_get_normal(&theirs[i], 1e3, false).is_some());
        }));
    }
    let (ours, parry) = (median(ours), median(parry));
    println!(
        "\nrays on {} triangles: {ours:.3} µs, {:.2} million a second; parry {parry:.3} µs, {:.2}; {} and {} of {count} \
         hit",
        ground.mesh.triangle_count(),
        1.0 / ours,
        1.0 / parry,
        hits[0],
        hits[1]
    );
}

/// Casts of a body of 32 vertices along the paths of rays.
fn casts(ground: &GroundMeshes, count: usize, rounds: usize) {
    let body = Body::new(32);
    let hull = body.pack.hull(0).expect("one hull");
    let lines = paths(ground, count);
    let (mut ours, mut parry, mut hits) = (Vec::new(), Vec::new(), [0; 2]);
    let options = ShapeCastOptions { max_time_of_impact: 1e3, ..ShapeCastOptions::default() };
    for _ in 0..rounds {
        hits = [0; 2];
        let settings = CastSettings { max_t: 1e3, ..CastSettings::default() };
        ours.push(time(count, |i| {
            let (start, motion) = (Pose::from_translation(lines[i].0), Motion::new(lines[i].1));
            let (start, motion) = (start.expect("finite"), motion.expect("finite"));
            let found = hullmap::cast(&ground.mesh, &hull, start, motion, &settings, &mut Cache::with_pairs(0));
            hits[0] += usize::from(found.hit);
        }));
        parry.push(time(count, |i| {
            let pose = math::Pose::from_translation(lines[i].0.as_vec3());
            let shapes = (&ground.parry, &body.parry);
            let found = DefaultQueryDispatcher.cast_shapes(&pose, lines[i].1.as_vec3(), shapes.0, shapes.1, options);
            hits[1] += usize::from(found.is_ok_and(|found| found.is_some()));
        }));
    }
    println!(
        "casts of 32 vertices: {:.1} µs, parry {:.1}; {} and {} of {count} hit",
        median(ours),
        median(parry),
        hits[0],
        hits[1]
    );
}
