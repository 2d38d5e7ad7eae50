//! Triangle meshes and height fields with wrong contents, which `bake verify` finds.
//! `tests/cases/surfaces.md` has what the command prints.

use std::fs;
use std::path::Path;

use hullmap::TriangleMesh;
use hullmap_bake::{
    SourceRecord,
    triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh},
};
use hullmap_format::{header::HEADER_LEN, triangle_mesh::sections::Sections};
use hullmap_testkit::command::bake_line as run;
use hullmap_testkit::{files::folder, packs::reseal};
use hullmap_tests::hostile::patch::payload;
use shapes::rng::SplitMix64;
use tempfile::TempDir;

const SEED: u64 = 39;

/// A rough floor of squares in y-up, with two materials and a part without one.
fn level(cells: usize) -> String {
    let mut rng = SplitMix64::new(SEED);
    let mut text = String::new();
    for z in 0..=cells {
        for x in 0..=cells {
            text += &format!("v {x} {:.3} {z}\n", rng.unit());
        }
    }
    for z in 0..cells {
        match z {
            1 => text += "usemtl rock\n",
            2 => text += "usemtl wet grass\n",
            _ => {}
        }
        for x in 0..cells {
            let first = 1 + z * (cells + 1) + x;
            text += &format!("f {first} {} {} {}\n", first + cells + 1, first + cells + 2, first + 1);
        }
    }
    text
}

/// Writes the triangles of the level to a file that claims to be of `in/level.obj`, after a change.
fn forged(folder: &TempDir, change: impl Fn(&mut Vec<[f32; 3]>, &mut Vec<[u32; 3]>, &mut Vec<u16>)) {
    let path = folder.path().join("o/level.hullmesh");
    let mesh = TriangleMesh::open(&path).unwrap();
    let mut positions: Vec<[f32; 3]> = (0..mesh.vertex_count()).map(|v| mesh.vertex(v).unwrap().to_array()).collect();
    let mut order: Vec<usize> = (0..mesh.triangle_count()).collect();
    order.sort_by_key(|triangle| mesh.source_triangle(*triangle));
    let mut corners: Vec<[u32; 3]> = order.iter().map(|t| mesh.corners(*t).unwrap()).collect();
    let mut materials: Vec<u16> = order.iter().map(|t| mesh.material(*t).unwrap()).collect();
    change(&mut positions, &mut corners, &mut materials);
    let source = SourceRecord {
        path: mesh.source_path().to_owned(),
        hash: mesh.header().source_hash,
        options: mesh.options().to_owned(),
        warnings: Vec::new(),
    };
    let triangles = Triangles { positions: &positions, corners: &corners, materials: &materials };
    let baked = bake_triangle_mesh(&triangles).unwrap();
    fs::write(path, write_triangle_mesh(baked, &source).unwrap()).unwrap();
}

/// Bytes of a section of a file, by its place in the payload.
fn place<T>(payload: &[u8], section: &[T]) -> usize {
    section.as_ptr().addr() - payload.as_ptr().addr()
}

/// Changes bytes of the payload, and gives the file a checksum that fits.
fn patched(path: &Path, change: impl Fn(&Sections, &mut Vec<(usize, u8)>, &[u8])) {
    let mut file = fs::read(path).unwrap();
    let (payload, mut changes) = (payload(&file), Vec::new());
    change(&Sections::read(&payload).unwrap(), &mut changes, &payload);
    changes.into_iter().for_each(|(place, byte)| file[HEADER_LEN + place] = byte);
    reseal(&mut file);
    fs::write(path, file).unwrap();
}

/// Wrong contents in every section that a mesh has, in files that open.
#[test]
fn verify_finds_what_is_wrong_in_each_section() {
    let folder = folder(&[("in/level.obj", &level(6))]);
    let path = folder.path().join("o/level.hullmesh");
    let fresh = || drop(run(&folder, "build in --out o --keep-triangles --force").expect(0));
    let fails = |name: &str, expected: &str| {
        let run = run(&folder, "verify o --directions 200 --json").expect(1);
        let row = run.json().remove(0);
        let problems = row["problems"].to_string();
        assert!(problems.contains(expected), "{name}: {problems}");
        assert!(row["mismatches"].as_u64().unwrap() > 0, "{row}");
    };
    fresh();
    run(&folder, "verify o --require-source").expect(0);
    for (name, change, expected) in [
        (
            "vertices",
            (|p, _, _| p[20][1] += 0.25) as fn(&mut Vec<[f32; 3]>, &mut Vec<[u32; 3]>, &mut Vec<u16>),
            "differs",
        ),
        ("triangles", |_, c, _| c[7].swap(0, 1), "differs"),
        (
            "missing",
            |_, c, m| {
                c.truncate(70);
                m.truncate(70);
            },
            "number of triangles",
        ),
        ("source_triangles", |_, c, _| c.swap(3, 40), "differs"),
        ("materials", |_, _, m| m[70] = 9, "material of triangle"),
    ] {
        fresh();
        forged(&folder, change);
        fails(name, expected);
    }
    fresh();
    patched(&path, |sections, changes, payload| {
        // An inner edge becomes a border, on both sides.
        let (triangle, edge, beyond) = (0..72)
            .flat_map(|triangle| (0..3).map(move |edge| (triangle, edge)))
            .find_map(|(triangle, edge)| {
                let beyond = sections.neighbours[triangle][edge].to_native();
                (beyond != u32::MAX).then_some((triangle, edge, beyond as usize))
            })
            .unwrap();
        let back = (0..3).find(|back| sections.neighbours[beyond][*back].to_native() as usize == triangle).unwrap();
        for (triangle, edge) in [(triangle, edge), (beyond, back)] {
            let at = place(payload, sections.neighbours) + 12 * triangle + 4 * edge;
            changes.extend((at..at + 4).map(|at| (at, u8::MAX)));
            let classes = sections.edge_classes[triangle].to_native() & !(15 << (4 * edge));
            let at = place(payload, sections.edge_classes) + 2 * triangle;
            changes.extend(classes.to_le_bytes().iter().zip(at..).map(|(byte, at)| (at, *byte)));
        }
    });
    fails("neighbours", "neighbour of triangle");
    fresh();
    patched(&path, |sections, changes, payload| {
        let class = sections.vertex_classes[5];
        changes.push((place(payload, sections.vertex_classes) + 5, if class == 0 { 1 } else { 0 }));
    });
    fails("vertex_classes", "class of vertex 5");
    fresh();
    patched(&path, |sections, changes, payload| {
        // After the bounds.
        changes.push((place(payload, sections.records) + 24, 7));
    });
    fails("records", "number of degenerate triangles");
    // Boxes are checked when the file is opened.
    fresh();
    patched(&path, |sections, changes, payload| changes.push((place(payload, sections.boxes), 3)));
    let row = run(&folder, "verify o --json").expect(1).json().remove(0);
    assert!(row["problems"].to_string().contains("box"), "{row}");
}

/// Other heights, a filled hole and a moved grid, in files that claim the same source.
#[test]
fn verify_finds_what_is_wrong_in_a_field() {
    let grid = |from: &str, to: &str| {
        "ncols 4\nnrows 3\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -1\n8 9 10 11\n4 5 6 -1\n0 1 2 3\n"
            .replace(from, to)
    };
    let folder = folder(&[("in/dem.asc", &grid(" ", " "))]);
    let path = folder.path().join("o/dem.hullfield");
    run(&folder, "build in/dem.asc --out o --terrain").expect(0);
    let good = fs::read(&path).unwrap();
    for (from, to, expected) in [
        ("8 9 10 11", "8 9 12 11", "differs: heights"),
        ("4 5 6 -1", "4 5 6 7", "ground instead of a hole"),
        ("xllcorner 100", "xllcorner 101", "grid: Layout"),
    ] {
        fs::write(folder.path().join("in/dem.asc"), grid(from, to)).unwrap();
        run(&folder, "build in/dem.asc --out o --terrain").expect(0);
        let mut forged = fs::read(&path).unwrap();
        forged[24..40].copy_from_slice(&good[24..40]);
        reseal(&mut forged);
        fs::write(&path, &forged).unwrap();
        fs::write(folder.path().join("in/dem.asc"), grid(" ", " ")).unwrap();
        for line in ["verify o", "report o --out page.html --directions 50"] {
            let run = run(&folder, line).expect(1);
            assert!(format!("{run:?}").contains(expected), "{line}: {run:?}");
        }
    }
}
