//! The corpus of a fuzz target, as one archive: `fuzz/corpus/TARGET.tar.gz`. libFuzzer works on a
//! folder; `fuzz/README.md` has the commands between the two.

use std::io::{self, Read};

use flate2::read::GzDecoder;

/// An input: its name within the corpus, and its bytes.
pub type Input = (String, Vec<u8>);

/// The inputs of an archive, in the archive's order. Fails if the bytes are not a gzip-compressed
/// tar archive of files.
pub fn unpack(archive: &[u8]) -> io::Result<Vec<Input>> {
    let mut archive = tar::Archive::new(GzDecoder::new(archive));
    let read = |entry: io::Result<tar::Entry<'_, _>>| {
        let mut entry = entry?;
        let name = entry.path()?.display().to_string();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes)?;
        Ok((name, bytes))
    };
    archive.entries()?.map(read).collect()
}
