//! Mergers of parts across a mirror plane, cheapest first: a part with its image, or self-symmetric
//! parts with each other or with a part and its image. Results are symmetric, so that other parts
//! keep their images.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::{
    body::Body,
    context::PartitionSearch,
    join::{self, Merger, Pair, Rules, Unit, merged},
    piece::Piece,
    shape::{Component, Part},
};
use crate::symmetry::Mirror;
use hullmap_geometry::planes::HalfSpace;

/// Parts of half a surface.
#[derive(Clone, Debug, Default)]
pub struct Halves {
    /// Parts that are their own mirror images.
    pub whole: Vec<Part>,
    /// Parts that also stand for their mirror images.
    pub mirrored: Vec<Part>,
}

impl Halves {
    /// The number of parts, with images.
    pub fn count(&self) -> usize {
        self.whole.len() + 2 * self.mirrored.len()
    }

    /// All parts and the images of those that have images. `None` if an image is not proven, or the
    /// time is over.
    fn with_images(self, search: &PartitionSearch, mirror: &Mirror, meeting: &[u32]) -> Option<Vec<Part>> {
        let image = |part: &Part| {
            let Piece { atoms, corners, planes, .. } = &part.piece;
            let atoms = atoms.iter().map(|atom| Arc::new(atom.image(mirror))).collect();
            let corners = corners.iter().map(|p| mirror.image(*p)).collect();
            let planes = planes.iter().map(|plane| plane_image(plane, mirror)).collect();
            let Component { index, image } = part.component;
            let component = Component { index, image: if meeting.contains(&index) { image } else { 1 } };
            let image = search.shaped(&search.scale.piece(atoms, corners, planes, &[])).ok()?;
            Some(Part { component, ..image })
        };
        let images: Option<Vec<Part>> = self.mirrored.par_iter().map(image).collect();
        Some([self.whole, self.mirrored, images?].concat())
    }
}

fn plane_image(plane: &HalfSpace, mirror: &Mirror) -> HalfSpace {
    let normal = mirror.image(plane.normal) - mirror.image(DVec3::ZERO);
    HalfSpace { normal, offset: normal.dot(mirror.image(plane.normal * plane.offset)) }
}

/// Merges the parts of a surface, and then across its mirrors, the last one first, down to `wanted`
/// parts in all. `meeting` has the components that reach each mirror. `None` if an image is not
/// proven, or the time is over.
pub fn merge_all(
    search: &PartitionSearch,
    parts: Vec<Part>,
    mirrors: &[Mirror],
    meeting: &[Vec<u32>],
    forbidden: &mut Vec<DVec3>,
    wanted: usize,
) -> Option<Halves> {
    let wanted = |mirrors: usize| wanted.div_ceil(1 << mirrors);
    let mut parts = join::merge(search, parts, forbidden, wanted(mirrors.len()));
    let across: Vec<(&Mirror, &Vec<u32>)> = mirrors.iter().zip(meeting).collect();
    let Some((first, others)) = across.split_first() else {
        return Some(Halves { whole: parts, mirrored: Vec::new() });
    };
    for (mirror, meeting) in others.iter().rev() {
        let halves = merge(search, parts, mirror, meeting, forbidden, wanted(1));
        parts = halves.with_images(search, mirror, meeting)?;
    }
    Some(merge(search, parts, first.0, first.1, forbidden, wanted(0)))
}

/// Merges parts of half a surface with their mirror images, under the conditions of
/// [`join::merge`], down to `wanted` parts. Only components among `meeting`, which reach the
/// mirror, have parts on both of its sides.
///
/// # Complexity
/// One hull for each pair of parts, including merged parts.
fn merge(
    search: &PartitionSearch,
    parts: Vec<Part>,
    mirror: &Mirror,
    meeting: &[u32],
    forbidden: &mut Vec<DVec3>,
    wanted: usize,
) -> Halves {
    let image = |part: &Part| Some(search.scale.body(&images(&part.piece.body, mirror)));
    let mut units: Vec<Unit> = parts.into_iter().map(|part| Unit { image: image(&part), part }).collect();
    if units.iter().map(Unit::count).sum::<usize>() <= join::MANY {
        units = join::merge_units(search, units, forbidden, wanted, &Across { search, mirror, meeting });
    }
    let (own, whole): (Vec<Unit>, Vec<Unit>) = units.into_iter().partition(|unit| unit.image.is_some());
    let parts = |units: Vec<Unit>| units.into_iter().map(|unit| unit.part).collect();
    Halves { whole: parts(whole), mirrored: parts(own) }
}

fn images(body: &Body, mirror: &Mirror) -> Vec<DVec3> {
    body.points.iter().map(|p| mirror.image(*p)).collect()
}

/// The rules of a mirror.
struct Across<'a, 's> {
    search: &'a PartitionSearch<'s>,
    mirror: &'a Mirror,
    meeting: &'a [u32],
}

impl Rules for Across<'_, '_> {
    fn pairs(&self, units: &[Option<Unit>], _: usize) -> Vec<Pair> {
        let has_image = |i: usize| units[i].as_ref().map(|unit| unit.image.is_some());
        let component = |i: usize| units[i].as_ref().map(|unit| unit.part.component);
        let all = (0..units.len()).flat_map(|j| (0..=j).map(move |i| (i, j)));
        let of_one = all.filter(|(i, j)| {
            component(*i) == component(*j) && component(*i).is_some_and(|own| self.meeting.contains(&own.index))
        });
        let may_merge = |(i, j): &Pair| match (has_image(*i), has_image(*j)) {
            (Some(true), Some(true)) => i == j,
            (Some(false), Some(false)) => i != j,
            (Some(_), Some(_)) => true,
            _ => false,
        };
        of_one.filter(may_merge).collect()
    }

    fn merger(&self, units: &[Option<Unit>], pair: Pair, forbidden: &[DVec3]) -> Option<Merger> {
        let Self { search, mirror, .. } = self;
        if search.is_over() {
            return None;
        }
        let own = merged(units, pair);
        let points: Vec<DVec3> =
            own.iter().flat_map(|unit| unit.bodies()).flat_map(|body| body.points.clone()).collect();
        let body = search.scale.body(&points);
        // The body is its own image, but a point may be known on one side only.
        let is_inside =
            |p: &DVec3| search.scale.is_inside(&body, *p) || search.scale.is_inside(&body, mirror.image(*p));
        let is_free = !forbidden.iter().any(is_inside);
        let volume = |unit: &&Unit| unit.bodies().map(Body::volume).sum::<f64>();
        is_free.then(|| Merger { cost: body.volume() - own.iter().map(volume).sum::<f64>(), body })
    }

    fn united(&self, units: &[Option<Unit>], pair: Pair, body: &Body) -> Piece {
        let Self { search, mirror, .. } = self;
        let (mut atoms, mut corners, mut planes) = (Vec::new(), Vec::new(), Vec::new());
        for unit in merged(units, pair) {
            let own = &unit.part.piece.atoms;
            atoms.extend(own.iter().cloned());
            corners.extend_from_slice(&unit.part.piece.corners);
            for plane in &unit.part.piece.planes {
                planes.extend([*plane, plane_image(plane, mirror)]);
            }
            if unit.image.is_some() {
                atoms.extend(own.iter().map(|atom| Arc::new(atom.image(mirror))));
                corners.extend(unit.part.piece.corners.iter().map(|p| mirror.image(*p)));
            }
        }
        planes.retain(|plane: &HalfSpace| body.points.iter().all(|p| plane.height(*p) <= search.scale.tolerance()));
        search.scale.piece(atoms, corners, planes, &[])
    }
}
