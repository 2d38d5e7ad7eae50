//! Container of binary glTF: a header, and chunks that end at multiples of four bytes.
//!
//! # Reference
//! Khronos Group, "glTF 2.0 Specification", section 4.4.

/// `glTF` and the version.
const MAGIC: [u32; 2] = [0x4654_6c67, 2];

pub const JSON: u32 = 0x4e4f_534a;
pub const BIN: u32 = 0x004e_4942;

/// JSON is padded by spaces, all else by zeros. Fails above 4 GiB, the limit of its header.
pub fn write(mut chunks: Vec<(u32, Vec<u8>)>) -> Result<Vec<u8>, String> {
    for (kind, chunk) in &mut chunks {
        chunk.resize(chunk.len().next_multiple_of(4), if *kind == JSON { b' ' } else { 0 });
    }
    let length = 12 + chunks.iter().map(|(_, chunk)| 8 + chunk.len()).sum::<usize>();
    let number = |length: usize| {
        u32::try_from(length).map_err(|_| {
            format!("the GLB file would have {length} bytes, and the limit is 4 GiB; select fewer hulls with --hull")
        })
    };
    let mut file = Vec::with_capacity(length);
    file.extend(MAGIC.into_iter().chain([number(length)?]).flat_map(u32::to_le_bytes));
    for (kind, chunk) in chunks {
        file.extend([number(chunk.len())?, kind].into_iter().flat_map(u32::to_le_bytes));
        file.extend(chunk);
    }
    Ok(file)
}

/// The chunks of a file, with their types. Fails if it is cut off or of another version.
pub fn read(bytes: &[u8]) -> Result<Vec<(u32, &[u8])>, String> {
    let word = |at: usize| bytes.get(at..)?.first_chunk().map(|bytes| u32::from_le_bytes(*bytes));
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err("the GLB header is incomplete".to_owned());
    };
    if version != MAGIC[1] {
        return Err(format!("the file is GLB version {version}; expected version 2"));
    }
    let bytes = bytes.get(..length as usize).ok_or("the file is shorter than its GLB header claims")?;
    let (mut chunks, mut at) = (Vec::new(), 12);
    while let (Some(length), Some(kind)) = (word(at), word(at + 4)) {
        let Some(chunk) = bytes.get(at + 8..).and_then(|rest| rest.get(..length as usize)) else {
            return Err("a GLB chunk is cut off".to_owned());
        };
        chunks.push((kind, chunk));
        at += 8 + chunk.len();
    }
    Ok(chunks)
}

pub fn is_glb(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC[0].to_le_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_are_padded_and_read_again() {
        let file = write(vec![(JSON, b"{}".to_vec()), (BIN, vec![1, 2, 3, 4, 5]), (7, vec![9])]).unwrap();
        assert!(is_glb(&file) && file.len() == 12 + 12 + 16 + 12);
        let chunks = read(&file).unwrap();
        assert_eq!(chunks, [(JSON, &b"{}  "[..]), (BIN, &[1, 2, 3, 4, 5, 0, 0, 0]), (7, &[9, 0, 0, 0])]);
        for length in 0..file.len() {
            assert!(read(&file[..length]).is_err(), "{length}");
        }
    }
}
