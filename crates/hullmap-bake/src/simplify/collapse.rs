//! Edge collapse (progressive hulls): removes vertices of a convex surface around a hull, one edge
//! at a time, without cutting into the hull.
//!
//! # Steps
//! 1. Take the edge that can be replaced by the point nearest to the hull. That point lies outside
//!    all triangles at both ends of the edge, so that the convex hull of the other vertices and the
//!    point contains everything the surface contained. Alternating projections find it: the nearest
//!    point outside the triangles to a point of the hull, then the nearest point of the hull to
//!    that, and so on.
//! 2. Replace the edge.
//! 3. Move the new vertex and its neighbours as near to the hull as possible. They must keep the
//!    hull inside, but no longer the previous surface.
//! 4. The edges around them have changed. Their distances are updated when they reach the front of
//!    the queue.
//!
//! # Reference
//! Sander et al., "Silhouette clipping", 2000 (progressive hulls).
//!
//! # Deviations
//! - Sander takes the point that adds the minimum volume, by linear programming. Here, edges are
//!   ordered by distance from the *original* hull, because that distance is what is guaranteed.
//! - Exact predicates keep the surface convex. Everything that a new point sees beyond the two ends
//!   is removed as well.

use std::{cmp::Reverse, collections::BinaryHeap};

use glam::DVec3;

use super::{
    half_spaces::{HalfSpace, nearest_to_origin},
    nearest::Nearest,
    surface::Surface,
    wrap::Wrapped,
};

/// Maximum number of alternating projections. After three, distances change by less than a tenth.
const TURNS: usize = 3;

/// The projections continue only if the distance falls below this fraction of the best so far.
const WORTH_A_TURN: f64 = 0.98;

/// Maximum number of sweeps over all vertices. The third improves distances by less than a
/// hundredth.
const SWEEPS: usize = 4;

/// A vertex moves only if its distance falls below this fraction.
const WORTH_MOVING: f64 = 0.999;

/// A vertex moves only if its distance from the hull, relative to the diameter, exceeds this. Below
/// it, rounding to f32 costs more than the move gains.
const WORTH_A_MOVE: f64 = 1e-8;

/// Maximum number of times a plane turns about an edge until it touches the hull. Five are common.
const MAX_TURNS_OF_A_PLANE: usize = 100;

/// Initial margin by which a new point lies outside the triangles it replaces, relative to the
/// largest coordinate. It is several hundred units of rounding error, so that exact predicates see
/// the point outside.
const OUTSIDE: f64 = 1e-13;

/// Number of margins tried, each 100 times the previous one, before an edge is skipped.
const MAX_TRIES: u32 = 3;

/// Maximum number of triangles in the first estimate of an edge's distance. A sample of the
/// triangles can only underestimate the distance.
const FIRST_LOOK: usize = 64;

/// A convex surface around a hull, in the process of losing vertices.
pub struct Collapse<'a> {
    nearest: &'a Nearest,
    surface: Surface,
    /// A vertex of the hull near each vertex of the surface.
    feet: Vec<u32>,
    queue: BinaryHeap<Reverse<Entry>>,
    scale: f64,
    diameter: f64,
    /// A point strictly inside the hull.
    inside: DVec3,
}

/// An edge in the queue. The distance is stored as its bits, which have the same order for values
/// from 0.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    distance: u64,
    ends: [u32; 2],
    changes: u32,
    is_first_look: bool,
}

impl<'a> Collapse<'a> {
    /// Starts with a convex surface around the hull.
    pub fn new(nearest: &'a Nearest, Wrapped { surface, feet }: Wrapped, diameter: f64) -> Self {
        let scale = surface.vertices().fold(0.0, |scale: f64, (_, p)| scale.max(p.abs().max_element()));
        let mut this =
            Self { nearest, surface, feet, queue: BinaryHeap::new(), scale, diameter, inside: nearest.middle() };
        let vertices: Vec<u32> = this.surface.vertices().map(|(v, _)| v).collect();
        for v in vertices {
            let above: Vec<u32> = this.surface.around(v).map(|[b, _]| b).filter(|b| *b > v).collect();
            above.into_iter().for_each(|b| this.first_look([v, b]));
        }
        this
    }

    /// The current surface.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// Returns the surface.
    pub fn into_surface(self) -> Surface {
        self.surface
    }

    /// Replaces the edge that costs the least, and moves the vertices around it nearer to the hull.
    ///
    /// Returns false, without changes, if no edge can be replaced by a point within `reach` of the
    /// hull.
    pub fn step(&mut self, reach: f64) -> bool {
        let new = self.replace_nearest(reach);
        new.into_iter().for_each(|new| self.settle_around(new));
        new.is_some()
    }

    fn replace_nearest(&mut self, reach: f64) -> Option<u32> {
        while let Some(&Reverse(entry)) = self.queue.peek() {
            if f64::from_bits(entry.distance) > reach {
                return None;
            }
            self.queue.pop();
            let [a, b] = entry.ends;
            if !self.surface.is_there(a) || !self.surface.is_there(b) {
                continue;
            }
            let is_old = entry.changes != self.changes(entry.ends);
            if is_old && !self.surface.around(a).any(|[next, _]| next == b) {
                continue;
            }
            if is_old || entry.is_first_look {
                self.queue_edge(entry.ends, 1);
            } else if let Some(place) = self.place_outside(entry.ends)
                && place.distance <= reach
            {
                return self.replace(a, place);
            }
        }
        None
    }

    fn changes(&self, [a, b]: [u32; 2]) -> u32 {
        self.surface.changes(a).wrapping_add(self.surface.changes(b))
    }

    /// Queues an edge with the distance that every `stride`-th triangle at its ends gives.
    fn queue_edge(&mut self, ends: [u32; 2], stride: usize) {
        if let Some(place) = self.place(ends, stride, OUTSIDE * self.scale) {
            let (distance, changes) = (place.distance.to_bits(), self.changes(ends));
            self.queue.push(Reverse(Entry { distance, ends, changes, is_first_look: stride > 1 }));
        }
    }

    fn first_look(&mut self, ends: [u32; 2]) {
        let triangles: usize = ends.iter().map(|end| self.surface.around(*end).count()).sum();
        self.queue_edge(ends, triangles.div_ceil(FIRST_LOOK));
    }

    /// The point nearest to the hull that lies outside every `stride`-th triangle at the ends, by
    /// `margin`; `None` if there is no such point within one diameter.
    fn place(&self, ends: [u32; 2], stride: usize, margin: f64) -> Option<Place> {
        let corners = ends.map(|end| self.surface.point(end));
        let around = ends.into_iter().flat_map(|end| self.surface.around(end).map(move |[b, c]| [end, b, c]));
        let planes: Vec<(DVec3, DVec3)> = around
            .step_by(stride)
            .map(|triangle| (self.surface.normal(triangle), self.surface.point(triangle[0])))
            // Skip a sliver without a normal. Its neighbours have normals.
            .filter(|(normal, _)| *normal != DVec3::ZERO)
            .collect();
        let mut foot = self.nearest.from((corners[0] + corners[1]) * 0.5, self.feet[ends[0] as usize]);
        let mut best: Option<Place> = None;
        let mut half_spaces = Vec::with_capacity(planes.len());
        for _ in 0..TURNS {
            let from = foot.point;
            half_spaces.clear();
            let offset = |(normal, on): &(DVec3, DVec3)| normal.dot(*on - from) + margin;
            half_spaces.extend(planes.iter().map(|plane| HalfSpace { normal: plane.0, offset: offset(plane) }));
            let point = from + nearest_to_origin(&half_spaces, self.diameter)?;
            foot = self.nearest.from(point, foot.vertex);
            let distance = foot.point.distance(point);
            let is_better = best.is_none_or(|best| distance < best.distance);
            let is_worth = best.is_none_or(|best| distance < WORTH_A_TURN * best.distance);
            if is_better {
                best = Some(Place { point, foot: foot.vertex, distance });
            }
            if !is_worth {
                break;
            }
        }
        best
    }

    /// The same for all triangles. Exact predicates confirm that the point is outside.
    fn place_outside(&self, ends: [u32; 2]) -> Option<Place> {
        (0..MAX_TRIES).find_map(|tried| {
            let place = self.place(ends, 1, OUTSIDE * self.scale * 100_f64.powi(tried as i32))?;
            ends.iter().all(|end| self.surface.sees_all_around(place.point, *end)).then_some(place)
        })
    }

    /// Replaces the edge at `end` by `place`, and returns the index of the new vertex.
    fn replace(&mut self, end: u32, place: Place) -> Option<u32> {
        let new = self.surface.insert(place.point, self.surface.triangle_at(end))?;
        self.feet.push(place.foot);
        let rim: Vec<u32> = self.surface.around(new).map(|[b, _]| b).collect();
        rim.into_iter().for_each(|b| self.first_look([new, b]));
        Some(new)
    }

    /// Moves `vertex` and its neighbours as near to the hull as possible.
    fn settle_around(&mut self, vertex: u32) {
        let mut moved = vec![vertex];
        moved.extend(self.surface.around(vertex).map(|[b, _]| b));
        moved.retain(|v| self.settle(*v));
        let ends = |v: &u32| self.surface.around(*v).map(|[b, _]| [b.min(*v), b.max(*v)]).collect::<Vec<_>>();
        let mut edges: Vec<[u32; 2]> = moved.iter().flat_map(ends).collect();
        edges.sort_unstable();
        edges.dedup();
        edges.into_iter().for_each(|edge| self.first_look(edge));
    }

    /// Moves all vertices as near to the hull as possible, the farthest first.
    pub fn settle_all(&mut self) {
        for _ in 0..SWEEPS {
            let distance = |(v, p): (u32, DVec3)| (self.nearest.from(p, self.feet[v as usize]).point.distance(p), v);
            let mut order: Vec<(f64, u32)> = self.surface.vertices().map(distance).collect();
            order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            if !order.into_iter().fold(false, |any, (_, v)| self.settle(v) || any) {
                return;
            }
        }
    }

    /// Moves a vertex as near to the hull as possible if the surface stays convex. Returns whether
    /// it moved.
    ///
    /// The vertex must stay outside the planes that touch the hull and contain an edge opposite the
    /// vertex. The hull then lies behind the planes of all triangles at the vertex.
    fn settle(&mut self, vertex: u32) -> bool {
        let margin = OUTSIDE * self.scale;
        let at = self.surface.point(vertex);
        let mut foot = self.nearest.from(at, self.feet[vertex as usize]);
        let before = foot.point.distance(at);
        if !(before > WORTH_A_MOVE * self.diameter) {
            return false;
        }
        let touching = |[b, c]: [u32; 2]| self.touching(self.surface.point(b), self.surface.point(c), foot.vertex);
        let planes: Vec<(DVec3, DVec3)> = self.surface.around(vertex).map(touching).collect();
        let mut best = Place { point: at, foot: foot.vertex, distance: before };
        for _ in 0..TURNS {
            let from = foot.point;
            let half_space =
                |(normal, on): &(DVec3, DVec3)| HalfSpace { normal: *normal, offset: normal.dot(*on - from) + margin };
            let half_spaces: Vec<HalfSpace> = planes.iter().map(half_space).collect();
            let Some(nearest) = nearest_to_origin(&half_spaces, self.diameter) else { break };
            let point = from + nearest;
            foot = self.nearest.from(point, foot.vertex);
            let distance = foot.point.distance(point);
            if !(distance < best.distance) {
                break;
            }
            best = Place { point, foot: foot.vertex, distance };
        }
        // If the full move would make the surface concave, try parts of it. The surface contains
        // the hull at every point on the way.
        let shares = [1.0, 0.5, 0.25, 0.125];
        for to in shares.map(|share| at.lerp(best.point, share)) {
            let foot = self.nearest.from(to, best.foot);
            if foot.point.distance(to) < before * WORTH_MOVING && self.surface.try_move(vertex, to) {
                self.feet[vertex as usize] = foot.vertex;
                return true;
            }
        }
        false
    }

    /// The plane through `b` and `c` that touches the hull, with the search starting at hull vertex
    /// `start`. Returns the plane's normal, which points away from the hull, and a point on the
    /// plane.
    fn touching(&self, b: DVec3, c: DVec3, start: u32) -> (DVec3, DVec3) {
        let (mut normal, mut through, mut foot) = (DVec3::ZERO, self.inside, start);
        for _ in 0..MAX_TURNS_OF_A_PLANE {
            normal = (c - b).cross(through - b).normalize_or_zero();
            foot = self.nearest.climb(normal, foot);
            through = self.nearest.vertex(foot);
            if !(normal.dot(through - b) > OUTSIDE * self.scale) {
                return (normal, b);
            }
        }
        (normal, through)
    }
}

/// A point that may replace an edge.
#[derive(Clone, Copy)]
struct Place {
    point: DVec3,
    /// A vertex of the hull near the point.
    foot: u32,
    /// Distance of the point from the hull.
    distance: f64,
}
