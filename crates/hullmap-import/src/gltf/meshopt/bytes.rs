//! Meshopt compression: a stream of bytes that are read in order.

pub type Damage = &'static str;

const CUT_OFF: Damage = "it ends too early";

pub struct Bytes<'a>(pub &'a [u8]);

impl<'a> Bytes<'a> {
    pub fn byte(&mut self) -> Result<u8, Damage> {
        let (&first, rest) = self.0.split_first().ok_or(CUT_OFF)?;
        self.0 = rest;
        Ok(first)
    }

    pub fn take(&mut self, count: usize) -> Result<&'a [u8], Damage> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(CUT_OFF)?;
        self.0 = rest;
        Ok(taken)
    }

    pub fn take_tail(&mut self, count: usize) -> Result<&'a [u8], Damage> {
        let at = self.0.len().checked_sub(count).ok_or(CUT_OFF)?;
        let (rest, tail) = self.0.split_at_checked(at).ok_or(CUT_OFF)?;
        self.0 = rest;
        Ok(tail)
    }

    /// A number in LEB128: seven bits a byte, the lowest first, in at most five bytes. Bits beyond
    /// the 32nd are dropped.
    pub fn varint(&mut self) -> Result<u32, Damage> {
        let mut number = 0;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.byte()?;
            number |= u32::from(byte & 0x7F) << shift;
            if byte & 0x80 == 0 {
                return Ok(number);
            }
        }
        Err("a number has more than five bytes")
    }

    pub fn finish(&self) -> Result<(), Damage> {
        if self.0.is_empty() { Ok(()) } else { Err("it has bytes beyond its last element") }
    }
}
