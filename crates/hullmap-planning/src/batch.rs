//! Many configurations or edges in one call, on all threads of the current pool.
//!
//! Each run of configurations has its own memory: answers do not depend on the number of threads.

use hullmap::{Differentiability, Settings};
use rayon::prelude::*;

use crate::clear::{EdgeClearance, EdgeSettings};
use crate::clearance::RobotClearance;
use crate::error::PlanningError;
use crate::memory::Memory;
use crate::robot::Robot;

/// Configurations of a run: about 1 ms of work.
const RUN: usize = 256;

const RUN_OF_EDGES: usize = 32;

/// Solves rows in runs. `row` solves the row of an index, and gets the memory of its run.
fn solve<T: Send>(
    robot: &Robot,
    run: usize,
    out: &mut [T],
    row: impl Fn(usize, &mut T, &mut Memory) -> Result<(), PlanningError> + Sync,
) -> Result<(), PlanningError> {
    out.par_chunks_mut(run).enumerate().try_for_each(|(index, out)| {
        let mut memory = robot.memory();
        out.iter_mut().enumerate().try_for_each(|(at, out)| row(index * run + at, out, &mut memory))
    })
}

impl Robot {
    /// [`in_collision`](Self::in_collision) of each row of `q`, which has a number for each joint.
    ///
    /// # Errors
    /// A number is out of range, or `q` has not as many rows as `out`.
    pub fn in_collision_batch(&self, q: &[f64], margin: f64, out: &mut [bool]) -> Result<(), PlanningError> {
        let rows = self.rows(q, out.len())?;
        solve(self, RUN, out, |at, out, memory| {
            *out = self.in_collision(rows(at), margin, memory)?;
            Ok(())
        })
    }

    /// [`clearance`](Self::clearance) of each row of `q`.
    ///
    /// # Errors
    /// As for [`in_collision_batch`](Self::in_collision_batch).
    pub fn clearance_batch(
        &self,
        q: &[f64],
        settings: &Settings,
        out: &mut [RobotClearance],
    ) -> Result<(), PlanningError> {
        let rows = self.rows(q, out.len())?;
        solve(self, RUN, out, |at, out, memory| {
            *out = self.clearance(rows(at), settings, memory)?;
            Ok(())
        })
    }

    /// [`clearance_gradient`](Self::clearance_gradient) of each row of `q`, with its gradient.
    ///
    /// # Errors
    /// As for [`in_collision_batch`](Self::in_collision_batch).
    pub fn clearance_gradient_batch(
        &self,
        q: &[f64],
        settings: &Settings,
        out: &mut [(RobotClearance, Differentiability, Vec<f64>)],
    ) -> Result<(), PlanningError> {
        let rows = self.rows(q, out.len())?;
        solve(self, RUN, out, |at, (clearance, status, gradient), memory| {
            gradient.resize(self.joint_count(), 0.0);
            (*clearance, *status) = self.clearance_gradient(rows(at), settings, memory, gradient)?;
            Ok(())
        })
    }

    /// [`clear`](Self::clear) of the edges from each row of `start` to the same row of `end`.
    ///
    /// # Errors
    /// As for [`in_collision_batch`](Self::in_collision_batch).
    pub fn clear_batch(
        &self,
        start: &[f64],
        end: &[f64],
        settings: &EdgeSettings,
        out: &mut [EdgeClearance],
    ) -> Result<(), PlanningError> {
        let (start, end) = (self.rows(start, out.len())?, self.rows(end, out.len())?);
        solve(self, RUN_OF_EDGES, out, |at, out, memory| {
            *out = self.clear(start(at), end(at), settings, memory)?;
            Ok(())
        })
    }

    fn rows<'q>(&self, q: &'q [f64], count: usize) -> Result<impl Fn(usize) -> &'q [f64] + Sync, PlanningError> {
        let width = self.joint_count();
        if q.len() != width * count {
            return Err(PlanningError::JointCount { expected: width * count, found: q.len() });
        }
        Ok(move |at: usize| &q[at * width..(at + 1) * width])
    }
}
