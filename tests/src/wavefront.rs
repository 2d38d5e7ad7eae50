//! A plain reader of valid OBJ files, as a second opinion: `v` lines and the elements that
//! reference them. Positions are read in f64, where the command rounds them to f32.

use std::collections::BTreeSet;

use glam::DVec3;

/// The points of an OBJ file that elements reference, in order; all points if `all`, or if there is
/// no element. Panics if the file is invalid.
pub fn points(text: &str, all: bool) -> Vec<DVec3> {
    let mut vertices = Vec::new();
    let mut referenced = BTreeSet::new();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut numbers = words.map(|word| word.parse::<f64>().expect("a number"));
                vertices.push(DVec3::from_array(std::array::from_fn(|_| numbers.next().expect("three numbers"))));
            }
            Some("f" | "l" | "p") => {
                for word in words {
                    let number: i64 = word.split('/').next().unwrap_or_default().parse().expect("a vertex number");
                    let number = if number < 0 { vertices.len() as i64 + number } else { number - 1 };
                    referenced.insert(usize::try_from(number).expect("a vertex above"));
                }
            }
            _ => {}
        }
    }
    if all || referenced.is_empty() {
        vertices
    } else {
        referenced.into_iter().map(|number| vertices[number]).collect()
    }
}
