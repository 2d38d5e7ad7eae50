//! Programs in C and C++ against the library, if there is a compiler: the headers in each language
//! version, and parts of small meshes.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Warnings that a user may have switched on.
const WARNINGS: [&str; 4] = ["-Wall", "-Wextra", "-pedantic", "-Werror"];

fn crate_path(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A compiler: from the environment variable, or the usual one. `None` if it does not run.
#[expect(clippy::disallowed_methods, reason = "the machine says which compiler it has")]
fn compiler(variable: &str, usual: &str) -> Option<String> {
    let name = env::var(variable).ok().filter(|name| !name.is_empty()).unwrap_or_else(|| usual.to_owned());
    let runs = Command::new(&name).arg("--version").output().is_ok_and(|output| output.status.success());
    if !runs {
        println!("skipped: {usual} does not run; set {variable}");
    }
    runs.then_some(name)
}

fn run(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{command:?}: {}\n{out}{err}", output.status);
    out.into_owned()
}

/// Each header compiles without a warning, alone and twice.
#[test]
fn headers_compile_in_each_language_version() {
    let folder = tempfile::tempdir().unwrap();
    let check = |compiler: &str, header: &str, file: &str, standards: &[&str]| {
        let source = folder.path().join(file);
        fs::write(&source, format!("#include <{header}>\n#include <{header}>\n")).unwrap();
        for standard in standards {
            let mut command = Command::new(compiler);
            run(command.args(WARNINGS).args([standard, "-fsyntax-only", "-I"]).arg(crate_path("include")).arg(&source));
        }
    };
    if let Some(cc) = compiler("CC", "cc") {
        check(&cc, "hullmap_decompose.h", "c.c", &["-std=c99", "-std=c11", "-std=c17"]);
    }
    if let Some(cxx) = compiler("CXX", "c++") {
        check(&cxx, "hullmap_decompose.h", "cpp.cpp", &["-std=c++11", "-std=c++17"]);
        check(&cxx, "hullmap_vhacd.hpp", "vhacd.cpp", &["-std=c++11", "-std=c++17", "-std=c++20"]);
    }
}

#[test]
#[cfg_attr(not(unix), ignore = "the script `install` is for Unix")]
fn programs_run_against_the_installed_library() {
    let (Some(cc), Some(cxx)) = (compiler("CC", "cc"), compiler("CXX", "c++")) else { return };
    let folder = tempfile::tempdir().unwrap();
    // Where Cargo has built this test and the libraries.
    let built = env::current_exe().unwrap().parent().unwrap().to_owned();
    let prefix = folder.path().join("prefix");
    run(Command::new(crate_path("install")).arg(&prefix).arg("--no-symbols").arg("--from").arg(built));
    let pc = fs::read_to_string(prefix.join("lib/pkgconfig/hullmap_decompose.pc")).unwrap();
    assert!(pc.contains("-lhullmap_decompose") && !pc.contains('@'), "{pc}");
    let licences = prefix.join("share/licenses/hullmap_decompose");
    assert!(licences.join("LICENSES-OF-DEPENDENCIES.txt").exists() && licences.join("LICENSE-MIT").exists());
    let libraries = prefix.join("lib");
    let library_path = if cfg!(target_os = "macos") { "DYLD_LIBRARY_PATH" } else { "LD_LIBRARY_PATH" };
    for (compiler, options, source) in [
        (&cc, &["-std=c99"][..], "tests/c/parts.c"),
        (&cxx, &["-std=c++11"], "tests/c/vhacd.cpp"),
        (&cxx, &["-std=c++11", "-DHULLMAP_VHACD_4_0"], "tests/c/vhacd.cpp"),
    ] {
        let program = folder.path().join(Path::new(source).file_stem().unwrap());
        let mut command = Command::new(compiler);
        command.args(WARNINGS).args(options).arg(crate_path(source)).arg("-I").arg(prefix.join("include"));
        command.arg("-L").arg(&libraries).args(["-lhullmap_decompose", "-lm", "-pthread", "-o"]).arg(&program);
        run(&mut command);
        let out = run(Command::new(&program).env(library_path, &libraries));
        assert!(out.contains(" checks, 0 failures\n"), "{source} {options:?}: {out}");
    }
}
