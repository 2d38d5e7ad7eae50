//! What an import needs to know.

/// Which points of a source file a hull is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Vertices {
    /// Those that any face, line or point element references; all of them when nothing does.
    Referenced,
    /// Every `v` line.
    All,
}

/// Into how many hulls a source file is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Split {
    /// One hull of the whole file.
    None,
    /// One hull for each object.
    Object,
    /// One hull for each collision part by the names that artists give them; as `None` where a file has no such names.
    Auto,
}

/// An exact rotation of the source by 90° about its x axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum UpAxis {
    /// No rotation.
    Keep,
    /// What points along y in the source points along z: (x, y, z) becomes (x, −z, y).
    #[cfg_attr(feature = "clap", value(name = "y-to-z"))]
    YToZ,
    /// What points along z in the source points along y: (x, y, z) becomes (x, z, −y).
    #[cfg_attr(feature = "clap", value(name = "z-to-y"))]
    ZToY,
}

/// What an import needs to know.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImportOptions {
    /// How the file is cut.
    pub split: Split,
    /// Which points count.
    pub vertices: Vertices,
    /// What each coordinate is multiplied with, in f64, then rounded once to f32; finite and above 0.
    pub unit_scale: f64,
    /// How the source is turned.
    pub up_axis: UpAxis,
    /// Whether points are taken relative to the middle of the file's bounds, which the hull then records as its origin.
    pub recentre: bool,
}

impl ImportOptions {
    /// What is used where nothing is asked for.
    pub const DEFAULT: Self = Self {
        split: Split::None,
        vertices: Vertices::Referenced,
        unit_scale: 1.0,
        up_axis: UpAxis::Keep,
        recentre: false,
    };
}
