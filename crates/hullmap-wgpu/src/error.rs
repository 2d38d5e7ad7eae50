/// Why a batch could not be solved on a GPU.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum Error {
    /// There is no Vulkan device.
    #[error("no Vulkan device: {reason}; install a driver, or use Backend::Cpu")]
    NoDevice { reason: String },
    /// A section of the pack is longer than the device can bind.
    #[error(
        "the section `{section}` has {found} bytes, but the device binds {limit}; use Backend::Cpu or split the pack"
    )]
    TooLarge { section: &'static str, found: u64, limit: u64 },
    /// The sections of the pack cannot be read in place.
    #[error("the sections of the pack cannot be used in place on this processor; use Backend::Cpu")]
    Pack,
    /// The device was lost, or an operation on it failed.
    #[error("the device failed: {reason}; solve the batch again with Backend::Cpu")]
    Device { reason: String },
}
