//! Settings of a manifold: how far apart two surfaces may be and still have points.

#![forbid(unsafe_code)]

use crate::solver::Settings;

/// How far two surfaces may be separated and still have manifold points, of negative depth, so that
/// a rocking body keeps them.
///
/// NaN and negative values count as 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Prediction {
    /// A length, in the shapes' units.
    Length(f64),
    /// A fraction of the outer radius of the smaller shape.
    Relative(f64),
}

impl Prediction {
    /// The prediction as a length, for a smaller shape of this outer radius.
    pub fn length(self, smaller_outer_radius: f64) -> f64 {
        match self {
            Self::Length(length) => length.max(0.0),
            Self::Relative(fraction) => fraction.max(0.0) * smaller_outer_radius,
        }
    }
}

impl Default for Prediction {
    /// 2 % of the smaller shape's outer radius.
    fn default() -> Self {
        Self::Relative(0.02)
    }
}

/// Settings of [`Manifold::update`](crate::Manifold::update).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ManifoldSettings {
    /// Settings of the contact or distance query inside.
    pub contact: Settings,
    /// How far two surfaces may be separated and still have points.
    pub prediction: Prediction,
}
