//! Errors of robots and configurations, each with the remedy.

use std::path::PathBuf;

use hullmap::PoseError;
use hullmap_robot::RobotError;

/// Why a robot cannot be built or queried.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum PlanningError {
    /// The description cannot be read, or is invalid.
    #[error(transparent)]
    Description(#[from] RobotError),
    /// A collision has no shape that can be queried.
    #[error("{}:{line}: link `{link}`: {cause}", file.display())]
    Collision { file: PathBuf, line: u32, link: String, cause: String },
    /// A folder of packs does not exist.
    #[error("{}: no such folder; name folders of packs that `bake` has written, or none", folder.display())]
    NoSuchFolder { folder: PathBuf },
    /// No link and no obstacle has this name.
    #[error("`{name}` is neither a link with a collision nor an obstacle; there are {}", listed(known))]
    UnknownName {
        name: String,
        /// Some of the known names.
        known: Vec<String>,
    },
    /// An obstacle has a name that is in use.
    #[error("obstacle `{name}` has the name of another obstacle or of a link; choose another one")]
    NameInUse { name: String },
    /// A configuration has too few or too many numbers.
    #[error("a configuration has {expected} numbers, one for each joint, found {found}")]
    JointCount { expected: usize, found: usize },
    /// The poses of links are too few or too many.
    #[error("there are {expected} links, found {found} poses; pass the pose of each link in the world")]
    LinkCount { expected: usize, found: usize },
    /// A link is too far away for a pose.
    #[error("link `{link}`: {error}")]
    LinkPose { link: String, error: PoseError },
    /// Some geometry is not tested, which [`Robot::strict`](crate::Robot::strict) does not accept.
    #[error("{}: {}{}; change the description, or read it without `strict`", file.display(), causes[0], others(causes))]
    Untested {
        file: PathBuf,
        /// The untested collisions and the reasons; at least one.
        causes: Vec<String>,
    },
    /// A joint's position is NaN or out of range.
    #[error("joint `{joint}`: {value} is no position; pass finite numbers below 1e15")]
    Position { joint: String, value: f64 },
}

fn listed(names: &[String]) -> String {
    if names.is_empty() { "none".to_owned() } else { format!("`{}`", names.join("`, `")) }
}

fn others(causes: &[String]) -> String {
    if causes.len() == 1 { String::new() } else { format!(", and {} more", causes.len() - 1) }
}
