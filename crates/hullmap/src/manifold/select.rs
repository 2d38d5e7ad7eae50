//! Choice of the four points of a contact patch that support a body best.
//!
//! A body rests on three of the points: the ones below its centre. A point that is left out must
//! not be below the plane through them, or else the body sinks in there, and is pushed out as soon
//! as that point is chosen. On a patch that is nearly flat, this repeats for ever.
//!
//! # Steps
//! 1. Keep the deepest point; of several equally deep points, the outermost.
//! 2. Take each other point as the opposite corner of the diagonal, with the farthest point on
//!    either side. Keep the pair of triangles with the largest area.
//! 3. Find the triangle of chosen points on which the body rests. If another point is below its
//!    plane, exchange it for one of the four, so that the greatest depth below the new plane is as
//!    small as possible. Repeat. If the exchanges end before that, find the triangle on which the
//!    body would rest with all points, by exchanging corners of a triangle below the centre.
//! 4. Last frame's points stay while they span nearly as much area and leave out no deep point.
//!
//! For the corners of a flat convex polygon the result is exactly the largest quadrilateral with
//! the deepest point as a corner.
//!
//! # Complexity
//! O(n²) for n points.

#![forbid(unsafe_code)]

use glam::DVec2;

/// Depths that differ by less than this fraction of the prediction count as equal.
///
/// The deepest of the corners of a smooth body changes with every hundredth of a degree. If it is
/// always among the four, the body rocks for ever. 98 of 102 real meshes come to rest with a
/// tenth, 93 with half as much (decision 13).
pub const SLIGHT: f64 = 0.1;

/// A point on other features than before counts as the same point if it has moved by less than this
/// on one of the shapes, relative to the smaller shape's outer radius.
pub const SAME_PLACE: f64 = 0.02;

/// Last frame's four points stay while their area is at least this fraction of the best four
/// points' area.
const KEPT_AREA: f64 = 0.9;

/// Share of the depth that counts as equal by which a point that is left out may be below the plane
/// of rest.
///
/// When the body rocks on to that point, the point is pushed out from that depth, and the body
/// gains the energy. One of 696 bodies gained 12 mJ/kg with the whole, and none more than 5 with
/// half. With a quarter, eleven more bodies are awake after 10 s.
pub(crate) const LEFT_OUT: f64 = 0.5;

/// Maximum number of exchanges. Two are usually enough.
const MAX_EXCHANGES: usize = 8;

/// Maximum number of exchanged corners until the body rests. Three are usually enough.
const MAX_PIVOTS: usize = 32;

/// A point of a patch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spot {
    /// Position in the plane perpendicular to the normal.
    pub at: DVec2,
    /// Penetration depth along the normal; negative above the surface.
    pub depth: f64,
}

/// Indices of up to four spots, each once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Choice {
    indices: [usize; 4],
    count: usize,
}

impl Choice {
    /// The indices.
    pub fn indices(&self) -> &[usize] {
        &self.indices[..self.count]
    }

    /// Adds an index, unless it is there already, or there are four.
    pub fn push(&mut self, index: usize) {
        if self.count < 4 && !self.indices().contains(&index) {
            self.indices[self.count] = index;
            self.count += 1;
        }
    }

    /// Adds an index. If there are four already, it replaces the one whose loss leaves the largest
    /// area.
    pub(super) fn insert(&mut self, spots: &[Spot], index: usize) {
        if self.count < 4 || self.indices().contains(&index) {
            return self.push(index);
        }
        let all = *self;
        let candidates = (0..4).map(|place| all.with(place, index));
        *self = candidates.max_by(|p, q| p.area(spots).total_cmp(&q.area(spots))).unwrap_or(all);
    }

    /// With the deepest of `spots`, unless it has one that is as deep within `slight`, a length.
    pub(super) fn with_deepest(mut self, spots: &[Spot], slight: f64) -> Self {
        if let Some(deep) = self.missing_deepest(spots, slight) {
            self.insert(spots, deep);
        }
        self
    }

    /// With the deepest of `spots`, however little deeper it is than the others. No point that is
    /// left out is below the plane on which the body rests by more than `slight` allows, see
    /// [`choose`], unless one is without it as well.
    pub(super) fn with_exact_deepest(self, spots: &[Spot], center: DVec2, slight: f64) -> Self {
        let Some(deep) = self.missing_deepest(spots, 0.0) else { return self };
        if self.count < 4 {
            let mut all = self;
            all.push(deep);
            return all;
        }
        let allowed = LEFT_OUT * slight;
        let left_out = |choice: &Self| choice.left_out(spots, center).map_or(f64::INFINITY, |(below, _)| below);
        let order = |p: &Self, q: &Self| {
            let [below_p, below_q] = [p, q].map(|choice| left_out(choice).max(allowed));
            below_p.total_cmp(&below_q).then(q.area(spots).total_cmp(&p.area(spots)))
        };
        let exchanged = (0..4).map(|place| self.with(place, deep)).min_by(order).unwrap_or(self);
        if left_out(&exchanged) <= left_out(&self).max(allowed) {
            return exchanged;
        }
        // No point is below the plane of the lowest triangle, so the fourth point can be any.
        let lowest = lowest(spots, self, center);
        if lowest.missing_deepest(spots, 0.0).is_none() { lowest } else { lowest.with(lowest.count - 1, deep) }
    }

    /// The deepest of `spots`, unless one of the chosen is as deep within `slight`, a length.
    fn missing_deepest(&self, spots: &[Spot], slight: f64) -> Option<usize> {
        let deep = (0..spots.len()).fold(0, |deep, i| if spots[i].depth > spots[deep].depth { i } else { deep });
        let is_less = |i: &usize| spots[*i].depth < spots[deep].depth - slight;
        (!spots.is_empty() && self.indices().iter().all(is_less)).then_some(deep)
    }

    /// With `index` in place of one of the four.
    fn with(mut self, place: usize, index: usize) -> Self {
        self.indices[place] = index;
        self
    }

    /// Area that the points span, in any order; 0 for fewer than three.
    fn area(&self, spots: &[Spot]) -> f64 {
        match *self.indices() {
            [a, b, c] => area([a, b, c, c].map(|i| spots[i].at)),
            [a, b, c, d] => area([a, b, c, d].map(|i| spots[i].at)),
            _ => 0.0,
        }
    }

    /// The triangle of chosen points on which the body rests.
    fn rest(&self, spots: &[Spot], center: DVec2) -> Option<Rest> {
        let mut rest: Option<Rest> = None;
        let triangles: &[[usize; 3]] = match self.count {
            4 => &[[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]],
            3 => &[[0, 1, 2]],
            _ => &[],
        };
        for places in triangles {
            let corners = places.map(|place| self.indices[place]);
            let Some(plane) = Plane::of_triangle(corners.map(|i| spots[i]), center) else { continue };
            // The body comes to rest on the lowest of the planes below its centre.
            if rest.is_none_or(|deepest| plane.depth(center) > deepest.plane.depth(center)) {
                rest = Some(Rest { corners, plane });
            }
        }
        rest
    }

    /// How far the deepest point that is not chosen is below the plane on which the body rests with
    /// its centre over `center`, and its index. `None` if the centre is not over the chosen points.
    fn left_out(&self, spots: &[Spot], center: DVec2) -> Option<(f64, Option<usize>)> {
        let rest = self.rest(spots, center)?;
        let mut worst = (0.0, None);
        for (index, spot) in spots.iter().enumerate() {
            let below = spot.depth - rest.depth(spot.at);
            if below > worst.0 && !self.indices().contains(&index) {
                worst = (below, Some(index));
            }
        }
        Some(worst)
    }

    /// Whether the body's centre is over the chosen points, so that it does not tip.
    pub fn is_below(&self, spots: &[Spot], center: DVec2) -> bool {
        self.rest(spots, center).is_some()
    }
}

/// A plane through three spots.
#[derive(Clone, Copy, Debug)]
struct Plane {
    through: Spot,
    slope: DVec2,
}

impl Plane {
    /// The plane of a triangle; `None` if `center` is not over it, or if it is a line.
    fn of_triangle([p, q, r]: [Spot; 3], center: DVec2) -> Option<Self> {
        let (u, v) = (q.at - p.at, r.at - p.at);
        let area = u.perp_dot(v);
        let sides = [(p, q), (q, r), (r, p)].map(|(s, t)| (s.at - center).perp_dot(t.at - center));
        let (rise_u, rise_v) = (q.depth - p.depth, r.depth - p.depth);
        let slope = DVec2::new(rise_u * v.y - rise_v * u.y, rise_v * u.x - rise_u * v.x) / area;
        // NaN takes the failing branch.
        (sides.iter().all(|side| side * area >= 0.0) && slope.is_finite()).then_some(Self { through: p, slope })
    }

    fn depth(&self, at: DVec2) -> f64 {
        self.through.depth + self.slope.dot(at - self.through.at)
    }
}

/// The triangle of spots on which a body rests, and its plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rest {
    pub(crate) corners: [usize; 3],
    plane: Plane,
}

impl Rest {
    /// A triangle of corners of a convex polygon, in order, that has `at` in it; `None` if the
    /// polygon has not. `spot` returns the point of an index.
    pub(crate) fn over(polygon: &[usize], spot: impl Fn(usize) -> Spot, at: DVec2) -> Option<Self> {
        let [first, ring @ ..] = polygon else { return None };
        let mut fan = ring.iter().zip(ring.iter().skip(1)).map(|(second, third)| [*first, *second, *third]);
        fan.find_map(|corners| Some(Self { corners, plane: Plane::of_triangle(corners.map(&spot), at)? }))
    }

    /// Depth of the plane at a place.
    pub(crate) fn depth(&self, at: DVec2) -> f64 {
        self.plane.depth(at)
    }

    /// The triangle on which the body rests with its centre over `center`, which is in this
    /// triangle, if none of `points` is left out. The deepest point below the plane replaces one of
    /// the corners, so that the centre stays over the triangle. Each plane is lower below the
    /// centre than the one before.
    ///
    /// # Complexity
    /// O(n) for n points, for each exchanged corner.
    pub(crate) fn lowered(
        mut self,
        points: impl Iterator<Item = usize> + Clone,
        spot: impl Fn(usize) -> Spot,
        center: DVec2,
    ) -> Self {
        for _ in 0..MAX_PIVOTS {
            let below = |i: &usize| spot(*i).depth - self.plane.depth(spot(*i).at);
            let Some(worst) = points.clone().max_by(|i, j| below(i).total_cmp(&below(j))) else { break };
            if self.corners.contains(&worst) {
                break;
            }
            let exchanged =
                (0..3).map(|place| std::array::from_fn(|i| if i == place { worst } else { self.corners[i] }));
            let next = exchanged
                .filter_map(|corners: [usize; 3]| {
                    Some(Self { corners, plane: Plane::of_triangle(corners.map(&spot), center)? })
                })
                .max_by(|p, q| p.plane.depth(center).total_cmp(&q.plane.depth(center)));
            match next {
                Some(next) if next.plane.depth(center) > self.plane.depth(center) => self = next,
                _ => break,
            }
        }
        self
    }
}

/// The four of `spots` that support a body best whose centre is over `center`, or all of them if
/// there are at most four. Depths that differ by at most `slight`, a length, count as equal.
///
/// The four spots that were chosen `last`, if they are still there, are preferred to others that
/// are nearly as good.
///
/// # Examples
/// The corners of a square, and a point between them:
/// ```
/// use hullmap::glam::DVec2;
/// use hullmap::manifold::select::{Spot, choose};
///
/// let square = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y, DVec2::splat(0.5)];
/// let spots = square.map(|at| Spot { at, depth: 0.0 });
/// let chosen = choose(&spots, DVec2::splat(0.5), 0.01, None);
/// assert!((0..4).all(|corner| chosen.indices().contains(&corner)));
/// ```
pub fn choose(spots: &[Spot], center: DVec2, slight: f64, last: Option<Choice>) -> Choice {
    let mut best = Choice::default();
    if spots.len() <= 4 {
        (0..spots.len()).for_each(|i| best.push(i));
        return best;
    }
    let below = LEFT_OUT * slight;
    best = largest(spots, slight);
    let kept = last.filter(|last| last.count == 4).map(|last| last.with_deepest(spots, below));
    // No choice supports a centre that is beside all spots.
    let tips = is_beside(spots, center);
    let left_out = |choice: &Choice| {
        let found = if tips { None } else { choice.left_out(spots, center) };
        found.map_or(f64::INFINITY, |(below, _)| below)
    };
    let is_as_good = |kept: &Choice, best: &Choice, allowed: f64| {
        kept.area(spots) >= KEPT_AREA * best.area(spots) && left_out(kept) <= allowed
    };
    // Usually, which the best ones are need not be known.
    if let Some(kept) = kept.filter(|kept| is_as_good(kept, &best, below)) {
        return kept;
    }
    if !tips {
        best = supporting(spots, best, center, below);
    }
    kept.filter(|kept| is_as_good(kept, &best, left_out(&best).max(below))).unwrap_or(best)
}

/// Whether a line separates `center` from all spots. Only one line is tried, so `false` proves
/// nothing.
fn is_beside(spots: &[Spot], center: DVec2) -> bool {
    let away = spots.iter().map(|spot| spot.at - center).sum::<DVec2>();
    spots.iter().all(|spot| (spot.at - center).dot(away) > 0.0)
}

/// Index of the deepest of `spots`; of all within `slight` of the deepest, the one farthest from
/// their centre, since large quadrilaterals have it as a corner.
fn deepest(spots: &[Spot], slight: f64) -> usize {
    let depth = spots.iter().map(|spot| spot.depth).fold(f64::NEG_INFINITY, f64::max) - slight;
    let deep = || spots.iter().enumerate().filter(move |(_, spot)| spot.depth >= depth);
    let middle = deep().map(|(_, spot)| spot.at).sum::<DVec2>() / deep().count() as f64;
    let far = |spot: &Spot| spot.at.distance_squared(middle);
    deep().fold(0, |best, (i, p)| if spots[best].depth < depth || far(p) > far(&spots[best]) { i } else { best })
}

/// The four of five or more `spots` that span the largest area, with one that is as deep as the
/// deepest.
fn largest(spots: &[Spot], slight: f64) -> Choice {
    let first = deepest(spots, slight);
    let origin = spots[first].at;
    let mut greatest = (-1.0, [first; 3]);
    for (across, spot) in spots.iter().enumerate() {
        let along = spot.at - origin;
        // Twice the area of the largest triangle on either side of the diagonal, and its third
        // corner; 0 if no point is on that side.
        let (mut left, mut right) = ((0.0, first), (0.0, first));
        for (i, spot) in spots.iter().enumerate() {
            let area = along.perp_dot(spot.at - origin);
            if area > left.0 {
                left = (area, i);
            }
            if -area > right.0 {
                right = (-area, i);
            }
        }
        let area = left.0 + right.0;
        if area > greatest.0 {
            greatest = (area, [left.1, across, right.1]);
        }
    }
    let mut choice = Choice::default();
    choice.push(first);
    greatest.1.into_iter().for_each(|i| choice.push(i));
    choice
}

/// Exchanges points until the body's centre is over the chosen ones, and none that is left out is
/// below them by more than `allowed`.
fn supporting(spots: &[Spot], mut choice: Choice, center: DVec2, allowed: f64) -> Choice {
    if choice.count < 3 {
        return choice;
    }
    for _ in 0..MAX_EXCHANGES {
        let found = choice.left_out(spots, center);
        let candidates = match found {
            Some((below, Some(worst))) if below > allowed => worst..worst + 1,
            None => 0..spots.len(),
            _ => break,
        };
        let exchanged = candidates
            .filter(|index| !choice.indices().contains(index))
            .flat_map(|index| (0..choice.count).map(move |place| choice.with(place, index)))
            .filter_map(|choice| Some((choice.left_out(spots, center)?.0, choice)));
        let best = exchanged.min_by(|(below_p, p), (below_q, q)| {
            below_p.total_cmp(below_q).then(q.area(spots).total_cmp(&p.area(spots)))
        });
        match best {
            Some((below, better)) if found.is_none_or(|(before, _)| below < before) => choice = better,
            _ => break,
        }
    }
    match choice.left_out(spots, center) {
        Some((below, Some(_))) if below > allowed => lowest(spots, choice, center),
        // No single exchange brings the centre over the chosen points.
        None => over(spots, choice.indices[0], center).map_or(choice, |triangle| lowest(spots, triangle, center)),
        _ => choice,
    }
}

/// A triangle with a given corner below the centre; `None` if the centre is not over the spots. The
/// triangles of a spot and the edges of the spots' outline cover all that the outline encloses.
fn over(spots: &[Spot], corner: usize, center: DVec2) -> Option<Choice> {
    let mut pairs = (0..spots.len()).flat_map(|j| (0..j).map(move |i| [corner, i, j]));
    let corners = pairs.find(|corners| Plane::of_triangle(corners.map(|i| spots[i]), center).is_some())?;
    let mut triangle = Choice::default();
    corners.into_iter().for_each(|i| triangle.push(i));
    Some(triangle)
}

/// The triangle on which the body rests if nothing is left out, and the fourth point that spans the
/// largest area with it.
fn lowest(spots: &[Spot], choice: Choice, center: DVec2) -> Choice {
    let Some(rest) = choice.rest(spots, center) else { return choice };
    let corners = rest.lowered(0..spots.len(), |i| spots[i], center).corners;
    let mut lowest = Choice::default();
    corners.into_iter().for_each(|i| lowest.push(i));
    let with = |i: &usize| {
        let mut four = lowest;
        four.push(*i);
        four.area(spots)
    };
    let fourth = (0..spots.len()).max_by(|i, j| with(i).total_cmp(&with(j)));
    fourth.into_iter().for_each(|i| lowest.push(i));
    lowest
}

/// Area of the quadrilateral of four points in any order: the largest of the three possible orders.
fn area([a, b, c, d]: [DVec2; 4]) -> f64 {
    let order = |p: DVec2, q: DVec2, r: DVec2, s: DVec2| 0.5 * (r - p).perp_dot(s - q).abs();
    order(a, b, c, d).max(order(a, c, b, d)).max(order(a, b, d, c))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pseudo-random number from 0 to 1.
    fn random(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (*seed >> 40) as f64 / 2_f64.powi(24)
    }

    /// Compared with every quadruple that has the deepest point.
    #[test]
    fn no_other_four_points_span_a_larger_area() {
        let mut seed = 1_u64;
        for n in 5..24 {
            // Corners of a convex polygon: an ellipse at random angles in order.
            let mut angles: Vec<f64> = (0..n).map(|_| random(&mut seed) * std::f64::consts::TAU).collect();
            angles.sort_by(f64::total_cmp);
            let flat = random(&mut seed);
            let corners: Vec<DVec2> = angles.iter().map(|a| DVec2::new(a.cos(), flat * a.sin())).collect();
            let deep = (random(&mut seed) * n as f64) as usize % n;
            let spot = |(i, at): (usize, &DVec2)| Spot { at: *at, depth: f64::from(u8::from(i == deep)) };
            let spots: Vec<Spot> = corners.iter().enumerate().map(spot).collect();
            let chosen = largest(&spots, 0.0);
            assert!(chosen.indices().len() >= 3 && chosen.indices()[0] == deep);
            let mut best: f64 = 0.0;
            for i in 0..n {
                for j in 0..i {
                    for k in 0..j {
                        best = best.max(area([deep, i, j, k].map(|i| corners[i])));
                    }
                }
            }
            let spanned = chosen.area(&spots);
            assert!(spanned >= best * (1.0 - 1e-12), "{n} corners: {spanned} of {best}");
        }
    }

    /// The corners of a shallow bowl, pressed into the floor by different depths: what the patch of
    /// a smooth body looks like while it rocks.
    fn bowl(seed: &mut u64, n: usize, height: f64) -> Vec<Spot> {
        let tilt = DVec2::new(random(seed) - 0.5, random(seed) - 0.5) * height;
        let spot = |_| {
            let at = DVec2::from_angle(random(seed) * std::f64::consts::TAU) * random(seed).sqrt();
            Spot { at, depth: tilt.dot(at) - height * at.length_squared() }
        };
        (0..n).map(spot).collect()
    }

    /// A nearly flat patch with more than four corners lost a deep one: it returned two
    /// to three millimetres deep, and a robot's elbow gained energy for ever. The plane of rest is
    /// found by trying all triangles.
    #[test]
    fn no_corner_is_left_out_that_is_below_the_plane_of_rest() {
        let (mut seed, mut exchanged) = (3_u64, 0);
        for trial in 0..20_000 {
            let spots = bowl(&mut seed, 5 + trial % 28, 0.01);
            let center = DVec2::new(random(&mut seed) - 0.5, random(&mut seed) - 0.5) * 0.4;
            let slight = 0.001;
            let chosen = choose(&spots, center, slight, None);
            let all: Vec<usize> = (0..spots.len()).collect();
            let over = |indices: &[usize]| {
                let mut planes = Vec::new();
                for (i, a) in indices.iter().enumerate() {
                    for (j, b) in indices.iter().enumerate().skip(i + 1) {
                        planes.extend(
                            indices[j + 1..]
                                .iter()
                                .filter_map(|c| Plane::of_triangle([*a, *b, *c].map(|i| spots[i]), center)),
                        );
                    }
                }
                planes.into_iter().max_by(|p, q| p.depth(center).total_cmp(&q.depth(center)))
            };
            let Some(plane) = over(chosen.indices()) else {
                assert!(over(&all).is_none(), "{trial}: the centre is not over the chosen points");
                continue;
            };
            let below = spots.iter().map(|spot| spot.depth - plane.depth(spot.at)).fold(0.0, f64::max);
            assert!(
                below <= LEFT_OUT * slight,
                "{trial}: a corner is left out that is {below} below the plane of rest"
            );
            exchanged += usize::from(chosen != largest(&spots, slight));
        }
        assert!(exchanged > 2000, "the largest area alone would do in all but {exchanged} trials");
    }

    /// If depths differed by less than the tolerance, the largest area decided, and the deepest
    /// point was missing.
    #[test]
    fn the_exact_deepest_point_joins_without_leaving_out_a_deep_one() {
        let (mut seed, mut joined, mut supported) = (5_u64, 0, 0);
        for trial in 0..2000 {
            let spots = bowl(&mut seed, 1 + trial % 32, 0.01);
            let center = DVec2::new(random(&mut seed) - 0.5, random(&mut seed) - 0.5) * 0.4;
            let slight = 0.002;
            let before = choose(&spots, center, slight, None);
            let chosen = before.with_exact_deepest(&spots, center, slight);
            assert_eq!(chosen.missing_deepest(&spots, 0.0), None, "{trial}");
            assert!(chosen.indices().len() >= before.indices().len(), "{trial}");
            joined += usize::from(chosen != before);
            if before.is_below(&spots, center) {
                let below = chosen.left_out(&spots, center).map(|(below, _)| below);
                assert!(below.is_some_and(|below| below <= LEFT_OUT * slight), "{trial}: {below:?}");
                supported += 1;
            }
        }
        assert!(joined > 200 && supported > 1000, "{joined} joined, {supported} supported");
    }

    /// Last frame's points stay while the body rocks by less than the tolerance, and are replaced
    /// as soon as a corner beside them is deeper.
    #[test]
    fn points_stay_until_one_that_is_left_out_is_deep() {
        let corner = |i: usize| Spot { at: DVec2::from_angle(i as f64 * std::f64::consts::FRAC_PI_4), depth: 0.0 };
        let mut spots: Vec<Spot> = (0..8).map(corner).collect();
        let first = choose(&spots, DVec2::ZERO, 0.01, None);
        let left_out = (0..8).find(|i| !first.indices().contains(i)).unwrap();
        spots[left_out].depth = 0.0049;
        assert_eq!(choose(&spots, DVec2::ZERO, 0.01, Some(first)), first);
        spots[left_out].depth = 0.0051;
        assert!(choose(&spots, DVec2::ZERO, 0.01, Some(first)).indices().contains(&left_out));
    }

    #[test]
    fn the_order_of_four_points_does_not_matter() {
        let [a, b, c, d] = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]].map(DVec2::from_array);
        assert_eq!([area([a, b, c, d]), area([a, c, b, d]), area([b, a, c, d])], [2.0; 3]);
    }
}
