//! The bytes behind a glTF document: containers, buffers and accessors, every length checked.

use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Root, buffer};

use super::error::{ImportError, excerpt};
use super::source::Source;

/// Remedy for a broken glTF file.
pub(super) const REMEDY: &str = "export the file again, as GLB if possible";

/// The parts of a glTF or GLB file.
pub(super) struct Container<'a> {
    pub json: &'a [u8],
    /// The binary chunk of a GLB file.
    pub binary: Option<&'a [u8]>,
    pub warning: Option<String>,
}

/// Takes a file apart: GLB into its chunks (glTF 2.0, section 4.4), anything else is JSON as a whole.
pub(super) fn split<'a>(source: &Source<'a>) -> Result<Container<'a>, ImportError> {
    let bytes = source.bytes;
    if !bytes.starts_with(b"glTF") {
        return Ok(Container { json: source.text(), binary: None, warning: None });
    }
    let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let header = |problem: String| source.malformed("GLB header", problem, REMEDY);
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(header(format!("the file ends after {} bytes", bytes.len())));
    };
    if version != 2 {
        return Err(header(format!("is of version {version}, only version 2 is supported")));
    }
    if length > bytes.len() {
        return Err(header(format!("{length} bytes are promised but the file has {}", bytes.len())));
    }
    let mut container = Container { json: &[], binary: None, warning: None };
    let mut at = 12;
    while at + 8 <= length {
        let place = || format!("GLB chunk at byte {at}");
        let (Some(size), Some(kind)) = (word(at), bytes.get(at + 4..at + 8)) else { break };
        let Some(chunk) = bytes[..length].get(at + 8..).and_then(|rest| rest.get(..size)) else {
            return Err(source.malformed(place(), format!("is {size} bytes long, more than the file has"), REMEDY));
        };
        match kind {
            b"JSON" if container.json.is_empty() => container.json = chunk,
            b"BIN\0" if container.binary.is_none() => container.binary = Some(chunk),
            _ => {}
        }
        at += 8 + size;
    }
    if length < bytes.len() {
        container.warning = Some(format!("{} bytes after the end of the GLB were ignored.", bytes.len() - length));
    }
    Ok(container)
}

/// The content of every buffer of a document.
pub(super) struct Buffers<'a> {
    contents: Vec<Cow<'a, [u8]>>,
    /// Whether each buffer came from a file of its own.
    external: Vec<bool>,
}

impl<'a> Buffers<'a> {
    /// Fetches all buffers of `root`: the binary chunk, data URIs, and files in the same folder.
    pub fn load(source: &Source<'a>, root: &Root, binary: Option<&'a [u8]>) -> Result<Self, ImportError> {
        let mut buffers = Self { contents: Vec::new(), external: Vec::new() };
        let mut total = source.bytes.len() as u64;
        for (i, buffer) in root.buffers.iter().enumerate() {
            source.task.check()?;
            let place = || format!("buffer {i}");
            let error = |problem: String| source.malformed(place(), problem, REMEDY);
            let uri = buffer.uri.as_deref();
            let content: Cow<[u8]> = match uri {
                Some(uri) if uri.starts_with("data:") => Cow::Owned(decode(uri).map_err(error)?),
                Some(uri) => Cow::Owned(read_beside(source, uri, &place(), total)?),
                None => Cow::Borrowed(binary.filter(|_| i == 0).ok_or_else(|| error("has no content".to_owned()))?),
            };
            let external = uri.is_some_and(|uri| !uri.starts_with("data:"));
            total += if external { content.len() as u64 } else { 0 };
            if (content.len() as u64) < buffer.byte_length.0 {
                let problem = format!("has {} bytes where {} are promised", content.len(), buffer.byte_length.0);
                return Err(error(problem));
            }
            buffers.contents.push(content);
            buffers.external.push(external);
        }
        Ok(buffers)
    }

    /// The contents that came from files of their own, in order.
    pub fn into_attachments(self) -> Vec<Vec<u8>> {
        let both = self.contents.into_iter().zip(self.external);
        both.filter(|(_, external)| *external).map(|(content, _)| content.into_owned()).collect()
    }

    /// The elements of accessor `index`, which must be points (`Vec3` of `f32`) or indices (`Scalar`, unsigned).
    pub fn elements<'b>(
        &'b self,
        source: &Source,
        root: &Root,
        index: usize,
        kind: Type,
    ) -> Result<Elements<'b>, ImportError> {
        let error = |problem: &str| source.malformed(format!("accessor {index}"), problem, REMEDY);
        let accessor = root.accessors.get(index).ok_or_else(|| error("does not exist but is referred to"))?;
        let component = match (accessor.component_type, kind) {
            (Checked::Valid(c), Type::Vec3) if c.0 == ComponentType::F32 => 4,
            (Checked::Valid(c), Type::Scalar) if c.0 == ComponentType::U8 => 1,
            (Checked::Valid(c), Type::Scalar) if c.0 == ComponentType::U16 => 2,
            (Checked::Valid(c), Type::Scalar) if c.0 == ComponentType::U32 => 4,
            _ => return Err(error("has components of a type that positions or indices cannot have")),
        };
        if accessor.type_ != Checked::Valid(kind) {
            return Err(error("is of a shape that positions or indices cannot have"));
        }
        if accessor.sparse.is_some() {
            return Err(error("is sparse, which is not supported"));
        }
        let Some(view) = accessor.buffer_view else {
            return Err(error("has no buffer view; the mesh is perhaps compressed"));
        };
        let view = root.buffer_views.get(view.value()).ok_or_else(|| error("has a buffer view that does not exist"))?;
        let content =
            self.contents.get(view.buffer.value()).ok_or_else(|| error("has a buffer that does not exist"))?;
        let size = if kind == Type::Vec3 { 12 } else { component };
        let stride = view.byte_stride.as_ref().map_or(0, |stride| stride.0);
        let stride = if stride == 0 { size } else { stride };
        if stride < size {
            return Err(error("has elements that overlap"));
        }
        let offset = accessor.byte_offset.unwrap_or_default().0;
        extent(content, view, offset, accessor.count.0, stride, size)
            .map(|(bytes, count)| Elements { bytes, stride, component, count })
            .ok_or_else(|| error(&format!("promises {} elements, more than its buffer holds", accessor.count.0)))
    }
}

/// The bytes from the first element on, and the number of elements, if `content` really holds so many.
fn extent<'b>(
    content: &'b [u8],
    view: &buffer::View,
    offset: u64,
    count: u64,
    stride: usize,
    size: usize,
) -> Option<(&'b [u8], usize)> {
    let start = usize::try_from(view.byte_offset.unwrap_or_default().0).ok()?;
    let length = usize::try_from(view.byte_length.0).ok()?;
    let viewed = content.get(start..start.checked_add(length)?)?;
    let count = usize::try_from(count).ok()?;
    let elements = viewed.get(usize::try_from(offset).ok()?..)?;
    let needed = match count {
        0 => 0,
        n => stride.checked_mul(n - 1)?.checked_add(size)?,
    };
    (needed <= elements.len()).then_some((elements, count))
}

/// The elements of an accessor; all of them lie within `bytes`.
pub(super) struct Elements<'b> {
    bytes: &'b [u8],
    stride: usize,
    /// Bytes of one component.
    component: usize,
    pub count: usize,
}

impl Elements<'_> {
    /// Element `i` of less than `count` as a point.
    pub fn point(&self, i: usize) -> [f64; 3] {
        let b = &self.bytes[i * self.stride..];
        [0, 4, 8].map(|k| f64::from(f32::from_le_bytes([b[k], b[k + 1], b[k + 2], b[k + 3]])))
    }

    /// Element `i` of less than `count` as an index.
    pub fn index(&self, i: usize) -> usize {
        let b = &self.bytes[i * self.stride..];
        b[..self.component].iter().rev().fold(0, |n, &byte| n << 8 | usize::from(byte))
    }
}

fn decode(uri: &str) -> Result<Vec<u8>, String> {
    match gltf::buffer::Data::from_source(gltf::buffer::Source::Uri(uri), None) {
        Ok(data) => Ok(data.0),
        Err(e) => Err(format!("its data cannot be decoded ({e})")),
    }
}

/// Reads the file that `uri` names in the folder of the document, and nowhere else.
fn read_beside(source: &Source, uri: &str, place: &str, so_far: u64) -> Result<Vec<u8>, ImportError> {
    let refuse = |problem: String| {
        source.malformed(place, problem, "export the file again as GLB, which has everything in one file")
    };
    let shown = excerpt(uri.as_bytes());
    let name = percent_decoded(uri).filter(|name| is_plain_name(name));
    let Some(name) = name else {
        return Err(refuse(format!("lies at {shown}; only files in the same folder are read")));
    };
    let Some(folder) = source.folder else {
        return Err(refuse(format!("lies in the file {shown}, which did not come along")));
    };
    let path = folder.join(name);
    let unreadable = |e: std::io::Error| refuse(format!("its file {shown} cannot be read ({e})"));
    // Asked before opening, as opening a pipe would wait for ever.
    let about = std::fs::metadata(&path).map_err(unreadable)?;
    if !about.is_file() {
        return Err(refuse(format!("{shown} is not a file")));
    }
    source.limits.check_file(source.name, so_far.saturating_add(about.len()))?;
    let mut content = Vec::new();
    let left = source.limits.max_file_bytes.saturating_sub(so_far);
    File::open(&path).and_then(|file| file.take(left).read_to_end(&mut content)).map_err(unreadable)?;
    Ok(content)
}

/// Whether `name` is one component of a path and no way out of the folder, on any system.
fn is_plain_name(name: &str) -> bool {
    !name.contains(['/', '\\', ':', '\0']) && Path::new(name).file_name().is_some_and(|n| n == name)
}

fn percent_decoded(uri: &str) -> Option<String> {
    let mut bytes = uri.bytes();
    let mut decoded = Vec::with_capacity(uri.len());
    while let Some(byte) = bytes.next() {
        if byte != b'%' {
            decoded.push(byte);
            continue;
        }
        let mut digit = || char::from(bytes.next()?).to_digit(16);
        decoded.push((digit()? * 16 + digit()?) as u8);
    }
    String::from_utf8(decoded).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_plain_names_lead_to_files() {
        for bad in ["../part.bin", "/etc/passwd", "a/b.bin", "..", ".", "", "c:part.bin", "a\\b.bin"] {
            assert!(!is_plain_name(bad), "{bad}");
        }
        assert!(is_plain_name("part.bin"));
        assert_eq!(percent_decoded("my%20part.bin").as_deref(), Some("my part.bin"));
        assert_eq!(percent_decoded("%2e%2E%2fpart").as_deref(), Some("../part"));
        assert_eq!(percent_decoded("part%2"), None);
    }
}
