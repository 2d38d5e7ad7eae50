//! `HullmapPlugin`: packs as assets.

use bevy_app::{App, Plugin};
use bevy_asset::{AssetApp, Assets};

use crate::asset::{PackAsset, Selection};
use crate::collider::BakedCollider;
use crate::loader::PackLoader;

/// Registers [`PackAsset`], its loader and [`BakedCollider`].
///
/// Add it after Bevy's `AssetPlugin`. [`ColliderPlugin`](crate::ColliderPlugin) adds it too; adding
/// it twice does nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct HullmapPlugin;

impl Plugin for HullmapPlugin {
    fn build(&self, app: &mut App) {
        if app.world().contains_resource::<Assets<PackAsset>>() {
            return;
        }
        app.init_asset::<PackAsset>()
            .register_asset_reflect::<PackAsset>()
            .init_asset_loader::<PackLoader>()
            .register_type::<Selection>()
            .register_type::<BakedCollider>();
    }

    fn is_unique(&self) -> bool {
        false
    }
}
