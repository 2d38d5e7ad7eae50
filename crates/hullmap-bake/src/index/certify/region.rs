//! Regions of directions on a face of the cube, as convex polygons in (u, v).

use glam::DVec3;
use hullmap_format::cube;
use hullmap_geometry::planes;

/// How far beyond a cell arcs are followed. It is less than the margin by which the baker widens
/// cells, so that its rounding error does not matter, and more than directions are misplaced.
pub fn cube_slack() -> f64 {
    cube::CELL_SLACK - 1e-10
}

/// Margins of a region at its border on a plane through the origin, in units of u and v.
#[derive(Clone, Copy, Debug)]
pub struct Margin {
    /// How far the region reaches across the plane: more than a direction is misplaced there.
    reach: f64,
    /// How far its core stays behind the plane: more than a cone may reach across it without being
    /// listed there ([`TOUCH`](crate::index::cones::TOUCH), 4e-15, and rounding error).
    core: f64,
}

impl Margin {
    /// At a plane of unit normal. The dot product is off by at most 6e-16.
    pub const PLANE: Self = Self { reach: 2e-15, core: 7e-15 };

    /// At a step of a fan. The angle is off by at most 3.3e-15. Each of the two dot products adds
    /// as much error as the dot product with a plane.
    pub const STEP: Self = Self { reach: 8e-15, core: 1.5e-14 };

    /// Where the same leaf continues.
    pub const NONE: Self = Self { reach: 0.0, core: 0.0 };

    pub fn core(self) -> f64 {
        self.core
    }
}

pub type Polygon = Vec<[f64; 2]>;

#[derive(Clone, Debug)]
pub struct Outline {
    /// Where all support vertices must be listed.
    pub core: Polygon,
    /// Contains all directions that lead to the region, and the core.
    pub reach: Polygon,
}

/// A region on a face of the cube: a square of the grid, or a part of one.
#[derive(Clone, Debug)]
pub struct Cell {
    pub face: u32,
    /// Lower and upper corner of the square, widened.
    pub square: [[f64; 2]; 2],
    /// Below planes or fans, the part of the square that they leave.
    pub part: Option<Outline>,
    /// Below a fan, the step of the innermost one.
    pub turn: Option<Turn>,
}

#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// The axes from which its angles are measured.
    pub axes: [DVec3; 2],
    pub angles: [f64; 2],
}

impl Cell {
    pub fn direction(&self, [u, v]: [f64; 2]) -> DVec3 {
        DVec3::from_array(cube::direction(self.face, u, v))
    }

    pub fn point(&self) -> Option<[f64; 2]> {
        match &self.part {
            None => Some([0, 1].map(|axis| 0.5 * (self.square[0][axis] + self.square[1][axis]))),
            Some(part) => (!part.core.is_empty()).then(|| middle(&part.core)),
        }
    }

    pub fn to_part(&self) -> Outline {
        self.part.clone().unwrap_or_else(|| {
            let [low, high] = self.square;
            let square = vec![low, [high[0], low[1]], high, [low[0], high[1]]];
            Outline { core: square.clone(), reach: square }
        })
    }
}

/// A plane through the origin, as a linear function on the plane of a cube's face.
#[derive(Clone, Copy, Debug)]
pub struct Line([f64; 3]);

impl Line {
    pub fn new(face: u32, normal: DVec3) -> Self {
        let axis = (face / 2) as usize;
        let towards = if face.is_multiple_of(2) { normal[axis] } else { -normal[axis] };
        Self([normal[(axis + 1) % 3], normal[(axis + 2) % 3], towards])
    }

    pub fn height(self, [u, v]: [f64; 2]) -> f64 {
        self.0[0] * u + self.0[1] * v + self.0[2]
    }

    pub fn reversed(self) -> Self {
        Self(self.0.map(|term| -term))
    }
}

impl Outline {
    /// The part in front of a plane; `None` if no direction leads there.
    pub fn clip(&self, line: Line, margin: Margin) -> Option<Self> {
        let reach = clip(&self.reach, |p| line.height(p) + margin.reach);
        let core = clip(&self.core, |p| line.height(p) - margin.core);
        (!reach.is_empty()).then_some(Self { core, reach })
    }
}

fn clip(polygon: &[[f64; 2]], height: impl Fn([f64; 2]) -> f64) -> Polygon {
    let mut out = Polygon::with_capacity(polygon.len() + 1);
    planes::clip(polygon, height, planes::between, &mut out);
    out
}

fn middle(polygon: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|axis| polygon.iter().map(|p| p[axis]).sum::<f64>() / polygon.len() as f64)
}

/// The two corners that are farthest from each other, and the greatest distance of a point of the
/// polygon from the segment between them.
pub fn axis(polygon: &[[f64; 2]]) -> ([[f64; 2]; 2], f64) {
    let mut ends = [polygon[0]; 2];
    let mut farthest = 0.0;
    for (i, &p) in polygon.iter().enumerate() {
        for &q in &polygon[i + 1..] {
            if between(p, q) > farthest {
                (ends, farthest) = ([p, q], between(p, q));
            }
        }
    }
    (ends, distance(polygon, &ends))
}

fn distance(polygon: &[[f64; 2]], core: &[[f64; 2]]) -> f64 {
    let [tip, nearest] = farthest(polygon, core);
    between(tip, nearest)
}

/// The point of `polygon` that is farthest from `core`, and the point of the core that is nearest
/// to it. The distance from a convex set is a convex function, so a corner is farthest.
pub fn farthest(polygon: &[[f64; 2]], core: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let pairs = polygon.iter().map(|&p| [p, nearest(p, core)]);
    pairs.max_by(|a, b| between(a[0], a[1]).total_cmp(&between(b[0], b[1]))).unwrap_or([[f64::NAN; 2]; 2])
}

fn nearest(p: [f64; 2], core: &[[f64; 2]]) -> [f64; 2] {
    let (mut best, mut least) = ([f64::NAN; 2], f64::INFINITY);
    let (mut left, mut right) = (false, false);
    for (i, &a) in core.iter().enumerate() {
        let b = core[(i + 1) % core.len()];
        let (side, to) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
        let area = side[0] * to[1] - side[1] * to[0];
        left |= area > 0.0;
        right |= area < 0.0;
        let size_sq = side[0] * side[0] + side[1] * side[1];
        let share = if size_sq > 0.0 { ((side[0] * to[0] + side[1] * to[1]) / size_sq).clamp(0.0, 1.0) } else { 0.0 };
        let on_side = [a[0] + share * side[0], a[1] + share * side[1]];
        if between(p, on_side) < least {
            (best, least) = (on_side, between(p, on_side));
        }
    }
    // A core without area contains nothing.
    if left != right && core.len() > 2 { p } else { best }
}

/// Cuts a convex polygon at `at`, at right angles to the way from there to `tip`: the part on the
/// side of the tip, and the rest.
pub fn cut_across(polygon: &[[f64; 2]], at: [f64; 2], tip: [f64; 2]) -> (Polygon, Polygon) {
    let way = [tip[0] - at[0], tip[1] - at[1]];
    let along = |p: [f64; 2]| way[0] * (p[0] - at[0]) + way[1] * (p[1] - at[1]);
    (clip(polygon, along), clip(polygon, |p| -along(p)))
}

pub fn between(p: [f64; 2], q: [f64; 2]) -> f64 {
    length([p[0] - q[0], p[1] - q[1]])
}

fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}
