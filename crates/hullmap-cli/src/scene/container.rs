//! A glTF file that is taken apart, changed, and put together: JSON text, and for GLB the chunks.

use std::borrow::Cow;

use hullmap_pipeline::mesh_file::glb_chunks::{self, BIN, JSON};

pub struct GltfFile<'a> {
    pub text: Cow<'a, str>,
    /// Start of a text file, before the JSON: a byte order mark, or nothing.
    mark: &'a [u8],
    /// The BIN chunk and all chunks after it; `None` for a text file.
    chunks: Option<Chunks<'a>>,
}

struct Chunks<'a> {
    buffer: Option<&'a [u8]>,
    others: Vec<(u32, &'a [u8])>,
}

impl<'a> GltfFile<'a> {
    pub fn open(bytes: &'a [u8]) -> Result<Self, String> {
        let as_text = |bytes: &'a [u8]| {
            std::str::from_utf8(bytes).map(Cow::Borrowed).map_err(|_| "its text is not UTF-8".to_owned())
        };
        if !glb_chunks::is_glb(bytes) {
            let (mark, text) = match bytes.strip_prefix(b"\xEF\xBB\xBF") {
                Some(text) => bytes.split_at(bytes.len() - text.len()),
                None => (&b""[..], bytes),
            };
            return Ok(Self { text: as_text(text)?, mark, chunks: None });
        }
        let (mut text, mut buffer, mut others) = (None, None, Vec::new());
        for (kind, chunk) in glb_chunks::read(bytes)? {
            match kind {
                JSON if text.is_none() => text = Some(chunk),
                BIN if buffer.is_none() => buffer = Some(chunk),
                _ => others.push((kind, chunk)),
            }
        }
        let text = as_text(text.ok_or("it has no JSON chunk")?)?;
        Ok(Self { text, mark: b"", chunks: Some(Chunks { buffer, others }) })
    }

    pub fn empty() -> Self {
        let text = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{}]}"#;
        Self { text: Cow::Borrowed(text), mark: b"", chunks: Some(Chunks { buffer: None, others: Vec::new() }) }
    }

    pub fn is_glb(&self) -> bool {
        self.chunks.is_some()
    }

    /// The BIN chunk, which is the first buffer.
    pub fn buffer(&self) -> Option<&'a [u8]> {
        self.chunks.as_ref().and_then(|chunks| chunks.buffer)
    }

    /// The file with another text, and `added` at the end of the BIN chunk, which text files lack.
    pub fn with(&self, text: String, added: &[u8]) -> Result<Vec<u8>, String> {
        let Some(Chunks { buffer, others }) = &self.chunks else {
            return Ok([self.mark, text.as_bytes()].concat());
        };
        let mut chunks = vec![(JSON, text.trim_end().as_bytes().to_vec())];
        if buffer.is_some() || !added.is_empty() {
            chunks.push((BIN, [buffer.unwrap_or_default(), added].concat()));
        }
        chunks.extend(others.iter().map(|&(kind, chunk)| (kind, chunk.to_vec())));
        glb_chunks::write(chunks)
    }
}
