//! Mergers of parts across a mirror plane, cheapest first: a part with its image, or self-symmetric
//! parts with each other or with a part and its image. Results are symmetric, so that other parts
//! keep their images.

use std::{collections::BTreeMap, sync::Arc};

use glam::DVec3;
use rayon::prelude::*;

use super::{
    body::Body,
    context::PartitionSearch,
    join::{self, Overlap},
    piece::Piece,
    shape::{Component, Part},
};
use crate::symmetry::Mirror;
use hullmap_geometry::planes::HalfSpace;

/// A part, and whether it stands for its mirror image, too. Otherwise it is its own image.
#[derive(Clone)]
struct Unit {
    part: Part,
    image: Option<Body>,
}

impl Unit {
    fn count(&self) -> usize {
        1 + usize::from(self.image.is_some())
    }

    fn bodies(&self) -> impl Iterator<Item = &Body> {
        std::iter::once(&self.part.piece.body).chain(&self.image)
    }

    fn volume(&self) -> f64 {
        self.bodies().map(Body::volume).sum()
    }
}

struct Merger {
    cost: f64,
    body: Body,
}

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
    let mut units: Vec<Option<Unit>> = parts.into_iter().map(|part| Some(Unit { image: image(&part), part })).collect();
    let mut count: usize = units.iter().flatten().map(Unit::count).sum();
    if count > join::MANY {
        return result(units);
    }
    let mut shared = Overlap::new(units.iter().flatten().flat_map(Unit::bodies));
    let mut failures = join::FAILURES + units.len();
    let mut mergers: BTreeMap<(usize, usize), Option<Merger>> = BTreeMap::new();
    while failures > 0 && !search.is_over() {
        let new: Vec<(usize, usize)> = pairs(&units, meeting).filter(|pair| !mergers.contains_key(pair)).collect();
        let new: Vec<_> =
            new.into_par_iter().map(|pair| (pair, merger(search, &units, pair, mirror, forbidden))).collect();
        mergers.extend(new);
        let possible = mergers.iter().filter_map(|(pair, merger)| Some((*pair, merger.as_ref()?.cost)));
        let Some((pair, _)) = possible.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0))) else { break };
        let Some(Some(Merger { cost, body })) = mergers.insert(pair, None) else { break };
        if count <= wanted && !join::is_free(cost, &body) {
            break;
        }
        let others = units.iter().enumerate().filter(|(k, _)| *k != pair.0 && *k != pair.1);
        let others = others.filter_map(|(_, unit)| unit.as_ref()).flat_map(Unit::bodies);
        let own = merged(&units, pair).into_iter().flat_map(Unit::bodies);
        let Some(after) = shared.after(&own.collect::<Vec<_>>(), &body, others) else { continue };
        let beyond = search.points_beyond(&body);
        if !beyond.is_empty() {
            forbidden.extend(beyond);
            continue;
        }
        let component = units[pair.0].as_ref().map(|unit| unit.part.component).unwrap_or_default();
        match search.shaped(&united(search, &units, pair, &body, mirror)) {
            Ok(part) => {
                let part = Part { component, ..part };
                shared = after;
                let merged = [pair.0, pair.1].map(|i| units[i].take().map_or(0, |unit| unit.count()));
                count = count + 1 - merged.iter().sum::<usize>();
                units.push(Some(Unit { part, image: None }));
                mergers.retain(|(i, j), _| [i, j].iter().all(|k| ![pair.0, pair.1].contains(k)));
            }
            Err(point) => {
                failures -= 1;
                forbidden.extend(point);
            }
        }
    }
    result(units)
}

fn result(units: Vec<Option<Unit>>) -> Halves {
    let (own, whole): (Vec<Unit>, Vec<Unit>) = units.into_iter().flatten().partition(|unit| unit.image.is_some());
    let parts = |units: Vec<Unit>| units.into_iter().map(|unit| unit.part).collect();
    Halves { whole: parts(whole), mirrored: parts(own) }
}

fn images(body: &Body, mirror: &Mirror) -> Vec<DVec3> {
    body.points.iter().map(|p| mirror.image(*p)).collect()
}

fn pairs<'a>(units: &'a [Option<Unit>], meeting: &'a [u32]) -> impl Iterator<Item = (usize, usize)> + 'a {
    let has_image = |i: usize| units[i].as_ref().map(|unit| unit.image.is_some());
    let component = |i: usize| units[i].as_ref().map(|unit| unit.part.component);
    let all = (0..units.len()).flat_map(|j| (0..=j).map(move |i| (i, j)));
    let of_one = all.filter(move |(i, j)| {
        component(*i) == component(*j) && component(*i).is_some_and(|own| meeting.contains(&own.index))
    });
    of_one.filter(move |(i, j)| match (has_image(*i), has_image(*j)) {
        (Some(true), Some(true)) => i == j,
        (Some(false), Some(false)) => i != j,
        (Some(_), Some(_)) => true,
        _ => false,
    })
}

fn merged(units: &[Option<Unit>], (i, j): (usize, usize)) -> Vec<&Unit> {
    [i, j][..if i == j { 1 } else { 2 }].iter().filter_map(|i| units[*i].as_ref()).collect()
}

fn merger(
    search: &PartitionSearch,
    units: &[Option<Unit>],
    pair: (usize, usize),
    mirror: &Mirror,
    forbidden: &[DVec3],
) -> Option<Merger> {
    if search.is_over() {
        return None;
    }
    let own = merged(units, pair);
    let points: Vec<DVec3> = own.iter().flat_map(|unit| unit.bodies()).flat_map(|body| body.points.clone()).collect();
    let body = search.scale.body(&points);
    // The body is its own image, but a point may be known on one side only.
    let is_inside = |p: &DVec3| search.scale.is_inside(&body, *p) || search.scale.is_inside(&body, mirror.image(*p));
    let is_free = !forbidden.iter().any(is_inside);
    is_free.then(|| Merger { cost: body.volume() - own.iter().map(|unit| unit.volume()).sum::<f64>(), body })
}

fn united(
    search: &PartitionSearch,
    units: &[Option<Unit>],
    pair: (usize, usize),
    body: &Body,
    mirror: &Mirror,
) -> Piece {
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
    let holds = |plane: &HalfSpace| body.points.iter().all(|p| plane.height(*p) <= search.scale.tolerance());
    search.scale.piece(atoms, corners, planes.into_iter().filter(holds).collect(), &[])
}
