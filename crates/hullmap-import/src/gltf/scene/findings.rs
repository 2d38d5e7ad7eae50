use std::collections::HashSet;

use crate::fault::{counted, excerpt};
use crate::gltf::physics::ROUND_ERROR;

/// Findings about the colliders that were read.
#[derive(Debug, Default)]
pub struct Findings {
    pub count: usize,
    pub meshes: HashSet<u32>,
    round_count: usize,
    /// Name of the first collider whose triangles count, and the number of such colliders.
    concave: Option<(String, usize)>,
    /// The first collider without a hull, why, and the number of such colliders.
    unusable: Option<(String, usize)>,
}

impl Findings {
    pub fn add_concave(&mut self, name: &str) {
        self.concave.get_or_insert_with(|| (excerpt(name), 0)).1 += 1;
    }

    pub fn add_unusable(&mut self, label: &str, text: &str) {
        self.unusable.get_or_insert_with(|| (format!("{label} has {text}"), 0)).1 += 1;
    }

    /// Counts an implicit shape of this many points. More points than a box has mean a round shape.
    pub fn add_points(&mut self, count: usize) {
        self.round_count += usize::from(count > 8);
    }

    pub fn notes(&self) -> Vec<String> {
        let share = 100.0 * ROUND_ERROR;
        let round = format!(
            "round colliders, read as hulls of points on their surfaces, up to {share} % of the radius inside: {}",
            self.round_count
        );
        (self.round_count > 0).then_some(round).into_iter().collect()
    }

    pub fn warnings(&self) -> Vec<String> {
        let concave = self.concave.as_ref().map(|(name, count)| {
            format!(
                "{} of triangles (the first is {name}): this pack has convex hulls instead; bake such meshes with --decompose",
                counted(count, "collider is", "colliders are")
            )
        });
        let unusable = self.unusable.as_ref().map(|(first, count)| {
            format!("{} left out: {first}; replace it by a box or a mesh", counted(count, "collider", "colliders"))
        });
        concave.into_iter().chain(unusable).collect()
    }
}
