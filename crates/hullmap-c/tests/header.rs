//! The header agrees with the sources. That it is exactly what cbindgen makes of them,
//! `header --check` compares in `.ci/nightly`.

use std::{collections::BTreeSet, fs, path::Path};

fn read(path: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).expect(path)
}

fn words<'t>(text: &'t str, prefix: &str) -> BTreeSet<&'t str> {
    text.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| word.starts_with(prefix)).collect()
}

/// Lines of the header that are not comments.
fn code(header: &str) -> String {
    let lines = header.lines().map(|line| line.split("//").next().unwrap_or_default());
    lines.collect::<Vec<_>>().join("\n")
}

/// Each exported function with the number of its parameters.
fn functions(text: &str, keyword: &str) -> BTreeSet<(String, usize)> {
    let mut found = BTreeSet::new();
    for (at, _) in text.match_indices("hullmap_") {
        let (before, after) = text.split_at(at);
        let Some((name, rest)) = after.split_once('(') else { continue };
        let is_declared = before.ends_with(keyword) || keyword.is_empty() && before.ends_with([' ', '*']);
        if !is_declared || name.contains(|c: char| !c.is_alphanumeric() && c != '_') {
            continue;
        }
        let parameters = rest.split_once(')').expect("closed").0.trim().trim_end_matches(',');
        let count = if ["", "void"].contains(&parameters) { 0 } else { parameters.split(',').count() };
        found.insert((name.to_owned(), count));
    }
    found
}

#[test]
fn every_exported_function_is_in_the_header() {
    let mut exported = BTreeSet::new();
    for entry in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/exports")).unwrap() {
        let text = fs::read_to_string(entry.unwrap().path()).unwrap();
        exported.extend(functions(&text, "fn "));
    }
    let header = code(&read("include/hullmap.h"));
    assert!(exported.len() >= 40, "{exported:?}");
    assert_eq!(functions(&header, ""), exported, "run crates/hullmap-c/header");
}

#[test]
fn every_constant_is_in_the_header() {
    let (types, header) = (read("src/types/result.rs"), read("include/hullmap.h"));
    let mut count = 0;
    for line in types.lines().filter_map(|line| line.strip_prefix("pub const ")) {
        let (name, value) = line.trim_end_matches(';').split_once(": u32 = ").expect(line);
        assert!(header.contains(&format!("#define HULLMAP_{name} {value}\n")), "{name}: run crates/hullmap-c/header");
        count += 1;
    }
    assert!(count >= 4, "{count}");
}

#[test]
fn the_header_for_cpp_calls_every_function() {
    let (header, cpp) = (code(&read("include/hullmap.h")), read("include/hullmap.hpp"));
    // Versions and names are the same in both; manifolds in batches are rare.
    let left_out = [
        "hullmap_version",
        "hullmap_abi_version",
        "hullmap_format_version",
        "hullmap_result_name",
        "hullmap_batch_manifolds",
    ];
    let missing: Vec<&str> = words(&header, "hullmap_").difference(&words(&cpp, "hullmap_")).copied().collect();
    let unexpected: Vec<&&str> = missing.iter().filter(|name| !left_out.contains(name)).collect();
    assert!(unexpected.is_empty(), "{unexpected:?}");
}

#[test]
fn defaults_match_the_crate_for_rust() {
    let header = read("include/hullmap.h").replace("\\\n   ", "");
    let value = |name: &str| {
        let line = header.lines().find_map(|line| line.strip_prefix(&format!("#define {name} "))).expect(name);
        line.trim().to_owned()
    };
    let (settings, cast) = (hullmap::Settings::default(), hullmap::CastSettings::default());
    let expected = format!("{{sizeof(HullmapSettings), {:e}, {}}}", settings.tolerance, settings.max_iterations);
    assert_eq!(value("HULLMAP_SETTINGS_DEFAULT"), expected);
    assert!(cast.max_t.is_infinite());
    let expected = format!("{{sizeof(HullmapCastSettings), HUGE_VAL, {:e}, {}}}", cast.tolerance, cast.max_iterations);
    assert_eq!(value("HULLMAP_CAST_SETTINGS_DEFAULT"), expected);
    let (motion, clear) = (hullmap::MotionSettings::default(), hullmap::ClearSettings::default());
    assert_eq!((motion.target_distance, clear.motion), (0.0, motion));
    let expected = format!("{{sizeof(HullmapMotionSettings), 0.0, {:e}, {}}}", motion.tolerance, motion.max_iterations);
    assert_eq!(value("HULLMAP_MOTION_SETTINGS_DEFAULT"), expected);
    let expected = format!(
        "{{sizeof(HullmapClearSettings), 0.0, {:e}, {}, {}}}",
        motion.tolerance, clear.share, motion.max_iterations
    );
    assert_eq!(value("HULLMAP_CLEAR_SETTINGS_DEFAULT"), expected);
    let hullmap::Prediction::Relative(prediction) = hullmap::ManifoldSettings::default().prediction else {
        panic!("another kind of default");
    };
    let expected = format!(
        "{{sizeof(HullmapManifoldSettings), {:e}, {}, HULLMAP_PREDICTION_RELATIVE, {prediction}}}",
        settings.tolerance, settings.max_iterations
    );
    assert_eq!(value("HULLMAP_MANIFOLD_SETTINGS_DEFAULT"), expected);
}
