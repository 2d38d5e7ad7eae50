//! Options of an import.

/// Source points that a hull is built from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Vertices {
    /// Points that a face, line or point element references. All points if there are no elements.
    Referenced,
    /// All points of the file.
    All,
}

/// How a source file is split into hulls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Split {
    /// One hull for the whole file.
    None,
    /// One hull for each object.
    Object,
    /// One hull for each object with the name of a collision part. Same as `None` if there are no
    /// such names.
    Auto,
}

/// Exact rotation of the source by 90° about its x axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum UpAxis {
    /// No rotation.
    Keep,
    /// The y axis of the source becomes the z axis: (x, y, z) becomes (x, −z, y).
    #[cfg_attr(feature = "clap", value(name = "y-to-z"))]
    YToZ,
    /// The z axis of the source becomes the y axis: (x, y, z) becomes (x, z, −y).
    #[cfg_attr(feature = "clap", value(name = "z-to-y"))]
    ZToY,
}

/// Options of an import.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImportOptions {
    /// How the file is split into hulls.
    pub split: Split,
    /// Source points of the hulls.
    pub vertices: Vertices,
    /// Factor of every coordinate, finite and positive. The product is computed in `f64` and
    /// rounded to `f32` once.
    pub unit_scale: f64,
    /// Rotation of the source.
    pub up_axis: UpAxis,
    /// Whether the centre of the file's bounds becomes the origin. Each hull records it.
    pub recentre: bool,
}

impl ImportOptions {
    /// The default options.
    pub const DEFAULT: Self = Self {
        split: Split::None,
        vertices: Vertices::Referenced,
        unit_scale: 1.0,
        up_axis: UpAxis::Keep,
        recentre: false,
    };
}
