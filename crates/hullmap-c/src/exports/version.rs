//! Versions, and the message of the last failure.
#![allow(unsafe_code)]

use std::ffi::c_char;

use crate::{failure, types};

/// The version of the library, for instance "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn hullmap_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// The number of the binary interface of the library: HULLMAP_ABI_VERSION of its own header.
#[unsafe(no_mangle)]
pub extern "C" fn hullmap_abi_version() -> u32 {
    types::ABI_VERSION
}

/// The version of the file format that the library reads.
#[unsafe(no_mangle)]
pub extern "C" fn hullmap_format_version() -> u32 {
    hullmap::FORMAT_VERSION
}

/// Message of the last call that failed on this thread: what went wrong, where, and what to do. In
/// UTF-8, at most 1023 bytes; "" if no call has failed. A call that succeeds does not change it.
/// Valid until the next failure on this thread.
#[unsafe(no_mangle)]
pub extern "C" fn hullmap_last_error() -> *const c_char {
    failure::last()
}

/// The name of a HullmapResult in lower case, for instance "not_found"; "unknown" for any other
/// number.
#[unsafe(no_mangle)]
pub extern "C" fn hullmap_result_name(result: u32) -> *const c_char {
    const NAMES: [&str; 9] = [
        "ok\0",
        "null\0",
        "invalid_argument\0",
        "not_found\0",
        "io\0",
        "invalid_pack\0",
        "unsupported\0",
        "busy\0",
        "panic\0",
    ];
    let name = usize::try_from(result).ok().and_then(|result| NAMES.get(result));
    name.unwrap_or(&"unknown\0").as_ptr().cast()
}
