//! Wavefront OBJ: vertices and faces; materials, normals and texture coordinates are skipped.

use glam::DVec3;

use super::error::{ImportError, excerpt};
use super::report::count;
use super::source::{RawMesh, Source};
use super::weld::weld_exact;

/// Reads an OBJ file. Polygons become fans, or are cut at their ears where a fan would fold over.
pub(super) fn read(source: &Source) -> Result<RawMesh, ImportError> {
    let mut reader = Reader { source, line: 0, raw: RawMesh::default(), skipped: 0 };
    let mut offset = 0;
    let text = source.text();
    // Lines end with "\n", "\r\n" or, in very old files, "\r" alone.
    let end = if text.contains(&b'\n') { b'\n' } else { b'\r' };
    for line in text.split(|&b| b == end) {
        reader.line += 1;
        reader.read_line(line)?;
        offset += line.len() + 1;
        source.tick("reading lines", reader.line, reader.line * text.len() / offset.max(1))?;
    }
    let Reader { mut raw, skipped, .. } = reader;
    if skipped > 0 {
        raw.warnings.push(format!("{} of fewer than three corners skipped.", count(skipped, "face")));
    }
    raw.mesh = weld_exact(raw.mesh, source.progress, source.cancel)?;
    Ok(raw)
}

struct Reader<'a> {
    source: &'a Source<'a>,
    /// Number of the current line, from 1.
    line: usize,
    raw: RawMesh,
    /// Faces that are points or lines.
    skipped: usize,
}

impl Reader<'_> {
    fn read_line(&mut self, line: &[u8]) -> Result<(), ImportError> {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        match words.next() {
            Some(b"v") => self.read_vertex(words),
            Some(b"f") => self.read_face(words),
            Some(word) if word.starts_with(b"#") => {
                self.keep_comment(line);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn error(&self, problem: String, remedy: &'static str) -> ImportError {
        self.source.malformed(format!("line {}", self.line), problem, remedy)
    }

    /// Comments may name the unit; those at the head of a file are enough.
    fn keep_comment(&mut self, line: &[u8]) {
        if self.raw.note.len() < 1000 {
            self.raw.note.push_str(&String::from_utf8_lossy(&line[..line.len().min(200)]));
            self.raw.note.push('\n');
        }
    }

    fn read_vertex<'w>(&mut self, mut words: impl Iterator<Item = &'w [u8]>) -> Result<(), ImportError> {
        let mut p = [0.0; 3];
        for x in &mut p {
            let word = words.next().unwrap_or_default();
            *x = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok()).ok_or_else(|| {
                let problem = format!("a vertex needs three numbers, found {}", excerpt(word));
                self.error(problem, "export the file again, with points as decimal marks")
            })?;
        }
        let line = self.line;
        let p = self.source.finite(DVec3::from_array(p), || format!("line {line}"))?;
        self.raw.mesh.vertices.push(p);
        self.check_size(0)
    }

    fn read_face<'w>(&mut self, words: impl Iterator<Item = &'w [u8]>) -> Result<(), ImportError> {
        let corners = words.map(|word| self.read_index(word)).collect::<Result<Vec<u32>, _>>()?;
        match *corners.as_slice() {
            [a, b, c] => self.raw.mesh.triangles.push([a, b, c]),
            [] | [_] | [_, _] => self.skipped += 1,
            _ => {
                self.source.cancel.check()?;
                self.check_size(corners.len() as u64)?;
                let triangles = triangulate(&corners, &self.raw.mesh.vertices);
                self.raw.mesh.triangles.extend(triangles);
            }
        }
        self.check_size(0)
    }

    /// The vertex that the first number of `12/3/4` means: counted from 1, or backwards from the last if negative.
    fn read_index(&self, word: &[u8]) -> Result<u32, ImportError> {
        let first = word.split(|&b| b == b'/').next().unwrap_or_default();
        let index: i64 = std::str::from_utf8(first).ok().and_then(|w| w.parse().ok()).ok_or_else(|| {
            let problem = format!("a face needs vertex numbers, found {}", excerpt(word));
            self.error(problem, "export the file again")
        })?;
        let count = self.raw.mesh.vertices.len() as i64;
        let from_zero = if index < 0 { count.saturating_add(index) } else { index - 1 };
        if (0..count).contains(&from_zero) {
            return Ok(from_zero as u32);
        }
        let problem = format!("a face refers to vertex {index}, but {count} are given up to here");
        Err(self.error(problem, "export the file again; parts of it are missing"))
    }

    /// Refuses a mesh that has grown too large, with `more` triangles to come at once.
    fn check_size(&self, more: u64) -> Result<(), ImportError> {
        let mesh = &self.raw.mesh;
        if more == 0 && !(mesh.triangles.len() + mesh.vertices.len()).is_multiple_of(1024) {
            return Ok(());
        }
        self.source.check_mesh(mesh.triangles.len() as u64 + more, mesh.vertices.len() as u64)
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::mesh::Mesh;

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
