//! Times queries beside an older commit's, in one process, and prints the ratio of every cell.
//!
//! # Steps
//! 1. Bake the same points with both versions.
//! 2. In each round, time a cell with one version, then with the other, in alternating order.
//! 3. A cell's ratio is the median over the rounds. Time is the processor's, so that work beside it
//!    counts only by what it takes from the caches.
//!
//! The functions of both versions are in one program, so the place of code in memory differs, too.
//! That alone changes a cell by up to 2 %.

use std::hint::black_box;
use std::process::ExitCode;

use clap::Parser;
use cpu_time::ThreadTime;
use glam::{DQuat, DVec3};
use shapes::families::Family;
use shapes::rng::SplitMix64;

/// Times queries beside an older commit's, in one process.
#[derive(Parser)]
struct Arguments {
    /// Vertices of each hull, separated by commas
    #[arg(long, value_delimiter = ',', default_values_t = [8, 32, 128, 512, 2048])]
    n: Vec<usize>,
    /// Rounds of each cell
    #[arg(long, default_value_t = 31)]
    rounds: usize,
    /// Only cells whose names contain this
    #[arg(long, default_value = "")]
    only: String,
    /// Name the cells whose ratio exceeds this, and exit with 1 if there are any
    #[arg(long, value_name = "RATIO")]
    fail_above: Option<f64>,
}

/// The families whose hulls are timed.
const FAMILIES: [Family; 3] = [Family::Sphere, Family::ClusteredEllipsoid, Family::Rock];

/// Poses of each family and class, and seed of all random numbers.
const POSES: usize = 60;
const SEED: u64 = 20_261_128;

/// Frames of a path, distance between two frames over the mean diameter, and the angle of a frame.
const FRAMES: usize = 16;
const STEP: f64 = 0.01;
const TURN_RAD: f64 = std::f64::consts::PI / 180.0;

/// Minimum and maximum distance of a class, over the touching distance.
const CLASSES: [(&str, [f64; 2]); 3] =
    [("penetrating", [0.0, 0.9]), ("near touching", [0.98, 1.02]), ("separated", [1.05, 2.0])];

/// The class of hulls that lie on each other, face on face. The depth and the steps of a path are
/// fractions of the others.
const RESTING: &str = "resting";
const RESTING_DEPTH: f64 = 0.005;
const RESTING_STEP: f64 = 0.01;

/// A pose of B in A's frame.
type Placed = (DVec3, DQuat);

/// A query, and whether caches are kept along paths.
#[derive(Clone, Copy, PartialEq)]
enum Query {
    Intersects,
    Distance,
    Contact,
    Manifold,
}

/// The queries, as one version answers them. All versions have these names.
macro_rules! version {
    ($name:ident, $hullmap:ident, $bake:ident) => {
        mod $name {
            use super::{DVec3, Placed, Query, ThreadTime, black_box};
            use $bake::{IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
            use $hullmap::{Cache, Hull, Manifold, ManifoldSettings, Pack, Pose, Settings};

            pub struct Pair([Pack; 2], Vec<Manifold>);

            impl Pair {
                pub fn new(points: [Vec<[f32; 3]>; 2]) -> Self {
                    let packs = points.map(|positions| {
                        let source_vertices = (0..positions.len() as u32).collect();
                        let points = PointSet { positions, source_vertices, ..PointSet::default() };
                        let baked = bake_hull(&points, IndexKind::Tree).expect("the points span a hull");
                        let bytes = write_pack(&[baked], &SourceRecord::default()).expect("a hull can be written");
                        Pack::from_bytes(&bytes).expect("a pack just written opens")
                    });
                    Self(packs, Vec::new())
                }

                fn hulls(&self) -> [Hull<'_>; 2] {
                    self.0.each_ref().map(|pack| pack.hull(0).expect("a pack has a hull"))
                }

                #[allow(dead_code, reason = "one version finds the poses of both")]
                pub fn diameter(&self) -> f64 {
                    let [a, b] = self.hulls();
                    0.5 * (a.diameter() + b.diameter())
                }

                /// The middle and the normal of a face of each hull.
                #[allow(dead_code, reason = "one version finds the poses of both")]
                pub fn faces(&self, of: [usize; 2]) -> [(DVec3, DVec3); 2] {
                    let hulls = self.hulls();
                    [0, 1].map(|side| {
                        let face = (of[side] % hulls[side].face_count()) as u32;
                        let corners: Vec<DVec3> =
                            hulls[side].face(face).filter_map(|v| Some(hulls[side].vertex(v)?.as_dvec3())).collect();
                        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
                        (middle, hulls[side].face_normal(face).expect("a solid's face has a normal"))
                    })
                }

                #[allow(dead_code, reason = "one version finds the poses of both")]
                pub fn overlaps(&self, placed: Placed) -> bool {
                    let [a, b] = self.hulls();
                    $hullmap::intersects(&a, &b, pose(placed), &mut Cache::new()).is_hit()
                }

                /// Nanoseconds of all poses. Frames of a path follow each other; each path has a
                /// cache.
                pub fn time(&mut self, query: Query, placed: &[Placed], frames: usize) -> f64 {
                    let poses: Vec<Pose> = placed.iter().map(|placed| pose(*placed)).collect();
                    let paths = poses.len() / frames;
                    let mut caches = vec![Cache::new(); paths];
                    let mut manifolds = std::mem::take(&mut self.1);
                    manifolds.clear();
                    manifolds.resize(paths, Manifold::new());
                    let ([a, b], settings) = (self.hulls(), Settings::default());
                    let mut sum = DVec3::ZERO;
                    let start = ThreadTime::now();
                    for (at, b_in_a) in poses.iter().enumerate() {
                        let path = at % paths;
                        let (b_in_a, cache) = (black_box(*b_in_a), &mut caches[path]);
                        sum += match query {
                            Query::Intersects => {
                                DVec3::splat($hullmap::intersects(&a, &b, b_in_a, cache).support_calls.into())
                            }
                            Query::Distance => $hullmap::distance(&a, &b, b_in_a, &settings, cache).normal,
                            Query::Contact => $hullmap::contact(&a, &b, b_in_a, &settings, cache).normal,
                            Query::Manifold => {
                                manifolds[path].update(&a, &b, b_in_a, &ManifoldSettings::default(), cache).normal
                            }
                        };
                    }
                    let elapsed = start.elapsed().as_nanos() as f64;
                    black_box(sum);
                    self.1 = manifolds;
                    elapsed
                }
            }

            fn pose((translation, rotation): Placed) -> Pose {
                Pose::new(translation, rotation).expect("finite")
            }
        }
    };
}

version!(before, then, then_bake);
version!(here, now, now_bake);

/// Two hulls of a family, baked by both versions, and their poses.
struct Subject {
    before: before::Pair,
    here: here::Pair,
    /// For each class, single poses and the frames of paths.
    placed: Vec<[Vec<Placed>; 2]>,
}

impl Subject {
    fn new(family: Family, n: usize, rng: &mut SplitMix64) -> Self {
        let points = [0, 1].map(|index| family.points(n, SEED + index));
        let (before, here) = (before::Pair::new(points.clone()), here::Pair::new(points));
        let mut placed = CLASSES.map(|(_, [low, high])| {
            let middles: Vec<[DVec3; 2]> = (0..POSES)
                .map(|_| {
                    let rotation = DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize();
                    let (out, side) = (DVec3::from_array(rng.direction()), DVec3::from_array(rng.direction()));
                    let reach = touching_distance(&here, rotation, out) * rng.between(low, high);
                    [out * reach, side.cross(out).normalize()]
                })
                .collect();
            let mut rotations = rng.clone();
            let turns: Vec<DQuat> = (0..POSES)
                .map(|_| DQuat::from_array([(); 4].map(|()| rotations.between(-1.0, 1.0))).normalize())
                .collect();
            let at = |frame: f64| {
                let moved = |(&[middle, side], &turn): (&[DVec3; 2], &DQuat)| {
                    let turned = DQuat::from_axis_angle(side, frame * TURN_RAD) * turn;
                    (middle + side * (frame * STEP * here.diameter()), turned)
                };
                middles.iter().zip(&turns).map(moved).collect::<Vec<Placed>>()
            };
            let frames = (0..FRAMES).flat_map(|frame| at(frame as f64 - 0.5 * FRAMES as f64));
            [at(0.0), frames.collect()]
        })
        .to_vec();
        placed.push(resting(&here, rng));
        Self { before, here, placed }
    }
}

/// Poses face on face, and paths that slide and turn a little.
fn resting(pair: &here::Pair, rng: &mut SplitMix64) -> [Vec<Placed>; 2] {
    let faces: Vec<[usize; 2]> = (0..POSES).map(|_| [(); 2].map(|()| rng.next_u64() as usize)).collect();
    let at = |frame: f64| {
        let placed = faces.iter().map(|&faces| {
            let [(on_a, normal), (on_b, facing)] = pair.faces(faces);
            let turn = DQuat::from_axis_angle(normal, frame * RESTING_STEP * TURN_RAD);
            let rotation = turn * DQuat::from_rotation_arc(facing, -normal);
            let side = normal.any_orthonormal_vector() * (frame * RESTING_STEP * STEP);
            (on_a - rotation * on_b + (side - normal * RESTING_DEPTH) * pair.diameter(), rotation)
        });
        placed.collect::<Vec<Placed>>()
    };
    let frames = (0..FRAMES).flat_map(|frame| at(frame as f64 - 0.5 * FRAMES as f64));
    [at(0.0), frames.collect()]
}

/// The distance of the origins at which the hulls touch, by bisection.
fn touching_distance(pair: &here::Pair, rotation: DQuat, out: DVec3) -> f64 {
    let (mut low, mut high) = (0.0, 4.0 * pair.diameter());
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if pair.overlaps((out * middle, rotation)) { low = middle } else { high = middle }
    }
    low
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let mut slower = Vec::new();
    println!("{:>6}  {:<36} {:>9} {:>9}  {:>6}  {:>13}", "n", "query", "then, ns", "now, ns", "ratio", "quartiles");
    for &n in &arguments.n {
        let mut rng = SplitMix64::new(SEED ^ n as u64);
        let mut subjects: Vec<Subject> = FAMILIES.iter().map(|&family| Subject::new(family, n, &mut rng)).collect();
        let queries = [
            ("intersects", Query::Intersects),
            ("distance", Query::Distance),
            ("contact", Query::Contact),
            ("manifold", Query::Manifold),
        ];
        for ((name, query), class, warm) in queries
            .into_iter()
            .flat_map(|query| (0..=CLASSES.len()).flat_map(move |class| [0, 1].map(|warm| (query, class, warm))))
        {
            let title = CLASSES.get(class).map_or(RESTING, |(title, _)| title);
            let name = format!("{name}, {title}, {}", ["cold", "along paths"][warm]);
            if !name.contains(&arguments.only) {
                continue;
            }
            let ratio = cell(&mut subjects, query, class, warm, arguments.rounds, &format!("{n:>6}  {name:<36}"));
            if arguments.fail_above.is_some_and(|limit| ratio > limit) {
                slower.push(format!("slower: {n} {name}: {ratio:.3}"));
            }
        }
    }
    slower.iter().for_each(|cell| eprintln!("{cell}"));
    if slower.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(1) }
}

/// Times one cell, prints its row, and returns its ratio.
fn cell(subjects: &mut [Subject], query: Query, class: usize, warm: usize, rounds: usize, title: &str) -> f64 {
    let (mut ratios, mut times) = (Vec::new(), [Vec::new(), Vec::new()]);
    for round in 0..=rounds {
        let mut sums = [0.0; 2];
        let mut count = 0;
        for Subject { before, here, placed } in subjects.iter_mut() {
            let placed = &placed[class][warm];
            let frames = if warm == 1 { FRAMES } else { 1 };
            // The order alternates.
            for side in [round % 2, 1 - round % 2] {
                sums[side] += match side {
                    0 => before.time(query, placed, frames),
                    _ => here.time(query, placed, frames),
                };
            }
            count += placed.len();
        }
        // The first round fetches the hulls into caches.
        if round > 0 {
            ratios.push(sums[1] / sums[0]);
            times.iter_mut().zip(sums).for_each(|(times, sum)| times.push(sum / count as f64));
        }
    }
    let [then, now] = times.each_mut().map(|times| median(times));
    let ratio = median(&mut ratios);
    let quartiles = [ratios[rounds / 4], ratios[rounds * 3 / 4]];
    println!("{title} {then:>9.1} {now:>9.1}  {ratio:>6.3}  {:>5.3} - {:.3}", quartiles[0], quartiles[1]);
    ratio
}
