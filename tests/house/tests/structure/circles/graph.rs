//! A graph of files, and its circles: strongly connected components of more than one file.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// For each file, the files that it uses, and the names by which it uses them.
#[derive(Default)]
pub struct Graph {
    edges: BTreeMap<PathBuf, BTreeMap<PathBuf, BTreeSet<String>>>,
}

impl Graph {
    pub fn add(&mut self, user: &Path, used: &Path, name: &str) {
        if user != used {
            let edges = self.edges.entry(user.to_owned()).or_default();
            edges.entry(used.to_owned()).or_default().insert(name.to_owned());
        }
    }

    pub fn edge_count(&self) -> usize {
        self.edges.values().map(BTreeMap::len).sum()
    }

    /// Files that can be reached from `file`.
    fn reach<'a>(&'a self, file: &'a Path) -> BTreeSet<&'a Path> {
        let (mut found, mut open) = (BTreeSet::new(), vec![file]);
        while let Some(file) = open.pop() {
            let used = self.edges.get(file).into_iter().flat_map(BTreeMap::keys);
            open.extend(used.map(PathBuf::as_path).filter(|used| found.insert(*used)));
        }
        found
    }

    pub fn circles(&self) -> Vec<BTreeSet<&Path>> {
        let reach: BTreeMap<&Path, BTreeSet<&Path>> =
            self.edges.keys().map(|file| (file.as_path(), self.reach(file))).collect();
        let mut circles = BTreeSet::new();
        for (file, reached) in &reach {
            let circle = reached.iter().copied().filter(|other| reach.get(other).is_some_and(|back| back.contains(file)));
            let circle: BTreeSet<&Path> = circle.collect();
            if !circle.is_empty() {
                circles.insert(circle);
            }
        }
        circles.into_iter().collect()
    }

    /// The edges of a circle, one a line.
    pub fn describe(&self, circle: &BTreeSet<&Path>) -> String {
        let mut text = format!("a circle of {} files\n", circle.len());
        for user in circle {
            for (used, names) in self.edges[*user].iter().filter(|(used, _)| circle.contains(used.as_path())) {
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                let _ = writeln!(text, "  {} -> {}: {}", user.display(), used.display(), names.join(", "));
            }
        }
        text
    }
}
