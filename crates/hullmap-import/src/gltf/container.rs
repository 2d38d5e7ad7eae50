//! glTF 2.0: the container, JSON text or a GLB file, and the locations of buffers.

use std::borrow::Cow;

use super::document::{BufferView, Document, Meshopt};
use super::extensions::{may_be_required, remedy};
use super::version_1::is_version_1;
use crate::fault::{Fault, LineFault, counted, excerpt};

/// Bytes of the header of a GLB file, and of a chunk.
const GLB_HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// Cesium's gltf-pipeline upgrades every file that it reads.
const VERSION_1: &str = "the file is glTF 1.0, which is not supported; expected glTF 2.0: export it again, or convert it with `gltf-pipeline -i IN -o OUT` (npm install --global gltf-pipeline)";

#[derive(Debug)]
pub struct Container<'a> {
    pub document: Document<'a>,
    pub buffer: Option<&'a [u8]>,
}

impl Container<'_> {
    /// The compressed data of a view and the name of its extension, if the file does not have the
    /// view uncompressed. The buffer of a missing fallback is a placeholder without bytes.
    pub fn compression<'a>(&self, view: &'a BufferView) -> Option<(&'static str, &'a Meshopt)> {
        let fallback = self.document.buffers.get(view.buffer as usize);
        // Only the first buffer can be the BIN chunk.
        let is_chunk = view.buffer == 0 && self.buffer.is_some();
        let has_fallback = is_chunk || fallback.is_some_and(|buffer| buffer.uri.is_some());
        view.extensions.compression().filter(|_| !has_fallback)
    }
}

/// Fails if the container is damaged, the text is not glTF 2.0, or the file requires an unsupported
/// extension.
pub fn open(bytes: &[u8]) -> Result<Container<'_>, LineFault> {
    let fault = |text: String| Err(LineFault::of_file(text));
    let (text, buffer) = if bytes.starts_with(b"glTF") { chunks(bytes)? } else { (bytes, None) };
    if text.iter().all(u8::is_ascii_whitespace) {
        return fault("the file is empty; expected glTF: export it again".to_owned());
    }
    let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
    if !text.trim_ascii_start().starts_with(b"{") {
        return fault(
            "not a glTF document: expected `{`, or `glTF` as in GLB, at the start; the file is damaged or in another \
             format: export it again"
                .to_owned(),
        );
    }
    let document: Document = match serde_json::from_slice(text) {
        Ok(document) => document,
        Err(_) if is_version_1(text) => return fault(VERSION_1.to_owned()),
        Err(error) if buffer.is_none() && error.line() > 1 => {
            return Err(Fault::format(not_a_document(&error)).at_line(error.line()));
        }
        Err(error) => return fault(not_a_document(&error)),
    };
    if !document.asset.version.starts_with("2.") {
        let version = excerpt(&document.asset.version);
        return match version.as_str() {
            "1.0" | "1.0.1" => fault(VERSION_1.to_owned()),
            _ => fault(format!("the file is glTF {version}; expected glTF 2.0: export it as that")),
        };
    }
    if let Some(extension) = document.extensions_required.iter().find(|name| !may_be_required(name)) {
        return fault(format!(
            "the file requires the extension {}, which is not supported; {}",
            excerpt(extension),
            remedy(extension)
        ));
    }
    Ok(Container { document, buffer })
}

/// Serde quotes values of any length, and names the structs of this program: a list in place of an
/// object is "invalid length 0, expected struct Asset with 1 element at line 1".
fn not_a_document(error: &serde_json::Error) -> String {
    let text = error.to_string();
    let text = match text.rsplit_once(", expected ") {
        Some((found, wanted)) => {
            let is_struct = wanted.starts_with("struct ");
            let is_list = is_struct && found.starts_with("invalid length");
            let found = if is_list { "invalid type: a list".to_owned() } else { excerpt(found) };
            let place = wanted.find(" at line").and_then(|at| wanted.get(at..)).unwrap_or_default();
            let wanted = if is_struct { format!("an object{place}") } else { wanted.to_owned() };
            format!("{found}, expected {wanted}")
        }
        None => text,
    };
    format!("not a glTF document: {text}; export it again")
}

fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), LineFault> {
    let fault = |text: String| Err(LineFault::of_file(text));
    let word = |at: usize| bytes.get(at..)?.first_chunk().map(|bytes| u32::from_le_bytes(*bytes));
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return fault("the GLB header is incomplete: the file was cut off; export it again".to_owned());
    };
    if version != 2 {
        return fault(match version {
            1 => VERSION_1.to_owned(),
            _ => format!("the file is GLB version {version}; expected version 2: export it as that"),
        });
    }
    let Some(within) = bytes.get(..(length as usize).max(GLB_HEADER)) else {
        let have = bytes.len();
        return fault(format!(
            "the GLB header claims {}, but the file has {have}: it was cut off; export it again",
            counted(length, "byte", "bytes")
        ));
    };
    let bytes = within;
    let (mut text, mut buffer) = (None, None);
    let mut at = GLB_HEADER;
    while let (Some(length), Some(kind)) = (word(at), word(at + 4)) {
        let start = at + CHUNK_HEADER;
        let Some(chunk) = bytes.get(start..).and_then(|rest| rest.get(..length as usize)) else {
            return fault(format!(
                "a GLB chunk claims {}, but {} left: the file was cut off; export it again",
                counted(length, "byte", "bytes"),
                counted(bytes.len().saturating_sub(start), "is", "are")
            ));
        };
        match &kind.to_le_bytes() {
            b"JSON" => text = text.or(Some(chunk)),
            b"BIN\0" => buffer = buffer.or(Some(chunk)),
            // The specification requires other chunks to be ignored.
            _ => {}
        }
        at = start + chunk.len();
    }
    match text {
        Some(text) => Ok((text, buffer)),
        None => fault("the GLB file has no JSON chunk; export it again".to_owned()),
    }
}

#[derive(Debug, PartialEq)]
pub enum BufferLocation<'a> {
    Chunk,
    /// In the text, as base64.
    Data(&'a str),
    /// In a file beside this one, with its path relative to this one.
    Beside(Cow<'a, str>),
}

impl BufferLocation<'_> {
    /// Fails if the URI is neither data nor a relative path below the file's folder.
    pub fn from_uri(uri: Option<&str>) -> Result<BufferLocation<'_>, String> {
        let Some(uri) = uri else {
            return Ok(BufferLocation::Chunk);
        };
        if let Some(data) = uri.strip_prefix("data:") {
            let (kind, data) = data.split_once(',').ok_or("a data URI without data")?;
            if !kind.ends_with(";base64") {
                return Err(format!("a data URI of type `{}`; expected base64", excerpt(kind)));
            }
            return Ok(BufferLocation::Data(data));
        }
        let path = unescape(uri).ok_or_else(|| format!("the URI `{}`, which is not UTF-8", excerpt(uri)))?;
        let is_below = !path.is_empty()
            && !path.starts_with(['/', '\\'])
            && !path.contains(':')
            && path.split(['/', '\\']).all(|step| step != "..");
        if !is_below {
            return Err(format!(
                "the URI `{}`; expected a file in the same folder or below it: copy it there",
                excerpt(uri)
            ));
        }
        Ok(BufferLocation::Beside(path))
    }
}

/// Resolves percent-encoding such as `%20`.
fn unescape(uri: &str) -> Option<Cow<'_, str>> {
    if !uri.contains('%') {
        return Some(Cow::Borrowed(uri));
    }
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    let digit = |byte: u8| char::from(byte).to_digit(16);
    while let [first, tail @ ..] = rest {
        if let (b'%', [high, low, after @ ..]) = (first, tail)
            && let (Some(high), Some(low)) = (digit(*high), digit(*low))
        {
            bytes.push((16 * high + low) as u8);
            rest = after;
        } else {
            bytes.push(*first);
            rest = tail;
        }
    }
    String::from_utf8(bytes).ok().map(Cow::Owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buffers_must_lie_in_the_file_or_below_its_folder() {
        assert_eq!(BufferLocation::from_uri(None), Ok(BufferLocation::Chunk));
        assert_eq!(
            BufferLocation::from_uri(Some("data:application/octet-stream;base64,AAAA")),
            Ok(BufferLocation::Data("AAAA"))
        );
        assert_eq!(BufferLocation::from_uri(Some("a%20b/c.bin")), Ok(BufferLocation::Beside("a b/c.bin".into())));
        assert_eq!(BufferLocation::from_uri(Some("100%.bin")), Ok(BufferLocation::Beside("100%.bin".into())));
        for uri in
            ["", "/etc/x", "../x.bin", "a/../../x.bin", "%2e%2e/x", "https://host/x", "C:\\x", "data:text,a", "data:"]
        {
            assert!(BufferLocation::from_uri(Some(uri)).is_err(), "{uri}");
        }
    }
}
