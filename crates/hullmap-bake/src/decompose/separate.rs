//! Separation of parts: where two parts overlap, a plane divides the surface that both contain.
//!
//! # Steps
//! 1. Take pairs of parts whose hulls meet, those with the largest common box first.
//! 2. Find a plane between the surface that only the one contains and the surface that only the
//!    other contains: across an axis, or else by GJK. If there is none, take the plane with the
//!    least depth of both beyond it.
//! 3. Hand over what is on the other part's side and in the other part.
//! 4. While the parts overlap by more than is allowed, divide one part of the pair that overlaps
//!    most, like the bar of a cross, and separate its pieces from the others.
//!
//! # Why the bounds hold
//! A part only takes over surface in its own proven hull. So the hull of what it has afterwards
//! lies in that hull, and protrudes no farther. No surface is dropped, so the cover stays complete.

use glam::DVec3;

use super::{
    cover::{
        CoverPart,
        body::{Body, farthest, separation},
    },
    patch::Patch,
};
use crate::{
    fit::planes::{self, HalfSpace},
    spread::spread,
};

/// Depth beyond a plane up to which a point counts as behind it, relative to the diagonal.
const TOLERANCE: f64 = 1e-9;

/// Number of points by which the common volume of two bodies is estimated.
const COMMON_POINTS: usize = 512;

/// Number of faces that are tried as planes by which a part is divided.
const TRIED_FACES: usize = 24;

/// A part's surface, and the region that it may take over.
struct Region {
    patches: Vec<Patch>,
    /// The half-spaces of the part's proven hull, and those on its side of the separating planes.
    planes: Vec<HalfSpace>,
    /// The hull of the patches.
    body: Body,
}

impl Region {
    fn new(part: &CoverPart, thickness: f64) -> Self {
        let planes = planes::half_spaces(&part.hull);
        Self { patches: part.patches.clone(), planes, body: body_of(&part.patches, thickness) }
    }

    /// Points of the surface outside of another part's region.
    fn outside(&self, other: &Self, tolerance: f64) -> Vec<DVec3> {
        let rest = |patch: &Patch| patch.clone().divided(&other.planes, tolerance)[1].take();
        self.patches.iter().filter_map(rest).flat_map(|patch| patch.points).collect()
    }

    /// Hands over the surface in front of a plane that is in another part's region.
    fn hand_over(&mut self, other: &Self, plane: HalfSpace, tolerance: f64) -> Vec<Patch> {
        let mut kept = Vec::new();
        let mut handed = Vec::new();
        for patch in std::mem::take(&mut self.patches) {
            let [behind, front] = patch.divided(&[plane], tolerance);
            kept.extend(behind);
            if let Some(front) = front {
                let [inside, outside] = front.divided(&other.planes, tolerance);
                handed.extend(inside);
                kept.extend(outside);
            }
        }
        self.patches = kept;
        handed
    }
}

fn body_of(patches: &[Patch], thickness: f64) -> Body {
    Body::new(&patches.iter().flat_map(|patch| patch.points.iter().copied()).collect::<Vec<_>>(), thickness)
}

/// Moves surface between parts so that their hulls overlap by at most about `allowed` of their
/// volume. Where that is not enough, parts are divided. Parts without surface are dropped.
/// `thickness` is that of flat bodies.
///
/// # Complexity
/// For each pair of parts that meet, each polygon of both is compared with the planes of both; once
/// more for each division.
pub fn separate(parts: &mut Vec<CoverPart>, allowed: f64, diagonal: f64, thickness: f64) {
    let tolerance = TOLERANCE * diagonal;
    let mut regions: Vec<Region> = parts.iter().map(|part| Region::new(part, thickness)).collect();
    // Of which part each region is a piece.
    let mut origins: Vec<usize> = (0..parts.len()).collect();
    for (_, i, j) in meeting(&regions, tolerance) {
        separate_two(&mut regions, i, j, tolerance, thickness);
    }
    for _ in 0..parts.len() {
        let volume: f64 = regions.iter().map(|region| region.body.volume()).sum();
        let mut common: Vec<(f64, usize, usize)> = meeting(&regions, tolerance)
            .into_iter()
            .map(|(_, i, j)| (common_volume(&regions[i].body, &regions[j].body), i, j))
            .collect();
        let total: f64 = common.iter().map(|(volume, ..)| volume).sum();
        common.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        if total <= allowed * volume {
            break;
        }
        let is_divided = common.into_iter().any(|(_, i, j)| {
            let Some((divided, front)) = divide(&mut regions, i, j, tolerance, thickness) else { return false };
            origins.push(origins[divided]);
            regions.push(front);
            separate_two(&mut regions, i, j, tolerance, thickness);
            let new = regions.len() - 1;
            for other in 0..new {
                separate_two(&mut regions, other, new, tolerance, thickness);
            }
            true
        });
        if !is_divided {
            break;
        }
    }
    let separated = regions.into_iter().zip(origins).filter(|(region, _)| !region.patches.is_empty());
    *parts = separated
        .map(|(region, origin)| CoverPart { patches: region.patches, planes: region.planes, ..parts[origin].clone() })
        .collect();
}

/// Pairs of regions that meet, those with the largest common box first.
fn meeting(regions: &[Region], tolerance: f64) -> Vec<(f64, usize, usize)> {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (j, b) in regions.iter().enumerate() {
        for (i, a) in regions[..j].iter().enumerate() {
            let size = a.body.high.min(b.body.high) - a.body.low.max(b.body.low);
            if size.min_element() > tolerance && meet(&a.body, &b.body, tolerance) {
                pairs.push((size.x * size.y * size.z, i, j));
            }
        }
    }
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    pairs
}

fn separate_two(regions: &mut [Region], i: usize, j: usize, tolerance: f64, thickness: f64) {
    let (left, right) = regions.split_at_mut(j);
    separate_pair(&mut left[i], &mut right[0], tolerance, thickness);
}

/// The volume that two bodies have in common, from the share of evenly spread points.
fn common_volume(a: &Body, b: &Body) -> f64 {
    let (low, high) = (a.low.max(b.low), a.high.min(b.high));
    let size = high - low;
    let is_common = |k: &usize| {
        let at = DVec3::from_array(spread(*k));
        let p = low + size * at;
        a.holds(p, 0.0) && b.holds(p, 0.0)
    };
    let count = (0..COMMON_POINTS).filter(is_common).count();
    size.x * size.y * size.z * count as f64 / COMMON_POINTS as f64
}

/// Divides one of two regions by a plane that has all surface behind it that only the other one
/// contains. Returns the index of the divided region, which keeps what is behind the plane, and the
/// region in front; `None` if no such plane divides either.
fn divide(regions: &mut [Region], i: usize, j: usize, tolerance: f64, thickness: f64) -> Option<(usize, Region)> {
    let only = [regions[i].outside(&regions[j], tolerance), regions[j].outside(&regions[i], tolerance)];
    // The wider the gap that is left between them, the less they overlap afterwards.
    let mut best: Option<(f64, usize, HalfSpace)> = None;
    for (divided, own, others) in [(i, &only[0], &only[1]), (j, &only[1], &only[0])] {
        let around = Body::new(others, thickness);
        let mut faces: Vec<usize> = (0..around.planes.len()).collect();
        faces.sort_by(|a, b| around.areas[*b].total_cmp(&around.areas[*a]).then(a.cmp(b)));
        for face in faces.into_iter().take(TRIED_FACES) {
            let plane = around.planes[face];
            let behind: Vec<DVec3> = own.iter().filter(|p| plane.height(**p) <= tolerance).copied().collect();
            if behind.len() == own.len() || behind.is_empty() {
                continue;
            }
            let gap = plane_between(&behind, others, tolerance).map_or(f64::INFINITY, |found| found.gap);
            if best.is_none_or(|(widest, ..)| gap > widest) {
                best = Some((gap, divided, plane));
            }
        }
    }
    let (_, divided, plane) = best?;
    let region = &mut regions[divided];
    let (mut behind, mut front) = (Vec::new(), Vec::new());
    for patch in std::mem::take(&mut region.patches) {
        let [near, far] = patch.divided(&[plane], tolerance);
        behind.extend(near);
        front.extend(far);
    }
    let back = HalfSpace { normal: -plane.normal, offset: -plane.offset };
    let beyond = Region {
        body: body_of(&front, thickness),
        patches: front,
        planes: region.planes.iter().copied().chain([back]).collect(),
    };
    region.body = body_of(&behind, thickness);
    region.patches = behind;
    region.planes.push(plane);
    Some((divided, beyond))
}

fn separate_pair(a: &mut Region, b: &mut Region, tolerance: f64, thickness: f64) {
    if a.patches.is_empty() || b.patches.is_empty() || !meet(&a.body, &b.body, tolerance) {
        return;
    }
    let (only_a, only_b) = (a.outside(b, tolerance), b.outside(a, tolerance));
    let Some(Between { plane, gap }) = plane_between(&only_a, &only_b, tolerance) else {
        // All of one part's surface is in the other.
        let (from, to) = if only_a.is_empty() { (a, b) } else { (b, a) };
        to.patches.append(&mut from.patches);
        to.body = body_of(&to.patches, thickness);
        from.body = Body::default();
        return;
    };
    let back = HalfSpace { normal: -plane.normal, offset: -plane.offset };
    let to_b = a.hand_over(b, plane, tolerance);
    let to_a = b.hand_over(a, back, tolerance);
    a.patches.extend(to_a);
    b.patches.extend(to_b);
    if gap >= -tolerance {
        a.planes.push(plane);
        b.planes.push(back);
    }
    (a.body, b.body) = (body_of(&a.patches, thickness), body_of(&b.patches, thickness));
}

/// Whether two bodies overlap, as far as their faces and GJK show.
fn meet(a: &Body, b: &Body, tolerance: f64) -> bool {
    let apart =
        |a: &Body, b: &Body| a.planes.iter().any(|plane| b.points.iter().all(|p| plane.height(*p) >= -tolerance));
    !apart(a, b) && !apart(b, a) && between(&a.points, &b.points, tolerance).is_none()
}

/// A plane between two sets of points.
struct Between {
    plane: HalfSpace,
    /// Width of the gap between the sets; negative if they reach beyond the plane.
    gap: f64,
}

/// A plane with `behind` behind it and `front` in front of it, as far as one is found; `None` if
/// there are no points on one side.
fn plane_between(behind: &[DVec3], front: &[DVec3], tolerance: f64) -> Option<Between> {
    if behind.is_empty() || front.is_empty() {
        return None;
    }
    let reach = |points: &[DVec3], d: DVec3| points.iter().map(|p| d.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
    let gap = |normal: &DVec3| -reach(front, -*normal) - reach(behind, *normal);
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
    let (mut best, mut widest) = (DVec3::X, f64::NEG_INFINITY);
    for normal in axes {
        let found = gap(&normal);
        if found > widest {
            (best, widest) = (normal, found);
        }
    }
    // People read cuts across an axis best.
    if widest < -tolerance {
        let middle = |points: &[DVec3]| points.iter().sum::<DVec3>() / points.len() as f64;
        let towards = (middle(front) - middle(behind)).normalize_or_zero();
        for normal in [Some(towards), between(behind, front, tolerance)].into_iter().flatten() {
            let found = gap(&normal);
            if found > widest {
                (best, widest) = (normal, found);
            }
        }
    }
    let offset = 0.5 * (reach(behind, best) - reach(front, -best));
    Some(Between { plane: HalfSpace { normal: best, offset }, gap: widest })
}

/// The normal of a plane between two sets of points, by GJK.
fn between(behind: &[DVec3], front: &[DVec3], tolerance: f64) -> Option<DVec3> {
    // The set of differences must not contain the origin.
    let support = |d: DVec3| farthest(behind, d) - farthest(front, -d);
    let towards = front.first()? - behind.first()?;
    Some(separation(support, DVec3::ZERO, towards, tolerance)?.normal)
}
