//! The corpus of a fuzz target, as one archive: `fuzz/corpus/TARGET.tar.gz`.
//!
//! The archive depends on the names and bytes of its inputs alone: entries are sorted by name, and
//! have no owner and no time. Packing unchanged inputs therefore changes no byte. libFuzzer works
//! on a folder; `fuzz-corpus` converts between the two.

use std::{
    fs,
    io::{self, Read},
    path::{Path, PathBuf},
};

use flate2::{Compression, read::GzDecoder, write::GzEncoder};

/// An input: its name within the corpus, and its bytes.
pub type Input = (String, Vec<u8>);

/// Path of a target's archive in the folder of all archives.
pub fn archive_path(folder: &Path, target: &str) -> PathBuf {
    folder.join(format!("{target}.tar.gz"))
}

/// The inputs of an archive, in the archive's order. Fails if the bytes are not a gzip-compressed
/// tar archive of files with names in UTF-8.
pub fn unpack(archive: &[u8]) -> io::Result<Vec<Input>> {
    let mut archive = tar::Archive::new(GzDecoder::new(archive));
    let read = |entry: io::Result<tar::Entry<'_, _>>| {
        let mut entry = entry?;
        let name = entry.path()?.to_str().map(str::to_owned);
        let name = name.ok_or_else(|| io::Error::new(io::ErrorKind::InvalidData, "a name is not UTF-8"))?;
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes)?;
        Ok((name, bytes))
    };
    archive.entries()?.map(read).collect()
}

/// The archive of these inputs, sorted by name. Fails if a name is too long for its format.
pub fn pack(mut inputs: Vec<Input>) -> io::Result<Vec<u8>> {
    inputs.sort();
    let mut archive = tar::Builder::new(GzEncoder::new(Vec::new(), Compression::best()));
    for (name, bytes) in &inputs {
        let mut header = tar::Header::new_ustar();
        header.set_mode(0o644);
        header.set_size(bytes.len() as u64);
        archive.append_data(&mut header, name, &bytes[..])?;
    }
    archive.into_inner()?.finish()
}

/// The files of a folder as inputs, sorted by name. Fails if the folder or a file cannot be read,
/// or a name is not UTF-8.
pub fn read_folder(folder: &Path) -> io::Result<Vec<Input>> {
    let mut inputs = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().into_string();
        let name = name.map_err(|name| io::Error::other(format!("the name {} is not UTF-8", name.display())))?;
        inputs.push((name, fs::read(entry.path())?));
    }
    inputs.sort();
    Ok(inputs)
}

/// Writes inputs as files into a folder. Creates the folder if it does not exist. Fails if the
/// folder or a file cannot be written.
pub fn write_folder(folder: &Path, inputs: &[Input]) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    inputs.iter().try_for_each(|(name, bytes)| fs::write(folder.join(name), bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_survive_archive_and_folder_sorted_by_name() {
        let inputs = vec![("b".to_owned(), vec![]), ("a".to_owned(), vec![0, 255, 10])];
        let archive = pack(inputs.clone()).unwrap();
        let unpacked = unpack(&archive).unwrap();
        assert_eq!(unpacked, [inputs[1].clone(), inputs[0].clone()]);
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("new");
        write_folder(&folder, &inputs).unwrap();
        assert_eq!(read_folder(&folder).unwrap(), unpacked);
    }

    #[test]
    fn the_archive_does_not_depend_on_the_order_of_inputs() {
        let mut inputs: Vec<Input> = (0..100_u8).map(|i| (format!("{i}"), vec![i; usize::from(i)])).collect();
        let archive = pack(inputs.clone()).unwrap();
        inputs.reverse();
        assert_eq!(pack(inputs).unwrap(), archive);
    }

    #[test]
    fn damaged_archives_are_errors() {
        let archive = pack(vec![("a".to_owned(), vec![1; 1000])]).unwrap();
        assert!(unpack(&archive[..archive.len() / 2]).is_err());
        assert!(unpack(b"not an archive").is_err());
    }
}
