//! What can be wrong with a source file, said so that its author can mend it.

use std::fmt;

/// Why a source file was not imported: where and what.
#[derive(Debug)]
pub struct ImportError {
    /// The file as the user named it.
    pub file: String,
    /// One-based line; of a continued line the first. `None` where the whole file is meant.
    pub line: Option<usize>,
    /// What was found, what was expected, and the remedy.
    pub fault: Fault,
}

impl fmt::Display for ImportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", self.file, self.fault),
            None => write!(f, "{}: {}", self.file, self.fault),
        }
    }
}

impl std::error::Error for ImportError {}

/// A [`Fault`] and the one-based line it was found at.
#[derive(Debug)]
pub struct LineFault {
    /// See [`ImportError::line`].
    pub line: Option<usize>,
    /// What is wrong.
    pub fault: Fault,
}

/// What is wrong with a source file.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum Fault {
    /// What the other formats can have wrong with them, in full.
    #[error("{0}")]
    Format(String),
    /// A coordinate that leaves f32 when it is scaled or moved.
    #[error("vertex {vertex} is at {coordinate:e} {after}, too large for 32-bit floats (limit 3.4e38); {remedy}")]
    Unplaceable {
        /// Zero-based number.
        vertex: u32,
        /// The coordinate.
        coordinate: f64,
        /// What was done to it.
        after: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// More objects than the limit, in a file that is to be cut at them.
    #[error(
        "more than {limit} objects, each of which would become a hull; use --split none, split the file, or raise --max-objects"
    )]
    TooManyObjects {
        /// The limit.
        limit: usize,
    },
    /// Zero bytes, or white space only.
    #[error("the file is empty; expected an OBJ file with `v x y z` lines: export it again")]
    Empty,
    /// A UTF-16 byte order mark.
    #[error("the file is UTF-16 text; OBJ is ASCII or UTF-8: save it again as UTF-8")]
    Utf16,
    /// Not one `v` line.
    #[error(
        "no `v x y z` line found; a hull needs at least one point: is this an OBJ file, and did the export finish?"
    )]
    NoVertices,
    /// More `v` lines than vertex numbers.
    #[error("more than {} vertices; split the file", u32::MAX - 1)]
    TooManyVertices,
    /// More references than their places can be numbered.
    #[error("more than {} corners; split the file", u32::MAX)]
    TooManyReferences,
    /// Fewer than three numbers after `v`.
    #[error(
        "`v` has {found} of its 3 coordinates; expected `v x y z`: complete the line, or export the file again if it was cut off"
    )]
    TooFewCoordinates {
        /// Numbers found.
        found: usize,
    },
    /// A number of numbers after `v` that has no meaning.
    #[error("`v` has {found} numbers; expected 3 (x y z), 4 (x y z w) or 6 (x y z r g b): remove the others")]
    CoordinateCount {
        /// Numbers found.
        found: usize,
    },
    /// A coordinate that is no number.
    #[error("coordinate `{text}` is not a number; expected one such as -1.5 or 2e-3{}", comma_hint(.text))]
    BadNumber {
        /// The word found.
        text: String,
    },
    /// A coordinate that says NaN.
    #[error(
        "coordinate `{text}` is not a number (NaN); mend the mesh where it was made: degenerate geometry or a division by zero"
    )]
    NotANumber {
        /// The word found.
        text: String,
    },
    /// A coordinate that says infinity.
    #[error("coordinate `{text}` is infinite; a hull needs finite points: mend or remove this vertex")]
    Infinite {
        /// The word found.
        text: String,
    },
    /// A coordinate that is finite in the text and too large for an `f32`.
    #[error("coordinate `{text}` is too large for 32-bit floats (limit 3.4e38); scale the mesh down")]
    Overflow {
        /// The word found, or the quotient of two.
        text: String,
    },
    /// A fourth coordinate of zero, which puts the point at infinity.
    #[error("the weight w of `v x y z w` is 0, which puts the point at infinity; use 1 or leave it out")]
    ZeroWeight,
    /// An `f`, `l` or `p` without anything behind it.
    #[error("`{keyword}` names no vertices; complete or remove the line")]
    NoReferences {
        /// The element's keyword.
        keyword: String,
    },
    /// A vertex reference that cannot be read.
    #[error("`{text}` is not a vertex reference; expected forms such as 7, 7/1, 7//3, 7/1/3 or -1")]
    BadReference {
        /// The word found.
        text: String,
    },
    /// Vertex number 0.
    #[error(
        "vertex number 0 in `{text}`; OBJ counts from 1, or from -1 backwards: was the file written with numbers from 0?"
    )]
    ZeroIndex {
        /// The word found.
        text: String,
    },
    /// A positive vertex number above the number of `v` lines in the file.
    #[error(
        "vertex number {number} is out of range: the file has {count} vertices; was the file cut off or put together from parts?"
    )]
    IndexTooLarge {
        /// The number found.
        number: u64,
        /// Vertices in the whole file.
        count: usize,
    },
    /// A negative vertex number that reaches back before the first `v` line.
    #[error(
        "vertex number {text} is out of range: {declared} vertices stand above this line, so -{declared} is the lowest"
    )]
    IndexBeforeFirst {
        /// The word found.
        text: String,
        /// Vertices above the line.
        declared: usize,
    },
    /// tobj, the second reader, does not accept what the first one accepted.
    #[error("the second reader (tobj) refuses the file: {0}; please report it with the file")]
    Refused(tobj::LoadError),
    /// The two readers came to different points.
    #[error("two readers disagree: {0}; the points cannot be trusted: please report it with the file")]
    Disagreement(String),
}

/// Longest excerpt of a faulty word in a message, in characters.
const EXCERPT_CHARS: usize = 40;

/// The start of a faulty word, without control characters.
pub fn excerpt(word: &str) -> String {
    let mut text: String =
        word.chars().take(4 * EXCERPT_CHARS).filter(|c| !c.is_control()).take(EXCERPT_CHARS).collect();
    if word.chars().nth(EXCERPT_CHARS).is_some() {
        text.push('…');
    }
    text
}

impl Fault {
    /// A fault of a format without variants of its own: what was found, what was expected, and the remedy.
    pub fn format(text: impl Into<String>) -> Self {
        Self::Format(text.into())
    }

    /// The fault at a one-based line.
    pub fn at(self, line: usize) -> LineFault {
        LineFault { line: Some(line), fault: self }
    }

    /// The fault of the whole file.
    pub fn of_file(self) -> LineFault {
        LineFault { line: None, fault: self }
    }
}

/// Decimal commas are the one malformed number with a remedy of its own.
fn comma_hint(text: &str) -> &'static str {
    if text.contains(',') { ": use a point, not a comma" } else { ": correct the line" }
}
