//! A glTF file with all its buffers: JSON with its data beside or within it, or both in a `.glb`
//! (glTF 2.0, section 4).

use super::document::{BufferView, Document, MEND, named};
use super::uri;
use crate::error::Fault;
use std::path::Path;

const MAGIC: &[u8; 4] = b"glTF";
const JSON: &[u8; 4] = b"JSON";
const BINARY: &[u8; 4] = b"BIN\0";

/// A document and the bytes of its buffers.
pub(super) struct Container {
    pub(super) document: Document,
    buffers: Vec<Vec<u8>>,
}

impl Container {
    /// The content of a file in `folder`.
    pub(super) fn read(bytes: &[u8], folder: &Path) -> Result<Self, Fault> {
        let (json, binary) = if bytes.starts_with(MAGIC) { chunks(bytes)? } else { (bytes, None) };
        let document = Document::parse(json)?;
        let buffers = (0..document.buffers.len())
            .map(|index| buffer(&document, index, binary, folder))
            .collect::<Result<_, _>>()?;
        Ok(Self { document, buffers })
    }

    /// Bytes in all buffers.
    pub(super) fn buffer_bytes(&self) -> u64 {
        self.buffers.iter().map(|buffer| buffer.len() as u64).sum()
    }

    /// A view of a buffer and its bytes; `owner` names it.
    pub(super) fn view(&self, index: usize, owner: &str) -> Result<(&BufferView, &[u8]), Fault> {
        let view = named(&self.document.buffer_views, "bufferViews", index, owner)?;
        let own = format!("bufferViews[{index}]");
        let buffer = named(&self.buffers, "buffers", view.buffer, &own)?;
        let end = view.byte_offset.checked_add(view.byte_length);
        let bytes = end.and_then(|end| {
            let (start, end) = (view.byte_offset.try_into().ok()?, end.try_into().ok()?);
            buffer.get::<std::ops::Range<usize>>(start..end)
        });
        let bytes = bytes.ok_or_else(|| {
            let what = format!(
                "{own} is {} bytes from {} on of buffers[{}], which has {}",
                view.byte_length,
                view.byte_offset,
                view.buffer,
                buffer.len()
            );
            Fault::whole(what, MEND)
        })?;
        Ok((view, bytes))
    }
}

/// The kind and the content of a chunk.
type Chunk<'a> = (&'a [u8], &'a [u8]);

/// The JSON and the binary chunk of a `.glb`.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Fault> {
    let word = |bytes: &[u8], at: usize| {
        let word: Option<[u8; 4]> = bytes.get(at..at + 4).and_then(|word| word.try_into().ok());
        word.map(u32::from_le_bytes).ok_or_else(Fault::truncated)
    };
    let version = word(bytes, 4)?;
    if version != 2 {
        let what = format!("version {version} of .glb files is not known (this reads 2)");
        return Err(Fault::whole(what, "export it as glTF 2.0"));
    }
    let length = word(bytes, 8)? as usize;
    let mut rest = bytes.get(12..length).ok_or_else(Fault::truncated)?;
    let mut next = || -> Result<Option<Chunk<'_>>, Fault> {
        if rest.is_empty() {
            return Ok(None);
        }
        let length = word(rest, 0)? as usize;
        let kind = rest.get(4..8).ok_or_else(Fault::truncated)?;
        let content = rest.get(8..).and_then(|rest| rest.get(..length));
        let content = content.ok_or_else(Fault::truncated)?;
        rest = &rest[8 + length..];
        Ok(Some((kind, content)))
    };
    let json = match next()? {
        Some((kind, content)) if kind == JSON => content,
        _ => return Err(Fault::whole("its first chunk is not JSON", MEND)),
    };
    // Chunks of other kinds are passed over.
    let binary = next()?.filter(|(kind, _)| kind == BINARY).map(|(_, content)| content);
    Ok((json, binary))
}

/// The bytes of a buffer.
fn buffer(
    document: &Document,
    index: usize,
    binary: Option<&[u8]>,
    folder: &Path,
) -> Result<Vec<u8>, Fault> {
    let buffer = &document.buffers[index];
    let owner = format!("buffers[{index}]");
    let mut bytes = match (&buffer.uri, binary) {
        (Some(uri), _) => uri::read(uri, &owner, folder)?,
        (None, Some(binary)) if index == 0 => binary.to_vec(),
        (None, _) => {
            return Err(Fault::whole(format!("{owner} has no data"), "export it as a .glb file"));
        }
    };
    let length = usize::try_from(buffer.byte_length).unwrap_or(usize::MAX);
    if bytes.len() < length {
        let what = format!("{owner} claims {length} bytes, but has {}", bytes.len());
        return Err(Fault::whole(what, MEND));
    }
    bytes.truncate(length);
    Ok(bytes)
}
