//! Packs that contradict themselves in values that are computed here: each must be rejected with
//! the right error, or be detected by `bake verify`. Single values are a table, in `rejections.rs`.

use std::collections::BTreeMap;

use hullmap::{InvalidPack, Pack};
use hullmap_bake::IndexKind;
use hullmap_format::{
    archive as format, fan,
    slot::{Branch, Slot},
};
use hullmap_outside::files::workspace;
use hullmap_testkit::packs::reseal;
use hullmap_tests::hostile::{
    patch::{archive, offset_of, open_with, payload},
    samples,
};

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

#[test]
fn packs_of_other_versions_are_rejected() {
    for version in 1..hullmap_format::FORMAT_VERSION {
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
