//! The outermost layer of glTF: a text, or a GLB file of a text and a buffer; and where buffers lie.

use std::borrow::Cow;

use super::document::Document;
use crate::fault::{Fault, LineFault, excerpt};

/// Bytes of a GLB file's header, and of a chunk's.
const GLB_HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// A document, and the buffer that a GLB file carries.
#[derive(Debug)]
pub struct Container<'a> {
    /// The text, parsed.
    pub document: Document<'a>,
    /// The BIN chunk.
    pub buffer: Option<&'a [u8]>,
}

/// Opens a glTF text or a GLB file, told apart by their first bytes.
///
/// # Errors
/// A damaged container, a text that is no glTF 2.0, or an extension without which the geometry cannot be read.
pub fn open(bytes: &[u8]) -> Result<Container<'_>, LineFault> {
    let fault = |text: String| Err(Fault::format(text).of_file());
    let (text, buffer) = if bytes.starts_with(b"glTF") { chunks(bytes)? } else { (bytes, None) };
    if text.iter().all(u8::is_ascii_whitespace) {
        return fault("the file is empty; expected glTF: export it again".to_owned());
    }
    let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
    if !text.trim_ascii_start().starts_with(b"{") {
        return fault(
            "no glTF document: it starts neither with `glTF`, as GLB does, nor with `{`; was it damaged, or is it another \
             format? Export it again"
                .to_owned(),
        );
    }
    let document: Document = match serde_json::from_slice(text) {
        Ok(document) => document,
        Err(error) if buffer.is_none() && error.line() > 1 => {
            return Err(Fault::format(format!("no glTF document: {error}; export it again")).at(error.line()));
        }
        Err(error) => return fault(format!("no glTF document: {error}; export it again")),
    };
    if !document.asset.version.starts_with("2.") {
        let version = excerpt(&document.asset.version);
        return fault(format!("glTF version {version}; expected 2.0: export it again with a newer exporter"));
    }
    if let Some(extension) = document.extensions_required.iter().find(|name| !leaves_geometry_alone(name)) {
        return fault(format!(
            "the file requires the extension {}, which is not read here; {}",
            excerpt(extension),
            remedy(extension)
        ));
    }
    Ok(Container { document, buffer })
}

/// Whether geometry reads the same without this extension, or it is one that is read.
fn leaves_geometry_alone(extension: &str) -> bool {
    ["KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_", "EXT_lights_", "KHR_xmp"]
        .iter()
        .any(|prefix| extension.starts_with(prefix))
        || [
            "KHR_mesh_quantization",
            "KHR_animation_pointer",
            "MSFT_packing_normalRoughnessMetallic",
            "KHR_audio_emitter",
        ]
        .contains(&extension)
}

/// What to do about an extension that is not read.
pub fn remedy(extension: &str) -> &'static str {
    match extension {
        "KHR_draco_mesh_compression" | "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "export it without mesh compression"
        }
        "EXT_mesh_gpu_instancing" => "export the instances as nodes",
        _ => "export it without",
    }
}

fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), LineFault> {
    let fault = |text: String| Err(Fault::format(text).of_file());
    let word = |at: usize| bytes.get(at..)?.first_chunk().map(|bytes| u32::from_le_bytes(*bytes));
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return fault("the GLB header is not whole: the file was cut off; export it again".to_owned());
    };
    if version != 2 {
        return fault(format!("GLB version {version}; expected 2: export it again with a newer exporter"));
    }
    let Some(within) = bytes.get(..(length as usize).max(GLB_HEADER)) else {
        let have = bytes.len();
        return fault(format!(
            "the GLB header claims {length} bytes, the file has {have}: it was cut off; export it again"
        ));
    };
    let bytes = within;
    let (mut text, mut buffer) = (None, None);
    let mut at = GLB_HEADER;
    while let (Some(length), Some(kind)) = (word(at), word(at + 4)) {
        let start = at + CHUNK_HEADER;
        let Some(chunk) = bytes.get(start..).and_then(|rest| rest.get(..length as usize)) else {
            return fault(format!(
                "a GLB chunk claims {length} bytes, where {} are left: the file was cut off; export it again",
                bytes.len().saturating_sub(start)
            ));
        };
        match &kind.to_le_bytes() {
            b"JSON" => text = text.or(Some(chunk)),
            b"BIN\0" => buffer = buffer.or(Some(chunk)),
            // Others are extensions, to be passed over.
            _ => {}
        }
        at = start + chunk.len();
    }
    match text {
        Some(text) => Ok((text, buffer)),
        None => fault("the GLB file has no JSON chunk; export it again".to_owned()),
    }
}

/// Where a buffer's bytes are.
#[derive(Debug, PartialEq)]
pub enum Place<'a> {
    /// In the GLB file itself.
    Chunk,
    /// In the text, in base64.
    Data(&'a str),
    /// In a file beside this one, by its path relative to it.
    Beside(Cow<'a, str>),
}

impl Place<'_> {
    /// Where the buffer with this URI is.
    ///
    /// # Errors
    /// A URI that is neither data nor a relative path that stays below the file's folder.
    pub fn of(uri: Option<&str>) -> Result<Place<'_>, String> {
        let Some(uri) = uri else {
            return Ok(Place::Chunk);
        };
        if let Some(data) = uri.strip_prefix("data:") {
            let (kind, data) = data.split_once(',').ok_or("a data URI without data")?;
            if !kind.ends_with(";base64") {
                return Err(format!("a data URI of the kind `{}`, where base64 is expected", excerpt(kind)));
            }
            return Ok(Place::Data(data));
        }
        let path = unescape(uri).ok_or_else(|| format!("the URI `{}`, which is not UTF-8", excerpt(uri)))?;
        let is_below = !path.is_empty()
            && !path.starts_with(['/', '\\'])
            && !path.contains(':')
            && path.split(['/', '\\']).all(|step| step != "..");
        if !is_below {
            return Err(format!(
                "the URI `{}`; expected a file beside this one, or below its folder: copy it there",
                excerpt(uri)
            ));
        }
        Ok(Place::Beside(path))
    }
}

/// Resolves `%20` and the like.
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
    fn buffers_lie_in_the_file_or_below_its_folder() {
        assert_eq!(Place::of(None), Ok(Place::Chunk));
        assert_eq!(Place::of(Some("data:application/octet-stream;base64,AAAA")), Ok(Place::Data("AAAA")));
        assert_eq!(Place::of(Some("a%20b/c.bin")), Ok(Place::Beside("a b/c.bin".into())));
        assert_eq!(Place::of(Some("100%.bin")), Ok(Place::Beside("100%.bin".into())));
        for uri in
            ["", "/etc/x", "../x.bin", "a/../../x.bin", "%2e%2e/x", "https://host/x", "C:\\x", "data:text,a", "data:"]
        {
            assert!(Place::of(Some(uri)).is_err(), "{uri}");
        }
    }
}
