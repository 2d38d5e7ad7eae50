//! glTF files to which colliders are added, in place: everything else keeps its bytes.
//!
//! | module | concept |
//! |---|---|
//! | `container` | a glTF file, as text or GLB, taken apart and put together |
//! | `edit` | insertions into JSON text |
//! | `colliders` | hulls and masses as nodes with physics extensions |

pub mod colliders;
pub mod container;
pub mod edit;
