//! Puts written files in place: each is complete or absent, and replaces another only on request.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::outcome::Failure;
use crate::pack_file::{put_in_free_place, put_in_place, write_beside};

/// Fails if a file, or a link, exists at a target.
pub fn check_free(targets: &[PathBuf]) -> Result<(), Failure> {
    match targets.iter().find(|target| fs::symlink_metadata(target).is_ok()) {
        Some(target) => Err(exists(target)),
        None => Ok(()),
    }
}

/// Writes a file. With `force`, it replaces a file that exists.
pub fn put(target: &Path, bytes: &[u8], force: bool) -> Result<(), Failure> {
    let unplaced = write_beside(target, bytes).map_err(|error| cannot_write(target, &error))?;
    let place = if force { put_in_place } else { put_in_free_place };
    place(unplaced, target).map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists if !force => exists(target),
        _ => cannot_write(target, &error),
    })
}

pub fn cannot_write(target: &Path, error: &io::Error) -> Failure {
    Failure::usage(format!("{}: cannot write: {error}; check the path", target.display()))
}

fn exists(target: &Path) -> Failure {
    let target = target.display();
    Failure::usage(format!(
        "{target}: already exists and was not changed; name another path, or replace it with --force"
    ))
}
