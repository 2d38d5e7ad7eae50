//! Length of functions: a long one becomes steps with names. Tests may list as many cases as they
//! like.

use std::fs;

use hullmap_house::tracked;
use hullmap_testkit::files::workspace;

const MAX_LINES: usize = 80;

/// Words with which a line of JavaScript starts that opens a block, but no method.
const STATEMENTS: [&str; 7] = ["if", "for", "while", "switch", "catch", "with", "}"];

/// Whether a function starts with this line. The language is the ending of its file.
fn starts_function(line: &str, language: &str) -> bool {
    let line = line.trim_start();
    if line.starts_with("//") {
        return false;
    }
    if matches!(language, "rs" | "wgsl") {
        return line.split_whitespace().any(|word| word == "fn");
    }
    let opens = line.ends_with('{');
    let first = line.split([' ', '(']).next().unwrap_or_default();
    let is_method = line.ends_with(") {") && !STATEMENTS.contains(&first);
    opens && (is_method || line.contains("=>") || line.split_whitespace().any(|word| word.starts_with("function")))
}

/// First lines and numbers of lines of the functions in `text`. Formatted code closes a block with
/// the indentation of its first line.
fn functions<'t>(text: &'t str, language: &str) -> Vec<(&'t str, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let indentation = |line: &str| line.len() - line.trim_start().len();
    let count = |at: usize| {
        // The body may start below the parameters. A declaration, or a body in one line, has none.
        let body = at + lines[at..].iter().position(|line| line.ends_with(['{', '}', ';']))?;
        let closes = |line: &&str| line.trim_start().starts_with('}') && indentation(line) == indentation(lines[at]);
        let end = body + 1 + lines[body + 1..].iter().position(closes)?;
        lines[body].ends_with('{').then_some((lines[at].trim(), end + 1 - at))
    };
    (0..lines.len()).filter(|at| starts_function(lines[*at], language)).filter_map(count).collect()
}

#[test]
fn functions_are_short() {
    let files = tracked();
    if files.is_empty() && !workspace().join(".git").exists() {
        println!("skipped: functions_are_short: this is not a git checkout");
        return;
    }
    let is_product = |file: &&String| {
        let folders: Vec<&str> = file.split('/').collect();
        ["crates", "tools"].contains(&folders[0]) && !folders.iter().any(|name| ["tests", "tests.rs"].contains(name))
    };
    let (mut counts, mut long) = ([0; 3], Vec::new());
    for file in files.iter().filter(is_product) {
        let language = file.rsplit('.').next().unwrap_or_default();
        let Some(kind) = [&["rs"][..], &["wgsl"], &["js", "mjs"]].iter().position(|kind| kind.contains(&language))
        else {
            continue;
        };
        let text = fs::read_to_string(workspace().join(file)).expect("a tracked file can be read");
        let found = functions(&text, language);
        counts[kind] += found.len();
        let too_long = found.iter().filter(|(_, count)| *count > MAX_LINES);
        long.extend(too_long.map(|(line, count)| format!("{file}: {count} lines: {line}")));
    }
    assert!(counts[0] > 2000 && counts[1] > 50 && counts[2] > 200, "{counts:?} functions");
    assert!(long.is_empty(), "make these steps with names, of at most {MAX_LINES} lines:\n{}", long.join("\n"));
}

#[test]
fn functions_are_counted_in_each_language() {
    for (text, language, expected) in [
        // One line, a declaration, and parameters in lines of their own.
        ("fn f() {}\ntrait T {\n    fn g(&self);\n}\n", "rs", vec![]),
        ("impl S {\n    pub(super) fn f(\n        a: u32,\n    ) {\n        a\n    }\n}", "rs", vec![5]),
        ("fn f()\nwhere\n    T: U,\n{\n    // fn g() {\n    if a {\n    }\n}\n", "rs", vec![8]),
        ("@compute\nfn f(a: u32) -> u32 {\n    return a;\n}\n", "wgsl", vec![3]),
        ("class C {\n  get size() {\n    if (a) {\n    }\n  }\n}\n", "js", vec![4]),
        ("async function f() {\n  on(\"x\", () => {\n    g();\n  });\n}\n", "js", vec![5, 3]),
        ("const f = (a) => {\n  for (const b of a) {\n    g(b);\n  }\n};\n", "js", vec![5]),
    ] {
        let found: Vec<usize> = functions(text, language).iter().map(|(_, count)| *count).collect();
        assert_eq!(found, expected, "{text}");
    }
}
