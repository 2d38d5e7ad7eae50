//! The `bake` command, run as its users run it.

#[cfg(target_os = "linux")]
mod cases;
mod document;
mod export;
#[cfg(target_os = "linux")]
mod faults;
#[cfg(unix)]
mod interruptions;
mod meshes;
mod parts;
mod pipeline;
mod primitives;
mod robot;
mod surfaces;
#[cfg(unix)]
mod untrusted;
