//! Ear clipping: triangulation of polygons, convex or not.
//!
//! 1. Project the polygon along the axis with the largest projection, without rounding.
//! 2. A convex polygon becomes a fan from its first corner.
//! 3. Otherwise clip an ear: a corner whose triangle contains no obstacle, which is a reflex or
//!    straight corner, stored in a k-d tree. Continue two corners further.
//! 4. If no ear exists, for instance because the outline crosses itself, the rest becomes a fan,
//!    whose signed area is correct, but whose triangles overlap.
//!
//! Orientation tests are exact, so distant and thin polygons need no special care.
//!
//! # Reference
//! G. H. Meisters, "Polygons have ears" (1975); J. R. Shewchuk, "Adaptive precision floating-point
//! arithmetic and fast robust geometric predicates" (1997), for the orientation test.

use std::ops::Range;

use robust::{Coord, orient2d};

/// Maximum number of obstacle tests per corner, some microseconds; then the rest becomes a fan.
/// Only self-intersecting polygons come near it.
const TESTS_A_CORNER: usize = 1024;

/// Appends the triangles of a polygon: two fewer than its corners, with its winding. Complexity:
/// O(corners) for convex polygons. Otherwise O(obstacles · log obstacles) for the tree, and at most
/// [`TESTS_A_CORNER`] tests per corner.
#[expect(clippy::indexing_slicing, reason = "indices modulo the number of corners, and `flat` is as long as `corners`")]
pub fn triangulate(corners: &[u32], points: &[[f32; 3]], out: &mut Vec<[u32; 3]>) {
    if let [a, b, c] = *corners {
        out.push([a, b, c]);
        return;
    }
    let flat = flattened(corners, points);
    let count = corners.len();
    if (0..count).all(|i| turn(flat[(i + count - 1) % count], flat[i], flat[(i + 1) % count]) >= 0.0) {
        fan(corners.iter().copied(), out);
    } else {
        Outline::new(&flat).clip(corners, out);
    }
}

fn fan(mut corners: impl Iterator<Item = u32>, out: &mut Vec<[u32; 3]>) {
    let Some(first) = corners.next() else { return };
    let Some(mut last) = corners.next() else { return };
    for corner in corners {
        out.push([first, last, corner]);
        last = corner;
    }
}

/// The part of an outline that is not clipped yet, counter-clockwise.
struct Outline<'a> {
    flat: &'a [[f64; 2]],
    next: Vec<usize>,
    previous: Vec<usize>,
    /// For each corner whether it is an obstacle: reflex or straight, and not clipped.
    is_obstacle: Vec<bool>,
    /// Corners that were obstacles initially, as a k-d tree, see [`build_tree`]. No corner becomes
    /// an obstacle later, since clipping an ear only reduces the angles of its neighbours.
    obstacles: Vec<usize>,
    tests_left: usize,
}

#[expect(
    clippy::indexing_slicing,
    reason = "indices are of corners, and all lists but `obstacles` have one entry per corner; a subtree that is \
              not empty has a middle; axes are 0 and 1"
)]
impl<'a> Outline<'a> {
    fn new(flat: &'a [[f64; 2]]) -> Self {
        let count = flat.len();
        let mut outline = Self {
            flat,
            next: (0..count).map(|i| (i + 1) % count).collect(),
            previous: (0..count).map(|i| (i + count - 1) % count).collect(),
            is_obstacle: Vec::new(),
            obstacles: Vec::new(),
            tests_left: TESTS_A_CORNER * count,
        };
        outline.is_obstacle = (0..count).map(|corner| !outline.turns_left(corner)).collect();
        outline.obstacles = (0..count).filter(|corner| outline.is_obstacle[*corner]).collect();
        build_tree(&mut outline.obstacles, 0, flat);
        outline
    }

    fn turn_at(&self, corner: usize) -> f64 {
        turn(self.flat[self.previous[corner]], self.flat[corner], self.flat[self.next[corner]])
    }

    fn turns_left(&self, corner: usize) -> bool {
        self.turn_at(corner) > 0.0
    }

    fn clip(mut self, corners: &[u32], out: &mut Vec<[u32; 3]>) {
        let (mut at, mut left) = (0, corners.len());
        // Number of corners visited since the last ear. If there is no ear, a straight corner is
        // clipped: its triangle has no area.
        let (mut visited, mut clips_straight) = (0, false);
        while left > 3 && self.tests_left > 0 {
            let is_ear = if clips_straight { self.turn_at(at) == 0.0 } else { self.is_ear(at) };
            if is_ear {
                let [a, c] = [self.previous[at], self.next[at]];
                out.push([a, at, c].map(|corner| corners[corner]));
                (self.next[a], self.previous[c]) = (c, a);
                for corner in [a, c] {
                    self.is_obstacle[corner] &= !self.turns_left(corner);
                }
                self.is_obstacle[at] = false;
                (at, left, visited, clips_straight) = (self.next[c], left - 1, 0, false);
                continue;
            }
            (at, visited) = (self.next[at], visited + 1);
            if visited == left {
                if clips_straight {
                    break;
                }
                (visited, clips_straight) = (0, true);
            }
        }
        let rest = std::iter::successors(Some(at), |corner| Some(self.next[*corner])).take(left);
        fan(rest.map(|corner| corners[corner]), out);
    }

    fn is_ear(&mut self, corner: usize) -> bool {
        self.tests_left = self.tests_left.saturating_sub(1);
        if self.is_obstacle[corner] || !self.turns_left(corner) {
            return false;
        }
        let triangle = [self.previous[corner], corner, self.next[corner]].map(|corner| self.flat[corner]);
        let bounds =
            [f64::min, f64::max].map(|pick| [0, 1].map(|axis| triangle.map(|p| p[axis]).into_iter().reduce(pick)));
        let [Some(low), Some(high)] = bounds.map(|[x, y]| x.zip(y).map(|(x, y)| [x, y])) else { return false };
        !self.has_obstacle(0..self.obstacles.len(), 0, &triangle, [low, high])
    }

    fn has_obstacle(
        &mut self,
        part: Range<usize>,
        axis: usize,
        triangle: &[[f64; 2]; 3],
        bounds: [[f64; 2]; 2],
    ) -> bool {
        if part.is_empty() {
            return false;
        }
        self.tests_left = self.tests_left.saturating_sub(1);
        let middle = middle(&part);
        let obstacle = self.obstacles[middle];
        let (p, [low, high]) = (self.flat[obstacle], bounds);
        let [a, b, c] = *triangle;
        // A corner in the place of a triangle's, where an outline touches itself, is no obstacle.
        let contains =
            || turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0 && p != a && p != b && p != c;
        let is_near = (0..2).all(|axis| low[axis] <= p[axis] && p[axis] <= high[axis]);
        is_near && self.is_obstacle[obstacle] && contains()
            || low[axis] <= p[axis] && self.has_obstacle(part.start..middle, 1 - axis, triangle, bounds)
            || high[axis] >= p[axis] && self.has_obstacle(middle + 1..part.end, 1 - axis, triangle, bounds)
    }
}

/// The middle corner splits the others along `axis`; each half alternates the axis.
#[expect(clippy::indexing_slicing, reason = "`corners` are indices into `flat`, and axes are 0 and 1")]
fn build_tree(corners: &mut [usize], axis: usize, flat: &[[f64; 2]]) {
    if corners.len() > 1 {
        let middle = middle(&(0..corners.len()));
        let by_axis = |a: &usize, b: &usize| flat[*a][axis].total_cmp(&flat[*b][axis]).then(a.cmp(b));
        let (below, _, above) = corners.select_nth_unstable_by(middle, by_axis);
        build_tree(below, 1 - axis, flat);
        build_tree(above, 1 - axis, flat);
    }
}

fn middle(part: &Range<usize>) -> usize {
    part.start + part.len() / 2
}

/// The corners projected to the largest area, counter-clockwise.
#[expect(clippy::indexing_slicing, reason = "indices modulo the number of corners, which index points; axes modulo 3")]
fn flattened(corners: &[u32], points: &[[f32; 3]]) -> Vec<[f64; 2]> {
    let at = |i: usize| points[corners[i % corners.len()] as usize].map(f64::from);
    // Newell's normal, relative to the first corner, so that a distant polygon loses no precision.
    let mut normal = [0.0; 3];
    for i in 0..corners.len() {
        let [a, b] = [at(i), at(i + 1)].map(|p| [0, 1, 2].map(|axis| p[axis] - at(0)[axis]));
        for (axis, sum) in normal.iter_mut().enumerate() {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            *sum += a[u] * b[v] - a[v] * b[u];
        }
    }
    let axis = (0..3).fold(0, |best, next| if normal[next].abs() > normal[best].abs() { next } else { best });
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let sign = if normal[axis] < 0.0 { -1.0 } else { 1.0 };
    (0..corners.len()).map(at).map(|p| [p[u] * sign, p[v]]).collect()
}

/// Positive if the path a, b, c turns left, negative if right, 0 if straight. The sign is exact.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let [a, b, c] = [a, b, c].map(|[x, y]| Coord { x, y });
    orient2d(a, b, c)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(outline: &[[f32; 3]]) -> Vec<[u32; 3]> {
        let mut triangles = Vec::new();
        triangulate(&(0..outline.len() as u32).collect::<Vec<_>>(), outline, &mut triangles);
        triangles
    }

    fn area(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> f64 {
        let at = |corner: u32| glam::Vec3::from_array(points[corner as usize]).as_dvec3();
        triangles.iter().map(|&[a, b, c]| (at(b) - at(a)).cross(at(c) - at(a)).length() / 2.0).sum()
    }

    /// Area of a simple planar polygon, computed from its outline.
    fn true_area(points: &[[f32; 3]]) -> f64 {
        let at = |i: usize| {
            glam::Vec3::from_array(points[i % points.len()]).as_dvec3() - glam::Vec3::from_array(points[0]).as_dvec3()
        };
        (0..points.len()).map(|i| at(i).cross(at(i + 1))).sum::<glam::DVec3>().length() / 2.0
    }

    #[track_caller]
    fn assert_covers(outline: &[[f32; 3]], what: &str) {
        let triangles = cut(outline);
        assert_eq!(triangles.len(), outline.len() - 2, "{what}");
        let (found, expected) = (area(outline, &triangles), true_area(outline));
        assert!((found - expected).abs() <= 1e-9 * expected, "{what}: {found} {expected}");
    }

    fn star(points: usize, mirror: f64, middle: f32) -> Vec<[f32; 3]> {
        let corner = |i: usize| {
            let angle = std::f64::consts::PI * (i as f64 + 0.3) / points as f64;
            let radius = if i.is_multiple_of(2) { 1.0 } else { 0.4 };
            [middle, middle + (radius * angle.cos()) as f32, middle + (mirror * radius * angle.sin()) as f32]
        };
        (0..2 * points).map(corner).collect()
    }

    #[test]
    fn distant_polygons_are_covered() {
        for middle in [1e3, -1e5, 1e6] {
            assert_covers(&star(7, 1.0, middle), &format!("{middle}"));
        }
        let moved = |scale: f32| star(9, -1.0, 0.0).iter().map(|p| p.map(|x| x * scale)).collect::<Vec<_>>();
        for scale in [1e-30, 1e-3, 1e30] {
            assert_eq!(cut(&moved(scale)).len(), 16);
            assert_eq!(cut(&moved(scale)), cut(&star(9, -1.0, 0.0)), "{scale}");
        }
    }

    #[test]
    fn combs_spirals_steps_and_holes_are_covered() {
        let comb = |teeth: usize| {
            let mut outline = vec![[teeth as f32, 0.0, 0.0], [teeth as f32, 5.0, 0.0]];
            outline.extend((0..2 * teeth).rev().map(|i| [i as f32 / 2.0, if i % 2 == 0 { 5.0 } else { 1.0 }, 0.0]));
            outline.push([0.0, 0.0, 0.0]);
            outline
        };
        assert_covers(&comb(3), "comb");
        assert_covers(&comb(500), "long comb");
        let spiral = |radius: f64, i: usize| {
            let angle = i as f64 * 0.1;
            let r = radius * (1.0 + angle);
            [(r * angle.cos()) as f32, 3.0, (r * angle.sin()) as f32]
        };
        let outline: Vec<_> = (0..600).map(|i| spiral(1.0, i)).chain((0..600).rev().map(|i| spiral(0.97, i))).collect();
        assert_covers(&outline, "spiral");
        let steps: Vec<_> = (0..40_u8)
            .map(|i| [f32::from(i / 2), f32::from(i.div_ceil(2)), 0.0])
            .chain([[20.0, -1.0, 0.0], [0.0, -1.0, 0.0]])
            .collect();
        assert_covers(&steps, "steps");
        assert_covers(&star(5, -1.0, 0.2), "clockwise star");
        let keyhole = [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)];
        assert_covers(&keyhole.map(|(x, y)| [x as f32, y as f32, 2.0]), "keyhole");
        let straight = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 1), (0, 2), (0, 1)];
        assert_covers(&straight.map(|(x, y)| [x as f32, y as f32, 2.0]), "straight corners");
    }

    #[test]
    fn random_outlines_are_covered() {
        let seed = 5;
        let mut random = shapes::rng::SplitMix64::new(seed);
        let mut concave = 0;
        for round in 0..400 {
            let count = 4 + round % 60;
            let outline: Vec<[f32; 3]> = (0..count)
                .map(|i| {
                    let angle = std::f32::consts::TAU * i as f32 / count as f32;
                    let radius = random.between(0.2, 1.2) as f32;
                    [7.0, (64.0 * radius * angle.cos()), (64.0 * radius * angle.sin())]
                })
                .collect();
            assert_covers(&outline, &format!("seed {seed}, round {round}"));
            let fan: Vec<[u32; 3]> = (2..count as u32).map(|i| [0, i - 1, i]).collect();
            concave += usize::from(area(&outline, &fan) > 1.001 * true_area(&outline));
        }
        assert!(concave > 200, "only {concave} outlines are concave");
    }

    #[test]
    fn huge_polygons_take_bounded_time() {
        let start = std::time::Instant::now();
        assert_covers(&star(100_000, 1.0, 0.0), "star");
        println!("star of 200,000 corners: {:?}", start.elapsed());
        let start = std::time::Instant::now();
        let count = 20_000;
        let mut random = shapes::rng::SplitMix64::new(1);
        let tangle: Vec<[f32; 3]> =
            (0..count).map(|_| std::array::from_fn(|_| random.between(-1.0, 1.0) as f32)).collect();
        assert_eq!(cut(&tangle).len(), count - 2);
        println!("tangle of {count} corners: {:?}", start.elapsed());
    }

    #[test]
    fn degenerate_polygons_have_the_right_number_of_triangles() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.5, 0.0, 0.0], [1.0, 1.0, 0.0]];
        for corners in [&[0, 0, 0, 0][..], &[0, 1, 2, 1], &[0, 1], &[3], &[], &[0, 3, 1, 2, 2, 0, 3]] {
            let mut triangles = Vec::new();
            triangulate(corners, &points, &mut triangles);
            assert_eq!(triangles.len(), corners.len().saturating_sub(2), "{corners:?}");
        }
    }
}
