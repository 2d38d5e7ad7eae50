//! Words of a text file, with their line numbers.

/// Splits a text at white space. The bytes need not be UTF-8.
#[derive(Clone, Debug)]
pub struct Tokens<'a> {
    rest: &'a [u8],
    line: usize,
}

impl<'a> Tokens<'a> {
    /// Words of `text`, which starts at line `line` of its file.
    pub fn new(text: &'a [u8], line: usize) -> Self {
        Self { rest: text, line }
    }

    /// One-based line number of the word returned last, or of the end of the text.
    pub fn line(&self) -> usize {
        self.line
    }

    pub fn rest(&self) -> &'a [u8] {
        self.rest
    }

    pub fn next(&mut self) -> Option<&'a [u8]> {
        while let [first, tail @ ..] = self.rest {
            match first {
                // CRLF is one line ending, and so is a lone CR.
                b'\n' => self.line += 1,
                b'\r' if tail.first() != Some(&b'\n') => self.line += 1,
                b'\r' | b' ' | b'\t' | 0x0B | 0x0C => {}
                _ => {
                    let end = self.rest.iter().position(|b| matches!(b, b'\t'..=b'\r' | b' '));
                    let (word, tail) = self.rest.split_at(end.unwrap_or(self.rest.len()));
                    self.rest = tail;
                    return Some(word);
                }
            }
            self.rest = tail;
        }
        None
    }

    pub fn next_in_line(&mut self) -> Option<&'a [u8]> {
        let blank = self.rest.iter().take_while(|b| matches!(b, b' ' | b'\t' | 0x0B | 0x0C)).count();
        let (_, rest) = self.rest.split_at(blank);
        self.rest = rest;
        if matches!(rest, [] | [b'\n' | b'\r', ..]) { None } else { self.next() }
    }

    pub fn skip_blank(&mut self) {
        let mut ahead = self.clone();
        if let Some(word) = ahead.next() {
            let end = self.rest.len() - ahead.rest.len();
            let (_, rest) = self.rest.split_at(end - word.len());
            (self.rest, self.line) = (rest, ahead.line);
        } else {
            *self = ahead;
        }
    }

    pub fn rest_of_line(&mut self) -> &'a [u8] {
        let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(self.rest.len());
        let (line, tail) = self.rest.split_at(end);
        self.rest = tail;
        line.trim_ascii()
    }
}

/// Text of a word. Replacement characters stand for bytes that are not UTF-8.
pub fn text(word: &[u8]) -> std::borrow::Cow<'_, str> {
    String::from_utf8_lossy(word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_know_their_lines() {
        let mut tokens = Tokens::new(b" a\tb\r\n\r\nc\rd  e f \n\x0Cg", 3);
        let mut found = Vec::new();
        while let Some(word) = tokens.next() {
            found.push((tokens.line(), text(word).into_owned()));
            if word == b"d" {
                assert_eq!(tokens.rest_of_line(), b"e f");
            }
        }
        let expected = [(3, "a"), (3, "b"), (5, "c"), (6, "d"), (7, "g")];
        assert_eq!(found, expected.map(|(line, word)| (line, word.to_owned())));
    }

    #[test]
    fn words_of_a_line_end_with_it() {
        let mut tokens = Tokens::new(b"a \tb \r\n\n c", 1);
        assert_eq!(tokens.next_in_line(), Some(&b"a"[..]));
        assert_eq!(tokens.next_in_line(), Some(&b"b"[..]));
        assert_eq!((tokens.next_in_line(), tokens.next_in_line()), (None, None));
        tokens.skip_blank();
        assert_eq!((tokens.line(), tokens.next_in_line()), (3, Some(&b"c"[..])));
        tokens.skip_blank();
        assert_eq!((tokens.line(), tokens.rest(), tokens.next_in_line()), (3, &b""[..], None));
    }
}
