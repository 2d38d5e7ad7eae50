//! Flags in docs/COMMAND.md, made from the command.
//!
//! Each section of the page has a block between two marks. With `UPDATE=1`, the test replaces the
//! blocks; otherwise it fails if one is stale. `clap-markdown` was judged: it repeats the forty
//! flags of `bake build` under six other commands, and takes a page without other text.

use std::collections::HashSet;
use std::{env, fs};

use clap::{Arg, Command};

use super::DECIDED_BY_ROBOTS;
use super::options::key_of;

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/COMMAND.md");
const END: &str = "<!-- end -->\n";

/// An argument as it is typed: `--max-vertices N`, `INPUT`.
fn typed(arg: &Arg) -> String {
    let names = arg.get_value_names().unwrap_or_default().join(" ");
    let short = arg.get_short().map_or_else(String::new, |short| format!("-{short}, "));
    match arg.get_long() {
        // A switch takes its value after `=`, and rarely has one.
        Some(long) if key_of(arg).is_some() => format!("--{long}={names}"),
        Some(long) if !arg.get_action().takes_values() || arg.is_require_equals_set() => format!("{short}--{long}"),
        Some(long) => format!("{short}--{long} {names}"),
        None => names,
    }
}

fn meaning(arg: &Arg) -> String {
    // The keys of --set are listed below it.
    let help = arg.get_long_help().filter(|_| arg.get_id() != "set").or(arg.get_help());
    // A second paragraph is for this page.
    let help = help.map(|help| help.to_string().replace("\n\n", ". ")).unwrap_or_default();
    assert!(!help.is_empty(), "no help: {}", typed(arg));
    let values: Vec<_> = arg.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
    match values.as_slice() {
        [value] if arg.get_action().takes_values() && !arg.is_hide_default_value_set() => {
            format!("{help} [default: {value}]")
        }
        _ => help,
    }
}

fn name(own: &Command) -> String {
    own.get_display_name().unwrap_or_default().replace('-', " ")
}

/// Usage and arguments of a subcommand. Flags that mean the same in `bake build` are only named.
fn block(own: &Command, build: &Command) -> String {
    let usage = own.clone().render_usage().to_string();
    let mut text = format!("    {}\n", usage.trim_start_matches("Usage: "));
    let is_repeated = |arg: &Arg| {
        let same = |other: &Arg| other.get_long() == arg.get_long() && meaning(other) == meaning(arg);
        arg.get_long().is_some() && name(own) != "bake build" && build.get_arguments().any(same)
    };
    let is_taken = |key: &str| own.get_name() != "robot" || !DECIDED_BY_ROBOTS.contains(&key);
    let is_shown = |arg: &&Arg| !arg.is_hide_set() || key_of(arg).is_some_and(is_taken);
    let is_of_all = |arg: &Arg| arg.get_id() == "help" || arg.get_id() == "color" && name(own) != "bake build";
    let shown = own.get_arguments().filter(is_shown).filter(|arg| !is_of_all(arg));
    let (repeated, listed): (Vec<_>, Vec<_>) = shown.partition(|arg| is_repeated(arg));
    // As in the help: arguments without a heading come first, then headings as they appear.
    let mut headings: Vec<_> = listed.iter().map(|arg| arg.get_help_heading()).collect();
    headings.sort_by_key(Option::is_some);
    let mut seen = HashSet::new();
    headings.retain(|heading| seen.insert(*heading));
    for heading in headings {
        text += &heading.map_or_else(|| "\n".to_owned(), |heading| format!("\n{heading}:\n\n"));
        for arg in listed.iter().filter(|arg| arg.get_help_heading() == heading) {
            text += &format!("- `{}`: {}\n", typed(arg), meaning(arg));
        }
    }
    // A heading stands for its flags if all of them are repeated.
    let count = |args: &[&Arg], heading| args.iter().filter(|arg| arg.get_help_heading() == Some(heading)).count();
    let all: Vec<_> = build.get_arguments().collect();
    let mut names: Vec<_> = repeated
        .iter()
        .map(|arg| match arg.get_help_heading() {
            Some(heading) if count(&all, heading) == count(&repeated, heading) => format!("all of *{heading}*"),
            _ => format!("`--{}`", arg.get_long().unwrap_or_default()),
        })
        .collect();
    let mut seen = HashSet::new();
    names.retain(|name| seen.insert(name.clone()));
    if !names.is_empty() {
        text += &format!("\nAs for [bake build](#bake-build): {}.\n", names.join(", "));
    }
    text
}

/// The table stated that commands have flags which they lacked.
#[test]
fn commands_have_the_flags_of_the_conventions() {
    let page = fs::read_to_string(PAGE).unwrap();
    let (_, table) = page.split_once("## Conventions\n").unwrap();
    let rows = table.lines().skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|'));
    // `-q`, `--quiet`: build, robot; and so on
    let lists = rows.filter_map(|row| row.split('|').nth(2)?.split_once("`: "));
    let command = super::command("bake");
    let mut count = 0;
    for (flags, listed) in lists {
        for flag in flags.trim().trim_start_matches('`').split("`, `") {
            let is_it = |arg: &Arg| match flag.strip_prefix("--") {
                Some(long) => arg.get_long() == Some(long),
                None => arg.get_short() == flag.chars().nth(1),
            };
            let visible = command.get_subcommands().filter(|own| !own.is_hide_set());
            let mut having: Vec<_> =
                visible.filter(|own| own.get_arguments().any(is_it)).map(Command::get_name).collect();
            having.sort_unstable();
            let listed = listed.split(';').next().unwrap_or_default().trim();
            assert_eq!(having.join(", "), listed, "{flag}");
            count += 1;
        }
    }
    assert_eq!(count, 11);
}

#[test]
fn the_page_has_the_flags_of_the_command() {
    let mut command = super::command("bake");
    command.build();
    let build = command.find_subcommand("build").unwrap();
    let page = fs::read_to_string(PAGE).unwrap();
    let mut made = page.clone();
    let own = command.get_subcommands().flat_map(|own| [own].into_iter().chain(own.get_subcommands()));
    for own in own.filter(|own| !own.has_subcommands()) {
        let mark = format!("<!-- {}: made by args/reference.rs -->\n", name(own));
        let (before, rest) = made.split_once(&mark).unwrap_or_else(|| panic!("docs/COMMAND.md lacks {mark}"));
        let (_, after) = rest.split_once(END).unwrap();
        made = format!("{before}{mark}{}{END}{after}", block(own, build));
    }
    if env::var_os("UPDATE").is_some() {
        fs::write(PAGE, &made).unwrap();
    } else {
        assert!(page == made, "docs/COMMAND.md is stale: UPDATE=1 cargo test -p hullmap-cli --lib reference");
    }
}
