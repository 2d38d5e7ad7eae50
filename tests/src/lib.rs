//! Libraries of the tests of the whole workspace. Truths and packs that other packages' tests need
//! too are in `hullmap-testkit`.
//!
//! | module | contents | program |
//! |---|---|---|
//! | [`hostile`] | damaged and hostile packs | `hostile-packs` |
//! | [`faults`] | bakes with faults at system calls, power cuts (Linux) | `bake-faults` |
//! | [`soak`] | solver answers judged by certificates | `solver-soak` |
//! | [`degenerate`] | small hulls in degenerate poses, judged by their exact depth | `degenerate-truth` |
//! | [`sheets`] | queries of triangle meshes judged by brute force | `mesh-truth` |
//! | [`sampler`] | bounds of convex parts, tried by sampling | `decompose-soak` |
//! | [`fuzzed`] | the fuzz targets, and their corpora | the targets in `fuzz/` |
//! | [`game_hulls`] | game hulls, from outside of the repository | |
//! | [`directions`], [`regret`] | directions in which a support query can fail, and by how much | |

pub mod degenerate;
pub mod directions;
#[cfg(target_os = "linux")]
pub mod faults;
pub mod fuzzed;
pub mod game_hulls;
pub mod hostile;
pub mod index_truth;
pub mod regret;
pub mod sampler;
pub mod sheets;
pub mod soak;
