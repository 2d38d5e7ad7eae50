//! Heights on a grid, and how samples become heights.

use super::hole::Hole;
use crate::fault::LineFault;

/// Maximum number of samples: a height field has at most 2²⁷ cells.
const MAX_SAMPLES: usize = 1 << 28;

/// How samples become heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightOptions {
    /// Height of a sample of 1 above a sample of 0; in an image, of white above black.
    pub scale: f64,
    /// Height of a sample of 0.
    pub offset: f64,
    /// Samples without ground; in an image, a whole number from 0 to 65535 (or 255). In grids of
    /// numbers, NaN never has ground.
    pub hole: Option<Hole>,
    /// Numbers of columns and rows of a file of raw numbers, which does not state them.
    pub raw: Option<[usize; 2]>,
}

impl HeightOptions {
    /// Samples are heights.
    pub const DEFAULT: Self = Self { scale: 1.0, offset: 0.0, hole: None, raw: None };

    pub(super) fn height(&self, sample: f64) -> f32 {
        (self.offset + self.scale * sample) as f32
    }

    /// The height of a sample of a grid of numbers; NaN for [`hole`](Self::hole), which is counted.
    pub(super) fn height_of_number(&self, sample: f64, hole_samples: &mut usize) -> f32 {
        let is_hole = self.hole.is_some_and(|hole| hole.is_number(sample));
        *hole_samples += usize::from(is_hole);
        if is_hole { f32::NAN } else { self.height(sample) }
    }
}

/// Heights on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Heights {
    /// Number of samples along x.
    pub columns: usize,
    /// Number of samples along y.
    pub rows: usize,
    /// Heights, row by row, the row with the least y first; NaN without ground.
    pub heights: Vec<f32>,
    /// Number of samples that are the [hole](HeightOptions::hole) of the options.
    pub hole_samples: usize,
    /// x and y of the first sample, if the file states them.
    pub origin: Option<[f64; 2]>,
    /// Distance of samples along x and y, if the file states it.
    pub spacing: Option<[f64; 2]>,
    /// Whether the file is an image, whose samples count from 0 to 1.
    pub is_image: bool,
}

/// Number of samples, if it is not too large.
pub(super) fn sample_count(columns: usize, rows: usize) -> Result<usize, LineFault> {
    columns.checked_mul(rows).filter(|count| (1..=MAX_SAMPLES).contains(count)).ok_or_else(|| {
        let text = format!(
            "{columns} × {rows} samples (expected at least 1, and at most {MAX_SAMPLES}); use a part of the grid"
        );
        LineFault::of_file(text)
    })
}

pub(super) fn flipped<T: Copy>(samples: &[T], columns: usize) -> Vec<T> {
    samples.chunks(columns.max(1)).rev().flatten().copied().collect()
}
