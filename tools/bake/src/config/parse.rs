//! The text of a `hullmap.toml` to defaults and rules.

use std::ops::Range;
use std::path::Path;

use globset::GlobBuilder;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{Config, Glob, Rule};
use crate::option_layer::{KEYS, Kind, OptionLayer, ValueError};
use crate::outcome::Failure;

/// The tables of the file.
const TABLES: [&str; 2] = ["defaults", "rule"];

/// The key of a rule that is no option.
const FILES: &str = "files";

/// How alike two names must be, from 0 to 1, for one to be offered in the other's place: `vertces` and `vertices` are at
/// 0.97, `skip` and `split` at 0.65, `colour` and `recentre` at 0.47.
const ALIKE: f64 = 0.7;

/// What is wrong, and where in the text.
struct Fault {
    span: Range<usize>,
    message: String,
}

fn fault(span: Range<usize>, message: impl Into<String>) -> Fault {
    Fault { span, message: message.into() }
}

/// Reads the text of the file at `path`.
///
/// # Errors
/// The first fault in the file, with file and line.
pub fn parse(path: &Path, text: &str) -> Result<Config, Failure> {
    let line_of = |at: usize| 1 + text.as_bytes()[..at.min(text.len())].iter().filter(|&&byte| byte == b'\n').count();
    let placed = |fault: Fault| {
        let line = line_of(fault.span.start);
        Failure::usage(format!("{}:{line}: {}", path.display(), fault.message))
    };
    let root = DeTable::parse(text)
        .map_err(|error| placed(fault(error.span().unwrap_or(0..0), format!("no TOML: {}", error.message().trim()))))?;
    let (defaults, rules) = read(root.get_ref(), &line_of).map_err(placed)?;
    Ok(Config { path: path.to_owned(), defaults, rules })
}

fn read(root: &DeTable, line_of: &dyn Fn(usize) -> usize) -> Result<(OptionLayer, Vec<Rule>), Fault> {
    let mut defaults = OptionLayer::default();
    let mut rules = Vec::new();
    for (span, key, value) in in_order(root) {
        match (key, value.get_ref()) {
            ("defaults", DeValue::Table(table)) => defaults = layer(table)?,
            ("rule", DeValue::Array(array)) => {
                for entry in array.iter() {
                    let DeValue::Table(table) = entry.get_ref() else {
                        return Err(fault(entry.span(), "`rule` holds tables: write [[rule]] above each one"));
                    };
                    rules.push(rule(entry.span(), table, line_of)?);
                }
            }
            ("defaults", _) => return Err(fault(span, "`defaults` is a table: write [defaults]")),
            ("rule", _) => return Err(fault(span, "`rule` is a list of tables: write [[rule]], in two brackets")),
            (option, _) if KEYS.iter().any(|(known, _)| *known == option) => {
                return Err(fault(
                    span,
                    format!("`{option}` stands in no table: put it below [defaults] or a [[rule]]"),
                ));
            }
            _ => return Err(fault(span, unknown("table", key, &TABLES))),
        }
    }
    Ok((defaults, rules))
}

fn rule(span: Range<usize>, table: &DeTable, line_of: &dyn Fn(usize) -> usize) -> Result<Rule, Fault> {
    let Some(files) = table.get(FILES) else {
        return Err(fault(span, "this rule has no `files`: say which meshes it is for, as in files = \"props/**\""));
    };
    let patterns: Vec<(Range<usize>, &str)> = match files.get_ref() {
        DeValue::String(pattern) => vec![(files.span(), pattern)],
        DeValue::Array(patterns) => {
            let text = |pattern: &Spanned<DeValue>| match pattern.get_ref() {
                DeValue::String(_) => Ok(pattern.span()),
                _ => Err(fault(pattern.span(), "`files` holds globs: expected a string")),
            };
            let spans = patterns.iter().map(text).collect::<Result<Vec<_>, _>>()?;
            spans.into_iter().zip(patterns.iter().filter_map(|pattern| pattern.get_ref().as_str())).collect()
        }
        _ => return Err(fault(files.span(), "`files` is a glob or a list of globs")),
    };
    if patterns.is_empty() {
        return Err(fault(
            files.span(),
            "`files` is empty, so the rule is for no mesh: name a glob or remove the rule",
        ));
    }
    let line = line_of(files.span().start);
    let files = patterns.into_iter().map(|(span, pattern)| glob(span, pattern)).collect::<Result<_, _>>()?;
    Ok(Rule { line, files, layer: layer(table)? })
}

fn glob(span: Range<usize>, pattern: &str) -> Result<Glob, Fault> {
    let is_of_name = !pattern.contains('/');
    // A leading `/` or `./` says what holds anyway: a glob with `/` starts at the file's folder.
    let below = pattern.strip_prefix("./").or_else(|| pattern.strip_prefix('/')).unwrap_or(pattern);
    let built = GlobBuilder::new(below).literal_separator(true).case_insensitive(true).build();
    let matcher = built.map_err(|error| fault(span, format!("glob `{pattern}`: {}", error.kind())))?.compile_matcher();
    Ok(Glob { text: pattern.to_owned(), matcher, is_of_name })
}

/// The options in a table; `files` is skipped.
fn layer(table: &DeTable) -> Result<OptionLayer, Fault> {
    let mut layer = OptionLayer::default();
    for (span, key, value) in in_order(table) {
        if key == FILES {
            continue;
        }
        let Some(&(_, kind)) = KEYS.iter().find(|(known, _)| *known == key) else {
            let mut known = KEYS.map(|(known, _)| known).to_vec();
            known.push(FILES);
            return Err(fault(span, unknown("key", key, &known)));
        };
        let text = text_of(value.get_ref(), kind).ok_or_else(|| {
            let found = value.get_ref().type_str();
            fault(value.span(), format!("{key}: expected {}, found {found}", expected(kind)))
        })?;
        layer.set(key, &text).map_err(|error| {
            let near = match &error {
                ValueError::UnknownWord(words) => nearest(&text, words.iter().map(String::as_str)),
                _ => None,
            };
            let offer = near.map_or_else(String::new, |near| format!("; did you mean \"{near}\"?"));
            fault(value.span(), format!("{key} = {}: {error}{offer}", shown(value.get_ref(), &text)))
        })?;
    }
    match layer.clash() {
        None => Ok(layer),
        Some((key, why)) => {
            let spans = in_order(table).into_iter().filter(|entry| entry.1 == key);
            Err(fault(spans.map(|entry| entry.0).next().unwrap_or(0..0), format!("{key} {why}")))
        }
    }
}

/// The entries as they stand in the file.
fn in_order<'t>(table: &'t DeTable) -> Vec<(Range<usize>, &'t str, &'t Spanned<DeValue<'t>>)> {
    let mut entries: Vec<_> = table.iter().map(|(key, value)| (key.span(), key.get_ref().as_ref(), value)).collect();
    entries.sort_by_key(|(span, _, _)| span.start);
    entries
}

/// The value as [`OptionLayer::set`] reads it, if it is of the right kind.
fn text_of(value: &DeValue, kind: Kind) -> Option<String> {
    let takes_integer = matches!(kind, Kind::Integer | Kind::Number | Kind::IntegerOrNone | Kind::NumberOrNone);
    match value {
        DeValue::String(text) => match kind {
            Kind::Word => Some(text.to_string()),
            Kind::IntegerOrNone | Kind::NumberOrNone if text == "none" => Some(text.to_string()),
            _ => None,
        },
        DeValue::Integer(number) if takes_integer => {
            i64::from_str_radix(number.as_str(), number.radix()).ok().map(|number| number.to_string())
        }
        DeValue::Float(number) if matches!(kind, Kind::Number | Kind::NumberOrNone) => Some(number.as_str().to_owned()),
        DeValue::Boolean(switch) if kind == Kind::Switch => Some(switch.to_string()),
        _ => None,
    }
}

/// The value as the file writes it.
fn shown(value: &DeValue, text: &str) -> String {
    if value.is_str() { format!("\"{text}\"") } else { text.to_owned() }
}

fn expected(kind: Kind) -> &'static str {
    match kind {
        Kind::Word => "a string",
        Kind::Integer => "a whole number",
        Kind::Number => "a number",
        Kind::Switch => "true or false",
        Kind::IntegerOrNone => "a whole number or \"none\"",
        Kind::NumberOrNone => "a number or \"none\"",
    }
}

fn unknown(what: &str, name: &str, known: &[&str]) -> String {
    // The command line has `-` where this file has `_`.
    let offer = match nearest(&name.replace('-', "_"), known.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("expected one of {}", known.join(", ")),
    };
    format!("unknown {what} `{name}`; {offer}")
}

/// The name most like this one, if any is alike at all; of equals the first.
fn nearest<'k>(name: &str, known: impl Iterator<Item = &'k str>) -> Option<&'k str> {
    let mut best = None;
    let mut most = ALIKE;
    for other in known {
        let alike = strsim::jaro_winkler(&name.to_lowercase(), other);
        if alike > most {
            (best, most) = (Some(other), alike);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        parse(Path::new("a/hullmap.toml"), text).unwrap_err().message
    }

    #[test]
    fn faults_have_a_line_and_the_nearest_right_name() {
        for (text, expected) in [
            ("[defaults]\n\nvertces = \"all\"\n", ":3: unknown key `vertces`; did you mean `vertices`?"),
            ("[defaults]\nunit-scale = 1\n", ":2: unknown key `unit-scale`; did you mean `unit_scale`?"),
            ("[defaults]\nrecenter = true\n", ":2: unknown key `recenter`; did you mean `recentre`?"),
            ("[defaults]\nmax_vertex = 5\n", ":2: unknown key `max_vertex`; did you mean `max_vertices`?"),
            ("[defaults]\nxyzzy = true\n", ":2: unknown key `xyzzy`; expected one of split, "),
            ("[default]\nsplit = \"none\"\n", ":1: unknown table `default`; did you mean `defaults`?"),
            ("[[rules]]\nfiles = \"x\"\n", ":1: unknown table `rules`; did you mean `rule`?"),
            ("split = \"none\"\n", ":1: `split` stands in no table"),
            ("[rule]\nfiles = \"x\"\n", ":1: `rule` is a list of tables: write [[rule]]"),
            ("[[rule]]\nfiles = \"x\"\n\n[[rule]]\nsplit = \"none\"\n", ":4: this rule has no `files`"),
            ("[[rule]]\nfiles = []\n", ":2: `files` is empty"),
            ("[[rule]]\nfiles = [\"x\",\n 5]\n", ":3: `files` holds globs"),
            ("[[rule]]\nfiles = [\"x\",\n \"a[\"]\n", ":3: glob `a[`: unclosed character class"),
            ("[defaults]\nindex = \"compakt\"\n", ":2: index = \"compakt\": expected one of tree, medium, compact, "),
            ("[defaults]\nindex = \"compakt\"\n", "did you mean \"compact\"?"),
            ("[defaults]\nunit_scale = \"0.01\"\n", ":2: unit_scale: expected a number, found string"),
            ("[defaults]\nunit_scale = -1\n", ":2: unit_scale = -1: expected a finite number above 0"),
            ("[defaults]\nunit_scale = nan\n", ":2: unit_scale = nan: expected a finite number above 0"),
            ("[defaults]\nresolution = 5\n", ":2: resolution belongs to index cubemap"),
            ("[defaults]\nmax_error = 1\n\nmax_vertices = 5\n", ":2: max_error cannot be kept together"),
            ("[defaults]\nmax_vertices = 3.5\n", ":2: max_vertices: expected a whole number or \"none\", found float"),
            ("[defaults]\nsplit = \"none\"\nsplit = \"none\"\n", ":3: no TOML: duplicate key"),
            ("[defaults\n", ":1: no TOML: "),
            // The first of several, as they stand in the file.
            ("[defaults]\nzz = 1\naa = 2\n", ":2: unknown key `zz`"),
        ] {
            let message = error(text);
            assert!(message.starts_with("a/hullmap.toml:") && message.contains(expected), "{text}: {message}");
        }
    }

    #[test]
    fn numbers_may_be_written_in_every_way_of_toml() {
        for (text, scale) in
            [("1", 1.0), ("0.5", 0.5), ("1e-2", 0.01), ("1_000", 1000.0), ("1_0.5", 10.5), ("0x10", 16.0)]
        {
            let text = format!("[defaults]\nunit_scale = {text}\n");
            let config = parse(Path::new("x"), &text).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(config.defaults.unit_scale, Some(scale), "{text}");
        }
    }

    #[test]
    fn an_empty_file_says_nothing() {
        let config = parse(Path::new("x"), "# nothing\n").unwrap();
        assert_eq!((config.defaults, config.rules.len()), (OptionLayer::default(), 0));
    }
}
