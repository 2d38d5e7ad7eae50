//! Hulls and triangle meshes as OBJ text. Each hull is an object of triangles, or of a line or
//! point element. Coordinates read back as the same `f32`, also through `f64`.

use std::fmt::Write as _;

use super::body::Body;
use super::names::line;
use super::seal::{SEAL, sealed};

/// Start of every file, by which `bake robot` recognises its own hulls.
pub const START: &str = "# Convex hulls, exported by bake";

/// The file. With `has_groups`, each object is a group too: Unreal makes a mesh of each group.
pub fn write(bodies: &[Body], has_groups: bool) -> Vec<u8> {
    sealed([format!("# Convex hulls, {SEAL}\n").as_bytes(), &objects(bodies, has_groups, 0)].concat())
}

pub fn objects(bodies: &[Body], has_groups: bool, before: usize) -> Vec<u8> {
    let mut text = String::new();
    // OBJ counts from 1, over all objects.
    let mut first = 1 + before as u64;
    for body in bodies {
        let name = line(&body.name);
        text += &format!("o {name}\n");
        if has_groups {
            text += &format!("g {name}\n");
        }
        push_vertices(&mut text, &body.positions);
        match body.rank {
            0 => push_element(&mut text, "p", first..first + 1),
            1 => push_element(&mut text, "l", first..first + body.positions.len() as u64),
            _ => {
                for corners in body.triangles() {
                    push_element(&mut text, "f", corners.into_iter().map(|corner| first + u64::from(corner)));
                }
            }
        }
        first += body.positions.len() as u64;
    }
    text.into_bytes()
}

/// Materials are named by their numbers: the file has no names.
pub fn write_triangles(body: &Body, materials: &[u16]) -> Vec<u8> {
    let mut text = format!("# Triangle mesh, {SEAL}\no {}\n", line(&body.name));
    push_vertices(&mut text, &body.positions);
    let mut current = 0;
    for (corners, material) in body.triangles().zip(materials) {
        if *material != current {
            current = *material;
            // Without a name, the faces have no material.
            let name = if current == 0 { String::new() } else { format!(" material_{current}") };
            text += &format!("usemtl{name}\n");
        }
        push_element(&mut text, "f", corners.into_iter().map(|corner| 1 + u64::from(corner)));
    }
    sealed(text.into_bytes())
}

/// The file of a mesh that a robot's description contains: its triangles, or its vertices if it has
/// none.
pub fn write_inline(name: &str, vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<u8> {
    let mut text = format!("# Mesh of a robot, written by bake robot\no {}\n", line(name));
    push_vertices(&mut text, vertices);
    for corners in triangles {
        push_element(&mut text, "f", corners.iter().map(|corner| 1 + u64::from(*corner)));
    }
    if triangles.is_empty() {
        push_element(&mut text, "p", 1..=vertices.len() as u64);
    }
    text.into_bytes()
}

fn push_vertices(text: &mut String, positions: &[[f32; 3]]) {
    for position in positions {
        text.push('v');
        for coordinate in position {
            text.push(' ');
            push_decimal(text, *coordinate);
        }
        text.push('\n');
    }
}

fn push_element(text: &mut String, keyword: &str, vertices: impl Iterator<Item = u64>) {
    text.push_str(keyword);
    for vertex in vertices {
        let _ = write!(text, " {vertex}");
    }
    text.push('\n');
}

/// Appends a number. The shortest decimal of 7.038531e-26 lies so close to the middle between two
/// `f32` that rounding to `f64` first gives its neighbour; such numbers are written in full.
fn push_decimal(text: &mut String, number: f32) {
    let start = text.len();
    let _ = write!(text, "{number}");
    let is_same = text[start..].parse::<f64>().is_ok_and(|read| (read as f32).to_bits() == number.to_bits());
    if !is_same {
        text.truncate(start);
        let _ = write!(text, "{}", f64::from(number));
    }
}

#[cfg(test)]
mod tests {
    use super::super::body::cube;
    use super::*;

    #[test]
    fn decimals_keep_their_bits_on_both_ways() {
        let special = [0.0, -0.0, 1.0, 0.1, f32::MAX, f32::MIN_POSITIVE, f32::from_bits(1), 7.038_531e-26, -1.0e-3];
        let spread = (0..200_000_u32).map(|index| f32::from_bits(index.wrapping_mul(2_654_435_761)));
        let mut long = 0;
        for number in special.into_iter().chain(spread).filter(|number| number.is_finite()) {
            let mut text = String::new();
            push_decimal(&mut text, number);
            assert_eq!(text.parse::<f32>().unwrap().to_bits(), number.to_bits(), "{text}");
            assert_eq!((text.parse::<f64>().unwrap() as f32).to_bits(), number.to_bits(), "{text}");
            long += usize::from(text != number.to_string());
        }
        assert!((1..10).contains(&long), "{long} numbers in full");
    }

    #[test]
    fn objects_count_their_vertices_from_the_first_of_the_file() {
        let segment =
            Body { rank: 1, positions: vec![[0.0; 3], [0.5, 0.0, 1e-3]], polygons: Vec::new(), ..cube("a\nb") };
        let point = Body { rank: 0, positions: vec![[1.0; 3]], polygons: Vec::new(), ..cube("p") };
        let text = String::from_utf8(write(&[segment, point, cube("c")], true)).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let expected = ["o a_b", "g a_b", "v 0 0 0", "v 0.5 0 0.001", "l 1 2", "o p", "g p", "v 1 1 1", "p 3", "o c"];
        assert_eq!(lines[1..11], expected);
        assert_eq!((lines[20], lines.len()), ("f 4 8 10", 20 + 12), "{text}");
    }
}
