//! Gives the shared library the name that programs record (SONAME, install name). The file itself
//! gets that name from the script `install`. The crate hullmap-decompose-c has the same build
//! script.

fn main() {
    println!("cargo:rerun-if-changed=../hullmap-c/build.rs");
    // The library of hullmap-c has the name `hullmap`.
    let name = variable("CARGO_PKG_NAME").replace('-', "_").trim_end_matches("_c").to_owned();
    // Before 1.0, minor versions may break the interface, so the name states both numbers.
    let version = format!("{}.{}", variable("CARGO_PKG_VERSION_MAJOR"), variable("CARGO_PKG_VERSION_MINOR"));
    match variable("CARGO_CFG_TARGET_OS").as_str() {
        "linux" | "freebsd" | "netbsd" | "openbsd" | "dragonfly" | "android" => {
            println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,lib{name}.so.{version}");
        }
        "macos" => println!("cargo:rustc-cdylib-link-arg=-Wl,-install_name,@rpath/lib{name}.{version}.dylib"),
        _ => {}
    }
}

#[expect(clippy::disallowed_methods, reason = "Cargo passes its facts to a build script in this way")]
fn variable(name: &str) -> String {
    std::env::var(name).unwrap_or_default()
}
