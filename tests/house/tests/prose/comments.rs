//! Comments are narrow enough to read beside the code. Sentences start with their subject, and
//! headings have a line of their own.

use std::fs;

use hullmap_house::tracked;
use hullmap_testkit::files::workspace;

/// Column at which comment lines end.
const COMMENT_WIDTH: usize = 100;

/// Whether a line is a comment of more than [`COMMENT_WIDTH`] columns that could be broken: it has
/// a space before the limit, and is neither a row of a table nor a line of code in an example.
fn is_too_wide(line: &str) -> bool {
    let text = line.trim_start();
    let words = text.trim_start_matches(['/', '!']).trim_start();
    !words.starts_with('|') && line.chars().count() > COMMENT_WIDTH && words.split_whitespace().nth(1).is_some()
}

/// Openings that put the subject last: "Of the faces, the first one counts".
const OPENINGS: [&str; 3] = ["Of ", "What ", "The same for "];

/// Words that few native speakers print, or that stand for a noun far away.
const WORDS: [&str; 8] =
    ["hardly", "sought", "of no use", "so many", "that of", "those of", "for lack of", "was to be found"];

/// The opening or word in a line of prose that is better rewritten.
fn habit(prose: &str) -> Option<&'static str> {
    let sentences = || prose.split(". ").map(str::trim_start).filter(|sentence| !sentence.contains('?'));
    let opens = |opening: &&&str| sentences().any(|sentence| sentence.starts_with(**opening));
    let words = prose.to_lowercase().replace(|c: char| !c.is_alphanumeric(), " ");
    let has = |word: &&&str| format!(" {words} ").contains(&format!(" {word} "));
    OPENINGS.iter().find(opens).or_else(|| WORDS.iter().find(has)).copied()
}

/// Headings of items.
const HEADINGS: [&str; 6] = ["# Errors", "# Panics", "# Complexity", "# Examples", "# Safety", "# Reference"];

/// Whether a comment has a heading on a line with other text: a reflow makes one paragraph of them.
fn swallows_heading(line: &str) -> bool {
    let text = line.trim_start().trim_start_matches(['/', '!']).trim();
    HEADINGS.iter().any(|heading| text.contains(heading) && text != *heading)
}

/// Lines of tracked files that end so, outside of code blocks. Case files quote output.
fn lines(ending: &str) -> Vec<(String, String)> {
    let files = tracked().into_iter().filter(|file| file.ends_with(ending) && !file.starts_with("tests/cases/"));
    let mut found = Vec::new();
    for file in files {
        let text = fs::read_to_string(workspace().join(&file)).expect("a tracked file can be read");
        let mut in_example = false;
        for (index, line) in text.lines().enumerate() {
            let is_prose = ending == ".md" || line.trim_start().starts_with("//");
            in_example ^= is_prose && line.contains("```");
            if is_prose && !in_example {
                found.push((format!("{file}:{}", index + 1), line.to_owned()));
            }
        }
    }
    assert!(found.len() > 5_000 || !workspace().join(".git").exists(), "{} lines", found.len());
    found
}

#[test]
fn comment_lines_end_at_column_100() {
    let wide: Vec<_> = lines(".rs").into_iter().filter(|(_, line)| is_too_wide(line)).map(|(at, _)| at).collect();
    assert!(wide.is_empty(), "{} comment lines go past column {COMMENT_WIDTH}: {wide:#?}", wide.len());
}

#[test]
fn headings_have_their_own_line() {
    let found: Vec<_> = lines(".rs").into_iter().filter(|(_, line)| swallows_heading(line)).map(|(at, _)| at).collect();
    assert!(found.is_empty(), "separate these headings from the text: {found:#?}");
    let swallowed = ["/// # Complexity One descent", "    //! It fails. # Errors", "/// # Complexity"];
    assert_eq!(swallowed.map(swallows_heading), [true, true, false]);
}

#[test]
fn sentences_start_with_their_subject() {
    let prose = lines(".rs").into_iter().chain(lines(".md")).filter_map(|(at, line)| {
        let text = line.trim_start().trim_start_matches(['/', '!', '-', '|']).trim_start();
        Some(format!("{at}: {}", habit(text)?))
    });
    let found: Vec<_> = prose.collect();
    assert!(found.is_empty(), "rewrite these sentences: {found:#?}");
    assert_eq!(habit("A face. Of these, one counts."), Some("Of "));
    assert_eq!(habit("It differs from that of B."), Some("that of"));
    assert_eq!([habit("What is B?"), habit("The index of A")], [None, None]);
}
