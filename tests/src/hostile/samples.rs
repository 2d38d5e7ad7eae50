//! The packs to change. [`sheets`](super::sheets) has the other files.

use hullmap_bake::{
    Fit, IndexKind, NO_SOURCE_VERTEX, PointSet, SolidKind, SourceRecord, bake_hull, write_lean_pack, write_pack,
};
use hullmap_testkit::packs::{self, ALL_INDICES, cube, point_set};
use shapes::{families::Family, rng::SplitMix64};

/// A file, by name.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Name of the file, after its contents.
    pub name: String,
    /// Its bytes.
    pub file: Vec<u8>,
}

/// Small packs of every rank and index kind: with one leaf and with nodes of each kind, with one
/// hull and with several, with parts and with simplified hulls.
pub fn small() -> Vec<Sample> {
    let map = |resolution| IndexKind::CubeMap { resolution };
    let one = |points: &[[f32; 3]]| vec![point_set("hüll", points)];
    let octagon: Vec<[f32; 3]> = Family::Prism.points(24, 0).iter().map(|p| [p[0], p[1], 0.5]).collect();
    let sixteen = IndexKind::Medium;
    vec![
        sample("point, tree", &one(&[[1.0, 2.0, 3.0]]), IndexKind::Tree),
        sample("point, no index", &one(&[[0.0; 3]]), IndexKind::None),
        sample("segment, cube map 1", &one(&[[0.0; 3], [1.0, 2.0, 3.0]]), map(1)),
        sample("segment, binary tree", &one(&[[-1.0; 3], [1e-3, 2.0, 0.0]]), IndexKind::Binary),
        sample("polygon, tree", &one(&octagon), IndexKind::Tree),
        sample("polygon, no index", &one(&octagon[..5]), IndexKind::None),
        sample("cube, no index", &one(&cube()), IndexKind::None),
        sample("cube, cube map 2", &one(&cube()), map(2)),
        sample("cube, tree", &one(&cube()), IndexKind::Tree),
        sample("sphere, cube map 3", &one(&Family::Sphere.points(14, 1)), map(3)),
        sample("sphere, cube map 1", &one(&Family::Sphere.points(30, 2)), map(1)),
        sample("cone, binary tree", &one(&Family::Cone.points(14, 1)), IndexKind::Binary),
        sample("sphere, binary tree", &one(&Family::Sphere.points(20, 5)), IndexKind::Binary),
        sample("sphere, tree", &one(&Family::Sphere.points(36, 3)), IndexKind::Tree),
        sample("prism, tree", &one(&Family::Prism.points(80, 0)), IndexKind::Tree),
        sample("rotated prism, tree", &one(&Family::RotatedPrism.points(48, 0)), IndexKind::Tree),
        sample("needle, tree", &one(&Family::Needle.points(24, 1)), IndexKind::Tree),
        sample("lens, leaves of 16", &one(&Family::Lens.points(40, 1)), sixteen),
        sample("sphere, compact", &one(&Family::Sphere.points(40, 4)), IndexKind::Compact),
        sample("rock, tree", &one(&Family::Rock.points(48, 1)), IndexKind::Tree),
        sample("five hulls, no index", &five_hulls(), IndexKind::None),
        sample("hulls of all ranks, tree", &all_ranks(), IndexKind::Tree),
        sample("recentred, tree", &recentred(), IndexKind::Tree),
        simplified(),
        parts(),
        meshes(),
        lean(),
        sample("two hulls, tree", &[point_set("a", &cube()), point_set("", &cube()[..3])], IndexKind::Tree),
    ]
}

/// The small pack of this name. Panics if no pack has this name.
pub fn named(name: &str) -> Vec<u8> {
    let found = small().into_iter().find(|sample| sample.name == name);
    found.unwrap_or_else(|| panic!("there is no sample {name:?}")).file
}

/// Pack `pack_index` of the random series of `seed`: one to three hulls of 9 to 300 points each, of
/// any family and index kind.
pub fn drawn(seed: u64, pack_index: u64) -> Sample {
    let mut rng = SplitMix64::new(seed ^ pack_index << 32);
    let index = ALL_INDICES[rng.below(ALL_INDICES.len())];
    let mut name = format!("drawn {pack_index}, {index:?}");
    let sets: Vec<PointSet> = (0..1 + rng.below(3))
        .map(|hull| {
            let family = Family::ALL[rng.below(Family::ALL.len())];
            let count = 9 + rng.below(292) / (hull + 1);
            name += &format!(", {} {count}", family.name());
            let shift = rng.direction().map(|c| c as f32 * 2.5 * hull as f32);
            let points = family.points(count, rng.next_u64());
            let points: Vec<[f32; 3]> = points.iter().map(|p| [0, 1, 2].map(|axis| p[axis] + shift[axis])).collect();
            point_set(["a", "bé", "c"][hull], &points)
        })
        .collect();
    sample(&name, &sets, index)
}

fn sample(name: &str, sets: &[PointSet], index: IndexKind) -> Sample {
    let file = packs::bytes(sets, index, &source()).unwrap_or_else(|error| panic!("{name}: {error}"));
    Sample { name: name.to_owned(), file }
}

/// The source that every sample records.
pub fn source() -> SourceRecord {
    SourceRecord { path: "../ä.obj".into(), hash: 7 << 90, options: "split none".into(), ..SourceRecord::default() }
}

/// Tetrahedra far from each other, so that their BVH has at least three levels.
fn five_hulls() -> Vec<PointSet> {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0_f32]];
    let at = |i: usize| corners.map(|[x, y, z]| [x + 3.0 * i as f32, y + (i % 2) as f32, z - i as f32]);
    (0..5).map(|i| point_set(["a", "b", "c", "d", "e"][i], &at(i))).collect()
}

fn all_ranks() -> Vec<PointSet> {
    let at = |count: usize, shift: f32| -> Vec<[f32; 3]> {
        cube()[..count].iter().map(|p| [p[0] + shift, p[1], p[2] * 0.5]).collect()
    };
    vec![
        point_set("point", &at(1, 0.0)),
        point_set("segment", &at(2, 2.0)),
        point_set("polygon", &at(4, 4.0)),
        point_set("solid", &at(8, 6.0)),
    ]
}

fn recentred() -> Vec<PointSet> {
    let origin = [1e7, -3.25, 0.0];
    let set = |name, family: Family| PointSet { origin, ..point_set(name, &family.points(16, 9)) };
    vec![set("left", Family::Rock), set("right", Family::Sphere)]
}

/// A hull that reaches beyond its source, as if simplified: no vertex is a source vertex.
fn simplified() -> Sample {
    let mut set = point_set("simplified", &Family::Rock.points(12, 2));
    set.source_vertices.fill(NO_SOURCE_VERTEX);
    let mut baked = bake_hull(&set, IndexKind::Tree).expect("a rock can be baked");
    baked.outer_error = 0.03;
    let file = write_pack(&[baked], &source()).expect("a small pack can be written");
    Sample { name: "simplified, tree".to_owned(), file }
}

/// A lean pack: a large hull without faces, a small one with faces, and a segment.
fn lean() -> Sample {
    let sets = [&Family::Sphere.points(36, 7)[..], &cube(), &cube()[..2]].map(|points| point_set("lean", points));
    let hulls = sets.iter().map(|set| bake_hull(set, IndexKind::Tree).expect("these points can be baked"));
    let file = write_lean_pack(hulls.collect(), &source()).expect("a small pack can be written");
    Sample { name: "lean, tree".to_owned(), file }
}

/// A cube and two parts of one object, both with the mass of their mesh.
fn meshes() -> Sample {
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let set = PointSet { triangles, ..point_set("cube", &cube()) };
    let solid = bake_hull(&set, IndexKind::Tree).expect("a cube can be baked");
    let mut hulls = vec![solid.clone()];
    for part in 0..2 {
        let mut hull = solid.clone();
        (hull.part, hull.part_count) = (part, 2);
        hulls.push(hull);
    }
    let file = write_pack(&hulls, &source()).expect("a small pack can be written");
    Sample { name: "meshes, tree".to_owned(), file }
}

/// Three convex parts of one object beside a hull of another, as decomposition produces them.
fn parts() -> Sample {
    let mut hulls: Vec<_> = five_hulls()[..4]
        .iter()
        .map(|set| bake_hull(set, IndexKind::Tree).expect("a tetrahedron can be baked"))
        .collect();
    for (part, hull) in hulls[1..].iter_mut().enumerate() {
        (hull.part, hull.part_count, hull.outer_error) = (part as u32, 3, 0.01);
        let protrusion_at = hull.hull.vertices[0].map(f64::from);
        hull.fit = Some(Fit { solid: SolidKind::Closed, uncovered: 0.25, protrusion: 0.125, protrusion_at });
    }
    let file = write_pack(&hulls, &source()).expect("a small pack can be written");
    Sample { name: "parts, tree".to_owned(), file }
}
