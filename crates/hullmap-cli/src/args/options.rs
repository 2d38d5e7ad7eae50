//! The options as flags of the subcommands, made from the table; for the few, as keys of `--set`.
//!
//! clap sees `--set wall=1%` as the flag `--set wall`, so that each key has a parser, conflicts and
//! messages of its own.

use std::ffi::OsString;

use clap::builder::{PossibleValuesParser, TypedValueParser, ValueParser};
use clap::{Arg, ArgMatches, Command};

use hullmap_pipeline::options::table::{BuildOption, OPTIONS, Scope, Section, named, position};
use hullmap_pipeline::options::value::{Syntax, Value};
use hullmap_pipeline::options::{OptionLayer, flag};

/// The options, in the order of the help.
fn in_order() -> impl Iterator<Item = &'static BuildOption> {
    Section::ALL.iter().flat_map(|section| section.options())
}

/// The key of an argument that has no flag of its own.
pub fn key_of(arg: &Arg) -> Option<&str> {
    arg.get_long()?.strip_prefix("set ")
}

/// The words of a command line with `--set` and its key in one word. A key that has a flag becomes
/// the flag.
pub fn joined(words: &[OsString]) -> Vec<OsString> {
    let (mut joined, mut words) = (Vec::with_capacity(words.len()), words.iter());
    while let Some(word) = words.next() {
        let setting = match word.to_str().and_then(|word| word.strip_prefix("--set")) {
            Some("") => words.next().map(|next| next.to_string_lossy().into_owned()),
            Some(rest) => rest.strip_prefix('=').map(str::to_owned),
            None => None,
        };
        joined.push(setting.map_or_else(
            || word.clone(),
            |setting| {
                let (key, value) = setting.split_at(setting.find('=').unwrap_or(setting.len()));
                let key = key.replace('-', "_");
                let flag =
                    if let Some(index) = named(&key) { flag(OPTIONS[index].key) } else { format!("--set {key}") };
                format!("{flag}{value}").into()
            },
        ));
    }
    joined
}

/// The subcommand with `--set` in its help, in place of the keys.
pub fn with_set(own: Command) -> Command {
    let own = own.mut_subcommands(with_set);
    let keys: Vec<_> = own.get_arguments().filter(|arg| !arg.is_hide_set()).filter_map(key_of).collect();
    if keys.is_empty() {
        return own;
    }
    let help = "Set a further option; repeatable";
    let set = Arg::new("set")
        .long("set")
        .value_name("KEY=VALUE")
        .help(help)
        .long_help(format!("{help}. Keys: {}", keys.join(", ")))
        .value_parser(PossibleValuesParser::new(keys.iter().map(|key| format!("{key}="))))
        .hide_possible_values(true);
    own.arg(set).mut_args(|arg| if key_of(&arg).is_some() { arg.hide(true) } else { arg })
}

/// The command without keys, which are no words of a shell.
pub fn without_keys(own: &Command) -> Command {
    Command::new(own.get_name().to_owned())
        .about(own.get_about().cloned().unwrap_or_default())
        .disable_help_subcommand(true)
        .args(own.get_arguments().filter(|arg| key_of(arg).is_none()).cloned())
        .subcommands(own.get_subcommands().map(without_keys))
}

/// The options of a subcommand as flags.
#[derive(Clone, Debug)]
pub struct OptionFlags(pub OptionLayer);

impl clap::Args for OptionFlags {
    fn augment_args(command: Command) -> Command {
        let is_of_robots = command.get_name() == "robot";
        command.args(in_order().filter(|own| !is_of_robots || own.scope != Scope::Terrains).map(arg))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// The options of `bake decompose`.
const OF_PARTS: [&str; 9] = [
    "decompose_seconds",
    "for_engine",
    "max_error",
    "max_parts",
    "max_vertices",
    "solid",
    "unit_scale",
    "up_axis",
    "wall",
];

/// Options of a decomposition as flags of `bake decompose`.
#[derive(Clone, Debug)]
pub struct PartsLayer(pub OptionLayer);

impl clap::Args for PartsLayer {
    fn augment_args(command: Command) -> Command {
        let no_curve = |own: &BuildOption| (own.key == "decompose_seconds").then_some("curve");
        let own = in_order().filter(|own| OF_PARTS.contains(&own.key));
        command.args(own.map(|own| arg(own).conflicts_with_all(no_curve(own))))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl clap::FromArgMatches for PartsLayer {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut layer = Self(OptionLayer::default());
        layer.update_from_arg_matches(matches)?;
        Ok(layer)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        for key in OF_PARTS {
            if let Some(index) = position(key) {
                self.0.set_at(index, matches.get_one::<Value>(key).cloned());
            }
        }
        for (key, value) in [("split", "object"), ("decompose", "true"), ("index", "none")] {
            self.0.set(key, value).map_err(|error| clap::Error::raw(clap::error::ErrorKind::InvalidValue, error))?;
        }
        Ok(())
    }
}

impl clap::FromArgMatches for OptionFlags {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut layer = Self(OptionLayer::default());
        layer.update_from_arg_matches(matches)?;
        Ok(layer)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        for (index, option) in OPTIONS.iter().enumerate() {
            // A subcommand takes some of them.
            self.0.set_at(index, matches.try_get_one::<Value>(option.key).ok().flatten().cloned());
        }
        Ok(())
    }
}

fn arg(option: &'static BuildOption) -> Arg {
    let help = match option.default {
        value if value != "false" && value != "none" => {
            format!("{} [default: {value}]", option.help)
        }
        _ => option.help.to_owned(),
    };
    let arg = Arg::new(option.key)
        .long(flag(option.key)[2..].to_owned())
        .help(option.help.split(". ").next().unwrap_or_default())
        .long_help(help)
        .help_heading((option.section != Section::Parts).then_some(option.section.heading()))
        .hide_short_help(option.section != Section::Parts || option.key == "solid")
        .value_name(option.value_name)
        .value_parser(value_parser(option))
        .hide_possible_values(true)
        .require_equals(option.is_advanced);
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
