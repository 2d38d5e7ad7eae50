//! Import of heights on a grid: greyscale PNG, ESRI ASCII grid, raw numbers of 32 bits.
//!
//! A sample becomes the height `offset + scale · sample`, computed in f64 and rounded to f32.
//! Samples of an image count from 0, black, to 1, white. Rows are returned in the order of y:
//! images and ESRI grids start with the greatest y, files of raw numbers with the least.
//!
//! # Reference
//! ESRI ASCII grid: "Esri ASCII raster format", ArcGIS documentation. Its samples belong to the
//! middles of its cells, which become vertices here.

mod esri;
mod grid;
mod hole;
mod image;
mod raw;
#[cfg(test)]
mod tests;

use std::path::Path;

pub use grid::{HeightOptions, Heights};
pub use hole::Hole;

use crate::fault::{ImportError, LineFault};
use crate::limits::Limits;
use crate::read::{ReadError, SourceFile, read_beside};

/// File name extensions of grids of heights, in lower case. Other files may be such a grid, and
/// files with these extensions may be something else.
pub const EXTENSIONS: [&str; 3] = ["asc", "png", "f32"];

/// Whether the extension of a file is one of [`EXTENSIONS`], in any case.
pub fn is_grid(path: &Path) -> bool {
    path.extension().is_some_and(|extension| EXTENSIONS.iter().any(|own| extension.eq_ignore_ascii_case(own)))
}

/// Reads a file of heights, of any format, and the image of its holes, if there is one beside it.
///
/// # Errors
/// A file cannot be read or is not a regular file, or they are larger than the limit.
pub fn read_heights(file: &str, path: &Path, holes: Option<&str>, limits: &Limits) -> Result<SourceFile, ReadError> {
    read_beside(file, path, limits, "image of holes", |_| Ok(holes.map(str::to_owned).into_iter().collect()))
}

/// Heights from the bytes of a file, whose name in messages is `file`.
///
/// # Errors
/// The bytes are in no format that is read, or are incomplete, or a height is too large for f32.
///
/// # Complexity
/// O(bytes + samples). There are at most 1,100 times as many samples as bytes.
///
/// # Examples
/// ```
/// use hullmap_import::height_field::{HeightOptions, import_heights};
///
/// let text = b"ncols 3\nnrows 2\nxllcorner 10\nyllcorner 20\ncellsize 2\n1 2 3\n4 5 -9999\n";
/// let heights = import_heights("a.asc", text, &HeightOptions::DEFAULT)?;
/// // The last row of the file has the least y.
/// assert_eq!(heights.heights[..2], [4.0, 5.0]);
/// assert!(heights.heights[2].is_nan());
/// assert_eq!((heights.origin, heights.spacing), (Some([11.0, 21.0]), Some([2.0, 2.0])));
/// # Ok::<(), hullmap_import::ImportError>(())
/// ```
pub fn import_heights(file: &str, bytes: &[u8], options: &HeightOptions) -> Result<Heights, ImportError> {
    let heights = if image::is_png(bytes) {
        image::heights(bytes, options)
    } else if let Some([columns, rows]) = options.raw {
        raw::heights(bytes, columns, rows, options)
    } else if esri::is_grid(bytes) {
        esri::heights(bytes, options)
    } else {
        let text = "expected a greyscale PNG, an ESRI ASCII grid that starts with `ncols`, or raw numbers of 32 bits, \
                    whose numbers of rows and columns are given (rows, columns)";
        Err(LineFault::of_file(text))
    };
    heights.and_then(finite).map_err(|fault| in_file(file, fault))
}

/// Holes from an image in which black is a hole: as large as the grid, for its vertices, or smaller
/// by one in both directions, for its cells. Returns whether each cell is a hole.
///
/// # Errors
/// The bytes are not a greyscale PNG of one of these sizes.
pub fn import_holes(file: &str, bytes: &[u8], columns: usize, rows: usize) -> Result<Vec<bool>, ImportError> {
    image::holes(bytes, columns, rows).map_err(|fault| in_file(file, fault))
}

fn in_file(file: &str, LineFault { line, fault }: LineFault) -> ImportError {
    ImportError { file: file.to_owned(), line, fault }
}

fn finite(heights: Heights) -> Result<Heights, LineFault> {
    match heights.heights.iter().position(|height| height.is_infinite()) {
        Some(at) => {
            let (column, row) = (at % heights.columns.max(1), at / heights.columns.max(1));
            let text = format!(
                "the height at column {column}, row {row} (counted from the least y) is infinite in 32-bit floats; \
                 correct the sample, or choose another --set height_scale"
            );
            Err(LineFault::of_file(text))
        }
        None => Ok(heights),
    }
}
