//! Options of a height field, and their text in its file.
//!
//! The text names every option that is set, as `height-field scale 100 offset 0 diagonal rising
//! spacing 2 2 …`. The name of the image of holes is last, since it may have spaces.

use std::fmt;

use hullmap::height_field::Diagonal;
use hullmap_import::height_field::{HeightOptions, Hole};

use crate::args::height_field::{HeightFieldArgs, name};

const WORD: &str = "height-field";

const HOLE_IMAGE: &str = " hole-image ";

#[derive(Clone, Debug, PartialEq)]
pub struct FieldOptions {
    /// `None`: 1, and an error for images.
    pub scale: Option<f64>,
    pub offset: f64,
    pub diagonal: Diagonal,
    pub spacing: Option<[f64; 2]>,
    pub origin: Option<[f64; 2]>,
    pub hole: Option<Hole>,
    /// Columns and rows of raw numbers.
    pub raw: Option<[usize; 2]>,
    /// Name of the image of holes, beside the source.
    pub hole_image: Option<String>,
}

impl FieldOptions {
    pub fn from_args(args: &HeightFieldArgs) -> Self {
        Self {
            scale: args.height_scale,
            offset: args.height_offset,
            diagonal: args.diagonal,
            spacing: args.spacing,
            origin: args.origin,
            hole: args.hole,
            raw: args.columns.zip(args.rows).map(|(columns, rows)| [columns as usize, rows as usize]),
            hole_image: args.hole_image.clone(),
        }
    }

    pub fn from_recorded(text: &str) -> Option<Self> {
        let (text, hole_image) = match text.split_once(HOLE_IMAGE) {
            // The file may be hostile, so the name must not lead to another folder.
            Some((text, image)) => (text, Some(name(image).ok()?)),
            None => (text, None),
        };
        let mut words = text.split(' ');
        if words.next() != Some(WORD) {
            return None;
        }
        let diagonal = Diagonal::default();
        let mut options =
            Self { scale: None, offset: 0.0, diagonal, spacing: None, origin: None, hole: None, raw: None, hole_image };
        while let Some(key) = words.next() {
            if key == "hole" {
                options.hole = Some(words.next()?.parse().ok()?);
                continue;
            }
            let mut number = || words.next()?.parse::<f64>().ok();
            match key {
                "scale" => options.scale = Some(number()?),
                "offset" => options.offset = number()?,
                "spacing" => options.spacing = Some([number()?, number()?]),
                "origin" => options.origin = Some([number()?, number()?]),
                "raw" => options.raw = Some([number()? as usize, number()? as usize]),
                "diagonal" => {
                    let name = words.next()?;
                    options.diagonal = Diagonal::ALL.into_iter().find(|own| own.as_str() == name)?;
                }
                _ => return None,
            }
        }
        Some(options)
    }

    pub fn samples(&self) -> HeightOptions {
        HeightOptions { scale: self.scale.unwrap_or(1.0), offset: self.offset, hole: self.hole, raw: self.raw }
    }
}

impl fmt::Display for FieldOptions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{WORD}")?;
        if let Some(scale) = self.scale {
            write!(f, " scale {scale}")?;
        }
        write!(f, " offset {} diagonal {}", self.offset, self.diagonal)?;
        for (key, pair) in [("spacing", self.spacing), ("origin", self.origin)] {
            if let Some([x, y]) = pair {
                write!(f, " {key} {x} {y}")?;
            }
        }
        if let Some(hole) = self.hole {
            write!(f, " hole {hole}")?;
        }
        if let Some([columns, rows]) = self.raw {
            write!(f, " raw {columns} {rows}")?;
        }
        match &self.hole_image {
            Some(name) => write!(f, "{HOLE_IMAGE}{name}"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recorded_options_lead_back() {
        let plain = FieldOptions {
            scale: None,
            offset: 0.0,
            diagonal: Diagonal::Rising,
            spacing: None,
            origin: None,
            hole: None,
            raw: None,
            hole_image: None,
        };
        assert_eq!(plain.to_string(), "height-field offset 0 diagonal rising");
        let all = FieldOptions {
            scale: Some(0.1),
            offset: -1e-300,
            diagonal: Diagonal::Falling,
            spacing: Some([0.3, 1e9]),
            origin: Some([-5.25, 7e5]),
            hole: "-3.402823e+38".parse().ok(),
            raw: Some([17, 4096]),
            hole_image: Some("holes of hole-image x.png".to_owned()),
        };
        for options in [plain, all] {
            assert_eq!(FieldOptions::from_recorded(&options.to_string()), Some(options));
        }
        for text in [
            "",
            "index tree",
            "height-field scale",
            "height-field scale x",
            "height-field up 1",
            "height-field hole-image ../x",
        ] {
            assert_eq!(FieldOptions::from_recorded(text), None, "{text}");
        }
    }
}
