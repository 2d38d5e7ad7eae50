//! What crates may depend on and contain: walls between crates, circles of files, unsafe code,
//! length of functions, other packages and their licences, and what is published.

mod circles;
mod dependencies;
mod functions;
mod packages;
mod walls;
