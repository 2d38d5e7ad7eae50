//! Writes the generated OBJ files, or checks that a folder holds exactly those.

#![forbid(unsafe_code)]

use shapes::assets;
use std::path::PathBuf;
use std::process::ExitCode;

const USAGE: &str = "\
Usage: make-assets DIR           write the generated files into DIR
       make-assets --check DIR   list the files in DIR that differ from the generated ones
       make-assets --help

Exit status: 0 done; 1 --check found a difference; 2 usage error, or a file could not be read or written.";

enum Command {
    Help,
    Write(PathBuf),
    Check(PathBuf),
}

fn parse(args: impl Iterator<Item = std::ffi::OsString>) -> Result<Command, String> {
    let mut check = false;
    let mut dir: Option<PathBuf> = None;
    for arg in args {
        match arg.to_str() {
            Some("-h" | "--help") => return Ok(Command::Help),
            Some("--check") => check = true,
            Some(option) if option.starts_with('-') => {
                return Err(format!("unknown option {option}"));
            }
            _ if dir.is_some() => {
                let extra = arg.to_string_lossy();
                return Err(format!("unexpected argument {extra}; expected one folder"));
            }
            _ => dir = Some(arg.into()),
        }
    }
    let dir = dir.ok_or("missing argument DIR")?;
    Ok(if check { Command::Check(dir) } else { Command::Write(dir) })
}

fn main() -> ExitCode {
    let command = match parse(std::env::args_os().skip(1)) {
        Ok(command) => command,
        Err(message) => {
            eprintln!("make-assets: {message}\n\n{USAGE}");
            return ExitCode::from(2);
        }
    };
    let outcome = match command {
        Command::Help => {
            println!("{USAGE}");
            return ExitCode::SUCCESS;
        }
        Command::Write(dir) => assets::write(&dir).map(|written| {
            for name in &written {
                eprintln!("wrote {}", dir.join(name).display());
            }
            if written.is_empty() {
                eprintln!("{}: up to date", dir.display());
            }
            ExitCode::SUCCESS
        }),
        Command::Check(dir) => assets::compare(&dir).map(|differences| {
            for (name, difference) in &differences {
                println!("{}: {difference}", dir.join(name).display());
            }
            if differences.is_empty() {
                return ExitCode::SUCCESS;
            }
            eprintln!(
                "make-assets: {} files differ; run `make-assets {}` to regenerate them, and delete those that are not generated",
                differences.len(),
                dir.display()
            );
            ExitCode::from(1)
        }),
    };
    outcome.unwrap_or_else(|error| {
        eprintln!("make-assets: {error}");
        ExitCode::from(2)
    })
}
