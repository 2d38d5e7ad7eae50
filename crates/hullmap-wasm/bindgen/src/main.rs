//! Writes JavaScript and TypeScript around a WebAssembly module, as the command `wasm-bindgen`
//! does.
//!
//! A program of the workspace, so that its version is locked together with the crate's.

#![forbid(unsafe_code)]

use std::path::Path;
use std::process::ExitCode;
use std::{env, fs, io};

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
    let written = chosen.and_then(|bindgen| bindgen.generate(folder)).map_err(|error| format!("{error:#}"));
    let script = Path::new(folder).join(name).with_extension("js");
    match written.and_then(|()| check_arrays(&script).map_err(|error| error.to_string())) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{module}: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Makes the script reject what has no length, where an array of numbers is expected: it would take
/// it as an empty array.
fn check_arrays(script: &Path) -> io::Result<()> {
    let text = fs::read_to_string(script)?;
    let mut checked = String::with_capacity(text.len());
    let mut count = 0;
    for line in text.lines() {
        checked += line;
        checked.push('\n');
        if line.trim_start().starts_with("function passArrayF") && line.ends_with("(arg, malloc) {") {
            count += 1;
            checked += "    if (typeof arg?.length !== 'number') {\n        throw new TypeError('expected an array of \
                        numbers, such as [0, 0, 1]; of an attribute of three.js, its array');\n    }\n";
        }
    }
    if count == 0 {
        return Err(io::Error::other("the script passes no arrays of numbers as expected; adapt `check_arrays`"));
    }
    fs::write(script, checked)
}
