//! `docs/contributors/FORMAT.md` agrees with the bytes of packs. A reader written from the document
//! alone agrees with `hullmap::Pack` on packs of all shapes, and the file that the document lists
//! is the one that is baked today.

mod reader;

use std::hash::Hasher;

use glam::{DQuat, DVec3};
use hullmap::{IndexKind as Kind, Pack, PrimitiveKind, SolidKind, SupportMap};
use hullmap_bake::fit::VoidsShare;
use hullmap_bake::primitive::{Primitive, ProvenPrimitive};
use hullmap_bake::{BakedHull, Fit, IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
use hullmap_tests::directions;
use reader::{File, Stored as _, section};
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
    let file = File::new(&bytes);
    let pack = Pack::from_bytes(&bytes).unwrap();

    met.padded += usize::from(file.check_layout() > 0);
    hashes(&bytes, &file, source);
    let text = |section| std::str::from_utf8(file.section(section)).unwrap();
    assert_eq!(text(section::SOURCE_PATH), pack.source_path());
    assert_eq!(text(section::OPTIONS), pack.options());
    assert_eq!(text(section::NAMES), hulls.iter().map(|h| h.name.as_str()).collect::<String>());

    assert_eq!(file.count(section::HULLS), pack.hull_count());
    assert_eq!(file.count(section::SPANS), pack.hull_count() + 1);
    assert_eq!(file.span(0), [0; 11]);
    let counts = [
        section::NAMES,
        section::VERTICES,
        section::FACE_STARTS,
        section::FACE_VERTICES,
        section::NEIGHBOURS,
        section::SLOTS,
        section::BLOCKS,
        section::OUTER_VERTICES,
        section::EDGES,
        section::QUADS,
        section::MASSES,
    ];
    assert_eq!(file.span(hulls.len()), counts.map(|section| file.count(section)));
    assert_eq!(file.count(section::SOURCE_VERTICES), file.count(section::VERTICES));
    assert_eq!(file.count(section::NEIGHBOUR_STARTS), file.count(section::VERTICES));

    assert_eq!(file.count(section::NEIGHBOUR_FACES), file.count(section::NEIGHBOURS));

    boxes(&file);
    for (index, baked) in hulls.iter().enumerate() {
        let (ours, theirs) = (file.hull(index), pack.hull(index).unwrap());
        record(&ours, &theirs, baked);
        shape(&ours, &theirs, baked);
        direction_index(&ours, &theirs, baked);
        support(&ours, &theirs, count, met);
    }
}

/// The BVH agrees with the document, and contains each hull once.
fn boxes(file: &File) {
    let (nodes, count) = (file.nodes(), file.count(section::HULLS));
    assert_eq!(nodes.len(), 2 * count - 1);
    let mut free = 1;
    let mut levels = vec![0; nodes.len()];
    for (index, node) in nodes.iter().enumerate() {
        let inside = |other: &reader::BoxNode| {
            (0..3).all(|i| node.bounds_min[i] <= other.bounds_min[i] && other.bounds_max[i] <= node.bounds_max[i])
        };
        let target = node.target as usize;
        if node.hull_count == 1 {
            let hull = file.hull(target);
            assert_eq!(hull.record.leaf as usize, index);
            assert_eq!([node.bounds_min, node.bounds_max], [hull.record.bounds_min, hull.record.bounds_max]);
            continue;
        }
        assert_eq!(target, free);
        free += 2;
        for child in [target, target + 1] {
            levels[child] = levels[index] + 1;
            assert!(inside(&nodes[child]) && levels[child] < 32);
        }
        assert_eq!(node.hull_count, nodes[target].hull_count + nodes[target + 1].hull_count);
    }
    assert_eq!((free, nodes[0].hull_count as usize), (nodes.len(), count));
}

fn hashes(bytes: &[u8], file: &File, source: &SourceRecord) {
    let low_then_high = u128::from(u64::at(bytes, 24)) | u128::from(u64::at(bytes, 32)) << 64;
    assert_eq!(low_then_high, source.hash);
    assert_eq!(u64::at(bytes, 40), XxHash3_64::oneshot(file.section(section::OPTIONS)));
    let mut checksum = XxHash3_64::with_seed(0);
    checksum.write(&bytes[..56]);
    checksum.write(&bytes[64..]);
    assert_eq!(u64::at(bytes, 56), checksum.finish());
    assert_eq!(u64::at(bytes, 56), XxHash3_64::oneshot(&[&bytes[..56], &bytes[64..]].concat()), "in one piece");
}

fn record(ours: &reader::Hull, theirs: &hullmap::Hull, baked: &BakedHull) {
    let r = &ours.record;
    assert_eq!(ours.name, theirs.name().as_bytes());
    assert_eq!(r.diameter, theirs.diameter());
    assert_eq!(r.centroid, theirs.centroid().to_array());
    assert_eq!(r.interior_point, theirs.interior_point().to_array());
    assert_eq!(r.inner_radius, theirs.inner_radius());
    assert_eq!(r.outer_radius, theirs.outer_radius());
    assert_eq!(r.volume, theirs.volume());
    assert_eq!(r.surface_area, theirs.surface_area());
    assert_eq!(r.second_moments, theirs.second_moments());
    assert_eq!(r.containment_error, theirs.containment_error());
    assert_eq!((r.outer_error, r.part, r.part_count), (theirs.outer_error(), theirs.part(), theirs.part_count()));
    assert_eq!((r.outer_error, r.part, r.part_count), (baked.outer_error, baked.part, baked.part_count));
    fit(r, theirs, baked);
    mass(ours, theirs, baked);
    assert_eq!((r.origin, r.origin), (theirs.origin().to_array(), baked.origin));
    assert_eq!([r.bounds_min, r.bounds_max], theirs.bounds().map(|b| b.to_array()));
    assert_eq!(r.rank, theirs.rank());
    let expected = match theirs.index_kind() {
        Kind::None => (0, 0, 1),
        Kind::CubeMap { resolution } => (1, resolution, 1),
        Kind::Binary => (2, 0, 1),
        Kind::Tree => (3, 0, 1),
        Kind::Medium => (3, 0, 2),
        Kind::Compact => (3, 0, 4),
    };
    assert_eq!((r.index_kind, r.resolution, r.leaf_blocks), expected);
    assert_eq!((r.max_nodes, r.max_dots), (theirs.worst_cost().nodes, theirs.worst_cost().dots));
    assert_eq!(r.source_points, theirs.source_point_count());
    assert_eq!(r.source_points as usize, baked.point_count);

    assert!(r.containment_error <= 1e-7);
    for i in 0..3 {
        let along = || ours.vertices.iter().map(|v| v[i]);
        assert_eq!(r.bounds_min[i], along().reduce(f32::min).unwrap(), "bounds are tight");
        assert_eq!(r.bounds_max[i], along().reduce(f32::max).unwrap(), "bounds are tight");
    }
    let from_point = |v: &[f32; 3]| DVec3::from_array(v.map(f64::from)).distance(DVec3::from_array(r.interior_point));
    assert!(ours.vertices.iter().all(|v| from_point(v) <= r.outer_radius));
    assert!(r.rank == 3 || (r.volume == 0.0 && r.inner_radius == 0.0));
    assert!(r.rank >= 2 || r.surface_area == 0.0);
}

/// The first hull of an object has the mass of its mesh. All of its parts state it.
fn mass(ours: &reader::Hull, theirs: &hullmap::Hull, baked: &BakedHull) {
    let found = theirs.mesh_mass_properties(1.0);
    if ours.record.part > 0 {
        assert!(ours.masses.is_empty());
        return;
    }
    let expected = baked.mesh_mass.map(|mass| (mass.volume, mass.centroid, mass.second_moments));
    assert_eq!(ours.masses.first().map(|mass| (mass.volume, mass.centroid, mass.second_moments)), expected);
    let Some(reader::Mass { volume, centroid, second_moments: [xx, yy, zz, yz, zx, xy] }) = ours.masses.first() else {
        assert_eq!(found, None);
        return;
    };
    let found = found.unwrap();
    assert_eq!((found.mass, found.center_of_mass.to_array()), (*volume, *centroid));
    // The tensor of section 6.2.
    let rows = [[yy + zz, -xy, -zx], [-xy, zz + xx, -yz], [-zx, -yz, xx + yy]];
    assert_eq!(found.inertia.transpose().to_cols_array_2d(), rows.map(|row| row.map(|entry| entry * volume)));
}

/// Meshes with a mass, without one, and parts that share one.
#[test]
fn masses_are_read_back() {
    let shapes = shapes_of_all_ranks();
    let solid = bake(&PointSet { origin: ORIGIN, ..tetrahedron() }, IndexKind::Tree);
    assert!(solid.mesh_mass.is_some());
    let mut hulls = vec![bake(&shapes[5], IndexKind::Tree), solid.clone()];
    hulls.extend((0..3).map(|part| BakedHull { part, part_count: 3, ..solid.clone() }));
    hulls.push(bake(&shapes[6], IndexKind::Tree));
    compare(&hulls, &source("masses", ""), 500, &mut Met::default());
    let file = write_pack(&hulls, &SourceRecord::default()).unwrap();
    assert_eq!(File::new(&file).count(section::MASSES), 2);
}

/// Objects with voids, without, and hulls that are no parts. The pack then has another version.
#[test]
fn voids_are_read_back() {
    let solid = bake(&tetrahedron(), IndexKind::Tree);
    let of = |part: u32, voids: Option<VoidsShare>| BakedHull { part, part_count: 2, voids, ..solid.clone() };
    let share = |share: f64| Some(VoidsShare { share, error: 0.0625 });
    let hulls =
        [solid.clone(), of(0, share(0.5)), of(1, None), of(0, None), of(1, None), of(0, share(0.0)), of(1, None)];
    compare(&hulls, &source("voids", ""), 500, &mut Met::default());
    let file = write_pack(&hulls, &SourceRecord::default()).unwrap();
    let expected = [(1, 0.5), (5, 0.0)].map(|(hull, share)| reader::Voids { hull, share, error: 0.0625 });
    assert_eq!((u32::at(&file, 8), File::new(&file).voids()), (9, Vec::from(expected)));
    let pack = Pack::from_bytes(&file).unwrap();
    let found: Vec<Option<f64>> = pack.hulls().map(|hull| hull.voids().map(|voids| voids.share)).collect();
    assert_eq!(found, [None, Some(0.5), Some(0.5), None, None, Some(0.0), Some(0.0)]);
}

/// Primitives of each kind.
#[test]
fn primitives_are_read_back() {
    let solid = bake(&tetrahedron(), IndexKind::Tree);
    let fit = Fit { solid: SolidKind::Watertight, uncovered: 0.0, protrusion: 0.5, protrusion_at: [0.0; 3] };
    let sizes = [[1.0, 2.0, 3.0], [1.5, 0.0, 0.0], [0.5, 2.0, 0.0], [2.5, 1.0, 0.0]];
    let of = |(part, (kind, sizes)): (u32, (PrimitiveKind, [f64; 3]))| {
        let (center, rotation) = (DVec3::new(1.0, -2.0, f64::from(part)), DQuat::from_rotation_y(f64::from(part)));
        let primitive = Primitive { kind, center, rotation, sizes };
        let primitive = Some(ProvenPrimitive { primitive, protrusion: 0.25 });
        BakedHull { part, part_count: 4, fit: Some(fit), primitive, ..solid.clone() }
    };
    let mut hulls = vec![solid.clone()];
    hulls.extend((0..).zip(PrimitiveKind::ALL.into_iter().zip(sizes)).map(of));
    compare(&hulls, &source("primitives", ""), 500, &mut Met::default());
    let file = write_pack(&hulls, &SourceRecord::default()).unwrap();
    let expected: Vec<reader::Primitive> = (0..4)
        .map(|part: u32| reader::Primitive {
            hull: part + 1,
            kind: part + 1,
            center: [1.0, -2.0, f64::from(part)],
            rotation: DQuat::from_rotation_y(f64::from(part)).to_array(),
            sizes: sizes[part as usize],
            protrusion: 0.25,
        })
        .collect();
    assert_eq!(File::new(&file).primitives(), expected);
    let pack = Pack::from_bytes(&file).unwrap();
    let names: Vec<Option<&str>> = pack.hulls().map(|hull| Some(hull.primitive()?.kind.as_str())).collect();
    assert_eq!(names, [None, Some("box"), Some("sphere"), Some("capsule"), Some("cylinder")]);
}

/// Checks the claims of a part about its mesh, by the table of kinds in the document.
fn fit(r: &reader::Record, theirs: &hullmap::Hull, baked: &BakedHull) {
    let Some(fit) = baked.fit else {
        assert_eq!((r.solid, r.uncovered, r.protrusion, r.protrusion_at), (0, 0.0, 0.0, [0.0; 3]));
        assert_eq!(
            (theirs.solid(), theirs.uncovered(), theirs.protrusion(), theirs.protrusion_at()),
            Default::default()
        );
        return;
    };
    let kinds = [None, Some(SolidKind::Watertight), Some(SolidKind::Closed), Some(SolidKind::Walls)];
    assert_eq!((kinds[r.solid as usize], Some(fit.solid)), (Some(fit.solid), theirs.solid()));
    assert_eq!((Some(r.uncovered), Some(fit.uncovered)), (theirs.uncovered(), theirs.uncovered()));
    assert_eq!((Some(r.protrusion), Some(fit.protrusion)), (theirs.protrusion(), theirs.protrusion()));
    let at = theirs.protrusion_at().map(|at| at.to_array());
    assert_eq!((Some(r.protrusion_at), Some(fit.protrusion_at)), (at, at));
}

/// Parts of an object between hulls that are no parts, of each kind of solid, and parts that were
/// not measured.
#[test]
fn parts_and_their_fit_are_read_back() {
    let shapes = shapes_of_all_ranks();
    let fits = SolidKind::ALL.map(|solid| {
        Some(Fit { solid, uncovered: 0.125, protrusion: solid.code().into(), protrusion_at: [1.0, -2.0, 0.5] })
    });
    let mut hulls = vec![bake(&shapes[5], IndexKind::Tree)];
    for fit in fits.into_iter().chain([None]) {
        for part in 0..3 {
            hulls.push(BakedHull { part, part_count: 3, fit, ..bake(&shapes[4], IndexKind::Tree) });
        }
    }
    hulls.push(bake(&shapes[6], IndexKind::None));
    compare(&hulls, &source("parts", ""), 500, &mut Met::default());
}

/// Vertices and faces, and their order by the document.
fn shape(ours: &reader::Hull, theirs: &hullmap::Hull, baked: &BakedHull) {
    assert!(ours.vertices.iter().copied().eq(theirs.vertices().map(|v| v.to_array())));
    assert!(ours.vertices.iter().flatten().all(|c| c.to_bits() != (-0.0_f32).to_bits()));
    assert_eq!(ours.source_vertices, baked.hull.source_vertices);
    for (vertex, source_vertex) in ours.source_vertices.iter().enumerate() {
        let expected = (*source_vertex != NO_SOURCE_VERTEX).then_some(*source_vertex);
        assert_eq!(theirs.source_vertex(vertex as u32), expected);
    }
    assert!(ours.source_vertices.is_sorted_by(|a, b| a < b || *a == NO_SOURCE_VERTEX && a == b));
    let faces = ours.faces();
    let expected: Vec<Vec<u32>> = theirs.faces().map(|face| face.collect()).collect();
    assert_eq!(faces, expected);
    assert!(faces.is_sorted());
    assert!(faces.iter().all(|face| face.iter().min() == face.first() && face.len() >= 3));
    let neighbours = ours.neighbours();
    for (vertex, list) in neighbours.iter().enumerate() {
        assert!(theirs.neighbours(vertex as u32).eq(list.iter().copied()));
        assert!(list.is_sorted_by(|a, b| a < b));
        assert!(list.iter().all(|other| neighbours[*other as usize].contains(&(vertex as u32))), "both ways");
    }
    let edges = faces.iter().flat_map(|face| face.iter().zip(face.iter().cycle().skip(1)));
    let mut of_edges = vec![std::collections::BTreeSet::new(); neighbours.len()];
    edges.for_each(|(a, b)| _ = of_edges[*a as usize].insert(*b));
    match ours.record.rank {
        0 => assert!(neighbours.len() == 1 && neighbours[0].is_empty()),
        1 => assert_eq!(neighbours, [[1], [0]]),
        _ => assert!(of_edges.iter().zip(&neighbours).all(|(set, list)| set.iter().eq(list.iter()))),
    }
    assert_eq!(ours.record.max_neighbours as usize, neighbours.iter().map(|list| list.len()).max().unwrap());
    beside(ours, theirs, &neighbours, &faces);
    edges_of(ours, &neighbours);
    quads(ours, &faces);
    outer(ours, theirs, baked);
    let (v, c, f) = (ours.vertices.len(), ours.face_vertices.len(), faces.len());
    match ours.record.rank {
        0 => assert_eq!((v, c, f), (1, 0, 0)),
        1 => assert_eq!((v, c, f), (2, 0, 0)),
        2 => assert_eq!((c, f), (2 * v, 2)),
        _ => assert!(v >= 4 && v + f == 2 + c / 2 && c.is_multiple_of(2)),
    }
}

/// The face beside each edge contains the edge, and the faces beside a vertex's edges are all faces
/// at the vertex.
fn beside(ours: &reader::Hull, theirs: &hullmap::Hull, neighbours: &[&[u32]], faces: &[&[u32]]) {
    for (v, (around, beside)) in neighbours.iter().zip(ours.faces_beside()).enumerate() {
        let v = v as u32;
        if faces.is_empty() {
            assert!(beside.iter().all(|face| *face == 0) && theirs.faces_at(v).len() == 0);
            continue;
        }
        for (w, face) in around.iter().zip(beside) {
            let face = faces[*face as usize];
            assert!(face.iter().zip(face.iter().cycle().skip(1)).any(|edge| edge == (&v, w)));
        }
        assert!(theirs.faces_at(v).eq(beside.iter().copied()));
        let at = faces.iter().enumerate().filter(|(_, face)| face.contains(&v)).map(|(index, _)| index as u32);
        // This search is slow, so large hulls are sampled.
        if v < 100 {
            let mut sorted = beside.to_vec();
            sorted.sort_unstable();
            assert!(at.eq(sorted));
        }
    }
}

/// Each face with more than four corners has a quad.
fn quads(ours: &reader::Hull, faces: &[&[u32]]) {
    let large = (0..faces.len()).filter(|face| faces[*face].len() > 4);
    assert!(large.eq(ours.quads.iter().map(|quad| quad.face as usize)));
    for quad in &ours.quads {
        let face = faces[quad.face as usize];
        assert!(quad.corners.is_sorted_by(|a, b| a < b) && (quad.corners[3] as usize) < face.len());
        assert!((0.0..=1.0).contains(&quad.fall) && (ours.record.rank == 3 || quad.fall == 1.0), "{}", quad.fall);
    }
}

/// The edges agree with the document. Hulls below rank 3 have no edges.
fn edges_of(ours: &reader::Hull, neighbours: &[&[u32]]) {
    assert_eq!(ours.edges.len(), if ours.record.rank == 3 { 3 * ours.neighbours.len() } else { 0 });
    for (v, (around, edges)) in neighbours.iter().zip(ours.edges()).enumerate() {
        for (w, q) in around.iter().zip(edges) {
            let [v, w] = [v, *w as usize].map(|i| DVec3::from_array(ours.vertices[i].map(f64::from)));
            let e = w - v;
            let length = (e.x * e.x + e.y * e.y + e.z * e.z).sqrt();
            assert_eq!(q, e.to_array().map(|c| (c / length * 32767.0).round() as i16));
        }
    }
}

/// Hulls of more than 32 vertices have outer vertices.
fn outer(ours: &reader::Hull, theirs: &hullmap::Hull, baked: &BakedHull) {
    let all = &ours.outer_vertices;
    assert_eq!(all, &baked.outer);
    assert!(all.iter().copied().eq(theirs.outer_vertices().map(|v| v.to_array())));
    assert_eq!(all.is_empty(), ours.vertices.len() <= 32);
}

fn direction_index(ours: &reader::Hull, theirs: &hullmap::Hull, baked: &BakedHull) {
    let encoded = &baked.index.encoded;
    assert_eq!(ours.slots, encoded.slots);
    assert_eq!(ours.blocks.len(), encoded.blocks.len());
    for (ours, written) in ours.blocks.iter().zip(&encoded.blocks) {
        assert_eq!((ours.position, ours.vertex), ([written.x, written.y, written.z], written.vertex));
    }
    assert_eq!(4 * ours.slots.len() + 128 * ours.blocks.len(), theirs.index_byte_len());
    assert!(ours.record.index_kind != 3 || ours.vertices.len() > 32, "small hulls are scanned");
}

fn support(ours: &reader::Hull, theirs: &hullmap::Hull, count: usize, met: &mut Met) {
    let mut rng = SplitMix64::new(SEED);
    let edges = ours.edges();
    for dir in directions::all(theirs, count, SEED) {
        let d = dir.to_array().map(f64::from);
        let expected = theirs.support(dir);
        assert_eq!(ours.support(d), expected.index, "{}: {dir}", theirs.name());
        assert_eq!(ours.vertices[expected.index as usize], expected.point.to_array());
        // The cost belongs to the direction scaled to a largest coordinate of 1.
        let (leaf, cost) = (ours.leaf(reader::scaled(d)), theirs.support_cost(dir));
        assert_eq!((leaf.nodes, leaf.blocks.len() as u32 * 8), (cost.nodes, cost.dots));
        met.kinds |= leaf.kinds;

        // A direction in f64 that f32 cannot represent.
        let fine = DVec3::from_array(rng.direction()) * 1e-9 * dir.as_dvec3().length() + dir.as_dvec3();
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
        assert!((ours_found.max(theirs_found) as usize) < ours.vertices.len());
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

/// The points of the asset whose pack the document shows.
fn tetrahedron() -> PointSet {
    let positions: Vec<[f32; 3]> = TETRAHEDRON
        .lines()
        .filter_map(|line| line.strip_prefix("v "))
        .map(|line| {
            let numbers: Vec<f32> = line.split_whitespace().map(|c| c.parse().unwrap()).collect();
            numbers.try_into().unwrap()
        })
        .collect();
    let corners =
        |line: &str| -> Vec<u32> { line.split_whitespace().map(|corner| corner.parse::<u32>().unwrap() - 1).collect() };
    let triangles = TETRAHEDRON.lines().filter_map(|line| line.strip_prefix("f ")).map(corners);
    PointSet {
        name: "tetrahedron".to_owned(),
        source_vertices: (0..positions.len() as u32).collect(),
        positions,
        triangles: triangles.map(|face| face.try_into().unwrap()).collect(),
        ..PointSet::default()
    }
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
        let count = u32::at(&baked, offset + 4);
        assert_eq!(note, format!("{name}: {relative} from here, at {:08x}; count {count}", range.start));
    }
    assert!(sections.next().is_none());
}

/// The document's tables of the header and of records cover every byte.
#[test]
fn tables_have_no_gaps() {
    let rows = |heading: &str| -> Vec<(usize, usize)> {
        let (_, rest) = DOCUMENT.split_once(heading).unwrap();
        rest.lines()
            .skip_while(|line| !line.starts_with("| offset"))
            .take_while(|line| line.starts_with('|'))
            .skip(2)
            .map(|line| {
                let cells: Vec<&str> = line.split('|').map(str::trim).collect();
                (cells[1].parse().unwrap(), cells[2].parse().unwrap())
            })
            .collect()
    };
    for (heading, size) in [
        ("\n## 3. Header\n", 64),
        ("\n### 6.1 Span\n", 44),
        ("\n### 6.2 Hull record\n", 288),
        ("\n### 6.3 Block\n", 128),
        ("\n### 6.4 Node\n", 32),
        ("\n### 6.5 Quad\n", 24),
        ("\n### 6.6 Mass record\n", 80),
    ] {
        let end = rows(heading).into_iter().fold(0, |end, (offset, size)| {
            assert_eq!(offset, end, "{heading}");
            end + size
        });
        assert_eq!(end, size, "{heading}");
    }
}
