//! Values of options: which are accepted, and how they are written in flags, in `hullmap.toml` and
//! in records.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use hullmap_import::height_field::Hole;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Syntax {
    Words(&'static [&'static str]),
    Switch,
    Positive,
    CountOrNone {
        min: u32,
    },
    /// A finite number above 0, or `none`.
    PositiveOrNone,
    /// A finite number above 0, the same as a percentage, or `none`.
    /// A finite number above 0, the same followed by `mm`, a percentage of at most 100, or `none`.
    LengthOrNone,
    Finite,
    FiniteOrNone,
    /// Two finite numbers, or `none`.
    PairOrNone,
    /// One or two finite numbers above 0, or `none`.
    SpacingOrNone,
    /// The value of a sample without ground, or `none`.
    HoleOrNone,
    /// The name of a file beside the source, or `none`.
    NameOrNone,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    Word(&'static str),
    Switch(bool),
    Count(u32),
    Number(f64),
    /// A finite number of hundredths.
    Percent(f64),
    Pair([f64; 2]),
    Hole(Hole),
    Name(Arc<str>),
    /// `none`: no limit, even if a lower layer sets one.
    None,
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Word(word) => f.write_str(word),
            Self::Switch(is_on) => is_on.fmt(f),
            Self::Count(count) => count.fmt(f),
            Self::Number(number) => number.fmt(f),
            Self::Percent(number) => write!(f, "{number}%"),
            Self::Pair([x, y]) => write!(f, "{x},{y}"),
            Self::Hole(hole) => hole.fmt(f),
            Self::Name(name) => f.write_str(name),
            Self::None => f.write_str("none"),
        }
    }
}

impl Syntax {
    pub fn takes_none(self) -> bool {
        !matches!(self, Self::Words(_) | Self::Switch | Self::Positive | Self::Finite)
    }

    pub fn parse(self, text: &str) -> Result<Value, String> {
        let value = match self {
            _ if self.takes_none() && text == "none" => Some(Value::None),
            Self::Words(words) => words.iter().find(|word| **word == text).map(|word| Value::Word(word)),
            Self::Switch => text.parse().ok().map(Value::Switch),
            Self::CountOrNone { min } => number(text, |&count| count >= min).map(Value::Count),
            Self::LengthOrNone if text.ends_with('%') => {
                let is_share = |&x: &f64| x / 100.0 > 0.0 && x <= 100.0;
                number(&text[..text.len() - 1], is_share).map(Value::Percent)
            }
            Self::LengthOrNone if text.ends_with("mm") => {
                number(text[..text.len() - 2].trim_end(), |&x: &f64| x / 1000.0 > 0.0 && x.is_finite())
                    .map(|millimetres| Value::Number(millimetres / 1000.0))
            }
            Self::Positive | Self::PositiveOrNone | Self::LengthOrNone => {
                number(text, |&x: &f64| x > 0.0 && x.is_finite()).map(Value::Number)
            }
            Self::Finite | Self::FiniteOrNone => number(text, |x: &f64| x.is_finite()).map(Value::Number),
            Self::PairOrNone => pair(text, |x| x.is_finite()),
            Self::SpacingOrNone => {
                let both = if text.contains(',') { text } else { &format!("{text},{text}") };
                pair(both, |x| *x > 0.0 && x.is_finite())
            }
            Self::HoleOrNone => text.parse().ok().map(Value::Hole),
            // The record may be hostile, so the name must not lead to another folder.
            Self::NameOrNone => {
                let is_plain = !text.is_empty() && !text.contains(['/', '\\', '\n', ',']) && text != "..";
                is_plain.then(|| Value::Name(text.into()))
            }
        };
        value.ok_or_else(|| format!("expected {}", self.accepted()))
    }

    fn accepted(self) -> String {
        match self {
            Self::Words(words) => format!("one of {}", words.join(", ")),
            Self::Switch => "true or false".to_owned(),
            Self::Positive => "a finite number above 0".to_owned(),
            Self::CountOrNone { min } => format!("a whole number of at least {min}, or none"),
            Self::PositiveOrNone => "a finite number above 0, or none".to_owned(),
            Self::LengthOrNone => "a finite number above 0, the same with mm or (up to 100) %, or none".to_owned(),
            Self::Finite => "a finite number".to_owned(),
            Self::FiniteOrNone | Self::HoleOrNone => "a finite number, or none".to_owned(),
            Self::PairOrNone => "two numbers, such as 100,250, or none".to_owned(),
            Self::SpacingOrNone => "one or two lengths above 0, or none".to_owned(),
            Self::NameOrNone => "the name of a file beside the source, without a folder or comma, or none".to_owned(),
        }
    }
}

/// The number in `text`, if it is accepted. `is_accepted` must reject NaN.
fn number<T: FromStr>(text: &str, is_accepted: impl Fn(&T) -> bool) -> Option<T> {
    text.parse().ok().filter(is_accepted)
}

fn pair(text: &str, is_accepted: impl Fn(&f64) -> bool) -> Option<Value> {
    let (x, y) = text.split_once(',')?;
    Some(Value::Pair([number(x.trim(), &is_accepted)?, number(y.trim(), &is_accepted)?]))
}
