//! One XML file: its bytes, their encoding, and edits that keep every other byte.
//!
//! The text is decoded, parsed and edited as UTF-8. An edit is written back in the encoding of the
//! file; bytes outside of edits are copied from the file.

use std::borrow::Cow;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use crate::edit::{Edit, in_order};
use crate::error::RobotError;
use crate::lenient::{MAX_DEPTH, TooDeep, prepared, without_prefix};

/// Maximum size of a file in bytes. The largest public descriptions have some megabytes.
const MAX_BYTES: u64 = 64 << 20;

/// Maximum number of nodes: with about 100 bytes a node, 100 MB.
const MAX_NODES: u32 = 1_000_000;

const MAX_PREFIXES: usize = 32;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Utf8,
    /// ISO 8859-1: each byte is a character.
    Latin1,
    Utf16Le,
    Utf16Be,
}

/// One file.
#[derive(Clone, Debug)]
pub struct Document {
    path: PathBuf,
    bytes: Vec<u8>,
    encoding: Encoding,
    mark: usize,
    /// Decoded, without the mark.
    text: String,
    /// The parser's text, of the same length, if it differs.
    prepared: Option<String>,
}

impl Document {
    /// Reads a regular file.
    ///
    /// # Errors
    /// It cannot be read, is too large, is not a regular file, or has an unknown encoding.
    pub fn read(path: &Path) -> Result<Self, RobotError> {
        let unreadable =
            |error: std::io::Error| RobotError::unreadable(path, format!("cannot read: {error}; check the path"));
        // A pipe would block.
        let kind = std::fs::metadata(path).map_err(unreadable)?;
        if !kind.is_file() {
            return Err(RobotError::unreadable(path, "is not a regular file; name a robot description"));
        }
        let mut bytes = Vec::new();
        File::open(path).and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes)).map_err(unreadable)?;
        if bytes.len() as u64 > MAX_BYTES {
            let message = format!("has more than {MAX_BYTES} bytes; a description that large is not supported");
            return Err(RobotError::rejected(path, None, message));
        }
        Self::from_bytes(path, bytes)
    }

    /// A file with this content.
    ///
    /// # Errors
    /// It has an unknown encoding, or elements are nested too deeply.
    pub fn from_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self, RobotError> {
        let (encoding, mark) = match bytes.as_slice() {
            [0xef, 0xbb, 0xbf, ..] => (Encoding::Utf8, 3),
            [0xff, 0xfe, ..] => (Encoding::Utf16Le, 2),
            [0xfe, 0xff, ..] => (Encoding::Utf16Be, 2),
            _ => (declared(&bytes), 0),
        };
        let text = decoded(&bytes[mark..], encoding).ok_or_else(|| {
            let message = "the text is not UTF-8, ISO-8859-1 or UTF-16 with a byte order mark; save it as UTF-8";
            RobotError::rejected(path, None, message)
        })?;
        let too_deep = |at: usize| {
            let message = format!("elements are nested deeper than {MAX_DEPTH}; this is not a robot description");
            RobotError::rejected(path, Some(line_of(&text, at)), message)
        };
        let prepared = match prepared(&text) {
            Err(TooDeep(at)) => return Err(too_deep(at)),
            Ok(Cow::Borrowed(_)) => None,
            Ok(Cow::Owned(changed)) => Some(changed),
        };
        let mut document = Self { path: path.to_owned(), bytes, encoding, mark, text, prepared };
        document.mask_prefixes();
        Ok(document)
    }

    /// Replaces prefixes that have no namespace. Other faults are reported by [`Self::parse`].
    fn mask_prefixes(&mut self) {
        for _ in 0..MAX_PREFIXES {
            let prefix = match roxmltree::Document::parse_with_options(self.parsed_text(), options()) {
                Err(roxmltree::Error::UnknownNamespace(prefix, _)) => prefix,
                _ => return,
            };
            let masked = without_prefix(self.parsed_text(), &prefix);
            if masked == self.parsed_text() {
                return;
            }
            self.prepared = Some(masked);
        }
    }

    fn parsed_text(&self) -> &str {
        self.prepared.as_deref().unwrap_or(&self.text)
    }

    /// The file's path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The decoded text. Spans refer to it.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The bytes of the file.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The tree of elements, with their spans in [`Self::text`].
    ///
    /// # Errors
    /// The text is not well-formed, has a document type definition, or has too many nodes.
    pub fn parse(&self) -> Result<roxmltree::Document<'_>, RobotError> {
        roxmltree::Document::parse_with_options(self.parsed_text(), options()).map_err(|error| {
            let position = error.pos().row;
            let message = match error {
                roxmltree::Error::DtdDetected => {
                    "document type definitions are not read, since entities can expand without bound; remove <!DOCTYPE>"
                        .to_owned()
                }
                roxmltree::Error::NodesLimitReached => {
                    format!("has more than {MAX_NODES} nodes; this is not a robot description")
                }
                error => format!("invalid XML: {error}; name a URDF, MJCF or SDF file, or correct this one"),
            };
            RobotError::rejected(&self.path, Some(position), message)
        })
    }

    /// The line of a place, from 1.
    pub fn line(&self, at: usize) -> u32 {
        line_of(&self.text, at)
    }

    /// An error about a place.
    pub fn error(&self, at: usize, message: impl Into<String>) -> RobotError {
        RobotError::rejected(&self.path, Some(self.line(at)), message)
    }

    /// The bytes of the edited file.
    ///
    /// # Errors
    /// The encoding cannot express a character of an edit.
    pub fn edited(&self, edits: Vec<Edit>) -> Result<Vec<u8>, RobotError> {
        let mut result = self.bytes[..self.mark].to_vec();
        let (mut at, mut byte) = (0, self.mark);
        for edit in in_order(edits) {
            let end = byte + encoded_len(&self.text[at..edit.span.start], self.encoding);
            result.extend_from_slice(&self.bytes[byte..end]);
            let text = encoded(&edit.text, self.encoding).ok_or_else(|| {
                self.error(
                    edit.span.start,
                    "a name is not in ISO-8859-1, the encoding of the file; save the file as UTF-8",
                )
            })?;
            result.extend(text);
            byte = end + encoded_len(&self.text[edit.span.clone()], self.encoding);
            at = edit.span.end;
        }
        result.extend_from_slice(&self.bytes[byte..]);
        Ok(result)
    }
}

fn options<'input>() -> roxmltree::ParsingOptions<'input> {
    roxmltree::ParsingOptions { allow_dtd: false, nodes_limit: MAX_NODES, ..roxmltree::ParsingOptions::default() }
}

fn line_of(text: &str, at: usize) -> u32 {
    1 + text.as_bytes()[..at.min(text.len())].iter().filter(|&&byte| byte == b'\n').count() as u32
}

/// Encoding by the XML declaration, unless the text is UTF-8.
fn declared(bytes: &[u8]) -> Encoding {
    let head = &bytes[..bytes.len().min(200)];
    let head = String::from_utf8_lossy(head).to_lowercase();
    let declaration = head.trim_start().strip_prefix("<?xml").and_then(|rest| rest.split_once("?>"));
    let is_latin = declaration.is_some_and(|(declaration, _)| {
        ["iso-8859-1", "latin1", "windows-1252", "us-ascii"].iter().any(|name| declaration.contains(name))
    });
    if is_latin && std::str::from_utf8(bytes).is_err() { Encoding::Latin1 } else { Encoding::Utf8 }
}

fn decoded(bytes: &[u8], encoding: Encoding) -> Option<String> {
    let units = |unit: fn([u8; 2]) -> u16| -> Option<String> {
        let (pairs, rest) = bytes.as_chunks::<2>();
        let decoded = String::from_utf16(&pairs.iter().map(|pair| unit(*pair)).collect::<Vec<u16>>());
        decoded.ok().filter(|_| rest.is_empty())
    };
    match encoding {
        Encoding::Utf8 => std::str::from_utf8(bytes).ok().map(str::to_owned),
        Encoding::Latin1 => Some(bytes.iter().map(|&byte| char::from(byte)).collect()),
        Encoding::Utf16Le => units(u16::from_le_bytes),
        Encoding::Utf16Be => units(u16::from_be_bytes),
    }
}

/// `None` if a character does not exist in the encoding.
fn encoded(text: &str, encoding: Encoding) -> Option<Vec<u8>> {
    match encoding {
        Encoding::Utf8 => Some(text.as_bytes().to_vec()),
        Encoding::Latin1 => text.chars().map(|letter| u8::try_from(u32::from(letter)).ok()).collect(),
        Encoding::Utf16Le => Some(text.encode_utf16().flat_map(u16::to_le_bytes).collect()),
        Encoding::Utf16Be => Some(text.encode_utf16().flat_map(u16::to_be_bytes).collect()),
    }
}

fn encoded_len(text: &str, encoding: Encoding) -> usize {
    match encoding {
        Encoding::Utf8 => text.len(),
        Encoding::Latin1 => text.chars().count(),
        Encoding::Utf16Le | Encoding::Utf16Be => 2 * text.encode_utf16().count(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document(bytes: &[u8]) -> Result<Document, RobotError> {
        Document::from_bytes(Path::new("r.urdf"), bytes.to_vec())
    }

    #[test]
    fn bytes_outside_of_edits_are_those_of_the_file() {
        let text = "<robot name=\"Zürich\">\r\n<link name='a'/></robot>\r\n";
        let utf16 = |unit: fn(u16) -> [u8; 2], mark: u16| -> Vec<u8> {
            std::iter::once(mark).chain(text.encode_utf16()).flat_map(unit).collect()
        };
        let declared = format!("<?xml version='1.0' encoding='ISO-8859-1'?>{text}");
        for bytes in [
            text.as_bytes().to_vec(),
            [b"\xef\xbb\xbf", text.as_bytes()].concat(),
            utf16(u16::to_le_bytes, 0xfeff),
            utf16(u16::to_be_bytes, 0xfeff),
            declared.chars().map(|letter| letter as u8).collect(),
        ] {
            let document = document(&bytes).unwrap();
            assert_eq!(document.edited(Vec::new()).unwrap(), bytes);
            let at = document.text().find("'a'").unwrap() + 1;
            let changed = document.edited(vec![Edit::replace(at..at + 1, "bc")]).unwrap();
            let back = Document::from_bytes(Path::new("r.urdf"), changed).unwrap();
            assert_eq!(back.text(), document.text().replace("'a'", "'bc'"));
            assert_eq!(back.parse().unwrap().root_element().attribute("name"), Some("Zürich"));
        }
    }

    #[test]
    fn bad_texts_are_errors_with_lines() {
        for (text, expected) in [
            (&b"<robot>\n<link></robot>"[..], "r.urdf:2: invalid XML: "),
            (b"<!DOCTYPE a [<!ENTITY x \"y\">]>\n<a>&x;</a>", "remove <!DOCTYPE>"),
            (b"\x80\x81", "save it as UTF-8"),
            (b"", "invalid XML"),
        ] {
            let error = document(text).and_then(|document| document.parse().map(drop)).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
        let nested = "<a>\n".repeat(2_500_000);
        let error = document(nested.as_bytes()).unwrap_err().to_string();
        assert!(error.starts_with("r.urdf:1001: elements are nested deeper than 1000"), "{error}");
        let many = format!("<a>{}</a>", "<b/>".repeat(2_500_000));
        let error = document(many.as_bytes()).unwrap().parse().unwrap_err().to_string();
        assert!(error.contains("has more than 1000000 nodes"), "{error}");
    }

    #[test]
    fn prefixes_need_no_namespace() {
        let document = document(b"<robot><sensor:camera><x:y z:w='1'/></sensor:camera></robot>").unwrap();
        assert_eq!(document.parse().unwrap().descendants().filter(|node| node.is_element()).count(), 3);
        assert!(document.text().contains("sensor:camera"));
    }
}
