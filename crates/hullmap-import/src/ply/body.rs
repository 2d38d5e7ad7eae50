//! PLY: the body behind the header, read number by number.

use super::header::{Element, Encoding, Header, Scalar};
use crate::coordinate::parse_coordinate;
use crate::fault::{Fault, LineFault, excerpt};
use crate::tokens::{Tokens, text};

/// Reader of a body.
pub enum Body<'a> {
    /// ASCII words.
    Text(Tokens<'a>),
    /// Binary numbers.
    Binary {
        /// Bytes not read yet.
        rest: &'a [u8],
        /// Whether numbers are big-endian.
        is_big: bool,
    },
}

impl<'a> Body<'a> {
    /// The body behind a header.
    #[expect(clippy::indexing_slicing, reason = "the header was read from these bytes, and ends within them")]
    pub fn new(header: &Header, bytes: &'a [u8]) -> Self {
        let rest = &bytes[header.body..];
        match header.encoding {
            Encoding::Text => Self::Text(Tokens::new(rest, header.line)),
            Encoding::Little => Self::Binary { rest, is_big: false },
            Encoding::Big => Self::Binary { rest, is_big: true },
        }
    }

    /// A fault at the current position.
    pub fn fault(&self, message: String) -> LineFault {
        match self {
            Self::Text(tokens) => Fault::format(message).at(tokens.line()),
            Self::Binary { .. } => Fault::format(message).of_file(),
        }
    }

    /// Checks that the rest of the body is long enough for the elements that the header claims.
    /// Callers do this before they allocate memory for them.
    ///
    /// # Errors
    /// The body is too short.
    pub fn check_room(&self, element: &Element) -> Result<(), LineFault> {
        let (have, encoding) = match self {
            // The last number needs no separator.
            Self::Text(tokens) => (tokens.rest().len() as u64 + 1, Encoding::Text),
            Self::Binary { rest, .. } => (rest.len() as u64, Encoding::Little),
        };
        let minimum = element.minimum_size(encoding);
        if element.count.checked_mul(minimum).is_some_and(|need| need <= have) {
            return Ok(());
        }
        Err(Fault::format(format!(
            "the header claims {} elements `{}` of at least {minimum} bytes each, but {have} bytes are left: the file was cut off; export it again",
            element.count, element.name
        ))
        .of_file())
    }

    /// Skips all instances of an element.
    ///
    /// # Errors
    /// The file ends first.
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
            for property in &element.properties {
                match property.length {
                    Some(length) => self.skip_list(length, property.scalar, element, index)?,
                    None => self.skip_number(property.scalar, element, index)?,
                }
            }
        }
        Ok(())
    }

    /// Skips a list.
    ///
    /// # Errors
    /// The file ends first.
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

    /// Skips a number.
    ///
    /// # Errors
    /// The file ends first.
    pub fn skip_number(&mut self, scalar: Scalar, element: &Element, index: u64) -> Result<(), LineFault> {
        match self {
            Self::Text(_) => self.word(element, index).map(drop),
            Self::Binary { .. } => self.bytes(scalar.size(), element, index).map(drop),
        }
    }

    /// Length of a list whose numbers fit in the rest of the file.
    ///
    /// # Errors
    /// The length is negative, or more than the rest of the file can hold.
    pub fn length(&mut self, length: Scalar, scalar: Scalar, element: &Element, index: u64) -> Result<u64, LineFault> {
        let count = self.integer(length, element, index)?;
        let have = match self {
            Self::Text(tokens) => tokens.rest().len() as u64,
            Self::Binary { rest, .. } => (rest.len() / scalar.size()) as u64,
        };
        u64::try_from(count).ok().filter(|&count| count <= have).ok_or_else(|| {
            self.fault(format!(
                "{} {index} claims a list of {count} numbers, more than the file holds: it was cut off or is damaged; export it again",
                element.name
            ))
        })
    }

    /// An integer.
    ///
    /// # Errors
    /// The word is not an integer, or the file ends first.
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

    /// A number. A number in text is rounded to `f32`, or to `f64` if `is_double`.
    ///
    /// # Errors
    /// The word is not a finite number, or the file ends first. Binary numbers may be NaN or
    /// infinite.
    #[expect(clippy::indexing_slicing, reason = "a number has at most 8 bytes")]
    pub fn number(&mut self, scalar: Scalar, is_double: bool, element: &Element, index: u64) -> Result<f64, LineFault> {
        if let Self::Text(_) = self {
            let word = text(self.word(element, index)?);
            let value =
                if is_double { parse_coordinate::<f64>(&word) } else { parse_coordinate::<f32>(&word).map(f64::from) };
            let Self::Text(tokens) = self else { unreachable!("the variant does not change") };
            return value.map_err(|fault| fault.at(tokens.line()));
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
            Self::Text(tokens) => tokens.next(),
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
