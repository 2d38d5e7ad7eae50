//! Points that manifolds of sheets must have, and those that [`BodyManifold`] chooses.
//!
//! | claim | truth |
//! |---|---|
//! | parts that clearly touch have a point about as deep as the contact, and none deeper | the bounds of the contact and distance queries of the pair; for half-spaces, the corners |
//! | a triangle that a body is behind is left out if only fronts collide | the side of the body's interior point |
//! | a body that clearly touches a sheet has a point, also where edges are welded | the same bounds |
//! | the points under a box on a level sheet span its lower face, and are as deep | the corners of the box |
//! | chosen points are points of the manifolds, one of them about the deepest, and keep their age | the manifolds |
//! | they span 60 % of the area of all points, if all normals are about equal | area of the convex hull, without slight ears |
//!
//! [`BodyManifold`]: hullmap::compound::BodyManifold

use glam::{DVec2, DVec3};
use hullmap::compound::{BodyPoint, MAX_BODY_POINTS};
use hullmap::manifold::{Manifold, ManifoldPoint};
use hullmap::shapes::Triangle;
use hullmap::{Cache, CompoundManifolds, Settings};
use hullmap_testkit::triangles::distance_from_triangle;

use super::manifolds::{Judge, Way};
use super::tally::Tally;

/// Points may be less deep than the contact by this share of the prediction.
const SLIGHT: f64 = 0.1;

/// Depths may differ by this share of the smaller outer radius in any case.
const SAME_DEPTH: f64 = 1e-4;

/// A pair is extreme if its smaller outer radius is less than this share of the larger one. The
/// soak of manifolds has the same limit.
const EXTREME: f64 = 1e-3;

/// A body that is deeper in a triangle than this share of the smaller radius may be on either side
/// of it.
const DEEP: f64 = 0.1;

/// Areas up to this share of the square of the points' length count as nothing, for each point.
const LINE: f64 = 1e-4;

/// Bodies with curved faces. Deep in a triangle, the search for their contact may end before its
/// points are on both surfaces.
const CURVED_BODIES: [&str; 4] = ["cylinder", "cone", "rounded disc", "ellipsoid"];

/// Share of the area of all points that chosen ones span.
const LEAST_AREA: f64 = 0.6;

/// Share of a box's lower face that the points below it span. Each triangle has four of at most
/// seven corners of its part of the face. The smallest ear of m corners has at most the share
/// 4 sin²(π / m) / m of the area, so three ears leave 53.8 %.
const LEAST_RESTING: f64 = 0.53;

/// Cosine of the greatest angle between normals that count as equal: five degrees.
const SAME_NORMAL: f64 = 0.996_194_7;

impl Judge<'_> {
    fn fail(&self, tally: &mut Tally, is_wrong: bool, what: impl FnOnce() -> String) {
        if is_wrong {
            tally.wrong.push(format!("{}: {}", what(), self.place()));
        }
    }

    /// Bounds of the depth of a part in a triangle; negative if they are apart. `None` if they are
    /// farther apart than the prediction.
    fn depth(&self, corners: [DVec3; 3], part: usize) -> Option<[f64; 2]> {
        let (settings, cache) = (Settings::default(), &mut Cache::new());
        let shape = Triangle::new(corners).expect("finite");
        let found = self.body.with_part(part, |body| {
            let middle = self.pose.transform_point(body.interior_point());
            let gap = distance_from_triangle(corners, middle) - body.outer_radius();
            if gap > self.query.prediction + self.rounding() {
                return None;
            }
            let contact = hullmap::contact(&shape, body, self.pose, &settings, cache);
            if contact.hit {
                return Some([contact.depth_lower, contact.depth_upper]);
            }
            let gap = hullmap::distance(&shape, body, self.pose, &settings, cache);
            Some([-gap.upper, -gap.lower])
        });
        found.unwrap_or_else(|| {
            let height = |corner| self.body.models[part].outside(self.pose.inverse().transform_point(corner));
            Some([-corners.map(height).into_iter().fold(f64::INFINITY, f64::min); 2])
        })
    }

    /// Whether a part is certainly behind a triangle.
    fn is_behind(&self, [a, b, c]: [DVec3; 3], part: usize) -> bool {
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let middle = self.body.with_part(part, |body| self.pose.transform_point(body.interior_point()));
        middle.is_some_and(|middle| normal.dot(middle - a) < -self.rounding())
    }

    /// The manifolds have points where the body touches the sheet.
    pub(super) fn missing(&self, tally: &mut Tally, found: &CompoundManifolds) {
        let prediction = self.query.prediction;
        let mut held: f64 = 0.0;
        for (triangle, corners) in self.sheet.triangles.iter().enumerate() {
            let Some(corners) = *corners else { continue };
            for part in 0..self.body.models.len() {
                let manifold = found.get(self.indices([triangle, part]));
                if self.query.is_one_sided {
                    let is_wrong = manifold.is_some() && self.is_behind(corners, part);
                    self.fail(tally, is_wrong, || format!("a manifold of the back of triangle {triangle}"));
                    continue;
                }
                let (bound, [smaller, larger]) = (self.bound(corners, part), self.radii(corners, part));
                let is_extreme = smaller < EXTREME * larger && self.body.name != "half-space";
                let Some([low, high]) = self.depth(corners, part).filter(|_| !is_extreme) else { continue };
                let is_shallow = low > bound && high < DEEP * smaller;
                if is_shallow {
                    held = held.max(low);
                }
                if self.welds {
                    continue;
                }
                let slack = (SLIGHT * prediction).max(SAME_DEPTH * smaller) + bound;
                let deepest = manifold.map_or(f64::NEG_INFINITY, deepest);
                let is_curved = CURVED_BODIES.contains(&self.body.name);
                // The point of a curved body, and of no other, may be beyond the prediction if the
                // contact is nearly as far.
                let margin = if is_curved { SLIGHT * prediction } else { 0.0 };
                let touches = low > bound + margin - prediction && !(is_curved && high >= DEEP * smaller);
                tally.note("touching", if touches { "yes" } else { "no" });
                self.fail(tally, touches && !(deepest >= low - slack), || {
                    format!("no point of triangle {triangle} {corners:?}, part {part}, is {low:e} deep: {manifold:?}")
                });
                self.fail(tally, deepest > high.max(-prediction) + slack, || {
                    format!("a point of triangle {triangle} {corners:?} is deeper than {high:e}: {manifold:?}")
                });
            }
        }
        // The other tile is a copy at the same place: it may hold the body as well. A triangle is
        // on neither side of what it crosses.
        let is_held = held > 0.0 && self.query.way != Way::Joined && self.body.name != "triangle";
        tally.note("held", if is_held { "yes" } else { "no" });
        self.fail(tally, is_held && found.is_empty(), || format!("nothing holds the body, which is {held:e} deep"));
        self.resting(tally, found);
    }

    /// The points under a box that rests on a level sheet span its lower face.
    fn resting(&self, tally: &mut Tally, found: &CompoundManifolds) {
        let (Some(level), true, true) = (self.sheet.level, self.welds, self.body.name == "cuboid") else { return };
        let Some(half) =
            self.body.with_part(0, |body| DVec3::AXES.map(|axis| body.support_point(axis).point.dot(axis)))
        else {
            return;
        };
        let axes = DVec3::AXES.map(|axis| self.pose.transform_vector(axis));
        let Some(up) = (0..3).find(|axis| axes[*axis].truncate().length() < 1e-8) else { return };
        let middle = self.pose.translation();
        let [p, q] = [(up + 1) % 3, (up + 2) % 3].map(|axis| (axes[axis] * half[axis]).truncate());
        let depth = half[up] - middle.z.abs();
        let reach = half.into_iter().fold(0.0, f64::max);
        let corners = [p + q, p - q, -p - q, q - p].map(|corner| corner + middle.truncate());
        let is_inside = corners.iter().all(|corner| corner.abs().max_element() < level - 1e-3 * reach);
        let is_shallow =
            depth > -0.5 * self.query.prediction && depth < 0.1 * half.into_iter().fold(f64::INFINITY, f64::min);
        if !(is_inside && is_shallow && (depth > self.rounding() || self.query.prediction > 0.0))
            || self.query.is_one_sided && middle.z < 0.0
        {
            return;
        }
        let points: Vec<(DVec2, f64)> = found
            .iter()
            .flat_map(|(_, manifold)| manifold.points())
            .map(|point| (self.local(point)[0].truncate(), point.depth))
            .collect();
        let share = area(points.iter().map(|(place, _)| *place)) / (4.0 * p.perp_dot(q).abs());
        tally.note("resting", "box");
        self.fail(tally, !(share > LEAST_RESTING), || format!("the points span {share} of the lower face: {points:?}"));
        let is_off = points.iter().any(|(_, of_point)| (of_point - depth).abs() > 1e-6 * reach);
        self.fail(tally, is_off, || format!("points of other depths than {depth:e}: {points:?}"));
    }

    /// The points of the body manifold; `before` has the ones of the last frame.
    pub(super) fn chosen(
        &self,
        tally: &mut Tally,
        found: &CompoundManifolds,
        before: &[BodyPoint],
        chosen: &[BodyPoint],
    ) {
        let all =
            || found.iter().flat_map(|(_, manifold)| manifold.points().iter().map(|point| (manifold.normal(), point)));
        let is_same = |p: &ManifoldPoint, q: &ManifoldPoint| {
            (p.id, p.point_a, p.point_b, p.local_b, p.depth) == (q.id, q.point_a, q.point_b, q.local_b, q.depth)
        };
        let is_one = |chosen: &BodyPoint| {
            found.get(chosen.pair).is_some_and(|manifold| {
                manifold.normal() == chosen.normal
                    && manifold.points().iter().any(|point| is_same(point, &chosen.point))
            })
        };
        let was_there = |p: &BodyPoint| before.iter().any(|q| (p.pair, p.point.id) == (q.pair, q.point.id));
        tally.note("chosen", ["none", "one", "two", "three", "four", "more"][chosen.len().min(5)]);
        let Some((normal, most)) =
            all().map(|(normal, point)| (normal, point.depth)).max_by(|p, q| p.1.total_cmp(&q.1))
        else {
            return self.fail(tally, !chosen.is_empty(), || "chosen points of no manifold".to_owned());
        };
        let own = chosen.iter().map(|point| point.point.depth).fold(f64::NEG_INFINITY, f64::max);
        let reach = if self.body.name == "half-space" { self.sheet.greatest } else { 2.0 * self.body.radius };
        let is_equal = all().all(|(other, _)| other.dot(normal) >= SAME_NORMAL);
        let across = normal.any_orthonormal_pair();
        let over = |point: &ManifoldPoint| DVec2::new(point.point_b.dot(across.0), point.point_b.dot(across.1));
        let (of_all, of_chosen) =
            (area(all().map(|(_, point)| over(point))), area(chosen.iter().map(|p| over(&p.point))));
        let places: Vec<DVec2> = all().map(|(_, point)| over(point)).collect();
        let spans = places.iter().flat_map(|p| places.iter().map(|q| p.distance_squared(*q)));
        let length_sq = spans.fold(0.0, f64::max);
        let slight = MAX_BODY_POINTS as f64 * LINE * length_sq + self.rounding() * self.rounding();
        for (is_wrong, what) in [
            (chosen.len() > MAX_BODY_POINTS, "more points than there is room for"),
            (!chosen.iter().all(is_one), "a chosen point is of no manifold"),
            (!(own >= most - SAME_DEPTH * reach), "no chosen point is about the deepest"),
            (chosen.iter().any(|point| was_there(point) && point.point.age == 0), "a chosen point forgets its age"),
            (is_equal && of_chosen < LEAST_AREA * of_all - slight, "chosen points span too little"),
        ] {
            self.fail(tally, is_wrong, || format!("{what}: areas {of_chosen:e} of {of_all:e}, {chosen:?}"));
        }
    }
}

fn deepest(manifold: &Manifold) -> f64 {
    manifold.points().iter().map(|point| point.depth).fold(f64::NEG_INFINITY, f64::max)
}

/// Area of the convex hull of points.
///
/// # Reference
/// A. M. Andrew, "Another efficient algorithm for convex hulls in two dimensions", 1979.
fn area(points: impl Iterator<Item = DVec2>) -> f64 {
    let mut points: Vec<DVec2> = points.collect();
    points.sort_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
    let half = |points: &mut dyn Iterator<Item = &DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp_dot(*p - a) <= 0.0
            {
                chain.pop();
            }
            chain.push(*p);
        }
        let first = chain.first().copied().unwrap_or_default();
        chain.windows(2).map(|pair| 0.5 * (pair[0] - first).perp_dot(pair[1] - first)).sum::<f64>()
    };
    half(&mut points.iter()) + half(&mut points.iter().rev())
}
