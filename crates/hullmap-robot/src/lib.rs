//! Robot descriptions: finds collision geometry in URDF, MJCF and SDF files, and edits it in place.
//!
//! 1. [`Description::read`] reads a file, and the files that it includes. [`Places`] has the
//!    folders of meshes and packages. The result lists links, their collisions and visuals.
//! 2. The caller makes hulls of the meshes, and passes the changes: a list of [`Change`].
//! 3. [`Description::changed`] returns the bytes of each file.
//!
//! Only collision geometry changes. An edit replaces a span of the text, which the XML reader
//! found; every other byte is copied: comments, order, white space, line ends, encoding.
//!
//! | module | concept |
//! |---|---|
//! | `description` | links, shapes and changes, in every format |
//! | `formats` | reading and editing in any format |
//! | `urdf`, `sdf`, `mjcf` | one format each |
//! | `chain`, `frame` | joints, and where they move links |
//! | `collision_filter`, `skipped` | which pairs are tested, and why others are not |
//! | `primitive` | sizes of primitives |
//! | `srdf` | pairs that MoveIt does not test |
//! | `places` | from a name to a file |
//! | `document` | bytes, encoding, and parsing within limits |
//! | `lenient` | what robot programs accept and XML does not |
//! | `element`, `edit` | spans of elements, and edits of spans |
//!
//! ```
//! use hullmap_robot::{Change, Description, Places};
//!
//! let folder = std::env::temp_dir().join("hullmap-robot-example");
//! std::fs::create_dir_all(&folder)?;
//! let text = "<robot name='r'>\n<link name='arm'>\n <collision><geometry>\n  <mesh filename='arm.stl'/> <!-- kept -->\n\
//!             </geometry></collision>\n</link>\n</robot>\n";
//! std::fs::write(folder.join("r.urdf"), text)?;
//! let description = Description::read(&folder.join("r.urdf"), &Places::default())?;
//! assert_eq!(description.links[0].name, "arm");
//! let change = Change::Replace { link: 0, collision: 0, meshes: vec!["arm_hull.obj".to_owned()] };
//! let changed = String::from_utf8(description.changed(&[change])?.remove(0))?;
//! assert_eq!(changed, text.replace("arm.stl", "arm_hull.obj"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

mod chain;
mod collision_filter;
mod description;
mod document;
mod edit;
mod element;
mod error;
mod formats;
mod frame;
mod lenient;
mod link_edits;
mod links;
mod mjcf;
mod places;
mod primitive;
mod sdf;
mod skipped;
mod srdf;
mod urdf;

pub use chain::{COEFFICIENTS, Chain, Coupling, Displacement, Joint, Motion, Placement};
pub use collision_filter::{CollisionFilter, masks_match};
pub use description::{
    Change, Contacts, Description, Format, Geometry, Link, MeshUse, OtherModel, Reference, Shape, Submesh, Unread,
};
pub use document::Document;
pub use element::escaped;
pub use error::RobotError;
pub use frame::Frame;
pub use glam;
pub use places::{InlineMesh, Places, Scheme, Unresolved, relative};
pub use primitive::{NamedPrimitive, Primitive};
pub use skipped::{SkipReason, Skipped};
pub use srdf::{DisabledPair, SrdfPairs, srdf, srdf_pairs};
