//! Direction ↔ cell of the cube map (Kenwright 4.8).
//!
//! A direction pierces the cube [−1, 1]³ in one of six faces. Face `2·axis + s` is the one on which coordinate `axis` is
//! the largest by magnitude, `s` being 1 where it is negative. On it the other two coordinates, in cyclic order and
//! divided by the largest one's magnitude, are (u, v) ∈ [−1, 1]². Each is put on a grid of 2²⁴ cells by rounding
//! `u · SCALE + 2²³`; the bits of the two grid numbers, from the top, are the path through a tree over the face.
//!
//! The baker finds a cell's square by [`grid_to_uv`]; the runtime finds a direction's cell by [`locate`]. They agree up
//! to [`CELL_SLACK`], by which the baker widens every square.
//!
//! All arithmetic is in f64: the largest and smallest f32 need no scaling, and a cell is missed by at most 1e-15.

/// Bits of a grid number.
pub const GRID_BITS: u32 = 24;

/// Grid cells from the centre of a face to just inside its edge: `±SCALE` rounds into the grid without a clamp.
const SCALE: f64 = ((1 << (GRID_BITS - 1)) - 1) as f64;

/// Centre of the grid.
const CENTRE: f64 = (1 << (GRID_BITS - 1)) as f64;

/// Adding this to a number below 2⁵¹ rounds it to an integer in the low bits of the mantissa.
const ROUND_BY: f64 = (1_u64 << 52) as f64;

const GRID_MASK: u32 = (1 << GRID_BITS) - 1;

/// By how much, in units of u and v, a cell's square must be widened to hold every direction that [`locate`] puts in it.
///
/// One division, one product and one sum in f64 misplace u by less than 4·2⁻⁵³; this is a thousand times that.
pub const CELL_SLACK: f64 = 1e-12;

/// Where a direction pierces the cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Face of the cube, 0 to 5.
    pub face: u32,
    /// Grid number along u, below 2²⁴.
    pub u: u32,
    /// Grid number along v, below 2²⁴.
    pub v: u32,
}

/// Cell of the finest grid that `dir` falls into; `dir` need not be of unit length.
///
/// A direction that is zero or not finite gets some cell; every result is in range.
#[inline]
pub fn locate(dir: [f64; 3]) -> Cell {
    let [ax, ay, az] = dir.map(f64::abs);
    let z_wins = az > ax && az > ay;
    let y_wins = !z_wins && ay > ax;
    // Written as selects, without branches: directions are as good as random to a branch predictor.
    let (largest, a, b, axis) = if z_wins {
        (dir[2], dir[0], dir[1], 2)
    } else if y_wins {
        (dir[1], dir[2], dir[0], 1)
    } else {
        (dir[0], dir[1], dir[2], 0)
    };
    let negative = u32::from(largest.is_sign_negative());
    let size = largest.abs();
    Cell { face: 2 * axis + negative, u: grid(a / size), v: grid(b / size) }
}

#[inline]
fn grid(u: f64) -> u32 {
    // NaN leaves some bits in the mantissa; the mask keeps them in range.
    (u * SCALE + (CENTRE + ROUND_BY)).to_bits() as u32 & GRID_MASK
}

/// Lower edge, in u or v, of grid cell `g`; the upper edge is that of `g + 1`.
#[inline]
pub fn grid_to_uv(g: u32) -> f64 {
    (f64::from(g) - 0.5 - CENTRE) / SCALE
}

/// The direction through point (u, v) of `face`; its largest coordinate is ±1.
#[inline]
pub fn direction(face: u32, u: f64, v: f64) -> [f64; 3] {
    let axis = (face / 2) as usize;
    let mut dir = [0.0; 3];
    dir[axis] = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    dir[(axis + 1) % 3] = u;
    dir[(axis + 2) % 3] = v;
    dir
}

/// Cell of a uniform cube map with `resolution` cells along a face's edge, row by row, face by face.
#[inline]
pub fn uniform_cell(cell: Cell, resolution: u32) -> u64 {
    let column = uniform_step(cell.u, resolution);
    let row = uniform_step(cell.v, resolution);
    (u64::from(cell.face) * u64::from(resolution) + row) * u64::from(resolution) + column
}

#[inline]
fn uniform_step(g: u32, resolution: u32) -> u64 {
    (u64::from(g) * u64::from(resolution)) >> GRID_BITS
}

/// First grid number in step `step` of a uniform cube map: the least `g` with `g · resolution ≥ step · 2²⁴`.
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

    #[test]
    fn located_cells_hold_their_direction() {
        let mut seed = 1;
        for _ in 0..100_000 {
            let dir = [next(&mut seed), next(&mut seed), next(&mut seed)];
            let cell = locate(dir);
            let axis = (cell.face / 2) as usize;
            let size = dir[axis].abs();
            assert!(dir.iter().all(|c| c.abs() <= size));
            assert_eq!(dir[axis] < 0.0, cell.face % 2 == 1);
            for (g, c) in [(cell.u, dir[(axis + 1) % 3]), (cell.v, dir[(axis + 2) % 3])] {
                let x = c / size;
                assert!(grid_to_uv(g) - CELL_SLACK <= x && x <= grid_to_uv(g + 1) + CELL_SLACK, "{dir:?}");
            }
            let back = direction(cell.face, dir[(axis + 1) % 3] / size, dir[(axis + 2) % 3] / size);
            let cosine: f64 = back.iter().zip(dir).map(|(b, d)| b * d).sum();
            assert!(cosine > 0.0);
        }
    }

    #[test]
    fn corners_and_seams_are_in_range() {
        for x in [-1.0, 0.0, 1.0] {
            for y in [-1.0, 0.0, 1.0] {
                for z in [-1.0, 0.0, 1.0] {
                    for scale in [1.0, f64::from(f32::MIN_POSITIVE) * 1e-7, f64::from(f32::MAX)] {
                        let cell = locate([x * scale, y * scale, z * scale]);
                        assert!(cell.face < 6 && cell.u <= GRID_MASK && cell.v <= GRID_MASK);
                        assert_eq!(cell, locate([x, y, z]), "scaling must not move a direction");
                    }
                }
            }
        }
    }

    #[test]
    fn numbers_that_are_no_directions_stay_in_range() {
        let bad = [0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.0, -0.0];
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
