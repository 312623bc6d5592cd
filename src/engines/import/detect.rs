//! Telling the format of a file by its content; its name is only a hint where the content leaves a doubt.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::error::{ImportError, excerpt};
use super::source::without_mark;
use super::stl;

/// A format of mesh files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Format {
    /// Binary STL.
    StlBinary,
    /// ASCII STL.
    StlAscii,
    /// Wavefront OBJ.
    Obj,
    /// glTF 2.0 as JSON.
    Gltf,
    /// glTF 2.0 in one binary file.
    Glb,
}

/// How much of a text is looked at to tell what it is (bytes).
const HEAD: usize = 1 << 16;

/// How many bytes may follow the last triangle of a binary STL file that is not named one.
const STRAY_BYTES: u64 = 1024;

/// The format of a file of the given content and name.
///
/// # Errors
/// [`ImportError::UnknownFormat`], with what the content looks like.
pub fn detect(name: &str, bytes: &[u8]) -> Result<Format, ImportError> {
    let extension = Path::new(name).extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let head = &bytes[..bytes.len().min(HEAD)];
    let text = without_mark(head).trim_ascii_start();
    if bytes.starts_with(b"glTF") {
        return Ok(Format::Glb);
    }
    // First of all the lengths: a binary file may well open with the word "solid", but no ASCII file has such bytes
    // where the count stands that its length comes out right.
    let promised = stl::promised_triangles(bytes).map(stl::binary_length);
    if promised == Some(bytes.len() as u64) {
        return Ok(Format::StlBinary);
    }
    let is_text = !head.contains(&0);
    if is_text && starts_with_word(text, b"solid") {
        return Ok(Format::StlAscii);
    }
    if is_text && text.starts_with(b"{") && (contains(bytes, b"\"asset\"") || extension == "gltf") {
        return Ok(Format::Gltf);
    }
    if is_text && let Some(other) = foreign(text) {
        return Err(unknown(name, other.to_owned()));
    }
    if is_text && (looks_like_obj(text) || extension == "obj" && !bytes.is_empty()) {
        return Ok(Format::Obj);
    }
    let fits = promised.is_some_and(|n| n > stl::binary_length(0) && n <= bytes.len() as u64);
    let stray = promised.map_or(u64::MAX, |n| (bytes.len() as u64).saturating_sub(n));
    if extension == "stl" && !is_text || fits && stray <= STRAY_BYTES {
        return Ok(Format::StlBinary);
    }
    let found = match bytes {
        [] => "the file is empty".to_owned(),
        [b'P', b'K', 3, 4, ..] => "the file is a ZIP archive (3MF perhaps)".to_owned(),
        _ => format!(
            "the content, beginning with {}, is of no known mesh format",
            excerpt(&bytes[..bytes.len().min(20)])
        ),
    };
    Err(unknown(name, found))
}

fn unknown(name: &str, found: String) -> ImportError {
    ImportError::UnknownFormat { file: name.to_owned(), found }
}

/// Name of a known format that is no mesh for this program, by the beginning of its text.
fn foreign(text: &[u8]) -> Option<&'static str> {
    let known: [(&[u8], &str); 5] = [
        (b"ISO-10303-21", "the file is a STEP file"),
        (b"ply", "the file is a PLY file"),
        (b"OFF", "the file is an OFF file"),
        (b"<", "the file is an XML or HTML file"),
        (b"%PDF", "the file is a PDF file"),
    ];
    known.iter().find(|(start, _)| text.starts_with(start)).map(|(_, name)| *name)
}

fn starts_with_word(text: &[u8], word: &[u8]) -> bool {
    text.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word))
        && text.get(word.len()).is_none_or(u8::is_ascii_whitespace)
}

fn contains(bytes: &[u8], needle: &[u8]) -> bool {
    bytes.windows(needle.len()).any(|window| window == needle)
}

/// Whether a line gives a vertex and none before it is foreign to OBJ.
fn looks_like_obj(text: &[u8]) -> bool {
    for line in text.split(|b| matches!(b, b'\n' | b'\r')) {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        match words.next() {
            Some(b"v") => return words.clone().count() >= 3,
            None | Some(b"o" | b"g" | b"s" | b"vn" | b"vt" | b"f" | b"l" | b"p" | b"mtllib" | b"usemtl") => {}
            Some(word) if word.starts_with(b"#") => {}
            Some(_) => return false,
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_decides_and_the_name_only_helps_in_doubt() {
        let mut solid = b"solid but binary".to_vec();
        solid.resize(80, b' ');
        solid.extend(1u32.to_le_bytes());
        solid.extend([0; 50]);
        assert_eq!(detect("a.obj", &solid).unwrap(), Format::StlBinary);
        assert_eq!(detect("a.bin", b" \n SOLID x\nfacet").unwrap(), Format::StlAscii);
        assert_eq!(detect("a.stl", b"# made\no box\nv 0 0 1\n").unwrap(), Format::Obj);
        assert_eq!(detect("a.stl", b" {\"asset\":{}}").unwrap(), Format::Gltf);
        assert_eq!(detect("a", b"glTF....").unwrap(), Format::Glb);
    }

    #[test]
    fn strangers_are_named() {
        for (content, word) in [
            (b"ISO-10303-21;\nHEADER;".as_slice(), "STEP"),
            (b"PK\x03\x04rest", "ZIP"),
            (b"", "empty"),
            (b"hello world", "hello world"),
            (b"solidity", "solidity"),
        ] {
            let text = detect("a.xyz", content).unwrap_err().to_string();
            assert!(text.contains(word) && text.contains("a.xyz") && text.contains("STL"), "{text}");
        }
    }
}
