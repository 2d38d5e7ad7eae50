//! Damaged packs: each is refused, or answers every query; none makes a query panic, hang or read out of bounds.
//!
//! 1. As it is, a changed, cut or lengthened file is refused: the checksum covers every byte.
//! 2. With its checksum made right again, it stands for a file that someone made on purpose. It is refused, or it
//!    opens and then answers everything that can be asked, however wrong its numbers are.
//!
//! The checksum is computed here a second time, from what docs say of it.

use std::{
    collections::BTreeMap,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::atomic::{AtomicBool, AtomicUsize, Ordering},
    time::Duration,
};

use glam::{DQuat, DVec3, Vec3};
use hullmap::levels::{self, Levels, OuterHulls};
use hullmap::{
    Cache, Compound, CompoundCache, Feature, Hull, InvalidPack, Manifold, ManifoldSettings, Pack, Pose, Settings,
    Shape, SupportMap, compound, distance, intersects,
};
use hullmap_bake::{IndexKind, PointSet, SourceRecord};
use hullmap_format::{
    archive::{self as format, ArchivedPack, Span},
    fan,
    header::Header,
    slot::{Branch, Slot},
};
use hullmap_tests::{
    directions,
    packs::{self, point_set, reseal},
};
use rkyv::util::AlignedVec;
use shapes::{families::Family, rng::SplitMix64};

/// Bytes of the header.
const HEADER_LEN: usize = 64;

/// Seed of the changes that are drawn.
const SEED: u64 = 0xdead;

/// Changes of several words at once, drawn for each pack.
const DRAWN: usize = 4_000;

/// A pack that takes no step for so long hangs. The slowest takes milliseconds.
const HANG: Duration = Duration::from_secs(60);

/// Small packs of every rank and kind of index, with one leaf and with nodes of each kind, of one hull and of two.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let map = |resolution| IndexKind::CubeMap { resolution };
    let cube: Vec<[f32; 3]> = (0..8).map(|i| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32]).collect();
    let octagon: Vec<[f32; 3]> = Family::Prism.points(24, 0).iter().map(|p| [p[0], p[1], 0.5]).collect();
    let sample = |name: &'static str, sets: &[PointSet], index| {
        let source = SourceRecord { path: "../ä.obj".into(), hash: 7 << 90, options: "split none".into() };
        (name, packs::bytes(sets, index, &source).unwrap_or_else(|error| panic!("{name}: {error}")))
    };
    let one = |points: &[[f32; 3]]| [point_set("hüll", points)];
    vec![
        sample("point, tree", &one(&[[1.0, 2.0, 3.0]]), IndexKind::TREE),
        sample("segment, cube map 1", &one(&[[0.0; 3], [1.0, 2.0, 3.0]]), map(1)),
        sample("polygon, tree", &one(&octagon), IndexKind::TREE),
        sample("cube, no index", &one(&cube), IndexKind::None),
        sample("cube, cube map 2", &one(&cube), map(2)),
        sample("sphere, cube map 3", &one(&Family::Sphere.points(14, 1)), map(3)),
        sample("sphere, cube map 1", &one(&Family::Sphere.points(30, 2)), map(1)),
        sample("cone, binary tree", &one(&Family::Cone.points(14, 1)), IndexKind::Binary),
        sample("sphere, binary tree", &one(&Family::Sphere.points(20, 5)), IndexKind::Binary),
        sample("sphere, tree", &one(&Family::Sphere.points(36, 3)), IndexKind::TREE),
        sample("prism, tree", &one(&Family::Prism.points(80, 0)), IndexKind::TREE),
        sample("rotated prism, tree", &one(&Family::RotatedPrism.points(48, 0)), IndexKind::TREE),
        sample("sphere, compact", &one(&Family::Sphere.points(40, 4)), IndexKind::COMPACT),
        sample("five hulls, no index", &five_hulls(), IndexKind::None),
        sample("two hulls, tree", &[point_set("a", &cube), point_set("", &cube[..3])], IndexKind::TREE),
    ]
}

/// Tetrahedra far from each other, so that their tree of boxes has three levels or more.
fn five_hulls() -> Vec<PointSet> {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0_f32]];
    let at = |i: usize| corners.map(|[x, y, z]| [x + 3.0 * i as f32, y + (i % 2) as f32, z - i as f32]);
    (0..5).map(|i| point_set(["a", "b", "c", "d", "e"][i], &at(i))).collect()
}

/// Asks everything that can be asked of a pack that opened.
struct Inquiry {
    dirs: Vec<Vec3>,
    poses: Vec<Pose>,
    cube: Pack,
}

impl Inquiry {
    fn new() -> Self {
        let corners: Vec<[f32; 3]> = (0..8).map(|i| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32]).collect();
        let cube = packs::pack("cube", &corners, IndexKind::TREE);
        let mut dirs = directions::all(&cube.hull(0).unwrap(), 64, SEED);
        dirs.extend(directions::invalid().into_iter().step_by(7));
        let turned = DQuat::from_array([0.3, -0.2, 0.5, 0.7]);
        let poses = [[0.0, 0.0, 0.0], [0.6, 0.5, 0.4], [9.0, -3.0, 1.0]]
            .map(|translation| Pose::new(DVec3::from_array(translation), turned).unwrap());
        Self { dirs, poses: poses.to_vec(), cube }
    }

    fn ask(&self, pack: &Pack) {
        assert!(pack.hull_count() > 0, "an opened pack has a hull");
        assert!(pack.hull(pack.hull_count()).is_err());
        std::hint::black_box((pack.source_path(), pack.options(), pack.header(), pack.byte_len()));
        let (whole, other) = (Compound::new(pack), Compound::new(&self.cube));
        let mut cache = CompoundCache::new(2);
        for &pose in &self.poses {
            for (a, b) in [(&whole, &other), (&other, &whole), (&whole, &whole)] {
                std::hint::black_box(compound::intersects(a, b, pose, &mut cache));
                std::hint::black_box(compound::distance(a, b, pose, &Settings::default(), &mut cache));
                let deepest = compound::contact(a, b, pose, &Settings::default(), &mut cache);
                assert!(deepest.is_none_or(|found| found.hulls[0] < a.hull_count() && found.hulls[1] < b.hull_count()));
            }
        }
        let cube = self.cube.hull(0).unwrap();
        for hull in pack.hulls() {
            self.ask_hull(&hull);
            let mut cache = Cache::default();
            for &pose in &self.poses {
                ask_pair(&hull, &cube, pose, &mut cache);
                ask_pair(&cube, &hull, pose, &mut cache);
                ask_pair(&hull, &hull, pose, &mut cache);
            }
        }
    }

    fn ask_hull(&self, hull: &Hull) {
        let count = hull.vertex_count();
        assert!(count > 0 && hull.rank() <= 3 && hull.vertices().len() == count);
        assert_eq!(hull.vertex(count as u32), None);
        assert!(hull.vertices().all(|vertex| vertex.is_finite()));
        let faces: Vec<Vec<u32>> = hull.faces().map(Iterator::collect).collect();
        assert_eq!(faces.len(), hull.face_count());
        assert!(faces.iter().all(|face| face.len() >= 3 && face.iter().all(|v| (*v as usize) < count)));
        let facts = (hull.name(), hull.bounds(), hull.volume(), hull.surface_area(), hull.second_moments());
        let more = (hull.centroid(), hull.diameter(), hull.containment_error(), hull.source_point_count());
        let index = (hull.index_kind(), hull.index_byte_len(), hull.source_vertex(0), hull.source_vertex(count as u32));
        std::hint::black_box((facts, more, index));
        let most = hull.worst_cost();
        for &dir in &self.dirs {
            let got = hull.support(dir);
            assert_eq!(hull.vertex(got.index), Some(got.point), "in direction {dir}");
            let cost = hull.support_cost(dir);
            assert!(cost.nodes <= most.nodes && cost.dots <= most.dots, "{cost:?} exceeds {most:?}");
            let mut feature = Feature::new();
            hull.feature(dir.as_dvec3(), &mut feature);
            assert!(!feature.corners().is_empty() && feature.corners().iter().all(|c| (c.vertex as usize) < count));
            assert!(hull.faces_at(got.index).all(|face| (face as usize) < hull.face_count()));
            assert!(hull.face_towards(dir.as_dvec3()).is_none_or(|face| hull.face(face).len() >= 3));
            for hint in [got.index, 0, count as u32 - 1, count as u32, u32::MAX] {
                let got = hull.support_from(dir, hint);
                assert_eq!(hull.vertex(got.index), Some(got.point), "in direction {dir} from {hint}");
            }
            let got = SupportMap::support(hull, dir.as_dvec3() * 1e200);
            assert!((got.feature as usize) < count && got.point.is_finite());
        }
    }
}

fn ask_pair(a: &Hull, b: &Hull, b_in_a: Pose, cache: &mut Cache) {
    let settings = Settings::default();
    std::hint::black_box(intersects(a, b, b_in_a, cache));
    std::hint::black_box(distance(a, b, b_in_a, &settings, cache));
    // The contact among other things.
    let mut manifold = Manifold::new();
    manifold.update(a, b, b_in_a, &ManifoldSettings::default(), cache);
    assert!(manifold.points().len() <= 4);
    let levels = Levels { boxes: true, outer: OuterHulls::Always };
    std::hint::black_box(levels::intersects(a, b, b_in_a, levels, &mut Cache::new()));
}

/// How a pack's changed files ended.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    tried: usize,
    opened: usize,
    refused: usize,
}

/// Opens what `change` makes of `file` for every number below `count`, asks what opens, and counts.
///
/// # Panics
/// If one of them panics or hangs: with its number.
fn try_all(name: &str, file: &[u8], count: usize, change: impl Fn(usize, &mut Vec<u8>) + Sync) -> Tally {
    let inquiry = Inquiry::new();
    let (at, opened, done) = (AtomicUsize::new(0), AtomicUsize::new(0), AtomicBool::new(false));
    std::thread::scope(|scope| {
        let worker = scope.spawn(|| {
            let mut changed = Vec::new();
            for number in 0..count {
                at.store(number, Ordering::Relaxed);
                changed.clear();
                changed.extend_from_slice(file);
                change(number, &mut changed);
                let result = catch_unwind(AssertUnwindSafe(|| match Pack::from_bytes(&changed) {
                    Ok(pack) => {
                        inquiry.ask(&pack);
                        true
                    }
                    Err(error) => {
                        assert!(!error.to_string().is_empty());
                        false
                    }
                }));
                let Ok(has_opened) = result else { panic!("{name}: change {number} makes it panic, seed {SEED:#x}") };
                opened.fetch_add(usize::from(has_opened), Ordering::Relaxed);
            }
            done.store(true, Ordering::Relaxed);
        });
        let (mut last, mut waited) = (usize::MAX, Duration::ZERO);
        let step = Duration::from_millis(5);
        while !done.load(Ordering::Relaxed) && !worker.is_finished() {
            std::thread::sleep(step);
            waited += step;
            let now = at.load(Ordering::Relaxed);
            if now != last {
                (last, waited) = (now, Duration::ZERO);
            } else if waited > HANG {
                // The thread cannot be ended, and the scope would wait for it for ever.
                eprintln!("{name}: change {now} makes it hang, seed {SEED:#x}");
                std::process::abort();
            }
        }
    });
    let opened = opened.into_inner();
    let tally = Tally { tried: count, opened, refused: count - opened };
    println!("{name:20} {tally:?}");
    tally
}

fn flip(number: usize, file: &mut [u8]) {
    file[number / 8] ^= 1 << (number % 8);
}

#[test]
fn every_flipped_bit_is_noticed() {
    for (name, file) in samples() {
        assert!(Pack::from_bytes(&file).is_ok(), "{name}");
        let tally = try_all(name, &file, file.len() * 8, |number, changed| flip(number, changed));
        assert_eq!(tally.opened, 0, "{name}");
    }
}

#[test]
fn every_cut_or_lengthened_file_is_refused() {
    for (name, file) in samples() {
        let len = file.len();
        let tally = try_all(name, &file, len, |number, changed| changed.truncate(number));
        assert_eq!(tally.opened, 0, "{name}");
        let tally = try_all(name, &file, 3 * 70, |number, changed| {
            changed.resize(len + 1 + number / 3, [0, 0xff, b'\n'][number % 3]);
        });
        assert_eq!(tally.opened, 0, "{name}");
        // With the right checksum, and then with the right length too.
        let tally = try_all(name, &file, len, |number, changed| {
            changed.truncate(number);
            reseal(changed);
        });
        assert_eq!(tally.opened, 0, "{name}");
        let tally = try_all(name, &file, len, |number, changed| {
            changed.truncate(number);
            if number >= HEADER_LEN {
                changed[16..24].copy_from_slice(&((number - HEADER_LEN) as u64).to_le_bytes());
            }
            reseal(changed);
        });
        assert_eq!(tally.opened, 0, "{name}");
    }
}

#[test]
fn flipped_bits_under_a_right_checksum_are_refused_or_harmless() {
    let mut sum = Tally::default();
    for (name, file) in samples() {
        let mut same = file.clone();
        reseal(&mut same);
        assert_eq!(same, file, "{name}: the checksum is what docs say");
        let tally = try_all(name, &file, file.len() * 8, |number, changed| {
            flip(number, changed);
            reseal(changed);
        });
        sum = add(sum, tally);
    }
    assert_representative(sum);
}

#[test]
fn extreme_words_under_a_right_checksum_are_refused_or_harmless() {
    let mut sum = Tally::default();
    for (name, file) in samples() {
        let words = (file.len() - HEADER_LEN) / 4;
        let values = values(&file);
        let tally = try_all(name, &file, words * values.len(), |number, changed| {
            set_word(changed, number / values.len(), values[number % values.len()]);
            reseal(changed);
        });
        sum = add(sum, tally);
    }
    assert_representative(sum);
}

/// Changes that open alone, several together: the likeliest way past checks that look at one number at a time.
#[test]
fn several_drawn_changes_under_a_right_checksum_are_refused_or_harmless() {
    let mut sum = Tally::default();
    for (name, file) in samples() {
        let words = (file.len() - HEADER_LEN) / 4;
        let values = values(&file);
        let opens = |&(word, value): &(usize, u32)| {
            let mut changed = file.clone();
            set_word(&mut changed, word, value);
            reseal(&mut changed);
            changed != file && Pack::from_bytes(&changed).is_ok()
        };
        let alone: Vec<(usize, u32)> =
            (0..words).flat_map(|word| values.iter().map(move |&value| (word, value))).filter(opens).collect();
        let tally = try_all(name, &file, DRAWN, |number, changed| {
            let mut rng = SplitMix64::new(SEED ^ (number as u64) << 20);
            for _ in 0..2 + rng.below(5) {
                let (word, value) = alone[rng.below(alone.len())];
                set_word(changed, word, value);
            }
            // One in four also has something that need not open.
            if rng.below(4) == 0 {
                let at = HEADER_LEN + 4 * rng.below(words);
                let other = HEADER_LEN + 4 * rng.below(words);
                match rng.below(3) {
                    0 => flip(8 * at + rng.below(32), changed),
                    1 => changed[at..at + 4].copy_from_slice(&(rng.next_u64() as u32).to_le_bytes()),
                    _ => changed.copy_within(other..other + 4, at),
                }
            }
            reseal(changed);
        });
        sum = add(sum, tally);
    }
    assert_representative(sum);
}

fn set_word(file: &mut [u8], word: usize, value: u32) {
    file[HEADER_LEN + 4 * word..][..4].copy_from_slice(&value.to_le_bytes());
}

/// Words that go wrong most: ends of ranges, numbers that are lengths or places in this file, odd floats.
fn values(file: &[u8]) -> Vec<u32> {
    let payload = (file.len() - HEADER_LEN) as u32;
    let pack = Pack::from_bytes(file).unwrap();
    let hull = pack.hull(0).unwrap();
    let (vertices, faces) = (hull.vertex_count() as u32, hull.face_count() as u32);
    let floats = [f32::NAN, f32::INFINITY, f32::MAX, -1.0].map(f32::to_bits);
    // High words of an f64: NaN, infinity, 1e308.
    let doubles = [f64::NAN, f64::INFINITY, 1e308].map(|x| (x.to_bits() >> 32) as u32);
    let mut values = vec![0, 1, 2, 6, u32::MAX, i32::MAX as u32, 1 << 31, 1 << 30, 0xffff];
    values.extend([payload, payload / 4, payload - 1, vertices, vertices - 1, vertices + 1, faces, faces + 1]);
    values.extend(floats.into_iter().chain(doubles));
    values.sort_unstable();
    values.dedup();
    values
}

fn add(a: Tally, b: Tally) -> Tally {
    Tally { tried: a.tried + b.tried, opened: a.opened + b.opened, refused: a.refused + b.refused }
}

/// Neither side may be rare, or one of the two promises goes untried.
fn assert_representative(sum: Tally) {
    println!("{:20} {sum:?}", "all");
    assert!(sum.opened * 20 > sum.tried && sum.refused * 20 > sum.tried, "{sum:?}");
}

fn payload(file: &[u8]) -> AlignedVec<HEADER_LEN> {
    let mut payload = AlignedVec::new();
    payload.extend_from_slice(&file[HEADER_LEN..]);
    payload
}

fn archive(payload: &[u8]) -> &ArchivedPack {
    rkyv::access::<ArchivedPack, rkyv::rancor::Error>(payload).unwrap()
}

/// Without nodes of a kind, the changes above would say nothing of it.
#[test]
fn nodes_of_every_kind_are_among_the_samples() {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for (_, file) in samples() {
        let payload = payload(&file);
        let archive = archive(&payload);
        for (record, span) in archive.hulls.iter().zip(archive.spans.iter()) {
            let roots = match record.index_kind.to_native() {
                format::index_kind::TREE | format::index_kind::BINARY => 6,
                _ => 6 * record.resolution.to_native().pow(2),
            };
            let mut pending: Vec<u32> = (0..roots).collect();
            while let Some(at) = pending.pop() {
                let slot = Slot::decode(archive.slots[(span.slot.to_native() + at) as usize].to_native());
                let (name, below) = match slot {
                    Slot::Branch(at) if record.index_kind == format::index_kind::BINARY => ("halves", at..at + 2),
                    Slot::Branch(payload) => {
                        let Branch { at, bits } = Branch::decode(payload);
                        ("squares", at..at + (1 << (2 * bits)))
                    }
                    Slot::Plane(at) => ("plane", at + 6..at + 8),
                    Slot::Bundle(at) => ("bundle", at + 42..at + 50),
                    Slot::Fan(at) => {
                        let slots = at + fan::HEAD_WORDS;
                        let bits = archive.slots[(span.slot.to_native() + slots - 1) as usize].to_native();
                        ("fan", slots..slots + (1 << bits))
                    }
                    Slot::Block(_) if record.leaf_blocks > 1 => ("blocks", 0..0),
                    Slot::Block(_) => ("block", 0..0),
                    Slot::List(_) => ("list", 0..0),
                };
                *counts.entry(name).or_default() += 1;
                pending.extend(below);
            }
        }
    }
    println!("{counts:?}");
    for name in ["halves", "squares", "plane", "bundle", "fan", "block", "blocks", "list"] {
        assert!(counts.contains_key(name), "{name}");
    }
}

/// The number of a cube map's cells was computed without regard to overflow: a panic with overflow checks on, and
/// without them a small number.
#[test]
fn a_resolution_whose_cells_overflow_is_refused() {
    let (name, file) = samples().remove(4);
    assert_eq!(name, "cube, cube map 2");
    let payload = payload(&file);
    let archive = archive(&payload);
    let resolution = &archive.hulls[0].resolution;
    assert_eq!(*resolution, 2);
    let at = HEADER_LEN + std::ptr::from_ref(resolution).addr() - payload.as_ptr().addr();
    for resolution in [u32::MAX, u32::MAX - 1, 1 << 31, 0x9000_0000, 0xf000_0001] {
        let mut changed = file.clone();
        changed[at..at + 4].copy_from_slice(&resolution.to_le_bytes());
        reseal(&mut changed);
        assert!(Pack::from_bytes(&changed).is_err(), "{resolution}");
    }
}

/// Contacts follow the faces beside edges, and yes/no queries read the outer vertices.
#[test]
fn faces_and_outer_vertices_that_are_not_there_are_refused() {
    let points = Family::Rock.points(300, 1);
    let file = packs::bytes(&[point_set("rock", &points)], IndexKind::TREE, &SourceRecord::default()).unwrap();
    let payload = payload(&file);
    let archive = archive(&payload);
    assert!(archive.outer_vertices.len() > 4 && Pack::from_bytes(&file).is_ok());
    let place = |value: *const u8| HEADER_LEN + value.addr() - payload.as_ptr().addr();
    let beside = place(std::ptr::from_ref(&archive.neighbour_faces[17]).cast());
    let outer = place(std::ptr::from_ref(&archive.outer_vertices[3][1]).cast());
    let faces = archive.face_starts.len() as u32;
    for (at, word, refused) in [
        (beside, faces - 1, false),
        (beside, faces, true),
        (beside, u32::MAX, true),
        (outer, f32::NAN.to_bits(), true),
        (outer, f32::NEG_INFINITY.to_bits(), true),
        (outer, 1.0_f32.to_bits(), false),
    ] {
        let mut changed = file.clone();
        changed[at..at + 4].copy_from_slice(&word.to_le_bytes());
        reseal(&mut changed);
        let result = Pack::from_bytes(&changed);
        assert_eq!(result.is_err(), refused, "{word:#x} at {at}: {:?}", result.err());
    }
}

/// Changes one number of the archive at a time, which `place` finds, and opens the file.
fn open_with<T>(file: &[u8], place: impl Fn(&ArchivedPack) -> &T, bytes: &[u8]) -> Result<Pack, InvalidPack> {
    let payload = payload(file);
    let at = HEADER_LEN + std::ptr::from_ref(place(archive(&payload))).addr() - payload.as_ptr().addr();
    let mut changed = file.to_vec();
    changed[at..at + bytes.len()].copy_from_slice(bytes);
    reseal(&mut changed);
    Pack::from_bytes(&changed)
}

/// A hint is believed by its edges: each must be that of its vertices, to the last digit.
#[test]
fn edges_that_contradict_their_vertices_are_refused() {
    let (name, file) = samples().into_iter().find(|(name, _)| *name == "prism, tree").unwrap();
    let count = archive(&payload(&file)).edges.len();
    assert!(count > 500, "{name}");
    for number in (0..count).step_by(7) {
        let right = archive(&payload(&file)).edges[number].to_native();
        let open = |value: i16| open_with(&file, |pack| &pack.edges[number], &value.to_le_bytes());
        assert!(open(right).is_ok());
        for wrong in [right.wrapping_add(1), right.wrapping_sub(1), 0x7fff_i16.wrapping_sub(right), i16::MIN] {
            let error = open(wrong).unwrap_err().to_string();
            assert!(error.contains("an edge contradicts its vertices"), "{number}: {error}");
        }
    }
}

#[test]
fn edges_of_another_number_are_refused() {
    let (_, file) = samples().pop().unwrap();
    let end = archive(&payload(&file)).spans[1].edge.to_native();
    assert_eq!(end as usize, archive(&payload(&file)).edges.len(), "a cube's, and none of a triangle");
    for fewer in [1, 3, 6, end] {
        let error = open_with(&file, |pack| &pack.spans[1].edge, &(end - fewer).to_le_bytes()).unwrap_err().to_string();
        assert!(error.contains("hull 0: it has not three numbers for each edge"), "{error}");
    }
    let error = open_with(&file, |pack| &pack.spans[2].edge, &(end - 2).to_le_bytes()).unwrap_err().to_string();
    assert!(error.contains("edges"), "{error}");
}

/// Queries between packs walk the tree of boxes, and believe its boxes.
#[test]
fn a_tree_of_boxes_that_is_none_is_refused() {
    let (_, file) = samples().into_iter().find(|(name, _)| name.starts_with("five")).unwrap();
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
        ("no number at all", set_target(1, u32::MAX), false),
        ("two leaves of a hull", set_target(leaf, target(other)), false),
        ("a hull that is not there", set_target(leaf, 5), false),
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
        assert!(error.is_none_or(|error| error.contains("the tree of boxes over the hulls: ")), "{name}");
    }
}

#[test]
fn parts_frames_and_errors_that_contradict_each_other_are_refused() {
    let (_, file) = samples().into_iter().find(|(name, _)| name.starts_with("five")).unwrap();
    let set_part = |hull: usize, to: u32| open_with(&file, |pack| &pack.hulls[hull].part, &to.to_le_bytes());
    let set_origin = |hull: usize, to: f64| open_with(&file, |pack| &pack.hulls[hull].origin[1], &to.to_le_bytes());
    let set_error = |to: f64| open_with(&file, |pack| &pack.hulls[3].outer_error, &to.to_le_bytes());
    let set_uncovered = |to: f64| open_with(&file, |pack| &pack.hulls[3].uncovered, &to.to_le_bytes());
    assert!(set_part(0, 1).is_err() && set_part(3, 1).is_ok() && set_part(3, 2).is_err());
    assert!(set_part(3, u32::MAX).is_err());
    assert!(set_origin(2, 1.0).is_err() && set_origin(0, f64::NAN).is_err() && set_origin(1, -0.0).is_ok());
    for set in [&set_error as &dyn Fn(f64) -> _, &set_uncovered] {
        let fails = |to: f64| -> bool { Result::<Pack, InvalidPack>::is_err(&set(to)) };
        assert!(!fails(0.5) && fails(-0.5) && fails(f64::NAN) && fails(f64::INFINITY));
    }
}

/// Every section empty is consistent in itself, and promised not to open.
#[test]
fn a_pack_of_no_hulls_is_refused() {
    let empty = format::Pack { spans: vec![Span::default()], ..format::Pack::default() };
    let payload = rkyv::to_bytes::<rkyv::rancor::Error>(&empty).unwrap();
    let header = Header::for_payload(0, 0, &payload);
    let result = Pack::from_bytes(&[&header.to_bytes()[..], &payload].concat());
    assert!(matches!(result, Err(InvalidPack::Content(_))), "{result:?}");
}
