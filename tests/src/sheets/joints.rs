//! Rays at edges, vertices and seams, judged in rational numbers: where triangles or parts meet, a
//! ray must not reach the surface behind.

use std::sync::Arc;

use glam::DVec3;
use hullmap::compound::{OneSided, SharedSheet};
use hullmap::height_field::{Diagonal, Layout};
use hullmap::shapes::Sphere;
use hullmap::{
    Cache, CastSettings, HeightField, Motion, Pack, Pose, Ray, RayHit, SharedGeometry, Status, TriangleMesh,
};
use hullmap_bake::height_field::{HeightGrid, bake_height_field, write_height_field};
use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_testkit::packs::{bytes, point_set};
use hullmap_testkit::ray::{Fraction, Line, facets};
use shapes::rng::SplitMix64;

use super::tally::Tally;

/// Number of rays in a scene.
const RAYS: u64 = 100;

/// Surfaces in one scene.
struct Joints {
    sheets: Vec<SharedSheet>,
    pack: Option<Arc<Pack>>,
    triangles: Vec<[DVec3; 3]>,
    /// Vertices of each part of the pack, and its facets.
    parts: Vec<Vec<DVec3>>,
    facets: Vec<Vec<[DVec3; 3]>>,
}

fn mesh(triangles: &[[DVec3; 3]]) -> TriangleMesh {
    let positions: Vec<[f32; 3]> = triangles.iter().flatten().map(|corner| corner.as_vec3().to_array()).collect();
    let corners: Vec<[u32; 3]> = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let baked = bake_triangle_mesh(&Triangles { positions: &positions, corners: &corners, materials: &[] });
    TriangleMesh::from_bytes(&write_triangle_mesh(baked.expect("a mesh"), &Default::default()).expect("a file"))
        .expect("the file is valid")
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
    let baked = bake_height_field(&HeightGrid { layout, heights: &heights, holes: &[], materials: &[] });
    HeightField::from_bytes(&write_height_field(baked.expect("a field"), &Default::default()).expect("a file"))
        .expect("the file is valid")
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

impl Joints {
    fn new(rng: &mut SplitMix64) -> Self {
        let mut own =
            Self { sheets: Vec::new(), pack: None, triangles: Vec::new(), parts: Vec::new(), facets: Vec::new() };
        let kind = rng.below(6);
        if kind < 4 {
            let near = if kind == 1 { Vec::new() } else { ground(rng) };
            own.sheets.push(SharedSheet::Mesh(Arc::new(mesh(&[near, floor(-20.0)].concat()))));
        }
        if kind == 1 || kind == 2 {
            own.sheets.push(SharedSheet::Field(Arc::new(field(rng))));
        }
        if kind > 2 {
            let sets: Vec<_> = blocks(rng)
                .iter()
                .map(|part| point_set("part", &part.iter().map(|p| p.as_vec3().to_array()).collect::<Vec<_>>()))
                .collect();
            let file = bytes(&sets, IndexKind::Tree, &SourceRecord::default()).expect("a pack");
            own.pack = Some(Arc::new(Pack::from_bytes(&file).expect("the pack is valid")));
        }
        let of_sheet = |sheet: &SharedSheet| {
            let corners = |i| Some(sheet.triangle(i)?.corners());
            (0..sheet.triangle_count()).filter_map(corners).collect::<Vec<_>>()
        };
        own.triangles = own.sheets.iter().flat_map(of_sheet).collect();
        let hulls = own.pack.iter().flat_map(|pack| (0..pack.hull_count()).filter_map(|i| pack.hull(i).ok()));
        own.parts = hulls.map(|hull| hull.vertices().map(|v| v.as_dvec3()).collect()).collect();
        own.facets = own.parts.iter().map(|part| facets(part)).collect();
        own
    }

    /// The corners of a random triangle, or three vertices of a part.
    fn corners(&self, rng: &mut SplitMix64) -> [DVec3; 3] {
        let at = rng.below(self.triangles.len() + 2 * self.parts.len());
        if let Some(triangle) = self.triangles.get(at) {
            return *triangle;
        }
        let part = &self.parts[(at - self.triangles.len()) / 2];
        let first = rng.below(part.len());
        [0, 1, 2].map(|i| part[(first + i * (1 + rng.below(2))) % part.len()])
    }

    /// A ray at a vertex, an edge or a seam.
    fn ray(&self, rng: &mut SplitMix64) -> ([DVec3; 2], f64) {
        let [a, b, c] = self.corners(rng);
        let share = if rng.below(2) == 0 { 0.5 } else { rng.unit() };
        let target = [a, a.midpoint(b), a + share * (b - a), a + 0.25 * (b - a) + 0.5 * (c - a)][rng.below(4)];
        let way = DVec3::from_array(rng.direction()).as_vec3().as_dvec3();
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
    /// Judges rays of the scene of joints with this index.
    pub fn judge_joints(&mut self, seed: u64, index: u64) {
        let mut rng = SplitMix64::new(seed ^ index.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let joints = Joints::new(&mut rng);
        for round in 0..RAYS {
            let ([origin, direction], max_t) = joints.ray(&mut rng);
            let Ok(ray) = Ray::new(origin, direction) else { continue };
            let settings = CastSettings { max_t, ..CastSettings::default() };
            let is_one_sided = joints.parts.is_empty() && rng.below(4) == 0;
            let line = Line::new(origin, direction, max_t);
            let (truth, count) = joints.truth(&line, is_one_sided);
            let outcome = match (&truth, count) {
                (None, _) => "miss",
                (Some(_), 1) => "one",
                _ => "several",
            };
            *self.counts.entry((if joints.pack.is_some() { "seam" } else { "edge" }, outcome)).or_default() += 1;
            let mut answers = joints.answers(&ray, &settings, is_one_sided);
            if !is_one_sided {
                answers.extend(joints.casts(&ray, &settings));
            }
            // All of a kind: the nearest surface of the scene. Two may be within rounding error.
            for (of_kind, is_ray) in answers.into_iter().zip([true, false, false]) {
                let t_lower = of_kind.iter().map(|found| found.t_lower).fold(f64::INFINITY, f64::min);
                let nearest = of_kind.into_iter().min_by(|p, q| p.t.total_cmp(&q.t)).expect("a surface");
                let first = RayHit { t_lower, ..nearest };
                if let Some(wrong) = fault(truth.as_ref(), &first, is_ray) {
                    let what = format!("{wrong}: {first:?}, {ray:?}, max_t {max_t}, truth {truth:?}");
                    self.wrong.push(format!("joints, --seed {seed} --first {index}, ray {round}: {what}"));
                }
            }
        }
    }
}

/// The fault of an answer, if it has one.
pub(super) fn fault(truth: Option<&Fraction>, found: &RayHit, is_ray: bool) -> Option<&'static str> {
    use std::cmp::Ordering::{Greater, Less};
    let Some(truth) = truth else { return found.hit.then_some("nothing is there") };
    match () {
        () if !found.hit => Some("a hit is missing"),
        () if truth.compare(found.t_lower) == Less => Some("too late"),
        () if truth.compare(found.t_upper) == Greater => Some("too early"),
        () if found.status == Status::Touching => Some("not certain"),
        // At slivers, the intervals of casts may be wide.
        () if is_ray && found.status == Status::Stalled => Some("wide"),
        () if !(found.t_lower <= found.t && found.t <= found.t_upper) => Some("t is outside"),
        () => None,
    }
}

impl Joints {
    /// Where a ray first meets the scene, and how many triangles or parts it meets there.
    fn truth(&self, line: &Line, is_one_sided: bool) -> (Option<Fraction>, usize) {
        let fronts = self.triangles.iter().filter(|corners| !is_one_sided || line.is_towards_front(**corners));
        let hits: Vec<Fraction> = fronts
            .filter_map(|corners| line.meet(*corners))
            .chain(self.facets.iter().filter_map(|part| line.meet_hull(part)))
            .collect();
        let first = hits.iter().cloned().reduce(Fraction::min);
        let count = first.as_ref().map_or(0, |first| hits.iter().filter(|hit| hit.is(first)).count());
        (first, count)
    }

    /// The surfaces, each with both of its sides.
    fn surfaces(&self) -> impl Iterator<Item = SharedGeometry> {
        let sheets = self.sheets.iter().cloned().map(SharedGeometry::Sheet);
        sheets.chain(self.pack.clone().map(SharedGeometry::Compound))
    }

    /// The answers of all surfaces to a ray.
    fn answers(&self, ray: &Ray, settings: &CastSettings, is_one_sided: bool) -> Vec<Vec<RayHit>> {
        let of_front = |sheet| hullmap::ray(&OneSided::new(sheet), ray, settings);
        vec![match is_one_sided {
            true => self.sheets.iter().map(of_front).collect(),
            false => self.surfaces().map(|surface| hullmap::ray(&surface, ray, settings)).collect(),
        }]
    }

    /// The answers of all surfaces to a point that moves along a ray, and of those to surfaces that
    /// move against it.
    fn casts(&self, ray: &Ray, settings: &CastSettings) -> Vec<Vec<RayHit>> {
        let (dot, cache) = (Sphere::new(0.0).expect("a point"), &mut Cache::new());
        let place = |sign: f64| {
            Some((Pose::from_translation(sign * ray.origin()).ok()?, Motion::new(sign * ray.direction()).ok()?))
        };
        let (Some((start, motion)), Some((back, against))) = (place(1.0), place(-1.0)) else { return Vec::new() };
        let as_ray = |found: hullmap::Impact| {
            let hullmap::Impact { hit, status, t, t_lower, t_upper, normal, point_a: point, .. } = found;
            RayHit { hit, status, t, t_lower, t_upper, point, normal, iterations: 0, support_calls: 0, part: 0 }
        };
        let (mut to, mut from) = (Vec::new(), Vec::new());
        for surface in self.surfaces() {
            to.push(as_ray(hullmap::cast(&surface, &dot, start, motion, settings, cache)));
            from.push(as_ray(hullmap::cast(&dot, &surface, back, against, settings, cache)));
        }
        vec![to, from]
    }
}
