//! The calls into the baking crate, all of them.

use std::borrow::Cow;

use hullmap_bake::decompose::{self, Fill, Parameters, decompose};
use hullmap_bake::hull::Hull;
use hullmap_bake::simplify::Limit;
use hullmap_bake::{BakedHull, IndexKind, PointSet, SourceRecord, bake_hull, bake_simplified_hull, write_pack};
use rayon::prelude::*;

use crate::advice::{self, HullFacts, Remark};
use crate::options::{self, BuildOptions, DecomposeOptions, Simplify};

/// A pack in memory.
#[derive(Clone, Debug, Default)]
pub struct BakedPack {
    /// The bytes of the file.
    pub bytes: Vec<u8>,
    /// Rank of each hull.
    pub ranks: Vec<u32>,
    /// Vertices over all hulls.
    pub vertex_count: usize,
    /// What the user may want to know of the bake.
    pub notes: Vec<String>,
    /// What the user should look at.
    pub warnings: Vec<String>,
}

/// The points of one hull: a point set of the source, or a convex part of it.
#[derive(Clone, Debug)]
pub struct Part<'a> {
    /// The points.
    pub points: Cow<'a, PointSet>,
    /// Number among the parts of its set, from 0; 0 for a whole set.
    pub number: u32,
    /// The set, by its place in the source.
    pub set: usize,
}

/// The hulls that point sets become: themselves, or their parts. A function of the sets and the options, whatever the threads: so
/// `bake verify` knows the truth about each part.
///
/// # Errors
/// The first set, in their order, that has no hull, by name.
pub fn parts<'a>(point_sets: &'a [PointSet], parameters: Option<&DecomposeOptions>) -> Result<Vec<Part<'a>>, String> {
    let cut: Vec<_> = point_sets
        .par_iter()
        .map(|points| parameters.map_or(Ok(None), |parameters| decompose(points, &vhacd(parameters))))
        .collect();
    let mut parts = Vec::with_capacity(point_sets.len());
    for (set, (found, points)) in cut.into_iter().zip(point_sets).enumerate() {
        match found.map_err(|error| format!("hull {}: {error}", points.name))? {
            None => parts.push(Part { points: Cow::Borrowed(points), number: 0, set }),
            Some(found) => {
                let part = |(number, points)| Part { points: Cow::Owned(points), number, set };
                parts.extend((0..).zip(found).map(part));
            }
        }
    }
    Ok(parts)
}

/// Builds, certifies and indexes a hull of each point set, or of each of its parts, and puts them into one pack.
///
/// # Errors
/// The first hull, in their order, that could not be baked, by name.
pub fn bake_pack(point_sets: &[PointSet], options: &BuildOptions, source: &SourceRecord) -> Result<BakedPack, String> {
    let parts = parts(point_sets, options.decompose.as_ref())?;
    let limit = match options.simplify {
        Simplify::None => None,
        Simplify::MaxVertices(most) => Some(Limit::Vertices(most as usize)),
        Simplify::MaxError(distance) => Some(Limit::Distance(distance)),
    };
    let bake = |part: &Part| match limit {
        None => bake_hull(&part.points, options.index),
        Some(limit) => bake_simplified_hull(&part.points, limit, options.index),
    };
    let baked: Vec<_> = parts.par_iter().map(bake).collect();
    let mut hulls = Vec::with_capacity(baked.len());
    for (hull, part) in baked.into_iter().zip(&parts) {
        let hull = hull.map_err(|error| format!("hull {}: {error}", part.points.name))?;
        hulls.push(BakedHull { part: part.number, ..hull });
    }
    let (mut notes, mut warnings) = (Vec::new(), Vec::new());
    let covers = options.decompose.map_or(Vec::new(), |decompose| {
        let is_one_asked_for = decompose.max_parts == 1;
        cover(point_sets, &parts, &mut hulls, is_one_asked_for)
    });
    let simplified = hulls.iter().filter_map(|baked| advice::simplified(&facts(baked)));
    covers.into_iter().chain(simplified).for_each(|remark| remark.tell(&mut notes, &mut warnings));
    if let IndexKind::Budget { bytes_per_vertex } = options.index {
        notes.extend(hulls.iter().map(|baked| budget_note(baked, bytes_per_vertex)));
    }
    let bytes = write_pack(&hulls, source).map_err(|error| error.to_string())?;
    let ranks = hulls.iter().map(|baked| baked.hull.rank).collect();
    let vertex_count = hulls.iter().map(|baked| baked.hull.vertices.len()).sum();
    warnings.extend(hulls.iter().flat_map(|baked| advice::of_hull(&facts(baked))));
    Ok(BakedPack { bytes, ranks, vertex_count, notes, warnings })
}

/// Measures what the parts of each set leave out, tells the hulls, and says it.
fn cover(point_sets: &[PointSet], parts: &[Part], hulls: &mut [BakedHull], is_one_asked_for: bool) -> Vec<Remark> {
    let mut remarks = Vec::new();
    let mut start = 0;
    for (set, points) in point_sets.iter().enumerate() {
        let count = parts[start..].iter().take_while(|part| part.set == set).count();
        let own = &mut hulls[start..start + count];
        start += count;
        let name = &points.name;
        if count == 1 {
            let why = if points.triangles.is_empty() {
                "it has no faces to cut by"
            } else if is_one_asked_for {
                "no more parts are asked for"
            } else {
                "it is convex, or thin, as it is"
            };
            remarks.push(Remark::Note(format!("{name}: one hull: {why}")));
            continue;
        }
        let whole: Vec<&Hull> = own.iter().map(|baked| &baked.hull).collect();
        let uncovered = decompose::uncovered(points, &whole);
        own.iter_mut().for_each(|baked| baked.uncovered = uncovered);
        let size = own.iter().map(|baked| baked.hull.diameter).fold(0.0, f64::max);
        remarks.push(advice::parts(name, count, uncovered, size));
    }
    remarks
}

fn vhacd(options: &DecomposeOptions) -> Parameters {
    Parameters {
        concavity: options.concavity.into(),
        resolution: options.resolution,
        max_parts: options.max_parts,
        alpha: options.alpha.into(),
        beta: options.beta.into(),
        plane_downsampling: options.plane_downsampling,
        hull_downsampling: options.hull_downsampling,
        hull_approximation: options.hull_approximation,
        fill: match options.fill {
            options::Fill::Flood => Fill::Flood,
            options::Fill::Cavities => Fill::Cavities,
            options::Fill::Surface => Fill::Surface,
        },
    }
}

/// What warnings are given by.
fn facts(baked: &BakedHull) -> HullFacts<'_> {
    let coordinates = baked.hull.vertices.iter().flatten();
    HullFacts {
        name: &baked.name,
        rank: baked.hull.rank,
        point_count: baked.point_count,
        vertex_count: baked.hull.vertices.len(),
        diameter: baked.hull.diameter,
        inner_radius: baked.interior.inner_radius,
        greatest_coordinate: coordinates.map(|x| f64::from(x.abs())).fold(0.0, f64::max),
        outer_error: baked.outer_error,
    }
}

/// Which index a budget bought.
fn budget_note(baked: &BakedHull, bytes_per_vertex: u32) -> String {
    let vertex_count = baked.hull.vertices.len();
    let chosen = baked.index.describe(vertex_count);
    let is_kept = baked.index.byte_len() <= bytes_per_vertex as usize * vertex_count;
    let verdict = if is_kept { "" } else { ": above the budget, but nothing is smaller" };
    format!("hull {}: {chosen}{verdict}", baked.name)
}
