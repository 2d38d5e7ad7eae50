//! Wavefront OBJ, the reference: read twice, by [`scan`] and by tobj.
//!
//! 1. [`scan`] reads every vertex and every reference, in parts side by side, and names the line of any fault.
//! 2. [`cross_check`] has tobj read the same words; the two must agree on every position and reference.

mod cross_check;
mod lines;
mod reference;
mod scan;

use super::fault::LineFault;
use super::limits::Limits;
use super::mesh::{Mesh, Positions};

/// Reads an OBJ file. Vertices are the `v` lines, objects what `o` lines open; the first is what stands before them.
///
/// `wants_double`: whether to keep the digits of f64.
///
/// # Errors
/// The first fault in the file, with its line; references that are too large come after all others.
///
/// # Complexity
/// O(bytes), shared by the threads of the pool.
pub fn read(bytes: &[u8], wants_double: bool, limits: &Limits) -> Result<Mesh, LineFault> {
    let scan = scan::scan(bytes, limits)?;
    cross_check::cross_check(&scan, bytes).map_err(|fault| fault.of_file())?;
    let mut notes = Vec::new();
    if scan.short_face_count > 0 {
        let faces = super::count(scan.short_face_count, "face", "faces");
        notes.push(format!("{faces} with fewer than 3 vertices"));
    }
    if let Some(line) = scan.free_form_line {
        notes.push(format!(
            "line {line}: free-form curves and surfaces are not read; --vertices all takes their control points"
        ));
    }
    let is_grouped = scan.objects.len() == 1 && scan.group_count > 0;
    let positions = if wants_double {
        // One after the other, for the sake of memory.
        drop(scan.positions);
        Positions::Double(scan::doubles(bytes)?)
    } else {
        Positions::Single(scan.positions)
    };
    Ok(Mesh {
        loose: scan.loose,
        objects: scan.objects,
        has_too_many_objects: scan.has_too_many_objects,
        notes,
        has_only_groups: is_grouped,
        ..Mesh::of(positions, scan.faces)
    })
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;

    /// A sphere of a million vertices and two million triangles, each corner with a texture coordinate and a normal.
    fn sphere() -> String {
        const RINGS: usize = 1000;
        let mut text = String::with_capacity(160 << 20);
        for ring in 0..RINGS {
            let (sin, cos) = libm::sincos(std::f64::consts::PI * (ring as f64 + 0.5) / RINGS as f64);
            for step in 0..RINGS {
                let (y, x) = libm::sincos(std::f64::consts::TAU * step as f64 / RINGS as f64);
                text += &format!("v {:.6} {:.6} {cos:.6}\n", sin * x, sin * y);
            }
        }
        for ring in 0..RINGS - 1 {
            for step in 0..RINGS {
                let [a, b] = [step, (step + 1) % RINGS].map(|step| ring * RINGS + step + 1);
                let [c, d] = [a + RINGS, b + RINGS];
                text += &format!("f {a}/{a}/{a} {c}/{c}/{c} {b}/{b}/{b}\nf {b}/{b}/{b} {c}/{c}/{c} {d}/{d}/{d}\n");
            }
        }
        text
    }

    #[test]
    #[ignore = "prints times: cargo test --release -p hullmap-import times_of_a_million -- --ignored --nocapture"]
    fn times_of_a_million_vertices() {
        let text = sphere();
        println!("{} bytes, {} threads", text.len(), rayon::current_num_threads());
        for _ in 0..3 {
            let start = Instant::now();
            let scan = scan::scan(text.as_bytes(), &Limits::DEFAULT).unwrap();
            let scanned = start.elapsed();
            cross_check::cross_check(&scan, text.as_bytes()).unwrap();
            let checked = start.elapsed();
            assert_eq!((scan.positions.len(), scan.faces.len()), (1_000_000, 1_998_000));
            drop(scan);
            let source = crate::SourceFile::alone(text.clone().into_bytes());
            let options = crate::options::ImportOptions::DEFAULT;
            let path = std::path::Path::new("a.obj");
            let start = Instant::now();
            crate::import("a.obj", "a", path, &source, &options, &Limits::DEFAULT).unwrap();
            let whole = start.elapsed();
            println!(
                "scan {scanned:.2?}, tobj {:.2?}, the rest {:.2?}",
                checked - scanned,
                whole.saturating_sub(checked)
            );
        }
    }
}
