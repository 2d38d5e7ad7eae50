//! Rays at edges, vertices and seams, judged in rational numbers: where triangles or parts meet, a
//! ray must not reach the surface behind.

use std::sync::Arc;

use glam::DVec3;
use hullmap::compound::{OneSided, SharedSheet};
use hullmap::height_field::{Diagonal, Layout};
use hullmap::shapes::Sphere;
use hullmap::{Cache, CastSettings, Geometry, HeightField, Impact, Motion, Pack, Pose, Ray, RayHit, SharedGeometry};
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_testkit::packs::{bytes, height_field, loose_mesh, point_set};
use hullmap_testkit::random::RandomPoses;
use hullmap_testkit::ray::Line;
use shapes::rng::SplitMix64;

use super::hits::{Hits, Part, Query};
use super::{scene::stream, tally::Tally};

/// Number of rays in a scene.
const RAYS: u64 = 100;

/// Names of casts of points, on both sides and on fronts.
const CASTS: [&str; 2] = ["cast", "cast on fronts"];

/// A mesh, a height field or a pack.
struct Surface {
    geometry: SharedGeometry,
    parts: Vec<Part>,
}

/// A floor of two triangles, far below.
fn floor(z: f64) -> Vec<[DVec3; 3]> {
    let [a, b, c, d] = [(-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0)].map(|(x, y)| DVec3::new(x, y, z));
    vec![[a, b, c], [a, c, d]]
}

/// A roof or a rough ground: a grid of vertices, moved at random. Slivers where they nearly meet.
fn ground(rng: &mut SplitMix64) -> Vec<[DVec3; 3]> {
    let (size, height) = (10_f64.powf(rng.between(-2.0, 1.0)), rng.between(0.0, 2.0));
    let (thin, is_whole) = (if rng.below(3) == 0 { 1e-4 } else { 1.0 }, rng.below(3) == 0);
    let mut grid = [[DVec3::ZERO; 5]; 5];
    for (i, row) in grid.iter_mut().enumerate() {
        for (j, corner) in row.iter_mut().enumerate() {
            let moved = if is_whole { 0.0 } else { 0.4 };
            let at = [i, j].map(|k| k as f64 - 2.0 + moved * (rng.unit() - 0.5));
            let z = if is_whole { rng.below(2) as f64 } else { height * rng.unit() };
            *corner = (size * DVec3::new(at[0], at[1] * thin, z)).as_vec3().as_dvec3();
        }
    }
    let cell = |i: usize, j: usize| {
        let [a, b, c, d] = [grid[i][j], grid[i + 1][j], grid[i + 1][j + 1], grid[i][j + 1]];
        [[a, b, c], [a, c, d]]
    };
    (0..4).flat_map(|i| (0..4).flat_map(move |j| cell(i, j))).collect()
}

fn field(rng: &mut SplitMix64) -> HeightField {
    let mut even = |a: f64, b: f64| if rng.below(2) == 0 { a } else { rng.between(0.3, 1.0) * b };
    let (spacing, origin) = ([even(0.5, 1.0), even(0.25, 0.7)], [even(-2.0, -3.0), even(-1.0, 1e3)]);
    let layout = Layout { columns: 6, rows: 5, origin, spacing, diagonal: Diagonal::ALL[rng.below(2)] };
    let is_flat = rng.below(4) == 0;
    let heights: Vec<f32> = (0..30).map(|_| if is_flat { 0.5 } else { rng.unit() as f32 }).collect();
    height_field(layout, &heights, &[])
}

/// Boxes that share faces, edges and corners; some are cut into prisms and pyramids.
fn blocks(rng: &mut SplitMix64) -> Vec<Vec<DVec3>> {
    let planes = |rng: &mut SplitMix64| {
        let steps = if rng.below(2) == 0 { [1.0; 2] } else { [rng.between(0.1, 1.0), rng.between(0.1, 1.0)] };
        [-1.0, -1.0 + steps[0], -1.0 + steps[0] + steps[1]].map(|c| f64::from(c as f32))
    };
    let axes = [planes(rng), planes(rng), planes(rng)];
    let mut parts = Vec::new();
    for cell in 0..8_usize {
        let corner = |i: usize| {
            let pick = |axis: usize| axes[axis][(cell >> axis & 1) + (i >> axis & 1)];
            DVec3::new(pick(0), pick(1), pick(2))
        };
        let of = |indices: &[usize]| indices.iter().map(|i| corner(*i)).collect::<Vec<_>>();
        match rng.below(4) {
            0 => parts.extend([of(&[0, 1, 2, 4, 5, 6]), of(&[1, 2, 3, 5, 6, 7])]),
            // Six tetrahedra around a diagonal.
            1 => parts.extend([[1, 3], [3, 2], [2, 6], [6, 4], [4, 5], [5, 1]].map(|[i, j]| of(&[0, i, j, 7]))),
            2 => {}
            _ => parts.push(of(&[0, 1, 2, 3, 4, 5, 6, 7])),
        }
    }
    let below = [-20.0, -19.0];
    parts.push((0..8).map(|i| DVec3::new([-30.0, 30.0][i & 1], [-30.0, 30.0][i >> 1 & 1], below[i >> 2])).collect());
    parts
}

impl Surface {
    fn sheet(sheet: SharedSheet) -> Self {
        let corners = |i| Some(Part::triangle(&sheet.triangle(i)?.corners()));
        let parts = (0..sheet.triangle_count()).map(|i| corners(i).expect("no holes")).collect();
        Self { geometry: SharedGeometry::Sheet(sheet), parts }
    }

    fn pack(blocks: &[Vec<DVec3>]) -> Self {
        let points = |part: &Vec<DVec3>| part.iter().map(|p| p.as_vec3().to_array()).collect::<Vec<_>>();
        let sets: Vec<_> = blocks.iter().map(|part| point_set("part", &points(part))).collect();
        let file = bytes(&sets, IndexKind::Tree, &SourceRecord::default()).expect("a pack");
        let pack = Arc::new(Pack::from_bytes(&file).expect("the pack is valid"));
        let parts = pack.hulls().map(|hull| Part::hull(hull.vertices().map(|v| v.as_dvec3()).collect())).collect();
        Self { geometry: SharedGeometry::Compound(pack), parts }
    }
}

/// The surfaces of one scene.
struct Joints(Vec<Surface>);

impl Joints {
    fn new(rng: &mut SplitMix64) -> Self {
        let mut surfaces = Vec::new();
        let kind = rng.below(6);
        if kind < 4 {
            let near = if kind == 1 { Vec::new() } else { ground(rng) };
            surfaces.push(Surface::sheet(SharedSheet::Mesh(Arc::new(loose_mesh(&[near, floor(-20.0)].concat())))));
        }
        if kind == 1 || kind == 2 {
            surfaces.push(Surface::sheet(SharedSheet::Field(Arc::new(field(rng)))));
        }
        if kind > 2 {
            surfaces.push(Surface::pack(&blocks(rng)));
        }
        Self(surfaces)
    }

    /// The corners of a random triangle, or three vertices of a part.
    fn corners(&self, rng: &mut SplitMix64) -> [DVec3; 3] {
        let surface = &self.0[rng.below(self.0.len())];
        let part = surface.parts[rng.below(surface.parts.len())].vertices();
        let first = rng.below(part.len());
        [0, 1, 2].map(|i| part[(first + i * (1 + rng.below(2) * (part.len() / 4))) % part.len()])
    }

    /// A ray at a vertex, an edge or a seam.
    fn ray(&self, rng: &mut SplitMix64) -> ([DVec3; 2], f64) {
        let [a, b, c] = self.corners(rng);
        let share = if rng.below(2) == 0 { 0.5 } else { rng.unit() };
        let target = [a, a.midpoint(b), a + share * (b - a), a + 0.25 * (b - a) + 0.5 * (c - a)][rng.below(4)];
        let way = rng.unit_vector().as_vec3().as_dvec3();
        let axis = DVec3::AXES[rng.below(3)] * [1.0, -1.0][rng.below(2)];
        let other = self.corners(rng)[0];
        let way = match rng.below(9) {
            0..3 => DVec3::NEG_Z,
            3 => axis,
            4 => way,
            // From afar, from nearby, and along an edge.
            5 => way * [1e4, 1e-7][rng.below(2)],
            6 => b - a,
            7 => target - other,
            _ => (target - other).with_z(-1.0),
        };
        let origin = match rng.below(8) {
            0 => target,
            1 => target + way,
            2 => target - 0.5 * way,
            _ => target - 2.0 * way,
        };
        let way = if way == DVec3::ZERO { DVec3::Z } else { way };
        let length = match rng.below(6) {
            0 => 10_f64.powf(rng.between(-300.0, 30.0)),
            1 => f64::from(rng.below(60) as i32 - 30).exp2(),
            2 => way.length().recip(),
            _ => 1.0,
        };
        let limit = [f64::INFINITY, f64::INFINITY, 2.0 / length, (2.0 / length).next_down(), 0.0][rng.below(5)];
        ([origin, way * length], limit)
    }
}

impl Tally {
    /// Judges rays of the scene of joints with this index: each surface by itself, which is more
    /// than the nearest one alone.
    pub fn judge_joints(&mut self, seed: u64, index: u64) {
        let mut rng = stream(seed, index);
        let joints = Joints::new(&mut rng);
        for round in 0..RAYS {
            let ([origin, direction], max_t) = joints.ray(&mut rng);
            let Ok(ray) = Ray::new(origin, direction) else { continue };
            let settings = CastSettings { max_t, ..CastSettings::default() };
            let line = Line::new(origin, direction, max_t);
            let is_one_sided = rng.below(4) == 0;
            for surface in &joints.0 {
                let name = format!("joints, --seed {seed} --first {index}, ray {round}, max_t {max_t}");
                let (geometry, query) = (&surface.geometry, (&ray, &settings));
                let kind = if geometry.name() == "a compound" { "seam" } else { "edge" };
                self.judge_sides(geometry, &Hits::new(&line, &surface.parts, false), query, (kind, &name));
                if let (SharedGeometry::Sheet(sheet), true) = (geometry, is_one_sided) {
                    let fronts = Hits::new(&line, &surface.parts, true);
                    self.judge_sides(&OneSided::new(sheet), &fronts, query, ("front", &name));
                }
            }
        }
    }

    fn judge_sides<S: Geometry>(
        &mut self,
        surface: &S,
        hits: &Hits,
        line: (&Ray, &CastSettings),
        (kind, scene): (&'static str, &str),
    ) {
        for (query, found, of_dot) in answers(surface, line) {
            let is_unsure = query == Query::Cast && kind == "front" && !hits.has_clear_fronts();
            let outcome = if is_unsure { "unsure" } else { hits.outcome() };
            let key = if query == Query::Ray { kind } else { CASTS[usize::from(kind == "front")] };
            self.note(key, outcome);
            if is_unsure {
                continue;
            }
            if let Some(wrong) = hits.fault(&found, of_dot, query) {
                self.wrong.push(format!("{wrong}: {query:?}, {kind}, {found:?}, {:?}\n  {hits:?}\n  {scene}", line.0));
            }
        }
    }
}

/// The answers to a ray, to a point that moves along it, and to the surface that moves against it.
fn answers<S: Geometry>(surface: &S, (ray, settings): (&Ray, &CastSettings)) -> Vec<(Query, RayHit, DVec3)> {
    let found = hullmap::ray(surface, ray, settings);
    let mut answers = vec![(Query::Ray, found, found.point)];
    let (dot, cache) = (Sphere::new(0.0).expect("a point"), &mut Cache::new());
    for sign in [1.0, -1.0] {
        let (Ok(start), Ok(motion)) =
            (Pose::from_translation(sign * ray.origin()), Motion::new(sign * ray.direction()))
        else {
            continue;
        };
        let found = match sign > 0.0 {
            true => hullmap::cast(surface, &dot, start, motion, settings, cache),
            false => hullmap::cast(&dot, surface, start, motion, settings, cache),
        };
        let Impact { hit, status, t, t_lower, t_upper, normal, point_a, point_b, parts, .. } = found;
        // In the frame of the surface.
        let (frame, side) = if sign > 0.0 { (DVec3::ZERO, 0) } else { (ray.point_at(if hit { t } else { 0.0 }), 1) };
        let [point, of_dot] = if side == 0 { [point_a, point_b] } else { [point_b, point_a] }.map(|p| p + frame);
        let (normal, part) = (normal * sign, parts[side]);
        let found = RayHit { hit, status, t, t_lower, t_upper, point, normal, part, ..RayHit::default() };
        answers.push((Query::Cast, found, of_dot));
    }
    answers
}
