//! PLY: the body behind the header, read number by number.
//!
//! In text, each instance is a line, and values after the declared ones are ignored, as by other
//! readers. Files with other line breaks are read as a sequence of words, see [`Layout`].

use super::header::{Element, Encoding, Header, Scalar};
use crate::coordinate::parse_coordinate;
use crate::fault::{Fault, LineFault, counted, excerpt};
use crate::tokens::{Tokens, text};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Each instance starts and ends with its line. Surplus words are ignored.
    Lines,
    /// Line breaks are white space like any other.
    Words,
}

pub struct TextBody<'a> {
    tokens: Tokens<'a>,
    layout: Layout,
    surplus_count: usize,
    surplus_line: Option<usize>,
    has_short_line: bool,
}

impl<'a> TextBody<'a> {
    fn word(&mut self) -> Option<&'a [u8]> {
        let word = match self.layout {
            Layout::Lines => self.tokens.next_in_line(),
            Layout::Words => self.tokens.next(),
        };
        self.has_short_line |= word.is_none() && !self.tokens.rest().trim_ascii_start().is_empty();
        word
    }
}

pub enum Body<'a> {
    Text(TextBody<'a>),
    Binary { rest: &'a [u8], is_big: bool },
}

impl<'a> Body<'a> {
    /// The body behind a header. `layout` has no effect on binary ones.
    #[expect(clippy::indexing_slicing, reason = "the header was read from these bytes, and ends within them")]
    pub fn new(header: &Header, bytes: &'a [u8], layout: Layout) -> Self {
        let rest = &bytes[header.body..];
        match header.encoding {
            Encoding::Text => Self::Text(TextBody {
                tokens: Tokens::new(rest, header.line),
                layout,
                surplus_count: 0,
                surplus_line: None,
                has_short_line: false,
            }),
            Encoding::Little => Self::Binary { rest, is_big: false },
            Encoding::Big => Self::Binary { rest, is_big: true },
        }
    }

    /// Whether an instance has more numbers than its line, with [`Layout::Lines`].
    pub fn has_short_line(&self) -> bool {
        matches!(self, Self::Text(TextBody { has_short_line: true, .. }))
    }

    /// Whether a line has more words than its instance, with [`Layout::Lines`].
    pub fn has_surplus(&self) -> bool {
        matches!(self, Self::Text(TextBody { surplus_count: 1.., .. }))
    }

    pub fn note(&self) -> Option<String> {
        let Self::Text(TextBody { surplus_count, surplus_line: Some(line), .. }) = self else {
            return None;
        };
        let lines = counted(surplus_count, "line has", "lines have");
        Some(format!("line {line}: {lines} more values than the header declares, which are ignored"))
    }

    pub fn begin_instance(&mut self) {
        if let Self::Text(TextBody { tokens, layout: Layout::Lines, .. }) = self {
            tokens.skip_blank();
        }
    }

    pub fn end_instance(&mut self) {
        if let Self::Text(TextBody { tokens, layout: Layout::Lines, surplus_count, surplus_line, .. }) = self
            && !tokens.rest_of_line().is_empty()
        {
            *surplus_count += 1;
            surplus_line.get_or_insert(tokens.line());
        }
    }

    pub fn fault(&self, message: String) -> LineFault {
        match self {
            Self::Text(text) => Fault::format(message).at_line(text.tokens.line()),
            Self::Binary { .. } => LineFault::of_file(message),
        }
    }

    /// Checks that the rest of the body is long enough for the elements that the header claims.
    /// Callers do this before they allocate memory for them. Fails if the body is too short.
    pub fn check_room(&self, element: &Element) -> Result<(), LineFault> {
        let (have, encoding) = match self {
            // The last number needs no separator.
            Self::Text(text) => (text.tokens.rest().len() as u64 + 1, Encoding::Text),
            Self::Binary { rest, .. } => (rest.len() as u64, Encoding::Little),
        };
        let minimum = element.minimum_size(encoding);
        if element.count.checked_mul(minimum).is_some_and(|need| need <= have) {
            return Ok(());
        }
        Err(LineFault::of_file(format!(
            "the header claims {} `{}` of at least {}, but {} left: the file was cut off; export it again",
            counted(element.count, "element", "elements"),
            element.name,
            counted(minimum, "byte", "bytes each"),
            counted(have, "byte is", "bytes are")
        )))
    }

    pub fn skip(&mut self, element: &Element) -> Result<(), LineFault> {
        if let (Self::Binary { rest, .. }, Some(size)) = (&mut *self, element.fixed_size()) {
            // `check_room` has checked that the bytes exist.
            *rest = rest.get((element.count as usize).saturating_mul(size)..).unwrap_or_default();
            return Ok(());
        }
        if element.properties.is_empty() {
            return Ok(());
        }
        for index in 0..element.count {
            self.begin_instance();
            for property in &element.properties {
                match property.length {
                    Some(length) => self.skip_list(length, property.scalar, element, index)?,
                    None => self.skip_number(property.scalar, element, index)?,
                }
            }
            self.end_instance();
        }
        Ok(())
    }

    pub fn skip_list(
        &mut self,
        length: Scalar,
        scalar: Scalar,
        element: &Element,
        index: u64,
    ) -> Result<(), LineFault> {
        let count = self.length(length, scalar, element, index)?;
        match self {
            // `length` has checked that the bytes exist.
            Self::Binary { rest, .. } => *rest = rest.get(count as usize * scalar.size()..).unwrap_or_default(),
            Self::Text(_) => {
                for _ in 0..count {
                    self.skip_number(scalar, element, index)?;
                }
            }
        }
        Ok(())
    }

    pub fn skip_number(&mut self, scalar: Scalar, element: &Element, index: u64) -> Result<(), LineFault> {
        match self {
            Self::Text(_) => self.word(element, index).map(drop),
            Self::Binary { .. } => self.bytes(scalar.size(), element, index).map(drop),
        }
    }

    /// Fails if the length is negative, or more than the rest of the file can hold.
    pub fn length(&mut self, length: Scalar, scalar: Scalar, element: &Element, index: u64) -> Result<u64, LineFault> {
        let number_count = self.integer(length, element, index)?;
        let have = match self {
            Self::Text(text) => text.tokens.rest().len() as u64,
            Self::Binary { rest, .. } => (rest.len() / scalar.size()) as u64,
        };
        u64::try_from(number_count).ok().filter(|&count| count <= have).ok_or_else(|| {
            self.fault(format!(
                "{} {index} claims a list of {}, more than the file holds: it was cut off or is damaged; export it again",
                element.name,
                counted(number_count, "number", "numbers")
            ))
        })
    }

    pub fn integer(&mut self, scalar: Scalar, element: &Element, index: u64) -> Result<i64, LineFault> {
        if let Self::Text(_) = self {
            let word = text(self.word(element, index)?);
            return word.parse().map_err(|_| {
                self.fault(format!(
                    "`{}` in {} {index} is not an integer: correct the line",
                    excerpt(&word),
                    element.name
                ))
            });
        }
        // f64 holds 32-bit integers exactly.
        Ok(self.number(scalar, true, element, index)? as i64)
    }

    /// A number. A number in text is rounded to `f32`, or to `f64` if `is_double`. Fails if the
    /// word is not a finite number, or the file ends first. Binary numbers may be NaN or infinite.
    #[expect(clippy::indexing_slicing, reason = "a number has at most 8 bytes")]
    pub fn number(&mut self, scalar: Scalar, is_double: bool, element: &Element, index: u64) -> Result<f64, LineFault> {
        if let Self::Text(_) = self {
            let word = text(self.word(element, index)?);
            let value =
                if is_double { parse_coordinate::<f64>(&word) } else { parse_coordinate::<f32>(&word).map(f64::from) };
            let Self::Text(text) = self else { unreachable!("the variant does not change") };
            return value.map_err(|fault| fault.at_line(text.tokens.line()));
        }
        let is_big = matches!(self, Self::Binary { is_big: true, .. });
        let bytes = self.bytes(scalar.size(), element, index)?;
        let mut low_first = [0; 8];
        low_first[..bytes.len()].copy_from_slice(bytes);
        if is_big {
            low_first[..bytes.len()].reverse();
        }
        let [a, b, c, d, ..] = low_first;
        Ok(match scalar {
            Scalar::I8 => f64::from(a as i8),
            Scalar::U8 => f64::from(a),
            Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
            Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
            Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Scalar::F64 => f64::from_le_bytes(low_first),
        })
    }

    fn word(&mut self, element: &Element, index: u64) -> Result<&'a [u8], LineFault> {
        let word = match self {
            Self::Text(text) => text.word(),
            Self::Binary { .. } => None,
        };
        word.ok_or_else(|| self.ends_within(element, index))
    }

    fn bytes(&mut self, count: usize, element: &Element, index: u64) -> Result<&'a [u8], LineFault> {
        if let Self::Binary { rest, .. } = self
            && let Some((bytes, tail)) = rest.split_at_checked(count)
        {
            *rest = tail;
            return Ok(bytes);
        }
        Err(self.ends_within(element, index))
    }

    fn ends_within(&self, element: &Element, index: u64) -> LineFault {
        self.fault(format!(
            "the file ends within {} {index} of the {} that its header claims: it was cut off; export it again",
            element.name, element.count
        ))
    }
}
