//! Wavefront OBJ: vertices and faces; materials, normals and texture coordinates are skipped.
//!
//! The `tobj` crate reads the file, but sees only what [`Lines`] lets through: it knows no limits, does not say where
//! a file is wrong, and trusts numbers of vertices that are not there.

use std::io::{self, BufRead, Read, Write};
use std::iter;

use glam::DVec3;
use tobj::{LoadError, LoadOptions, Model};

use super::error::{ImportError, excerpt};
use super::source::{Content, Likeness, MeshFormat, RawMesh, Source, count};
use super::weld::weld_exact;
use geometry::mesh::Mesh;

/// Wavefront OBJ.
pub(super) static TEXT: MeshFormat = MeshFormat { likeness, read, unit: None };

fn likeness(content: &Content) -> Likeness {
    let Some(text) = content.text else { return Likeness::No };
    Likeness::Perhaps.when(begins_with_vertex(text) || content.ending == "obj" && !content.bytes.is_empty())
}

/// Whether a line gives a vertex and none before it is foreign to OBJ.
fn begins_with_vertex(text: &[u8]) -> bool {
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

/// Reads an OBJ file. Polygons become fans, or are cut at their ears where a fan would fold over.
fn read(source: &Source) -> Result<RawMesh, ImportError> {
    let mut lines = Lines::new(source);
    let no_materials = |_: &std::path::Path| Err(LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut lines, &LoadOptions::default(), no_materials)
        .map_err(|error| lines.explained(error))?;
    let mut raw = RawMesh { note: lines.note, ..RawMesh::default() };
    if lines.skipped > 0 {
        raw.warnings.push(format!("{} of fewer than three corners skipped.", count(lines.skipped, "face")));
    }
    for model in &models {
        source.task.check()?;
        append(&mut raw.mesh, model);
    }
    raw.mesh = weld_exact(raw.mesh, source.task)?;
    Ok(raw)
}

/// Adds the faces of `model` as triangles.
fn append(mesh: &mut Mesh, model: &Model) {
    let tobj::Mesh { positions, indices, face_arities, .. } = &model.mesh;
    let base = mesh.vertices.len() as u32;
    mesh.vertices.extend(positions.chunks_exact(3).map(DVec3::from_slice));
    let mut rest = indices.as_slice();
    // No numbers of corners are given where all faces have three.
    let corners_of_each = face_arities.iter().copied().chain(iter::repeat(3)).map(|n| n as usize);
    for n in corners_of_each {
        let Some((face, others)) = rest.split_at_checked(n).filter(|(face, _)| !face.is_empty()) else { break };
        let corners: Vec<u32> = face.iter().map(|v| base + v).collect();
        match *corners.as_slice() {
            [a, b, c] => mesh.triangles.push([a, b, c]),
            _ => mesh.triangles.extend(triangulate(&corners, &mesh.vertices)),
        }
        rest = others;
    }
}

/// The lines that describe vertices and faces, checked and put plainly: three words to a vertex, and to a face the
/// numbers of its vertices, counted from 1.
struct Lines<'a> {
    source: &'a Source<'a>,
    /// Text after the current line.
    rest: &'a [u8],
    /// Line end: "\n", also after "\r", or in very old files "\r" alone.
    end: u8,
    /// Number of the current line, from 1.
    line: usize,
    /// Words after the first.
    words: &'a [u8],
    vertices: usize,
    triangles: u64,
    /// Faces that are points or lines.
    skipped: usize,
    /// The first comments: they may name the unit.
    note: String,
    /// Buffer of the text that is read next, and the position in it.
    plain: Vec<u8>,
    read: usize,
    /// Reason why nothing more is read.
    refusal: Option<ImportError>,
}

impl<'a> Lines<'a> {
    /// Triangles after which a new object is begun, so that none takes long to be put together.
    const TO_AN_OBJECT: u64 = 1 << 15;

    fn new(source: &'a Source<'a>) -> Self {
        let rest = source.text();
        Self {
            source,
            rest,
            end: if rest.contains(&b'\n') { b'\n' } else { b'\r' },
            line: 0,
            words: &[],
            vertices: 0,
            triangles: 0,
            skipped: 0,
            note: String::new(),
            plain: Vec::new(),
            read: 0,
            refusal: None,
        }
    }

    /// Puts the next line of interest into `plain`, which stays empty at the end.
    fn advance(&mut self) -> Result<(), ImportError> {
        self.plain.clear();
        self.read = 0;
        while self.plain.is_empty() && !self.rest.is_empty() {
            let end = self.rest.iter().position(|&b| b == self.end);
            let line = &self.rest[..end.unwrap_or(self.rest.len())];
            self.rest = end.map_or(&[], |end| &self.rest[end + 1..]);
            self.line += 1;
            let total = self.source.bytes.len();
            self.source.tick("reading lines", self.line, self.line * total / (total - self.rest.len()).max(1))?;
            let trimmed = line.trim_ascii_start();
            let first = trimmed.split(u8::is_ascii_whitespace).next().unwrap_or_default();
            self.words = &trimmed[first.len()..];
            match first {
                b"v" => self.pass_vertex()?,
                b"f" => self.pass_face()?,
                _ if first.starts_with(b"#") => self.keep_comment(line),
                _ => {}
            }
        }
        Ok(())
    }

    fn keep_comment(&mut self, line: &[u8]) {
        if self.note.len() < 1000 {
            self.note.push_str(&String::from_utf8_lossy(&line[..line.len().min(200)]));
            self.note.push('\n');
        }
    }

    fn pass_vertex(&mut self) -> Result<(), ImportError> {
        let mut p = [0.0; 3];
        let mut words = words(self.words);
        self.plain.push(b'v');
        for x in &mut p {
            let word = words.next().unwrap_or_default();
            *x = number(word).ok_or_else(|| {
                let problem = format!("a vertex needs three numbers, found {}", excerpt(word));
                self.error(problem, "export the file again, with points as decimal marks")
            })?;
            self.plain.push(b' ');
            self.plain.extend(word);
        }
        self.plain.push(b'\n');
        self.source.finite(DVec3::from_array(p), || format!("line {}", self.line))?;
        self.vertices += 1;
        self.check_size()
    }

    fn pass_face(&mut self) -> Result<(), ImportError> {
        let corners = words(self.words).map(|word| self.vertex(word)).collect::<Result<Vec<_>, _>>()?;
        if corners.len() < 3 {
            self.skipped += 1;
            return Ok(());
        }
        let before = self.triangles / Self::TO_AN_OBJECT;
        self.triangles += corners.len() as u64 - 2;
        self.check_size()?;
        if self.triangles / Self::TO_AN_OBJECT > before {
            self.plain.extend(b"o next\n");
        }
        self.plain.push(b'f');
        for corner in corners {
            self.plain.extend(format!(" {corner}").bytes());
        }
        self.plain.push(b'\n');
        Ok(())
    }

    /// The vertex, counted from 1, that the first number of `12/3/4` means: negative ones count backwards from the
    /// last.
    fn vertex(&self, word: &[u8]) -> Result<usize, ImportError> {
        let first = word.split(|&b| b == b'/').next().unwrap_or_default();
        let index: i64 = number(first).ok_or_else(|| {
            let problem = format!("a face needs vertex numbers, found {}", excerpt(word));
            self.error(problem, "export the file again")
        })?;
        let count = self.vertices as i64;
        let from_one = if index < 0 { count.saturating_add(index) + 1 } else { index };
        if (1..=count).contains(&from_one) {
            return Ok(from_one as usize);
        }
        let problem = format!("a face refers to vertex {index}, but {count} are given up to here");
        Err(self.error(problem, "export the file again; parts of it are missing"))
    }

    /// Refuses a mesh that has grown too large.
    fn check_size(&self) -> Result<(), ImportError> {
        self.source.check_mesh(self.triangles, self.vertices as u64)
    }

    fn error(&self, problem: String, remedy: &'static str) -> ImportError {
        self.source.malformed(format!("line {}", self.line), problem, remedy)
    }

    /// Reason why the crate stopped at the current line.
    fn explained(&mut self, error: LoadError) -> ImportError {
        self.refusal.take().unwrap_or_else(|| self.error(error.to_string(), "export the file again"))
    }
}

impl BufRead for Lines<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.read == self.plain.len() {
            self.advance().map_err(|refusal| {
                self.refusal = Some(refusal);
                io::Error::from(io::ErrorKind::InvalidData)
            })?;
        }
        Ok(&self.plain[self.read..])
    }

    fn consume(&mut self, amount: usize) {
        self.read = (self.read + amount).min(self.plain.len());
    }
}

impl Read for Lines<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = self.fill_buf()?.read(into)?;
        self.consume(read);
        Ok(read)
    }
}

fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

fn number<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Ear cutting takes the cube of the number of corners at worst; beyond this many a fan has to do.
const MOST_CORNERS_TO_CUT: usize = 128;

/// Triangles that fill the polygon `corners`, in its sense of rotation.
fn triangulate(corners: &[u32], vertices: &[DVec3]) -> Vec<[u32; 3]> {
    let point = |v: u32| vertices[v as usize];
    // Newell's normal: exact for a flat polygon, the mean for a warped one.
    let normal: DVec3 = (0..corners.len())
        .map(|i| {
            let (a, b) =
                (point(corners[i]) - point(corners[0]), point(corners[(i + 1) % corners.len()]) - point(corners[0]));
            a.cross(b)
        })
        .sum();
    let turn = |a: u32, b: u32, c: u32| (point(b) - point(a)).cross(point(c) - point(a)).dot(normal);
    let fan = |ring: &[u32]| ring.windows(2).skip(1).map(|w| [ring[0], w[0], w[1]]).collect::<Vec<_>>();
    let mut ring = corners.to_vec();
    if ring.len() > MOST_CORNERS_TO_CUT || fan(&ring).iter().all(|&[a, b, c]| turn(a, b, c) >= 0.0) {
        return fan(&ring);
    }
    let mut triangles = Vec::with_capacity(ring.len() - 2);
    while ring.len() > 3 {
        let n = ring.len();
        let is_ear = |&i: &usize| {
            let [a, b, c] = [ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]];
            let inside = |v: u32| turn(a, b, v) >= 0.0 && turn(b, c, v) >= 0.0 && turn(c, a, v) >= 0.0;
            turn(a, b, c) > 0.0 && !ring.iter().any(|&v| ![a, b, c].contains(&v) && inside(v))
        };
        // A polygon that crosses itself may have no ear; the rest of it is closed by a fan.
        let Some(i) = (0..n).find(is_ear) else { break };
        triangles.push([ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]]);
        ring.remove(i);
    }
    triangles.extend(fan(&ring));
    triangles
}

/// A named mesh as the text of an OBJ file, coordinates in its own unit (mm), exact to the last bit.
///
/// # Errors
/// `InvalidInput` for coordinates that are not finite, and vertex numbers without a vertex.
pub fn obj_bytes(name: &str, mesh: &Mesh) -> io::Result<Vec<u8>> {
    let invalid = |problem: &str| io::Error::new(io::ErrorKind::InvalidInput, problem.to_owned());
    if !mesh.vertices.iter().all(|p| p.is_finite()) {
        return Err(invalid("a coordinate is not finite"));
    }
    if mesh.triangles.iter().flatten().any(|&v| v as usize >= mesh.vertices.len()) {
        return Err(invalid("a triangle refers to a vertex that does not exist"));
    }
    let name: String = name.chars().map(|c| if c.is_control() || c.is_whitespace() { '_' } else { c }).collect();
    let mut bytes = format!("# sparkpath, units: mm\no {name}\n").into_bytes();
    for p in &mesh.vertices {
        writeln!(bytes, "v {} {} {}", p.x, p.y, p.z)?;
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(bytes, "f {} {} {}", u64::from(*a) + 1, u64::from(*b) + 1, u64::from(*c) + 1)?;
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ImportOptions, Unit, import_bytes};
    use geometry::mesh::Mesh;
    use task::Task;

    #[test]
    fn what_is_written_is_read_as_it_was() {
        let mesh = Mesh::cuboid(DVec3::new(0.1, 1.0 / 3.0, 40.0)).mapped(|p| p - DVec3::new(7.7, 0.0, 1e-7));
        let bytes = obj_bytes("E 01\nf 1 1 1", &mesh).unwrap();
        let options = ImportOptions::default();
        let read = import_bytes("e.obj", &bytes, &options, &Task::default()).unwrap();
        assert!(read.report.watertight && read.report.unit == Unit::Mm);
        let sorted = |mesh: &Mesh| {
            let mut corners: Vec<_> = mesh.iter_corners().map(|c| c.map(|p| p.to_array())).collect();
            // Whichever corner of a triangle comes first.
            corners.iter_mut().for_each(|c| {
                let first = (0..3).min_by(|a, b| c[*a].partial_cmp(&c[*b]).unwrap()).unwrap();
                c.rotate_left(first);
            });
            corners.sort_by(|a, b| a.partial_cmp(b).unwrap());
            corners
        };
        assert_eq!(sorted(&read.mesh), sorted(&mesh));
        let broken = Mesh { vertices: mesh.vertices[..5].to_vec(), ..mesh.clone() };
        assert!(obj_bytes("x", &broken).is_err());
        assert!(obj_bytes("x", &mesh.mapped(|p| p / 0.0)).is_err());
    }

    #[test]
    fn a_polygon_with_a_notch_is_filled_without_folds() {
        // An L of area 3 whose first corner does not see the whole of it.
        let vertices: Vec<DVec3> = [(2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0), (0.0, 0.0)]
            .map(|(x, y)| DVec3::new(x, y, 5.0))
            .to_vec();
        for first in 0..6 {
            let ring: Vec<u32> = (0..6).map(|i| (i + first) % 6).collect();
            let triangles = triangulate(&ring, &vertices);
            assert_eq!(triangles.len(), 4);
            let mesh = Mesh { vertices: vertices.clone(), triangles };
            assert!((mesh.area() - 3.0).abs() < 1e-12, "start {first}: area {}", mesh.area());
        }
    }
}
