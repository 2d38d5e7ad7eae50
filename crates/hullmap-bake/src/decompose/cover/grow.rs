//! Growth of parts: cell after cell, while the hull of the cells stays near the solid.
//!
//! # Steps
//! 1. Start with the given cells. Candidates are cells whose boxes are close to a member's.
//! 2. Take the candidates in a given order. A candidate joins if the hull of all members then
//!    contains no forbidden point: a point that is known to be too far from the solid. For each
//!    forbidden point, a plane that separates it is kept, so that most are settled by one dot
//!    product. A cell that was rejected stays rejected, since the hull only grows.
//! 3. When the part has doubled, and at the end, points of its hull's faces are measured. Those
//!    that are too far become forbidden, and the growth goes back to where it was last measured.
//! 4. The part also covers every cell whose points its hull contains.

use std::collections::BTreeSet;

use glam::DVec3;

use super::bits::Bits;
use super::body::{Body, THICKNESS, farthest, separation};
use super::cells::{self, Cell};
use super::field::Field;

/// The cells of a cover and their neighbours, with the solid: shared by all growths.
pub struct CellGraph<'a> {
    /// The cells.
    pub cells: &'a [Cell],
    /// For each cell, the cells whose boxes are within twice the limit of its box, along each
    /// axis.
    pub near: Vec<Vec<u32>>,
    /// The solid.
    pub field: &'a Field<'a>,
    /// Maximum distance of a part from the solid.
    pub limit: f64,
    /// Diagonal of the mesh.
    pub diagonal: f64,
}

/// A part that may be chosen.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The cells it is made of.
    pub members: Vec<u32>,
    /// The cells in its hull, members and others.
    pub covers: Bits,
    /// Extreme points of its hull.
    pub points: Vec<DVec3>,
}

/// Maximum number of distances by which points of a hull's faces that are too far are sought.
const MEASURED: usize = 200;

/// The same at the end of a growth.
const MEASURED_LAST: usize = 800;

/// Number of points after which no more are sought.
const FOUND: usize = 8;

/// Maximum number of times that a growth goes back.
const MAX_REPAIRS: usize = 12;

/// Number of points after which those inside the hull are dropped.
const CROWD: usize = 96;

impl<'a> CellGraph<'a> {
    /// Finds the neighbours of all cells.
    pub fn new(cells: &'a [Cell], field: &'a Field<'a>, limit: f64, diagonal: f64) -> Self {
        let mut order: Vec<u32> = (0..cells.len() as u32).collect();
        order.sort_by(|a, b| cells[*a as usize].low.x.total_cmp(&cells[*b as usize].low.x).then(a.cmp(b)));
        // A gap is bridged if its middle is within the limit of both sides.
        let reach = 2.0 * limit;
        let mut near = vec![Vec::new(); cells.len()];
        for (at, i) in order.iter().enumerate() {
            let a = &cells[*i as usize];
            for j in &order[at + 1..] {
                let b = &cells[*j as usize];
                if b.low.x > a.high.x + reach {
                    break;
                }
                let gap = (a.low - b.high).max(b.low - a.high).max_element();
                if gap <= reach {
                    near[*i as usize].push(*j);
                    near[*j as usize].push(*i);
                }
            }
        }
        near.iter_mut().for_each(|list| list.sort_unstable());
        Self { cells, near, field, limit, diagonal }
    }

    fn margin(&self) -> f64 {
        1e-9 * self.diagonal
    }

    fn body(&self, points: &[DVec3]) -> Body {
        Body::new(points, self.diagonal * THICKNESS)
    }

    /// Points of a body's surface that are too far from the solid.
    pub fn too_far(&self, body: &Body, count: usize) -> Vec<DVec3> {
        self.field.points_beyond(&body.triangles, self.limit, FOUND, count)
    }

    /// Grows a part from the cells of `start`; `None` if their own hull is too far from the solid.
    ///
    /// Cells join in ascending order of `key`, which is not negative. Cells without a key do not
    /// join. If a cell of `wanted` cannot join, there is no part. Points that are found to be too
    /// far from the solid are added to `forbidden`.
    pub fn grow(
        &self,
        start: &[u32],
        key: &dyn Fn(u32) -> Option<f64>,
        wanted: Option<&Bits>,
        forbidden: &mut Vec<DVec3>,
    ) -> Option<Candidate> {
        let mut growth = Growth::new(self);
        if !growth.start(start, forbidden) {
            return None;
        }
        let mut good = growth.members.len();
        let mut repairs = 0;
        let mut tried = Bits::new(self.cells.len());
        let mut frontier = BTreeSet::new();
        let extend = |frontier: &mut BTreeSet<(u64, u32)>, tried: &Bits, cell: u32| {
            for next in &self.near[cell as usize] {
                if !tried.has(*next as usize)
                    && let Some(key) = key(*next)
                {
                    // Keys are not negative, so that their bits are in order.
                    frontier.insert((key.max(0.0).to_bits(), *next));
                }
            }
        };
        for cell in start {
            tried.insert(*cell as usize);
        }
        for cell in start {
            extend(&mut frontier, &tried, *cell);
        }
        loop {
            while let Some((_, cell)) = frontier.pop_first() {
                if tried.has(cell as usize) {
                    continue;
                }
                tried.insert(cell as usize);
                if growth.join(cell, forbidden) {
                    extend(&mut frontier, &tried, cell);
                    if growth.members.len() >= 2 * good + 2 {
                        break;
                    }
                } else if wanted.is_some_and(|wanted| wanted.has(cell as usize)) {
                    return None;
                }
            }
            growth.tighten();
            let found = self.too_far(&growth.shell, if frontier.is_empty() { MEASURED_LAST } else { MEASURED });
            if found.is_empty() {
                good = growth.members.len();
                if frontier.is_empty() {
                    return Some(self.candidate(growth.members, &growth.shell, self.margin() + self.coarse()));
                }
                continue;
            }
            forbidden.extend(found);
            repairs += 1;
            if repairs > MAX_REPAIRS || good == growth.members.len() {
                if good == start.len() && good == growth.members.len() && start.len() > 1 {
                    return None;
                }
                growth.go_back(good, forbidden);
                growth.tighten();
                return Some(self.candidate(growth.members, &growth.shell, self.margin() + self.coarse()));
            }
            let again = growth.go_back(good, forbidden);
            for cell in again {
                if let Some(key) = key(cell) {
                    frontier.insert((key.max(0.0).to_bits(), cell));
                }
            }
            tried = Bits::new(self.cells.len());
            growth.members.iter().for_each(|cell| tried.insert(*cell as usize));
            // Only cells in `Growth::rejected` stay rejected.
            growth.rejected.iter().for_each(|cell| tried.insert(*cell as usize));
        }
    }

    /// Distance up to which a part that grew with few points of its cells may miss others.
    pub fn coarse(&self) -> f64 {
        cells::COARSE * self.limit
    }

    /// A part of these cells, with all cells in its hull, or at most `slack` outside.
    fn candidate(&self, members: Vec<u32>, body: &Body, slack: f64) -> Candidate {
        let mut covers = Bits::new(self.cells.len());
        members.iter().for_each(|cell| covers.insert(*cell as usize));
        let holds = |cell: &Cell| {
            body.planes.iter().all(|plane| {
                plane.height(cell.centre) + cell.radius <= slack
                    || cell.points.iter().all(|p| plane.height(*p) <= slack)
            })
        };
        for (i, cell) in self.cells.iter().enumerate() {
            let is_near = cell.low.cmpge(body.low - slack).all() && cell.high.cmple(body.high + slack).all();
            if is_near && !covers.has(i) && holds(cell) {
                covers.insert(i);
            }
        }
        Candidate { members, covers, points: body.points.clone() }
    }

    /// The part of these cells, without growth.
    pub fn part(&self, members: Vec<u32>) -> Candidate {
        let points: Vec<DVec3> =
            members.iter().flat_map(|cell| self.cells[*cell as usize].points.iter().copied()).collect();
        let body = self.body(&points);
        self.candidate(members, &body, self.margin())
    }

    /// A part with more cells.
    pub fn with(&self, part: &Candidate, cells: &[u32]) -> Candidate {
        let more = cells.iter().flat_map(|cell| self.cells[*cell as usize].points.iter().copied());
        let body = self.body(&part.points.iter().copied().chain(more).collect::<Vec<_>>());
        self.candidate([part.members.as_slice(), cells].concat(), &body, self.margin())
    }
}

/// A part while it grows.
struct Growth<'a> {
    graph: &'a CellGraph<'a>,
    members: Vec<u32>,
    rejected: Vec<u32>,
    points: Vec<DVec3>,
    /// The hull of some of the points.
    shell: Body,
    crowd: usize,
    low: DVec3,
    high: DVec3,
    /// For each forbidden point, a plane through it that has all points below.
    apart: Planes,
    /// Forbidden points that rejected the last cells. They are tested first.
    hot: Vec<u32>,
    /// Forbidden points whose planes may not have a new cell below. Scratch space.
    close: Vec<u32>,
}

impl<'a> Growth<'a> {
    fn new(graph: &'a CellGraph<'a>) -> Self {
        Self {
            graph,
            members: Vec::new(),
            rejected: Vec::new(),
            points: Vec::new(),
            shell: Body::default(),
            crowd: CROWD,
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
            apart: Planes::default(),
            hot: Vec::new(),
            close: Vec::new(),
        }
    }

    /// The hull of all points. Points inside are dropped.
    fn tighten(&mut self) {
        self.shell = self.graph.body(&self.points);
        self.points.clone_from(&self.shell.points);
        self.crowd = CROWD.max(2 * self.points.len());
    }

    /// Adds the first cells, unless their hull contains a forbidden point.
    fn start(&mut self, cells: &[u32], forbidden: &[DVec3]) -> bool {
        self.collect(cells);
        if self.points.len() > self.crowd {
            self.tighten();
        }
        self.members.extend_from_slice(cells);
        self.apart.resize(forbidden.len());
        let (low, high) = (self.low, self.high);
        (0..forbidden.len()).all(|i| self.separate(i, forbidden[i], low, high))
    }

    /// Adds points of cells, and extends the box.
    fn collect(&mut self, cells: &[u32]) {
        for cell in cells {
            let cell = &self.graph.cells[*cell as usize];
            self.points.extend_from_slice(&cell.few);
            (self.low, self.high) = (self.low.min(cell.low), self.high.max(cell.high));
        }
    }

    /// Finds a plane between all points, which lie in a box, and a forbidden point. Returns whether
    /// there is one.
    fn separate(&mut self, i: usize, f: DVec3, low: DVec3, high: DVec3) -> bool {
        let margin = self.graph.margin();
        // A side of the box.
        let (below, above) = (low - f, f - high);
        if below.max(above).max_element() > 2.0 * margin {
            let mut best = (0.0, DVec3::ZERO);
            for axis in 0..3 {
                for (gap, sign) in [(below[axis], -1.0), (above[axis], 1.0)] {
                    if gap > best.0 {
                        let mut normal = DVec3::ZERO;
                        normal[axis] = sign;
                        best = (gap, normal);
                    }
                }
            }
            self.apart.set(i, best.1, best.1.dot(f) - margin);
            return true;
        }
        let towards = self.apart.normal(i).unwrap_or(f - (low + high) * 0.5);
        let Some(plane) = separation(|d| farthest(&self.points, d), f, towards, margin) else { return false };
        // The plane through the forbidden point leaves the most room.
        self.apart.set(i, plane.normal, plane.normal.dot(f) - margin);
        true
    }

    /// Adds a cell, unless the hull would contain a forbidden point.
    fn join(&mut self, cell: u32, forbidden: &[DVec3]) -> bool {
        self.apart.resize(forbidden.len());
        let graph = self.graph;
        let new = &graph.cells[cell as usize];
        let (low, high) = (self.low.min(new.low), self.high.max(new.high));
        let count = self.points.len();
        self.points.extend(new.few.iter().filter(|p| !self.shell.holds(**p, 0.0)));
        if self.points.len() == count {
            self.members.push(cell);
            return true;
        }
        let mut close = std::mem::take(&mut self.close);
        close.clear();
        close.extend_from_slice(&self.hot);
        self.apart.not_below(new.centre, new.radius, &mut close);
        let is_free = close.iter().all(|i| {
            let at = *i as usize;
            let is_joined = self.apart.has_below(at, &new.few) || self.separate(at, forbidden[at], low, high);
            if !is_joined {
                self.points.truncate(count);
                self.rejected.push(cell);
                self.hot.retain(|other| other != i);
                self.hot.insert(0, *i);
                self.hot.truncate(8);
            }
            is_joined
        });
        self.close = close;
        if !is_free {
            return false;
        }
        (self.low, self.high) = (low, high);
        self.members.push(cell);
        if self.points.len() > self.crowd {
            self.tighten();
        }
        true
    }

    /// Drops all members but the first `count`, and returns them.
    fn go_back(&mut self, count: usize, forbidden: &[DVec3]) -> Vec<u32> {
        let dropped = self.members.split_off(count);
        self.points.clear();
        self.shell = Body::default();
        (self.low, self.high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let members = std::mem::take(&mut self.members);
        self.collect(&members);
        self.members = members;
        self.crowd = CROWD;
        self.apart.resize(forbidden.len());
        // A cell that was rejected beside dropped members may fit now.
        self.rejected.clear();
        dropped
    }
}

/// Planes, one array for each coordinate, so that many are tested at once.
#[derive(Default)]
struct Planes {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    /// A point below a plane has a lower dot product with its normal. Nothing is below a missing
    /// plane.
    offset: Vec<f64>,
}

/// Number of planes that are tested at once.
const AT_ONCE: usize = 8;

impl Planes {
    fn resize(&mut self, count: usize) {
        [&mut self.x, &mut self.y, &mut self.z].into_iter().for_each(|list| list.resize(count, 0.0));
        self.offset.resize(count, f64::NEG_INFINITY);
    }

    fn set(&mut self, i: usize, normal: DVec3, offset: f64) {
        (self.x[i], self.y[i], self.z[i], self.offset[i]) = (normal.x, normal.y, normal.z, offset);
    }

    /// The normal of a plane; `None` without one.
    fn normal(&self, i: usize) -> Option<DVec3> {
        (self.offset[i] > f64::NEG_INFINITY).then(|| DVec3::new(self.x[i], self.y[i], self.z[i]))
    }

    fn has_below(&self, i: usize, points: &[DVec3]) -> bool {
        let normal = DVec3::new(self.x[i], self.y[i], self.z[i]);
        points.iter().all(|p| normal.dot(*p) < self.offset[i])
    }

    /// Adds the planes that may not have all of a ball below them.
    fn not_below(&self, centre: DVec3, radius: f64, found: &mut Vec<u32>) {
        let is_below =
            |i: usize| self.x[i] * centre.x + self.y[i] * centre.y + self.z[i] * centre.z + radius < self.offset[i];
        let count = self.offset.len();
        let whole = count - count % AT_ONCE;
        for first in (0..whole).step_by(AT_ONCE) {
            let (x, y) = (&self.x[first..first + AT_ONCE], &self.y[first..first + AT_ONCE]);
            let (z, offset) = (&self.z[first..first + AT_ONCE], &self.offset[first..first + AT_ONCE]);
            let mut least = [0.0; AT_ONCE];
            for k in 0..AT_ONCE {
                least[k] = offset[k] - (x[k] * centre.x + y[k] * centre.y + z[k] * centre.z + radius);
            }
            if least.iter().any(|room| !(*room > 0.0)) {
                found.extend((first..first + AT_ONCE).filter(|i| !is_below(*i)).map(|i| i as u32));
            }
        }
        found.extend((whole..count).filter(|i| !is_below(*i)).map(|i| i as u32));
    }
}
