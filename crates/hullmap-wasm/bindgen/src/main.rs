//! Writes JavaScript and TypeScript around a WebAssembly module, as the command `wasm-bindgen`
//! does.
//!
//! A program of the workspace, so that its version is locked together with the crate's.

#![forbid(unsafe_code)]

use std::env;
use std::process::ExitCode;

use wasm_bindgen_cli_support::Bindgen;

const USAGE: &str = "usage: hullmap-bindgen MODULE.wasm FOLDER NAME web|no-modules";

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [module, folder, name, target] = arguments.as_slice() else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    let mut bindgen = Bindgen::new();
    bindgen.input_path(module).out_name(name).typescript(target == "web");
    // A panic states its place; names of functions would add a tenth to the module.
    bindgen.remove_name_section(true).remove_producers_section(true);
    let chosen = match target.as_str() {
        // With the place of the module beside the script, so that `init()` needs no argument.
        "web" => bindgen.omit_default_module_path(false).web(true),
        "no-modules" => bindgen.no_modules(true),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match chosen.and_then(|bindgen| bindgen.generate(folder)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{module}: {error:#}");
            ExitCode::FAILURE
        }
    }
}
