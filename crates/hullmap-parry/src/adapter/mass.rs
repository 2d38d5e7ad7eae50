//! Mass properties, from the values in the pack.
//!
//! parry adds the masses of the parts of a compound, and parts of a mesh overlap. So the first part
//! of an object has the mass of the whole mesh, and the other parts have none.

use hullmap::MassProperties as Mass;

use super::baked_hull::{BakedHull, PartMass};
use super::convert::{narrow, real};
use super::parry::mass_properties::MassProperties;
use super::parry::math::{Matrix, Vector};

/// Gives the parts of an object, which follow one another, the mass of its mesh, if recorded.
pub(super) fn share_masses(hulls: &mut [BakedHull]) {
    let mut rest = hulls;
    while let Some(first) = rest.first() {
        let count = (first.hull().part_count() as usize).max(1);
        let is_whole = rest.get(..count).is_some_and(is_whole_object);
        let is_known = is_whole && first.hull().mesh_mass_properties(1.0).is_some();
        let (own, later) = rest.split_at_mut(if is_known { count } else { 1 });
        if own.len() > 1 {
            own.iter_mut().for_each(|part| part.set_part_mass(PartMass::Nothing));
            own.iter_mut().take(1).for_each(|part| part.set_part_mass(PartMass::Mesh));
        }
        rest = later;
    }
}

/// Whether hulls are the parts of an object in their order, at one scale.
fn is_whole_object(parts: &[BakedHull]) -> bool {
    let Some((first, others)) = parts.split_first() else { return false };
    let follows = |(part, hull): (usize, &BakedHull)| {
        let (own, start) = (hull.shared_hull(), first.shared_hull());
        std::sync::Arc::ptr_eq(own.pack(), start.pack())
            && own.index() == start.index() + part
            && hull.scale_factors() == first.scale_factors()
    };
    first.hull().part() == 0 && (1..).zip(others).all(follows)
}

impl BakedHull {
    /// Mass properties at uniform `density`, O(1). Zero below rank 3.
    pub(super) fn baked_mass(&self, density: f64) -> MassProperties {
        let hull = self.shared_hull();
        let mass = match self.part_mass() {
            PartMass::Hull => hull.pack().mass_properties_of([hull.index()], density).ok(),
            PartMass::Mesh => hull.hull().mesh_mass_properties(density),
            PartMass::Nothing => return MassProperties::new(Vector::ZERO, 0.0, Vector::ZERO),
        };
        let Mass { mass, center_of_mass, inertia, .. } = mass.unwrap_or_default().scaled(self.scale_factors());
        let center = narrow(center_of_mass);
        // parry's decomposition has an absolute tolerance, so it gets a tensor of size 1.
        let size = inertia.to_cols_array().into_iter().fold(0.0, |size: f64, entry| size.max(entry.abs()));
        // NaN takes the failing branch.
        if !(size > 0.0 && size < f64::INFINITY) {
            return MassProperties::new(center, real(mass), Vector::ZERO);
        }
        let unit = Matrix::from_cols_array(&inertia.to_cols_array().map(|entry| real(entry / size)));
        let unit = MassProperties::with_inertia_matrix(center, 1.0, unit);
        let principal = unit.principal_inertia() * real(size);
        MassProperties::with_principal_inertia_frame(center, real(mass), principal, unit.principal_inertia_local_frame)
    }
}
