//! scratch
use hullmap_bake::*;
use std::time::Instant;
fn main() {
    let n: usize = std::env::args().nth(1).unwrap().parse().unwrap();
    let only = std::env::args().nth(2);
    for f in shapes::families::Family::ALL.iter() {
        let name = f.name();
        if only.as_ref().is_some_and(|o| o != name) {
            continue;
        }
        let positions = f.points(n, 7);
        let k = positions.len();
        let set = PointSet { name: name.into(), source_vertices: (0..k as u32).collect(), positions };
        let t = Instant::now();
        let hull = match hull::build(&set) {
            Ok(h) => h,
            Err(e) => {
                println!("{name} {e}");
                continue;
            }
        };
        let th = t.elapsed().as_secs_f64();
        let t = Instant::now();
        let index = index::build(&hull, IndexKind::Tree).unwrap();
        let ti = t.elapsed().as_secs_f64();
        println!(
            "{name:20} rank {} V {} F {} hull {th:.3}s err {:.1e} index {ti:.3}s slots {} blocks {} B/v {:.0} cost {:?}",
            hull.rank,
            hull.vertices.len(),
            hull.faces.len(),
            hull.containment_error,
            index.encoded.slots.len(),
            index.encoded.blocks.len(),
            (index.encoded.slots.len() * 4 + index.encoded.blocks.len() * 128) as f64 / hull.vertices.len() as f64,
            index.cost
        );
    }
}
