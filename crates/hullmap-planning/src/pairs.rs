//! Which pairs are tested: the filter of the description, then the allowed collision matrix.
//!
//! The matrix has an entry for each pair that the user or an SRDF file names. An entry overrides
//! the filter, and a later entry an earlier one.
//!
//! # Reference
//! MoveIt's `AllowedCollisionMatrix`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use hullmap_robot::{SkipReason, srdf_pairs};

use crate::error::PlanningError;
use crate::robot::{BodyOrObstacle, BodyPair, Couple, Robot};
use crate::skipped::Skipped;

const NAMES_SHOWN: usize = 12;

/// Pairs of collisions of two links, each an index of its link's collisions.
type Shapes = [usize; 2];

impl Robot {
    /// Allows pairs of links, or of links and obstacles, to collide: they are not tested.
    ///
    /// # Errors
    /// A name is unknown. Then nothing changes.
    pub fn allow<N: AsRef<str>>(&mut self, pairs: impl IntoIterator<Item = [N; 2]>) -> Result<(), PlanningError> {
        self.set_allowed(pairs, true)
    }

    /// Disallows collisions of pairs of links, or of links and obstacles: they are tested, whatever
    /// the description says, and all of their geoms are.
    ///
    /// # Errors
    /// A name is unknown. Then nothing changes.
    pub fn disallow<N: AsRef<str>>(&mut self, pairs: impl IntoIterator<Item = [N; 2]>) -> Result<(), PlanningError> {
        self.set_allowed(pairs, false)
    }

    fn set_allowed<N: AsRef<str>>(
        &mut self,
        pairs: impl IntoIterator<Item = [N; 2]>,
        is_allowed: bool,
    ) -> Result<(), PlanningError> {
        let index = self.indices();
        let find = |name: &str| {
            index.get(name).copied().ok_or_else(|| PlanningError::UnknownName {
                name: name.to_owned(),
                known: index.keys().take(NAMES_SHOWN).map(|name| (*name).to_owned()).collect(),
            })
        };
        let mut entries = BTreeMap::new();
        for [a, b] in pairs {
            entries.insert(sorted([find(a.as_ref())?, find(b.as_ref())?]), is_allowed);
        }
        self.allowed.extend(entries);
        self.list_pairs();
        Ok(())
    }

    /// Allows the pairs that an SRDF file disables, and disallows the pairs that it enables. Names
    /// of other robots are ignored.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn allow_srdf(&mut self, file: &Path) -> Result<(), PlanningError> {
        let pairs = srdf_pairs(file)?;
        let index = self.indices();
        let find = |[a, b]: [String; 2]| Some(sorted([*index.get(a.as_str())?, *index.get(b.as_str())?]));
        let of_link = |name: String| index.get(name.as_str()).copied();
        let mut entries = BTreeMap::new();
        for own in pairs.disabled_links.into_iter().filter_map(of_link) {
            let others = (0..self.links.len()).filter(|other| *other != own);
            entries.extend(others.map(|other| (sorted([own, other]), true)));
        }
        entries.extend(pairs.enabled.into_iter().filter_map(find).map(|pair| (pair, false)));
        entries.extend(pairs.disabled.into_iter().filter_map(find).map(|pair| (pair, true)));
        self.allowed.extend(entries);
        self.list_pairs();
        Ok(())
    }

    fn indices(&self) -> BTreeMap<&str, usize> {
        let obstacles = self.obstacles.iter().map(|own| own.obstacle.name.as_str());
        let names = self.links.iter().map(String::as_str).chain(obstacles);
        names.enumerate().map(|(index, name)| (name, index)).collect()
    }

    pub(crate) fn list_pairs(&mut self) {
        let (mut pairs, mut couples) = (Vec::new(), Vec::new());
        let mut add = |a: BodyOrObstacle, b: usize, own: Vec<BodyPair>| {
            let first = pairs.len();
            pairs.extend(own);
            if pairs.len() > first {
                couples.push(Couple { a, b, pairs: first..pairs.len() });
            }
        };
        for links @ [a, b] in self.pairs_of_links() {
            let skipped = self.skipped_shapes(links);
            let shared = self.shared_joints(links);
            let all = self.of_link[a].clone().flat_map(|a| self.of_link[b].clone().map(move |b| [a, b]));
            let is_tested = |bodies: &[usize; 2]| {
                // Within a link, each pair once.
                let is_first = a != b || bodies[0] <= bodies[1];
                is_first && !skipped.contains_key(&bodies.map(|body| self.bodies[body].shape))
            };
            let pair = |[a, b]: [usize; 2]| BodyPair { a: BodyOrObstacle::Body(a), b, shared };
            add(BodyOrObstacle::Body(a), b, all.filter(is_tested).map(pair).collect());
        }
        for obstacle in 0..self.obstacles.len() {
            for b in self.links_with_bodies() {
                if self.allowed.get(&[b, self.links.len() + obstacle]) != Some(&true) {
                    let a = BodyOrObstacle::Obstacle(obstacle);
                    add(a, b, self.of_link[b].clone().map(|b| BodyPair { a, b, shared: 0 }).collect());
                }
            }
        }
        (self.pairs, self.couples) = (pairs, couples);
    }

    fn links_with_bodies(&self) -> impl Iterator<Item = usize> + Clone {
        (0..self.links.len()).filter(|link| !self.of_link[*link].is_empty())
    }

    /// The lower link is first. A link is its own partner only if MJCF pairs its geoms.
    fn pairs_of_links(&self) -> impl Iterator<Item = [usize; 2]> {
        let links = self.links_with_bodies();
        links
            .clone()
            .flat_map(move |a| links.clone().filter(move |b| a <= *b).map(move |b| [a, b]))
            .filter(|[a, b]| a != b || self.filter.pairs_within(*a))
    }

    fn shapes_of(&self, link: usize) -> BTreeSet<usize> {
        self.of_link[link].clone().map(|body| self.bodies[body].shape).collect()
    }

    fn skipped_shapes(&self, links @ [a, b]: [usize; 2]) -> BTreeMap<Shapes, SkipReason> {
        let allowed = self.allowed.get(&links);
        let of_links = self.filter.links(links);
        let others = self.shapes_of(b);
        let all = self.shapes_of(a).into_iter().flat_map(|own| others.iter().map(move |other| [own, *other]));
        let skipped = all.filter_map(|shapes @ [own, other]| match allowed {
            Some(true) => Some((shapes, SkipReason::Allowed)),
            Some(false) if a != b => None,
            _ => Some((shapes, self.filter.collisions(of_links, [[a, own], [b, other]])?)),
        });
        skipped.collect()
    }

    /// Pairs and geometry that are not tested, with reasons. A pair of links is listed once if one
    /// reason holds for all its geoms; else, each pair of geoms is. O(p) for p pairs of geoms.
    pub fn skipped(&self) -> Vec<Skipped> {
        let mut found = self.skipped_geometry.clone();
        for links @ [a, b] in self.pairs_of_links().filter(|[a, b]| a != b) {
            let skipped = self.skipped_shapes(links);
            let names = links.map(|link| self.links[link].clone());
            let reasons: BTreeSet<SkipReason> = skipped.values().copied().collect();
            match reasons.first() {
                Some(&reason)
                    if reasons.len() == 1 && skipped.len() == self.shapes_of(a).len() * self.shapes_of(b).len() =>
                {
                    found.push(Skipped::Pair { links: names, geoms: None, reason });
                }
                _ => found.extend(skipped.into_iter().map(|([own, other], reason)| {
                    let geoms = Some([self.geoms[a][own].clone(), self.geoms[b][other].clone()]);
                    Skipped::Pair { links: names.clone(), geoms, reason }
                })),
            }
        }
        let is_obstacle = |pair: &[usize; 2]| pair[1] >= self.links.len() && !self.of_link[pair[0]].is_empty();
        let allowed = self.allowed.iter().filter(|(pair, is_allowed)| **is_allowed && is_obstacle(pair));
        found.extend(allowed.map(|(pair, _)| {
            let links = pair.map(|index| self.collider(index).unwrap_or_default().to_owned());
            Skipped::Pair { links, geoms: None, reason: SkipReason::Allowed }
        }));
        found
    }

    /// The robot, if all of its geometry is tested.
    ///
    /// # Errors
    /// Some geometry is not, or the description disables all contacts.
    pub fn strict(self) -> Result<Self, PlanningError> {
        let disabled = self.filter.is_disabled().then(|| SkipReason::Disabled.to_string());
        let causes: Vec<String> =
            disabled.into_iter().chain(self.skipped_geometry.iter().map(Skipped::to_string)).collect();
        if causes.is_empty() { Ok(self) } else { Err(PlanningError::Untested { file: self.file, causes }) }
    }
}

fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}
