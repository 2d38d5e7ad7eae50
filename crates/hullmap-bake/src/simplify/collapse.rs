//! Edge collapse (progressive hulls): removes vertices of a convex surface around a hull, one edge
//! at a time, without cutting into the hull.
//!
//! # Steps
//! 1. Take the edge whose replacement by a point outside all triangles at its ends, so that the
//!    convex hull of the other vertices and the point contains the surface, is nearest to the hull.
//!    Alternating projections find the point: from the hull to the nearest point outside the
//!    triangles, back to the hull, and so on.
//! 2. Replace the edge.
//! 3. Move the new vertex and its neighbours as near to the hull as possible. They must keep the
//!    hull inside, but no longer the previous surface.
//! 4. Queue the changed edges with lower bounds of their distances, which are computed when they
//!    reach the front. By then, most of these edges are gone.
//!
//! # Reference
//! Sander et al., "Silhouette clipping", 2000 (progressive hulls).
//!
//! # Deviations
//! - Sander takes the point that adds the minimum volume, by linear programming. Here, edges are
//!   ordered by distance from the *original* hull, because that distance is what is guaranteed.
//! - Exact predicates keep the surface convex. Everything that a new point sees beyond the two ends
//!   is removed as well.

use std::{
    cmp::Reverse,
    collections::{BinaryHeap, HashMap},
};

use glam::DVec3;
use rayon::prelude::*;

use super::{nearest::Nearest, surface::Surface, wrap::Wrapped};
use hullmap_geometry::planes::HalfSpace;
use hullmap_geometry::quadratic_program::{nearest_to_origin, nearest_with_planes};

/// Maximum number of alternating projections. After three, distances change by less than a tenth.
const TURNS: usize = 3;

/// The projections continue only if the distance falls below this fraction of the best so far.
const WORTH_A_TURN: f64 = 0.98;

/// Maximum number of sweeps over all vertices. The third improves distances by under a hundredth.
const SWEEPS: usize = 4;

/// A vertex moves only if its distance falls below this fraction.
const WORTH_MOVING: f64 = 0.999;

/// A vertex moves only if its distance from the hull, relative to the diameter, exceeds this. Below
/// it, rounding to f32 costs more than the move gains.
const WORTH_A_MOVE: f64 = 1e-8;

/// Maximum number of times a plane turns about an edge until it touches the hull. Seven are common.
const MAX_TURNS_OF_A_PLANE: usize = 100;

/// Maximum number of turns from a nearly touched vertex; two are common.
const FEW_TURNS: usize = 16;

/// Minimum distance of a touched vertex from the edge, relative to the largest such distance, for
/// the plane to be certain: see [`Collapse::touching_from`].
const LEAST_LEVER: f64 = 0.003;

/// Height that is far more than rounding error, relative to the largest coordinate.
const CLEAR: f64 = 1e-11;

/// Maximum number of edges with lower bounds. Each takes about 700 bytes.
const MAX_PENDING: usize = 1 << 15;

/// Depths inside the hull from which bounds of distances are searched for, relative to the
/// diameter. The best is the radius of the hull's curvature.
const DEPTHS: [f64; 4] = [0.5, 0.12, 0.03, 0.008];

/// Depth below a plane of a point that counts as outside, relative to the diameter: several times
/// the tolerance of [`nearest_to_origin`].
const INSIDE_A_PLANE: f64 = 1e-9;

/// Initial distance of a new point outside the triangles it replaces, relative to the largest
/// coordinate: several hundred roundings, so that exact predicates agree.
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
    feet: Vec<u32>,
    queue: BinaryHeap<Reverse<Entry>>,
    /// Edges whose distances are not known yet, by the indices in their entries.
    pending: HashMap<u32, Pending>,
    max_pending: usize,
    next_pending: u32,
    /// Number of edges queued since the pending ones were last cleared of edges that are gone.
    queued: usize,
    scale: f64,
    diameter: f64,
    inside: DVec3,
}

/// An edge in the queue. The distance is stored as its bits, which have the same order for values
/// from 0. A bound comes before an equal distance.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    distance: u64,
    /// Whether the distance is not a lower bound.
    is_known: bool,
    ends: [u32; 2],
    changes: u32,
    is_first_look: bool,
    /// Index of a pending edge; 0 if the distance is known.
    pending: u32,
}

/// Copy of what determines an edge's distance: the surface may change before it is computed.
struct Pending {
    planes: Vec<(DVec3, DVec3)>,
    middle: DVec3,
    foot: u32,
    ends: [u32; 2],
    changes: u32,
    is_first_look: bool,
}

impl<'a> Collapse<'a> {
    /// Starts with a convex surface around the hull.
    pub fn new(nearest: &'a Nearest, wrapped: Wrapped, diameter: f64) -> Self {
        Self::with_pending(nearest, wrapped, diameter, MAX_PENDING)
    }

    /// As [`Self::new`], with another maximum number of edges with bounds, which changes no result.
    fn with_pending(
        nearest: &'a Nearest,
        Wrapped { surface, feet }: Wrapped,
        diameter: f64,
        max_pending: usize,
    ) -> Self {
        let scale = surface.vertices().fold(0.0, |scale: f64, (_, p)| scale.max(p.abs().max_element()));
        let mut this = Self {
            nearest,
            surface,
            feet,
            queue: BinaryHeap::new(),
            pending: HashMap::new(),
            max_pending,
            next_pending: 0,
            queued: 0,
            scale,
            diameter,
            inside: nearest.middle(),
        };
        let edges =
            |(v, _): (u32, DVec3)| this.surface.around(v).filter(move |[b, _]| *b > v).map(move |[b, _]| [v, b]);
        let edges: Vec<[u32; 2]> = this.surface.vertices().flat_map(edges).collect();
        if edges.len() <= max_pending {
            this.queue_first_looks(edges);
        } else {
            let look = |ends| this.entry(&this.first_look(ends)).map(Reverse);
            let entries: Vec<Reverse<Entry>> = edges.into_par_iter().filter_map(look).collect();
            this.queue = BinaryHeap::from(entries);
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
    /// Returns false, without changes, if no edge can be replaced within `reach` of the hull.
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
            if !entry.is_known {
                let pending = self.pending.remove(&entry.pending);
                self.queue.extend(pending.and_then(|pending| self.entry(&pending)).map(Reverse));
            } else if is_old || entry.is_first_look {
                self.queue.extend(self.entry(&self.edge(entry.ends, 1)).map(Reverse));
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

    /// An edge with the distance that some triangles at its ends give.
    fn entry(&self, edge: &Pending) -> Option<Entry> {
        let distance = self.place(edge, OUTSIDE * self.scale)?.distance.to_bits();
        let Pending { ends, changes, is_first_look, .. } = *edge;
        Some(Entry { distance, is_known: true, ends, changes, is_first_look, pending: 0 })
    }

    fn edge(&self, ends: [u32; 2], stride: usize) -> Pending {
        let corners = ends.map(|end| self.surface.point(end));
        let around = ends
            .into_iter()
            .zip(corners)
            .flat_map(|(end, corner)| self.surface.normals_around(end).map(move |normal| (normal, corner)));
        Pending {
            planes: around.step_by(stride).filter(|(normal, _)| *normal != DVec3::ZERO).collect(),
            middle: (corners[0] + corners[1]) * 0.5,
            foot: self.feet[ends[0] as usize],
            ends,
            changes: self.changes(ends),
            is_first_look: stride > 1,
        }
    }

    fn first_look(&self, ends: [u32; 2]) -> Pending {
        let triangles: usize = ends.iter().map(|end| self.surface.around(*end).count()).sum();
        self.edge(ends, triangles.div_ceil(FIRST_LOOK))
    }

    /// Queues edges with the first estimates of their distances, or with bounds of these.
    fn queue_first_looks(&mut self, edges: impl IntoIterator<Item = [u32; 2]>) {
        for ends in edges {
            let edge = self.first_look(ends);
            match self.bound(&edge) {
                Some(bound) if self.has_room() => {
                    self.next_pending += 1;
                    let Pending { ends, changes, is_first_look, .. } = edge;
                    let (distance, pending) = (bound.to_bits(), self.next_pending);
                    self.queue.push(Reverse(Entry {
                        distance,
                        is_known: false,
                        ends,
                        changes,
                        is_first_look,
                        pending,
                    }));
                    self.pending.insert(pending, edge);
                }
                _ => self.queue.extend(self.entry(&edge).map(Reverse)),
            }
        }
    }

    /// Whether another edge may be pending. Now and then removes edges that are gone for good.
    fn has_room(&mut self) -> bool {
        self.queued += 1;
        if self.pending.len() >= self.max_pending && self.queued >= self.max_pending / 2 {
            self.queued = 0;
            let surface = &self.surface;
            self.pending.retain(|_, edge| {
                let [a, b] = edge.ends;
                surface.is_there(a) && surface.is_there(b) && surface.around(a).any(|[next, _]| next == b)
            });
        }
        self.pending.len() < self.max_pending
    }

    /// A lower bound of the distance that [`place`](Self::place) finds, if there is a good one.
    ///
    /// A point p outside of planes with unit normals n and offsets o satisfies n·p ≥ o. For any
    /// weights w ≥ 0 and v = Σ w n, it satisfies v·p ≥ Σ w o. Every point h of the hull satisfies
    /// v·h ≤ s, the hull's height along v. So p and h are at least (Σ w o − s) / |v| apart. The
    /// best weights belong to the nearest point outside of the planes.
    fn bound(&self, edge: &Pending) -> Option<f64> {
        let inside = INSIDE_A_PLANE * self.diameter + CLEAR * self.scale;
        let mut along: DVec3 = edge.planes.iter().map(|(normal, _)| *normal).sum();
        let mut support = self.nearest.vertex(self.nearest.certain_climb(along)?.0);
        let mut best = None;
        let mut half_spaces = Vec::with_capacity(edge.planes.len());
        for depth in DEPTHS {
            let from = support - along.normalize_or_zero() * depth * self.diameter;
            half_spaces.clear();
            let offset = |(normal, on): &(DVec3, DVec3)| normal.dot(*on - from);
            half_spaces.extend(edge.planes.iter().map(|plane| HalfSpace { normal: plane.0, offset: offset(plane) }));
            let Some(nearest) = nearest_with_planes(&half_spaces, f64::INFINITY) else { break };
            let mut offsets = 0.0;
            along = DVec3::ZERO;
            for (plane, weight) in nearest.weighted() {
                along += plane.normal * weight;
                offsets += weight * (plane.offset - inside);
            }
            let Some((highest, _)) = self.nearest.certain_climb(along) else { break };
            support = self.nearest.vertex(highest);
            let apart = (offsets - along.dot(support - from)) / along.length() - CLEAR * self.scale;
            // Written so that NaN is no bound.
            if apart > best.unwrap_or(0.0) {
                best = Some(apart);
            }
        }
        best
    }

    /// The point nearest to the hull that lies outside the triangles at an edge, by `margin`;
    /// `None` if there is no such point within one diameter.
    fn place(&self, edge: &Pending, margin: f64) -> Option<Place> {
        let planes = &edge.planes;
        let mut foot = self.nearest.nearest_from(edge.middle, edge.foot);
        let mut best: Option<Place> = None;
        let mut half_spaces = Vec::with_capacity(planes.len());
        for _ in 0..TURNS {
            let from = foot.point;
            half_spaces.clear();
            let offset = |(normal, on): &(DVec3, DVec3)| normal.dot(*on - from) + margin;
            half_spaces.extend(planes.iter().map(|plane| HalfSpace { normal: plane.0, offset: offset(plane) }));
            let point = from + nearest_to_origin(&half_spaces, self.diameter)?;
            foot = self.nearest.nearest_from(point, foot.vertex);
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

    /// As [`Self::place`], confirmed by exact predicates.
    fn place_outside(&self, ends: [u32; 2]) -> Option<Place> {
        let edge = self.edge(ends, 1);
        (0..MAX_TRIES).find_map(|tried| {
            let place = self.place(&edge, OUTSIDE * self.scale * 100_f64.powi(tried as i32))?;
            ends.iter().all(|end| self.surface.sees_all_around(place.point, *end)).then_some(place)
        })
    }

    fn replace(&mut self, end: u32, place: Place) -> Option<u32> {
        let new = self.surface.insert(place.point, self.surface.triangle_at(end))?;
        self.feet.push(place.foot);
        let horizon: Vec<u32> = self.surface.around(new).map(|[b, _]| b).collect();
        self.queue_first_looks(horizon.into_iter().map(|b| [new, b]));
        Some(new)
    }

    fn settle_around(&mut self, vertex: u32) {
        let mut moved = vec![vertex];
        moved.extend(self.surface.around(vertex).map(|[b, _]| b));
        moved.retain(|v| self.settle(*v));
        let ends = |v: &u32| self.surface.around(*v).map(|[b, _]| [b.min(*v), b.max(*v)]).collect::<Vec<_>>();
        let mut edges: Vec<[u32; 2]> = moved.iter().flat_map(ends).collect();
        edges.sort_unstable();
        edges.dedup();
        self.queue_first_looks(edges);
    }

    /// Moves all vertices as near to the hull as possible, the farthest first.
    pub fn settle_all(&mut self) {
        for _ in 0..SWEEPS {
            let distance =
                |(v, p): (u32, DVec3)| (self.nearest.nearest_from(p, self.feet[v as usize]).point.distance(p), v);
            let mut order: Vec<(f64, u32)> = self.surface.vertices().map(distance).collect();
            order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            if !order.into_iter().fold(false, |any, (_, v)| self.settle(v) || any) {
                return;
            }
        }
    }

    /// Moves a vertex as near to the hull as possible if the surface stays convex, and returns
    /// whether it moved. It must stay outside the planes that touch the hull at the edges opposite
    /// it, so that the hull lies behind all its triangles.
    fn settle(&mut self, vertex: u32) -> bool {
        let margin = OUTSIDE * self.scale;
        let at = self.surface.point(vertex);
        let mut foot = self.nearest.nearest_from(at, self.feet[vertex as usize]);
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
            foot = self.nearest.nearest_from(point, foot.vertex);
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
            let foot = self.nearest.nearest_from(to, best.foot);
            if foot.point.distance(to) < before * WORTH_MOVING && self.surface.try_move(vertex, to) {
                self.feet[vertex as usize] = foot.vertex;
                return true;
            }
        }
        false
    }

    /// The plane through `b` and `c` that touches the hull, searched for from hull vertex `start`:
    /// its normal, away from the hull, and a point.
    fn touching(&self, b: DVec3, c: DVec3, start: u32) -> (DVec3, DVec3) {
        self.touching_from(b, c, start).unwrap_or_else(|| self.touching_from_inside(b, c, start))
    }

    fn touching_from_inside(&self, b: DVec3, c: DVec3, start: u32) -> (DVec3, DVec3) {
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

    /// The touching plane from vertex `start` of the hull, in fewer turns; `None` unless both
    /// certainly find the same plane, which depends only on the last vertex touched. Let r be a
    /// vertex' distance from the line through b and c, R the maximum r, and φ the angle by which
    /// the plane has to turn to the touched vertex v. All other vertices are below the plane by at
    /// least the gap D.
    ///
    /// - No other plane is the end. A plane through another vertex has φ ≥ D / R, so v is above it
    ///   by at least r D / R. That must be far above all tolerances.
    /// - The turns from the middle end there. Each turns the plane to the highest vertex w, with
    ///   r(w) sin(turn) ≥ r(v) sin(φ). So φ falls by a factor of 1 − 2 r / (π R) or less, and after
    ///   at most π R / (2 r) · ln(π R / D) turns, no other vertex is above the plane. That bound is
    ///   far above the turns that are common, and above [`MAX_TURNS_OF_A_PLANE`]. Should the turns
    ///   from the middle ever be given up, this plane is the better one.
    fn touching_from(&self, b: DVec3, c: DVec3, start: u32) -> Option<(DVec3, DVec3)> {
        let mut vertex = start;
        for _ in 0..FEW_TURNS {
            let through = self.nearest.vertex(vertex);
            let normal = (c - b).cross(through - b).normalize_or_zero();
            let (next, gap) = self.nearest.certain_climb(normal)?;
            if next == vertex {
                let lever = (through - b).cross((c - b).normalize_or_zero()).length();
                let longest = (through - b).length() + self.diameter;
                let margin = CLEAR * self.scale + 10.0 * self.nearest.climbing_error();
                // Written so that NaN is not certain.
                let is_certain = lever > LEAST_LEVER * longest && lever * gap > margin * longest;
                return is_certain.then_some((normal, b));
            }
            vertex = next;
        }
        None
    }
}

#[derive(Clone, Copy)]
struct Place {
    point: DVec3,
    foot: u32,
    distance: f64,
}

#[cfg(test)]
mod tests {
    use shapes::families::Family;

    use super::*;
    use crate::{hull::Hull, simplify::wrap::wrap, test_meshes::hull_of};

    const FAMILIES: [Family; 6] =
        [Family::Sphere, Family::Rock, Family::Lens, Family::Needle, Family::Cone, Family::CubeGrid];

    fn start(hull: &Hull, nearest: &Nearest, max_vertices: usize) -> Wrapped {
        let wrapped = (1..12)
            .find_map(|step| wrap(nearest, hull.diameter, hull.diameter * 1e-4 * 3_f64.powi(step), max_vertices));
        let feet = (0..hull.vertices.len() as u32).collect();
        wrapped.unwrap_or_else(|| Wrapped { surface: Surface::new(hull), feet })
    }

    fn edges(collapse: &Collapse) -> Vec<[u32; 2]> {
        let edges = |(v, _): (u32, DVec3)| collapse.surface.around(v).map(move |[b, _]| [v, b]);
        collapse.surface.vertices().flat_map(edges).collect()
    }

    #[test]
    fn bounds_are_below_distances() {
        let (mut all, mut good) = (0, 0);
        for family in FAMILIES {
            let hull = hull_of(family.points(1_200, 2));
            let nearest = Nearest::new(&hull);
            for max_vertices in [40, 200] {
                let mut collapse = Collapse::new(&nearest, start(&hull, &nearest, max_vertices), hull.diameter);
                for _ in 0..4 {
                    for ends in edges(&collapse) {
                        let edge = collapse.first_look(ends);
                        let (bound, place) = (collapse.bound(&edge), collapse.place(&edge, OUTSIDE * collapse.scale));
                        let (Some(bound), Some(place)) = (bound, place) else { continue };
                        assert!(bound <= place.distance, "{family:?} {ends:?}: {bound} {}", place.distance);
                        all += 1;
                        good += usize::from(bound > 0.8 * place.distance);
                    }
                    (0..7).for_each(|_| {
                        collapse.step(f64::INFINITY);
                    });
                }
            }
        }
        println!("{good} of {all} bounds are near the distance");
        assert!(good > 2_000, "{good} of {all}");
    }

    #[test]
    fn pending_edges_change_nothing() {
        for family in FAMILIES {
            let hull = hull_of(family.points(1_200, 2));
            let nearest = Nearest::new(&hull);
            let collapsed = |max_pending: usize| -> Vec<(u32, [u64; 3])> {
                let start = start(&hull, &nearest, 300);
                let mut collapse = Collapse::with_pending(&nearest, start, hull.diameter, max_pending);
                while collapse.surface().vertex_count() > 20 && collapse.step(f64::INFINITY) {}
                collapse.settle_all();
                collapse.surface.vertices().map(|(v, p)| (v, p.to_array().map(f64::to_bits))).collect()
            };
            let eager = collapsed(0);
            for max_pending in [1, 30, 1_000, MAX_PENDING] {
                assert_eq!(collapsed(max_pending), eager, "{family:?} {max_pending}");
            }
        }
    }

    #[test]
    fn planes_touch_where_slow_ones_do() {
        let (mut all, mut certain) = (0, 0);
        for family in FAMILIES {
            let hull = hull_of(family.points(1_200, 2));
            let nearest = Nearest::new(&hull);
            for max_vertices in [8, 40, 200] {
                let collapse = Collapse::new(&nearest, start(&hull, &nearest, max_vertices), hull.diameter);
                for (v, _) in collapse.surface.vertices() {
                    for [b, c] in collapse.surface.around(v) {
                        let [b, c] = [b, c].map(|v| collapse.surface.point(v));
                        for start in [collapse.feet[v as usize], 0] {
                            all += 1;
                            let Some(found) = collapse.touching_from(b, c, start) else { continue };
                            let slow = collapse.touching_from_inside(b, c, start);
                            let bits = |(n, p): (DVec3, DVec3)| [n, p].map(|v| v.to_array().map(f64::to_bits));
                            assert_eq!(bits(found), bits(slow), "{family:?} {max_vertices}");
                            certain += 1;
                        }
                    }
                }
            }
        }
        println!("{certain} of {all} planes were certain");
        assert!(certain > 2_000, "{certain} of {all}");
    }
}
