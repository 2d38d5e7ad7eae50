//! The options as flags of the subcommands, made from the table.

use std::sync::LazyLock;

use clap::builder::{PossibleValuesParser, TypedValueParser, ValueParser};
use clap::{Arg, ArgMatches, Command};

use hullmap_pipeline::options::table::{BuildOption, OPTIONS, Scope, Section, position};
use hullmap_pipeline::options::value::{Syntax, Value};
use hullmap_pipeline::options::{OptionLayer, flag};

/// The flags, in the order of the help. clap takes names that live as long as the program.
static FLAGS: LazyLock<Vec<(&'static BuildOption, &'static str)>> = LazyLock::new(|| {
    Section::ALL.iter().flat_map(|own| own.options()).map(|option| (option, &*flag(option.key).leak())).collect()
});

/// The subcommand that takes the options of terrains. All others take the options of meshes, and
/// find terrains by the rules of `hullmap.toml`.
pub const TERRAIN: &str = "terrain";

/// The options of a subcommand as flags.
#[derive(Clone, Debug)]
pub struct OptionFlags(pub OptionLayer);

impl clap::Args for OptionFlags {
    fn augment_args(command: Command) -> Command {
        let is_terrain = command.get_name() == TERRAIN;
        let is_taken = |option: &BuildOption| match option.scope {
            Scope::All => option.key != "terrain",
            Scope::Terrains => is_terrain,
            _ => !is_terrain,
        };
        let mut taken: Vec<_> = FLAGS.iter().filter(|(option, _)| is_taken(option)).collect();
        // The help has the options of the subcommand first.
        taken.sort_by_key(|(option, _)| option.scope != Scope::Terrains);
        command.args(taken.into_iter().map(|(option, flag)| arg(option, flag)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// Options have help of their own where the help of `bake build` is also about whole hulls.
const OF_PARTS: [(&str, Option<&str>); 9] = [
    (
        "max_error",
        Some(
            "How far parts may protrude from the mesh's solid: a length, or a share of the mesh's diagonal such as 1%; default 2%",
        ),
    ),
    ("max_vertices", Some("Maximum number of vertices of each part, 4 or more; default 64")),
    (
        "for_engine",
        Some(
            "Simplify parts to the limits of an engine: physx, physx-gpu, jolt, box3d, unity, unreal, newton or mujoco-warp",
        ),
    ),
    ("max_parts", None),
    ("solid", None),
    ("wall", None),
    ("decompose_seconds", None),
    ("unit_scale", None),
    ("up_axis", None),
];

/// Options of a decomposition as flags of `bake decompose`.
#[derive(Clone, Debug)]
pub struct PartsLayer(pub OptionLayer);

impl clap::Args for PartsLayer {
    fn augment_args(command: Command) -> Command {
        command.args(OF_PARTS.iter().filter_map(|(key, help)| {
            let (option, flag) = FLAGS.iter().find(|(option, _)| option.key == *key)?;
            let arg = arg(option, flag).hide_short_help(false);
            Some(match help {
                Some(help) => arg.help(*help),
                None => arg,
            })
        }))
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
        for (key, _) in OF_PARTS {
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

fn arg(option: &'static BuildOption, flag: &'static str) -> Arg {
    let help = match option.default {
        value if value != "false" && option.syntax.parse(value) != Ok(Value::None) => {
            format!("{} [default: {value}]", option.help)
        }
        _ => option.help.to_owned(),
    };
    let arg = Arg::new(option.key)
        .long(flag)
        .help(help)
        .help_heading(option.section.heading())
        .value_name(option.value_name)
        .value_parser(value_parser(option))
        .hide_possible_values(true)
        // Heights, offsets and origins may be below 0.
        .allow_hyphen_values(option.scope == Scope::Terrains)
        .hide_short_help(option.is_advanced);
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
