//! Convex decomposition: a concave mesh becomes convex parts, by one of two methods.
//!
//! | file | concept |
//! |---|---|
//! | [`cover`] | few parts that contain the whole surface and protrude by a limited length, both proven |
//! | [`vhacd`], `merge` | V-HACD: parts of limited volume, measured afterwards |
//!
//! ```
//! use hullmap_bake::{PointSet, decompose::{Cover, Length, Method, decompose}};
//!
//! // Two tetrahedra that share a corner.
//! let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! let far = corners.map(|p: [f32; 3]| p.map(|x| -x));
//! let outward = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
//! let inward = outward.map(|[a, b, c]: [u32; 3]| [a + 4, c + 4, b + 4]);
//! let mesh = PointSet {
//!     positions: [corners, far].concat(),
//!     source_vertices: (0..8).collect(),
//!     triangles: [outward, inward].concat(),
//!     ..PointSet::default()
//! };
//! let method = Method::Cover(Cover { max_error: Length::Relative(0.02), ..Cover::default() });
//! let parts = decompose(&mesh, &method)?.expect("the mesh is concave");
//! assert_eq!(parts.len(), 2);
//! # Ok::<(), hullmap_bake::BakeError>(())
//! ```

pub mod cover;
mod merge;
pub mod vhacd;

use cover::{Deadline, Search};
use glam::DVec3;
use rayon::prelude::*;
pub use vhacd::{Fill, Parameters};

use crate::{
    BakeError, PointSet,
    hull::{self, Hull},
    parts::{solid::Solid, uncovered_triangles},
};

/// How a mesh is decomposed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// A cover with proven bounds.
    Cover(Cover),
    /// V-HACD.
    Vhacd(Parameters),
}

impl Method {
    /// Whether at most one part is allowed.
    pub fn allows_one_part(&self) -> bool {
        match self {
            Self::Cover(cover) => cover.max_parts == Some(1),
            Self::Vhacd(parameters) => parameters.max_parts == 1,
        }
    }
}

/// A length, absolute or relative to the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Length {
    /// In the unit of the positions.
    Absolute(f64),
    /// In diagonals of the mesh's box.
    Relative(f64),
}

impl Length {
    /// The length for a mesh with this diagonal.
    pub fn of(self, diagonal: f64) -> f64 {
        match self {
            Self::Absolute(length) => length,
            Self::Relative(share) => share * diagonal,
        }
    }
}

/// Parameters of a cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cover {
    /// Maximum protrusion of a part from the mesh's solid, above 0. With `max_parts`, the search
    /// starts with this limit, and finds the smallest one that suffices.
    pub max_error: Length,
    /// Maximum number of parts, at least 1. If `max_error` takes more parts, `max_error` is
    /// exceeded.
    pub max_parts: Option<u32>,
    /// Maximum number of vertices of a part, at least
    /// [`MIN_VERTICES`](crate::simplify::MIN_VERTICES).
    pub max_vertices: u32,
    /// Time after which the search stops improving the parts, in seconds. A first cover is
    /// completed in any case, which may take longer. The result then depends on the machine.
    pub seconds: Option<f64>,
}

impl Default for Cover {
    fn default() -> Self {
        Self { max_error: Length::Relative(0.02), max_parts: None, max_vertices: 64, seconds: None }
    }
}

/// Smallest limit on the protrusion that is searched for, relative to the diagonal. Parts are
/// rounded and moved outward by up to a tenth of that.
const LEAST_ERROR: f64 = 2e-5;

/// Distance from the parts up to which the surface counts as covered, relative to the diagonal.
const COVERED: f64 = 1e-7;

/// Number of times that the limit is doubled to reach a number of parts. The hull of a mesh
/// protrudes by less than its diagonal.
const MAX_DOUBLINGS: usize = 17;

/// Number of bisections of the range of limits.
const BISECTIONS: usize = 5;

/// The convex parts of a mesh; `None` if the mesh is convex, or has no triangles or no extent.
///
/// Each part is named after the mesh, with the suffix `_part_00`, `_part_01` and so on. Without a
/// time limit, parts and their order depend on the mesh and the parameters only. A sheet, which has
/// no inside, is covered by thin parts.
///
/// # Errors
/// The errors of [`hull::build`].
///
/// # Complexity
/// See [`cover`] and [`vhacd`].
pub fn decompose(mesh: &PointSet, method: &Method) -> Result<Option<Vec<PointSet>>, BakeError> {
    match method {
        Method::Vhacd(parameters) => vhacd::decompose(mesh, parameters),
        Method::Cover(parameters) => covered(mesh, parameters),
    }
}

fn covered(mesh: &PointSet, parameters: &Cover) -> Result<Option<Vec<PointSet>>, BakeError> {
    let hull = hull::build(mesh)?;
    if hull.rank < 3 || mesh.triangles.is_empty() || vhacd::is_convex(mesh, &hull) {
        return Ok(None);
    }
    let solid = Solid::new(mesh);
    let mut parts = cover_within(mesh, &solid, parameters);
    add_uncovered(mesh, &mut parts, solid.diagonal(), parameters.max_error.of(solid.diagonal()));
    if parts.is_empty() {
        return Ok(None);
    }
    let order = vhacd::by_position(mesh);
    let point_set = |(index, hull): (usize, &Hull)| {
        let located = |p: &[f32; 3]| (*p, vhacd::source_vertex_at(mesh, &order, *p));
        let mut points: vhacd::Part = hull.vertices.iter().map(located).collect();
        vhacd::in_order(&mut points);
        vhacd::point_set(&points, mesh, format!("{}_part_{index:02}", mesh.name))
    };
    Ok(Some(parts.iter().enumerate().map(point_set).collect()))
}

/// Adds a thin part for each triangle that is not proven to be covered, for instance one without
/// area, of which no cell is made. A triangle of the mesh protrudes nowhere.
fn add_uncovered(mesh: &PointSet, parts: &mut Vec<Hull>, diagonal: f64, limit: f64) {
    let missing = uncovered_triangles(mesh, &parts.iter().collect::<Vec<_>>(), COVERED * diagonal);
    let thin = missing.into_par_iter().filter_map(|triangle| {
        let corner = |v: u32| DVec3::from_array(mesh.positions[v as usize].map(f64::from));
        let corners = mesh.triangles[triangle].map(corner);
        cover::wrap::tight(&corners, diagonal, (0.25 * limit).min(1e-6 * diagonal))
    });
    let thin: Vec<Hull> = thin.collect();
    parts.extend(thin);
}

/// The hulls of a cover, within the maximum number of parts.
fn cover_within(mesh: &PointSet, solid: &Solid, parameters: &Cover) -> Vec<Hull> {
    let diagonal = solid.diagonal();
    let deadline = parameters.seconds.map(Deadline::after);
    let is_over = || deadline.is_some_and(|deadline| deadline.is_over());
    let least = LEAST_ERROR * diagonal;
    let search = |limit: f64| -> Vec<Hull> {
        let max_vertices = (parameters.max_vertices as usize).max(crate::simplify::MIN_VERTICES);
        let what = Search { limit: limit.max(least), max_vertices, deadline };
        cover::search(mesh, solid, &what).into_iter().map(|(hull, _)| hull).collect()
    };
    let mut limit = parameters.max_error.of(diagonal).max(least);
    let mut best = search(limit);
    let Some(max_parts) = parameters.max_parts.map(|count| count.max(1) as usize) else { return best };
    // The smallest limit that is known to suffice, and the greatest that is known not to.
    let mut low = 0.0;
    for _ in 0..MAX_DOUBLINGS {
        if best.len() <= max_parts {
            break;
        }
        low = limit;
        limit *= 2.0;
        best = search(limit);
    }
    for _ in 0..BISECTIONS {
        if is_over() || limit <= least {
            break;
        }
        let middle = if low > 0.0 { (low * limit).sqrt() } else { 0.25 * limit };
        let found = search(middle);
        if found.len() <= max_parts { (best, limit) = (found, middle) } else { low = middle }
    }
    best
}
