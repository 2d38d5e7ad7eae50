//! EPA seed: a first tetrahedron for the expanding polytope, or the proof that the difference is
//! flat.
//!
//! Portal discovery and refinement may leave no tetrahedron with a volume: for flat shapes,
//! coplanar polygons, or interior points on the boundary. Then this search finds one along
//! directions of its own, and thereby determines the rank of the Minkowski difference.
//!
//! # Steps
//! 1. Query support points both ways along the three axes. Keep the two that are farthest from each
//!    other.
//! 2. Of these six, and of four more perpendicular to the line of the two, keep the point farthest
//!    from the line.
//! 3. Query both ways along the normal of the triangle. Keep the point farther from it.
//! 4. If the length, the height or the thickness is within rounding error, the rank is 0, 1 or 2:
//!    flat.

use crate::solver::minkowski::{Minkowski, Point};
use crate::support::SupportMap;
use crate::vector::{perpendicular, unit};
use glam::DVec3;

/// A thickness up to this many rounding errors counts as zero: the errors of two support points on
/// either side, and the error of the normal.
const FLAT_ROUNDINGS: f64 = 8.0;

/// The Minkowski difference has no thickness along this unit normal.
#[derive(Clone, Copy, Debug)]
pub(in crate::solver) struct Flat {
    pub(in crate::solver) normal: DVec3,
}

/// Finds a tetrahedron of support points. At most 12 support calls.
pub(in crate::solver) fn seed<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
) -> Result<[Point; 4], Flat> {
    let thin = FLAT_ROUNDINGS * m.rounding_error();
    let mut seen = [Point::EMPTY; 10];
    for (i, dir) in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z].into_iter().enumerate() {
        seen[i] = m.point(dir);
    }
    let mut pair = (seen[0], seen[1]);
    for i in 0..6 {
        for j in i + 1..6 {
            if seen[i].w.distance_squared(seen[j].w) > pair.0.w.distance_squared(pair.1.w) {
                pair = (seen[i], seen[j]);
            }
        }
    }
    let (p, q) = pair;
    // NaN takes the branch of flat differences, here and below.
    let Some(line) = unit(q.w - p.w).filter(|_| q.w.distance(p.w) > thin) else {
        return Err(Flat { normal: unit(-m.center_point().w).unwrap_or(DVec3::X) });
    };
    let side = perpendicular(line);
    let other = line.cross(side);
    for (i, dir) in [side, -side, other, -other].into_iter().enumerate() {
        seen[6 + i] = m.point(dir);
    }
    let height = |v: &Point| (v.w - p.w).cross(line).length();
    let mut r = seen[0];
    for v in &seen[1..] {
        if height(v) > height(&r) {
            r = *v;
        }
    }
    let normal = unit((q.w - p.w).cross(r.w - p.w)).filter(|_| height(&r) > thin);
    let Some(normal) = normal else {
        return Err(Flat { normal: side });
    };
    let (above, below) = (m.point(normal), m.point(-normal));
    let rise = (above.w - p.w).dot(normal);
    let fall = (p.w - below.w).dot(normal);
    let s = if rise >= fall { above } else { below };
    if rise.max(fall) > thin { Ok([p, q, r, s]) } else { Err(Flat { normal }) }
}
