//! Where a number of the archive stands in the file, so that one number at a time can be changed on purpose.

use hullmap::{InvalidPack, Pack};
use hullmap_format::archive::ArchivedPack;
use rkyv::util::AlignedVec;

use super::HEADER_LEN;
use crate::packs::reseal;

/// What follows the header, aligned as the archive needs it.
pub fn payload(file: &[u8]) -> AlignedVec<HEADER_LEN> {
    let mut payload = AlignedVec::new();
    payload.extend_from_slice(&file[HEADER_LEN..]);
    payload
}

/// The archive in a payload.
///
/// # Panics
/// If it is none.
pub fn archive(payload: &[u8]) -> &ArchivedPack {
    rkyv::access::<ArchivedPack, rkyv::rancor::Error>(payload).expect("the payload is an archive")
}

/// Place in the file of the number that `number` finds.
pub fn place<T>(file: &[u8], number: impl Fn(&ArchivedPack) -> &T) -> usize {
    let payload = payload(file);
    HEADER_LEN + std::ptr::from_ref(number(archive(&payload))).addr() - payload.as_ptr().addr()
}

/// The file with other bytes at the number that `number` finds, and a right checksum.
pub fn changed<T>(file: &[u8], number: impl Fn(&ArchivedPack) -> &T, bytes: &[u8]) -> Vec<u8> {
    let at = place(file, number);
    let mut changed = file.to_vec();
    changed[at..at + bytes.len()].copy_from_slice(bytes);
    reseal(&mut changed);
    changed
}

/// Opens [`changed`].
///
/// # Errors
/// As [`Pack::from_bytes`].
pub fn open_with<T>(file: &[u8], number: impl Fn(&ArchivedPack) -> &T, bytes: &[u8]) -> Result<Pack, InvalidPack> {
    Pack::from_bytes(&changed(file, number, bytes))
}
