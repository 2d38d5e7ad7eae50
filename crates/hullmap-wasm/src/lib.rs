//! hullmap for the browser: bakes meshes into packs, opens packs, and answers queries on hulls.
//!
//! This is the border to JavaScript. Numbers go in and out as typed arrays, answers as plain
//! objects, errors as `Error` with the message of the Rust library. The npm package made of it
//! (`./build`) has TypeScript types.
//!
//! | module | concept |
//! |---|---|
//! | `bake` | a mesh file or arrays to a pack |
//! | `options` | options of a bake: a JavaScript object to the options of the command |
//! | `pack` | packs and hulls |
//! | `level` | triangle meshes and height fields |
//! | `shape` | bodies of queries; rays |
//! | `pair` | queries on two bodies |
//! | `motion` | two bodies of which one moves and turns |
//! | `object` | answers as plain JavaScript objects |

#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod bake;
mod level;
mod motion;
mod object;
mod options;
mod pack;
mod pair;
mod shape;

use wasm_bindgen::prelude::*;

pub use bake::{Baked, bake, bake_mesh};
pub use level::Level;
pub use motion::pose_between;
pub use pack::{Hull, Pack};
pub use pair::QueryPair;
pub use shape::Shape;

#[wasm_bindgen]
extern "C" {
    #[wasm_bindgen(js_namespace = console, js_name = error)]
    fn console_error(text: &str);
}

/// Writes the message of a panic to the console: the exception says only `unreachable`.
#[wasm_bindgen(start)]
pub fn start() {
    std::panic::set_hook(Box::new(|panic| {
        console_error(&format!("hullmap: internal error, please report it: {panic}"));
    }));
}

/// Version of the package.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}
