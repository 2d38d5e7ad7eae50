//! The contact manifolds of a body on a surface: computed by hullmap, and written to parry's.
//!
//! # Steps
//! 1. If the body has barely moved, keep the points (parry's coherence test).
//! 2. Update hullmap's manifolds of each piece of the body on each tile near it. Tiles that meet
//!    are joined, so normals at their common edges are normals of one surface.
//! 3. Correct normals at internal edges of a body that is a compound.
//! 4. Choose at most eight points for each tile and piece ([`BodyManifold`]), and of these at most
//!    four for each normal, as Rapier would; for a ball, one: others would slow it as it rolls.
//! 5. Write a parry manifold for each piece and face of the surface, with the index of the deepest
//!    triangle. A point that hullmap kept retains the data that the engine stored in it.
//!
//! A manifold for each triangle did not work: Rapier merges manifolds with nearly the same normal,
//! and finds the last impulses by the positions of points on the ground. Bodies that slide or roll
//! would lose them in every step.

use hullmap::compound::seams::{self, Side, Union};
use hullmap::compound::{BodyManifold, BodyPoint, Joined, Tile};
use hullmap::glam::DVec3;
use hullmap::{CompoundManifolds, EdgeClass, Manifold, ManifoldSettings};

use super::super::convert::{double, real, wide};
use super::super::parry::bounding_volume::BoundingVolume as _;
use super::super::parry::math::{Pose, Real};
use super::super::parry::query::{ContactManifold, TrackedContact};
use super::super::surface::{SurfaceTile, on_sheet};
use super::compound_union::CompoundUnion;
use super::manifold::{barely_moved, packed, settings};
use super::pair::Placement;
use super::patches::{PatchPoint, SAME_NORMAL, Supported, deepest, places, thinned};
use super::surface_pair::{Part, SurfacePair};

/// Number of triangles that a piece may touch on a tile before more memory is allocated: 40 KB.
const FEW: usize = 8;

/// Maximum number of triangles of a piece on a tile: 2.5 MB. Those in the last step stay.
const MOST: usize = 512;

/// Part of the prediction by which a body may move before more triangles may be in reach.
const BARELY_MOVED: f64 = 0.25;

/// Cosine of the angle (1e-3) up to which triangles are one face, as in hullmap's correction of
/// normals: their points are in one manifold.
const SAME_FACE: f64 = 1.0 - 5e-7;

/// Width of a seam as a part of the prediction, as in hullmap's correction of normals.
const SEAM: f64 = 0.005;

/// Memory of a pair of a surface and a body from step to step, in a parry workspace.
#[derive(Clone, Default)]
pub(super) struct SurfaceMemory {
    entries: Vec<Entry>,
    written: usize,
    /// The pose of the body in the frame of the surface in the last update.
    last: Option<hullmap::Pose>,
}

#[derive(Clone)]
struct Entry {
    /// Number of the tile's first triangle, and the index of the piece.
    key: (usize, u32),
    capacity: usize,
    manifolds: CompoundManifolds,
    /// The user data of its points are the numbers of the written points, counted from 1.
    body: BodyManifold,
    is_near: bool,
}

struct Point {
    subshapes: [u32; 2],
    /// From the surface to the body, in the frame of the surface.
    normal: DVec3,
    on_surface: DVec3,
    on_body: DVec3,
    found: BodyPoint,
    is_beside: bool,
}

impl SurfaceMemory {
    pub(super) fn update<M, C>(
        &mut self,
        pos12: &Pose,
        pair: &SurfacePair<'_>,
        prediction: Real,
        manifolds: &mut Vec<ContactManifold<M, C>>,
    ) where
        M: Default + Clone,
        C: Default + Copy,
    {
        if self.keeps_points(pos12, pair, prediction, manifolds) {
            return;
        }
        self.last = Some(pair.placement.b_in_a);
        self.update_entries(pair, prediction);
        let points = self.points(pair, SEAM * double(prediction));
        let before = places(manifolds, !pair.placement.flipped);
        let of_patch = |point: &Point| PatchPoint {
            place: point.on_body,
            normal: pair.placement.b_in_a.inverse_transform_vector(-point.normal),
            depth: point.found.point.depth,
        };
        let counted: Vec<&Point> = points.iter().filter(|point| !point.is_beside).collect();
        let patch: Vec<PatchPoint> = counted.into_iter().map(of_patch).collect();
        let stays = if pair.body.as_ball().is_some() {
            deepest(&patch)
        } else {
            thinned(&patch, &before, supported(pair), prediction)
        };
        let mut stays = stays.into_iter();
        let stays: Vec<bool> = points.iter().map(|point| !point.is_beside && stays.next() == Some(true)).collect();
        self.write(&points, &stays, &pair.placement, manifolds);
    }

    /// Whether the body has barely moved, so that the points of `manifolds` stay, with updated
    /// distances.
    fn keeps_points<M, C: Default + Copy>(
        &self,
        pos12: &Pose,
        pair: &SurfacePair<'_>,
        prediction: Real,
        manifolds: &mut [ContactManifold<M, C>],
    ) -> bool {
        let (Some(last), now) = (self.last, pair.placement.b_in_a) else { return false };
        let bounds = pair.body.compute_local_aabb();
        let farthest = double(bounds.mins.abs().max(bounds.maxs.abs()).length());
        let half_turn = (last.rotation().conjugate() * now.rotation()).xyz().length();
        let moved = now.translation().distance(last.translation()) + 2.0 * half_turn * farthest;
        // NaN takes the failing branch.
        if !(moved <= BARELY_MOVED * double(prediction)) {
            return false;
        }
        let mut touching = manifolds.iter_mut().filter(|manifold| !manifold.points.is_empty()).peekable();
        touching.peek().is_some() && touching.all(|manifold| barely_moved(pos12, manifold))
    }

    fn update_entries(&mut self, pair: &SurfacePair<'_>, prediction: Real) {
        for entry in &mut self.entries {
            entry.is_near = false;
        }
        let around = pair.body_bounds().loosened(prediction);
        let near: Vec<&SurfaceTile> =
            pair.surface.tiles().iter().filter(|tile| tile.bounds().intersects(&around)).collect();
        let tiles: Vec<Tile<'_>> =
            near.iter().map(|tile| Tile { union: *tile, parts: tile.triangle_count(), place: tile.place() }).collect();
        let (joined, settings, of_body) =
            (Joined::new(&tiles), settings(prediction), CompoundUnion::from_shape(pair.body));
        for part in pair.parts() {
            let Some(index) = near.iter().position(|tile| std::ptr::eq(*tile, part.tile)) else { continue };
            let shape = part.piece.shape();
            let center = part.b_in_a.transform_point(shape.interior_point());
            let reach = shape.outer_radius() + double(prediction);
            if !part.tile.any_near(center, reach, &mut |_| true) {
                continue;
            }
            let joined = (tiles.len() > 1).then_some((&joined, index));
            let entry = self.entry((part.tile.first(), part.piece.subshape));
            entry.update(&OnTile { part: &part, joined, settings: &settings }, of_body.as_ref());
        }
        self.entries.retain(|entry| entry.is_near);
    }

    fn entry(&mut self, key: (usize, u32)) -> &mut Entry {
        let found = self.entries.iter().position(|entry| entry.key == key);
        let index = found.unwrap_or_else(|| {
            let (manifolds, body) = (CompoundManifolds::new(FEW), BodyManifold::new(FEW));
            self.entries.push(Entry { key, capacity: FEW, manifolds, body, is_near: true });
            self.entries.len() - 1
        });
        #[expect(clippy::indexing_slicing, reason = "found, or just pushed")]
        &mut self.entries[index]
    }

    fn points(&self, pair: &SurfacePair<'_>, seam: f64) -> Vec<Point> {
        let mut points = Vec::new();
        for entry in &self.entries {
            let is_of = |part: &Part<'_>| entry.key == (part.tile.first(), part.piece.subshape);
            let Some(part) = pair.parts().find(is_of) else { continue };
            let place = part.tile.place();
            points.extend(entry.body.points().iter().map(|found| Point {
                subshapes: part.subshapes(found.pair[0] as u32),
                normal: snapped(place.transform_vector(found.normal), part.tile.normal(found.pair[0])),
                on_surface: place.transform_point(found.point.point_a),
                on_body: part.piece.place.transform_point(found.point.local_b),
                found: *found,
                is_beside: is_beside(found, part.tile, seam),
            }));
        }
        points
    }

    /// Replaces the manifolds by manifolds of the points that stay.
    fn write<M, C>(
        &mut self,
        points: &[Point],
        stays: &[bool],
        placement: &Placement,
        manifolds: &mut Vec<ContactManifold<M, C>>,
    ) where
        M: Default + Clone,
        C: Default + Copy,
    {
        let mut old = std::mem::take(manifolds);
        let old_points: Vec<C> = old.iter().flat_map(|manifold| &manifold.points).map(|point| point.data).collect();
        // If the engine has changed the points, all of them count as new.
        let is_ours = old_points.len() == self.written;
        let mut numbers = Vec::new();
        for (point, stays) in points.iter().zip(stays) {
            if !stays {
                numbers.push(None);
                continue;
            }
            let [subshape1, subshape2] = in_order(placement, point.subshapes);
            let [normal1, normal2] = placement.normals(point.normal);
            let of_body = |manifold: &ContactManifold<M, C>| {
                if placement.flipped { manifold.subshape1 == subshape1 } else { manifold.subshape2 == subshape2 }
            };
            let angle = |manifold: &ContactManifold<M, C>| double(manifold.local_n1.dot(normal1));
            let is_same = |manifold: &ContactManifold<M, C>| of_body(manifold) && angle(manifold) >= SAME_FACE;
            let index = manifolds.iter().position(is_same).unwrap_or_else(|| {
                let was = |manifold: &ContactManifold<M, C>| of_body(manifold) && angle(manifold) >= SAME_NORMAL;
                let known = old.iter().position(was).map(|index| old.swap_remove(index));
                let mut manifold = known.unwrap_or_else(ContactManifold::new);
                manifold.points.clear();
                (manifold.subshape1, manifold.subshape2) = (subshape1, subshape2);
                (manifold.local_n1, manifold.local_n2) = (normal1, normal2);
                manifolds.push(manifold);
                manifolds.len() - 1
            });
            let Some(manifold) = manifolds.get_mut(index) else { continue };
            let [local_p1, local_p2] = placement.order(point.on_surface, point.on_body);
            let id = point.found.point.id;
            let [fid1, fid2] = in_order(placement, [packed(id.on_a()), packed(id.on_b())]);
            let mut contact = TrackedContact::new(local_p1, local_p2, fid1, fid2, real(-point.found.point.depth));
            let number = (point.found.point.user_data as usize).checked_sub(1).filter(|_| is_ours);
            if let Some(data) = number.and_then(|number| old_points.get(number)) {
                contact.data = *data;
            }
            manifold.points.push(contact);
            numbers.push(Some([index, manifold.points.len() - 1]));
        }
        self.number(manifolds, &numbers);
    }

    /// Marks the points of all entries with their places among the written ones, counted from 1: a
    /// manifold and a point in it. 0 marks a point that was not written.
    fn number<M, C>(&mut self, manifolds: &[ContactManifold<M, C>], written: &[Option<[usize; 2]>]) {
        let mut before = vec![0];
        for manifold in manifolds {
            before.push(before.last().copied().unwrap_or(0) + manifold.points.len());
        }
        self.written = before.last().copied().unwrap_or(0);
        let mut written = written.iter();
        for point in self.entries.iter_mut().flat_map(|entry| entry.body.points_mut()) {
            let place = written.next().copied().flatten();
            let number = place.and_then(|[manifold, point]| Some(before.get(manifold)? + point + 1));
            point.point.user_data = number.unwrap_or(0) as u64;
        }
    }
}

fn in_order<T>(placement: &Placement, [of_surface, of_body]: [T; 2]) -> [T; 2] {
    if placement.flipped { [of_body, of_surface] } else { [of_surface, of_body] }
}

/// Replaces a normal that deviates little by the normal of the triangle: Rapier counts both as one,
/// and a body that rolls over many edges would be slowed down by small deviations.
fn snapped(normal: DVec3, face: Option<DVec3>) -> DVec3 {
    match face {
        Some(face) if normal.dot(face) >= SAME_NORMAL => face,
        Some(face) if normal.dot(face) <= -SAME_NORMAL => -face,
        _ => normal,
    }
}

/// Whether a point that does not touch yet is beside its triangle, at a flat or concave edge: the
/// triangle beyond it is nearer. Gaps up to `seam` are ignored.
fn is_beside(found: &BodyPoint, tile: &SurfaceTile, seam: f64) -> bool {
    let triangle = found.pair[0];
    let parts = (tile.triangle(triangle), tile.local_normal(triangle), tile.edge_classes(triangle));
    let (Some(shape), Some(face), Some(classes)) = parts else { return false };
    if found.point.depth >= 0.0 || found.normal.dot(face).abs() >= SAME_NORMAL {
        return false;
    }
    let [a, b, c] = shape.corners();
    let distance = |from: DVec3, to: DVec3| {
        let (along, offset) = (to - from, found.point.point_a - from);
        let share = (offset.dot(along) / along.length_squared()).clamp(0.0, 1.0);
        offset.distance(along * share)
    };
    let edges = [distance(a, b), distance(b, c), distance(c, a)];
    let mut near = edges.iter().zip(classes).filter(|(distance, _)| **distance <= seam).peekable();
    near.peek().is_some() && near.all(|(_, class)| matches!(class, EdgeClass::Flat | EdgeClass::Concave))
}

struct OnTile<'t> {
    part: &'t Part<'t>,
    /// The tiles near the body, and the index of this one.
    joined: Option<(&'t Joined<'t>, usize)>,
    settings: &'t ManifoldSettings,
}

impl Entry {
    /// Updates the manifolds, and chooses points. `of_body` is the compound that the piece is in.
    fn update(&mut self, on_tile: &OnTile<'_>, of_body: Option<&CompoundUnion<'_>>) {
        self.is_near = true;
        let before: Vec<([usize; 2], Manifold)> = match of_body {
            Some(_) => self.manifolds.iter().map(|(pair, manifold)| (pair, manifold.clone())).collect(),
            None => Vec::new(),
        };
        while on_tile.update(&mut self.manifolds) > 0 && self.capacity < MOST {
            self.capacity *= 2;
            self.manifolds = CompoundManifolds::new(self.capacity);
        }
        if let Some(union) = of_body {
            on_tile.weld(&mut self.manifolds, &before, union);
        }
        self.body.update(&self.manifolds);
    }
}

impl OnTile<'_> {
    /// Updates the manifolds of all triangles. Returns the number of triangles without memory.
    fn update(&self, manifolds: &mut CompoundManifolds) -> u32 {
        let Self { part: Part { tile, piece, b_in_a }, joined, settings } = self;
        let shape = piece.shape();
        let counts = match joined {
            Some((joined, index)) => {
                on_sheet!(tile, sheet => manifolds.update_joined(joined, *index, sheet, shape, *b_in_a, settings))
            }
            None => manifolds.update(*tile, shape, *b_in_a, settings),
        };
        counts.dropped
    }

    /// Corrects normals at internal edges of the compound that the piece is in.
    fn weld(&self, manifolds: &mut CompoundManifolds, before: &[([usize; 2], Manifold)], union: &CompoundUnion<'_>) {
        let Self { part: Part { tile, piece, b_in_a }, settings, .. } = self;
        let new = Manifold::new();
        for (pair, manifold) in manifolds.iter_mut() {
            let Some(triangle) = tile.triangle(pair[0]) else { continue };
            let before = before.iter().find(|(old, _)| *old == pair).map_or(&new, |(_, manifold)| manifold);
            let a = Side { shape: &triangle, union: Some((*tile as &dyn Union, pair[0], hullmap::Pose::IDENTITY)) };
            let b = Side { shape: piece.shape(), union: union.part(piece.subshape as usize) };
            seams::weld(manifold, before, &a, &b, *b_in_a, settings);
        }
    }
}

/// The body that the points support, in its own frame.
fn supported(pair: &SurfacePair<'_>) -> Supported {
    if let [piece] = pair.pieces.as_slice() {
        let shape = piece.shape();
        let center = piece.place.transform_point(shape.interior_point());
        return Supported { center, radius: shape.outer_radius() };
    }
    let ball = pair.body.compute_local_bounding_sphere();
    Supported { center: wide(ball.center), radius: double(ball.radius) }
}
