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

use std::collections::{BTreeMap, BTreeSet};

use crate::description::{Change, Description, Format, Geometry, Link, Shape, Unread};
use crate::skipped::{SkipReason, Skipped, named};

/// A collision of a link.
#[derive(Clone, Debug)]
struct Collision {
    /// Its name in lists.
    name: String,
    line: u32,
    /// `contype` and `conaffinity`.
    masks: [i32; 2],
    /// Why it has no shape that can be queried.
    cause: Option<String>,
    is_removed: bool,
}

impl Collision {
    fn new(shape: &Shape) -> Self {
        let Shape { line, contact_bits: masks, .. } = *shape;
        let cause = match &shape.geometry {
            Geometry::Other(cause) => Some(cause.clone()),
            Geometry::Mesh(_) | Geometry::Primitive(_) => None,
        };
        Self { name: named(&shape.name, line), line, masks, cause, is_removed: false }
    }
}

/// The collision filter of a description.
#[derive(Clone, Debug)]
pub struct CollisionFilter {
    names: Vec<String>,
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
    /// The collisions of each link.
    collisions: Vec<Vec<Collision>>,
    unread: Vec<Unread>,
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
        let collisions = |link: &Link| link.collisions.iter().map(Collision::new).collect();
        Self {
            names: description.links.iter().map(|link| link.name.clone()).collect(),
            parent: group.iter().map(|&own| chain.links[own].parent.map(|parent| group[parent])).collect(),
            group,
            is_world: chain.links.iter().map(|link| link.is_world).collect(),
            is_immobile: rigid.iter().map(|own| is_mjcf && !moved.contains(own)).collect(),
            rigid,
            robots: chain.robots(),
            excluded: contacts.excluded.iter().map(|[a, b]| [*a.min(b), *a.max(b)]).collect(),
            paired: contacts.paired.iter().flat_map(|&[a, b]| [[a, b], [b, a]]).collect(),
            collisions: description.links.iter().map(collisions).collect(),
            unread: description.unread.clone(),
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

    /// Why two collisions are not tested. Each is a link, and an index of its collisions. `allowed`
    /// is the entry of an allowed collision matrix for the two links, which overrides the filter.
    /// `links` is the reason for them, from [`links`](Self::links).
    pub fn collisions(
        &self,
        allowed: Option<bool>,
        links: Option<SkipReason>,
        [a, b]: [[usize; 2]; 2],
    ) -> Option<SkipReason> {
        match allowed {
            Some(true) => return Some(SkipReason::Allowed),
            Some(false) if a[0] != b[0] => return None,
            _ if !self.is_disabled && self.paired.contains(&[a, b]) => return None,
            _ => {}
        }
        let [mask_a, mask_b] = [a, b].map(|[link, index]| self.collisions[link][index].masks);
        links.or((!masks_match(mask_a, mask_b)).then_some(SkipReason::Masks))
    }

    /// Follows changes of the collisions of the description.
    pub fn change(&mut self, changes: &[Change], description: &Description) {
        for change in changes {
            match change {
                Change::Remove { link, collision } => self.collisions[*link][*collision].is_removed = true,
                Change::FromVisual { link, visual, .. } => {
                    let visual = Collision::new(&description.links[*link].visuals[*visual]);
                    // A geom that was only drawn collides with everything now.
                    self.collisions[*link].push(Collision { masks: [1, 1], ..visual });
                }
                Change::Replace { .. } | Change::Inertia { .. } | Change::Exclude { .. } => {}
            }
        }
    }

    /// Geometry without a shape that can be queried.
    pub fn untested(&self) -> impl Iterator<Item = Skipped> {
        let of_link = |(own, link): (&'_ Vec<Collision>, &'_ String)| {
            let kept = own.iter().filter(|own| !own.is_removed);
            let geometry = |own: &Collision| {
                let (link, geom, line) = (Some(link.clone()), own.name.clone(), own.line);
                Some(Skipped::Geometry { link, geom, line, cause: own.cause.clone()? })
            };
            kept.filter_map(geometry).collect::<Vec<_>>()
        };
        let unread = self.unread.iter().map(|own| Skipped::Geometry {
            link: None,
            geom: own.element.clone(),
            line: own.line,
            cause: own.reason.to_owned(),
        });
        self.collisions.iter().zip(&self.names).flat_map(of_link).chain(unread)
    }

    fn testable(&self, link: usize) -> impl Iterator<Item = usize> + Clone {
        self.collisions[link]
            .iter()
            .enumerate()
            .filter(|(_, own)| own.cause.is_none() && !own.is_removed)
            .map(|(index, _)| index)
    }

    /// Pairs of links with shapes, the lower link first. A link is its own partner only if MJCF
    /// pairs its geoms.
    pub fn pairs_of_links(&self) -> impl Iterator<Item = [usize; 2]> {
        let links = (0..self.names.len()).filter(|link| self.testable(*link).next().is_some());
        links
            .clone()
            .flat_map(move |a| links.clone().filter(move |b| a <= *b).map(move |b| [a, b]))
            .filter(|[a, b]| a != b || self.pairs_within(*a))
    }

    /// Geometry and pairs that are not tested, with reasons. A pair of links is listed once if one
    /// reason holds for all its geoms; else, each pair of geoms is. `allowed` is an allowed
    /// collision matrix, the lower link first. O(p) for p pairs of geoms.
    pub fn skipped(&self, allowed: &BTreeMap<[usize; 2], bool>) -> impl Iterator<Item = Skipped> {
        let pairs = self.pairs_of_links().filter(|[a, b]| a != b);
        let pairs = pairs.flat_map(|links| self.skipped_pairs(links, allowed.get(&links).copied()));
        self.untested().chain(pairs)
    }

    fn skipped_pairs(&self, links @ [a, b]: [usize; 2], allowed: Option<bool>) -> impl Iterator<Item = Skipped> {
        let of_links = self.links(links);
        let all = self.testable(a).flat_map(move |own| self.testable(b).map(move |other| [[a, own], [b, other]]));
        let reasons = all.map(move |pair| (pair, self.collisions(allowed, of_links, pair)));
        let first = reasons.clone().find_map(|(_, reason)| reason);
        let is_one = first.is_some() && reasons.clone().all(|(_, reason)| reason == first);
        let skipped =
            move |geoms, reason| Skipped::Pair { links: links.map(|link| self.names[link].clone()), geoms, reason };
        let whole = first.filter(|_| is_one).map(|reason| skipped(None, reason));
        let each = reasons.take(if is_one { 0 } else { usize::MAX }).filter_map(move |(pair, reason)| {
            let geoms = pair.map(|[link, index]| self.collisions[link][index].name.clone());
            Some(skipped(Some(geoms), reason?))
        });
        whole.into_iter().chain(each)
    }

    /// Whether nothing is tested.
    pub fn is_disabled(&self) -> bool {
        self.is_disabled
    }

    /// Whether geoms of one link are tested against each other: MJCF may name them as a `pair`.
    fn pairs_within(&self, link: usize) -> bool {
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
