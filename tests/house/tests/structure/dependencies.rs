//! Dependencies of the project: licences, sources, and packages that must have a single version.
//! `deny.toml` has the same rules for `cargo deny`, which also checks advisories and duplicates.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::LazyLock,
};

use hullmap_outside::command::cargo;
use serde_json::Value;
use spdx::{Expression, LicenseReq};

/// Licences that everybody may use.
const LICENCES: [&str; 6] = ["MIT", "Apache-2.0", "BSD-2-Clause", "BSD-3-Clause", "Zlib", "Unicode-3.0"];

/// Packages with other permissive licences, used only by the command: they report changed files to
/// `bake build --watch`, or encrypt connections to farms.
const EXCEPTIONS: [(&str, &str); 6] = [
    ("inotify", "ISC"),
    ("inotify-sys", "ISC"),
    ("notify", "CC0-1.0"),
    ("ring", "ISC"),
    ("rustls-webpki", "ISC"),
    ("untrusted", "ISC"),
];

/// Every package of the lock file that is built on this system.
fn packages() -> &'static [Value] {
    static PACKAGES: LazyLock<Vec<Value>> = LazyLock::new(read_packages);
    &PACKAGES
}

fn read_packages() -> Vec<Value> {
    let version = String::from_utf8(cargo(["-vV"]).stdout).unwrap();
    let host = version.lines().find_map(|line| line.strip_prefix("host: ")).unwrap();
    let output = cargo(["metadata", "--format-version", "1", "--locked", "--filter-platform", host]);
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let built: BTreeSet<&str> =
        metadata["resolve"]["nodes"].as_array().unwrap().iter().map(|node| node["id"].as_str().unwrap()).collect();
    let packages = metadata["packages"].as_array().unwrap();
    let found: Vec<Value> =
        packages.iter().filter(|package| built.contains(package["id"].as_str().unwrap())).cloned().collect();
    assert!(found.len() > 100, "{}", found.len());
    found
}

fn name(package: &Value) -> &str {
    package["name"].as_str().unwrap()
}

fn is_allowed(package: &str, licence: &str) -> bool {
    let allows = |requirement: &LicenseReq| {
        let id = requirement.license.id().map(|id| id.name);
        id.is_some_and(|id| LICENCES.contains(&id) || EXCEPTIONS.contains(&(package, id)))
    };
    // `MIT/Apache-2.0` is the older notation.
    Expression::parse(&licence.replace('/', " OR ")).is_ok_and(|expression| expression.evaluate(allows))
}

#[test]
fn every_licence_is_permissive() {
    let packages = packages();
    let wrong =
        |package: &&Value| !package["license"].as_str().is_some_and(|licence| is_allowed(name(package), licence));
    let wrong: BTreeMap<&str, &Value> =
        packages.iter().filter(wrong).map(|package| (name(package), &package["license"])).collect();
    assert!(wrong.is_empty(), "of {}: {wrong:?}", packages.len());
}

#[test]
fn licence_expressions_are_parsed() {
    assert!(
        is_allowed("x", "MIT")
            && is_allowed("x", "MIT/Apache-2.0")
            && is_allowed("x", "GPL-3.0-only OR (MIT AND Zlib)")
    );
    assert!(!is_allowed("x", "GPL-3.0-only") && !is_allowed("x", "MIT AND BSL-1.0") && !is_allowed("x", "ISC"));
    assert!(is_allowed("inotify", "ISC") && !is_allowed("x", "no licence"));
}

#[test]
fn everything_comes_from_the_registry_or_this_repository() {
    for package in packages() {
        let source = package["source"].as_str();
        let sound = source.is_none_or(|source| source.starts_with("registry+"));
        assert!(sound, "{} comes from {source:?}", name(package));
        let is_ours = package["id"].as_str().unwrap().contains("path+file");
        assert_eq!(source.is_none(), is_ours, "{}", name(package));
    }
}

/// Two versions of these would be two incompatible types, or twice the code in the runtime.
#[test]
fn packages_that_share_types_have_one_version() {
    // The lock file also lists optional packages that no feature selects, `cargo tree` does not.
    let tree = cargo(["tree", "--workspace", "--locked", "--prefix", "none", "--format", "{p}"]);
    let tree = String::from_utf8(tree.stdout).unwrap();
    for one in ["glam", "rkyv", "rayon", "rayon-core", "memmap2", "twox-hash", "thiserror"] {
        let versions: BTreeSet<&str> =
            tree.lines().filter_map(|line| line.strip_prefix(one)?.strip_prefix(" v")?.split(' ').next()).collect();
        assert_eq!(versions.len(), 1, "{one}: {versions:?}");
    }
}

/// Versions below these have advisories: reads out of bounds in rkyv, undefined behaviour in
/// memmap2.
#[test]
fn versions_with_advisories_are_not_used() {
    for (package, least) in [("rkyv", [0, 8, 18]), ("memmap2", [0, 9, 12])] {
        let packages = packages();
        let found = packages.iter().find(|found| name(found) == package).unwrap()["version"].as_str().unwrap();
        let numbers: Vec<u32> = found.split('.').map(|number| number.parse().unwrap()).collect();
        assert!(numbers.as_slice() >= least.as_slice(), "{package} {found}");
    }
}
