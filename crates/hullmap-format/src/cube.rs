//! Direction ↔ cell of the cube map (Kenwright 4.8).
//!
//! A direction pierces the cube [−1, 1]³ in one of six faces. Face `2·axis + s` is the one on which coordinate `axis` is
//! the largest by magnitude, `s` being 1 where it is negative. On it the other two coordinates, in cyclic order and
//! divided by the largest one's magnitude, are (u, v) ∈ [−1, 1]². Each is put on a grid of 2²³ cells by rounding
//! `u · SCALE + 2²²`; the bits of the two grid numbers, from the top, are the path through a tree over the face.
//!
//! The baker finds a cell's square by [`grid_to_uv`]; the runtime finds a direction's cell by [`locate`]. They agree up
//! to [`CELL_SLACK`], by which the baker widens every square.
//!
//! Locating is done in f32, one division and no branch: a cell is then missed by at most 3e-7 in u or v, which
//! [`CELL_SLACK`] covers. Directions of every f32 or f64 size are brought into f32's comfortable range first
//! ([`IN_RANGE`]); that moves them by less than the slack as well.

use std::ops::RangeInclusive;

/// Bits of a grid number.
pub const GRID_BITS: u32 = 23;

/// Largest coordinate of a direction for which [`locate`] keeps its promise.
pub const IN_RANGE: RangeInclusive<f32> = 1e-30..=1e30;

/// Grid cells from the centre of a face to just inside its edge: `±SCALE` rounds into the grid without a clamp.
const SCALE: f32 = ((1 << (GRID_BITS - 1)) - 1) as f32;

/// Centre of the grid.
const CENTRE: u32 = 1 << (GRID_BITS - 1);

/// Adding this to a number below 2²² rounds it to an integer in the low bits of the mantissa, 2²² above it.
const ROUND_BY: f32 = (3_u32 << (GRID_BITS - 1)) as f32;

const GRID_MASK: u32 = (1 << GRID_BITS) - 1;

/// By how much, in units of u and v, a cell's square must be widened to hold every direction that [`locate`] puts in it.
///
/// Rounding both coordinates to f32, the quotient, the product and the sum misplace u by at most five times 2⁻²⁴, 3e-7.
pub const CELL_SLACK: f64 = 4e-7;

/// Where a direction pierces the cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Face of the cube, 0 to 5.
    pub face: u32,
    /// Grid number along u, below 2²³.
    pub u: u32,
    /// Grid number along v, below 2²³.
    pub v: u32,
}

/// Greatest magnitude of a direction's coordinates; a NaN is passed over or returned.
#[inline]
pub fn largest(dir: [f32; 3]) -> f32 {
    let [x, y, z] = dir.map(f32::abs);
    let xy = if x > y { x } else { y };
    if z > xy { z } else { xy }
}

/// Cell of the finest grid that `dir` falls into; `dir` need not be of unit length, but [`largest`] of it should be
/// [`IN_RANGE`]. For any other direction some cell comes back; every result is in range.
#[inline]
#[expect(clippy::indexing_slicing, reason = "`axis` is 0, 1 or 2: where z wins, y does not")]
pub fn locate(dir: [f32; 3]) -> Cell {
    let [ax, ay, az] = dir.map(f32::abs);
    let size = largest(dir);
    // Written without branches: directions are as good as random to a branch predictor.
    let z_wins = (az > ax) & (az > ay);
    let y_wins = !z_wins & (ay > ax);
    let axis = usize::from(y_wins) | usize::from(z_wins) << 1;
    let grid = dir.map(|c| (c / size * SCALE + ROUND_BY).to_bits() & GRID_MASK);
    let negative = dir[axis].to_bits() >> 31;
    let turned = [grid[1], grid[2], grid[0], grid[1]];
    Cell { face: 2 * axis as u32 + negative, u: turned[axis], v: turned[axis + 1] }
}

/// Lower edge, in u or v, of grid cell `g`; the upper edge is that of `g + 1`.
#[inline]
pub fn grid_to_uv(g: u32) -> f64 {
    (f64::from(g) - 0.5 - f64::from(CENTRE)) / f64::from(SCALE)
}

/// The direction through point (u, v) of `face`, 0 to 5; its largest coordinate is ±1.
#[inline]
#[expect(clippy::indexing_slicing, reason = "the bakers' faces are below 6, so that `axis` is 0, 1 or 2")]
pub fn direction(face: u32, u: f64, v: f64) -> [f64; 3] {
    let axis = (face / 2) as usize;
    let mut dir = [0.0; 3];
    dir[axis] = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    dir[(axis + 1) % 3] = u;
    dir[(axis + 2) % 3] = v;
    dir
}

/// Cell of a uniform cube map with `resolution` cells along a face's edge, row by row, face by face.
///
/// Resolutions near 2³², which a file that was not checked may state, have more cells than 64 bits count: some number comes back.
#[inline]
pub fn uniform_cell(cell: Cell, resolution: u32) -> u64 {
    let column = uniform_step(cell.u, resolution);
    let row = uniform_step(cell.v, resolution);
    let first_of_row = (u64::from(cell.face) * u64::from(resolution) + row).wrapping_mul(u64::from(resolution));
    first_of_row.wrapping_add(column)
}

#[inline]
fn uniform_step(g: u32, resolution: u32) -> u64 {
    (u64::from(g) * u64::from(resolution)) >> GRID_BITS
}

/// First grid number in step `step` of a uniform cube map: the least `g` with `g · resolution ≥ step · 2²³`.
pub fn uniform_step_start(step: u32, resolution: u32) -> u32 {
    (u64::from(step) << GRID_BITS).div_ceil(u64::from(resolution)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn next(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (*state >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
    }

    /// A pack opened without checks made it overflow, which panics where overflow is checked.
    #[test]
    fn resolutions_that_overflow_have_some_cell() {
        let last = Cell { face: 5, u: GRID_MASK, v: GRID_MASK };
        for resolution in [1 << 30, 1 << 31, u32::MAX - 1, u32::MAX] {
            uniform_cell(last, resolution);
        }
        assert_eq!(uniform_cell(last, 1 << 30), 6 * (1 << 60) - (1 << 37) + (1 << 30) - (1 << 7));
        assert_eq!(uniform_cell(last, 3), 53);
    }

    #[test]
    fn located_cells_hold_their_direction() {
        let mut seed = 1;
        for _ in 0..200_000 {
            let exact = [next(&mut seed), next(&mut seed), next(&mut seed)];
            let dir = exact.map(|c| c as f32);
            let cell = locate(dir);
            let axis = (cell.face / 2) as usize;
            assert!(dir.iter().all(|c| c.abs() <= dir[axis].abs()));
            assert_eq!(dir[axis] < 0.0, cell.face % 2 == 1);
            // The direction before it was rounded to f32 is covered as well.
            for dir in [exact, dir.map(f64::from)] {
                let size = dir[axis].abs();
                for (g, c) in [(cell.u, dir[(axis + 1) % 3]), (cell.v, dir[(axis + 2) % 3])] {
                    let x = c / size;
                    assert!(grid_to_uv(g) - CELL_SLACK <= x && x <= grid_to_uv(g + 1) + CELL_SLACK, "{dir:?}");
                }
                let back = direction(cell.face, dir[(axis + 1) % 3] / size, dir[(axis + 2) % 3] / size);
                let cosine: f64 = back.iter().zip(dir).map(|(b, d)| b * d).sum();
                assert!(cosine > 0.0);
            }
        }
    }

    #[test]
    fn corners_and_seams_are_in_range() {
        for x in [-1.0, 0.0, 1.0] {
            for y in [-1.0, 0.0, 1.0] {
                for z in [-1.0, 0.0, 1.0] {
                    for scale in [1.0, *IN_RANGE.start(), *IN_RANGE.end()] {
                        let cell = locate([x * scale, y * scale, z * scale]);
                        assert!(cell.face < 6 && cell.u <= GRID_MASK && cell.v <= GRID_MASK);
                        if [x, y, z] != [0.0; 3] {
                            assert_eq!(cell, locate([x, y, z]), "scaling must not move a direction");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn numbers_that_are_no_directions_stay_in_range() {
        let bad = [0.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0, -0.0, f32::MAX, f32::MIN_POSITIVE * 1e-6];
        for x in bad {
            for y in bad {
                for z in bad {
                    let cell = locate([x, y, z]);
                    assert!(cell.face < 6 && cell.u <= GRID_MASK && cell.v <= GRID_MASK);
                    assert!(uniform_cell(cell, 7) < 6 * 49);
                }
            }
        }
    }

    #[test]
    fn uniform_steps_tile_the_grid() {
        for resolution in [1, 2, 3, 7, 64, 1000] {
            for step in 0..=resolution {
                let start = uniform_step_start(step, resolution);
                if step < resolution {
                    assert_eq!(uniform_step(start, resolution), u64::from(step));
                }
                if step > 0 {
                    assert_eq!(uniform_step(start - 1, resolution), u64::from(step) - 1);
                }
            }
            assert_eq!(uniform_step_start(resolution, resolution), 1 << GRID_BITS);
        }
    }
}
