//! Verification of a triangle mesh against its source, by brute force over all triangles in f64.
//!
//! # Steps
//! 1. Compare each triangle with the one of the source that it names, and the materials.
//! 2. Recompute counts, neighbours and classes of edges and vertices: by maps instead of a sort,
//!    and by angles instead of heights.
//! 3. Compare rays and nearest points with all triangles of the source. Every other ray is aimed at
//!    a vertex or an edge, which it meets exactly.
//!
//! # Reference
//! Möller, Trumbore, "Fast, minimum storage ray-triangle intersection", 1997.

use std::collections::HashMap;

use glam::DVec3;
use hullmap::shapes::Sphere;
use hullmap::{Cache, CastSettings, EdgeClass, Pose, Ray, Settings, TriangleMesh, VertexClass};
use hullmap_geometry::PointSet;
use hullmap_import::{Materials, Polygons};
use rayon::prelude::*;
use serde::Serialize;

use crate::joints::{AimedRay, Answer, exact_middle};
use crate::random::SplitMix;
use hullmap_geometry::triangle::nearest;

/// Maximum number of tests of a triangle, by rays and by points, which take seconds. A large mesh
/// gets fewer rays and points, but at least [`LEAST`].
const TESTS: usize = 200_000_000;

const LEAST: usize = 100;

/// Rounding error of a distance that is computed here, relative to the greatest coordinate.
const ROUNDING: f64 = 1e-12;

/// Barycentric coordinate up to which rounding may decide whether a ray hits a triangle.
const GRAZE: f64 = 1e-9;

/// Cosine of the angle to the normal below which a ray counts as parallel to a triangle.
const PARALLEL: f64 = 1e-6;

/// Angle in which two triangles count as flat, and how near to it rounding may decide.
const FLAT: f64 = 1e-3;
const FLAT_ROUNDING: f64 = 1e-7;

/// Height of a triangle, relative to its longest side, below which rounding decides its normal.
const SLIVER: f64 = 1e-6;

const MAX_PROBLEMS: usize = 8;

/// Triangles of a source, as the bake of a triangle mesh takes them.
#[derive(Debug)]
pub struct SourceTriangles<'a> {
    positions: &'a [[f32; 3]],
    corners: &'a [[u32; 3]],
    materials: Vec<u16>,
}

impl<'a> SourceTriangles<'a> {
    /// Fails if a source that was imported as a whole has no triangles, or too many materials.
    pub fn new(sets: &'a [PointSet], faces: &[Polygons], materials: &Materials) -> Result<Self, String> {
        let ([points], [faces]) = (sets, faces) else {
            return Err("the source is not one mesh".to_owned());
        };
        let materials = materials.of_triangles(&faces.ends).ok_or("the source has too many materials")?;
        Ok(Self { positions: &points.positions, corners: &points.triangles, materials })
    }

    /// The corners of a triangle, where -0 is 0.
    fn triangle(&self, index: usize) -> Option<[[f32; 3]; 3]> {
        let corners = self.corners.get(index)?;
        let [a, b, c] = corners.map(|corner| self.positions.get(corner as usize).map(|p| p.map(|x| x + 0.0)));
        Some([a?, b?, c?])
    }
}

/// Result of the verification of a triangle mesh or a height field. Field names are the JSON's.
#[derive(Clone, Debug, Default, Serialize)]
pub struct SurfaceVerification {
    /// The file.
    pub file: String,
    /// The source; `None` if it was not found.
    pub source: Option<String>,
    /// The reference: `source`, `stored triangles` or `stored heights`.
    pub against: Option<&'static str>,
    /// Number of triangles.
    pub triangles: Option<usize>,
    /// Number of rays that were tested.
    pub rays: Option<usize>,
    /// Number of these that meet a vertex or an edge exactly.
    pub joint_rays: Option<usize>,
    /// Number of rays that hit the mesh.
    pub ray_hits: Option<usize>,
    /// Number of points whose nearest triangle was tested; `None` for a height field.
    pub points: Option<usize>,
    /// Seed of both.
    pub seed: Option<u64>,
    /// Number of wrong answers, and of wrong entries of the file.
    pub mismatches: Option<usize>,
    /// Whether there are none.
    pub pass: bool,
    /// Its faults, at most eight sentences.
    pub problems: Vec<String>,
}

impl SurfaceVerification {
    /// Its faults; `None` if it passes.
    pub fn verdict(&self) -> Option<String> {
        (!self.pass).then(|| self.problems.join("; "))
    }
}

#[derive(Default)]
pub(crate) struct Findings {
    count: usize,
    problems: Vec<String>,
}

impl Findings {
    pub(crate) fn add(&mut self, problem: impl FnOnce() -> String) {
        self.count += 1;
        if self.problems.len() < MAX_PROBLEMS {
            self.problems.push(problem());
        }
    }

    pub(crate) fn compare<T: PartialEq + std::fmt::Debug>(&mut self, what: &str, found: T, expected: T) {
        if found != expected {
            self.add(|| format!("{what}: {found:?} instead of {expected:?}"));
        }
    }

    /// The result, without what was compared.
    pub(crate) fn verification(self) -> SurfaceVerification {
        SurfaceVerification {
            mismatches: Some(self.count),
            pass: self.count == 0,
            problems: self.problems,
            ..SurfaceVerification::default()
        }
    }
}

/// Verifies a mesh. Without a source, its own triangles are the truth for rays and points.
/// Complexity: O(n log n) for n triangles, plus up to `directions` rays and points, each against
/// all triangles.
pub fn verify_mesh(
    mesh: &TriangleMesh,
    source: Option<&SourceTriangles>,
    directions: usize,
    seed: u64,
) -> SurfaceVerification {
    let answer: &Answer = &|ray| hullmap::ray(mesh, ray, &CastSettings::default());
    verify_answers(mesh, source, directions, seed, answer)
}

fn verify_answers(
    mesh: &TriangleMesh,
    source: Option<&SourceTriangles>,
    directions: usize,
    seed: u64,
    answer: &Answer,
) -> SurfaceVerification {
    let mut findings = Findings::default();
    let stored: Vec<[DVec3; 3]> =
        (0..mesh.triangle_count()).filter_map(|index| Some(mesh.triangle(index)?.corners())).collect();
    let truth = match source {
        Some(source) => {
            compare_triangles(mesh, source, &mut findings);
            (0..source.corners.len())
                .filter_map(|index| source.triangle(index))
                .map(|corners| corners.map(|corner| DVec3::from_array(corner.map(f64::from))))
                .collect()
        }
        None => stored.clone(),
    };
    compare_surface(mesh, &stored, &mut findings);
    let count = directions.min((TESTS / truth.len().max(1)).max(LEAST));
    let random = SplitMix::new(seed);
    let [low, high] = mesh.bounds().map(|corner| corner.as_dvec3());
    let space = Space { center: low.midpoint(high), radius: 0.5 * low.distance(high), scale: greatest(&truth) };
    let [joint_rays, ray_hits] = compare_rays(answer, &truth, count, space, random.clone(), &mut findings);
    compare_points(mesh, &truth, count, space, random, &mut findings);
    SurfaceVerification {
        against: Some(if source.is_some() { "source" } else { "stored triangles" }),
        triangles: Some(mesh.triangle_count()),
        rays: Some(count),
        joint_rays: Some(joint_rays),
        ray_hits: Some(ray_hits),
        points: Some(count),
        seed: Some(seed),
        ..findings.verification()
    }
}

/// The ball from which rays and points come, and the greatest coordinate.
#[derive(Clone, Copy)]
struct Space {
    center: DVec3,
    radius: f64,
    scale: f64,
}

fn greatest(triangles: &[[DVec3; 3]]) -> f64 {
    triangles.iter().flatten().map(|corner| corner.abs().max_element()).fold(0.0, f64::max)
}

/// Step 1.
fn compare_triangles(mesh: &TriangleMesh, source: &SourceTriangles, findings: &mut Findings) {
    findings.compare("number of triangles", mesh.triangle_count(), source.corners.len());
    let mut is_used = vec![false; source.corners.len()];
    for index in 0..mesh.triangle_count() {
        let own = mesh.corners(index).map(|corners| corners.map(|corner| mesh.vertex(corner as usize)));
        let from = mesh.source_triangle(index).map_or(usize::MAX, |from| from as usize);
        let expected = source.triangle(from);
        if own.is_none_or(|own| Some(own) != expected.map(|corners| corners.map(|c| Some(glam::Vec3::from_array(c))))) {
            findings.add(|| format!("triangle {index} differs from triangle {from} of the source"));
        }
        match is_used.get_mut(from) {
            Some(is_used) if !*is_used => *is_used = true,
            _ => {
                findings.add(|| format!("triangle {index}: triangle {from} of the source occurs twice, or not at all"))
            }
        }
        let material = source.materials.get(from).copied().unwrap_or_default();
        findings.compare(&format!("material of triangle {index}"), mesh.material(index), Some(material));
    }
    let (mut positions, mut used) = (std::collections::HashSet::new(), vec![false; source.positions.len()]);
    for corner in source.corners.as_flattened() {
        if let (Some(used), Some(at)) = (used.get_mut(*corner as usize), source.positions.get(*corner as usize)) {
            *used = true;
            positions.insert(at.map(|x| (x + 0.0).to_bits()));
        }
    }
    let used = used.into_iter().filter(|used| *used).count();
    findings.compare("number of vertices", mesh.vertex_count(), positions.len());
    findings.compare("number of merged vertices", mesh.merged_count(), used.saturating_sub(positions.len()));
}

/// Step 2.
fn compare_surface(mesh: &TriangleMesh, triangles: &[[DVec3; 3]], findings: &mut Findings) {
    let corners: Vec<[u32; 3]> = (0..mesh.triangle_count()).filter_map(|index| mesh.corners(index)).collect();
    let sorted = |of: &[u32; 3]| {
        let mut of = *of;
        of.sort_unstable();
        of
    };
    // Triangles that are not part of the surface: two corners are equal, or it is repeated.
    let (mut first, mut duplicate) = (HashMap::new(), 0);
    let mut is_part = vec![true; corners.len()];
    for (index, own) in corners.iter().enumerate() {
        let key = sorted(own);
        let is_repeated = *first.entry(key).or_insert(index) != index;
        duplicate += usize::from(is_repeated);
        is_part[index] = !is_repeated && key[0] != key[1] && key[1] != key[2];
    }
    findings.compare("number of duplicate triangles", mesh.duplicate_count(), duplicate);
    let degenerate = triangles.iter().filter(|triangle| is_on_a_line(triangle)).count();
    findings.compare("number of degenerate triangles", mesh.degenerate_count(), degenerate);
    let mut at_edges: HashMap<[u32; 2], Vec<(usize, usize)>> = HashMap::new();
    for (index, own) in corners.iter().enumerate().filter(|(index, _)| is_part[*index]) {
        for edge in 0..3 {
            let (from, to) = (own[edge], own[(edge + 1) % 3]);
            at_edges.entry([from.min(to), from.max(to)]).or_default().push((index, edge));
        }
    }
    let mut at_vertices: Vec<Option<VertexClass>> = vec![None; mesh.vertex_count()];
    let mut keys: Vec<_> = at_edges.keys().copied().collect();
    keys.sort_unstable();
    for key in keys {
        let sides = &at_edges[&key];
        let class = |(index, edge): (usize, usize)| mesh.edge_classes(index).map(|classes| classes[edge]);
        let beyond = |(index, edge): (usize, usize)| mesh.neighbours(index).and_then(|beyond| beyond[edge]);
        let expected = match sides.as_slice() {
            [_] => vec![EdgeClass::Border],
            [a, b] => between(triangles, &corners, *a, *b),
            _ => vec![EdgeClass::NonManifold],
        };
        for (at, side) in sides.iter().enumerate() {
            let other = if sides.len() == 2 { Some(sides[1 - at].0 as u32) } else { None };
            findings.compare(&format!("neighbour of triangle {} at edge {}", side.0, side.1), beyond(*side), other);
            if class(*side).is_none_or(|class| !expected.contains(&class)) {
                findings.add(|| {
                    let found = class(*side).map_or("none", EdgeClass::as_str);
                    format!("class of edge {} of triangle {}: {found} instead of {}", side.1, side.0, expected[0])
                });
            }
        }
        // If rounding decides, the class in the file is accepted.
        let class = class(sides[0]).filter(|class| expected.contains(class)).unwrap_or(expected[0]);
        for end in key {
            if let Some(at) = at_vertices.get_mut(end as usize) {
                *at = Some(at.unwrap_or(VertexClass::Flat).with(class));
            }
        }
    }
    for (index, own) in corners.iter().enumerate().filter(|(index, _)| !is_part[*index]) {
        let what = format!("edges of triangle {index} {own:?}, which is not part of the surface");
        findings.compare(&what, mesh.edge_classes(index), Some([EdgeClass::Border; 3]));
    }
    for (vertex, class) in at_vertices.into_iter().enumerate() {
        let what = format!("class of vertex {vertex}");
        findings.compare(&what, mesh.vertex_class(vertex), Some(class.unwrap_or(VertexClass::Border)));
    }
}

/// Uses exact predicates: products of three differences of f32 may round.
fn is_on_a_line(triangle: &[DVec3; 3]) -> bool {
    [[0, 1], [1, 2], [2, 0]].iter().all(|[x, y]| {
        let [a, b, c] = triangle.map(|corner| robust::Coord { x: corner[*x], y: corner[*y] });
        robust::orient2d(a, b, c) == 0.0
    })
}

/// The classes that the edge of two triangles may have: one, unless rounding decides.
fn between(triangles: &[[DVec3; 3]], corners: &[[u32; 3]], a: (usize, usize), b: (usize, usize)) -> Vec<EdgeClass> {
    let start = |(index, edge): (usize, usize)| corners[index][edge];
    if start(a) == start(b) {
        return vec![EdgeClass::Reversed];
    }
    let normal = |(index, _): (usize, usize)| {
        let [p, q, r] = triangles[index];
        let (u, v) = (q - p, r - p);
        let longest = u.length().max(v.length()).max(u.distance(v));
        (u.cross(v).normalize_or_zero(), u.cross(v).length() > SLIVER * longest * longest)
    };
    let ((n, is_known), (m, is_known_too)) = (normal(a), normal(b));
    if !(is_known && is_known_too) {
        return vec![EdgeClass::Flat, EdgeClass::Convex, EdgeClass::Concave];
    }
    let edge = triangles[a.0][(a.1 + 1) % 3] - triangles[a.0][a.1];
    // Positive where the surface turns away from its front: a ridge.
    let angle = n.cross(m).dot(edge.normalize_or_zero()).atan2(n.dot(m));
    let is_folded = std::f64::consts::PI - angle.abs() < FLAT_ROUNDING;
    if is_folded {
        vec![EdgeClass::Convex, EdgeClass::Concave]
    } else if (angle.abs() - FLAT).abs() < FLAT_ROUNDING {
        vec![EdgeClass::Flat, if angle > 0.0 { EdgeClass::Convex } else { EdgeClass::Concave }]
    } else if angle > FLAT {
        vec![EdgeClass::Convex]
    } else if angle < -FLAT {
        vec![EdgeClass::Concave]
    } else {
        vec![EdgeClass::Flat]
    }
}

struct RayTruth {
    /// The first t at which it certainly hits a triangle; infinite if it hits none.
    sure: f64,
    /// The times at which it may hit a triangle, with their errors.
    possible: Vec<(f64, f64)>,
    /// Whether the ray is nearly parallel to a triangle that it may hit.
    is_doubtful: bool,
}

/// Step 3. Returns the number of rays at vertices and edges, and of hits.
fn compare_rays(
    answer: &Answer,
    triangles: &[[DVec3; 3]],
    count: usize,
    space: Space,
    mut random: SplitMix,
    findings: &mut Findings,
) -> [usize; 2] {
    let rays: Vec<AimedRay> = (0..count)
        .map(|index| {
            let origin = space.center + random.in_ball_f64() * (1.5 * space.radius);
            let [a, b, c] = triangles[random.below(triangles.len())];
            let free = random.in_ball_f64();
            let joint = if index % 4 == 0 { a } else { exact_middle(a, b) };
            if index % 2 == 0
                && let Some(aimed) = AimedRay::at(joint, origin)
            {
                return aimed;
            }
            // Two of three other rays are aimed at a triangle.
            let [u, v] = [(); 2].map(|()| 0.5 + 0.5 * random.signed());
            let target = a + (b - a) * (u * (1.0 - v)) + (c - a) * (u * v);
            let direction = if index % 3 == 0 { free } else { (target - origin).normalize_or(free) };
            AimedRay { origin, direction, meets: f64::INFINITY }
        })
        .collect();
    let judged: Vec<(Option<hullmap::RayHit>, bool)> = rays
        .par_iter()
        .map(|ray| {
            let truth = ray_truth(triangles, [ray.origin, ray.direction], space.scale);
            let found = Ray::new(ray.origin, ray.direction).ok().map(|own| answer(&own));
            let is_right = found.is_some_and(|found| ray.is_met_by(&found, 0.0) && is_right(&found, &truth));
            (found, is_right)
        })
        .collect();
    for (AimedRay { origin, direction, .. }, (found, _)) in
        rays.iter().zip(&judged).filter(|(_, (_, is_right))| !is_right)
    {
        findings.add(|| {
            let t = found.map_or(f64::NAN, |found| found.t);
            format!("ray from {origin} along {direction}: wrong answer, t = {t}")
        });
    }
    let joint_rays = rays.iter().filter(|ray| ray.meets < f64::INFINITY).count();
    [joint_rays, judged.iter().filter(|(found, _)| found.is_some_and(|found| found.hit)).count()]
}

fn is_right(found: &hullmap::RayHit, truth: &RayTruth) -> bool {
    if truth.is_doubtful {
        return true;
    }
    if !found.hit {
        return truth.sure == f64::INFINITY;
    }
    let is_near = |(t, error): &(f64, f64)| found.t_lower - error <= *t && *t <= found.t_upper + error;
    let error = truth.possible.iter().filter(|(t, _)| *t <= truth.sure).map(|(_, error)| *error).fold(0.0, f64::max);
    // A ray that hits none may still graze one.
    truth.possible.iter().any(is_near) && found.t_lower <= truth.sure + error
}

fn ray_truth(triangles: &[[DVec3; 3]], [origin, direction]: [DVec3; 2], scale: f64) -> RayTruth {
    let mut truth = RayTruth { sure: f64::INFINITY, possible: Vec::new(), is_doubtful: false };
    let speed = direction.length();
    for [a, b, c] in triangles {
        let (ab, ac, from) = (*b - *a, *c - *a, origin - *a);
        let side = direction.cross(ac);
        let volume = ab.dot(side);
        let (turned, area) = (from.cross(ab), ab.cross(ac).length());
        let cosine = volume.abs() / (area * speed);
        // NaN of a triangle without area, which only a graze can hit.
        if !(cosine > PARALLEL) {
            truth.is_doubtful |= is_near_line(origin, direction, &[*a, *b, *c], scale);
            continue;
        }
        let (u, v, t) = (from.dot(side) / volume, direction.dot(turned) / volume, ac.dot(turned) / volume);
        let least = u.min(v).min(1.0 - u - v);
        let error = ROUNDING * scale / (cosine * speed);
        // Barycentric coordinates lose precision where the triangle is small or thin.
        let width = area / ab.length().max(ac.length()).max((*c - *b).length());
        let margin = GRAZE + ROUNDING * scale / (cosine * width);
        if least >= -margin && t >= -error {
            truth.possible.push((t, error));
            if least >= margin && t >= error {
                truth.sure = truth.sure.min(t);
            }
        }
    }
    truth
}

/// Whether a ray passes a triangle, without area or nearly parallel to it, so closely that rounding
/// may decide.
fn is_near_line(origin: DVec3, direction: DVec3, [a, b, c]: &[DVec3; 3], scale: f64) -> bool {
    let along = direction.normalize_or_zero();
    let sides = [[*a, *b], [*b, *c], [*c, *a]];
    let length = |side: &[DVec3; 2]| side[0].distance(side[1]);
    let [from, to] = sides.into_iter().max_by(|x, y| length(x).total_cmp(&length(y))).unwrap_or([*a, *b]);
    let height = (*b - *a).cross(*c - *a).length() / from.distance(to).max(f64::MIN_POSITIVE);
    // Project along the ray, which becomes a point.
    let [p, from, to] = [origin, from, to].map(|x| x - along * x.dot(along));
    nearest(&[from, to, to], p).distance(p) <= height + GRAZE * scale
}

/// Step 3.
fn compare_points(
    mesh: &TriangleMesh,
    triangles: &[[DVec3; 3]],
    count: usize,
    space: Space,
    mut random: SplitMix,
    findings: &mut Findings,
) {
    let points: Vec<DVec3> = (0..count)
        .map(|index| {
            // Half of them are near the surface.
            let [a, b, c] = triangles[random.below(triangles.len())];
            let near = (a + b + c) / 3.0 + random.in_ball_f64() * (0.02 * space.radius);
            let far = space.center + random.in_ball_f64() * (1.5 * space.radius);
            if index % 2 == 0 { near } else { far }
        })
        .collect();
    let judge = |point: &DVec3| {
        let least =
            triangles.iter().map(|triangle| nearest(triangle, *point).distance(*point)).fold(f64::INFINITY, f64::min);
        let (Ok(pose), Ok(dot)) = (Pose::from_translation(*point), Sphere::new(0.0)) else {
            return (f64::NAN, f64::NAN, false);
        };
        let found = hullmap::distance(mesh, &dot, pose, &Settings::default(), &mut Cache::new());
        let error = ROUNDING * (space.scale + point.length());
        (found.distance, least, found.lower - error <= least && least <= found.upper + error)
    };
    let judged: Vec<(f64, f64, bool)> = points.par_iter().map(judge).collect();
    for (point, (found, least, _)) in points.iter().zip(judged).filter(|(_, (.., is_right))| !is_right) {
        findings.add(|| format!("nearest triangle of {point}: at {found} instead of {least}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};

    /// A square at each height.
    fn squares(heights: &[f32]) -> TriangleMesh {
        let square = |z: &f32| [[0.0, 0.0, *z], [4.0, 0.0, *z], [4.0, 4.0, *z], [0.0, 4.0, *z]];
        let positions: Vec<[f32; 3]> = heights.iter().flat_map(square).collect();
        let square = |at: usize| [[0, 1, 2], [0, 2, 3]].map(|triangle| triangle.map(|corner| corner + 4 * at as u32));
        let corners: Vec<[u32; 3]> = (0..heights.len()).flat_map(square).collect();
        let source = Triangles { positions: &positions, corners: &corners, materials: &[] };
        let file = write_triangle_mesh(bake_triangle_mesh(&source).unwrap(), &Default::default()).unwrap();
        TriangleMesh::from_bytes(&file).unwrap()
    }

    /// Only rays at vertices and edges, which meet them at t = 1, get the answer of the floor.
    #[test]
    fn an_answer_from_behind_an_edge_fails() {
        let (mesh, floor) = (squares(&[1.0, 0.0]), squares(&[0.0]));
        let cast = |mesh: &TriangleMesh, ray: &Ray| hullmap::ray(mesh, ray, &CastSettings::default());
        let right = verify_answers(&mesh, None, 400, 1, &|ray| cast(&mesh, ray));
        assert!(right.pass && right.joint_rays > Some(100), "{right:?}");
        let wrong = verify_answers(&mesh, None, 400, 1, &|ray| {
            let (found, behind) = (cast(&mesh, ray), cast(&floor, ray));
            if (found.t - 1.0).abs() < 1e-9 && behind.hit { behind } else { found }
        });
        assert!(!wrong.pass, "{wrong:?}");
    }
}
