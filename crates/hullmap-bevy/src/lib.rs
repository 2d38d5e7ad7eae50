//! Baked hulls in Bevy: packs as assets, and colliders of Avian and bevy_rapier made from them.
//!
//! - [`HullmapPlugin`] loads `.hullmap` files as [`PackAsset`]s.
//! - [`BakedCollider`] is a component that names hulls of a pack. [`ColliderPlugin`] keeps the
//!   engine's collider in step with it: it is built when the pack is loaded, and again when the
//!   file changes (Cargo feature `file_watcher`).
//! - `HullGizmosPlugin` (Cargo feature `gizmos`) draws the edges of hulls.
//!
//! With Avian (Cargo feature `avian`):
//!
//! ```
//! # #[cfg(feature = "avian")] {
//! # use avian3d::prelude::{Collider, PhysicsPlugins, RigidBody};
//! # use bevy_app::{App, Plugin, Startup, TaskPoolPlugin};
//! # use bevy_asset::{AssetPlugin, AssetServer};
//! # use bevy_ecs::{lifecycle::Insert, prelude::*};
//! # use bevy_transform::{TransformPlugin, components::Transform};
//! # use hullmap_bevy::{AvianColliderPlugin, BakedCollider};
//! # struct DefaultPlugins;
//! # impl Plugin for DefaultPlugins {
//! #     fn build(&self, app: &mut App) {
//! #         app.add_plugins((TaskPoolPlugin::default(), bevy_time::TimePlugin, TransformPlugin, AssetPlugin::default()));
//! #     }
//! # }
//! App::new()
//!     .add_plugins((DefaultPlugins, PhysicsPlugins::default(), AvianColliderPlugin::default()))
//!     .add_systems(Startup, |assets: Res<AssetServer>, mut commands: Commands| {
//!         let barrel = BakedCollider::new(assets.load("barrel.hullmap"));
//!         let mut body = commands.spawn((barrel, Transform::from_xyz(0.0, 2.0, 0.0)));
//!         // The body starts to fall when it can collide.
//!         body.observe(|event: On<Insert<Collider>>, mut commands: Commands| {
//!             commands.entity(event.entity).insert_if_new(RigidBody::Dynamic);
//!         });
//!     });
//! # }
//! ```
//!
//! With bevy_rapier (Cargo feature `rapier`), the plugins are `RapierColliderPlugin` and, for
//! contacts by hullmap's solver, `RapierDispatcherPlugin`. `examples/drop.rs` runs both engines.
//!
//! # Frames and units
//!
//! A collider has the frame and units of its pack: the source mesh's, or the ones chosen by `bake
//! build --unit-scale` and `--up-axis`. Render mesh and collider agree if both come from one file.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing))]

mod asset;
#[cfg(feature = "avian")]
mod avian;
mod builder;
mod collider;
#[cfg(feature = "gizmos")]
mod gizmos;
mod loader;
mod plugin;
#[cfg(feature = "rapier")]
mod rapier;

pub use self::asset::{NAMES_IN_ERRORS, PackAsset, Selection, ShapeError};
#[cfg(feature = "avian")]
pub use self::avian::AvianColliderPlugin;
pub use self::builder::{ColliderPlugin, ColliderSystems, EngineCollider};
pub use self::collider::{BakedCollider, ColliderFailure};
#[cfg(feature = "gizmos")]
pub use self::gizmos::{HullGizmos, HullGizmosPlugin};
pub use self::loader::{LoadError, PackLoader};
pub use self::plugin::HullmapPlugin;
#[cfg(feature = "rapier")]
pub use self::rapier::{RapierColliderPlugin, RapierDispatcherPlugin};
