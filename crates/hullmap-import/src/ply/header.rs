//! The header of a PLY file: which elements it has, in which order, of which properties.

use crate::fault::{Fault, LineFault, excerpt};

/// How the numbers behind the header are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// As words.
    Text,
    /// As bytes, the lowest first.
    Little,
    /// As bytes, the highest first.
    Big,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    /// `char`, `int8`
    I8,
    /// `uchar`, `uint8`
    U8,
    /// `short`, `int16`
    I16,
    /// `ushort`, `uint16`
    U16,
    /// `int`, `int32`
    I32,
    /// `uint`, `uint32`
    U32,
    /// `float`, `float32`
    F32,
    /// `double`, `float64`
    F64,
}

impl Scalar {
    fn of(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of a number.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Whether it is a whole number.
    pub fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// A property of an element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Property {
    /// Its name.
    pub name: String,
    /// Type of the number, or of the numbers of a list.
    pub scalar: Scalar,
    /// Type of a list's length, if it is one.
    pub length: Option<Scalar>,
}

/// A kind of element, and how many follow.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Element {
    /// Its name.
    pub name: String,
    /// How many the header claims.
    pub count: u64,
    /// Its properties in their order.
    pub properties: Vec<Property>,
}

impl Element {
    /// Bytes of one such element at least: lists may be empty. In a text, each number takes one and a blank.
    pub fn least_size(&self, encoding: Encoding) -> u64 {
        let size = |property: &Property| match encoding {
            Encoding::Text => 2,
            _ => property.length.unwrap_or(property.scalar).size() as u64,
        };
        self.properties.iter().map(size).sum()
    }

    /// Bytes of one such element, if all have the same.
    pub fn fixed_size(&self) -> Option<usize> {
        self.properties.iter().map(|p| p.length.is_none().then_some(p.scalar.size())).sum()
    }

    /// Place of a property among the element's.
    pub fn find(&self, names: &[&str]) -> Option<usize> {
        self.properties.iter().position(|property| names.contains(&property.name.as_str()))
    }
}

/// What a header says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Header {
    /// How numbers are written.
    pub encoding: Encoding,
    /// The elements in their order.
    pub elements: Vec<Element>,
    /// Where they start.
    pub body: usize,
    /// Line they start on.
    pub line: usize,
}

/// Reads the header.
///
/// # Errors
/// The first line that is not understood.
pub fn read(bytes: &[u8]) -> Result<Header, LineFault> {
    let mut lines = HeaderLines { bytes, at: 0, number: 0 };
    if lines.next() != Some(b"ply") {
        return Err(Fault::format("the first line is not `ply`; is this a PLY file?").at(1));
    }
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    loop {
        let Some(line) = lines.next() else {
            return Err(
                Fault::format("the header has no `end_header`: the file was cut off; export it again").of_file()
            );
        };
        let number = lines.number;
        let text = String::from_utf8_lossy(line);
        let wrong = |expected: &str| {
            Fault::format(format!("`{}`, where {expected} is expected: correct the line", excerpt(&text))).at(number)
        };
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        match words.as_slice() {
            [] | ["comment" | "obj_info", ..] => {}
            ["format", kind, version] => {
                let kind = match *kind {
                    "ascii" => Encoding::Text,
                    "binary_little_endian" => Encoding::Little,
                    "binary_big_endian" => Encoding::Big,
                    _ => return Err(wrong("`ascii`, `binary_little_endian` or `binary_big_endian`")),
                };
                if *version != "1.0" {
                    return Err(wrong("version 1.0"));
                }
                encoding = Some(kind);
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| wrong("`element <name> <count>`"))?;
                elements.push(Element { name: (*name).to_owned(), count, properties: Vec::new() });
            }
            ["property", kind @ .., name] => {
                let types: Option<Vec<Scalar>> = kind.iter().filter(|w| **w != "list").map(|w| Scalar::of(w)).collect();
                let (scalar, length) = match (kind.first(), types.as_deref()) {
                    (Some(&"list"), Some(&[length, scalar])) if length.is_whole() => (scalar, Some(length)),
                    (_, Some(&[scalar])) if kind.len() == 1 => (scalar, None),
                    _ => return Err(wrong("`property <type> <name>` or `property list <type> <type> <name>`")),
                };
                let Some(element) = elements.last_mut() else {
                    return Err(wrong("an `element` before its properties"));
                };
                element.properties.push(Property { name: (*name).to_owned(), scalar, length });
            }
            ["end_header"] => break,
            _ => return Err(wrong("`format`, `comment`, `element`, `property` or `end_header`")),
        }
    }
    let Some(encoding) = encoding else {
        return Err(Fault::format("the header has no `format` line; export the file again").of_file());
    };
    Ok(Header { encoding, elements, body: lines.at, line: lines.number + 1 })
}

/// Lines that end in LF or CRLF, or in CR alone where the first one does.
struct HeaderLines<'a> {
    bytes: &'a [u8],
    at: usize,
    number: usize,
}

impl<'a> HeaderLines<'a> {
    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = self.bytes.get(self.at..)?;
        let end = rest.iter().position(|b| matches!(b, b'\n' | b'\r'))?;
        let (line, tail) = rest.split_at(end);
        // A CR is followed by an LF or by the next line; a binary body that begins with the byte 10 behind a lone CR
        // would be read wrongly, but nobody has written such files for decades.
        let skip = if tail.starts_with(b"\r\n") { 2 } else { 1 };
        self.at += end + skip;
        self.number += 1;
        Some(line)
    }
}
