//! Portal refinement along a line: a triangle of points of the set that the line pierces.
//!
//! # Reference
//! Snethen, "XenoCollide", Game Programming Gems 7. It is the simplex method of linear programming
//! as well.
//!
//! # Steps
//! 1. Discovery, seen along the line: v1 is the support point from the centre v0 towards the line,
//!    v2 the one perpendicular to v0 v1 on the line's side. Turn v1 until the line is between them.
//! 2. While the line is beyond the segment v1 v2, replace one end by the support point across it.
//!    Then the line pierces the triangle v0 v1 v2.
//! 3. Refinement: query the support point along the triangle's normal, against the line (for the
//!    entry) or along it (for the exit). It forms three triangles with the sides of the portal.
//!    Keep the one that the line pierces.
//!
//! # Deviations
//! - Coordinates are in the line's frame: x and y across the line, z along it, from the foot of the
//!   centre. So the signs of two-dimensional cross products decide.
//! - A line through an edge or a vertex of the portal, within rounding error, counts as moved a
//!   little towards a point inside the first triangle: the rule against cycling of the simplex
//!   method (perturbation).

use glam::DVec3;

use super::clip::Clip;
use crate::polygon::edge_distance;
use crate::solver::barycentric::on_triangle;
use crate::solver::minkowski::{Minkowski, Point};
use crate::support::SupportMap;
use crate::vector::unit;

/// Maximum number of steps of discovery. Most lines need 2 to 4.
const MAX_DISCOVERY_STEPS: u32 = 64;

/// A support plane this many errors beyond a portal or less is on it.
const FLAT_ERRORS: f64 = 2.0;

/// Weights of the corners in the point towards which a line on an edge is moved. They differ, so
/// that the point is on no symmetry of a symmetric triangle.
const NUDGE: [f64; 3] = [0.41, 0.33, 0.26];

/// The corner that the new one replaces. The index has a bit for each corner: whether the line is
/// on the left of the edge from the new corner to it. A table, since branches would be mispredicted
/// half of the time.
const REPLACED: [usize; 8] = [1, 2, 0, 0, 1, 2, 1, 1];

/// Maximum distance of the line from the point of the areas' weights, relative to the portal's
/// extent. The areas of a sliver are rounding error, and so are their weights.
const MAX_RESIDUAL: f64 = 1e-12;

/// Share of the radius of the ball around the centre from which the clearance that the ball proves
/// is enough.
const ROOM: f64 = 1.0 / 16.0;

/// A point of the Minkowski difference in the line's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub(super) at: DVec3,
    pub(super) point: Point,
}

/// Twice the area of the triangle of the line, `a` and `b`, seen along the line: positive if they
/// turn counter-clockwise.
#[inline(always)]
pub(super) fn turn(a: DVec3, b: DVec3) -> f64 {
    a.x * b.y - a.y * b.x
}

pub(super) fn across_sq(a: DVec3) -> f64 {
    a.x * a.x + a.y * a.y
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Portal {
    pub(super) corners: [Corner; 3],
}

/// Where the line pierces a portal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pierced {
    pub(super) weights: [f64; 3],
    pub(super) at: f64,
    pub(super) residual: f64,
}

impl Portal {
    /// Where the line pierces the portal. If it passes outside, its nearest point.
    #[inline(always)]
    pub(super) fn pierced(&self) -> Pierced {
        let [a, b, c] = self.corners.map(|corner| corner.at);
        let areas = [turn(b, c), turn(c, a), turn(a, b)];
        let sum = areas[0] + areas[1] + areas[2];
        // NaN and a portal without area take the slow path.
        let is_inside = areas[0] >= 0.0 && areas[1] >= 0.0 && areas[2] >= 0.0 && sum > 0.0;
        let blended = |weights: [f64; 3]| {
            let point = a * weights[0] + b * weights[1] + c * weights[2];
            Pierced { weights, at: point.z, residual: across_sq(point).sqrt() }
        };
        let found = blended(areas.map(|area| area / sum));
        let size_sq = across_sq(a) + across_sq(b) + across_sq(c);
        if is_inside && found.residual * found.residual <= MAX_RESIDUAL * MAX_RESIDUAL * size_sq {
            found
        } else {
            blended(nearest_weights([a, b, c]))
        }
    }

    /// Minimum distance of the line from an edge, seen along the line; negative if it passes
    /// outside.
    pub(super) fn depth(&self) -> f64 {
        let [a, b, c] = self.corners.map(|corner| corner.at.truncate());
        [(a, b), (b, c), (c, a)].into_iter().map(|(a, b)| edge_distance(a, b)).fold(f64::INFINITY, f64::min)
    }
}

/// Weights of the point of a triangle that is nearest to the line.
#[cold]
fn nearest_weights(corners: [DVec3; 3]) -> [f64; 3] {
    let [a, b, c] = corners.map(|corner| corner.with_z(0.0));
    on_triangle(a, b, c).weights
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sense {
    Entry,
    Exit,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    /// A plane proves that the line misses the set.
    Missed,
    /// The portal is beyond the line's origin for certain.
    Passed,
    /// The portal is on the surface, within rounding error.
    OnSurface,
    Narrow,
    Limit,
}

/// Search for the entry or exit of a line, with what is known so far.
pub(super) struct LineSearch<'m, 's, A: ?Sized, B: ?Sized> {
    pub(super) m: &'m mut Minkowski<'s, A, B>,
    pub(super) clip: Clip,
    across: [DVec3; 2],
    pub(super) steps: u32,
}

impl<'m, 's, A: SupportMap + ?Sized, B: SupportMap + ?Sized> LineSearch<'m, 's, A, B> {
    pub(super) fn new(m: &'m mut Minkowski<'s, A, B>, clip: Clip) -> Self {
        let across = clip.across();
        Self { m, clip, across, steps: 0 }
    }

    #[inline(always)]
    fn corner(&self, point: Point) -> Corner {
        let offset = point.w - self.clip.foot;
        let [x, y] = self.across;
        Corner { at: DVec3::new(offset.dot(x), offset.dot(y), offset.dot(self.clip.direction)), point }
    }

    /// Support point in a direction of the line's frame. Its plane clips the line.
    #[inline]
    pub(super) fn probe(&mut self, n: DVec3) -> Corner {
        self.steps += 1;
        let [x, y] = self.across;
        let n = x * n.x + y * n.y + self.clip.direction * n.z;
        let point = self.m.point(n);
        self.clip.cut(n, point.w);
        self.corner(point)
    }

    /// Steps 1 and 2: a triangle of the centre, its first corner, and two support points, which the
    /// line pierces, or grazes within rounding error. `None` if a plane proves that the line misses
    /// the set.
    pub(super) fn discover(&mut self) -> Option<Portal> {
        let mut v0 = self.corner(self.m.center_point());
        let short_sq = self.clip.error * self.clip.error;
        // From the centre to the line. If the centre is on it, any direction serves.
        let towards = if across_sq(v0.at) > short_sq { -v0.at.with_z(0.0) } else { DVec3::X };
        let mut v1 = self.probe(towards);
        if self.clip.is_empty() {
            return None;
        }
        if turn(v0.at, v1.at) < 0.0 {
            // Mirror the frame, so that the line is on the left of v0 v1.
            self.across[0] = -self.across[0];
            (v0.at.x, v1.at.x) = (-v0.at.x, -v1.at.x);
        }
        let mut v2 = v1;
        for _ in 0..MAX_DISCOVERY_STEPS {
            let edge = v1.at - v0.at;
            // Seen along the line, v1 may be the centre: the set has no extent that way.
            let edge = if across_sq(edge) > short_sq { edge } else { towards };
            v2 = self.probe(DVec3::new(-edge.y, edge.x, 0.0));
            if self.clip.is_empty() {
                return None;
            }
            // The line is on the left of v0 v2 as well, and v2 on the left of v0 v1.
            let is_beyond = turn(v0.at, v2.at) > 0.0 && turn(edge, v2.at - v0.at) > 0.0;
            if !is_beyond {
                break;
            }
            v1 = v2;
        }
        for _ in 0..MAX_DISCOVERY_STEPS {
            if turn(v1.at, v2.at) >= 0.0 {
                break;
            }
            let edge = v2.at - v1.at;
            let n = DVec3::new(edge.y, -edge.x, 0.0);
            let v3 = self.probe(n);
            if self.clip.is_empty() {
                return None;
            }
            // NaN counts as no gain. The line then grazes the set.
            let gain = n.dot(v3.at - v1.at);
            if !(gain > FLAT_ERRORS * self.clip.error * n.length()) {
                break;
            }
            if turn(v0.at, v3.at) >= 0.0 {
                v1 = v3;
            } else {
                v2 = v3;
            }
        }
        Some(Portal { corners: [v0, v1, v2] })
    }

    /// Lower bound of the distance of the line from the border of the set, seen along the line,
    /// from the first triangle and the ball around the centre. Negative if the line may miss.
    pub(super) fn first_clearance(&self, start: &Portal, pierced: &Pierced) -> f64 {
        let radius = self.m.inner_radius();
        let by_ball = radius - across_sq(start.corners[0].at).sqrt() - self.clip.noise;
        if by_ball > ROOM * radius {
            return by_ball;
        }
        // The triangle with a ball around its first corner: its part at the line has a radius
        // proportional to that corner's weight.
        let by_weight = radius * pierced.weights[0] - pierced.residual;
        by_ball.max(by_weight.max(start.depth()) - self.clip.noise)
    }

    /// Upper bound of the error of the parameter at which the line pierces a triangle.
    ///
    /// The corners have errors, so the line is within `residual` and the noise of a point of the
    /// set. If it passes at `clearance` inside the border, it is in the set itself a little farther
    /// on. Infinite if the clearance is not positive.
    pub(super) fn error(&self, residual: f64, clearance: f64) -> f64 {
        let off = residual + self.clip.noise;
        // NaN takes the failing branch.
        if clearance > 0.0 { off + off / (off + clearance) * 2.0 * self.clip.reach } else { f64::INFINITY }
    }

    /// The error for a portal that the line pierces inside its edges by more than the corners'
    /// errors: then the slope of the portal bounds the error. Infinite otherwise.
    pub(super) fn error_in(&self, portal: &Portal, pierced: &Pierced) -> f64 {
        let [a, b, c] = portal.corners.map(|corner| corner.at);
        let n = (b - a).cross(c - a);
        let off = pierced.residual + self.clip.noise;
        // NaN takes the failing branch.
        if portal.depth() > off { off * (1.0 + n.length() / n.z) } else { f64::INFINITY }
    }

    /// Step 3: moves the portal to the surface, on the side of the entry or of the exit.
    ///
    /// It ends early if the portal is certainly beyond the line's origin, given the clearance.
    pub(super) fn refine(&mut self, portal: &mut Portal, sense: Sense, clearance: f64, terms: (f64, u32)) -> End {
        let (gap, limit) = terms;
        let nudge = (0..3).fold(DVec3::ZERO, |sum, i| sum + portal.corners[i].at * NUDGE[i]);
        let sign = if sense == Sense::Entry { -1.0 } else { 1.0 };
        loop {
            let [a, b, c] = portal.corners.map(|corner| corner.at);
            let normal = (b - a).cross(c - a);
            // Where the line crosses the plane of the portal: near a sliver, a rough value.
            let at = normal.dot(a) / normal.z;
            if sign * (at - self.clip.origin) > 0.0 {
                let Pierced { at, residual, .. } = portal.pierced();
                if sign * (at - self.clip.origin) >= self.error(residual, clearance) {
                    return End::Passed;
                }
            }
            if self.steps >= limit {
                return End::Limit;
            }
            let n = normal * sign;
            let new = self.probe(n);
            if self.clip.is_empty() {
                return End::Missed;
            }
            // Compared by squares. NaN counts as the surface, since no point is known to be farther
            // out.
            let (gain, flat) = (n.dot(new.at - a), FLAT_ERRORS * self.clip.error);
            if !(gain > 0.0 && gain * gain > flat * flat * n.length_squared()) {
                if sense == Sense::Entry {
                    self.keep_face(n, new.at);
                }
                return End::OnSurface;
            }
            // The plane may be behind the line's origin: then the origin may be inside, and the
            // search continues.
            let open = if sense == Sense::Entry { at - self.clip.entry } else { self.clip.upper - at };
            if open <= gap {
                return End::Narrow;
            }
            let [on_a, on_b, on_c] = [a, b, c].map(|corner| self.is_left(new.at, corner, nudge));
            let sides = usize::from(on_a) | usize::from(on_b) << 1 | usize::from(on_c) << 2;
            portal.corners[REPLACED[sides]] = new;
        }
    }

    /// Keeps the normal `n` of the plane of the last portal, through `at`, if no point of the line
    /// before the entry is behind this plane. At an edge, another plane may have the same entry.
    fn keep_face(&mut self, n: DVec3, at: DVec3) {
        let depth = n.dot(at) - n.z * self.clip.entry;
        // NaN takes the failing branch.
        if n.z < 0.0 && depth <= 0.0 {
            let [x, y] = self.across;
            self.clip.normal = unit(x * n.x + y * n.y + self.clip.direction * n.z).unwrap_or(self.clip.normal);
        }
    }

    /// Whether the line is on the left of the edge from `a` to `b`. If it is on the edge, within
    /// rounding error, the side of `nudge` decides.
    #[inline(always)]
    fn is_left(&self, a: DVec3, b: DVec3, nudge: DVec3) -> bool {
        let area = turn(a, b);
        let error = self.clip.noise * (a.x.abs() + a.y.abs() + b.x.abs() + b.y.abs());
        if area.abs() > error { area > 0.0 } else { turn(b - a, nudge) > 0.0 }
    }
}
