//! Contact points of a body: at most eight, chosen from the manifolds of all pairs of parts.
//!
//! A body on a mesh touches several triangles, each of which has a manifold of up to four points.
//! Most of the points lie between others, where they support nothing, and the time of an engine's
//! solver grows with their number.
//!
//! # Steps
//! 1. Group the manifolds by their normals ([`groups`]), the deepest one first.
//! 2. Share the eight points among the groups in turn.
//! 3. From each group, take the deepest point, and the corners of the convex hull of its points,
//!    without those that add little area ([`spread`]).
//! 4. If a point that is left out is too far below the chosen ones ([`envelope`]), or below the
//!    triangle on which the body then rests ([`select`](crate::manifold::select)), take it instead
//!    of a corner. Repeat.
//! 5. Keep the points of the last frame instead, with the deepest point, if they span at least 90 %
//!    of the area of the best choice and leave out no such point.
//! 6. Points that were also chosen in the last frame keep the caller's data.
//!
//! # Why area is not enough
//! A plate that lands on a ridge touches it at two points between its corners. The area needs
//! neither, and the deepest point is only one of them. Step by step, the plate tipped over one of
//! them and sank in at the other one. A box on its edge rocked on three points for ever.
//!
//! # Reference
//! Rouwe, "Architecting Jolt Physics for Horizon Forbidden West", GDC 2022 (manifold reduction:
//! manifolds with similar normals are one). NVIDIA PhysX has patches of contacts with the same
//! normal and reduces each.
//!
//! # Deviations
//! Jolt and PhysX move the points of a group to one normal. Here every point has the normal of its
//! own manifold.

#![forbid(unsafe_code)]

mod envelope;
mod groups;
mod spread;

use arrayvec::ArrayVec;
use glam::{DVec2, DVec3};

use super::manifolds::{CompoundManifolds, SmallerBody};
use crate::manifold::matching::{Likeness, match_points};
use crate::manifold::select::{Choice, LEFT_OUT, Rest, SAME_PLACE, SLIGHT, Spot};
use crate::manifold::{ManifoldPoint, SAME_DEPTH};
use crate::vector::perpendicular;
pub use groups::MAX_BODY_POINTS;
use groups::{Member, group, shares};
use spread::{Span, hull, reduce, span};

/// The points of the last frame stay while they span at least this share of the area of the best
/// ones.
const KEPT_AREA: f64 = 0.9;

/// Points between corners are chosen instead of corners while the others span at least this share
/// of the area of all points. With [`KEPT_AREA`], at least 60 % of the area are left.
const LEAST_AREA: f64 = 2.0 / 3.0;

/// A point of a [`BodyManifold`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyPoint {
    /// The parts of A and of B that touch there, by index.
    pub pair: [usize; 2],
    /// Unit normal from A to B, in A's frame: the normal of the manifold of these parts.
    pub normal: DVec3,
    /// The point. Its impulse, user data and age belong to the body manifold: those in the
    /// [`CompoundManifolds`] are others.
    pub point: ManifoldPoint,
}

impl BodyPoint {
    const EMPTY: Self = Self { pair: [0; 2], normal: DVec3::X, point: ManifoldPoint::EMPTY };
}

/// At most eight contact points of a body, chosen from its [`CompoundManifolds`]: caller-owned
/// memory of one ordered pair (A, B), in addition to the memory of the manifolds.
///
/// A point is one of those in the manifolds, unchanged. The deepest of all points is chosen, or
/// another one that is less deep by at most 1e-4 of half the diagonal of the smaller body's box. If
/// all normals are within five degrees of the deepest point's, the chosen points span at least 60 %
/// of the area that all points span, in projection along the normal, together with points between
/// them without which the body would sink in. Otherwise the points are shared by groups of normals,
/// each of which has at least its deepest point.
///
/// A point that was chosen before keeps its impulse and user data, and its age grows: one of the
/// same parts and features, or one at the same place. So a body that slides from triangle to
/// triangle keeps its points.
///
/// # Examples
/// A die over two triangles of a floor: each has a manifold, and the four corners of the die hold
/// it.
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use hullmap::compound::BodyManifold;
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Cuboid;
/// use hullmap::{CompoundManifolds, ManifoldSettings, Pose, TriangleMesh};
/// # use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};
/// # let positions = [[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]];
/// # let corners = [[0, 1, 2], [0, 2, 3]];
/// # let baked = bake_triangle_mesh(&Triangles { positions: &positions, corners: &corners, materials: &[] })?;
/// # let file = write_triangle_mesh(baked, &Default::default())?;
///
/// let (ground, die) = (TriangleMesh::from_bytes(&file)?, Cuboid::new(DVec3::splat(0.5))?);
/// let mut manifolds = CompoundManifolds::new(16);
/// let mut body = BodyManifold::new(16);
/// for step in 0..3 {
///     let at = Pose::from_translation(DVec3::new(0.1 + 0.01 * f64::from(step), 0.0, 0.499))?;
///     manifolds.update(&ground, &die, at, &ManifoldSettings::default());
///     body.update(&manifolds);
///     assert_eq!(body.points().len(), 4);
///     for point in body.points_mut() {
///         assert!(point.normal.distance(DVec3::Z) < 1e-9 && point.point.age == step);
///         point.point.impulse[0] = 1.0;
///     }
/// }
/// assert!(manifolds.iter().map(|(_, manifold)| manifold.points().len()).sum::<usize>() > 4);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct BodyManifold {
    points: ArrayVec<BodyPoint, MAX_BODY_POINTS>,
    scratch: Scratch,
}

/// Memory of an update: all points of the manifolds.
#[derive(Clone, Debug, Default)]
struct Scratch {
    members: Vec<Member>,
    candidates: Vec<Candidate>,
    taken: Vec<bool>,
    /// Indices of the candidates of a group.
    own: Vec<usize>,
    /// Corners of the hulls of all groups, one after the other.
    hulls: Vec<usize>,
    /// Corners of a polygon, and of two others.
    polygons: [Vec<usize>; 3],
}

#[derive(Clone, Copy, Debug)]
struct Candidate {
    point: BodyPoint,
    member: usize,
    /// The point of the last frame that it is.
    last: Option<usize>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Group {
    index: usize,
    /// Where the corners of its hull begin among all of them, and how many they are.
    corners: [usize; 2],
    deepest: usize,
    /// Least depth of a point that may stand for the deepest one.
    deep: f64,
    tangents: [DVec3; 2],
    /// Area that all points span.
    whole: Span,
    /// The triangle on which the body rests with all points; `None` if it rests on other groups,
    /// too.
    rest: Option<Rest>,
}

impl Default for BodyManifold {
    /// As [`new`](Self::new) for 16 pairs of parts.
    fn default() -> Self {
        Self::new(16)
    }
}

impl BodyManifold {
    /// Memory for the points of [`CompoundManifolds`] with `pairs` pairs of parts.
    pub fn new(pairs: usize) -> Self {
        let points = crate::manifold::MAX_POINTS * pairs;
        let scratch = Scratch {
            members: Vec::with_capacity(pairs),
            candidates: Vec::with_capacity(points),
            taken: Vec::with_capacity(points),
            own: Vec::with_capacity(points),
            hulls: Vec::with_capacity(points),
            polygons: [(); 3].map(|()| Vec::with_capacity(points + 4)),
        };
        Self { points: ArrayVec::new(), scratch }
    }

    /// The points; the group with the deepest point comes first.
    pub fn points(&self) -> &[BodyPoint] {
        &self.points
    }

    /// The points, for storing impulses and user data.
    pub fn points_mut(&mut self) -> &mut [BodyPoint] {
        &mut self.points
    }

    /// Removes all points.
    pub fn clear(&mut self) {
        self.points.clear();
    }

    /// Chooses points from `manifolds`, which have just been updated.
    ///
    /// # Complexity
    /// O(n²) for n points, and O(n log n) if few of them are corners of a convex hull. Allocates
    /// only if more pairs of parts touch than [`new`](Self::new) was told.
    pub fn update(&mut self, manifolds: &CompoundManifolds) {
        let last: ArrayVec<BodyPoint, MAX_BODY_POINTS> = self.points.drain(..).collect();
        let Scratch { members, candidates, taken, own, hulls, polygons } = &mut self.scratch;
        collect(manifolds, members, candidates);
        if candidates.is_empty() {
            return;
        }
        let body = manifolds.body();
        find_last(&last, SAME_PLACE * body.reach, taken, candidates);
        let (mut groups, mut wanted) = ([Group::default(); MAX_BODY_POINTS], [0; MAX_BODY_POINTS]);
        let count = group(members);
        hulls.clear();
        let places = Places { members, candidates, body };
        for (index, (group, wanted)) in groups.iter_mut().zip(&mut wanted).enumerate().take(count) {
            (*group, *wanted) = places.group(index, own, hulls, &mut polygons[0]);
        }
        for (group, share) in groups.iter().zip(shares(&wanted, MAX_BODY_POINTS)).take(count) {
            let chosen = places.choose(group, share, own, hulls, polygons);
            for candidate in chosen.iter().filter_map(|index| candidates.get(*index)) {
                let mut chosen = candidate.point;
                if let Some(old) = candidate.last.and_then(|index| last.get(index)) {
                    chosen.point.keep(&old.point);
                }
                if self.points.try_push(chosen).is_err() {
                    break;
                }
            }
        }
    }
}

fn collect(manifolds: &CompoundManifolds, members: &mut Vec<Member>, candidates: &mut Vec<Candidate>) {
    members.clear();
    candidates.clear();
    for (pair, manifold) in manifolds.iter() {
        let normal = manifold.normal();
        let depth = manifold.points().iter().map(|point| point.depth).fold(f64::NEG_INFINITY, f64::max);
        for point in manifold.points() {
            let point = ManifoldPoint { impulse: [0.0; 3], user_data: 0, age: 0, ..*point };
            candidates.push(Candidate { point: BodyPoint { pair, normal, point }, member: members.len(), last: None });
        }
        members.push(Member { normal, depth, group: 0 });
    }
}

/// Points of the last frame, and candidates.
struct Frames<'p> {
    last: &'p [BodyPoint],
    candidates: &'p [Candidate],
}

impl Likeness for Frames<'_> {
    fn has_same_features(&self, point: usize, other: usize) -> bool {
        let (Some(last), Some(new)) = (self.last.get(point), self.candidates.get(other)) else { return false };
        last.pair == new.point.pair && last.point.id == new.point.point.id
    }

    fn distance(&self, point: usize, other: usize) -> f64 {
        let (Some(last), Some(new)) = (self.last.get(point), self.candidates.get(other)) else { return f64::INFINITY };
        new.point.point.distance(&last.point)
    }
}

/// Finds the candidates that are points of the last frame.
fn find_last(last: &[BodyPoint], same_place: f64, taken: &mut Vec<bool>, candidates: &mut [Candidate]) {
    taken.clear();
    taken.resize(candidates.len(), false);
    let mut matches = [None; MAX_BODY_POINTS];
    let matches = matches.get_mut(..last.len()).unwrap_or_default();
    match_points(&Frames { last, candidates }, same_place, taken, matches);
    for (index, found) in matches.iter().enumerate() {
        if let Some(candidate) = found.and_then(|found| candidates.get_mut(found)) {
            candidate.last = Some(index);
        }
    }
}

struct Places<'p> {
    members: &'p [Member],
    candidates: &'p [Candidate],
    body: SmallerBody,
}

impl Places<'_> {
    /// Indices of the candidates of a group.
    fn of_group(&self, index: usize) -> impl Iterator<Item = usize> {
        let is_in = move |candidate: &Candidate| self.members.get(candidate.member).is_some_and(|m| m.group == index);
        self.candidates.iter().enumerate().filter(move |(_, candidate)| is_in(candidate)).map(|(i, _)| i)
    }

    fn point(&self, index: usize) -> BodyPoint {
        self.candidates.get(index).map_or(BodyPoint::EMPTY, |candidate| candidate.point)
    }

    fn place(&self, group: &Group, index: usize) -> DVec2 {
        group.over(self.point(index).point.point_b)
    }

    fn spot(&self, group: &Group, index: usize) -> Spot {
        Spot { at: self.place(group, index), depth: self.point(index).point.depth }
    }

    /// The group `index`, whose hull is appended to `hulls`, and the number of points that it has
    /// at most.
    fn group(
        &self,
        index: usize,
        own: &mut Vec<usize>,
        hulls: &mut Vec<usize>,
        polygon: &mut Vec<usize>,
    ) -> (Group, usize) {
        own.clear();
        own.extend(self.of_group(index));
        let is_deeper = |p: usize, q: usize| self.point(q).point.depth > self.point(p).point.depth;
        let deepest = own.iter().copied().reduce(|p, q| if is_deeper(p, q) { q } else { p }).unwrap_or(0);
        let normal = self.point(deepest).normal;
        let across = perpendicular(normal);
        // Depths that differ by less count as equal.
        let deep = self.point(deepest).point.depth - SAME_DEPTH * self.body.reach;
        let tangents = [across, normal.cross(across)];
        let mut group = Group { index, corners: [hulls.len(), 0], deepest, deep, tangents, ..Group::default() };
        hull(own, |index| self.place(&group, index), polygon);
        group.whole = span(polygon, |index| self.place(&group, index));
        group.rest = self.rest(&group, own.iter().copied(), polygon);
        let kept = [self.deepest_of(&group, polygon)];
        reduce(polygon, MAX_BODY_POINTS, &kept, |index| self.place(&group, index));
        group.corners[1] = polygon.len();
        hulls.extend_from_slice(polygon);
        let wanted = polygon.len() + usize::from(!polygon.contains(&kept[0]));
        let needs_others = self.left_out(&group, [polygon, &kept]).0 > self.may_be_left_out();
        (group, if needs_others { MAX_BODY_POINTS } else { wanted })
    }

    /// The triangle on which the body rests with some candidates of a group. `polygon` has the
    /// corners of their convex hull.
    fn rest(&self, group: &Group, own: impl Iterator<Item = usize> + Clone, polygon: &[usize]) -> Option<Rest> {
        let (spot, center) = (|index: usize| self.spot(group, index), group.over(self.body.center));
        Some(Rest::over(polygon, spot, center)?.lowered(own, spot, center))
    }

    /// How far a point of a group that is not chosen is below the chosen ones, or below the
    /// triangle on which the body then rests, and its index. `chosen` are the corners of a convex
    /// polygon, and other candidates.
    fn left_out(&self, group: &Group, chosen: [&[usize]; 2]) -> (f64, Option<usize>) {
        let rest = self.rest(group, chosen.into_iter().flatten().copied(), chosen[0]);
        if rest.is_none() && group.rest.is_some() {
            return (f64::INFINITY, None);
        }
        let slight = self.may_be_left_out();
        let mut worst = (0.0, None);
        for index in self.of_group(group.index).filter(|index| !chosen.iter().any(|some| some.contains(index))) {
            let spot = self.spot(group, index);
            let of_rest = rest.map_or(0.0, |rest| spot.depth - rest.depth(spot.at));
            let below = of_rest.max(envelope::below(spot, chosen, |index| self.spot(group, index), slight));
            if below > worst.0 {
                worst = (below, Some(index));
            }
        }
        worst
    }

    /// How far that may be.
    fn may_be_left_out(&self) -> f64 {
        LEFT_OUT * (SLIGHT * self.body.prediction).max(SAME_DEPTH * self.body.reach)
    }

    /// Drops corners of the convex hull of some candidates of a group, so that at most `most` are
    /// left with the points that are kept, which it returns: the deepest one, and points that would
    /// be too far below the others, while the corners span enough. `rest` is the triangle on which
    /// the body rests with all of these candidates, and `without` is scratch.
    fn reduce(
        &self,
        group: &Group,
        most: usize,
        corners: &mut Vec<usize>,
        rest: Option<Rest>,
        without: &mut Vec<usize>,
    ) -> Choice {
        let mut kept = Choice::default();
        kept.push(self.deepest_of(group, corners));
        self.reduce_to(group, most, corners, &kept);
        // The deepest one, and three others.
        for _ in 1..most.min(4) {
            let mut more = kept;
            match self.left_out(group, [corners, kept.indices()]) {
                (below, Some(worst)) if below > self.may_be_left_out() => more.push(worst),
                (below, _) if below > self.may_be_left_out() => break,
                _ => return kept,
            }
            if !self.exchange(group, most, corners, &more, without) {
                break;
            }
            kept = more;
        }
        // That was not enough, or the body's centre is not over the corners that are left.
        if let Some(rest) = rest
            && !self.holds(group, [corners, kept.indices()])
        {
            let mut all = Choice::default();
            kept.indices().iter().take(1).chain(&rest.corners).take(most).for_each(|index| all.push(*index));
            if self.exchange(group, most, corners, &all, without) {
                return all;
            }
        }
        kept
    }

    /// Drops corners so that at most `most` are left with the points `kept`. Returns false, and
    /// drops none, if the area would be too small. `without` is scratch.
    fn exchange(
        &self,
        group: &Group,
        most: usize,
        corners: &mut Vec<usize>,
        kept: &Choice,
        without: &mut Vec<usize>,
    ) -> bool {
        without.clear();
        without.extend_from_slice(corners);
        self.reduce_to(group, most, without, kept);
        // With fewer points than that, several groups support the body.
        let is_wide = most < MAX_BODY_POINTS
            || span(without, |index| self.place(group, index)).is_at_least(LEAST_AREA, &group.whole);
        if is_wide {
            std::mem::swap(corners, without);
        }
        is_wide
    }

    /// Whether the body rests on some points of a group, so that no other is too far below the
    /// triangle on which it does.
    fn holds(&self, group: &Group, chosen: [&[usize]; 2]) -> bool {
        let rest = self.rest(group, chosen.into_iter().flatten().copied(), chosen[0]);
        let below = |index: usize, rest: &Rest| self.point(index).point.depth - rest.depth(self.place(group, index));
        rest.is_some_and(|rest| self.of_group(group.index).all(|index| below(index, &rest) <= self.may_be_left_out()))
    }

    /// Drops corners of a convex polygon until at most `most` are left with the points `kept`.
    fn reduce_to(&self, group: &Group, most: usize, corners: &mut Vec<usize>, kept: &Choice) {
        let beside = kept.indices().iter().filter(|index| !corners.contains(index)).count();
        if beside >= most {
            return corners.clear();
        }
        reduce(corners, most - beside, kept.indices(), |index| self.place(group, index));
    }

    /// The deepest of a few candidates of a group, or of all if these are less deep.
    fn deepest_of(&self, group: &Group, few: &[usize]) -> usize {
        let depth = |index: usize| self.point(index).point.depth;
        let deepest = few.iter().copied().reduce(|p, q| if depth(q) > depth(p) { q } else { p });
        deepest.filter(|index| depth(*index) >= group.deep).unwrap_or(group.deepest)
    }

    /// The chosen candidates of a group, at most `share`, the deepest first.
    fn choose<'c>(
        &self,
        group: &Group,
        share: usize,
        own: &mut Vec<usize>,
        hulls: &[usize],
        [best, last, without]: &'c mut [Vec<usize>; 3],
    ) -> &'c [usize] {
        let at = |index: usize| self.place(group, index);
        let [start, count] = group.corners;
        best.clear();
        best.extend(hulls.iter().skip(start).take(count));
        let kept = self.reduce(group, share, best, group.rest, without);
        let was_last = |index: &usize| self.candidates.get(*index).is_some_and(|candidate| candidate.last.is_some());
        own.clear();
        own.extend(self.of_group(group.index).filter(was_last));
        hull(own, at, last);
        let rest = self.rest(group, own.iter().copied(), last);
        let kept_of_last = self.reduce(group, share, last, rest, without);
        let left_out = |corners: &[usize], kept: &Choice| self.left_out(group, [corners, kept.indices()]);
        let is_as_good = !last.is_empty()
            && span(last, at).is_at_least(KEPT_AREA, &span(best, at))
            && left_out(last, &kept_of_last).0 <= left_out(best, &kept).0.max(self.may_be_left_out());
        let (chosen, kept) = if is_as_good { (last, kept_of_last) } else { (best, kept) };
        for (rank, index) in kept.indices().iter().enumerate() {
            match chosen.iter().position(|chosen| chosen == index) {
                Some(place) if rank == 0 => chosen.swap(0, place),
                Some(_) => {}
                None if rank == 0 => chosen.insert(0, *index),
                None => chosen.push(*index),
            }
        }
        chosen
    }
}

impl Group {
    /// A place in the plane of the group.
    fn over(&self, place: DVec3) -> DVec2 {
        let [x, y] = self.tangents.map(|tangent| tangent.dot(place));
        DVec2::new(x, y)
    }
}
