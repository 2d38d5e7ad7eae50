//! The `bake` command, run as its users run it.

mod assets;
mod document;
mod export;
mod farm;
mod farm_server;
#[cfg(target_os = "linux")]
mod faults;
#[cfg(unix)]
mod interruptions;
mod meshes;
mod parts;
mod pipeline;
mod queries;
mod remote;
mod remote_hostile;
mod remote_tls;
mod report;
mod sources;
mod subcommands;
#[cfg(unix)]
mod untrusted;
