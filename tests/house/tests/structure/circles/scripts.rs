//! Which Python file imports which, and which JavaScript file.

use std::path::{Component, Path, PathBuf};

use super::graph::{Graph, Sources};

/// Adds the edges between scripts.
pub fn add_edges(sources: &Sources, graph: &mut Graph) {
    for (file, text) in sources {
        let used = match file.extension().and_then(|extension| extension.to_str()) {
            Some("py") => python(file, text),
            Some("js" | "mjs") => javascript(file, text),
            _ => continue,
        };
        for used in used {
            // Python's absolute imports name the end of a path.
            let is_found = |other: &&PathBuf| **other == used || !used.starts_with("./") && other.ends_with(&used);
            for found in sources.keys().filter(is_found) {
                graph.add(file, found, &used.display().to_string());
            }
        }
    }
}
