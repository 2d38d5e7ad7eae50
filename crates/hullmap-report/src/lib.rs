//! HTML report of a pack, triangle mesh, height field or robot: one page that any browser opens,
//! without a network.
//!
//! The caller opens the pack, finds its source, verifies it and collects remarks, as an [`Input`].
//! [`analyse`] counts what queries cost and gathers what the page draws. [`pack_page`] makes one
//! page; [`folder_page`] lists packs, a [`Card`] each.
//!
//! | module | concept |
//! |---|---|
//! | [`input`] | a pack, its source and its verification |
//! | `analysis` | everything a page shows, before any of it is HTML |
//! | `index_reader` | a direction index, and the leaf of a direction |
//! | `cells` | the cells of an index, as lines on the cube |
//! | `gauss_map` | support vertices and leaves over the unfolded cube |
//! | `census` | cost of queries over the sphere |
//! | `display_mesh` | triangles and edges to draw |
//! | `solid_mesh` | meshes of primitives |
//! | `picture` | a still picture of them |
//! | `verdict` | the verdict in plain words, and the worst place |
//! | `parts_section`, `part_colours` | the parts of decomposed meshes |
//! | `sizes` | bytes by section |
//! | [`surface`], `surface_page` | a triangle mesh or height field, and its page |
//! | [`robot`], `robot_page` | a robot, and its page |
//! | `relief` | a height field as a shaded relief |
//! | `page` | the head and the scripts that all pages share |
//! | `html`, `encode` | text and numbers in a page |

#![forbid(unsafe_code)]

mod analysis;
mod cells;
mod census;
mod display_mesh;
mod encode;
mod folder_page;
mod gauss_map;
mod html;
mod index_reader;
pub mod input;
mod pack_page;
mod page;
mod part_colours;
mod parts_section;
mod picture;
mod relief;
pub mod robot;
mod robot_page;
mod sizes;
mod solid_mesh;
pub mod surface;
mod surface_page;
#[cfg(test)]
mod test_packs;
mod verdict;

pub use analysis::{Analysis, analyse};
pub use display_mesh::DisplayMesh;
pub use folder_page::{Card, folder_page};
pub use gauss_map::gauss_map_json;
pub use input::Input;
pub use pack_page::pack_page;
pub use robot_page::robot_page;
pub use surface_page::surface_page;
