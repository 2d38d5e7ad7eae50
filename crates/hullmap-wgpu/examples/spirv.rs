//! Writes the kernels as SPIR-V, one file for each entry point, for the tools that read it.
//!
//!     cargo run --example spirv -- FOLDER
//!
//! `tests/registers` counts registers with them.

use std::path::PathBuf;

use wgpu::naga::{back::spv, front::wgsl, valid};

macro_rules! kernels {
    ($($name:literal),*) => { concat!($(include_str!(concat!("../src/kernels/", $name, ".wgsl"))),*) };
}

const MODULES: [(&str, &[&str]); 3] = [
    (kernels!("records", "support", "simplex", "gjk"), &["solve_pairs"]),
    (kernels!("records", "support", "simplex", "epa"), &["expand_pairs"]),
    (kernels!("records", "support", "vertices"), &["find_vertices"]),
];

#[expect(clippy::disallowed_methods, reason = "a program has arguments")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("the folder is missing")?);
    std::fs::create_dir_all(&folder)?;
    for (source, entry_points) in MODULES {
        let module = wgsl::parse_str(source)?;
        let flags = valid::ValidationFlags::all();
        let info = valid::Validator::new(flags, valid::Capabilities::default()).validate(&module)?;
        for entry_point in entry_points {
            let pipeline = spv::PipelineOptions {
                shader_stage: wgpu::naga::ShaderStage::Compute,
                entry_point: (*entry_point).to_owned(),
            };
            let words = spv::write_vec(&module, &info, &spv::Options::default(), Some(&pipeline))?;
            let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
            let file = folder.join(format!("{entry_point}.spv"));
            println!("{}: {} bytes", file.display(), bytes.len());
            std::fs::write(file, bytes)?;
        }
    }
    Ok(())
}
