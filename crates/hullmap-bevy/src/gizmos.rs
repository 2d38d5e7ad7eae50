//! Draws the edges of hulls. The engines' own debug drawing leaves them out.

use bevy_app::{App, Plugin, PostUpdate};
use bevy_asset::Assets;
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_gizmos::AppGizmoBuilder;
use bevy_gizmos::config::GizmoConfigGroup;
use bevy_gizmos::gizmos::Gizmos;
use bevy_reflect::Reflect;
use bevy_transform::TransformSystems;
use bevy_transform::components::GlobalTransform;

use crate::{BakedCollider, PackAsset};

/// Draws the edges of all hulls of [`BakedCollider`]s, at the entity's transform.
///
/// Needs Bevy's `GizmoPlugin`, which its default plugins have.
///
/// # Complexity
/// O(edges) for each frame.
///
/// Switch it off with `GizmoConfigStore::config_mut::<HullGizmos>().0.enabled`.
#[derive(Clone, Copy, Debug, Default)]
pub struct HullGizmosPlugin;

/// Configuration of the drawing.
#[derive(Clone, Copy, Debug, Reflect, GizmoConfigGroup)]
pub struct HullGizmos {
    /// Colour of the edges.
    pub color: Color,
}

impl Default for HullGizmos {
    fn default() -> Self {
        Self { color: Color::srgb(0.2, 0.8, 0.6) }
    }
}

impl Plugin for HullGizmosPlugin {
    fn build(&self, app: &mut App) {
        app.init_gizmo_group::<HullGizmos>();
        app.add_systems(PostUpdate, draw_hulls.after(TransformSystems::Propagate));
    }
}

fn draw_hulls(
    colliders: Query<(&BakedCollider, &GlobalTransform)>,
    packs: Res<Assets<PackAsset>>,
    mut gizmos: Gizmos<HullGizmos>,
) {
    if !gizmos.config.enabled {
        return;
    }
    let color = gizmos.config_ext.color;
    for (baked, transform) in &colliders {
        let Some(pack) = packs.get(&baked.pack) else { continue };
        for index in pack.select(&baked.hulls).unwrap_or_default() {
            for edge in pack.edges(index) {
                let [start, end] = edge.map(|point| transform.transform_point(point * baked.scale));
                gizmos.line(start, end, color);
            }
        }
    }
}
