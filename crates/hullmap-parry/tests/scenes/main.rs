//! Scenes in Rapier: bodies come to rest, slide over seams, and go on after their world was saved.

mod rest;
mod saved;
// The recipe of docs/engines.md.
#[expect(dead_code, reason = "the page's own program calls it")]
mod saving;
mod slide;
mod stage;
