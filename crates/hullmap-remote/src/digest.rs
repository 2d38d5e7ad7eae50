//! Digests: SHA-256 and size of a blob, which are its name in a content-addressed store.

use bazel_remote_apis::build::bazel::remote::execution::v2 as api;
use sha2::{Digest as _, Sha256};

use crate::RemoteError;

/// Name of a blob.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Digest {
    hash: String,
    size: u64,
}

impl Digest {
    /// The digest of some bytes.
    ///
    /// ```
    /// let digest = hullmap_remote::Digest::from_bytes(b"abc");
    /// assert!(digest.hash().starts_with("ba7816bf") && digest.size() == 3);
    /// ```
    ///
    /// # Complexity
    /// O(bytes).
    pub fn from_bytes(bytes: &[u8]) -> Self {
        let hash = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        Self { hash, size: bytes.len() as u64 }
    }

    /// A digest that is known already; `hash` are 64 hexadecimal digits in lower case.
    ///
    /// # Errors
    /// `hash` is something else.
    pub fn new(hash: &str, size: u64) -> Result<Self, RemoteError> {
        let is_digit = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
        if hash.len() != 64 || !hash.bytes().all(is_digit) || i64::try_from(size).is_err() {
            return Err(RemoteError::Invalid(format!("`{}`, {size} is not a SHA-256 digest", hash.escape_debug())));
        }
        Ok(Self { hash: hash.to_owned(), size })
    }

    /// SHA-256 as 64 hexadecimal digits.
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// Size of the blob in bytes.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// The digest as a message.
    pub(crate) fn message(&self) -> api::Digest {
        // `new` rejects larger sizes, and no slice is larger.
        api::Digest { hash: self.hash.clone(), size_bytes: i64::try_from(self.size).unwrap_or(i64::MAX) }
    }

    /// The digest in a message.
    pub(crate) fn read(message: Option<&api::Digest>) -> Result<Self, RemoteError> {
        let missing = || RemoteError::Invalid("a digest is missing".to_owned());
        let message = message.ok_or_else(missing)?;
        Self::new(&message.hash, u64::try_from(message.size_bytes).map_err(|_| missing())?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_digests_are_digests() {
        let hash = Digest::from_bytes(b"").hash().to_owned();
        assert_eq!(Digest::new(&hash, 0).unwrap(), Digest::from_bytes(b""));
        for (hash, size) in [
            ("", 0),
            (&hash[1..], 0),
            (&*hash.to_uppercase(), 0),
            (&*format!("{}/", &hash[1..]), 0),
            (&*hash, u64::MAX),
        ] {
            assert!(Digest::new(hash, size).is_err(), "{hash} {size}");
        }
    }
}
