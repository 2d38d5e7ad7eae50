//! glTF files to which colliders are added, in place: everything else keeps its bytes.

pub mod colliders;
pub mod container;
pub mod edit;
