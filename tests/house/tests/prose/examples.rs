//! Starting points of the runtime have examples, which doctests compile and run. One example for
//! each concept is enough: readers of a method have the example of its type before them.

use std::fs;

use hullmap_outside::files::workspace;

/// Files of the runtime's sources, and the items in them from which a user starts.
const STARTS: [(&str, &[&str]); 37] = [
    ("asset.rs", &["enum Asset"]),
    ("batch/mod.rs", &["fn support_points", "fn contact", "fn manifolds", "fn map"]),
    ("batch/moving_pair.rs", &["fn clear"]),
    ("compound/body_manifold/mod.rs", &["struct BodyManifold"]),
    ("compound/joined.rs", &["struct Joined"]),
    ("compound/manifolds.rs", &["struct CompoundManifolds"]),
    ("compound/members.rs", &["struct Compound"]),
    ("compound/one_sided.rs", &["struct OneSided"]),
    ("compound/seams.rs", &["fn weld"]),
    ("compound/surface.rs", &["fn surface_distance"]),
    ("continuous/rigid_motion.rs", &["struct RigidMotion"]),
    ("derivatives/lengths.rs", &["fn derivatives"]),
    ("derivatives/witness_derivatives.rs", &["fn witness_derivatives"]),
    ("geometry/mod.rs", &["trait Geometry"]),
    ("geometry/shared.rs", &["enum SharedGeometry"]),
    ("hull/arrays.rs", &["fn arrays"]),
    ("hull/mass.rs", &["fn combined", "fn mass_properties"]),
    ("hull/mod.rs", &["struct Hull"]),
    ("hull/shared.rs", &["struct SharedHull"]),
    ("hull/support_mapping.rs", &["fn support", "fn support_from"]),
    ("manifold/mod.rs", &["struct Manifold"]),
    ("pack/map.rs", &["fn map"]),
    ("pack/mass.rs", &["fn mass_properties"]),
    ("pack/mod.rs", &["struct Pack", "fn from_static"]),
    ("pose.rs", &["struct Pose", "fn relative"]),
    ("query/contact.rs", &["fn contact", "fn contacts"]),
    ("query/distance.rs", &["fn distance"]),
    ("query/intersects.rs", &["fn intersects"]),
    ("query/motion.rs", &["fn cast", "fn cast_motion", "fn clear"]),
    ("query/point.rs", &["fn ray", "fn signed_distance"]),
    ("shapes/feature.rs", &["struct Feature"]),
    ("shapes/half_space.rs", &["struct HalfSpace"]),
    ("shapes/shape.rs", &["trait Shape"]),
    ("solver/cache.rs", &["struct Cache"]),
    ("solver/minkowski.rs", &["struct Minkowski"]),
    ("solver/scratch.rs", &["struct Scratch"]),
    ("support/support_map.rs", &["trait SupportMap"]),
];

/// Whether the public item has a code block in its documentation. Expects the layout of rustfmt.
fn has_example(text: &str, item: &str) -> bool {
    let mut has_example = false;
    for line in text.lines().map(str::trim_start) {
        // In two parts, so that the test of the walls does not count this file.
        let declared = line.strip_prefix("pub ").map(|rest| rest.strip_prefix(concat!("un", "safe ")).unwrap_or(rest));
        let rest = declared.and_then(|declared| declared.strip_prefix(item));
        if has_example && rest.is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_')) {
            return true;
        }
        // An example belongs to the next item. Attributes may stand between the two.
        has_example |= line.starts_with("/// ```");
        has_example &= !line.is_empty() && (line.starts_with("//") || !line.ends_with([';', '{', '}']));
    }
    false
}

#[test]
fn starting_points_have_examples() {
    let mut missing = Vec::new();
    for (file, items) in STARTS {
        let text = fs::read_to_string(workspace().join("crates/hullmap/src").join(file)).unwrap();
        missing.extend(items.iter().filter(|item| !has_example(&text, item)).map(|item| format!("{file}: {item}")));
    }
    assert!(missing.is_empty(), "no example on:\n{}", missing.join("\n"));
    // The scan finds the example of the item alone.
    let text = "/// ```\n/// ```\n#[inline]\npub fn shown() {}\n/// Text.\npub fn show() {}\n";
    assert_eq!(["fn shown", "fn show", "fn other"].map(|item| has_example(text, item)), [true, false, false]);
}
