//! Positions of the archive's numbers in the file. They let a test change one number at a time.

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

/// The archive in a payload.
///
/// # Panics
/// If the payload is not an archive.
pub fn archive(payload: &[u8]) -> &ArchivedPack {
    rkyv::access::<ArchivedPack, rkyv::rancor::Error>(payload).expect("the payload is an archive")
}

/// Position in the file of the number that `number` selects.
pub fn place<T>(file: &[u8], number: impl Fn(&ArchivedPack) -> &T) -> usize {
    let payload = payload(file);
    HEADER_LEN + std::ptr::from_ref(number(archive(&payload))).addr() - payload.as_ptr().addr()
}

/// The file with other bytes at the number that `number` selects, and a correct checksum.
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
