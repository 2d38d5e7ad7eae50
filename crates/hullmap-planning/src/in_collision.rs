//! Whether a robot touches itself or an obstacle in one configuration.

use hullmap::{Overlap, Pose, Settings};

use crate::error::PlanningError;
use crate::memory::Memory;
use crate::robot::Robot;

impl Robot {
    /// Whether two tested links, or a link and an obstacle, touch or are within `margin` of each
    /// other. Touching and undecided pairs count. NaN and negative margins count as 0.
    ///
    /// # Errors
    /// The length of `q` is not the number of joints, or a number is out of range.
    ///
    /// # Complexity
    /// A few comparisons for each pair of links, and a query for each pair whose balls overlap, up
    /// to the first one that touches. No allocation after the first calls.
    pub fn in_collision(&self, q: &[f64], margin: f64, memory: &mut Memory) -> Result<bool, PlanningError> {
        self.place(q, memory)?;
        Ok(self.touching_pair(margin, memory).is_some())
    }

    /// As [`in_collision`](Self::in_collision), for given poses of all links in the world.
    ///
    /// # Errors
    /// There are more or fewer poses than links.
    pub fn in_collision_at(&self, poses: &[Pose], margin: f64, memory: &mut Memory) -> Result<bool, PlanningError> {
        self.place_at(poses, memory)?;
        Ok(self.touching_pair(margin, memory).is_some())
    }

    /// All pairs of colliders that touch in a configuration: to allow pairs that touch by design.
    ///
    /// # Errors
    /// As for [`in_collision`](Self::in_collision).
    pub fn touching(&self, q: &[f64], memory: &mut Memory) -> Result<Vec<[usize; 2]>, PlanningError> {
        self.place(q, memory)?;
        let touches = |own: &crate::robot::Couple, memory: &mut Memory| {
            own.pairs.clone().any(|pair| self.pair_touches(pair, 0.0, memory))
        };
        let couples = self.couples.iter().filter(|couple| touches(couple, memory));
        Ok(couples.map(|couple| self.colliders_of(couple.pairs.start)).collect())
    }

    fn touching_pair(&self, margin: f64, memory: &mut Memory) -> Option<usize> {
        let margin = margin.max(0.0);
        let last = memory.last;
        if last < self.pairs.len() && self.pair_touches(last, margin, memory) {
            return Some(last);
        }
        for couple in &self.couples {
            // NaN takes the failing branch.
            if self.couple_gap(couple, memory) > margin {
                continue;
            }
            if let Some(found) = couple.pairs.clone().find(|pair| self.pair_touches(*pair, margin, memory)) {
                memory.last = found;
                return Some(found);
            }
        }
        None
    }

    fn pair_touches(&self, index: usize, margin: f64, memory: &mut Memory) -> bool {
        let pair = &self.pairs[index];
        if self.pair_gap(pair, memory) > margin {
            return false;
        }
        let pairing = self.pairing(index, memory);
        if margin > 0.0 {
            let found = pairing.distance(&Settings::default(), &mut memory.caches);
            return !(found.lower - self.pair_noise(pair, memory) > margin);
        }
        pairing.overlap(&mut memory.caches) != Overlap::Separated
    }
}
