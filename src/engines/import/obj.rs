//! Wavefront OBJ: vertices and faces; materials, normals and texture coordinates are skipped.

use std::io::{self, Write};

use glam::DVec3;

use super::error::{ImportError, excerpt};
use super::format::{Content, Likeness, MeshFormat};
use super::report::count;
use super::source::{RawMesh, Source};
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
    let text = source.text();
    // Very old files end their lines with "\r" alone.
    let end = if text.contains(&b'\n') { b'\n' } else { b'\r' };
    let mut lines = Lines { source, line: 0, mesh: Mesh::default(), skipped: 0 };
    let (mut raw, mut read) = (RawMesh::default(), 0);
    for line in text.split(|b| *b == end) {
        lines.line += 1;
        read += line.len() + 1;
        source.tick("reading lines", lines.line, lines.line * source.bytes.len() / read)?;
        let trimmed = line.trim_ascii_start();
        let first = trimmed.split(u8::is_ascii_whitespace).next().unwrap_or_default();
        let rest = &trimmed[first.len()..];
        match first {
            b"v" => lines.vertex(rest)?,
            b"f" => lines.face(rest)?,
            // The first comments may name the unit.
            _ if first.starts_with(b"#") && raw.note.len() < 1000 => {
                raw.note.push_str(&String::from_utf8_lossy(&line[..line.len().min(200)]));
                raw.note.push('\n');
            }
            _ => {}
        }
    }
    if lines.skipped > 0 {
        raw.warnings.push(format!("{} of fewer than three corners skipped.", count(lines.skipped, "face")));
    }
    raw.mesh = weld_exact(lines.mesh, source.task)?;
    Ok(raw)
}

/// What has been read up to a line.
struct Lines<'a> {
    source: &'a Source<'a>,
    /// Number of the current line, from 1.
    line: usize,
    mesh: Mesh,
    /// Faces that are points or lines.
    skipped: usize,
}

impl Lines<'_> {
    fn vertex(&mut self, line: &[u8]) -> Result<(), ImportError> {
        let mut p = [0.0; 3];
        let mut words = words(line);
        for x in &mut p {
            let word = words.next().unwrap_or_default();
            *x = number(word).ok_or_else(|| {
                let problem = format!("a vertex needs three numbers, found {}", excerpt(word));
                self.error(problem, "export the file again, with points as decimal marks")
            })?;
        }
        let p = self.source.finite(DVec3::from_array(p), || format!("line {}", self.line))?;
        self.mesh.vertices.push(p);
        self.check_size(0)
    }

    fn face(&mut self, line: &[u8]) -> Result<(), ImportError> {
        let corners = words(line).map(|word| self.corner(word)).collect::<Result<Vec<_>, _>>()?;
        if corners.len() < 3 {
            self.skipped += 1;
            return Ok(());
        }
        self.check_size(corners.len() - 2)?;
        self.mesh.triangles.extend(triangulate(&corners, &self.mesh.vertices));
        Ok(())
    }

    /// The vertex that the first number of `12/3/4` means: positive ones count from 1, negative ones backwards from the
    /// last.
    fn corner(&self, word: &[u8]) -> Result<u32, ImportError> {
        let first = word.split(|&b| b == b'/').next().unwrap_or_default();
        let index: i64 = number(first).ok_or_else(|| {
            let problem = format!("a face needs vertex numbers, found {}", excerpt(word));
            self.error(problem, "export the file again")
        })?;
        let count = self.mesh.vertices.len() as i64;
        let from_one = if index < 0 { count.saturating_add(index) + 1 } else { index };
        if (1..=count).contains(&from_one) {
            return Ok((from_one - 1) as u32);
        }
        let problem = format!("a face refers to vertex {index}, but {count} are given up to here");
        Err(self.error(problem, "export the file again; parts of it are missing"))
    }

    /// Refuses a mesh that has grown too large, or would with so many more triangles.
    fn check_size(&self, more: usize) -> Result<(), ImportError> {
        self.source.check_mesh((self.mesh.triangles.len() + more) as u64, self.mesh.vertices.len() as u64)
    }

    fn error(&self, problem: String, remedy: &'static str) -> ImportError {
        self.source.malformed(format!("line {}", self.line), problem, remedy)
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
