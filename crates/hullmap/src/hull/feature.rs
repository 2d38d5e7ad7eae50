//! The feature of a hull that faces a direction: a face, an edge or a vertex, found through the
//! direction index.
//!
//! [`Shape::feature`] uses the direction alone:
//! 1. If every edge at the support vertex falls by more than [`TILT`], the feature is that vertex.
//!    If all edges but one do, at both ends of that one, the feature is that edge.
//! 2. Otherwise, support queries in eight directions, tilted to all sides. Take the face at the
//!    support vertex whose normal is closest to the direction. If all eight answers are its
//!    corners, its corners are the feature, exactly.
//! 3. Otherwise the support points in [`MAX_CORNERS`] tilted directions. This happens for several
//!    faces (f32 can break a flat cap into slivers), and for a face with more corners than a
//!    feature holds.
//!
//! [`Shape::feature_within`] also uses the heights that matter:
//! 1. As above, if all neighbours of the vertex, or of the edge, are also farther below the support
//!    plane than the reach. Then no face has three corners within reach.
//! 2. Find the face at the support vertex whose normal n is closest to the direction. If fewer than
//!    three of its corners are within reach of the support plane, and its tilt is above [`TILT`],
//!    the feature is found by the directions above.
//! 3. Otherwise the feature is that face, merged with the faces around it that are nearly in its
//!    plane: the support points in directions tilted from n by [`TILT`]. If one of them is more
//!    than [`MERGED_SHARE`] of the reach below the plane, tilt by less: a support point at the
//!    distance l from the face, in a direction tilted by the tangent t, is at most t l below the
//!    plane.
//!
//! No ring of directions is needed if every edge that leaves the face falls by more than [`TILT`]:
//! then the face alone is the feature. [`Shape::reduced_feature_within`] returns its
//! best four corners, which the pack stores.
//!
//! So the tilt towards the *direction* is limited by the reach, and the tilt towards *each other*
//! of merged faces by the flatness that a contact patch needs. Decision 13 has the measurements.
//!
//! No step scans all faces, and the cost does not grow with the number of a face's corners beyond
//! [`MAX_CORNERS`].

#![forbid(unsafe_code)]

use super::Hull;
use super::entry::Walk;
use crate::shapes::feature::{COARSE, Cone, KeptFace, NO_REACH, coarse_ring, refine};
use crate::shapes::{Corner, Feature, MAX_CORNERS, Shape, TILT};
use crate::solver::Ray;
use crate::solver::ray::entry;
use crate::support::{SupportMap, SupportPoint};
use crate::vector::unit;
use glam::{DVec3, Vec3};
use hullmap_format::archive::ArchivedQuad;

/// Faces are merged into the feature of [`Shape::feature_within`] if their corners are at most this
/// fraction of the reach below the plane of the face closest to the direction.
///
/// A quarter: the height of a point that was found on the merged plane is then uncertain by a
/// quarter of the prediction, which is of the order of the depth that engines leave uncorrected. A
/// smaller share puts real meshes to sleep less often, a larger one makes no difference.
const MERGED_SHARE: f64 = 0.25;

/// A vertex with more faces than this, for instance the tip of a cone, is not searched for the face
/// closest to a direction. Only the faces at the edges to support points nearby are considered, and
/// a sample of this many others.
const MAX_FACES: usize = 64;

impl Shape for Hull<'_> {
    /// A baked face, or an edge, or a vertex. Faces within [`TILT`] of `dir` are merged.
    ///
    /// An engine that has a prediction passes it to [`feature_within`](Shape::feature_within). An
    /// engine that has none, and wants a face in any case, passes [`f64::INFINITY`].
    ///
    /// # Complexity
    /// For a vertex or an edge, one support query, and the edges there. For a face of at most
    /// [`MAX_CORNERS`] corners, 9 support queries and one normal for each face at the support
    /// vertex. Otherwise at most 34 support queries.
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        self.feature_at(dir, self.top(dir), out);
    }

    /// The face closest to `dir` if three of its corners are at most `reach` below the support
    /// plane, otherwise as [`feature`](Shape::feature).
    ///
    /// Faces around it are merged into it if their normals are within [`TILT`] of its normal, and
    /// their corners at most a quarter of `reach` below its plane.
    ///
    /// With an infinite `reach` the answer for a solid or a polygon is always a face, merged with
    /// those within [`TILT`] of it. Adapters of engines that do not pass a prediction use that.
    ///
    /// # Complexity
    /// At most 49 support queries, and at most 80 normals: one for each face at the support vertex,
    /// or for a sample of them.
    fn feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        self.facing(dir, reach, Corners::All, out);
    }

    /// The four corners of the face that span the largest area, which the pack stores, if it has
    /// more than four and no faces are merged into it.
    ///
    /// # Complexity
    /// If the surface falls away from the face by more than [`TILT`], one support query, and one
    /// normal for each face at its vertex. Otherwise as
    /// [`feature_within`](Shape::feature_within).
    fn reduced_feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        self.facing(dir, reach, Corners::Four, out);
    }

    /// By a walk over the faces from those at `near`, or by support queries if the walk is long.
    ///
    /// # Complexity
    /// At most 64 edges; beyond that, as [`ray`](crate::ray()).
    fn entry(&self, ray: &Ray, near: u32, until: f64) -> Option<f64> {
        match self.walk(ray, near, until) {
            Walk::Entry(t) => Some(t),
            Walk::Miss => None,
            Walk::Open => entry(self, ray),
        }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Corners {
    /// Up to [`MAX_CORNERS`].
    All,
    /// The four that span the largest area.
    Four,
}

/// Corners of one face are in one plane up to this fraction of the outer radius: the rounding error
/// of f32, and of the merging of coplanar triangles when the hull was built.
const ROUGHNESS: f64 = 1e-6;

/// A unit direction, and the support point there.
type Top = (DVec3, SupportPoint);

impl Hull<'_> {
    /// The unit vector along `dir`, and its support point; `None` if `dir` has no direction.
    fn top(&self, dir: DVec3) -> Option<Top> {
        unit(dir).map(|n| (n, SupportMap::support_point(self, n)))
    }

    /// The vertex or the edge at `vertex`, the support point of the unit vector `n`, into `out`.
    /// Returns false if the feature may be more than that: if more than one neighbour, at either
    /// end of the edge, falls by at most [`TILT`] or is at most `reach` below the vertex.
    ///
    /// The support point in a tilted direction is where no edge rises, since the hull is convex.
    ///
    /// # Complexity
    /// At most 2 × [`MAX_FACES`] edges; with more edges than that the answer is `false`.
    fn sharp_feature(&self, n: DVec3, vertex: u32, reach: f64, out: &mut Feature) -> bool {
        let Some(top) = self.vertex(vertex).map(Vec3::as_dvec3) else { return false };
        let Some((mut fall, beside)) = self.falls(n, (vertex, top), (None, top), reach) else { return false };
        out.clear();
        out.push(Corner { point: top, vertex });
        if let Some((w, end)) = beside {
            let Some((beyond, None)) = self.falls(n, (w, end), (Some(vertex), top), reach) else { return false };
            if is_steep(top - end, n) {
                fall = fall.min(tangent(top - end, n));
            } else {
                fall = fall.min(beyond);
                out.push(Corner { point: end, vertex: w });
            }
        }
        out.set_fall(fall);
        out.set_flat();
        true
    }

    /// The one neighbour of a vertex, other than `known`, that falls by at most [`TILT`] along the
    /// unit vector `n`, or is at most `reach` below `top`; and the least tangent by which the edges
    /// to the others fall. `None` if there are more than one.
    fn falls(
        &self,
        n: DVec3,
        (vertex, place): (u32, DVec3),
        (known, top): (Option<u32>, DVec3),
        reach: f64,
    ) -> Option<(f64, Option<(u32, DVec3)>)> {
        let neighbours = self.neighbours(vertex);
        // Lean hulls have no neighbours.
        if !(1..=MAX_FACES).contains(&neighbours.len()) {
            return None;
        }
        // The edge that falls least.
        let mut lowest = n;
        let mut beside = None;
        for w in neighbours {
            if known == Some(w) {
                continue;
            }
            let end = self.vertex(w)?.as_dvec3();
            let edge = place - end;
            let below = edge.dot(n);
            // NaN takes the branch of a neighbour beside.
            if !((top - end).dot(n) > reach && is_steep(edge, n)) {
                if beside.is_some() {
                    return None;
                }
                beside = Some((w, end));
            } else if below * below * lowest.length_squared() < lowest.dot(n) * lowest.dot(n) * edge.length_squared() {
                lowest = edge;
            }
        }
        Some((tangent(lowest, n), beside))
    }

    /// [`Shape::feature`]. `top` is [`Self::top`].
    fn feature_at(&self, dir: DVec3, top: Option<Top>, out: &mut Feature) {
        if top.is_some_and(|(n, top)| self.sharp_feature(n, top.feature, NO_REACH, out)) {
            return;
        }
        let cone = Cone::new(dir, TILT);
        let around = coarse_ring(self, &cone);
        if !self.baked_face(top, &around, out) {
            refine(self, &cone, around, out);
            self.mark_flat(out);
        }
    }

    /// [`Shape::feature_within`] and [`Shape::reduced_feature_within`].
    fn facing(&self, dir: DVec3, reach: f64, wanted: Corners, out: &mut Feature) {
        if let Some((n, face)) = unit(dir).zip(out.kept.lone_face())
            && self.still_faces(face, n)
            && self.own_corners(face, wanted, out)
        {
            return;
        }
        let top = self.top(dir);
        if top.is_some_and(|(n, top)| self.sharp_feature(n, top.feature, reach, out)) {
            return;
        }
        let facing = top.and_then(|top| self.face_within(top, reach));
        let Some((face, normal)) = facing else { return self.feature_at(dir, top, out) };
        // NaN and negative values count as 0. The rounding error of the face's own corners is far
        // below the second term.
        let flat = (MERGED_SHARE * reach).max(ROUGHNESS * self.outer_radius());
        let kept = out.kept;
        if let Some(vertices) = kept.vertices(face, flat)
            && if vertices.is_empty() { self.own_corners(face, wanted, out) } else { self.corners_of(vertices, out) }
        {
            return;
        }
        // Support points in all directions near the normal are corners of the face.
        if self.stands_alone(face, normal) && self.own_corners(face, wanted, out) {
            out.kept = KeptFace::lone(face);
            return;
        }
        self.merge((face, normal), flat, wanted, out);
        out.kept = KeptFace::merged(face, flat, out);
    }

    /// The feature of a face and of the faces around it that are at most `flat` below its plane.
    fn merge(&self, (face, normal): (u32, DVec3), flat: f64, wanted: Corners, out: &mut Feature) {
        let on_face = self.face(face).next().and_then(|vertex| self.vertex(vertex));
        let on_face = on_face.map_or(DVec3::ZERO, Vec3::as_dvec3);
        let below = |point: DVec3| (on_face - point).dot(normal);
        let mut cone = Cone::new(normal, TILT);
        let mut around = coarse_ring(self, &cone);
        if around.iter().any(|support| below(support.point) > flat) {
            let extent = around.iter().map(|support| support.point.distance(on_face)).fold(0.0, f64::max);
            cone = Cone::new(normal, TILT.min(flat / extent));
            around = coarse_ring(self, &cone);
        }
        let is_own = around.iter().all(|support| self.has_corner(face, support.feature));
        if is_own && self.own_corners(face, wanted, out) {
            return;
        }
        refine(self, &cone, around, out);
        // Between the eight directions of `around`, a support point may be farther out.
        out.retain(|corner| below(corner.point) <= flat);
        // The directions may miss a corner of a needle, which is farthest in few of them.
        let mut own = Feature::new();
        if self.own_corners(face, wanted, &mut own) && area(out, normal) < area(&own, normal) {
            *out = own;
        } else {
            self.mark_flat(out);
        }
    }

    /// Marks a feature as flat if it is a vertex or an edge of the hull.
    fn mark_flat(&self, out: &mut Feature) {
        let is_flat = match out.corners() {
            [] | [_] => true,
            [a, b] => self.neighbours(a.vertex).any(|vertex| vertex == b.vertex),
            _ => false,
        };
        if is_flat {
            out.set_flat();
        }
    }

    /// Whether a face that [stands alone](Self::stands_alone) is the closest to the unit vector
    /// `n`: the normals of the faces beside it are tilted from its own by more than [`TILT`].
    fn still_faces(&self, face: u32, n: DVec3) -> bool {
        // NaN takes the failing branch.
        self.face_normal(face).is_some_and(|normal| normal.dot(n) > 0.0 && normal.cross(n).length() <= 0.5 * TILT)
    }

    /// Whether every edge that leaves `face` falls by more than [`TILT`], so that the support point
    /// in every direction this close to its normal is on the face.
    ///
    /// # Complexity
    /// A binary search for a face with more than four corners. For another one, at most
    /// [`MAX_FACES`] edges; with more edges than that the answer is `false`.
    fn stands_alone(&self, face: u32, normal: DVec3) -> bool {
        if let Some(quad) = self.quad(face) {
            return f64::from(quad.fall.to_native()) > TILT;
        }
        let corners = self.face(face);
        if corners.len() > 4 || corners.map(|corner| self.neighbours(corner).len()).sum::<usize>() > MAX_FACES {
            return false;
        }
        // A polygon has no edges that leave its face.
        self.face(face).all(|corner| {
            let Some(v) = self.vertex(corner) else { return false };
            let falls = |w: u32| {
                let edge = self.vertex(w).map_or(DVec3::NAN, |w| (v - w).as_dvec3());
                // NaN takes the failing branch.
                edge.dot(normal) > TILT * edge.length()
            };
            self.neighbours(corner).all(|w| falls(w) || self.face(face).any(|own| own == w))
        })
    }

    /// The stored four corners of a face with more than four, and its fall.
    fn quad(&self, face: u32) -> Option<&ArchivedQuad> {
        let at = self.quads.binary_search_by_key(&face, |quad| quad.face.to_native()).ok()?;
        self.quads.get(at)
    }

    /// Puts all corners of `face` into `out`, or the stored four if four are requested and the face
    /// has more. Returns false if there are too many.
    fn own_corners(&self, face: u32, wanted: Corners, out: &mut Feature) -> bool {
        match self.quad(face).filter(|_| wanted == Corners::Four) {
            Some(quad) => self.quad_corners(face, quad, out),
            None => self.face_corners(face, out),
        }
    }

    /// Puts the stored four corners of `face` into `out`.
    fn quad_corners(&self, face: u32, quad: &ArchivedQuad, out: &mut Feature) -> bool {
        out.clear();
        let corners = self.face_run(face);
        for at in quad.corners {
            let Some(vertex) = corners.get(at.to_native() as usize).map(|v| v.to_native()) else { return false };
            let Some(point) = self.vertex(vertex) else { return false };
            out.push(Corner { point: point.as_dvec3(), vertex });
        }
        out.set_reduced();
        out.set_flat();
        true
    }

    /// Whether `vertex` is a corner of `face`, by the faces at the vertex, or by the corners of the
    /// face if these are fewer. `false` if both have more than [`MAX_FACES`].
    fn has_corner(&self, face: u32, vertex: u32) -> bool {
        let corners = self.face(face);
        let at = self.faces_at(vertex);
        if corners.len().min(at.len()) > MAX_FACES {
            false
        } else if corners.len() < at.len() {
            corners.into_iter().any(|corner| corner == vertex)
        } else {
            at.into_iter().any(|other| other == face)
        }
    }

    /// The face at the support vertex of n whose normal is closest to n, and its normal, if three
    /// of its corners are at most `reach` below the support plane, or its normal is within [`TILT`]
    /// of n.
    fn face_within(&self, (n, top): Top, reach: f64) -> Option<(u32, DVec3)> {
        let faces = self.faces_at(top.feature);
        let closest = |faces: &mut dyn Iterator<Item = u32>| {
            let mut best = (f64::NEG_INFINITY, None);
            for face in faces {
                if let Some(normal) = self.face_normal(face)
                    && normal.dot(n) > best.0
                {
                    best = (normal.dot(n), Some((face, normal)));
                }
            }
            best.1
        };
        let (face, normal) = if faces.len() <= MAX_FACES {
            closest(&mut faces.into_iter())
        } else {
            // Just wide enough to find an edge within reach.
            #[expect(clippy::manual_clamp, reason = "NaN becomes the minimum; `clamp` would keep it")]
            let wide = (reach / self.outer_radius()).max(TILT).min(1.0);
            let around = coarse_ring(self, &Cone::new(n, wide));
            let beside = around.iter().flat_map(|support| self.faces_beside(top.feature, support.feature)).flatten();
            let step = faces.len().div_ceil(MAX_FACES);
            closest(&mut beside.chain(faces.step_by(step)))
        }?;
        let height = top.point.dot(n);
        let is_near = |vertex: u32| self.vertex(vertex).is_some_and(|p| height - p.as_dvec3().dot(n) <= reach);
        let corners = self.face(face);
        // Sample a large face.
        let step = corners.len().div_ceil(MAX_CORNERS).max(1);
        let near = || corners.step_by(step).filter(|vertex| is_near(*vertex)).count();
        // NaN takes the failing branch.
        (normal.cross(n).length() <= TILT || near() >= 3).then_some((face, normal))
    }

    /// The faces on both sides of the edge between two vertices; nothing if there is no such edge.
    fn faces_beside(&self, v: u32, w: u32) -> [Option<u32>; 2] {
        [self.face_left_of(v, w), self.face_left_of(w, v)]
    }

    /// Puts the corners of `face` into `out`. Returns false if there are more than
    /// [`MAX_CORNERS`].
    fn face_corners(&self, face: u32, out: &mut Feature) -> bool {
        out.clear();
        let corners = self.face(face);
        if corners.len() > MAX_CORNERS {
            return false;
        }
        for vertex in corners {
            let Some(point) = self.vertex(vertex) else { return false };
            out.push(Corner { point: point.as_dvec3(), vertex });
        }
        out.set_flat();
        true
    }

    /// Puts these vertices into `out`. Returns false if there is no such vertex.
    fn corners_of(&self, vertices: &[u32], out: &mut Feature) -> bool {
        out.clear();
        for &vertex in vertices {
            let Some(point) = self.vertex(vertex) else { return false };
            out.push(Corner { point: point.as_dvec3(), vertex });
        }
        true
    }

    /// Puts the corners of the face towards the direction of `top` into `out`. Returns false if the
    /// support points `around` the direction are not all corners of that face.
    fn baked_face(&self, top: Option<Top>, around: &[SupportPoint; COARSE], out: &mut Feature) -> bool {
        out.clear();
        if around.iter().all(|support| support.feature == around[0].feature) {
            return false;
        }
        let facing = top.and_then(|top| self.face_within(top, NO_REACH));
        let around = around.iter().map(|support| support.feature);
        facing.is_some_and(|(face, _)| self.face_corners(face, out) && contains_all(out, around))
    }
}

/// Whether an edge, from its upper end, falls so much along the unit vector `n` that it also falls
/// in all directions within [`TILT`] of `n`.
fn is_steep(edge: DVec3, n: DVec3) -> bool {
    let below = edge.dot(n);
    // The tangent of its fall is below / √(edge² − below²).
    below > 0.0 && below * below * (1.0 + TILT * TILT) > TILT * TILT * edge.length_squared()
}

/// The tangent of the angle by which an edge, from its upper end, falls along the unit vector `n`.
fn tangent(edge: DVec3, n: DVec3) -> f64 {
    let below = edge.dot(n);
    below / (edge - n * below).length()
}

/// Twice the area of the feature, projected along `normal`.
fn area(feature: &Feature, normal: DVec3) -> f64 {
    let [origin, rest @ ..] = feature.corners() else { return 0.0 };
    let sides = rest.windows(2).filter_map(|pair| pair.first().zip(pair.last()));
    sides.map(|(p, q)| (p.point - origin.point).cross(q.point - origin.point)).sum::<DVec3>().dot(normal).abs()
}

fn contains_all(feature: &Feature, mut vertices: impl Iterator<Item = u32>) -> bool {
    vertices.all(|vertex| feature.corners().iter().any(|corner| corner.vertex == vertex))
}

#[cfg(test)]
mod tests {
    use ::shapes::families::Family;
    use ::shapes::rng::SplitMix64;
    use hullmap_testkit::packs::tree_bytes;

    use super::*;
    use crate::Pack;
    use crate::shapes::feature::ring;

    const SEED: u64 = 20_261_201;

    fn hulls(mut judge: impl FnMut(&Hull<'_>, &mut SplitMix64, &str)) {
        let mut rng = SplitMix64::new(SEED);
        for family in [Family::Sphere, Family::Rock, Family::ClusteredEllipsoid, Family::Prism] {
            for count in [8, 40, 400] {
                let pack = Pack::from_bytes(&tree_bytes(&family.points(count, 3))).unwrap();
                judge(&pack.hull(0).unwrap(), &mut rng, &format!("{family:?} {count}, seed {SEED}"));
            }
        }
    }

    fn vertices(feature: &Feature) -> Vec<u32> {
        let mut vertices: Vec<u32> = feature.corners().iter().map(|corner| corner.vertex).collect();
        vertices.sort_unstable();
        vertices
    }

    /// The edge from the support point of the unit vector `dir` to a vertex.
    fn top(hull: &Hull<'_>, vertex: u32, dir: DVec3) -> DVec3 {
        SupportMap::support_point(hull, dir).point - hull.vertex(vertex).unwrap().as_dvec3()
    }

    /// Beside the ring of support queries, and along directions tilted by up to the fall.
    #[test]
    fn vertices_and_edges_by_their_edges_are_those_by_support_queries() {
        let [mut corners, mut edges] = [0, 0];
        hulls(|hull, rng, name| {
            for _ in 0..200 {
                let vertex = rng.below(hull.vertex_count()) as u32;
                let Some(next) = hull.neighbours(vertex).next() else { continue };
                // Towards a vertex, or the middle of an edge, seen from the inside.
                let [from, to] = [vertex, next].map(|v| hull.vertex(v).unwrap().as_dvec3() - hull.interior_point());
                let dir = from.lerp(to, 0.5 * rng.below(2) as f64).normalize();
                let mut found = Feature::new();
                hull.feature(dir, &mut found);
                if found.fall() == 0.0 {
                    continue;
                }
                let mut queried = Feature::new();
                ring(hull, dir, &mut queried);
                // Between two of its first eight directions, the ring misses an edge that falls by
                // nearly the angle.
                let [of_edges, of_queries] = [&found, &queried].map(vertices);
                let is_missed = |v: &u32| of_queries.contains(v) || tangent(top(hull, *v, dir), dir) > 0.92 * TILT;
                assert!(of_queries.iter().all(|v| of_edges.contains(v)), "{name}, {dir}");
                assert!(of_edges.iter().all(is_missed), "{name}, {dir}: {of_edges:?} {of_queries:?}");
                *[&mut corners, &mut edges][found.corners().len() - 1] += 1;
                let cone = Cone::new(dir, found.fall() * (1.0 - 1e-9));
                for step in 0..32 {
                    let support = SupportMap::support_point(hull, cone.tilted(step));
                    assert!(vertices(&found).contains(&support.feature), "{name}, {dir}, step {step}");
                }
            }
        });
        assert!(corners > 300 && edges > 100, "{corners} vertices, {edges} edges");
    }

    /// A feature that is taken again from the last one, beside a new one.
    #[test]
    fn kept_faces_have_the_corners_of_new_ones() {
        let [mut lone, mut merged, mut others] = [0, 0, 0];
        hulls(|hull, rng, name| {
            for _ in 0..60 {
                let face = rng.below(hull.face_count()) as u32;
                let (mut dir, mut kept) = (hull.face_normal(face).unwrap(), Feature::new());
                let reach = hull.outer_radius() * [0.02, 0.1][rng.below(2)];
                for frame in 0..6 {
                    let before = kept.kept;
                    hull.reduced_feature_within(dir, reach, &mut kept);
                    let mut new = Feature::new();
                    hull.reduced_feature_within(dir, reach, &mut new);
                    assert_eq!((kept.corners(), kept.is_flat()), (new.corners(), new.is_flat()), "{name}, {frame}");
                    let is_again = before == kept.kept || before.lone_face() == kept.kept.lone_face();
                    let count = match before.lone_face() {
                        _ if before == KeptFace::NONE || !is_again => &mut others,
                        Some(_) => &mut lone,
                        None => &mut merged,
                    };
                    *count += 1;
                    dir = (dir + DVec3::from_array(rng.direction()) * 0.003).normalize();
                }
            }
        });
        assert!(lone > 400 && merged > 400 && others > 400, "{lone} alone, {merged} merged, {others} others");
    }

    /// A manifold of parts is used for another part.
    #[test]
    fn flat_features_are_faces_whatever_is_kept() {
        let packs = [3, 4].map(|seed| Pack::from_bytes(&tree_bytes(&Family::Sphere.points(40, seed))).unwrap());
        let [x, y] = packs.each_ref().map(|pack| pack.hull(0).unwrap());
        let mut flat = 0;
        for other in 0..x.face_count().min(y.face_count()) as u32 {
            let mut found = Feature::new();
            x.feature_within(x.face_normal(other).unwrap(), 0.1, &mut found);
            y.feature_within(y.face_normal(other).unwrap(), 0.1, &mut found);
            if found.is_flat() && found.corners().len() > 2 {
                let is_face =
                    |face: u32| contains_all(&found, y.face(face)) && y.face(face).len() == found.corners().len();
                assert!((0..y.face_count() as u32).any(is_face), "face {other}: {found:?}");
                flat += 1;
            }
        }
        assert!(flat > 20, "{flat}");
    }
}
