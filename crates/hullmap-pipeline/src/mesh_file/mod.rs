//! Hulls as files of meshes, written in memory and put in place: for `bake export`,
//! `bake decompose` and `bake robot`.

pub mod body;
pub mod glb;
pub mod glb_chunks;
pub mod names;
pub mod obj;
pub mod place;
pub mod seal;
pub mod stl;
pub mod usda;
