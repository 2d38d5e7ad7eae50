//! Which Python file imports which, and which JavaScript file.

use std::path::{Component, Path, PathBuf};

use super::graph::{Graph, Sources};

/// Adds the edges between scripts.
pub fn add_edges(sources: &Sources, graph: &mut Graph) {
    for (file, text) in sources {
        let used = match file.extension().and_then(|extension| extension.to_str()) {
            Some("py") => python(sources, file, text),
            Some("js" | "mjs") => javascript(file, text),
            _ => continue,
        };
        for used in used.iter().filter(|used| sources.contains_key(*used)) {
            graph.add(file, used, &used.display().to_string());
        }
    }
}

/// The files that `from module import names` and `import module` name.
fn python(sources: &Sources, file: &Path, text: &str) -> Vec<PathBuf> {
    // An absolute import names the end of a path.
    let find = |module: &Path| -> Vec<PathBuf> {
        let names = [module.with_extension("py"), module.with_extension("pyi"), module.join("__init__.py")];
        let ends = |found: &&PathBuf| names.iter().any(|name| found.ends_with(name));
        sources.keys().filter(ends).cloned().collect()
    };
    let mut used = Vec::new();
    let text = text.replace("(\n", "(").replace(",\n", ",");
    for line in text.lines().map(str::trim_start) {
        let (path, names) = match (line.strip_prefix("from "), line.strip_prefix("import ")) {
            (Some(rest), _) => rest.split_once(" import ").unwrap_or_default(),
            (_, Some(path)) => (path.split([' ', ',']).next().unwrap_or_default(), ""),
            _ => continue,
        };
        if path.is_empty() {
            continue;
        }
        let dots = path.len() - path.trim_start_matches('.').len();
        let above = file.ancestors().nth(dots).filter(|_| dots > 0).unwrap_or(Path::new(""));
        let module = above.join(path.trim_start_matches('.').replace('.', "/"));
        // A name is a module, or one of the module's own.
        for name in names.split(['(', ')', ',']).map(|name| name.split_whitespace().next().unwrap_or("__init__")) {
            let found = find(&module.join(name));
            used.extend(if found.is_empty() { find(&module) } else { found });
        }
    }
    used
}

/// The files that `import … from "./name.js"`, `import("./name.js")` or `require` name.
fn javascript(file: &Path, text: &str) -> Vec<PathBuf> {
    let mut used = Vec::new();
    for quote in ['"', '\''] {
        let mut parts = text.split(quote);
        let mut before = parts.next().unwrap_or_default();
        for part in parts {
            let is_import =
                ["from", "import", "import(", "require("].iter().any(|word| before.trim_end().ends_with(word));
            if is_import && part.starts_with('.') {
                used.push(beside(file, part));
            }
            before = part;
        }
    }
    used
}

/// The file at a relative path.
fn beside(file: &Path, path: &str) -> PathBuf {
    let mut found = file.parent().unwrap_or(Path::new("")).to_owned();
    for part in Path::new(path).components() {
        match part {
            Component::ParentDir => drop(found.pop()),
            Component::Normal(name) => found.push(name),
            _ => {}
        }
    }
    found
}
