//! The numbers behind the header of a PLY file.

use super::header::{Element, Encoding, Header, Scalar};
use crate::coordinate::parse_coordinate;
use crate::fault::{Fault, LineFault, excerpt};
use crate::tokens::{Tokens, text};

/// Reads one number after the other.
pub enum Body<'a> {
    /// Words.
    Text(Tokens<'a>),
    /// Bytes.
    Binary {
        /// What is not read yet.
        rest: &'a [u8],
        /// Whether the highest byte comes first.
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

    /// A fault where the body is read.
    pub fn fault(&self, message: String) -> LineFault {
        match self {
            Self::Text(tokens) => Fault::format(message).at(tokens.line()),
            Self::Binary { .. } => Fault::format(message).of_file(),
        }
    }

    /// Checks that as many elements as the header claims can be there at all, before memory is taken for them.
    ///
    /// # Errors
    /// They cannot.
    pub fn check_room(&self, element: &Element) -> Result<(), LineFault> {
        let (have, encoding) = match self {
            // The last number needs no blank behind it.
            Self::Text(tokens) => (tokens.rest().len() as u64 + 1, Encoding::Text),
            Self::Binary { rest, .. } => (rest.len() as u64, Encoding::Little),
        };
        let least = element.least_size(encoding);
        if element.count.checked_mul(least).is_some_and(|need| need <= have) {
            return Ok(());
        }
        Err(Fault::format(format!(
            "the header claims {} of `{}`, of at least {least} bytes each, but {have} bytes are left: the file was cut off; export it again",
            element.count, element.name
        ))
        .of_file())
    }

    /// Passes over all elements of a kind.
    ///
    /// # Errors
    /// The file ends before.
    pub fn skip(&mut self, element: &Element) -> Result<(), LineFault> {
        if let (Self::Binary { rest, .. }, Some(size)) = (&mut *self, element.fixed_size()) {
            // `check_room` has found that they are there.
            *rest = rest.get((element.count as usize).saturating_mul(size)..).unwrap_or_default();
            return Ok(());
        }
        if element.properties.is_empty() {
            return Ok(());
        }
        for number in 0..element.count {
            for property in &element.properties {
                match property.length {
                    Some(length) => self.skip_list(length, property.scalar, element, number)?,
                    None => self.skip_number(property.scalar, element, number)?,
                }
            }
        }
        Ok(())
    }

    /// Passes over a list.
    ///
    /// # Errors
    /// The file ends before.
    pub fn skip_list(
        &mut self,
        length: Scalar,
        scalar: Scalar,
        element: &Element,
        number: u64,
    ) -> Result<(), LineFault> {
        let count = self.length(length, scalar, element, number)?;
        match self {
            // `length` has found that they are there.
            Self::Binary { rest, .. } => *rest = rest.get(count as usize * scalar.size()..).unwrap_or_default(),
            Self::Text(_) => {
                for _ in 0..count {
                    self.skip_number(scalar, element, number)?;
                }
            }
        }
        Ok(())
    }

    /// Passes over a number.
    ///
    /// # Errors
    /// The file ends before.
    pub fn skip_number(&mut self, scalar: Scalar, element: &Element, number: u64) -> Result<(), LineFault> {
        match self {
            Self::Text(_) => self.word(element, number).map(drop),
            Self::Binary { .. } => self.bytes(scalar.size(), element, number).map(drop),
        }
    }

    /// A list's length, of which the numbers are there.
    ///
    /// # Errors
    /// It is negative, or more than the file has.
    pub fn length(&mut self, length: Scalar, scalar: Scalar, element: &Element, number: u64) -> Result<u64, LineFault> {
        let count = self.whole(length, element, number)?;
        let have = match self {
            Self::Text(tokens) => tokens.rest().len() as u64,
            Self::Binary { rest, .. } => (rest.len() / scalar.size()) as u64,
        };
        u64::try_from(count).ok().filter(|&count| count <= have).ok_or_else(|| {
            self.fault(format!(
                "{} {number} has a list of {count} numbers, which the file has not: it was cut off, or is damaged; export it again",
                element.name
            ))
        })
    }

    /// A whole number.
    ///
    /// # Errors
    /// It is none, or the file ends before.
    pub fn whole(&mut self, scalar: Scalar, element: &Element, number: u64) -> Result<i64, LineFault> {
        if let Self::Text(_) = self {
            let word = text(self.word(element, number)?);
            return word.parse().map_err(|_| {
                self.fault(format!(
                    "`{}` in {} {number} is no whole number: correct the line",
                    excerpt(&word),
                    element.name
                ))
            });
        }
        // Whole numbers of 32 bits are exact in f64.
        Ok(self.number(scalar, true, element, number)? as i64)
    }

    /// A number; one in a text is rounded to f32 unless it `is_double`.
    ///
    /// # Errors
    /// It is none, or the file ends before. In a text, also what is not finite.
    #[expect(clippy::indexing_slicing, reason = "a number has 8 bytes at most")]
    pub fn number(
        &mut self,
        scalar: Scalar,
        is_double: bool,
        element: &Element,
        number: u64,
    ) -> Result<f64, LineFault> {
        if let Self::Text(_) = self {
            let word = text(self.word(element, number)?);
            let value =
                if is_double { parse_coordinate::<f64>(&word) } else { parse_coordinate::<f32>(&word).map(f64::from) };
            let Self::Text(tokens) = self else { unreachable!("it has not changed") };
            return value.map_err(|fault| fault.at(tokens.line()));
        }
        let is_big = matches!(self, Self::Binary { is_big: true, .. });
        let bytes = self.bytes(scalar.size(), element, number)?;
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

    fn word(&mut self, element: &Element, number: u64) -> Result<&'a [u8], LineFault> {
        let word = match self {
            Self::Text(tokens) => tokens.next(),
            Self::Binary { .. } => None,
        };
        word.ok_or_else(|| self.ends_in(element, number))
    }

    fn bytes(&mut self, count: usize, element: &Element, number: u64) -> Result<&'a [u8], LineFault> {
        if let Self::Binary { rest, .. } = self
            && let Some((bytes, tail)) = rest.split_at_checked(count)
        {
            *rest = tail;
            return Ok(bytes);
        }
        Err(self.ends_in(element, number))
    }

    fn ends_in(&self, element: &Element, number: u64) -> LineFault {
        self.fault(format!(
            "the file ends in {} {number} of the {} that its header claims: it was cut off; export it again",
            element.name, element.count
        ))
    }
}
