//! Mass properties from those that the bake recorded.

use hullmap::glam::DMat3;

use super::BakedHull;
use super::convert::{narrow, real};
use super::parry::mass_properties::MassProperties;
use super::parry::math::Matrix;

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
        let columns = Matrix::from_cols_array(&inertia.to_cols_array().map(real));
        MassProperties::with_inertia_matrix(narrow(hull.centroid() * scale), real(mass), columns)
    }
}
