//! Decomposes random and damaged meshes and judges every claim by sampling.
//!
//! ```text
//! cargo program decompose-soak -- --meshes 10000 --seed 1
//! ```
//!
//! The judge is [`hullmap_tests::sampler`], which shares no code with the bounds. Ends with status
//! 1 if a claim is false or a mesh takes longer than `--seconds`. Faults are printed as they are
//! found, the slowest meshes at the end.

use std::{
    fs,
    ops::Range,
    path::PathBuf,
    process::ExitCode,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
};

use clap::Parser;
use glam::DVec3;
use hullmap_bake::{
    PointSet,
    decompose::{Cover, Length, decompose},
    fit::{Solid, fits},
    hull::{self, Hull},
};
use hullmap_testkit::{clock::timed, packs::point_set};
use hullmap_tests::sampler::refutation;
use shapes::{mesh::Mesh, obj, rng::SplitMix64};

/// Convex decompositions of random meshes, judged by sampling.
#[derive(Parser)]
struct Arguments {
    /// Number of meshes
    #[arg(long, default_value_t = 10_000)]
    meshes: u64,
    /// Seed of the first mesh; the others count up from it
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of sample points for each mesh's surface and for each mesh's parts
    #[arg(long, default_value_t = 600)]
    samples: usize,
    /// Maximum processor time for a mesh, in seconds
    #[arg(long, default_value_t = 30.0)]
    seconds: f64,
    /// Folder for the meshes as OBJ files
    #[arg(long)]
    keep: Option<PathBuf>,
}

/// Outcome of one mesh.
enum Outcome {
    Rejected,
    Convex,
    Parts { count: usize, protruding: bool },
    False(String),
}

/// Number of slow meshes that are printed.
const SLOWEST: usize = 5;

/// Number of meshes after which progress is reported.
const PROGRESS: u64 = 500;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let seeds = arguments.seed..arguments.seed.saturating_add(arguments.meshes);
    let mut outcomes = judged(seeds, &arguments);
    let (mut rejected, mut convex, mut decomposed, mut parts, mut protruding, mut faults) = (0, 0, 0, 0, 0, 0);
    for (_, outcome, seconds) in &outcomes {
        faults += u64::from(*seconds > arguments.seconds);
        match outcome {
            Outcome::Rejected => rejected += 1,
            Outcome::Convex => convex += 1,
            Outcome::Parts { count, protruding: is } => {
                decomposed += 1;
                parts += count;
                protruding += u64::from(*is);
            }
            Outcome::False(_) => faults += 1,
        }
    }
    println!(
        "{} meshes: {decomposed} decomposed into {parts} parts ({protruding} with protruding parts), {convex} convex, \
         {rejected} rejected; {faults} faults",
        outcomes.len()
    );
    outcomes.sort_by(|a, b| b.2.total_cmp(&a.2));
    let slowest: Vec<String> =
        outcomes.iter().take(SLOWEST).map(|(seed, _, seconds)| format!("{seed} ({seconds:.1} s)")).collect();
    println!("slowest seeds: {}", slowest.join(", "));
    // A sample of convex meshes would prove nothing.
    let is_representative = decomposed * 2 > outcomes.len() as u64 && protruding * 4 > decomposed;
    if !is_representative {
        println!("the sample is not representative");
    }
    if faults == 0 && is_representative { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The outcome of each seed, and its seconds. Each worker has a thread pool of one thread: in a
/// shared pool, a mesh's time would include other meshes, which its thread takes on while it waits.
fn judged(seeds: Range<u64>, arguments: &Arguments) -> Vec<(u64, Outcome, f64)> {
    let (first, end) = (seeds.start, seeds.end);
    let next = AtomicU64::new(first);
    let outcomes = Mutex::new(Vec::new());
    let work = || {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread can be started");
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= end {
                return;
            }
            let (outcome, seconds) = pool.install(|| timed(|| judge(seed, arguments)));
            if let Outcome::False(why) = &outcome {
                println!("seed {seed}: {why}");
            }
            if seconds > arguments.seconds {
                println!("seed {seed}: took {seconds:.1} s");
            }
            if (seed - first + 1).is_multiple_of(PROGRESS) {
                eprintln!("{} meshes begun", seed - first + 1);
            }
            outcomes.lock().unwrap_or_else(PoisonError::into_inner).push((seed, outcome, seconds));
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..rayon::current_num_threads() {
            scope.spawn(work);
        }
    });
    outcomes.into_inner().unwrap_or_else(PoisonError::into_inner)
}

fn judge(seed: u64, arguments: &Arguments) -> Outcome {
    let mut rng = SplitMix64::new(seed);
    let mesh = mesh(&mut rng);
    let share = [0.005, 0.02, 0.05, 0.2][rng.below(4)];
    if let Some(folder) = &arguments.keep {
        let faces = mesh.triangles.iter().map(|corners| corners.to_vec()).collect();
        let text = obj::text(&Mesh { vertices: mesh.positions.clone(), faces });
        fs::write(folder.join(format!("{seed}.obj")), format!("# maximum error {share}\n{text}"))
            .expect("the folder exists");
    }
    let cover = Cover { max_error: Length::Relative(share), ..Cover::default() };
    let sets = match decompose(&mesh, &cover) {
        Err(_) => return Outcome::Rejected,
        Ok(None) => return Outcome::Convex,
        Ok(Some(sets)) => sets,
    };
    let hulls: Vec<Hull> = match sets.iter().map(hull::build).collect() {
        Ok(hulls) => hulls,
        Err(error) => return Outcome::False(format!("a part cannot be built: {error}")),
    };
    let diagonal = Solid::new(&mesh).diagonal();
    let limit = share * diagonal;
    let Some(fits) = fits(&mesh, &hulls.iter().collect::<Vec<_>>(), Some(limit)) else {
        return Outcome::False("no claim".to_owned());
    };
    let claimed = fits[0].uncovered;
    if claimed > 1e-7 * diagonal {
        return Outcome::False(format!("uncovered by {:.2e} of the diagonal", claimed / diagonal));
    }
    if let Some(fit) = fits.iter().find(|fit| fit.protrusion > limit) {
        return Outcome::False(format!("a part protrudes by {:.6} of the limit", fit.protrusion / limit));
    }
    let most = if hulls.len() > 1 { cover.part_vertices() } else { cover.one_part_vertices() };
    if let Some(hull) = hulls.iter().find(|hull| hull.vertices.len() > most as usize) {
        return Outcome::False(format!("a part has {} vertices", hull.vertices.len()));
    }
    if let Some(why) = refutation(&mesh, &hulls, &fits, 2 * arguments.samples, seed) {
        return Outcome::False(why);
    }
    let greatest = fits.iter().map(|fit| fit.protrusion).fold(0.0, f64::max);
    Outcome::Parts { count: hulls.len(), protruding: greatest > 1e-3 * limit }
}

/// A random mesh: a union of boxes, prisms and soups, then damaged, scaled and moved.
fn mesh(rng: &mut SplitMix64) -> PointSet {
    let mut positions: Vec<DVec3> = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for _ in 0..1 + rng.below(3) {
        let first = positions.len() as u32;
        let (corners, faces) = match rng.below(4) {
            0 => block(rng),
            1 => prism(rng),
            2 => ring(rng),
            _ => soup(rng),
        };
        positions.extend(corners);
        triangles.extend(faces.into_iter().map(|t| t.map(|v| v + first)));
    }
    match rng.below(8) {
        0 => {
            triangles.remove(rng.below(triangles.len()));
        }
        1 => {
            let at = rng.below(triangles.len());
            triangles[at].swap(0, 1);
        }
        2 => triangles.extend(triangles.clone()),
        3 => triangles.iter_mut().for_each(|t| t.swap(0, 1)),
        4 => {
            // Corners of their own, apart by rounding.
            positions =
                triangles.iter().flatten().map(|v| positions[*v as usize] + DVec3::splat(1e-8 * rng.unit())).collect();
            triangles = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        }
        5 => triangles.push([0, 0, 1]),
        _ => {}
    }
    if triangles.is_empty() {
        triangles.push([0, 1, 2]);
    }
    let scale = [1.0, 1.0, 1.0, 1e-12, 1e12][rng.below(5)];
    let stretch = [DVec3::ONE, DVec3::ONE, DVec3::new(1.0, 1.0, 1e-3), DVec3::new(1.0, 1e-2, 1e-2)][rng.below(4)];
    let offset = [0.0, 0.0, 0.0, 0.5][rng.below(4)];
    let positions: Vec<[f32; 3]> =
        positions.iter().map(|p| ((*p + offset) * stretch * scale).as_vec3().to_array()).collect();
    PointSet { triangles, ..point_set("random", &positions) }
}

type Piece = (Vec<DVec3>, Vec<[u32; 3]>);

fn point(rng: &mut SplitMix64) -> DVec3 {
    DVec3::new(rng.unit(), rng.unit(), rng.unit())
}

/// A box, aligned or sheared.
fn block(rng: &mut SplitMix64) -> Piece {
    let (low, size, shear) = (point(rng), point(rng) + 0.05, if rng.unit() < 0.5 { 0.0 } else { rng.unit() });
    let corner = |i: usize| {
        let p = DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64) * size;
        low + DVec3::new(p.x + shear * p.y, p.y + shear * p.z, p.z)
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    ((0..8).map(corner).collect(), quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

/// A prism over a star, which is concave.
fn prism(rng: &mut SplitMix64) -> Piece {
    let (count, centre, height) = (3 + rng.below(6), point(rng), 0.1 + rng.unit());
    let outline: Vec<DVec3> = (0..count)
        .map(|i| {
            let angle = std::f64::consts::TAU * i as f64 / count as f64;
            let radius = 0.1 + rng.unit();
            centre + DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
        })
        .collect();
    let mut positions = vec![centre, centre + DVec3::Z * height];
    positions.extend(outline.iter().flat_map(|p| [*p, *p + DVec3::Z * height]));
    let mut triangles = Vec::new();
    for i in 0..count as u32 {
        let (a, b) = (2 + 2 * i, 2 + 2 * ((i + 1) % count as u32));
        triangles.extend([[0, b, a], [1, a + 1, b + 1], [a, b, b + 1], [a, b + 1, a + 1]]);
    }
    (positions, triangles)
}

/// A torus of few triangles.
fn ring(rng: &mut SplitMix64) -> Piece {
    let (around, across, thin) = (3 + rng.below(8) as u32, 3 + rng.below(4) as u32, 0.1 + 0.35 * rng.unit());
    let centre = point(rng);
    let turn = |i: u32, count: u32| std::f64::consts::TAU * f64::from(i) / f64::from(count);
    let corner = |i: u32, j: u32| {
        let (u, v) = (turn(i, around), turn(j, across));
        let radius = 0.5 + 0.5 * thin * v.cos();
        centre + DVec3::new(radius * u.cos(), radius * u.sin(), 0.5 * thin * v.sin())
    };
    let positions = (0..around).flat_map(|i| (0..across).map(move |j| (i, j))).map(|(i, j)| corner(i, j)).collect();
    let at = |i: u32, j: u32| (i % around) * across + j % across;
    let quads = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let triangles = quads
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    (positions, triangles)
}

/// Triangles between random points.
fn soup(rng: &mut SplitMix64) -> Piece {
    let count = 4 + rng.below(10);
    let positions = (0..count).map(|_| point(rng)).collect();
    let triangles = (0..3 + rng.below(14)).map(|_| std::array::from_fn(|_| rng.below(count) as u32)).collect();
    (positions, triangles)
}
