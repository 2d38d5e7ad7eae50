//! Dependency files for Ninja and Make: which files each pack was baked from.

use std::fmt::Write;
use std::io;
use std::path::{Path, PathBuf};

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rule {
    /// The file that is out of date if a prerequisite is newer.
    pub target: PathBuf,
    pub prerequisites: Vec<PathBuf>,
}

/// Each prerequisite also gets a rule of its own, so that Make continues after its removal. Fails
/// for a path with a line break, which neither Ninja nor Make can read, or not in UTF-8.
pub fn text(rules: &[Rule]) -> io::Result<String> {
    let mut text = String::new();
    for rule in rules {
        text.push_str(&escaped(&rule.target)?);
        text.push(':');
        for path in &rule.prerequisites {
            // One line each, so that no line grows without bound.
            let _ = write!(text, " \\\n  {}", escaped(path)?);
        }
        text.push('\n');
    }
    let mut paths: Vec<&PathBuf> = rules.iter().flat_map(|rule| &rule.prerequisites).collect();
    paths.sort_unstable();
    paths.dedup();
    for path in paths {
        let _ = write!(text, "\n{}:\n", escaped(path)?);
    }
    Ok(text)
}

/// A path as both programs read it: `\ ` for a space (with the backslashes before it doubled),
/// `\#`, `\:`, `$$`. On Windows, a colon only follows a drive, and needs no escape.
fn escaped(path: &Path) -> io::Result<String> {
    let invalid = |what: &str| io::Error::new(io::ErrorKind::InvalidInput, format!("{}: {what}", path.display()));
    let path_text = path
        .to_str()
        .ok_or_else(|| invalid("this path is not UTF-8, so it cannot be written to a depfile; rename it"))?;
    let mut text = String::with_capacity(path_text.len() + 8);
    let mut backslashes = 0;
    for letter in path_text.chars() {
        match letter {
            '\n' | '\r' => {
                return Err(invalid(
                    "this path contains a line break, so it cannot be written to a depfile; rename it",
                ));
            }
            ' ' | '\t' => {
                text.extend(std::iter::repeat_n('\\', backslashes + 1));
            }
            '#' => text.push('\\'),
            ':' if !cfg!(windows) => text.push('\\'),
            '$' => text.push('$'),
            _ => {}
        }
        text.push(letter);
        backslashes = if letter == '\\' { backslashes + 1 } else { 0 };
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `tests/cases/options.md` has the other characters.
    #[test]
    fn colons_of_drives_are_not_escaped() {
        let expected = if cfg!(windows) { "12:30" } else { "12\\:30" };
        assert_eq!(escaped(Path::new("12:30")).unwrap(), expected);
    }
}
