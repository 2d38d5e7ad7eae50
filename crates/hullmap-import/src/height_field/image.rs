//! Greyscale PNG images of 8 or 16 bits.

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder, Limits};

use super::grid::{HeightOptions, Heights, flipped, sample_count};
use super::hole::Hole;
use crate::fault::LineFault;

/// A little above DEFLATE's greatest ratio, 1032. An image that claims to be larger is damaged.
const MAX_RATIO: usize = 1100;

const MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";

struct Samples {
    columns: usize,
    rows: usize,
    /// Row by row, the one with the least y first, which is the last one of the file.
    samples: Vec<u16>,
    white: u16,
}

pub(super) fn is_png(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

pub(super) fn heights(bytes: &[u8], options: &HeightOptions) -> Result<Heights, LineFault> {
    let Samples { columns, rows, samples, white } = samples(bytes)?;
    let grey = |hole: Hole| {
        let text = format!("no sample is {hole}; name a grey value from 0 to {white} with --set hole=V");
        hole.grey(white).ok_or_else(|| LineFault::of_file(text))
    };
    let hole = options.hole.map(grey).transpose()?;
    let height = |sample: &u16| match *sample {
        sample if Some(sample) == hole => f32::NAN,
        sample => options.height(f64::from(sample) / f64::from(white)),
    };
    let heights = samples.iter().map(height).collect();
    let hole_samples = samples.iter().filter(|sample| Some(**sample) == hole).count();
    Ok(Heights { columns, rows, heights, hole_samples, origin: None, spacing: None, is_image: true })
}

pub(super) fn holes(bytes: &[u8], columns: usize, rows: usize) -> Result<Vec<bool>, LineFault> {
    if !is_png(bytes) {
        return Err(LineFault::of_file("holes are given by a greyscale PNG; export the image as PNG"));
    }
    let image = samples(bytes)?;
    let (across, along) = (columns.saturating_sub(1), rows.saturating_sub(1));
    let is_black = |column: usize, row: usize| image.samples.get(row * image.columns + column) == Some(&0);
    let steps: &[(usize, usize)] = match [image.columns, image.rows] {
        size if size == [columns, rows] => &[(0, 0), (1, 0), (0, 1), (1, 1)],
        size if size == [across, along] => &[(0, 0)],
        [width, height] => {
            let text = format!(
                "the image has {width} × {height} pixels; expected {columns} × {rows} for the vertices of the height \
                 field, or {across} × {along} for its cells"
            );
            return Err(LineFault::of_file(text));
        }
    };
    let cells = (0..along).flat_map(|row| (0..across).map(move |column| (column, row)));
    Ok(cells.map(|(column, row)| steps.iter().any(|(dx, dy)| is_black(column + dx, row + dy))).collect())
}

fn samples(bytes: &[u8]) -> Result<Samples, LineFault> {
    let damaged = |error: png::DecodingError| LineFault::of_file(format!("damaged PNG: {error}; export it again"));
    let limit = bytes.len().saturating_mul(MAX_RATIO);
    let decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: limit.saturating_add(1 << 20) });
    let mut reader = decoder.read_info().map_err(damaged)?;
    let (width, height) = reader.info().size();
    let (columns, rows) = (width as usize, height as usize);
    let count = sample_count(columns, rows)?;
    let (color, depth) = reader.output_color_type();
    let size = match (color, depth) {
        (ColorType::Grayscale, BitDepth::Eight) => count,
        (ColorType::Grayscale, BitDepth::Sixteen) => 2 * count,
        _ => {
            let kind = match color {
                ColorType::Grayscale => "greyscale",
                ColorType::GrayscaleAlpha => "greyscale with alpha",
                ColorType::Indexed => "a palette",
                ColorType::Rgb => "colour",
                ColorType::Rgba => "colour with alpha",
            };
            let bits = depth as u8;
            let text = format!(
                "the image is {kind} of {bits} bits; heights need greyscale of 16 bits, or of 8: convert it, for \
                 instance with `magick IN -colorspace gray -depth 16 -define png:color-type=0 OUT`"
            );
            return Err(LineFault::of_file(text));
        }
    };
    if size > limit {
        let text =
            format!("damaged PNG: {} bytes cannot hold {columns} × {rows} samples; export it again", bytes.len());
        return Err(LineFault::of_file(text));
    }
    let mut pixels = vec![0; size];
    reader.next_frame(&mut pixels).map_err(damaged)?;
    let (samples, white) = if size == count {
        (pixels.iter().map(|sample| u16::from(*sample)).collect::<Vec<u16>>(), u16::from(u8::MAX))
    } else {
        let (pairs, _) = pixels.as_chunks::<2>();
        (pairs.iter().map(|pair| u16::from_be_bytes(*pair)).collect(), u16::MAX)
    };
    Ok(Samples { columns, rows, samples: flipped(&samples, columns), white })
}
