//! Fewer vertices around a convex hull, one edge at a time, without ever cutting into it.
//!
//! # Steps
//! 1. An edge is replaced by the point outside of all triangles at both of its ends that is nearest to the hull: with it the
//!    convex hull of the rest holds all that it held before. It is found by turns: the nearest point outside of the triangles to
//!    a point of the hull, the nearest point of the hull to that, and so on.
//! 2. All around is moved nearer to the hull, as far as that allows: it has to hold the hull alone, no longer the surface of before.
//! 3. The edge whose point lies nearest to the hull goes first. Around it edges change; they are looked at again when their turn
//!    comes.
//!
//! # Reference
//! Sander et al., "Silhouette clipping", 2000 (progressive hulls).
//!
//! # Deviations
//! - Sander takes the point that adds the least volume, by linear programming; here it is the distance to the *original* hull that
//!   is promised, so that is what the order is by.
//! - The surface stays convex, by exact predicates: what a new point sees beyond the two ends goes, too.

use std::{cmp::Reverse, collections::BinaryHeap};

use glam::DVec3;

use super::{
    half_spaces::{HalfSpace, nearest_to_origin},
    nearest::Nearest,
    surface::Surface,
    wrap::Wrapped,
};

/// Turns between the triangles' outside and the hull: distances change by less than a tenth after three.
const TURNS: usize = 3;

/// By how much less a turn's distance must be for another turn.
const WORTH_A_TURN: f64 = 0.98;

/// Sweeps over all vertices: the third brings less than a hundredth.
const SWEEPS: usize = 4;

/// By how much less a move must make a distance.
const WORTH_MOVING: f64 = 0.999;

/// Distance from the hull, over its diameter, below which vertices stay: less than rounding to f32 will cost.
const WORTH_A_MOVE: f64 = 1e-8;

/// Turns of a plane about an edge until it touches the hull; five are common.
const MAX_TURNS_OF_A_PLANE: usize = 100;

/// By how much of the greatest coordinate a new point lies outside of the triangles it replaces, at first: some hundred units of
/// rounding, so that exact predicates see it there.
const OUTSIDE: f64 = 1e-13;

/// How often that is made a hundred times as much before an edge is left.
const MAX_TRIES: u32 = 3;

/// Triangles at an edge of which a first look takes some only: what it finds is too near, never too far.
const FIRST_LOOK: usize = 64;

/// A surface around a hull, on its way to fewer vertices.
pub struct Collapse<'a> {
    nearest: &'a Nearest,
    surface: Surface,
    /// A vertex of the hull near each vertex of the surface.
    feet: Vec<u32>,
    queue: BinaryHeap<Reverse<Entry>>,
    scale: f64,
    diameter: f64,
    /// A point strictly inside of the hull.
    inside: DVec3,
}

/// An edge in the queue: distance, by its bits, which order as numbers from 0 on do.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    distance: u64,
    ends: [u32; 2],
    changes: u32,
    is_first_look: bool,
}

impl<'a> Collapse<'a> {
    /// Starts with a surface around the hull.
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

    /// The surface as it is now.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// The surface.
    pub fn into_surface(self) -> Surface {
        self.surface
    }

    /// Replaces the edge that costs least, and moves what is around it nearer to the hull. False, and nothing changes, where none
    /// can be replaced by a point within `reach` of the hull.
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

    /// Queues an edge by every `stride`-th of its triangles.
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

    /// The point outside of every `stride`-th triangle at the ends, by `margin`, that is nearest to the hull; `None` where there is
    /// none within a diameter.
    fn place(&self, ends: [u32; 2], stride: usize, margin: f64) -> Option<Place> {
        let corners = ends.map(|end| self.surface.point(end));
        let around = ends.into_iter().flat_map(|end| self.surface.around(end).map(move |[b, c]| [end, b, c]));
        let planes: Vec<(DVec3, DVec3)> = around
            .step_by(stride)
            .map(|triangle| (self.surface.normal(triangle), self.surface.point(triangle[0])))
            // A sliver without one is next to others that have one.
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

    /// The same of all triangles, seen by exact predicates to be outside.
    fn place_outside(&self, ends: [u32; 2]) -> Option<Place> {
        (0..MAX_TRIES).find_map(|tried| {
            let place = self.place(ends, 1, OUTSIDE * self.scale * 100_f64.powi(tried as i32))?;
            ends.iter().all(|end| self.surface.sees_all_around(place.point, *end)).then_some(place)
        })
    }

    /// Puts `place` for the edge of `end`; returns the number of the new vertex.
    fn replace(&mut self, end: u32, place: Place) -> Option<u32> {
        let new = self.surface.insert(place.point, self.surface.triangle_at(end))?;
        self.feet.push(place.foot);
        let rim: Vec<u32> = self.surface.around(new).map(|[b, _]| b).collect();
        rim.into_iter().for_each(|b| self.first_look([new, b]));
        Some(new)
    }

    /// Moves the vertices at the edges of `vertex`, and it itself, as near to the hull as they may be.
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

    /// Moves all vertices as near to the hull as they may be, the farthest first.
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

    /// Moves a vertex as near to the hull as the hull itself lets it, if the surface stays convex. False where it stays.
    ///
    /// The planes through the edges around it that touch the hull are what it must stay outside of: then the hull is behind the
    /// planes of all triangles at it.
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
        // Where the whole way would bend the surface inward, a part of it may not: all places on it hold the hull.
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

    /// The plane through b and c that touches the hull where the vertex is that b and c are around: its normal, away from the hull,
    /// and a point on it.
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

/// Where an edge may go.
#[derive(Clone, Copy)]
struct Place {
    point: DVec3,
    /// A vertex of the hull near it.
    foot: u32,
    /// From the hull.
    distance: f64,
}
