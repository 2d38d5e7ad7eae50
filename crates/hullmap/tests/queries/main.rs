//! Queries by way of the public interface, against truths in f64. One binary, because each would
//! compile the solver again.

mod cascade;
mod compound;
mod defaults;
mod entry;
mod features;
mod half_space;
mod lean;
mod manifold;
mod pairings;
mod seams;
mod shared_hull;
mod solver;
mod stack;
