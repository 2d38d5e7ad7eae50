//! A mirror: a plane, and reflections about it.

use std::fmt;

use glam::DVec3;

use hullmap_geometry::{number::short, planes::HalfSpace};

/// A plane of symmetry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// Its plane. The half-space is the other side; the own side is above the plane.
    pub plane: HalfSpace,
    /// Greatest distance of a point from the reflection of its image; 0 if exact.
    pub error: f64,
}

impl Mirror {
    /// The mirror whose plane has a unit normal and an offset along it.
    pub fn new(normal: [f64; 3], offset: f64) -> Self {
        Self { plane: HalfSpace { normal: DVec3::from_array(normal), offset }, error: 0.0 }
    }

    /// The reflection of a point. It is exact about a coordinate plane through the origin.
    pub fn image(&self, p: DVec3) -> DVec3 {
        p - self.plane.normal * (2.0 * self.plane.height(p))
    }

    /// The reflection of a stored point, rounded.
    pub fn rounded_image(&self, p: [f32; 3]) -> [f32; 3] {
        self.image(DVec3::from_array(p.map(f64::from))).as_vec3().to_array().map(|c| c + 0.0)
    }

    /// The point of the plane nearest to a point.
    pub fn foot(&self, p: DVec3) -> DVec3 {
        0.5 * (p + self.image(p))
    }

    /// Whether reflections of stored points are exact: about a coordinate plane through the origin.
    pub fn is_exact(&self) -> bool {
        self.plane.offset == 0.0 && self.axis().is_some()
    }

    /// The axis at right angles to the plane, if there is one.
    pub fn axis(&self) -> Option<usize> {
        (0..3).find(|axis| self.plane.normal[*axis].abs() == 1.0)
    }
}

impl fmt::Display for Mirror {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let HalfSpace { normal, offset } = self.plane;
        match self.axis() {
            Some(axis) => write!(f, "{} = {}", ['x', 'y', 'z'][axis], short(offset * normal[axis] + 0.0)),
            None => {
                let [x, y, z] = normal.to_array().map(short);
                write!(f, "{x} x + {y} y + {z} z = {}", short(offset))
            }
        }
    }
}
