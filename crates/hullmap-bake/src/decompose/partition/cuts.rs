//! The plane that divides a piece.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::{
    body::Body,
    conflicts::Conflicts,
    context::PartitionSearch,
    links::Links,
    piece::{Piece, Scale},
};
use crate::fit::SolidKind;
use hullmap_geometry::planes::HalfSpace;

/// Number of equal slabs between the candidates across a direction.
const SLABS: usize = 12;

/// Maximum number of planes of faces at concave edges, and of large faces, that are tried.
const FACES: usize = 12;

/// Number of forbidden points by which planes are compared.
const COMPARED: usize = 600;

/// Weight of the protrusion of both sides, relative to the weight of conflicts.
const PROTRUSION: f64 = 2.0;

/// Extra cost of a plane across a direction at the border of a piece, as a share, so that symmetric
/// meshes are cut in the middle.
const OFF_MIDDLE: f64 = 0.3;

/// Relative extra cost of a plane that is not across an axis: axis cuts are the easiest to read.
const SLANTED: f64 = 0.5;

/// Distance of a cut from the wall that it cuts off, relative to the tolerance of points in a
/// plane.
const BESIDE: f64 = 4.0;

/// Factor for planes of faces: parts then end where faces do, and faces stay flat.
const OF_FACE: f64 = 0.7;

/// Weight of the volume, relative to the weight of forbidden points.
const VOLUME: f64 = 0.1;

/// Relative extra cost of a plane if all concavities lead through the piece along its normal: both
/// sides then need as many parts as the piece.
const THROUGH: f64 = 1.0;

/// Maximum number of forbidden points from which that share is estimated.
const CHORDS: usize = 64;

/// Places on the chord through such a point at which the distance is measured.
const ON_CHORD: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

/// Number of steps by which principal axes are found.
const POWERS: usize = 60;

/// The coordinate axes, and the principal axes of a piece's surface.
pub fn directions(piece: &Piece) -> [DVec3; 6] {
    let [first, second, third] = principal_axes(piece.atoms.iter().flat_map(|atom| atom.triangles()));
    [DVec3::X, DVec3::Y, DVec3::Z, first, second, third]
}

/// The principal axes of a surface, the longest first.
pub fn principal_axes(triangles: impl Iterator<Item = [DVec3; 3]>) -> [DVec3; 3] {
    let (mut sum, mut total, mut second) = (DVec3::ZERO, 0.0, DMat3::ZERO);
    let outer = |v: DVec3| DMat3::from_cols(v * v.x, v * v.y, v * v.z);
    for [a, b, c] in triangles {
        let (area, middle) = ((b - a).cross(c - a).length(), (a + b + c) / 3.0);
        sum += middle * area;
        total += area;
        second += outer(middle) * area;
    }
    let mut spread = second * (1.0 / total) - outer(sum / total);
    // Power iteration; the axis that was found is taken out.
    let mut longest = || {
        let mut axis = DVec3::new(0.57, 0.61, 0.55);
        for _ in 0..POWERS {
            axis = (spread * axis).normalize_or(DVec3::X);
        }
        spread -= outer(axis) * axis.dot(spread * axis);
        axis
    };
    let (first, second) = (longest(), longest());
    [first, second, first.cross(second).normalize_or(DVec3::Z)]
}

/// Lowest and highest point of a piece along a direction.
pub fn range(piece: &Piece, normal: DVec3) -> (f64, f64) {
    let heights = piece.body.points.iter().map(|p| normal.dot(*p));
    heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)))
}

/// The plane across the longest side of a piece's box, in its middle.
pub fn middle(piece: &Piece) -> HalfSpace {
    let Body { low, high, .. } = piece.body;
    let normal = DVec3::AXES[(high - low).max_position()];
    HalfSpace { normal, offset: normal.dot(0.5 * (low + high)) }
}

/// Planes through the middle of a piece's box: across its axes, and along its diagonals.
pub fn through_middle(piece: &Piece) -> impl Iterator<Item = HalfSpace> {
    let Body { low, high, .. } = piece.body;
    let (middle, size) = (0.5 * (low + high), high - low);
    let diagonals = (0..3).flat_map(move |axis| {
        let (u, v) = (DVec3::AXES[(axis + 1) % 3], DVec3::AXES[(axis + 2) % 3]);
        [1.0, -1.0].map(|sign| u * size.dot(v) + sign * v * size.dot(u))
    });
    let normals = DVec3::AXES.into_iter().chain(diagonals).filter_map(DVec3::try_normalize);
    normals.map(move |normal| HalfSpace { normal, offset: normal.dot(middle) })
}

/// The planes of faces at concave edges, and of large faces, that cut a piece, in the given order.
/// Walls have planes just beside them, so that the last wall can be cut off.
pub fn faces<'a>(search: &'a PartitionSearch, piece: &'a Piece) -> impl Iterator<Item = HalfSpace> + 'a {
    let inward = BESIDE * search.scale.tolerance();
    let are_walls = search.field.solid().kind() == SolidKind::Walls;
    let margin = if are_walls { 0.2 * inward } else { 0.2 * search.scale.limit };
    let cuts = move |plane: &HalfSpace| {
        let (low, high) = range(piece, plane.normal);
        low < plane.offset - margin && high > plane.offset + margin
    };
    let beside = move |plane: &HalfSpace| {
        let sides = [*plane, plane.opposite()];
        if are_walls { sides.map(|plane| plane.moved(-inward)).to_vec() } else { vec![*plane] }
    };
    let some = move |planes: &'a [HalfSpace]| planes.iter().flat_map(beside).filter(cuts).take(FACES);
    some(&search.planes.concave).chain(some(&search.planes.large))
}

/// How much two sides of a plane protrude: the sum of squares of the numbers of forbidden points in
/// their components, so that planes are preferred that leave little on each side, and a share of
/// the volume.
fn protrusion(piece: &Piece, scale: &Scale, near: &Links, forbidden: &[DVec3], plane: &HalfSpace) -> f64 {
    let back = plane.opposite();
    let sides = [plane, &back].map(|plane| scale.above(&piece.atoms, near, plane));
    if sides.iter().any(Vec::is_empty) {
        return f64::INFINITY;
    }
    let (mut squares, mut volume) = (0.0, 0.0);
    for component in sides.iter().flatten() {
        let points = &component.points;
        let body = scale.rough_body(points).unwrap_or_else(|| scale.body_of(points));
        let count = forbidden.iter().filter(|p| scale.is_inside(&body, **p)).count() as f64;
        squares += count * count;
        volume += body.volume();
    }
    let count = forbidden.len().max(1) as f64;
    squares / (count * count) + VOLUME * volume / piece.body.volume().max(f64::MIN_POSITIVE)
}

/// The share of forbidden points around which a concavity leads through a piece along a normal: all
/// of the chord through the point is too far from the solid, such as between the teeth of a gear.
fn led_through(search: &PartitionSearch, piece: &Piece, forbidden: &[DVec3], normal: DVec3) -> f64 {
    let is_through = |p: &&DVec3| {
        let [back, forth] = [-normal, normal].map(|direction| piece.body.exit(**p, direction));
        let at = |t: &f64| **p + (t * (back + forth) - back) * normal;
        ON_CHORD.iter().all(|t| search.field.is_beyond(at(t), search.scale.limit))
    };
    let some = || forbidden.iter().step_by(forbidden.len().div_ceil(CHORDS).max(1));
    some().filter(is_through).count() as f64 / some().count().max(1) as f64
}

/// The plane whose sides protrude least; `None` if no plane cuts the piece, or after the deadline.
/// Candidates: planes of faces at concave edges and of large faces, and equally spaced planes
/// across axes.
pub fn best_plane(search: &PartitionSearch, piece: &Piece, near: &Links, conflicts: &Conflicts) -> Option<HalfSpace> {
    let choice = Choice::new(search, piece, near, conflicts);
    let mut candidates = choice.candidates();
    candidates.sort_by(|a, b| a.least().total_cmp(&b.least()));
    // One batch for each thread; the best does not depend on their number.
    let mut best: Option<(f64, &Candidate)> = None;
    for some in candidates.chunks(rayon::current_num_threads()) {
        if best.is_some_and(|(cost, _)| some[0].least() > cost) {
            break;
        }
        let costs: Vec<(f64, &Candidate)> = some.par_iter().map(|some| (choice.cost(some), some)).collect();
        let order = |a: &(f64, &Candidate), b: &(f64, &Candidate)| a.0.total_cmp(&b.0).then(a.1.index.cmp(&b.1.index));
        best = best.into_iter().chain(costs).min_by(order);
    }
    best.filter(|(cost, _)| cost.is_finite()).map(|(_, candidate)| candidate.plane)
}

struct Choice<'a> {
    search: &'a PartitionSearch<'a>,
    piece: &'a Piece,
    near: &'a Links,
    conflicts: &'a Conflicts,
    forbidden: Vec<DVec3>,
}

impl<'a> Choice<'a> {
    fn new(search: &'a PartitionSearch<'a>, piece: &'a Piece, near: &'a Links, conflicts: &'a Conflicts) -> Self {
        let stride = piece.forbidden.len().div_ceil(COMPARED).max(1);
        let forbidden = piece.forbidden.iter().step_by(stride).copied().collect();
        Self { search, piece, near, conflicts, forbidden }
    }

    fn candidates(&self) -> Vec<Candidate> {
        let Self { search, piece, .. } = *self;
        let scale = &search.scale;
        let across = |normal: DVec3, k: usize| {
            let (low, high) = range(piece, normal);
            HalfSpace { normal, offset: low + (high - low) * k as f64 / SLABS as f64 }
        };
        let wide = directions(piece).into_iter().filter(|normal| {
            let (low, high) = range(piece, *normal);
            high - low >= 2.0 * scale.limit
        });
        let slices = wide.flat_map(|normal| (2..SLABS - 1).map(move |k| across(normal, k)));
        let slices = slices.map(|plane| (plane, 1.0 + unlike(piece, &plane)));
        let of_face = if search.field.solid().kind() == SolidKind::Walls { 1.0 } else { OF_FACE };
        let faces = faces(search, piece).map(|plane| (plane, of_face));
        let all: Vec<(usize, (HalfSpace, f64))> = slices.chain(faces).enumerate().collect();
        let candidate = |(index, (plane, factor))| Candidate { index, plane, factor, left: self.left(&plane) };
        all.into_par_iter().map(candidate).collect()
    }

    fn left(&self, plane: &HalfSpace) -> f64 {
        if self.search.is_over() {
            return 0.0;
        }
        self.conflicts.left(self.piece, &self.search.scale, self.near, plane)
    }

    fn cost(&self, Candidate { plane, factor, left, .. }: &Candidate) -> f64 {
        let Self { search, piece, near, ref forbidden, .. } = *self;
        if search.is_over() {
            return f64::INFINITY;
        }
        let through = THROUGH * led_through(search, piece, forbidden, plane.normal);
        (left + PROTRUSION * protrusion(piece, &search.scale, near, forbidden, plane)) * (1.0 + through) * factor
    }
}

struct Candidate {
    /// Ties go to the lowest index.
    index: usize,
    plane: HalfSpace,
    factor: f64,
    left: f64,
}

impl Candidate {
    /// A lower bound of its cost, which needs no hulls.
    fn least(&self) -> f64 {
        self.left * self.factor
    }
}

fn unlike(piece: &Piece, plane: &HalfSpace) -> f64 {
    let (low, high) = range(piece, plane.normal);
    let off_middle = (2.0 * (plane.offset - low) / (high - low) - 1.0).abs();
    let is_across_axis = plane.normal.abs().max_element() > 1.0 - 1e-9;
    OFF_MIDDLE * off_middle + if is_across_axis { 0.0 } else { SLANTED }
}

/// Tests, and the meshes and pieces that tests of other files use.
#[cfg(test)]
pub mod tests {
    use std::{f64::consts::TAU, sync::Arc};

    use shapes::{concave, mesh::Mesh};

    use super::*;
    use crate::{
        decompose::{
            partition::{atom::Atom, field::Field, planes::FacePlanes, surface::Surface, wrap::HullLimits},
            patch::Patch,
        },
        fit::Solid,
        progress::Stage,
        test_meshes::point_set,
    };

    /// A gear around the z axis, with four corners of its outline for each tooth.
    pub fn gear(teeth: u32, height: f64) -> Mesh {
        let count = 4 * teeth;
        let mut mesh = Mesh::default();
        for z in [0.0, height] {
            for k in 0..count {
                let (angle, radius) = (TAU * f64::from(k) / f64::from(count), if k % 4 < 2 { 1.0 } else { 0.75 });
                mesh.push_vertex([radius * libm::cos(angle), radius * libm::sin(angle), z]);
            }
        }
        let middles = [0.0, height].map(|z| mesh.push_vertex([0.0, 0.0, z]));
        for k in 0..count {
            let next = (k + 1) % count;
            let sides = vec![k, next, next + count, k + count];
            mesh.faces.extend([vec![middles[0], next, k], vec![middles[1], k + count, next + count], sides]);
        }
        mesh
    }

    /// Calls `with` with a search within a share of the diagonal, and the surface as a piece.
    pub fn with_search<T>(mesh: &Mesh, share: f64, with: impl FnOnce(&PartitionSearch, &Piece) -> T) -> T {
        let mesh = point_set(mesh);
        let solid = Solid::new(&mesh);
        let surface = Surface::new(&mesh, &solid);
        let (diagonal, limit) = (solid.diagonal(), share * solid.diagonal());
        let bounds =
            HullLimits { limit, max_vertices: 64, diagonal, thickness: 0.0, deadline: None, stage: Stage::default() };
        let field = Field::new(&solid);
        let scale = Scale { limit, diagonal, field: &field };
        let planes = FacePlanes::new(&surface.triangles);
        let search = PartitionSearch { field: &field, scale, planes: &planes, bounds };
        let atom = |triangle: &[DVec3; 3]| Arc::new(Atom::new(Patch::new(vec![triangle.to_vec()]).unwrap()));
        let atoms: Vec<Arc<Atom>> = surface.triangles.iter().map(atom).collect();
        let forbidden = search.forbidden(&surface.triangles, &scale.body(surface.triangles.as_flattened()));
        with(&search, &scale.piece(atoms, Vec::new(), Vec::new(), &forbidden))
    }

    #[test]
    fn gaps_between_teeth_lead_through_along_the_axis_only() {
        with_search(&gear(9, 0.4), 0.02, |search, piece| {
            assert!(piece.forbidden.len() > 100, "{} points", piece.forbidden.len());
            let along = |normal| led_through(search, piece, &piece.forbidden, normal);
            let found = [DVec3::Z, DVec3::X, DVec3::Y, DVec3::ONE.normalize()].map(along);
            assert!(found[0] == 1.0 && found[1..].iter().all(|share| *share < 0.3), "{found:?}");
        });
    }

    /// Two thin gears need twice as many parts as one; by conflicts alone, each is cut across.
    #[test]
    fn gears_are_not_cut_across_the_axis() {
        for (teeth, height, share) in
            [(11, 0.3, 0.01), (11, 1.4, 0.03), (12, 0.6, 0.03), (20, 0.3, 0.02), (20, 1.0, 0.03)]
        {
            with_search(&gear(teeth, height), share, |search, piece| {
                let near = search.scale.links(&piece.atoms);
                let plane = best_plane(search, piece, &near, &Conflicts::new(search, piece)).unwrap();
                assert!(plane.normal.z.abs() < 0.1, "{teeth} teeth, {height} high, {share}: {plane:?}");
            });
        }
    }

    /// Without the factors, slanted cuts would be best for some gears.
    #[test]
    fn cuts_across_an_axis_and_along_faces_are_preferred() {
        let mut turned = 0;
        for teeth in 8..24 {
            with_search(&gear(teeth, 0.4), 0.02, |search, piece| {
                let (near, conflicts) = (search.scale.links(&piece.atoms), Conflicts::new(search, piece));
                let choice = Choice::new(search, piece, &near, &conflicts);
                let is_slanted = |candidate: &Candidate| {
                    candidate.factor != OF_FACE && candidate.plane.normal.abs().max_element() < 0.99
                };
                let plain = |candidate: &Candidate| match candidate.factor {
                    OF_FACE => choice.cost(candidate) / OF_FACE,
                    factor if is_slanted(candidate) => choice.cost(candidate) * (factor - SLANTED) / factor,
                    _ => choice.cost(candidate),
                };
                let candidates = choice.candidates();
                let best = |cost: &dyn Fn(&Candidate) -> f64| {
                    let best = candidates.iter().min_by(|a, b| cost(a).total_cmp(&cost(b)));
                    is_slanted(best.unwrap())
                };
                let (with, without) = (best(&|candidate| choice.cost(candidate)), best(&plain));
                assert!(!with || without, "{teeth} teeth");
                turned += usize::from(without && !with);
            });
        }
        assert!(turned > 1, "the sample is not representative: {turned}");
    }

    #[test]
    fn candidates_that_are_skipped_are_no_better() {
        let mut skipped = 0;
        for (mesh, share) in [(gear(9, 0.4), 0.02), (concave::bowl(24, 8), 0.02), (concave::spiral_stair(9), 0.01)] {
            with_search(&mesh, share, |search, piece| {
                let (near, conflicts) = (search.scale.links(&piece.atoms), Conflicts::new(search, piece));
                let choice = Choice::new(search, piece, &near, &conflicts);
                let candidates = choice.candidates();
                let costs: Vec<f64> = candidates.iter().map(|candidate| choice.cost(candidate)).collect();
                let best = (0..costs.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b])).unwrap();
                assert_eq!(best_plane(search, piece, &near, &conflicts), Some(candidates[best].plane));
                assert!(candidates.iter().zip(&costs).all(|(candidate, cost)| candidate.least() <= *cost));
                skipped += candidates.iter().filter(|candidate| candidate.least() > costs[best]).count();
            });
        }
        assert!(skipped > 10, "the sample is not representative: {skipped}");
    }
}
