//! Manifolds.
#![allow(unsafe_code)]

use crate::border::{self, Out, call};
use crate::handles::{Empty, Manifold, Shape};
use crate::query;
use crate::types::{ManifoldPoints, ManifoldSettings, Pose, Result};

/// Makes a manifold without points, for one ordered pair of shapes. `max_pairs` is the maximum
/// number of pairs of parts, of triangles of a level or of cells of a terrain that may touch at the
/// same time. For two convex shapes, pass 1; for a body on a level, 32 or more. If more touch, the
/// earlier pairs stay, and HullmapManifoldPoints.dropped counts the others: a body may then sink
/// in. At most 65,536. About 1 KB for each of them, and 5 KB more once compounds are updated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_manifold_new(max_pairs: u32, manifold: *mut *mut Manifold) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let out = unsafe { Out::of_handle("manifold", manifold)? };
        out.give(Manifold::new(max_pairs)?);
        Ok(())
    })
}

/// Finds up to four contact points of A and of B placed at b_in_a; for compounds, of each pair of
/// hulls that touch.
///
/// Shapes touch if they overlap, or if they are separated by at most the prediction. A point that
/// was there before keeps its impulse and user data, and its age grows. settings may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_manifold_update(
    manifold: *mut Manifold,
    a: *const Shape,
    b: *const Shape,
    b_in_a: *const Pose,
    settings: *const ManifoldSettings,
    out: *mut ManifoldPoints,
) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (manifold, pair, settings, out) = unsafe {
            let (manifold, pair) = (border::handle("manifold", manifold)?, super::query::pair(a, b, b_in_a)?);
            (manifold, pair, border::read_sized("settings", settings)?, Out::new("out", out)?)
        };
        let settings = super::manifold_settings(settings)?;
        let mut points = manifold.0.take("manifold")?;
        query::update(&pair, &settings, &mut points);
        out.write(points.answer());
        Ok(())
    })
}

/// Removes all points, for instance because a body was moved by hand.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_manifold_clear(manifold: *mut Manifold) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let manifold = unsafe { border::handle("manifold", manifold)? };
        manifold.0.take("manifold")?.empty();
        Ok(())
    })
}

/// Frees a manifold; NULL is allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_manifold_free(manifold: *mut Manifold) {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { border::free(manifold) }
}
