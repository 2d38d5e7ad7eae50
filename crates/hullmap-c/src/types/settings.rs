//! Settings of queries and manifolds.

/// Unit of HullmapManifoldSettings.prediction.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prediction {
    /// A fraction of the outer radius of the smaller shape.
    Relative = 0,
    /// A length in the shapes' unit.
    Length = 1,
}

/// Accuracy and effort of a distance, contact or signed distance. Start from
/// HULLMAP_SETTINGS_DEFAULT.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// sizeof(HullmapSettings)
    pub struct_size: usize,
    /// Maximum width of the interval, relative to its upper bound. The default is 1e-5. NaN and
    /// negative values count as 0: as narrow as rounding error allows.
    pub tolerance: f64,
    /// Maximum number of steps of the last phase. The default is 1000.
    pub max_iterations: u32,
}

/// Limits and accuracy of a ray or a cast. Start from HULLMAP_CAST_SETTINGS_DEFAULT.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CastSettings {
    /// sizeof(HullmapCastSettings)
    pub struct_size: usize,
    /// Maximum t, in the unit of the ray or the motion. The default is infinite. NaN and negative
    /// values count as 0.
    pub max_t: f64,
    /// Maximum width of the interval as a length along the way, relative to the outer radius of the
    /// shape, or to the sum of both radii. The default is 1e-6.
    pub tolerance: f64,
    /// Maximum number of steps. The default is 1000.
    pub max_iterations: u32,
}

/// Settings of a contact manifold. Start from HULLMAP_MANIFOLD_SETTINGS_DEFAULT.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldSettings {
    /// sizeof(HullmapManifoldSettings)
    pub struct_size: usize,
    /// As in HullmapSettings.
    pub tolerance: f64,
    /// As in HullmapSettings.
    pub max_iterations: u32,
    /// A HullmapPrediction: the unit of prediction. The default is HULLMAP_PREDICTION_RELATIVE.
    pub prediction_kind: u32,
    /// How far two surfaces may be separated and still have points, of negative depth. The default
    /// is 0.02. NaN and negative values count as 0.
    pub prediction: f64,
}
