//! The triangles of a tile near a moving body, in the order along its path.

use hullmap::compound::seams::Union as _;
use hullmap::glam::DVec3;

use super::super::surface::SurfaceTile;

/// A ball that contains the body during a part of its motion, in the frame of the tile.
pub(super) struct Ball {
    pub(super) center: DVec3,
    pub(super) radius: f64,
    /// When this part of the motion begins.
    pub(super) start: f64,
}

/// The first hit of a body with a triangle near its path, which `balls` cover. `test` returns the
/// hit with a triangle and its time. A ball that begins after a hit is skipped.
pub(super) fn first_hit<H>(
    tile: &SurfaceTile,
    balls: impl IntoIterator<Item = Ball>,
    mut test: impl FnMut(usize, &dyn hullmap::Shape) -> Option<(f64, H)>,
) -> Option<(f64, H)> {
    let mut first: Option<(f64, H)> = None;
    for Ball { center, radius, start } in balls {
        if first.as_ref().is_some_and(|(t, _)| *t < start) {
            break;
        }
        tile.any_near(center, radius, &mut |near| {
            if let Some(found) = test(near.index, near.shape)
                && first.as_ref().is_none_or(|(t, _)| found.0 < *t)
            {
                first = Some(found);
            }
            false
        });
    }
    first
}
