//! Cuts the payload of a file into its sections, in their order.
//!
//! The root is the last structure of the payload: for each section an offset, relative to its own
//! position, and an element count. Given the counts, the order and alignment of sections fix every
//! offset: it must equal the only one that this version writes.

use bytemuck::Pod;

use crate::check_error::CheckError;

/// The first section starts on a multiple of this many bytes in memory: a cache line.
pub const PAYLOAD_ALIGNMENT: usize = 64;

/// The root starts on a multiple of this many bytes: the size of its numbers.
pub(crate) const ROOT_ALIGNMENT: usize = 4;

/// Cuts sections off the payload's front, one by one. The root has at most `ROOT_LEN` bytes.
pub(crate) struct Cutter<'a, const ROOT_LEN: usize> {
    payload: &'a [u8],
    /// The last bytes of the payload, after zeros if it is shorter.
    root: [u8; ROOT_LEN],
    root_at: usize,
    end: usize,
}

impl<'a, const ROOT_LEN: usize> Cutter<'a, ROOT_LEN> {
    pub(crate) fn new(payload: &'a [u8], least: usize) -> Result<Self, CheckError> {
        if !payload.as_ptr().addr().is_multiple_of(PAYLOAD_ALIGNMENT) {
            return Err(CheckError::Misaligned);
        }
        let Some(root_at) = payload.len().checked_sub(least) else {
            return Err(CheckError::TooShort { found: payload.len(), expected: least });
        };
        let mut root = [0; ROOT_LEN];
        root.iter_mut().rev().zip(payload.iter().rev()).for_each(|(to, from)| *to = *from);
        // The copy is opaque to the compiler, so that the checked bytes are the ones used, even if
        // another process writes to the file in between.
        let root = std::hint::black_box(root);
        Ok(Self { payload, root, root_at, end: 0 })
    }

    pub(crate) fn has_more(&self) -> bool {
        self.end.next_multiple_of(ROOT_ALIGNMENT) != self.root_at
    }

    pub(crate) fn extend_root(&mut self, len: usize) {
        self.root_at = self.root_at.saturating_sub(len);
    }

    fn word(&self, at: usize) -> [u8; 4] {
        self.root.get(at..).and_then(<[u8]>::first_chunk).copied().unwrap_or_default()
    }

    /// The section whose offset and count are at `field` in a root of `ROOT_LEN` bytes.
    pub(crate) fn cut<T: Pod>(&mut self, section: &'static str, field: usize) -> Result<&'a [T], CheckError> {
        let offset = i32::from_le_bytes(self.word(field));
        let count = u32::from_le_bytes(self.word(field + 4)) as usize;
        let expected = self.end.next_multiple_of(align_of::<T>());
        let found = (self.payload.len() + field) as i64 - ROOT_LEN as i64 + i64::from(offset);
        if found != expected as i64 {
            return Err(CheckError::Section { section, found, expected });
        }
        let bytes = count
            .checked_mul(size_of::<T>())
            .and_then(|len| expected.checked_add(len))
            .filter(|end| *end <= self.root_at)
            .and_then(|end| Some((end, self.payload.get(expected..end)?)));
        // Never misaligned: `expected` is a multiple of the alignment, as the payload's start is.
        let slice = bytes.and_then(|(end, bytes)| Some((end, bytemuck::try_cast_slice(bytes).ok()?)));
        let Some((end, slice)) = slice else {
            return Err(CheckError::SectionLength { section, count, available: self.root_at.saturating_sub(expected) });
        };
        self.end = end;
        Ok(slice)
    }

    pub(crate) fn finish(&self) -> Result<(), CheckError> {
        let expected = self.end.next_multiple_of(ROOT_ALIGNMENT);
        let found = self.root_at as i64;
        if found == expected as i64 { Ok(()) } else { Err(CheckError::Section { section: "root", found, expected }) }
    }
}
