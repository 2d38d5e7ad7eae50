//! Files of raw numbers: little-endian f32, row by row, the row with the least y first.

use super::grid::{HeightOptions, Heights, sample_count};
use crate::fault::LineFault;

pub(super) fn heights(
    bytes: &[u8],
    columns: usize,
    rows: usize,
    options: &HeightOptions,
) -> Result<Heights, LineFault> {
    let expected = sample_count(columns, rows)?.saturating_mul(4);
    if bytes.len() != expected {
        let text = format!(
            "the file has {} bytes, but {rows} rows of {columns} numbers of 32 bits take {expected}; check --set rows \
             and --set columns, and that the file is complete",
            bytes.len()
        );
        return Err(LineFault::of_file(text));
    }
    let (samples, _) = bytes.as_chunks::<4>();
    let mut hole_samples = 0;
    let number = |sample: &[u8; 4]| f64::from(f32::from_le_bytes(*sample));
    let heights = samples.iter().map(|sample| options.height_of_number(number(sample), &mut hole_samples)).collect();
    Ok(Heights { columns, rows, heights, hole_samples, origin: None, spacing: None, is_image: false })
}
