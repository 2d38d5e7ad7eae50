//! The crate in headless apps: packs are loaded, dropped, changed on disk and damaged.

#[cfg(feature = "avian")]
mod avian;
mod colliders;
#[cfg(feature = "gizmos")]
mod gizmos;
mod packs;
#[cfg(feature = "rapier")]
mod rapier;
mod reload;
mod saved;
mod stage;
