//! The rest: triangles of the mesh that are not proven to lie in parts. Most of them have no area,
//! or lie in a gap between parts that is narrower than f32 can close.
//!
//! # Steps
//! 1. Each of these triangles is given to the part nearest to it.
//! 2. A part absorbs all of its triangles at once, if its hull with them is proven. Otherwise, half
//!    of them are tried after the other, down to one.
//! 3. A triangle that is not absorbed becomes a part, if there may be more. If not, or if the time is
//!    over, it is absorbed without a proof.
//!
//! # Complexity
//! For n triangles and m parts, O(n m) comparisons of boxes, a few nearest points for each triangle,
//! and at most 2 n proofs; one for each part that absorbs all of its triangles.

use std::collections::BTreeMap;

use glam::DVec3;

use super::{
    levels::Levels,
    partition::wrap::{self, Bounds},
};
use crate::{hull::Hull, simplify::nearest::Nearest};

/// A triangle of the mesh.
pub type Corners = [DVec3; 3];

/// What is done with triangles that no part covers.
pub struct Rest<'a> {
    /// The mesh's searches.
    pub levels: &'a Levels<'a>,
    /// Limits of the parts that absorb triangles.
    pub bounds: Bounds<'a>,
    /// Thickness of parts that triangles become.
    pub thickness: f64,
    /// Maximum number of parts.
    pub max_parts: usize,
    /// Number of proofs so far.
    pub proofs: usize,
}

impl Rest<'_> {
    /// Adds triangles to `hulls`, which are finished by `finish`.
    pub fn add(&mut self, hulls: &mut Vec<Hull>, triangles: &[Corners], finish: &dyn Fn(Hull) -> Hull) {
        let mut of_part: BTreeMap<usize, Vec<Corners>> = BTreeMap::new();
        let parts: Vec<(Nearest, [DVec3; 2])> = hulls.iter().map(|hull| (Nearest::new(hull), box_of(hull))).collect();
        for corners in triangles {
            of_part.entry(nearest(&parts, corners)).or_default().push(*corners);
        }
        let mut left: Vec<(usize, Corners)> = Vec::new();
        for (part, triangles) in of_part {
            if let Some(hull) = hulls.get_mut(part) {
                let rest = self.absorbed(hull, &triangles, finish);
                left.extend(rest.into_iter().map(|corners| (part, corners)));
            } else {
                // There are no parts yet.
                left.extend(triangles.into_iter().map(|corners| (part, corners)));
            }
        }
        let mut must: BTreeMap<usize, Vec<Corners>> = BTreeMap::new();
        for (part, corners) in left {
            if hulls.len() < self.max_parts && !self.bounds.is_over() {
                let Bounds { diagonal, max_vertices, .. } = self.bounds;
                let own = wrap::of_polygon(&corners, diagonal, self.thickness, max_vertices);
                hulls.extend(own.into_iter().map(|(_, hull)| finish(hull)));
            } else {
                must.entry(part).or_default().push(corners);
            }
        }
        for (part, triangles) in must {
            if let Some((hull, grown)) =
                hulls.get_mut(part).and_then(|hull| Some((self.grown(hull, &triangles)?, hull)))
            {
                *grown = finish(hull);
            }
        }
    }

    /// A part absorbs triangles. Returns those that it does not.
    fn absorbed(&mut self, hull: &mut Hull, triangles: &[Corners], finish: &dyn Fn(Hull) -> Hull) -> Vec<Corners> {
        let (mut left, mut stack) = (Vec::new(), vec![triangles]);
        while let Some(some) = stack.pop() {
            if self.bounds.is_over() {
                left.extend_from_slice(some);
                continue;
            }
            self.proofs += 1;
            let grown = self.grown(hull, some);
            let is_proven =
                |grown: &Hull| wrap::prove(&self.levels.field, grown, &self.bounds, wrap::MEASUREMENTS).is_ok();
            match grown.filter(is_proven) {
                Some(grown) => *hull = finish(grown),
                None if some.len() > 1 => {
                    let (first, second) = some.split_at(some.len() / 2);
                    stack.extend([second, first]);
                }
                None => left.extend_from_slice(some),
            }
        }
        left
    }

    /// The hull of a part and triangles.
    fn grown(&self, hull: &Hull, triangles: &[Corners]) -> Option<Hull> {
        let points = [hull.positions().as_slice(), triangles.as_flattened()].concat();
        let grown = wrap::tight(&points, self.bounds.diagonal, self.bounds.thickness)?;
        Some(wrap::within_vertices(grown, self.bounds.max_vertices))
    }
}

/// The minimum and the maximum of a hull's vertices.
fn box_of(hull: &Hull) -> [DVec3; 2] {
    let points = hull.positions();
    [
        points.iter().copied().fold(DVec3::INFINITY, DVec3::min),
        points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max),
    ]
}

/// The index of the part that is nearest to a triangle's farthest corner; 0 if there is none.
fn nearest(parts: &[(Nearest, [DVec3; 2])], corners: &Corners) -> usize {
    let to_box =
        |[low, high]: &[DVec3; 2]| corners.iter().map(|p| p.distance(p.clamp(*low, *high))).fold(0.0, f64::max);
    let mut order: Vec<(f64, usize)> = parts.iter().enumerate().map(|(i, (_, sides))| (to_box(sides), i)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let (mut least, mut found) = (f64::INFINITY, 0);
    for (bound, index) in order {
        if bound > least {
            break;
        }
        let part = &parts[index].0;
        let distance = corners.iter().map(|p| part.certain(*p).point.distance(*p)).fold(0.0, f64::max);
        if distance < least {
            (least, found) = (distance, index);
        }
    }
    found
}
