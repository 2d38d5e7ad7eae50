//! Collision queries of whole robots for motion planning, on exact convex hulls.
//!
//! A [`Robot`] is read from a URDF, MJCF or SDF file. For a configuration of its joints, queries
//! return whether it touches itself or an obstacle, and its clearance, with the pair that decides
//! and the derivatives. For an edge in joint space, they prove whether all configurations are free.
//!
//! | module | concept |
//! |---|---|
//! | `robot` | links, bodies, obstacles |
//! | `pairs` | which pairs are tested, and why others are not |
//! | `kinematics` | where links are, and how joints move them |
//! | `in_collision`, `clearance` | one configuration |
//! | `clear`, `motion_bound` | an edge, and how far bodies move along it |
//! | `batch` | many configurations or edges |
//! | `obstacle`, `convex`, `meshes` | shapes, and where they come from |
//! | `queries` | queries of a body and anything it may touch |
//! | `memory` | what a thread remembers |
//!
//! ```
//! use hullmap_planning::{EdgeSettings, Packs, Robot};
//! use hullmap::Verdict;
//! use hullmap_robot::{Description, Places};
//!
//! // Two bars that turn about z, one at the end of the other, and a post on the base.
//! let text = "<robot name='r'>
//!   <link name='base'><collision><origin xyz='0.2 0 0'/><geometry><box size='0.2 0.2 0.2'/></geometry></collision></link>
//!   <link name='upper'><collision><origin xyz='0.5 0 0'/><geometry><box size='0.8 0.1 0.1'/></geometry></collision></link>
//!   <link name='lower'><collision><origin xyz='0.5 0 0'/><geometry><box size='0.8 0.1 0.1'/></geometry></collision></link>
//!   <joint name='shoulder' type='continuous'><parent link='base'/><child link='upper'/><axis xyz='0 0 1'/></joint>
//!   <joint name='elbow' type='continuous'><parent link='upper'/><child link='lower'/>
//!     <origin xyz='1 0 0'/><axis xyz='0 0 1'/></joint>
//! </robot>";
//! let folder = std::env::temp_dir().join("hullmap-planning-example");
//! std::fs::create_dir_all(&folder)?;
//! std::fs::write(folder.join("r.urdf"), text)?;
//! let robot = Robot::read(&folder.join("r.urdf"), &Places::default(), &mut Packs::default())?;
//!
//! let mut memory = robot.memory();
//! assert!(!robot.in_collision(&[0.0, 1.0], 0.0, &mut memory)?);
//! // The elbow folds the lower bar back onto the post.
//! let found = robot.clear(&[0.0, 1.0], &[0.0, 3.1], &EdgeSettings::default(), &mut memory)?;
//! assert_eq!(found.answer.verdict, Verdict::Hit);
//! let found = robot.clear(&[0.0, -1.0], &[0.0, 2.0], &EdgeSettings::default(), &mut memory)?;
//! assert_eq!(found.answer.verdict, Verdict::Free);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

mod batch;
mod clear;
mod clearance;
mod convex;
mod error;
mod in_collision;
mod kinematics;
mod memory;
mod meshes;
mod motion_bound;
mod obstacle;
mod pairs;
mod queries;
mod robot;

pub use clear::{EdgeClearance, EdgeSettings};
pub use clearance::RobotClearance;
pub use convex::{AnyShape, Convex, hull_of, hulls, shape_of_primitive};
pub use error::PlanningError;
pub use glam;
pub use hullmap_robot::Skipped;
pub use memory::Memory;
pub use meshes::{MeshPoints, Packs, imported, read_file};
pub use obstacle::Obstacle;
pub use robot::{JointFacts, Robot};
