//! The faces of a small polytope, as the separating axis test (SAT) reads them.
//!
//! | file | concept |
//! |---|---|
//! | `table` | the face table of a hull: normals and offsets, vertices, and the arcs of the Gauss map |
//! | `build` | how a hull's table is built and proven when its pack is opened |
//! | `view` | [`Facets`]: the faces of a hull or of a box |
//! | `lane_set` | sets of faces or vertices, in blocks of eight lanes |

mod build;
pub(crate) mod lane_set;
pub(crate) mod table;
pub(crate) mod view;

pub use view::Facets;
