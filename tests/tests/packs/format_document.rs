//! `docs/contributors/FORMAT.md` agrees with the bytes of packs. Its tables are the layout of the
//! records, a look-up written from the document alone agrees with `hullmap::Pack` on packs of all
//! shapes, and the file that the document lists is the one that is baked today.

pub mod reader;

use std::{collections::BTreeMap, hash::Hasher, mem::offset_of, path::Path};

use glam::{DQuat, DVec3};
use hullmap::{IndexKind as Kind, Pack, PrimitiveKind, SolidKind, SupportMap};
use hullmap_bake::fit::VoidsShare;
use hullmap_bake::primitive::{Primitive, ProvenPrimitive};
use hullmap_bake::{BakedHull, Fit, IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
use hullmap_format::{
    archive::{
        ArchivedBlock, ArchivedBvhNode, ArchivedHullRecord, ArchivedMassRecord, ArchivedPrimitiveRecord, ArchivedQuad,
        ArchivedSpan, ArchivedVoidsRecord,
    },
    header::HEADER_LEN,
    sections::Sections,
};
use hullmap_import::{ImportOptions, Limits, SourceFile, import};
use hullmap_testkit::random::RandomPoses;
use hullmap_tests::{directions, hostile::patch::payload};
use reader::File;
use shapes::{families::Family, rng::SplitMix64};
use twox_hash::{XxHash3_64, XxHash3_128};

const DOCUMENT: &str = include_str!("../../../docs/contributors/FORMAT.md");
/// The bytes of a pack, listed with their meaning.
const LISTING: &str = include_str!("../../../docs/contributors/tetrahedron.txt");
const TETRAHEDRON: &str = include_str!("../../../assets/tetrahedron.obj");

const SEED: u64 = 0xf0_0d_0c;

/// Origin of the hulls' frame in the source's frame.
const ORIGIN: [f64; 3] = [1e6, -0.1, 3.0];

/// Source vertex of a point that is not in the source, by the document.
const NO_SOURCE_VERTEX: u32 = 0xffff_ffff;

/// Counts over all packs of a test, which show that every kind of slot is tested.
#[derive(Default, Debug)]
struct Met {
    /// The kinds of [`reader::Leaf`].
    kinds: u8,
    padded: usize,
    directions: usize,
    /// Numbers of directions whose support vertex its edges certify, and of all others.
    certain: usize,
    uncertain: usize,
}

fn points(name: &str, positions: Vec<[f32; 3]>) -> PointSet {
    // Source vertices differ from indices in the set, as in a file of several objects, and some
    // points are not in the source.
    let source_vertex = |i| if i % 7 == 6 { NO_SOURCE_VERTEX } else { 3 * i + 5 };
    let source_vertices = (0..positions.len() as u32).map(source_vertex).collect();
    PointSet { name: name.to_owned(), positions, source_vertices, origin: ORIGIN, ..PointSet::default() }
}

fn bake(points: &PointSet, index: IndexKind) -> BakedHull {
    bake_hull(points, index).unwrap_or_else(|e| panic!("{}: {e}", points.name))
}

fn source(path: &str, options: &str) -> SourceRecord {
    let hash = XxHash3_128::oneshot(path.as_bytes());
    SourceRecord { path: path.to_owned(), hash, options: options.to_owned(), ..SourceRecord::default() }
}

/// Writes hulls into one pack and compares all of its contents.
fn compare(hulls: &[BakedHull], source: &SourceRecord, count: usize, met: &mut Met) {
    let bytes = write_pack(hulls, source).unwrap();
    let (file, payload) = (File::new(&bytes), payload(&bytes));
    let pack = Pack::from_bytes(&bytes).unwrap();
    met.padded += usize::from(file.check_layout() > 0);
    hashes(&bytes, &file, source);
    let text = |section| std::str::from_utf8(file.section(section)).unwrap();
    assert_eq!(text("source_path"), pack.source_path());
    assert_eq!(text("options"), pack.options());
    assert_eq!(text("names"), hulls.iter().map(|h| h.name.as_str()).collect::<String>());
    let stored = Sections::read(&payload).unwrap();
    let mut sections = file.sections.iter().chain(&file.further);
    macro_rules! assert_sections {
        ($($field:ident)+) => {
            $({
                let start = HEADER_LEN + stored.$field.as_ptr().addr() - payload.as_ptr().addr();
                assert_eq!(sections.next(), Some(&(start..start + size_of_val(&stored.$field[..]))), stringify!($field));
            })+
        };
    }
    assert_sections! {
        blocks source_path options names spans hulls masses nodes vertices source_vertices face_starts face_vertices quads
        neighbour_starts neighbours neighbour_faces outer_vertices slots edges
    }
    if !file.further.is_empty() {
        assert_sections! { voids primitives }
    }
    assert_eq!((sections.next(), pack.hull_count(), stored.spans.len()), (None, hulls.len(), hulls.len() + 1));
    for (index, baked) in hulls.iter().enumerate() {
        let (ours, theirs) = (reader::Hull::new(&stored, index), pack.hull(index).unwrap());
        facts(&theirs, baked);
        shape(&ours, &theirs, baked);
        direction_index(&ours, &theirs, baked);
        support(&ours, &theirs, count, met);
    }
}

fn hashes(bytes: &[u8], file: &File, source: &SourceRecord) {
    let of = |at: usize| reader::number(bytes, at, 8);
    assert_eq!(u128::from(of(24)) | u128::from(of(32)) << 64, source.hash);
    assert_eq!(of(40), XxHash3_64::oneshot(file.section("options")));
    let mut checksum = XxHash3_64::with_seed(0);
    checksum.write(&bytes[..56]);
    checksum.write(&bytes[64..]);
    assert_eq!(of(56), checksum.finish());
    assert_eq!(of(56), XxHash3_64::oneshot(&[&bytes[..56], &bytes[64..]].concat()), "in one piece");
}

/// The facts of a hull are read back as they were baked.
fn facts(theirs: &hullmap::Hull, baked: &BakedHull) {
    let hull = &baked.hull;
    assert_eq!((theirs.name(), theirs.rank(), theirs.diameter()), (&*baked.name, hull.rank, hull.diameter));
    assert_eq!((theirs.containment_error(), theirs.outer_error()), (hull.containment_error, baked.outer_error));
    assert_eq!((theirs.part(), theirs.part_count()), (baked.part, baked.part_count));
    assert_eq!((theirs.origin().to_array(), theirs.source_point_count() as usize), (baked.origin, baked.point_count));
    let voids = if theirs.part_count() == 0 { None } else { theirs.voids() };
    assert!(
        baked.voids.is_none_or(|voids_of| voids.is_some_and(|found| found.share == f64::from(voids_of.share as f32)))
    );
    assert_eq!(
        (theirs.solid(), theirs.uncovered()),
        (baked.fit.map(|fit| fit.solid), baked.fit.map(|fit| fit.uncovered))
    );
    assert_eq!(theirs.protrusion(), baked.fit.map(|fit| fit.protrusion));
    assert_eq!(theirs.protrusion_at(), baked.fit.map(|fit| DVec3::from_array(fit.protrusion_at)));
    let primitive = theirs.primitive().map(|own| (own.kind, own.center, own.rotation, own.sizes, own.protrusion));
    let expected = baked.primitive.map(|own| {
        let Primitive { kind, center, rotation, sizes } = own.primitive;
        (kind, center, rotation, sizes, own.protrusion)
    });
    assert_eq!(primitive, expected);
    // The first hull of an object has the mass of its mesh; all of its parts state it. The tensor
    // is the one of section 6.2.
    let Some(mass) = baked.mesh_mass.filter(|_| baked.part == 0) else { return };
    let ([xx, yy, zz, yz, zx, xy], found) = (mass.second_moments, theirs.mesh_mass_properties(1.0).unwrap());
    assert_eq!((found.mass, found.center_of_mass.to_array()), (mass.volume, mass.centroid));
    let rows = [[yy + zz, -xy, -zx], [-xy, zz + xx, -yz], [-zx, -yz, xx + yy]];
    let expected = rows.map(|row| row.map(|entry| entry * mass.volume));
    assert_eq!(found.inertia.transpose().to_cols_array_2d(), expected);
}

/// Vertices and faces, and their order by the document. The check of an opened pack has the rest.
fn shape(ours: &reader::Hull, theirs: &hullmap::Hull, baked: &BakedHull) {
    let vertices: Vec<DVec3> = theirs.vertices().map(|v| v.as_dvec3()).collect();
    assert_eq!(vertices, baked.hull.positions());
    assert!(theirs.vertices().all(|v| v.to_array().iter().all(|c| c.to_bits() != (-0.0_f32).to_bits())));
    let sources = || (0..vertices.len() as u32).map(|v| theirs.source_vertex(v).unwrap_or(NO_SOURCE_VERTEX));
    assert!(sources().eq(baked.hull.source_vertices.iter().copied()));
    assert!(sources().is_sorted_by(|a, b| a < b || *a == NO_SOURCE_VERTEX && a == b));
    let faces: Vec<Vec<u32>> = theirs.faces().map(|face| face.collect()).collect();
    assert!(faces.is_sorted() && faces.iter().all(|face| face.iter().min() == face.first() && face.len() >= 3));
    // The face to the left of each edge.
    let edges = |face: &[u32]| (0..face.len()).map(|i| [face[i], face[(i + 1) % face.len()]]).collect::<Vec<_>>();
    let left: BTreeMap<[u32; 2], u32> =
        (0..).zip(&faces).flat_map(|(at, face)| edges(face).into_iter().map(move |edge| (edge, at))).collect();
    for v in 0..vertices.len() as u32 {
        let around: Vec<u32> = theirs.neighbours(v).collect();
        assert!(around.is_sorted_by(|a, b| a < b));
        if theirs.rank() > 1 {
            let expected = left.range([v, 0]..=[v, u32::MAX]);
            assert!(around.iter().copied().eq(expected.clone().map(|([_, w], _)| *w)));
            assert!(theirs.faces_at(v).eq(expected.map(|(_, face)| *face)));
        }
        for (w, q) in around.iter().zip(ours.edges.get(v as usize).into_iter().flatten()) {
            let e = vertices[*w as usize] - vertices[v as usize];
            let length = (e.x * e.x + e.y * e.y + e.z * e.z).sqrt();
            assert_eq!(*q, e.to_array().map(|c| (c / length * 32767.0).round() as i16));
        }
    }
    assert_eq!(ours.edges.len(), if theirs.rank() == 3 { vertices.len() } else { 0 });
    assert!(baked.outer.iter().copied().eq(theirs.outer_vertices().map(|v| v.to_array())));
    assert_eq!(baked.outer.is_empty(), vertices.len() <= 32);
}

fn direction_index(ours: &reader::Hull, theirs: &hullmap::Hull, baked: &BakedHull) {
    let (encoded, r) = (&baked.index.encoded, ours.record);
    assert_eq!(ours.slots, encoded.slots);
    assert_eq!(ours.blocks.len(), encoded.blocks.len());
    for (ours, written) in ours.blocks.iter().zip(&encoded.blocks) {
        let positions = [ours.x, ours.y, ours.z].map(|lanes| lanes.map(|c| c.to_native()));
        assert_eq!(
            (positions, ours.vertex.map(|v| v.to_native())),
            ([written.x, written.y, written.z], written.vertex)
        );
    }
    assert_eq!(4 * ours.slots.len() + 128 * ours.blocks.len(), theirs.index_byte_len());
    assert!(r.index_kind != 3 || theirs.vertex_count() > 32, "small hulls are scanned");
    let expected = match theirs.index_kind() {
        Kind::None => (0, 0, 1),
        Kind::CubeMap { resolution } => (1, resolution, 1),
        Kind::Binary => (2, 0, 1),
        Kind::Tree => (3, 0, 1),
        Kind::Medium => (3, 0, 2),
        Kind::Compact => (3, 0, 4),
    };
    assert_eq!((r.index_kind.into(), r.resolution.into(), r.leaf_blocks.into()), expected);
}

fn support(ours: &reader::Hull, theirs: &hullmap::Hull, count: usize, met: &mut Met) {
    let mut rng = SplitMix64::new(SEED);
    let edges = &ours.edges;
    for dir in directions::all(theirs, count, SEED) {
        let d = dir.to_array().map(f64::from);
        let expected = theirs.support(dir);
        assert_eq!(ours.support(d), expected.index, "{}: {dir}", theirs.name());
        assert_eq!(theirs.vertex(expected.index), Some(expected.point));
        // The cost belongs to the direction scaled to a largest coordinate of 1.
        let (leaf, cost) = (ours.leaf(reader::scaled(d)), theirs.support_cost(dir));
        assert_eq!((leaf.nodes, leaf.blocks.len() as u32 * 8), (cost.nodes, cost.dots));
        met.kinds |= leaf.kinds;

        // A direction in f64 that f32 cannot represent.
        let fine = rng.unit_vector() * 1e-9 * dir.as_dvec3().length() + dir.as_dvec3();
        assert_eq!(ours.support(fine.to_array()), SupportMap::support_point(theirs, fine).feature);

        // If the edges of a vertex certify it, the index finds the same vertex.
        if !edges.is_empty() && (1e-30..=1e30).contains(&dir.abs().max_element()) {
            let is_certain = |v: u32| reader::Hull::is_certain(&edges[v as usize], dir.to_array());
            *(if is_certain(expected.index) { &mut met.certain } else { &mut met.uncertain }) += 1;
            let other = rng.below(edges.len()) as u32;
            assert!(other == expected.index || !is_certain(other));
        }

        met.directions += 1;
    }
    for dir in directions::invalid() {
        // For invalid directions, the document does not specify the vertex.
        let (ours_found, theirs_found) = (ours.support(dir.to_array().map(f64::from)), theirs.support(dir).index);
        assert!((ours_found.max(theirs_found) as usize) < theirs.vertex_count());
    }
}

/// Hulls of every rank; among the solids, hulls with small and deep indices, with planes, and with
/// long leaves.
fn shapes_of_all_ranks() -> Vec<PointSet> {
    vec![
        points("point", vec![[1.0, -2.0, 3.5]; 3]),
        points("segment", vec![[0.0; 3], [1.0, 2.0, 3.0], [0.5, 1.0, 1.5]]),
        points("triangle", vec![[-0.0, 0.0, 0.25], [1.0, -0.0, 0.25], [0.0, 1.0, 0.25]]),
        points("sheet", Family::FlatSheet.points(300, 1)),
        points("tetrahedron", tetrahedron().positions),
        points("grid", Family::CubeGrid.points(125, 1)),
        points("rock", Family::Rock.points(400, 2)),
        points("prism", Family::RotatedPrism.points(1_000, 3)),
        points("cone", Family::Cone.points(300, 4)),
        points("needle", Family::Needle.points(200, 5)),
        points("lens", Family::Lens.points(600, 6)),
        points("sphere", Family::Sphere.points(4_000, 7)),
    ]
}

/// Meshes with a mass, without one, and parts that share one; parts of each kind of solid, and not
/// measured; objects with voids and without; primitives of each kind. The pack then has another
/// version.
#[test]
fn records_are_read_back() {
    let (shapes, solid) = (shapes_of_all_ranks(), bake(&PointSet { origin: ORIGIN, ..tetrahedron() }, IndexKind::Tree));
    assert!(solid.mesh_mass.is_some());
    let parts = |count: u32, first: &BakedHull| -> Vec<BakedHull> {
        let part = |part| if part == 0 { first.clone() } else { BakedHull { voids: None, ..first.clone() } };
        (0..count).map(|index| BakedHull { part: index, part_count: count, ..part(index) }).collect()
    };
    let fits = SolidKind::ALL.map(|solid| {
        Some(Fit { solid, uncovered: 0.125, protrusion: solid.code().into(), protrusion_at: [1.0, -2.0, 0.5] })
    });
    let mut hulls = vec![bake(&shapes[5], IndexKind::Tree), solid.clone()];
    hulls.extend(parts(3, &solid));
    for fit in fits.into_iter().chain([None]) {
        hulls.extend(parts(3, &BakedHull { fit, ..bake(&shapes[4], IndexKind::Tree) }));
    }
    let (plain, share) = (hulls.len(), |share: f64| Some(VoidsShare { share, error: 0.0625 }));
    compare(&hulls, &source("parts", ""), 500, &mut Met::default());
    let file = write_pack(&hulls, &SourceRecord::default()).unwrap();
    assert_eq!((reader::number(&file, 8, 4), Sections::read(&payload(&file)).unwrap().masses.len()), (7, 2));

    for voids in [share(0.5), None, share(0.0)] {
        hulls.extend(parts(2, &BakedHull { voids, ..solid.clone() }));
    }
    let sizes = [[1.0, 2.0, 3.0], [1.5, 0.0, 0.0], [0.5, 2.0, 0.0], [2.5, 1.0, 0.0]];
    for (part, (kind, sizes)) in
        parts(4, &BakedHull { fit: fits[0], ..solid }).into_iter().zip(PrimitiveKind::ALL.into_iter().zip(sizes))
    {
        let at = f64::from(part.part);
        let (center, rotation) = (DVec3::new(1.0, -2.0, at), DQuat::from_rotation_y(at));
        let primitive = Primitive { kind, center, rotation, sizes };
        hulls.push(BakedHull { primitive: Some(ProvenPrimitive { primitive, protrusion: 0.25 }), ..part });
    }
    compare(&hulls, &source("all", ""), 500, &mut Met::default());
    let file = write_pack(&hulls, &SourceRecord::default()).unwrap();
    let (payload, pack) = (payload(&file), Pack::from_bytes(&file).unwrap());
    let further = Sections::read(&payload).unwrap();
    let voids: Vec<_> = further.voids.iter().map(|own| (own.hull.into(), own.share.into(), own.error.into())).collect();
    assert_eq!(voids, [(plain as u32, 0.5_f32, 0.0625_f32), (plain as u32 + 4, 0.0, 0.0625)]);
    let shares: Vec<Option<f64>> = pack.hulls().skip(plain).map(|hull| hull.voids().map(|voids| voids.share)).collect();
    assert_eq!(shares[..6], [Some(0.5), Some(0.5), None, None, Some(0.0), Some(0.0)]);
    let kinds: Vec<(u32, u32)> = further.primitives.iter().map(|own| (own.hull.into(), own.kind.into())).collect();
    assert!(kinds.into_iter().eq((1..=4).map(|kind| (plain as u32 + 5 + kind, kind))));
    let names: Vec<Option<&str>> =
        pack.hulls().skip(plain + 6).map(|hull| Some(hull.primitive()?.kind.as_str())).collect();
    assert_eq!(names, [Some("box"), Some("sphere"), Some("capsule"), Some("cylinder")]);
}

#[test]
fn a_reader_written_from_the_document_agrees() {
    let kinds = [
        IndexKind::Tree,
        IndexKind::Medium,
        IndexKind::Compact,
        IndexKind::Binary,
        IndexKind::CubeMap { resolution: 1 },
        IndexKind::CubeMap { resolution: 13 },
        IndexKind::None,
    ];
    let mut met = Met::default();
    let mut ranks = [0; 4];
    for shape in shapes_of_all_ranks() {
        for kind in kinds {
            let hull = bake(&shape, kind);
            ranks[hull.hull.rank as usize] += 1;
            compare(&[hull], &source(&shape.name, "options"), 3_000, &mut met);
        }
    }
    println!("{met:?}");
    assert!(ranks.iter().all(|count| *count > 0), "hulls of each rank: {ranks:?}");
    assert_eq!(met.kinds, 0x7f, "slots of each kind: {met:?}");
    assert!(met.directions > 100_000 && met.padded > 0);
    assert!(met.certain * 4 > met.directions && met.uncertain * 10 > met.directions, "{met:?}");
}

#[test]
fn several_hulls_share_a_pack() {
    let kinds =
        [IndexKind::CubeMap { resolution: 3 }, IndexKind::Tree, IndexKind::Binary, IndexKind::None, IndexKind::Compact];
    let mut met = Met::default();
    for (first, name) in ["", "ä", "a b", "日本語"].into_iter().enumerate() {
        // Names and paths of different lengths, and hulls of different kinds, vary the padding.
        let mut hulls: Vec<BakedHull> = shapes_of_all_ranks()
            .iter()
            .skip(first)
            .zip(kinds.iter().cycle())
            .map(|(shape, kind)| bake(shape, *kind))
            .collect();
        hulls[0].name = name.to_owned();
        compare(&hulls, &source(name, &"o".repeat(first)), 500, &mut met);
        compare(&hulls[..2], &source("", ""), 500, &mut met);
    }
    assert!(met.padded > 0);
}

#[test]
fn grid_coordinates_match_the_runtime() {
    let mut rng = SplitMix64::new(SEED);
    let check = |d: [f32; 3]| {
        let cell = hullmap_format::cube::locate(d);
        assert_eq!(reader::locate(d), (cell.face, [cell.u, cell.v]), "{d:?}");
    };
    for _ in 0..200_000 {
        check(rng.direction().map(|c| c as f32));
        // A point on a grid line, and its two neighbours in f32.
        let t = (rng.below(1 << 23) as f32 - 4_194_303.5) / 4_194_303.0;
        for t in [t, t.next_up(), t.next_down()] {
            check([-1.0, t, rng.between(-1.0, 1.0) as f32]);
        }
    }
    // All corners and seams. The centre is not a direction.
    for corner in (0..27_u8).filter(|corner| *corner != 13) {
        check([corner % 3, corner / 3 % 3, corner / 9].map(|c| f32::from(c) - 1.0));
    }
    assert_eq!([-1.0, 0.0, 1.0].map(|t| reader::locate([2.0, 2.0 * t, 0.0]).1[0]), [1, 1 << 22, (1 << 23) - 1]);
}

/// The asset whose pack the document shows.
fn tetrahedron() -> PointSet {
    let (file, limits) = ("tetrahedron.obj", Limits::DEFAULT);
    let source = SourceFile::alone(TETRAHEDRON.into());
    let mut imported = import(file, "tetrahedron", Path::new(file), &source, &ImportOptions::DEFAULT, &limits).unwrap();
    imported.give_triangles();
    imported.point_sets.remove(0)
}

fn shown_pack() -> Vec<u8> {
    let source = SourceRecord {
        path: "../assets/tetrahedron.obj".to_owned(),
        hash: XxHash3_128::oneshot(TETRAHEDRON.as_bytes()),
        options: "split none, vertices referenced, index tree 8".to_owned(),
        ..SourceRecord::default()
    };
    write_pack(&[bake(&tetrahedron(), IndexKind::Tree)], &source).unwrap()
}

/// Lines of the listing: offset, bytes, and note.
fn listing() -> Vec<(usize, Vec<u8>, &'static str)> {
    let line = |line: &'static str| {
        let (bytes, note) = line.split_once('|')?;
        let (offset, bytes) = bytes.split_once(' ').unwrap();
        let bytes = bytes.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect();
        Some((usize::from_str_radix(offset, 16).unwrap(), bytes, note.trim()))
    };
    LISTING.lines().filter_map(line).collect()
}

#[test]
fn the_file_shown_is_the_one_baked_today() {
    let baked = shown_pack();
    let mut shown = Vec::new();
    for (offset, bytes, note) in listing() {
        assert_eq!(offset, shown.len(), "tetrahedron.txt: the line at {offset:08x}, {note}");
        let now = baked.get(offset..offset + bytes.len());
        assert_eq!(now, Some(&bytes[..]), "tetrahedron.txt: the line at {offset:08x}, {note}");
        shown.extend(bytes);
    }
    assert_eq!(shown.len(), baked.len(), "tetrahedron.txt shows all of the file");
}

#[test]
fn the_notes_on_the_root_hold() {
    let baked = shown_pack();
    let root = baked.len() - reader::ROOT;
    let mut sections = File::new(&baked).sections.into_iter().zip(reader::SECTIONS);
    for (offset, _, note) in listing().into_iter().filter(|line| line.0 >= root) {
        let (range, (name, ..)) = sections.next().unwrap();
        let relative = range.start as i64 - offset as i64;
        let count = reader::number(&baked, offset + 4, 4);
        assert_eq!(note, format!("{name}: {relative} from here, at {:08x}; count {count}", range.start));
    }
    assert!(sections.next().is_none());
}

/// Rows of the document's first table of fields after this text: offset, size, type and name.
pub fn fields(after: &str) -> Vec<(usize, usize, &'static str, &'static str)> {
    let (_, rest) = DOCUMENT.split_once(after).unwrap();
    let table = rest.lines().skip_while(|line| !line.starts_with("| offset")).take_while(|line| line.starts_with('|'));
    let row = |line: &'static str| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        (cells[1].parse().unwrap(), cells[2].parse().unwrap(), cells[3], cells[4])
    };
    table.skip(2).map(row).collect()
}

/// The document's tables of the header and of records cover every byte, and each field of a record
/// is where its table states.
#[test]
fn tables_state_the_layout() {
    let has_no_gaps = |heading: &str, size: usize| {
        let end = fields(heading).into_iter().fold(0, |end, (offset, size, ..)| {
            assert_eq!(offset, end, "{heading}");
            end + size
        });
        assert_eq!(end, size, "{heading}");
    };
    has_no_gaps("\n## 3. Header\n", HEADER_LEN);
    macro_rules! layouts {
        ($($heading:literal $record:ident { $($field:ident)+ })+) => {
            $({
                has_no_gaps($heading, size_of::<$record>());
                let found = [$((offset_of!($record, $field), stringify!($field))),+];
                assert!(fields($heading).into_iter().map(|(offset, _, _, name)| (offset, name)).eq(found), $heading);
            })+
        };
    }
    layouts! {
        "\n### 6.1 Span\n" ArchivedSpan {
            name vertex face face_vertex neighbour slot block outer edge quad mass
        }
        "\n### 6.2 Hull record\n" ArchivedHullRecord {
            diameter centroid interior_point inner_radius outer_radius volume surface_area second_moments containment_error
            outer_error uncovered protrusion protrusion_at origin bounds_min bounds_max rank index_kind resolution
            leaf_blocks max_neighbours max_nodes max_dots source_points leaf part part_count solid
        }
        "\n### 6.3 Block\n" ArchivedBlock { x y z vertex }
        "\n### 6.4 Node\n" ArchivedBvhNode { bounds_min target bounds_max hull_count }
        "\n### 6.5 Quad\n" ArchivedQuad { face corners fall }
        "\n### 6.6 Mass record\n" ArchivedMassRecord { volume centroid second_moments }
        "A *voids record* states" ArchivedVoidsRecord { hull share error }
        "A *primitive record* has" ArchivedPrimitiveRecord { hull kind center rotation sizes protrusion }
    }
}
