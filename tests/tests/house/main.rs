//! Rules of the house: which crate may see which, what the project is built from, how wide comments
//! are, and documents that stay true.

mod comments;
mod dependencies;
mod examples;
mod names;
mod readme;
mod walls;
