//! What crates may depend on and contain: walls between crates, circles of files, unsafe code,
//! other packages and their licences, and what is published.

mod circles;
mod dependencies;
mod packages;
mod walls;
