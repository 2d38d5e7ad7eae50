//! Voids: the places inside a mesh's solid that are in none of its parts. A small body that starts
//! there touches nothing.
//!
//! # Steps
//! 1. Start with the box around the mesh. Drop a cell that is all in one part. The centre of a cell
//!    that no part and no triangle touches decides for all of it. Divide every other cell into
//!    eight.
//! 2. One point of a fixed sequence, which is the same everywhere, decides each cell of the last
//!    level. After the deadline, the current level is the last one if it has at least 16 cells
//!    along each axis, and of many cells only some are decided.
//!
//! # Reference
//! Meagher, "Geometric modeling using octree encoding", 1982.
//!
//! # Deviations
//! - Meagher's cells of the last level count as full. One point in each gives an estimate without
//!   bias, with an error that can be stated.

use glam::DVec3;
use rayon::prelude::*;

use super::{Solid, region::Region};
use crate::{
    deadline::{Deadline, is_over},
    hull::Hull,
    spread::spread,
};

/// The volume of a solid that is in no part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Voids {
    /// The estimate, in cubic units of the positions.
    pub volume: f64,
    /// Twice the maximum standard deviation, for random points.
    pub error: f64,
}

impl Voids {
    /// Relative to the volume of the solid, which is above 0.
    pub fn relative_to(self, volume: f64) -> VoidsShare {
        let share = |part: f64| (part / volume).clamp(0.0, 1.0);
        VoidsShare { share: share(self.volume), error: share(self.error) }
    }
}

/// The share of a solid's volume that is in no part: 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VoidsShare {
    /// The estimate.
    pub share: f64,
    /// Its error, as in [`Voids`].
    pub error: f64,
}

/// Number of times that the box around the mesh is halved along each axis.
const LEVELS: u32 = 6;

/// The level that is always finished, also when the time is over.
const LATE_LEVEL: u32 = 4;

/// Maximum number of cells that are decided by a point when the time is over.
const LATE_CELLS: usize = 4096;

struct Voxel {
    place: [u32; 3],
    parts: Vec<u32>,
}

enum Judged {
    Full,
    Void,
    Open(Vec<u32>),
}

/// Estimates the volume of `solid` in none of `parts`, in one frame: 0 for a solid without an
/// inside. After the deadline, the estimate is a coarse one, as its error states.
///
/// # Complexity
/// At most 8⁶ cells, each compared with the planes of the parts that touch the cell around it. An
/// undecided cell of the last level may take a ray through the mesh.
pub fn voids(solid: &Solid, parts: &[&Hull], deadline: Option<Deadline>) -> Voids {
    if solid.is_hollow() {
        return Voids::default();
    }
    let regions: Vec<Region> = parts.iter().filter(|part| part.rank == 3).map(|part| Region::new(part)).collect();
    let [low, high] = solid.bounds();
    let mut open = vec![Voxel { place: [0; 3], parts: (0..regions.len() as u32).collect() }];
    let mut volume = 0.0;
    let mut size = high - low;
    for level in 0..=LEVELS {
        size = (high - low) / f64::from(1 << level);
        let judge = |cell: Voxel| {
            let is_late = level > LATE_LEVEL && is_over(deadline);
            let judged = if is_late { Judged::Open(cell.parts) } else { judge(solid, &regions, &cell, low, size) };
            (judged, cell.place)
        };
        let judged: Vec<(Judged, [u32; 3])> = open.into_par_iter().map(judge).collect();
        let is_last = level == LEVELS || level >= LATE_LEVEL && is_over(deadline);
        open = Vec::new();
        for (judged, place) in judged {
            match judged {
                Judged::Full => {}
                Judged::Void => volume += size.element_product(),
                Judged::Open(parts) if is_last => open.push(Voxel { place, parts }),
                Judged::Open(parts) => open.extend((0..8).map(|child| Voxel {
                    place: [0, 1, 2].map(|axis| 2 * place[axis] + (child >> axis & 1)),
                    parts: parts.clone(),
                })),
            }
        }
        if is_last {
            break;
        }
    }
    let stride = if is_over(deadline) { open.len().div_ceil(LATE_CELLS).max(1) } else { 1 };
    let decided: Vec<&Voxel> = open.iter().step_by(stride).collect();
    let empty = decided.par_iter().filter(|cell| is_void(solid, &regions, cell, low, size)).count() as f64;
    let count = decided.len() as f64;
    let cell = size.element_product() * open.len() as f64 / count.max(1.0);
    // The variance of n points with the mean p is at most n p (1 − p). One more keeps it above 0.
    let deviation = cell * ((empty + 1.0) * (1.0 - empty / (count + 1.0))).sqrt();
    Voids { volume: volume + cell * empty, error: 2.0 * deviation }
}

fn judge(solid: &Solid, regions: &[Region], cell: &Voxel, low: DVec3, size: DVec3) -> Judged {
    let from = low + DVec3::from_array(cell.place.map(f64::from)) * size;
    let to = from + size;
    let parts: Vec<u32> =
        cell.parts.iter().copied().filter(|part| !regions[*part as usize].misses_box(from, to)).collect();
    if parts.iter().any(|part| regions[*part as usize].holds_box(from, to)) {
        Judged::Full
    } else if parts.is_empty() && solid.triangles_in(from, to).is_empty() {
        if solid.is_inside((from + to) / 2.0) { Judged::Void } else { Judged::Full }
    } else {
        Judged::Open(parts)
    }
}

fn is_void(solid: &Solid, regions: &[Region], cell: &Voxel, low: DVec3, size: DVec3) -> bool {
    let [x, y, z] = cell.place.map(|place| place as usize);
    let k = x | y << LEVELS | z << (2 * LEVELS);
    let p = low + (DVec3::from_array(cell.place.map(f64::from)) + DVec3::from_array(spread(k))) * size;
    !cell.parts.iter().any(|part| regions[*part as usize].holds(p, 0.0)) && solid.is_inside(p)
}

#[cfg(test)]
mod tests {
    use std::{
        sync::atomic::{AtomicU64, Ordering},
        time::Duration,
    };

    use shapes::concave;

    use super::*;
    use crate::{
        hull,
        test_meshes::{block, box_hull, hull_of, on_threads, point_set},
    };

    fn cube() -> Solid {
        Solid::new(&block([-1.0; 3], [1.0; 3]))
    }

    fn octahedron() -> Hull {
        hull_of([1.0, -1.0].iter().flat_map(|sign| DVec3::AXES.map(|p| (p * sign).as_vec3().to_array())).collect())
    }

    #[track_caller]
    fn assert_near(found: Voids, truth: f64, most_error: f64) {
        println!("{found:?}, truth {truth}");
        assert!((found.volume - truth).abs() <= found.error && found.error <= most_error, "{found:?}, not {truth}");
    }

    #[test]
    fn what_no_part_covers_of_a_cube_is_known() {
        let solid = cube();
        assert_near(voids(&solid, &[&octahedron()], None), 8.0 - 4.0 / 3.0, 4e-3);
        // Six slabs around a hollow that is in no plane of the grid.
        let hollow: [f32; 2] = [-0.37, 0.41];
        let slab = |i: usize| {
            let (axis, side) = (i % 3, i / 3);
            let (mut low, mut high) = ([-1.0; 3], [1.0; 3]);
            if side == 0 {
                high[axis] = hollow[0]
            } else {
                low[axis] = hollow[1]
            }
            box_hull(low, high)
        };
        let slabs: Vec<Hull> = (0..6).map(slab).collect();
        let truth = (f64::from(hollow[1]) - f64::from(hollow[0])).powi(3);
        assert_near(voids(&solid, &slabs.iter().collect::<Vec<_>>(), None), truth, 4e-3);
        assert_near(voids(&solid, &[], None), 8.0, 1e-4);
        let (large, half) = (box_hull([-2.0; 3], [2.0; 3]), box_hull([-1.0; 3], [1.5, 0.1, 3.0]));
        assert_eq!(voids(&solid, &[&large, &half], None).volume, 0.0);
        assert_near(voids(&solid, &[&half], None), 4.0 * 0.9, 4e-3);
    }

    /// Whenever the time ends, the estimate is as good as it states. On one thread, since the clock
    /// advances at each look: on several, chance would decide which cells are late, and a few
    /// estimates in a hundred are off by more than twice their deviation.
    #[test]
    fn late_estimates_state_their_error() {
        static NOW: AtomicU64 = AtomicU64::new(0);
        let (solid, part, truth) = (cube(), octahedron(), 8.0 - 4.0 / 3.0);
        let mut errors = Vec::new();
        for looks in [0, 4000, 10_000, 20_000, 10_000_000] {
            let now = || Duration::from_secs(NOW.fetch_add(1, Ordering::Relaxed));
            let deadline = Deadline::by(now, f64::from(looks));
            let found = on_threads(1, || voids(&solid, &[&part], Some(deadline)));
            assert_near(found, truth, 0.3);
            errors.push(found.error);
        }
        assert!(errors[0] > 4.0 * errors[4], "{errors:?}");
    }

    #[test]
    fn space_outside_the_solid_is_no_void() {
        let mesh = point_set(&concave::l());
        let solid = Solid::new(&mesh);
        let [low, high] = solid.bounds();
        let mut count = 0;
        let steps = 96;
        for i in 0..steps * steps * steps {
            let at = [i % steps, i / steps % steps, i / (steps * steps)].map(|k| (k as f64 + 0.5) / steps as f64);
            count += u32::from(solid.is_inside(low + (high - low) * DVec3::from_array(at)));
        }
        let truth = (high - low).element_product() * f64::from(count) / (steps * steps * steps) as f64;
        let found = voids(&solid, &[], None);
        assert!((found.volume - truth).abs() < 0.01 * truth, "{found:?} {truth}");
        assert_eq!(voids(&solid, &[&hull::build(&mesh).unwrap()], None).volume, 0.0);
    }

    #[test]
    fn the_estimate_is_the_same_for_any_number_of_threads() {
        let solid = Solid::new(&point_set(&concave::mug(24)));
        let part = box_hull([-0.5; 3], [0.5; 3]);
        let with = |threads| on_threads(threads, || voids(&solid, &[&part], None));
        assert!(with(1).volume > 0.0);
        assert_eq!(with(1), with(5));
    }
}
