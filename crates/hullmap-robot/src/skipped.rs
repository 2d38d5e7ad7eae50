//! Collisions that are not tested, and the reasons.

use std::fmt;

/// Why a pair is not tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SkipReason {
    /// The two never move relative to each other.
    RigidlyConnected,
    /// A joint connects the two.
    Adjacent,
    /// Neither has degrees of freedom: static and mocap bodies of MJCF.
    Immobile,
    /// `contact` / `exclude` of MJCF.
    Excluded,
    /// `contype` and `conaffinity` of MJCF do not match.
    Masks,
    /// `option` / `flag` of MJCF disables all contacts.
    Disabled,
    /// The user or an SRDF file allows the collision.
    Allowed,
}

impl SkipReason {
    /// The reason in words.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::RigidlyConnected => "rigidly connected",
            Self::Adjacent => "adjacent: connected by a joint",
            Self::Immobile => "neither body has degrees of freedom",
            Self::Excluded => "excluded by `exclude`",
            Self::Masks => "`contype` and `conaffinity` do not match",
            Self::Disabled => "contacts are disabled by `flag`",
            Self::Allowed => "allowed",
        }
    }
}

impl fmt::Display for SkipReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.in_words())
    }
}

/// A pair or a geometry that is not tested.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Skipped {
    /// A pair of links, or of geoms of two links.
    Pair {
        /// Names of the links.
        links: [String; 2],
        /// Names of the geoms; `None` for all pairs of geoms of the two links.
        geoms: Option<[String; 2]>,
        /// Why it is not tested.
        reason: SkipReason,
    },
    /// A geometry without a shape that can be queried.
    Geometry {
        /// The name of its link; `None` if it belongs to no link that was read.
        link: Option<String>,
        /// Its name, or its element.
        geom: String,
        /// The line in its file.
        line: u32,
        /// Why it is not tested.
        cause: String,
    },
}

impl Skipped {
    /// The names of its links and of its geoms, and the reason: a row of a list.
    pub fn row(self) -> (Vec<String>, Vec<String>, String) {
        match self {
            Self::Pair { links, geoms, reason } => {
                (links.into(), geoms.map(Vec::from).unwrap_or_default(), reason.to_string())
            }
            Self::Geometry { link, geom, line, cause } => {
                (link.into_iter().collect(), vec![geom], format!("line {line}: {cause}"))
            }
        }
    }
}

impl fmt::Display for Skipped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pair { links: [a, b], geoms: None, reason } => write!(f, "`{a}` and `{b}`: {reason}"),
            Self::Pair { links: [a, b], geoms: Some([own_a, own_b]), reason } => {
                write!(f, "`{own_a}` of `{a}` and `{own_b}` of `{b}`: {reason}")
            }
            Self::Geometry { link: Some(link), line, cause, .. } => {
                write!(f, "link `{link}`, line {line}: not tested: {cause}")
            }
            Self::Geometry { link: None, geom, line, cause } => write!(f, "line {line}: {geom} is not tested: {cause}"),
        }
    }
}

/// The name of a geom in lists, if it may have none.
pub(crate) fn named(name: &str, line: u32) -> String {
    if name.is_empty() { format!("geom in line {line}") } else { name.to_owned() }
}
