//! Rules of the house: which crate may see which, what the project is built from, how wide comments
//! are, and a README that stays true. stays true.

mod comments;
mod dependencies;
mod examples;
mod readme;
mod walls;
