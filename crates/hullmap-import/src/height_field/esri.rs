//! ESRI ASCII grids: a header of keys with numbers, then the samples, the top row first.

use super::grid::{HeightOptions, Heights, flipped, sample_count};
use super::hole::Hole;
use crate::fault::{Fault, LineFault, excerpt};
use crate::tokens::{Tokens, text};

/// Sample without ground, unless the header states another one.
const NO_DATA: f64 = -9999.0;

pub(super) fn is_grid(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"ncols"))
}

#[derive(Default)]
struct Head {
    columns: Option<f64>,
    rows: Option<f64>,
    size: Option<f64>,
    no_data: Option<Hole>,
    /// x and y of the lower left corner, or of the middle of the lower left cell.
    low: [Option<f64>; 2],
    /// Whether they belong to the middle of a cell.
    is_middle: [bool; 2],
}

pub(super) fn heights(bytes: &[u8], options: &HeightOptions) -> Result<Heights, LineFault> {
    let mut tokens = Tokens::new(bytes, 1);
    let head = head(&mut tokens)?;
    let whole = |count: Option<f64>, key: &str| {
        let count = count.filter(|count| count.fract() == 0.0 && (1.0..=4e9).contains(count));
        let text = format!("the header has no valid `{key}`; expected a whole number of at least 1");
        count.map(|count| count as usize).ok_or_else(|| LineFault::of_file(text))
    };
    let (columns, rows) = (whole(head.columns, "ncols")?, whole(head.rows, "nrows")?);
    let count = sample_count(columns, rows)?;
    let missing = |found: String| {
        let text = format!("{found} of {count} samples; complete the file, or correct `ncols` and `nrows`");
        Fault::format(text)
    };
    // Two bytes for each sample but the last: checked before memory is allocated.
    if tokens.rest().len().saturating_add(1) < 2 * count {
        return Err(missing(format!("at most {}", tokens.rest().len().div_ceil(2))).of_file());
    }
    let no_data = head.no_data.unwrap_or(Hole::new(NO_DATA));
    let mut hole_samples = 0;
    let mut samples = Vec::with_capacity(count);
    while samples.len() < count {
        let Some(word) = tokens.next() else { return Err(missing(samples.len().to_string()).of_file()) };
        let sample = number(word).map_err(|fault| fault.at_line(tokens.line()))?;
        let height = options.height_of_number(sample, &mut hole_samples);
        samples.push(if no_data.is_number(sample) { f32::NAN } else { height });
    }
    if let Some(word) = tokens.next() {
        let text = format!("`{}` after the last of {count} samples; correct `ncols` and `nrows`", excerpt(&text(word)));
        return Err(Fault::format(text).at_line(tokens.line()));
    }
    let size = head.size.filter(|size| *size > 0.0 && size.is_finite());
    let size = size.ok_or_else(|| LineFault::of_file("the header has no valid `cellsize`; expected a length"))?;
    let ([x, y], [mid_x, mid_y]) = (head.low, head.is_middle);
    let middle = |low: f64, is_middle: bool| if is_middle { low } else { low + 0.5 * size };
    let origin = x.zip(y).map(|(x, y)| [middle(x, mid_x), middle(y, mid_y)]);
    let heights = flipped(&samples, columns);
    Ok(Heights { columns, rows, heights, hole_samples, origin, spacing: Some([size; 2]), is_image: false })
}

/// Reads keys and their numbers, up to the first sample.
fn head(tokens: &mut Tokens) -> Result<Head, LineFault> {
    let mut head = Head::default();
    loop {
        let before = tokens.clone();
        let Some(word) = tokens.next() else { return Ok(head) };
        if !word.first().is_some_and(u8::is_ascii_alphabetic) || number(word).is_ok() {
            *tokens = before;
            return Ok(head);
        }
        let key = text(word).to_ascii_lowercase();
        let Some(word) = tokens.next_in_line() else {
            return Err(
                Fault::format(format!("`{}` has no value; complete the line", excerpt(&key))).at_line(tokens.line())
            );
        };
        let value = number(word).map_err(|fault| fault.at_line(tokens.line()))?;
        let [x, y] = &mut head.low;
        let [mid_x, mid_y] = &mut head.is_middle;
        let field = match key.as_str() {
            "ncols" => &mut head.columns,
            "nrows" => &mut head.rows,
            "cellsize" => &mut head.size,
            "nodata_value" => {
                head.no_data = Some(text(word).parse().unwrap_or(Hole::new(value)));
                continue;
            }
            "xllcorner" | "xllcenter" => {
                *mid_x = key == "xllcenter";
                x
            }
            "yllcorner" | "yllcenter" => {
                *mid_y = key == "yllcenter";
                y
            }
            _ => {
                let text = format!(
                    "unknown key `{}`; expected ncols, nrows, xllcorner, yllcorner, xllcenter, yllcenter, cellsize or \
                     nodata_value",
                    excerpt(&key)
                );
                return Err(Fault::format(text).at_line(tokens.line()));
            }
        };
        *field = Some(value);
    }
}

fn number(word: &[u8]) -> Result<f64, Fault> {
    let word = text(word);
    word.parse().map_err(|_| {
        Fault::format(format!("`{}` is not a number; expected a form such as -1.5 or 2e-3", excerpt(&word)))
    })
}
