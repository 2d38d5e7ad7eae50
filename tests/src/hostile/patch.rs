//! Changes a single value of the archive in a file.

use hullmap::{InvalidPack, Pack};
use hullmap_format::archive::ArchivedPack;
use hullmap_testkit::packs::reseal;
use rkyv::util::AlignedVec;

use super::HEADER_LEN;

/// The payload after the header, aligned as the archive requires.
pub fn payload(file: &[u8]) -> AlignedVec<HEADER_LEN> {
    let mut payload = AlignedVec::new();
    payload.extend_from_slice(&file[HEADER_LEN..]);
    payload
}

/// The archive in a payload. Panics if the payload is not an archive.
pub fn archive(payload: &[u8]) -> &ArchivedPack {
    rkyv::access::<ArchivedPack, rkyv::rancor::Error>(payload).expect("the payload is an archive")
}

/// Offset in the file of the value that `select` returns.
pub fn offset_of<T>(file: &[u8], select: impl Fn(&ArchivedPack) -> &T) -> usize {
    let payload = payload(file);
    HEADER_LEN + std::ptr::from_ref(select(archive(&payload))).addr() - payload.as_ptr().addr()
}

/// The file with `bytes` in place of the value that `select` returns, and a correct checksum.
pub fn changed<T>(file: &[u8], select: impl Fn(&ArchivedPack) -> &T, bytes: &[u8]) -> Vec<u8> {
    let offset = offset_of(file, select);
    let mut changed = file.to_vec();
    changed[offset..offset + bytes.len()].copy_from_slice(bytes);
    reseal(&mut changed);
    changed
}

/// Opens [`changed`]. Fails as [`Pack::from_bytes`] does.
pub fn open_with<T>(file: &[u8], select: impl Fn(&ArchivedPack) -> &T, bytes: &[u8]) -> Result<Pack, InvalidPack> {
    Pack::from_bytes(&changed(file, select, bytes))
}
