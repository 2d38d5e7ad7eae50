//! House rules: dependencies between crates and on other packages, width of comments, and documents
//! that agree with the code.

mod comments;
mod dependencies;
mod documents;
mod examples;
mod names;
mod packages;
mod readme;
mod walls;
