//! Guessed names and the names to use instead: `--simplify` is `--max-vertices`.
//!
//! clap suggests names of similar letters; these are names of similar meaning.

use std::ffi::OsString;
use std::path::Path;

use clap::ValueEnum;
use clap::error::{ContextKind, ContextValue, ErrorKind};

use super::export::Target;
use hullmap_pipeline::budget::budget;
use hullmap_pipeline::options::flag;
use hullmap_pipeline::options::removed::instead_of_option;
use hullmap_pipeline::options::table::OPTIONS;
use hullmap_pipeline::options::value::Syntax;

const SUBCOMMANDS: [(&[&str], &str); 13] = [
    (
        &["split", "vhacd", "coacd", "parts"],
        "convex parts are made by `bake decompose MESH OUT.obj`, and in packs by `bake build MESH --out DIR --decompose`",
    ),
    (&["simplify", "reduce", "decimate"], "hulls are simplified by `bake build MESH --out DIR --max-vertices N`"),
    (&["bake", "hull", "convex", "cook", "make", "create", "convert", "import"], "meshes are baked by `bake build`"),
    (&["info", "show", "list", "ls", "stats", "describe", "print", "dump"], "packs are described by `bake inspect`"),
    (&["check", "test", "validate"], "packs are verified by `bake verify`; `bake build --check` lists stale ones"),
    (&["contact", "collide", "distance", "intersect", "intersects"], "two packs are compared by `bake query`"),
    (&["view", "html", "visualise", "visualize", "open"], "packs are drawn on a page by `bake report`"),
    (&["clean", "prune", "remove"], "packs whose source is gone are removed by `bake build --prune`"),
    (&["terrain", "heightfield"], "grids of heights are baked by `bake build FILE --out DIR --terrain`"),
    (&["key", "plan", "task", "status", "shard"], "one build on many machines is made by `bake farm`"),
    (&["watch"], "files that change are baked by `bake build --watch`"),
    (&["config", "new"], "a hullmap.toml is written by `bake init`"),
    (&["help", "version"], "pass it as a flag: `bake --help`, `bake COMMAND --help`, `bake --version`"),
];

/// Guessed flags, without dashes, and the flags that are meant, for subcommands that have these.
const FLAGS: [(&[&str], &str, &str); 21] = [
    (&["simplify", "vertices-max", "max-verts", "max-points", "decimate"], "max-vertices", "--max-vertices N"),
    (&["tolerance", "error", "epsilon", "threshold", "concavity"], "max-error", "--max-error E"),
    (&["parts", "num-parts", "hulls", "max-hulls", "max-convex-hulls"], "max-parts", "--decompose --max-parts N"),
    (&["vhacd", "coacd", "convex-decomposition", "concave", "method"], "decompose", "--decompose"),
    (
        &["time", "timeout", "time-limit", "max-seconds"],
        "set decompose_seconds",
        "--decompose --set decompose_seconds=S",
    ),
    (&["scale", "unit", "units"], "unit-scale", "--unit-scale F"),
    (&["up", "axis", "y-up", "z-up"], "up-axis", "--up-axis y-to-z or z-to-y"),
    (&["recenter", "center", "centre"], "set recentre", "--set recentre=true"),
    (&["output", "output-dir", "dir"], "out", "--out"),
    (&["threads", "workers"], "jobs", "--jobs N"),
    (&["dry-run", "n"], "check", "--check"),
    (&["overwrite", "f", "rebuild"], "force", "--force"),
    (&["clean", "delete"], "prune", "--prune"),
    (&["filter", "formats", "extensions"], "ext", "--ext LIST"),
    (&["skip", "ignore"], "exclude", "--exclude GLOB"),
    (&["engine", "target"], "for", "--for ENGINE"),
    (&["samples", "count"], "directions", "--directions N"),
    (&["no-config"], "config", "--config none"),
    (&["shard"], "prune", "`bake farm build --shard I/N`"),
    (&["hulls"], "require-source", "--verbose"),
    (&["mesh", "input"], "source", "--source PATH"),
];

/// The error with the name that is meant, if a guess is known. `command` is the subcommand.
pub fn with_tip(error: clap::Error, command: &clap::Command) -> clap::Error {
    let context = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => text.clone(),
        _ => String::new(),
    };
    let tip = match error.kind() {
        ErrorKind::InvalidSubcommand => {
            let name = context(ContextKind::InvalidSubcommand).to_lowercase();
            SUBCOMMANDS.iter().find(|(guesses, _)| guesses.contains(&&*name)).map(|(_, tip)| (*tip).to_owned())
        }
        ErrorKind::InvalidValue if context(ContextKind::InvalidArg).starts_with("--for ") => {
            let engine = context(ContextKind::InvalidValue);
            match (Target::from_str(&engine, false), budget(&engine)) {
                (Ok(_), _) => Some(format!("{engine} has no limits; `bake export --for {engine}` writes its files")),
                (_, Some(_)) => Some(format!(
                    "{engine} has no files of its own; `bake build --for {engine}` meets its limits, and programs \
                         read the pack (docs/engines.md)"
                )),
                _ => None,
            }
        }
        ErrorKind::UnknownArgument => {
            let argument = context(ContextKind::InvalidArg);
            let name = argument.trim_start_matches('-').trim_start_matches("set ");
            let name = name.split('=').next().unwrap_or_default().to_lowercase();
            if let Some(instead) = instead_of_option(&name) {
                return with_suggestion(error, instead.to_owned());
            }
            let is_known = |own: &str| command.get_arguments().any(|argument| argument.get_long() == Some(own));
            let meant = FLAGS.iter().find(|(guesses, own, _)| guesses.contains(&&*name) && is_known(own));
            // `bake decompose` decomposes without a flag.
            let usage = |usage: &str| {
                if is_known("decompose") { usage.to_owned() } else { usage.replace("--decompose --", "--") }
            };
            let key = name.replace('-', "_");
            match meant {
                _ if is_known(&format!("set {key}")) => Some(format!("use --set {key}=VALUE")),
                Some((_, _, meant)) => Some(format!("use {}", usage(meant))),
                None => None,
            }
        }
        ErrorKind::MissingRequiredArgument if command.get_name() == "build" => {
            Some("`bake init` here writes a hullmap.toml; with its `sources` and `output`, none is required".to_owned())
        }
        _ => None,
    };
    match tip {
        Some(tip) => with_suggestion(error, tip),
        None => error,
    }
}

fn with_suggestion(mut error: clap::Error, tip: String) -> clap::Error {
    error.remove(ContextKind::SuggestedArg);
    error.remove(ContextKind::SuggestedSubcommand);
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    error
}

/// The error for a switch with a separate value: `--decompose true` bakes a mesh named `true`.
pub fn detached_value(words: &[OsString]) -> Option<String> {
    words.windows(2).find_map(|pair| {
        let (name, value) = (pair[0].to_str()?, pair[1].to_str()?);
        let mut switches = OPTIONS.iter().filter(|option| option.syntax == Syntax::Switch && option.default == "false");
        let option = switches.find(|option| flag(option.key) == name)?;
        let is_value = option.parse(value).is_ok() && !Path::new(value).exists();
        is_value.then(|| format!("{name} takes its value after `=`: {name}={value}"))
    })
}
