//! Rules for what crates may depend on and contain: walls between crates, unsafe code, other
//! packages and their licences, and what is published.

mod dependencies;
mod packages;
mod walls;
