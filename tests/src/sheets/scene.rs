//! Triangle meshes of all kinds, and bodies beside them.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use hullmap::{Pack, Pose, TriangleMesh};
use hullmap_testkit::packs::{loose_mesh, tree_pack};
use hullmap_testkit::random::RandomPoses;
use shapes::rng::SplitMix64;

/// A kind of mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Triangles at random places.
    Random,
    /// A plane of triangles, and bodies that stand on it.
    Flat,
    /// Triangles that are nearly lines.
    Needle,
    /// Corners with small whole coordinates: edges and corners in line with each other.
    Tied,
    /// As `Random`, far from the origin.
    Far,
    /// As `Random`, a million times smaller.
    Tiny,
    /// A triangle of 10 km beside triangles of 1 m.
    Huge,
    /// Closed boxes that overlap, with whole coordinates.
    Closed,
    /// A closed sphere of triangles, rough, thin or hollow.
    Round,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 9] = [
        Self::Random,
        Self::Flat,
        Self::Needle,
        Self::Tied,
        Self::Far,
        Self::Tiny,
        Self::Huge,
        Self::Closed,
        Self::Round,
    ];

    /// Whether all coordinates are small whole numbers times the unit.
    pub fn is_whole(self) -> bool {
        matches!(self, Self::Tied | Self::Closed | Self::Flat)
    }
}

/// A mesh, and the size of things beside it.
pub struct Scene {
    /// Its kind.
    pub kind: Kind,
    /// The mesh.
    pub mesh: TriangleMesh,
    /// Corners of its triangles, as it has them.
    pub triangles: Vec<[DVec3; 3]>,
    /// The middle of the mesh.
    pub origin: DVec3,
    /// A power of two: most triangles have about this size.
    pub unit: f64,
    /// Bound of the rounding error of a truth in f64.
    pub slack: f64,
}

/// A body beside a mesh.
pub struct Body {
    /// Its hull, alone in a pack.
    pub pack: Pack,
    /// Where it is.
    pub pose: Pose,
    /// Its vertices there, in f64.
    pub points: Vec<DVec3>,
    /// Whether these are exact.
    pub is_exact: bool,
}

fn vector(rng: &mut SplitMix64) -> DVec3 {
    rng.unit_vector() * rng.unit().cbrt()
}

/// A point with whole coordinates from −most to most.
fn whole(most: i32, rng: &mut SplitMix64) -> DVec3 {
    let mut coordinate = || f64::from(rng.below(2 * most as usize + 1) as i32 - most);
    DVec3::new(coordinate(), coordinate(), coordinate())
}

impl Scene {
    /// The scene with this index. Panics if it cannot be baked.
    pub fn new(kind: Kind, seed: u64, index: u64) -> Self {
        let mut rng = stream(seed, index);
        let unit = if kind == Kind::Tiny { (-20.0_f64).exp2() } else { 1.0 };
        let origin = if kind == Kind::Far { 1e4 * rng.unit_vector().round() } else { DVec3::ZERO };
        let count = 1 + rng.below(48);
        let mut corners: Vec<[DVec3; 3]> = (0..count).map(|_| Self::triangle(kind, &mut rng)).collect();
        match kind {
            Kind::Flat => corners = flat_square(1 + rng.below(4)),
            Kind::Closed => corners = (0..1 + rng.below(3)).flat_map(|_| block(&mut rng)).collect(),
            Kind::Huge => corners.extend(long(&mut rng)),
            Kind::Round => corners = sphere(&mut rng),
            _ => {}
        }
        corners.iter_mut().flatten().for_each(|corner| *corner = origin + *corner * unit);
        let mesh = loose_mesh(&corners);
        let triangles: Vec<_> = (0..mesh.triangle_count()).filter_map(|i| Some(mesh.triangle(i)?.corners())).collect();
        let greatest = triangles.iter().flatten().map(|corner| corner.abs().max_element()).fold(0.0, f64::max);
        Self { kind, mesh, triangles, origin, unit, slack: 1e-12 * (greatest + unit) }
    }

    /// A triangle of about the size 1 within 3 of the origin.
    fn triangle(kind: Kind, rng: &mut SplitMix64) -> [DVec3; 3] {
        loop {
            let middle = 2.0 * vector(rng);
            let corners = match kind {
                Kind::Tied => [0; 3].map(|_| whole(3, rng)),
                Kind::Needle => {
                    let along = vector(rng);
                    let off = 10_f64.powf(rng.between(-6.0, -1.0));
                    [middle, middle + along, middle + along * rng.unit() + vector(rng) * off]
                }
                _ => [0; 3].map(|_| middle + vector(rng) * rng.between(0.1, 1.5)),
            };
            let [a, b, c] = corners;
            if (b - a).cross(c - a).length() > 1e-9 {
                return corners;
            }
        }
    }

    /// A body that touches the mesh, or is near it.
    pub fn body(&self, rng: &mut SplitMix64) -> Body {
        let exact = self.kind.is_whole() && rng.below(2) == 0;
        let corners: Vec<DVec3> = if exact {
            let half = DVec3::splat(1.0) + whole(1, rng).abs();
            let ways = |i: usize| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64) * 2.0 - 1.0;
            match rng.below(3) {
                0 => (0..8).map(|i| ways(i) * half).collect(),
                1 => DVec3::AXES.into_iter().flat_map(|axis| [axis * half, -axis * half]).collect(),
                _ => vec![DVec3::ZERO, DVec3::X * half, DVec3::Y * half, DVec3::Z * half],
            }
        } else {
            let size = rng.between(0.1, 1.0);
            (0..4 + rng.below(5)).map(|_| rng.unit_vector() * size).collect()
        };
        let positions: Vec<[f32; 3]> = corners.iter().map(|c| (*c * self.unit).as_vec3().to_array()).collect();
        let pack = tree_pack(&positions);
        let at = if exact {
            whole(4, rng)
        } else {
            // Near a triangle, inside or outside.
            let [a, b, c] = self.triangles[rng.below(self.triangles.len())];
            let (u, v) = (rng.unit(), rng.unit());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let on = a + (b - a) * u + (c - a) * v;
            // For a long triangle, half of the time near the others.
            let on = if self.kind == Kind::Huge && rng.below(2) == 0 { on * 1e-3 } else { on };
            (on - self.origin) / self.unit + vector(rng) * rng.between(0.0, 1.5)
        };
        let turn = DQuat::from_xyzw(rng.unit() - 0.5, rng.unit() - 0.5, rng.unit() - 0.5, rng.unit() - 0.5);
        let turn = if exact { DQuat::IDENTITY } else { turn.normalize() };
        let pose = Pose::new(self.origin + at * self.unit, turn).expect("a pose");
        let hull = pack.hull(0).expect("one hull");
        let points = hull.vertices().map(|vertex| pose.transform_point(vertex.as_dvec3())).collect();
        Body { pose, points, is_exact: exact, pack }
    }

    /// A point near the mesh, or on it.
    pub fn point(&self, rng: &mut SplitMix64) -> DVec3 {
        if self.kind.is_whole() && rng.below(3) > 0 {
            return (whole(8, rng) * 0.5) * self.unit;
        }
        let corner = self.triangles[rng.below(self.triangles.len())][rng.below(3)];
        corner + vector(rng) * self.unit * 10_f64.powf(rng.between(-4.0, 0.5))
    }
}

/// A square of 2 × `cells` triangles a side in the plane z = 0.
fn flat_square(cells: usize) -> Vec<[DVec3; 3]> {
    let at = |x: usize, y: usize| DVec3::new(x as f64 - 2.0, y as f64 - 2.0, 0.0);
    let square =
        |x: usize, y: usize| [[at(x, y), at(x + 1, y), at(x + 1, y + 1)], [at(x, y), at(x + 1, y + 1), at(x, y + 1)]];
    (0..cells).flat_map(|x| (0..cells).flat_map(move |y| square(x, y))).collect()
}

/// A box with whole coordinates, its fronts outwards.
fn block(rng: &mut SplitMix64) -> Vec<[DVec3; 3]> {
    let low = whole(3, rng);
    let high = low + DVec3::ONE + whole(2, rng).abs();
    let corner = |i: usize| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|t| t.map(corner)).collect()
}

/// A sphere of triangles, its vertices moved at random, or pressed flat; or with a cavity, whose
/// fronts are inwards.
fn sphere(rng: &mut SplitMix64) -> Vec<[DVec3; 3]> {
    let (rings, rough) = (2 + rng.below(3), [0.0, 0.4][rng.below(2)]);
    let thin = [1.0, 1.0, 1e-3][rng.below(3)];
    let around = 2 * rings;
    let mut grid = vec![vec![DVec3::NEG_Z * thin; around]];
    for ring in 1..rings {
        let angle = PI * ring as f64 / rings as f64;
        let mut at = |i: usize| {
            let turn = 2.0 * PI * i as f64 / around as f64;
            let place = DVec3::new(angle.sin() * turn.cos(), angle.sin() * turn.sin(), -angle.cos() * thin);
            place * (1.0 + rough * rng.unit())
        };
        grid.push((0..around).map(&mut at).collect());
    }
    grid.push(vec![DVec3::Z * thin; around]);
    let mut corners = Vec::new();
    for (ring, i) in (0..rings).flat_map(|ring| (0..around).map(move |i| (ring, i))) {
        let [a, b] = [i, (i + 1) % around].map(|i| grid[ring][i]);
        let [d, c] = [i, (i + 1) % around].map(|i| grid[ring + 1][i]);
        corners.extend([[a, b, c], [a, c, d]].into_iter().filter(|[a, b, c]| a != b && b != c && c != a));
    }
    let outer = corners.iter().map(|t| t.map(|corner| corner * 2.0));
    let inner = corners.iter().map(|[a, b, c]| [*b, *a, *c]);
    if rng.below(3) == 0 { outer.chain(inner).collect() } else { outer.collect() }
}

/// A triangle of up to 10 km through the origin, nearly.
fn long(rng: &mut SplitMix64) -> Vec<[DVec3; 3]> {
    let size = 10_f64.powf(rng.between(1.0, 4.0));
    let turn = DQuat::from_rotation_arc(DVec3::Z, rng.unit_vector());
    vec![[DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, -1.0, 0.0), DVec3::Y].map(|corner| turn * corner * size)]
}

/// Random numbers of a scene. The seed is mixed: the state after `n` numbers has `n` times the same
/// constant added, so that a scene would continue the numbers of another one.
pub fn stream(seed: u64, index: u64) -> SplitMix64 {
    SplitMix64::new(SplitMix64::new(seed).next_u64() ^ index.wrapping_mul(0x9e37_79b9_7f4a_7c15))
}
