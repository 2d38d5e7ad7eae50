//! The bytes of a file: a header, then the archive.

use hullmap_format::{
    check::MAX_PACK_LEN,
    header::{HEADER_LEN, Header},
};
use rkyv::{Serialize, api::high::HighSerializer, rancor, ser::allocator::ArenaHandle};

use crate::error::BakeError;

/// The bytes of a file with this archive, whose `header` is a function of the payload.
pub(crate) fn bytes<T>(archive: &T, header: impl FnOnce(&[u8]) -> Header) -> Result<Vec<u8>, BakeError>
where
    T: for<'a> Serialize<HighSerializer<Vec<u8>, ArenaHandle<'a>, rancor::Error>>,
{
    // The header is written last, in front of the payload. Offsets in the payload are relative, and
    // the header's length is a multiple of every alignment.
    let bytes = rkyv::api::high::to_bytes_in::<_, rancor::Error>(archive, vec![0; HEADER_LEN]);
    let mut bytes = bytes.map_err(|_| BakeError::PackTooLarge)?;
    if bytes.len() > MAX_PACK_LEN {
        return Err(BakeError::PackTooLarge);
    }
    let header = header(&bytes[HEADER_LEN..]);
    bytes[..HEADER_LEN].copy_from_slice(&header.to_bytes());
    Ok(bytes)
}
