//! BVH over triangles: a binary tree of boxes, split where a binned cost of volumes is lowest.
//!
//! # Steps
//! 1. Sort the triangles into eight bins, by the centres of their boxes along the axis on which the
//!    centres are spread farthest.
//! 2. Take the plane between bins with the minimum cost: the sum over both sides of volume times
//!    number of triangles. Triangles that no plane separates are halved.
//! 3. Repeat on both sides until each leaf holds one triangle.
//!
//! # Reference
//! Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007.
//!
//! # Deviations
//! - Volumes instead of surface areas. Among triangles at the same distance, the tree decides which
//!   one is found, so another cost would change the parts of meshes that are already baked.

use std::ops::ControlFlow;

use glam::DVec3;

use hullmap_geometry::triangle::Triangle;

const BINS: usize = 8;

/// Share of the spread by which the bins end before the last centre, so that it lies in a bin.
const BIN_MARGIN: f64 = 1e-5;

pub struct TriangleTree {
    children: Vec<[Node; 2]>,
    root: Option<Node>,
}

#[derive(Clone, Copy)]
pub struct Node {
    pub bounds: Bounds,
    below: Below,
}

#[derive(Clone, Copy)]
enum Below {
    Leaf(u32),
    Inner(u32),
}

/// An axis-aligned box.
#[derive(Clone, Copy)]
pub struct Bounds {
    pub low: DVec3,
    pub high: DVec3,
}

impl Bounds {
    const EMPTY: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    pub fn around(points: &[DVec3]) -> Self {
        points.iter().map(|p| Self::of_point(*p)).fold(Self::EMPTY, Self::with)
    }

    pub fn grown(&self, by: f64) -> Self {
        Self { low: self.low - by, high: self.high + by }
    }

    pub fn contains(&self, p: DVec3) -> bool {
        p.cmpge(self.low).all() && p.cmple(self.high).all()
    }

    pub fn touches(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    /// Distance of a point; 0 inside.
    pub fn distance(&self, p: DVec3) -> f64 {
        (self.low - p).max(p - self.high).max(DVec3::ZERO).length()
    }

    fn with(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn of_point(p: DVec3) -> Self {
        Self { low: p, high: p }
    }

    fn centre(&self) -> DVec3 {
        self.low.midpoint(self.high)
    }

    fn volume(&self) -> f64 {
        let size = self.high - self.low;
        size.x * size.y * size.z
    }
}

impl TriangleTree {
    pub fn new(triangles: &[Triangle]) -> Self {
        Self::of_boxes(triangles.iter().map(|corners| Bounds::around(corners)))
    }

    pub fn of_boxes(boxes: impl Iterator<Item = Bounds>) -> Self {
        let leaf = |(index, bounds)| Node { bounds, below: Below::Leaf(index) };
        let mut leaves: Vec<Node> = (0..).zip(boxes).map(leaf).collect();
        let mut tree = Self { children: Vec::with_capacity(leaves.len()), root: None };
        if !leaves.is_empty() {
            tree.root = Some(tree.built(&mut leaves));
        }
        tree
    }

    fn built(&mut self, leaves: &mut [Node]) -> Node {
        if let [leaf] = leaves {
            return *leaf;
        }
        let own = self.children.len();
        self.children.push([leaves[0]; 2]);
        let middle = split(leaves);
        let (left, right) = leaves.split_at_mut(middle);
        let children = [self.built(left), self.built(right)];
        self.children[own] = children;
        Node { bounds: children[0].bounds.with(children[1].bounds), below: Below::Inner(own as u32) }
    }

    /// Visits the triangles in all nodes that `accepts`, unless it rejects an ancestor.
    pub fn for_each(&self, accepts: impl Fn(&Bounds) -> bool, mut visit: impl FnMut(u32)) {
        let _ = self.visit(accepts, |triangle| {
            visit(triangle);
            ControlFlow::<()>::Continue(())
        });
    }

    /// As [`Self::for_each`], until a visit breaks.
    pub fn visit<B>(
        &self,
        accepts: impl Fn(&Bounds) -> bool,
        mut visit: impl FnMut(u32) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        match &self.root {
            Some(root) if accepts(&root.bounds) => self.visit_below(root, &accepts, &mut visit),
            _ => ControlFlow::Continue(()),
        }
    }

    fn visit_below<B>(
        &self,
        node: &Node,
        accepts: &impl Fn(&Bounds) -> bool,
        visit: &mut impl FnMut(u32) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        match node.below {
            Below::Leaf(triangle) => visit(triangle),
            Below::Inner(index) => {
                let accepted = self.children[index as usize].iter().filter(|child| accepts(&child.bounds));
                accepted.into_iter().try_for_each(|child| self.visit_below(child, accepts, visit))
            }
        }
    }

    /// The triangle with the lowest cost below `limit`, and that cost. `of_box` is a lower bound on
    /// all costs in a box. Triangles without a cost are skipped.
    pub fn lowest(
        &self,
        limit: f64,
        of_box: impl Fn(&Bounds) -> f64,
        of_triangle: impl Fn(u32) -> Option<f64>,
    ) -> Option<(f64, u32)> {
        let root = self.root?;
        let mut best = Lowest { cost: limit, triangle: None };
        if of_box(&root.bounds) < limit {
            match root.below {
                Below::Leaf(triangle) => best.take(triangle, &of_triangle),
                Below::Inner(index) => self.search(index, &of_box, &of_triangle, &mut best),
            }
        }
        best.triangle.map(|triangle| (best.cost, triangle))
    }

    fn search(
        &self,
        index: u32,
        of_box: &impl Fn(&Bounds) -> f64,
        of_triangle: &impl Fn(u32) -> Option<f64>,
        best: &mut Lowest,
    ) {
        let mut children = self.children[index as usize].each_ref().map(|child| (of_box(&child.bounds), child.below));
        if children[0].0 > children[1].0 {
            children.swap(0, 1);
        }
        let inner = children.map(|(cost, below)| match below {
            _ if !(cost < best.cost) => None,
            Below::Inner(index) => Some((cost, index)),
            Below::Leaf(triangle) => {
                best.take(triangle, of_triangle);
                None
            }
        });
        for (cost, index) in inner.into_iter().flatten() {
            if cost < best.cost {
                self.search(index, of_box, of_triangle, best);
            }
        }
    }
}

struct Lowest {
    cost: f64,
    triangle: Option<u32>,
}

impl Lowest {
    fn take(&mut self, triangle: u32, of_triangle: &impl Fn(u32) -> Option<f64>) {
        // NaN is no cost.
        if let Some(cost) = of_triangle(triangle).filter(|cost| *cost < self.cost) {
            *self = Self { cost, triangle: Some(triangle) };
        }
    }
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    count: usize,
}

impl Bin {
    const EMPTY: Self = Self { bounds: Bounds::EMPTY, count: 0 };

    fn with(self, other: Self) -> Self {
        Self { bounds: self.bounds.with(other.bounds), count: self.count + other.count }
    }

    fn cost(&self) -> f64 {
        self.bounds.volume() * self.count as f64
    }
}

fn split(leaves: &mut [Node]) -> usize {
    let centres = leaves.iter().map(|leaf| Bounds::of_point(leaf.bounds.centre())).fold(Bounds::EMPTY, Bounds::with);
    let spread = centres.high - centres.low;
    let axis = spread.max_position();
    let to_bin = BINS as f64 * (1.0 - BIN_MARGIN) / spread[axis];
    // Without spread, NaN becomes bin 0.
    let bin_of = |leaf: &Node| ((to_bin * (leaf.bounds.centre()[axis] - centres.low[axis])) as usize).min(BINS - 1);
    let mut bins = [Bin::EMPTY; BINS];
    for leaf in &*leaves {
        let bin = &mut bins[bin_of(leaf)];
        *bin = bin.with(Bin { bounds: leaf.bounds, count: 1 });
    }
    let mut best = (f64::MAX, 0, bins[0].count);
    for last in 0..BINS - 1 {
        let left = bins[..=last].iter().copied().fold(Bin::EMPTY, Bin::with);
        let right = bins[last + 1..].iter().copied().fold(Bin::EMPTY, Bin::with);
        let cost = left.cost() + right.cost();
        // Never with an empty side: its cost is NaN, which is not lower.
        if cost < best.0 {
            best = (cost, last, left.count);
        }
    }
    let (_, last, count) = best;
    if count == 0 || count == leaves.len() {
        return leaves.len() / 2;
    }
    // Swaps each leaf on the left that belongs to the right with one of the opposite kind.
    let is_left = |leaf: &Node| bin_of(leaf) <= last;
    let mut right = count;
    for left in 0..count {
        if !is_left(&leaves[left]) {
            while !is_left(&leaves[right]) {
                right += 1;
            }
            leaves.swap(left, right);
            right += 1;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use shapes::rng::SplitMix64;

    use super::*;
    use hullmap_geometry::triangle;

    fn triangles(count: usize, rng: &mut SplitMix64) -> Vec<Triangle> {
        let mut point = |size: f64| DVec3::from_array(rng.direction()) * size;
        let mut all: Vec<Triangle> = (0..count)
            .map(|i| {
                let place = point(1.0) * if i % 3 == 0 { DVec3::new(1.0, 1.0, 0.0) } else { DVec3::ONE };
                [place, place + point(0.1), place + point(0.1)]
            })
            .collect();
        all.extend_from_within(..count / 4);
        all
    }

    #[test]
    fn searches_find_what_a_scan_finds() {
        let seed = 11;
        println!("seed {seed}");
        let mut rng = SplitMix64::new(seed);
        for count in [0, 1, 2, 3, 9, 400] {
            let triangles = triangles(count, &mut rng);
            let tree = TriangleTree::new(&triangles);
            for _ in 0..50 {
                let p = DVec3::from_array(rng.direction()) * 1.5 * rng.unit();
                let cost = |index: u32| triangle::nearest(&triangles[index as usize], p).distance_squared(p);
                let all = || 0..triangles.len() as u32;
                let of_box = |b: &Bounds| (b.low - p).max(p - b.high).max(DVec3::ZERO).length_squared();
                let even = |index: u32| (index.is_multiple_of(2)).then(|| cost(index));
                for limit in [f64::MAX, 0.05] {
                    let least = all().filter_map(even).fold(limit, f64::min);
                    let found = tree.lowest(limit, of_box, even);
                    assert_eq!(found.map_or(limit, |(cost, _)| cost), least, "{count}");
                    assert!(found.is_none_or(|(least, index)| index % 2 == 0 && cost(index) == least));
                }
                let touches = |low: DVec3, high: DVec3| low.cmple(p + 0.3).all() && high.cmpge(p - 0.3).all();
                let mut found = Vec::new();
                tree.for_each(|b| touches(b.low, b.high), |index| found.push(index));
                found.sort_unstable();
                let is_near = |index: &u32| {
                    let [a, b, c] = triangles[*index as usize];
                    touches(a.min(b).min(c), a.max(b).max(c))
                };
                assert_eq!(found, all().filter(is_near).collect::<Vec<_>>(), "{count}");
                let first = tree.visit(|b| touches(b.low, b.high), ControlFlow::Break).break_value();
                assert_eq!(first.is_some(), !found.is_empty());
            }
        }
    }

    /// The number of boxes that are compared, not a time.
    #[test]
    fn neighbours_are_found_by_nearly_linear_work() {
        let compared = |side: u32| {
            let steps = || (0..side).map(f64::from);
            let place = steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| DVec3::new(x, y, z))));
            let boxes: Vec<Bounds> = place.map(|p| Bounds { low: p, high: p + 0.9 }).collect();
            let tree = TriangleTree::of_boxes(boxes.iter().copied());
            let (count, mut found) = (Cell::new(0), 0);
            for own in &boxes {
                let around = Bounds { low: own.low - 0.2, high: own.high + 0.2 };
                let touches = |bounds: &Bounds| {
                    count.set(count.get() + 1);
                    bounds.touches(&around)
                };
                tree.for_each(touches, |_| found += 1);
            }
            let side = side as usize;
            assert_eq!(found, (3 * side - 2).pow(3), "each box with the 26 around it, and itself");
            count.get() as f64 / boxes.len() as f64
        };
        let counts = [10, 16, 25].map(compared);
        println!("{counts:?} boxes compared for each of 1,000, 4,096 and 15,625");
        assert!(counts[2] < 1.6 * counts[0], "{counts:?}");
    }

    #[test]
    fn triangles_of_all_sizes_are_found() {
        let triangles: Vec<Triangle> =
            (-500..500).map(|e| [DVec3::ZERO, DVec3::X, DVec3::Y].map(|p| p * 2_f64.powi(e))).collect();
        let tree = TriangleTree::new(&triangles);
        let mut count = 0;
        tree.for_each(|_| true, |_| count += 1);
        assert_eq!(count, triangles.len());
    }
}
