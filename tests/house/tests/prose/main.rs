//! Comments and documents: their width and length, that they agree with the code, and that examples
//! run.

mod comments;
mod documents;
mod guides;
mod names;
mod readme;
mod words;
