//! Results of functions, flags of opening, and the number of the binary interface.

/// Number of the binary interface. A program compares it with hullmap_abi_version() if it loads the
/// library at run time.
pub const ABI_VERSION: u32 = 1;

/// Open a file by mapping it instead of copying it. No process may write to the file or truncate it
/// while the pack or a shape made from it exists; replacing it by renaming is allowed. If this rule
/// is broken, answers are wrong, or the process is ended by SIGBUS.
pub const OPEN_MAP: u32 = 1;

/// Use the caller's memory in place instead of copying it.
pub const OPEN_BORROW: u32 = 2;

/// Check the header, the length and the structure, but not the checksum and the contents. For files
/// that have passed the full check before. If the file is damaged, answers may be wrong, and
/// queries may return HULLMAP_RESULT_PANIC; they never read out of bounds.
pub const OPEN_SKIP_CONTENTS: u32 = 4;

/// Result of a function. Every value except HULLMAP_RESULT_OK is a failure, for which
/// hullmap_last_error() has a message.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Result {
    /// Success.
    Ok = 0,
    /// A pointer is NULL but must not be.
    Null = 1,
    /// An argument is out of range, not a finite number, misaligned or of an unknown version.
    InvalidArgument = 2,
    /// The pack has no hull of this index or name.
    NotFound = 3,
    /// The file cannot be read.
    Io = 4,
    /// The file or the memory is not a sound pack that this version reads.
    InvalidPack = 5,
    /// The query does not exist for shapes of this kind.
    Unsupported = 6,
    /// A cache or manifold is in use by another call, or was passed twice to a batch.
    Busy = 7,
    /// A bug in the library. The call was ended; caches and manifolds in it were emptied.
    Panic = 8,
}
