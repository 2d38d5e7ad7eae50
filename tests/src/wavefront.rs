//! A plain reader of OBJ files: positions as the decimal text has them, in f64, where the command rounds them to f32.
//!
//! It knows `v` lines and the elements that name them, and no errors: it is a second opinion on files that are sound.

use std::collections::BTreeSet;

use glam::DVec3;

/// The points of an OBJ file that elements reference (all of them where nothing does, or if `all`), in order.
///
/// # Panics
/// On a file that is not sound.
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
