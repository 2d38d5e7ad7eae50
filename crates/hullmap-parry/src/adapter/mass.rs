//! Mass properties, from those in the pack.

use hullmap::glam::DMat3;

use super::BakedHull;
use super::convert::{narrow, real};
use super::parry::mass_properties::MassProperties;
use super::parry::math::{Matrix, Vector};

impl BakedHull {
    /// Mass properties at uniform `density`, O(1). Zero below rank 3.
    pub(super) fn baked_mass(&self, density: f64) -> MassProperties {
        let hull = self.hull();
        let scale = self.scale_factors();
        let mass = density * hull.volume() * scale.element_product().abs();
        // Scaling multiplies each second moment by the scales of its two axes.
        let [xx, yy, zz, yz, zx, xy] = hull.second_moments();
        let (xx, yy, zz) = (xx * scale.x * scale.x, yy * scale.y * scale.y, zz * scale.z * scale.z);
        let (yz, zx, xy) = (yz * scale.y * scale.z, zx * scale.z * scale.x, xy * scale.x * scale.y);
        let inertia = DMat3::from_cols_array(&[yy + zz, -xy, -zx, -xy, zz + xx, -yz, -zx, -yz, xx + yy]) * mass;
        let center = narrow(hull.centroid() * scale);
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
