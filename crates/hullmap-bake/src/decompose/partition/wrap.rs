//! Hulls of few vertices around a part. Each is bounded by a few planes of the part's faces: enough
//! to exclude every point that is too far from the solid.
//!
//! # Steps
//! 1. Start with the planes of the largest faces.
//! 2. Find a point of the polytope that is too far from the solid or the part: a vertex, a point of
//!    a face, or a point that the proof found. Add the plane of a large face that cuts it off.
//!    Repeat.
//! 3. Drop planes, small faces first, as long as nothing becomes too far.
//! 4. With too many vertices, start again, with more room around the part.
//!
//! All planes are moved outward by more than rounding to f32 moves a vertex, so that the hull of
//! the rounded vertices contains the part.

use glam::DVec3;

use super::body::{Body, farthest, rough};
use super::few;
use super::field::Field;
use super::sample::face_points;
use crate::deadline::{self, Deadline};
use crate::fit::{branch::Accuracy, protrusion::protrusion_beside};
use crate::hull::{
    self, Hull, quickhull,
    rank::{Simplex, spanning_simplex},
};
use crate::progress::Stage;
use crate::simplify;
use hullmap_geometry::planes::HalfSpace;

const MAX_STEPS: usize = 200;

const MAX_PROOFS: usize = 24;

/// Maximum number of measurements of a proof.
pub const MEASUREMENTS: usize = 100_000;

/// Maximum heights above a body that are tried in turn, relative to the limit. The smallest one
/// that the number of vertices allows follows the body's shape best. Inside the solid, a hull may
/// be higher than the limit.
const LOOSENESS: [f64; 3] = [0.25, 0.6, f64::INFINITY];

/// Share of the limit that measured points may use; the rest is for the proof.
const PLANNED: f64 = 0.975;

/// Maximum number of points that are searched for after a proof has failed.
const REFUTED: usize = 12;

/// Maximum number of distances by which they are searched for.
const REFUTING: usize = 400;

/// Number of vertices above which a hull is not simplified, relative to the allowed number.
const MANY: f64 = 1.5;

/// Number of vertices up to which any hull is simplified.
const FEW: usize = 64;

/// Share of all faces' area from which a face's plane is used from the start.
const LARGE: f64 = 0.04;

/// Cosine of the angle between planes that are used from the start.
const ALIKE: f64 = 0.94;

/// Number of points of the faces that are measured.
const MEASURED: usize = 150;

/// Maximum rounding error of a point, relative to its greatest coordinate.
pub const ROUNDING: f64 = 1.1e-7;

/// Distance from a hull up to which it counts as containing a point, relative to the diagonal.
const HELD: f64 = 2e-13;

/// Additional distance, relative to the greatest coordinate, for rounding of heights.
const HELD_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Limits of a hull.
#[derive(Clone, Copy, Debug)]
pub struct HullLimits<'a> {
    /// Maximum distance from the solid.
    pub limit: f64,
    /// Maximum number of vertices.
    pub max_vertices: usize,
    /// Diagonal of the mesh.
    pub diagonal: f64,
    /// The least thickness of a part.
    pub thickness: f64,
    /// When to stop.
    pub deadline: Option<Deadline>,
    /// The progress of the search, which may be cancelled.
    pub stage: Stage<'a>,
}

impl HullLimits<'_> {
    /// Whether the deadline has passed, or the search is cancelled.
    pub fn is_over(&self) -> bool {
        self.stage.is_cancelled() || deadline::is_over(self.deadline)
    }
}

/// Proves that a hull is within the limit by at most `measurements`, and returns the bound.
///
/// # Errors
/// A point of the hull that is too far from the solid; `None` if undecided.
pub fn prove(field: &Field, hull: &Hull, bounds: &HullLimits, measurements: usize) -> Result<f64, Option<DVec3>> {
    let usual = Accuracy::decide(bounds.limit);
    let measurements = measurements.min(usual.measurements);
    let accuracy = Accuracy { measurements, deadline: bounds.deadline, ..usual };
    let found = protrusion_beside(field.solid(), hull, &accuracy, field.peaks());
    // Written so that NaN fails.
    if found.bound <= bounds.limit { Ok(found.bound) } else { Err((found.reached > bounds.limit).then_some(found.at)) }
}

/// The points, moved apart to a hull about `thickness` thick in all directions.
fn thickened(points: &[DVec3], thickness: f64) -> Vec<DVec3> {
    let mut points = points.to_vec();
    // A hull of some of the points is no thicker.
    let some = rough(&points);
    if some.len() < points.len() && thinnest(&some).1 >= thickness {
        return points;
    }
    for _ in 0..3 {
        let (normal, width) = thinnest(&points);
        if width >= thickness {
            break;
        }
        let step = normal * (0.5 * (thickness - width));
        points = points.iter().flat_map(|p| [*p + step, *p - step]).collect();
    }
    points
}

fn thinnest(points: &[DVec3]) -> (DVec3, f64) {
    if points.is_empty() {
        return (DVec3::X, f64::INFINITY);
    }
    match spanning_simplex(points) {
        Simplex::Point(_) => (DVec3::X, 0.0),
        Simplex::Segment([a, b]) => ((points[b] - points[a]).normalize_or_zero().any_orthonormal_vector(), 0.0),
        Simplex::Triangle([a, b, c]) => ((points[b] - points[a]).cross(points[c] - points[a]).normalize_or_zero(), 0.0),
        Simplex::Tetrahedron(_) => {
            let body = Body::new(points, 0.0);
            let width = |normal: DVec3| {
                normal.dot(farthest(&body.points, normal)) - normal.dot(farthest(&body.points, -normal))
            };
            let widths = body.planes.iter().map(|plane| (plane.normal, width(plane.normal)));
            widths.fold((DVec3::X, f64::INFINITY), |least, found| if found.1 < least.1 { found } else { least })
        }
    }
}

/// The hull of `points`, rounded outward to f32. A thinner one is made `thickness` thick, because
/// only a solid has an inside.
pub fn tight(points: &[DVec3], diagonal: f64, thickness: f64) -> Option<Hull> {
    let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let thick = thickened(points, thickness);
    let room = if thick.len() > points.len() { 4.0 * ROUNDING * (middle.abs().max_element() + diagonal) } else { 0.0 };
    let moved = thick.iter().map(|p| *p + (*p - middle).normalize_or_zero() * room);
    let outward = |p: DVec3| {
        let [p, m] = [p.to_array(), middle.to_array()];
        [0, 1, 2].map(|axis| {
            let near = p[axis] as f32;
            let rounded = f64::from(near);
            let is_up = p[axis] > m[axis];
            // Rounding puts cut points off a face, which is no reason to leave it.
            (if (rounded - p[axis]).abs() <= HELD * diagonal {
                near
            } else if rounded < p[axis] && is_up {
                near.next_up()
            } else if rounded > p[axis] && !is_up {
                near.next_down()
            } else {
                near
            }) + 0.0
        })
    };
    let mut rounded: Vec<[f32; 3]> = moved.map(outward).collect();
    let body = Body::new(&rounded.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect::<Vec<_>>(), 0.0);
    let slack = HELD * diagonal + HELD_ROUNDING * body.low.abs().max(body.high.abs()).max_element();
    let around: Vec<[f32; 3]> = points.iter().filter(|p| !body.holds(**p, slack)).flat_map(|p| around(*p)).collect();
    rounded.extend(around);
    hull::of_positions(rounded)
}

/// A hull around a hull, at least as thick as the bounds require; or the hull itself, if the
/// thicker one is not proven to be within the limit.
pub fn thick(field: &Field, hull: Hull, bounds: &HullLimits) -> Hull {
    let points = hull.positions();
    if thinnest(&points).1 >= 0.99 * bounds.thickness {
        return hull;
    }
    let thick = tight(&points, bounds.diagonal, bounds.thickness);
    let thick = thick.map(|thick| few::within_vertices(thick, bounds.max_vertices));
    thick.filter(|thick| prove(field, thick, bounds, MEASUREMENTS).is_ok()).unwrap_or(hull)
}

fn around(p: DVec3) -> Vec<[f32; 3]> {
    let sides = p.to_array().map(|x| {
        let near = x as f32;
        if f64::from(near) == x {
            [near, near]
        } else if f64::from(near) < x {
            [near, near.next_up()]
        } else {
            [near.next_down(), near]
        }
    });
    (0..8).map(|i| [sides[0][i & 1], sides[1][i >> 1 & 1], sides[2][i >> 2]]).collect()
}

/// A proven hull around `body` with fewer vertices than the body, and at most the allowed number.
/// It is as loose as that number requires, and at most as the limit allows.
///
/// # Errors
/// A point of the body that may be too far from the solid; `None` if no such hull was found.
pub fn wrap(field: &Field, body: &Body, bounds: &HullLimits) -> Result<(Hull, f64), Option<DVec3>> {
    let mut found = Err(None);
    for share in LOOSENESS {
        found = wrapped(field, body, bounds, share * bounds.limit);
        if !matches!(found, Err(None)) {
            break;
        }
    }
    found
}

/// As [`wrap`]; no vertex is higher above the body's faces than `looseness`.
fn wrapped(field: &Field, body: &Body, bounds: &HullLimits, looseness: f64) -> Result<(Hull, f64), Option<DVec3>> {
    let middle = body.points.iter().sum::<DVec3>() / body.points.len().max(1) as f64;
    let greatest = body.low.abs().max(body.high.abs()).max_element() + bounds.limit;
    let room = (1e-3 * bounds.limit).clamp(3e-7 * bounds.diagonal, 2e-6 * bounds.diagonal) + 2.0 * ROUNDING * greatest;
    let depth = body.planes.iter().map(|plane| -plane.height(middle)).fold(f64::INFINITY, f64::min);
    // Written so that NaN fails.
    if !(depth > 20.0 * room) {
        return Err(None);
    }
    let max_vertices = bounds.max_vertices.min(body.points.len().saturating_sub(1));
    let mut faces = Faces { field, body, bounds, looseness, middle, room, refuted: Vec::new() };
    let mut planes = faces.largest();
    let mut proofs = 0;
    for _ in 0..MAX_STEPS {
        if bounds.is_over() {
            return Err(None);
        }
        let Some(vertices) = faces.vertices(&planes) else {
            if !faces.close(&mut planes) {
                return Err(None);
            }
            continue;
        };
        let point = match faces.too_far(&planes, &vertices) {
            Some(point) => point,
            None => {
                let (left, fewer) = faces.fewer(planes.clone(), vertices);
                let hull = faces.rounded(&fewer).ok_or(None)?;
                if hull.vertices.len() > max_vertices {
                    return simplified(field, &hull, bounds, max_vertices);
                }
                proofs += 1;
                match prove(field, &hull, bounds, MEASUREMENTS) {
                    Ok(bound) => return Ok((hull, bound)),
                    Err(None) => return Err(None),
                    Err(Some(_)) if proofs == MAX_PROOFS => return Err(None),
                    Err(Some(point)) => {
                        planes = left;
                        faces.refuted.push(point);
                        // The proof ends at the first point. Others save further proofs.
                        let polytope = Body::new(&fewer, 0.0);
                        let others = field.points_beyond(&polytope.triangles, bounds.limit, REFUTED, REFUTING);
                        faces.refuted.extend(others.into_iter().filter(|p| !body.holds(*p, 3.5 * room)));
                        point
                    }
                }
            }
        };
        if body.holds(point, 3.5 * room) {
            return Err(Some(point));
        }
        if !faces.cut_off(&mut planes, point) {
            return Err(None);
        }
    }
    Err(None)
}

/// A hull with at most `max_vertices` vertices around a hull that has a few more.
pub fn simplified(
    field: &Field,
    hull: &Hull,
    bounds: &HullLimits,
    max_vertices: usize,
) -> Result<(Hull, f64), Option<DVec3>> {
    let most = ((MANY * max_vertices as f64) as usize).max(FEW);
    if hull.vertices.len() > most || max_vertices < simplify::MIN_VERTICES {
        return Err(None);
    }
    let simplified = simplify::simplify(hull, simplify::Limit::Vertices(max_vertices));
    let Ok(Some(simplified)) = simplified else { return Err(None) };
    match prove(field, &simplified.hull, bounds, MEASUREMENTS) {
        Ok(bound) => Ok((simplified.hull, bound)),
        Err(_) => Err(None),
    }
}

/// Thin hulls that together contain a convex polygon, each with at most `max_vertices` vertices,
/// and the piece of the polygon that each contains.
pub fn of_polygon(polygon: &[DVec3], diagonal: f64, thickness: f64, max_vertices: usize) -> Vec<(Vec<DVec3>, Hull)> {
    let mut found = Vec::new();
    let mut stack = vec![polygon.to_vec()];
    while let Some(corners) = stack.pop() {
        let Some(hull) = tight(&corners, diagonal, thickness) else { continue };
        if hull.vertices.len() > max_vertices && corners.len() > 3 {
            // Both halves have the diagonal between them.
            let half = corners.len() / 2;
            stack.push(corners[..=half].to_vec());
            stack.push([&corners[half..], &corners[..1]].concat());
        } else {
            found.push((corners, few::within_vertices(hull, max_vertices)));
        }
    }
    found
}

/// The vertices of an intersection of half-spaces around the inner point `middle`, at least
/// `distance` apart; `None` if it reaches farther than `reach`.
pub fn polytope(planes: &[HalfSpace], middle: DVec3, reach: f64, distance: f64) -> Option<Vec<DVec3>> {
    let mut dual: Vec<DVec3> =
        planes.iter().map(|plane| plane.normal / (plane.offset - plane.normal.dot(middle))).collect();
    dual.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    dual.dedup();
    if dual.is_empty() || !dual.iter().all(|p| p.is_finite()) {
        return None;
    }
    let Simplex::Tetrahedron(simplex) = spanning_simplex(&dual) else { return None };
    let mut vertices: Vec<DVec3> = Vec::new();
    for facet in quickhull::hull(&dual, simplex) {
        let at = |i: usize| dual[facet[i] as usize];
        let area: DVec3 = (1..facet.len() - 1).map(|i| (at(i) - at(0)).cross(at(i + 1) - at(0))).sum();
        let offset = area.dot(at(0));
        let vertex = area / offset;
        // Written so that NaN and an origin outside are unbounded.
        if !(offset > 0.0) || !(vertex.length() < reach) {
            return None;
        }
        let vertex = middle + vertex;
        if vertices.iter().all(|other| other.distance(vertex) > distance) {
            vertices.push(vertex);
        }
    }
    Some(vertices)
}

struct Faces<'a> {
    field: &'a Field<'a>,
    body: &'a Body,
    bounds: &'a HullLimits<'a>,
    looseness: f64,
    middle: DVec3,
    room: f64,
    refuted: Vec<DVec3>,
}

impl Faces<'_> {
    fn plane(&self, face: usize) -> HalfSpace {
        self.body.planes[face]
    }

    fn largest(&self) -> Vec<HalfSpace> {
        let total: f64 = self.body.areas.iter().sum();
        let mut order: Vec<usize> = (0..self.body.planes.len()).collect();
        order.sort_by(|a, b| self.body.areas[*b].total_cmp(&self.body.areas[*a]).then(a.cmp(b)));
        let mut chosen: Vec<HalfSpace> = Vec::new();
        for face in order {
            let plane = self.plane(face);
            if self.body.areas[face] >= LARGE * total
                && chosen.iter().all(|other| other.normal.dot(plane.normal) < ALIKE)
            {
                chosen.push(plane);
            }
        }
        self.close(&mut chosen);
        chosen
    }

    /// Adds the sides of the body's box, except those to which a plane is nearly parallel. Returns
    /// whether it added any.
    fn close(&self, planes: &mut Vec<HalfSpace>) -> bool {
        let before = planes.len();
        for normal in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
            if planes.iter().all(|plane| plane.normal.dot(normal) < 0.8) {
                let offset = self.body.points.iter().map(|p| normal.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
                planes.push(HalfSpace { normal, offset });
            }
        }
        planes.len() > before
    }

    /// The vertices of the polytope of the planes, each moved outward; `None` if it is unbounded.
    fn vertices(&self, planes: &[HalfSpace]) -> Option<Vec<DVec3>> {
        let moved: Vec<HalfSpace> = planes.iter().map(|plane| plane.moved(self.room)).collect();
        let reach = 2.0 * self.bounds.diagonal + self.body.diagonal();
        polytope(&moved, self.middle, reach, 0.4 * self.room)
    }

    /// The point of the polytope farthest from the body among those too far from it or the solid.
    fn too_far(&self, planes: &[HalfSpace], vertices: &[DVec3]) -> Option<DVec3> {
        // A point on a face counts as inside, whatever the rounding error.
        let is_in = |p: &&DVec3| planes.iter().all(|plane| plane.height(**p) <= 2.0 * self.room);
        if let Some(point) = self.refuted.iter().find(is_in) {
            return Some(*point);
        }
        let limit = PLANNED * self.bounds.limit;
        let height =
            |p: &DVec3| self.body.planes.iter().map(|plane| plane.height(*p)).fold(f64::NEG_INFINITY, f64::max);
        let worst = |points: Vec<DVec3>| {
            let mut ranked: Vec<(f64, DVec3)> = points.into_iter().map(|p| (height(&p), p)).collect();
            ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
            // Points of the body cannot be cut off.
            let mut high = ranked.into_iter().filter(|(h, _)| *h > 3.5 * self.room);
            high.find(|(h, p)| *h > self.looseness || self.field.is_beyond(*p, limit))
        };
        if let Some((_, point)) = worst(vertices.to_vec()) {
            return Some(point);
        }
        let polytope = Body::new(vertices, 0.0);
        worst(face_points(&polytope, MEASURED, self.bounds.limit)).map(|(_, point)| point)
    }

    fn cut_off(&self, planes: &mut Vec<HalfSpace>, point: DVec3) -> bool {
        let above = self.body.face_below(point).filter(|(highest, _)| *highest > 3.0 * self.room);
        let Some((_, face)) = above else { return false };
        let plane = self.plane(face);
        if planes.contains(&plane) {
            return false;
        }
        planes.push(plane);
        true
    }

    fn rounded(&self, vertices: &[DVec3]) -> Option<Hull> {
        hull::of_positions(vertices.iter().map(|p| p.as_vec3().to_array().map(|c| c + 0.0)).collect())
    }

    fn fewer(&self, planes: Vec<HalfSpace>, vertices: Vec<DVec3>) -> (Vec<HalfSpace>, Vec<DVec3>) {
        let (mut left, mut best) = (planes, vertices);
        // The first planes are of large faces.
        let mut at = left.len();
        while at > 0 && left.len() > 4 && !self.bounds.is_over() {
            at -= 1;
            let mut fewer = left.clone();
            fewer.remove(at);
            let Some(vertices) = self.vertices(&fewer) else { continue };
            if vertices.len() < best.len() && self.too_far(&fewer, &vertices).is_none() {
                (left, best) = (fewer, vertices);
            }
        }
        (left, best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{fit::Solid, test_meshes::block};

    /// A plate, which may get a thickness of 0.2 only where it may protrude by half of that.
    #[test]
    fn a_hull_stays_thin_where_the_thick_one_protrudes_too_far() {
        let mesh = block([-1.0, -1.0, 0.0], [1.0, 1.0, 0.001]);
        let (solid, plate) = (Solid::new(&mesh), hull::build(&mesh).unwrap());
        let field = Field::new(&solid);
        let result = |limit: f64| {
            let (max_vertices, diagonal) = (64, solid.diagonal());
            let bounds =
                HullLimits { limit, max_vertices, diagonal, thickness: 0.2, deadline: None, stage: Stage::default() };
            let found = thick(&field, plate.clone(), &bounds);
            assert!(prove(&field, &found, &bounds, MEASUREMENTS).is_ok());
            thinnest(&found.positions()).1
        };
        assert!((result(0.11) - 0.2).abs() < 1e-3 && (result(0.09) - 0.001).abs() < 1e-6);
    }
}
