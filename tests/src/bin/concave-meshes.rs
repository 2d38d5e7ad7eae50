//! Writes generated concave meshes as OBJ files.
//!
//! ```text
//! cargo program concave-meshes -- --write FOLDER
//! ```

use std::path::PathBuf;

use clap::Parser;
use shapes::{concave, obj};

/// Generated concave meshes.
#[derive(Parser)]
struct Arguments {
    /// Folder to write the meshes to
    #[arg(long)]
    write: PathBuf,
}

fn main() {
    let folder = Arguments::parse().write;
    for (name, mesh) in concave::all() {
        std::fs::write(folder.join(name).with_extension("obj"), obj::text(&mesh)).expect("the folder can be written");
    }
}
