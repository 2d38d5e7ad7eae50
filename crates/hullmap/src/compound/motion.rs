//! Rays and linear shape casts of parts: the first hit over all pairs of parts.
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
use super::indices;
use super::parts::Parts;
use super::sheet::CandidatePair;
use super::traversal::{BoxPairs, Traversal};
use crate::height_field::walk::Walk;
use crate::pose::Pose;
use crate::shapes::Shape;
use crate::solver::cast::cast as cast_pair;
use crate::solver::motion::Path;
use crate::solver::ray::ray as cast_ray;
use crate::solver::ray_triangle::{is_towards_front, ray_triangle};
use crate::solver::{Cache, CastSettings, Impact, Motion, Ray, RayHit, Status};
use glam::DVec3;

/// Relative rounding error of a length that follows from a time and a speed.
const LENGTH_ERROR: f64 = 8.0 * f64::EPSILON;

/// When `b`, which starts at `b_in_a` and translates by `motion`, first meets `a`.
///
/// # Complexity
/// Branch and bound: usually only the few pairs within the distance covered until the hit.
pub(crate) fn cast<A: Parts + ?Sized, B: Parts + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    motion: Motion,
    settings: &CastSettings,
    cache: &mut Cache,
) -> Impact {
    if a.part_count() == 0 || b.part_count() == 0 {
        // Only in a pack that was opened without checks: nothing is known.
        return Impact::default();
    }
    let placement = Placement::new(a.nodes(), b.nodes(), b_in_a);
    first_hit(placement, motion, settings, |pair| {
        let parts = CandidatePair::new(a, b, pair, b_in_a).filter(|parts| !parts.is_passed(motion.velocity()))?;
        Some(cast_pair(&parts.a, &parts.b, b_in_a, motion, settings, cache.pair(pair)))
    })
}

/// Where `ray` first enters `a`.
///
/// # Complexity
/// Branch and bound: no ray casts on parts farther away than the first hit.
pub(crate) fn ray<A: Parts + ?Sized>(a: &A, ray: &Ray, settings: &CastSettings) -> RayHit {
    let origin = Nodes::one(DVec3::ZERO, DVec3::ZERO);
    let placement = Placement::new(a.nodes(), origin, Pose::from_checked(ray.origin()));
    let cast_part = |index: usize| {
        let is_one_sided = a.front(index).is_some();
        let part = a.part(index)?;
        let found = match part.triangle() {
            Some(corners) if is_one_sided && !is_towards_front(corners, ray) => return None,
            Some(corners) => ray_triangle(corners, ray, settings),
            None => cast_ray(&part, ray, settings),
        };
        Some(Impact::of_ray(found, index))
    };
    let (nodes, margin) = (a.nodes(), placement.rounding_error());
    let first = ray.motion().path().and_then(|path| {
        let line = [ray.origin(), path.direction];
        if let Some(field) = nodes.field() {
            return Some(first_along(path, settings, cast_part, |reach, visit| {
                Walk::run(field, line, margin, reach, visit);
            }));
        }
        let mesh = nodes.mesh()?;
        Some(first_along(path, settings, cast_part, |reach, visit| {
            mesh.along(line, margin, reach, visit);
        }))
    });
    let first = first.unwrap_or_else(|| first_hit(placement, ray.motion(), settings, |pair| cast_part(pair[0])));
    let first = if a.part_count() == 0 { Impact::default() } else { first };
    first.ray_hit(if first.hit { first.point_a } else { ray.origin() })
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
) -> Impact {
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
    first.answer()
}

/// The first hit of a ray on a sheet that finds the triangles along a ray faster than a traversal
/// of its tree does: `walk`, to which a length and a visit are passed. `query` casts the ray on a
/// triangle.
fn first_along(
    path: Path,
    settings: &CastSettings,
    query: impl Fn(usize) -> Option<Impact>,
    walk: impl FnOnce(f64, &mut dyn FnMut(usize) -> f64),
) -> Impact {
    let mut first = First::default();
    let reach = first.reach(&path, settings);
    walk(reach, &mut |triangle| {
        if let Some(found) = query(triangle) {
            first.add(&found, [triangle, 0]);
        }
        first.reach(&path, settings)
    });
    first.answer()
}

pub(super) struct First {
    certain: Option<Impact>,
    grazing: Option<Impact>,
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
        let found = Impact { parts: indices(pair), ..*found };
        let first = if !is_certain {
            self.grazing_upper = self.grazing_upper.max(found.t_upper);
            &mut self.grazing
        } else {
            self.certain_upper = self.certain_upper.min(found.t_upper);
            &mut self.certain
        };
        // Ties go to the lowest index, so that the answer does not depend on the order of visits.
        if first.is_none_or(|best| found.t < best.t || found.t == best.t && found.parts < best.parts) {
            *first = Some(found);
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
    pub(super) fn answer(&self) -> Impact {
        let is_certain = self.certain.is_some();
        let nearest = match (self.certain, self.grazing) {
            (Some(certain), Some(grazing)) if grazing.t < certain.t => Some(grazing),
            (certain, grazing) => certain.or(grazing),
        };
        let mut answer = nearest.unwrap_or_else(|| {
            let never = f64::INFINITY;
            let miss = Impact { hit: false, status: Status::Separated, t: never, t_lower: never, ..Impact::default() };
            Impact { t_upper: never, ..miss }
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
        answer
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

    /// The answer by the tree.
    fn by_tree<P: Parts>(sheet: &P, ray: &Ray, settings: &CastSettings) -> RayHit {
        let origin = Nodes::one(DVec3::ZERO, DVec3::ZERO);
        let placement = Placement::new(sheet.nodes(), origin, Pose::from_checked(ray.origin()));
        let found = first_hit(placement, ray.motion(), settings, |[part, _]| {
            Some(Impact::of_ray(ray_triangle(sheet.part(part)?.triangle()?, ray, settings), part))
        });
        found.ray_hit(if found.hit { found.point_a } else { ray.origin() })
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

    /// Compares the answer for a ray with that by the tree, and returns whether it hits.
    fn compare<P: Parts>(sheet: &P, line: &Ray, settings: &CastSettings, round: usize) -> bool {
        let (found, expected) = (ray(sheet, line, settings), by_tree(sheet, line, settings));
        // Only the order of visits differs.
        let bits = |hit: RayHit| format!("{:?}", RayHit { iterations: 0, support_calls: 0, ..hit });
        assert_eq!(bits(found), bits(expected), "round {round}: {line:?}, {settings:?}");
        assert_ne!(found.status, Status::Touching, "round {round}: {line:?}, {settings:?}");
        found.hit
    }

    #[test]
    fn walks_and_descents_find_what_the_trees_find() {
        let seed = 0x3a7;
        println!("seed {seed}");
        let mut rng = SplitMix64::new(seed);
        let (fields, meshes) = (fields(&mut rng), meshes(&mut rng));
        let (mut hits, rounds) = ([0; 2], 30_000);
        for round in 0..rounds {
            let field = &fields[round / 10 % fields.len()];
            let draw = |rng: &mut SplitMix64| Some(field.triangle(rng.below(field.triangle_count()))?.corners());
            let (line, max_t) = draw_ray(field.bounds(), draw, round, &mut rng);
            let settings = |max_t| CastSettings { max_t, ..CastSettings::default() };
            hits[0] += usize::from(compare(field, &line, &settings(max_t), round));
            let mesh = &meshes[round / 10 % meshes.len()];
            let draw = |rng: &mut SplitMix64| Some(mesh.triangle(rng.below(mesh.triangle_count()))?.corners());
            let (line, max_t) = draw_ray(mesh.bounds().map(|c| c.as_dvec3()), draw, round, &mut rng);
            hits[1] += usize::from(compare(mesh, &line, &settings(max_t), round));
        }
        println!("{hits:?} hits");
        assert!(hits.iter().all(|hits| *hits > rounds / 4 && *hits < rounds * 3 / 4), "{hits:?}");
    }
}
