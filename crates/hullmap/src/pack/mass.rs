//! Mass properties of the hulls of a pack as one rigid body.

use super::{NoSuchHull, Pack};
use crate::hull::MassProperties;

impl Pack {
    /// Mass properties of all hulls as one rigid body of uniform `density`, in the frame of the
    /// pack.
    ///
    /// Each object counts with the mass of its mesh, where that is recorded: see
    /// [`Hull::mesh_mass_properties`](crate::Hull::mesh_mass_properties). Convex parts protrude, so
    /// the sum of their masses would be too large. Other objects count with the sum of their hulls.
    /// [`MassProperties::source`] is [`Mesh`](crate::MassSource::Mesh) if every object has the mass
    /// of its mesh.
    ///
    /// # Complexity
    /// O(number of hulls), no allocation.
    pub fn mass_properties(&self, density: f64) -> MassProperties {
        // No index below the count is an error.
        self.mass_properties_of(0..self.hull_count(), density).unwrap_or_default()
    }

    /// Mass properties of some hulls as one rigid body, like
    /// [`mass_properties`](Self::mass_properties) of all. `hulls` are indices in ascending order.
    ///
    /// If all parts of an object are among the hulls, they count together, with the mass of its
    /// mesh. Otherwise they count one by one, with the mass of the hulls.
    ///
    /// # Errors
    /// [`NoSuchHull`] if an index is not below [`hull_count`](Self::hull_count).
    ///
    /// # Complexity
    /// O(number of indices), no allocation.
    pub fn mass_properties_of(
        &self,
        hulls: impl IntoIterator<Item = usize, IntoIter: Clone>,
        density: f64,
    ) -> Result<MassProperties, NoSuchHull> {
        let mut indices = hulls.into_iter();
        let mut body: Option<MassProperties> = None;
        while let Some(index) = indices.next() {
            let hull = self.hull(index)?;
            let count = hull.part_count().max(1) as usize;
            let is_whole =
                hull.part() == 0 && indices.clone().take(count - 1).eq(index + 1..index.saturating_add(count));
            let solid = match hull.mesh_mass_properties(density) {
                Some(mesh) if is_whole => {
                    for _ in 1..count {
                        // The other parts exist, or the pack was not checked.
                        self.hull(indices.next().unwrap_or_default())?;
                    }
                    mesh
                }
                _ => hull.mass_properties(density),
            };
            body = Some(body.map_or(solid, |body| MassProperties::combined([body, solid])));
        }
        Ok(body.unwrap_or_default())
    }
}
