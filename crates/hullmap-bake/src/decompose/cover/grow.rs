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
use super::body::{Body, Plane, separation};
use super::cells::Cell;
use super::field::Field;
use super::sample::face_points;

/// What all growths share: the cells, their neighbours, and the solid.
pub struct Ground<'a> {
    /// The cells.
    pub cells: &'a [Cell],
    /// For each cell, the cells whose boxes are within the limit of its box, along each axis.
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

/// Number of points of a hull's faces that are measured.
const MEASURED: usize = 240;

/// The same at the end of a growth.
const MEASURED_LAST: usize = 4000;

/// Maximum number of times that a growth goes back.
const MAX_REPAIRS: usize = 12;

/// Number of points after which those inside the hull are dropped.
const CROWD: usize = 96;

impl<'a> Ground<'a> {
    /// Finds the neighbours of all cells.
    pub fn new(cells: &'a [Cell], field: &'a Field<'a>, limit: f64, diagonal: f64) -> Self {
        let mut order: Vec<u32> = (0..cells.len() as u32).collect();
        order.sort_by(|a, b| cells[*a as usize].low.x.total_cmp(&cells[*b as usize].low.x).then(a.cmp(b)));
        let mut near = vec![Vec::new(); cells.len()];
        for (at, i) in order.iter().enumerate() {
            let a = &cells[*i as usize];
            for j in &order[at + 1..] {
                let b = &cells[*j as usize];
                if b.low.x > a.high.x + limit {
                    break;
                }
                let gap = (a.low - b.high).max(b.low - a.high).max_element();
                if gap <= limit {
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
        Body::new(points, self.diagonal * super::THICKNESS)
    }

    /// Points of a body's surface that are too far from the solid.
    pub fn too_far(&self, body: &Body, count: usize) -> Vec<DVec3> {
        let points = face_points(body, count, self.limit);
        points.into_iter().filter(|p| self.field.is_beyond(*p, self.limit)).take(8).collect()
    }

    /// Grows a part from the cells of `start`; `None` if their own hull is too far from the solid.
    ///
    /// Cells join in ascending order of `key`, which is not negative. Cells without a key do not
    /// join. Points that are found to be too far from the solid are added to `forbidden`.
    pub fn grow(
        &self,
        start: &[u32],
        key: &dyn Fn(u32) -> Option<f64>,
        forbidden: &mut Vec<DVec3>,
    ) -> Option<Candidate> {
        let mut growth = Growth::new(self);
        for cell in start {
            if !growth.join(*cell, forbidden) {
                return None;
            }
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
                }
            }
            let body = growth.body();
            let found = self.too_far(&body, if frontier.is_empty() { MEASURED_LAST } else { MEASURED });
            if found.is_empty() {
                good = growth.members.len();
                if frontier.is_empty() {
                    return Some(self.candidate(growth.members, &body));
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
                let body = growth.body();
                return Some(self.candidate(growth.members, &body));
            }
            let again = growth.go_back(good, forbidden);
            for cell in again {
                if let Some(key) = key(cell) {
                    frontier.insert((key.max(0.0).to_bits(), cell));
                }
            }
            tried = Bits::new(self.cells.len());
            growth.members.iter().for_each(|cell| tried.insert(*cell as usize));
            // What was rejected stays rejected, but only what was rejected: see `Growth::rejected`.
            growth.rejected.iter().for_each(|cell| tried.insert(*cell as usize));
        }
    }

    /// A part of these cells, with all cells in its hull.
    pub fn candidate(&self, members: Vec<u32>, body: &Body) -> Candidate {
        let mut covers = Bits::new(self.cells.len());
        members.iter().for_each(|cell| covers.insert(*cell as usize));
        let slack = self.margin();
        for (i, cell) in self.cells.iter().enumerate() {
            let is_near = cell.centre.cmpge(body.low).all() && cell.centre.cmple(body.high).all();
            if is_near && !covers.has(i) && cell.points.iter().all(|p| body.holds(*p, slack)) {
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
        self.candidate(members, &body)
    }
}

/// A part while it grows.
struct Growth<'a> {
    ground: &'a Ground<'a>,
    members: Vec<u32>,
    rejected: Vec<u32>,
    points: Vec<DVec3>,
    crowd: usize,
    low: DVec3,
    high: DVec3,
    /// For each forbidden point, a plane through it that has all points below.
    apart: Vec<Option<Plane>>,
    /// Forbidden points that rejected the last cells. They are tested first.
    hot: Vec<u32>,
}

impl<'a> Growth<'a> {
    fn new(ground: &'a Ground<'a>) -> Self {
        Self {
            ground,
            members: Vec::new(),
            rejected: Vec::new(),
            points: Vec::new(),
            crowd: CROWD,
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
            apart: Vec::new(),
            hot: Vec::new(),
        }
    }

    fn body(&self) -> Body {
        self.ground.body(&self.points)
    }

    /// Adds a cell, unless the hull would contain a forbidden point.
    fn join(&mut self, cell: u32, forbidden: &[DVec3]) -> bool {
        self.apart.resize(forbidden.len(), None);
        let new = &self.ground.cells[cell as usize];
        let (low, high) = (self.low.min(new.low), self.high.max(new.high));
        let count = self.points.len();
        self.points.extend_from_slice(&new.points);
        let margin = self.ground.margin();
        let middle = (low + high) * 0.5;
        for step in 0..self.hot.len() + forbidden.len() {
            let i = match step.checked_sub(self.hot.len()) {
                Some(i) => i,
                None => self.hot[step] as usize,
            };
            let f = forbidden[i];
            if f.cmplt(low).any() || f.cmpgt(high).any() {
                continue;
            }
            if let Some(plane) = self.apart[i] {
                let room = plane.offset - margin;
                if plane.normal.dot(new.centre) + new.radius < room
                    || new.points.iter().all(|p| plane.normal.dot(*p) < room)
                {
                    continue;
                }
            }
            let towards = self.apart[i].map_or(f - middle, |plane| plane.normal);
            match separation(&self.points, f, towards, margin) {
                // The plane through the forbidden point leaves the most room.
                Some(plane) => self.apart[i] = Some(Plane { offset: plane.normal.dot(f), ..plane }),
                None => {
                    self.points.truncate(count);
                    self.rejected.push(cell);
                    let i = i as u32;
                    self.hot.retain(|other| *other != i);
                    self.hot.insert(0, i);
                    self.hot.truncate(8);
                    return false;
                }
            }
        }
        (self.low, self.high) = (low, high);
        self.members.push(cell);
        if self.points.len() > self.crowd {
            self.points = self.body().points;
            self.crowd = CROWD.max(2 * self.points.len());
        }
        true
    }

    /// Drops all members but the first `count`, and returns them.
    fn go_back(&mut self, count: usize, forbidden: &[DVec3]) -> Vec<u32> {
        let dropped = self.members.split_off(count);
        self.points.clear();
        (self.low, self.high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for cell in &self.members {
            let cell = &self.ground.cells[*cell as usize];
            self.points.extend_from_slice(&cell.points);
            (self.low, self.high) = (self.low.min(cell.low), self.high.max(cell.high));
        }
        self.crowd = CROWD;
        self.apart.resize(forbidden.len(), None);
        // A cell that was rejected beside dropped members may fit now.
        self.rejected.clear();
        dropped
    }
}
