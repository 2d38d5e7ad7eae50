//! Clouds of game data: the file that the variable `HULLMAP_HULLS` names.
//!
//! Little-endian: a u32 count and that many points of three f32, repeated to the end of the file.

use hullmap_testkit::files;

/// The variable that names the file.
pub const VARIABLE: &str = "HULLMAP_HULLS";

/// The clouds of the file. If the variable is not set, prints which test is skipped and returns
/// `None`. Panics if the file cannot be read, or ends inside a cloud.
pub fn clouds(test: &str) -> Option<Vec<Vec<[f32; 3]>>> {
    let path = files::path(VARIABLE, test)?;
    Some(read(&std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))))
}

/// The clouds in the bytes of such a file. Panics if they end inside a cloud.
pub fn read(bytes: &[u8]) -> Vec<Vec<[f32; 3]>> {
    let mut words = bytes.chunks_exact(4).map(|word| <[u8; 4]>::try_from(word).expect("four bytes"));
    let mut clouds = Vec::new();
    while let Some(count) = words.next() {
        let mut number = || f32::from_le_bytes(words.next().expect("the file ends inside a cloud"));
        clouds.push((0..u32::from_le_bytes(count)).map(|_| std::array::from_fn(|_| number())).collect());
    }
    clouds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_clouds_is_read() {
        let mut bytes = Vec::new();
        for cloud in [vec![[1.0_f32, 2.0, 3.0]], vec![], vec![[4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]] {
            bytes.extend((cloud.len() as u32).to_le_bytes());
            bytes.extend(cloud.iter().flatten().flat_map(|x| x.to_le_bytes()));
        }
        assert_eq!(read(&bytes), [vec![[1.0, 2.0, 3.0]], vec![], vec![[4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]]);
    }
}
