//! Primitives: boxes, spheres, cylinders, capsules, ellipsoids and cones.

/// A primitive about the origin of its frame, along z, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Primitive {
    /// Half of its edges along each axis.
    Box([f64; 3]),
    /// Its radius.
    Sphere(f64),
    /// Its radius, and half of its length.
    Cylinder([f64; 2]),
    /// Its radius, and half of the length between the centres of its caps.
    Capsule([f64; 2]),
    /// Its radii along each axis.
    Ellipsoid([f64; 3]),
    /// The radius of its base, and half of its height; the origin is halfway up.
    Cone([f64; 2]),
}

/// A geometry of a description that is given by its name and sizes.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPrimitive {
    /// Its name in the description.
    pub name: String,
    /// The shape; `None` if its sizes are missing, or if it is fitted to a mesh.
    pub shape: Option<Primitive>,
}

impl Primitive {
    /// A primitive by its name and half of its lengths: three for boxes and ellipsoids, a radius
    /// for spheres, a radius and half of a length otherwise. `None` unless they are positive.
    pub(crate) fn new(name: &str, sizes: &[f64]) -> Option<Self> {
        let is_positive = |sizes: &[f64]| sizes.iter().all(|size| *size > 0.0 && size.is_finite());
        let two = || sizes.first_chunk().copied().filter(|sizes: &[f64; 2]| is_positive(sizes));
        let three = || sizes.first_chunk().copied().filter(|sizes: &[f64; 3]| is_positive(sizes));
        match name {
            "box" => three().map(Self::Box),
            "sphere" => sizes.first().copied().filter(|radius| is_positive(&[*radius])).map(Self::Sphere),
            "cylinder" => two().map(Self::Cylinder),
            "capsule" => two().map(Self::Capsule),
            "ellipsoid" => three().map(Self::Ellipsoid),
            "cone" => two().map(Self::Cone),
            _ => None,
        }
    }

    /// A primitive by the attributes or elements of URDF and SDF, which state whole lengths.
    pub(crate) fn of_lengths(name: &str, stated: impl Fn(&str) -> Vec<f64>) -> Option<Self> {
        let half = |numbers: Vec<f64>| numbers.into_iter().map(|length| length / 2.0).collect::<Vec<f64>>();
        match name {
            "box" => Self::new(name, &half(stated("size"))),
            "ellipsoid" => Self::new(name, &stated("radii")),
            name => Self::new(name, &[stated("radius"), half(stated("length"))].concat()),
        }
    }
}
