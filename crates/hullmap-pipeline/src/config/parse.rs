//! The text of a `hullmap.toml` to defaults and rules.

use std::ops::Range;
use std::path::{Component, Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::rules::{Config, Rule};
use crate::glob::Glob;
use crate::options::removed::{instead_of_option, instead_of_value};
use crate::options::table::{OPTIONS, Scope, named};
use crate::options::value::Syntax;
use crate::options::{OptionLayer, name};
use crate::outcome::Failure;

const TABLES: [&str; 5] = ["defaults", "terrain", "rule", OUTPUT, SOURCES];

/// Keys of the whole file, above its tables.
const OUTPUT: &str = "output";
const SOURCES: &str = "sources";

/// Where an option stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Defaults,
    Terrain,
    Rule,
}

const FILES: &str = "files";

const LINKS: &str = "links";

/// The key of a rule that leaves its meshes out; every other key is an option.
const SKIP: &str = "skip";

/// Similarity, from 0 to 1, above which a known name is suggested for an unknown one: `vertces` and
/// `vertices` have 0.97, `skipped` and `split` 0.67, `colour` and `recentre` 0.47.
const MIN_SIMILARITY: f64 = 0.7;

struct Fault {
    span: Range<usize>,
    message: String,
}

fn fault(span: Range<usize>, message: impl Into<String>) -> Fault {
    Fault { span, message: message.into() }
}

pub fn parse(path: &Path, text: &str) -> Result<Config, Failure> {
    let line_of = |at: usize| 1 + text.as_bytes()[..at.min(text.len())].iter().filter(|&&byte| byte == b'\n').count();
    let with_line = |fault: Fault| {
        let line = line_of(fault.span.start);
        Failure::usage(format!("{}:{line}: {}", path.display(), fault.message))
    };
    let root = DeTable::parse(text).map_err(|error| {
        let message = format!("invalid TOML: {}", error.message().trim());
        with_line(fault(error.span().unwrap_or(0..0), message))
    })?;
    let mut config = Config { path: path.to_owned(), ..Config::default() };
    read(root.get_ref(), &line_of, &mut config).map_err(with_line)?;
    Ok(config)
}

fn read(root: &DeTable, line_of: &dyn Fn(usize) -> usize, config: &mut Config) -> Result<(), Fault> {
    let Config { defaults, rules, .. } = config;
    for (span, key, value) in in_order(root) {
        match (key, value.get_ref()) {
            ("defaults", DeValue::Table(table)) => {
                *defaults = layer(table, Place::Defaults)?.laid_over(defaults);
            }
            ("terrain", DeValue::Table(table)) => *defaults = defaults.laid_over(&layer(table, Place::Terrain)?),
            ("rule", DeValue::Array(array)) => {
                for entry in array.iter() {
                    let DeValue::Table(table) = entry.get_ref() else {
                        return Err(fault(entry.span(), "each `rule` must be a table: write [[rule]] above each rule"));
                    };
                    rules.push(rule(entry.span(), table, line_of)?);
                }
            }
            ("defaults" | "terrain", _) => {
                return Err(fault(span, format!("`{key}` must be a table: write [{key}]")));
            }
            ("rule", _) => {
                return Err(fault(span, "`rule` must be a list of tables: write [[rule]], in double brackets"));
            }
            (OUTPUT, _) => config.output = Some((line_of(span.start), inside(key, value)?)),
            (SOURCES, DeValue::Array(paths)) => {
                config.sources = paths.iter().map(|path| inside(key, path)).collect::<Result<_, _>>()?;
            }
            (SOURCES, _) => {
                return Err(fault(value.span(), "`sources` must be a list of paths, as in sources = [\"assets\"]"));
            }
            (option, _) if named(option).is_some() => {
                return Err(fault(
                    span,
                    format!("`{option}` is outside any table: move it below [defaults] or a [[rule]]"),
                ));
            }
            _ => return Err(fault(span, unknown("table", key, &TABLES))),
        }
    }
    Ok(())
}

/// A path that stays in the folder of the file.
fn inside(key: &str, value: &Spanned<DeValue>) -> Result<PathBuf, Fault> {
    let found = value.get_ref();
    let Some(text) = found.as_str() else {
        return Err(fault(value.span(), format!("{key}: expected a path, found {}", found.type_str())));
    };
    let is_inside = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
    if text.is_empty() || !Path::new(text).components().all(is_inside) {
        let message = "expected a path in the folder of this file, without `..`; another one is an argument";
        return Err(fault(value.span(), format!("{key} = \"{text}\": {message}")));
    }
    Ok(PathBuf::from(text))
}

fn rule(span: Range<usize>, table: &DeTable, line_of: &dyn Fn(usize) -> usize) -> Result<Rule, Fault> {
    let (files, links) = (table.get(FILES), table.get(LINKS));
    let Some(first) = files.or(links) else {
        return Err(fault(
            span,
            "this rule has no `files` and no `links`: add the meshes it applies to, as in files = \"props/**\"",
        ));
    };
    let line = line_of(first.span().start);
    let files = files.map_or_else(|| Ok(Vec::new()), |files| globs(FILES, files))?;
    let links = links.map_or_else(|| Ok(Vec::new()), |links| globs(LINKS, links))?;
    let skip = match table.get(SKIP).map(|value| (value.span(), value.get_ref())) {
        None => None,
        Some((_, DeValue::Boolean(skip))) => Some(*skip),
        Some((span, other)) => {
            return Err(fault(span, format!("{SKIP}: expected true or false, found {}", other.type_str())));
        }
    };
    Ok(Rule { line, files, links, skip, layer: layer(table, Place::Rule)? })
}

fn globs(key: &str, value: &Spanned<DeValue>) -> Result<Vec<Glob>, Fault> {
    let patterns: Vec<(Range<usize>, &str)> = match value.get_ref() {
        DeValue::String(pattern) => vec![(value.span(), pattern)],
        DeValue::Array(patterns) => {
            let text = |pattern: &Spanned<DeValue>| match pattern.get_ref() {
                DeValue::String(_) => Ok(pattern.span()),
                _ => Err(fault(pattern.span(), format!("`{key}` must hold globs: expected a string"))),
            };
            let spans = patterns.iter().map(text).collect::<Result<Vec<_>, _>>()?;
            spans.into_iter().zip(patterns.iter().filter_map(|pattern| pattern.get_ref().as_str())).collect()
        }
        _ => return Err(fault(value.span(), format!("`{key}` must be a glob or a list of globs"))),
    };
    if patterns.is_empty() {
        return Err(fault(
            value.span(),
            format!("`{key}` is empty, so the rule applies to nothing: add a glob or remove the rule"),
        ));
    }
    patterns.into_iter().map(|(span, pattern)| Glob::new(pattern).map_err(|error| fault(span, error))).collect()
}

fn layer(table: &DeTable, place: Place) -> Result<OptionLayer, Fault> {
    let mut layer = OptionLayer::default();
    for (span, key, value) in in_order(table) {
        if [FILES, LINKS, SKIP].contains(&key) {
            if place == Place::Rule {
                continue;
            }
            return Err(fault(span, format!("`{key}` applies to the meshes of a rule: move it below a [[rule]]")));
        }
        if [OUTPUT, SOURCES].contains(&key) {
            return Err(fault(span, format!("`{key}` applies to the whole file: move it above all tables")));
        }
        let Some(index) = named(key) else {
            let keys_of_rules: &[&str] = if place == Place::Rule { &[FILES, LINKS, SKIP] } else { &[] };
            let known: Vec<&str> =
                OPTIONS.iter().map(|option| name(option.key)).chain(keys_of_rules.iter().copied()).collect();
            let message = instead_of_option(key)
                .map_or_else(|| unknown("key", key, &known), |instead| format!("`{key}`: {instead}"));
            return Err(fault(span, message));
        };
        let is_of_terrains = OPTIONS[index].scope == Scope::Terrains;
        match place {
            Place::Defaults if is_of_terrains => {
                return Err(fault(span, format!("`{key}` applies to terrains: move it below [terrain] or a [[rule]]")));
            }
            Place::Terrain if !is_of_terrains => {
                let message = "is no option of a height field: move it below [defaults] or a [[rule]]";
                return Err(fault(span, format!("`{key}` {message}")));
            }
            _ => {}
        }
        let syntax = OPTIONS[index].syntax;
        if let Some(text) = value.get_ref().as_str()
            && let Some(instead) = instead_of_value(key, text)
        {
            return Err(fault(value.span(), format!("{key} = \"{text}\": {instead}")));
        }
        let text = text_of(value.get_ref(), syntax).ok_or_else(|| {
            let found = value.get_ref().type_str();
            fault(value.span(), format!("{key}: expected {}, found {found}", toml_type(syntax)))
        })?;
        let parsed = OPTIONS[index].parse(&text).map_err(|error| {
            let suggestion = match syntax {
                Syntax::Words(words) => most_similar(&text, words),
                _ => None,
            };
            let suggestion = suggestion.map_or_else(String::new, |word| format!("; did you mean \"{word}\"?"));
            fault(value.span(), format!("{key} = {}: {error}{suggestion}", as_written(value.get_ref(), &text)))
        })?;
        layer.set_at(index, Some(parsed));
    }
    match layer.clash() {
        None => Ok(layer),
        Some(clash) => {
            let span =
                in_order(table).into_iter().find(|entry| entry.1 == name(clash.key)).map_or(0..0, |entry| entry.0);
            Err(fault(span, clash.message(|key| name(key).to_owned())))
        }
    }
}

/// The entries in the order of the file.
fn in_order<'t>(table: &'t DeTable) -> Vec<(Range<usize>, &'t str, &'t Spanned<DeValue<'t>>)> {
    let mut entries: Vec<_> = table.iter().map(|(key, value)| (key.span(), key.get_ref().as_ref(), value)).collect();
    entries.sort_by_key(|(span, _, _)| span.start);
    entries
}

fn text_of(value: &DeValue, syntax: Syntax) -> Option<String> {
    use Syntax::{HoleOrNone, LengthOrNone, NameOrNone, PairOrNone, SpacingOrNone, Switch, Words};
    let is_text = matches!(syntax, Words(_) | LengthOrNone | HoleOrNone | NameOrNone);
    let accepts_integer = !matches!(syntax, Words(_) | Switch | NameOrNone | PairOrNone);
    let accepts_float = accepts_integer && !matches!(syntax, Syntax::CountOrNone { .. });
    match value {
        DeValue::String(text) if is_text || syntax.takes_none() && text == "none" => Some(text.to_string()),
        DeValue::Array(numbers) if matches!(syntax, PairOrNone | SpacingOrNone) => {
            let texts = numbers.iter().map(|number| text_of(number.get_ref(), Syntax::Finite));
            Some(texts.collect::<Option<Vec<String>>>()?.join(","))
        }
        DeValue::Integer(number) if accepts_integer => {
            i64::from_str_radix(number.as_str(), number.radix()).ok().map(|number| number.to_string())
        }
        DeValue::Float(number) if accepts_float => Some(number.as_str().to_owned()),
        DeValue::Boolean(is_on) if syntax == Syntax::Switch => Some(is_on.to_string()),
        _ => None,
    }
}

fn toml_type(syntax: Syntax) -> &'static str {
    match syntax {
        Syntax::Words(_) => "a string",
        Syntax::Switch => "true or false",
        Syntax::LengthOrNone => "a number, or a string such as \"2%\" or \"none\"",
        Syntax::Positive | Syntax::Finite => "a number",
        Syntax::CountOrNone { .. } => "a whole number or \"none\"",
        Syntax::PositiveOrNone | Syntax::FiniteOrNone => "a number or \"none\"",
        Syntax::PairOrNone => "a list of two numbers or \"none\"",
        Syntax::SpacingOrNone => "a number, a list of two, or \"none\"",
        Syntax::HoleOrNone => "a number, also as a string, or \"none\"",
        Syntax::NameOrNone => "a string",
    }
}

fn as_written(value: &DeValue, text: &str) -> String {
    if value.is_str() { format!("\"{text}\"") } else { text.to_owned() }
}

fn unknown(what: &str, name: &str, known: &[&str]) -> String {
    // Flags have `-` where this file has `_`.
    let suggestion = match most_similar(&name.replace('-', "_"), known) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("expected one of {}", known.join(", ")),
    };
    format!("unknown {what} `{name}`; {suggestion}")
}

/// The known name most similar to `name`, if any is similar enough; the first of several.
pub(crate) fn most_similar<'k>(name: &str, known: &[&'k str]) -> Option<&'k str> {
    let mut best = None;
    let mut max = MIN_SIMILARITY;
    for other in known {
        let similarity = strsim::jaro_winkler(&name.to_lowercase(), other);
        if similarity > max {
            (best, max) = (Some(*other), similarity);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::value::Value;

    #[test]
    fn faults_have_a_line_and_a_suggestion() {
        let files: Vec<&str> = include_str!("faults.txt").split("=== ").skip(1).collect();
        assert!(files.len() > 40, "{}", files.len());
        for file in files {
            let (expected, text) = file.split_once('\n').unwrap();
            let message = parse(Path::new("a/hullmap.toml"), text).unwrap_err().message;
            assert!(message.starts_with("a/hullmap.toml:") && message.contains(expected), "{file}: {message}");
        }
    }

    #[test]
    fn numbers_may_have_every_notation_of_toml() {
        for (text, scale) in
            [("1", 1.0), ("0.5", 0.5), ("1e-2", 0.01), ("1_000", 1000.0), ("1_0.5", 10.5), ("0x10", 16.0)]
        {
            let text = format!("[defaults]\nunit_scale = {text}\n");
            let config = parse(Path::new("x"), &text).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(config.defaults.get("unit_scale"), Some(Value::Number(scale)), "{text}");
        }
    }

    #[test]
    fn terrains_have_a_table_of_their_own() {
        let text = "[terrain]\nspacing = [2, 0.5]\norigin = [-1, 2]\nhole = -9999\n[defaults]\nindex = \"none\"\n";
        let defaults = parse(Path::new("x"), text).unwrap().defaults;
        let texts = ["spacing", "origin", "hole", "index"].map(|key| defaults.get(key).unwrap().to_string());
        assert_eq!(texts, ["2,0.5", "-1,2", "-9999", "none"]);
    }

    #[test]
    fn an_empty_file_gives_no_options() {
        let config = parse(Path::new("x"), "# nothing\n").unwrap();
        assert_eq!((config.defaults, config.rules.len()), (OptionLayer::default(), 0));
    }
}
