//! Wavefront OBJ: logical lines with their numbers, and a text cut into parts for parallel reading.

use std::borrow::Cow;

use memchr::{memchr, memchr2};
use rayon::prelude::*;

use crate::fault::Fault;

const LONGEST_NAME_KEYWORD: usize = "usemtl".len();

/// Iterator over the lines of a text. A line ends with LF, CRLF or a lone CR.
#[derive(Clone, Debug)]
pub struct Lines<'a> {
    rest: &'a [u8],
    line_number: usize,
}

impl<'a> Lines<'a> {
    /// Lines of `bytes`. `first` is the one-based number of the first line.
    pub fn new(bytes: &'a [u8], first: usize) -> Self {
        Self { rest: bytes, line_number: first - 1 }
    }

    pub fn line_number(&self) -> usize {
        self.line_number
    }

    fn next_physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.line_number += 1;
        let end = memchr2(b'\n', b'\r', self.rest).unwrap_or(self.rest.len());
        let (line, tail) = self.rest.split_at(end);
        self.rest = match tail {
            [b'\r', b'\n', rest @ ..] | [_, rest @ ..] => rest,
            [] => tail,
        };
        Some(line)
    }

    /// Next logical line, a line joined with its continuations, and the number of its first line.
    pub fn next_logical(&mut self) -> Option<(usize, Cow<'a, [u8]>)> {
        let first = self.next_physical()?;
        let line_number = self.line_number;
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
        Some((line_number, line))
    }
}

/// Whether a trailing `\` joins the next line: not after comments or names. Reads only the start of
/// the line, which grows with each continuation.
fn may_continue(line: &[u8]) -> bool {
    let start = line.get(..=LONGEST_NAME_KEYWORD).unwrap_or(line);
    let keyword = start.split(u8::is_ascii_whitespace).next().unwrap_or_default();
    !keyword.starts_with(b"#") && ![&b"o"[..], b"g", b"usemtl", b"mtllib"].contains(&keyword)
}

pub fn is_vertex_line(line: &[u8]) -> bool {
    // A line whose first part is only a continuation starts with a blank.
    match line.trim_ascii_start() {
        [b'v', b' ' | b'\t', ..] => true,
        // White space beyond ASCII, or a vertical tab, may precede or follow the keyword.
        [b'v' | 0x0B | 0x80.., ..] if !is_irrelevant(line) => with_words!(line, words => words.next() == Some("v")),
        _ => false,
    }
}

/// The most frequent lines without effect on a hull need not be split into words.
pub fn is_irrelevant(line: &[u8]) -> bool {
    matches!(line, [b'v', b't' | b'n' | b'p', b' ' | b'\t', ..] | [b'#', ..])
}

/// A text cut into parts that are read in parallel.
#[derive(Debug)]
pub struct Parts<'a> {
    pub text: &'a [u8],
    /// The parts, in file order. Joined they are the text, and so are their logical lines.
    pub parts: Vec<Part<'a>>,
}

#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    pub text: &'a [u8],
    /// One-based number of its first line.
    pub first_line: usize,
    /// Number of `v` lines before it.
    pub first_vertex: usize,
    pub vertex_count: usize,
}

impl<'a> Parts<'a> {
    /// Cuts `text` into parts of about `part_bytes` and counts the lines of each. Fails for more
    /// vertices than `u32` can index. Complexity: O(bytes), in parallel.
    pub fn new(text: &'a [u8], part_bytes: usize) -> Result<Self, Fault> {
        let texts = cut(text, part_bytes);
        let counts: Vec<(usize, usize)> = texts.par_iter().map(|text| count_vertices_and_lines(text)).collect();
        let (mut first_vertex, mut first_line) = (0, 1);
        let mut parts = Vec::with_capacity(texts.len());
        for (text, (vertex_count, line_count)) in texts.into_iter().zip(counts) {
            parts.push(Part { text, first_line, first_vertex, vertex_count });
            first_vertex += vertex_count;
            first_line += line_count;
        }
        if first_vertex > (u32::MAX - 1) as usize {
            return Err(Fault::TooManyVertices);
        }
        Ok(Self { text, parts })
    }

    pub fn vertex_count(&self) -> usize {
        self.parts.iter().map(|part| part.vertex_count).sum()
    }
}

fn count_vertices_and_lines(text: &[u8]) -> (usize, usize) {
    let mut lines = Lines::new(text, 1);
    let mut vertices = 0;
    while let Some((_, line)) = lines.next_logical() {
        vertices += usize::from(is_vertex_line(&line));
    }
    (vertices, lines.line_number())
}

/// Cuts a text into pieces of about `size` bytes. Each ends with an LF that no logical line spans.
#[expect(
    clippy::indexing_slicing,
    reason = "`end` is `size`, which is less than the rest, or lies behind an LF that was found"
)]
fn cut(bytes: &[u8], size: usize) -> Vec<&[u8]> {
    let mut pieces = Vec::new();
    let mut rest = bytes;
    while rest.len() > size {
        let mut end = size;
        // The bytes of the current line: first all of the piece, later what follows the last LF.
        let mut line = 0;
        // Never cuts behind a line that ends in `\`, even where that `\` continues nothing.
        let cut = loop {
            match memchr(b'\n', &rest[end..]) {
                Some(at) if rest[line..end + at].trim_ascii_end().last() == Some(&b'\\') => {
                    end += at + 1;
                    line = end;
                }
                Some(at) => break end + at + 1,
                None => break rest.len(),
            }
        };
        let (piece, tail) = rest.split_at(cut);
        pieces.push(piece);
        rest = tail;
    }
    if !rest.is_empty() || pieces.is_empty() {
        pieces.push(rest);
    }
    pieces
}

/// Runs `$body` with the words of a logical line, as from `str::split_whitespace`, faster for
/// ASCII. Replacement characters stand for bytes beyond UTF-8.
macro_rules! with_words {
    ($line:expr, $words:ident => $body:expr) => {{
        match std::str::from_utf8($line) {
            Ok(text) if text.is_ascii() => {
                // All white space below 128.
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
        std::iter::from_fn(|| lines.next_logical().map(|(line_number, line)| (line_number, line.into_owned())))
            .collect()
    }

    #[test]
    fn parts_have_the_lines_of_the_whole() {
        const SEED: u64 = 5;
        let mut random = SplitMix64::new(SEED);
        let mut cut_count = 0;
        for round in 0..2000 {
            let text: Vec<u8> = (0..random.below(60)).map(|_| b"\n\n\r\\\\ vvfo#1"[random.below(12)]).collect();
            let parts = Parts::new(&text, 1 + random.below(20)).unwrap();
            cut_count += parts.parts.len() - 1;
            let mut bytes = Vec::new();
            let (mut lines, mut vertex_count) = (Vec::new(), 0);
            for part in &parts.parts {
                assert_eq!(part.first_vertex, vertex_count, "seed {SEED}, round {round}");
                bytes.extend_from_slice(part.text);
                let mut reader = Lines::new(part.text, part.first_line);
                while let Some((line_number, line)) = reader.next_logical() {
                    let text = String::from_utf8_lossy(&line);
                    vertex_count += usize::from(text.split_whitespace().next() == Some("v"));
                    lines.push((line_number, line.into_owned()));
                }
            }
            assert_eq!(bytes, text, "seed {SEED}, round {round}");
            assert_eq!(parts.vertex_count(), vertex_count, "seed {SEED}, round {round}");
            assert_eq!(lines, all(&text), "seed {SEED}, round {round}: {}", text.escape_ascii());
        }
        assert!(cut_count > 1000, "only {cut_count} cuts");
    }

    #[test]
    fn ascii_words_agree_with_split_whitespace() {
        for c in (0..0x300).filter_map(char::from_u32) {
            let text = format!("a{c}b 1");
            let count = with_words!(text.as_bytes(), words => words.by_ref().count());
            assert_eq!(count, text.split_whitespace().count(), "{c:?}");
        }
    }

    #[test]
    fn vertex_lines_are_recognised_by_their_keyword() {
        for c in (0..0x3100).filter_map(char::from_u32).filter(|c| !matches!(c, '\n' | '\r')) {
            for text in [format!("v{c}1 2 3"), format!("{c}v 1 2 3"), format!("{c} v")] {
                let expected = text.split_whitespace().next() == Some("v");
                assert_eq!(is_vertex_line(text.trim_ascii().as_bytes()), expected, "{text:?}");
            }
        }
    }
}
