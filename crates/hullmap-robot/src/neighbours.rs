//! Which links move relative to each other, and which are neighbours in the chain.

use crate::chain::Chain;

/// The neighbours of a chain. Links that are rigidly connected count as one.
#[derive(Clone, Debug)]
pub struct Neighbours {
    /// For each link, one that it is rigidly connected to.
    rigid: Vec<usize>,
    /// For each link, the rigid group of the parent of its own.
    parent: Vec<Option<usize>>,
    robots: Vec<usize>,
    is_world: Vec<bool>,
}

impl Neighbours {
    /// The neighbours of a chain.
    pub fn new(chain: &Chain) -> Self {
        let rigid = chain.rigid();
        let parent = rigid.iter().map(|&own| chain.links[own].parent.map(|parent| rigid[parent])).collect();
        let is_world = chain.links.iter().map(|link| link.is_world).collect();
        Self { rigid, parent, robots: chain.robots(), is_world }
    }

    /// Whether two links never move against each other.
    pub fn are_rigid(&self, [a, b]: [usize; 2]) -> bool {
        self.rigid[a] == self.rigid[b]
    }

    /// Whether two links are connected by one joint, or by none. As in MuJoCo, the world and links
    /// that are rigidly connected to it are not neighbours.
    pub fn are_adjacent(&self, [a, b]: [usize; 2]) -> bool {
        let is_world = |link: usize| self.is_world[self.rigid[link]];
        self.are_rigid([a, b]) || self.are_joined([a, b]) && !is_world(a) && !is_world(b)
    }

    /// Whether two links are connected by one joint, or by none. The base of a robot is a
    /// neighbour, and the world itself is not.
    pub fn are_connected(&self, [a, b]: [usize; 2]) -> bool {
        self.are_rigid([a, b]) || self.are_joined([a, b]) && !self.is_world[a] && !self.is_world[b]
    }

    /// Whether a joint connects the rigid groups of two links.
    fn are_joined(&self, [a, b]: [usize; 2]) -> bool {
        let [own_a, own_b] = [self.rigid[a], self.rigid[b]];
        self.parent[a] == Some(own_b) || self.parent[b] == Some(own_a)
    }

    /// All pairs of links of one robot for which `has_pieces` holds. The world belongs to no robot.
    pub fn pairs(&self, has_pieces: impl Fn(usize) -> bool) -> Vec<[usize; 2]> {
        let chosen = |link: &usize| has_pieces(*link) && !self.is_world[*link];
        let chosen: Vec<usize> = (0..self.rigid.len()).filter(chosen).collect();
        let pairs = chosen.iter().enumerate().flat_map(|(at, &a)| chosen[at + 1..].iter().map(move |&b| [a, b]));
        pairs.filter(|[a, b]| self.robots[*a] == self.robots[*b]).collect()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::chain::{Joint, Motion};
    use crate::frame::Frame;

    #[test]
    fn neighbours_are_found_across_rigid_links_and_not_across_the_world() {
        // A world, a base that is fixed to it, an arm with a flange fixed to it, and a tool.
        let mut chain = Chain::new(5);
        for (child, parent) in [(1, 0), (2, 1), (3, 2), (4, 3)] {
            chain.attach(child, parent, Frame::IDENTITY).unwrap();
        }
        chain.links[0].is_world = true;
        let joint = |link| Joint {
            name: String::new(),
            link,
            motion: Motion::Hinge,
            axis: DVec3::Z,
            anchor: DVec3::ZERO,
            limits: None,
            reference: 0.0,
            neutral: 0.0,
            coupling: None,
        };
        chain.joints = vec![joint(2), joint(4)];
        let found = Neighbours::new(&chain);
        assert!(found.are_rigid([2, 3]) && found.are_adjacent([2, 4]) && found.are_connected([3, 4]));
        assert!(!found.are_adjacent([1, 2]) && found.are_connected([1, 2]) && !found.are_connected([0, 2]));
        assert!(found.are_connected([0, 1]) && !found.are_connected([1, 4]));
        assert_eq!(found.pairs(|link| link != 3), [[1, 2], [1, 4], [2, 4]]);
    }
}
