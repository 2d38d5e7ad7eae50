//! Dependencies and contents of crates: walls between crates, circles of files, unsafe code,
//! length of functions, and what is published.

mod circles;
mod functions;
mod packages;
mod walls;
