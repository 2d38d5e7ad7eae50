//! Decomposes random and damaged meshes and judges every claim by sampling.
//!
//! ```text
//! cargo run --release -p hullmap-tests --bin decompose-soak -- --meshes 10000 --seed 1
//! ```
//!
//! The judge measures by other code than the bounds: winding numbers are sums of solid angles,
//! distances are brute force over all triangles, and points are compared with all planes of a part.
//! Only the inside of a mesh that is not watertight is that of [`Solid`], since it is a convention.
//! Ends with status 1 if a claim is false or a mesh takes longer than `--seconds`.

use std::{process::ExitCode, time::Instant};

use clap::Parser;
use glam::DVec3;
use hullmap_bake::{
    PointSet, SolidKind,
    decompose::{Cover, Length, Method, decompose},
    hull::{self, Hull},
    parts::{Solid, fits},
};
use rayon::prelude::*;
use shapes::rng::SplitMix64;

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
    /// Maximum time for a mesh, in seconds
    #[arg(long, default_value_t = 60.0)]
    seconds: f64,
}

/// What came of one mesh.
enum Outcome {
    Refused,
    Convex,
    Parts { count: usize, protruding: bool },
    False(String),
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let seeds = arguments.seed..arguments.seed.saturating_add(arguments.meshes);
    let outcomes: Vec<(u64, Outcome, f64)> = seeds
        .into_par_iter()
        .map(|seed| {
            let start = Instant::now();
            let outcome = judge(seed, &arguments);
            (seed, outcome, start.elapsed().as_secs_f64())
        })
        .collect();
    let (mut refused, mut convex, mut decomposed, mut parts, mut protruding, mut faults) = (0, 0, 0, 0, 0, 0);
    for (seed, outcome, seconds) in &outcomes {
        if *seconds > arguments.seconds {
            faults += 1;
            println!("seed {seed}: took {seconds:.1} s");
        }
        match outcome {
            Outcome::Refused => refused += 1,
            Outcome::Convex => convex += 1,
            Outcome::Parts { count, protruding: is } => {
                decomposed += 1;
                parts += count;
                protruding += u64::from(*is);
            }
            Outcome::False(why) => {
                faults += 1;
                println!("seed {seed}: {why}");
            }
        }
    }
    let slowest = outcomes.iter().map(|(_, _, seconds)| *seconds).fold(0.0, f64::max);
    println!(
        "{} meshes: {decomposed} decomposed into {parts} parts ({protruding} with protruding parts), {convex} convex, \
         {refused} refused; slowest {slowest:.1} s; {faults} faults",
        outcomes.len()
    );
    // A sample of convex meshes would prove nothing.
    let is_representative = decomposed * 2 > outcomes.len() as u64 && protruding * 4 > decomposed;
    if !is_representative {
        println!("the sample is not representative");
    }
    if faults == 0 && is_representative { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn judge(seed: u64, arguments: &Arguments) -> Outcome {
    let mut rng = SplitMix64::new(seed);
    let mesh = mesh(&mut rng);
    let share = [0.005, 0.02, 0.05, 0.2][index(&mut rng, 4)];
    let cover = Cover { max_error: Length::Relative(share), ..Cover::default() };
    let sets = match decompose(&mesh, &Method::Cover(cover)) {
        Err(_) => return Outcome::Refused,
        Ok(None) => return Outcome::Convex,
        Ok(Some(sets)) => sets,
    };
    let hulls: Vec<Hull> = match sets.iter().map(hull::build).collect() {
        Ok(hulls) => hulls,
        Err(error) => return Outcome::False(format!("a part cannot be built: {error}")),
    };
    let triangles = triangles(&mesh);
    let corners = || triangles.iter().flatten().copied();
    let diagonal =
        corners().fold(DVec3::NEG_INFINITY, DVec3::max).distance(corners().fold(DVec3::INFINITY, DVec3::min));
    let Some(fits) = fits(&mesh, &hulls.iter().collect::<Vec<_>>(), Some(share * diagonal)) else {
        return Outcome::False("no claim".to_owned());
    };
    let (claimed, limit) = (fits[0].uncovered, share * diagonal);
    // What is inside an open mesh is a convention, not a fact.
    let solid = Solid::new(&mesh);
    let is_inside = |p: DVec3| match fits[0].solid {
        SolidKind::Watertight => is_inside(&triangles, p),
        _ => solid.is_inside(p),
    };
    if claimed > 1e-7 * diagonal {
        return Outcome::False(format!("uncovered by {:.2e} of the diagonal", claimed / diagonal));
    }
    if let Some(fit) = fits.iter().find(|fit| fit.protrusion > limit) {
        return Outcome::False(format!("a part protrudes by {:.6} of the limit", fit.protrusion / limit));
    }
    if let Some(hull) = hulls.iter().find(|hull| hull.vertices.len() > cover.max_vertices as usize) {
        return Outcome::False(format!("a part has {} vertices", hull.vertices.len()));
    }
    // The closing triangles are near the solid as well, if anything is inside them.
    let surface = if fits[0].solid == SolidKind::Watertight { &triangles } else { solid.triangles() };
    let planes: Vec<Vec<(DVec3, f64)>> = hulls.iter().map(planes).collect();
    for at in 0..arguments.samples {
        let p = in_triangle(&triangles[at % triangles.len()], &mut rng);
        let height =
            |planes: &Vec<(DVec3, f64)>| planes.iter().map(|(n, d)| n.dot(p) - d).fold(f64::NEG_INFINITY, f64::max);
        // The height above a part's planes is at most its distance.
        let least = planes.iter().map(height).fold(f64::INFINITY, f64::min);
        if least > claimed + 1e-9 * diagonal {
            return Outcome::False(format!("{p} is {:.2e} outside all parts, claimed {claimed:.2e}", least));
        }
    }
    let mut greatest = 0.0_f64;
    for at in 0..arguments.samples {
        let part = at % hulls.len();
        let p = on_hull(&hulls[part], &mut rng);
        let distance = distance(surface, p);
        if distance > fits[part].protrusion + 2e-6 * diagonal && !is_inside(p) {
            return Outcome::False(format!(
                "part {part} protrudes by {distance:.6e} at {p}, claimed {:.6e}",
                fits[part].protrusion
            ));
        }
        greatest = greatest.max(fits[part].protrusion);
    }
    Outcome::Parts { count: hulls.len(), protruding: greatest > 1e-3 * limit }
}

fn index(rng: &mut SplitMix64, count: usize) -> usize {
    ((rng.unit() * count as f64) as usize).min(count - 1)
}

/// A random mesh: a union of boxes, prisms and soups, then damaged, scaled and moved.
fn mesh(rng: &mut SplitMix64) -> PointSet {
    let mut positions: Vec<DVec3> = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for _ in 0..1 + index(rng, 3) {
        let first = positions.len() as u32;
        let (corners, faces) = match index(rng, 4) {
            0 => block(rng),
            1 => prism(rng),
            2 => ring(rng),
            _ => soup(rng),
        };
        positions.extend(corners);
        triangles.extend(faces.into_iter().map(|t| t.map(|v| v + first)));
    }
    match index(rng, 8) {
        0 => {
            triangles.remove(index(rng, triangles.len()));
        }
        1 => {
            let at = index(rng, triangles.len());
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
    let scale = [1.0, 1.0, 1.0, 1e-12, 1e12][index(rng, 5)];
    let stretch = [DVec3::ONE, DVec3::ONE, DVec3::new(1.0, 1.0, 1e-3), DVec3::new(1.0, 1e-2, 1e-2)][index(rng, 4)];
    let offset = [0.0, 0.0, 0.0, 0.5][index(rng, 4)];
    let positions: Vec<[f32; 3]> =
        positions.iter().map(|p| ((*p + offset) * stretch * scale).as_vec3().to_array()).collect();
    PointSet {
        name: "random".to_owned(),
        source_vertices: (0..positions.len() as u32).collect(),
        positions,
        triangles,
        ..PointSet::default()
    }
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
    let (count, centre, height) = (3 + index(rng, 6), point(rng), 0.1 + rng.unit());
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
    let (around, across, thin) = (3 + index(rng, 8) as u32, 3 + index(rng, 4) as u32, 0.1 + 0.35 * rng.unit());
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
    let count = 4 + index(rng, 10);
    let positions = (0..count).map(|_| point(rng)).collect();
    let triangles = (0..3 + index(rng, 14)).map(|_| std::array::from_fn(|_| index(rng, count) as u32)).collect();
    (positions, triangles)
}

fn triangles(mesh: &PointSet) -> Vec<[DVec3; 3]> {
    let at = |v: u32| DVec3::from_array(mesh.positions[v as usize].map(f64::from));
    mesh.triangles.iter().map(|t| t.map(at)).collect()
}

/// Outward unit normals and offsets of a part's faces.
fn planes(hull: &Hull) -> Vec<(DVec3, f64)> {
    let positions = hull.positions();
    let plane = |face: &Vec<u32>| {
        let corner = |i: usize| positions[face[i] as usize];
        let areas = (1..face.len() - 1).map(|i| (corner(i) - corner(0)).cross(corner(i + 1) - corner(0)));
        let normal = areas.sum::<DVec3>().try_normalize()?;
        Some((normal, positions.iter().map(|p| p.dot(normal)).fold(f64::NEG_INFINITY, f64::max)))
    };
    hull.faces.iter().filter_map(plane).collect()
}

fn in_triangle(&[a, b, c]: &[DVec3; 3], rng: &mut SplitMix64) -> DVec3 {
    let (mut u, mut v) = (rng.unit(), rng.unit());
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    a + u * (b - a) + v * (c - a)
}

/// A point on a face of a part.
fn on_hull(hull: &Hull, rng: &mut SplitMix64) -> DVec3 {
    let positions = hull.positions();
    if hull.faces.is_empty() {
        return positions[0];
    }
    let face = &hull.faces[index(rng, hull.faces.len())];
    let second = 1 + index(rng, face.len() - 2);
    in_triangle(&[face[0], face[second], face[second + 1]].map(|v| positions[v as usize]), rng)
}

/// Distance from all triangles: the nearest of a triangle's interior, edges and corners.
fn distance(triangles: &[[DVec3; 3]], p: DVec3) -> f64 {
    let to_segment = |a: DVec3, b: DVec3| {
        let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        // NaN if both ends are equal.
        if along.is_nan() { p.distance(a) } else { p.distance(a + along * (b - a)) }
    };
    let to_triangle = |[a, b, c]: &[DVec3; 3]| {
        let normal = (*b - *a).cross(*c - *a);
        let is_above =
            [(*a, *b), (*b, *c), (*c, *a)].iter().all(|(from, to)| normal.dot((*to - *from).cross(p - *from)) > 0.0);
        let edges = to_segment(*a, *b).min(to_segment(*b, *c)).min(to_segment(*c, *a));
        if is_above { edges.min((p - *a).dot(normal).abs() / normal.length()) } else { edges }
    };
    triangles.iter().map(to_triangle).fold(f64::INFINITY, f64::min)
}

/// Whether the solid angles of the triangles amount to more than a quarter of a turn: generous, so
/// that no claim is called false at an open mesh, whose inside is a convention.
fn is_inside(triangles: &[[DVec3; 3]], p: DVec3) -> bool {
    let mut sum = 0.0;
    for [a, b, c] in triangles.iter().map(|t| t.map(|corner| corner - p)) {
        let [la, lb, lc] = [a.length(), b.length(), c.length()];
        sum += 2.0 * f64::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    (sum / (4.0 * std::f64::consts::PI)).abs() > 0.25
}
