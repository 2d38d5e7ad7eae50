//! PLY: the header, which lists the elements of the file and their properties.

use crate::fault::{Fault, LineFault, counted, excerpt};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    Text,
    Little,
    Big,
}

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
    fn from_name(word: &str) -> Option<Self> {
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

    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Property {
    pub name: String,
    pub scalar: Scalar,
    /// Type of the length, if the property is a list.
    pub length: Option<Scalar>,
}

/// An element declaration: a record type and its number of instances.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Element {
    pub name: String,
    /// Number of instances that the header claims.
    pub count: u64,
    pub properties: Vec<Property>,
}

impl Element {
    /// Minimum bytes of an instance, with empty lists. A number in text takes a digit and a
    /// separator.
    pub fn minimum_size(&self, encoding: Encoding) -> u64 {
        let size = |property: &Property| match encoding {
            Encoding::Text => 2,
            _ => property.length.unwrap_or(property.scalar).size() as u64,
        };
        self.properties.iter().map(size).sum()
    }

    /// Size of an instance in bytes, if all instances have the same.
    pub fn fixed_size(&self) -> Option<usize> {
        self.properties.iter().map(|p| p.length.is_none().then_some(p.scalar.size())).sum()
    }

    pub fn find(&self, names: &[&str]) -> Option<usize> {
        self.properties.iter().position(|property| names.contains(&property.name.as_str()))
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Offset of the body in the file.
    pub body: usize,
    /// One-based number of the line at which the body starts.
    pub line: usize,
    /// Note about lines with an unknown keyword, which are skipped.
    pub note: Option<String>,
}

/// Skips lines with an unknown keyword, as other readers do: some exporters write a remark without
/// `comment`.
pub fn read(bytes: &[u8]) -> Result<Header, LineFault> {
    let mut lines = HeaderLines { bytes, at: 0, number: 0 };
    if lines.next() != Some(b"ply") {
        return Err(Fault::format("the first line is not `ply`; check that this is a PLY file").at_line(1));
    }
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let (mut unknown_count, mut first_unknown) = (0, None);
    loop {
        let Some(line) = lines.next() else {
            return Err(LineFault::of_file("the header has no `end_header`: the file was cut off; export it again"));
        };
        let number = lines.number;
        let text = String::from_utf8_lossy(line);
        let wrong = |expected: &str| {
            Fault::format(format!("found `{}`; expected {expected}: correct the line", excerpt(&text))).at_line(number)
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
            ["element", name, instances] => {
                let count = instances.parse().map_err(|_| wrong("`element <name> <count>`"))?;
                elements.push(Element { name: (*name).to_owned(), count, properties: Vec::new() });
            }
            ["property", kind @ .., name] => {
                let types: Option<Vec<Scalar>> =
                    kind.iter().filter(|w| **w != "list").map(|w| Scalar::from_name(w)).collect();
                let (scalar, length) = match (kind.first(), types.as_deref()) {
                    (Some(&"list"), Some(&[length, scalar])) if length.is_integer() => (scalar, Some(length)),
                    (_, Some(&[scalar])) if kind.len() == 1 => (scalar, None),
                    _ => return Err(wrong("`property <type> <name>` or `property list <type> <type> <name>`")),
                };
                let Some(element) = elements.last_mut() else {
                    return Err(wrong("an `element` before its properties"));
                };
                element.properties.push(Property { name: (*name).to_owned(), scalar, length });
            }
            ["end_header"] => break,
            ["format" | "element" | "property" | "end_header", ..] => {
                return Err(wrong(
                    "`format <encoding> 1.0`, `element <name> <count>`, `property <type> <name>` or `end_header`",
                ));
            }
            _ => {
                unknown_count += 1;
                first_unknown.get_or_insert_with(|| format!("line {number}: `{}`", excerpt(&text)));
            }
        }
    }
    let Some(encoding) = encoding else {
        return Err(LineFault::of_file("the header has no `format` line; export the file again"));
    };
    let note = first_unknown.map(|first| {
        format!("{first}: {} with an unknown keyword, skipped", counted(unknown_count, "header line", "header lines"))
    });
    Ok(Header { encoding, elements, body: lines.at, line: lines.number + 1, note })
}

/// Lines of a header. A line ends with LF, CRLF or a lone CR.
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
        // An LF behind a CR belongs to the same line ending. A binary body that starts with 10
        // behind a lone CR would be misread, but no current exporter ends lines so.
        let skip = if tail.starts_with(b"\r\n") { 2 } else { 1 };
        self.at += end + skip;
        self.number += 1;
        Some(line)
    }
}
