//! The import of OBJ files against two twins: the parser of this crate, and tobj's own reading of
//! the whole file.

use shapes::rng::SplitMix64;

use super::*;
use crate::obj::vertex_line::VertexLine;

const SEED: u64 = 29;

/// Twin of [`positions::singles`]: the coordinates parsed one line after the other, without tobj.
fn parsed_positions(text: &[u8]) -> Vec<[f32; 3]> {
    let mut positions = Vec::new();
    let mut lines = lines::Lines::new(text, 1);
    while let Some((_, line)) = lines.next_logical() {
        let line = String::from_utf8_lossy(&line);
        let mut words = line.split_whitespace();
        if words.next() == Some("v") {
            let vertex = VertexLine::new(words.take_while(|word| !word.starts_with('#'))).unwrap();
            positions.push(vertex.point().unwrap());
        }
    }
    positions
}

fn bits(positions: &Positions) -> Vec<[u32; 3]> {
    let Positions::Single(positions) = positions else { panic!("expected f32") };
    positions.iter().map(|position| position.map(f32::to_bits)).collect()
}

/// Corners of the `f` elements and of the `l` elements, each by the bits of its position.
type Corners = [Vec<[u32; 3]>; 2];

fn without_weights(text: &str) -> String {
    let without = |line: &str| match line.split_whitespace().collect::<Vec<_>>()[..] {
        ["v", x, y, z, _] => format!("v {x} {y} {z}\n"),
        _ => format!("{line}\n"),
    };
    text.split('\n').map(without).collect()
}

fn corners_of_tobj(text: &[u8]) -> Option<Corners> {
    let text = without_weights(&String::from_utf8_lossy(text));
    let no_materials = |_: &std::path::Path| Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &tobj::LoadOptions::default(), no_materials).ok()?;
    let keyword = |line: &str| line.split_whitespace().next().map(str::to_owned);
    let mut keywords = text.lines().filter_map(keyword).filter(|word| word == "f" || word == "l");
    let mut corners = Corners::default();
    for tobj::Model { mesh, .. } in models {
        let triangles = vec![3; mesh.indices.len() / 3];
        let arities = if mesh.face_arities.is_empty() { &triangles } else { &mesh.face_arities };
        let mut indices = mesh.indices.iter();
        for &arity in arities {
            let kind = usize::from(keywords.next().unwrap() == "l");
            let at = |&index: &u32| [0, 1, 2].map(|axis| mesh.positions[3 * index as usize + axis].to_bits());
            corners[kind].extend(indices.by_ref().take(arity as usize).map(at));
        }
    }
    assert_eq!(keywords.next(), None);
    Some(corners)
}

fn corners_of_import(mesh: &SourceMesh) -> Corners {
    let bits = bits(&mesh.positions);
    [&mesh.faces.corners, &mesh.loose].map(|list| list.iter().map(|&vertex| bits[vertex as usize]).collect())
}

/// A file of random coordinates and elements. No element points ahead; tobj reads all statements.
fn random_file(random: &mut SplitMix64) -> String {
    let mut text = String::new();
    let mut vertex_count = 0;
    // tobj rejects files in which only some vertices have a colour.
    let endings = [["", " 2.5", " -0.125e0"], [" 0.5 0.25 1"; 3]][random.below(2)];
    for _ in 0..1 + random.below(60) {
        let kind = if vertex_count == 0 { 0 } else { random.below(8) };
        match kind {
            0..3 => {
                vertex_count += 1;
                let magnitude = [1.0, 1e-3, 1e6, 1e-42, 3e37][random.below(5)];
                let mut number = || random.between(-1.0, 1.0) * magnitude;
                let [x, y, z] = [number(), number(), number()];
                let ending = endings[random.below(3)];
                text += &match random.below(3) {
                    0 => format!("v {x} {y} {z}{ending}\n"),
                    1 => format!("v {x:e} {y:.3} {z:.9}{ending}\r\n"),
                    _ => format!(" \tv  {x:.1}\t{y:.0} -0{ending} \n"),
                };
            }
            3..6 => {
                text += ["f", "l"][usize::from(kind == 5)];
                for _ in 0..1 + random.below(6) {
                    let vertex = 1 + random.below(vertex_count);
                    let form = random.below(4);
                    text += &match form {
                        0 => format!(" {vertex}"),
                        1 => format!(" -{vertex}"),
                        2 => format!(" {vertex}/"),
                        _ => format!(" +{vertex}//"),
                    };
                }
                text.push('\n');
            }
            _ => text += ["o solid\n", "g set\n", "usemtl a\n", "# comment\n", "s off\n", "\n"][random.below(6)],
        }
    }
    text
}

#[test]
fn random_files_agree_with_both_twins() {
    let mut random = SplitMix64::new(SEED);
    let mut corner_counts = [0; 2];
    for round in 0..3000 {
        let text = random_file(&mut random);
        let mesh = read(text.as_bytes(), false, &Limits::DEFAULT).unwrap();
        assert_eq!(bits(&mesh.positions), bits(&Positions::Single(parsed_positions(text.as_bytes()))), "{text}");
        let corners = corners_of_import(&mesh);
        assert_eq!(corners_of_tobj(text.as_bytes()).as_ref(), Some(&corners), "seed {SEED}, round {round}: {text}");
        corner_counts = [0, 1].map(|kind| corner_counts[kind] + corners[kind].len());
    }
    assert!(corner_counts.iter().all(|&count| count > 10_000), "{corner_counts:?}");
}

#[test]
fn damaged_files_agree_with_both_twins_or_are_rejected() {
    let mut random = SplitMix64::new(SEED);
    let (mut read_count, mut compared_count) = (0, 0);
    for round in 0..6000 {
        let mut bytes = random_file(&mut random).into_bytes();
        for _ in 0..=random.below(2) {
            let at = random.below(bytes.len());
            let pieces = ["v ", "f ", "-", "/", " ", "\n", ".", "e9", "0", "1", "nan", "inf", "\u{A0}", "x"];
            match random.below(3) {
                0 => bytes[at] = random.next_u64() as u8 & 0x7F,
                1 if bytes.len() > 1 => drop(bytes.remove(at)),
                _ => drop(bytes.splice(at..at, pieces[random.below(pieces.len())].bytes())),
            }
        }
        let Ok(mesh) = read(&bytes, false, &Limits::DEFAULT) else { continue };
        read_count += 1;
        let at = format!("seed {SEED}, round {round}: {}", bytes.escape_ascii());
        assert_eq!(bits(&mesh.positions), bits(&Positions::Single(parsed_positions(&bytes))), "{at}");
        // tobj reads comments behind numbers, continued lines, lone CRs and `p` elements otherwise.
        let text = String::from_utf8_lossy(&bytes).replace("\r\n", "\n").replace("\n# comment\n", "\n");
        let is_beyond_tobj = text.contains(['#', '\\', 'p', '\r']);
        if !is_beyond_tobj && let Some(corners) = corners_of_tobj(&bytes) {
            assert_eq!(corners_of_import(&mesh), corners, "{at}");
            compared_count += 1;
        }
    }
    assert!(read_count > 1000 && compared_count > 500, "{read_count} read, {compared_count} compared");
}

#[test]
fn committed_models_agree_with_both_twins() {
    let mut compared_count = 0;
    let assets = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets")).unwrap();
    let paths = assets.map(|entry| entry.unwrap().path());
    for path in paths.filter(|path| path.extension().is_some_and(|own| own == "obj")) {
        let (bytes, name) = (std::fs::read(&path).unwrap(), path.display());
        let mesh = read(&bytes, false, &Limits::DEFAULT).unwrap();
        assert_eq!(bits(&mesh.positions), bits(&Positions::Single(parsed_positions(&bytes))), "{name}");
        let text = String::from_utf8(bytes.clone()).unwrap();
        if !text.lines().any(|line| line.starts_with("p ")) {
            assert_eq!(Some(corners_of_import(&mesh)), corners_of_tobj(&bytes), "{name}");
            compared_count += 1;
        }
    }
    assert!(compared_count >= 10, "{compared_count}");
}

#[test]
fn batches_and_parts_keep_every_vertex() {
    for count in [1, 2, 3, 4095, 4096, 4097, 12_289] {
        let text: String = (0..count).map(|i| format!("v {i} 0.1 -{i}e-7\n")).collect();
        for part_bytes in [100, 30_000, usize::MAX] {
            let parts = Parts::new(text.as_bytes(), part_bytes).unwrap();
            let mesh = read_parts(&parts, false, &Limits::DEFAULT).unwrap();
            let expected = bits(&Positions::Single(parsed_positions(text.as_bytes())));
            assert_eq!(bits(&mesh.positions), expected, "{count} in {part_bytes}");
        }
    }
}

/// References ahead of more corners than one batch were once rejected.
#[test]
fn references_ahead_resolve_over_any_distance() {
    let mut text = "f 1 2 3\n".repeat(40_000);
    text += "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    assert_eq!(read(text.as_bytes(), false, &Limits::DEFAULT).unwrap().faces.len(), 40_000);
}

#[test]
fn the_first_fault_is_reported_whichever_step_finds_it() {
    let line = |text: &str, is_double| read(text.as_bytes(), is_double, &Limits::DEFAULT).unwrap_err().line;
    for is_double in [false, true] {
        assert_eq!(line("v 0 0 0\nv 0 x 0\nf 0\n", is_double), Some(2));
        assert_eq!(line("v 0 0 0\nf 0\nv 0 x 0\n", is_double), Some(2));
        assert_eq!(line("v 0 0 0\nf 1\nf 9\nv 0 nan 0\n", is_double), Some(4));
        assert_eq!(line("v 0 0 0\nv 1 2 3 x\n", is_double), Some(2));
    }
    // Only f32 overflows.
    assert_eq!(line("v 0 0 0\nv 1e39 0 0\n", false), Some(2));
    assert!(read(b"v 1e39 0 0\n", true, &Limits::DEFAULT).is_ok());
}

#[test]
fn doubles_round_to_the_singles() {
    let mut random = SplitMix64::new(SEED);
    let mut point_count = 0;
    for _ in 0..300 {
        let text = random_file(&mut random);
        let read = |is_double| read(text.as_bytes(), is_double, &Limits::DEFAULT).unwrap().positions;
        let (Positions::Single(singles), Positions::Double(doubles)) = (read(false), read(true)) else {
            panic!("the wrong precision")
        };
        assert_eq!(singles.len(), doubles.len());
        for (double, single) in doubles.iter().zip(&singles) {
            assert_eq!(double.map(|x| x as f32), *single);
            point_count += 1;
        }
    }
    assert!(point_count > 2000, "{point_count}");
}
