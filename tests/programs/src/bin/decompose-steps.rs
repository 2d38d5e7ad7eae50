//! Prints the number of parts of decompositions by maximum error; reports rises and thin parts.
//!
//! ```text
//! cargo run --release -p hullmap-programs --bin concave-meshes -- --write FOLDER
//! cargo run --release -p hullmap-programs --bin decompose-steps -- FOLDER
//! ```
//!
//! A row is a mesh, a column a maximum error in percent of the diagonal. A cell has the number of
//! parts, in parentheses how many of them are thin, and the number of vertices. A rise is a larger
//! error that takes more parts, or as many parts with more vertices. A part is thin if twice its
//! volume is less than a thousandth of its diameter times half its area. A rise or a thin part ends
//! the program with status 1.

use std::{path::PathBuf, process::ExitCode};

use clap::Parser;
use hullmap_bake::{
    decompose::{Cover, Length, decompose},
    hull, mass,
};
use hullmap_outside::clock::timed;
use hullmap_programs::meshes_of;

/// Number of parts by maximum error.
#[derive(Parser)]
struct Arguments {
    /// Folder of OBJ files
    folder: PathBuf,
    /// Maximum errors, in percent of the diagonal, ascending
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "0.5,0.6,0.7,0.8,0.9,1,1.2,1.4,1.7,2,2.3,2.6,3,3.5,4,5,6,7,8.5,10"
    )]
    errors: Vec<f64>,
    /// Only meshes whose name contains this
    #[arg(long, default_value = "")]
    only: String,
}

/// Thickness below which a part is thin, relative to its diameter.
const THIN: f64 = 1e-3;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    // The processor time of a thread does not include its pool.
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread can be started");
    let (mut rises, mut thin, mut cells) = (0, 0, 0);
    println!("mesh | {} | seconds", arguments.errors.iter().map(f64::to_string).collect::<Vec<_>>().join(" | "));
    for (name, mesh) in meshes_of(&arguments.folder, &arguments.only) {
        let mut last = None;
        let (mut row, mut total) = (Vec::new(), 0.0);
        for error in &arguments.errors {
            let cover = Cover { max_error: Length::Relative(0.01 * error), ..Cover::default() };
            let (parts, seconds) = one.install(|| timed(|| decompose(&mesh, &cover)));
            total += seconds;
            let Some(parts) = parts.expect("the mesh can be decomposed") else { continue };
            let hulls = parts.iter().map(|part| hull::build(part).expect("a part has a hull"));
            let hulls: Vec<_> = hulls.collect();
            let is_thin = |hull: &&hull::Hull| {
                let mass = mass::mass(hull);
                4.0 * mass.volume < THIN * hull.diameter * mass.surface_area
            };
            let slivers = hulls.iter().filter(is_thin).count();
            let size = (hulls.len(), hulls.iter().map(|hull| hull.vertices.len()).sum::<usize>());
            let is_rise = last.is_some_and(|last| size > last);
            (rises, thin, cells) = (rises + usize::from(is_rise), thin + slivers, cells + 1);
            last = Some(size);
            let slivers = if slivers > 0 { format!(" ({slivers})") } else { String::new() };
            row.push(format!("{}{}{slivers}/{}", if is_rise { "↑" } else { "" }, size.0, size.1));
        }
        println!("{name} | {} | {total:.1}", row.join(" | "));
    }
    println!("{cells} decompositions: {rises} rises, {thin} thin parts");
    if rises + thin == 0 && cells > 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
