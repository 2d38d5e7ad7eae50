//! Comments and documents: their width, that they agree with the code, and that examples are there.

mod comments;
mod documents;
mod examples;
mod names;
mod readme;
