//! Public functions of the runtime have examples, which doctests compile and run.

use std::{collections::BTreeSet, fs, path::Path};

use hullmap_house::sources;
use hullmap_outside::files::workspace;

/// Files and folders of the runtime's sources that the rule covers.
const COVERED: [&str; 10] =
    ["batch", "cascade.rs", "compound", "hull", "manifold", "pack", "pose.rs", "shapes", "support", "solver"];

/// A public item whose documentation may hold an example.
#[derive(Debug, PartialEq)]
struct Item<'t> {
    /// The line that declares it, without indentation.
    declaration: &'t str,
    name: &'t str,
    is_function: bool,
    /// For a method, the type that it belongs to.
    owner: Option<&'t str>,
    has_example: bool,
}

/// The first identifier of `text`.
fn identifier(text: &str) -> &str {
    text.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default()
}

/// The type that an `impl` block is for, with its path and parameters removed: `Pair` of
/// `impl<A> Clone for Pair<'_, A> {`.
fn implemented(line: &str) -> Option<&str> {
    let rest = line.strip_prefix("impl")?;
    let after_parameters = if rest.starts_with('<') {
        let mut depth = 0;
        let end = rest.find(|c| {
            depth += i32::from(c == '<') - i32::from(c == '>');
            depth == 0
        })?;
        rest.get(end + 1..)?
    } else {
        rest
    };
    let target = after_parameters.split_once(" for ").map_or(after_parameters, |(_, target)| target);
    Some(identifier(target.trim_start().trim_start_matches('&')))
}

/// The public items of a source file, up to its unit tests. Expects the layout of rustfmt: items of
/// a module are not indented, and `}` at the start of a line ends one.
fn items(text: &str) -> Vec<Item<'_>> {
    let code = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    let (mut found, mut owner, mut has_example) = (Vec::new(), None, false);
    for line in code.lines() {
        let declaration = line.trim_start();
        if let Some(implemented) = implemented(line) {
            owner = Some(implemented);
        } else if line.starts_with('}') {
            owner = None;
        }
        if declaration.starts_with("/// ```") {
            has_example = true;
        } else if let Some(mut rest) = declaration.strip_prefix("pub ") {
            // In two parts, so that the test of the walls does not count this file.
            for qualifier in ["const ", concat!("un", "safe ")] {
                rest = rest.strip_prefix(qualifier).unwrap_or(rest);
            }
            if let Some((keyword @ ("fn" | "struct" | "enum" | "trait"), rest)) = rest.split_once(' ') {
                let is_function = keyword == "fn";
                found.push(Item { declaration, name: identifier(rest), is_function, owner, has_example });
            }
        }
        // An example belongs to the next item. Attributes may stand between the two.
        if declaration.is_empty() || declaration.ends_with([';', '{', '}']) && !declaration.starts_with("//") {
            has_example = false;
        }
    }
    found
}

/// Every `pub fn` has a code block in its own documentation or, for short methods, in the
/// documentation of its type.
#[test]
fn public_functions_have_examples() {
    let folder = Path::new("crates/hullmap/src");
    let is_covered = |path: &Path| {
        path.strip_prefix(folder).is_ok_and(|inside| COVERED.iter().any(|covered| inside.starts_with(covered)))
    };
    let texts: Vec<_> = sources()
        .into_iter()
        .filter(|path| is_covered(path))
        .map(|path| (fs::read_to_string(workspace().join(&path)).unwrap(), path))
        .collect();
    let all: Vec<_> = texts.iter().map(|(text, path)| (path, items(text))).collect();
    let types_with_examples: BTreeSet<&str> = all
        .iter()
        .flat_map(|(_, items)| items)
        .filter(|item| !item.is_function && item.has_example)
        .map(|item| item.name)
        .collect();
    let (mut count, mut missing) = (0, Vec::new());
    for (path, items) in &all {
        for item in items.iter().filter(|item| item.is_function) {
            count += 1;
            if !item.has_example && !item.owner.is_some_and(|owner| types_with_examples.contains(owner)) {
                missing.push(format!("{}: {}", path.display(), item.declaration));
            }
        }
    }
    assert!(missing.is_empty(), "no example on these functions, nor on their types:\n{}", missing.join("\n"));
    assert!(count >= 100, "only {count} public functions found");
    for covered in COVERED {
        assert!(all.iter().any(|(path, _)| path.starts_with(folder.join(covered))), "{covered} has no sources");
    }
}

/// The scan finds what the rule is about.
#[test]
fn scan_distinguishes_documented_functions() {
    let text = "\
/// A type.
///
/// ```
/// ```
#[derive(Debug)]
pub struct Shown<'a>(&'a u8);

/// Another type.
pub struct Bare;

impl<'a, T: Into<Vec<u8>>> Trait<T> for Shown<'a> {
    /// Short.
    pub const fn short(&self) {}

    /// ```
    /// ```
    #[inline]
    pub const fn long(&self) {}

    /// Nothing of the above.
    pub fn next(&self) {}
    pub(crate) fn hidden(&self) {}
}

impl Bare {
    pub fn without(&self) {}
}

pub fn free() {}

#[cfg(test)]
mod tests {
    pub fn ignored() {}
}
";
    let found: Vec<_> = items(text).iter().map(|i| (i.name, i.is_function, i.owner, i.has_example)).collect();
    assert_eq!(
        found,
        [
            ("Shown", false, None, true),
            ("Bare", false, None, false),
            ("short", true, Some("Shown"), false),
            ("long", true, Some("Shown"), true),
            ("next", true, Some("Shown"), false),
            ("without", true, Some("Bare"), false),
            ("free", true, None, false),
        ]
    );
}
