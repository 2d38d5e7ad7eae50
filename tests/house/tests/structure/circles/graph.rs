//! A graph of files, and its circles: strongly connected components of more than one file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The texts of files.
pub type Sources = BTreeMap<PathBuf, String>;

/// For each file, the files that it uses, and the names by which it uses them.
#[derive(Default)]
pub struct Graph(BTreeMap<PathBuf, BTreeMap<PathBuf, BTreeSet<String>>>);

impl Graph {
    pub fn add(&mut self, user: &Path, used: &Path, name: &str) {
        if user != used {
            let edges = self.0.entry(user.to_owned()).or_default();
            edges.entry(used.to_owned()).or_default().insert(name.to_owned());
        }
    }

    /// The graph of groups of files: the group of a file takes its place, and a file without a
    /// group is left out.
    pub fn grouped(&self, group: impl Fn(&Path) -> Option<PathBuf>) -> Self {
        let mut grouped = Self::default();
        for (user, used) in &self.0 {
            for (used, names) in used {
                if let (Some(user), Some(used)) = (group(user), group(used)) {
                    names.iter().for_each(|name| grouped.add(&user, &used, name));
                }
            }
        }
        grouped
    }

    pub fn edge_count(&self) -> usize {
        self.0.values().map(BTreeMap::len).sum()
    }

    /// Files that `file` uses, itself or through others.
    fn reach<'g>(&'g self, file: &'g Path) -> BTreeSet<&'g Path> {
        let (mut found, mut open) = (BTreeSet::new(), vec![file]);
        while let Some(file) = open.pop() {
            let used = self.0.get(file).into_iter().flat_map(BTreeMap::keys);
            open.extend(used.map(PathBuf::as_path).filter(|used| found.insert(*used)));
        }
        found
    }

    /// Each circle as text: an edge a line.
    pub fn circles(&self) -> Vec<String> {
        let reach: BTreeMap<&Path, BTreeSet<&Path>> =
            self.0.keys().map(|file| (file.as_path(), self.reach(file))).collect();
        let circle_of = |file: &Path| -> Vec<&Path> {
            reach[file]
                .iter()
                .copied()
                .filter(|other| reach.get(other).is_some_and(|back| back.contains(file)))
                .collect()
        };
        let circles: BTreeSet<Vec<&Path>> = reach.keys().map(|file| circle_of(file)).collect();
        circles.iter().filter(|circle| !circle.is_empty()).map(|circle| self.describe(circle)).collect()
    }

    fn describe(&self, circle: &[&Path]) -> String {
        let mut text = format!("a circle of {} files:", circle.len());
        for user in circle {
            for (used, names) in self.0[*user].iter().filter(|(used, _)| circle.contains(&used.as_path())) {
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                text += &format!("\n  {} -> {}: {}", user.display(), used.display(), names.join(", "));
            }
        }
        text
    }
}
