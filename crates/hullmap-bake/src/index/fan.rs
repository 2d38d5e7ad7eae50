//! Fans: cones that lie side by side around a common axis, like the pages of an open book.
//!
//! The cones around a facet of many corners, along a prism's side or along the rim of a lens are long and thin. Their
//! sides lie in planes through one line. Seen along it they are intervals of an angle: a row of equal steps in its
//! tangent parts them all at once, where squares would need to be as small as a cone is thin, and planes are a
//! logarithm deep.
//!
//! 1. [`axis`]: of the lines in which planes between neighbouring cones meet, the one that most such planes hold.
//! 2. [`Fan::new`]: the interval of each cone in `t = (across·d) / (along·d)`, scaled to [0, 1).
//! 3. It is a fan if few intervals lie over one another.

use glam::DVec3;

use super::cones::{Cones, TOUCH};

/// How far a plane may miss the axis, as the sine of the angle between them.
///
/// Single-precision corners tilt the plane between two of them by 6e-8 of the size over their distance: by this for a
/// facet of 10,000 corners.
const NEAR_AXIS: f64 = 1e-3;

/// Planes must meet at this angle at least (its sine) to say where the axis is.
const LEAST_ANGLE: f64 = 1e-4;

/// Greatest tangent, on either side of the middle, that a fan spans: steps at its ends are four times as narrow, in
/// angle, as in its middle.
const WIDEST: f64 = 1.8;

/// Most intervals, on average, that may lie over one another: a fan on either side of a prism's equator, and a few
/// more. More layers than that are left to planes, which cut across them.
const LAYERS: f64 = 2.7;

/// Places in a fan: `t(d) = (across·d) / (along·d)`, in [0, 1) for all directions of its cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Across the fan, as long as its steps are fine.
    pub across: DVec3,
    /// Out from the axis, to the middle of the fan; of unit length.
    pub along: DVec3,
}

impl Frame {
    /// The frame of part `part` of 2^`bits` equal ones.
    pub fn part(self, part: usize, bits: u32) -> Self {
        Self { across: self.across * f64::from(1 << bits) - self.along * part as f64, along: self.along }
    }

    /// Normal of the plane at place `t`; greater places lie in front.
    pub fn plane(self, t: f64) -> DVec3 {
        (self.across - self.along * t).normalize()
    }
}

/// One polygon's interval.
#[derive(Clone, Copy, Debug)]
pub struct Interval {
    /// Number of the polygon.
    pub polygon: u32,
    /// Its vertex.
    pub vertex: u32,
    low: f64,
    high: f64,
}

impl Interval {
    /// Whether it reaches into the places from `start` to `end`.
    pub fn meets(&self, start: f64, end: f64) -> bool {
        if self.low < self.high {
            self.low < end && self.high > start
        } else {
            // Too small to reach over any bound: it belongs where it is.
            (start..end).contains(&self.low)
        }
    }
}

/// The cones of a cell, side by side.
pub struct Fan {
    /// Where a direction's place is.
    pub frame: Frame,
    /// The intervals, in the order of the polygons.
    pub intervals: Vec<Interval>,
    /// How many intervals lie over the middle of one, itself included, on average.
    pub layers: f64,
}

/// The line that most of the planes with these normals hold, if several do: its direction, of unit length.
pub fn axis(normals: &[DVec3]) -> Option<DVec3> {
    let mut best = (2, None);
    for stride in [normals.len() / 2, normals.len() / 3, normals.len() / 5 + 1] {
        for (i, &a) in normals.iter().enumerate() {
            let axis = a.cross(normals[(i + stride) % normals.len()]);
            if axis.length() < LEAST_ANGLE {
                continue;
            }
            let axis = axis.normalize();
            let holds = normals.iter().filter(|n| n.dot(axis).abs() < NEAR_AXIS).count();
            if holds > best.0 {
                best = (holds, Some(axis));
            }
        }
    }
    best.1
}

impl Fan {
    /// The cones of a cell on `face` as a fan around `axis`; none if they are none.
    pub fn new(face: u32, cones: &Cones, axis: DVec3) -> Option<Self> {
        let middle = cones.iter().flat_map(|(_, polygon)| polygon).map(|&p| direction(face, p)).sum::<DVec3>();
        let along = (middle - axis * middle.dot(axis)).try_normalize()?;
        let across = axis.cross(along);
        let mut intervals = Vec::with_capacity(cones.len());
        for (number, (vertex, polygon)) in cones.iter().enumerate() {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for &corner in polygon {
                let d = direction(face, corner);
                let (x, y) = (d.dot(along), d.dot(across));
                // A corner on the axis, or so near that it reaches over no plane through it.
                if x.abs().max(y.abs()) <= TOUCH {
                    continue;
                }
                if y.abs() > WIDEST * x {
                    return None;
                }
                low = low.min(y / x + TOUCH / x);
                high = high.max(y / x - TOUCH / x);
            }
            if low > high {
                // Nothing reaches over anything: a point.
                low = if low.is_finite() && high.is_finite() { 0.5 * (low + high) } else { 0.0 };
                high = low;
            }
            intervals.push(Interval { polygon: number as u32, vertex, low, high });
        }
        let start = intervals.iter().map(|i| i.low).fold(f64::INFINITY, f64::min) - TOUCH;
        let end = intervals.iter().map(|i| i.high).fold(f64::NEG_INFINITY, f64::max) + TOUCH;
        let scale = 1.0 / (end - start);
        let frame = Frame { across: (across - along * start) * scale, along };
        for interval in &mut intervals {
            interval.low = (interval.low - start) * scale;
            interval.high = (interval.high - start) * scale;
        }
        let layers = layers(&intervals);
        (scale.is_finite() && layers <= LAYERS).then_some(Self { frame, intervals, layers })
    }
}

/// How many intervals lie over the middle of one, itself included, on average.
fn layers(intervals: &[Interval]) -> f64 {
    let sorted = |of: fn(&Interval) -> f64| {
        let mut all: Vec<f64> = intervals.iter().map(of).collect();
        all.sort_unstable_by(f64::total_cmp);
        all
    };
    let (starts, ends) = (sorted(|i| i.low), sorted(|i| i.high));
    let over = |i: &Interval| {
        let middle = 0.5 * (i.low + i.high);
        starts.partition_point(|start| *start <= middle) - ends.partition_point(|end| *end < middle)
    };
    intervals.iter().map(over).sum::<usize>() as f64 / intervals.len() as f64
}

fn direction(face: u32, p: [f64; 2]) -> DVec3 {
    DVec3::from_array(hullmap_format::cube::direction(face, p[0], p[1]))
}
