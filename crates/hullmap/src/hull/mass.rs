//! Mass properties: mass, centre of mass and inertia tensor at uniform density, of a hull and of
//! the mesh that it was baked from.

use glam::{DMat3, DVec3};

use super::{Hull, vector};

/// The solid that mass properties describe.
#[repr(u32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MassSource {
    /// The hulls. Parts of a mesh overlap, and hulls of concave meshes and simplified hulls are
    /// larger than their mesh, so their mass is an upper bound, and may be twice the mesh's.
    #[default]
    Hulls = 0,
    /// The mesh that the hulls were baked from.
    Mesh = 1,
}

impl MassSource {
    /// The name: `hulls` or `mesh`.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Hulls => "hulls",
            Self::Mesh => "mesh",
        }
    }
}

/// Mass properties of a solid of uniform density, in the hull's local frame.
///
/// Units follow from the units of the hull's lengths and of the density. A hull in metres and a
/// density in kilograms per cubic metre give kilograms, metres, and kilograms times square metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MassProperties {
    /// Mass: density times volume.
    pub mass: f64,
    /// Centre of mass.
    pub center_of_mass: DVec3,
    /// Inertia tensor about the centre of mass, along the axes of the local frame. Symmetric. Its
    /// diagonal holds the moments of inertia about the axes; the other entries are the products of
    /// inertia with a minus sign, so that `inertia * angular_velocity` is the angular momentum.
    pub inertia: DMat3,
    /// The solid that these are the properties of.
    pub source: MassSource,
}

impl MassProperties {
    /// Properties from the volume, the centroid, and second moments xx, yy, zz, yz, zx, xy about
    /// it, divided by the volume.
    fn of_solid(volume: f64, centroid: DVec3, moments: [f64; 6], density: f64, source: MassSource) -> Self {
        let mass = density * volume;
        let [xx, yy, zz, yz, zx, xy] = moments;
        let inertia = DMat3::from_cols(
            DVec3::new(yy + zz, -xy, -zx),
            DVec3::new(-xy, zz + xx, -yz),
            DVec3::new(-zx, -yz, xx + yy),
        ) * mass;
        Self { mass, center_of_mass: centroid, inertia, source }
    }

    /// Properties of several solids as one rigid body. All are in one frame. The source is
    /// [`MassSource::Mesh`] if it is so for all of them.
    pub fn combined(solids: impl IntoIterator<Item = Self>) -> Self {
        let mut solids = solids.into_iter();
        let Some(first) = solids.next() else { return Self::default() };
        solids.fold(first, |body, solid| {
            let mass = body.mass + solid.mass;
            let center = (body.center_of_mass * body.mass + solid.center_of_mass * solid.mass) / mass;
            // Flat hulls have no mass.
            let center_of_mass = if center.is_finite() { center } else { body.center_of_mass };
            let both = [body.source, solid.source];
            Self {
                mass,
                center_of_mass,
                inertia: body.inertia_about(center_of_mass) + solid.inertia_about(center_of_mass),
                source: if both == [MassSource::Mesh; 2] { MassSource::Mesh } else { MassSource::Hulls },
            }
        })
    }

    /// Properties of the solid scaled along the axes of the frame, at the same density. A negative
    /// factor mirrors it.
    pub fn scaled(&self, scale: DVec3) -> Self {
        // Scaling multiplies each second moment by the factors of its two axes.
        let trace = self.inertia.x_axis.x + self.inertia.y_axis.y + self.inertia.z_axis.z;
        let moments = DMat3::from_diagonal(DVec3::splat(trace / 2.0)) - self.inertia;
        let factors = DMat3::from_diagonal(scale);
        let volume = scale.element_product().abs();
        let moments = factors * moments * factors * volume;
        let trace = moments.x_axis.x + moments.y_axis.y + moments.z_axis.z;
        Self {
            mass: self.mass * volume,
            center_of_mass: self.center_of_mass * scale,
            inertia: DMat3::from_diagonal(DVec3::splat(trace)) - moments,
            source: self.source,
        }
    }

    /// Inertia tensor about `point` (local frame) instead of the centre of mass, by the parallel
    /// axis theorem.
    pub fn inertia_about(&self, point: DVec3) -> DMat3 {
        let r = self.center_of_mass - point;
        let outer = DMat3::from_cols(r * r.x, r * r.y, r * r.z);
        self.inertia + (DMat3::from_diagonal(DVec3::splat(r.length_squared())) - outer) * self.mass
    }
}

impl Hull<'_> {
    /// Mass, centre of mass and inertia tensor of the solid hull at a uniform `density`: mass per
    /// volume.
    ///
    /// This is the hull's own mass. The mesh that it was baked from has
    /// [`mesh_mass_properties`](Self::mesh_mass_properties), and a body made of all hulls of a pack
    /// has [`Pack::mass_properties`](crate::Pack::mass_properties).
    ///
    /// The values were recorded by the bake, in the hull's local frame. A hull of rank below 3 has
    /// no volume: its mass and inertia are 0, and its centre of mass is the centre of the polygon,
    /// segment or point.
    ///
    /// # Complexity
    /// O(1).
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// use hullmap::glam::{DMat3, DVec3};
    ///
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// let properties = cube.mass_properties(1000.0);
    /// // Edge length 2: volume 8, and m · (2² + 2²) / 12 about each axis.
    /// assert!((properties.mass - 8000.0).abs() < 1e-9);
    /// assert!(properties.center_of_mass.length() < 1e-12);
    /// let expected = DMat3::from_diagonal(DVec3::splat(8000.0 * 8.0 / 12.0));
    /// assert!(properties.inertia.abs_diff_eq(expected, 1e-9));
    /// # }
    /// ```
    pub fn mass_properties(&self, density: f64) -> MassProperties {
        let (centroid, moments) = (self.centroid(), self.second_moments());
        MassProperties::of_solid(self.volume(), centroid, moments, density, MassSource::Hulls)
    }

    /// Mass properties of the solid that the mesh of this hull bounds, at a uniform `density`: mass
    /// per volume. The parts of an object have one mesh, and the same answer.
    ///
    /// `None` if the pack does not record it: the hull was baked from points, or its mesh is open,
    /// inconsistently oriented or without volume. A mesh that is turned inside out bounds the same
    /// solid. Where shells of a mesh overlap, they count once.
    ///
    /// # Complexity
    /// O(1).
    pub fn mesh_mass_properties(&self, density: f64) -> Option<MassProperties> {
        let mesh = self.mesh_mass?;
        let (volume, moments) = (mesh.volume.to_native(), mesh.second_moments.map(|m| m.to_native()));
        Some(MassProperties::of_solid(volume, vector(&mesh.centroid), moments, density, MassSource::Mesh))
    }

    /// Mass properties of the hull as a body of its own: the mesh's, if the hull stands for the
    /// whole mesh and they are known.
    pub(crate) fn body_mass_properties(&self, density: f64) -> MassProperties {
        let of_mesh = if self.part_count() <= 1 { self.mesh_mass_properties(density) } else { None };
        of_mesh.unwrap_or_else(|| self.mass_properties(density))
    }

    /// Inertia tensor about the centre of mass at density 1, along the axes of the hull's local
    /// frame.
    ///
    /// The unit is the fifth power of a length. For another density, multiply by it; see
    /// [`mass_properties`](Self::mass_properties).
    pub fn inertia_tensor(&self) -> DMat3 {
        self.mass_properties(1.0).inertia
    }
}

#[cfg(test)]
mod tests {
    use shapes::families;

    use super::*;
    use crate::pack::Pack;

    fn pack(positions: Vec<[f32; 3]>) -> Pack {
        Pack::from_bytes(&hullmap_testkit::packs::tree_bytes(&positions)).unwrap()
    }

    fn assert_near(found: DMat3, expected: DMat3, relative: f64) {
        let scale = expected.to_cols_array().into_iter().fold(0.0, |scale: f64, c| scale.max(c.abs()));
        let error = (found - expected).to_cols_array().into_iter().fold(0.0, |error: f64, c| error.max(c.abs()));
        // NaN fails.
        assert!(error <= relative * scale, "{found} instead of {expected}: off by {error:e}");
    }

    /// The slow twin: tetrahedra from the origin over the faces' triangles, each integrated
    /// exactly.
    #[test]
    fn rocks_agree_with_a_sum_over_tetrahedra() {
        for seed in 0..5 {
            let moved = families::rock(60, seed).into_iter().map(|[x, y, z]| [x + 2.0, 3.0 * y - 1.0, z]).collect();
            let pack = pack(moved);
            let hull = pack.hull(0).unwrap();
            let vertex = |index: u32| hull.vertex(index).unwrap().as_dvec3();
            let (mut volume, mut first, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
            for face in hull.faces() {
                let face: Vec<u32> = face.collect();
                for pair in face[1..].windows(2) {
                    let [a, b, c] = [face[0], pair[0], pair[1]].map(vertex);
                    let v = a.cross(b).dot(c) / 6.0;
                    volume += v;
                    first += (a + b + c) * (v / 4.0);
                    let outer = |p: DVec3| DMat3::from_cols(p * p.x, p * p.y, p * p.z);
                    second += (outer(a + b + c) + outer(a) + outer(b) + outer(c)) * (v / 20.0);
                }
            }
            let about_origin =
                DMat3::from_diagonal(DVec3::splat(second.x_axis.x + second.y_axis.y + second.z_axis.z)) - second;
            let properties = hull.mass_properties(1.0);
            assert!((properties.mass - volume).abs() < 1e-12 * volume, "seed {seed}");
            assert!(properties.center_of_mass.abs_diff_eq(first / volume, 1e-12), "seed {seed}");
            assert_near(properties.inertia_about(DVec3::ZERO), about_origin, 1e-11);
            assert_near(hull.inertia_tensor() * 7.5, hull.mass_properties(7.5).inertia, 1e-12);
        }
    }

    #[test]
    fn a_flat_hull_has_no_mass() {
        let pack = pack(vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]]);
        let properties = pack.hull(0).unwrap().mass_properties(3.0);
        assert_eq!((properties.mass, properties.inertia), (0.0, DMat3::ZERO));
        assert!(properties.center_of_mass.abs_diff_eq(DVec3::new(1.0, 1.0, 0.0), 1e-12));
    }
}
