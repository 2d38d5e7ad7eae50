//! The options as flags of the subcommands, made from the table; for the few, as keys of `--set`.
//!
//! clap sees `--set wall=1%` as the flag `--set wall`, so that each key has a parser, conflicts and
//! messages of its own.

use std::borrow::Cow;
use std::ffi::OsString;
use std::iter;

use clap::builder::{PossibleValuesParser, TypedValueParser, ValueParser};
use clap::{Arg, ArgMatches, Command};

use hullmap_pipeline::options::table::{BuildOption, OPTIONS, Scope, Section, named};
use hullmap_pipeline::options::value::{Syntax, Value};
use hullmap_pipeline::options::{OptionLayer, flag};

/// The key of an argument that has no flag of its own.
pub fn key_of(arg: &Arg) -> Option<&str> {
    arg.get_long()?.strip_prefix("set ")
}

/// The words of a command line with `--set` and its key in one word. A key that has a flag becomes
/// the flag.
pub fn joined(words: &[OsString]) -> Vec<OsString> {
    let mut words = words.iter();
    let next = || {
        let word = words.next()?;
        let setting = match word.to_str().and_then(|word| word.strip_prefix("--set")) {
            Some("") => words.next().map(|next| next.to_string_lossy()),
            rest => rest.and_then(|rest| rest.strip_prefix('=')).map(Cow::from),
        };
        let Some(setting) = setting else { return Some(word.clone()) };
        let (key, value) = setting.split_at(setting.find('=').unwrap_or(setting.len()));
        let key = key.replace('-', "_");
        let flag = named(&key).map_or_else(|| format!("--set {key}"), |index| flag(OPTIONS[index].key));
        Some(format!("{flag}{value}").into())
    };
    iter::from_fn(next).collect()
}

/// The subcommand with `--set` in its help, in place of the keys.
pub fn with_set(own: Command) -> Command {
    let own = own.mut_subcommands(with_set);
    let keys: Vec<_> = own.get_arguments().filter(|arg| !arg.is_hide_set()).filter_map(key_of).collect();
    let help = "Set a further option; repeatable";
    let set = Arg::new("set").long("set").value_name("KEY=VALUE").help(help);
    let set = set.long_help(format!("{help}. Keys: {}", keys.join(", ")));
    let set = set.value_parser(PossibleValuesParser::new(keys.iter().map(|key| format!("{key}="))));
    let set = (!keys.is_empty()).then_some(set);
    own.args(set).mut_args(|arg| {
        let (is_key, takes_values) = (key_of(&arg).is_some(), arg.get_action().takes_values());
        let arg = if takes_values { arg.hide_possible_values(true) } else { arg };
        if is_key { arg.hide(true).require_equals(true) } else { arg }
    })
}

/// The command without keys, which are no words of a shell.
pub fn without_keys(own: &Command) -> Command {
    let mut command = Command::new(own.get_name().to_owned())
        .about(own.get_about().cloned().unwrap_or_default())
        .after_help(own.get_after_help().cloned().unwrap_or_default())
        .disable_help_subcommand(true)
        .args(own.get_arguments().filter(|arg| key_of(arg).is_none()).cloned())
        .subcommands(own.get_subcommands().map(without_keys));
    if let Some(version) = own.get_version() {
        command = command.version(version.to_owned());
    }
    command
}

/// Options of `bake decompose`, with the options of parts.
const OF_DECOMPOSE: [&str; 6] = ["max_error", "max_vertices", "for_engine", "split", "unit_scale", "up_axis"];

/// The options of a subcommand as flags.
#[derive(Clone, Debug)]
pub struct OptionFlags(pub OptionLayer);

impl clap::Args for OptionFlags {
    fn augment_args(command: Command) -> Command {
        let is_taken = |own: &&BuildOption| match command.get_name() {
            "decompose" => own.scope == Scope::Parts && own.key != "primitives" || OF_DECOMPOSE.contains(&own.key),
            "robot" => own.scope != Scope::Terrains,
            _ => true,
        };
        let taken: Vec<Arg> = Section::ALL.iter().flat_map(|own| own.options()).filter(is_taken).map(arg).collect();
        command.args(taken)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl clap::FromArgMatches for OptionFlags {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut layer = OptionLayer::default();
        for (index, option) in OPTIONS.iter().enumerate() {
            // A subcommand takes some of them.
            layer.set_at(index, matches.try_get_one::<Value>(option.key).ok().flatten().cloned());
        }
        Ok(Self(layer))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

fn arg(option: &'static BuildOption) -> Arg {
    let with_default = |help: &str| match option.default {
        "false" | "none" => help.to_owned(),
        value => format!("{help} [default: {value}]"),
    };
    let arg = Arg::new(option.key)
        .long(flag(option.key)[2..].to_owned())
        .help(with_default(option.help.split(". ").next().unwrap_or_default()))
        .long_help(with_default(option.help))
        .help_heading((option.section != Section::Parts).then_some(option.section.heading()))
        .hide_short_help(option.section != Section::Parts || option.key == "solid")
        .value_name(option.value_name)
        .value_parser(value_parser(option));
    match (option.syntax, option.default) {
        // A switch that is on by default can only be switched off, with a value.
        (Syntax::Switch, "false") => arg.num_args(0..=1).require_equals(true).default_missing_value("true"),
        _ => arg,
    }
}

/// Words are possible values of clap, which shells complete; everything else is read by the
/// option's syntax, and so is `decompose`, whose earlier values have messages of their own.
fn value_parser(option: &'static BuildOption) -> ValueParser {
    let words = match option.syntax {
        _ if option.key == "decompose" => return ValueParser::new(|text: &str| option.parse(text)),
        Syntax::Words(words) => words,
        Syntax::Switch => &["true", "false"],
        _ => return ValueParser::new(|text: &str| option.parse(text)),
    };
    ValueParser::new(PossibleValuesParser::new(words).try_map(|text| option.parse(&text)))
}
