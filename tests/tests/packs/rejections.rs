//! The table of patches: violations of each requirement on a pack. The error states the location,
//! the value found and the value expected.

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
    slot::{Slot, encode_f64},
    version::{EXTENDED_FORMAT_VERSION, LEAN_EXTENDED_FORMAT_VERSION},
    walk::Cost,
};
use hullmap_testkit::files::workspace;
use hullmap_testkit::packs::{self, Further, point_set, reseal};
use hullmap_tests::hostile::{
    patch::{archive, changed, offset_of, open_with, payload},
    samples,
};
use regex::Regex;
use shapes::{families::Family, solids};

/// The message with which a file is rejected.
fn message(file: &[u8]) -> String {
    let error = Pack::from_bytes(file).expect_err("the file violates a requirement").to_string();
    assert!(error.ends_with("; bake the source again"), "{error}");
    error.trim_end_matches("; bake the source again").to_owned()
}

/// Whether a message is the expected one, in which `…` stands for any text.
fn matches(message: &str, expected: &str) -> bool {
    let pattern = format!("^{}$", regex::escape(expected).replace('…', ".*"));
    Regex::new(&pattern).unwrap().is_match(message)
}

/// Asserts that a file is rejected with this message.
fn assert_rejected(file: &[u8], expected: impl AsRef<str>, change: &str) {
    let found = message(file);
    assert!(matches(&found, expected.as_ref()), "{change}: {found}");
}

/// The table of patches: fields of the archive in a file, values of which each alone is set there,
/// and the message with which the file is then rejected.
macro_rules! assert_rejections {
    ($file:expr; $($field:tt = $($value:expr),+ => $expected:expr;)+) => {
        $($(assert_rejections!(@one $file, $field, $value, $expected);)+)+
    };
    (@one $file:expr, [$($field:tt)+], $value:expr, $expected:expr) => {
        let patched = changed($file, |pack| &pack.$($field)+, &$value.to_le_bytes());
        assert_rejected(&patched, $expected, stringify!($($field)+ = $value));
    };
}

/// Two hulls of these points each.
fn two(names: [&str; 2], points: &[[f32; 3]]) -> Vec<u8> {
    let sets = names.map(|name| point_set(name, points));
    packs::bytes(&sets, IndexKind::Tree, &SourceRecord::default()).unwrap()
}

#[test]
fn sections_and_spans() {
    let cube = samples::named("cube, tree");
    let pair = samples::named("two hulls, tree");
    assert_rejections! { &cube;
        [spans[0].vertex] = 1_u32 => "hull 0: its vertices start at 1 (expected 0)";
        [spans[1].face] = 5_u32 => "the faces of all hulls end at 5 (expected 6)";
        [source_path[3]] = 0xff_u8 => "section source_path is not UTF-8 from byte 3 on";
    }
    assert_rejections! { &pair; [spans[2].edge] = 70_u32 => "hull 2: its edges start at 70 (expected at least 72)"; }
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
    of_records(Vec::new());
}

#[test]
fn records() {
    let named = two(["é", "x"], &[[0.0; 3]]);
    assert_rejections! { &named; [spans[1].name] = 1_u32 => "hull 0: its name is not UTF-8 from byte 0 on"; }
    assert_rejections! { &samples::named("cube, tree");
        [hulls[0].diameter] = -1.0_f64 => "hull 0: its diameter is -1 (expected a finite number of at least 0)";
        [hulls[0].centroid[1]] = f64::NAN => "hull 0: component 1 of its centroid is NaN (expected a finite number)";
        [hulls[0].rank] = 4_u32 => "hull 0: its rank is 4 (expected 0 to 3)";
        [hulls[0].rank] = 1_u32 => "hull 0: it has 8 vertices (expected 2 for rank 1)";
        [hulls[0].inner_radius] = 5.0_f64 => "hull 0: its inner radius 5 is greater than its outer radius 0.86…";
    }
    let five = samples::named("five hulls, no index");
    assert!(open_with(&five, |pack| &pack.hulls[1].origin[1], &(-0.0_f64).to_le_bytes()).is_ok());
    assert!(open_with(&five, |pack| &pack.hulls[3].outer_error, &0.5_f64.to_le_bytes()).is_ok());
    assert_rejections! { &five;
        [hulls[3].part] = 2_u32 => "hull 3: its part is 2 (expected 0)";
        [hulls[0].part] = 1_u32 => "hull 0: its part is 1 (expected 0)";
        [hulls[3].part] = 1_u32, u32::MAX => "hull 3: its part is … (expected 0)";
        [hulls[3].part_count] = 3_u32 => "hull 3: its object has 3 parts (expected at most 2)";
        [hulls[1].solid] = 1_u32 => "hull 1: it is not a part of an object, but states a kind of solid";
        [hulls[2].origin[1]] = 1.0_f64
            => "hull 2: its origin is [0.0, 1.0, 0.0] (expected [0.0, 0.0, 0.0], the origin of the hull before it)";
        [hulls[3].outer_error] = -0.5_f64, f64::NAN, f64::INFINITY
            => "hull 3: its outer error is … (expected a finite number of at least 0)";
    }
    // Hulls 1 to 3 are the parts of one object.
    let parts = samples::named("parts, tree");
    assert!(open_with(&parts, |pack| &pack.hulls[3].protrusion, &0.5_f64.to_le_bytes()).is_ok());
    assert_rejections! { &parts;
        [hulls[2].part] = 0_u32 => "hull 2: its part is 0 (expected 1)";
        [hulls[2].part_count] = 4_u32 => "hull 2: its object has 4 parts (expected 3, as in the part before it)";
        [hulls[1].part_count] = 0_u32, 1_u32, 2_u32, 4_u32, u32::MAX => "hull …";
        [hulls[2].part_count] = 0_u32, 1_u32, 2_u32, u32::MAX => "hull …";
        [hulls[3].part_count] = 0_u32, 1_u32, 2_u32, 4_u32, u32::MAX => "hull …";
        [hulls[1].solid] = 4_u32 => "hull 1: its kind of solid is 4 (expected 0 to 3)";
        [hulls[1].solid] = 0_u32
            => "hull 1: its kind of solid states that it was not measured, but its uncovered distance or its protrusion is not 0";
        [hulls[0].solid] = 1_u32, 3_u32, 4_u32, u32::MAX => "hull …";
        [hulls[1].solid] = 1_u32, 3_u32, u32::MAX => "hull …";
        [hulls[2].solid] = 0_u32, 1_u32, 3_u32, 4_u32, u32::MAX => "hull …";
        [hulls[3].solid] = 0_u32, 1_u32, 3_u32, 4_u32, u32::MAX => "hull …";
        [hulls[3].uncovered] = 0.5_f64
            => "hull 3: its uncovered distance or its kind of solid differs from the part before it";
        [hulls[0].uncovered] = 0.5_f64 => "hull …";
        [hulls[1].uncovered] = 0.5_f64 => "hull …: its uncovered distance …";
        [hulls[2].uncovered] = 0.5_f64 => "hull …: its uncovered distance …";
        [hulls[3].protrusion] = -0.5_f64, f64::NAN, f64::INFINITY
            => "hull 3: its protrusion is … (expected a finite number of at least 0)";
    }
}

/// A solid and a polygon differ only in their edges.
#[test]
fn ranks() {
    for (name, rank) in
        [("point, tree", 0), ("segment, cube map 1", 1), ("polygon, tree", 2), ("cube, tree", 3), ("sphere, tree", 3)]
    {
        for wrong in (0..6).chain([u32::MAX]).filter(|wrong| *wrong != rank) {
            assert_rejections! { &samples::named(name); [hulls[0].rank] = wrong => "hull 0: …"; }
        }
    }
}

#[test]
fn numbers_that_are_not_finite() {
    let sphere = samples::named("sphere, tree");
    for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3_usize {
            assert_rejections! { &sphere;
                [vertices[5][axis]] = odd => format!("hull 0: vertex 5: coordinate {axis} is …");
                [hulls[0].bounds_min[axis]] = odd => "hull 0: … of its lower bounds is …";
                [hulls[0].bounds_max[axis]] = odd => "hull 0: … of its upper bounds is …";
                [outer_vertices[0][axis]] = odd => "hull 0: vertex 0 of its outer hull: …";
                [nodes[0].bounds_min[axis]] = odd => "bounding volume hierarchy: …";
            }
        }
        assert_rejections! { &sphere; [blocks[0].y[3]] = odd => "hull 0: block 0, lane 3: coordinate 1 is …"; }
    }
    for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_rejections! { &sphere;
            [hulls[0].diameter] = odd => "hull 0: …expected a finite number…";
            [hulls[0].centroid[1]] = odd => "hull 0: …expected a finite number…";
            [hulls[0].interior_point[2]] = odd => "hull 0: …expected a finite number…";
            [hulls[0].inner_radius] = odd => "hull 0: …expected a finite number…";
            [hulls[0].outer_radius] = odd => "hull 0: …expected a finite number…";
            [hulls[0].volume] = odd => "hull 0: …expected a finite number…";
            [hulls[0].surface_area] = odd => "hull 0: …expected a finite number…";
            [hulls[0].second_moments[5]] = odd => "hull 0: …expected a finite number…";
            [hulls[0].containment_error] = odd => "hull 0: …expected a finite number…";
            [hulls[0].outer_error] = odd => "hull 0: …expected a finite number…";
            [hulls[0].uncovered] = odd => "hull 0: …expected a finite number…";
            [hulls[0].protrusion] = odd => "hull 0: …expected a finite number…";
            [hulls[0].protrusion_at[2]] = odd => "hull 0: …expected a finite number…";
            [hulls[0].origin[0]] = odd => "hull 0: …expected a finite number…";
        }
        // The normal of the first plane, or the axis of the first fan.
        let fan = samples::named("prism, tree");
        let payload = payload(&fan);
        let mut slots = archive(&payload).slots.iter().map(|word| Slot::decode(word.to_native()));
        let Some(Slot::Fan(node)) = slots.find(|slot| matches!(slot, Slot::Fan(_))) else { panic!("there is a fan") };
        let high = encode_f64(odd)[1];
        assert_rejections! { &fan; [slots[node as usize + 1]] = high => "hull 0: …of the direction index is …"; }
    }
}

/// The mass of a mesh must be possible for a solid between the hulls.
#[test]
fn masses() {
    let pair = samples::named("meshes, tree");
    assert_eq!(Pack::from_bytes(&pair).unwrap().hulls().filter_map(|hull| hull.mesh_mass_properties(1.0)).count(), 3);
    assert_rejections! { &pair;
        [masses[0].volume] = 0.0_f64, -1.0_f64, f64::NAN, f64::INFINITY
            => "hull 0: the volume of its mesh is … (expected a finite number above 0)";
        [masses[0].centroid[1]] = 1.5_f64
            => "hull 0: coordinate 1 of its mesh's centre of mass is 1.5 (its hulls extend from -0.00000173…";
        [masses[1].second_moments[0]] = -1.0_f64
            => "hull 1: the second moments of its mesh are […] (expected a positive semidefinite matrix)";
        [masses[1].second_moments[1]] = f64::NAN
            => "hull 1: the second moments of its mesh are […] (expected a positive semidefinite matrix)";
        [masses[1].second_moments[5]] = 10.0_f64
            => "hull 1: the second moments of its mesh are […] (expected a positive semidefinite matrix)";
        [masses[1].second_moments[3]] = f64::INFINITY
            => "hull 1: the second moments of its mesh are […] (expected a positive semidefinite matrix)";
        [spans[1].mass] = 2_u32 => "hull 0: it has 2 mass records (expected at most 1)";
        [spans[2].mass] = 1_u32 => "hull 2: it has 1 mass records (expected at most 0)";
        [spans[3].mass] = 3_u32 => "the mass records of all hulls end at 3 (expected 2)";
    }
}

#[test]
fn vertices_and_faces() {
    let cube = samples::named("cube, tree");
    let pair = samples::named("two hulls, tree");
    assert_rejections! { &cube;
        [vertices[5][1]] = 9.0_f32 => "hull 0: vertex 5: coordinate 1 is 9 (the bounds are 0 to 1)";
        [source_vertices[3]] = 0_u32
            => "hull 0: vertex 3: source vertex 0 does not follow source vertex 2 of the vertex before it";
        [face_starts[0]] = 1_u32, u32::MAX => "hull 0: face 0: its vertices are entries …";
        [face_starts[2]] = 6_u32
            => "hull 0: face 1: its vertices are entries 4..6 of 24 (runs must be contiguous, of 3 entries or more)";
        [face_vertices[12]] = 8_u32 => "hull 0: face 3: vertex index 8 is out of range (the hull has 8 vertices)";
        [face_vertices[7]] = 8_u32, 9_u32, u32::MAX
            => "hull 0: face 1: vertex index … is out of range (the hull has 8 vertices)";
        [spans[1].face] = 5_u32, 7_u32 => "…faces…";
    }
    for face in 1..6_usize {
        let right = 4 * face as u32;
        assert_rejections! { &cube;
            [face_starts[face]] = 0_u32, right - 2, right + 2, 24_u32, 25_u32, u32::MAX
                => "hull 0: face …: its vertices are entries …";
        }
    }
    assert_rejections! { &pair;
        [spans[1].face] = 0_u32 => "hull 0: it has 0 faces and 24 face vertices (rank 3 has at least 2 faces)";
        [spans[1].face] = 5_u32
            => "hull 0: its 8 vertices, 5 faces and 24 face vertices (two per edge) violate Euler's formula";
    }
    assert_rejections! { &samples::named("prism, tree");
        [quads[0].face] = 7_u32 => "hull 0: quad 0: its face is 7 (expected 1)";
        [quads[0].corners[1]] = 0_u32 => "hull 0: quad 0: its corners are […";
        [quads[1].fall] = f32::NAN => "hull 0: quad 1: its fall is NaN (expected 0 to 1)";
    }
    let prisms = two(["a", "b"], &solids::extrusion(&solids::regular_polygon(7, 1.0), -1.0, 1.0).vertices);
    assert_rejections! { &prisms;
        [spans[1].quad] = 1_u32 => "hull 0: face 8 has more than four corners and no quad";
        [spans[1].quad] = 3_u32
            => "hull 0: quad 2: its face is 1 (expected no more faces with more than four corners)";
    }
}

/// Hints and manifolds follow the neighbours, contacts the faces beside edges.
#[test]
fn neighbours_and_edges() {
    let pair = samples::named("two hulls, tree");
    assert_rejections! { &samples::named("cube, tree");
        [neighbour_starts[3]] = 25_u32
            => "hull 0: vertex 2: its neighbours are entries 6..25 of 24 (runs must be contiguous)";
        [neighbour_starts[0]] = 1_u32 => "hull 0: vertex …: its neighbours are entries …";
        [neighbour_starts[3]] = 0_u32 => "hull 0: vertex …: its neighbours are entries …";
        [neighbour_starts[7]] = u32::MAX => "hull 0: vertex …: its neighbours are entries …";
        [hulls[0].max_neighbours] = 2_u32, 4_u32, u32::MAX
            => "hull 0: its record states at most … neighbours of a vertex (expected 3)";
        [neighbours[11]] = 8_u32, 9_u32, 12_u32, u32::MAX
            => "hull 0: neighbour 11: vertex index … is out of range (the hull has 8 vertices)";
        // Vertex 0 has the neighbours 1, 2 and 4.
        [neighbours[0]] = 2_u32, 4_u32 => "hull 0: vertex 0: its neighbours do not ascend…";
        [neighbours[1]] = 1_u32 => "hull 0: vertex 0: its neighbours do not ascend…";
        [neighbour_faces[7]] = 6_u32 => "hull 0: neighbour 7: face index 6 is out of range (the hull has 6 faces)";
        [neighbour_faces[7]] = 5_u32
            => "hull 0: face 1 and the neighbours disagree on the edge from vertex 2 to vertex 3";
        [face_vertices[1]] = 3_u32
            => "hull 0: face 0 and the neighbours disagree on the edge from vertex 0 to vertex 3";
    }
    // A cube has edges, a triangle has no edges.
    assert_rejections! { &pair;
        [spans[1].neighbour] = 23_u32 => "hull 0: its vertices have 23 neighbours (expected 24, one per face vertex)";
        [spans[1].edge] = 71_u32, 69_u32, 66_u32, 0_u32 => "hull 0: it has … edge coordinates (expected 72)";
    }
}

/// Records of voids belong to the first parts of objects whose mass is recorded.
#[test]
fn voids() {
    let mesh = shapes::concave::l();
    let letter = PointSet { triangles: mesh.fans(), ..point_set("letter", &mesh.vertices) };
    let share = VoidsShare { share: 0.25, error: 0.125 };
    let first = bake_hull(&letter, IndexKind::Tree).unwrap();
    let part = |part: u32| BakedHull { part, part_count: 2, voids: Some(share), ..first.clone() };
    let alone = BakedHull { voids: Some(share), ..first.clone() };
    let hulls = [part(0), part(1), part(0), part(1), alone];
    let file = write_pack(&hulls, &SourceRecord::default()).unwrap();
    let pack = Pack::from_bytes(&file).unwrap();
    let found: Vec<Option<f64>> = pack.hulls().map(|hull| hull.voids().map(|voids| voids.share)).collect();
    assert_eq!(found, [Some(0.25), Some(0.25), Some(0.25), Some(0.25), None]);
    assert_eq!(pack.header().format_version, EXTENDED_FORMAT_VERSION);
    let with = |record: usize, offset: usize, bytes: [u8; 4]| {
        message(&packs::with_record(&file, Further::Voids, record, offset, &bytes))
    };
    for hull in [1_u32, 3, 4, 5, u32::MAX] {
        let expected = "(expected the first part of an object whose mass is recorded, from hull 0 on)";
        assert_eq!(with(0, 0, hull.to_le_bytes()), format!("voids, record 0: its hull is {hull} {expected}"));
    }
    // Each object has one record, in their order.
    assert!(with(0, 0, 2_u32.to_le_bytes()).starts_with("voids, record 1: its hull is 2 (expected"));
    assert!(with(1, 0, 0_u32.to_le_bytes()).starts_with("voids, record 1: its hull is 0 (expected"));
    for number in [f32::NAN, -0.5, 1.5, f32::INFINITY] {
        for offset in [4, 8] {
            let changed = packs::with_record(&file, Further::Voids, 1, offset, &number.to_le_bytes());
            let expected = "voids, record 1: its share of the solid is …(expected numbers from 0 to 1)…";
            assert_rejected(&changed, expected, "a number of voids");
        }
    }
    // A pack without voids keeps its version and its bytes.
    let none = hulls.map(|baked| BakedHull { voids: None, ..baked });
    let usual = write_pack(&none, &SourceRecord::default()).unwrap();
    assert_eq!(Pack::from_bytes(&usual).unwrap().header().format_version, FORMAT_VERSION);
    let shared = usual.len() - 152;
    assert_eq!(usual[64..shared], file[64..shared]);
    let lean = write_lean_pack(vec![part(0), part(1)], &SourceRecord::default()).unwrap();
    let lean = Pack::from_bytes(&lean).unwrap();
    assert_eq!(lean.header().format_version, LEAN_EXTENDED_FORMAT_VERSION);
    assert!(lean.hull(1).unwrap().voids().is_some_and(|voids| voids.error == 0.125));
}

/// Records of primitives belong to parts that were measured, and can be placed.
#[test]
fn primitives() {
    let mesh = shapes::concave::l();
    let letter = PointSet { triangles: mesh.fans(), ..point_set("letter", &mesh.vertices) };
    let baked = bake_hull(&letter, IndexKind::Tree).unwrap();
    let fit = Fit { solid: SolidKind::Watertight, uncovered: 0.0, protrusion: 0.5, protrusion_at: [0.0; 3] };
    let kind = PrimitiveKind::Capsule;
    let primitive = Primitive {
        kind,
        center: DVec3::new(1.0, 2.0, 3.0),
        rotation: DQuat::from_rotation_x(0.5),
        sizes: [2.0, 1.0, 0.0],
    };
    let proven = ProvenPrimitive { primitive, protrusion: 0.25 };
    let part = |part: u32, primitive| BakedHull { part, part_count: 3, fit: Some(fit), primitive, ..baked.clone() };
    // Without a fit, there is no record.
    let hulls = [
        BakedHull { primitive: Some(proven), ..baked.clone() },
        part(0, Some(proven)),
        part(1, None),
        part(2, Some(proven)),
    ];
    let file = write_pack(&hulls, &SourceRecord::default()).unwrap();
    let pack = Pack::from_bytes(&file).unwrap();
    assert_eq!(pack.header().format_version, EXTENDED_FORMAT_VERSION);
    let found: Vec<_> = pack.hulls().map(|hull| hull.primitive()).collect();
    assert!(found[0].is_none() && found[2].is_none() && found[1] == found[3]);
    let read = found[1].unwrap();
    assert_eq!((read.kind, read.center, read.rotation), (kind, primitive.center, primitive.rotation));
    assert_eq!((read.sizes, read.protrusion), (primitive.sizes, 0.25));
    let with = |record: usize, offset: usize, bytes: &[u8]| {
        message(&packs::with_record(&file, Further::Primitives, record, offset, bytes))
    };
    for (record, hull, at, least) in [(0, 0_u32, 0, 0), (0, 4, 0, 0), (0, u32::MAX, 0, 0), (1, 1, 1, 2), (0, 3, 1, 4)] {
        let expected = format!("(expected a part that was measured, from hull {least} on)");
        let found = with(record, 0, &hull.to_le_bytes());
        assert_eq!(found, format!("primitives, record {at}: its hull is {hull} {expected}"));
    }
    for kind in [0_u32, 5] {
        let text = format!("primitives, record 1: its kind is {kind} (expected 1 to 4)");
        assert_eq!(with(1, 4, &kind.to_le_bytes()), text);
    }
    // A capsule has two sizes, at 64 bytes.
    let sizes = [(64, 0.0), (64, -1.0), (72, f64::NAN), (72, f64::INFINITY), (80, 1.0), (80, f64::NAN)];
    let places = [(8, f64::NAN), (24, f64::INFINITY), (32, 0.5), (56, f64::NAN), (88, -0.5), (88, f64::NAN)];
    for (changes, expected) in [
        (sizes, "primitives, record 0: its sizes are […(expected 2 positive…"),
        (places, "primitives, record 0: its centre is […a unit quaternion…"),
    ] {
        for (offset, number) in changes {
            let changed = packs::with_record(&file, Further::Primitives, 0, offset, &number.to_le_bytes());
            assert_rejected(&changed, expected, &format!("{number} at {offset}"));
        }
    }
}

/// A lean pack has a version of its own, and none of the data that it leaves out.
#[test]
fn lean_packs() {
    let lean = samples::named("lean, tree");
    let pack = Pack::from_bytes(&lean).unwrap();
    assert_eq!((pack.header().format_version, pack.hull_count()), (LEAN_FORMAT_VERSION, 3));
    let faces: Vec<usize> = pack.hulls().map(|hull| hull.face_count()).collect();
    assert_eq!(faces, [0, 6, 0]);
    assert_rejections! { &lean;
        [hulls[0].max_neighbours] = 3_u32 => "hull 0: its record states at most 3 neighbours of a vertex (expected 0)";
        [face_vertices[12]] = 8_u32 => "hull 1: face 3: vertex index 8 is out of range (the hull has 8 vertices)";
        [spans[1].face] = 1_u32 => "hull 0: it has 1 faces (a lean pack has none of a hull of 36 vertices, more than 32)";
    }
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

#[test]
fn outer_hulls_and_indices() {
    // Intersection queries read the outer vertices.
    let rocks = two(["a", "b"], &Family::Rock.points(300, 1));
    let faces = Pack::from_bytes(&rocks).unwrap().hull(0).unwrap().face_count() as u32;
    assert!(open_with(&rocks, |pack| &pack.outer_vertices[3][1], &1.0_f32.to_le_bytes()).is_ok());
    assert_rejections! { &rocks;
        [spans[1].outer] = 3_u32 => "hull 0: its outer hull has 3 vertices (expected 0, or 4 to 64)";
        [outer_vertices[2][0]] = f32::INFINITY, f32::NAN, f32::NEG_INFINITY
            => "hull 0: vertex 2 of its outer hull: coordinate 0 is … (expected a finite number)";
        [neighbour_faces[17]] = faces - 1 => "hull 0: face … and the neighbours disagree on the edge…";
        [neighbour_faces[17]] = faces, u32::MAX => "hull 0: neighbour 17: face index … is out of range…";
    }
    assert_rejections! { &samples::named("cube, tree");
        [hulls[0].index_kind] = 9_u32 => "hull 0: index kind 9 is unknown (known kinds are 0 to 3)";
        [hulls[0].leaf_blocks] = 3_u32 => "hull 0: a leaf of its index has 3 blocks (expected 1, 2 or 4)";
        [hulls[0].resolution] = 2_u32
            => "hull 0: index kind 0 has resolution 2 (a cube map, kind 1, requires at least 1; all other kinds require 0)";
        [hulls[0].max_nodes] = 7_u32
            => "hull 0: its record states a worst case of 7 nodes and 8 dot products (expected 0 and 8)";
        [blocks[0].vertex[6]] = 8_u32
            => "hull 0: block 0, lane 6: vertex index 8 is out of range (the hull has 8 vertices)";
        [blocks[0].y[6]] = -0.5_f32 => "hull 0: block 0, lane 6: coordinate 1 is -0.5 (the bounds are 0 to 1)";
    }
    // The number of a cube map's cells overflowed: with overflow checks this was a panic, without
    // them a small number.
    assert_rejections! { &samples::named("cube, cube map 2");
        [hulls[0].resolution] = u32::MAX, u32::MAX - 1, 1_u32 << 31, 0x9000_0000_u32, 0xf000_0001_u32 => "…";
    }
    assert_rejections! { &samples::named("two hulls, tree");
        [spans[1].block] = 0_u32 => "hull 0: it has no blocks (expected at least 1)";
    }
    assert_rejections! { &samples::named("sphere, tree");
        [slots[5]] = 1_u32 << 30 | 9_999
            => "hull 0: slot 5 of the direction index refers to 1 blocks from block 9999 on…";
    }
    // The worst cost of a query is recorded, and callers rely on it.
    for name in ["sphere, tree", "sphere, binary tree", "cube, cube map 2", "cube, no index", "sphere, compact"] {
        let file = samples::named(name);
        let payload = payload(&file);
        let record = &archive(&payload).hulls[0];
        let (nodes, dots) = (record.max_nodes.to_native(), record.max_dots.to_native());
        assert_rejections! { &file;
            [hulls[0].max_nodes] = nodes + 1, nodes.wrapping_sub(1), u32::MAX
                => "hull 0: its record states a worst case of …";
            [hulls[0].max_dots] = dots + 8, dots - 8, 0_u32 => "hull 0: its record states a worst case of …";
        }
    }
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

/// Queries between packs descend the tree and rely on its boxes.
#[test]
fn bounding_volume_hierarchies() {
    let five = samples::named("five hulls, no index");
    let payload = payload(&five);
    let nodes = &archive(&payload).nodes;
    assert_eq!(nodes.len(), 9);
    let leaf = nodes.iter().position(|node| node.hull_count == 1).unwrap();
    let other = nodes.iter().rposition(|node| node.hull_count == 1).unwrap();
    let (own, shared) = (nodes[other].target.to_native(), nodes[0].target.to_native());
    let low = nodes[leaf].bounds_min[0].to_native();
    assert_rejections! { &five;
        [nodes[0].target] = 0_u32 => "bounding volume hierarchy: node 0: its first child is 0 (expected 1)";
        // The node itself, a shared child, a child past the end, and one far beyond.
        [nodes[1].target] = 1_u32, shared, 8_u32, u32::MAX => "bounding volume hierarchy: …";
        [nodes[leaf].target] = own => "bounding volume hierarchy: …";
        [nodes[leaf].target] = 5_u32
            => format!("bounding volume hierarchy: node {leaf}: hull index 5 is out of range (the pack has 5 hulls)");
        [nodes[leaf].hull_count] = 2_u32 => "bounding volume hierarchy: …";
        [nodes[0].hull_count] = 6_u32 => "bounding volume hierarchy: node 0 states 6 hulls (its children have [2, 3])";
        [nodes[0].hull_count] = 1_u32
            => "bounding volume hierarchy: node 0 is the leaf of hull 1, whose record states leaf 4";
        [nodes[0].hull_count] = 0_u32 => "bounding volume hierarchy: …";
        [hulls[0].leaf] = other as u32, 9_u32 => "bounding volume hierarchy: …";
        [nodes[leaf].bounds_min[0]] = low.next_up(), low.next_down() => "bounding volume hierarchy: …";
        [nodes[0].bounds_min[0]] = f32::NAN => "bounding volume hierarchy: …";
        [nodes[0].bounds_min[0]] = 0.5_f32
            => "bounding volume hierarchy: node 0: its box is not the union of the boxes of its children";
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
