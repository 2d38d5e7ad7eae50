//! The rest: triangles of a mesh that are not proven to lie in its parts. Most of them have no
//! area, or lie in a gap between parts that is narrower than f32 can close.
//!
//! # Steps
//! 1. Give each triangle to the part nearest to its farthest corner.
//! 2. A part absorbs all of its triangles at once, if its hull with them is proven. Otherwise, each
//!    half of them is tried, down to one.

use std::collections::BTreeMap;

use crate::{
    fit::triangle_tree::{Bounds, TriangleTree},
    hull::Hull,
    simplify::nearest::Nearest,
};
use hullmap_geometry::triangle::Triangle;

/// The triangles nearest to each part, by its index. Without parts, part 0 gets them all.
pub fn by_part(parts: &[&Hull], triangles: &[Triangle]) -> BTreeMap<usize, Vec<Triangle>> {
    let tree = TriangleTree::of_boxes(parts.iter().map(|part| Bounds::around(&part.positions())));
    let nearest: Vec<Nearest> = parts.iter().map(|part| Nearest::new(part)).collect();
    let part_of = |corners: &Triangle| {
        let of_box = |bounds: &Bounds| corners.iter().map(|p| bounds.distance(*p)).fold(0.0, f64::max);
        let of_part = |part: u32| {
            let distance = |p| nearest[part as usize].certain(p).point.distance(p);
            Some(corners.iter().map(|p| distance(*p)).fold(0.0, f64::max))
        };
        tree.lowest(f64::INFINITY, of_box, of_part).map_or(0, |(_, part)| part as usize)
    };
    let mut found: BTreeMap<usize, Vec<Triangle>> = BTreeMap::new();
    for corners in triangles {
        found.entry(part_of(corners)).or_default().push(*corners);
    }
    found
}

/// Halves triangles until `absorb` accepts them. Returns those that it does not accept one by one,
/// in their order. After `is_over`, nothing is tried any more.
pub fn in_halves(
    triangles: &[Triangle],
    is_over: impl Fn() -> bool,
    mut absorb: impl FnMut(&[Triangle]) -> bool,
) -> Vec<Triangle> {
    let (mut left, mut stack) = (Vec::new(), vec![triangles]);
    while let Some(some) = stack.pop() {
        let is_late = is_over();
        if !is_late && absorb(some) {
            continue;
        }
        if is_late || some.len() == 1 {
            left.extend_from_slice(some);
        } else {
            let (first, second) = some.split_at(some.len() / 2);
            stack.extend([second, first]);
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use glam::DVec3;
    use shapes::rng::SplitMix64;

    use super::*;
    use crate::test_meshes::hull_of;

    #[test]
    fn triangles_go_to_the_nearest_part() {
        let mut rng = SplitMix64::new(8);
        println!("seed 8");
        let mut point = |size: f64| DVec3::from_array(std::array::from_fn(|_| rng.between(-size, size)));
        let part = |middle: DVec3, corners: [DVec3; 4]| {
            hull_of(corners.iter().map(|p| (middle + *p).as_vec3().to_array()).collect())
        };
        let hulls: Vec<Hull> = (0..60).map(|_| part(point(2.0), std::array::from_fn(|_| point(0.3)))).collect();
        let triangles: Vec<Triangle> = (0..200).map(|_| std::array::from_fn(|_| point(2.0))).collect();
        let found = by_part(&hulls.iter().collect::<Vec<_>>(), &triangles);
        assert_eq!(found.values().map(Vec::len).sum::<usize>(), 200);
        let distance = |hull: &Hull, corners: &Triangle| {
            let nearest = Nearest::new(hull);
            corners.iter().map(|p| nearest.certain(*p).point.distance(*p)).fold(0.0, f64::max)
        };
        for (part, triangles) in &found {
            for corners in triangles {
                let least = hulls.iter().map(|hull| distance(hull, corners)).fold(f64::INFINITY, f64::min);
                assert_eq!(distance(&hulls[*part], corners), least);
            }
        }
        assert!(found.len() > 20 && by_part(&[], &triangles).len() == 1);
    }

    #[test]
    fn triangles_are_tried_together_then_in_halves() {
        let triangles: Vec<Triangle> = (0..16).map(|i| [DVec3::splat(f64::from(i)); 3]).collect();
        let at = |t: &Triangle| t[0].x as usize;
        let tried = Cell::new(0);
        let count = |is_over: &dyn Fn() -> bool, accepts: &dyn Fn(&[Triangle]) -> bool| {
            tried.set(0);
            let left = in_halves(&triangles, is_over, |some| {
                tried.set(tried.get() + 1);
                accepts(some)
            });
            (left.iter().map(at).collect::<Vec<_>>(), tried.get())
        };
        let never = || false;
        assert_eq!(count(&never, &|_| true), (vec![], 1));
        assert_eq!(count(&never, &|_| false), ((0..16).collect(), 31));
        // Two proofs for each halving on the way to the one that is not accepted, and the first.
        assert_eq!(count(&never, &|some| !some.iter().any(|t| at(t) == 5)), (vec![5], 9));
        assert_eq!(count(&|| true, &|_| true), ((0..16).collect(), 0));
        assert_eq!(count(&|| tried.get() >= 3, &|_| false), ((0..16).collect(), 3));
    }
}
