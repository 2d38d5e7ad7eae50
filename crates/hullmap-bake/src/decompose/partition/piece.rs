//! Pieces of the surface, and how planes divide them.

use std::{cell::LazyCell, sync::Arc};

use glam::DVec3;

use super::atom::Atom;
use super::body::{Body, Inner, MANY, ROUGH, THICKNESS};
use super::extremes::Extremes;
use super::field::Field;
use super::links::{Links, shells};
use crate::fit::SolidKind;
use hullmap_geometry::planes::HalfSpace;

/// Distance from a plane up to which a point counts as on it, relative to the diagonal.
pub const ON_PLANE: f64 = 1e-9;

/// Distance between boxes of atoms up to which they are neighbours, relative to the limit. Smaller
/// gaps are part of the solid as far as the limit is concerned.
const GAP: f64 = 0.1;

/// As [`GAP`], where the solid is walls: their two sides may be apart.
const WALL_GAP: f64 = 0.5;

/// Sum of the normals of a closed shell, relative to its area.
const CLOSED: f64 = 1e-6;

/// Distance from the hull of the surface up to which a corner adds nothing, relative to the
/// diagonal.
const NEAR_BODY: f64 = 1e-7;

/// Distance from a corner at which it is inside the solid, relative to the diagonal.
const BESIDE: f64 = 1e-5;

/// Diagonal of a piece, relative to the limit, up to which it may stand out of flat faces.
const SMALL: f64 = 2.0;

/// Where a line through the solid is tested.
const SEEN: [f64; 4] = [0.25, 0.5, 0.75, 0.97];

/// Atoms, and their hull with the solid between them.
#[derive(Clone, Debug)]
pub struct Piece {
    /// The atoms.
    pub atoms: Vec<Arc<Atom>>,
    /// Points of the solid's inside at which planes meet that bound the piece.
    pub corners: Vec<DVec3>,
    /// The hull of both.
    pub body: Body,
    /// Half-spaces that contain it.
    pub planes: Vec<HalfSpace>,
    /// Points in the hull that are too far from the solid.
    pub forbidden: Vec<DVec3>,
}

impl Piece {
    /// The area of the surface.
    pub fn area(&self) -> f64 {
        self.atoms.iter().map(|atom| atom.area).sum()
    }
}

/// The points of atoms, of which some are cut off.
#[derive(Default)]
pub struct Cloud<'a> {
    groups: Vec<Group<'a>>,
    count: usize,
}

enum Group<'a> {
    Atom(&'a Atom),
    Rest(Vec<DVec3>),
}

impl Group<'_> {
    fn points(&self) -> &[DVec3] {
        match self {
            Self::Atom(atom) => &atom.patch.points,
            Self::Rest(points) => points,
        }
    }
}

impl<'a> Cloud<'a> {
    /// Some points.
    pub fn of_points(points: Vec<DVec3>) -> Self {
        Self { count: points.len(), groups: vec![Group::Rest(points)] }
    }

    /// The points of atoms.
    pub fn of_atoms(atoms: &'a [Arc<Atom>]) -> Self {
        let mut cloud = Self::default();
        atoms.iter().for_each(|atom| cloud.push(Group::Atom(atom)));
        cloud
    }

    fn push(&mut self, group: Group<'a>) {
        self.count += group.points().len();
        self.groups.push(group);
    }

    fn extremes(&self) -> Extremes {
        let mut found = Extremes::EMPTY;
        for group in &self.groups {
            match group {
                Group::Atom(atom) => {
                    found.add_all(atom.extremes());
                }
                Group::Rest(points) => points.iter().for_each(|p| found.add(*p)),
            }
        }
        found
    }

    /// The points.
    pub fn points(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.groups.iter().flat_map(|group| group.points().iter().copied())
    }

    fn body(&self, thickness: f64, extremes: impl FnOnce() -> Extremes) -> Body {
        if self.count < MANY {
            return Body::of_outer_points(self.points(), thickness);
        }
        let inner = Inner::new(&extremes());
        let is_outer = |group: &&Group| match group {
            Group::Atom(atom) => !inner.holds_box(atom.low, atom.high),
            Group::Rest(_) => true,
        };
        let points = self.groups.iter().filter(is_outer).flat_map(|group| group.points().iter().copied());
        Body::of_outer_points(points.filter(|p| !inner.holds(*p)), thickness)
    }
}

/// A connected piece above a plane.
pub struct Above<'a> {
    /// Its corners.
    pub points: Cloud<'a>,
    /// Its approximate area.
    pub area: f64,
}

/// Lengths by which pieces are compared.
#[derive(Clone, Copy)]
pub struct Scale<'a> {
    /// Maximum distance of a piece's hull from the solid.
    pub limit: f64,
    /// Diagonal of the mesh.
    pub diagonal: f64,
    /// Its solid.
    pub field: &'a Field<'a>,
}

impl Scale<'_> {
    /// Distance from a plane up to which a point counts as on it.
    pub fn tolerance(&self) -> f64 {
        ON_PLANE * self.diagonal
    }

    /// The hull of points.
    pub fn body(&self, points: &[DVec3]) -> Body {
        Body::new(points, THICKNESS * self.diagonal)
    }

    /// The hull of points.
    pub fn body_of(&self, points: &Cloud) -> Body {
        points.body(THICKNESS * self.diagonal, || points.extremes())
    }

    /// Whether the hull of points contains none of those that are forbidden.
    pub fn is_free(&self, points: &Cloud, forbidden: &[DVec3]) -> bool {
        let extremes = points.extremes();
        let slack = 2.0 * THICKNESS * self.diagonal;
        // A smaller hull's points are in the hull, too.
        let small = LazyCell::new(|| self.body(&extremes.few_points()));
        let mut near = Vec::new();
        for p in forbidden.iter().copied().filter(|p| extremes.may_hold(*p, slack)) {
            if self.is_inside(&small, p) {
                return false;
            }
            near.push(p);
        }
        let is_free = |body: &Body| !near.iter().any(|p| self.is_inside(body, *p));
        near.is_empty()
            || (points.count < ROUGH || is_free(&self.body(&extremes.points())))
                && is_free(&points.body(THICKNESS * self.diagonal, || extremes.clone()))
    }

    /// A body in the hull of points that is nearly as large. `None` if it would be the hull.
    pub fn rough_body(&self, points: &Cloud) -> Option<Body> {
        (points.count >= ROUGH).then(|| self.body(&points.extremes().points()))
    }

    /// A piece. The points among `forbidden` that are inside its hull stay forbidden.
    pub fn piece(
        &self,
        atoms: Vec<Arc<Atom>>,
        corners: Vec<DVec3>,
        planes: Vec<HalfSpace>,
        forbidden: &[DVec3],
    ) -> Piece {
        let mut cloud = Cloud::of_atoms(&atoms);
        let mut body = self.body_of(&cloud);
        let is_outer = |p: &&DVec3| !body.holds(**p, NEAR_BODY * self.diagonal);
        let outer: Vec<DVec3> = corners.iter().filter(is_outer).copied().collect();
        if !outer.is_empty() {
            cloud.push(Group::Rest(outer));
            body = self.body_of(&cloud);
        }
        let forbidden = forbidden.iter().copied().filter(|p| self.is_inside(&body, *p)).collect();
        Piece { atoms, corners, body, planes, forbidden }
    }

    /// The sides of a plane; `None` if one is empty.
    pub fn cut(&self, piece: &Piece, plane: &HalfSpace) -> Option<[Piece; 2]> {
        let [below, above] = self.divided(&piece.atoms, plane);
        if below.is_empty() || above.is_empty() {
            return None;
        }
        let side = |atoms: Vec<Arc<Atom>>, plane: HalfSpace| {
            let planes = [piece.planes.as_slice(), &[plane]].concat();
            let mut corners = piece.corners.clone();
            corners.retain(|p| plane.height(*p) <= self.tolerance());
            corners.extend(self.new_corners(&planes));
            corners.retain(|p| self.sees(&atoms, *p));
            self.piece(atoms, corners, planes, &piece.forbidden)
        };
        Some([side(below, *plane), side(above, plane.opposite())])
    }

    /// Some atoms of a piece above a plane, and the rest of the piece, which is on both of its
    /// sides.
    pub fn cut_off(&self, piece: &Piece, plane: &HalfSpace, is_own: &[bool]) -> Option<[Piece; 2]> {
        let (mut cap, mut rest) = (Vec::new(), Vec::new());
        for (atom, is_own) in piece.atoms.iter().zip(is_own) {
            if *is_own {
                let [below, above] = self.divided(std::slice::from_ref(atom), plane);
                rest.extend(below);
                cap.extend(above);
            } else {
                rest.push(Arc::clone(atom));
            }
        }
        if cap.is_empty() || rest.is_empty() {
            return None;
        }
        let planes = [piece.planes.as_slice(), &[plane.opposite()]].concat();
        let corners = [piece.corners.as_slice(), &self.new_corners(&planes)].concat();
        let of = |atoms: Vec<Arc<Atom>>, planes: Vec<HalfSpace>, is_cap: bool| {
            let is_in = |p: &&DVec3| !is_cap || plane.height(**p) >= -self.tolerance();
            let corners = corners.iter().filter(is_in).filter(|p| self.sees(&atoms, **p)).copied().collect();
            self.piece(atoms, corners, planes, &piece.forbidden)
        };
        Some([of(cap, planes.clone(), true), of(rest, piece.planes.clone(), false)])
    }

    /// The points at which the last of some planes meets two others, if the solid is within all
    /// planes there.
    fn new_corners(&self, planes: &[HalfSpace]) -> Vec<DVec3> {
        let mut found = Vec::new();
        let Some((last, others)) = planes.split_last() else { return found };
        for (index, first) in others.iter().enumerate() {
            for second in &others[..index] {
                let sides = [
                    first.normal.cross(second.normal),
                    second.normal.cross(last.normal),
                    last.normal.cross(first.normal),
                ];
                let meet = |offsets: [f64; 3]| {
                    let sum = offsets[2] * sides[0] + offsets[0] * sides[1] + offsets[1] * sides[2];
                    sum / last.normal.dot(sides[0])
                };
                let p = meet([first.offset, second.offset, last.offset]);
                let is_within = p.is_finite() && planes.iter().all(|plane| plane.height(p) <= self.tolerance());
                let into = meet([-1.0; 3]).normalize_or_zero() * (BESIDE * self.diagonal);
                if is_within && self.field.is_inside(p + into) {
                    found.push(p);
                }
            }
        }
        found
    }

    /// The connected components of a piece.
    pub fn parted(&self, piece: Piece) -> Vec<Piece> {
        let components = self.components(&piece.atoms);
        if components.len() == 1 {
            return vec![piece];
        }
        let part = |atoms: Vec<Arc<Atom>>| {
            let corners = piece.corners.iter().copied().filter(|p| self.sees(&atoms, *p)).collect();
            self.piece(atoms, corners, piece.planes.clone(), &piece.forbidden)
        };
        components.into_iter().map(part).collect()
    }

    /// Whether the line from a point to the nearest corner of atoms is inside the solid.
    fn sees(&self, atoms: &[Arc<Atom>], p: DVec3) -> bool {
        let corners = atoms.iter().flat_map(|atom| &atom.patch.points);
        let nearest = corners.min_by(|a, b| a.distance_squared(p).total_cmp(&b.distance_squared(p)));
        nearest.is_some_and(|q| SEEN.iter().all(|t| self.field.is_inside(p.lerp(*q, *t))))
    }

    /// The pieces of a surface with which its division starts: each closed shell by itself. With
    /// each, the index of the group of shells that touch it.
    pub fn shells(&self, atoms: Vec<Arc<Atom>>, planes: &[HalfSpace], forbidden: &[DVec3]) -> Vec<(u32, Piece)> {
        let links = self.links(&atoms);
        let mut component_of = vec![0; atoms.len()];
        for (group, members) in (0..).zip(links.groups(|_| true, |_| true)) {
            members.iter().for_each(|atom| component_of[*atom as usize] = group);
        }
        let is_closed = |shell: &Vec<u32>| {
            let all = || shell.iter().map(|atom| &atoms[*atom as usize]);
            let normal: DVec3 = all().map(|atom| atom.normal).sum();
            // A mirror plane closes halves of shells.
            let open = planes.iter().fold(normal, |normal, plane| normal.reject_from_normalized(plane.normal));
            open.length() <= CLOSED * all().map(|atom| atom.area).sum::<f64>()
        };
        let (mut pieces, rest): (Vec<Vec<u32>>, Vec<Vec<u32>>) = shells(&atoms).into_iter().partition(is_closed);
        let mut is_open = vec![false; atoms.len()];
        rest.iter().flatten().for_each(|atom| is_open[*atom as usize] = true);
        pieces.extend(links.groups(|atom| is_open[atom as usize], |_| true));
        let piece = |members: Vec<u32>| {
            let own = members.iter().map(|atom| Arc::clone(&atoms[*atom as usize])).collect();
            (component_of[members[0] as usize], self.piece(own, Vec::new(), planes.to_vec(), forbidden))
        };
        pieces.into_iter().map(piece).collect()
    }

    /// Whether a body is too small to keep flat faces flat.
    pub fn is_small(&self, body: &Body) -> bool {
        body.diagonal() <= SMALL * self.limit
    }

    /// Whether a point is inside a body, not on its surface.
    pub fn is_inside(&self, body: &Body, p: DVec3) -> bool {
        body.holds(p, -self.tolerance())
    }

    /// The atoms below and above a plane; those that it cuts are divided.
    pub fn divided(&self, atoms: &[Arc<Atom>], plane: &HalfSpace) -> [Vec<Arc<Atom>>; 2] {
        let mut sides = [Vec::new(), Vec::new()];
        for atom in atoms {
            let (low, high) = heights(atom, plane);
            let is_in_plane = low >= -self.tolerance() && high <= self.tolerance();
            // The solid is behind a polygon.
            let is_below = if is_in_plane { atom.normal.dot(plane.normal) >= 0.0 } else { high <= self.tolerance() };
            if is_below {
                sides[0].push(Arc::clone(atom));
            } else if low >= -self.tolerance() {
                sides[1].push(Arc::clone(atom));
            } else {
                let halves = atom.patch.divided(plane, self.tolerance());
                for (side, half) in sides.iter_mut().zip(halves) {
                    side.extend(half.map(|half| Arc::new(Atom::new(half))));
                }
            }
        }
        sides
    }

    /// Whether a body reaches a plane, as far as the limit is concerned.
    pub fn meets(&self, body: &Body, plane: &HalfSpace) -> bool {
        body.points.iter().any(|p| plane.height(*p).abs() <= GAP * self.limit)
    }

    /// The links between atoms.
    pub fn links(&self, atoms: &[Arc<Atom>]) -> Links {
        let gap = if self.field.solid().kind() == SolidKind::Walls { WALL_GAP } else { GAP };
        Links::new(atoms, self.field, gap * self.limit)
    }

    /// The connected components of atoms.
    pub fn components(&self, atoms: &[Arc<Atom>]) -> Vec<Vec<Arc<Atom>>> {
        let lists = self.links(atoms).groups(|_| true, |_| true);
        lists.into_iter().map(|list| list.into_iter().map(|i| Arc::clone(&atoms[i as usize])).collect()).collect()
    }

    /// For each atom, the index of its connected component above a plane, or `u32::MAX` below it.
    pub fn components_above(&self, atoms: &[Arc<Atom>], links: &Links, plane: &HalfSpace) -> Vec<u32> {
        let is_above: Vec<bool> = atoms.iter().map(|atom| heights(atom, plane).1 > self.tolerance()).collect();
        let mut component = vec![u32::MAX; atoms.len()];
        let groups = links.groups(|i| is_above[i as usize], |p| plane.height(p) >= -self.tolerance());
        for (c, list) in (0..).zip(groups) {
            list.into_iter().for_each(|i| component[i as usize] = c);
        }
        component
    }

    /// The approximate area above a plane: the sum of the areas of all components.
    pub fn area_above(&self, atoms: &[Arc<Atom>], plane: &HalfSpace) -> f64 {
        let share = |atom: &Atom| match heights(atom, plane) {
            (low, _) if low >= -self.tolerance() => 1.0,
            (_, high) if high > self.tolerance() => 0.5,
            _ => 0.0,
        };
        atoms.iter().map(|atom| share(atom) * atom.area).sum()
    }

    /// The connected components above a plane.
    pub fn above<'b>(&self, atoms: &'b [Arc<Atom>], links: &Links, plane: &HalfSpace) -> Vec<Above<'b>> {
        let range: Vec<(f64, f64)> = atoms.iter().map(|atom| heights(atom, plane)).collect();
        let is_above: Vec<bool> = range.iter().map(|(_, high)| *high > self.tolerance()).collect();
        let collect = |list: Vec<u32>| {
            let (mut points, mut area) = (Cloud::default(), 0.0);
            for i in list.into_iter().map(|i| i as usize) {
                if range[i].0 >= -self.tolerance() {
                    points.push(Group::Atom(&atoms[i]));
                    area += atoms[i].area;
                } else {
                    let mut rest = Vec::new();
                    atoms[i].patch.polygons.iter().for_each(|polygon| collect_above(polygon, plane, &mut rest));
                    points.push(Group::Rest(rest));
                    area += 0.5 * atoms[i].area;
                }
            }
            Above { points, area }
        };
        let groups = links.groups(|i| is_above[i as usize], |p| plane.height(p) >= -self.tolerance());
        groups.into_iter().map(collect).collect()
    }
}

/// Bounds on the heights of an atom's points; exact where the plane may cut it.
fn heights(atom: &Atom, plane: &HalfSpace) -> (f64, f64) {
    let middle = (atom.low + atom.high) * 0.5;
    let (height, reach) = (plane.height(middle), plane.normal.abs().dot(atom.high - middle));
    if height.abs() > reach {
        return (height - reach, height + reach);
    }
    atom.patch
        .points
        .iter()
        .map(|p| plane.height(*p))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)))
}

fn collect_above(polygon: &[DVec3], plane: &HalfSpace, points: &mut Vec<DVec3>) {
    for (k, p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        let (h, g) = (plane.height(*p), plane.height(q));
        if h >= 0.0 {
            points.push(*p);
        }
        if (h < 0.0) != (g < 0.0) {
            points.push(p.lerp(q, h / (h - g)));
        }
    }
}

#[cfg(test)]
mod tests {
    use hullmap_geometry::bounds;
    use shapes::{concave, rng::SplitMix64};

    use super::*;
    use crate::{decompose::patch::Patch, fit::Solid, test_meshes::point_set};

    #[test]
    fn bodies_of_clouds_are_those_of_their_points() {
        let seed = 6;
        println!("seed {seed}");
        let mut rng = SplitMix64::new(seed);
        let (mut large, mut free) = (0, 0);
        for mesh in [point_set(&concave::bowl(40, 12)), point_set(&concave::spiral_stair(30))] {
            let polygons: Vec<Vec<DVec3>> = mesh.triangles.iter().map(|t| mesh.corners(t).to_vec()).collect();
            let atom = |some: &[Vec<DVec3>]| Arc::new(Atom::new(Patch::new(some.to_vec()).unwrap()));
            let atoms: Vec<Arc<Atom>> = polygons.chunks(5).map(atom).collect();
            let [low, high] = bounds(polygons.concat());
            let solid = Solid::new(&mesh);
            let field = Field::new(&solid);
            let scale = Scale { limit: 0.01 * high.distance(low), diagonal: high.distance(low), field: &field };
            let near = scale.links(&atoms);
            for round in 0..40 {
                let mut inside = || low + (high - low) * DVec3::from_array(std::array::from_fn(|_| rng.unit()));
                let (a, b) = (inside(), inside());
                let forbidden: Vec<DVec3> = (0..6).map(|_| inside()).collect();
                let Some(normal) = (b - a).try_normalize() else { continue };
                let plane = HalfSpace { normal, offset: normal.dot(0.5 * (a + b)) };
                for above in scale.above(&atoms, &near, &plane) {
                    let points: Vec<DVec3> = above.points.points().collect();
                    let (found, expected) = (scale.body_of(&above.points), scale.body(&points));
                    assert_eq!(found.points, expected.points, "round {round}");
                    let is_free = !forbidden.iter().any(|p| scale.is_inside(&expected, *p));
                    assert_eq!(scale.is_free(&above.points, &forbidden), is_free, "round {round}");
                    large += usize::from(points.len() > MANY);
                    free += usize::from(is_free);
                }
            }
        }
        assert!(large > 40 && free > 20, "{large} large, {free} free");
    }
}
