/// UTF-8 text of a file with a byte order mark of UTF-16, which is removed. Replacement characters
/// stand for invalid UTF-16. The text is at most 1.5 times as long.
pub fn from_utf16(bytes: &[u8]) -> Option<Vec<u8>> {
    let unit: fn([u8; 2]) -> u16 = match bytes {
        [0xFF, 0xFE, ..] => u16::from_le_bytes,
        [0xFE, 0xFF, ..] => u16::from_be_bytes,
        _ => return None,
    };
    let (units, rest) = bytes.get(2..)?.as_chunks::<2>();
    let mut text = String::with_capacity(units.len());
    let decoded = char::decode_utf16(units.iter().map(|&bytes| unit(bytes)));
    text.extend(decoded.map(|decoded| decoded.unwrap_or(char::REPLACEMENT_CHARACTER)));
    if !rest.is_empty() {
        text.push(char::REPLACEMENT_CHARACTER);
    }
    Some(text.into_bytes())
}

pub fn is_utf16(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\xFF\xFE") || bytes.starts_with(b"\xFE\xFF")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_a_unit_and_lone_surrogates_become_replacement_characters() {
        assert_eq!(from_utf16(b"\xFF\xFEv\0x").unwrap(), "v\u{FFFD}".as_bytes());
        assert_eq!(from_utf16(b"\xFF\xFE\0\xD8v\0").unwrap(), "\u{FFFD}v".as_bytes());
        assert_eq!(from_utf16(b"\xFF\xFE").unwrap(), b"");
    }
}
