//! From arrays to convex parts.
//!
//! 1. Check the arrays. Positions are taken relative to the centre of the box around them, and
//!    equal ones are merged.
//! 2. Decompose the mesh. A convex mesh gives its hull, simplified if it has too many vertices.
//! 3. Measure cover and protrusion, and how the parts fit together.

#![forbid(unsafe_code)]

use std::collections::HashMap;
use std::time::Instant;

use hullmap_bake::deadline::{Deadline, is_over};
use hullmap_bake::decompose::{Cover, Length, decompose_in};
use hullmap_bake::fit::{SolidRule, fits_around, looseness, mesh_mass, voids};
use hullmap_bake::hull::{self, Hull};
use hullmap_bake::mass::{Mass, mass};
use hullmap_bake::progress::{Progress, Stage};
use hullmap_bake::simplify::{Limit, MIN_VERTICES, simplify};
use hullmap_bake::{BakeError, MAX_POINTS, PointSet};
use hullmap_geometry::diagonal;

use crate::failure::Failure;
use crate::types::{Facts, Options, Part, Result as Code};

/// A decomposition of a mesh into convex parts.
#[derive(Debug)]
pub struct Decomposition {
    parts: Vec<OwnedPart>,
    facts: Facts,
}

/// The arrays of a part.
#[derive(Debug)]
struct OwnedPart {
    vertices: Vec<f64>,
    triangles: Vec<u32>,
    volume: f64,
    center: [f64; 3],
    protrusion: f64,
}

impl Decomposition {
    /// Facts about it.
    pub fn facts(&self) -> Facts {
        self.facts
    }

    /// The part with this index.
    pub fn part(&self, index: usize) -> Option<Part> {
        let part = self.parts.get(index)?;
        Some(Part {
            vertices: part.vertices.as_ptr(),
            vertex_count: (part.vertices.len() / 3) as u32,
            triangle_count: (part.triangles.len() / 3) as u32,
            triangles: part.triangles.as_ptr(),
            volume: part.volume,
            center: part.center,
            protrusion: part.protrusion,
        })
    }
}

/// Decomposes a mesh of `triangles` with corners among `points`.
///
/// # Errors
/// Wrong arrays or options, a mesh without a hull, or `progress` was cancelled.
pub fn decompose(
    points: &[[f64; 3]],
    triangles: &[[u32; 3]],
    options: Option<Options>,
    progress: Option<&Progress>,
) -> Result<Decomposition, Failure> {
    let start = Instant::now();
    let cover = options.map_or_else(|| Ok(Cover::default()), |options| cover(&options))?;
    let stage = progress.map_or_else(Stage::default, Progress::whole);
    let mesh = point_set(points, triangles)?;
    let rejected = |error: BakeError| Failure::new(Code::Rejected, error);
    let hulls: Vec<Hull> = match decompose_in(&mesh, &cover, stage.from_to(0.0, 0.8)).map_err(rejected)? {
        Some(parts) => parts.iter().map(hull::build).collect::<Result<_, _>>().map_err(rejected)?,
        None => vec![whole(&mesh, cover.one_part_vertices()).map_err(rejected)?],
    };
    if stage.is_cancelled() {
        return Err(Failure::new(Code::Cancelled, "the decomposition was cancelled; start it again"));
    }
    let spent = start.elapsed().as_secs_f64();
    let deadline = cover.seconds.map(|seconds| Deadline::after((seconds - spent).max(0.0)));
    let (parts, facts) = measured(&mesh, &cover, &hulls, deadline);
    stage.reach(1.0);
    Ok(Decomposition { parts, facts })
}

/// The arrays of the parts, with their bounds, and the facts about all of them. After the deadline,
/// bounds are coarse, and estimates are left out.
fn measured(mesh: &PointSet, cover: &Cover, hulls: &[Hull], deadline: Option<Deadline>) -> (Vec<OwnedPart>, Facts) {
    let all: Vec<&Hull> = hulls.iter().collect();
    // With a maximum number of parts, the limit is not proven.
    let limit = cover.max_parts.is_none().then(|| cover.max_error.resolve(diagonal(&mesh.positions)));
    let solid = (!mesh.triangles.is_empty()).then(|| cover.solid_of(mesh));
    let fits = solid.as_ref().and_then(|solid| fits_around(solid, mesh, &all, limit, deadline));
    let protrusion = |index: usize| fits.as_ref().and_then(|fits| fits.get(index)).map_or(f64::NAN, |f| f.protrusion);
    let parts: Vec<OwnedPart> =
        hulls.iter().enumerate().map(|(index, hull)| owned(hull, mesh.origin, protrusion(index))).collect();
    let is_early = !is_over(deadline);
    let whole = solid.as_ref().filter(|_| is_early).and_then(|solid| Some((solid, hull::build(mesh).ok()?)));
    let loose = whole.map(|(solid, whole)| looseness(solid, &whole, &all));
    let mass = mesh_mass(mesh);
    let empty = solid.as_ref().zip(mass).filter(|_| is_early);
    let facts = Facts {
        struct_size: size_of::<Facts>(),
        part_count: parts.len(),
        uncovered: fits.as_ref().and_then(|fits| fits.first()).map_or(f64::NAN, |fit| fit.uncovered),
        protrusion: if fits.is_some() { parts.iter().map(|p| p.protrusion).fold(0.0, f64::max) } else { f64::NAN },
        overlap: loose.map_or(f64::NAN, |loose| loose.overlap),
        mean_protrusion: loose.map_or(f64::NAN, |loose| loose.mean_protrusion),
        voids: empty.map_or(f64::NAN, |(own, mass)| voids(own, &all, deadline).relative_to(mass.volume).share),
        volume: mass.map_or(f64::NAN, |mass| mass.volume),
        center: mass.map_or([f64::NAN; 3], |mass| moved(mass.centroid, mesh.origin)),
        inertia: mass.map_or([f64::NAN; 9], |mass| inertia(&mass)),
        solid: solid.as_ref().map_or(0, |solid| solid.kind().code()),
    };
    (parts, facts)
}

/// Inertia tensor about the centre of mass at density 1, row by row.
fn inertia(mass: &Mass) -> [f64; 9] {
    let [xx, yy, zz, yz, zx, xy] = mass.second_moments.map(|moment| moment * mass.volume);
    [yy + zz, -xy, -zx, -xy, zz + xx, -yz, -zx, -yz, xx + yy]
}

/// The hull of a mesh that is not divided, with at most this number of vertices.
fn whole(mesh: &PointSet, max_vertices: u32) -> Result<Hull, BakeError> {
    let exact = hull::build(mesh)?;
    Ok(simplify(&exact, Limit::Vertices(max_vertices as usize))?.map_or(exact, |simplified| simplified.hull))
}

/// The parameters that the options state.
fn cover(options: &Options) -> Result<Cover, Failure> {
    for (name, value) in [
        ("max_error", options.max_error),
        ("max_error_share", options.max_error_share),
        ("wall_share", options.wall_share),
        ("seconds", options.seconds),
    ] {
        // No range contains NaN.
        if !(0.0..f64::INFINITY).contains(&value) {
            let text = format_args!("options.{name}: {value} is not a finite number, or below 0; 0 is the default");
            return Err(Failure::new(Code::InvalidArgument, text));
        }
    }
    let Some(solid) = SolidRule::ALL.get(options.solid as usize).copied() else {
        let text = format_args!("options.solid: {} is none of 0, 1 and 2", options.solid);
        return Err(Failure::new(Code::InvalidArgument, text));
    };
    let usual = Cover::default();
    let max_vertices = (options.max_vertices > 0).then_some(options.max_vertices);
    if let Some(few) = max_vertices.filter(|count| (*count as usize) < MIN_VERTICES) {
        let text = format_args!("options.max_vertices: {few} is below {MIN_VERTICES}; increase it");
        return Err(Failure::new(Code::InvalidArgument, text));
    }
    Ok(Cover {
        max_error: match (options.max_error, options.max_error_share) {
            (0.0, 0.0) => usual.max_error,
            (0.0, share) => Length::Relative(share),
            (length, _) => Length::Absolute(length),
        },
        max_parts: (options.max_parts > 0).then_some(options.max_parts),
        max_vertices,
        solid,
        wall: match options.wall_share {
            0.0 => usual.wall,
            share => Length::Relative(share),
        },
        seconds: (options.seconds > 0.0).then_some(options.seconds),
    })
}

/// The mesh, with the corners of its triangles as points; all points if there are no triangles.
fn point_set(points: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<PointSet, Failure> {
    let invalid = |text: std::fmt::Arguments| Failure::new(Code::InvalidArgument, text);
    if points.is_empty() || points.len() > MAX_POINTS {
        return Err(invalid(format_args!("points: expected 1 to {MAX_POINTS}, found {}", points.len())));
    }
    if let Some(index) = points.iter().position(|point| !point.iter().all(|x| x.abs() <= f64::from(f32::MAX))) {
        return Err(invalid(format_args!(
            "points[{index}]: a coordinate is not a finite number in the range of float"
        )));
    }
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in points {
        for ((low, high), x) in low.iter_mut().zip(&mut high).zip(point) {
            (*low, *high) = (low.min(*x), high.max(*x));
        }
    }
    let [a, b, c] =
        [0, 1, 2].map(|axis| low.get(axis).zip(high.get(axis)).map_or(0.0, |(low, high)| (low + high) / 2.0));
    let origin = [a, b, c];
    let mut mesh = PointSet { name: "mesh".to_owned(), origin, ..PointSet::default() };
    let mut merged: HashMap<[u32; 3], u32> = HashMap::new();
    let mut index_of = |point: &[f64; 3], source: u32| {
        let [x, y, z] = point;
        // Adding 0 removes the sign of a zero.
        let position = [x - a, y - b, z - c].map(|x| x as f32 + 0.0);
        *merged.entry(position.map(f32::to_bits)).or_insert_with(|| {
            mesh.positions.push(position);
            mesh.source_vertices.push(source);
            mesh.positions.len() as u32 - 1
        })
    };
    let mut found = Vec::with_capacity(triangles.len());
    for (index, triangle) in triangles.iter().enumerate() {
        let mut corners = [0; 3];
        for (corner, v) in corners.iter_mut().zip(triangle) {
            let point = points.get(*v as usize).ok_or_else(|| {
                invalid(format_args!("triangles[{index}]: point {v} is out of range, of {} points", points.len()))
            })?;
            *corner = index_of(point, *v);
        }
        found.push(corners);
    }
    if triangles.is_empty() {
        for (source, point) in (0..).zip(points) {
            index_of(point, source);
        }
    }
    // Triangles whose corners became one have no area.
    found.retain(|[a, b, c]| a != b && b != c && c != a);
    mesh.triangles = found;
    Ok(mesh)
}

/// A point relative to `origin`, in the frame of the mesh.
fn moved([x, y, z]: [f64; 3], [a, b, c]: [f64; 3]) -> [f64; 3] {
    [x + a, y + b, z + c]
}

/// The arrays of a hull in the frame of the mesh.
fn owned(hull: &Hull, origin: [f64; 3], protrusion: f64) -> OwnedPart {
    let mass = mass(hull);
    // Faces are convex: each is divided from its first vertex.
    let fan = |face: &Vec<u32>| -> Vec<u32> {
        let first = face.first().copied().unwrap_or_default();
        let pairs = face.get(1..).unwrap_or_default().windows(2);
        pairs.flat_map(|pair| std::iter::once(first).chain(pair.iter().copied())).collect()
    };
    OwnedPart {
        vertices: hull.vertices.iter().flat_map(|vertex| moved(vertex.map(f64::from), origin)).collect(),
        triangles: hull.faces.iter().flat_map(fan).collect(),
        volume: mass.volume,
        center: moved(mass.centroid, origin),
        protrusion,
    }
}
