//! STL, binary and ASCII: reading both, writing binary.
//!
//! Binary: 80 bytes of header, the number of triangles as `u32`, then for each triangle its normal, three corners
//! (twelve `f32`) and two attribute bytes, all little-endian. Normals are not read: the order of the corners says the
//! same, and where the two disagree it is the normal that is usually wrong.

use std::io;
use std::path::Path;

use glam::DVec3;

use super::error::{ImportError, excerpt};
use super::source::{Content, Likeness, MeshFormat, RawMesh, Source};
use files::atomic::atomic_write;
use geometry::mesh::{Mesh, unit_normal};
use geometry::weld::Weld;

/// Binary STL.
pub(super) static BINARY: MeshFormat =
    MeshFormat { name: "binary STL", likeness: like_binary, read: read_binary, unit: None };
/// ASCII STL.
pub(super) static ASCII: MeshFormat =
    MeshFormat { name: "text STL", likeness: like_ascii, read: read_ascii, unit: None };

/// How many bytes may follow the last triangle of a binary file that is not named `.stl`.
const STRAY_BYTES: u64 = 1024;

/// A binary file may well open with the word "solid", but no text has such bytes where the number of triangles stands
/// that its length comes out right.
fn like_binary(content: &Content) -> Likeness {
    let length = content.bytes.len() as u64;
    let promised = promised_triangles(content.bytes).map(binary_length);
    if promised == Some(length) {
        return Likeness::Certain;
    }
    let has_strays = |n: u64| n > binary_length(0) && n < length && length - n <= STRAY_BYTES;
    Likeness::Perhaps.when(content.ending == "stl" && content.text.is_none() || promised.is_some_and(has_strays))
}

fn like_ascii(content: &Content) -> Likeness {
    const WORD: &[u8] = b"solid";
    Likeness::Likely.when(content.text.is_some_and(|text| {
        text.get(..WORD.len()).is_some_and(|start| start.eq_ignore_ascii_case(WORD))
            && text.get(WORD.len()).is_none_or(u8::is_ascii_whitespace)
    }))
}

/// Bytes before the first triangle.
const HEADER: usize = 84;
/// Bytes of one triangle.
const RECORD: usize = 50;
/// Bytes of the free text that opens the header.
const TITLE: usize = 80;

/// Number of triangles that a binary header promises; `None` for fewer bytes than a header.
fn promised_triangles(bytes: &[u8]) -> Option<u32> {
    let count = bytes.get(TITLE..HEADER)?;
    Some(u32::from_le_bytes(count.try_into().ok()?))
}

/// Length of a binary file of so many triangles.
fn binary_length(triangles: u32) -> u64 {
    HEADER as u64 + RECORD as u64 * u64::from(triangles)
}

/// Reads a binary STL file; bytes after the last triangle are skipped with a warning.
fn read_binary(source: &Source) -> Result<RawMesh, ImportError> {
    let found = source.bytes.len() as u64;
    let Some(count) = promised_triangles(source.bytes) else {
        let problem = format!("the file ends after {found} bytes, within the header of {HEADER}");
        return Err(source.malformed("header", problem, "export or copy the file again"));
    };
    let promised = binary_length(count);
    if found < promised {
        let problem = format!("{count} triangles need {promised} bytes but the file has {found}");
        return Err(source.malformed("header", problem, "the file is cut off: export or copy it again"));
    }
    let count = count as usize;
    source.check_mesh(count as u64, 3 * count as u64)?;
    let mut weld = Weld::default();
    let mut triangles = Vec::with_capacity(count);
    for (i, record) in source.bytes[HEADER..].chunks_exact(RECORD).take(count).enumerate() {
        source.tick("reading triangles", i, count)?;
        let mut corners = [0; 3];
        for (k, corner) in corners.iter_mut().enumerate() {
            let p = point_at(record, 12 * (k + 1));
            *corner = weld.add(source.finite(p, || format!("triangle {}", i + 1))?);
        }
        triangles.push(corners);
    }
    let mut warnings = Vec::new();
    if found > promised {
        warnings.push(format!("{} bytes after the last triangle were ignored.", found - promised));
    }
    let note = String::from_utf8_lossy(&source.bytes[..TITLE]).into_owned();
    Ok(RawMesh { mesh: Mesh { vertices: weld.into_points(), triangles }, warnings, note, ..RawMesh::default() })
}

/// Three little-endian `f32` at `offset` of a record, which is long enough for them.
fn point_at(record: &[u8], offset: usize) -> DVec3 {
    let coordinate = |k: usize| {
        let b = &record[offset + 4 * k..];
        f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    };
    DVec3::new(coordinate(0), coordinate(1), coordinate(2))
}

/// Reads an ASCII STL file: any case, any white space, any number of solids.
fn read_ascii(source: &Source) -> Result<RawMesh, ImportError> {
    let mut words = Words { bytes: source.text(), at: 0, line: 1 };
    let mut weld = Weld::default();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    let mut corners: Vec<u32> = Vec::with_capacity(3);
    let mut note = String::new();
    while let Some(word) = words.next_word() {
        match word.to_ascii_lowercase().as_slice() {
            b"solid" => note.push_str(&String::from_utf8_lossy(words.rest_of_line())),
            b"endsolid" => drop(words.rest_of_line()),
            b"vertex" => {
                let p = read_vertex(source, &mut words)?;
                corners.push(weld.add(source.finite(p, || format!("line {}", words.line))?));
            }
            b"endloop" => {
                let &[a, b, c] = corners.as_slice() else {
                    let problem = format!("a facet has {} corners instead of 3", corners.len());
                    return Err(at_line(source, &words, problem, "export the surface as triangles"));
                };
                source.tick("reading triangles", triangles.len(), source.bytes.len() / 250)?;
                if triangles.len().is_multiple_of(1024) {
                    source.check_mesh(triangles.len() as u64 + 1, weld.points().len() as u64)?;
                }
                triangles.push([a, b, c]);
                corners.clear();
            }
            b"facet" | b"normal" | b"outer" | b"loop" | b"endfacet" => {}
            _ if number(word).is_some() => {}
            _ => {
                let problem = format!("unexpected {}", excerpt(word));
                return Err(at_line(source, &words, problem, "export the file again, preferably as binary STL"));
            }
        }
    }
    if !corners.is_empty() {
        let problem = "the file ends within a facet";
        return Err(at_line(source, &words, problem, "the file is cut off: export or copy it again"));
    }
    Ok(RawMesh { mesh: Mesh { vertices: weld.into_points(), triangles }, note, ..RawMesh::default() })
}

fn at_line(source: &Source, words: &Words, problem: impl Into<String>, remedy: &'static str) -> ImportError {
    source.malformed(format!("line {}", words.line), problem, remedy)
}

fn read_vertex(source: &Source, words: &mut Words) -> Result<DVec3, ImportError> {
    let mut p = [0.0; 3];
    for x in &mut p {
        let word = words.next_word().unwrap_or_default();
        *x = number(word).ok_or_else(|| {
            let problem = format!("a vertex needs three numbers, found {}", excerpt(word));
            at_line(source, words, problem, "export the file again, with points as decimal marks")
        })?;
    }
    Ok(DVec3::from_array(p))
}

fn number(word: &[u8]) -> Option<f64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// The words of a text, with the line that the last one stands in.
struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Words<'a> {
    fn next_word(&mut self) -> Option<&'a [u8]> {
        while let Some(&b) = self.bytes.get(self.at)
            && b.is_ascii_whitespace()
        {
            // A line ends with "\n", "\r\n" or, in very old files, "\r" alone.
            let lone_return = b == b'\r' && self.bytes.get(self.at + 1) != Some(&b'\n');
            self.line += usize::from(b == b'\n' || lone_return);
            self.at += 1;
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += length;
        (length > 0).then(|| &rest[..length])
    }

    fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        self.at += length;
        &rest[..length]
    }
}

/// Writes `mesh` to `path` as binary STL. The file appears whole or not at all (see [`atomic_write`]).
///
/// # Errors
/// Every error of [`stl_bytes`] and of the file system.
pub fn write_stl(path: &Path, mesh: &Mesh) -> io::Result<()> {
    let bytes = stl_bytes(mesh)?;
    atomic_write(path, |out| out.write_all(&bytes))
}

/// `mesh` as the bytes of a binary STL file, coordinates in its own unit (mm) rounded to `f32`.
///
/// # Errors
/// `InvalidInput` for coordinates beyond `f32`, vertex numbers without a vertex, or
/// more triangles than the format can count.
pub fn stl_bytes(mesh: &Mesh) -> io::Result<Vec<u8>> {
    let invalid = |problem: &str| io::Error::new(io::ErrorKind::InvalidInput, problem.to_owned());
    let count = u32::try_from(mesh.triangles.len()).map_err(|_| invalid("too many triangles for an STL file"))?;
    if !mesh.vertices.iter().all(|p| p.as_vec3().is_finite()) {
        return Err(invalid("a coordinate is not finite or too large for an STL file"));
    }
    if mesh.triangles.iter().flatten().any(|&v| v as usize >= mesh.vertices.len()) {
        return Err(invalid("a triangle refers to a vertex that does not exist"));
    }
    // Many readers take any file that begins with "solid" for ASCII, so the title must not.
    let mut bytes = vec![b' '; TITLE];
    let title = b"Binary STL by sparkpath, UNITS=mm";
    bytes[..title.len()].copy_from_slice(title);
    bytes.reserve(4 + mesh.triangles.len() * RECORD);
    bytes.extend(count.to_le_bytes());
    for corners in mesh.iter_corners() {
        let mut record = [0; RECORD];
        let points = [unit_normal(corners), corners[0], corners[1], corners[2]];
        for (bytes, x) in record.chunks_exact_mut(4).zip(points.iter().flat_map(|p| p.to_array())) {
            bytes.copy_from_slice(&(x as f32).to_le_bytes());
        }
        bytes.extend(record);
    }
    Ok(bytes)
}
