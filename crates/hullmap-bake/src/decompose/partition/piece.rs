//! Pieces of the surface, and how planes divide them.

use std::sync::{Arc, OnceLock};

use glam::DVec3;

use super::body::{self, Body, Inner, MANY, ROUGH, THICKNESS};
use super::extremes::Extremes;
use crate::{
    decompose::patch::Patch,
    fit::triangle_tree::{Bounds, TriangleTree},
    symmetry::Mirror,
};
use hullmap_geometry::planes::{self, HalfSpace};

/// Distance from a plane up to which a point counts as on it, relative to the diagonal.
pub const ON_PLANE: f64 = 1e-9;

/// Distance between boxes of atoms up to which they are neighbours, relative to the limit. Smaller
/// gaps are part of the solid as far as the limit is concerned.
const GAP: f64 = 0.1;

/// A small patch that is not divided unless a plane cuts it.
#[derive(Debug)]
pub struct Atom {
    /// The patch.
    pub patch: Patch,
    low: DVec3,
    high: DVec3,
    area: f64,
    /// Sum of the polygons' normals, each as long as its area.
    normal: DVec3,
    /// The extremes of its points, once they are used.
    extremes: OnceLock<Box<Extremes>>,
}

impl Atom {
    /// An atom of a patch.
    pub fn new(patch: Patch) -> Self {
        let (low, high) = body::bounds(&patch.points);
        let mut atom = Self { patch, low, high, area: 0.0, normal: DVec3::ZERO, extremes: OnceLock::new() };
        let normals: Vec<DVec3> = atom.triangles().map(|[a, b, c]| 0.5 * (b - a).cross(c - a)).collect();
        (atom.area, atom.normal) = (normals.iter().map(|n| n.length()).sum(), normals.iter().sum());
        atom
    }

    /// Its mirror image, whose faces point outward, too.
    pub fn image(&self, mirror: &Mirror) -> Self {
        let polygons = &self.patch.polygons;
        let image = |p: &DVec3| mirror.image(*p);
        let polygons = polygons.iter().map(|polygon| polygon.iter().rev().map(image).collect()).collect();
        Self::new(Patch { polygons, points: self.patch.points.iter().map(image).collect() })
    }

    /// The polygons as triangles.
    pub fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        let fan = |p: &'_ Vec<DVec3>| planes::fan(p);
        self.patch.polygons.iter().flat_map(fan)
    }
}

/// Atoms and their hull.
#[derive(Clone, Debug)]
pub struct Piece {
    /// The atoms.
    pub atoms: Vec<Arc<Atom>>,
    /// Their hull.
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

    fn of_atoms(atoms: &'a [Arc<Atom>]) -> Self {
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
                    found.add_all(atom.extremes.get_or_init(|| Box::new(Extremes::from_points(&atom.patch.points))));
                }
                Group::Rest(points) => points.iter().for_each(|p| found.add(*p)),
            }
        }
        found
    }

    fn points(&self) -> impl Iterator<Item = DVec3> + '_ {
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
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// Maximum distance of a piece's hull from the solid.
    pub limit: f64,
    /// Diagonal of the mesh.
    pub diagonal: f64,
}

impl Scale {
    /// Distance from a plane up to which a point counts as on it.
    pub fn tolerance(&self) -> f64 {
        ON_PLANE * self.diagonal
    }

    /// The hull of points.
    pub fn body(&self, points: &[DVec3]) -> Body {
        Body::new(points, THICKNESS * self.diagonal)
    }

    /// The hull of atoms.
    pub fn body_of_atoms(&self, atoms: &[Arc<Atom>]) -> Body {
        self.body_of(&Cloud::of_atoms(atoms))
    }

    /// The hull of points.
    pub fn body_of(&self, points: &Cloud) -> Body {
        points.body(THICKNESS * self.diagonal, || points.extremes())
    }

    /// Whether the hull of points contains none of those that are forbidden.
    pub fn is_free(&self, points: &Cloud, forbidden: &[DVec3]) -> bool {
        let extremes = points.extremes();
        let slack = 2.0 * THICKNESS * self.diagonal;
        let near: Vec<DVec3> = forbidden.iter().filter(|p| extremes.may_hold(**p, slack)).copied().collect();
        if near.is_empty() {
            return true;
        }
        let is_free = |body: &Body| !near.iter().any(|p| self.is_inside(body, *p));
        // A smaller hull's points are in the hull, too.
        is_free(&self.body(&extremes.few_points()))
            && (points.count < ROUGH || is_free(&self.body(&extremes.points())))
            && is_free(&points.body(THICKNESS * self.diagonal, || extremes))
    }

    /// A body in the hull of points that is nearly as large. `None` if it would be the hull.
    pub fn rough_body(&self, points: &Cloud) -> Option<Body> {
        (points.count >= ROUGH).then(|| self.body(&points.extremes().points()))
    }

    /// A piece. The points among `forbidden` that are inside its hull stay forbidden.
    pub fn piece(&self, atoms: Vec<Arc<Atom>>, planes: Vec<HalfSpace>, forbidden: &[DVec3]) -> Piece {
        let body = self.body_of_atoms(&atoms);
        let forbidden = forbidden.iter().copied().filter(|p| self.is_inside(&body, *p)).collect();
        Piece { atoms, body, planes, forbidden }
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

    /// For each atom, its neighbours.
    pub fn neighbours(&self, atoms: &[Arc<Atom>]) -> Vec<Vec<u32>> {
        let gap = DVec3::splat(GAP * self.limit);
        let tree = TriangleTree::of_boxes(atoms.iter().map(|atom| Bounds { low: atom.low, high: atom.high }));
        let of = |(index, atom): (u32, &Arc<Atom>)| {
            let around = Bounds { low: atom.low - gap, high: atom.high + gap };
            let mut near = Vec::new();
            tree.for_each(|bounds| bounds.touches(&around), |other| near.push(other));
            near.retain(|other| *other != index);
            near
        };
        (0..).zip(atoms).map(of).collect()
    }

    /// The connected components of atoms.
    pub fn components(&self, atoms: &[Arc<Atom>]) -> Vec<Vec<Arc<Atom>>> {
        let lists = connected(&self.neighbours(atoms), &vec![true; atoms.len()]);
        lists.into_iter().map(|list| list.into_iter().map(|i| Arc::clone(&atoms[i as usize])).collect()).collect()
    }

    /// For each atom, the index of its connected component above a plane, or `u32::MAX` below it.
    pub fn components_above(&self, atoms: &[Arc<Atom>], near: &[Vec<u32>], plane: &HalfSpace) -> Vec<u32> {
        let is_above: Vec<bool> = atoms.iter().map(|atom| heights(atom, plane).1 > self.tolerance()).collect();
        let mut component = vec![u32::MAX; atoms.len()];
        for (c, list) in connected(near, &is_above).into_iter().enumerate() {
            list.into_iter().for_each(|i| component[i as usize] = c as u32);
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
    pub fn above<'a>(&self, atoms: &'a [Arc<Atom>], near: &[Vec<u32>], plane: &HalfSpace) -> Vec<Above<'a>> {
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
        connected(near, &is_above).into_iter().map(collect).collect()
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

fn connected(near: &[Vec<u32>], is_in: &[bool]) -> Vec<Vec<u32>> {
    let mut is_left = is_in.to_vec();
    let mut found = Vec::new();
    for i in 0..is_left.len() {
        if !std::mem::take(&mut is_left[i]) {
            continue;
        }
        let mut list = vec![i as u32];
        let mut at = 0;
        while let Some(&next) = list.get(at) {
            list.extend(near[next as usize].iter().filter(|j| std::mem::take(&mut is_left[**j as usize])));
            at += 1;
        }
        list.sort_unstable();
        found.push(list);
    }
    found
}

#[cfg(test)]
mod tests {
    use shapes::{concave, rng::SplitMix64};

    use super::*;
    use crate::decompose::tests::point_set;

    #[test]
    fn bodies_of_clouds_are_those_of_their_points() {
        let seed = 6;
        println!("seed {seed}");
        let mut rng = SplitMix64::new(seed);
        let (mut large, mut free) = (0, 0);
        for mesh in [point_set(&concave::bowl(40, 12)), point_set(&concave::spiral_stair(30))] {
            let corner = |v: &u32| DVec3::from_array(mesh.positions[*v as usize].map(f64::from));
            let polygons: Vec<Vec<DVec3>> = mesh.triangles.iter().map(|t| t.iter().map(corner).collect()).collect();
            let atom = |some: &[Vec<DVec3>]| Arc::new(Atom::new(Patch::new(some.to_vec()).unwrap()));
            let atoms: Vec<Arc<Atom>> = polygons.chunks(5).map(atom).collect();
            let (low, high) = body::bounds(&polygons.concat());
            let scale = Scale { limit: 0.01 * high.distance(low), diagonal: high.distance(low) };
            let near = scale.neighbours(&atoms);
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
