//! Which pairs are tested: the filter of the description, then the allowed collision matrix.
//!
//! The matrix has an entry for each pair that the user or an SRDF file names. An entry overrides
//! the filter, and a later entry an earlier one.
//!
//! # Reference
//! MoveIt's `AllowedCollisionMatrix`.

use std::collections::BTreeMap;
use std::path::Path;

use hullmap_robot::{SkipReason, Skipped, srdf_pairs};

use crate::error::PlanningError;
use crate::robot::{BodyOrObstacle, BodyPair, Couple, Robot};

const NAMES_SHOWN: usize = 12;

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
        for links @ [a, b] in self.filter.pairs_of_links() {
            let (allowed, of_links) = (self.allowed.get(&links).copied(), self.filter.links(links));
            let shared = self.shared_joints(links);
            let all = self.of_link[a].clone().flat_map(|a| self.of_link[b].clone().map(move |b| [a, b]));
            let is_tested = |bodies: &[usize; 2]| {
                // Within a link, each pair once.
                let is_first = a != b || bodies[0] <= bodies[1];
                let shapes = bodies.map(|body| [self.bodies[body].link, self.bodies[body].shape]);
                is_first && self.filter.collisions(allowed, of_links, shapes).is_none()
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

    /// Pairs and geometry that are not tested, with reasons. A pair of links is listed once if one
    /// reason holds for all its geoms; else, each pair of geoms is. O(p) for p pairs of geoms.
    pub fn skipped(&self) -> Vec<Skipped> {
        let mut found: Vec<Skipped> = self.filter.skipped(&self.allowed).collect();
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
            disabled.into_iter().chain(self.filter.untested().map(|own| own.to_string())).collect();
        if causes.is_empty() { Ok(self) } else { Err(PlanningError::Untested { file: self.file, causes }) }
    }
}

fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}
