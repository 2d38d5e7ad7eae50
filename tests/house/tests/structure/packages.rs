//! Packages that are published: what the registry and docs.rs show, and what is in the package.
//! `.ci/msrv` compiles them with the Rust versions that they state.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use hullmap_testkit::command::cargo;
use hullmap_testkit::files::workspace;
use serde_json::Value;

fn packages() -> &'static [Value] {
    static METADATA: LazyLock<Value> = LazyLock::new(|| {
        serde_json::from_slice(&cargo(["metadata", "--format-version", "1", "--locked", "--no-deps"]).stdout).unwrap()
    });
    METADATA["packages"].as_array().unwrap()
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
        for file in ["LICENSE-MIT", "LICENSE-APACHE", "CITATION.cff", "SECURITY.md"] {
            let own = fs::read(folder(package).join(file)).unwrap_or_else(|error| panic!("{what}: {file}: {error}"));
            assert_eq!(own, fs::read(workspace().join(file)).unwrap(), "{what}: {file}");
        }
    }
}

/// `.ci/package` packs all of them. cargo puts them in order, and rejects dependencies without a
/// version.
#[test]
fn the_script_packs_them() {
    let script = fs::read_to_string(workspace().join(".ci/package")).unwrap();
    let list = script.split("packages=(").nth(1).unwrap().split(')').next().unwrap();
    let packed: BTreeSet<&str> = list.split_whitespace().collect();
    assert_eq!(packed, published().into_iter().map(name).collect());
}
