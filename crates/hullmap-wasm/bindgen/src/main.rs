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
    match written.and_then(|()| add_checks(&script).map_err(|error| error.to_string())) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{module}: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Functions that [`add_checks`] puts into a script.
const CHECKS: &str = include_str!("../../npm/checks.js");

/// Where the functions of [`CHECKS`] are called: a line of the script, and what replaces it. An
/// array without a length would be taken as an empty one, and a call before `init` or of a freed
/// object would fail with a message about neither.
const CALLS: [(&str, &str); 5] = [
    (
        "function passArrayF32ToWasm0(arg, malloc) {",
        "function passArrayF32ToWasm0(arg, malloc) {\n    arg = numbersOf(arg);",
    ),
    (
        "function passArrayF64ToWasm0(arg, malloc) {",
        "function passArrayF64ToWasm0(arg, malloc) {\n    arg = numbersOf(arg);",
    ),
    ("let wasmModule, wasmInstance, wasm;", "let wasmModule, wasmInstance, wasm = notLoaded();"),
    ("if (wasm !== undefined) return wasm;", "if (wasmInstance !== undefined) return wasm;"),
    (
        "throw new Error(getStringFromWasm0(arg0, arg1));",
        "throw new Error(withRemedy(getStringFromWasm0(arg0, arg1)));",
    ),
];

/// Adds the checks to a script of wasm-bindgen.
fn add_checks(script: &Path) -> io::Result<()> {
    let mut text = fs::read_to_string(script)?;
    for (line, checked) in CALLS {
        // A module need not pass arrays of both kinds.
        if !text.contains(line) && !line.contains("F32") {
            return Err(io::Error::other(format!("the script has no line `{line}`; adapt `CALLS`")));
        }
        text = text.replace(line, checked);
    }
    let start = "function __wbg_get_imports() {";
    let at = text.find(start).ok_or_else(|| io::Error::other(format!("the script has no line `{start}`")))?;
    text.insert_str(at, CHECKS);
    fs::write(script, text)
}
