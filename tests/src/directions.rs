//! Directions in which a support query can go wrong, each with its purpose.

use glam::{DVec3, Vec3};
use hullmap::Hull;
use hullmap_testkit::random::RandomPoses;
use shapes::rng::SplitMix64;

/// A fan of a direction index, and the cell that it divides.
#[derive(Clone, Debug)]
pub struct Fan {
    /// Face of the cube.
    pub face: u32,
    /// Least u and v of the cell.
    pub corner: [f64; 2],
    /// Its width in both.
    pub size: f64,
    /// Axis from which angles are measured.
    pub x: DVec3,
    /// Axis at a quarter turn.
    pub y: DVec3,
    /// Angle of the first step.
    pub start: f64,
    /// Steps in a unit of the angle.
    pub rate: f64,
    /// Number of steps.
    pub steps: u32,
}

/// `count` directions for `hull`, of all kinds that need no fan, then the axes, diagonals and
/// seams of the cube. Directions that f32 rounds to zero are left out.
pub fn all(hull: &Hull, count: usize, seed: u64) -> Vec<Vec3> {
    let mut maker = Maker::new(hull, Vec::new(), seed);
    let drawn = (0..count).map(|index| maker.make(index).1);
    let axis = |digit: usize| digit as f64 - 1.0;
    let axes = (0..27).map(|i| DVec3::new(axis(i % 3), axis(i / 3 % 3), axis(i / 9)));
    drawn.chain(axes).map(|d| d.as_vec3()).filter(|d| *d != Vec3::ZERO).collect()
}

/// Purpose of a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Anywhere.
    Random,
    /// The normal of a facet, as accurate as f64 allows.
    Normal,
    /// The same, disturbed by 1 to 1e-8.
    NearNormal,
    /// Between the normals of two facets, where two vertices tie; exact and disturbed alike.
    Edge,
    /// Inside a vertex's normal cone, where a hint is correct.
    Vertex,
    /// Axes, diagonals and seams of the cube, exact and disturbed.
    Seam,
    /// Near the axis of a fan, or exactly on it.
    FanAxis,
    /// On the border between two steps of a fan.
    FanStep,
    /// So long or short that it is near the limits of f32.
    Extreme,
}

/// All kinds.
pub const KINDS: [Kind; 9] = [
    Kind::Random,
    Kind::Normal,
    Kind::NearNormal,
    Kind::Edge,
    Kind::Vertex,
    Kind::Seam,
    Kind::FanAxis,
    Kind::FanStep,
    Kind::Extreme,
];

/// Makes directions for one hull.
pub struct Maker {
    rng: SplitMix64,
    normals: Vec<DVec3>,
    /// Pairs of faces that share an edge.
    sides: Vec<[usize; 2]>,
    /// Indices of the faces at each vertex.
    faces_at: Vec<Vec<usize>>,
    fans: Vec<Fan>,
}

impl Maker {
    /// For a hull, and the fans of its index.
    pub fn new(hull: &Hull, fans: Vec<Fan>, seed: u64) -> Self {
        let vertices: Vec<DVec3> = hull.vertices().map(|v| v.as_dvec3()).collect();
        let (mut normals, mut sides) = (Vec::new(), Vec::new());
        let mut faces_at = vec![Vec::new(); vertices.len()];
        for (face_index, face) in hull.faces().enumerate() {
            let corners: Vec<u32> = face.collect();
            let at = |i: usize| vertices[corners[i % corners.len()] as usize];
            let sum: DVec3 = (1..corners.len()).map(|i| (at(i) - at(0)).cross(at(i + 1) - at(0))).sum();
            normals.push(sum.normalize_or_zero());
            for (i, &corner) in corners.iter().enumerate() {
                faces_at[corner as usize].push(face_index);
                let next = corners[(i + 1) % corners.len()];
                sides.push((corner.min(next), corner.max(next), face_index));
            }
        }
        sides.sort_unstable();
        let sides = sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).filter(|both| both.len() == 2);
        let sides = sides.map(|both| [both[0].2, both[1].2]).collect();
        Self { rng: SplitMix64::new(seed), normals, sides, faces_at, fans }
    }

    /// Every face's normal and its opposite, if there are at most `most` faces.
    pub fn normals(&self, most: usize) -> Vec<DVec3> {
        let all = self.normals.iter().filter(|_| self.normals.len() <= most);
        all.filter(|n| **n != DVec3::ZERO).flat_map(|n| [*n, -*n]).collect()
    }

    /// Direction `index` of a list in which the kinds take turns.
    pub fn make(&mut self, index: usize) -> (Kind, DVec3) {
        let kind = KINDS[index % KINDS.len()];
        let random = self.rng.unit_vector();
        let (kind, d) = match kind {
            Kind::Normal if !self.normals.is_empty() => (kind, self.normal()),
            Kind::NearNormal if !self.normals.is_empty() => {
                (kind, self.normal() + random * 10_f64.powi(-(self.rng.below(9) as i32)))
            }
            Kind::Edge if !self.sides.is_empty() => {
                let [a, b] = self.sides[self.rng.below(self.sides.len())].map(|face| self.normals[face]);
                let t = self.rng.unit();
                (kind, a * t + b * (1.0 - t) + random * self.slight())
            }
            Kind::Vertex if !self.normals.is_empty() => {
                let around = &self.faces_at[self.rng.below(self.faces_at.len())];
                (kind, around.iter().map(|face| self.normals[*face] * (0.5 + self.rng.unit())).sum())
            }
            Kind::Seam => (kind, self.seam(random)),
            Kind::FanAxis if !self.fans.is_empty() => (kind, self.fan_axis(random)),
            Kind::FanStep if !self.fans.is_empty() => (kind, self.fan_step()),
            Kind::Extreme => {
                let size = [1e-44, 3e-39, 1e-35, 1e-31, 1e-30, 1e-20, 1e20, 1e30, 1e31, 1e38][self.rng.below(10)];
                (kind, random * size)
            }
            _ => (Kind::Random, random),
        };
        if d.length_squared() > 0.0 || kind == Kind::Extreme { (kind, d) } else { (Kind::Random, random) }
    }

    fn normal(&mut self) -> DVec3 {
        let normal = self.normals[self.rng.below(self.normals.len())];
        // A facet with many corners is rarely drawn, although most normal cones meet there. One
        // draw in eight takes the axis of its fan.
        let great = self.rng.below(8) == 0;
        if great && !self.fans.is_empty() { self.axis() } else { normal }
    }

    /// 0, or 1e-3 to 1e-17.
    fn slight(&mut self) -> f64 {
        if self.rng.below(4) == 0 { 0.0 } else { 10_f64.powi(-(3 + self.rng.below(15) as i32)) }
    }

    fn axis(&mut self) -> DVec3 {
        let fan = &self.fans[self.rng.below(self.fans.len())];
        let axis = fan.x.cross(fan.y).normalize();
        if self.rng.below(2) == 0 { axis } else { -axis }
    }

    fn fan_axis(&mut self, random: DVec3) -> DVec3 {
        let axis = self.axis();
        let distance = if self.rng.below(8) == 0 { 0.0 } else { 10_f64.powf(-6.0 - 11.0 * self.rng.unit()) };
        // If a facet has this normal, use its exact normal instead of the fan's axis.
        let near = |n: &&DVec3| n.distance(axis) < 1e-9;
        let base = if self.rng.below(2) == 0 { self.normals.iter().find(near).copied() } else { None };
        base.unwrap_or(axis) + random * distance
    }

    /// A direction in a fan's cell, turned to the border of a step, and a last digit beside it.
    fn fan_step(&mut self) -> DVec3 {
        let index = self.rng.below(self.fans.len());
        let fan = self.fans[index].clone();
        let p = fan.corner.map(|c| c + fan.size * self.rng.unit());
        let inside = DVec3::from_array(hullmap_format::cube::direction(fan.face, p[0], p[1]));
        let axis = fan.x.cross(fan.y);
        let along = axis.dot(inside);
        let step = self.rng.below(fan.steps as usize + 1) as f64;
        let angle = fan.start + step / fan.rate;
        let quarter = ((angle + 1.0) / 2.0).floor();
        let t = angle - 2.0 * quarter;
        let [x, y] = [[1.0, t], [-t, 1.0], [-1.0, -t], [t, -1.0]][quarter.rem_euclid(4.0) as usize];
        let mut distance = (inside - axis * along).length() / (1.0 + t * t).sqrt();
        if self.rng.below(2) == 0 {
            distance *= 10_f64.powf(-16.0 * self.rng.unit());
        }
        let d = axis * along + (fan.x * x + fan.y * y) * distance;
        [d, d, d.map(f64::next_up), d.map(f64::next_down)][self.rng.below(4)]
    }

    fn seam(&mut self, random: DVec3) -> DVec3 {
        let exact = match self.rng.below(4) {
            0 => {
                let corner = (self.rng.below(26) + 14) % 27;
                DVec3::new((corner % 3) as f64, (corner / 3 % 3) as f64, (corner / 9) as f64) - 1.0
            }
            1 => DVec3::new(random.x, random.x.abs() * random.y.signum(), random.z),
            2 => DVec3::new(random.x, random.y, random.y),
            _ => DVec3::new(random.z, random.y, -random.z),
        };
        // Exact in f32 as well.
        exact.as_vec3().as_dvec3() + self.rng.unit_vector() * self.slight()
    }
}

/// Invalid directions: zero, NaN, infinite. Any vertex is an allowed answer.
pub fn invalid() -> Vec<Vec3> {
    let odd = [0.0, -0.0, 1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    let all = odd.into_iter().flat_map(|x| odd.into_iter().flat_map(move |y| odd.map(|z| Vec3::new(x, y, z))));
    all.filter(|dir| !dir.is_finite() || *dir == Vec3::ZERO).collect()
}
