//! The command by case files: what a user types, what `bake` prints, and its exit code.
//!
//! `tests/cases/README.md` describes the files. With `SNAPSHOTS=overwrite`, the expected outputs
//! are replaced by the actual ones.

use std::ffi::OsString;
use std::fs;
use std::process::Command;

use hullmap_testkit::command::{Run, binary, finished};
use hullmap_testkit::files::workspace;
use regex::Regex;
use serde_json::Value;
use snapbox::{Assert, Data, RedactedValue, Redactions, assert::DEFAULT_ACTION_ENV};
use tempfile::TempDir;

/// Parts of the output that differ between runs.
const REDACTED: [(&str, &str); 4] = [
    // The column of milliseconds, whose width differs, too.
    ("[MS]", r"(?<redacted>  +([0-9]+( [0-9]{3})*[.][0-9]|ms))  (status|baked|fresh|FAILED|orphaned|pruned)"),
    ("[TIME]", r"\b(?<redacted>[0-9.]+ (ns|ms|s))\b"),
    ("[KEY]", r"\b(?<redacted>[0-9a-f]{64})\b"),
    ("[RANDOM]", r"hullmap(?<redacted>[A-Za-z0-9]{6})[.]tmp\b"),
];

/// An empty folder for a case, and what its outputs are shown without.
struct Case {
    folder: TempDir,
    redactions: Redactions,
}

impl Case {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut redactions = Redactions::new();
        for (placeholder, pattern) in REDACTED {
            redactions.insert(placeholder, RedactedValue::from(Regex::new(pattern).unwrap())).unwrap();
        }
        redactions.insert("[FOLDER]", folder.path().canonicalize().unwrap().display().to_string()).unwrap();
        redactions.insert("[ROOT]", workspace().display().to_string()).unwrap();
        Self { folder, redactions }
    }

    /// Runs a step by the shell.
    fn run(&self, step: &str) -> Run {
        let mut path = OsString::from(binary().parent().expect("the binary is in a folder"));
        path.push(format!(":{}:", workspace().join("tests/cases").display()));
        path.push(std::env::var_os("PATH").unwrap_or_default());
        let mut shell = Command::new("sh");
        shell.args(["-c", step]).current_dir(&self.folder).env("PATH", path).env("LC_ALL", "C");
        shell.env("ROOT", workspace()).env("MESHES", workspace().join("tests/cases/meshes"));
        finished(&mut shell)
    }

    /// Output of a step, as its case file shows it.
    fn output(&self, step: &str) -> String {
        let (line, fields) = step.rsplit_once(" | pick ").unwrap_or((step, ""));
        let run = self.run(line);
        let fields: Vec<Vec<&str>> = fields.split_whitespace().map(|field| field.split('.').collect()).collect();
        let mut shown = if run.code == 0 { String::new() } else { format!("? {}\n", run.code) };
        if fields.is_empty() {
            run.stdout.lines().for_each(|line| shown += &format!("{}\n", line.trim_end()));
        } else {
            for row in run.json() {
                let cells: Vec<String> = fields.iter().flat_map(|field| pick(&row, field)).collect();
                shown += &format!("{}\n", cells.join(" | "));
            }
        }
        // Below a wrong argument stand two paragraphs of clap's.
        let usage = Regex::new(r"\n\nUsage: .*\n\nFor more information, try '--help'\.").unwrap();
        let stderr = usage.replace_all(&run.stderr, "");
        // Progress depends on the time.
        let messages = stderr.lines().filter(|line| !line.contains(" files; in progress: "));
        messages.for_each(|line| shown += &format!("{}\n", format!("! {line}").trim_end()));
        let is_read_as_step = |line: &str| ["$ ", "> ", "```"].iter().any(|mark| line.starts_with(mark));
        assert!(!shown.lines().any(is_read_as_step), "{step}: a line of the output reads as a step: {shown}");
        self.redactions.redact(&shown)
    }
}

/// Values of the fields at `path`, where `*` stands for all elements of a list.
fn pick(row: &Value, path: &[&str]) -> Vec<String> {
    match (path, row) {
        ([], Value::String(text)) => vec![text.clone()],
        ([], other) => vec![other.to_string()],
        (["*", rest @ ..], Value::Array(values)) => values.iter().flat_map(|value| pick(value, rest)).collect(),
        ([name, rest @ ..], Value::Array(values)) => pick(&values[name.parse::<usize>().unwrap()], rest),
        ([name, rest @ ..], other) => pick(other.get(name).unwrap_or(&Value::Null), rest),
    }
}

/// The text of a case file, with the outputs of this run.
fn played(text: &str) -> String {
    let (mut shown, mut case, mut is_console) = (String::new(), None, false);
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        if line.starts_with("## ") {
            case = Some(Case::new());
        }
        if line.starts_with("```") {
            is_console = line == "```console";
        }
        let Some(first) = line.strip_prefix("$ ").filter(|_| is_console) else {
            // In consoles, other lines are the old output.
            if !is_console || line.starts_with("```") {
                shown += &format!("{line}\n");
            }
            continue;
        };
        let mut step = first.to_owned();
        shown += &format!("{line}\n");
        while let Some(more) = lines.next_if(|line| line.starts_with("> ")) {
            step += &format!("\n{}", &more[2..]);
            shown += &format!("{more}\n");
        }
        shown += &case.as_ref().expect("a case has a heading").output(&step);
    }
    shown
}

fn assert_played(name: &str) {
    if name == "pages" && Case::new().run("browse").code != 0 {
        println!("skipped: no Chromium is installed");
        return;
    }
    let path = workspace().join(format!("tests/cases/{name}.md"));
    let actual = played(&fs::read_to_string(&path).unwrap());
    Assert::new().action_env(DEFAULT_ACTION_ENV).normalize_paths(false).eq(actual, Data::read_from(&path, None));
}

macro_rules! files {
    ($($name:ident)*) => {
        $(#[test]
        fn $name() {
            assert_played(stringify!($name));
        })*

        #[test]
        fn every_file_is_listed() {
            let names = fs::read_dir(workspace().join("tests/cases")).unwrap();
            let names = names.map(|entry| entry.unwrap().file_name().into_string().unwrap());
            let mut names: Vec<String> = names.filter_map(|name| Some(name.strip_suffix(".md")?.to_owned())).collect();
            names.sort();
            assert_eq!(names, ["README", $(stringify!($name)),*]);
        }
    };
}

files! { arguments assets check decompose export farm guides input names options pages report robot scenes surfaces untrusted verify }
