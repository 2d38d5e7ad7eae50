//! Import errors: what is wrong with a source file, where, and what to do about it.

use std::fmt;

/// Displayed as `file:line: fault`, or `file: fault` where the fault has no line.
#[derive(Debug)]
pub struct ImportError {
    /// Name of the file, as the caller gave it.
    pub file: String,
    /// One-based; the first line of a continued one. `None`: the whole file.
    pub line: Option<usize>,
    /// The finding, the expectation, and the remedy.
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

#[derive(Debug)]
pub struct LineFault {
    pub line: Option<usize>,
    pub fault: Fault,
}

impl LineFault {
    /// A fault of the whole file. The text states the finding, the expectation, and the remedy.
    pub fn of_file(text: impl Into<String>) -> Self {
        Fault::format(text).of_file()
    }
}

/// Fault of a source file.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum Fault {
    /// A fault without a variant of its own: the whole message.
    #[error("{0}")]
    Format(String),
    #[error(
        "the file has more than {limit} bytes, and an import can take eight times as much memory; split it, or raise --set max_input_bytes"
    )]
    InputTooLarge { limit: u64 },
    #[error(
        "vertex {vertex} has the coordinate {coordinate:e} {after}, too large for 32-bit floats (limit 3.4e38); {remedy}"
    )]
    Unplaceable { vertex: u32, coordinate: f64, after: &'static str, remedy: &'static str },
    #[error(
        "the file has more than {}, and each would become a hull; use --split none, split the file, or raise --set max_objects",
        counted(.limit, "object", "objects")
    )]
    TooManyObjects { limit: usize },
    #[error("the file is empty; expected an OBJ file with `v x y z` lines: export it again")]
    Empty,
    /// A UTF-16 byte order mark, in a format other than OBJ.
    #[error("the file is UTF-16 text; expected ASCII, UTF-8 or binary: save it again as UTF-8")]
    Utf16,
    #[error(
        "no `v x y z` line found, but a hull requires at least one point: check that this is an OBJ, glTF, GLB, STL, PLY, COLLADA or MSH file and that the export finished; a grid of heights requires --terrain, and a baked file is no source"
    )]
    NoVertices,
    #[error("the file has more than {} vertices; split it", u32::MAX - 1)]
    TooManyVertices,
    #[error("the file has more than {} face corners; split it", u32::MAX)]
    TooManyReferences,
    #[error(
        "`v` has {found} of 3 coordinates; expected `v x y z`: complete the line, or export the file again if it was cut off"
    )]
    TooFewCoordinates { found: usize },
    /// Five numbers after `v`, or more than six.
    #[error("`v` has {found} numbers; expected 3 (x y z), 4 (x y z w) or 6 (x y z r g b): correct the line")]
    CoordinateCount { found: usize },
    #[error("coordinate `{text}` is not a number; expected a form such as -1.5 or 2e-3{}", comma_hint(.text))]
    BadNumber { text: String },
    #[error("coordinate `{text}` is not a number (NaN); repair the mesh in its editor: look for degenerate geometry")]
    NotANumber { text: String },
    #[error("coordinate `{text}` is infinite, but a hull requires finite points: correct or remove this vertex")]
    Infinite { text: String },
    #[error("coordinate `{text}` is too large for 32-bit floats (limit 3.4e38); scale the mesh down")]
    Overflow { text: String },
    #[error("`{keyword}` references no vertices; complete or remove the line")]
    NoReferences { keyword: String },
    #[error("`{text}` is not a vertex reference; expected a form such as 7, 7/1, 7//3, 7/1/3 or -1")]
    BadReference { text: String },
    #[error(
        "vertex index 0 in `{text}` is invalid: OBJ indices start at 1, or at -1 counting backwards; check whether the exporter wrote indices from 0"
    )]
    ZeroIndex { text: String },
    #[error(
        "vertex index {text} is out of range (the file has {}); check whether the file was cut off or joined from parts",
        counted(.count, "vertex", "vertices")
    )]
    IndexTooLarge { text: String, count: usize },
    #[error(
        "vertex index {text} is out of range ({} above this line); a negative index counts back from its line",
        counted(.declared, "vertex", "vertices")
    )]
    IndexBeforeFirst { text: String, declared: usize },
    /// tobj rejects coordinates in which the scan finds no fault.
    #[error("the OBJ reader (tobj) rejects the vertices: {0}; this is a defect of hullmap: report it with the file")]
    Rejected(tobj::LoadError),
}

const EXCERPT_CHARS: usize = 40;

/// Start of a word or name, short enough for a message and without control characters.
pub fn excerpt(word: &str) -> String {
    let mut text: String =
        word.chars().take(4 * EXCERPT_CHARS).filter(|c| !c.is_control()).take(EXCERPT_CHARS).collect();
    if word.chars().nth(EXCERPT_CHARS).is_some() {
        text.push('…');
    }
    text
}

impl Fault {
    /// The text states the finding, the expectation, and the remedy.
    pub fn format(text: impl Into<String>) -> Self {
        Self::Format(text.into())
    }

    pub fn at_line(self, line: usize) -> LineFault {
        LineFault { line: Some(line), fault: self }
    }

    pub fn of_file(self) -> LineFault {
        LineFault { line: None, fault: self }
    }
}

/// A number with its noun: `1 vertex`, `2 vertices`.
pub fn counted(number: impl fmt::Display, one: &str, many: &str) -> String {
    let number = number.to_string();
    let noun = if number == "1" { one } else { many };
    format!("{number} {noun}")
}

/// Remedy for a malformed number. Decimal commas are the one case with a remedy of its own.
fn comma_hint(text: &str) -> &'static str {
    if text.contains(',') { ": use a point, not a comma" } else { ": correct the line" }
}
