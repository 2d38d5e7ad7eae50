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
fn files_may_follow_switches_and_poses_start_with_a_minus() {
    assert!(parse(["bake", "build", "--out", "o", "--decompose", "Cargo.toml"]).is_ok());
    assert!(parse("bake build a -o o -j 2 -q".split(' ')).is_ok(), "short forms");
    let cli = parse(["bake", "query", "a", "b", "--pose", "-1 0 0 0 0 0 1", "--pose", "1 0 0 0 0 0 1"]).unwrap();
    let Command::Query(args) = cli.command else { unreachable!() };
    assert_eq!(args.poses.len(), 2);
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
