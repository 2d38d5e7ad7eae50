//! Hulls as meshes for other programs: what `bake export` and `bake robot` share.

pub mod body;
pub mod names;
pub mod obj;
