//! Collision filter: which pairs of links and shapes are tested, and why the others are not.
//!
//! | format | pairs that are not tested |
//! |---|---|
//! | all | links that never move relative to each other |
//! | URDF, SDF | the parent and the child of a joint |
//! | MJCF | parent and child, rigidly connected bodies as one, unless one is in the world |
//! | MJCF | two bodies without degrees of freedom, `exclude`, and masks that do not match |
//!
//! In MJCF, a `pair` of geoms is tested whatever these rules say.
//!
//! # Reference
//! <https://mujoco.readthedocs.io/en/stable/computation/index.html#selection>

use std::collections::BTreeSet;
use std::fmt;

use crate::description::{Description, Format, Link};

/// Why a pair is not tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SkipReason {
    /// The two never move relative to each other.
    RigidlyConnected,
    /// A joint connects the two.
    Adjacent,
    /// Neither has degrees of freedom: static and mocap bodies of MJCF.
    Immobile,
    /// `contact` / `exclude` of MJCF.
    Excluded,
    /// `contype` and `conaffinity` of MJCF do not match.
    Masks,
    /// `option` / `flag` of MJCF disables all contacts.
    Disabled,
    /// The user or an SRDF file allows the collision.
    Allowed,
}

impl SkipReason {
    /// The reason in words.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::RigidlyConnected => "rigidly connected",
            Self::Adjacent => "adjacent: connected by a joint",
            Self::Immobile => "neither body has degrees of freedom",
            Self::Excluded => "excluded by `exclude`",
            Self::Masks => "`contype` and `conaffinity` do not match",
            Self::Disabled => "contacts are disabled by `flag`",
            Self::Allowed => "allowed",
        }
    }
}

impl fmt::Display for SkipReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.in_words())
    }
}

/// The collision filter of a description.
#[derive(Clone, Debug)]
pub struct CollisionFilter {
    /// For each link, the root of the links that it is rigidly connected to.
    rigid: Vec<usize>,
    /// In MJCF the same, since rigidly connected bodies have one parent; otherwise, the link.
    group: Vec<usize>,
    /// For each link, the group of the parent of its own.
    parent: Vec<Option<usize>>,
    is_world: Vec<bool>,
    /// Whether a link has no degrees of freedom, as far as that matters: in MJCF.
    is_immobile: Vec<bool>,
    robots: Vec<usize>,
    excluded: BTreeSet<[usize; 2]>,
    /// In both orders.
    paired: BTreeSet<[[usize; 2]; 2]>,
    /// `contype` and `conaffinity` of each collision.
    masks: Vec<Vec<[i32; 2]>>,
    tests_parents: bool,
    is_disabled: bool,
}

impl CollisionFilter {
    /// The filter of a description.
    pub fn new(description: &Description) -> Self {
        let (chain, contacts) = (&description.chain, &description.contacts);
        let is_mjcf = description.format == Format::Mjcf;
        let rigid = chain.rigid();
        let group = if is_mjcf { rigid.clone() } else { (0..rigid.len()).collect() };
        let moved: BTreeSet<usize> = chain.joints.iter().map(|joint| joint.link).collect();
        let masks = |link: &Link| link.collisions.iter().map(|shape| shape.contact_bits).collect();
        Self {
            parent: group.iter().map(|&own| chain.links[own].parent.map(|parent| group[parent])).collect(),
            group,
            is_world: chain.links.iter().map(|link| link.is_world).collect(),
            is_immobile: rigid.iter().map(|own| is_mjcf && !moved.contains(own)).collect(),
            rigid,
            robots: chain.robots(),
            excluded: contacts.excluded.iter().map(|[a, b]| [*a.min(b), *a.max(b)]).collect(),
            paired: contacts.paired.iter().flat_map(|&[a, b]| [[a, b], [b, a]]).collect(),
            masks: description.links.iter().map(masks).collect(),
            tests_parents: contacts.tests_parents,
            is_disabled: contacts.is_disabled,
        }
    }

    /// Why two links are not tested, apart from the masks and pairs of their geoms.
    pub fn links(&self, [a, b]: [usize; 2]) -> Option<SkipReason> {
        let is_child = |link: usize, of: usize| self.parent[link] == Some(self.group[of]);
        let is_world = |link: usize| self.is_world[self.rigid[link]];
        let is_filtered = !self.tests_parents && !is_world(a) && !is_world(b);
        if self.is_disabled {
            Some(SkipReason::Disabled)
        } else if self.rigid[a] == self.rigid[b] {
            Some(SkipReason::RigidlyConnected)
        } else if self.is_immobile[a] && self.is_immobile[b] {
            Some(SkipReason::Immobile)
        } else if is_filtered && (is_child(a, b) || is_child(b, a)) {
            Some(SkipReason::Adjacent)
        } else {
            self.excluded.contains(&[a.min(b), a.max(b)]).then_some(SkipReason::Excluded)
        }
    }

    /// Why two collisions are not tested. Each is a link, and an index of its collisions. `links`
    /// is the reason for the two links, from [`links`](Self::links).
    pub fn collisions(&self, links: Option<SkipReason>, [a, b]: [[usize; 2]; 2]) -> Option<SkipReason> {
        if !self.is_disabled && self.paired.contains(&[a, b]) {
            return None;
        }
        let [mask_a, mask_b] = [a, b].map(|[link, index]| self.masks[link][index]);
        links.or((!masks_match(mask_a, mask_b)).then_some(SkipReason::Masks))
    }

    /// Whether nothing is tested.
    pub fn is_disabled(&self) -> bool {
        self.is_disabled
    }

    /// Whether geoms of one link are tested against each other: MJCF may name them as a `pair`.
    pub fn pairs_within(&self, link: usize) -> bool {
        !self.is_disabled && self.paired.iter().any(|[a, b]| [a[0], b[0]] == [link; 2])
    }

    /// All pairs of links of one robot for which `has_pieces` holds. The world belongs to no robot.
    pub fn pairs(&self, has_pieces: impl Fn(usize) -> bool) -> Vec<[usize; 2]> {
        let chosen = |link: &usize| has_pieces(*link) && !self.is_world[*link];
        let chosen: Vec<usize> = (0..self.rigid.len()).filter(chosen).collect();
        let pairs = chosen.iter().enumerate().flat_map(|(at, &a)| chosen[at + 1..].iter().map(move |&b| [a, b]));
        pairs.filter(|[a, b]| self.robots[*a] == self.robots[*b]).collect()
    }
}

/// Whether MuJoCo's masks, `contype` and `conaffinity`, let two geoms collide.
pub fn masks_match([type_a, affinity_a]: [i32; 2], [type_b, affinity_b]: [i32; 2]) -> bool {
    type_a & affinity_b != 0 || type_b & affinity_a != 0
}
