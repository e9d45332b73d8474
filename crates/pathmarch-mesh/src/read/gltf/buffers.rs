//! Bytes of a glTF file: the chunks of GLB, buffers, and the views of them.

use super::super::error::Mistake;
use super::super::files::{Companions, shortened};
use super::json;
use std::sync::Arc;

/// JSON and binary chunk of a file, which is GLB or plain JSON.
pub fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Mistake> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), None));
    }
    let word = |at: usize| {
        let word: Option<[u8; 4]> = bytes.get(at..at.saturating_add(4)).and_then(|word| word.try_into().ok());
        word.map(|word| u32::from_le_bytes(word) as usize)
    };
    if word(4) != Some(2) {
        return Err(Mistake::with_remedy("byte 4", "only version 2 of GLB can be read", "export it as glTF 2.0"));
    }
    let (mut at, mut json, mut binary) = (12, None, None);
    while let (Some(length), Some(kind)) = (word(at), word(at + 4)) {
        let start = at + 8;
        let end = start.saturating_add(length);
        let chunk = bytes.get(start..end);
        let chunk = chunk.ok_or_else(|| Mistake::new(format!("byte {at}"), "a chunk is longer than the file"))?;
        match kind {
            0x4e4f_534a if json.is_none() => json = Some(chunk),
            0x004e_4942 if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        at = end;
    }
    Ok((json.ok_or_else(|| Mistake::new("byte 12", "there is no chunk of JSON"))?, binary))
}

/// Buffers, as far as they were needed.
pub struct Buffers<'a> {
    root: &'a json::Root,
    binary: Option<&'a [u8]>,
    companions: &'a Companions<'a>,
    loaded: Vec<Option<Result<Bytes<'a>, Mistake>>>,
    /// Bytes of views that were copied.
    copied: usize,
}

/// Bytes of a buffer: in the file, or of their own.
#[derive(Clone)]
enum Bytes<'a> {
    InFile(&'a [u8]),
    Own(Arc<[u8]>),
}

impl Bytes<'_> {
    fn as_slice(&self) -> &[u8] {
        match self {
            Self::InFile(bytes) => bytes,
            Self::Own(bytes) => bytes,
        }
    }
}

impl<'a> Buffers<'a> {
    pub fn new(root: &'a json::Root, binary: Option<&'a [u8]>, companions: &'a Companions) -> Self {
        Self { root, binary, companions, loaded: vec![None; root.buffers.len()], copied: 0 }
    }

    /// Bytes of a file or a data URI.
    pub fn read_uri(&self, uri: &str, place: &str) -> Result<Arc<[u8]>, Mistake> {
        if let Some(data) = uri.strip_prefix("data:") {
            let encoded = data.split_once(";base64,").map(|(_, encoded)| encoded);
            let decoded = encoded.and_then(decode_base64).map(Arc::from);
            return decoded.ok_or_else(|| Mistake::new(place, "the data URI is not base64"));
        }
        self.companions.read(&decode_percent(uri), place)
    }

    /// Loads a buffer, unless it is. Its errors are kept, so that a missing file is looked for once.
    pub fn load(&mut self, index: usize, place: &str) -> Result<(), Mistake> {
        let missing = || Mistake::new(place, format!("buffer {index} does not exist"));
        let buffer = self.root.buffers.get(index).ok_or_else(missing)?;
        if self.loaded[index].is_none() {
            self.loaded[index] = Some(self.read_buffer(index, buffer));
        }
        self.loaded[index].as_ref().map_or(Ok(()), |result| result.as_ref().map(|_| ()).map_err(Clone::clone))
    }

    fn read_buffer(&self, index: usize, buffer: &json::Buffer) -> Result<Bytes<'a>, Mistake> {
        let place = format!("buffer {index}");
        let bytes = match (&buffer.uri, self.binary) {
            (Some(uri), _) => Bytes::Own(self.read_uri(uri, &place)?),
            (None, Some(binary)) if index == 0 => Bytes::InFile(binary),
            _ => return Err(Mistake::new(place, "it names no file, and there is no binary chunk")),
        };
        let length = bytes.as_slice().len();
        if length < buffer.byte_length {
            let problem = format!("{} bytes are declared, but there are {length}", buffer.byte_length);
            return Err(Mistake::new(place, problem));
        }
        Ok(bytes)
    }

    /// Bytes of a view whose buffer is loaded, and its stride.
    pub fn view(&self, index: usize, place: &str) -> Result<(&[u8], Option<usize>), Mistake> {
        let mistake = |problem: String| Mistake::new(place, problem);
        let view = self.root.buffer_views.get(index);
        let view = view.ok_or_else(|| mistake(format!("buffer view {index} does not exist")))?;
        let buffer = self.loaded.get(view.buffer).and_then(|loaded| loaded.as_ref()?.as_ref().ok());
        let buffer = buffer.ok_or_else(|| mistake(format!("buffer {} does not exist", view.buffer)))?.as_slice();
        let end = view.byte_offset.checked_add(view.byte_length);
        let bytes = end.and_then(|end| buffer.get(view.byte_offset..end));
        let bytes = bytes.ok_or_else(|| {
            mistake(format!("buffer view {index} is beyond the {} bytes of buffer {}", buffer.len(), view.buffer))
        })?;
        Ok((bytes, view.byte_stride))
    }

    /// Loads the buffer of a view.
    pub fn load_view(&mut self, index: usize, place: &str) -> Result<(), Mistake> {
        let view = self.root.buffer_views.get(index);
        let view = view.ok_or_else(|| Mistake::new(place, format!("buffer view {index} does not exist")))?;
        self.load(view.buffer, place)
    }

    /// Copy of the bytes of a view, whose buffer is loaded if it is not. All copies together are at most as large as the buffers.
    pub fn view_bytes(&mut self, index: usize, place: &str) -> Result<Arc<[u8]>, Mistake> {
        self.load_view(index, place)?;
        let bytes: Arc<[u8]> = self.view(index, place)?.0.into();
        self.copied = self.copied.saturating_add(bytes.len());
        if self.copied > self.total_bytes() {
            return Err(Mistake::new(place, "the buffer views of images overlap"));
        }
        Ok(bytes)
    }

    /// Bytes of all buffers so far.
    pub fn total_bytes(&self) -> usize {
        self.loaded.iter().flatten().flatten().map(|bytes| bytes.as_slice().len()).sum()
    }
}

/// Decodes base64 (RFC 4648), with or without padding.
fn decode_base64(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0_u32, 0);
    for byte in text.bytes().filter(|byte| !byte.is_ascii_whitespace() && *byte != b'=') {
        let digit = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(digit);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    Some(bytes)
}

/// Decodes `%20` and the like in a URI.
fn decode_percent(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let hex = after.get(..2).and_then(|hex| u8::from_str_radix(std::str::from_utf8(hex).ok()?, 16).ok());
        match hex.filter(|_| first == b'%') {
            Some(byte) => {
                bytes.push(byte);
                rest = &after[2..];
            }
            None => {
                bytes.push(first);
                rest = after;
            }
        }
    }
    String::from_utf8(bytes).unwrap_or_else(|_| shortened(uri))
}
