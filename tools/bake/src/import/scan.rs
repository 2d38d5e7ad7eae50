//! First reader: every `v` line and every vertex reference of an OBJ file, with line numbers.
//!
//! tobj reads OBJ files well but reports only the vertices that faces and lines reference, forgets their numbers and
//! has no line numbers in its errors. This scanner reads just what shapes a hull, so that errors can say where they
//! are and so that every hull vertex can be traced to its `v` line. `cross_check` has tobj read the same words.
//!
//! 1. Split the bytes at LF, CRLF or a lone CR; drop a UTF-8 byte order mark; join lines that end in `\`.
//! 2. `v`: three coordinates parsed as `f32`, divided by a fourth (w) where there is one; colours are skipped.
//! 3. `f`, `l`, `p`: references resolved to zero-based vertex numbers; negative ones count back from their line.
//! 4. `o` opens an object. Everything else (`vt`, `vn`, `g`, materials, …) does not shape a hull and is not checked.
//! 5. Positive references may point ahead; they are checked against the vertex count at the end.
//!
//! Deviations from the OBJ text format, all of them harmless:
//! - a word that starts with `#` ends a `v`, `f`, `l` or `p` line (many writers put remarks there);
//! - comments and lines that hold names (`o`, `g`, `usemtl`, `mtllib`) never continue: Windows paths end in `\`;
//! - bytes that are not UTF-8 are tolerated wherever they are not part of a number;
//! - an `f` of one or two vertices counts as an element, as it does for tobj.

use std::borrow::Cow;
use std::fmt::Write as _;

use super::fault::{Fault, LineFault};

/// Longest excerpt of a faulty word in a message, in characters.
const EXCERPT_CHARS: usize = 40;

/// Everything in an OBJ file that can shape a hull.
#[derive(Debug, Default)]
pub struct Scan {
    /// Position of each `v` line, in file order, all finite.
    pub positions: Vec<[f32; 3]>,
    /// For each `v` line the number of the object it was declared in.
    pub vertex_objects: Vec<u32>,
    /// Elements in file order.
    pub elements: Vec<Element>,
    /// References of all elements, one after the other: zero-based numbers of `v` lines, all in range.
    pub references: Vec<u32>,
    /// Objects in file order; the first is what stands before any `o` line, with an empty name.
    pub objects: Vec<String>,
    /// Number of `g` lines.
    pub group_count: usize,
    /// Number of `f` lines with fewer than three vertices.
    pub short_face_count: usize,
    /// First line with a free-form curve or surface, which is not read as an element.
    pub free_form_line: Option<usize>,
    /// The words of all `v` lines and elements, one logical line each, for the second reader.
    pub plain_text: String,
}

/// One `f`, `l` or `p` line.
#[derive(Clone, Copy, Debug)]
pub struct Element {
    /// One-based line.
    pub line: usize,
    /// Number of the object it belongs to.
    pub object: u32,
    /// Where its references end in [`Scan::references`]; they start where the previous element's end.
    pub end: usize,
}

/// Reads the geometry of an OBJ file.
///
/// # Errors
/// The first fault in the file, with its line; references that are too large come after all others.
///
/// # Complexity
/// O(bytes); memory a small multiple of the file.
pub fn scan(bytes: &[u8]) -> Result<Scan, LineFault> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    if bytes.starts_with(b"\xFF\xFE") || bytes.starts_with(b"\xFE\xFF") {
        return Err(Fault::Utf16.of_file());
    }
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(Fault::Empty.of_file());
    }

    let mut scan = Scan { objects: vec![String::new()], ..Scan::default() };
    let mut lines = Lines { rest: bytes, number: 0 };
    while let Some((line, text)) = lines.next_logical() {
        scan.read_line(line, &text).map_err(|fault| fault.at(line))?;
    }
    if scan.positions.is_empty() {
        return Err(Fault::NoVertices.of_file());
    }
    scan.check_range()?;
    Ok(scan)
}

impl Scan {
    /// References of element number `element`.
    pub fn references_of(&self, element: usize) -> &[u32] {
        let start = if element == 0 { 0 } else { self.elements[element - 1].end };
        &self.references[start..self.elements[element].end]
    }

    fn read_line(&mut self, line: usize, text: &[u8]) -> Result<(), Fault> {
        let text = String::from_utf8_lossy(text);
        let mut words = text.split_whitespace();
        match words.next() {
            Some("v") => self.read_vertex(words.take_while(|word| !word.starts_with('#'))),
            Some(keyword @ ("f" | "l" | "p")) => {
                self.read_element(line, keyword, words.take_while(|word| !word.starts_with('#')))
            }
            Some("o") => {
                let name = text.trim_start()["o".len()..].trim();
                self.objects.push(name.to_owned());
                Ok(())
            }
            Some("g") => {
                self.group_count += 1;
                Ok(())
            }
            Some("curv" | "surf") => {
                self.free_form_line.get_or_insert(line);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn object(&self) -> u32 {
        (self.objects.len() - 1) as u32
    }

    fn read_vertex<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<(), Fault> {
        if self.positions.len() >= (u32::MAX - 1) as usize {
            return Err(Fault::TooManyVertices);
        }
        let mut found = 0;
        let mut numbers = [""; 4];
        for word in words {
            if let Some(slot) = numbers.get_mut(found) {
                *slot = word;
            }
            found += 1;
        }
        let mut position = [0.0; 3];
        for (coordinate, word) in position.iter_mut().zip(&numbers[..found.min(3)]) {
            *coordinate = parse_coordinate(word)?;
        }
        self.plain_text.push('v');
        let kept = match found {
            0..3 => return Err(Fault::TooFewCoordinates { found }),
            3 | 6 => 3,
            4 => {
                let weight = parse_coordinate(numbers[3])?;
                if weight == 0.0 {
                    return Err(Fault::ZeroWeight);
                }
                for (coordinate, word) in position.iter_mut().zip(&numbers) {
                    *coordinate /= weight;
                    if !coordinate.is_finite() {
                        return Err(Fault::Overflow { text: excerpt(&format!("{word} / {weight}")) });
                    }
                }
                4
            }
            _ => return Err(Fault::CoordinateCount { found }),
        };
        for word in &numbers[..kept] {
            self.plain_text.push(' ');
            self.plain_text.push_str(word);
        }
        self.plain_text.push('\n');
        self.positions.push(position);
        self.vertex_objects.push(self.object());
        Ok(())
    }

    fn read_element<'a>(
        &mut self,
        line: usize,
        keyword: &str,
        words: impl Iterator<Item = &'a str>,
    ) -> Result<(), Fault> {
        // tobj ignores `p`; as an `l` it reads the same references.
        self.plain_text.push(if keyword == "f" { 'f' } else { 'l' });
        let start = self.references.len();
        for word in words {
            self.references.push(resolve_reference(word, self.positions.len())?);
            self.plain_text.push(' ');
            self.plain_text.push_str(word);
        }
        self.plain_text.push('\n');
        let count = self.references.len() - start;
        if count == 0 {
            return Err(Fault::NoReferences { keyword: keyword.to_owned() });
        }
        if keyword == "f" && count < 3 {
            self.short_face_count += 1;
        }
        self.elements.push(Element { line, object: self.object(), end: self.references.len() });
        Ok(())
    }

    fn check_range(&mut self) -> Result<(), LineFault> {
        let count = self.positions.len();
        for (number, element) in self.elements.iter().enumerate() {
            for &reference in self.references_of(number) {
                if reference as usize >= count {
                    let number = u64::from(reference) + 1;
                    return Err(Fault::IndexTooLarge { number, count }.at(element.line));
                }
            }
        }
        // tobj reports only what elements reference. This last element references every vertex, counted from the
        // end, so that it also fails when tobj has counted fewer of them.
        self.plain_text.push('l');
        for back in (1..=count).rev() {
            write!(self.plain_text, " -{back}").expect("writing to a string succeeds");
        }
        self.plain_text.push('\n');
        Ok(())
    }
}

/// A coordinate as tobj parses it, or why it is none.
fn parse_coordinate(word: &str) -> Result<f32, Fault> {
    let text = || excerpt(word);
    match word.parse::<f32>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(value) if value.is_nan() => Err(Fault::NotANumber { text: text() }),
        Ok(_) if word.contains(|c: char| c.is_ascii_digit()) => Err(Fault::Overflow { text: text() }),
        Ok(_) => Err(Fault::Infinite { text: text() }),
        Err(_) => Err(Fault::BadNumber { text: text() }),
    }
}

/// Zero-based vertex number of a reference such as `7`, `7/1`, `7//3`, `7/1/3` or `-1`, with `declared` vertices
/// above it. The numbers of texture coordinates and normals must be numbers; their range does not matter to a hull.
fn resolve_reference(word: &str, declared: usize) -> Result<u32, Fault> {
    let bad = || Fault::BadReference { text: excerpt(word) };
    let mut parts = word.split('/');
    let number: i64 = parts.next().unwrap_or("").parse().map_err(|_| bad())?;
    let mut other_count = 0;
    for part in parts {
        other_count += 1;
        if other_count > 2 || !(part.is_empty() || part.parse::<i64>().is_ok()) {
            return Err(bad());
        }
    }
    match number {
        0 => Err(Fault::ZeroIndex { text: excerpt(word) }),
        // Beyond u32 it is out of range whatever follows: `check_range` says so, with the vertex count.
        1.. => Ok(u32::try_from(number - 1).unwrap_or(u32::MAX)),
        _ => usize::try_from(number.unsigned_abs())
            .ok()
            .and_then(|back| declared.checked_sub(back))
            .map(|index| index as u32)
            .ok_or_else(|| Fault::IndexBeforeFirst { text: excerpt(word), declared }),
    }
}

/// The start of a faulty word, without control characters.
fn excerpt(word: &str) -> String {
    let mut text: String = word.chars().filter(|c| !c.is_control()).take(EXCERPT_CHARS).collect();
    if word.chars().nth(EXCERPT_CHARS).is_some() {
        text.push('…');
    }
    text
}

/// The lines of a file with their one-based numbers.
struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    /// The next line without its end.
    fn next_physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end = self.rest.iter().position(|&byte| byte == b'\n' || byte == b'\r');
        let end = end.unwrap_or(self.rest.len());
        let (line, tail) = self.rest.split_at(end);
        self.rest = match tail {
            [b'\r', b'\n', rest @ ..] | [_, rest @ ..] => rest,
            [] => tail,
        };
        Some(line)
    }

    /// The next line with those that continue it, and the number of its first.
    fn next_logical(&mut self) -> Option<(usize, Cow<'a, [u8]>)> {
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
