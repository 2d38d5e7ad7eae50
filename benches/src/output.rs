//! Atomic writing of files.

use std::{
    fs,
    io::{self, Write},
    path::Path,
};

/// Writes `text` to a temporary file beside `path`, then renames it. Fails with any error of the
/// file system, and its path.
pub fn write(path: &Path, text: &str) -> io::Result<()> {
    let explained = |e: io::Error| io::Error::new(e.kind(), format!("cannot write {}: {e}", path.display()));
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(folder).map_err(explained)?;
    let mut file = tempfile::NamedTempFile::new_in(folder).map_err(explained)?;
    file.write_all(text.as_bytes()).map_err(explained)?;
    file.as_file().sync_all().map_err(explained)?;
    file.persist(path).map_err(|e| explained(e.error))?;
    Ok(())
}
