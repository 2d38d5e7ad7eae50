//! The curve of parts against protrusion, from which a person chooses an error or a number of
//! parts.

use rayon::prelude::*;

use super::{Cover, Length, decompose_in};
use crate::{
    error::BakeError,
    fit::fits_around,
    hull::{self, Hull},
    progress::Stage,
};
use hullmap_geometry::PointSet;

/// Number of errors below the requested one, and above it.
const STEPS: i32 = 4;

/// Number of errors in which the error doubles.
const PER_OCTAVE: f64 = 2.0;

/// Parts within an error. Lengths are in the unit of the positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// The maximum error.
    pub max_error: f64,
    /// Number of parts.
    pub parts: usize,
    /// Number of vertices of all parts.
    pub vertices: usize,
    /// Proven bound on how far they protrude; `None` if it is not known.
    pub protrusion: Option<f64>,
}

/// The parts of a mesh within errors from a quarter of the maximum error to four times of it, each
/// by [`decompose`](super::decompose), the largest error first. An error that gives as many parts
/// as a larger one, or more, is only listed if they protrude less.
///
/// # Errors
/// The errors of [`hull::build`].
///
/// # Complexity
/// Nine times the cost of [`decompose`](super::decompose).
pub fn curve(mesh: &PointSet, cover: &Cover, stage: Stage) -> Result<Vec<CurvePoint>, BakeError> {
    let solid = cover.solid_of(mesh);
    let error = cover.max_error.resolve(solid.diagonal());
    let steps: Vec<i32> = (-STEPS..=STEPS).rev().collect();
    let done = stage.steps(steps.len());
    let point = |step: &i32| {
        let max_error = error * libm::exp2(f64::from(*step) / PER_OCTAVE);
        let cover = Cover { max_error: Length::Absolute(max_error), max_parts: None, ..*cover };
        let sets = decompose_in(mesh, &cover, Stage::default())?;
        let hulls: Vec<Hull> = match &sets {
            Some(sets) => sets.iter().map(hull::build).collect::<Result<_, _>>()?,
            None => vec![hull::build(mesh)?],
        };
        let all: Vec<&Hull> = hulls.iter().collect();
        let fits = fits_around(&solid, mesh, &all, Some(max_error), None);
        done.take();
        let protrusion = fits.map(|fits| fits.iter().map(|fit| fit.protrusion).fold(0.0, f64::max));
        let vertices = hulls.iter().map(|hull| hull.vertices.len()).sum();
        Ok(CurvePoint { max_error, parts: hulls.len(), vertices, protrusion })
    };
    let all: Vec<CurvePoint> = steps.par_iter().map(point).collect::<Result<_, BakeError>>()?;
    let mut found: Vec<CurvePoint> = Vec::new();
    for point in all {
        let is_beaten = |other: &CurvePoint| {
            other.parts <= point.parts && other.protrusion.is_some_and(|own| point.protrusion.is_none_or(|p| own <= p))
        };
        if !found.iter().any(is_beaten) {
            found.push(point);
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use shapes::concave;

    use super::*;
    use crate::{
        decompose::decompose,
        test_meshes::{hulls_of, point_set},
    };

    #[test]
    fn points_of_the_curve_are_what_either_option_gives() {
        for mesh in [concave::horseshoe(12), concave::l()] {
            let mesh = point_set(&mesh);
            let cover = Cover::default();
            let found = curve(&mesh, &cover, Stage::default()).unwrap();
            println!("{found:?}");
            assert!(found.len() > 1 || found[0].parts == 2);
            for point in &found {
                let count = |cover: &Cover| decompose(&mesh, cover).unwrap().map_or(1, |parts| parts.len());
                assert_eq!(count(&Cover { max_error: Length::Absolute(point.max_error), ..cover }), point.parts);
                assert!(point.protrusion.unwrap() <= point.max_error);
            }
            assert!(
                found.windows(2).all(|pair| pair[0].parts < pair[1].parts || pair[0].protrusion > pair[1].protrusion)
            );
            for point in found {
                let cover = Cover { max_parts: Some(point.parts as u32), ..cover };
                let parts = decompose(&mesh, &cover).unwrap().unwrap();
                let hulls = hulls_of(&parts);
                let fits = fits_around(&cover.solid_of(&mesh), &mesh, &hulls.iter().collect::<Vec<_>>(), None, None);
                let reached = fits.unwrap().iter().map(|fit| fit.protrusion).fold(0.0, f64::max);
                let accuracy = 1e-5 * cover.solid_of(&mesh).diagonal();
                assert!(reached <= 1.05 * point.protrusion.unwrap() + accuracy, "{reached} with {point:?}");
            }
        }
    }
}
