//! Direction ↔ cell of the cube map (Kenwright 4.8).
//!
//! A direction pierces one of the six faces of the cube [−1, 1]³. On face `2·axis + s`, coordinate
//! `axis` has the largest magnitude; `s` is 1 if it is negative. The other two coordinates, in
//! cyclic order and divided by that magnitude, are (u, v), both in [−1, 1]. Rounding `u · SCALE +
//! 2²²` gives the index of u in a grid of 2²³ cells, and likewise v. The bits of both indices, from
//! the top, are the path through a tree over the face.
//!
//! The baker computes a cell's square with [`grid_to_uv`]; the runtime computes a direction's cell
//! with [`locate`], in f32 with one division and no branch. It is off by at most 3e-7 in u or v,
//! less than the [`CELL_SLACK`] by which the baker widens squares. Directions outside of
//! [`IN_RANGE`] are scaled into it first, within the slack.

use std::ops::RangeInclusive;

/// Bits of a grid index.
pub const GRID_BITS: u32 = 23;

/// Range of [`largest`] in which the result of [`locate`] is within [`CELL_SLACK`].
pub const IN_RANGE: RangeInclusive<f32> = 1e-30..=1e30;

/// Number of grid cells from the centre of a face to just inside its edge. So `±SCALE` rounds into
/// the grid without a clamp.
const SCALE: f32 = ((1 << (GRID_BITS - 1)) - 1) as f32;

const CENTRE: u32 = 1 << (GRID_BITS - 1);

/// Added to a number of magnitude below 2²², it rounds to an integer, plus 2²² in the low bits of
/// the mantissa.
const ROUND_BY: f32 = (3_u32 << (GRID_BITS - 1)) as f32;

const GRID_MASK: u32 = (1 << GRID_BITS) - 1;

/// Margin, in units of u and v, by which a cell's square contains every direction that [`locate`]
/// assigns to it. Five roundings, of both coordinates to f32, the quotient, the product and the
/// sum, move u by at most five times 2⁻²⁴, 3e-7.
pub const CELL_SLACK: f64 = 4e-7;

/// Where a direction pierces the cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Face of the cube, 0 to 5.
    pub face: u32,
    /// Grid index along u, below 2²³.
    pub u: u32,
    /// Grid index along v, below 2²³.
    pub v: u32,
}

/// Maximum magnitude of a direction's coordinates. A NaN is ignored or returned.
#[inline]
pub fn largest(dir: [f32; 3]) -> f32 {
    let [x, y, z] = dir.map(f32::abs);
    let xy = if x > y { x } else { y };
    if z > xy { z } else { xy }
}

/// Cell of the finest grid that contains `dir`, which need not be of unit length, but whose
/// [`largest`] coordinate should be [`IN_RANGE`]. For any other direction, some cell in range is
/// returned.
#[inline]
#[expect(clippy::indexing_slicing, reason = "`axis` is 0, 1 or 2: where z wins, y does not")]
pub fn locate(dir: [f32; 3]) -> Cell {
    let [ax, ay, az] = dir.map(f32::abs);
    let size = largest(dir);
    // Without branches: a branch predictor cannot predict directions.
    let z_wins = (az > ax) & (az > ay);
    let y_wins = !z_wins & (ay > ax);
    let axis = usize::from(y_wins) | usize::from(z_wins) << 1;
    let grid = dir.map(|c| (c / size * SCALE + ROUND_BY).to_bits() & GRID_MASK);
    let negative = dir[axis].to_bits() >> 31;
    let turned = [grid[1], grid[2], grid[0], grid[1]];
    Cell { face: 2 * axis as u32 + negative, u: turned[axis], v: turned[axis + 1] }
}

/// Lower edge, in u or v, of grid cell `g`; its upper edge is the lower edge of `g + 1`.
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

/// Cell of a uniform cube map with `resolution` cells along a face's edge, by faces and rows. An
/// unchecked file's resolution near 2³² makes the result wrap around.
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

/// First grid index in step `step` of a uniform cube map: the smallest `g` for which
/// `g · resolution ≥ step · 2²³`.
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

    fn triples(values: &[f32]) -> impl Iterator<Item = [f32; 3]> {
        let pairs = values.iter().flat_map(|x| values.iter().map(|y| [*x, *y]));
        pairs.flat_map(|[x, y]| values.iter().map(move |z| [x, y, *z]))
    }

    /// Regression: a pack opened without checks caused an overflow, which panics in debug builds.
    #[test]
    fn overflowing_resolutions_do_not_panic() {
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
            // The direction before rounding to f32 is covered as well.
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
        for dir in triples(&[-1.0, 0.0, 1.0]) {
            for scale in [1.0, *IN_RANGE.start(), *IN_RANGE.end()] {
                let cell = locate(dir.map(|c| c * scale));
                assert!(cell.face < 6 && cell.u <= GRID_MASK && cell.v <= GRID_MASK);
                assert!(dir == [0.0; 3] || cell == locate(dir), "scaling must not move a direction");
            }
        }
    }

    #[test]
    fn invalid_directions_stay_in_range() {
        let bad = [0.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0, -0.0, f32::MAX, f32::MIN_POSITIVE * 1e-6];
        for dir in triples(&bad) {
            let cell = locate(dir);
            assert!(cell.face < 6 && cell.u <= GRID_MASK && cell.v <= GRID_MASK);
            assert!(uniform_cell(cell, 7) < 6 * 49);
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
