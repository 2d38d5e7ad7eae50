//! The lines of an OBJ file, continuations joined, and the file in parts that can be read side by side.

use std::borrow::Cow;

use memchr::memchr2;

/// The lines of a text with their one-based numbers: ended by LF, CRLF or a lone CR.
#[derive(Clone, Debug)]
pub struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    /// The lines of `bytes`, of which the first has the number `first`.
    pub fn new(bytes: &'a [u8], first: usize) -> Self {
        Self { rest: bytes, number: first - 1 }
    }

    /// Number of the last line returned.
    pub fn number(&self) -> usize {
        self.number
    }

    /// The next line without its end.
    fn next_physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end = memchr2(b'\n', b'\r', self.rest).unwrap_or(self.rest.len());
        let (line, tail) = self.rest.split_at(end);
        self.rest = match tail {
            [b'\r', b'\n', rest @ ..] | [_, rest @ ..] => rest,
            [] => tail,
        };
        Some(line)
    }

    /// The next line with those that continue it, and the number of its first.
    pub fn next_logical(&mut self) -> Option<(usize, Cow<'a, [u8]>)> {
        let first = self.next_physical()?;
        let number = self.number;
        let mut line = Cow::Borrowed(first.trim_ascii());
        while line.last() == Some(&b'\\') && may_continue(&line) {
            let joined = line.to_mut();
            joined.pop();
            joined.push(b' ');
            match self.next_physical() {
                Some(next) => joined.extend_from_slice(next.trim_ascii()),
                None => break,
            }
        }
        Some((number, line))
    }
}

/// Whether a `\` at the end of this line joins the next one to it.
fn may_continue(line: &[u8]) -> bool {
    let keyword = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
    !keyword.starts_with(b"#") && ![&b"o"[..], b"g", b"usemtl", b"mtllib"].contains(&keyword)
}

/// Cuts a text into parts of about `size` bytes, behind an LF that no line continues across.
///
/// The parts' lines, one part after the other, are the text's.
#[expect(
    clippy::indexing_slicing,
    reason = "`end` is `size`, which is less than is left, or behind an LF that was found"
)]
pub fn parts(bytes: &[u8], size: usize) -> Vec<&[u8]> {
    let mut parts = Vec::new();
    let mut rest = bytes;
    while rest.len() > size {
        let mut end = size;
        // A line that seems to continue is never cut, whether it may or not.
        let cut = loop {
            match memchr2(b'\n', b'\n', &rest[end..]) {
                Some(at) if rest[..end + at].trim_ascii_end().last() == Some(&b'\\') => end += at + 1,
                Some(at) => break end + at + 1,
                None => break rest.len(),
            }
        };
        let (part, tail) = rest.split_at(cut);
        parts.push(part);
        rest = tail;
    }
    if !rest.is_empty() || parts.is_empty() {
        parts.push(rest);
    }
    parts
}

/// Runs `$body` with the words of a logical line: as `char::is_whitespace` cuts them, sooner where all is ASCII. Bytes
/// that are not UTF-8 become replacement characters.
macro_rules! with_words {
    ($line:expr, $words:ident => $body:expr) => {{
        match std::str::from_utf8($line) {
            Ok(text) if text.is_ascii() => {
                // Exactly the white space below 128.
                let is_blank = |c: char| matches!(c, '\t'..='\r' | ' ');
                let mut $words = text.split(is_blank).filter(|word| !word.is_empty());
                $body
            }
            Ok(text) => {
                let mut $words = text.split_whitespace();
                $body
            }
            Err(_) => {
                let text = String::from_utf8_lossy($line);
                let mut $words = text.split_whitespace();
                $body
            }
        }
    }};
}
pub(super) use with_words;

#[cfg(test)]
mod tests {
    use super::*;
    use shapes::rng::SplitMix64;

    fn all(bytes: &[u8]) -> Vec<(usize, Vec<u8>)> {
        let mut lines = Lines::new(bytes, 1);
        std::iter::from_fn(|| lines.next_logical().map(|(number, line)| (number, line.into_owned()))).collect()
    }

    #[test]
    fn parts_have_the_lines_of_the_whole() {
        const SEED: u64 = 5;
        let mut random = SplitMix64::new(SEED);
        let mut cut_count = 0;
        for round in 0..2000 {
            let text: Vec<u8> = (0..random.below(60)).map(|_| b"\n\n\r\\\\ vfo#1"[random.below(11)]).collect();
            let size = 1 + random.below(20);
            let parts = parts(&text, size);
            cut_count += parts.len() - 1;
            assert_eq!(parts.concat(), text, "seed {SEED}, round {round}");
            let (mut lines, mut number) = (Vec::new(), 1);
            for part in parts {
                let mut reader = Lines::new(part, number);
                while let Some((number, line)) = reader.next_logical() {
                    lines.push((number, line.into_owned()));
                }
                number = reader.number() + 1;
            }
            assert_eq!(lines, all(&text), "seed {SEED}, round {round}: {}", text.escape_ascii());
        }
        assert!(cut_count > 1000, "{cut_count} cuts say little");
    }

    #[test]
    fn words_are_those_of_split_whitespace() {
        for c in (0..0x300).filter_map(char::from_u32) {
            let text = format!("a{c}b 1");
            let count = with_words!(text.as_bytes(), words => words.by_ref().count());
            assert_eq!(count, text.split_whitespace().count(), "{c:?}");
        }
    }
}
