//! Every file of `assets/` through the command, and back through the runtime.

use std::{collections::BTreeMap, fs, path::Path};

use hullmap::{IndexKind, Pack};
use hullmap_bake::index::SCAN_UP_TO;
use hullmap_testkit::{command::bake, files::workspace};

/// Each asset's rank, hull vertices, and volume where it is known from the shape.
fn expected() -> BTreeMap<&'static str, (u32, usize, Option<f64>)> {
    let root5 = 5_f64.sqrt();
    let dodecahedron = (15.0 + 7.0 * root5) / 4.0 * (root5 - 1.0).powi(3);
    let polygon = |corners: f64| corners / 2.0 * (std::f64::consts::TAU / corners).sin();
    BTreeMap::from([
        ("capsule", (3, 514, None)),
        ("cone", (3, 73, Some(polygon(72.0) * 2.0 / 3.0))),
        ("cube", (3, 8, Some(8.0))),
        ("dodecahedron", (3, 20, Some(dodecahedron))),
        ("flat_sheet", (2, 4, Some(0.0))),
        // Two corners per tooth and cap. The roots and the unreferenced vertex are inside.
        ("gear", (3, 80, None)),
        ("icosahedron", (3, 12, Some(5.0 / 12.0 * (3.0 + root5) * 8.0))),
        ("lens", (3, 530, None)),
        ("octahedron", (3, 6, Some(4.0 / 3.0))),
        ("pawn", (3, 257, None)),
        ("point_cloud", (3, 84, None)),
        ("prism_500", (3, 1000, Some(polygon(500.0) * 2.0))),
        ("rock", (3, 642, None)),
        ("segment", (1, 2, Some(0.0))),
        ("single_point", (0, 1, Some(0.0))),
        ("tetrahedron", (3, 4, Some(8.0 / 3.0))),
        ("torus_knot", (3, 183, None)),
        // One corner of the octahedron lies inside: it points at the cube.
        ("two_objects", (3, 13, None)),
    ])
}

/// Each index kind, as words on the command line and as the runtime reports it.
const INDICES: [(&[&str], IndexKind); 5] = [
    (&[], IndexKind::Tree),
    (&["--set", "index=compact"], IndexKind::Compact),
    (&["--set", "index=binary"], IndexKind::Binary),
    (&["--set", "index=cubemap"], IndexKind::CubeMap { resolution: 64 }),
    (&["--set", "index=none"], IndexKind::None),
];

fn build(out: &Path, words: &[&str]) -> Vec<serde_json::Value> {
    let line = ["build", "assets", "--json", "--out", out.to_str().unwrap()];
    bake(line.iter().chain(words)).expect(0).json()
}

/// Relative path and bytes of each file in a folder.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let read = |entry: fs::DirEntry| (entry.file_name().into_string().unwrap(), fs::read(entry.path()).unwrap());
    fs::read_dir(folder).unwrap().map(|entry| read(entry.unwrap())).collect()
}

#[test]
fn every_asset_bakes_reopens_and_verifies_with_every_index() {
    let expected = expected();
    for (words, kind) in INDICES {
        let out = tempfile::tempdir().unwrap();
        let folder = out.path().to_str().unwrap();
        let built = build(out.path(), words);
        assert!(built.iter().all(|row| row["status"] == "baked" && row["error"].is_null()), "{built:?}");

        let mut seen = 0;
        for (file, bytes) in contents(out.path()) {
            let name = file.strip_suffix(".hullmap").expect("packs only");
            let (rank, vertices, volume) = *expected.get(name).unwrap_or_else(|| panic!("{name}: not expected"));
            let mapped = Pack::open(out.path().join(&file)).unwrap();
            let copied = Pack::from_bytes(&bytes).unwrap();
            for pack in [&mapped, &copied] {
                assert_eq!(pack.hull_count(), 1);
                let hull = pack.hull(0).unwrap();
                let is_scanned = kind.is_tree() && vertices <= SCAN_UP_TO;
                let kind = if is_scanned { IndexKind::None } else { kind };
                assert_eq!((hull.rank(), hull.vertex_count(), hull.index_kind()), (rank, vertices, kind), "{name}");
                assert!(hull.containment_error() <= 1e-7, "{name}");
                if let Some(volume) = volume {
                    assert!((hull.volume() - volume).abs() <= 1e-6 * volume, "{name}: volume {}", hull.volume());
                }
            }
            seen += 1;
        }
        assert_eq!((seen, built.len()), (expected.len(), expected.len()));

        let reports = bake(["verify", folder, "--source", "assets", "--json", "--set", "seed=11"]).expect(0).json();
        assert_eq!(reports.len(), expected.len());
        let mut worst: f64 = 0.0;
        for report in &reports {
            let regret = report["max_regret"].as_f64().unwrap();
            assert!(report["pass"] == true && report["against"] == "source" && regret <= 2e-7, "{report}");
            assert_eq!(report["directions"], 10_000);
            worst = worst.max(regret);
        }
        println!("{kind:?}: {seen} assets verified in 10,000 directions each, seed 11, worst regret {worst:.1e}");
    }
}

#[test]
fn bytes_depend_only_on_sources_and_options() {
    let bakes = [&[][..], &[], &["--jobs", "1"], &["--jobs", "16"]].map(|jobs| {
        let out = tempfile::tempdir().unwrap();
        build(out.path(), &[jobs, &["--split", "object"]].concat());
        (contents(out.path()), out)
    });
    let (first, _) = &bakes[0];
    assert_eq!(first.len(), expected().len());
    for (other, _) in &bakes[1..] {
        for (name, bytes) in first {
            // Without printing a whole pack.
            assert!(other.get(name) == Some(bytes), "{name} differs");
        }
        assert_eq!(other.len(), first.len());
    }
    // The bytes contain neither the output folder nor the input folder.
    let root = workspace();
    for folder in [root.as_path(), bakes[0].1.path()] {
        let needle = folder.to_str().unwrap().as_bytes();
        assert!(first.values().all(|bytes| !bytes.windows(needle.len()).any(|window| window == needle)));
    }
    // Options do change the bytes.
    let out = tempfile::tempdir().unwrap();
    build(out.path(), &["--set", "index=none", "--split", "object"]);
    assert!(contents(out.path()).iter().all(|(name, bytes)| first[name] != *bytes));
    println!("{} packs, {} bytes, four times the same", first.len(), first.values().map(Vec::len).sum::<usize>());
}
