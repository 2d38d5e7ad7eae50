//! Comments are narrow enough to read beside the code.

use std::fs;

use hullmap_house::tracked;
use hullmap_outside::files::workspace;

/// Column at which comment lines end.
const COMMENT_WIDTH: usize = 100;

/// Whether a line is a comment of more than [`COMMENT_WIDTH`] columns that could be broken: it has
/// a space before the limit, and is neither a row of a table nor a line of code in an example.
fn is_too_wide(line: &str, in_example: bool) -> bool {
    let text = line.trim_start();
    let words = text.trim_start_matches(['/', '!']).trim_start();
    text.starts_with("//")
        && !in_example
        && !words.starts_with('|')
        && line.chars().count() > COMMENT_WIDTH
        && words.split_whitespace().nth(1).is_some()
}

#[test]
fn comment_lines_end_at_column_100() {
    let files: Vec<String> = tracked().into_iter().filter(|path| path.ends_with(".rs")).collect();
    assert!(files.len() > 150 || !workspace().join(".git").exists(), "{} files", files.len());
    let mut wide = Vec::new();
    for file in &files {
        let text = fs::read_to_string(workspace().join(file)).expect("a tracked file can be read");
        let mut in_example = false;
        for (index, line) in text.lines().enumerate() {
            in_example ^= line.trim_start().starts_with("//") && line.contains("```");
            if is_too_wide(line, in_example) {
                wide.push(format!("{file}:{}", index + 1));
            }
        }
    }
    assert!(wide.is_empty(), "{} comment lines go past column {COMMENT_WIDTH}: {wide:#?}", wide.len());
}
