//! Which Rust file uses which: the paths in its code, resolved through `use` and re-exports to the
//! file that defines the item. A module that is named for its re-export counts, too. Methods have
//! no path.

use std::collections::{BTreeMap, BTreeSet};
use std::iter::successors;
use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};

use super::graph::{Graph, Sources};

/// Paths are followed through this many imports. Only a circle of re-exports is longer.
const MOST_STEPS: usize = 32;

/// Words before the name of an item.
const ITEMS: [&str; 8] = ["const", "enum", "fn", "static", "struct", "trait", "type", "union"];

/// A file, or a block `mod name { }`.
#[derive(Default)]
struct Module {
    file: PathBuf,
    parent: Option<usize>,
    children: BTreeMap<String, usize>,
    items: BTreeSet<String>,
    imports: Vec<Import>,
    paths: BTreeSet<Vec<String>>,
}

struct Import {
    /// `*` for all names.
    name: String,
    path: Vec<String>,
    is_public: bool,
}

struct Modules<'s> {
    sources: &'s Sources,
    all: Vec<Module>,
    /// Files of child modules, tests included. The other files are roots of crates.
    named: BTreeSet<PathBuf>,
}

/// Adds the edges between Rust files.
pub fn add_edges(sources: &Sources, graph: &mut Graph) {
    let mut modules = Modules { sources, all: Vec::new(), named: BTreeSet::new() };
    // The first pass finds the files of child modules.
    for _ in 0..2 {
        modules.all.clear();
        for file in sources.keys().filter(|file| file.extension().is_some_and(|extension| extension == "rs")) {
            if !modules.named.contains(file) {
                modules.read(file, None);
            }
        }
    }
    for (at, module) in modules.all.iter().enumerate() {
        let imports = module.imports.iter().filter(|import| import.name != "*");
        let imports = imports.map(|import| (&import.path, import.is_public));
        for (path, is_public) in imports.chain(module.paths.iter().map(|path| (path, false))) {
            // A parent that re-exports an item of a child does not use it.
            let is_child =
                |found: usize| successors(Some(found), |at| modules.all[*at].parent).any(|above| above == at);
            if let Some(found) = modules.resolve(at, path, 0).filter(|found| !is_public || !is_child(*found)) {
                graph.add(&module.file, &modules.all[found].file, &path.join("::"));
                // A module that re-exports the item is used, too, unless it is a parent.
                let through = modules.named(at, path).filter(|through| !modules.contains(*through, at));
                if let Some(through) = through {
                    graph.add(&module.file, &modules.all[through].file, &path.join("::"));
                }
            }
        }
    }
}

impl Modules<'_> {
    fn read(&mut self, file: &Path, parent: Option<usize>) -> usize {
        let tokens = self.sources[file].parse().unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        self.add(file, parent, tokens)
    }

    fn add(&mut self, file: &Path, parent: Option<usize>, tokens: TokenStream) -> usize {
        let at = self.all.len();
        self.all.push(Module { file: file.to_owned(), parent, ..Module::default() });
        self.scan(at, tokens, true);
        at
    }

    /// Finds modules, items, imports and paths. Only items at the top belong to the module.
    fn scan(&mut self, at: usize, tokens: TokenStream, is_top: bool) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let words: Vec<String> = tokens.iter().map(word).collect();
        let word = |index: usize| words.get(index).map_or("", String::as_str);
        let (mut i, mut place) = (0, None);
        while i < words.len() {
            match word(i) {
                "#" if word(i + 1) == "[" => {
                    let text = tokens[i + 1].to_string();
                    i += 2;
                    if text.starts_with("[cfg (test") || text.starts_with("[cfg (all (test") {
                        let end = (i..words.len()).find(|i| [";", "{"].contains(&word(*i))).unwrap_or(words.len());
                        if let Some(name) = (i..end).find(|i| word(*i) == "mod") {
                            self.named.extend(self.file_of(at, word(name + 1), place.take()));
                        }
                        i = end + 1;
                    } else if text.starts_with("[path") {
                        place = text.split('"').nth(1).map(str::to_owned);
                    } else if let TokenTree::Group(group) = &tokens[i - 1] {
                        self.scan(at, group.stream(), false);
                    }
                }
                "mod" => {
                    let file = self.file_of(at, word(i + 1), place.take());
                    let child = match (tokens.get(i + 2), file) {
                        (Some(TokenTree::Group(block)), _) => {
                            Some(self.add(&self.all[at].file.clone(), Some(at), block.stream()))
                        }
                        (_, Some(file)) => {
                            self.named.insert(file.clone());
                            Some(self.read(&file, Some(at)))
                        }
                        _ => None,
                    };
                    self.all[at].children.extend(child.map(|child| (words[i + 1].clone(), child)));
                    i += 3;
                }
                "use" => {
                    let end = (i..words.len()).find(|i| word(*i) == ";").unwrap_or(words.len());
                    let is_public = i > 0 && (word(i - 1) == "pub" || i > 1 && word(i - 2) == "pub");
                    self.import(at, &tokens[i + 1..end], Vec::new(), is_public);
                    i = end + 1;
                }
                item if ITEMS.contains(&item) && !ITEMS.contains(&word(i + 1)) => {
                    if is_top {
                        self.all[at].items.insert(word(i + 1).to_owned());
                    }
                    i += 2;
                }
                // A member, or a lifetime.
                "." | "'" => i += 2,
                _ => {
                    if let TokenTree::Group(group) = &tokens[i] {
                        self.scan(at, group.stream(), false);
                    }
                    let start = i;
                    i += 1;
                    if matches!(tokens[start], TokenTree::Ident(_)) {
                        while word(i) == ":"
                            && word(i + 1) == ":"
                            && matches!(tokens.get(i + 2), Some(TokenTree::Ident(_)))
                        {
                            i += 3;
                        }
                        let path: Vec<String> = words[start..i].iter().filter(|word| *word != ":").cloned().collect();
                        // A single lower-case word may be a variable. A path after `::` is of
                        // another crate.
                        let is_path = path.len() > 1 || word(i) == "(" || path[0].starts_with(char::is_uppercase);
                        if is_path && !(start > 1 && word(start - 1) == ":" && word(start - 2) == ":") {
                            self.all[at].paths.insert(path);
                        }
                    }
                }
            }
        }
    }

    /// The file of a child module.
    fn file_of(&self, at: usize, name: &str, place: Option<String>) -> Option<PathBuf> {
        let file = &self.all[at].file;
        let folder = file.parent()?;
        let own = folder.join(file.file_stem()?);
        let beside = |folder: &Path| [folder.join(format!("{name}.rs")), folder.join(name).join("mod.rs")];
        let [a, b] = [beside(&own), beside(folder)];
        let places = place.map(|place| folder.join(place)).into_iter().chain(a).chain(b);
        places.into_iter().find(|file| self.sources.contains_key(file))
    }

    fn import(&mut self, at: usize, tokens: &[TokenTree], mut path: Vec<String>, is_public: bool) {
        let mut name = None;
        for (i, token) in tokens.iter().enumerate() {
            match (token, word(token).as_str()) {
                (TokenTree::Group(group), _) => {
                    let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                    for part in inner.split(|token| word(token) == ",").filter(|part| !part.is_empty()) {
                        self.import(at, part, path.clone(), is_public);
                    }
                    return;
                }
                (_, "as") => {
                    name = tokens.get(i + 1).map(word);
                    break;
                }
                (TokenTree::Ident(_), _) | (_, "*") => path.push(word(token)),
                _ => {}
            }
        }
        let last = path.pop_if(|last| last == "self" || last == "*");
        let name = name.or(last.filter(|last| last == "*")).or(path.last().cloned());
        self.all[at].imports.push(Import { name: name.unwrap_or_default(), path, is_public });
    }

    /// The module that `path` names for the item, seen from the module `at`.
    fn named(&self, at: usize, path: &[String]) -> Option<usize> {
        let (first, rest) = path.split_first().filter(|(_, rest)| !rest.is_empty())?;
        let next = match first.as_str() {
            "crate" => successors(Some(at), |at| self.all[*at].parent).last(),
            "self" => Some(at),
            "super" => self.all[at].parent,
            _ => self.all[at].children.get(first).copied(),
        }?;
        self.named(next, rest).or(Some(next))
    }

    /// Whether `inner` is the module `outer` or inside of it.
    fn contains(&self, outer: usize, inner: usize) -> bool {
        successors(Some(inner), |at| self.all[*at].parent).any(|above| above == outer)
    }

    /// The module that defines what `path` names, seen from the module `at`. `None` for a module,
    /// and for what other crates or the language define.
    fn resolve(&self, at: usize, path: &[String], steps: usize) -> Option<usize> {
        let module = &self.all[at];
        let (first, rest) = path.split_first().filter(|_| steps < MOST_STEPS)?;
        let next = match first.as_str() {
            "crate" => successors(Some(at), |at| self.all[*at].parent).last(),
            "self" => Some(at),
            "super" => Some(module.parent?),
            _ => module.children.get(first).copied().filter(|_| !rest.is_empty()),
        };
        if let Some(next) = next {
            return self.resolve(next, rest, steps + 1);
        }
        if module.items.contains(first) {
            return Some(at);
        }
        let named = module.imports.iter().filter(|import| import.name == *first && import.path.first() != Some(first));
        // All names of a module of this crate, or of an enumeration.
        let is_here = |name: &String| {
            ["crate", "self", "super"].contains(&name.as_str())
                || module.children.contains_key(name)
                || module.items.contains(name)
        };
        let all = module.imports.iter().filter(|import| import.name == "*" && import.path.first().is_some_and(is_here));
        let found = named.map(|import| (import, rest)).chain(all.map(|import| (import, path)));
        found.into_iter().find_map(|(import, rest)| self.resolve(at, &[&import.path, rest].concat(), steps + 1))
    }
}

/// A name or mark; a group is its opening bracket.
fn word(token: &TokenTree) -> String {
    let text = token.to_string();
    match token {
        TokenTree::Group(_) => text.chars().take(1).collect(),
        _ => text.trim_start_matches("r#").to_owned(),
    }
}
