//! Mass properties: measure, centroid and second moments of a hull of any rank at uniform density.
//!
//! A solid is the sum of the tetrahedra between one vertex and the triangle fan of each face. A
//! polygon is the sum of its triangle fan. All terms have the same sign, so nothing cancels.
//!
//! # Reference
//! Mirtich, "Fast and accurate computation of polyhedral mass properties", 1996, with the closed
//! form for simplices: ∫ xᵢxⱼ over a simplex of measure m with corners p₀…p_k is m / ((k+1)(k+2)) ·
//! (Σ p Σ p + Σ p p).

use glam::{DMat3, DVec3};

use crate::hull::{Hull, edges};

/// Mass properties at density 1, with lengths in source units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mass {
    /// Volume; 0 below rank 3.
    pub volume: f64,
    /// Surface area, which includes both sides of a polygon; 0 below rank 2.
    pub surface_area: f64,
    /// Centroid of the solid, polygon, segment or point.
    pub centroid: [f64; 3],
    /// Second moments about the centroid, divided by the measure: xx, yy, zz, yz, zx, xy.
    pub second_moments: [f64; 6],
}

/// Computes the mass properties of `hull`.
///
/// # Complexity
/// O(number of face corners).
pub fn mass(hull: &Hull) -> Mass {
    let origin = DVec3::from_array(hull.vertices[0].map(f64::from));
    let vertices: Vec<DVec3> = hull.positions().iter().map(|p| *p - origin).collect();
    let at = |v: u32| vertices[v as usize];
    let mut sum = Simplices::ZERO;
    let mut area = 0.0;
    for (index, face) in hull.faces.iter().enumerate() {
        let root = at(face[0]);
        for (a, b) in edges(&face[1..]).take(face.len().saturating_sub(2)) {
            let cross = (at(a) - root).cross(at(b) - root);
            area += cross.length() / 2.0;
            match hull.rank {
                3 => sum.add(root.dot(cross) / 6.0, &[DVec3::ZERO, root, at(a), at(b)]),
                _ if index == 0 => sum.add(cross.length() / 2.0, &[root, at(a), at(b)]),
                _ => {}
            }
        }
    }
    match hull.rank {
        0 => sum.add(1.0, &[at(0)]),
        1 => sum.add(at(0).distance(at(1)), &[at(0), at(1)]),
        _ => {}
    }
    let (centroid, moments) = sum.about_centroid(&vertices);
    let volume = if hull.rank == 3 { sum.measure } else { 0.0 };
    Mass { volume, surface_area: area, centroid: (centroid + origin).to_array(), second_moments: entries(moments) }
}

/// The entries xx, yy, zz, yz, zx, xy of a symmetric matrix.
pub(crate) fn entries(matrix: DMat3) -> [f64; 6] {
    let c = matrix.to_cols_array_2d();
    [c[0][0], c[1][1], c[2][2], c[1][2], c[2][0], c[0][1]]
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Simplices {
    pub(crate) measure: f64,
    pub(crate) first: DVec3,
    pub(crate) second: DMat3,
}

impl Simplices {
    pub(crate) const ZERO: Self = Self { measure: 0.0, first: DVec3::ZERO, second: DMat3::ZERO };

    /// The integrals over a simplex of this measure, negative where it counts against the others.
    pub(crate) fn from_simplex(measure: f64, corners: &[DVec3]) -> Self {
        let k = corners.len() as f64;
        let total: DVec3 = corners.iter().sum();
        let mut squares = outer(total);
        for corner in corners {
            squares += outer(*corner);
        }
        Self { measure, first: total * (measure / k), second: squares * (measure / (k * (k + 1.0))) }
    }

    fn add(&mut self, measure: f64, corners: &[DVec3]) {
        let simplex = Self::from_simplex(measure, corners);
        self.measure += simplex.measure;
        self.first += simplex.first;
        self.second += simplex.second;
    }

    /// Centroid, and second moments about it, relative to the measure; not finite if that is 0.
    pub(crate) fn centroid_and_moments(&self) -> (DVec3, DMat3) {
        let centroid = self.first / self.measure;
        (centroid, self.second * (1.0 / self.measure) - outer(centroid))
    }

    /// Centroid and second moments, divided by the measure. If the measure underflows, the mean of
    /// the vertices and zero.
    fn about_centroid(&self, vertices: &[DVec3]) -> (DVec3, DMat3) {
        let (centroid, moments) = self.centroid_and_moments();
        if self.measure > 0.0 && centroid.is_finite() && moments.is_finite() {
            (centroid, moments)
        } else {
            (vertices.iter().sum::<DVec3>() / vertices.len() as f64, DMat3::ZERO)
        }
    }
}

pub(crate) fn outer(p: DVec3) -> DMat3 {
    DMat3::from_cols(p * p.x, p * p.y, p * p.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::{corners, hull_of};

    #[test]
    fn hulls_of_each_rank_have_the_mass_of_their_closed_forms() {
        let far_box = corners([100.0, -50.0, 0.0], [102.0, -46.0, 6.0]);
        let triangle = vec![[0., 0., 1.], [3., 0., 1.], [0., 3., 1.]];
        let of_box = [4.0 / 12.0, 16.0 / 12.0, 36.0 / 12.0, 0.0, 0.0, 0.0];
        for (positions, volume, surface_area, centroid, second_moments) in [
            (far_box, 48.0, 88.0, [101.0, -48.0, 3.0], of_box),
            (triangle, 0.0, 9.0, [1.0; 3], [0.5, 0.5, 0.0, 0.0, 0.0, -0.25]),
            (vec![[0., 0., 1.], [6., 0., 1.]], 0.0, 0.0, [3.0, 0.0, 1.0], [3.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        ] {
            let found = mass(&hull_of(positions));
            let list = |m: &Mass| [&[m.volume, m.surface_area], &m.centroid[..], &m.second_moments].concat();
            let expected = Mass { volume, surface_area, centroid, second_moments };
            let is_near = list(&found).iter().zip(list(&expected)).all(|(a, b)| (a - b).abs() < 1e-12);
            assert!(is_near, "{found:?} is not {expected:?}");
        }
    }
}
