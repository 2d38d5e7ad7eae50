//! GJK: the point of a convex hull nearest to a given point.
//!
//! # Steps
//! 1. Start with any vertex of the hull.
//! 2. Add the support vertex in the direction from the current point to the given point.
//! 3. Take the nearest point in the simplex of the current vertices, and keep only the vertices of
//!    the smallest face that contains it.
//! 4. Repeat. The distance falls with every step.
//!
//! # Reference
//! Gilbert, Johnson, Keerthi, "A fast procedure for computing the distance between complex objects
//! in three-dimensional space", 1988.
//!
//! # Deviations
//! - It is not the solver's: the bytes of packs depend on how it rounds, and the baker does not
//!   depend on the runtime.
//! - Support vertices are found by hill climbing from the previous one. At a plateau of rounding
//!   error, the answer is nearest except in the last digits. [`Nearest::certain`] searches all
//!   vertices unless one is certainly the farthest.

use glam::DVec3;
use rayon::prelude::*;

use crate::hull::{Hull, adjacency::Adjacency};
use hullmap_geometry::bounds;

/// Maximum number of steps, after which the best point is returned; three to eight are common.
const MAX_STEPS: usize = 60;

/// Minimum gain of a support vertex in the search direction, relative to the largest coordinate.
const PROGRESS: f64 = 1e-14;

/// Number of climbing steps after which a sample of the vertices is searched. Ten are common.
const LONG_WAY: usize = 24;

/// Difference of heights, relative to the largest coordinate and the sum of the direction's
/// coordinates, that is certain: ten times the bound on rounding error.
const CERTAIN: f64 = 1e-14;

/// Twice the rounding error of a height, in the same unit, with a margin of a half: three products
/// and two sums round at most three times each.
const ROUNDING: f64 = 1e-15;

const TILTS: usize = 24;

/// Minimum number of vertices of a hull with a guide. Climbs of a smaller one are short.
const GUIDED_FROM: usize = 256;

/// Number of cells of a guide for each vertex. With four, most climbs start at their end.
const CELLS_PER_VERTEX: usize = 4;

/// Maximum number of cells along the edge of a guide's cube.
const MAX_CELLS: usize = 256;

/// Maximum number of steps of a guided climb. One or two are common.
const GUIDED_STEPS: usize = 16;

/// Minimum depth of the flattest vertex of a hull with a guide, relative to the largest coordinate.
const LEAST_DEPTH: f64 = 1e-11;

const MORTON_BITS: u32 = 10;

const TOGETHER: usize = 8;

/// A hull prepared for nearest-point searches.
pub struct Nearest {
    points: Vec<DVec3>,
    /// Place of each vertex along the Morton curve. The vertices of a mesh may be in any order, but
    /// a search reads those that are near each other.
    places: Vec<u32>,
    /// For each place, the start of its run in `around`; then the end of the last one.
    starts: Vec<u32>,
    /// For each place, its vertex, then its neighbours by ascending vertex: one run of memory.
    around: Vec<Corner>,
    samples: [Vec<f64>; 3],
    stride: usize,
    scale: f64,
    is_solid: bool,
    guide: Option<Guide>,
}

/// A vertex near the support vertex of each cell of a cube of directions.
///
/// A climb depends on where it starts only because of rounding error: it may end at a vertex x
/// whose neighbours are higher by less than that error. If a vertex v is higher than all its
/// neighbours by D, that cannot happen for a large D, and every climb ends at v:
///
/// - v − x is a sum of edges at x with weights that are not negative. They add up to at most L / η,
///   where L is the diameter, and η is the depth of x: the least distance by which an edge at x
///   descends from some plane through x.
/// - No edge at x ascends by more than twice the error E, so v is higher than x by at most
///   2 E L / η. But it is higher by at least D.
struct Guide {
    resolution: usize,
    starts: Vec<u32>,
    /// Value of D above which every climb ends at the same vertex, in the unit of [`CERTAIN`].
    certain: f64,
}

#[derive(Clone, Copy)]
struct Corner {
    position: [f32; 3],
    index: u32,
}

impl Corner {
    fn position(&self) -> DVec3 {
        DVec3::from_array(self.position.map(f64::from))
    }
}

/// A point of the hull, and a hull vertex near it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// The point, inside the hull except for rounding error.
    pub point: DVec3,
    /// A good start for a search near this point.
    pub vertex: u32,
}

impl Nearest {
    /// Prepares `hull`, which must be solid.
    pub fn new(hull: &Hull) -> Self {
        let points = hull.positions();
        let scale = points.iter().fold(0.0, |scale: f64, p| scale.max(p.abs().max_element()));
        let adjacency = Adjacency::new(hull);
        let order = along_morton_curve(&points);
        let mut places = vec![0; points.len()];
        for (place, vertex) in (0..).zip(&order) {
            places[*vertex as usize] = place;
        }
        let mut starts = Vec::with_capacity(points.len() + 1);
        let mut around = Vec::with_capacity(adjacency.neighbours.len() + points.len());
        for vertex in order {
            starts.push(around.len() as u32);
            let corner = |vertex: u32, index: u32| Corner { position: hull.vertices[vertex as usize], index };
            around.push(corner(vertex, vertex));
            around.extend(adjacency.neighbours(vertex).iter().map(|w| corner(*w, places[*w as usize])));
        }
        starts.push(around.len() as u32);
        let stride = points.len().isqrt().max(1);
        let samples = [0, 1, 2].map(|axis| points.iter().step_by(stride).map(|p| p[axis]).collect());
        let is_solid = hull.rank == 3;
        let mut nearest = Self { points, places, starts, around, samples, stride, scale, is_solid, guide: None };
        if is_solid && hull.vertices.len() >= GUIDED_FROM {
            nearest.guide = nearest.make_guide(hull);
        }
        nearest
    }

    /// `None` if a vertex is so flat that no difference is certain.
    fn make_guide(&self, hull: &Hull) -> Option<Guide> {
        let depth = self.least_depth(hull);
        // Written so that NaN fails.
        if !(depth > LEAST_DEPTH * self.scale) {
            return None;
        }
        let resolution = (CELLS_PER_VERTEX * hull.vertices.len() / 6).isqrt().clamp(1, MAX_CELLS);
        let mut starts = Vec::with_capacity(6 * resolution * resolution);
        let mut vertex = 0;
        for cell in 0..6 * resolution * resolution {
            let (face, row, column) =
                (cell / (resolution * resolution), cell / resolution % resolution, cell % resolution);
            let middle = |step: usize| (2 * step + 1) as f64 / resolution as f64 - 1.0;
            let mut direction = DVec3::ZERO;
            let axis = face / 2;
            direction[axis] = if face % 2 == 0 { 1.0 } else { -1.0 };
            direction[(axis + 1) % 3] = middle(column);
            direction[(axis + 2) % 3] = middle(row);
            if column == 0 && row > 0 {
                vertex = starts[cell - resolution];
            }
            while let Some(next) = self.step(direction, vertex).0 {
                vertex = next;
            }
            starts.push(vertex);
        }
        Some(Guide { resolution, starts, certain: ROUNDING * (1.0 + hull.diameter / depth) })
    }

    /// The depth of the flattest vertex: the least distance by which an edge descends from a plane
    /// through the vertex. The plane starts at right angles to the mean normal of the faces, and is
    /// tilted away from the edge that descends the least, which makes a vertex at a short edge a
    /// hundred times as deep.
    fn least_depth(&self, hull: &Hull) -> f64 {
        let mut normals = vec![DVec3::ZERO; self.points.len()];
        for face in &hull.faces {
            let [a, b, c] = [0, 1, 2].map(|corner| self.points[face[corner] as usize]);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            face.iter().for_each(|v| normals[*v as usize] += normal);
        }
        let depth_of = |v: usize| {
            let point = self.points[v];
            let least = |normal: DVec3| {
                let edges = self.neighbours(self.places[v]).iter().map(|w| w.position() - point);
                edges.fold((f64::INFINITY, DVec3::ZERO), |least, edge| {
                    let depth = -normal.dot(edge);
                    if depth < least.0 { (depth, edge) } else { least }
                })
            };
            let mut normal = normals[v].normalize_or_zero();
            let mut best = least(normal);
            let mut tilt = 0.25;
            for _ in 0..TILTS {
                let tilted = (normal - best.1.normalize_or_zero() * tilt).normalize_or_zero();
                let next = least(tilted);
                if next.0 > best.0 {
                    (normal, best) = (tilted, next);
                } else {
                    tilt *= 0.5;
                }
            }
            best.0
        };
        (0..self.points.len()).into_par_iter().map(depth_of).reduce(|| f64::INFINITY, f64::min)
    }

    fn run(&self, place: u32) -> &[Corner] {
        let [start, end] = [0, 1].map(|next| self.starts[place as usize + next] as usize);
        &self.around[start..end]
    }

    fn neighbours(&self, place: u32) -> &[Corner] {
        &self.run(place)[1..]
    }

    fn position(&self, place: u32) -> DVec3 {
        self.around[self.starts[place as usize] as usize].position()
    }

    fn vertex_at(&self, place: u32) -> u32 {
        self.around[self.starts[place as usize] as usize].index
    }

    /// The place of the highest neighbour of the vertex at a place, if that is higher; otherwise,
    /// how much higher the vertex is than all neighbours.
    fn step(&self, direction: DVec3, from: u32) -> (Option<u32>, f64) {
        let [own, neighbours @ ..] = self.run(from) else { return (None, f64::NAN) };
        let height = own.position().dot(direction);
        let mut highest = (f64::NEG_INFINITY, from);
        for next in neighbours {
            let height = next.position().dot(direction);
            highest = if height > highest.0 { (height, next.index) } else { highest };
        }
        ((highest.0 > height).then_some(highest.1), height - highest.0)
    }

    /// The place at which every climb ends, and how much higher its vertex is than all its
    /// neighbours; `None` if that is not certain.
    fn guided(&self, direction: DVec3) -> Option<(u32, f64)> {
        let guide = self.guide.as_ref()?;
        let size = direction.abs();
        let axis = size.max_position();
        let face = 2 * axis + usize::from(direction[axis] < 0.0);
        let cell = |axis: usize| {
            let at = (direction[axis % 3] / size.max_element() + 1.0) * 0.5;
            // Casts saturate, and turn NaN into 0.
            ((at * guide.resolution as f64) as usize).min(guide.resolution - 1)
        };
        let (column, row) = (cell(axis + 1), cell(axis + 2));
        let mut vertex = guide.starts[(face * guide.resolution + row) * guide.resolution + column];
        for _ in 0..GUIDED_STEPS {
            match self.step(direction, vertex) {
                (Some(next), _) => vertex = next,
                // Written so that NaN fails.
                (None, lower) => {
                    return (lower > guide.certain * self.scale * size.element_sum()).then_some((vertex, lower));
                }
            }
        }
        None
    }

    /// The nearest point to `target`. The search starts at vertex `start`.
    pub fn nearest_from(&self, target: DVec3, start: u32) -> Foot {
        self.search(target, start, |direction, from| self.climb_from(direction, from))
    }

    /// The nearest point to `target`, searching all vertices.
    pub fn certain(&self, target: DVec3) -> Foot {
        self.search(target, 0, |direction, _| self.farthest(direction))
    }

    /// A support vertex in `direction`, found by climbing from vertex `from`.
    pub fn climb(&self, direction: DVec3, from: u32) -> u32 {
        self.vertex_at(self.climb_from(direction, self.places[from as usize]))
    }

    /// The certain support vertex in `direction`, and how much higher it is than all others.
    pub fn certain_climb(&self, direction: DVec3) -> Option<(u32, f64)> {
        self.guided(direction).map(|(place, lower)| (self.vertex_at(place), lower))
    }

    /// Maximum height of a vertex above the end of a climb in a unit direction, except for the
    /// rounding error of heights; infinite if that is not known.
    pub fn climbing_error(&self) -> f64 {
        self.guide.as_ref().map_or(f64::INFINITY, |guide| guide.certain * self.scale * 3_f64.sqrt())
    }

    /// As [`Self::climb`], for places. A long climb continues from the best of a sample, since a
    /// face with ten thousand corners would take as many steps. One that ends is also continued
    /// once from the sample, because rounding can hide the ascent among vertices close together.
    fn climb_from(&self, direction: DVec3, from: u32) -> u32 {
        if let Some((place, _)) = self.guided(direction) {
            return place;
        }
        let mut best = (self.position(from).dot(direction), from);
        let doubt = CERTAIN * self.scale * direction.abs().element_sum();
        let mut is_sampled = false;
        for step in 0.. {
            let before = best;
            let mut highest = f64::NEG_INFINITY;
            for next in self.neighbours(before.1) {
                let height = next.position().dot(direction);
                if height > highest {
                    highest = height;
                    if height > best.0 {
                        best = (height, next.index);
                    }
                }
            }
            let is_highest = best.1 == before.1;
            if is_highest || step == LONG_WAY {
                // The second highest vertex of a convex polytope is a neighbour of the highest. If
                // all neighbours are certainly lower, so are all other vertices, and the sample has
                // none to continue from. Written so that NaN samples.
                if is_highest && (is_sampled || self.is_solid && before.0 - highest > doubt) {
                    break;
                }
                if !is_sampled {
                    is_sampled = true;
                    self.sample(direction, &mut best);
                    if best.1 == before.1 {
                        break;
                    }
                }
            }
        }
        best.1
    }

    /// Replaces `best` by the first of the highest sampled vertices, if that is higher.
    fn sample(&self, direction: DVec3, best: &mut (f64, u32)) {
        let [x, y, z] = self.samples.each_ref().map(|samples| samples.chunks(TOGETHER));
        for (chunk, ((x, y), z)) in x.zip(y).zip(z).enumerate() {
            let mut heights = [f64::NEG_INFINITY; TOGETHER];
            // With the operations of `DVec3::dot`, in their order.
            for (height, ((x, y), z)) in heights.iter_mut().zip(x.iter().zip(y).zip(z)) {
                *height = x * direction.x + y * direction.y + z * direction.z;
            }
            if heights.iter().any(|height| *height > best.0) {
                for (at, height) in heights.into_iter().enumerate() {
                    if height > best.0 {
                        *best = (height, self.places[(chunk * TOGETHER + at) * self.stride]);
                    }
                }
            }
        }
    }

    fn farthest(&self, direction: DVec3) -> u32 {
        self.guided(direction).map_or_else(|| self.scan(direction), |(place, _)| place)
    }

    fn scan(&self, direction: DVec3) -> u32 {
        let heights = self.points.iter().map(|p| p.dot(direction));
        let best = heights.enumerate().fold(
            (f64::NEG_INFINITY, 0),
            |best, (i, height)| {
                if height > best.0 { (height, i) } else { best }
            },
        );
        self.places[best.1]
    }

    /// The mean of the vertices, which lies inside the hull.
    pub fn middle(&self) -> DVec3 {
        self.points.iter().sum::<DVec3>() / self.points.len() as f64
    }

    /// Positions of the vertices.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Position of a vertex.
    pub fn vertex(&self, index: u32) -> DVec3 {
        self.points[index as usize]
    }

    fn search(&self, target: DVec3, start: u32, farthest: impl Fn(DVec3, u32) -> u32) -> Foot {
        let mut simplex = [self.places[start as usize]; 4];
        let mut count = 1;
        let mut point = self.vertex(start);
        let mut corners = [point - target; 4];
        for _ in 0..MAX_STEPS {
            let towards = target - point;
            let next = farthest(towards, simplex[count - 1]);
            let vertex = self.position(next);
            let gained = towards.dot(vertex - point);
            // Written so that NaN ends the search.
            if !(gained > PROGRESS * self.scale * towards.length()) || simplex[..count].contains(&next) {
                break;
            }
            (simplex[count], corners[count]) = (next, vertex - target);
            let Some((nearest, face)) = nearest_face(&corners, count) else { break };
            let nearest = target + nearest;
            if !(nearest.distance_squared(target) < point.distance_squared(target)) {
                break;
            }
            point = nearest;
            let mut kept = 0;
            for corner in 0..=count {
                if face >> corner & 1 == 1 {
                    (simplex[kept], corners[kept]) = (simplex[corner], corners[corner]);
                    kept += 1;
                }
            }
            count = kept;
            if count == 4 {
                // The target is inside.
                break;
            }
        }
        Foot { point, vertex: self.vertex_at(simplex[count - 1]) }
    }
}

/// Indices of points in their order along the Morton curve through their bounding box.
fn along_morton_curve(points: &[DVec3]) -> Vec<u32> {
    let [low, high] = bounds(points.iter().copied());
    let cells = f64::from((1_u32 << MORTON_BITS) - 1);
    let code = |p: DVec3| -> u32 {
        // Casts turn the NaN of a flat box into 0.
        let cell = ((p - low) / (high - low) * cells).to_array().map(|c| c as u32);
        let bit = |bit: u32| (0..3).map(move |axis| (cell[axis as usize] >> bit & 1) << (3 * bit + axis));
        (0..MORTON_BITS).flat_map(bit).sum()
    };
    let mut order: Vec<(u32, u32)> = points.iter().zip(0..).map(|(p, index)| (code(*p), index)).collect();
    order.sort_unstable();
    order.into_iter().map(|(_, index)| index).collect()
}

/// The point of a simplex nearest to the origin, and the smallest face that contains it, as a bit
/// per corner. The face always contains corner `new`, which lies farther in the search direction
/// than all others. `None` on overflow. Ties go to the face with the lowest bits.
fn nearest_face(corners: &[DVec3; 4], new: usize) -> Option<(DVec3, u32)> {
    let [a, b, c, _] = *corners;
    let n = corners[new];
    let only_new = 1_u32 << new;
    let distance = n.length_squared();
    let mut best = Best { distance, point: n, face: only_new };
    if !(distance < f64::INFINITY) {
        best = Best { distance: f64::INFINITY, point: DVec3::ZERO, face: 0 };
    }
    let from_a = n - a;
    best.take(on_segment(a, from_a), 1 | only_new);
    if new >= 2 {
        let (from_b, ab) = (n - b, b - a);
        let crosses = [a.cross(b), b.cross(n), a.cross(n)];
        best.take(on_segment(b, from_b), 2 | only_new);
        best.take(on_triangle(a, ab.cross(from_a), crosses), 3 | only_new);
        if new == 3 {
            let (from_c, ac, bc) = (n - c, c - a, c - b);
            let [ab_cross, bn_cross, an_cross] = crosses;
            let (ac_cross, bc_cross, cn_cross) = (a.cross(c), b.cross(c), c.cross(n));
            best.take(on_segment(c, from_c), 4 | only_new);
            best.take(on_triangle(a, ac.cross(from_a), [ac_cross, cn_cross, an_cross]), 5 | only_new);
            best.take(on_triangle(b, bc.cross(from_b), [bc_cross, cn_cross, bn_cross]), 6 | only_new);
            let volume = ab.cross(ac).dot(from_a);
            let parts = [bc_cross.dot(n), an_cross.dot(c), ab_cross.dot(n), ac_cross.dot(b)];
            let is_inside = parts.into_iter().all(|part| part / volume >= 0.0);
            best.take(is_inside.then_some(DVec3::ZERO), 7 | only_new);
        }
    }
    (best.face != 0).then_some((best.point, best.face))
}

struct Best {
    distance: f64,
    point: DVec3,
    face: u32,
}

impl Best {
    #[inline(always)]
    fn take(&mut self, point: Option<DVec3>, face: u32) {
        let Some(point) = point else { return };
        let distance = point.length_squared();
        if distance < self.distance {
            *self = Self { distance, point, face };
        }
    }
}

/// The point nearest to the origin on the line from `a` along `along`, if it lies on the segment.
#[inline(always)]
fn on_segment(a: DVec3, along: DVec3) -> Option<DVec3> {
    let t = -a.dot(along) / along.length_squared();
    (0.0..=1.0).contains(&t).then(|| a + along * t)
}

/// The point nearest to the origin in the plane of a triangle, if it lies in the triangle. `ab`,
/// `bc` and `ac` are cross products of the corners.
#[inline(always)]
fn on_triangle(a: DVec3, normal: DVec3, [ab, bc, ac]: [DVec3; 3]) -> Option<DVec3> {
    let area = normal.length_squared();
    // The weights of the corners a, b and c. A negative one decides without the others.
    let heights = [bc.dot(normal), -ac.dot(normal), ab.dot(normal)];
    if heights.into_iter().any(|height| height < 0.0 && height / area < 0.0) {
        return None;
    }
    let weights = DVec3::from_array(heights) / area;
    (weights.min_element() >= 0.0).then(|| normal * (a.dot(normal) / area))
}

#[cfg(test)]
mod tests {
    use shapes::{families::Family, rng::SplitMix64};

    use super::*;
    use crate::test_meshes::{hull_of, surface_of};
    use hullmap_geometry::{PointSet, triangle};

    /// The point nearest to the origin in the plane or line of the corners, if between them.
    fn inside_face(corners: &[DVec3]) -> Option<DVec3> {
        match *corners {
            [a] => Some(a),
            [a, b] => {
                let along = b - a;
                let t = -a.dot(along) / along.length_squared();
                (0.0..=1.0).contains(&t).then(|| a + along * t)
            }
            [a, b, c] => {
                let normal = (b - a).cross(c - a);
                let area = normal.length_squared();
                let weights = DVec3::new(b.cross(c).dot(normal), c.cross(a).dot(normal), a.cross(b).dot(normal)) / area;
                (weights.min_element() >= 0.0).then(|| normal * (a.dot(normal) / area))
            }
            [a, b, c, d] => {
                let volume = (b - a).cross(c - a).dot(d - a);
                let part = |p: DVec3, q: DVec3, r: DVec3| p.cross(q).dot(r) / volume;
                let weights = [part(b, c, d), part(a, d, c), part(a, b, d), part(a, c, b)];
                weights.iter().all(|w| *w >= 0.0).then_some(DVec3::ZERO)
            }
            _ => None,
        }
    }

    fn slow_face(corners: &[DVec3]) -> Option<(DVec3, u32)> {
        let (new, others) = corners.split_last().unwrap();
        let mut best: Option<(f64, DVec3, u32)> = None;
        for choice in 0..1_u32 << others.len() {
            let chosen = others.iter().enumerate().filter(|(index, _)| choice >> index & 1 == 1).map(|(_, p)| *p);
            let positions: Vec<DVec3> = chosen.chain([*new]).collect();
            let Some(nearest) = inside_face(&positions) else { continue };
            let distance = nearest.length_squared();
            if distance < best.map_or(f64::INFINITY, |best| best.0) {
                best = Some((distance, nearest, choice | 1 << others.len()));
            }
        }
        best.map(|(_, point, face)| (point, face))
    }

    /// The slow twin: the nearest point on all faces, as triangle fans.
    fn slow(surface: &PointSet, target: DVec3) -> f64 {
        let distance = |corners: &[u32; 3]| triangle::nearest(&surface.corners(corners), target).distance(target);
        surface.triangles.iter().map(distance).fold(f64::INFINITY, f64::min)
    }

    fn slow_climb(hull: &Hull, adjacency: &Adjacency, direction: DVec3, from: u32) -> u32 {
        let points = hull.positions();
        let mut best = (points[from as usize].dot(direction), from);
        let mut is_sampled = false;
        for step in 0.. {
            let before = best.1;
            for &next in adjacency.neighbours(before) {
                let height = points[next as usize].dot(direction);
                if height > best.0 {
                    best = (height, next);
                }
            }
            if best.1 == before || step == LONG_WAY {
                if is_sampled && best.1 == before {
                    break;
                }
                if !is_sampled {
                    is_sampled = true;
                    for index in (0..points.len()).step_by(points.len().isqrt().max(1)) {
                        let height = points[index].dot(direction);
                        if height > best.0 {
                            best = (height, index as u32);
                        }
                    }
                    if best.1 == before {
                        break;
                    }
                }
            }
        }
        best.1
    }

    #[test]
    fn nearest_faces_match_the_slow_twin() {
        const SEED: u64 = 12;
        let mut rng = SplitMix64::new(SEED);
        let mut faces = [0_usize; 16];
        for round in 0..60_000 {
            let (far, grid) = ([0.0, 0.5, 3.0, 1e6][round % 4], round / 4 % 3 == 0);
            let middle = DVec3::from_array(rng.direction()) * far;
            let mut corners: [DVec3; 4] = std::array::from_fn(|_| {
                let p = DVec3::from_array(rng.direction()) * rng.between(0.0, 2.0);
                middle + if grid { p.round() } else { p }
            });
            match round / 12 % 5 {
                0 => corners[3] = corners[0].lerp(corners[1], 0.25) + (corners[2] - corners[0]) * 0.5,
                1 => corners[2] = corners[0].lerp(corners[1], rng.between(-1.0, 2.0)),
                2 => corners[round / 60 % 3] *= 1e-9,
                _ => {}
            }
            for new in 1..4 {
                let found = nearest_face(&corners, new);
                let expected = slow_face(&corners[..=new]);
                let bits = |face: Option<(DVec3, u32)>| face.map(|(p, face)| (p.to_array().map(f64::to_bits), face));
                assert_eq!(bits(found), bits(expected), "{corners:?}, seed {SEED}");
                found.into_iter().for_each(|(_, face)| faces[face as usize] += 1);
            }
        }
        assert_eq!(nearest_face(&[DVec3::splat(f64::NAN); 4], 3), None);
        assert_eq!(nearest_face(&[DVec3::splat(1e200); 4], 2), None);
        println!("{faces:?}");
        // Every face that contains the newest corner.
        let all = (1..4).flat_map(|new| (1 << new)..(2 << new));
        assert!(all.into_iter().all(|face| faces[face] > 300), "{faces:?}");
    }

    #[test]
    fn climbs_end_where_slow_ones_do() {
        const SEED: u64 = 8;
        let mut rng = SplitMix64::new(SEED);
        let mut guided = 0;
        for family in Family::ALL {
            for far in [0.0_f32, 300.0] {
                let hull = hull_of(family.points(900, 3).iter().map(|p| p.map(|c| c + far)).collect());
                if hull.rank < 2 {
                    continue;
                }
                let (nearest, adjacency) = (Nearest::new(&hull), Adjacency::new(&hull));
                let points = hull.positions();
                for round in 0..600 {
                    let mut any = || points[rng.below(points.len())];
                    let direction = match round % 3 {
                        0 => DVec3::from_array(rng.direction()),
                        1 => (any() - any()).cross(any() - any()),
                        _ => any() - any(),
                    };
                    let from = rng.below(points.len()) as u32;
                    let slow = slow_climb(&hull, &adjacency, direction, from);
                    assert_eq!(nearest.climb(direction, from), slow, "{family:?} {far} {round}, seed {SEED}");
                    assert_eq!(nearest.farthest(direction), nearest.scan(direction), "{family:?} {far} {round}");
                    guided += usize::from(nearest.guided(direction).is_some());
                }
            }
        }
        println!("{guided} guided climbs");
        assert!(guided > 2_000, "{guided}");
    }

    fn on_surface(nearest: &Nearest, rng: &mut SplitMix64) -> DVec3 {
        nearest.position(nearest.farthest(DVec3::from_array(rng.direction())))
    }

    #[test]
    fn agrees_with_all_faces() {
        let mut rng = SplitMix64::new(4);
        for family in [Family::Sphere, Family::Rock, Family::Cone, Family::Prism, Family::Needle, Family::CubeGrid] {
            let hull = hull_of(family.points(216, 3));
            let (nearest, surface, half_spaces) = (Nearest::new(&hull), surface_of(&hull), hull.half_spaces());
            let (mut start, mut outside) = (0, 0);
            for round in 0..300 {
                let far = [1.01, 1.2, 3.0][round % 3];
                let inside = nearest.middle().lerp(on_surface(&nearest, &mut rng), rng.between(0.0, 1.0));
                for found in [nearest.certain(inside), nearest.nearest_from(inside, start)] {
                    assert!(found.point.distance(inside) <= 1e-9 * hull.diameter, "{family:?} {round}");
                }
                let on = on_surface(&nearest, &mut rng);
                let target = on
                    + (on - nearest.middle()) * (far - 1.0)
                    + DVec3::from_array(rng.direction()) * (far - 1.0) * 0.02 * hull.diameter;
                // Inside a thin hull, the distance is 0.
                if half_spaces.iter().all(|plane| plane.height(target) <= 0.0) {
                    continue;
                }
                outside += 1;
                let expected = slow(&surface, target);
                let certain = nearest.certain(target).point.distance(target);
                let climbed = nearest.nearest_from(target, start);
                start = climbed.vertex;
                for found in [certain, climbed.point.distance(target)] {
                    assert!((found - expected).abs() <= 1e-9 * hull.diameter, "{family:?} {round}: {found} {expected}");
                }
            }
            assert!(outside > 200, "{family:?}: {outside}");
        }
    }
}
