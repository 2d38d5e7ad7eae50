//! Judges the solver by truths about pairs of hulls, which `hullmap-testkit` computes in f64
//! without the solver.
//!
//! | module | contents |
//! |---|---|
//! | [`scene`] | hulls of many kinds and the poses they meet in |
//! | [`verdict`] | wrong answers, and the counts over all pairs |
//! | [`exact`] | the depth of two small hulls in exact arithmetic |
//! | [`degenerate`] | small hulls in degenerate poses, judged by their exact depth |

pub mod degenerate;
pub mod exact;
pub mod scene;
pub mod verdict;
