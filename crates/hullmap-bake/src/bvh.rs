//! BVH: builds the bounding volume hierarchy over a pack's hulls with the surface area heuristic.
//!
//! # Steps
//! 1. Split the hulls recursively, starting with all of them. Along each axis, sort the hulls by
//!    the centres of their boxes, and consider every split. Take the split with the minimum
//!    expected cost: the sum over both sides of area times number of hulls.
//! 2. Lay the nodes out breadth first, with siblings next to each other.
//!
//! # Reference
//! MacDonald, Booth, "Heuristics for ray tracing using space subdivision", 1990.
//!
//! Deviation: hulls are split at the median if any other split could make the tree too deep.

use std::collections::VecDeque;

use glam::DVec3;
use hullmap_format::{
    archive::{BvhNode, HullRecord},
    bvh::MAX_LEVELS,
};

/// Builds the tree over the bounds of `hulls`, with one hull per leaf, and sets the `leaf` of each
/// hull.
///
/// The result is a pure function of the bounds and their order.
///
/// # Complexity
/// O(n log² n) on typical packs.
pub fn build(hulls: &mut [HullRecord]) -> Vec<BvhNode> {
    let mut nodes = vec![BvhNode::default()];
    let mut queue = VecDeque::from([(0, 1, (0..hulls.len()).collect::<Vec<usize>>())]);
    while let Some((index, level, mut below)) = queue.pop_front() {
        let bounds = HullBox::around(hulls, &below);
        let first_child = nodes.len();
        nodes[index] = BvhNode {
            bounds_min: bounds.low,
            bounds_max: bounds.high,
            target: first_child as u32,
            hull_count: below.len() as u32,
        };
        if let [hull] = below[..] {
            nodes[index].target = hull as u32;
            hulls[hull].leaf = index as u32;
            continue;
        }
        let right = split(hulls, &mut below, MAX_LEVELS - level);
        nodes.extend([BvhNode::default(); 2]);
        queue.extend([(first_child, level + 1, below), (first_child + 1, level + 1, right)]);
    }
    nodes
}

#[derive(Clone, Copy)]
struct HullBox {
    low: [f32; 3],
    high: [f32; 3],
}

impl HullBox {
    fn of_hull(hull: &HullRecord) -> Self {
        Self { low: hull.bounds_min, high: hull.bounds_max }
    }

    fn with(self, other: Self) -> Self {
        Self {
            low: std::array::from_fn(|i| self.low[i].min(other.low[i])),
            high: std::array::from_fn(|i| self.high[i].max(other.high[i])),
        }
    }

    fn around(hulls: &[HullRecord], below: &[usize]) -> Self {
        below[1..].iter().fold(Self::of_hull(&hulls[below[0]]), |all, hull| all.with(Self::of_hull(&hulls[*hull])))
    }

    /// Half of the surface area.
    fn area(self) -> f64 {
        let size = DVec3::from_array(self.high.map(f64::from)) - DVec3::from_array(self.low.map(f64::from));
        size.x * size.y + size.y * size.z + size.z * size.x
    }
}

/// Splits `below`, which must hold at least two hulls: keeps one side in `below` and returns the
/// other. `levels` is the number of levels available below this node.
fn split(hulls: &[HullRecord], below: &mut Vec<usize>, levels: u32) -> Vec<usize> {
    let mut best = (f64::INFINITY, 0, below.len() / 2);
    let is_deep = below.len().next_power_of_two().ilog2() >= levels;
    for axis in 0..3 {
        sort(hulls, below, axis);
        let areas = |order: &mut dyn Iterator<Item = usize>| -> Vec<f64> {
            let grow = |all: &mut Option<HullBox>, hull: usize| {
                let own = HullBox::of_hull(&hulls[hull]);
                *all = Some(all.map_or(own, |all| all.with(own)));
                all.map(HullBox::area)
            };
            order.scan(None, grow).collect()
        };
        let from_left = areas(&mut below.iter().copied());
        let mut from_right = areas(&mut below.iter().rev().copied());
        from_right.reverse();
        let splits = if is_deep { below.len() / 2..below.len() / 2 + 1 } else { 1..below.len() };
        for split in splits {
            let cost = from_left[split - 1] * split as f64 + from_right[split] * (below.len() - split) as f64;
            if cost < best.0 {
                best = (cost, axis, split);
            }
        }
    }
    sort(hulls, below, best.1);
    below.split_off(best.2)
}

fn sort(hulls: &[HullRecord], below: &mut [usize], axis: usize) {
    let twice_middle = |hull: usize| f64::from(hulls[hull].bounds_min[axis]) + f64::from(hulls[hull].bounds_max[axis]);
    below.sort_unstable_by(|a, b| twice_middle(*a).total_cmp(&twice_middle(*b)).then(a.cmp(b)));
}

#[cfg(test)]
mod tests {
    use shapes::rng::SplitMix64;

    use super::*;

    fn levels(nodes: &[BvhNode], node: usize) -> u32 {
        let BvhNode { target, hull_count, .. } = nodes[node];
        if hull_count == 1 {
            return 1;
        }
        1 + levels(nodes, target as usize).max(levels(nodes, target as usize + 1))
    }

    fn boxes(count: usize, mut low: impl FnMut(usize) -> [f32; 3]) -> Vec<HullRecord> {
        let record = |i| {
            let bounds_min = low(i);
            HullRecord { bounds_min, bounds_max: bounds_min.map(|c| c * 1.5 + 0.5), ..HullRecord::default() }
        };
        (0..count).map(record).collect()
    }

    #[test]
    fn every_leaf_is_inside_the_boxes_above_it() {
        let mut rng = SplitMix64::new(3);
        for count in [1, 2, 3, 7, 64, 500] {
            let mut hulls = boxes(count, |_| rng.direction().map(|c| c as f32));
            let nodes = build(&mut hulls);
            assert_eq!(nodes.len(), 2 * count - 1);
            let mut met = vec![0; count];
            let mut pending = vec![0];
            while let Some(index) = pending.pop() {
                let node: BvhNode = nodes[index];
                if node.hull_count == 1 {
                    met[node.target as usize] += 1;
                    assert_eq!(hulls[node.target as usize].leaf as usize, index);
                    continue;
                }
                for child in [node.target as usize, node.target as usize + 1] {
                    let below = &nodes[child];
                    assert!((0..3).all(|i| node.bounds_min[i] <= below.bounds_min[i]));
                    assert!((0..3).all(|i| node.bounds_max[i] >= below.bounds_max[i]));
                    pending.push(child);
                }
            }
            assert!(met.iter().all(|times| *times == 1), "{met:?}");
        }
    }

    /// Without the depth limit, boxes that double in size and distance are split off one by one.
    #[test]
    fn no_tree_is_too_deep() {
        let mut hulls = boxes(120, |i| [2_f32.powi(i as i32), 0.0, 0.0]);
        let nodes = build(&mut hulls);
        assert!((16..=MAX_LEVELS).contains(&levels(&nodes, 0)), "{}", levels(&nodes, 0));
    }
}
