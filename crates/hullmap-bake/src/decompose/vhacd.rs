//! V-HACD: approximate convex decomposition of a concave mesh into convex parts.
//!
//! # Steps
//! 1. Keep a mesh that is already convex as one hull. A mesh is convex if all its triangles lie on
//!    its hull's surface and have the same total area.
//! 2. Cut the voxels of the mesh by planes with V-HACD (parry3d, in f64) until each part is nearly
//!    convex.
//! 3. Clip the mesh's triangles to the voxels of each part. Source points keep their indices and
//!    positions; other points are rounded to a fine grid.
//! 4. Merge parts whose union is convex, and further parts until at most the requested number is
//!    left (`merge`).
//!
//! V-HACD itself promises nothing about what its parts cover. [`parts`](crate::parts) measures
//! them.
//!
//! # Reference
//! Mamou, Ghorbel, "A simple and efficient approach for 3D mesh approximate convex decomposition",
//! 2009.
//!
//! # Deviations
//! - Parts are hulls of the mesh's own triangles, not of voxels, which are as coarse as their grid.

use glam::DVec3;
use parry3d_f64::transformation::{
    vhacd::{VHACD, VHACDParameters},
    voxelization::FillMode,
};

use crate::{
    BakeError, NO_SOURCE_VERTEX, PointSet,
    hull::{self, Hull},
    simplify::nearest::Nearest,
};

/// Parameters of V-HACD.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Volume by which a part may differ from its hull, relative to the whole mesh, from 0 to 1.
    pub concavity: f64,
    /// Number of voxels along the mesh's longest side, at least 1.
    pub resolution: u32,
    /// Maximum number of parts, at least 1.
    pub max_parts: u32,
    /// Weight of the bias towards cuts into halves of equal volume.
    pub alpha: f64,
    /// Weight of the bias towards cuts through an axis of revolution.
    pub beta: f64,
    /// Try one in this many cutting planes, at least 1.
    pub plane_downsampling: u32,
    /// Build trial hulls from one in this many voxels, at least 1.
    pub hull_downsampling: u32,
    /// Whether trial hulls are built from voxels instead of from the mesh.
    pub hull_approximation: bool,
    /// What counts as inside.
    pub fill: Fill,
}

/// How the inside of a voxelised mesh is determined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fill {
    /// Everything that a flood fill from outside does not reach.
    Flood,
    /// The same, without closed cavities.
    Cavities,
    /// Only the voxels of the surface.
    Surface,
}

impl Default for Parameters {
    /// The defaults of parry3d.
    fn default() -> Self {
        let VHACDParameters { concavity, alpha, beta, resolution, plane_downsampling, .. } = VHACDParameters::default();
        Self {
            concavity,
            resolution,
            max_parts: 1024,
            alpha,
            beta,
            plane_downsampling,
            hull_downsampling: 4,
            hull_approximation: true,
            fill: Fill::Flood,
        }
    }
}

/// Maximum distance of a convex mesh's triangle behind its hull's surface, relative to the
/// diameter. It covers rounding to f32 far from the origin.
const ON_SURFACE: f64 = 1e-6;

/// Maximum difference between the areas of a convex mesh and its hull, relative to the hull's area.
const SAME_AREA: f64 = 1e-4;

/// Spacing of the grid to which clipped points are rounded, relative to the mesh's size and before
/// it is rounded up to a power of two. The last digits of these points are noise, and every noisy
/// point would become a vertex.
const GRID: f64 = 1.0 / 4_194_304.0;

/// Volume that a part may gain by a merger, relative to the volume of the mesh's hull times the
/// concavity. It is a tenth of the volume by which a part may differ from its hull. At 0.5, the
/// bars of a horseshoe bulged by 2 % of its size.
const FREE_MERGER: f64 = 0.1;

/// The convex parts of a mesh; `None` if the mesh is convex, or has no triangles or no volume.
///
/// The order of the parts depends only on the mesh and the parameters. Each part is named after the
/// mesh, with the suffix `_part_00`, `_part_01` and so on.
///
/// # Errors
/// The errors of [`hull::build`].
///
/// # Complexity
/// O(resolution³) for the voxels. With the defaults, a mesh takes about a second.
pub fn decompose(mesh: &PointSet, parameters: &Parameters) -> Result<Option<Vec<PointSet>>, BakeError> {
    let hull = hull::build(mesh)?;
    if hull.rank < 3 || mesh.triangles.is_empty() || is_convex(mesh, &hull) {
        return Ok(None);
    }
    let cuts = cut(mesh, parameters);
    let [low, high] = extremes(mesh);
    let until = super::merge::Until {
        free: FREE_MERGER * parameters.concavity * crate::mass::mass(&hull).volume,
        max_parts: parameters.max_parts.max(1) as usize,
        size: (high - low).max_element(),
    };
    let point_sets: Vec<PointSet> = cuts.iter().map(|part| point_set(part, mesh, String::new())).collect();
    let merged = super::merge::merge(&point_sets, until)?.into_iter().enumerate().map(|(index, members)| {
        let mut part: Part = members.iter().flat_map(|member| &cuts[*member]).copied().collect();
        in_order(&mut part);
        point_set(&part, mesh, format!("{}_part_{index:02}", mesh.name))
    });
    let parts: Vec<PointSet> = merged.collect();
    Ok((parts.len() > 1).then_some(parts))
}

/// Points of a convex part, each with its source vertex.
pub(super) type Part = Vec<([f32; 3], u32)>;

/// The parts that V-HACD cuts a mesh into.
fn cut(mesh: &PointSet, parameters: &Parameters) -> Vec<Part> {
    // Centre the mesh on its bounding box, so that V-HACD cuts with full precision. The middle is
    // rounded to f32 numbers, so that subtracting it and adding it back are exact in f64 except in
    // extreme ranges.
    let [low, high] = extremes(mesh);
    let middle = ((low + high) * 0.5).as_vec3().as_dvec3();
    let points: Vec<_> =
        mesh.positions.iter().map(|p| to_parry(DVec3::from_array(p.map(f64::from)) - middle)).collect();
    let found = VHACD::decompose(&to_vhacd(parameters), &points, &mesh.triangles, true);
    let order = by_position(mesh);
    let step = power_of_two_from((high - low).max_element() * GRID);
    // A point that is not a source vertex is snapped to the grid.
    let located = |exact: DVec3| {
        let source_vertex = source_vertex_at(mesh, &order, exact.to_array().map(|c| c as f32 + 0.0));
        let snapped = (exact / step).round() * step;
        let kept = if source_vertex == NO_SOURCE_VERTEX { snapped } else { exact };
        (kept.to_array().map(|c| c as f32 + 0.0), source_vertex)
    };
    let cuts = found.compute_primitive_intersections(&points, &mesh.triangles).into_iter();
    cuts.filter(|cut| !cut.is_empty())
        .map(|cut| {
            let mut part = cut.iter().map(|p| located(DVec3::new(p.x, p.y, p.z) + middle)).collect();
            in_order(&mut part);
            part
        })
        .collect()
}

/// Minimum and maximum coordinates of a mesh.
fn extremes(mesh: &PointSet) -> [DVec3; 2] {
    let positions = || mesh.positions.iter().map(|p| DVec3::from_array(p.map(f64::from)));
    [positions().fold(DVec3::INFINITY, DVec3::min), positions().fold(DVec3::NEG_INFINITY, DVec3::max)]
}

/// Sorts points by source index, then by position, and removes duplicates.
pub(super) fn in_order(part: &mut Part) {
    part.sort_unstable_by_key(|(p, source_vertex)| (*source_vertex, p.map(f32::to_bits)));
    part.dedup();
}

pub(super) fn point_set(part: &[([f32; 3], u32)], mesh: &PointSet, name: String) -> PointSet {
    PointSet {
        name,
        positions: part.iter().map(|(p, _)| *p).collect(),
        source_vertices: part.iter().map(|(_, source_vertex)| *source_vertex).collect(),
        origin: mesh.origin,
        ..PointSet::default()
    }
}

/// Whether the mesh is the surface of its own hull.
pub(super) fn is_convex(mesh: &PointSet, hull: &Hull) -> bool {
    let nearest = Nearest::new(hull);
    let at = |v: u32| DVec3::from_array(mesh.positions[v as usize].map(f64::from));
    let (mut area, mut start) = (0.0, 0);
    for [a, b, c] in mesh.triangles.iter().map(|triangle| triangle.map(at)) {
        let normal = (b - a).cross(c - a);
        area += 0.5 * normal.length();
        let normal = normal.normalize_or_zero();
        // Triangles of either orientation are accepted.
        let is_on_surface = [normal, -normal].into_iter().any(|normal| {
            start = nearest.climb(normal, start);
            normal.dot(nearest.vertex(start) - a) <= ON_SURFACE * hull.diameter
        });
        if !is_on_surface {
            return false;
        }
    }
    let whole = crate::mass::mass(hull).surface_area;
    (area - whole).abs() <= SAME_AREA * whole
}

/// Indices of the mesh's points, sorted by position, then by source index.
pub(super) fn by_position(mesh: &PointSet) -> Vec<u32> {
    let mut order: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    order.sort_unstable_by_key(|i| (key(mesh.positions[*i as usize]), mesh.source_vertices[*i as usize]));
    order
}

fn key(p: [f32; 3]) -> [u32; 3] {
    p.map(|c| (c + 0.0).to_bits())
}

/// The source vertex at a position; [`NO_SOURCE_VERTEX`] if there is none.
pub(super) fn source_vertex_at(mesh: &PointSet, order: &[u32], p: [f32; 3]) -> u32 {
    let at = order.partition_point(|i| key(mesh.positions[*i as usize]) < key(p));
    let found = order.get(at).filter(|i| key(mesh.positions[**i as usize]) == key(p));
    found.map_or(NO_SOURCE_VERTEX, |i| mesh.source_vertices[*i as usize])
}

fn to_parry(p: DVec3) -> parry3d_f64::math::Vector {
    parry3d_f64::math::Vector::new(p.x, p.y, p.z)
}

fn to_vhacd(parameters: &Parameters) -> VHACDParameters {
    let fill_mode = match parameters.fill {
        Fill::Flood => FillMode::FloodFill { detect_cavities: false },
        Fill::Cavities => FillMode::FloodFill { detect_cavities: true },
        Fill::Surface => FillMode::SurfaceOnly,
    };
    VHACDParameters {
        concavity: parameters.concavity,
        alpha: parameters.alpha,
        beta: parameters.beta,
        resolution: parameters.resolution,
        plane_downsampling: parameters.plane_downsampling,
        convex_hull_downsampling: parameters.hull_downsampling,
        fill_mode,
        convex_hull_approximation: parameters.hull_approximation,
        max_convex_hulls: parameters.max_parts,
    }
}

/// The smallest power of two that is at least `x`, which must be positive and normal. Exact.
fn power_of_two_from(x: f64) -> f64 {
    const MANTISSA_BITS: u32 = f64::MANTISSA_DIGITS - 1;
    let exponent = x.to_bits() >> MANTISSA_BITS;
    let is_power = x.to_bits().trailing_zeros() >= MANTISSA_BITS;
    f64::from_bits((exponent + u64::from(!is_power)) << MANTISSA_BITS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parts::uncovered;

    #[test]
    fn power_of_two_from_rounds_up() {
        for (x, power) in [
            (1.0, 1.0),
            (1.0 + f64::EPSILON, 2.0),
            (0.75, 1.0),
            (0.5, 0.5),
            (3e-7, 2_f64.powi(-21)),
            (5e9, 2_f64.powi(33)),
        ] {
            assert_eq!(power_of_two_from(x), power, "{x}");
        }
    }

    /// Touching boxes as one mesh, each given by its minimum and maximum corner.
    fn boxes(name: &str, boxes: &[[[f32; 3]; 2]]) -> PointSet {
        let mut set = PointSet { name: name.to_owned(), ..PointSet::default() };
        for [low, high] in boxes {
            let first = set.positions.len() as u32;
            set.positions.extend(
                (0..8).map(|i| std::array::from_fn(|axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] })),
            );
            let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6_u32]];
            set.triangles.extend(
                quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).map(|t| t.map(|v| v + first)),
            );
        }
        set.source_vertices = (0..set.positions.len() as u32).map(|i| i + 10).collect();
        set
    }

    /// A U made of three bars.
    fn horseshoe() -> PointSet {
        boxes(
            "u",
            &[
                [[0.0, 0.0, 0.0], [3.0, 1.0, 1.0]],
                [[0.0, 1.0, 0.0], [1.0, 3.0, 1.0]],
                [[2.0, 1.0, 0.0], [3.0, 3.0, 1.0]],
            ],
        )
    }

    #[test]
    fn a_horseshoe_is_cut_into_parts_that_cover_it() {
        let mesh = horseshoe();
        let parts = decompose(&mesh, &Parameters::default()).unwrap().unwrap();
        assert_eq!(parts.len(), 4);
        let hulls: Vec<Hull> = parts.iter().map(|part| hull::build(part).unwrap()).collect();
        assert!(parts.iter().enumerate().all(|(index, part)| part.name == format!("u_part_{index:02}")));
        // The gap between the arms stays empty: the volume is that of the bars, not of their hull.
        let volume: f64 = hulls.iter().map(|hull| crate::mass::mass(hull).volume).sum();
        println!("{} parts of volume {volume}, where the bars have 7 and their hull 9", parts.len());
        assert!((6.0..8.0).contains(&volume), "{volume}");
        let lost = uncovered(&mesh, &hulls.iter().collect::<Vec<_>>()).bound;
        assert!(lost <= 1e-6, "{lost}");
        // Corners that are source vertices keep their indices.
        let known = parts.iter().flat_map(|part| part.source_vertices.iter().zip(&part.positions));
        let mut count = 0;
        for (source_vertex, p) in known.filter(|(source_vertex, _)| **source_vertex != NO_SOURCE_VERTEX) {
            assert_eq!(mesh.positions[*source_vertex as usize - 10], *p);
            count += 1;
        }
        assert!(count >= 16, "{count}");
    }

    /// V-HACD only aims at its number of parts: it makes 4 where at most 1 is requested.
    #[test]
    fn max_parts_is_not_exceeded() {
        let mesh = horseshoe();
        for max_parts in 1..=4 {
            let parts = decompose(&mesh, &Parameters { max_parts, ..Parameters::default() }).unwrap();
            let count = parts.as_ref().map_or(1, Vec::len);
            assert_eq!(count, max_parts as usize, "at most {max_parts}");
        }
    }

    #[test]
    fn convex_meshes_stay_whole_and_open_boxes_do_not() {
        let cube = boxes("cube", &[[[0.0; 3], [1.0; 3]]]);
        assert!(decompose(&cube, &Parameters::default()).unwrap().is_none());
        let cloud = PointSet { triangles: Vec::new(), ..horseshoe() };
        assert!(decompose(&cloud, &Parameters::default()).unwrap().is_none());
        let lidless = PointSet { triangles: cube.triangles[..10].to_vec(), ..cube };
        assert!(!is_convex(&lidless, &hull::build(&lidless).unwrap()));
    }

    #[test]
    fn a_missing_part_is_uncovered() {
        let mesh = horseshoe();
        let parts = decompose(&mesh, &Parameters::default()).unwrap().unwrap();
        let hulls: Vec<Hull> = parts.iter().map(|part| hull::build(part).unwrap()).collect();
        let lost = uncovered(&mesh, &hulls[..1].iter().collect::<Vec<_>>()).reached;
        assert!(lost > 1.0, "{lost}");
    }

    #[test]
    fn parts_are_the_same_at_any_number_of_threads() {
        let mesh = horseshoe();
        let of_threads = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let parts = pool.install(|| decompose(&mesh, &Parameters::default())).unwrap().unwrap();
            parts.into_iter().map(|part| (part.name, part.positions, part.source_vertices)).collect::<Vec<_>>()
        };
        let one = of_threads(1);
        assert!([2, 16].into_iter().all(|threads| of_threads(threads) == one));
    }
}
