//! Rays and linear shape casts of compounds: the first hit over all pairs of parts.
//!
//! # Steps
//! 1. Visit the pairs of boxes that meet on the path, the first ones first. Parts cannot meet
//!    before their boxes do, so pairs beyond the first certain hit are skipped.
//! 2. Cast each pair by itself.
//! 3. The first of all hits has the minimum of their lower bounds and the minimum of their upper
//!    bounds. A pair that only grazes may miss, so its upper bound does not count; but if it is the
//!    nearest, the answer is its point.
//!
//! # Reference
//! Branch and bound, as for [`distance`](super::distance()).

use super::bvh::{Node, Nodes, PlacedBox, Placement};
use super::parts::Parts;
use super::sheet::CandidatePair;
use super::traversal::{BoxPairs, Traversal};
use super::{CompoundAnswer, CompoundCache};
use crate::height_field::walk::Walk;
use crate::pose::Pose;
use crate::shapes::Shape;
use crate::solver::cast::cast as cast_pair;
use crate::solver::motion::Path;
use crate::solver::ray::ray as cast_ray;
use crate::solver::ray_triangle::{is_towards_front, ray_triangle};
use crate::solver::{CastSettings, Impact, Motion, Ray, RayHit, Status};
use glam::DVec3;

/// Relative rounding error of a length that follows from a time and a speed.
const LENGTH_ERROR: f64 = 8.0 * f64::EPSILON;

/// When `b`, which starts at `b_in_a` and translates by `motion`, first meets `a`.
///
/// The answer comes from the pair of parts that meet first, and its interval contains the time of
/// impact of the compounds. A pair that grazes, where rounding error decides, before the first
/// certain hit is the answer, with the status [`Stalled`](Status::Stalled), and the interval
/// extends to the certain hit. If only grazing pairs were found, it contains the intervals of all
/// of them. If there is no hit, points and normal mean nothing. A point
/// ([`Sphere`](crate::shapes::Sphere) of radius 0) meets triangles and hulls exactly as a [`ray`]
/// does.
///
/// `cache` belongs to this ordered pair of compounds; the query reads and updates it.
///
/// # Complexity
/// Branch and bound: at most G H casts for compounds of G and H, and usually only the few pairs
/// within the distance covered until the hit. No allocation.
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = two_cubes();
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Sphere;
/// use hullmap::{CastSettings, Compound, CompoundCache, Motion, Pose, compound};
///
/// // Two unit cubes, at x from 0 to 1 and from 3 to 4. A ball falls into the gap, then to the right.
/// let (cubes, ball) = (Compound::new(&pack), Sphere::new(0.5)?);
/// let (settings, mut cache) = (CastSettings::default(), CompoundCache::default());
/// let start = Pose::from_translation(DVec3::new(2.0, 0.5, 3.0))?;
/// let down = Motion::new(DVec3::new(0.0, 0.0, -1.0))?;
/// assert!(!compound::cast(&cubes, &ball, start, down, &settings, &mut cache).answer.hit);
/// let right = Motion::new(DVec3::new(1.0, 0.0, -1.0))?;
/// let impact = compound::cast(&cubes, &ball, start, right, &settings, &mut cache);
/// assert_eq!(impact.hulls, [1, 0]);
/// assert!(impact.answer.t_lower <= impact.answer.t && impact.answer.t <= impact.answer.t_upper);
/// # Ok(())
/// # }
/// ```
pub fn cast<A: Parts + ?Sized, B: Parts + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    motion: Motion,
    settings: &CastSettings,
    cache: &mut CompoundCache,
) -> CompoundAnswer<Impact> {
    let placement = Placement::new(a.nodes(), b.nodes(), b_in_a);
    let first = first_hit(placement, motion, settings, |pair| {
        let parts = CandidatePair::new(a, b, pair, b_in_a).filter(|parts| !parts.is_passed(motion.velocity()))?;
        Some(cast_pair(&parts.a, &parts.b, b_in_a, motion, settings, cache.pair(pair)))
    });
    if a.part_count() == 0 || b.part_count() == 0 {
        // Only in a pack that was opened without checks: nothing is known.
        return CompoundAnswer { answer: Impact::default(), ..first };
    }
    first
}

/// Where `ray` first enters `a`.
///
/// The ray is in the frame of the compound. The answer comes from the part that is hit first, and
/// its interval contains the t of the whole compound. `hulls` has the index of the part first. If
/// there is no hit, the normal means nothing.
///
/// Triangles and convex hulls are closed, and so is the ray at both ends, from t = 0 to `max_t`.
/// Whether they meet is decided exactly. So a ray through an edge, a vertex or a seam hits every
/// triangle and every part there, with certainty, and cannot slip between them to the surface
/// behind. Other shapes, such as spheres, may be grazed, where rounding error decides. A grazed
/// part that is nearer than the first certain hit is the answer, with the status
/// [`Stalled`](Status::Stalled), and the interval extends to the certain hit. If only grazed parts
/// were found, the interval contains the intervals of all of them.
///
/// # Complexity
/// Branch and bound: at most one ray cast for each part, and none for parts farther away than the
/// first hit. No allocation.
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = two_cubes();
/// use hullmap::glam::DVec3;
/// use hullmap::{CastSettings, Compound, Ray, compound};
///
/// // Two unit cubes, at x from 0 to 1 and from 3 to 4. The ray starts between them.
/// let right = Ray::new(DVec3::new(2.0, 0.5, 0.5), DVec3::X)?;
/// let hit = compound::ray(&Compound::new(&pack), &right, &CastSettings::default());
/// assert_eq!(hit.hulls, [1, 0]);
/// assert!(hit.answer.hit && (hit.answer.t - 1.0).abs() < 1e-9);
/// # Ok(())
/// # }
/// ```
pub fn ray<A: Parts + ?Sized>(a: &A, ray: &Ray, settings: &CastSettings) -> CompoundAnswer<RayHit> {
    let origin = Nodes::one(DVec3::ZERO, DVec3::ZERO);
    let placement = Placement::new(a.nodes(), origin, Pose::from_checked(ray.origin()));
    let cast_part = |part: usize| {
        let is_one_sided = a.front(part).is_some();
        let part = a.part(part)?;
        let found = match part.triangle() {
            Some(corners) if is_one_sided && !is_towards_front(corners, ray) => return None,
            Some(corners) => ray_triangle(corners, ray, settings),
            None => cast_ray(&part, ray, settings),
        };
        let RayHit { hit, status, t, t_lower, t_upper, point, normal, iterations, support_calls } = found;
        let [point_a, point_b] = [point; 2];
        Some(Impact { hit, status, t, t_lower, t_upper, normal, point_a, point_b, iterations, support_calls })
    };
    let (nodes, margin) = (a.nodes(), placement.rounding_error());
    let first = ray.motion().path().and_then(|path| {
        let line = [ray.origin(), path.direction];
        if let Some(field) = nodes.field() {
            return Some(first_along(path, settings, cast_part, |reach, visit| {
                Walk::run(field, line, margin, reach, visit)
            }));
        }
        let mesh = nodes.mesh()?;
        Some(first_along(path, settings, cast_part, |reach, visit| mesh.along(line, margin, reach, visit)))
    });
    let first = first.unwrap_or_else(|| first_hit(placement, ray.motion(), settings, |pair| cast_part(pair[0])));
    let CompoundAnswer { answer, hulls, pairs, boxes } = first;
    let answer = if a.part_count() == 0 { Impact::default() } else { answer };
    let Impact { hit, status, t, t_lower, t_upper, normal, iterations, support_calls, .. } = answer;
    let point = if hit { answer.point_a } else { ray.origin() };
    let answer = RayHit { hit, status, t, t_lower, t_upper, point, normal, iterations, support_calls };
    CompoundAnswer { answer, hulls, pairs, boxes }
}

/// Two compounds. B translates. The bound is the length that it moves until boxes meet; the
/// distance of their centres at the start orders equal bounds.
struct Swept<'q> {
    placement: Placement<'q>,
    /// Inverses of the components of the path's unit direction; `None` without motion.
    inverse: Option<DVec3>,
}

impl BoxPairs for Swept<'_> {
    type Placed = PlacedBox;

    fn nodes(&self) -> [Nodes<'_>; 2] {
        self.placement.nodes()
    }

    fn placed(&self, b: &Node) -> PlacedBox {
        self.placement.placed(b)
    }

    #[inline]
    fn bound(&mut self, a: &Node, b: &PlacedBox, outer: f64, reach: f64) -> [f64; 2] {
        let Some(inverse) = self.inverse else { return self.placement.bound(a, b, outer, reach) };
        let travel = self.placement.travel_lower_bound(a, b, inverse);
        // The box of a point has no axes of its own.
        let apart = if b.is_point() { 0.0 } else { self.placement.distance_lower_bound(a, b, f64::INFINITY) };
        [apart.max(travel), b.center_distance_sq(a)]
    }
}

/// The first hit of the pairs of a placement. `query` casts a pair.
fn first_hit(
    placement: Placement<'_>,
    motion: Motion,
    settings: &CastSettings,
    mut query: impl FnMut([usize; 2]) -> Option<Impact>,
) -> CompoundAnswer<Impact> {
    let mut first = First::default();
    let path = motion.path();
    let mut traversal = Traversal::new(Swept { placement, inverse: path.map(|path| path.direction.recip()) });
    loop {
        // Without motion this is 0, even for an infinite time.
        let reach = path.map_or(0.0, |path| first.reach(&path, settings));
        let Some(pair) = traversal.next(reach) else { break };
        if let Some(found) = query(pair) {
            first.add(&found, pair);
        }
    }
    let (answer, hulls) = first.answer();
    CompoundAnswer { answer, hulls, pairs: first.pairs, boxes: traversal.boxes() }
}

/// The first hit of a ray on a sheet that finds the triangles along a ray faster than a traversal
/// of its tree does: `walk`, to which a length and a visit are passed. `query` casts the ray on a
/// triangle.
fn first_along(
    path: Path,
    settings: &CastSettings,
    query: impl Fn(usize) -> Option<Impact>,
    walk: impl FnOnce(f64, &mut dyn FnMut(usize) -> f64) -> u32,
) -> CompoundAnswer<Impact> {
    let mut first = First::default();
    let reach = first.reach(&path, settings);
    let boxes = walk(reach, &mut |triangle| {
        if let Some(found) = query(triangle) {
            first.add(&found, [triangle, 0]);
        }
        first.reach(&path, settings)
    });
    let (answer, hulls) = first.answer();
    CompoundAnswer { answer, hulls, pairs: first.pairs, boxes }
}

/// The first of several hits.
pub(super) struct First {
    /// The first certain hit so far.
    certain: Option<(Impact, [usize; 2])>,
    /// The first grazing hit so far.
    grazing: Option<(Impact, [usize; 2])>,
    /// Minimum lower bound of all hits, and the status of that hit.
    lower: (f64, Status),
    /// Minimum upper bound of the certain hits.
    pub(super) certain_upper: f64,
    /// Maximum upper bound of the grazing hits: it is unknown which of them meet.
    grazing_upper: f64,
    pub(super) pairs: u32,
    iterations: u32,
    support_calls: u32,
}

impl Default for First {
    fn default() -> Self {
        Self {
            certain: None,
            grazing: None,
            lower: (f64::INFINITY, Status::Separated),
            certain_upper: f64::INFINITY,
            grazing_upper: 0.0,
            pairs: 0,
            iterations: 0,
            support_calls: 0,
        }
    }
}

impl First {
    /// Length of a path until the first certain hit, or until its end.
    fn reach(&self, path: &Path, settings: &CastSettings) -> f64 {
        path.length(settings.limit().min(self.certain_upper)) * (1.0 + LENGTH_ERROR)
    }

    pub(super) fn add(&mut self, found: &Impact, pair: [usize; 2]) {
        self.pairs += 1;
        self.iterations = self.iterations.saturating_add(found.iterations);
        self.support_calls = self.support_calls.saturating_add(found.support_calls);
        if !found.hit {
            return;
        }
        if found.t_lower < self.lower.0 {
            self.lower = (found.t_lower, found.status);
        }
        let is_certain = found.status != Status::Touching && found.t_upper < f64::INFINITY;
        let first = if !is_certain {
            self.grazing_upper = self.grazing_upper.max(found.t_upper);
            &mut self.grazing
        } else {
            self.certain_upper = self.certain_upper.min(found.t_upper);
            &mut self.certain
        };
        // Ties go to the lowest index, so that the answer does not depend on the order of visits.
        if first.is_none_or(|(best, of)| found.t < best.t || found.t == best.t && pair < of) {
            *first = Some((*found, pair));
        }
    }

    /// Adds that whatever is left may meet from a time on, beginning with a pair.
    pub(super) fn add_undecided(&mut self, found: &Impact, pair: [usize; 2]) {
        if self.certain.is_none() {
            self.add(found, pair);
            self.pairs -= 1;
        } else if found.t_lower < self.lower.0 {
            self.lower = (found.t_lower, found.status);
        }
    }

    /// The nearest hit. A grazing one counts even before a certain one: the part that it grazes may
    /// be beside the point where the path meets the compound.
    pub(super) fn answer(&self) -> (Impact, [usize; 2]) {
        let is_certain = self.certain.is_some();
        let nearest = match (self.certain, self.grazing) {
            (Some(certain), Some(grazing)) if grazing.0.t < certain.0.t => Some(grazing),
            (certain, grazing) => certain.or(grazing),
        };
        let (mut answer, pair) = nearest.unwrap_or_else(|| {
            let never = f64::INFINITY;
            let miss = Impact { hit: false, status: Status::Separated, t: never, t_lower: never, ..Impact::default() };
            (Impact { t_upper: never, ..miss }, [0, 0])
        });
        (answer.iterations, answer.support_calls) = (self.iterations, self.support_calls);
        if answer.hit {
            answer.t_upper = if is_certain { self.certain_upper } else { self.grazing_upper };
        }
        if self.lower.0 < answer.t_lower {
            (answer.t_lower, answer.status) = self.lower;
        }
        if answer.status == Status::Touching && is_certain {
            // The hit is certain, only its time is not.
            answer.status = Status::Stalled;
        }
        (answer, pair)
    }
}

#[cfg(test)]
mod tests {
    use hullmap_bake::height_field::{HeightGrid, bake_height_field, write_height_field};
    use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};
    use shapes::rng::SplitMix64;

    use super::*;
    use crate::height_field::{Diagonal, HeightField, Layout};
    use crate::triangle_mesh::TriangleMesh;

    /// The answer by the tree. Only its counts may differ from the answer by the walk over cells.
    fn by_tree<P: Parts>(sheet: &P, ray: &Ray, settings: &CastSettings) -> CompoundAnswer<Impact> {
        let origin = Nodes::one(DVec3::ZERO, DVec3::ZERO);
        let placement = Placement::new(sheet.nodes(), origin, Pose::from_checked(ray.origin()));
        first_hit(placement, ray.motion(), settings, |[part, _]| {
            let part = sheet.part(part)?;
            let RayHit { hit, status, t, t_lower, t_upper, point, normal, iterations, support_calls } =
                ray_triangle(part.triangle()?, ray, settings);
            let [point_a, point_b] = [point; 2];
            Some(Impact { hit, status, t, t_lower, t_upper, normal, point_a, point_b, iterations, support_calls })
        })
    }

    fn fields(rng: &mut SplitMix64) -> Vec<HeightField> {
        let mut of = |columns: usize, rows: usize, spacing: [f64; 2], origin: [f64; 2], height: f64, holes: f64| {
            let diagonal = Diagonal::ALL[columns % 2];
            let layout = Layout { columns, rows, origin, spacing, diagonal };
            // Waves, plus random heights.
            let wave = |i: usize| (i as f64 * 0.1).sin();
            let at = |i: usize| wave(i % columns) + wave(i / columns);
            let heights: Vec<f32> = (0..columns * rows).map(|i| (height * (at(i) + 0.3 * rng.unit())) as f32).collect();
            let holes: Vec<bool> = (1..(columns - 1) * (rows - 1)).map(|_| rng.unit() < holes).collect();
            let holes = [&[false], holes.as_slice()].concat();
            let baked = bake_height_field(&HeightGrid { layout, heights: &heights, holes: &holes, materials: &[] });
            HeightField::from_bytes(&write_height_field(baked.unwrap(), &Default::default()).unwrap()).unwrap()
        };
        vec![
            of(2, 2, [1.0, 1.0], [0.0, 0.0], 1.0, 0.0),
            of(9, 10, [1.0, 0.3], [-3.0, 4.0], 0.5, 0.2),
            of(40, 3, [0.1, 0.7], [0.0, 0.0], 0.0, 0.0),
            of(300, 2, [1.0, 1.0], [0.0, 0.0], 0.2, 0.05),
            of(2, 301, [1.0, 7.0], [0.0, 0.0], 0.2, 0.05),
            of(200, 170, [0.5, 0.5], [-50.0, -40.0], 1.0, 0.01),
            of(131, 257, [1e-4, 1e-4], [0.0, 0.0], 1e-4, 0.3),
            of(90, 90, [1e3, 2e3], [3e6, -7e6], 2e3, 0.0),
            // The spacing is 16 units in the last place of the coordinates.
            of(20, 17, [1.0, 1.0], [2_f64.powi(48), 0.0], 1.0, 0.1),
            // Cells that are narrow for their heights.
            of(120, 100, [0.01, 0.01], [0.0, 0.0], 10.0, 0.0),
        ]
    }

    /// Triangles that share many vertices: random, flat, on a line, far away, tiny, and slivers.
    fn meshes(rng: &mut SplitMix64) -> Vec<TriangleMesh> {
        let of = |positions: &[[f32; 3]], corners: &[[u32; 3]]| {
            let baked = bake_triangle_mesh(&Triangles { positions, corners, materials: &[] }).unwrap();
            TriangleMesh::from_bytes(&write_triangle_mesh(baked, &Default::default()).unwrap()).unwrap()
        };
        let mut soup = |points: usize, count: usize, size: [f64; 3], at: f64| {
            let positions: Vec<[f32; 3]> =
                (0..points).map(|_| size.map(|size| (at + size * (rng.unit() - 0.5)) as f32)).collect();
            // Some coordinates are equal.
            let round = |p: [f32; 3], by: f32| p.map(|c| if by > 0.0 { (c / by).round() * by } else { c });
            let positions: Vec<_> =
                positions.iter().enumerate().map(|(i, p)| round(*p, if i % 3 == 0 { 0.25 } else { 0.0 })).collect();
            let corners: Vec<[u32; 3]> = (0..count).map(|_| [0; 3].map(|_| rng.below(points) as u32)).collect();
            of(&positions, &corners)
        };
        vec![
            soup(3, 1, [1.0; 3], 0.0),
            soup(6, 3, [2.0; 3], 0.0),
            soup(40, 200, [3.0, 2.0, 0.5], 0.0),
            soup(600, 300, [10.0, 10.0, 1.0], 0.0),
            // In the plane z = 0, and on a line along x.
            soup(50, 40, [5.0, 3.0, 0.0], 0.0),
            soup(9, 5, [5.0, 0.0, 0.0], 0.0),
            soup(60, 90, [4.0; 3], 1e5),
            soup(60, 90, [1e-30; 3], 0.0),
            soup(60, 90, [1e30, 1e28, 1e30], 0.0),
            soup(90, 200, [100.0, 1e-3, 100.0], 0.0),
        ]
    }

    /// Rays through anything, along edges, through vertices, along axes, in the plane of the
    /// ground, of huge and of tiny lengths, and from far away.
    ///
    /// `draw` returns the corners of a random triangle.
    fn draw_ray(
        [low, high]: [DVec3; 2],
        draw: impl Fn(&mut SplitMix64) -> Option<[DVec3; 3]>,
        round: usize,
        rng: &mut SplitMix64,
    ) -> (Ray, f64) {
        let size = (high - low).max(DVec3::splat(0.05 * (high - low).max_element()));
        let mut place = |grow: f64| {
            let share = DVec3::new(rng.unit(), rng.unit(), rng.unit()) * (1.0 + grow) - 0.5 * grow;
            low + share * size
        };
        let (mut from, mut to) = (place(0.5), place(0.2));
        let triangle = |rng: &mut SplitMix64| (0..9).find_map(|_| draw(rng)).unwrap_or([low; 3]);
        let vertex = |rng: &mut SplitMix64| triangle(rng)[0];
        match round % 10 {
            0 => from.z = high.z + size.z,
            1 => to = from.with_z(low.z - size.z),
            2 => (from, to) = (vertex(rng), vertex(rng)),
            3 => (from, to) = (vertex(rng) + size.with_x(0.0).with_y(0.0), vertex(rng)),
            // Along a row or a column of vertices, above the ground and in it.
            4 => {
                let at = vertex(rng);
                let along = if rng.unit() < 0.5 { DVec3::X } else { DVec3::Y };
                (from, to) = (at - size * along, at + size * along);
                from.z += if rng.unit() < 0.5 { size.z } else { 0.0 };
            }
            // Down on a vertex, and on an edge.
            5 => {
                to = vertex(rng);
                from = to + DVec3::new(0.0, 0.0, 2.0 * size.z);
            }
            6 => {
                let [a, b, c] = triangle(rng);
                to = a.midpoint(b);
                from = if rng.unit() < 0.5 { to + (to - c).with_z(3.0 * size.z) } else { c };
            }
            7 => to.z = from.z,
            8 => from = to + (from - to) * 1e6,
            _ => {}
        }
        let length = [1.0, 1e-3, 1e3, 1e-300, 1e20][rng.below(5)];
        let mut direction = if from == to { DVec3::X } else { (to - from) * length };
        if !(direction.abs().max_element() < 1e38) {
            direction = direction.normalize();
        }
        let until = [f64::INFINITY, f64::INFINITY, 1.0, 0.3, 0.0][rng.below(5)];
        (Ray::new(from.clamp(DVec3::splat(-1e38), DVec3::splat(1e38)), direction).unwrap(), until / length)
    }

    /// What the rays of a test found.
    #[derive(Default)]
    struct Tally {
        hits: usize,
        boxes: [u64; 2],
    }

    impl Tally {
        /// Compares the answer for a ray with that by the tree.
        fn compare<P: Parts>(&mut self, sheet: &P, line: &Ray, settings: &CastSettings, round: usize) {
            let (found, expected) = (ray(sheet, line, settings), by_tree(sheet, line, settings));
            self.boxes[0] += u64::from(found.boxes);
            self.boxes[1] += u64::from(expected.boxes);
            let RayHit { hit, status, t, t_lower, t_upper, normal, point, .. } = found.answer;
            let of_tree = expected.answer;
            let point_of_tree = if of_tree.hit { of_tree.point_a } else { line.origin() };
            let own = format!("{:?}", (found.hulls, hit, status, t, t_lower, t_upper, normal, point));
            let Impact { hit, status, t, t_lower, t_upper, normal, .. } = of_tree;
            let tree = format!("{:?}", (expected.hulls, hit, status, t, t_lower, t_upper, normal, point_of_tree));
            assert_eq!(own, tree, "round {round}: {line:?}, {settings:?}");
            assert_ne!(status, Status::Touching, "round {round}: {line:?}, {settings:?}");
            self.hits += usize::from(hit);
        }

        fn check(&self, rounds: usize) {
            let Self { hits, boxes } = self;
            println!("{hits} hits, {boxes:?} boxes");
            assert!(*hits > rounds / 4 && *hits < rounds * 3 / 4);
        }
    }

    #[test]
    fn a_walk_over_cells_finds_what_the_tree_finds() {
        let seed = 0x3a7;
        println!("seed {seed}");
        let mut rng = SplitMix64::new(seed);
        let fields = fields(&mut rng);
        let (mut tally, rounds) = (Tally::default(), 30_000);
        for round in 0..rounds {
            let field = &fields[round / 10 % fields.len()];
            let draw = |rng: &mut SplitMix64| Some(field.triangle(rng.below(field.triangle_count()))?.corners());
            let (line, max_t) = draw_ray(field.bounds(), draw, round, &mut rng);
            tally.compare(field, &line, &CastSettings { max_t, ..CastSettings::default() }, round);
        }
        tally.check(rounds);
    }

    #[test]
    fn a_descent_along_a_ray_finds_what_the_tree_of_a_mesh_finds() {
        let seed = 0x3a8;
        println!("seed {seed}");
        let mut rng = SplitMix64::new(seed);
        let meshes = meshes(&mut rng);
        let (mut tally, rounds) = (Tally::default(), 30_000);
        for round in 0..rounds {
            let mesh = &meshes[round / 10 % meshes.len()];
            let draw = |rng: &mut SplitMix64| Some(mesh.triangle(rng.below(mesh.triangle_count()))?.corners());
            let (line, max_t) = draw_ray(mesh.bounds().map(|c| c.as_dvec3()), draw, round, &mut rng);
            tally.compare(mesh, &line, &CastSettings { max_t, ..CastSettings::default() }, round);
        }
        tally.check(rounds);
    }
}
