//! Packs that contradict themselves: each must be rejected with the right error, or be detected by
//! `bake verify`. Their checksums are correct, as in a malicious file.

use std::collections::BTreeMap;

use hullmap::{InvalidPack, Pack};
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_format::{
    archive::{self as format, Span},
    fan,
    header::Header,
    slot::{Branch, Slot, encode_f64},
};
use hullmap_outside::files::workspace;
use hullmap_testkit::packs::{self, point_set, reseal};
use hullmap_tests::hostile::{
    patch::{archive, offset_of, open_with, payload},
    samples,
};
use shapes::families::Family;

/// Asserts that a file is rejected with the expected error.
fn rejected(opened: Result<Pack, InvalidPack>, what: &str) {
    let error = opened.expect_err(what).to_string();
    assert!(error.contains(what), "{error}: expected {what}");
}

/// A slot of an index.
struct SlotInfo {
    /// Index of its word in the section.
    word: usize,
    /// First slot of its node.
    node: u32,
    slot: Slot,
    /// Name of its kind, for messages.
    name: &'static str,
}

/// All slots of all indices of a pack. The slots of a node follow the slot that refers to it. If
/// several slots share a node, its slots are listed once for each.
fn slots(file: &[u8]) -> Vec<SlotInfo> {
    let payload = payload(file);
    let archive = archive(&payload);
    let mut found = Vec::new();
    for (record, span) in archive.hulls.iter().zip(archive.spans.iter()) {
        let first = span.slot.to_native();
        let kind = IndexKind::of_record(record).unwrap();
        let is_binary = kind == IndexKind::Binary;
        let mut pending: Vec<(u32, u32)> = (0..kind.root_count() as u32).map(|at| (at, 0)).collect();
        while let Some((at, node)) = pending.pop() {
            let word = (first + at) as usize;
            let slot = Slot::decode(archive.slots[word].to_native());
            let (name, below) = match slot {
                Slot::Branch(at) if is_binary => ("halves", at..at + 2),
                Slot::Branch(payload) => {
                    let Branch { at, bits } = Branch::decode(payload);
                    ("squares", at..at + (1 << (2 * bits)))
                }
                Slot::Plane(at) => ("plane", at + 6..at + 8),
                Slot::Bundle(at) => ("bundle", at + 42..at + 50),
                Slot::Fan(at) => {
                    let slots = at + fan::HEAD_WORDS;
                    let bits = archive.slots[(first + slots - 1) as usize].to_native();
                    ("fan", slots..slots + (1 << bits))
                }
                Slot::Block(_) if record.leaf_blocks > 1 => ("blocks", 0..0),
                Slot::Block(_) => ("block", 0..0),
                Slot::List(_) => ("list", 0..0),
            };
            found.push(SlotInfo { word, node, slot, name });
            pending.extend(below.clone().map(|at| (at, below.start)));
        }
    }
    found
}

/// If a kind of node were missing, neither these changes nor the series would test it.
#[test]
fn nodes_of_every_kind_are_among_the_samples() {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for samples::Sample { file, .. } in samples::small() {
        slots(&file).iter().for_each(|slot| *counts.entry(slot.name).or_default() += 1);
    }
    println!("{counts:?}");
    for name in ["halves", "squares", "plane", "bundle", "fan", "block", "blocks", "list"] {
        assert!(counts.contains_key(name), "{name}");
    }
}

/// The number of a cube map's cells overflowed: with overflow checks this was a panic, without them
/// a small number.
#[test]
fn a_resolution_whose_cells_overflow_is_rejected() {
    let file = samples::named("cube, cube map 2");
    assert_eq!(archive(&payload(&file)).hulls[0].resolution, 2);
    for resolution in [u32::MAX, u32::MAX - 1, 1 << 31, 0x9000_0000, 0xf000_0001] {
        let opened = open_with(&file, |pack| &pack.hulls[0].resolution, &u32::to_le_bytes(resolution));
        assert!(opened.is_err(), "{resolution}");
    }
}

/// Contacts follow the faces next to edges, and intersection queries read the outer vertices.
#[test]
fn missing_faces_and_outer_vertices_are_rejected() {
    let points = Family::Rock.points(300, 1);
    let file = packs::bytes(&[point_set("rock", &points)], IndexKind::Tree, &SourceRecord::default()).unwrap();
    let payload = payload(&file);
    let archive = archive(&payload);
    assert!(archive.outer_vertices.len() > 4 && Pack::from_bytes(&file).is_ok());
    let beside = |word: u32| open_with(&file, |pack| &pack.neighbour_faces[17], &word.to_le_bytes());
    let outer = |x: f32| open_with(&file, |pack| &pack.outer_vertices[3][1], &x.to_le_bytes());
    let faces = archive.face_starts.len() as u32;
    assert!(outer(1.0).is_ok());
    for (opened, what) in [
        (beside(faces - 1), "and the neighbours disagree on the edge"),
        (beside(faces), "neighbour 17: face index"),
        (beside(u32::MAX), "neighbour 17: face index"),
        (outer(f32::NAN), "vertex 3 of its outer hull: coordinate 1 is"),
        (outer(f32::NEG_INFINITY), "vertex 3 of its outer hull: coordinate 1 is"),
    ] {
        rejected(opened, what);
    }
}

/// The face towards a direction is chosen among the faces listed at one vertex. With the face of
/// most corners listed at every vertex, each query would follow it, and be wrong.
#[test]
fn faces_beside_edges_match_the_faces() {
    let file = samples::named("prism, tree");
    let payload = payload(&file);
    let hull = archive(&payload);
    let entries = hull.neighbour_faces.len();
    let corners = |face: usize| {
        let end = hull.face_starts.get(face + 1).map_or(hull.face_vertices.len(), |start| start.to_native() as usize);
        end - hull.face_starts[face].to_native() as usize
    };
    let largest = (0..hull.face_starts.len()).max_by_key(|face| corners(*face)).unwrap() as u32;
    let mut rejections = 0;
    for entry in 0..entries {
        let is_same = hull.neighbour_faces[entry] == largest;
        let opened = open_with(&file, |pack| &pack.neighbour_faces[entry], &largest.to_le_bytes());
        assert_eq!(opened.is_ok(), is_same, "entry {entry}");
        rejections += usize::from(!is_same);
    }
    assert!(rejections > entries / 2, "{rejections} of {entries}");
    // A neighbour that the faces do not have, and two neighbours in exchange.
    let [first, second] = [0, 1].map(|entry| hull.neighbours[entry].to_native());
    assert_ne!(first, second);
    rejected(open_with(&file, |pack| &pack.neighbours[0], &second.to_le_bytes()), "its neighbours do not ascend");
    rejected(open_with(&file, |pack| &pack.neighbours[1], &first.to_le_bytes()), "its neighbours do not ascend");
}

/// Edges certify a hint, so each must agree exactly with its vertices. Queries are safe without
/// this check, so `bake verify` runs it, and opening does not.
#[test]
fn edges_that_contradict_their_vertices_are_found() {
    let file = samples::named("prism, tree");
    let count = archive(&payload(&file)).edges.len();
    assert!(count > 500, "{count}");
    for index in (0..count).step_by(7) {
        let right = archive(&payload(&file)).edges[index].to_native();
        let check = |value: i16| {
            let pack = open_with(&file, |pack| &pack.edges[index], &value.to_le_bytes()).unwrap();
            pack.check_repeats()
        };
        assert!(check(right).is_ok());
        for wrong in [right.wrapping_add(1), right.wrapping_sub(1), 0x7fff_i16.wrapping_sub(right), i16::MIN] {
            let error = check(wrong).unwrap_err().to_string();
            assert!(error.contains("the edge from vertex "), "{index}: {error}");
        }
    }
}

/// Each lane of a block repeats a vertex, and `bake verify` compares them. Opening rejects lanes
/// outside the hull's bounds, and lanes of vertices that do not exist.
#[test]
fn blocks_that_contradict_their_vertices_are_found() {
    let file = samples::named("sphere, tree");
    let (count, vertices) = (archive(&payload(&file)).blocks.len(), archive(&payload(&file)).vertices.len() as u32);
    assert!(count > 4);
    for (block, lane) in (0..count).flat_map(|block| [(block, 0), (block, 7)]) {
        let vertex = archive(&payload(&file)).blocks[block].vertex[lane].to_native();
        let open = |word: u32| open_with(&file, |pack| &pack.blocks[block].vertex[lane], &word.to_le_bytes());
        assert!(open(vertex).unwrap().check_repeats().is_ok());
        let error = open((vertex + 1) % vertices).unwrap().check_repeats().unwrap_err().to_string();
        assert!(error.contains(&format!("block {block}, lane {lane}: it has position")), "{error}");
        assert!(open(vertices).is_err() && open(u32::MAX).is_err());
        for x in [f32::NAN, f32::INFINITY, -1e9] {
            assert!(open_with(&file, |pack| &pack.blocks[block].x[lane], &x.to_le_bytes()).is_err(), "{x}");
        }
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
    assert_eq!(ways(&changed(vertex, &f32::NAN.to_le_bytes(), false)), [false, true, true], "the checksum");
    assert_eq!(ways(&changed(vertex, &f32::NAN.to_le_bytes(), true)), [false, true, true], "a coordinate");
    let span = offset_of(&file, |pack| &pack.spans[1].vertex);
    assert_eq!(ways(&changed(span, &u32::MAX.to_le_bytes(), true)), [false, false, true], "the start of a hull's run");
    let vector = file.len() - 4;
    assert_eq!(
        ways(&changed(vector, &u32::MAX.to_le_bytes(), true)),
        [false, false, false],
        "a vector outside the file"
    );
    assert_eq!(ways(&changed(8, &99_u32.to_le_bytes(), true)), [false, false, false], "the version");
    assert_eq!(ways(&file[..file.len() - 1]), [false, false, false], "the length");
    assert_eq!(ways(&[]), [false, false, false]);
    // A hull whose data is out of range is reported as missing, and not read.
    std::fs::write(&path, changed(span, &u32::MAX.to_le_bytes(), true)).unwrap();
    assert!(Pack::open_skipping_checks(&path).unwrap().hull(0).is_err());
}

#[test]
fn a_wrong_number_of_edges_is_rejected() {
    let file = samples::named("two hulls, tree");
    let end = archive(&payload(&file)).spans[1].edge.to_native();
    assert_eq!(end as usize, archive(&payload(&file)).edges.len(), "a cube has edges, a triangle has no edges");
    for fewer in [1, 3, 6, end] {
        let error = open_with(&file, |pack| &pack.spans[1].edge, &(end - fewer).to_le_bytes()).unwrap_err().to_string();
        assert!(
            error.contains(&format!("hull 0: it has {} edge coordinates (expected {end})", end - fewer)),
            "{error}"
        );
    }
    let error = open_with(&file, |pack| &pack.spans[2].edge, &(end - 2).to_le_bytes()).unwrap_err().to_string();
    assert!(error.contains("edges"), "{error}");
}

/// Queries between packs descend the BVH and rely on its boxes.
#[test]
fn an_invalid_tree_of_boxes_is_rejected() {
    let file = samples::named("five hulls, no index");
    let bytes = payload(&file);
    let nodes = &archive(&bytes).nodes;
    assert_eq!(nodes.len(), 9);
    let target = |node: usize| nodes[node].target.to_native();
    let leaf = nodes.iter().position(|node| node.hull_count == 1).unwrap();
    let other = nodes.iter().rposition(|node| node.hull_count == 1).unwrap();
    let set_target = |node: usize, to: u32| open_with(&file, |pack| &pack.nodes[node].target, &to.to_le_bytes());
    let set_count = |node: usize, to: u32| open_with(&file, |pack| &pack.nodes[node].hull_count, &to.to_le_bytes());
    let set_low = |node: usize, to: f32| open_with(&file, |pack| &pack.nodes[node].bounds_min[0], &to.to_le_bytes());
    let set_leaf = |to: usize| open_with(&file, |pack| &pack.hulls[0].leaf, &(to as u32).to_le_bytes());
    let low = nodes[leaf].bounds_min[0].to_native();
    let cases = [
        ("the same", set_target(0, target(0)), true),
        ("a cycle", set_target(0, 0), false),
        ("the node itself", set_target(1, 1), false),
        ("a shared child", set_target(1, target(0)), false),
        ("a child past the end", set_target(1, 8), false),
        ("an index out of range", set_target(1, u32::MAX), false),
        ("two leaves of a hull", set_target(leaf, target(other)), false),
        ("a hull that does not exist", set_target(leaf, 5), false),
        ("a leaf that counts two", set_count(leaf, 2), false),
        ("no hulls below", set_count(0, 0), false),
        ("an inner node as a leaf", set_count(0, 1), false),
        ("another leaf", set_leaf(other), false),
        ("no leaf", set_leaf(9), false),
        ("a box too small", set_low(leaf, low.next_up()), false),
        ("a box too large", set_low(leaf, low.next_down()), false),
        ("a root too small", set_low(0, 0.5), false),
        ("no box", set_low(0, f32::NAN), false),
    ];
    for (name, opened, is_sound) in cases {
        let error = opened.err().map(|error| error.to_string());
        println!("{name}: {error:?}");
        assert_eq!(error.is_none(), is_sound, "{name}");
        assert!(error.is_none_or(|error| error.contains("bounding volume hierarchy: ")), "{name}");
    }
}

#[test]
fn parts_frames_and_errors_that_contradict_each_other_are_rejected() {
    let file = samples::named("five hulls, no index");
    let set_part = |hull: usize, to: u32| open_with(&file, |pack| &pack.hulls[hull].part, &to.to_le_bytes());
    let set_origin = |hull: usize, to: f64| open_with(&file, |pack| &pack.hulls[hull].origin[1], &to.to_le_bytes());
    let set_error = |to: f64| open_with(&file, |pack| &pack.hulls[3].outer_error, &to.to_le_bytes());
    assert!([(0, 1), (3, 1), (3, 2), (3, u32::MAX)].iter().all(|(hull, to)| set_part(*hull, *to).is_err()));
    assert!(set_origin(2, 1.0).is_err() && set_origin(0, f64::NAN).is_err() && set_origin(1, -0.0).is_ok());
    // Hulls 1 to 3 are the parts of one object.
    let cut = samples::named("parts, tree");
    let set_protrusion = |to: f64| open_with(&cut, |pack| &pack.hulls[3].protrusion, &to.to_le_bytes());
    for set in [&set_error as &dyn Fn(f64) -> _, &set_protrusion] {
        let fails = |to: f64| -> bool { Result::<Pack, InvalidPack>::is_err(&set(to)) };
        assert!(!fails(0.5) && fails(-0.5) && fails(f64::NAN) && fails(f64::INFINITY));
    }
    let set_uncovered = |hull: usize| open_with(&cut, |pack| &pack.hulls[hull].uncovered, &0.5_f64.to_le_bytes());
    assert!((0..4).all(|hull| set_uncovered(hull).is_err()), "the parts of an object have one bound");
    let set_solid = |hull: usize, to: u32| open_with(&cut, |pack| &pack.hulls[hull].solid, &to.to_le_bytes());
    assert!(
        (0..4)
            .all(|hull| [0, 1, 3, 4, u32::MAX].iter().all(|to| *to == 0 && hull == 0 || set_solid(hull, *to).is_err()))
    );
    let set_count = |hull: usize, to: u32| open_with(&cut, |pack| &pack.hulls[hull].part_count, &to.to_le_bytes());
    assert!((1..4).all(|hull| [0, 1, 2, 4, u32::MAX].iter().all(|to| set_count(hull, *to).is_err())));
}

/// A pack with all sections empty is consistent, but must not open.
#[test]
fn a_pack_of_no_hulls_is_rejected() {
    let empty = format::Pack { spans: vec![Span::default()], ..format::Pack::default() };
    let payload = rkyv::to_bytes::<rkyv::rancor::Error>(&empty).unwrap();
    let header = Header::for_payload(0, 0, &payload);
    let result = Pack::from_bytes(&[&header.to_bytes()[..], &payload].concat());
    assert!(matches!(result, Err(InvalidPack::Content(_))), "{result:?}");
}

fn tree_words(file: &[u8]) -> Vec<u32> {
    archive(&payload(file)).slots.iter().map(|word| word.to_native()).collect()
}

fn open_with_word(file: &[u8], at: usize, word: u32) -> Result<Pack, InvalidPack> {
    open_with(file, |pack| &pack.slots[at], &word.to_le_bytes())
}

/// A walk over a cycle would never end. With shared nodes, the number of visits could double at
/// each level.
#[test]
fn index_trees_with_cycles_or_shared_nodes_are_rejected() {
    let (mut tried, mut trees) = (0, 0);
    for samples::Sample { name, file } in samples::small() {
        let is_node = |slot: Slot| !matches!(slot, Slot::Block(_) | Slot::List(_));
        let (words, slots, bytes) = (tree_words(&file), slots(&file), payload(&file));
        let nodes: Vec<&SlotInfo> = slots.iter().filter(|info| is_node(info.slot)).collect();
        if nodes.len() < 2 || archive(&bytes).hulls.len() > 1 {
            continue;
        }
        trees += 1;
        for slot in &slots {
            // Refer to a node above, below or beside; a leaf becomes another reference.
            for node in nodes.iter().step_by(nodes.len().div_ceil(24)) {
                let to = words[node.word];
                if to == words[slot.word] {
                    continue;
                }
                tried += 1;
                if open_with_word(&file, slot.word, to).is_ok() {
                    // Slots of one node may share planes.
                    let is_shared = slot.node == node.node && !matches!(node.slot, Slot::Branch(_));
                    assert!(is_shared, "{name}: word {} equals word {}", slot.word, node.word);
                }
            }
        }
        let root = nodes.iter().find(|info| info.word < 6).unwrap();
        let is_binary = IndexKind::of_record(&archive(&bytes).hulls[0]) == Ok(IndexKind::Binary);
        let own = if is_binary { Slot::Branch(0) } else { Slot::Branch(Branch { at: 0, bits: 1 }.encode()) };
        rejected(open_with_word(&file, root.word, own.encode()), "of the direction index");
    }
    println!("{tried} slots of {trees} trees were changed to refer to another node");
    assert!(tried > 2_000 && trees >= 4, "{tried} of {trees}");
}

/// The worst cost of a query is recorded, and callers rely on it.
#[test]
fn wrong_depths_and_costs_are_rejected() {
    for name in ["sphere, tree", "sphere, binary tree", "cube, cube map 2", "cube, no index", "sphere, compact"] {
        let file = samples::named(name);
        let bytes = payload(&file);
        let record = &archive(&bytes).hulls[0];
        let (nodes, dots) = (record.max_nodes.to_native(), record.max_dots.to_native());
        for wrong in [nodes + 1, nodes.wrapping_sub(1), u32::MAX] {
            let opened = open_with(&file, |pack| &pack.hulls[0].max_nodes, &wrong.to_le_bytes());
            rejected(opened, "its record states a worst case of");
        }
        for wrong in [dots + 8, dots - 8, 0] {
            let opened = open_with(&file, |pack| &pack.hulls[0].max_dots, &wrong.to_le_bytes());
            rejected(opened, "its record states a worst case of");
        }
    }
}

#[test]
fn nan_is_rejected_in_every_field() {
    let file = samples::named("sphere, tree");
    for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let odd = odd.to_le_bytes();
        for axis in 0..3 {
            rejected(
                open_with(&file, |pack| &pack.vertices[5][axis], &odd),
                &format!("vertex 5: coordinate {axis} is"),
            );
            rejected(open_with(&file, |pack| &pack.hulls[0].bounds_min[axis], &odd), "of its lower bounds is");
            rejected(open_with(&file, |pack| &pack.hulls[0].bounds_max[axis], &odd), "of its upper bounds is");
            rejected(open_with(&file, |pack| &pack.outer_vertices[0][axis], &odd), "of its outer hull");
            rejected(open_with(&file, |pack| &pack.nodes[0].bounds_min[axis], &odd), "bounding volume hierarchy");
        }
        rejected(open_with(&file, |pack| &pack.blocks[0].y[3], &odd), "block 0, lane 3: coordinate 1 is");
    }
    for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let odd = odd.to_le_bytes();
        let in_record = |field: fn(&format::ArchivedHullRecord) -> &rkyv::rend::f64_le| {
            rejected(open_with(&file, |pack| field(&pack.hulls[0]), &odd), "expected a finite number");
        };
        in_record(|r| &r.diameter);
        in_record(|r| &r.centroid[1]);
        in_record(|r| &r.interior_point[2]);
        in_record(|r| &r.inner_radius);
        in_record(|r| &r.outer_radius);
        in_record(|r| &r.volume);
        in_record(|r| &r.surface_area);
        in_record(|r| &r.second_moments[5]);
        in_record(|r| &r.containment_error);
        in_record(|r| &r.outer_error);
        in_record(|r| &r.uncovered);
        in_record(|r| &r.protrusion);
        in_record(|r| &r.protrusion_at[2]);
        in_record(|r| &r.origin[0]);
        // The normal of the first plane, or the axis of the first fan.
        let fan = samples::named("prism, tree");
        let at = tree_words(&fan).iter().position(|word| matches!(Slot::decode(*word), Slot::Fan(_))).unwrap();
        let Slot::Fan(node) = Slot::decode(tree_words(&fan)[at]) else { unreachable!("the slot is a fan") };
        let high = encode_f64(f64::from_le_bytes(odd))[1];
        rejected(open_with_word(&fan, node as usize + 1, high), "of the direction index is");
    }
}

#[test]
fn wrong_ranks_are_rejected() {
    for (name, rank) in
        [("point, tree", 0), ("segment, cube map 1", 1), ("polygon, tree", 2), ("cube, tree", 3), ("sphere, tree", 3)]
    {
        let file = samples::named(name);
        for wrong in (0..6).chain([u32::MAX]).filter(|wrong| *wrong != rank) {
            let opened = open_with(&file, |pack| &pack.hulls[0].rank, &wrong.to_le_bytes());
            // A solid and a polygon differ only in their edges.
            rejected(opened, "hull 0: ");
        }
    }
}

#[test]
fn wrong_faces_are_rejected() {
    let file = samples::named("cube, tree");
    let bytes = payload(&file);
    let (faces, count) = (archive(&bytes).face_starts.len(), archive(&bytes).vertices.len() as u32);
    let start = |face: usize, to: u32| open_with(&file, |pack| &pack.face_starts[face], &to.to_le_bytes());
    let vertex = |index: usize, to: u32| open_with(&file, |pack| &pack.face_vertices[index], &to.to_le_bytes());
    assert_eq!((faces, count), (6, 8));
    for to in [1, u32::MAX] {
        rejected(start(0, to), "face 0: its vertices are entries");
    }
    for face in 1..faces {
        let right = archive(&bytes).face_starts[face].to_native();
        for to in [0, right - 2, right + 2, 24, 25, u32::MAX] {
            rejected(start(face, to), "its vertices are entries");
        }
    }
    for to in [count, count + 1, u32::MAX] {
        rejected(vertex(7, to), &format!("face 1: vertex index {to} is out of range (the hull has 8 vertices)"));
    }
    // One face fewer: its vertices belong to the face before, and Euler's formula fails.
    let end = |to: u32| open_with(&file, |pack| &pack.spans[1].face, &to.to_le_bytes());
    rejected(end(5), "faces");
    rejected(end(7), "faces");
}

/// Hints and manifolds follow the neighbours.
#[test]
fn wrong_neighbours_are_rejected() {
    let file = samples::named("cube, tree");
    let start = |vertex: usize, to: u32| open_with(&file, |pack| &pack.neighbour_starts[vertex], &to.to_le_bytes());
    let neighbour = |index: usize, to: u32| open_with(&file, |pack| &pack.neighbours[index], &to.to_le_bytes());
    let max = |to: u32| open_with(&file, |pack| &pack.hulls[0].max_neighbours, &to.to_le_bytes());
    for opened in [start(0, 1), start(3, 0), start(3, 25), start(7, u32::MAX)] {
        rejected(opened, "its neighbours are entries");
    }
    for opened in [max(2), max(4), max(u32::MAX)] {
        rejected(opened, "neighbours of a vertex (expected 3)");
    }
    for to in [8, 9, u32::MAX] {
        rejected(neighbour(11, to), &format!("neighbour 11: vertex index {to} is out of range"));
    }
}

#[test]
fn packs_of_other_versions_are_rejected() {
    for version in 1..hullmap_format::FORMAT_VERSION {
        let file = std::fs::read(workspace().join(format!("tests/data/version-{version}.hullmap"))).unwrap();
        let error = Pack::from_bytes(&file).unwrap_err().to_string();
        let start = format!("the file has format version {version}, but this build reads versions 7 to 10; ");
        assert!(error.starts_with(&start) && error.contains("bake the source again"), "{error}");
        // The bytes are invalid in this version, even if the header states this version.
        let mut renamed = file.clone();
        renamed[8..12].copy_from_slice(&hullmap_format::FORMAT_VERSION.to_le_bytes());
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
            assert_eq!(opened.is_ok(), version == hullmap_format::FORMAT_VERSION, "version {version}");
            if let Err(error) = opened {
                let remedy = if version > hullmap_format::version::LEAN_EXTENDED_FORMAT_VERSION {
                    "update hullmap"
                } else {
                    "bake the source"
                };
                assert!(error.to_string().contains(remedy), "{error}");
                assert_eq!(ways(&other), [false; 3]);
            }
            reseal(&mut other);
        }
    }
}

/// If sections overlap, move or leave gaps, the file contains bytes that no check covers.
#[test]
fn moved_sections_are_rejected() {
    let file = samples::named("two hulls, tree");
    let root = offset_of(&file, |pack| pack);
    assert_eq!(root + size_of::<format::ArchivedPack>(), file.len());
    // A vector is an offset and a length.
    for word in 0..size_of::<format::ArchivedPack>() / 4 {
        let at = root + 4 * word;
        let old = u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
        for new in
            [0, 1, old.wrapping_add(1), old.wrapping_sub(1), old.wrapping_add(64), old.wrapping_sub(64), u32::MAX]
        {
            let mut moved = file.clone();
            moved[at..at + 4].copy_from_slice(&new.to_le_bytes());
            reseal(&mut moved);
            assert!(new == old || Pack::from_bytes(&moved).is_err(), "word {word} of the root: {old:#x} to {new:#x}");
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
