use std::collections::BTreeSet;

use hullmap_bake::IndexKind;
use hullmap_bake::decompose::Cover;
use hullmap_bake::simplify::Limit;
use hullmap_import::{ImportOptions, Split, UpAxis, Vertices};

use super::*;
use hullmap_pipeline::options::BuildOptions;

fn build(words: &str) -> Result<BuildOptions, i32> {
    let line = format!("bake build in.obj --out out {words}");
    match parse(line.split_whitespace()) {
        Ok(Cli { command: Command::Build(args) }) => Ok(args.meshes.options.0.resolve()),
        Ok(_) => unreachable!(),
        Err(error) => Err(error.exit_code()),
    }
}

fn error(line: &str) -> String {
    parse(line.split_whitespace()).unwrap_err().to_string()
}

#[test]
fn the_definition_is_sound() {
    Cli::command().debug_assert();
}

#[test]
fn flags_set_build_options() {
    let usual = BuildOptions::default();
    assert_eq!(build(""), Ok(usual.clone()));
    for kind in IndexKind::NAMED {
        assert_eq!(build(&format!("--set index={}", kind.as_str())).unwrap().index(), kind);
    }
    let import = ImportOptions { split: Split::Object, vertices: Vertices::All, ..ImportOptions::DEFAULT };
    assert_eq!(build("--split object --set vertices=all").unwrap().import(), import);
    let import = ImportOptions { unit_scale: 0.01, up_axis: UpAxis::YToZ, recentre: true, ..ImportOptions::DEFAULT };
    assert_eq!(build("--unit-scale 0.01 --up-axis y-to-z --set recentre").unwrap().import(), import);
    assert!(!build("--set recentre=false").unwrap().import().recentre);
    assert_eq!(build("--max-vertices 64").unwrap().simplify(1.0), Some(Limit::Vertices(64)));
    assert_eq!(build("--max-error 1e-3").unwrap().simplify(1.0), Some(Limit::Distance(1e-3)));
    for words in ["--decompose --max-parts 8", "--decompose=true --max-parts 8"] {
        assert_eq!(build(words).unwrap().decompose(), Some(Cover { max_parts: Some(8), ..Cover::default() }));
    }
    assert_eq!(build("--max-parts 8"), Ok(usual), "hullmap.toml may switch decomposition on");
}

#[test]
fn wrong_arguments_exit_with_2() {
    for words in [
        "--set index=octree",
        "--unit-scale 0",
        "--up-axis x",
        "--max-vertices 8 --max-error 1",
        "--decompose=false --max-parts 8",
        "--decompose --max-parts 0",
        "--split group",
        "--set=vertices=some",
        "--jobs 0",
        "--check --force",
        "--check --depfile x",
        "--quiet --verbose",
        "--set",
        "--set wall",
        "--set wall=1% --set wall=2%",
        "--set max_error=1 --max-error 1",
        "--set depfile_target=x",
        "--unknown",
    ] {
        assert_eq!(build(words), Err(2), "{words}");
    }
    for line in [
        "bake",
        "bake build",
        "bake build a.obj",
        "bake report x",
        "bake verify",
        "bake query a",
        "bake verify x --directions 0",
        "bake query a b --mode overlap",
        "bake inspect a --color purple",
    ] {
        assert_eq!(parse(line.split_whitespace()).unwrap_err().exit_code(), 2, "{line}");
    }
    assert_eq!(parse(["bake", "--help"]).unwrap_err().exit_code(), 0);
}

#[test]
fn poses_may_start_with_a_minus() {
    let cli = parse(["bake", "query", "a", "b", "--pose", "-1 0 0 0 0 0 1", "--pose", "1 0 0 0 0 0 1"]).unwrap();
    let Command::Query(args) = cli.command else { unreachable!() };
    assert_eq!(args.poses.len(), 2);
    for words in ["a b --pose -3 0 0 0 -0.5 0 1", "--pose -3 0 0 0 -0.5 0 1 a b --json"] {
        let message = error(&format!("bake query {words}"));
        assert!(message.contains("in quotes: --pose \"-3 0 0 0 -0.5 0 1\"") && message.contains("Usage"), "{message}");
    }
}

/// `--decompose cover` was read as a mesh named `cover`, and `bake decompose` did not exist.
#[test]
fn natural_guesses_are_answered_with_the_right_name() {
    for (line, tip) in [
        ("bake coacd a.obj b.obj", "bake build MESH --out DIR --decompose"),
        ("bake vhacd a.obj b.obj", "`bake decompose MESH OUT.obj`"),
        ("bake decompose a b --concavity 1", "tip: use --max-error E"),
        ("bake decompose a b --max-hulls 4", "tip: use --max-parts N"),
        ("bake simplify a.obj", "--max-vertices N"),
        ("bake info a.hullmap", "bake inspect"),
        ("bake help", "bake --help"),
        ("bake plan a --out o", "`bake farm`"),
        ("bake build a --out o --shard 0/8", "`bake farm build --shard I/N`"),
        ("bake terrain a.asc --out o", "`bake build FILE --out DIR --terrain`"),
        ("bake build a --out o --simplify 8", "tip: use --max-vertices N"),
        ("bake build a --out o --concavity=0.1", "tip: use --max-error E"),
        ("bake build a --out o --recenter", "tip: use --set recentre=true"),
        ("bake build a --output o", "tip: use --out"),
        ("bake verify a --seed 3", "tip: use --set seed=VALUE"),
        ("bake farm key a --parts 4", "tip: use --decompose --max-parts N"),
        ("bake export a --engine unreal", "tip: use --for ENGINE"),
        ("bake build a --out o --decompose true", "--decompose takes its value after `=`: --decompose=true"),
        ("bake farm plan a --out o --set recentre true", "--set recentre=true"),
    ] {
        let message = error(line);
        assert!(message.contains(tip) && message.contains("Usage"), "{line}: {message}");
    }
    let message = error("bake build a --out o --max-vertexes 8");
    assert!(message.contains("--max-vertices"), "similar letters: {message}");
    assert!(!error("bake inspect a --simplify").contains("--max-vertices"), "a flag of another subcommand");
    let words = ["bake", "build", "--out", "o", "--decompose", "Cargo.toml"];
    assert!(parse(words).is_ok(), "a file after a switch");
    assert!(parse("bake build a -o o -j 2 -q".split(' ')).is_ok(), "short forms");
}

#[test]
fn removed_options_name_what_to_use_instead() {
    for words in ["--decompose=vhacd", "--decompose --set vhacd-resolution=32", "--vhacd-fill=flood"] {
        let message = error(&format!("bake build a.obj --out o {words}"));
        assert!(message.contains("V-HACD was removed; use decompose without a method"), "{message}");
    }
    for (words, instead) in [
        ("--decompose=cover", "decompose takes no method"),
        ("--index-budget 40", "choose a kind with index"),
        ("--set index=cubemap --resolution=5", "choose a kind with index"),
        ("--min-thickness 1%", "min_thickness was renamed; use wall"),
        ("--wall 1%", "tip: use --set wall=VALUE"),
        ("--for-engine jolt", "were renamed; use --for"),
        ("--for godot", "tip: godot has no limits; `bake export --for godot` writes its files"),
        ("--no-config", "tip: use --config none"),
        ("--set wal=1%", "'--set wall'"),
    ] {
        let message = error(&format!("bake build a.obj --out o {words}"));
        assert!(message.contains(instead), "{message}");
    }
}

/// Errors in a line are printed in colour, too.
#[test]
fn colours_are_known_before_a_line_is_parsed() {
    for (line, expected) in [
        ("bake build a", ""),
        ("bake build a --color never --wrong", "never"),
        ("bake --color=always nonsense", "always"),
        ("bake build a --color", ""),
    ] {
        let words: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        assert_eq!(color(&words), expected, "{line}");
    }
}

#[test]
fn clashes_name_both_flags() {
    let message = error("bake build a --out b --max-error 1 --max-vertices 9");
    assert!(message.contains("--max-error and --max-vertices exclude each other"), "{message}");
}

#[test]
fn wrong_values_list_the_accepted_ones() {
    let message = error("bake build a --out b --split group");
    assert!(message.contains("none, object, auto"), "{message}");
}

#[test]
fn every_subcommand_has_an_example_that_parses() {
    let root = Cli::command();
    let inner = root.get_subcommands().flat_map(|own| own.get_subcommands());
    for subcommand in root.get_subcommands().chain(inner) {
        let help = subcommand.clone().render_help().to_string();
        let examples = help.split_once("Example").map_or("", |(_, examples)| examples);
        let lines: Vec<&str> = examples.lines().filter_map(|line| line.trim_start().strip_prefix("bake ")).collect();
        assert!(!lines.is_empty(), "{}", subcommand.get_name());
        for line in lines {
            let line = line.split(['(', '>']).next().unwrap();
            let (words, quoted) = line.split_once('"').map_or((line, None), |(words, pose)| (words, Some(pose)));
            let quoted = quoted.map(|pose| pose.trim_end().trim_end_matches('"'));
            let words = ["bake"].into_iter().chain(words.split_whitespace()).chain(quoted);
            parse(words).unwrap_or_else(|error| panic!("{line}: {error}"));
        }
    }
}

/// The help of `bake build` had 117 lines, and most flags were for the few. docs/COMMAND.md has the
/// keys of `--set`.
#[test]
fn help_fits_a_screen() {
    let mut root = command("bake");
    let help = |own: &mut clap::Command| own.render_help().to_string();
    let text = help(&mut root);
    assert!(text.lines().count() <= 24 && text.lines().all(|line| line.chars().count() <= 80), "{text}");
    let commands: Vec<_> = root.get_subcommands().filter(|own| !own.is_hide_set()).collect();
    assert!(commands.len() <= 10, "{}", commands.len());
    let flags = |own: &clap::Command| -> Vec<String> {
        let shown = own.get_arguments().filter(|arg| !arg.is_hide_set());
        let named = shown.filter_map(|arg| arg.get_long().map(str::to_owned));
        named.filter(|name| name != "help" && name != "version").collect()
    };
    let nested = commands.iter().flat_map(|own| own.get_subcommands());
    let all: BTreeSet<String> = commands.iter().copied().chain([&root]).chain(nested).flat_map(flags).collect();
    assert!(all.len() <= 60, "{}: {all:?}", all.len());
    let build = root.find_subcommand("build").unwrap();
    assert!(flags(build).len() <= 35);
    assert_eq!(flags(build)[..4], ["decompose", "max-parts", "max-error", "max-vertices"]);
    // A window of 80 columns wraps the lines of wider help.
    for (command, short, long) in [("build", 25, 60), ("robot", 30, 60), ("export", 30, 60)] {
        for (columns, flag, most) in
            [(80, "-h", short), (80, "--help", long), (100, "-h", short), (100, "--help", long)]
        {
            let words: Vec<OsString> = ["bake", command, flag].map(OsString::from).to_vec();
            let text = help_of(&words, super::command("bake").term_width(columns)).unwrap().to_string();
            assert!(text.lines().count() <= most, "{}: {text}", text.lines().count());
        }
    }
    let [short, long] = ["-h", "--help"].map(|help| error(&format!("bake build {help}")));
    assert!(!short.contains("--cache ") && long.contains("--cache ") && long.contains(" record_source,"), "{long}");
    // Narrower terminals wrap the lines.
    let long: Vec<String> = commands.into_iter().cloned().map(|own| help(&mut own.term_width(120))).collect();
    assert!(long.concat().lines().all(|line| line.chars().count() <= 120), "{long:#?}");
}

#[test]
fn wrong_arguments_show_the_usage_of_their_subcommand() {
    for (line, usage) in [
        ("bake build in --out o --max-parts 0", "Usage: bake build"),
        ("bake farm plan in --out o --max-parts 0", "Usage: bake farm plan"),
        ("bake farm key in --max-error 1 --max-vertices 9", "Usage: bake farm key"),
        ("bake build in --out o --memory many", "Usage: bake build"),
        ("bake build in --out o --set index=octree", "Usage: bake build"),
        ("bake query a b --mode overlap", "Usage: bake query"),
        ("bake build in", "Usage: bake build"),
        ("bake build in --out o --max-error 1 --max-vertices 9", "Usage: bake build"),
        ("bake verify x --directions 0", "Usage: bake verify"),
        ("bake inspect", "Usage: bake inspect"),
        ("bake query a", "Usage: bake query"),
        ("bake completions", "Usage: bake completions"),
    ] {
        let message = error(line);
        assert!(message.contains(usage), "{line}: {message}");
    }
}

/// `hullmap --help` of the Python package printed `Usage: bake`.
#[test]
fn help_has_the_name_under_which_the_command_was_started() {
    let text = |words: &[&str]| parse(words).unwrap_err().to_string();
    for (program, name) in [("bake", "bake"), ("/opt/bin/bake", "bake"), ("hullmap", "hullmap")] {
        assert!(text(&[program, "--help"]).contains(&format!("Usage: {name} [OPTIONS] <COMMAND>")));
        assert!(text(&[program, "--help"]).contains(&format!("`{name} build FOLDER --out DIR`")));
        assert!(text(&[program, "inspect", "--help"]).contains(&format!("Example:\n  {name} inspect baked")));
        assert!(text(&[program, "inspect"]).contains(&format!("Usage: {name} inspect")));
        assert!(
            text(&[program, "build", "a", "--out", "o", "--memory", "x"]).contains(&format!("Usage: {name} build"))
        );
    }
    let module = "python -m hullmap";
    assert!(text(&[module, "--help"]).contains("Usage: python -m hullmap [OPTIONS] <COMMAND>"));
    assert!(!text(&[module, "build", "--help"]).contains("bake build"));
}

#[test]
fn sizes() {
    for (text, bytes) in
        [("4096", 4096), ("1K", 1024), ("500M", 500 << 20), ("8g", 8 << 30), ("2GiB", 2 << 30), ("1mb", 1 << 20)]
    {
        assert_eq!(size(text), Ok(bytes), "{text}");
    }
    for text in ["", "0", "M", "-1", "1.5G", "5X", "99999999T"] {
        assert!(size(text).is_err(), "{text}");
    }
}
