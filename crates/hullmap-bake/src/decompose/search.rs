//! The search for parts: within an error, or at most a number of them with the least error.
//!
//! # Steps
//! 1. If the mesh has a mirror plane, search the parts of the surface on one side, and add their
//!    images. Merge parts at the plane with their images where the limit allows. With two mirrors,
//!    also search a quarter. As few parts, or fewer, win.
//! 2. Where that fails, search the whole surface. Cuts across the plane may need a few parts fewer,
//!    but equal features would become unequal parts. For a number of parts, the whole surface is
//!    searched, too, unless there is a deadline, since such parts may be an odd number.
//! 3. For a number of parts, start with the parts within the error. Raise the limit until there are
//!    few enough, or lower it as long as there are; then halve the interval. Divide parts further
//!    if more are allowed. So the result is never worse than parts of that number within the error.

use super::{
    finish::{COVERED, Finish},
    parameters::Cover,
    part::SourceVertices,
    partition::{self, Halves, Part, PartitionLimits, field::Field, surface::Surface, symmetric, wrap::HullLimits},
};
use crate::{
    deadline::{Deadline, Reserve},
    fit::{mesh_mass, uncovered_triangles, voids},
    hull::Hull,
    mass,
    progress::Stage,
    symmetry::{self, Mirror},
};
use hullmap_geometry::PointSet;

/// Smallest limit of a search, relative to the diagonal. Parts are moved outward by up to a tenth.
const LEAST_ERROR: f64 = 2e-5;

/// Smallest limit relative to the greatest coordinate, for meshes far from the origin. Rounding to
/// f32 moves a vertex by up to 2e-7 of the coordinate.
const LEAST_ROUNDED: f64 = 1e-5;

/// Smallest limit that is searched for a number of parts, relative to the diagonal. Below it, more
/// parts only follow the tessellation.
const LEAST_FOR_COUNTS: f64 = 2e-3;

/// Factor between limits for a number of parts; its square and so on upward. The factor between the
/// last two is its fourth root.
const STEP: f64 = 2.0;

/// Maximum number of limits that are searched for a number of parts, beside the error.
const MAX_SEARCHES: usize = 9;

/// Limits for which parts are divided further where there may be more, relative to what they reach.
const FURTHER: [f64; 3] = [0.5, 0.7, 0.85];

/// Maximum number of parts made by halving, the result if the deadline has already passed.
const HALVED: usize = 8;

/// Share of the solid that may be in no part of a mesh with two mirrors.
const VOIDS: f64 = 1e-3;

/// Time that a search leaves for final hulls.
const FINISHING: Reserve = Reserve { share: 0.2, seconds: 4.0 };

/// Parts within a limit.
pub struct Found {
    pub parts: Halves,
    pub limit: f64,
}

impl Found {
    pub fn count(&self) -> usize {
        self.parts.count()
    }

    /// The greatest bound; infinite if something is not proven.
    pub fn reached(&self) -> f64 {
        self.all().map(|part| part.bound).fold(0.0, f64::max)
    }

    fn all(&self) -> impl Iterator<Item = &Part> {
        self.parts.whole.iter().chain(&self.parts.mirrored)
    }

    fn volume(&self) -> f64 {
        let volume = |parts: &[Part]| parts.iter().map(|part| mass::mass(&part.hull).volume).sum::<f64>();
        volume(&self.parts.whole) + 2.0 * volume(&self.parts.mirrored)
    }
}

pub struct Search<'a> {
    pub mesh: &'a PointSet,
    pub vertices: &'a SourceVertices<'a>,
    pub field: Field<'a>,
    pub parameters: &'a Cover,
    pub max_vertices: usize,
    /// When the parts must be finished.
    pub deadline: Option<Deadline>,
    pub stage: Stage<'a>,
}

impl<'a> Search<'a> {
    pub fn hulls(&mut self) -> Option<Vec<Hull>> {
        let error = self.parameters.max_error.resolve(self.diagonal());
        let whole = [Surface::new(self.mesh, self.field.solid())];
        // Half of it, and a quarter.
        let mut halves: Vec<Surface> = Vec::new();
        for mirror in symmetry::mirrors_of_mesh(self.mesh, self.field.solid()) {
            let half = halves.last().unwrap_or(&whole[0]).halved(mirror, self.diagonal());
            halves.push(half);
        }
        let Some(count) = self.parameters.max_parts.map(|count| count as usize) else {
            let found = self.plain(&halves, error).map(|found| self.finished(&halves[0], found));
            return found.filter(|hulls| self.covers(hulls)).or_else(|| {
                let found = self.plain(&whole, error)?;
                Some(self.finished(&whole[0], found))
            });
        };
        let symmetric = self.at_most(&halves, count, error).and_then(|found| {
            let reached = found.reached();
            let hulls = self.finished(&halves[0], found);
            self.covers(&hulls).then_some((hulls, reached))
        });
        if self.deadline.is_some()
            && let Some((hulls, _)) = symmetric
        {
            return Some(hulls);
        }
        let other = self.at_most(&whole, count, error);
        let is_tighter = |found: &Found| symmetric.as_ref().is_none_or(|(_, reached)| found.reached() < *reached);
        let other = other.filter(is_tighter).map(|found| self.finished(&whole[0], found));
        other.or(symmetric.map(|(hulls, _)| hulls))
    }

    fn diagonal(&self) -> f64 {
        self.field.solid().diagonal()
    }

    /// The smallest limit that can be met.
    fn least(&self) -> f64 {
        let greatest = self.field.solid().bounds().map(|p| p.abs().max_element()).into_iter().fold(0.0, f64::max);
        (LEAST_ERROR * self.diagonal()).max(LEAST_ROUNDED * greatest)
    }

    pub fn final_bounds(&self, limit: f64) -> HullLimits<'a> {
        let (max_vertices, diagonal) = (self.max_vertices, self.diagonal());
        let thickness = self.parameters.wall.resolve(diagonal).min(0.5 * limit);
        HullLimits { limit, max_vertices, diagonal, thickness, deadline: self.deadline, stage: self.stage }
    }

    fn is_over(&self) -> bool {
        let bounds = self.final_bounds(0.0);
        HullLimits { deadline: self.searching(), ..bounds }.is_over()
    }

    fn searching(&self) -> Option<Deadline> {
        self.deadline.map(|deadline| deadline.with_reserve(FINISHING))
    }

    /// The fewest parts within a limit of a surface, or of quarters of it: of a smaller one, if
    /// they are as many.
    fn plain(&mut self, surfaces: &[Surface], limit: f64) -> Option<Found> {
        let mut best: Option<Found> = None;
        for surface in surfaces {
            if best.is_some() && self.is_over() {
                break;
            }
            let found = self.within(surface, limit, None);
            let found = found.filter(|found| surface.mirrors.len() < 2 || self.fills(&surface.mirrors[0], found));
            best = found.into_iter().chain(best).min_by_key(Found::count);
        }
        best
    }

    /// Whether next to nothing of the solid is in no part. In a quarter, atoms see few others
    /// through the solid, and a part may lack the inside behind its surface.
    fn fills(&self, mirror: &Mirror, found: &Found) -> bool {
        let images: Vec<Hull> =
            found.parts.mirrored.iter().filter_map(|part| symmetric::image(&part.hull, mirror)).collect();
        let hulls: Vec<&Hull> = found.all().map(|part| &part.hull).chain(&images).collect();
        let voids = voids(self.field.solid(), &hulls, self.deadline);
        mesh_mass(self.mesh).is_none_or(|mass| voids.relative_to(mass.volume).share <= VOIDS)
    }

    /// Parts within a limit. With `most`, `None` with more parts than that before mergers, and
    /// parts may bridge shells. With a deadline, they are at least as small as halves of the
    /// surface.
    fn within(&mut self, surface: &Surface, limit: f64, most: Option<usize>) -> Option<Found> {
        let limit = limit.max(self.least());
        let halved = self.halved(surface);
        if self.is_over() {
            return halved;
        }
        let count = self.parameters.max_parts.map(|count| count as usize);
        let limits = PartitionLimits {
            bounds: HullLimits { deadline: self.searching(), ..self.final_bounds(limit) },
            most: most.unwrap_or(usize::MAX),
            wanted: count.unwrap_or(1),
            bridges: most.is_some(),
        };
        let parts = partition::search(surface, &mut self.field, &limits)?;
        let found = Found { parts, limit };
        let is_smaller = |halved: &Found| !(found.reached() <= limit) && halved.volume() < found.volume();
        Some(halved.filter(is_smaller).unwrap_or(found))
    }

    /// The first parts of a search whose time is limited; `None` if it is not.
    fn halved(&self, surface: &Surface) -> Option<Found> {
        self.deadline?;
        // Nothing protrudes by more.
        let limit = self.diagonal();
        let count = self.parameters.max_parts.map_or(HALVED, |count| HALVED.min(count as usize));
        let is_half = !surface.mirrors.is_empty();
        let count = if is_half { count / 2 } else { count };
        let parts = partition::halved(surface, &self.field, &self.final_bounds(limit), count);
        let (whole, mirrored) = if is_half { (Vec::new(), parts) } else { (parts, Vec::new()) };
        Some(Found { parts: Halves { whole, mirrored }, limit }).filter(|found| found.count() > 1)
    }

    /// At most `count` parts, with the least protrusion: of a plain run, or of the first surface.
    fn at_most(&mut self, surfaces: &[Surface], count: usize, error: f64) -> Option<Found> {
        let surface = surfaces.first()?;
        let lowest = LEAST_FOR_COUNTS * self.diagonal();
        // The lowest limit known to leave few enough parts, and the highest that leaves too many.
        let (mut best, mut high, mut low): (Option<Found>, Option<f64>, Option<f64>) = (None, None, None);
        let (mut limit, mut step) = (error, STEP);
        for search in 0..=MAX_SEARCHES {
            let found = match search {
                // The parts of a plain run, if they are few enough.
                0 => self.plain(surfaces, limit),
                _ => self.within(surface, limit, Some(2 * count + 8)),
            };
            match found.filter(|found| found.count() <= count) {
                Some(found) => {
                    high = Some(limit);
                    let is_better = best.as_ref().is_none_or(|best| found.reached() < best.reached());
                    best = if is_better { Some(found) } else { best };
                }
                None => low = Some(limit),
            }
            let [least, most] = [lowest, self.diagonal()];
            limit = match (low, high) {
                (Some(low), Some(high)) if high <= low * STEP.sqrt().sqrt() => break,
                (Some(low), Some(high)) => (low * high).sqrt(),
                (None, Some(high)) if high <= least => break,
                (None, Some(high)) => (high / STEP).max(least),
                (Some(low), None) if low >= most => break,
                (Some(low), None) => {
                    let next = low * step;
                    step *= step;
                    next.min(most)
                }
                (None, None) => break,
            };
            if self.is_over() {
                break;
            }
        }
        best.map(|found| self.refined(surface, found, count))
    }

    /// Divides some parts if more are allowed.
    fn refined(&mut self, surface: &Surface, found: Found, count: usize) -> Found {
        let (reached, mut found) = (found.reached(), found);
        for limit in FURTHER.map(|share| share * reached) {
            let is_useful = limit.is_finite() && limit >= LEAST_FOR_COUNTS * self.diagonal();
            if found.count() >= count || !is_useful {
                break;
            }
            let bounds = HullLimits { deadline: self.searching(), ..self.final_bounds(limit) };
            // A part that is its own image cannot be divided into such parts.
            let (divisible, count) = if surface.mirrors.is_empty() {
                (&mut found.parts.whole, count)
            } else {
                (&mut found.parts.mirrored, (count - found.parts.whole.len()) / 2)
            };
            let parts = std::mem::take(divisible);
            *divisible = partition::divided_further(surface, &mut self.field, bounds, parts, count);
        }
        found
    }

    fn finished(&self, surface: &Surface, found: Found) -> Vec<Hull> {
        let Self { mesh, vertices, ref field, .. } = *self;
        let (bounds, max_parts) = (self.final_bounds(found.limit), self.parameters.max_parts);
        Finish { mesh, vertices, field, surface, bounds, max_parts }.hulls(found.parts)
    }

    fn covers(&self, hulls: &[Hull]) -> bool {
        let hulls: Vec<&Hull> = hulls.iter().collect();
        uncovered_triangles(self.mesh, &hulls, COVERED * self.diagonal(), self.deadline).is_empty()
    }
}
