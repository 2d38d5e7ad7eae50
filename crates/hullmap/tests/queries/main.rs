//! Tests of queries through the public interface, against ground truth in f64. One binary, so that
//! the solver is compiled once.

mod any_shape;
mod clear;
mod compound;
mod defaults;
mod derivatives;
mod entry;
mod features;
mod half_space;
mod lean;
mod manifold;
mod motions;
mod motions_of_parts;
mod pairings;
mod seams;
mod shared_hull;
mod solver;
mod stack;
