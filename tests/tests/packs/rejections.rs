//! Violations of each requirement on a pack, of which `rejections.txt` is the table. The error
//! states the location, the value found and the value expected.

use glam::{DQuat, DVec3};
use hullmap::{Pack, PrimitiveKind};
use hullmap_bake::{
    BakedHull, Fit, IndexKind, PointSet, SolidKind, SourceRecord, bake_hull,
    fit::VoidsShare,
    index::{Index, encode::Encoded},
    primitive::{Primitive, ProvenPrimitive},
    write_lean_pack, write_pack,
};
use hullmap_format::{
    FORMAT_VERSION, LEAN_FORMAT_VERSION,
    archive::{self as format, HullRecord, LANES, Span},
    header::Header,
    repeats,
    sections::Sections,
    slot::Slot,
    version::{EXTENDED_FORMAT_VERSION, LEAN_EXTENDED_FORMAT_VERSION},
    walk::Cost,
};
use hullmap_testkit::files::workspace;
use hullmap_testkit::packs::{self, point_set, reseal};
use hullmap_tests::hostile::{
    patch::{changed, offset_of, payload},
    samples,
};
use regex::Regex;
use shapes::{families::Family, solids};

use crate::format_document::{fields, reader::File};

/// Headings of the tables in the document of the fields of records, by section.
const RECORDS: [(&str, &str); 8] = [
    ("spans", "\n### 6.1 Span\n"),
    ("hulls", "\n### 6.2 Hull record\n"),
    ("blocks", "\n### 6.3 Block\n"),
    ("nodes", "\n### 6.4 Node\n"),
    ("quads", "\n### 6.5 Quad\n"),
    ("masses", "\n### 6.6 Mass record\n"),
    ("voids", "A *voids record* states"),
    ("primitives", "A *primitive record* has"),
];

/// Offset in a file and type of a number such as `hulls[2].origin[1]`, by the document.
fn place(file: &[u8], path: &str) -> (usize, &'static str) {
    let words: Vec<&str> = path.split(['[', ']', '.']).filter(|word| !word.is_empty()).collect();
    let index = |word: &str| word.parse::<usize>().unwrap();
    let start = File::new(file).element(words[0], index(words[1]));
    let record = RECORDS.iter().find(|(section, _)| *section == words[0]);
    let (start, kind, component) = match (record, &words[2..]) {
        (Some((_, heading)), [field, component @ ..]) => {
            let (offset, _, kind, _) = fields(heading).into_iter().find(|row| row.3 == *field).expect(path);
            (start + offset, kind.split('[').next().unwrap(), component)
        }
        (_, component) => match words[0] {
            "source_path" => (start, "u8", component),
            "vertices" | "outer_vertices" => (start, "f32", component),
            _ => (start, "u32", component),
        },
    };
    let size = if kind == "f64" { 8 } else { 4 };
    (component.first().map_or(start, |word| start + size * index(word)), kind)
}

/// A number in the bytes of a file.
fn encoded(kind: &str, value: &str) -> Vec<u8> {
    match kind {
        "f64" => value.parse::<f64>().unwrap().to_le_bytes().to_vec(),
        "f32" => value.parse::<f32>().unwrap().to_le_bytes().to_vec(),
        "u32" => value.parse::<u32>().unwrap().to_le_bytes().to_vec(),
        "u8" => vec![value.parse().unwrap()],
        _ => panic!("numbers of type {kind}"),
    }
}

/// The message with which a file is rejected, or `opens`.
fn message(file: &[u8]) -> String {
    let Err(error) = Pack::from_bytes(file) else { return "opens".to_owned() };
    let error = error.to_string();
    error.strip_suffix("; bake the source again").unwrap_or_else(|| panic!("{error}")).to_owned()
}

/// Whether a message is the expected one, in which `…` stands for any text.
fn matches(message: &str, expected: &str) -> bool {
    let pattern = format!("^{}$", regex::escape(expected).replace('…', ".*"));
    Regex::new(&pattern).unwrap().is_match(message)
}

/// Two hulls of these points each.
fn two(names: [&str; 2], points: &[[f32; 3]]) -> Vec<u8> {
    let sets = names.map(|name| point_set(name, points));
    packs::bytes(&sets, IndexKind::Tree, &SourceRecord::default()).unwrap()
}

#[test]
fn every_violation_has_its_message() {
    let mut count = 0;
    for section in include_str!("rejections.txt").split("\n= ").skip(1) {
        let (name, rows) = section.split_once('\n').unwrap();
        let file = match name {
            "two prisms" => two(["a", "b"], &solids::extrusion(&solids::regular_polygon(7, 1.0), -1.0, 1.0).vertices),
            "two names" => two(["é", "x"], &[[0.0; 3]]),
            "two rocks" => two(["a", "b"], &Family::Rock.points(300, 1)),
            "voids" => write_pack(&hulls_with_voids(), &SourceRecord::default()).unwrap(),
            "primitives" => write_pack(&hulls_with_primitives(), &SourceRecord::default()).unwrap(),
            _ => samples::named(name),
        };
        for (change, expected) in rows.lines().filter_map(|row| row.split_once(" => ")) {
            let (path, values) = change.split_once(" = ").unwrap();
            let (at, kind) = place(&file, path);
            for value in values.split(", ") {
                let bytes = encoded(kind, value);
                let mut changed = file.clone();
                changed[at..at + bytes.len()].copy_from_slice(&bytes);
                reseal(&mut changed);
                let found = message(&changed);
                assert!(matches(&found, expected), "{name}: {path} = {value}: {found}");
                count += 1;
            }
        }
    }
    assert!(count > 350, "{count} violations");
}

/// The rules of sections that no single number breaks.
#[test]
fn sections() {
    // Two bytes of names leave a gap of two bytes before the spans.
    let file = packs::bytes(&[point_set("ab", &[[0.0; 3]])], IndexKind::None, &SourceRecord::default()).unwrap();
    let at = offset_of(&file, |pack| &pack.spans[0]) - 1;
    let mut filled = file.clone();
    filled[at] = 7;
    reseal(&mut filled);
    assert_eq!(message(&filled), format!("byte {} of the archive, before section spans, is not zero", at - 64));
    // A pack with all sections empty is consistent, but must not open.
    let of_records = |hulls: Vec<HullRecord>| {
        let pack = format::Pack { spans: vec![Span::default()], hulls, ..Default::default() };
        let payload = rkyv::to_bytes::<rkyv::rancor::Error>(&pack).unwrap();
        message(&[&Header::for_payload(0, 0, &payload).to_bytes()[..], &payload].concat())
    };
    assert_eq!(of_records(vec![HullRecord::default()]), "section spans has 1 elements (expected 2)");
    assert_ne!(of_records(Vec::new()), "opens");
}

/// The hull of an L that has a mass.
fn letter() -> BakedHull {
    let mesh = shapes::concave::l();
    let points = PointSet { triangles: mesh.fans(), ..point_set("letter", &mesh.vertices) };
    bake_hull(&points, IndexKind::Tree).unwrap()
}

/// Two objects of two parts each, and a hull that is not a part.
fn hulls_with_voids() -> [BakedHull; 5] {
    let voids = Some(VoidsShare { share: 0.25, error: 0.125 });
    let part = |part: u32| BakedHull { part, part_count: 2, voids, ..letter() };
    [part(0), part(1), part(0), part(1), BakedHull { voids, ..letter() }]
}

/// Records of voids belong to the first parts of objects whose mass is recorded.
#[test]
fn voids() {
    let hulls = hulls_with_voids();
    let file = write_pack(&hulls, &SourceRecord::default()).unwrap();
    let pack = Pack::from_bytes(&file).unwrap();
    let found: Vec<Option<f64>> = pack.hulls().map(|hull| hull.voids().map(|voids| voids.share)).collect();
    assert_eq!(found, [Some(0.25), Some(0.25), Some(0.25), Some(0.25), None]);
    assert_eq!(pack.header().format_version, EXTENDED_FORMAT_VERSION);
    let lean = write_lean_pack(hulls[..2].to_vec(), &SourceRecord::default()).unwrap();
    let lean = Pack::from_bytes(&lean).unwrap();
    assert_eq!(lean.header().format_version, LEAN_EXTENDED_FORMAT_VERSION);
    assert!(lean.hull(1).unwrap().voids().is_some_and(|voids| voids.error == 0.125));
    // A pack without voids keeps its version and its bytes.
    let none = hulls.map(|baked| BakedHull { voids: None, ..baked });
    let usual = write_pack(&none, &SourceRecord::default()).unwrap();
    assert_eq!(Pack::from_bytes(&usual).unwrap().header().format_version, FORMAT_VERSION);
    let shared = usual.len() - 152;
    assert_eq!(usual[64..shared], file[64..shared]);
}

/// A hull that was not measured, and three parts; all but the second part state a primitive.
fn hulls_with_primitives() -> [BakedHull; 4] {
    let (center, rotation) = (DVec3::new(1.0, 2.0, 3.0), DQuat::from_rotation_x(0.5));
    let primitive = Primitive { kind: PrimitiveKind::Capsule, center, rotation, sizes: [2.0, 1.0, 0.0] };
    let primitive = Some(ProvenPrimitive { primitive, protrusion: 0.25 });
    let fit = Fit { solid: SolidKind::Watertight, uncovered: 0.0, protrusion: 0.5, protrusion_at: [0.0; 3] };
    let part = |part: u32, primitive| BakedHull { part, part_count: 3, fit: Some(fit), primitive, ..letter() };
    [BakedHull { primitive, ..letter() }, part(0, primitive), part(1, None), part(2, primitive)]
}

/// `format_document.rs` reads all numbers of a record.
#[test]
fn only_parts_that_were_measured_have_a_record_of_a_primitive() {
    let file = write_pack(&hulls_with_primitives(), &SourceRecord::default()).unwrap();
    let pack = Pack::from_bytes(&file).unwrap();
    assert_eq!(pack.header().format_version, EXTENDED_FORMAT_VERSION);
    assert!(pack.hulls().map(|hull| hull.primitive().is_some()).eq([false, true, false, true]));
}

/// A lean pack has a version of its own, and none of the data that it leaves out.
#[test]
fn lean_packs() {
    let lean = samples::named("lean, tree");
    let pack = Pack::from_bytes(&lean).unwrap();
    assert_eq!((pack.header().format_version, pack.hull_count()), (LEAN_FORMAT_VERSION, 3));
    let faces: Vec<usize> = pack.hulls().map(|hull| hull.face_count()).collect();
    assert_eq!(faces, [0, 6, 0]);
    let of_version = |file: &[u8], version: u32| {
        let mut file = file.to_vec();
        file[8..12].copy_from_slice(&version.to_le_bytes());
        reseal(&mut file);
        message(&file)
    };
    assert_eq!(
        of_version(&lean, LEAN_EXTENDED_FORMAT_VERSION),
        "section voids and primitives has 0 elements (expected 1)"
    );
    assert_eq!(of_version(&lean, FORMAT_VERSION), "section neighbour_starts has 0 elements (expected 46)");
    let cube = samples::named("cube, tree");
    assert_eq!(of_version(&cube, LEAN_FORMAT_VERSION), "section neighbour_starts has 8 elements (expected 0)");
}

/// A small hull whose leaves repeat its vertices would make queries as slow as the file is long.
#[test]
fn leaves_have_at_most_as_many_candidates_as_the_hull_has_vertices() {
    let cube = bake_hull(&point_set("cube", &packs::cube()), IndexKind::None).unwrap();
    let block = cube.index.encoded.blocks[0];
    let repeating = |kind: IndexKind, count: u32| {
        let blocks = vec![block; count as usize];
        let slots = match kind {
            IndexKind::None => Vec::new(),
            _ => [[Slot::List(6).encode(); 6].as_slice(), &[0, count]].concat(),
        };
        let cost = Cost { nodes: 0, dots: LANES as u32 * count };
        let index = Index { kind, cost, encoded: Encoded { slots, blocks }, replaces: None };
        write_pack(&[BakedHull { index, ..cube.clone() }], &SourceRecord::default()).unwrap()
    };
    // A plain leaf of a compact tree has four blocks, however few the vertices.
    for (kind, most) in [(IndexKind::None, 1), (IndexKind::Tree, 1), (IndexKind::Medium, 2), (IndexKind::Compact, 4)] {
        assert!(Pack::from_bytes(&repeating(kind, most)).is_ok(), "{kind}");
        assert_eq!(
            message(&repeating(kind, most + 1)),
            format!(
                "hull 0: a leaf of its index has {} candidates (a hull of 8 vertices has at most {})",
                8 * (most + 1),
                8 * most
            )
        );
    }
}

/// Only `bake verify` compares redundant values.
#[test]
fn redundant_values_that_differ() {
    let (cube, prism) = (samples::named("cube, tree"), samples::named("prism, tree"));
    let corners = [0_u32, 1, 2, 3].map(u32::to_le_bytes).concat();
    for (name, file, expected) in [
        (
            "position",
            changed(&cube, |pack| &pack.blocks[0].x[1], &0.5_f32.to_le_bytes()),
            "hull 0: block 0, lane 1: it has position [0.5, 0.0, 0.0] (expected [1.0, 0.0, 0.0]…",
        ),
        (
            "edge",
            changed(&cube, |pack| &pack.edges[0], &5_i16.to_le_bytes()),
            "hull 0: the edge from vertex 0 to vertex 1 is [5, 0, 0] (expected [32767, 0, 0]…",
        ),
        (
            "fall",
            changed(&prism, |pack| &pack.quads[0].fall, &0.5_f32.to_le_bytes()),
            "hull 0: quad 0: its fall is 0.5 (expected 1, from the edges that leave its face); bake the source again",
        ),
        (
            "corners",
            changed(&prism, |pack| &pack.quads[0].corners[0], &corners),
            "hull 0: quad 0: it has … of the area of its face…",
        ),
        (
            "unchecked",
            changed(&cube, |pack| &pack.neighbours[0], &u32::MAX.to_le_bytes()),
            "hull 0: its neighbours are out of range…",
        ),
    ] {
        let payload = payload(&file);
        let found = repeats::repeats(&Sections::read(&payload).unwrap()).unwrap_err().to_string();
        assert!(matches(&found, expected), "{name}: {found}");
    }
}

/// The checks of each way to open, on files with one kind of damage each.
#[test]
fn each_way_to_open_skips_the_checks_in_its_name() {
    let file = samples::named("two hulls, tree");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.hullmap");
    assert_eq!(ways(&file), [true, true, true]);
    let changed = |at: usize, bytes: &[u8], sealed: bool| {
        let mut changed = file.clone();
        changed[at..at + bytes.len()].copy_from_slice(bytes);
        if sealed {
            reseal(&mut changed);
        }
        changed
    };
    let vertex = offset_of(&file, |pack| &pack.vertices[0]);
    let span = offset_of(&file, |pack| &pack.spans[1].vertex);
    let (nan, greatest) = (f32::NAN.to_le_bytes(), u32::MAX.to_le_bytes());
    for (damage, file, expected) in [
        ("the checksum", changed(vertex, &nan, false), [false, true, true]),
        ("a coordinate", changed(vertex, &nan, true), [false, true, true]),
        ("the start of a hull's run", changed(span, &greatest, true), [false, false, true]),
        ("a vector outside the file", changed(file.len() - 4, &greatest, true), [false; 3]),
        ("the version", changed(8, &99_u32.to_le_bytes(), true), [false; 3]),
        ("the length", file[..file.len() - 1].to_vec(), [false; 3]),
        ("nothing left", Vec::new(), [false; 3]),
    ] {
        assert_eq!(ways(&file), expected, "{damage}");
    }
    // A hull whose data is out of range is reported as missing, and not read.
    std::fs::write(&path, changed(span, &u32::MAX.to_le_bytes(), true)).unwrap();
    assert!(Pack::open_skipping_checks(&path).unwrap().hull(0).is_err());
}

#[test]
fn packs_of_other_versions_are_rejected() {
    for version in 1..FORMAT_VERSION {
        let file = std::fs::read(workspace().join(format!("tests/data/version-{version}.hullmap"))).unwrap();
        let error = Pack::from_bytes(&file).unwrap_err().to_string();
        assert_eq!(
            u64::from_le_bytes(file[16..24].try_into().unwrap()),
            file.len() as u64 - 64,
            "the file is complete"
        );
        let mut sealed = file.clone();
        reseal(&mut sealed);
        assert_eq!(sealed, file, "the checksum is correct");
        let start = format!("the file has format version {version}, but this build reads versions 7 to 10; ");
        assert!(error.starts_with(&start) && error.contains("bake the source again"), "{error}");
        // The bytes are invalid in this version, even if the header states this version.
        let mut renamed = file.clone();
        renamed[8..12].copy_from_slice(&FORMAT_VERSION.to_le_bytes());
        reseal(&mut renamed);
        assert!(Pack::from_bytes(&renamed).is_err(), "version {version} with the current version number");
        assert!(ways(&renamed).iter().all(|opened| !opened), "version {version} with the current version number");
    }
    let file = samples::named("cube, tree");
    for version in (0..64).chain([u32::MAX, 1 << 31, 0x0300_0000]) {
        let mut other = file.clone();
        other[8..12].copy_from_slice(&version.to_le_bytes());
        for _ in 0..2 {
            let opened = Pack::from_bytes(&other);
            assert_eq!(opened.is_ok(), version == FORMAT_VERSION, "version {version}");
            if let Err(error) = opened {
                let remedy = if version > LEAN_EXTENDED_FORMAT_VERSION { "update hullmap" } else { "bake the source" };
                assert!(error.to_string().contains(remedy), "{error}");
                assert_eq!(ways(&other), [false; 3]);
            }
            reseal(&mut other);
        }
    }
}

/// Whether a file opens by each of the ways to open.
fn ways(bytes: &[u8]) -> [bool; 3] {
    let folder = tempfile::tempdir().unwrap();
    let path = &folder.path().join("x.hullmap");
    std::fs::write(path, bytes).unwrap();
    [Pack::open(path), Pack::open_skipping_contents(path), Pack::open_skipping_checks(path)].map(|way| way.is_ok())
}
