//! Formats of mesh files. The content decides the format; the name is a hint where the content is ambiguous.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::error::{ImportError, excerpt};
use super::source::{Content, Likeness, MeshFormat, without_mark};

/// Lists the formats: each has a variant of [`Format`], a [`MeshFormat`] in its own file, and the ending of its files.
/// Of two that are equally likely the first is taken.
macro_rules! formats {
    ($($(#[$doc:meta])* $format:ident: $about:path, $($ending:literal),+;)+) => {
        /// A format of mesh files.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Format { $($(#[$doc])* $format),+ }

        impl Format {
            const ALL: &'static [Self] = &[$(Self::$format),+];

            /// Name in a sentence.
            pub fn name(self) -> &'static str {
                self.about().name
            }

            pub(super) fn about(self) -> &'static MeshFormat {
                match self { $(Self::$format => &$about),+ }
            }
        }

        /// Endings of the names of mesh files, without the dot.
        pub const MESH_ENDINGS: &[&str] = &[$($($ending),+),+];
    };
}

formats! {
    /// glTF 2.0 in one binary file.
    Glb: super::gltf::BINARY, "glb";
    /// Binary STL.
    StlBinary: super::stl::BINARY, "stl";
    /// ASCII STL.
    StlAscii: super::stl::ASCII, "stl";
    /// glTF 2.0 as JSON.
    Gltf: super::gltf::TEXT, "gltf";
    /// Wavefront OBJ.
    Obj: super::obj::TEXT, "obj";
    /// STEP: AP203, AP214 or AP242.
    Step: super::step::TEXT, "step", "stp";
}

/// Length of text that is looked at to recognise its format (bytes).
const HEAD: usize = 1 << 16;

/// Format of a file with this content and name.
///
/// # Errors
/// [`ImportError::UnknownFormat`], with what the content resembles.
pub fn detect(name: &str, bytes: &[u8]) -> Result<Format, ImportError> {
    let ending = Path::new(name).extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let head = &bytes[..bytes.len().min(HEAD)];
    let text = (!head.contains(&0)).then(|| without_mark(head).trim_ascii_start());
    let content = Content { bytes, text, ending: &ending };
    // The last of equally great ones is taken, so that the list is gone through backwards.
    let likely = Format::ALL.iter().rev().map(|format| ((format.about().likeness)(&content), *format));
    let (likeness, format) = likely.max_by_key(|(likeness, _)| *likeness).unwrap_or((Likeness::No, Format::StlBinary));
    if likeness >= Likeness::Likely {
        return Ok(format);
    }
    if let Some(other) = content.text.and_then(foreign) {
        return Err(unknown(name, other.to_owned()));
    }
    if likeness == Likeness::Perhaps {
        return Ok(format);
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

/// Name of a known format that this program does not read, by the beginning of its text.
fn foreign(text: &[u8]) -> Option<&'static str> {
    let known: [(&[u8], &str); 4] = [
        (b"ply", "the file is a PLY file"),
        (b"OFF", "the file is an OFF file"),
        (b"<", "the file is an XML or HTML file"),
        (b"%PDF", "the file is a PDF file"),
    ];
    known.iter().find(|(start, _)| text.starts_with(start)).map(|(_, name)| *name)
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
        assert_eq!(detect("a.stl", b"ISO-10303-21;\nHEADER;").unwrap(), Format::Step);
    }

    #[test]
    fn strangers_are_named() {
        for (content, word) in [
            (b"ply\nformat ascii 1.0".as_slice(), "PLY"),
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
