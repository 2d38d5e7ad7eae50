//! Packages that are published: what the registry and docs.rs show, what is in the package, and the
//! lowest Rust version.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use hullmap_outside::command::cargo;
use hullmap_outside::files::workspace;
use serde_json::Value;

/// Everything in the lock file, and the packages of this workspace.
fn metadata() -> &'static Value {
    static METADATA: LazyLock<Value> = LazyLock::new(|| {
        serde_json::from_slice(&cargo(["metadata", "--format-version", "1", "--locked"]).stdout).unwrap()
    });
    &METADATA
}

fn packages() -> &'static [Value] {
    metadata()["packages"].as_array().unwrap()
}

fn name(package: &Value) -> &str {
    package["name"].as_str().unwrap()
}

/// Packages of this workspace that may be published: `publish` is null, not an empty list.
fn published() -> Vec<&'static Value> {
    packages().iter().filter(|package| package["source"].is_null() && package["publish"].is_null()).collect()
}

fn folder(package: &Value) -> &Path {
    Path::new(package["manifest_path"].as_str().unwrap()).parent().unwrap()
}

fn version(text: &str) -> Vec<u32> {
    let mut numbers: Vec<u32> = text.split('.').map(|number| number.parse().unwrap()).collect();
    numbers.resize(3, 0);
    numbers
}

/// Dependencies of a package, without its tests.
fn dependencies(package: &Value) -> impl Iterator<Item = &Value> {
    package["dependencies"].as_array().unwrap().iter().filter(|dependency| dependency["kind"] != "dev")
}

#[test]
fn published_packages_say_what_they_are() {
    let published = published();
    assert!(published.len() >= 8, "{}", published.len());
    for package in published {
        let what = name(package);
        for field in ["description", "license", "readme", "documentation", "rust_version"] {
            assert!(package[field].is_string(), "{what}: no {field}");
        }
        let keywords = package["keywords"].as_array().unwrap();
        assert!((1..=5).contains(&keywords.len()), "{what}: {keywords:?}");
        assert!(keywords.iter().all(|word| word.as_str().unwrap().len() <= 20), "{what}: {keywords:?}");
        assert!((1..=5).contains(&package["categories"].as_array().unwrap().len()), "{what}");
        let is_library = package["targets"][0]["kind"] == serde_json::json!(["lib"]);
        assert_eq!(
            is_library,
            package["metadata"]["docs"]["rs"]["all-features"] == true,
            "{what}: settings of docs.rs"
        );
        let readme = fs::read_to_string(folder(package).join("README.md")).unwrap();
        let version = package["rust_version"].as_str().unwrap();
        assert!(readme.starts_with(&format!("# {what}\n")), "{what}");
        assert!(
            readme.contains(&format!("## Lowest Rust version\n\n{version}")),
            "{what}: {version} is not in its README"
        );
        for file in ["LICENSE-MIT", "LICENSE-APACHE"] {
            let own = fs::read(folder(package).join(file)).unwrap_or_else(|error| panic!("{what}: {file}: {error}"));
            assert_eq!(own, fs::read(workspace().join(file)).unwrap(), "{what}: {file}");
        }
    }
}

/// `.ci/package` packs all of them, and each after those that it depends on. A dependency in this
/// workspace has a version, or the registry would reject the package.
#[test]
fn the_script_packs_them_in_order() {
    let script = fs::read_to_string(workspace().join(".ci/package")).unwrap();
    let list = script.split("packages=(").nth(1).unwrap().split(')').next().unwrap();
    let order: Vec<&str> = list.split_whitespace().collect();
    let published: BTreeMap<&str, &Value> = published().into_iter().map(|package| (name(package), package)).collect();
    assert_eq!(order.iter().copied().collect::<BTreeSet<_>>(), published.keys().copied().collect());
    let own: BTreeSet<&str> = packages().iter().filter(|p| p["source"].is_null()).map(name).collect();
    for (at, package) in order.iter().enumerate() {
        for dependency in dependencies(published[package]).filter(|dependency| own.contains(name(dependency))) {
            let needed = name(dependency);
            assert!(order[..at].contains(&needed), "{package} needs {needed}, which is packed later or not at all");
            assert_ne!(dependency["req"], "*", "{package} needs {needed} without a version");
        }
    }
}

/// A crate needs at least the Rust version that its dependencies state. Clippy compares its code
/// with the version (`incompatible_msrv`).
#[test]
fn rust_versions_are_those_of_the_dependencies_or_newer() {
    // By name and version: the lock file has two versions of some packages.
    let stated: BTreeMap<(&str, &str), &str> = packages()
        .iter()
        .filter_map(|p| Some(((name(p), p["version"].as_str()?), p["rust_version"].as_str()?)))
        .collect();
    for package in published() {
        let (what, own) = (name(package), package["rust_version"].as_str().unwrap());
        let words = ["tree", "--locked", "--prefix", "none", "--format", "{p}", "--package", what];
        let words = words.into_iter().chain(["--edges", "normal,build", "--all-features"]);
        let tree = String::from_utf8(cargo(words).stdout).unwrap();
        let mut count = 0;
        for line in tree.lines() {
            let mut parts = line.split(' ');
            let key = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default().trim_start_matches('v'));
            if let Some(needed) = stated.get(&key) {
                count += 1;
                assert!(version(needed) <= version(own), "{what} states {own}, but {} {} needs {needed}", key.0, key.1);
            }
        }
        assert!(count > 0, "{what}: {tree}");
    }
}
