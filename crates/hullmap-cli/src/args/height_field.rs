use hullmap::height_field::Diagonal;
use hullmap_import::height_field::Hole;

use crate::options::table::Section;

/// How a height field is baked.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = Section::Shape.heading())]
pub struct HeightFieldArgs {
    /// Bake grids of heights: greyscale PNG, ESRI ASCII, raw f32
    #[arg(long = "height-field")]
    pub is_set: bool,
    /// Distance between vertices; PNG and raw files require it
    #[arg(long, value_name = "X[,Y]", value_parser = spacing, requires = "is_set", hide_short_help = true)]
    pub spacing: Option<[f64; 2]>,
    /// Height of white above black, which PNG requires, or a factor
    #[arg(long, value_name = "S", value_parser = finite, allow_hyphen_values = true, requires = "is_set", hide_short_help = true)]
    pub height_scale: Option<f64>,
    /// Height of a sample of 0
    #[arg(long, value_name = "O", value_parser = finite, default_value_t = 0.0, allow_hyphen_values = true, requires = "is_set", hide_short_help = true)]
    pub height_offset: f64,
    /// First vertex [default: the file's, or field centred at 0 0]
    #[arg(long, value_name = "X,Y", value_parser = two, allow_hyphen_values = true, requires = "is_set", hide_short_help = true)]
    pub origin: Option<[f64; 2]>,
    /// Sample that means no ground, compared as samples are stored
    #[arg(long, value_name = "V", allow_hyphen_values = true, requires = "is_set", hide_short_help = true)]
    pub hole: Option<Hole>,
    /// PNG beside each INPUT in which black pixels are holes
    #[arg(long, value_name = "NAME", value_parser = name, requires = "is_set", hide_short_help = true)]
    pub hole_image: Option<String>,
    /// Number of rows of raw numbers; the first has the least y
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..), requires = "columns", hide_short_help = true)]
    pub rows: Option<u32>,
    /// Number of columns of raw numbers
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..), requires_all = ["is_set", "rows"], hide_short_help = true)]
    pub columns: Option<u32>,
    /// Diagonal that divides each cell
    #[arg(long, value_name = "rising|falling", value_parser = diagonal, default_value = "rising", requires = "is_set", hide_short_help = true)]
    pub diagonal: Diagonal,
}

fn finite(text: &str) -> Result<f64, String> {
    text.trim()
        .parse()
        .ok()
        .filter(|number: &f64| number.is_finite())
        .ok_or_else(|| "expected a finite number".to_owned())
}

fn two(text: &str) -> Result<[f64; 2], String> {
    let (x, y) = text.split_once(',').ok_or("expected two numbers, such as 100,250")?;
    Ok([finite(x)?, finite(y)?])
}

fn spacing(text: &str) -> Result<[f64; 2], String> {
    let both = if text.contains(',') { two(text)? } else { [finite(text)?; 2] };
    if both.iter().all(|length| *length > 0.0) { Ok(both) } else { Err("expected lengths above 0".to_owned()) }
}

fn diagonal(text: &str) -> Result<Diagonal, String> {
    Diagonal::ALL.into_iter().find(|own| own.as_str() == text).ok_or_else(|| "expected rising or falling".to_owned())
}

pub fn name(text: &str) -> Result<String, String> {
    let is_plain = !text.is_empty() && !text.contains(['/', '\\', '\n']) && text != "..";
    if is_plain {
        Ok(text.to_owned())
    } else {
        Err("expected the name of a file beside the input, without a folder".to_owned())
    }
}
