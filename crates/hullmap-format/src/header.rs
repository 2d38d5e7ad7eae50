//! Header of a file: the fixed 64 bytes in front of the archive, and their checks.
//!
//! | offset | bytes | field |
//! |---|---|---|
//! | 0 | 8 | magic: `hullmap\n` of a pack, `hullmsh\n` of a triangle mesh, `hullfld\n` of a height field |
//! | 8 | 4 | format version |
//! | 12 | 4 | header length, 64 |
//! | 16 | 8 | payload length: the file is exactly 64 bytes longer |
//! | 24 | 16 | XXH3-128 of the source file's bytes, its low 64 bits first |
//! | 40 | 8 | XXH3-64 of the archive's section `options` |
//! | 48 | 8 | reserved, zero |
//! | 56 | 8 | XXH3-64 of the whole file except these 8 bytes |
//!
//! All numbers are little-endian. All hashes use seed 0. The newline in the magic reveals a
//! transfer that rewrote line ends.

use std::{fmt, hash::Hasher};

use twox_hash::{XxHash3_64, XxHash3_128};

use crate::{
    height_field, triangle_mesh,
    version::{self, Layout},
};

/// Kinds of file that start with this header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A pack of convex hulls.
    Pack,
    /// A static mesh that keeps its triangles.
    TriangleMesh,
    /// A static ground whose heights are on a grid.
    HeightField,
}

impl FileKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Pack, Self::TriangleMesh, Self::HeightField];

    /// The kind of a file that starts with these bytes; `None` if it is of no kind.
    pub fn from_start(start: &[u8]) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| start.starts_with(&kind.magic()))
    }

    /// File name extension, without the dot.
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Pack => "hullmap",
            Self::TriangleMesh => triangle_mesh::EXTENSION,
            Self::HeightField => height_field::EXTENSION,
        }
    }

    /// First bytes of every file of this kind.
    pub const fn magic(self) -> [u8; 8] {
        match self {
            Self::Pack => *b"hullmap\n",
            Self::TriangleMesh => *b"hullmsh\n",
            Self::HeightField => *b"hullfld\n",
        }
    }

    const fn writer(self) -> &'static str {
        match self {
            Self::Pack => "`bake build`",
            Self::HeightField => "`bake build --terrain`",
            Self::TriangleMesh => "`bake build --keep-triangles`",
        }
    }

    /// Format versions that this build reads.
    pub const fn versions(self) -> &'static [u32] {
        match self {
            Self::Pack => &version::ALL,
            Self::TriangleMesh => &[triangle_mesh::FORMAT_VERSION],
            Self::HeightField => &[height_field::FORMAT_VERSION],
        }
    }
}

impl fmt::Display for FileKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Pack => "hullmap pack",
            Self::TriangleMesh => "hullmap triangle mesh",
            Self::HeightField => "hullmap height field",
        })
    }
}

/// Length of the header, in bytes: a whole cache line, so that the archive starts on the next one.
pub const HEADER_LEN: usize = 64;

/// Maximum length of a pack in bytes: its 32-bit offsets reach 2 GiB.
pub const MAX_PACK_LEN: usize = HEADER_LEN + i32::MAX as usize;

const CHECKSUM_AT: usize = 56;

/// The header, decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Kind of the file.
    pub kind: FileKind,
    /// Format version the file was written in.
    pub format_version: u32,
    /// Length of the archive after the header, in bytes.
    pub payload_len: u64,
    /// XXH3-128 of the source file's bytes.
    pub source_hash: u128,
    /// XXH3-64 of the section `options`: the options that shaped the bake, and warnings.
    pub options_hash: u64,
    /// XXH3-64 of every byte of the file except the eight of this field.
    pub checksum: u64,
}

/// Another kind of file, or its first bytes, and the remedy.
fn otherwise(found: [u8; 8], expected: FileKind) -> String {
    match FileKind::from_start(&found) {
        Some(kind) => format!("it is a {kind}; open it as one, or any kind with `Asset::open`"),
        None => {
            let [start, expected_start] = [found, expected.magic()].map(|bytes| bytes.escape_ascii().to_string());
            format!(
                "it starts with \"{start}\" instead of \"{expected_start}\"; pass a file that {} wrote",
                expected.writer()
            )
        }
    }
}

/// Why a header is rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum HeaderError {
    /// The file is shorter than a header.
    #[error("the file is {found} bytes long, but the header of a pack takes {HEADER_LEN}; bake the source again")]
    TooShort { found: usize },
    /// The file is longer than the longest pack.
    #[error("the file is {found} bytes long, but a pack takes at most {expected}; pass a file that `bake build` wrote")]
    TooLong { found: u64, expected: u64 },
    /// The first eight bytes are not the magic of the expected kind of file.
    #[error(
        "not a {expected}: {}",
        otherwise(*found, *expected)
    )]
    Magic { found: [u8; 8], expected: FileKind },
    /// The file has another format version.
    #[error(
        "the file has format version {found}, but this build reads {}; {}",
        version_list(kind.versions()),
        version_remedy(*found, kind.versions())
    )]
    Version { found: u32, kind: FileKind },
    /// The stated length of the header is not [`HEADER_LEN`].
    #[error("damaged header: it states a length of {found} bytes instead of {HEADER_LEN}; bake the source again")]
    HeaderLength { found: u32 },
    /// The reserved bytes are not zero.
    #[error("damaged header: its reserved bytes are {found:?} instead of zeros; bake the source again")]
    Reserved { found: [u8; 8] },
    /// The length of the file differs from the stated length.
    #[error(
        "{found} bytes follow the header, but it states {expected}: the file was truncated or extended; bake the source \
         again"
    )]
    Length { expected: u64, found: u64 },
}

fn version_list(versions: &[u32]) -> String {
    match versions {
        [first, .., last] => format!("versions {first} to {last}"),
        _ => format!("version {}", versions.first().copied().unwrap_or_default()),
    }
}

fn version_remedy(found: u32, versions: &[u32]) -> &'static str {
    if versions.iter().all(|version| found > *version) { "update hullmap" } else { "bake the source again" }
}

impl Header {
    /// A header for the `payload` of a pack of the usual layout, with its checksum.
    pub fn for_payload(source_hash: u128, options_hash: u64, payload: &[u8]) -> Self {
        Self::for_layout(Layout::default(), source_hash, options_hash, payload)
    }

    /// A header for the `payload` of a pack of any layout, with its checksum.
    pub fn for_layout(layout: Layout, source_hash: u128, options_hash: u64, payload: &[u8]) -> Self {
        Self::with_checksum(FileKind::Pack, layout.version(), source_hash, options_hash, payload)
    }

    /// A header for the `payload` of a triangle mesh, with its checksum.
    pub fn for_triangle_mesh(source_hash: u128, options_hash: u64, payload: &[u8]) -> Self {
        Self::with_checksum(FileKind::TriangleMesh, triangle_mesh::FORMAT_VERSION, source_hash, options_hash, payload)
    }

    /// A header for the `payload` of a height field, with its checksum.
    pub fn for_height_field(source_hash: u128, options_hash: u64, payload: &[u8]) -> Self {
        Self::with_checksum(FileKind::HeightField, height_field::FORMAT_VERSION, source_hash, options_hash, payload)
    }

    fn with_checksum(
        kind: FileKind,
        format_version: u32,
        source_hash: u128,
        options_hash: u64,
        payload: &[u8],
    ) -> Self {
        let payload_len = payload.len() as u64;
        let mut header = Self { kind, format_version, payload_len, source_hash, options_hash, checksum: 0 };
        header.checksum = checksum(&header.to_bytes(), payload);
        header
    }

    /// The 64 bytes of the header in the file.
    #[expect(clippy::indexing_slicing, reason = "the lengths of the fields, which are constants, come to 64")]
    pub fn to_bytes(&self) -> [u8; HEADER_LEN] {
        let mut bytes = [0; HEADER_LEN];
        let mut at = 0;
        let mut put = |field: &[u8]| {
            bytes[at..at + field.len()].copy_from_slice(field);
            at += field.len();
        };
        put(&self.kind.magic());
        put(&self.format_version.to_le_bytes());
        put(&(HEADER_LEN as u32).to_le_bytes());
        put(&self.payload_len.to_le_bytes());
        put(&self.source_hash.to_le_bytes());
        put(&self.options_hash.to_le_bytes());
        put(&[0; 8]);
        put(&self.checksum.to_le_bytes());
        bytes
    }

    /// The layout that the format version states.
    pub fn layout(&self) -> Layout {
        // A header that was read has a version that this crate reads.
        Layout::of_version(self.format_version).unwrap_or_default()
    }

    /// Reads the header at the start of a pack.
    ///
    /// Only the header itself is checked. [`check_length`](Self::check_length) and
    /// [`matches_checksum`](Self::matches_checksum) check the payload after it.
    ///
    /// # Errors
    /// The file is too short, has another magic or another version, or a field has a value that
    /// this version never writes.
    pub fn read(file: &[u8]) -> Result<Self, HeaderError> {
        Self::read_kind(file, FileKind::Pack)
    }

    /// Reads the header at the start of a file of this kind, as [`read`](Self::read) does.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn read_kind(file: &[u8], kind: FileKind) -> Result<Self, HeaderError> {
        let bytes: &[u8; HEADER_LEN] = file.first_chunk().ok_or(HeaderError::TooShort { found: file.len() })?;
        let magic: [u8; 8] = field(bytes, 0);
        if magic != kind.magic() {
            return Err(HeaderError::Magic { found: magic, expected: kind });
        }
        let format_version = u32::from_le_bytes(field(bytes, 8));
        if !kind.versions().contains(&format_version) {
            return Err(HeaderError::Version { found: format_version, kind });
        }
        let header_len = u32::from_le_bytes(field(bytes, 12));
        if header_len != HEADER_LEN as u32 {
            return Err(HeaderError::HeaderLength { found: header_len });
        }
        let reserved = field(bytes, 48);
        if reserved != [0; 8] {
            return Err(HeaderError::Reserved { found: reserved });
        }
        Ok(Self {
            kind,
            format_version,
            payload_len: u64::from_le_bytes(field(bytes, 16)),
            source_hash: u128::from_le_bytes(field(bytes, 24)),
            options_hash: u64::from_le_bytes(field(bytes, 40)),
            checksum: u64::from_le_bytes(field(bytes, CHECKSUM_AT)),
        })
    }

    /// Checks that exactly the stated payload follows the header in a file of `file_len` bytes.
    ///
    /// # Errors
    /// [`HeaderError::Length`] or [`HeaderError::TooLong`].
    pub fn check_length(&self, file_len: u64) -> Result<(), HeaderError> {
        let found = file_len.saturating_sub(HEADER_LEN as u64);
        if found != self.payload_len {
            return Err(HeaderError::Length { expected: self.payload_len, found });
        }
        let expected = MAX_PACK_LEN as u64;
        if file_len <= expected { Ok(()) } else { Err(HeaderError::TooLong { found: file_len, expected }) }
    }

    /// Whether the checksum matches this header and `payload`, in one pass.
    pub fn matches_checksum(&self, payload: &[u8]) -> bool {
        self.checksum == self.checksum_of(payload)
    }

    /// Checksum of a file of this header and `payload`, whatever its field
    /// [`checksum`](Self::checksum), in one pass.
    pub fn checksum_of(&self, payload: &[u8]) -> u64 {
        checksum(&self.to_bytes(), payload)
    }
}

#[expect(
    clippy::indexing_slicing,
    reason = "offsets and lengths are constants of `read`, and every field ends within the header"
)]
fn field<const N: usize>(bytes: &[u8; HEADER_LEN], at: usize) -> [u8; N] {
    let mut out = [0; N];
    out.copy_from_slice(&bytes[at..at + N]);
    out
}

/// Checksum of a file: XXH3-64 over the header up to the checksum field, then the payload.
fn checksum(header: &[u8; HEADER_LEN], payload: &[u8]) -> u64 {
    let mut hasher = XxHash3_64::with_seed(0);
    hasher.write(&header[..CHECKSUM_AT]);
    hasher.write(payload);
    hasher.finish()
}

/// XXH3-128 of a source file's bytes, as [`Header::source_hash`] records it.
pub fn source_hash(source: &[u8]) -> u128 {
    XxHash3_128::oneshot(source)
}

/// XXH3-64 of the section `options`, as [`Header::options_hash`] records it.
pub fn options_hash(options: &str) -> u64 {
    XxHash3_64::oneshot(options.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_trip() {
        let header = Header::for_payload(7 << 100, 42, b"payload");
        let bytes = header.to_bytes();
        assert_eq!(Header::read(&bytes), Ok(header));
        assert!(header.matches_checksum(b"payload"));
        assert!(!header.matches_checksum(b"Payload"));
        assert!(header.check_length(HEADER_LEN as u64 + 7).is_ok());
        assert!(header.check_length(HEADER_LEN as u64 + 8).is_err());
        assert!(header.check_length(3).is_err());
        let longest = MAX_PACK_LEN as u64;
        let of = |file_len: u64| Header { payload_len: file_len - HEADER_LEN as u64, ..header };
        assert_eq!(of(longest).check_length(longest), Ok(()));
        let too_long = HeaderError::TooLong { found: longest + 1, expected: longest };
        assert_eq!(of(longest + 1).check_length(longest + 1), Err(too_long));
    }

    #[test]
    fn each_kind_of_file_is_told_from_the_other() {
        let mesh = Header::for_triangle_mesh(7, 42, b"payload");
        assert_eq!(Header::read_kind(&mesh.to_bytes(), FileKind::TriangleMesh), Ok(mesh));
        let error = Header::read(&mesh.to_bytes()).unwrap_err().to_string();
        assert!(error.starts_with("not a hullmap pack: it is a "), "{error}");
        let pack = Header::for_payload(7, 42, b"payload");
        assert!(Header::read_kind(&pack.to_bytes(), FileKind::TriangleMesh).is_err());
        let later = Header { format_version: 2, ..mesh };
        let error = Header::read_kind(&later.to_bytes(), FileKind::TriangleMesh).unwrap_err().to_string();
        assert_eq!(error, "the file has format version 2, but this build reads version 1; update hullmap");
    }

    #[test]
    fn every_flipped_header_bit_is_detected() {
        let payload = b"some payload";
        let header = Header::for_payload(1, 2, payload);
        for bit in 0..HEADER_LEN * 8 {
            let mut bytes = header.to_bytes();
            bytes[bit / 8] ^= 1 << (bit % 8);
            let noticed = match Header::read(&bytes) {
                Err(_) => true,
                Ok(h) => h.check_length((HEADER_LEN + payload.len()) as u64).is_err() || !h.matches_checksum(payload),
            };
            assert!(noticed, "bit {bit}");
        }
    }
}
